# SPDX-License-Identifier: MIT
"""Factors of all harmonics at once against dense solutions."""

import numpy as np
import pytest

from fe_engine.assembly.harmonic_factors import HarmonicFactors
from fe_engine.errors import LinearSolverError


def grid(nx, ny):
    """Quads of a grid of nodes."""
    number = np.arange((nx + 1) * (ny + 1)).reshape(nx + 1, ny + 1)
    return np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)


def problem(n_waves, seed=0):
    """Elements, element matrices, what is held, and the dense matrices."""
    elements, rng = grid(5, 4), np.random.default_rng(seed)
    n = elements.max() + 1
    root = rng.normal(size=(n_waves, len(elements), 12, 12))
    stiffness = root @ root.transpose(0, 1, 3, 2)
    held = rng.uniform(size=(n, 3, n_waves)) < 0.1
    matrices = np.zeros((n_waves, 3 * n, 3 * n))
    for k in range(n_waves):
        for e, nodes in enumerate(elements):
            at = (3 * nodes[:, None] + np.arange(3)).ravel()
            still = held[nodes, :, k].ravel()
            stiffness[k, e, still], stiffness[k, e, :, still] = 0.0, 0.0
            matrices[k][np.ix_(at, at)] += stiffness[k, e]
        at = np.flatnonzero(held[..., k].ravel())
        matrices[k][at, at] = 1.0
    return elements, stiffness, held, matrices


@pytest.mark.parametrize("n_waves", [1, 4, 6])
def test_solves_equal_dense_ones_whatever_is_added_to_the_kept_nodes(n_waves):
    elements, stiffness, held, matrices = problem(n_waves)
    kept = np.array([7, 3, 20, 12])
    factors = HarmonicFactors(elements, kept, stiffness, held)
    rng = np.random.default_rng(1)
    rhs, added = rng.normal(size=held.shape), 5.0 * np.eye(12)
    swept, left = factors.forward(rhs)
    inside = np.stack(
        [np.linalg.solve(factors.schur[k] + added, left[..., k].ravel()) for k in range(n_waves)], axis=-1
    )
    found = factors.backward(swept, inside.reshape(4, 3, n_waves))
    at = (3 * kept[:, None] + np.arange(3)).ravel()
    for k in range(n_waves):
        whole = matrices[k].copy()
        whole[np.ix_(at, at)] += added
        wanted = np.linalg.solve(whole, rhs[..., k].ravel())
        np.testing.assert_allclose(found[..., k].ravel(), wanted, rtol=1e-9, atol=1e-12)


def test_the_schur_complement_is_what_elimination_leaves():
    elements, stiffness, held, matrices = problem(1)
    kept = np.array([0, 9])
    schur = HarmonicFactors(elements, kept, stiffness, held).schur[0]
    at = (3 * kept[:, None] + np.arange(3)).ravel()
    inverse = np.linalg.inv(matrices[0])[np.ix_(at, at)]
    np.testing.assert_allclose(schur, np.linalg.inv(inverse), rtol=1e-9, atol=1e-9)


def test_a_matrix_that_is_not_positive_is_refused():
    elements, stiffness, held, _ = problem(2)
    with pytest.raises(LinearSolverError, match="positive definite"):
        HarmonicFactors(elements, np.array([1]), -stiffness, held)
