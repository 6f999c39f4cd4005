# SPDX-License-Identifier: MIT
"""Elastic stiffness of a rigid caisson bonded to ground whose stiffness varies with depth, in series of one harmonic.

The references are independent computations of a caisson without thickness; ours has a skirt of D/8000. The paper's
geometry is R 3.9 m, L 4 m, in 24 m x 12 m of soil with a roller at the side, nu 0.3, in MN and m for G in MPa. In the
half-space G = G_R (z/R)^a, and factors are over G_R R, G_R R^3 and G_R R^2; our domain ends 40 diameters away.

Where G grows from 0 in proportion to depth, K_V of a short skirt depends on the cells below the lid more than the
other stiffnesses: that row is shown, and held on a finer mesh.
"""

from functools import cache
from typing import Any

import numpy as np

from fe_engine.clock import Clock
from fe_engine.state import State
from pysprings import Scene
from pysprings.full_model.work import newton_of
from pysprings.model.fourier import build
from pysprings.scene.sections import PAPER
from tests.support import tiny
from tests.verification.rows import Row

NAMES, UNITS = ("K_H", "K_C", "K_M", "K_free", "K_V"), ("MN/m", "MN", "MN m", "MN/m", "MN/m")
_MPA = 1.0e6
_PENALTY = 3.0e3  # over E/D: costs less than 0.1 % of the stiffness
_SOURCE = "independent computation, thickness 0"


def _young(form: Any) -> Any:
    """Return Young's modulus of a shear modulus in MPa, nu 0.3: a number, or the keys of a table that are moduli."""
    if isinstance(form, dict):
        moduli = ("top", "gradient", "reference")
        return {key: 2.6 * _MPA * value if key in moduli else value for key, value in form.items()}
    return 2.6 * _MPA * form


# name: layers (top in m, G in MPa), K_H, K_C, K_M, K_free, K_V, largest G beside the caisson
PAPERS: dict[str, tuple[list[tuple[float, Any]], tuple[float, ...], float]] = {
    "G = 1": ([(0.0, 1.0)], (52.940, -135.023, 1168.28, 37.335, 55.159), 1.0),
    "1 to 2 m, 4 below": ([(0.0, 1.0), (2.0, 4.0)], (171.604, -524.993, 3992.43, 102.569, 190.713), 4.0),
    "1 to 4 m, 4 below": ([(0.0, 1.0), (4.0, 4.0)], (106.558, -323.176, 2489.68, 64.608, 132.606), 4.0),
    "G = sqrt(z/4 m)": (
        [(0.0, {"reference": 1.0, "reference_depth": 4.0, "exponent": 0.5})],
        (48.607, -142.582, 1118.97, 30.438, 57.924), 1.0,
    ),
    "G = 0.2 + 0.2 z": ([(0.0, {"top": 0.2, "gradient": 0.2})], (49.778, -149.176, 1150.54, 30.436, 62.264), 1.0),
}  # fmt: skip
# a, L/D, nu: K_V, K_H, K_M, K_C, K_free
HALF_SPACE = {
    (0.5, 0.25, 0.2): (7.018, 6.088, 6.104, -2.534, 5.037), (0.5, 0.25, 0.3): (7.881, 6.418, 6.487, -2.524, 5.436),
    (0.5, 0.50, 0.2): (10.207, 9.769, 16.499, -7.622, 6.247), (0.5, 0.50, 0.3): (11.246, 10.286, 17.074, -7.747, 6.771),
    (0.5, 0.50, 0.499): (16.700, 11.819, 19.210, -8.222, 8.300), (1.0, 0.25, 0.3): (6.857, 5.260, 4.913, -2.133, 4.335),
    (1.0, 0.50, 0.3): (13.428, 11.061, 17.566, -8.860, 6.593), (1.0, 1.00, 0.3): (28.0, 25.295, 98.430, -39.663, 9.312),
    (1.0, 0.50, 0.499): (23.259, 12.807, 20.056, -9.527, 8.282),
}  # fmt: skip
SHORT = (1.0, 0.25)


def five(scene: Scene) -> np.ndarray:
    """Return K_H, K_C, K_M, K_free and K_V of the whole caisson at rest, in N and m."""
    built = build(scene)
    k = 2.0 * newton_of(scene, built, Clock()).border_stiffness(State(built.model))
    return np.array([k[0, 0], k[0, 2], k[2, 2], k[0, 0] - k[0, 2] * k[2, 0] / k[2, 2], k[1, 1]])


def _scene(caisson: dict[str, float], soil: dict[str, Any], young: float, **sections: Any) -> Scene:
    penalty = _PENALTY * young / caisson["outer_diameter"]
    return tiny.sand(
        caisson=caisson | {"skirt_thickness": caisson["outer_diameter"] / 8e3},
        soil={"yield_surface": "elastic"} | soil,
        interface={"normal_stiffness": penalty, "shear_stiffness": penalty, "friction_coefficient": 5.0},
        mesh={"discretisation": "fourier", "preset": "fine", "harmonics": 1}, **sections,
    )  # fmt: skip


@cache
def papers_rows() -> tuple[Row, ...]:
    """The paper's geometry, five profiles."""
    found = []
    for name, (layers, wanted, largest) in PAPERS.items():
        soil = {"layers": [{"top": top, "young_modulus": _young(form)} for top, form in layers]}
        ours = five(_scene({"outer_diameter": 7.8, "skirt_length": 4.0}, soil, 2.6 * _MPA * largest, domain=PAPER))
        numbers = zip(NAMES, UNITS, ours / _MPA, wanted, strict=True)
        found += [Row(f"bonded caisson, G by depth: {name}", *row, _SOURCE, 0.015) for row in numbers]
    return tuple(found)


@cache
def half_space_rows() -> tuple[Row, ...]:
    """A half-space whose stiffness is a power of depth."""
    found, radius, reference = [], 4.0, 20.0 * _MPA
    for (power, slenderness, poisson), wanted in HALF_SPACE.items():
        diameter = 2.0 * radius
        young = {"reference": 2.0 * (1.0 + poisson) * reference, "reference_depth": radius, "exponent": power}
        soil = {"poisson_ratio": poisson, "layers": [{"top": 0.0, "young_modulus": young}]}
        caisson = {"outer_diameter": diameter, "skirt_length": slenderness * diameter}
        ends = {"radius": 40.0 * diameter, "depth": 40.0 * diameter}
        k_h, k_c, k_m, k_free, k_v = five(_scene(caisson, soil, young["reference"], domain=ends)) / (reference * radius)
        ours = k_v, k_h, k_m / radius**2, k_c / radius, k_free
        case = f"half-space, G = G_R (z/R)^{power:g}, L/D {slenderness:g}, nu {poisson:g}"
        numbers = zip(("K_V", "K_H", "K_M", "K_C", "K_free"), ours, wanted, strict=True)
        for name, mine, its in numbers:
            by_mesh = name == "K_V" and (power, slenderness) == SHORT
            found.append(Row(case, name, "", mine, its, _SOURCE, None if by_mesh else 0.02))
        if (power, slenderness) == SHORT:
            finer = _scene(caisson, soil, young["reference"], domain=ends).replace(mesh={"refinement": 3.0})
            k_v = five(finer)[-1] / (reference * radius)
            found.append(Row(case, "K_V, refinement 3", "", k_v, wanted[0], _SOURCE, 0.02))
    return tuple(found)


def rows() -> tuple[Row, ...]:
    """Both domains."""
    return (*papers_rows(), *half_space_rows())
