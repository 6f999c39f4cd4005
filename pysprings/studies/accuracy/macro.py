# SPDX-License-Identifier: MIT
"""The macro-model's part of the study: its curves along the paths of the scene, and the time of one of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from pysprings.full_model.accuracy import quantities
from pysprings.full_model.accuracy.curves import LOAD, OTHER, Curve, leading
from pysprings.macro import slices
from pysprings.macro.comparison import curves
from pysprings.macro.sets import spring_sets
from pysprings.springs.dataset import get_path, is_vertical, path_names


@dataclass(frozen=True)
class Answer:
    """What one spring set with so many depth slices answers along each path; seconds of a curve of 50 points.

    ``paths`` are those of the lateral paths ``asked`` along which there is an answer.
    """

    springs: str
    slices: int
    asked: list[str]
    paths: Mapping[str, Curve]
    seconds: float


def answers(springs: xr.DataTree) -> Iterator[Answer]:
    """Yield the answers of the best spring set (fan where there is one, else full), from one slice to all of them.

    Vertical paths have springs of their own, without slices; the set is asked for the others.
    """
    kind = "fan" if "fan" in spring_sets(springs) else "full"
    names = [name for name in path_names(springs) if not is_vertical(springs, name)]
    if not names:
        return
    for n in slices.slice_counts(springs):
        merged = slices.merge_slices(springs, n)
        found = {name: _curve(get_path(merged, name), trace, springs) for name, trace in _traces(merged, names, kind)}
        whole = {name: curve for name, curve in found.items() if curve is not None}
        yield Answer(kind, n, names, whole, slices.curve_seconds(merged, kind))


def _traces(springs: xr.DataTree, names: list[str], kind: str) -> Iterator[tuple[str, xr.Dataset]]:
    for name in names:
        found = curves(springs, name, kind)
        if kind in found:
            yield name, found[kind]


def _curve(full: xr.Dataset, trace: xr.Dataset, springs: xr.DataTree) -> Curve | None:
    """Curve of a macro-model as the full model's are; no p(y), which is the springs' own."""
    n = trace.sizes["step"]
    states = full.isel(step=slice(0, n)).assign({name: ("step", trace[name].values) for name in ("H", "M", "rotation")})
    if full.attrs["kind"] == "rotation":  # what is imposed is the full model's
        states = states.assign(rotation=("step", full["rotation"].values[:n]))
    x = quantities.driver(states, float(springs.attrs["skirt_length_m"]))
    kept = leading(x) if n else np.zeros(0, dtype=int)
    if kept.size < 2:
        return None
    by_x = {LOAD: quantities.load(states), OTHER: quantities.other(states)}
    none = np.zeros((0, kept.size))
    return Curve(x[kept], {name: v[kept] for name, v in by_x.items() if v is not None}, none, none, float("nan"))
