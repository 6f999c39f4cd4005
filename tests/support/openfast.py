# SPDX-License-Identifier: MIT
"""Programs of OpenFAST 5.0.0 as outside answers: where they are, and SoilDyn's driver with its input and output."""

import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from tests.support.place import ROOT

SOURCE = ROOT.parent / "shared" / "openfast" / "build.sh"  # builds the programs from source, in minutes
CACHE = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "pysprings-openfast-2895884"
STEP = 0.01  # s


def program(name: str, build: bool = False) -> str:
    """Return a program: named by a variable such as SOILDYN_DRIVER, in the search path, or built before.

    With `build` it is built into the cache folder, once, where the source is there. Skips the test without one.
    """
    own = os.environ.get(name.upper()) or shutil.which(name)
    cached = CACHE / "bin" / name
    if own is None and not cached.exists() and build and SOURCE.exists() and shutil.which("gfortran"):
        done = subprocess.run(["bash", str(SOURCE), str(CACHE), name], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    if own is None and not cached.exists():
        pytest.skip(f"{name} is not there ({name.upper()} names it; {SOURCE} builds it with gfortran)")
    return own or str(cached)


@dataclass(frozen=True)
class Driven:
    """Exit code and log of SoilDyn's driver, and its channels (n, channels) without time."""

    code: int
    log: str
    channels: np.ndarray


def drive(folder: Path, motions: np.ndarray, soil: str = "soildyn.dat", matrix: bool = False) -> Driven:
    """Run SoilDyn's driver in a folder at motions (n, 6) [m, rad], one at each time step."""
    rows = [f"{STEP * k:.4f} " + " ".join(f"{value:.15e}" for value in row) for k, row in enumerate(motions)]
    (folder / "motion.txt").write_text("\n".join(rows) + "\n")
    lines = (
        "driver", "test", "-----", "False Echo", "-----", f'"{soil}" SlDIptFile', "0 TStart", "DEFAULT DT",
        "DEFAULT NumTimeSteps", f"{matrix} StiffMatOut", "False NonLinear", '"motion.txt" InputDispFile',
    )  # fmt: skip
    (folder / "driver.inp").write_text("\n".join(lines) + "\n")
    command = [program("soildyn_driver"), "driver.inp"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120)
    out = (folder / soil).with_suffix(".out")
    channels = _channels(out) if done.returncode == 0 and out.exists() else np.zeros((0, 0))
    return Driven(done.returncode, done.stdout + done.stderr, channels[: len(motions)])


def _channels(file: Path) -> np.ndarray:
    """Return the channels of an output file; the driver adds a step behind the last one."""
    text = file.read_text().splitlines()
    first = next(k for k, line in enumerate(text) if line.split()[:1] == ["Time"])
    table = np.array([[float(cell) for cell in line.split()] for line in text[first + 2 :] if line.strip()])
    assert (np.diff(np.rint(table[:, 0] / STEP).astype(int)) == 1).all()
    return table[:, 1:]
