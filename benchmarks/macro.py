# SPDX-License-Identifier: MIT
"""Speed of the macro-model: `python -m benchmarks.macro [SPRINGS]` prints what a curve, a batch and the command take.

SPRINGS: springs.nc or the folder of a run; without it a fan of eight invented rays is used. Nothing is asserted.
"""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import xarray as xr

from pysprings.cli.support import springs_of
from pysprings.macro.predict import MacroModel, curve, predict_batch
from pysprings.macro.sets import spring_sets
from pysprings.springs.file import save_springs

CASES = 10_000
REPEATS = 20


def invented() -> xr.DataTree:
    """Return a fan of eight rays to 8 mm, the one of the tests."""
    from tests.pysprings.macro.test_fan import fan_springs, potential

    return fan_springs(potential)


def seconds(work: Callable[[], object], repeats: int = REPEATS) -> tuple[float, float]:
    """Return the best and the median time of some work [s], after one call that does not count."""
    work()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times), float(np.median(times))


def ms(times: tuple[float, float]) -> str:
    """Return best and median time in milliseconds."""
    return f"{1e3 * times[0]:.2f} ms (median {1e3 * times[1]:.2f})"


def report(springs: xr.DataTree, file: Path) -> None:
    """Print all timings for one set of springs."""
    print(f"{platform.processor() or platform.machine()}, Python {platform.python_version()}")
    u_max = 0.3 * max(float(np.abs(path["u"].values).max()) for path in springs["paths"].children.values())
    rng = np.random.default_rng(0)
    for spring_set in spring_sets(springs):
        model = MacroModel.from_springs(springs, spring_set)
        build = seconds(lambda kind=spring_set: MacroModel.from_springs(springs, kind))
        fifty = seconds(lambda model=model: curve(model, u_max=u_max, arm=2.0))
        size = abs(float(curve(model, u_max=u_max, arm=2.0)["H"][-1]))
        H, arm = rng.uniform(0.1, 1.0, CASES) * size, rng.uniform(0.0, 10.0, CASES)
        batch = seconds(lambda model=model, H=H, arm=arm: predict_batch(model, H=H, arm=arm), 5)
        print(f"{spring_set:>4}: model {ms(build)}; curve of 50 points {ms(fifty)}")
        print(f"      {CASES} load cases {ms(batch)}: {CASES / batch[0]:,.0f} a second")
    command = [sys.executable, "-m", "pysprings", "predict", str(file), "--H", f"{0.3 * size:.6g} N"]
    cold = seconds(lambda: subprocess.run(command, capture_output=True, check=True), 5)
    busy = f", load of the machine {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    print(f"pysprings predict from a cold shell: {ms(cold)}{busy}")


def main() -> None:
    """Time the springs that were given, or invented ones."""
    warnings.simplefilter("ignore")
    if len(sys.argv) > 1:
        report(springs_of(Path(sys.argv[1])), Path(sys.argv[1]))
        return
    with tempfile.TemporaryDirectory() as folder:
        springs = invented()
        report(springs, save_springs(springs, Path(folder) / "springs.nc"))


if __name__ == "__main__":
    main()
