# SPDX-License-Identifier: MIT
"""`pysprings compile`, and the compilation before the first run of a kind of scene."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numba
import pytest

from pysprings.cli import compiling
from pysprings.core import jit, workers
from pysprings.core.storage import read_tree
from pysprings.core.workers import Task
from pysprings.results.folder import Writing, run_to_folder
from pysprings.scene.load import load_scene
from pysprings.springs.checks import save_springs
from pysprings.studies.accuracy.runs import warm_up_scene
from tests.support import tiny
from tests.support.commands import command, run_python
from tests.support.fans import fan_springs, potential


@pytest.fixture
def mark(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The mark of kept loops, for every kind of scene; not there yet."""
    file = tmp_path / "mark"
    monkeypatch.setattr("pysprings.core.jit.mark_of", lambda _kind: file)
    return file


def test_compilation_is_named_once_and_measured() -> None:
    begun: list[int] = []
    inner = numba.njit(lambda x: x + 1.0)
    outer = numba.njit(lambda x: 2.0 * inner(x))
    with jit.compilation(lambda: begun.append(1)) as seconds:
        assert seconds() == 0.0
        assert outer(1.0) == 4.0
    assert begun == [1] and seconds() > 0.0
    with jit.compilation(lambda: begun.append(1)) as again:
        assert outer(2.0) == 6.0
    assert begun == [1] and again() == 0.0


def test_the_command_runs_a_small_model_and_leaves_nothing_but_loops(tmp_path: Path, mark: Path) -> None:
    file = tiny.write(tiny.scene(), tmp_path / "caisson.toml")
    done = command("compile", file, "--json")
    assert done.code == 0 and list(json.loads(done.out)["compiled_s"]) == [str(file)]
    assert mark.exists() and {path.name for path in tmp_path.iterdir()} == {"caisson.toml", "mark"}
    assert command("compile", tmp_path / "no.toml").code == 2


def test_a_fan_is_short_while_it_compiles_and_still_yields(tmp_path: Path) -> None:
    fan = tiny.scene(springs={"reach": 0.02, "held_back": False, "vertical": False}, paths=())
    small = warm_up_scene(fan, "fourier")
    assert small.springs.reach == pytest.approx(0.002)
    run_to_folder(small, tmp_path, estimate_error=False, writing=Writing(figures="none"))
    records = [path["convergence"].dataset for path in read_tree(tmp_path / "full_model.nc")["paths"].children.values()]
    assert all(float(each["n_plastic"].max()) > 0.0 for each in records)


def test_only_the_first_run_of_a_kind_compiles_before(
    mark: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    made: list[bool] = []
    monkeypatch.setattr(compiling, "compiled", lambda _scene, quiet, jobs: made.append((quiet, jobs)) or 3.4)
    compiling.compile_first(tiny.scene())
    assert capsys.readouterr().err == "note: compiled in 3 s; later runs have the loops\n"
    compiling.compile_first(tiny.scene(), quiet=True, jobs=3)
    assert made == [(False, 1), (True, 3)] and capsys.readouterr().err == ""
    mark.touch()
    compiling.compile_first(tiny.scene())
    assert len(made) == 2


def test_springs_of_an_atlas_compile_what_those_of_a_run_need() -> None:
    """The loops of a fan are compiled while another process compiles those of the model."""
    code = (
        "import sys\nfrom pysprings.cli import compiling\nfrom pysprings.core.storage import read_tree\n"
        "from pysprings.macro import solver\nfrom pysprings.macro.predict import curve\n"
        "def known():\n    return {n: [*f.signatures] for n, f in vars(solver).items() if hasattr(f, 'signatures')}\n"
        "compiling._springs(print)\nbefore = known()\ncurve(read_tree(sys.argv[1]), u_max=1e-3, n=2)\n"
        "assert before['follow'] and before['fan_rows']\nprint(before == known())"
    )
    done = run_python("-c", code, save_springs(fan_springs(potential), Path("springs.nc")))
    assert done.stdout.endswith("True\n"), done.stderr


def test_loops_are_compiled_in_two_processes(
    mark: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """One note for both; the longer time, or the sum of one process; what fails is left to the run."""
    compiling.compiled(tiny.scene(), jobs=2)
    assert mark.exists()
    capsys.readouterr()

    def fake(tasks: Sequence[Task], _jobs: int, done: Callable[[Task, Any], object]) -> None:
        for task, seconds in zip(tasks, (3.0, 2.0), strict=True):
            assert task.progress is not None
            task.progress("compiling", 0.0, "")
            done(task, seconds)
        done(tasks[0], ValueError("no mesh"))

    monkeypatch.setattr(workers, "run_tasks", fake)
    assert [compiling.compiled(tiny.scene(), jobs=jobs) for jobs in (1, 2)] == [5.0, 3.0]
    assert capsys.readouterr().err.count("compiling the loops") == 2
    assert compiling.compiled(tiny.scene(), quiet=True, jobs=2) == 3.0 and not capsys.readouterr().err


def test_what_makes_a_kind(scene_file: Path) -> None:
    """Laws, water and kinds of paths do; numbers do not."""
    same = ['soil.young_modulus="80 MPa"', "interface.friction_coefficient=0.3", 'caisson.skirt_length="3 m"']
    other = ["soil.yield_surface=elastic", "drainage.mode=undrained", "path.pull.kind=translation"]
    kinds = [compiling._kind(load_scene(scene_file, [change])) for change in (*same, *other)]
    assert set(kinds[: len(same)]) == {compiling._kind(load_scene(scene_file))}
    assert len(set(kinds)) == 1 + len(other)
