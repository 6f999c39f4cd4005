# SPDX-License-Identifier: MIT
"""Speed of the macro-model: `python -m benchmarks.macro [SPRINGS]` prints what a curve, a batch and the command take.

SPRINGS: springs.nc or the folder of a run; without it the springs of the atlas `clay` are used. Nothing is asserted.
"""

import os
import platform
import subprocess
import sys
import tempfile
import timeit
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import xarray as xr

from pysprings import load_scene, open_atlas
from pysprings.cli.inputs import springs_of
from pysprings.macro.batch import predict_batch
from pysprings.macro.model import spring_sets
from pysprings.macro.predict import MacroModel, curve
from pysprings.springs.checks import save_springs
from pysprings.springs.springs import Springs

CASES = 10_000
REPEATS = 20
SCENE = Path(__file__).parents[1] / "data" / "studies" / "clay-scene.toml"


def seconds(work: Callable[[], object], repeats: int = REPEATS) -> list[float]:
    """Return the times of some work [s], the best first, after one call that does not count."""
    work()
    return sorted(timeit.repeat(work, number=1, repeat=repeats))


def ms(times: list[float]) -> str:
    """Return best and median time in milliseconds."""
    return f"{1e3 * times[0]:.2f} ms (median {1e3 * times[len(times) // 2]:.2f})"


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
    load_sets = Springs.of(springs).load_sets
    if len(load_sets) > 1:
        arms, V = np.arange(6.0) * float(springs.attrs["outer_diameter_m"]), 0.9 * load_sets[-1].V
        H = [np.abs(predict_batch(springs, H=1.0, arm=arms, V=each * V)["capacity_H"].values) for each in (1.0, 0.9)]
        change = 100.0 * np.abs(H[0] / H[1] - 1.0)
        print(f"V {1e-6 * V:.3g} MN, 10 % less: largest H at 0 to 5 D {change.min():.2g} to {change.max():.2g} % other")


def main() -> None:
    """Time the springs that were given, or those of an atlas."""
    warnings.simplefilter("ignore")
    if len(sys.argv) > 1:
        report(springs_of(Path(sys.argv[1])), Path(sys.argv[1]))
        return
    with tempfile.TemporaryDirectory() as folder:
        springs = open_atlas("clay").springs(load_scene(SCENE))
        report(springs, save_springs(springs, Path(folder) / "springs.nc"))


if __name__ == "__main__":
    main()
