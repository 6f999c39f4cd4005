# SPDX-License-Identifier: MIT
"""What becomes of an answer that the springs do not support: an error, a warning, or marks."""

from __future__ import annotations

import warnings
from typing import TypedDict

import xarray as xr

from pysprings.core.errors import BeyondSprings, Problem, RunIncomplete, refused

ASK = "--extrapolate (extrapolate=True) answers beyond it, marked"


class MacroWarning(UserWarning):
    """An answer of the macro-model that the springs support only in part."""


class PredictionNotConverged(RunIncomplete):
    """No equilibrium was found beyond a load; the message names it and the part that was reached."""


class Care(TypedDict, total=False):
    """Keywords on answers that springs support in part.

    Attributes
    ----------
    strict : refuse every answer with a mark.
    extrapolate : answer beyond the calibrated range, with marks; without, that is refused.
    """

    strict: bool
    extrapolate: bool


def raise_or_warn(answer: xr.Dataset, strict: bool = False, extrapolate: bool = False) -> xr.Dataset:
    """Return an answer; raise where it is beyond the springs or partial, warn (raise, when strict) where it is marked.

    Every answer passes here but those of `predict_batch`, which are marked by case.
    """
    if strict and extrapolate:
        raise refused("strict", "refuses what extrapolate asks for: give one of them")
    if answer.attrs["refusals"]:
        raise _beyond(answer.attrs["refusals"])
    beyond = answer.attrs["beyond_range"]
    if beyond and not extrapolate:
        raise _beyond([f"{text}; {ASK}" for text in beyond])
    if answer.attrs["status"] != "complete":
        raise PredictionNotConverged(answer.attrs["message"])
    notes = [*beyond, *answer.attrs["warnings"]]
    marks = [*notes, *filter(None, [str(answer.attrs.get("atlas_mesh", ""))])]
    if strict and marks:
        raise refused("strict", "; ".join(marks))
    for note in notes:
        warnings.warn(note, MacroWarning, stacklevel=4)
    return answer.assign_attrs(warnings=notes)


def _beyond(texts: list[str]) -> BeyondSprings:
    return BeyondSprings([Problem(key="springs", message=text) for text in texts])
