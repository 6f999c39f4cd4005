# SPDX-License-Identifier: MIT
"""Clay whose su differs by direction, on single points: strengths of the element tests (see soil.anisotropic)."""

from functools import cache

import numpy as np

from fe_engine.soil import anisotropic
from fe_engine.soil.law import Point
from tests.verification.rows import Row

YOUNG, POISSON, COMPRESSION, DIRECT, EXTENSION = 1.2e7, 0.49, 2.8e4, 2.0e4, 1.4e4
_STRAIN, _STEPS = 4.0e-3, 100


def strength(direction: np.ndarray, start: float = 0.8) -> float:
    """Largest shear in Pa after much strain, from a vertical stress of 100 kPa and K0 ``start``.

    (sigma_1 - sigma_3)/2, or in direct shear the shear stress on its planes.
    """
    p = anisotropic.pack(YOUNG, POISSON, COMPRESSION, DIRECT, EXTENSION)
    state = Point(-1.0e5 * np.array([start, start, 1.0, 0.0, 0.0, 0.0]), np.zeros(1))
    for _ in range(_STEPS):
        new = Point(np.empty(6), np.empty(1))
        anisotropic.update(p, _STRAIN * direction, state, new, np.empty((6, 6)), False)
        state = new
    if direction[:3].any() == 0:
        return float(np.abs(state.stress[3:]).max())
    x, y, z, xy, yz, zx = state.stress
    values = np.linalg.eigvalsh(np.array([[x, xy, zx], [xy, y, yz], [zx, yz, z]]))
    return float(0.5 * (values[-1] - values[0]))


@cache
def rows() -> tuple[Row, ...]:
    """Plane strain, direct simple shear and triaxial tests."""
    plane, triaxial = np.array([0.5, 0.0, -0.5, 0.0, 0.0, 0.0]), np.array([0.5, 0.5, -1.0, 0.0, 0.0, 0.0]) / 1.5
    shift = 0.5 * (COMPRESSION - EXTENSION)
    radius = np.sqrt(0.25 * (COMPRESSION + EXTENSION) ** 2 - 0.25 * DIRECT**2)
    tests = {
        "plane strain compression": (plane, COMPRESSION), "plane strain extension": (-plane, EXTENSION),
        "direct simple shear": (np.eye(6)[5], DIRECT), "shear in a horizontal plane": (np.eye(6)[3], DIRECT),
        "triaxial compression": (triaxial, radius + shift), "triaxial extension": (-triaxial, radius - shift),
    }  # fmt: skip
    case = "clay with su by direction, K0 0.8"
    return tuple(
        Row(case, f"strength in {name}", "kPa", 1e-3 * strength(direction), 1e-3 * exact, "as given", 1e-8)
        for name, (direction, exact) in tests.items()
    )
