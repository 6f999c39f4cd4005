# SPDX-License-Identifier: MIT
"""Runs that were stopped, at any step and in any way, and went on: the same result as in one go."""

import errno
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from functools import cache, partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr

import pysprings
from fe_engine.compiled import engine_digest
from fe_engine.settings import Recycling, Settings
from fe_engine.solve import step_size
from fe_engine.solve.newton import Newton
from pysprings.cli.support import interruptible
from pysprings.core.errors import ResourceError, UserInputError
from pysprings.full_model import cavitation, checkpoint, paths, work
from pysprings.full_model.checkpoint import Checkpoints
from pysprings.full_model.compute import compute
from pysprings.full_model.work import differences
from pysprings.results.folder import run_to_folder
from pysprings.results.layout import run_files
from tests.support import tiny
from tests.support.commands import command, environment
from tests.support.files import contents, record_of
from tests.support.two_paths import SECOND, assert_same, coupled, drained, plain


def viscous() -> pysprings.Scene:
    """The drained paths with overstress: attempts fail, since iterations are few."""
    return drained().replace(solver={"viscous_displacement": 5e-5, "max_iterations": 3})


def pressed() -> pysprings.Scene:
    """A dead load, a pull, and another vertical load at its end, with overstress."""
    path = {**tiny.PULL, "role": "held-back", "vertical_load": 0.9e6, "then": ("V 1.2 MN", "0 mm")}
    solver = {"first_step_fraction": 0.2, "viscous_displacement": 1e-6}
    return tiny.scene(paths=(path,), solver=solver)


SCENES = {"drained": drained, "coupled": coupled, "viscous": viscous, "pressed": pressed}


@cache
def straight(kind: str) -> xr.DataTree:
    return compute(SCENES[kind]()).recorded()


class Stop:
    """Progress that interrupts at its n-th call about the paths, or about the model."""

    def __init__(self, after: int, error: type[BaseException] = KeyboardInterrupt, of: str = "paths") -> None:
        self.left, self.error, self.of = after, error, of

    def __call__(self, path: str, _fraction: float, _message: str) -> None:
        self.left -= (path == "model") == (self.of == "model")
        if self.left == 0:
            raise self.error


@pytest.fixture
def every_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """Checkpoints at every step, whatever they cost."""
    monkeypatch.setattr(checkpoint, "EVERY", 0.0)


# --- equal to the straight run ---


@pytest.mark.parametrize(
    ("kind", "stops"),
    [
        ("drained", (3, 12)),
        ("coupled", (20,)),
        ("pressed", (12,)),
        pytest.param("drained", (1, 4, 6, 9, 14), marks=pytest.mark.slow),
        pytest.param("coupled", (2, 5, 24, 40), marks=pytest.mark.slow),
        pytest.param("viscous", (4, 9), marks=pytest.mark.slow),
    ],
    ids=str,
)
def test_a_run_stopped_at_any_step_equals_one_in_one_go(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, stops: tuple[int, ...], every_step: None
) -> None:
    """In the dead load, on the first path, in its rest, its new V, on the second path; stopped at all of them."""
    if kind == "coupled":  # water that cavitates at once, to see the warning come through
        monkeypatch.setattr(cavitation, "ATMOSPHERE", 0.0)
    done = 0
    for stop in stops:
        result = compute(
            SCENES[kind](), progress=Stop(stop - done), checkpoints=Checkpoints(tmp_path), resume=done > 0
        ).recorded()
        assert result.attrs["status"] == "interrupted"
        done = stop
    result = compute(SCENES[kind](), checkpoints=Checkpoints(tmp_path), resume=True).recorded()
    assert_same(result, straight(kind))
    assert len(record_of(result)["resumed"]) == len(stops)
    assert len(record_of(result)["warnings"]) == (2 if kind == "coupled" else 0)


def test_factors_of_earlier_tangents_go_on_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, every_step: None
) -> None:
    """As large models solve: what the factors were made from is in the checkpoint."""
    own = record_of(straight("drained"))["solver"]["factorisations"]
    monkeypatch.setattr(work, "Settings", partial(Settings, recycling=Recycling(start=0)))
    whole = compute(drained()).recorded()
    assert record_of(whole)["solver"]["factorisations"] < own
    done = 0
    for stop in (4, 6, 12):
        compute(drained(), progress=Stop(stop - done), checkpoints=Checkpoints(tmp_path), resume=done > 0)
        done = stop
    assert_same(compute(drained(), checkpoints=Checkpoints(tmp_path), resume=True).recorded(), whole)


class Killed(BaseException):
    pass


def test_there_is_one_checkpoint_a_minute_and_what_came_after_it_is_computed_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of steps of 25 s every third is kept; a path that has ended is kept as a whole."""
    now, written, save = [0.0], [], Checkpoints.save_path
    monkeypatch.setattr(paths, "time", SimpleNamespace(monotonic=lambda: now[0]))
    monkeypatch.setattr(Checkpoints, "save_path", lambda *args: (written.append(now[0]), save(*args)))
    stop = Stop(9, Killed)

    def step(*report: Any) -> None:
        now[0] += 25.0
        stop(*report)

    with pytest.raises(Killed):
        compute(drained(), progress=step, checkpoints=Checkpoints(tmp_path))
    assert written == [125.0, 200.0]  # from 50 s on: two calls are about the model
    result = compute(drained(), checkpoints=Checkpoints(tmp_path), resume=True).recorded()
    assert re.fullmatch("path 'pull', step [1-9]", record_of(result)["resumed"][0]["from"])
    ours, theirs = (tree["paths/pull"].to_dataset(inherit=False) for tree in (result, straight("drained")))
    xr.testing.assert_identical(ours, theirs)
    xr.testing.assert_identical(plain(result["paths/second"]), plain(straight("drained")["paths/second"]))


@pytest.mark.slow
def test_a_path_that_did_not_converge_stays_as_it_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(step_size, "SMALLEST", 0.02)  # no endless halving
    hasty = {"max_iterations": 2, "tolerance": 1e-8, "max_step_fraction": 0.3}
    scene = tiny.scene(solver=hasty, paths=(tiny.PULL, SECOND))
    whole = compute(scene).recorded()
    assert [path.attrs["status"] for path in whole["paths"].children.values()] == ["partial", "partial"]
    stopped = compute(
        scene, progress=Stop(whole["paths/pull"].sizes["step"]), checkpoints=Checkpoints(tmp_path)
    ).recorded()
    assert list(stopped["paths"].children) == ["pull", "second"]
    result = compute(scene, checkpoints=Checkpoints(tmp_path), resume=True).recorded()
    assert_same(result, whole)


@pytest.mark.slow
def test_a_limit_load_is_still_one_after_a_stop(tmp_path: Path, every_step: None) -> None:
    """What tells it, the stiffness of the last increment, is in the checkpoint of the last step that converged."""
    scene, calls = tiny.scene(caisson={"vertical_load": -5e6}), []
    whole = compute(scene, progress=lambda path, *_: calls.append(path)).recorded()
    (line,) = record_of(whole)["failures"]
    assert "stopped during its dead load: " in line and "of the initial stiffness is left" in line
    last = len(calls) - calls.count("model")
    assert (
        compute(scene, progress=Stop(last), checkpoints=Checkpoints(tmp_path)).recorded().attrs["status"]
        == "interrupted"
    )
    assert_same(compute(scene, checkpoints=Checkpoints(tmp_path), resume=True).recorded(), whole)


def test_the_python_call_goes_on_by_itself(tmp_path: Path) -> None:
    place = tmp_path / "safe"
    assert pysprings.run(drained(), progress=Stop(4), checkpoint=place).attrs["status"] == "interrupted"
    assert_same(pysprings.run(drained(), checkpoint=place), straight("drained"))
    assert not place.exists() or not any(place.iterdir())


# --- cost ---


def test_the_record_has_the_cost(tmp_path: Path, every_step: None) -> None:
    """One checkpoint at every step; their seconds, and these as a share of the run's."""
    kept = compute(drained(), checkpoints=Checkpoints(tmp_path)).recorded()
    record = record_of(kept)
    saved = record["checkpoints"]
    assert saved["written"] >= sum(path.sizes["step"] for path in kept["paths"].children.values()) - 1
    assert 0.0 < saved["wall_s"] <= record["phases"]["checkpoint"]["wall_s"] + 0.01
    assert 0.0 < saved["share_of_wall"] < 1.0
    assert saved["wall_s"] / saved["share_of_wall"] == pytest.approx(record["wall_s"], rel=0.5)


# --- damaged checkpoints ---


@pytest.fixture(scope="module")
def stopped(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with checkpoints of a run that was stopped on its second path."""
    folder = tmp_path_factory.mktemp("stopped")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(checkpoint, "EVERY", 0.0)
        compute(drained(), progress=Stop(14), checkpoints=Checkpoints(folder))
    assert set(contents(folder / "checkpoint")) == {"start.npz", "path-000.npz", "path-001.npz"}
    return folder


def _cut(file: Path) -> None:
    file.write_bytes(file.read_bytes()[:-100])


def _flip(file: Path) -> None:
    data = bytearray(file.read_bytes())
    data[len(data) // 2] ^= 1
    file.write_bytes(data)


def _empty(file: Path) -> None:
    file.write_bytes(b"")


def _head(file: Path) -> None:
    file.write_bytes(b"[]" + file.read_bytes())


@pytest.mark.parametrize(
    ("name", "damage"),
    [
        pytest.param("start.npz", _flip, marks=pytest.mark.slow),
        pytest.param("path-000.npz", _cut, marks=pytest.mark.slow),
        pytest.param("path-001.npz", _empty, marks=pytest.mark.slow),
        ("path-001.npz", _head),
    ],
)
def test_a_damaged_file_is_told_and_what_it_held_computed_again(
    stopped: Path, tmp_path: Path, name: str, damage: Any
) -> None:
    folder = shutil.copytree(stopped, tmp_path / "copy")
    damage(folder / "checkpoint" / name)
    result = compute(drained(), checkpoints=Checkpoints(folder), resume=True).recorded()
    (warning,) = record_of(result)["warnings"]
    assert warning == f"checkpoint {name}: its checksum is wrong; what it held is computed again"
    for group in straight("drained").groups:
        xr.testing.assert_identical(*(plain(tree[group]) for tree in (result, straight("drained"))))


def test_checkpoints_that_are_all_damaged_are_refused(stopped: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(stopped, tmp_path / "copy")
    for file in (folder / "checkpoint").iterdir():
        _cut(file)
    with pytest.raises(UserInputError, match=r"every checkpoint is damaged \(.*; start\.npz: .*--force"):
        compute(drained(), checkpoints=Checkpoints(folder), resume=True)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"scene": {"soil": {"K0": 0.9}}}, "its scene was sha256 "),
        ({"mesh": "medium"}, "its mesh was coarse and is medium"),
        ({"linear": "superlu"}, "its linear solver was pardiso and is superlu"),
        ({"version": "9.9"}, "its version of pysprings was "),
        ({"engine": "0" * 64}, "its engine was sha256 [0-9a-f]{64} and is sha256 0{64}"),
    ],
    ids=lambda value: "" if isinstance(value, str) else next(iter(value)),
)
def test_another_run_is_refused(
    stopped: Path, monkeypatch: pytest.MonkeyPatch, changed: dict[str, Any], words: str
) -> None:
    if "linear" in changed:
        pytest.importorskip("pypardiso")
    monkeypatch.setattr("pysprings.core.version.__version__", changed.pop("version", pysprings.__version__))
    digest = changed.pop("engine", engine_digest())
    monkeypatch.setattr(work, "engine_digest", lambda: digest)
    before = contents(stopped)
    scene = drained().replace(**changed.pop("scene", {}))
    with pytest.raises(UserInputError, match=f"another run was interrupted here: {words}"):
        compute(scene, **changed, checkpoints=Checkpoints(stopped), resume=True)
    assert contents(stopped) == before


def test_other_libraries_are_noted(stopped: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(stopped, tmp_path / "copy")
    files = sorted((folder / "checkpoint").iterdir())
    assert len(files) > 1
    for file in files:
        saved = checkpoint.read(file)
        assert saved.meta["environment"]["numpy"] == np.__version__
        other = saved.meta["environment"] | {"numpy": "1.2.3", "threads of numba": "999"}
        checkpoint.write(file, checkpoint.Saved(saved.meta | {"environment": other}, saved.arrays))
    result = compute(drained(), checkpoints=Checkpoints(folder), resume=True).recorded()
    (note,) = record_of(result)["warnings"]
    threads = record_of(result)["environment"]["threads of numba"]
    assert f"numpy 1.2.3 (here {np.__version__}), threads of numba 999 (here {threads}): last digits may differ" in note
    again = compute(
        drained(), checkpoints=Checkpoints(shutil.copytree(stopped, tmp_path / "same")), resume=True
    ).recorded()
    assert record_of(again)["warnings"] == []


def test_environments_that_differ() -> None:
    now = {"numpy": "2", "MKL": "3"}
    assert differences([], now) == differences([now, now], now) == []
    first, second = differences([{"numpy": "1", "MKL": "3"}, now, {"numpy": "2"}, {"numpy": "1", "MKL": "3"}], now)
    assert "numpy 1 (here 2)" in first and "MKL" not in first
    assert "MKL unknown (here 3)" in second


def test_the_record_names_what_computed_it() -> None:
    import numba
    import scipy

    environment = record_of(straight("drained"))["environment"]
    versions = (np.__version__, scipy.__version__, numba.__version__)
    assert tuple(environment[name] for name in ("numpy", "scipy", "numba")) == versions
    assert int(environment["threads of numba"]) == numba.get_num_threads()
    if record_of(straight("drained"))["solver"]["linear"] == "pardiso":
        assert re.fullmatch(r"[0-9]{4}\.[0-9.]+", environment["MKL"]) and int(environment["threads of MKL"]) >= 1
    else:
        assert "MKL" not in environment


def test_a_checkpoint_holds_no_pickles(tmp_path: Path) -> None:
    file = tmp_path / "a.npz"
    checkpoint.write(file, checkpoint.Saved({"a": [1.5, float("inf")]}, {"x": np.arange(3.0)}))
    found = checkpoint.read(file)
    assert found.meta == {"a": [1.5, float("inf")]}
    np.testing.assert_array_equal(found.arrays["x"], np.arange(3.0))
    checkpoint.write(file, checkpoint.Saved({}, {"x": np.array([object()])}))
    with pytest.raises(checkpoint.Damaged):
        checkpoint.read(file)


# --- the command ---


@pytest.fixture
def scene_file(tmp_path: Path) -> Path:
    return tiny.write(drained(), tmp_path / "caisson.toml")


def interrupted(folder: Path, after: int = 8) -> Path:
    """Leave an interrupted run in a folder."""
    with pytest.raises(KeyboardInterrupt):
        run_to_folder(drained(), folder, progress=Stop(after))
    return folder


def test_resume_finishes_an_interrupted_run(tmp_path: Path, scene_file: Path) -> None:
    out = interrupted(tmp_path / "out")
    assert json.loads((out / "run.json").read_text())["status"] == "interrupted"
    before = contents(out)
    refused = command("run", scene_file, "--out", out)
    assert (refused.code, refused.out) == (2, "")
    words = "holds an interrupted run; --resume goes on with it, --force begins anew"
    assert refused.err == f"fatal: user input: {out}: --out: {words}\n"
    both = command("run", scene_file, "--out", out, "--resume", "--force")
    assert both.code == 2 and "give one of them" in both.err
    assert contents(out) == before
    done = command("run", scene_file, "--out", out, "--resume")
    assert done.code == 0, done.err
    assert done.out.startswith(f"results in {out} (complete)\n")
    assert "checkpoints: " in done.out and "resumed 20" in done.out
    assert set(contents(out)) == set(run_files())
    with xr.open_datatree(out / "full_model.nc", engine="netcdf4", decode_timedelta=False) as tree:
        for path in ("pull", "second"):
            np.testing.assert_array_equal(tree[f"paths/{path}/H"], straight("drained")[f"paths/{path}/H"])
    before = contents(out)
    again = command("run", scene_file, "--out", out, "--resume")
    assert again.code == 0
    assert f"the run in {out} has ended (complete): nothing is left to do\n" in again.err
    assert again.out == done.out
    other = command("run", tiny.write(tiny.scene(), tmp_path / "other.toml"), "--out", out, "--resume")
    assert other.code == 2 and "those of another scene or mesh" in other.err
    assert command("run", scene_file, "--out", out, "--mesh", "medium", "--resume").code == 2
    assert contents(out) == before


def test_a_new_run_throws_old_checkpoints_away_once_it_has_its_own(stopped: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(stopped, tmp_path / "copy")
    before = contents(folder)
    with pytest.raises(KeyboardInterrupt):  # before it has any
        compute(tiny.scene(), progress=Stop(1, of="model"), checkpoints=Checkpoints(folder))
    assert contents(folder) == before
    compute(tiny.scene(), progress=Stop(1), checkpoints=Checkpoints(folder))
    assert set(contents(folder / "checkpoint")) == {"start.npz", "path-000.npz"}


class Interrupting(np.ndarray):
    """An array that interrupts who packs it."""

    @property
    def flags(self) -> Any:
        signal.raise_signal(signal.SIGINT)
        return super().flags


def test_an_interrupt_waits_until_a_checkpoint_is_written(tmp_path: Path) -> None:
    """Within a ZIP archive it would end in a ValueError of its close, as an error of the program."""
    file = tmp_path / "path-000.npz"
    with pytest.raises(KeyboardInterrupt):
        checkpoint.write(file, checkpoint.Saved({"step": 3}, {"u": np.arange(3.0).view(Interrupting)}))
    np.testing.assert_array_equal(checkpoint.read(file).arrays["u"], np.arange(3.0))


def test_a_run_killed_while_it_estimates_its_error_repeats_no_path(tmp_path: Path, whole_series: Path) -> None:
    """Neither one of its own nor one on the coarser mesh."""
    out, seen = tmp_path / "out", []

    def kill(path: str, *_: object) -> None:
        seen.append(path)
        if path == "coarser mesh, 5 harmonics, second":
            raise Killed

    with pytest.raises(Killed):
        run_to_folder(series(), out, progress=kill)
    left = ["path-000.npz", "path-001.npz", "start.npz"]
    kept = [*(f"coarser-3-{name}" for name in left), "coarser-5few-path-000.npz", "coarser-5few-start.npz", *left]
    assert sorted(contents(out / "checkpoint")) == kept
    again: list[str] = []
    run_to_folder(series(), out, progress=lambda path, *_: again.append(path), resume=True)
    assert {name for name in again if not name.endswith("model")} == {"coarser mesh, 5 harmonics, second"}
    assert set(contents(out)) == set(contents(whole_series))
    ours, theirs = (json.loads((each / "run.json").read_text()) for each in (out, whole_series))
    assert ours["error_estimate"] == theirs["error_estimate"] and ours["error_estimate"]["estimate_pct"]
    with xr.open_datatree(out / "full_model.nc", engine="netcdf4", decode_timedelta=False) as tree:
        reference = xr.open_datatree(whole_series / "full_model.nc", engine="netcdf4", decode_timedelta=False)
        for path in ("pull", "second"):
            np.testing.assert_array_equal(tree[f"paths/{path}/H"], reference[f"paths/{path}/H"])
        reference.close()


def series() -> pysprings.Scene:
    return drained().replace(mesh={"discretisation": "fourier", "harmonics": 3})


@pytest.fixture(scope="module")
def whole_series(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run_to_folder(series(), tmp_path_factory.mktemp("series") / "out")


def test_nothing_to_resume(tmp_path: Path, scene_file: Path) -> None:
    done = command("run", scene_file, "--out", tmp_path / "out", "--resume")
    assert done.code == 2
    words = "--resume: nothing to resume: no interrupted run in this folder"
    assert done.err == f"fatal: user input: {tmp_path / 'out'}: {words}\n"
    assert not (tmp_path / "out").exists()
    out = interrupted(tmp_path / "out")
    shutil.rmtree(out / "checkpoint")
    done = command("run", scene_file, "--out", out, "--resume")
    assert done.code == 2 and "its checkpoints are gone" in done.err


@pytest.mark.skipif(os.name == "nt", reason="signals are different there")
def test_a_run_killed_before_its_first_checkpoint_begins_from_the_start(tmp_path: Path, scene_file: Path) -> None:
    """Where the folder has results, or another scene's run was killed, it does not."""
    out, other = tmp_path / "out", tiny.write(drained().replace(soil={"K0": 0.9}), tmp_path / "other.toml")
    killed = (
        "from pysprings.full_model.checkpoint import Checkpoints as c; from pysprings.cli.app import main; import os; "
        "c.begin = lambda *_, **more: os.kill(os.getpid(), 9); main()"
    )
    first = [sys.executable, "-c", killed, "run", str(scene_file), "--out", str(out)]
    assert subprocess.run(first, env=environment(), capture_output=True, check=False).returncode == -9
    (out / "mine.txt").write_text("mine")
    left = shutil.copytree(out, tmp_path / "left")
    refused = command("run", other, "--out", left, "--resume")
    assert (refused.code, "nothing to resume" in refused.err, list(contents(left))) == (2, True, ["mine.txt"])
    done = command("run", scene_file, "--out", out, "--resume")
    assert done.code == 0, done.err
    assert "note: the run here was killed before its first checkpoint: it begins from the start\n" in done.err
    before = contents(out)
    assert set(before) == {*run_files(), "mine.txt"}
    assert json.loads((out / "run.json").read_text())["resumed"] == []
    assert subprocess.run([*first, "--force"], env=environment(), capture_output=True, check=False).returncode == -9
    ended = command("run", scene_file, "--out", out, "--resume")
    assert "has ended (complete): nothing is left to do" in ended.err
    assert contents(out) == before


def test_a_run_that_did_not_converge_cannot_end_otherwise(tmp_path: Path) -> None:
    file, out = tiny.write(tiny.stuck_scene(), tmp_path / "stuck.toml"), tmp_path / "out"
    assert command("run", file, "--out", out).code == 3
    before = contents(out)
    assert not (out / "checkpoint").exists()
    done = command("run", file, "--out", out, "--resume")
    assert done.code == 3 and "has ended (partial)" in done.err
    assert contents(out) == before


@pytest.mark.slow
def test_results_of_an_earlier_run_stay_until_there_are_new_ones(tmp_path: Path) -> None:
    run_to_folder(tiny.scene(), tmp_path)
    before = contents(tmp_path)

    with pytest.raises(Killed):
        run_to_folder(drained(), tmp_path, progress=Stop(8, Killed))
    left = {name: data for name, data in contents(tmp_path).items() if not name.startswith("checkpoint")}
    assert left == before
    run_to_folder(drained(), tmp_path, resume=True)
    assert set(contents(tmp_path)) == set(run_files())
    assert json.loads((tmp_path / "run.json").read_text())["scene_sha256"] == drained().sha256


@pytest.mark.slow
def test_a_second_run_is_refused(tmp_path: Path, scene_file: Path) -> None:
    """While the first one computes; the folder then has the results of the first."""
    seen = []

    def progress(*_: object) -> None:
        if not seen:
            env = environment()
            args = [sys.executable, "-m", "pysprings", "run", str(scene_file), "--out", str(tmp_path / "out")]
            seen.append(subprocess.run([*args, "--force"], capture_output=True, text=True, env=env, timeout=60))

    run_to_folder(drained(), tmp_path / "out", progress=progress)
    (second,) = seen
    assert (second.returncode, second.stdout) == (4, "")
    (line,) = second.stderr.splitlines()
    assert line.startswith(f"fatal: resources: {tmp_path / 'out'}: another run (process {os.getpid()} on ")
    assert set(contents(tmp_path / "out")) == set(run_files())


# --- memory and disk ---


def test_out_of_memory_keeps_what_converged(tmp_path: Path, scene_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    solve, calls = Newton.solve, []

    def starving(*args: Any) -> Any:
        calls.append(0)
        if len(calls) == 7:
            raise MemoryError
        return solve(*args)

    monkeypatch.setattr(Newton, "solve", starving)
    out = tmp_path / "out"
    done = command("run", scene_file, "--out", out)
    assert done.code == 4
    assert done.out.startswith(f"results in {out} (interrupted)\n")
    assert done.err.splitlines()[-1] == (
        "fatal: resources: out of memory; try a smaller mesh (`pysprings check` estimates); "
        f"what converged is kept in {out}, --resume goes on from there"
    )
    assert json.loads((out / "run.json").read_text())["stopped_by"] == "out of memory"
    assert_same(compute(drained(), checkpoints=Checkpoints(out), resume=True).recorded(), straight("drained"))


def test_a_full_disk_stops_the_run_and_spoils_nothing(
    tmp_path: Path, scene_file: Path, monkeypatch: pytest.MonkeyPatch, every_step: None
) -> None:
    out, sync, calls = tmp_path / "out", os.fsync, []

    def full(handle: int) -> None:
        calls.append(0)
        if len(calls) > 9:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        sync(handle)

    monkeypatch.setattr(os, "fsync", full)
    done = command("run", scene_file, "--out", out)
    assert (done.code, done.out) == (4, "")
    line = done.err.splitlines()[-1]
    assert line.startswith(f"fatal: resources: {out / 'checkpoint'}{os.sep}path-000.npz")
    assert "the checkpoint cannot be written (No space left on device)" in line and "--resume" in line
    assert set(contents(out)) == {"checkpoint/start.npz", "checkpoint/path-000.npz"}
    monkeypatch.setattr(os, "fsync", sync)
    assert_same(compute(drained(), checkpoints=Checkpoints(out), resume=True).recorded(), straight("drained"))


def test_a_disk_that_is_full_for_the_results_leaves_the_checkpoints(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    resource = pytest.importorskip("resource")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    written = pysprings.results.folder.write_tree

    def full(*args: Any) -> Any:
        resource.setrlimit(resource.RLIMIT_FSIZE, (8192, before[1]))
        try:
            return written(*args)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)

    monkeypatch.setattr(pysprings.results.folder, "write_tree", full)
    with pytest.raises(ResourceError, match=r"full_model\.nc: cannot be written"):
        run_to_folder(drained(), tmp_path)
    assert all(name.startswith("checkpoint") for name in contents(tmp_path))
    monkeypatch.setattr(pysprings.results.folder, "write_tree", written)
    run_to_folder(drained(), tmp_path, resume=True)
    assert set(contents(tmp_path)) == set(run_files())


# --- signals ---


@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_a_request_to_end_is_an_interrupt(name: str) -> None:
    if not hasattr(signal, name) or os.name == "nt":
        pytest.skip("signals are different here")
    kind = getattr(signal, name)
    before = signal.signal(kind, signal.SIG_DFL)  # under nohup SIGHUP is ignored, and stays so
    try:
        with pytest.raises(KeyboardInterrupt), interruptible():
            os.kill(os.getpid(), kind)
            time.sleep(5)
        assert signal.getsignal(kind) == signal.SIG_DFL
    finally:
        signal.signal(kind, before)


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="signals are different there")
@pytest.mark.parametrize(("kind", "code"), [("SIGTERM", 130), ("SIGKILL", -9)])
def test_a_killed_process_goes_on(tmp_path: Path, kind: str, code: int) -> None:
    scene = tiny.scene(solver={"first_step_fraction": 0.002, "max_step_fraction": 0.002})
    file, out = tiny.write(scene, tmp_path / "caisson.toml"), tmp_path / "out"
    often = "from pysprings.full_model import checkpoint as c; c.EVERY = 0; from pysprings.cli.app import main; main()"
    args = [sys.executable, "-c", often, "run", str(file), "--out", str(out)]
    env = environment()
    with subprocess.Popen(args, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=env) as run:
        while run.poll() is None and not list(out.glob("checkpoint/path-*.npz")):
            time.sleep(0.01)
        run.send_signal(getattr(signal, kind))
        _, err = run.communicate(timeout=60)
    assert run.returncode == code
    if kind == "SIGTERM":
        assert err.endswith(f"go on with: pysprings run {file} --out {out} --resume\ninterrupted\n")
        assert not (out / ".pysprings.lock").exists()
    run_to_folder(scene, out, resume=True)
    assert set(contents(out)) == set(run_files())
    record = json.loads((out / "run.json").read_text())
    assert record["status"] == "complete" and record["resumed"][0]["from"].startswith("path 'pull', step ")
    with xr.open_datatree(out / "full_model.nc", engine="netcdf4", decode_timedelta=False) as tree:
        np.testing.assert_allclose(tree["paths/pull/H"], compute(scene).recorded()["paths/pull/H"], rtol=1e-10)
