# SPDX-License-Identifier: MIT
"""Laboratory tests on one point of a layer: its law along strains that are imposed, under stresses that are held.

Components are xx, yy, zz, xy, yz, zx with engineering shear strains, z the axis of the specimen, tension positive.
Strains of the law have a direction for each test; where the specimen drains, stresses of some components stay what
they were, and their strains follow by Newton's method with the law's consistent tangent and a line search on the
residual. An increment that fails is halved; a test whose increments fail at a thousandth ends there, with the
reason in `Curve.stopped`.

Undrained is constant volume of the skeleton; the pore pressure is what the held total stress has more than the
effective one. A layer of clay in total stress is undrained by its law: its specimen is held as a drained one is.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fe_engine.conventions import OK
from fe_engine.material import Material
from fe_engine.soil.law import Point
from pysprings.core.arrays import Array, Integers
from pysprings.core.words import ElementTest
from pysprings.model.soil_laws import material_at
from pysprings.scene.by_depth import Value
from pysprings.scene.ground import Stratum

MAX_ITERATIONS, MAX_HALVINGS, MAX_CUTS = 40, 12, 10
TOLERANCE = 1.0e-9  # residual over the stress of the specimen
_FIRST = 1.0e-6  # strain of the first increment

TOTAL = "total stress"
LEAST_SHARE = 1.0e-4  # of the consolidation stress, sum of principal stresses below which there is no angle


@dataclass(frozen=True)
class Kind:
    """A laboratory test: strain directions (6,) drained and undrained, components whose stress is held, end strain.

    ``isotropic``: the specimen is consolidated under an equal stress all round; else without lateral strain, at K0.
    """

    name: str
    drained: tuple[float, ...]
    undrained: tuple[float, ...]
    held: tuple[int, ...]
    end: float
    isotropic: bool


_AXIAL, _AT_CONSTANT_VOLUME = (0.0, 0.0, -1.0, 0.0, 0.0, 0.0), (0.5, 0.5, -1.0, 0.0, 0.0, 0.0)
_SHEAR = (0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
KINDS: dict[ElementTest, Kind] = {
    "triaxial": Kind("triaxial compression", _AXIAL, _AT_CONSTANT_VOLUME, (0, 1), 0.1, True),
    "triaxial-extension": Kind(
        "triaxial extension", tuple(-each for each in _AXIAL), tuple(-each for each in _AT_CONSTANT_VOLUME),
        (0, 1), 0.1, True,
    ),
    "dss": Kind("direct simple shear", _SHEAR, _SHEAR, (2,), 0.2, False),
    "oedometer": Kind("oedometer", _AXIAL, _AXIAL, (), 0.02, False),
}  # fmt: skip


@dataclass(frozen=True)
class Curve:
    """States of a specimen along a test, one a row; compression positive, in SI.

    strain, stress : (n, 6), tension positive as the law has them.
    consolidation : stress (Pa) that the test was asked for: all round, or vertical.
    stopped : why it did not reach its last strain; blank where it did.
    """

    kind: Kind
    drainage: str
    consolidation: float
    strain: Array
    stress: Array
    stopped: str = ""

    def columns(self) -> dict[str, Array]:
        """Return the columns of its table, (n,) each; q is axial less radial stress, the pore pressure an excess.

        A law in total stress has neither pore pressure nor mobilised angle: they are NaN.
        """
        strain, stress, kind = 0.0 - self.strain, 0.0 - self.stress, self.kind
        axial, radial = stress[:, 2], 0.5 * (stress[:, 0] + stress[:, 1])
        held = stress[:, kind.held[0]] if kind.held and self.drainage == "undrained" else np.zeros(len(axial))
        known = np.nan if self.drainage == TOTAL else 1.0  # effective stress is
        least, _, most = np.linalg.eigvalsh(stress[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2]]]).T
        some = most + least > LEAST_SHARE * self.consolidation  # next to no stress has no angle
        sine = np.clip((most - least) / np.where(some, most + least, np.nan), 0.0, 1.0)
        return {
            "axial_strain": strain[:, 2], "volumetric_strain": strain[:, :3].sum(axis=1),
            "shear_strain": self.strain[:, 5], "p_Pa": stress[:, :3].mean(axis=1), "q_Pa": axial - radial,
            "axial_stress_Pa": axial, "radial_stress_Pa": radial, "shear_stress_Pa": self.stress[:, 5],
            "pore_pressure_Pa": known * (held[0] - held), "mobilised_angle_rad": known * np.arcsin(sine),
        }  # fmt: skip


def specimen(
    stratum: Stratum, kind: Kind, stress: float | None, depth: float, changed: Mapping[str, Value] | None = None
) -> Stratum:
    """Return a layer without weight that stands under the stress of a specimen, with some values changed.

    ``stress`` (Pa, compression positive) acts all round, or vertically where the kind has lateral stresses at K0. None
    is that of the layer at ``depth`` (m): the mean effective stress, or the vertical one.
    """
    z = np.array(depth)
    values: dict[str, Any] = dict(stratum.values)
    if stress is None:
        stress = float(stratum.mean_stress(z) if kind.isotropic else stratum.vertical_stress(z))
    values |= {"effective_unit_weight": 0.0, "K0": 1.0 if kind.isotropic else float(stratum.value("K0", z))}
    return replace(stratum, above=stress, values=values | dict(changed or {}))


def drainage_of(stratum: Stratum, undrained: bool) -> str:
    """Return how the specimen of a layer drains: `TOTAL` of a law in total stress, whatever is asked for."""
    return TOTAL if stratum.total_stress else "undrained" if undrained else "drained"


def element_test(stratum: Stratum, kind: Kind, depth: float, undrained: bool, end: float | None = None) -> Curve:
    """Drive one point of a specimen (see `specimen`) from its consolidation stress to the end of a test.

    ``end`` is the last strain, axial or shear; by default that of the kind.
    """
    material = material_at(stratum, np.array([[depth]]))
    lateral = float(stratum.value("K0", np.array(depth)))
    start = -stratum.above * np.array([lateral, lateral, 1.0, 0.0, 0.0, 0.0])
    drainage = drainage_of(stratum, undrained)
    direction = kind.undrained if drainage == "undrained" else kind.drained
    held = () if drainage == "undrained" else kind.held
    strains = schedule(kind.end if end is None else end)
    strain, stress, stopped = drive(material, start, np.array(direction), np.array(held, dtype=int), strains)
    return Curve(kind, drainage, stratum.above, strain, stress, stopped)


def schedule(end: float) -> Array:
    """Return the strains (n,) where a test has rows: by equal ratios from 1e-6, and by equal steps."""
    small = np.geomspace(min(_FIRST, 0.1 * end), end, 61)
    return np.unique(np.concatenate([small, np.linspace(0.0, end, 121)[1:]]))


def drive(
    material: Material, start: Array, direction: Array, held: Integers, strains: Array
) -> tuple[Array, Array, str]:
    """Return strains (n, 6), stresses (n, 6), and why it stopped, along strains (n - 1,) times a direction (6,).

    The stress of the components ``held`` stays that of ``start`` (6,) in Pa.
    """
    law, p = material.law, np.ascontiguousarray(material.parameters.reshape(-1, len(material.law.parameters))[0])
    old = Point(start.copy(), np.zeros(len(law.history)))
    states, total, guess = [(np.zeros(6), start.copy())], np.zeros(6), np.zeros(6)
    scale = max(float(np.abs(start).max()), 1.0)
    for before, now in zip([0.0, *strains[:-1]], strains, strict=True):
        done, size = before, now - before
        while now - done > 1e-9 * now:
            step = min(size, now - done)
            found = _advance(law.update, p, old, step * direction, held, (start, guess * step, scale))
            if found is None:
                size *= 0.5
                if size < (now - before) / 2.0**MAX_CUTS:
                    return *_rows(states), f"no equilibrium beyond a strain of {done:.4g}"
                continue
            increment, old = found
            done, total, guess = done + step, total + increment, increment / step
        states.append((total.copy(), old.stress.copy()))
    return *_rows(states), ""


def _rows(states: list[tuple[Array, Array]]) -> tuple[Array, Array]:
    return np.array([each for each, _ in states]), np.array([each for _, each in states])


def _advance(
    update: Any, p: Array, old: Point, imposed: Array, held: Integers, aim: tuple[Array, Array, float]
) -> tuple[Array, Point] | None:
    """Return the strain increment (6,) and the state after it; None where Newton's method finds none.

    ``aim`` : stress to be held (6,), first guess of the increment (6,), stress of the specimen (Pa).
    """
    target, guess, scale = aim
    strain, tangent = imposed.copy(), np.zeros((6, 6))
    strain[held] = guess[held]

    def state(trial: Array) -> tuple[Point, Array, float]:
        new = Point(np.zeros(6), np.zeros(len(old.history)))
        status, _ = update(p, trial, old, new, tangent, True)
        rest = new.stress[held] - target[held]
        worst = float(np.abs(rest).max()) if len(held) else 0.0
        return new, rest, worst if status == OK and np.isfinite(new.stress).all() else np.inf

    new, rest, worst = state(strain)
    for _ in range(MAX_ITERATIONS):
        if worst <= TOLERANCE * scale:
            return strain, new
        if not np.isfinite(worst):
            return None
        block = tangent[np.ix_(held, held)]
        change, share = np.linalg.lstsq(block, rest, rcond=None)[0], 1.0
        for _ in range(MAX_HALVINGS):
            trial = strain.copy()
            trial[held] -= share * change
            new, rest_new, worst_new = state(trial)
            if worst_new < worst:
                break
            share *= 0.5
        else:
            return None
        strain, rest, worst = trial, rest_new, worst_new
    return None
