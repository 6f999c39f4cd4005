# SPDX-License-Identifier: MIT
"""A study in a folder: what has not ended is run by the workers, `cases.csv` follows, `study.nc` comes last.

The folder of a case is the truth: it is named by the number of its scene, and marked when it has ended. A study that
was interrupted in any way goes on with the same call.
"""

import json
import secrets
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from pysprings.core.errors import ResourceError, refused
from pysprings.core.progress import Progress, duration
from pysprings.core.storage import remove_leftovers, write_text
from pysprings.core.written import exclusive, new_folder, own_folder
from pysprings.studies.sweep import worker
from pysprings.studies.sweep.plan import AGAIN, CASES, OPEN, SKIP, STOPPED, Case, Plan, State, read_cases, write_cases

STUDY = "study.json"
_AHEAD = 4  # cases that wait at the scheduler for each that runs
_FULL = 3  # cases in a row without disk or memory, after which the study stops
_WRITE_SHARE = 0.05  # of the time, for cases.csv
_LEAST_PAUSE = 2.0  # s between two writings of cases.csv


@dataclass
class Study:
    """A study that runs: its plan as cases.csv has it, the folder, how each case stands, remarks on values."""

    plan: Plan
    out: Path
    hashes: dict[int, str]
    states: dict[int, State] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)
    ran: int = 0
    carried: int = 0
    _written: float = -1e9
    _cost: float = 0.0

    def folder(self, number: int) -> Path:
        """Return the folder of a case."""
        return self.out / worker.FOLDER / self.hashes[number]

    @cached_property
    def _alike(self) -> dict[str, list[int]]:
        """Numbers of the cases by folder name."""
        found: dict[str, list[int]] = {}
        for number, name in self.hashes.items():
            found.setdefault(name, []).append(number)
        return found

    def note(self, ended: worker.Ended) -> None:
        """Take over how a case ended; cases with the same scene stand alike."""
        for number in self._alike[ended.name]:
            self.states[number] = State(ended.status, ended.reason, ended.seconds, ended.name)

    def write(self, force: bool = False) -> None:
        """Write cases.csv, unless it was written a moment ago."""
        now = time.monotonic()
        if force or now - self._written > max(_LEAST_PAUSE, self._cost / _WRITE_SHARE):
            write_cases(self.out, self.plan, self.states)
            self._written = time.monotonic()
            self._cost = self._written - now


def sweep(
    plan: Plan, out: Path, place: worker.Place, progress: Progress, say: Callable[[str], object] = lambda _: None,
    again: bool = False,
) -> Study:  # fmt: skip
    """Run the cases of a plan that have not ended; return the study.

    ``again``: rows of cases.csv that another study file made are replaced. ``say`` gets sentences for the user.

    Raises UserInputError: values that make no scene; a folder with another study.
    Raises ResourceError: the scheduler went away; no disk or memory. What has ended stays.
    """
    with new_folder(out), exclusive(out):
        remove_leftovers(out, own_folder(out, worker.FOLDER))
        study = _opened(plan, out, again)
        study.write(force=True)
        waiting = [case for case in study.plan.cases if study.states[case.number].status in OPEN]
        try:
            if waiting:
                _run(study, waiting, place, progress, say)
        finally:
            with suppress(OSError):  # a full disk: the folders have everything
                study.write(force=True)
        return study


def planned(plan: Plan, out: Path, again: bool = False) -> Study:
    """Check the cases of a plan and write cases.csv; run nothing. Raises as `sweep` does."""
    with new_folder(out), exclusive(out):
        study = _opened(plan, out, again)
        study.write(force=True)
        return study


def _opened(plan: Plan, out: Path, again: bool) -> Study:
    """Return the study of a folder, with what has ended in it."""
    asked: dict[int, str] = {}
    stamp = out / STUDY
    known = _stamp(stamp)
    if (out / CASES).exists():
        if known != plan.digest and not again:
            what = (
                "cases.csv here is of no study" if known is None else "the study has changed since cases.csv was made"
            )
            raise refused("--out", f"{what}; --again makes it anew (what has run stays)", out)
        if known == plan.digest:
            plan, asked = read_cases(out, plan)
    names, remarks = plan.checked()
    if known is None or not asked:
        write_text(json.dumps({"title": plan.title, "plan": plan.digest}) + "\n", stamp)
    study = Study(plan, out, dict(zip((case.number for case in plan.cases), names, strict=True)), remarks=remarks)
    for case in plan.cases:
        study.states[case.number] = _state(study, case, asked.get(case.number, ""))
    return study


def _stamp(file: Path) -> str | None:
    try:
        return str(json.loads(file.read_text(encoding="utf-8"))["plan"])
    except (OSError, ValueError, LookupError, TypeError):
        return None


def _state(study: Study, case: Case, asked: str) -> State:
    """Return how a case stands by its folder and by what a person asked for."""
    folder = study.folder(case.number)
    if asked == SKIP:
        return State(SKIP, hash=folder.name)
    if asked == AGAIN:
        (folder / worker.ENDED).unlink(missing_ok=True)
        return State(hash=folder.name)
    ended = worker.read_ended(folder, study.plan.keep == "all")
    if ended is None or ended.status == STOPPED:
        return State(hash=folder.name)
    return State(ended.status, ended.reason, ended.seconds, folder.name)


def _run(
    study: Study, waiting: list[Case], place: worker.Place, progress: Progress, say: Callable[[str], object]
) -> None:
    """Have the workers run cases; each scene once."""
    sign = secrets.token_hex(16)
    write_text(sign, study.out / worker.SIGN)
    first = {study.hashes[case.number]: case for case in reversed(waiting)}
    order = sorted(first.values(), key=lambda case: case.number)
    try:
        with worker.client_of(place) as client:
            workers = len(client.scheduler_info(n_workers=-1)["workers"])
            where = f"{workers} worker{'s' if workers != 1 else ''} at {client.scheduler.address}"
            say(f"{where}; {worker.dashboard(client)}")
            _follow(study, order, sign, client, progress)
    finally:
        (study.out / worker.SIGN).unlink(missing_ok=True)
    if study.carried:
        say(f"{study.carried} results were carried back by the scheduler: its workers do not share {study.out}")


def _follow(study: Study, order: list[Case], sign: str, client: Any, progress: Progress) -> None:
    """Submit cases, a few ahead of those that run, and take their answers as they come."""
    from distributed import as_completed

    start, done, short = time.monotonic(), 0, 0
    ahead = _AHEAD * max(1, len(client.scheduler_info(n_workers=-1)["workers"]))
    rest = iter(order)
    running = as_completed(list(_submitted(study, rest, sign, client, ahead)))
    try:
        for future in running:
            answer = _answer(future, study)
            future.release()
            _take(study, answer)
            done += 1
            short = short + 1 if answer.is_resource else 0
            if short >= _FULL:
                raise ResourceError(f"{short} cases in a row stopped: {answer.ended.reason}")
            left = (time.monotonic() - start) / done * (len(order) - done)
            text = f"{done} of {len(order)}" + (f", about {duration(left)} left" if done < len(order) else "")
            progress("cases", done / len(order), text)
            study.write()
            running.update(list(_submitted(study, rest, sign, client, 1)))
    finally:
        client.cancel(list(running.futures), force=True)


def _submitted(study: Study, cases: Iterator[Case], sign: str, client: Any, number: int) -> Iterator[Any]:
    """Submit the next cases; yield their futures."""
    for _ in range(number):
        case = next(cases, None)
        if case is None:
            return
        name = study.hashes[case.number]
        scene = study.plan.scene_of(case).to_toml()
        task = worker.Task(case.number, scene, str(study.out.resolve()), name, sign, study.plan.keep == "all")
        yield client.submit(worker.run_case, task, key=f"case-{case.id}-{name}-{sign[:8]}", pure=False)


def _answer(future: Any, study: Study) -> worker.Answer:
    """Return what a worker answered; an error that is none of ours stops the case, not the study."""
    from distributed import KilledWorker
    from distributed.client import FutureCancelledError

    number = int(future.key.split("-")[1])
    name = study.hashes[number]
    try:
        return future.result()
    except KilledWorker:
        text = "its workers died one after the other: memory? (--jobs 1 leaves more for each)"
        return worker.Answer(worker.Ended(number, STOPPED, text, 0.0, name))
    except (FutureCancelledError, TimeoutError, OSError) as error:
        raise ResourceError(f"the scheduler went away ({type(error).__name__}); the same command goes on") from None
    except Exception as error:  # of a worker: another version, a broken installation, a bug
        text = f"{type(error).__name__}: {error}".split("\n")[0]
        return worker.Answer(worker.Ended(number, STOPPED, text[:300], 0.0, name))


def _take(study: Study, answer: worker.Answer) -> None:
    """Put an answer into the study; unpack files that were carried back."""
    if answer.files is not None:
        worker.unpack(answer.files, study.folder(answer.ended.number))
        study.carried += 1
    study.ran += 1
    study.note(answer.ended)
