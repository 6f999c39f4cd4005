# SPDX-License-Identifier: MIT
"""Check the header of a NetCDF file: content that is too large is rejected before a number is loaded.

Arrays that were never written take no room on a disk, whatever their size: a file of 100 kB can ask for any memory.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pysprings.core.errors import ResourceError, refused

MOST_SPRINGS = 100e6  # bytes of a spring set, unpacked: hundreds of paths
MOST_GROUPS = 20_000
MOST_VARIABLES = 200  # in a group
MOST_ATTRIBUTES = 500  # of a group or variable
MOST_SHOWN = 40  # letters of a name
_DENSEST = 1032.0  # bytes that one byte of deflate can stand for at best
_SPARE = 10e6  # bytes that a small file may have beyond that: fill values of short arrays


def judge_header(path: str | os.PathLike[str]) -> None:
    """Refuse a file whose groups, variables or attributes are too many, or whose arrays are too large.

    Raises
    ------
    UserInputError
        The numbers, or sizes beyond what a file of this size can hold, or beyond a spring set's.
    ResourceError
        The content needs more memory than is free.
    """
    import netCDF4
    import psutil

    name, packed = str(path), Path(path).stat().st_size
    with netCDF4.Dataset(os.fspath(path)) as root:
        total = _sizes(name, root)
        springs = "schema" in root.ncattrs()
    if total > _DENSEST * packed + _SPARE:
        _refuse(name, f"{total / 1e9:,.3g} GB when unpacked from {packed / 1e6:.3g} MB: most of it was never written")
    if springs and max(total, packed) > MOST_SPRINGS:
        size = max(total, packed) / 1e6
        _refuse(name, f"{size:,.0f} MB when unpacked; a set of springs has at most {MOST_SPRINGS / 1e6:.0f} MB")
    free = psutil.virtual_memory().available
    if total > free:
        raise ResourceError(f"{path}: {total / 1e9:,.3g} GB when unpacked; {free / 1e9:.3g} GB of memory are free")


def _sizes(name: str, root: Any) -> float:
    """Return the bytes of all variables; refuse what is too many. Texts count as pointers."""
    total = 0.0
    for number, group in enumerate(_groups(root), start=1):
        if number > MOST_GROUPS:
            _refuse(name, f"holds more than {MOST_GROUPS:,} groups")
        _refuse_many(name, group.path, len(group.variables), MOST_VARIABLES, "variables")
        _refuse_many(name, group.path, len(group.ncattrs()), MOST_ATTRIBUTES, "attributes")
        for key, variable in group.variables.items():
            _refuse_many(name, f"{group.path}/{key}", len(variable.ncattrs()), MOST_ATTRIBUTES, "attributes")
            total += float(math.prod(variable.shape)) * getattr(variable.dtype, "itemsize", 8)
    return total


def _groups(group: Any) -> Iterator[Any]:
    yield group
    for each in group.groups.values():
        yield from _groups(each)


def _refuse_many(name: str, place: str, count: int, most: int, what: str) -> None:
    if count > most:
        _refuse(name, f"holds {count:,} {what} in '{place[-MOST_SHOWN:]}', at most {most:,}")


def _refuse(name: str, message: str) -> None:
    raise refused(None, message, name)
