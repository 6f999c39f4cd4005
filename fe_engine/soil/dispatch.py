# SPDX-License-Identifier: MIT
"""Update of a point by the code of its law, and its relaxation, see `law.SoilLaw`: the code, and their arguments.

A model has one law or two of ten, and a law takes Numba one to two seconds: loops are compiled for the laws of a model.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from fe_engine.compiled import with_globals
from fe_engine.register import suffix
from fe_engine.soil.laws import SOIL_LAWS
from fe_engine.soil.viscous import relax_point

_ARGUMENTS = "p, strain, old, new, tangent, with_tangent"
_RELAXED = "p, moduli, share, strain, old, new, tangent, with_tangent"
# of all laws; loops that name them are never called
update_soil = SOIL_LAWS.chain("update", _ARGUMENTS, __name__)
relax_soil = SOIL_LAWS.chain("relax", _RELAXED, __name__, default=relax_point)


@cache
def update_of(codes: tuple[int, ...]) -> Any:
    """Return the update of the laws of these codes."""
    return SOIL_LAWS.chain("update", _ARGUMENTS, __name__, codes)


@cache
def of_laws(codes: tuple[int, ...], *loops: Any) -> Any:
    """Return the last of jitted functions that call those of laws or one before them, for the laws of these codes."""
    relaxed = SOIL_LAWS.chain("relax", _RELAXED, __name__, codes, relax_point)
    known, made = {"update_soil": update_of(codes), "relax_soil": relaxed}, None
    for loop in loops:
        made = known[loop.__name__] = with_globals(loop, suffix(codes), known)
    return made
