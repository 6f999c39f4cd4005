# SPDX-License-Identifier: MIT
"""Loops over sparse rows beside SciPy's own."""

import numpy as np
import pytest
from scipy.sparse import diags_array, random_array

from fe_engine.linear.solver import equilibrated
from fe_engine.linear.sparse import scaled_entries, times

RNG = np.random.default_rng(5)
MATRIX = random_array((300, 300), density=0.05, format="csr", rng=RNG)
VECTOR = RNG.normal(size=300)


def test_product_with_a_vector():
    np.testing.assert_allclose(times(MATRIX, VECTOR), MATRIX @ VECTOR, rtol=1.0e-14, atol=1.0e-14)
    assert not times(0.0 * MATRIX, VECTOR).any()


@pytest.mark.parametrize(("kind", "rounding"), [(np.float64, 1.0e-15), (np.float32, 1.0e-6)])
def test_entries_scaled_from_both_sides(kind, rounding):
    scaled = scaled_entries(MATRIX, VECTOR, kind)
    assert scaled.dtype == kind
    expected = (diags_array(VECTOR) @ MATRIX @ diags_array(VECTOR)).tocsr()
    np.testing.assert_allclose(scaled, expected.data, rtol=rounding, atol=rounding)


def test_equilibrated_matrix_has_a_diagonal_of_ones():
    own = MATRIX - diags_array(MATRIX.diagonal())
    matrix = (own + diags_array(np.r_[-4.0, np.full(298, 9.0), 0.0])).tocsr()
    scale, scaled = equilibrated(matrix)
    np.testing.assert_allclose(np.abs(scaled.diagonal()), np.r_[np.ones(299), 0.0], rtol=1.0e-14)
    assert scale[-1] == 1.0
