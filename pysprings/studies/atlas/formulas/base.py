# SPDX-License-Identifier: MIT
"""What a form of springs is, its terms, and the dimensionless reactions and motions that all forms use.

    p/(s D), m/(s D^2), H_tip/(s_tip D^2), M_tip/(s_tip D^3), H_lid/(s_lid D^2), M_lid/(s_lid D^3)
    over the motions y G/(s D) and rotation G/s,

s the stress of the ground at the depth of the spring (su in clay, the vertical effective stress in sand), G its
stiffness (`Family.ground`, `Family.lid`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pysprings.studies.atlas.families import Family
from pysprings.studies.atlas.samples import ROWS, Samples
from pysprings.studies.sweep.measures import DEPTHS

Array = NDArray[np.float64]

ZETA: Array = (np.arange(DEPTHS) + 0.5) / DEPTHS
PLACES = {"p": ZETA, "m": ZETA, "H_tip": np.ones(1), "H_lid": np.zeros(1), "M_tip": np.ones(1), "M_lid": np.zeros(1)}
LATERAL = tuple(PLACES)
HEAVE = "w"  # over rho
PLACES |= {HEAVE: np.zeros(1)}
TURNING = ("m", "M_tip", "M_lid")  # springs of the rotation
WHERE = {
    name: np.array([k for k, row in enumerate(ROWS) if row == name or (row[:1] == name and row[1:].isdigit())])
    for name in PLACES
}


@dataclass(frozen=True)
class Term:
    """A summand of a formula: value times the product of its variables to their powers.

    Attributes
    ----------
    spring : p, m, H_tip, H_lid, M_tip, M_lid; w; K_V, K_a, K_b, K_c of the stiffness; w_0 at rest.
    ray : of the study; blank for a spring of its own displacement alone.
    parameter : what the summand belongs to: a parameter of the form.
    powers : of the variables of the form.
    """

    spring: str
    ray: str
    parameter: str
    powers: tuple[int, ...]
    value: float


@dataclass(frozen=True)
class Place:
    """Caissons of which formulas give reactions.

    Attributes
    ----------
    family : what decides.
    inputs : (n, d).
    x : (n, d) inputs in their even form, -1 to 1 between the full models.
    rays, angles, X : grid of the springs.
    """

    family: Family
    inputs: Array
    x: Array
    rays: tuple[str, ...]
    angles: Array
    X: Array


@dataclass(frozen=True)
class Form:
    """A form of springs: one module, one entry of `FORMS`.

    Attributes
    ----------
    name, label : word of `--form`; title.
    formula : lines that say how parameters make a reaction.
    variables : number of inputs -> names of the variables of its terms, in the order of the powers.
    fit : samples and their place -> terms of the lateral springs.
    values : terms, place -> (n, ray, row, X), rows of the lateral springs over F h and F L h; other rows are 0.
    own_stiffness : the lateral stiffness is that of the springs at rest; else it has formulas of its own.
    """

    name: str
    label: str
    formula: tuple[str, ...]
    variables: Callable[[int], tuple[str, ...]]
    fit: Callable[[Samples, Place], tuple[Term, ...]]
    values: Callable[[tuple[Term, ...], Place], Array]
    own_stiffness: bool = False


def units(place: Place) -> dict[str, Array]:
    """Return the size of every lateral spring over F or F L (n, depth): a row over F h is this times reaction/h."""
    lam = place.inputs[:, :1]
    size = {
        "p": lam / (DEPTHS * (1.0 + lam)), "m": 1.0 / (DEPTHS * (1.0 + lam)), "H_tip": 1.0 / (1.0 + lam),
        "H_lid": 1.0 / (1.0 + lam), "M_tip": 1.0 / (lam * (1.0 + lam)), "M_lid": 1.0 / (lam * (1.0 + lam)),
    }  # fmt: skip
    return {name: stresses(place, name) * each for name, each in size.items()}


def stresses(place: Place, spring: str) -> Array:
    """Return the stress (n, depth) that a spring is over."""
    if spring.endswith("lid"):
        return place.family.lid(place.inputs)[:, None]
    return place.family.ground(place.inputs, PLACES[spring])[0]


def motions(place: Place, spring: str) -> Array:
    """Return the motion y G/(s D), or rotation G/s, of a spring (n, ray, depth, X)."""
    zeta = PLACES[spring]
    stiffness = place.family.ground(place.inputs, zeta)[1] / stresses(place, spring)
    along, turning = np.cos(place.angles)[:, None], np.sin(place.angles)[:, None]
    if spring in TURNING:
        way = (turning + 0.0 * zeta)[None] / place.inputs[:, :1, None]
    else:
        way = (along + turning * zeta)[None] + 0.0 * place.inputs[:, :1, None]
    return np.asarray((way * stiffness[:, None])[..., None] * place.X)


def reactions(samples: Samples, place: Place, spring: str) -> Array:
    """Return the dimensionless reactions (n, ray, depth, X) of a spring over h, NaN beyond what a case reached."""
    rows: Array = samples.values[:, :, WHERE[spring], :]
    return rows / units(place)[spring][:, None, :, None]


def summed(terms: list[Term], variables: list[Array]) -> Array:
    """Return the sum of terms over variables that broadcast."""
    total: Array = np.zeros(np.broadcast_shapes(*(np.shape(each) for each in variables)))
    for term in terms:
        product: Array = np.asarray(term.value)
        for power, variable in zip(term.powers, variables, strict=True):
            if power:
                product = product * variable**power
        total = total + product
    return total


def placed(samples: Samples, family: Family) -> Place:
    """Return the place of the full models of a study."""
    even = family.even(samples.inputs)
    low, high = even.min(axis=0), even.max(axis=0)
    x = 2.0 * (even - low) / (high - low) - 1.0
    return Place(family, samples.inputs, x, samples.rays, samples.angles, samples.X)
