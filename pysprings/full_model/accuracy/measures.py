# SPDX-License-Identifier: MIT
"""Errors of a run beside a reference, each one number in percent (see `MEASURES`)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pysprings.full_model.accuracy.curves import LOAD, OTHER, PRESSURE, PY, STIFFNESS, Sample
from pysprings.full_model.accuracy.richardson import Reference, extrapolate
from pysprings.macro.measures import eta

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
