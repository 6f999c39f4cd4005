# SPDX-License-Identifier: MIT
"""Runs killed at random moments, resumed, and set beside the run that was left alone.

    python -m benchmarks.kills [--runs 20] [--refinement 0.5] [--seed 1]

A drained and a coupled scene in turn, two paths each. `pysprings run` is ended by SIGKILL at a moment that is uniform
over its whole time, writing its files included, and started again with `--resume`; half of the runs are killed twice.
Printed are where each went on, and the largest difference of any number of full_model.nc and springs.nc, relative to
the largest value of its variable. The processes are forks of this one, which has loaded everything: their time is that
of the run (needs a system with fork; one thread, since those of a solver do not survive it).
"""

import os

os.environ |= {"MKL_THREADING_LAYER": "SEQUENTIAL", "NUMBA_THREADING_LAYER": "workqueue"}  # before anything loads them

import argparse
import json
import random
import shutil
import signal
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from pysprings import Scene
from pysprings.cli import app
from pysprings.core.storage import read_tree, write_text
from pysprings.results.folder import run_to_folder
from pysprings.scene.sections import PAPER, PAPER_SOIL


def scenes(refinement: float) -> dict[str, Scene]:
    """Return a dead load and two paths; the coupled one has a rest."""
    pull = {"name": "pull", "kind": "pull", "lateral_displacement": 1e-3, "rate": 1e-4}
    turn = {"name": "turn", "kind": "translation", "lateral_displacement": 5e-4, "rate": 1e-3}
    common = {
        "title": "killed", "mesh": {"refinement": refinement, "discretisation": "hex8"},
        "caisson": {"vertical_load": 1.5e6},
        "solver": {"first_step_fraction": 0.05, "max_step_fraction": 0.2}, "output": {"figures": False},
    }  # fmt: skip
    drained = Scene(domain=PAPER, soil=PAPER_SOIL).replace(**common, paths=(pull, turn))
    rests = {**pull, "role": "held-back", "then": ("rest 2 hour",)}
    return {"drained": drained, "coupled": drained.replace(drainage={"mode": "coupled"}, paths=(rests, turn))}


def start(file: Path, out: Path, *options: str) -> int:
    """Start `pysprings run` in a process of its own; return its number. Its streams go to a file beside `out`."""
    if child := os.fork():
        return child
    log = os.open(out.with_suffix(".log"), os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(log, 1)
    os.dup2(log, 2)
    sys.argv = ["pysprings", "run", str(file), "--out", str(out), *options]
    code = 1
    try:
        app.main()
    except SystemExit as end:
        code = int(end.code or 0)
    finally:
        os._exit(code)


def ended(child: int) -> int:
    """Wait for a process; return its exit code, that of the signal with a minus."""
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def killed(file: Path, out: Path, whole: float, moments: list[float]) -> int:
    """Kill a run at these fractions of its whole time, each time start it again; return the number of kills."""
    n, options = 0, ()
    for moment in moments:
        run = start(file, out, *options)
        time.sleep(moment * whole)
        os.kill(run, signal.SIGKILL)  # a process that has ended waits for `ended`
        n += ended(run) == -signal.SIGKILL
        # a run that was killed before its first checkpoint has nothing to go on from
        options = ("--resume",) if any((out / "checkpoint").glob("*.npz")) or (out / "run.json").exists() else ()
    if ended(start(file, out, *options)):
        raise SystemExit(f"{file.stem}: {out.with_suffix('.log').read_text()}")
    return n


def difference(one: Path, other: Path) -> float:
    """Return the largest difference of two NetCDF files, relative to the largest value of each variable."""
    a, b, worst = read_tree(one), read_tree(other), 0.0
    assert a.groups == b.groups, "other groups"
    for group in a.groups:
        assert set(a[group].variables) == set(b[group].variables), f"{group}: other variables"
        for name, variable in a[group].variables.items():
            x, y = variable.values, b[group].variables[name].values
            assert x.shape == y.shape and x.dtype == y.dtype, f"{name}: another shape"
            if x.dtype.kind == "f":
                assert (np.isnan(x) == np.isnan(y)).all(), f"{name}: NaN elsewhere"
                scale = float(np.nanmax(np.abs(x), initial=0.0)) or 1.0
                worst = max(worst, float(np.nanmax(np.abs(x - y), initial=0.0)) / scale)
            else:
                assert (x == y).all(), f"{name}: other values"
    return worst


def main() -> int:
    """Print a line for each run, and the worst difference; return 1 where one is above 1e-10."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--refinement", type=float, default=0.5)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    rng, place = random.Random(given.seed), Path(tempfile.mkdtemp())
    whole, outcomes = dict[str, float](), list[tuple[int, int, float]]()
    for kind, scene in scenes(given.refinement).items():
        file = write_text(scene.to_toml(), place / f"{kind}.toml")
        run_to_folder(scene, place / "first")  # loads and compiles everything
        began = time.perf_counter()
        assert ended(start(file, place / kind)) == 0, (place / f"{kind}.log").read_text()
        whole[kind] = time.perf_counter() - began
        record = json.loads((place / kind / "run.json").read_text(encoding="utf-8"))
        print(f"{kind}: {record['mesh']['unknowns']} unknowns, {whole[kind]:.1f} s, {record['checkpoints']}")
    while len(outcomes) < given.runs:
        kind, out = list(whole)[len(outcomes) % 2], place / "run"
        moments = [rng.random() for _ in range(1 + (rng.random() < 0.5))]
        if kills := killed(place / f"{kind}.toml", out, whole[kind], moments):  # else it was faster than the one alone
            apart = max(difference(place / kind / name, out / name) for name in ("full_model.nc", "springs.nc"))
            resumed = json.loads((out / "run.json").read_text(encoding="utf-8"))["resumed"]
            at = ", ".join(f"{moment:.2f}" for moment in moments)
            went_on = "; ".join(part["from"] for part in resumed) or "anew"
            print(f"{kind}, killed at {at} of its time; from {went_on}: {apart:.1e}", flush=True)
            outcomes.append((kills, len(resumed), apart))
        shutil.rmtree(out)
    every = list(zip(*outcomes, strict=True))
    equal = sum(apart <= 1e-10 for apart in every[2])
    print(f"{given.runs} runs, {sum(every[0])} kills, {sum(every[1])} resumes from a checkpoint of a path; ", end="")
    print(f"{equal} equal to the run left alone, largest difference {max(every[2]):.1e}")
    shutil.rmtree(place)
    return int(equal < given.runs)


if __name__ == "__main__":
    sys.exit(main())
