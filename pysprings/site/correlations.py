# SPDX-License-Identifier: MIT
"""Named correlations from cone resistance, relative density and stress to values of the ground, each with its range.

All stresses are in Pa, angles in rad, unit weights in N/m3. p_a is 100 kPa. Rows outside the range of a correlation
have its value nevertheless; `Correlation.inside` marks them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace

import numpy as np

from pysprings.core.arrays import Array, Marks
from pysprings.scene.fields import Interval
from pysprings.scene.profile_table import WATER
from pysprings.scene.soils.clay import OCR
from pysprings.scene.soils.friction import LEAST_STIFFNESS
from pysprings.scene.soils.sand import mobilisation
from pysprings.site.sounding import LEAST_STRESS, PA, SAND_TO, unit_weight

GRAVITY = 9.81  # m/s2
CRITICAL = np.radians(33.0)  # critical-state friction angle of quartz sand (Bolton 1986)
K0_NC = 0.5  # of normally consolidated sand, where a correlation needs one
LEAST_PRESSURE = 150.0e3  # Pa, smallest p' in Bolton's index (his reply to the discussion)
HELD = (0.05, 1.0)  # D_r of correlations
LEAST_OCR, MOST_OCR = map(float, Interval(OCR.interval).bounds)  # that a scene takes
CONE_FACTORS = (10.0, 14.0, 18.0)  # N_kt that give su high, best, low


@dataclass(frozen=True)
class Rows:
    """What correlations read, each (n,): q_t, f_s, s_v0, s'_v0 [Pa], unit weight [N/m3], I_c, relative density."""

    cone: Array
    sleeve: Array
    total: Array
    effective: Array
    weight: Array
    index: Array
    density: Array

    def part(self, own: Marks) -> Rows:
        """Return some of the rows."""
        return Rows(*(getattr(self, each.name)[own] for each in fields(self)))

    def with_density(self, density: float | Array) -> Rows:
        """Return the rows with another relative density."""
        return replace(self, density=np.broadcast_to(density, self.cone.shape))

    @property
    def stress(self) -> Array:
        """s'_v0, at least `LEAST_STRESS`."""
        return np.maximum(self.effective, LEAST_STRESS)

    @property
    def net(self) -> Array:
        """q_t - s_v0."""
        return self.cone - self.total


@dataclass(frozen=True)
class Correlation:
    """A formula: the key that it gives, its authors, the text of its range, its values, and which rows are inside.

    free : rows whose value is not held at an end of what the key may be.
    """

    gives: str
    name: str
    range: str
    of: Callable[[Rows], Array]
    inside: Callable[[Rows], Marks]
    free: Callable[[Rows], Marks] = lambda rows: np.full(rows.cone.shape, True)


def _jamiolkowski(rows: Rows) -> Array:
    # D_r = ln((q_c/p_a)/(24.94 (s'_m/p_a)^0.46))/2.96 of dry sand, times 1 + (-1.87 + 2.32 ln(q_c/(p_a s'_v0)^0.5))/100
    mean = rows.stress * (1.0 + 2.0 * K0_NC) / 3.0
    dry = np.log(rows.cone / PA / (24.94 * (mean / PA) ** 0.46)) / 2.96
    return dry * (1.0 + (2.32 * np.log(rows.cone / np.sqrt(PA * rows.stress)) - 1.87) / 100.0)


def _baldi(rows: Rows, factor: float, rate: float) -> Array:
    # D_r = ln(q_c/(C_0 s'^0.55))/C_2, stresses in kPa
    return np.log(rows.cone / 1e3 / (factor * (rows.stress / 1e3) ** 0.55)) / rate


def _by_density(name: str, text: str, of: Callable[[Rows], Array]) -> Correlation:
    """Return a correlation of D_r, held between a twentieth and one."""
    return Correlation(
        "relative_density", name, text, lambda r: np.clip(of(r), *HELD),
        lambda r: (r.effective >= 50e3) & (r.effective <= 400e3) & ~(r.index > SAND_TO),
        lambda r: (of(r) >= HELD[0]) & (of(r) <= HELD[1]),
    )  # fmt: skip


def _kulhawy(rows: Rows) -> Array:
    # phi = 17.6 deg + 11 deg log10((q_t/p_a)/(s'_v0/p_a)^0.5)
    return np.radians(17.6 + 11.0 * np.log10(_normalised(rows)))


def _normalised(rows: Rows) -> Array:
    return rows.cone / PA / np.sqrt(rows.stress / PA)


def _dilatancy(rows: Rows) -> Array:
    # I_R = D_r (10 - ln p') - 1, p' in kPa, held between 0 and 4
    pressure = np.maximum(rows.stress * (1.0 + 2.0 * K0_NC) / 3.0, LEAST_PRESSURE) / 1e3
    return np.clip(rows.density * (10.0 - np.log(pressure)) - 1.0, 0.0, 4.0)


def dilation(friction: Array) -> Array:
    """Return the dilation angle [rad] of triaxial friction angles [rad], not below 0.

    Bolton (1986): I_R = (phi - phi_crit)/3 deg, sin psi = 0.3 I_R/(2 + 0.3 I_R).
    """
    index = np.maximum(np.degrees(friction - CRITICAL) / 3.0, 0.0)
    return np.arcsin(0.3 * index / (2.0 + 0.3 * index))


def _brinkgreve(rows: Rows) -> Array:
    # G_0 = (60 + 68 D_r) MPa (s'_3/p_a)^(0.7 - D_r/3.2)
    least = rows.stress * K0_NC / PA
    return (60e6 + 68e6 * rows.density) * least ** (0.7 - rows.density / 3.2)


def _rix(rows: Rows) -> Array:
    # G_0 = 1634 q_c^0.25 s'_v0^0.375, all in kPa
    return 1634e3 * (rows.cone / 1e3) ** 0.25 * (rows.stress / 1e3) ** 0.375


def _robertson(rows: Rows) -> Array:
    # v_s = (10^(0.55 I_c + 1.68) q_net/p_a)^0.5 m/s, G_0 = rho v_s^2
    return rows.weight / GRAVITY * 10.0 ** (0.55 * rows.index + 1.68) * np.maximum(rows.net, 1.0) / PA


def _mayne(rows: Rows) -> Array:
    # G_0 = 2.78 q_c^1.335, in kPa
    return 2.78e3 * (rows.cone / 1e3) ** 1.335


def _weight(rows: Rows) -> Array:
    # gamma = 1.95 gamma_w (s'_v0/p_a)^0.06 (f_s/p_a)^0.06
    return 1.95 * WATER * (rows.stress / PA * np.maximum(rows.sleeve, 1.0) / PA) ** 0.06 - WATER


def _constant(value: float) -> Callable[[Rows], Array]:
    return lambda rows: np.full(rows.cone.shape, value)


def _su(factor: float) -> Callable[[Rows], Array]:
    # su = q_net/N_kt
    return lambda rows: np.where(rows.net > 0.0, rows.net / factor, np.nan)


def _density_in(rows: Rows) -> Marks:
    return (rows.density >= 0.1) & (rows.density < 1.0)


_CHAMBER = "s'_v0 50 to 400 kPa, I_c to 2.60, D_r to 1"
_DENSE = "D_r 0.1 to 1"
_ROBERTSON = Correlation(
    "shear_modulus", "Robertson and Cabal 2015", "I_c 1 to 4, uncemented, Holocene to Pleistocene", _robertson,
    lambda rows: (rows.index >= 1.0) & (rows.index <= 4.0),
)  # fmt: skip
_WEIGHTS = (
    Correlation("effective_unit_weight", "Robertson and Cabal 2010", "grains of 2.65; 11 to 23 kN/m3",
                lambda r: unit_weight(r.cone, r.sleeve) - WATER, lambda r: (r.weight > 11e3) & (r.weight < 23e3)),
    Correlation("effective_unit_weight", "Mayne et al. 2010", "uncemented; s'_v0 10 to 500 kPa", _weight,
                lambda r: (r.effective >= 10e3) & (r.effective <= 500e3)),
)  # fmt: skip
SAND = (
    _by_density("Jamiolkowski et al. 2003", f"{_CHAMBER}, K0 0.4 to 1.5", _jamiolkowski),
    _by_density("Baldi et al. 1986, NC", _CHAMBER, lambda r: _baldi(r, 157.0, 2.41)),
    _by_density("Baldi et al. 1986, OC (K0 1)", _CHAMBER, lambda r: _baldi(r, 181.0, 2.61)),
    *_WEIGHTS,
    Correlation(
        "effective_unit_weight", "Brinkgreve et al. 2010", _DENSE, lambda r: 19.0e3 + 1.6e3 * r.density - WATER,
        _density_in,
    ),
    Correlation(
        "friction_angle_final", "Kulhawy and Mayne 1990", "(q_t/p_a)/(s'_v0/p_a)^0.5 10 to 1000", _kulhawy,
        lambda r: (_normalised(r) >= 10.0) & (_normalised(r) <= 1000.0),
    ),
    Correlation(
        "friction_angle_final", "Bolton 1986", f"{_DENSE}, I_R 0 to 4; p' at least 150 kPa",
        lambda r: CRITICAL + np.radians(3.0 * _dilatancy(r)),
        lambda r: _density_in(r) & (_dilatancy(r) > 0.0) & (_dilatancy(r) < 4.0),
    ),
    Correlation(
        "friction_angle_final", "Brinkgreve et al. 2010", _DENSE, lambda r: np.radians(28.0 + 12.5 * r.density),
        _density_in,
    ),
    Correlation("shear_modulus", "Rix and Stokoe 1991", "uncemented sand, I_c below 2.05", _rix,
                lambda r: ~(r.index > 2.05)),
    Correlation("shear_modulus", "Brinkgreve et al. 2010", _DENSE, _brinkgreve, _density_in),
    _ROBERTSON,
    Correlation(
        "degradation_strain", "Brinkgreve et al. 2010", _DENSE, lambda r: (2.0 - r.density) * 1e-4, _density_in
    ),
    *(
        Correlation("degradation_strain", f"Darendeli 2001, {stress} kPa", "p' 10 to 200 kPa", _constant(strain),
                    lambda r: ~(r.effective > 300e3))
        for stress, strain in ((10, 0.95e-4), (200, 1.9e-4))
    ),
)  # fmt: skip


KARLSRUHE = "25 triaxial tests on Karlsruhe fine sand (Wichtmann and Triantafyllidis 2016)"
SOFTEST = 1.9  # B fitted to a single one of these tests over that fitted to all, exceeded by a tenth of them
FOUR_SANDS = (0.4, 0.8)  # D_r at which B meets E_50 of four sands, s_3 100 kPa


def small_strains(density: Array) -> dict[str, Array]:
    """Return the keys of law sand that decide on small strains: low, best, high (3, 2) of D_r low, best, high (3, 2).

    Best is the default of the law, fitted to `KARLSRUHE`. High is the set of Brinkgreve et al. (2010): G_ur/G_0 =
    75 D_r/(60 + 68 D_r), and B with which the law has E_50 = 60 D_r MPa. Low: B of the softest tenth of the Karlsruhe
    tests; the floor stays, since these tests cannot tell a lower one from the bedding of the specimens.
    """
    floor = np.full((3, 2), LEAST_STIFFNESS)  # one number in a layer
    mean = density[2].mean()
    floor[2] = max(75.0 * mean / (60.0 + 68.0 * mean), LEAST_STIFFNESS)
    stiff = np.minimum(0.0122 * np.exp(-1.5 * (density[2] - 0.5)), mobilisation(density[1]))
    scale = np.array([SOFTEST * mobilisation(density[0]), mobilisation(density[1]), stiff])
    return {"degradation_limit": floor, "mobilisation_strain": scale}


def overconsolidation(strength: Array, stress: Array) -> Array:
    """Return the OCR of su and s'_v0, both in Pa, held within what the key may be.

    Jamiolkowski et al. (1985): su = 0.23 OCR^0.8 s'_v0.
    """
    return np.clip((strength / (0.23 * stress)) ** 1.25, LEAST_OCR, MOST_OCR)


def clay(factors: tuple[float, float, float] = CONE_FACTORS) -> tuple[Correlation, ...]:
    """Return the correlations of clay with cone factors N_kt for su high, best and low."""
    strength = [
        Correlation("undrained_shear_strength", f"N_kt {each:g}", "N_kt 8 to 25 in the field; I_c above 2.6",
                    _su(each), lambda r: ~(r.index < 2.6))
        for each in sorted(factors, reverse=True)  # low first, as the values stand
    ]  # fmt: skip
    stiffness = Correlation(
        "shear_modulus", "Mayne and Rix 1993", "G_0 0.7 to 800 MPa", _mayne,
        lambda r: (_mayne(r) >= 0.7e6) & (_mayne(r) <= 800e6),
    )  # fmt: skip
    half = (("2", 0.03), ("1", 0.015), ("0.5", 0.0075))
    strains = [
        Correlation("strain_at_half_strength", f"Matlock 1970, eps50 {name} %", "soft to stiff clay",
                    _constant(value), lambda r: np.full(r.cone.shape, True))
        for name, value in half
    ]  # fmt: skip
    return (*_WEIGHTS, *strength, stiffness, _ROBERTSON, *strains)
