# SPDX-License-Identifier: MIT
"""Keys of a layer fitted to laboratory tests: least squares with the bounds of each key (scipy, trust region)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from pysprings.core.units import read, si_of
from pysprings.model.element import KINDS, element_test, specimen
from pysprings.scene.by_depth import ByDepth
from pysprings.scene.fields import Interval
from pysprings.scene.sections import plain_field
from pysprings.scene.soils import LAW_KEYS, SOIL_LAWS
from pysprings.studies.element.data import MEASURED, LabTest, residuals

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from pysprings.core.words import ElementTest
    from pysprings.scene.ground import Stratum

    Array = NDArray[np.float64]

_SPAN = 1.0e3  # a key moves by this factor at most
_STEP = 1.0e-3  # of finite differences: increments of a test follow the strains of its schedule
_AT_BOUND = 1.0e-3


@dataclass(frozen=True)
class Fitted:
    """A key with its value before and after in ``unit``, standard error, and whether it ended at a bound."""

    key: str
    unit: str
    before: float
    value: float
    error: float
    at_bound: bool


@dataclass(frozen=True)
class Fit:
    """Fitted keys; root mean square residuals before and after, of the largest measured value; correlations (n, n)."""

    keys: tuple[Fitted, ...]
    before: float
    after: float
    correlation: Array
    values: dict[str, Any]
    converged: bool


def known_keys(stratum: Stratum) -> list[str]:
    """Return the keys of a layer that can be fitted: its numbers that its law uses."""
    law = SOIL_LAWS[stratum.law]
    values = law.derived(stratum) | stratum.values
    own = [name for name in (*law.stiffnesses, "poisson_ratio", *law.keys) if name in values]
    return [name for name in dict.fromkeys(own) if _number(values[name]) is not None]


def _number(value: Any) -> float | None:
    """Return the number that scales a value: itself, or the reference of one by depth or stress."""
    if isinstance(value, ByDepth):
        return value.reference
    return value if isinstance(value, float) else None


def _with(value: Any, number: float) -> Any:
    return replace(value, reference=number) if isinstance(value, ByDepth) else number


def bounds_of(key: str, start: float) -> tuple[float, float]:
    """Return the bounds of a key in SI: its interval, and a factor of 1000 about a positive start."""
    field = plain_field(key)
    unit = field.unit
    low, high = (
        float(each) if unit == "1" else read(f"{each} {unit}", si_of(unit)) for each in Interval(field.interval).bounds
    )
    if low >= 0.0 and start > 0.0:
        low, high = max(low, start / _SPAN), min(high, start * _SPAN)
    return low, high


def fit(
    stratum: Stratum, kind: ElementTest, depth: float, undrained: bool, tests: Sequence[LabTest], keys: Sequence[str]
) -> Fit:
    """Fit keys of a layer to tests of one kind; ``keys`` are some of `known_keys`, with numbers within their bounds.

    Positive keys move by their logarithm. Values that the checks of the law refuse, or that stop a test, count as
    100 % away from each measured value.
    """
    from scipy.optimize import least_squares

    values = SOIL_LAWS[stratum.law].derived(stratum) | stratum.values
    start = np.array([_number(values[key]) for key in keys], dtype=float)
    low, high = np.array([bounds_of(key, value) for key, value in zip(keys, start, strict=True)]).T
    logs = (low > 0.0) & (start > 0.0)

    def coordinates(x: Array) -> Array:
        return np.where(logs, np.log(np.where(logs, x, 1.0)), x)

    def numbers(c: Array) -> Array:
        return np.where(logs, np.exp(np.where(logs, c, 0.0)), c)

    def misfit(c: Array) -> Array:
        changed = {key: _with(values[key], float(x)) for key, x in zip(keys, numbers(c), strict=True)}
        return _misfit(stratum, kind, depth, undrained, tests, changed)

    first, bounds = misfit(coordinates(start)), (coordinates(low), coordinates(high))
    found = least_squares(misfit, coordinates(start), bounds=bounds, diff_step=_STEP, x_scale="jac")
    after = numbers(found.x)
    covariance = np.linalg.pinv(found.jac.T @ found.jac) * (found.fun @ found.fun) / max(len(found.fun) - len(keys), 1)
    spread = np.sqrt(np.diag(covariance))
    with np.errstate(divide="ignore", invalid="ignore"):
        correlation = covariance / np.outer(spread, spread)
    error = spread * np.where(logs, after, 1.0)
    near = np.minimum(found.x - bounds[0], bounds[1] - found.x) <= _AT_BOUND * (bounds[1] - bounds[0])
    fitted = tuple(_fitted(*each) for each in zip(keys, start, after, error, near, strict=True))
    changed = {key: _with(values[key], float(x)) for key, x in zip(keys, after, strict=True)}
    return Fit(fitted, float(np.linalg.norm(first)), float(np.linalg.norm(found.fun)), correlation, changed,
               found.status > 0)  # fmt: skip


def _fitted(key: str, start: float, after: float, error: float, near: bool) -> Fitted:
    unit = plain_field(key).unit
    scale = 1.0 if unit == "1" else read(f"1 {unit}", si_of(unit))
    return Fitted(key, unit, start / scale, after / scale, error / scale, bool(near))


def _misfit(
    stratum: Stratum,
    kind: ElementTest,
    depth: float,
    undrained: bool,
    tests: Sequence[LabTest],
    changed: dict[str, Any],
) -> Array:
    """Return the differences of all tests; their length is the root mean square over columns and tests."""
    parts = []
    for test in tests:
        point = specimen(stratum, KINDS[kind], test.stress, depth, changed)
        last = float(np.abs(test.columns[MEASURED[kind][0]]).max())
        curve = None if refused(point, depth) else element_test(point, KINDS[kind], depth, undrained, last)
        parts += residuals(test, curve, kind, undrained)
    return np.concatenate(parts) / np.sqrt(len(parts))


def refused(stratum: Stratum, depth: float) -> list[str]:
    """Return what the checks of the law find wrong with the values of a layer at a depth (m)."""
    z = np.array(depth)
    values = {name: float(stratum.value(name, z)) for name in (*stratum.values, "young_modulus")}
    soil = dict.fromkeys(LAW_KEYS) | values | stratum.tables | {"surcharge": stratum.above}
    found = SOIL_LAWS[stratum.law].faults(SimpleNamespace(**soil), (stratum.above, stratum.above))
    return [f"{'.'.join(map(str, clash.keys[0]))}: {clash.message}" for clash in found]
