# SPDX-License-Identifier: MIT
"""Build wheel and sdist, and use them in fresh environments: ``python -m tools.wheel_check`` (`make wheel-check`).

For each Python that is there the wheel is installed with its dependencies from wheels alone, and a small scene is run
and predicted from. The sdist is installed with the first of them. A Python that is not there is named as such.
"""

import argparse
import shutil
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Sequence
from pathlib import Path

from pysprings.core.text import markdown_table

ROOT = Path(__file__).resolve().parents[1]
VERSIONS = ("3.11", "3.12", "3.13", "3.14", "3.15")
SCENE = """
mesh = { preset = "coarse", refinement = 0.5, harmonics = 2, discretisation = "fourier" }
solver = { tolerance = 1e-3 }
output = { figures = false }

[soil]
young_modulus = "60 MPa"
poisson_ratio = 0.3
friction_angle_final = "34 deg"
effective_unit_weight = "9 kN/m^3"
K0 = 0.5
surcharge = "5 kPa"

[[path]]
name = "pull"
kind = "pull"
lateral_displacement = "0.5 mm"
arm = "2 m"
"""
COMMANDS = (
    ("--version",),
    ("check", "scene.toml"),
    ("run", "scene.toml", "--out", "out", "--no-estimate-error"),
    ("predict", "out", "--H", "50 kN", "--arm", "2 m"),
)


def uv(*words: str) -> subprocess.CompletedProcess[str]:
    """Call uv, which lies beside the interpreter or on the path."""
    program = shutil.which("uv", path=str(Path(sys.executable).parent)) or shutil.which("uv")
    if program is None:
        raise SystemExit("uv is needed: it comes with the extra `dev`")
    return subprocess.run([program, *words], cwd=ROOT, capture_output=True, text=True)


def build(folder: Path) -> tuple[Path, Path]:
    """Build sdist and, from it, the wheel; return both. The wheel is pure Python."""
    done = uv("build", "--quiet", "--out-dir", str(folder), str(ROOT))
    if done.returncode:
        raise SystemExit(done.stderr)
    wheel, sdist = next(folder.glob("*.whl")), next(folder.glob("*.tar.gz"))
    if not wheel.name.endswith("-py3-none-any.whl"):
        raise SystemExit(f"{wheel.name}: not a wheel for every Python 3 and system")
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    if any(name.startswith(("tests/", "docs/", "benchmarks/")) for name in names):
        raise SystemExit(f"{wheel.name}: holds more than the two packages")
    return wheel, sdist


def tried(version: str, package: Path) -> list[str]:
    """Install a package for one Python and run the commands; return a row: version, package, outcome, seconds."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as place:
        folder = Path(place)
        environment = folder / "venv"
        start = time.perf_counter()
        if uv("venv", "--quiet", "--no-python-downloads", "--python", version, str(environment)).returncode:
            return [version, package.name, "this Python is not there", "-"]
        scripts = environment / ("Scripts" if sys.platform == "win32" else "bin")
        wheels = ("--only-binary", ":all:") if package.suffix == ".whl" else ()
        done = uv("pip", "install", "--quiet", "--python", str(environment), *wheels, str(package))
        if done.returncode:
            return [version, package.name, f"not installed: {done.stderr.strip().splitlines()[-1]}", "-"]
        (folder / "scene.toml").write_text(SCENE, encoding="utf-8", newline="\n")
        for words in COMMANDS:
            called = subprocess.run([scripts / "pysprings", *words], cwd=folder, capture_output=True, text=True)
            if called.returncode:
                return [version, package.name, f"{words[0]}: {called.stderr.strip().splitlines()[-1]}", "-"]
        return [version, package.name, "installed, ran, predicted", f"{time.perf_counter() - start:.0f}"]


def main(argv: Sequence[str] | None = None) -> int:
    """Print what every Python made of the packages; return 1 where one that is there failed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--python", nargs="+", default=list(VERSIONS), help="versions to try")
    given = parser.parse_args(argv)
    with tempfile.TemporaryDirectory() as place:
        wheel, sdist = build(Path(place))
        size = wheel.stat().st_size / 1e3
        print(f"{wheel.name}: {size:.0f} kB; {sdist.name}: {sdist.stat().st_size / 1e3:.0f} kB", flush=True)
        rows = [tried(version, wheel) for version in given.python] + [tried(given.python[0], sdist)]
    print(markdown_table(["Python", "package", "outcome", "s"], rows))
    return int(not all(row[2] in ("installed, ran, predicted", "this Python is not there") for row in rows))


if __name__ == "__main__":
    raise SystemExit(main())
