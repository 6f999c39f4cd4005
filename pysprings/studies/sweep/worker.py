# SPDX-License-Identifier: MIT
"""One case of a study, as a worker runs it: into its folder, or into one of its own that is carried back.

A case folder has `case.json` at its end: status, reason, seconds, number of the scene, version. A study reads it
in place of the much longer run.json. Cases run in processes of this machine, or at a Dask scheduler that is there
already: any cluster of Dask has its address or file, SLURM (dask-jobqueue), Kubernetes (dask-kubernetes), SSH.
"""

import importlib.util
import io
import json
import logging
import shutil
import tempfile
import time
import warnings
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from pysprings.core.errors import PyspringsError, ResourceError, RunIncomplete, UserInputError, shortened
from pysprings.core.storage import write_text
from pysprings.core.version import __version__
from pysprings.core.workers import THREADS
from pysprings.full_model.run_record import RunRecord
from pysprings.scene.load import parse_scene
from pysprings.studies.sweep.plan import DONE, FAILED, SCHEMA, SHORT, STOPPED

_SHARE = 0.9  # of the memory of this machine, for all workers
_DEATHS = 10  # of workers with a case, before the case is given up
_ATTEMPTS = 3  # to start the processes
_WAIT = 15.0  # s for a scheduler to answer
_LOGS = ("distributed", "distributed.client", "tornado.application", "asyncio")


@dataclass(frozen=True)
class Place:
    """Address or scheduler file of a scheduler; None: ``jobs`` processes here (None: a core each)."""

    scheduler: str | None = None
    jobs: int | None = None


def cores() -> int:
    """Return the cores of this machine that a process may use."""
    import psutil

    physical = psutil.cpu_count(logical=False) or 1
    usable = len(psutil.Process().cpu_affinity()) if hasattr(psutil.Process, "cpu_affinity") else physical
    return max(1, min(physical, usable))


@contextmanager
def client_of(place: Place) -> Iterator[Any]:
    """Give a client of the workers.

    Raises ResourceError: no scheduler answers there.
    """
    import dask

    settings = {
        "distributed.nanny.pre-spawn-environ": dict.fromkeys(THREADS, 1),
        "distributed.scheduler.allowed-failures": _DEATHS,
        "distributed.admin.tick.limit": "1h",
    }
    with dask.config.set(settings), _quiet():
        if place.scheduler is None:
            with _local(place.jobs or cores()) as client:
                yield client
        else:
            with _remote(place.scheduler) as client:
                yield client


@contextmanager
def _local(jobs: int) -> Iterator[Any]:
    import psutil
    from distributed import Client

    cluster = _started(jobs, int(_SHARE * psutil.virtual_memory().total / jobs))
    try:
        with Client(cluster) as client:
            yield client
    finally:
        with suppress(Exception):  # what is left of workers dies with this process
            cluster.close(timeout=5)


def _started(jobs: int, memory: int) -> Any:
    """Return processes that have started; a few attempts, as one that dies before it has started ends the attempt."""
    from distributed import LocalCluster

    for _ in range(_ATTEMPTS):
        try:
            return LocalCluster(
                n_workers=jobs, threads_per_worker=1, processes=True, memory_limit=memory, dashboard_address=":0",
                silence_logs=logging.CRITICAL,
            )  # fmt: skip
        except (RuntimeError, OSError, TimeoutError) as error:
            reason = f"{type(error).__name__}: {error}"
    raise ResourceError(f"the workers could not be started ({reason}); the same command goes on")


@contextmanager
def _remote(scheduler: str) -> Iterator[Any]:
    from distributed import Client

    where: dict[str, Any] = {"scheduler_file": scheduler} if Path(scheduler).is_file() else {"address": scheduler}
    try:
        client = Client(**where, timeout=_WAIT)
    except (OSError, ValueError, TimeoutError) as error:
        raise ResourceError(f"no scheduler answers at {scheduler} ({type(error).__name__}: {error})") from None
    try:
        yield client
    finally:
        with suppress(Exception):
            client.close(timeout=5)


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep what Dask logs about workers and schedulers that come and go off the terminal."""
    import distributed  # noqa: F401  (sets levels of its own)

    logs = [logging.getLogger(name) for name in _LOGS]
    levels = [log.level for log in logs]
    for log in logs:
        log.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for log, level in zip(logs, levels, strict=True):
            log.setLevel(level)


def dashboard(client: Any) -> str:
    """Return a sentence with the address of the dashboard, or what it needs."""
    if importlib.util.find_spec("bokeh") is None:
        return "dashboard: needs bokeh (pip install bokeh)"
    return f"dashboard: {client.dashboard_link}"


ENDED = "case.json"
SIGN = ".pysprings-study"  # a worker that sees this file of the study writes into its folder itself
NEW = ".carried"
FOLDER = "cases"


@dataclass(frozen=True)
class Task:
    """What a worker gets: the scene as TOML, folder of the study, name of the case, sign, whether to keep all files."""

    number: int
    scene: str
    out: str
    name: str
    sign: str
    keep_all: bool = False


@dataclass(frozen=True)
class Ended:
    """How a case ended."""

    number: int
    status: str
    reason: str
    seconds: float
    name: str
    version: str = f"{__version__}, {SCHEMA}"
    scene_sha256: str = ""


@dataclass(frozen=True)
class Answer:
    """What a worker returns: how the case ended, its files where the folder of the study is not shared."""

    ended: Ended
    files: bytes | None = None
    is_resource: bool = False


def read_ended(folder: Path, keep_all: bool = False) -> Ended | None:
    """Return how a case ended by its folder; None where it has not, with another version, or without its full model.

    keep_all : whether the study keeps all files of a case.
    """
    try:
        ended = Ended(**json.loads((folder / ENDED).read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return None
    if keep_all and ended.status in (DONE, SHORT) and not (folder / "full_model.nc").exists():
        return None
    return ended if ended.version == Ended.version and RunRecord.has_whole_results(folder) else None


def run_case(task: Task) -> Answer:
    """Run a case and return how it ended; a case that has ended is not run again. Never raises an error of ours."""
    out = Path(task.out)
    if _is_shared(out, task.sign):
        return _run(task, out / FOLDER / task.name)
    with tempfile.TemporaryDirectory(prefix="pysprings-") as place:
        folder = Path(place) / task.name
        answer = _run(task, folder)
        return Answer(answer.ended, packed(folder), answer.is_resource)


def _is_shared(out: Path, sign: str) -> bool:
    try:
        return (out / SIGN).read_text(encoding="utf-8") == sign
    except (OSError, ValueError):
        return False


def _run(task: Task, folder: Path) -> Answer:
    if (known := read_ended(folder, task.keep_all)) is not None:
        return Answer(known)
    start = time.monotonic()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        status, reason, digest = _computed(task, folder)
    except (PyspringsError, OSError, MemoryError) as error:
        refused = isinstance(error, UserInputError)
        ended = Ended(task.number, FAILED if refused else STOPPED, _line(error), time.monotonic() - start, task.name)
        return Answer(ended, is_resource=not refused)
    ended = Ended(task.number, status, reason, round(time.monotonic() - start, 2), task.name, scene_sha256=digest)
    try:
        write_ended(folder, ended)
    except OSError as error:
        return Answer(Ended(task.number, STOPPED, _line(error), ended.seconds, task.name), is_resource=True)
    return Answer(ended)


def write_ended(folder: Path, ended: Ended) -> None:
    """Mark a case as ended."""
    write_text(json.dumps(asdict(ended)) + "\n", folder / ENDED)


def _computed(task: Task, folder: Path) -> tuple[str, str, str]:
    """Run the full model; return status, reason and the number of the scene."""
    from pysprings.full_model.accuracy.two_mesh import words
    from pysprings.results.folder import Writing, run_or_go_on

    scene = parse_scene(task.scene)
    with warnings.catch_warnings(action="ignore"), suppress(RunIncomplete):  # its record has them
        run_or_go_on(scene, folder, writing=Writing(springs_alone=not task.keep_all), estimate_error=None)
    record = RunRecord.read(folder)
    if record is None:
        return STOPPED, "no run.json was written", scene.sha256
    has_springs = (folder / "springs.nc").exists()
    status = DONE if record.complete and has_springs else SHORT if has_springs else FAILED
    estimate, missing = record.error_estimate, list(record.not_made.values())
    if not missing and estimate and not estimate["estimate_pct"]:
        missing = [words(estimate)]
    reason = "; ".join([*record.short, *missing]) or ("" if has_springs else "no springs")
    return status, _line(reason) if reason else "", scene.sha256


def _line(error: object) -> str:
    """Return an error as one line."""
    text = "; ".join(str(error).removeprefix("fatal: user input: ").split("\n")) or type(error).__name__
    return shortened(text)


def packed(folder: Path) -> bytes:
    """Return the files of a folder as one archive."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_STORED) as archive:
        for file in sorted(each for each in folder.rglob("*") if each.is_file()):
            archive.write(file, file.relative_to(folder).as_posix())
    return stream.getvalue()


def unpack(files: bytes, folder: Path) -> None:
    """Put the files of an archive into a folder that is whole or absent: files of an earlier run are replaced."""
    new = folder.with_name(folder.name + NEW)
    shutil.rmtree(new, ignore_errors=True)
    new.mkdir(parents=True)
    try:
        with zipfile.ZipFile(io.BytesIO(files)) as archive:
            archive.extractall(new)
        shutil.rmtree(folder, ignore_errors=True)
        new.rename(folder)
    finally:
        shutil.rmtree(new, ignore_errors=True)
