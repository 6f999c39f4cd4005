# SPDX-License-Identifier: MIT
"""The macro-model's part of the study: its curves along the paths of the scene, and the time of one of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from pysprings.core.path_kinds import driven
from pysprings.full_model.accuracy import quantities
from pysprings.full_model.accuracy.curves import LOAD, OTHER, Curve, leading
from pysprings.macro import slices
from pysprings.macro.comparison import curves
from pysprings.macro.sets import spring_sets
from pysprings.springs.path import SpringPath
from pysprings.springs.springs import Springs


@dataclass(frozen=True)
class Answer:
    """What one spring set with so many depth slices answers along each path; seconds of a curve of 50 points.

    ``paths`` are those of the lateral paths ``lateral`` along which there is an answer.
    """

    springs: str
    slices: int
    lateral: list[str]
    paths: Mapping[str, Curve]
    seconds: float


def answers(springs: xr.DataTree) -> Iterator[Answer]:
    """Yield the answers of the best spring set (fan if present, else full), from one slice to all of them.

    Vertical paths have springs of their own, without slices; the set answers the others.
    """
    given = Springs.of(springs)
    kind = "fan" if "fan" in spring_sets(given) else "full"
    names = [name for name, path in given.paths.items() if not path.is_vertical]
    if not names:
        return
    for n in slices.slice_counts(given):
        merged = slices.merge_slices(given, n)
        traced = {name: _curve(merged.paths[name], trace) for name, trace in _traces(merged, names, kind)}
        whole = {name: curve for name, curve in traced.items() if curve is not None}
        yield Answer(kind, n, names, whole, slices.curve_seconds(merged, kind))


def _traces(springs: Springs, names: list[str], kind: str) -> Iterator[tuple[str, xr.Dataset]]:
    for name in names:
        by_kind = curves(springs, name, kind)
        if kind in by_kind:
            yield name, by_kind[kind]


def _curve(path: SpringPath, trace: xr.Dataset) -> Curve | None:
    """Return the curve of a macro-model in the form of the full model's, without p(y), which belongs to the springs."""
    n, full = trace.sizes["step"], path.dataset
    states = full.isel(step=slice(0, n)).assign({name: ("step", trace[name].values) for name in ("H", "M", "rotation")})
    if driven(path.attrs) == "rotation":  # what is imposed is the full model's
        states = states.assign(rotation=("step", full["rotation"].values[:n]))
    x = quantities.driver(states, path.length)
    rising = leading(x) if n else np.zeros(0, dtype=int)
    if rising.size < 2:
        return None
    by_x = {LOAD: quantities.load(states), OTHER: quantities.other(states)}
    none = np.zeros((0, rising.size))
    return Curve(x[rising], {name: v[rising] for name, v in by_x.items() if v is not None}, none, none, float("nan"))
