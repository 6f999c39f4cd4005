# SPDX-License-Identifier: MIT
"""`Formulas`: springs of any caisson of a family by formulas with coefficients, as an atlas gives them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pysprings.studies.atlas.data import Dense, Estimate
from pysprings.studies.atlas.emulator import Emulator
from pysprings.studies.atlas.families import Family
from pysprings.studies.atlas.formulas.base import HEAVE, WHERE, Form, Place, Term, placed, summed
from pysprings.studies.atlas.formulas.hyperbolic import along_rays, chosen, ray_values
from pysprings.studies.atlas.model import sums
from pysprings.studies.atlas.samples import Samples, stiffness_of

if TYPE_CHECKING:
    from pysprings.scene.model import Scene

Array = NDArray[np.float64]
FACTORS = ("K_V", "K_a", "K_b", "K_c")
SETTLED = "w_0"
_CLOSE = 1e-4  # tolerance of the formulas of the stiffness
DENSE: Array = np.radians(np.arange(-87.0, 91.0, 3.0))  # rays of springs of their own displacement
_SMALL = 1e-6  # X at which springs of their own displacement are linear


@dataclass(frozen=True, eq=False, kw_only=True)
class Formulas(Emulator):
    """Springs by formulas.

    Attributes
    ----------
    form, terms : the form and its coefficients.
    stiffness_rest : standard deviations of the logarithms of K_V, K_H, K_M.
    """

    form: Form
    terms: tuple[Term, ...]
    stiffness_rest: tuple[float, float, float]

    @property
    def source(self) -> str:
        """Where springs come from: for files and remarks."""
        return f"formulas {self.family.name} {self.form.name}"

    def place(self, inputs: Array) -> Place:
        """Return the place of caissons with inputs (n, d)."""
        return Place(self.family, inputs, 2.0 * self.point(inputs) - 1.0, self.rays, self.angles, self.X)

    def _expected(self, scene: Scene, inputs: Array, outside: tuple[str, ...]) -> Estimate:
        place, sizes = self.place(inputs[None]), self.family.sizes(scene)
        D, L = scene.caisson.outer_diameter, scene.caisson.skirt_length
        matrix = stiffness_of(_factors(self.form, self.terms, place)[0], sizes.force, sizes.ratio, D, L)
        settled = float(_polynomial(self.terms, SETTLED, place)[0]) * D / sizes.ratio
        values, dense = rows(self.form, self.terms, place)[0], None
        if self.form.own_stiffness:
            dense = Dense(DENSE, _turned(self.rest, self.angles))
            values = self._dense_rows(place, values)
        errors = np.array(self.stiffness_rest)
        return Estimate(values, np.zeros((0, *values.shape)), matrix, errors, settled, outside, dense)

    def _dense_rows(self, place: Place, values: Array) -> Array:
        """Return rows (ray, row, X) of springs of their own displacement on close rays; the heave is interpolated."""
        close = replace(place, rays=tuple(map(str, range(DENSE.size))), angles=DENSE)
        made = self.form.values(self.terms, close)[0]
        made[:, WHERE[HEAVE]] = _turned(values[:, WHERE[HEAVE]].transpose(1, 0, 2), self.angles).transpose(1, 0, 2)
        return made


def _turned(values: Array, angles: Array) -> Array:
    """Return values (k, ray, X), the same in the mirror image of a motion, on close rays: linear in angle."""
    order = np.argsort(angles)
    known = np.concatenate([angles[order] - np.pi, angles[order], angles[order] + np.pi])
    three = np.concatenate([values[:, order]] * 3, axis=1)
    place = np.clip(np.searchsorted(known, DENSE, side="right") - 1, 0, known.size - 2)
    part = ((DENSE - known[place]) / (known[place + 1] - known[place]))[:, None]
    return np.asarray(three[:, place] * (1.0 - part) + three[:, place + 1] * part)


def rows(form: Form, terms: tuple[Term, ...], place: Place) -> Array:
    """Return all rows (n, ray, row, X): those of the form, and the heave."""
    values = form.values(terms, place)
    values[:, :, WHERE[HEAVE]] = ray_values(terms, HEAVE, place)
    return values


def fit(samples: Samples, family: Family, form: Form, about: Mapping[str, str] | None = None) -> Formulas:
    """Return formulas of a form, fitted to the full models of a study."""
    place = placed(samples, family)
    heave = samples.values[:, :, WHERE[HEAVE]]
    terms = (*form.fit(samples, place), *along_rays(HEAVE, heave, np.ones_like(heave), place))
    targets = dict(zip(FACTORS, samples.stiffness.T, strict=True)) | {SETTLED: samples.settled}
    own = FACTORS[1:] if form.own_stiffness else ()
    terms += tuple(term for name, values in targets.items() if name not in own for term in _smooth(name, values, place))
    made = rows(form, terms, place)
    missing = [one - other for one, other in zip(sums(made), sums(samples.values), strict=True)]
    errors = _logarithms(_factors(form, terms, place)) - _logarithms(samples.stiffness)
    deviation = [float(each) for each in np.sqrt((errors**2).mean(axis=0))]
    return Formulas(
        family=family, text=samples.scene, inputs=samples.inputs, rays=samples.rays, angles=samples.angles, X=samples.X,
        reach=samples.reach, rest=np.stack([np.sqrt(np.nanmean(each**2, axis=0)) for each in missing]),
        about=dict(about or {}), form=form, terms=terms, stiffness_rest=(deviation[0], deviation[1], deviation[2]),
    )  # fmt: skip


def _smooth(name: str, values: Array, place: Place) -> list[Term]:
    """Return the terms of a quadratic polynomial in x of values (n,)."""
    d = place.x.shape[1]
    powers = [each for each in product(range(3), repeat=d) if sum(each) <= 2]
    basis = np.stack([(place.x ** np.array(each)).prod(axis=1) for each in powers], axis=1)
    found = chosen(basis, values, _CLOSE, len(powers))
    pairs = zip(powers, found, strict=True)
    return [Term(name, "", "value", (0, 0, *each), float(value)) for each, value in pairs if value]


def _polynomial(terms: tuple[Term, ...], name: str, place: Place) -> Array:
    """Return the sums (n,) of the terms of a number of a caisson."""
    own = [Term("", "", "", each.powers[2:], each.value) for each in terms if each.spring == name]
    return summed(own, list(place.x.T))


def _factors(form: Form, terms: tuple[Term, ...], place: Place) -> Array:
    """Return the numbers (n, 4) of the stiffness, as `pysprings.studies.atlas.samples.factors` has them."""
    if not form.own_stiffness:
        return np.stack([_polynomial(terms, name, place) for name in FACTORS], axis=1)
    small = Place(
        place.family, place.inputs, place.x, ("u", "rotation"), np.array([0.0, np.pi / 2]), np.array([_SMALL])
    )
    H, M = (each[..., 0] / (1.0 + _SMALL) for each in sums(form.values(terms, small)))
    across = 0.5 * (H[:, 1] + M[:, 0])
    first = np.sqrt(H[:, 0])
    last = np.sqrt(np.maximum(M[:, 1] - across**2 / H[:, 0], 1e-12))
    K_V = _polynomial(terms, "K_V", place)
    return np.stack([K_V, np.log(first), across / H[:, 0], np.log(last)], axis=1)


def _logarithms(factors: Array) -> Array:
    """Return log K_V, log K_H and log K_M (n, 3) of numbers of the stiffness."""
    inner = np.exp(2.0 * factors[:, 1]) * factors[:, 2] ** 2 + np.exp(2.0 * factors[:, 3])
    return np.stack([factors[:, 0], 2.0 * factors[:, 1], np.log(inner)], axis=1)
