# SPDX-License-Identifier: MIT
"""The axisymmetric oracle against an exact answer, mixed elements, a boundary method, another order, and itself."""

import ast
import inspect
from functools import cache

import numpy as np
import pytest

from tests.verification import axisymmetric

PAPER = (3.9, 4.0, 24.0, 12.0, 200e6 / 2.6)
# Beyond 2000 radii the half-space is as near as the tables tell
FAR = 2000.0
# The paper's caisson, shear modulus 76.9 MPa: K_H, K_C, K_M, K_free in MN and m, computed once by a separate program
# with mixed elements (displacement of order 4, discontinuous pressure of order 3), 18 cells, grading 0.45
MIXED = {
    0.3: (4071.7, -10382.7, 89832.0, 2871.7),
    0.499: (4742.5, -10963.1, 99638.0, 3536.3),
    0.4999: (4746.9, -10968.0, 99713.0, 3540.5),
}
# Half-space, L/(2 R) and nu: K_H/(G R), K_C/(G R^2), K_M/(G R^3), K_free/(G R) by a boundary method as that of Doherty,
# Houlsby & Deeks (2005), printed to two decimals
HALF_SPACE = {
    (0.0, 0.3): (4.76, -0.45, 4.00, 4.71),
    (0.5, 0.2): (9.07, -6.29, 16.64, 6.69),
    (0.5, 0.3): (9.54, -6.37, 17.16, 7.18),
    (0.5, 0.4): (10.11, -6.48, 17.88, 7.77),
    (0.5, 0.499): (10.85, -6.68, 19.02, 8.50),
    (2.0, 0.3): (18.86, -45.19, 204.16, 8.86),
}


@cache
def paper(poisson: float, order: int = 4) -> np.ndarray:
    """K_H, K_C, K_M, K_free of the paper's caisson, MN and m."""
    return np.array(axisymmetric.stiffness(*PAPER, poisson, order=order)) / 1e6


@pytest.mark.slow
def test_rough_disc_on_an_incompressible_half_space():
    """K_H = 8 G R/(2 - nu) (Mindlin 1949) and K_M = 8 G R^3/(3 (1 - nu)) (Borowicka 1943): both 16/3 at nu = 0.5.

    They are of discs that transmit shear alone and normal stress alone. At nu = 0.5 neither of the two moves the
    surface in the direction of the other, so that both are exact for a rough disc too, and K_C = 0. Bycroft's (1956)
    K_H = 32 (1 - nu) G R/(7 - 8 nu) is 16/3 there as well.
    """
    radius, shear = 2.0, 3.0
    k_h, k_c, k_m, k_free = axisymmetric.stiffness(radius, 0.0, FAR * radius, FAR * radius, shear, 0.4999, cells=8)
    found = np.array([k_h / radius, k_m / radius**3, k_free / radius]) / shear
    assert found == pytest.approx(16.0 / 3.0, rel=1e-3)
    assert k_c / (shear * radius**2) == pytest.approx(0.0, abs=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("ratio, poisson", HALF_SPACE)
def test_half_space_is_that_of_a_boundary_method(ratio, poisson):
    found = axisymmetric.stiffness(1.0, 2.0 * ratio, FAR, FAR, 1.0, poisson, cells=6)
    assert found == pytest.approx(HALF_SPACE[ratio, poisson], rel=2.5e-3, abs=0.006)


@pytest.mark.slow
@pytest.mark.parametrize("poisson", MIXED)
def test_order_four_does_not_lock(poisson):
    assert paper(poisson) == pytest.approx(np.array(MIXED[poisson]), rel=1e-4)


@pytest.mark.parametrize("poisson", [0.3, 0.4999])
@pytest.mark.slow
def test_order_three_is_order_four(poisson):
    lower, higher = paper(poisson, order=3), paper(poisson)
    assert lower == pytest.approx(higher, rel=1e-3)
    # Energies of nested spaces come from above
    assert np.all((lower > higher)[[0, 2, 3]])


@pytest.mark.parametrize("poisson", [0.0, 0.4999])
def test_load_of_a_rotation_is_the_moment_of_a_translation(poisson):
    k = axisymmetric.matrix(*PAPER, poisson, cells=4)
    assert k[0, 1] == pytest.approx(k[1, 0], rel=1e-7)
    assert k[0, 1] < 0.0  # in the signs of the field


def test_oracle_uses_nothing_of_the_project():
    tree = ast.walk(ast.parse(inspect.getsource(axisymmetric)))
    used = {node.module if isinstance(node, ast.ImportFrom) else node.names[0].name
            for node in tree if isinstance(node, ast.Import | ast.ImportFrom)}  # fmt: skip
    assert "numpy" in used
    assert not {name.split(".")[0] for name in used} & {"fe_engine", "pysprings", "tests"}
