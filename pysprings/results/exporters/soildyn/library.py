# SPDX-License-Identifier: MIT
"""The SoilDyn library: its C source, and the command that builds it with the compiler of the system."""

import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

from pysprings.core.errors import ResourceError

_NAMES_OF_SOURCES = ("foundation.c", "springs.c", "memory.c", "spring_file.c")
SOURCES = tuple(Path(__file__).with_name(name) for name in _NAMES_OF_SOURCES)
COMPILERS = ("cc", "gcc", "clang")
_NAMES = {"linux": "libpysprings_soildyn.so", "darwin": "libpysprings_soildyn.dylib", "win32": "pysprings_soildyn.dll"}


def library_name(platform: str = sys.platform) -> str:
    """Return the file name of the library on a platform (`sys.platform`)."""
    return _NAMES.get(platform, _NAMES["linux"])


def compiler(given: str | None = None) -> list[str]:
    """Return the command of the C compiler: the given one, that of the variable CC, or the first that is installed.

    Raises
    ------
    ResourceError
        There is none.
    """
    named = given or os.environ.get("CC")
    words = shlex.split(named) if named else [name for name in COMPILERS if shutil.which(name)][:1]
    if not words or shutil.which(words[0]) is None:
        looked = named or ", ".join(COMPILERS)
        raise ResourceError(f"no C compiler ({looked}): install one, or name it by --compiler or the variable CC")
    return words


def build_command(words: list[str], output: Path, platform: str = sys.platform) -> list[str]:
    """Return the command that compiles and links the library into a file.

    Parameters
    ----------
    words
        Compiler with options of the user's own; `cl` is that of Visual Studio, all others take options as gcc.
    """
    if Path(words[0]).stem.lower() == "cl":
        return [*words, "/nologo", "/O2", "/LD", *map(str, SOURCES), f"/Fe:{output}"]
    shared = ["-dynamiclib"] if platform == "darwin" else ["-shared", *(["-fPIC"] if platform != "win32" else [])]
    return [*words, "-std=c99", "-O2", "-fvisibility=hidden", *shared, *map(str, SOURCES), "-o", str(output), "-lm"]


def build(folder: Path, given: str | None = None) -> Path:
    """Build the library into a folder, which need not exist; return its path.

    Raises
    ------
    ResourceError
        No compiler, or it fails; the message holds its last lines.
    """
    words = compiler(given)
    folder.mkdir(parents=True, exist_ok=True)
    output = folder.resolve() / library_name()
    command = build_command(words, output)
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        last = (done.stderr or done.stdout).strip().splitlines()[-5:]
        raise ResourceError(f"the C compiler failed ({' '.join(command)}): {' | '.join(last)}")
    return folder / output.name
