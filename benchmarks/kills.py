# SPDX-License-Identifier: MIT
"""Runs killed at random moments, resumed, and set beside the run that was left alone.

    python -m benchmarks.kills [--kills 20] [--refinement 0.4] [--seed 1]

A drained and a coupled scene in turn, two paths each. `pysprings run` is ended by SIGKILL at a moment that is uniform
over its whole time, started again with `--resume` until it ends, and killed once more half of the times. Printed are
where each went on, and the largest difference of any number of full_model.nc and springs.nc, relative to the largest
value of its variable.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import xarray as xr

from pysprings import Scene
from pysprings.storage import read_tree, write_text

ROOT = Path(__file__).parents[1]


def scenes(refinement: float) -> dict[str, Scene]:
    """A dead load and two paths; the coupled one has a rest."""
    pull = {"name": "pull", "kind": "pull", "lateral_displacement": 1e-3, "rate": 1e-4}
    turn = {"name": "turn", "kind": "translation", "lateral_displacement": 5e-4, "rate": 1e-3}
    common = {
        "title": "killed", "mesh": {"refinement": refinement}, "caisson": {"vertical_load": 1.5e6},
        "solver": {"first_step_fraction": 0.05, "max_step_fraction": 0.2}, "output": {"figures": False},
    }  # fmt: skip
    drained = Scene().replace(**common, paths=(pull, turn))
    rests = {**pull, "role": "held-back", "then": ("rest 2 hour",)}
    return {"drained": drained, "coupled": drained.replace(drainage={"mode": "coupled"}, paths=(rests, turn))}


def start(file: Path, out: Path, *options: str) -> subprocess.Popen[bytes]:
    """Start `pysprings run`."""
    args = [sys.executable, "-m", "pysprings", "run", str(file), "--out", str(out), *options]
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.Popen(args, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, env=env)


def difference(one: Path, other: Path) -> float:
    """Largest difference of two NetCDF files, relative to the largest value of each variable."""
    a, b = read_tree(one), read_tree(other)
    assert a.groups == b.groups, "other groups"
    return max((_of_datasets(a[group], b[group]) for group in a.groups), default=0.0)


def _of_datasets(a: xr.DataTree, b: xr.DataTree) -> float:
    worst = 0.0
    assert set(a.variables) == set(b.variables), "other variables"
    for name, variable in a.variables.items():
        x, y = variable.values, b.variables[name].values
        assert x.shape == y.shape and x.dtype == y.dtype, f"{name}: another shape"
        if x.dtype.kind == "f":
            scale = float(np.nanmax(np.abs(x), initial=0.0)) or 1.0
            worst = max(worst, float(np.nanmax(np.abs(x - y), initial=0.0)) / scale)
            assert (np.isnan(x) == np.isnan(y)).all(), f"{name}: NaN elsewhere"
        else:
            assert (x == y).all(), f"{name}: other values"
    return worst


def killed(file: Path, out: Path, whole: float, moments: list[float]) -> int:
    """Kill a run at these fractions of its whole time, each time start it again; return the number of kills."""
    n, options = 0, ()
    for moment in moments:
        run = start(file, out, *options)
        time.sleep(moment * whole)
        if run.poll() is None:
            run.send_signal(signal.SIGKILL)
            n += 1
        _, err = run.communicate()
        # a run that was killed before its first checkpoint has nothing to go on from
        options = ("--resume",) if any((out / "checkpoint").glob("*.npz")) or (out / "run.json").exists() else ()
    run = start(file, out, *options)
    _, err = run.communicate()
    if run.returncode:
        raise SystemExit(f"{file.stem}: {err.decode()}")
    return n


def main() -> None:
    """Print a line for each run, and the worst difference."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--refinement", type=float, default=0.4)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    rng, place = random.Random(given.seed), Path(tempfile.mkdtemp())
    reference: dict[str, tuple[Path, float]] = {}
    for kind, scene in scenes(given.refinement).items():
        file = write_text(scene.to_toml(), place / f"{kind}.toml")
        for _ in range(2):  # the first one fills caches
            shutil.rmtree(place / kind, ignore_errors=True)
            began = time.perf_counter()
            assert start(file, place / kind).wait() == 0
        reference[kind] = place / kind, time.perf_counter() - began
        record = json.loads((place / kind / "run.json").read_text(encoding="utf-8"))
        print(f"{kind}: {record['mesh']['unknowns']} unknowns, {reference[kind][1]:.1f} s, {record['checkpoints']}")
    kills, number, worst, equal = 0, 0, 0.0, 0
    while kills < given.kills:
        kind = list(reference)[number % 2]
        alone, whole = reference[kind]
        moments = [rng.random() for _ in range(1 + (rng.random() < 0.5))]
        out = place / f"run-{number}"
        kills += killed(place / f"{kind}.toml", out, whole, moments)
        found = max(difference(alone / name, out / name) for name in ("full_model.nc", "springs.nc"))
        resumed = json.loads((out / "run.json").read_text(encoding="utf-8"))["resumed"]
        at = ", ".join(f"{moment:.2f}" for moment in moments)
        went_on = "; ".join(part["from"] for part in resumed) or "anew"
        print(f"{kind}, killed at {at} of its time; from {went_on}: {found:.1e}", flush=True)
        number, worst, equal = number + 1, max(worst, found), equal + (found <= 1e-10)
        shutil.rmtree(out)
    print(f"{kills} kills in {number} runs, {equal} equal to the run left alone; largest difference {worst:.1e}")
    shutil.rmtree(place)
    sys.exit(0 if equal == number else 1)


if __name__ == "__main__":
    main()
