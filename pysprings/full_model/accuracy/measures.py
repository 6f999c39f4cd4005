# SPDX-License-Identifier: MIT
"""Errors of a run beside a reference, each one number in percent (see `MEASURES`), and the reference itself.

A quantity Q on meshes of cell size h1 > h2 > h3 is taken as Q = Q* + C h^p (Richardson 1911). The order p solves

    (Q1 - Q2)/(Q2 - Q3) = (h1^p - h2^p)/(h2^p - h3^p)

(Roache 1994, for unequal ratios of h). Of a curve, the left side is the ratio of the differences in the sense of least
squares, d12.d23/d23.d23, one order for the whole curve.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from pysprings.full_model.accuracy.curves import LOAD, OTHER, PRESSURE, PY, STIFFNESS, Sample
from pysprings.macro.measures import eta

LOWEST, HIGHEST = 0.5, 4.0  # orders that are believed
NEEDED = 3  # meshes


@dataclass(frozen=True)
class Reference:
    """Limit of a quantity on ever finer meshes: values, and ``beside``, whose distance from them is their uncertainty.

    ``order`` is None where the finest mesh is taken as it is; ``note`` is the cause. ``beside`` is the finest mesh if
    the values are extrapolated from it, else the mesh before it.
    """

    values: Array
    beside: Array
    order: float | None
    note: str

    @property
    def extrapolated(self) -> bool:
        """Whether the values are better than those of the finest mesh."""
        return self.order is not None


def cell_size(unknowns: float, harmonics: int | None = None) -> float:
    """Return the size h of the cells of a mesh with so many unknowns, up to a factor.

    unknowns^(-1/3) of bricks; (unknowns/(N + 1))^(-1/2) of a section with N harmonics.
    """
    if harmonics is not None:
        return (float(unknowns) / (harmonics + 1)) ** -0.5
    return float(unknowns) ** (-1.0 / 3.0)


def order_from(ratio: float, h: Sequence[float]) -> float:
    """Return the order p of three cell sizes h (falling) whose differences have this ratio; NaN outside the range."""
    h1, h2, h3 = (value / h[2] for value in h)

    def excess(p: float) -> float:
        return float((h1**p - h2**p) / (h2**p - h3**p)) - ratio

    if not excess(LOWEST) <= 0.0 <= excess(HIGHEST):
        return float("nan")
    return float(brentq(excess, LOWEST, HIGHEST, xtol=1e-12))


def extrapolate(values: Sequence[Array], h: Sequence[float]) -> Reference:
    """Return what values (one array a mesh, the finest last; NaN is left out) tend to as h (falling) goes to 0."""
    finest = values[-1]
    if len(values) == 1:
        return Reference(finest, np.full_like(finest, np.nan), None, "one mesh: nothing to compare it with")
    if len(values) < NEEDED:
        return Reference(finest, values[-2], None, f"{len(values)} meshes: no order, the finest mesh as it is")
    q1, q2, q3 = values[-3:]
    d12, d23 = q1 - q2, q2 - q3
    counted = np.isfinite(d12) & np.isfinite(d23)
    size = float(d23[counted] @ d23[counted])
    if size == 0.0:
        return Reference(finest, q2, None, "the two finest meshes agree: the finest mesh as it is")
    ratio = float(d12[counted] @ d23[counted]) / size
    if ratio <= 0.0:
        return Reference(finest, q2, None, "the differences change sign: the finest mesh as it is")
    p = order_from(ratio, h[-3:])
    if np.isnan(p):
        text = f"the order is not in [{LOWEST:g}, {HIGHEST:g}] (differences {ratio:.3g} to 1): the finest mesh as it is"
        return Reference(finest, q2, None, text)
    return Reference(q3 - d23 / ((h[-2] / h[-1]) ** p - 1.0), q3, p, f"extrapolated with order {p:.2f}")


Array = NDArray[np.float64]


def _largest(answer: Array, reference: Array) -> float:
    """Return the largest difference over the largest size of the reference; NaN on either side is left out."""
    counted = np.isfinite(answer) & np.isfinite(reference)
    size = np.abs(reference[counted]).max(initial=0.0)
    return float(np.abs(answer - reference)[counted].max() / size) if size else float("nan")


def _rms(answer: Array, reference: Array) -> float:
    """Return the root mean square of the differences over the largest size of the reference; NaN is left out."""
    counted = np.isfinite(answer) & np.isfinite(reference)
    size = np.abs(reference[counted]).max(initial=0.0)
    return float(np.sqrt(np.mean((answer - reference)[counted] ** 2)) / size) if size else float("nan")


def _area(answer: Array, reference: Array) -> float:
    """Return 1 - eta of curves on equally spaced displacements that start at 0."""
    start = [0.0]
    return 1.0 - eta(np.arange(reference.size + 1.0), np.append(start, reference), np.append(start, answer))


class Measure(NamedTuple):
    """How an error is taken: the quantity it belongs to, the head of its column, its words, its value (1, not %)."""

    quantity: str
    head: str
    words: str
    value: Callable[[Array, Array], float]


MEASURES = {
    "load_max": Measure(LOAD, "load max", "load: largest difference over the largest load", _largest),
    "load_area": Measure(LOAD, "load area", "load: area between the curves over the area below (1 - eta)", _area),
    "py_rms": Measure(
        PY, "p-y rms", "p(y): root mean square difference over slices and steps, over the largest p", _rms
    ),
    "py_max": Measure(PY, "p-y max", "p(y): largest difference over the largest p", _largest),
    "rotation_max": Measure(
        OTHER,
        "rotation",
        "rotation (M of a translation, H of a rotation): largest difference over the largest",
        _largest,
    ),
    "stiffness": Measure(STIFFNESS, "stiffness", "initial stiffness", _largest),
    "pressure_max": Measure(
        PRESSURE,
        "pressure",
        "peak contact pressure (to 0.9 of the skirt): largest difference over the largest",
        _largest,
    ),
}


def errors(answer: Sample, reference: Mapping[str, Array]) -> dict[str, float]:
    """Return the errors [%] of a sample beside the values of a reference on the same grid; NaN of what is not there."""
    percent = {}
    for name, measure in MEASURES.items():
        known = measure.quantity in answer and measure.quantity in reference
        value = measure.value(answer[measure.quantity], reference[measure.quantity]) if known else float("nan")
        percent[name] = 100.0 * value
    return percent


def reference_of(series: Sequence[Sample], h: Sequence[float]) -> dict[str, Reference]:
    """Return what each quantity tends to, from samples on ever finer meshes with cell sizes h."""
    names = [name for name in series[-1] if all(name in sample for sample in series)]
    return {name: extrapolate([sample[name] for sample in series], h) for name in names}


def uncertainty(reference: Mapping[str, Reference]) -> dict[str, float]:
    """Return the uncertainty [%] of a reference, by measure: what it has been corrected by, or the last difference."""
    beside = {name: each.beside for name, each in reference.items()}
    return errors(beside, {name: each.values for name, each in reference.items()})


def worst(by_path: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Return the largest of each measure over paths; NaN where no path has it."""
    largest = {}
    for name in MEASURES:
        values = [each[name] for each in by_path if np.isfinite(each[name])]
        largest[name] = max(values, default=float("nan"))
    return largest
