# SPDX-License-Identifier: MIT
"""Programs as processes of their own: output, wall time, peak memory; which of them are there, in what version."""

import importlib.metadata
import importlib.util
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

PATIENCE = 200.0  # s
ROOT = Path(__file__).resolve().parents[2]


def timed(command: list[str], folder: Path) -> tuple[str, float, float]:
    """Run a command; return its output, wall seconds and peak memory [MB]. subprocess.CalledProcessError on failure."""
    child = "import resource, subprocess, sys\n"
    child += f"done = subprocess.run(sys.argv[1:], timeout={PATIENCE})\n"
    child += "print('RSS', resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)\nsys.exit(done.returncode)"
    start = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", child, *command], cwd=folder, capture_output=True, text=True, check=True,
        env=environment(),
    )  # fmt: skip
    seconds = time.perf_counter() - start
    text, _, peak = done.stdout.rpartition("RSS ")
    return text, seconds, float(peak) / 1024.0


def environment() -> dict[str, str]:
    """Return the environment of one thread in which the libraries of openseespy's wheel find each other."""
    spec = importlib.util.find_spec("openseespylinux")
    own = [str(Path(spec.origin).parent / "lib")] if spec and spec.origin else []
    paths = os.pathsep.join([*own, *filter(None, [os.environ.get("LD_LIBRARY_PATH")])])
    threads = dict.fromkeys(("OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
    python = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    return {**os.environ, **threads, "LD_LIBRARY_PATH": paths, "PYTHONPATH": python}


def versions() -> dict[str, str | None]:
    """Return the version of each other program; None where it is missing."""
    there = importlib.util.find_spec("openseespy") is not None
    out: dict[str, str | None] = {"OpenSees": importlib.metadata.version("openseespy") if there else None}
    if shutil.which("ccx") is None:
        return out | {"CalculiX": None}
    text = subprocess.run(["ccx", "-v"], capture_output=True, text=True, check=False).stdout
    return out | {"CalculiX": next((word for word in text.split() if word[:1].isdigit()), "unknown")}
