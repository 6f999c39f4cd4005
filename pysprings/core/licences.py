# SPDX-License-Identifier: MIT
"""Packages beside pysprings whose licences are not open: which of them are installed, and what they allow.

Found by the names of their folders, as fast as `pysprings --version` has to be; a test compares the table with what the
metadata of the packages states. THIRD-PARTY.md has the whole list.
"""

import os
import sys
from collections.abc import Iterable
from dataclasses import dataclass

_SIMPLIFIED = "Intel Simplified Software License"
_DEVELOPER = "Intel End User License Agreement for Developer Tools"
# name -> licence, as the package's own metadata has it
PROPRIETARY = {
    "mkl": _SIMPLIFIED,
    "tbb": _SIMPLIFIED,
    "tcmlib": _SIMPLIFIED,
    "intel-openmp": _DEVELOPER,
    "intel-cmplr-lib-ur": _DEVELOPER,
}
TESTS_ONLY = {"openseespy": "for tests only; free for research, education and internal use"}
OWN = "licence MIT; most dependencies are under BSD, MIT, Apache-2.0, PSF or MPL-2.0 licences"


@dataclass(frozen=True)
class Installed:
    """A package that is installed, and its licence."""

    name: str
    version: str
    licence: str


def installed(folders: Iterable[str] | None = None) -> list[Installed]:
    """Return the packages of the tables above that lie in ``folders`` (default: where Python looks), by name."""
    known = PROPRIETARY | TESTS_ONLY
    packages: dict[str, Installed] = {}
    for folder in sys.path if folders is None else folders:
        for entry in _entries(folder):
            name, _, version = entry.removesuffix(".dist-info").partition("-")
            name = name.replace("_", "-").lower()
            if name in known:
                packages.setdefault(name, Installed(name, version, known[name]))
    return [packages[name] for name in sorted(packages)]


def text(packages: Iterable[Installed]) -> str:
    """Return what `pysprings --version` prints below its first line."""
    packages = list(packages)
    closed = [each for each in packages if each.name in PROPRIETARY]
    if not packages:
        return f"{OWN}; no proprietary package is installed"
    lines = [OWN]
    if closed:
        lines.append(
            "proprietary, installed by the extra mkl (1 GB; without them bricks are solved, more slowly, by rslab of"
        )
        lines.append("the open extra rslab, or by SuperLU):")
        lines += [_line(each) for each in closed]
    lines += [_line(each) for each in packages if each.name in TESTS_ONLY]
    return "\n".join(lines)


def _line(package: Installed) -> str:
    return f"  {package.name} {package.version}: {package.licence}"


def _entries(folder: str) -> list[str]:
    """Return the names of the packages' folders in a folder; none where it cannot be read."""
    try:
        return [name for name in os.listdir(folder or os.curdir) if name.endswith(".dist-info")]
    except OSError:  # an archive, or gone
        return []
