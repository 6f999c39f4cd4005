# SPDX-License-Identifier: MIT
"""Where the cases of a study run: processes of this machine, or a Dask scheduler that is there already.

Any cluster of Dask has a scheduler address or a scheduler file: SLURM (dask-jobqueue), Kubernetes
(dask-kubernetes), SSH.
"""

import importlib.util
import logging
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pysprings.core.errors import ResourceError

_SHARE = 0.9  # of the memory of this machine, for all workers
_DEATHS = 10  # of workers with a case, before the case is given up
_ATTEMPTS = 3  # to start the processes
_WAIT = 15.0  # s for a scheduler to answer
_LOGS = ("distributed", "distributed.client", "tornado.application", "asyncio")
_THREADS = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")


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

    Raises
    ------
    ResourceError
        No scheduler answers there.
    """
    import dask

    with dask.config.set({"distributed.nanny.pre-spawn-environ": dict.fromkeys(_THREADS, 1)}), _quiet():
        if place.scheduler is None:
            with _local(place.jobs or cores()) as client:
                yield client
        else:
            with _remote(place.scheduler) as client:
                yield client


@contextmanager
def _local(jobs: int) -> Iterator[Any]:
    import dask
    import psutil
    from distributed import Client

    memory = int(_SHARE * psutil.virtual_memory().total / jobs)
    with dask.config.set({"distributed.scheduler.allowed-failures": _DEATHS, "distributed.admin.tick.limit": "1h"}):
        cluster = _started(jobs, memory)
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
