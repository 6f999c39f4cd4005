# SPDX-License-Identifier: MIT
"""Paths in worker processes: the same result as in one process, whatever becomes of a worker."""

import json
import multiprocessing
import os
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import pysprings
from pysprings.core.errors import ResourceError
from pysprings.core.workers import Workers
from pysprings.full_model.accuracy.own_estimate import PHASE, companions_of
from pysprings.full_model.checkpoint import Checkpoints, read
from pysprings.full_model.compute import compute
from pysprings.full_model.paths import path_in_worker
from pysprings.full_model.run_record import Computed
from pysprings.model.forecast import resources
from pysprings.model.forecast.resources import jobs_for
from pysprings.results.folder import run_to_folder
from tests.support import tiny
from tests.support.commands import environment
from tests.support.files import record_of
from tests.support.two_paths import SECOND, assert_same, coupled, drained

pytestmark = pytest.mark.skipif(os.name == "nt", reason="signals are different there")

SERIES: dict[str, Any] = {"discretisation": "fourier", "harmonics": 3}
SCENES: dict[str, Callable[[], pysprings.Scene]] = {
    "series": lambda: drained().replace(mesh=SERIES),
    "coupled": lambda: coupled().replace(mesh=SERIES),
    "stuck": lambda: tiny.stuck_scene().replace(mesh=SERIES, paths=(*tiny.stuck_scene().paths, SECOND)),
}


@cache
def alone(kind: str) -> xr.DataTree:
    return compute(SCENES[kind]()).recorded()


def kill(*_: object) -> None:
    for process in multiprocessing.active_children():
        process.kill()
        process.join()


@pytest.mark.parametrize("kind", ["series", pytest.param("coupled", marks=pytest.mark.slow), "stuck"])
def test_any_number_of_jobs_gives_the_same_result(kind: str) -> None:
    """A path that stops is among those of one scene: it stops no other."""
    with Workers(2) as workers:
        result = compute(SCENES[kind](), workers=workers).recorded()
    assert_same(result, alone(kind))
    ours, theirs = record_of(result), record_of(alone(kind))
    assert list(ours["paths"]) == list(theirs["paths"])
    assert ours["cpu_s"] > 0.5 * sum(phase["cpu_s"] for phase in theirs["phases"].values())


def test_a_killed_worker_is_told_and_costs_nothing_else(tmp_path: Path) -> None:
    left = [1]

    def once(path: str, *_: object) -> None:
        if path == "pull" and left:
            left.pop()
            kill()

    run_to_folder(SCENES["series"](), tmp_path / "out", jobs=2, estimate_error=False, progress=once)
    record = json.loads((tmp_path / "out" / "run.json").read_text())
    assert record["status"] == "complete" and not (tmp_path / "out" / "checkpoint").exists()
    assert "pull: a worker process was ended by SIGKILL (memory?); it goes on in another one" in record["warnings"]
    with xr.open_datatree(tmp_path / "out" / "full_model.nc", engine="netcdf4", decode_timedelta=False) as tree:
        for path in ("pull", "second"):
            same = alone("series")[f"paths/{path}"].to_dataset(inherit=False)
            xr.testing.assert_equal(tree[f"paths/{path}"].to_dataset(inherit=False), same)


def test_a_path_whose_worker_dies_once_its_end_is_saved_is_not_run_again(tmp_path: Path) -> None:
    """Another worker gets it, and finds its end in the checkpoint."""
    compute(SCENES["series"](), checkpoints=Checkpoints(tmp_path))
    files = sorted((tmp_path / "checkpoint").glob("path-*.npz"))
    shared, times = read(tmp_path / "checkpoint" / "start.npz").arrays, [file.stat().st_mtime_ns for file in files]
    for number, file in enumerate(files):
        rest, again = (shared["stiffness"], float(shared["torsion"])), list[str]()
        progress = lambda name, *_, again=again: again.append(name)  # noqa: E731
        saved = path_in_worker(SCENES["series"](), number, rest, Checkpoints(tmp_path), progress)
        assert not again and saved.meta == read(file).meta
        for name, values in read(file).arrays.items():
            np.testing.assert_array_equal(saved.arrays[name], values)
    assert len(files) == 2 and times == [file.stat().st_mtime_ns for file in files]


def test_the_cost_of_the_estimate_has_that_of_its_workers(tmp_path: Path) -> None:
    """A run on the coarser mesh in another process: its seconds are not those of this one."""

    def elsewhere(scene: pysprings.Scene, **_: Any) -> Computed:
        result = compute(scene)
        result.record.cpu_s += 1000.0
        return result

    companions = companions_of(SCENES["series"](), elsewhere)
    assert len(companions.trees) == len(companions.richer) == 1 and 2000.0 <= companions.clock.cpu[PHASE] < 3000.0


def test_a_path_whose_workers_die_is_one_that_resources_do_not_suffice_for(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with pytest.raises(ResourceError, match=r": a worker process was ended by SIGKILL \(memory\?\), 2 times"):
        run_to_folder(SCENES["series"](), out, jobs=2, progress=lambda path, *_: path != "model" and kill())
    assert json.loads((out / "run.json").read_text())["status"] == "interrupted"
    run_to_folder(SCENES["series"](), out, jobs=1, resume=True)
    assert json.loads((out / "run.json").read_text())["status"] == "complete"


@pytest.mark.slow
def test_ctrl_c_keeps_what_workers_have_and_the_run_goes_on(tmp_path: Path) -> None:
    scene = SCENES["series"]().replace(solver={"first_step_fraction": 0.02, "max_step_fraction": 0.02})
    file, out = tiny.write(scene, tmp_path / "caisson.toml"), tmp_path / "out"
    args = [sys.executable, "-m", "pysprings", "run", str(file), "--out", str(out), "--jobs", "2"]
    code = f"""
import sys
from pysprings.core.progress import PlainLines
from pysprings.cli import app
import os, signal
def report(self, path, fraction, message):
    if path == "pull" and fraction > 0.05:
        os.killpg(0, signal.SIGINT)
PlainLines.__call__ = report
signal.signal(signal.SIGINT, signal.default_int_handler)  # where a shell has put this into the background
sys.argv = {args[2:]!r}
if __name__ == "__main__":
    app.main()
"""
    script = tmp_path / "stop.py"
    script.write_text(code)
    done = subprocess.run(
        [sys.executable, script], capture_output=True, text=True, env=environment(), start_new_session=True, timeout=300
    )
    assert done.returncode == 130, done.stderr
    assert done.stderr.endswith(f"go on with: pysprings run {file} --out {out} --jobs 2 --resume\ninterrupted\n")
    record = json.loads((out / "run.json").read_text())
    assert record["status"] == "interrupted" and record["paths"]["pull"]["increments"] > 0
    run_to_folder(scene, out, resume=True, jobs=2, estimate_error=False)
    with xr.open_datatree(out / "full_model.nc", engine="netcdf4", decode_timedelta=False) as tree:
        whole = compute(scene).recorded()
        for path in ("pull", "second"):
            same = whole[f"paths/{path}"].to_dataset(inherit=False)
            xr.testing.assert_equal(tree[f"paths/{path}"].to_dataset(inherit=False), same)


def test_workers_are_as_many_as_pay_and_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    series, bricks = tiny.scene(mesh=SERIES), drained()
    monkeypatch.setattr(resources, "cores", lambda: 8)
    assert jobs_for(series, None) == 1  # they take no time
    assert jobs_for(drained(), 4) == 2 and jobs_for(drained(), 1) == 1
    monkeypatch.setattr(resources, "WORTH_WORKERS", 0.0)
    assert jobs_for(SCENES["series"](), None) == 2
    assert jobs_for(bricks, None) == 1  # each path has all cores
    monkeypatch.setattr(resources, "memory_left", lambda: 1.5 * resources.model_bytes(bricks))
    assert jobs_for(bricks, 4) == 1
    monkeypatch.setattr(resources, "memory_left", lambda: 1e12)
    monkeypatch.setattr(resources, "in_worker", lambda: True)
    assert jobs_for(SCENES["series"](), 4) == 1
