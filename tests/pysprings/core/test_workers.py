# SPDX-License-Identifier: MIT
"""Worker processes: every task gets its answer, whatever becomes of the worker."""

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import psutil
import pytest

from pysprings.core.progress import Progress
from pysprings.core.workers import Task, WorkerDied, Workers, cores, run_tasks
from tests.support.commands import environment

pytestmark = pytest.mark.skipif(os.name == "nt", reason="signals are different there")


def twice(value: float, _: Progress) -> float:
    return 2.0 * value


class Stubborn(Exception):
    """An error that cannot be made anew from its arguments."""

    def __init__(self, one: int, two: int) -> None:
        super().__init__(f"{one} and {two}")


def fail(kind: str, _: Progress) -> None:
    raise Stubborn(1, 2) if kind == "stubborn" else ValueError(kind)


def die(mark: Path, always: bool, _: Progress) -> int:
    """End this process, the first time or always."""
    if always or not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return os.getpid()


def wait_for_the_end(seconds: float, progress: Progress) -> str:
    try:
        for k in range(1000):
            progress("wait", k / 1000, "")
            time.sleep(seconds / 1000)
    except KeyboardInterrupt:
        return "half"
    return "whole"


def threads(_: Progress) -> dict[str, int]:
    import numba
    import numpy as np
    from threadpoolctl import threadpool_info

    np.ones((2, 2)) @ np.ones((2, 2))
    return {"numba": numba.get_num_threads()} | {each["filepath"]: each["num_threads"] for each in threadpool_info()}


def answers(tasks: list[Task], jobs: int = 2, progress: Progress = lambda *_: None) -> tuple[dict[str, Any], list[str]]:
    found: dict[str, Any] = {}
    notes: list[str] = []
    with Workers(jobs) as workers:
        workers.run(tasks, lambda task, answer: found.update({task.name: answer}), progress, notes.append)
    return found, notes


def test_tasks_are_done_whatever_fails_among_them() -> None:
    tasks = [Task(str(k), twice, (k,), cost=k) for k in range(5)]
    tasks += [Task("fails", fail, ("because",)), Task("stubborn", fail, ("stubborn",)), Task("threads", threads)]
    found, notes = answers(tasks)
    assert {name: found[name] for name in "01234"} == {str(k): 2.0 * k for k in range(5)}
    assert isinstance(found["fails"], ValueError) and str(found["fails"]) == "because"
    assert isinstance(found["stubborn"], RuntimeError) and str(found["stubborn"]) == "Stubborn: 1 and 2"
    assert set(found["threads"].values()) == {1}
    assert notes == []


def test_the_longest_comes_first() -> None:
    order: list[str] = []
    with Workers(1) as workers:
        tasks = [Task(name, twice, (1.0,), cost) for name, cost in (("b", 2.0), ("c", 1.0), ("a", 3.0), ("d", 1.0))]
        workers.run(tasks, lambda task, _: order.append(task.name), lambda *_: None, lambda _: None)
    assert order == ["a", "b", "c", "d"]


def test_a_worker_that_dies_costs_its_own_task_one_attempt(tmp_path: Path) -> None:
    tasks = [Task("dies", die, (tmp_path / "mark", False)), *(Task(str(k), twice, (k,)) for k in range(4))]
    found, notes = answers(tasks)
    assert isinstance(found["dies"], int) and len(found) == 5
    assert notes == ["dies: a worker process was ended by SIGKILL (memory?); it goes on in another one"]
    found, notes = answers([Task("dies", die, (tmp_path / "mark", True)), Task("1", twice, (1,))])
    assert isinstance(found["dies"], WorkerDied) and found["1"] == 2.0 and len(notes) == 1
    assert str(found["dies"]) == "dies: a worker process was ended by SIGKILL (memory?), 2 times"


def test_a_worker_that_dies_idle_costs_no_attempt() -> None:
    notes: list[str] = []
    with Workers(2) as workers:
        for _ in range(2):
            tasks = [Task(str(k), twice, (k,)) for k in range(2)]
            workers.run(tasks, lambda *_: None, lambda *_: None, notes.append)
            for process in multiprocessing.active_children():
                process.kill()
                process.join()
    assert notes == []


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_task_reports_to_its_own_progress(jobs: int) -> None:
    heard: list[float] = []
    tasks = [Task(name, wait_for_the_end, (0.3,), progress=lambda *each: heard.append(each[1])) for name in "ab"]
    run_tasks(tasks, jobs, lambda *_: None)
    assert heard and max(heard) > 0.0


def ask(*_: object) -> None:
    os.kill(os.getpid(), signal.SIGINT)


def stop(*_: object) -> None:
    raise KeyboardInterrupt


@pytest.mark.parametrize("interrupt", [ask, stop])
def test_an_interrupt_waits_for_what_tasks_have(interrupt: Any) -> None:
    """Those on their way return it, those that wait do not begin; a signal, or an error of progress itself."""
    found: dict[str, Any] = {}
    before = signal.getsignal(signal.SIGINT)
    tasks = [Task(name, wait_for_the_end, (60.0,)) for name in "abc"]
    with Workers(2) as workers, pytest.raises(KeyboardInterrupt):
        workers.run(tasks, lambda task, answer: found.update({task.name: answer}), interrupt, print)
    assert found and set(found) <= {"a", "b"} and set(found.values()) == {"half"}
    assert signal.getsignal(signal.SIGINT) is before


@pytest.mark.parametrize("kind", [signal.SIGINT, signal.SIGKILL])
def test_ctrl_c_does_not_reach_the_server_and_a_dead_one_is_started_anew(kind: signal.Signals) -> None:
    """Ctrl-C would kill it while it imports."""
    from multiprocessing.forkserver import _forkserver as server

    with Workers(2) as workers:
        server._stop()
        workers.prepare()
        os.kill(server._forkserver_pid, kind)
        found: dict[str, Any] = {}
        tasks = [Task(str(k), twice, (k,)) for k in range(2)]
        workers.run(tasks, lambda task, answer: found.update({task.name: answer}), lambda *_: None, print)
    assert found == {"0": 0.0, "1": 2.0}


def test_an_error_of_the_program_ends_the_workers() -> None:
    def broken(*_: object) -> None:
        raise IndexError

    with Workers(2) as workers:
        with pytest.raises(IndexError):
            workers.run([Task("a", wait_for_the_end, (60.0,))], print, broken, print)
        assert workers._all == []


KILLED = """
from tests.pysprings.core.test_workers import *
if __name__ == "__main__":
    tasks = [Task(name, wait_for_the_end, (60.0,)) for name in "ab"]
    with Workers(2) as workers:
        workers.run(tasks, print, lambda *_: print("on its way", flush=True), print)
"""


@pytest.mark.slow
def test_workers_end_with_the_program(tmp_path: Path) -> None:
    """Killed, it cannot ask them to; nothing stays in the folder of temporary files."""
    script = tmp_path / "killed.py"
    script.write_text(KILLED)
    path = os.pathsep.join([str(Path(__file__).parents[3]), *sys.path])
    (temporary := tmp_path / "t").mkdir()
    with subprocess.Popen(
        [sys.executable, script],
        stdout=subprocess.PIPE,
        env=environment() | {"PYTHONPATH": path, "TMPDIR": str(temporary)},
    ) as program:
        assert program.stdout is not None
        assert program.stdout.readline() == b"on its way\n"
        children = psutil.Process(program.pid).children(recursive=True)
        assert os.name == "nt" or list(temporary.glob("pymp-*"))
        program.kill()
    assert len(children) >= 3  # the server, and workers
    _, alive = psutil.wait_procs(children, timeout=10)
    assert alive == [] and not list(temporary.glob("pymp-*"))


def test_cores() -> None:
    assert 1 <= cores() <= (os.cpu_count() or 1)
