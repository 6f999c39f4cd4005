# SPDX-License-Identifier: MIT
"""Independent work in worker processes: one scheduler for the paths of a run and the runs of a study.

Tasks are handed out one at a time, the longest first. Each worker is a process of `multiprocessing` with a pipe of its
own, so that one that dies costs its own task alone: it is started anew, and the task begins once more (a path goes on
from its checkpoint). `concurrent.futures` and loky give up every task of a pool when one worker dies, and the local
cluster of Dask takes some seconds more to start. Workers come from a fork server that has imported the modules of the
work once (where there is none, on Windows, each imports them itself): a fork of the program would inherit its threads.
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
import shutil
import signal
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.util import get_temp_dir
from typing import Any, Literal

from pysprings.core.errors import ResourceError, reason_of
from pysprings.core.process import interrupts
from pysprings.core.progress import Progress

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
PRELOADED = ["pysprings.full_model.paths"]
_TRIES = 2  # of a task whose worker dies
_STARTS = 6  # attempts at starting a worker, with ever longer pauses
_PATIENCE = 30.0  # s that a worker has to hand over what it has, when it is asked to stop
_TICK, _REPORTS = 0.2, 0.1  # s between looks at signals, and between two reports of a worker


@dataclass(frozen=True)
class Task:
    """``call(*arguments, progress)``, in a worker; both can be pickled. Tasks of the highest cost go first.

    ``progress`` gets the reports of the task instead of the progress function of all.
    """

    name: str
    call: Callable[..., Any]
    arguments: tuple[Any, ...] = ()
    cost: float = 1.0
    progress: Progress | None = None


class WorkerDied(ResourceError):
    """The worker of a task was killed, more than once."""


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def in_worker() -> bool:
    """Return whether this process is a worker, which starts none of its own."""
    return multiprocessing.parent_process() is not None


class Workers:
    """Up to ``jobs`` processes, started as they are needed, and ended at the end of the ``with`` block.

    Their libraries compute on one thread, or with ``threads`` None on as many as this process would use.
    """

    def __init__(self, jobs: int, threads: Literal[1] | None = 1) -> None:
        self.jobs = jobs
        self._narrow = _one_thread if threads else nullcontext
        self._all: list[_Worker] = []
        self._context = multiprocessing.get_context("forkserver" if os.name == "posix" else "spawn")
        if os.name == "posix":
            self._context.set_forkserver_preload(PRELOADED)

    def __enter__(self) -> Workers:
        return self

    def __exit__(self, *_: object) -> None:
        for worker in self._all:
            worker.end()
        self._all.clear()

    def prepare(self) -> None:
        """Have the fork server import what workers need, while this process does something else."""
        if os.name == "posix":
            from multiprocessing import forkserver, resource_tracker

            resource_tracker.ensure_running()  # beforehand: when it starts, it undoes what follows
            with self._narrow(), _deaf():
                forkserver.ensure_running()

    def _start(self, number: int) -> None:
        """Start workers for so many tasks; ResourceError where that fails."""
        failures = 0
        while len(self._all) < min(number, self.jobs):
            self.prepare()
            try:
                with self._narrow(), _deaf():
                    self._all.append(_Worker(self._context))
            except (EOFError, OSError) as error:  # the fork server was killed: the next attempt starts another one
                failures += 1
                time.sleep(failures * _TICK)
                if failures == _STARTS:
                    raise ResourceError(f"no worker process starts ({reason_of(error)}); use --jobs 1") from error

    def run(
        self,
        tasks: Sequence[Task],
        done: Callable[[Task, Any], object],
        progress: Progress,
        note: Callable[[str], object],
    ) -> None:
        """Run tasks; ``done`` gets each with its value, or with the error that ended it.

        ``note`` gets a sentence on each worker that died. An interrupt asks the workers to stop: tasks that return what
        they have until then are done, too, and KeyboardInterrupt follows.
        """
        waiting, tries = sorted(tasks, key=lambda task: -task.cost), Counter[str]()
        deadline = float("inf")
        with interrupts() as asked:

            def report(task: Task, *content: Any) -> None:
                if not asked:  # workers that are asked to stop have nothing to report
                    (task.progress or progress)(*content)

            def remark(text: str) -> None:
                if not asked:
                    note(text)

            try:
                while (waiting and not asked) or self._busy:
                    if asked and deadline == float("inf"):
                        deadline = time.monotonic() + _PATIENCE
                        for worker in self._busy:
                            worker.process.terminate()
                    if time.monotonic() > deadline or len(asked) > 1:
                        break
                    if not asked:
                        self._hand_out(waiting)
                    for worker in self._ready():
                        try:
                            self._hear(worker, waiting, tries, done, report, remark)
                        except KeyboardInterrupt:
                            asked.append(0)
            finally:
                for worker in self._all if asked else self._busy:  # an error, or a worker that was asked to stop
                    self._remove(worker)
        if asked:
            raise KeyboardInterrupt

    @property
    def _busy(self) -> list[_Worker]:
        return [worker for worker in self._all if worker.task is not None]

    def _hand_out(self, waiting: list[Task]) -> None:
        for worker in [each for each in self._all if each.task is None and not each.process.is_alive()]:
            self._remove(worker)  # it has died idle, which is no try of a task
        self._start(len(waiting) + len(self._busy))
        for worker in self._all:
            if waiting and worker.task is None:
                worker.take(waiting.pop(0))

    def _ready(self) -> list[_Worker]:
        """Return the busy workers that have sent something or have died."""
        found = wait([worker.pipe for worker in self._busy], _TICK)
        return [worker for worker in self._busy if worker.pipe in found]

    def _hear(
        self, worker: _Worker, waiting: list[Task], tries: Counter[str], done: Callable[[Task, Any], object],
        report: Callable[..., object], note: Callable[[str], object],
    ) -> None:  # fmt: skip
        """Take what a worker has sent."""
        task = worker.task
        assert task is not None
        try:
            kind, content = worker.pipe.recv()
        except (EOFError, OSError):
            why = self._remove(worker)
            tries[task.name] += 1
            if tries[task.name] < _TRIES:
                note(f"{task.name}: {why}; it goes on in another one")
                waiting.insert(0, task)
                self.jobs = max(1, self.jobs - 1)  # memory that was short is so again
            else:
                done(task, WorkerDied(f"{task.name}: {why}, {_TRIES} times"))
            return
        if kind == _REPORT:
            report(task, *content)
            return
        worker.task = None
        if kind != _STOPPED:
            done(task, content)

    def _remove(self, worker: _Worker) -> str:
        """Remove a worker, dead or not; return how it ended."""
        self._all = [each for each in self._all if each is not worker]
        return worker.kill()


def _silent(*_: object) -> None:
    """Report nothing."""


def run_tasks(tasks: Sequence[Task], jobs: int, done: Callable[[Task, Any], object]) -> None:
    """Run tasks in worker processes, or one after the other in this process (1); see `Workers.run`."""
    if jobs > 1 and len(tasks) > 1:
        with Workers(jobs) as workers:
            workers.run(tasks, done, _silent, _silent)
        return
    for task in tasks:
        try:
            answer = task.call(*task.arguments, task.progress or _silent)
        except Exception as error:
            answer = error
        done(task, answer)


class _Worker:
    """A process and what it is doing."""

    def __init__(self, context: Any) -> None:
        self.pipe, theirs = context.Pipe()
        self.task: Task | None = None
        folder = get_temp_dir() if os.name == "posix" else None  # of the fork server's socket
        self.process = context.Process(target=_serve, args=(theirs, folder), daemon=True)
        self.process.start()
        theirs.close()

    def take(self, task: Task) -> None:
        """Begin a task."""
        self.task = task
        with suppress(OSError):
            self.pipe.send((task.call, task.arguments))

    def kill(self) -> str:
        """End the process, whatever it does; return how it has ended, in words."""
        self.process.join(1.0)
        code = self.process.exitcode
        self.process.kill()
        self.end()
        if code is None or code >= 0:
            return f"a worker process ended{'' if code is None else f' with exit code {code}'}"
        return f"a worker process was ended by {signal.Signals(-code).name}" + (" (memory?)" if -code == 9 else "")

    def end(self) -> None:
        """End the process, which is idle or dead."""
        self.pipe.close()
        self.process.join(_PATIENCE)
        self.process.kill()


# --- in the worker ---

_REPORT, _DONE, _STOPPED = "report", "done", "stopped"


def _serve(pipe: Connection, folder: str | None) -> None:
    """Do what comes through the pipe until it is closed; interrupts are the parent's affair, which asks by SIGTERM."""
    turn = _Turn()
    for name in ("SIGINT", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    signal.signal(signal.SIGTERM, turn.stop)
    threading.Thread(target=_end_with_parent, args=(folder,), daemon=True).start()
    with suppress(EOFError, BrokenPipeError, ConnectionResetError):
        while True:
            call, arguments = pipe.recv()
            pipe.send(turn.answer(call, arguments, _reports(pipe)))


class _Turn:
    """The task of a worker, which a signal interrupts, now or when it comes; what it sends is never interrupted."""

    def __init__(self) -> None:
        self.busy = self.stopped = False

    def stop(self, *_: object) -> None:
        self.stopped = True
        if self.busy:
            raise KeyboardInterrupt

    def answer(self, call: Callable[..., Any], arguments: tuple[Any, ...], report: Progress) -> tuple[str, Any]:
        try:
            self.busy = True
            if self.stopped:
                raise KeyboardInterrupt
            value = call(*arguments, report)
            self.busy = False
        except KeyboardInterrupt:
            self.busy = False
            return _STOPPED, None
        except (BrokenPipeError, ConnectionResetError):
            raise
        except Exception as error:
            self.busy = False
            return _DONE, _sendable(error)
        return _DONE, value


def _sendable(error: Exception) -> Exception:
    """Return an error as it is, or its line where it does not survive its way."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError(reason_of(error))
    return error


def _reports(pipe: Connection) -> Progress:
    """Return the progress function of a task, which sends ten reports a second at most."""
    sent = [float("-inf")]

    def report(name: str, fraction: float, message: str) -> None:
        if time.monotonic() - sent[0] >= _REPORTS or fraction >= 1.0:
            sent[0] = time.monotonic()
            pipe.send((_REPORT, (name, fraction, message)))

    return report


def _end_with_parent(folder: str | None) -> None:
    """End this process at once when the program has ended: what it writes later would be in the way of another run.

    The program's temporary folder, which one that was killed leaves, goes.
    """
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        if folder is not None:
            shutil.rmtree(folder, ignore_errors=True)
        os._exit(1)


# --- in the program ---


@contextmanager
def _deaf() -> Iterator[None]:
    """Have processes that start in the block never receive Ctrl-C, which is for the program to answer."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGHUP})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _one_thread() -> Iterator[None]:
    """Have libraries of processes that start in the block compute on one thread."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
