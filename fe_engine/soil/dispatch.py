# SPDX-License-Identifier: MIT
"""Update of a point by the code of its law: `update(code, p, strain, old, new, tangent, with_tangent)`.

A model has one law or two of ten, and a law takes Numba one to two seconds: loops are compiled for the laws of a model.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from fe_engine.compiled import with_globals
from fe_engine.register import suffix
from fe_engine.soil.laws import SOIL_LAWS

_ARGUMENTS = "p, strain, old, new, tangent, with_tangent"
update_soil = SOIL_LAWS.chain("update", _ARGUMENTS, __name__)  # of all laws; loops that name it are never called


@cache
def update_of(codes: tuple[int, ...]) -> Any:
    """Return the update of the laws of these codes."""
    return SOIL_LAWS.chain("update", _ARGUMENTS, __name__, codes)


@cache
def of_laws(codes: tuple[int, ...], *loops: Any) -> Any:
    """Return the last of jitted functions that call `update_soil` or one before them, for the laws of these codes."""
    known, made = {"update_soil": update_of(codes)}, None
    for loop in loops:
        made = known[loop.__name__] = with_globals(loop, suffix(codes), known)
    return made
