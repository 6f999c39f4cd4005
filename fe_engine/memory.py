# SPDX-License-Identifier: MIT
"""Memory that this process may have, and what is left of it: judged before an allocation that would not be refused.

The libraries below do not all come back from a refused allocation: OpenBLAS tries again for ever, MKL ends the process.
"""

from __future__ import annotations

import math
from pathlib import Path

CGROUP, MY_GROUPS = Path("/sys/fs/cgroup"), Path("/proc/self/cgroup")
# Working memory of OpenBLAS, mapped by each thread at its first product: 34 MB measured (x86-64, NumPy's and SciPy's).
_BLAS_BYTES_PER_THREAD = 0.04e9
_MAPPED = {"threads": 0}  # of OpenBLAS that have it: they keep it


def limit() -> float:
    """Return the upper limit of memory (bytes) of this process: machine, control groups and address space."""
    import psutil

    return min(float(psutil.virtual_memory().total), *cgroup_limits(), address_space())


def left() -> float:
    """Return the memory (bytes) available to this process: free on the machine and within its limits."""
    import psutil

    about, machine = psutil.Process().memory_info(), psutil.virtual_memory()
    free = float(min(machine.available + psutil.swap_memory().free, machine.total))
    return max(min(free, min(cgroup_limits()) - about.rss, address_space() - about.vms), 0.0)


def require(needed: float, what: str) -> None:
    """Raise MemoryError, with the figures, where ``needed`` bytes are not left for something."""
    there = left()
    if needed > there:
        raise MemoryError(f"{what} needs {needed / 1e9:.3g} GB, {there / 1e9:.3g} GB are left")


def require_for_blas(needed: float, threads: int, what: str) -> None:
    """Raise MemoryError where ``needed`` bytes are not left beside what OpenBLAS maps for so many threads."""
    require(needed + _BLAS_BYTES_PER_THREAD * max(threads - _MAPPED["threads"], 0), what)
    _MAPPED["threads"] = max(threads, _MAPPED["threads"])


def cgroup_limits(root: Path = CGROUP, groups: Path = MY_GROUPS) -> list[float]:
    """Return limits (bytes) of the control groups of this process (Linux; versions 2 and 1); infinity: none.

    ``root`` is where they are mounted, ``groups`` the file that lists those of the process.
    """
    limits = [math.inf]
    try:
        lines = groups.read_text(encoding="ascii", errors="replace").splitlines()
    except OSError:
        return limits
    for line in lines:
        _, controllers, group = line.split(":", 2)
        if controllers not in ("", "memory"):
            continue
        base, name = (root, "memory.max") if not controllers else (root / "memory", "memory.limit_in_bytes")
        place = base / group.strip("/")
        limits += [_number_in(each / name) for each in (place, *place.parents) if each == base or base in each.parents]
    return limits


def _number_in(file: Path) -> float:
    try:
        text = file.read_text(encoding="ascii", errors="replace").strip()
    except OSError:
        return math.inf
    return float(text) if text.isdigit() else math.inf


def address_space() -> float:
    """Return the limit of the address space in bytes (`ulimit -v`), infinity where there is none."""
    try:
        import resource
    except ImportError:  # Windows
        return math.inf
    soft = resource.getrlimit(resource.RLIMIT_AS)[0]
    return math.inf if soft == resource.RLIM_INFINITY else float(soft)
