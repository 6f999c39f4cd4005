# SPDX-License-Identifier: MIT
"""Factors of all harmonics at once against dense solutions."""

import numpy as np
import pytest

from fe_engine.assembly.harmonic_factors import HarmonicFactors, order_of
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


def factors_of(elements, kept, stiffness, held):
    order = order_of([elements], kept, np.zeros(len(held), dtype=bool))
    return HarmonicFactors(order, [(elements, stiffness)], held)


@pytest.mark.parametrize("n_waves", [1, 4, 6])
def test_solves_equal_dense_ones_whatever_is_added_to_the_kept_nodes(n_waves):
    elements, stiffness, held, matrices = problem(n_waves)
    kept = np.array([7, 3, 20, 12])
    factors = factors_of(elements, kept, stiffness, held)
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
    schur = factors_of(elements, kept, stiffness, held).schur[0]
    at = (3 * kept[:, None] + np.arange(3)).ravel()
    inverse = np.linalg.inv(matrices[0])[np.ix_(at, at)]
    np.testing.assert_allclose(schur, np.linalg.inv(inverse), rtol=1e-9, atol=1e-9)


def test_a_matrix_that_is_not_positive_is_refused():
    elements, stiffness, held, _ = problem(2)
    with pytest.raises(LinearSolverError, match="positive definite"):
        factors_of(elements, np.array([1]), -stiffness, held)


@pytest.mark.parametrize(("gives_way", "stiff"), [(1.0, False), (1.0, True), (0.0, True)])
def test_pressures_behind_their_nodes_are_solved_however_little_the_water_gives_way(gives_way, stiff):
    elements, stiffness, held, matrices = problem(2)
    rng, n = np.random.default_rng(2), len(held)
    corners, kept = np.arange(0, n, 2), np.array([1, 7])  # a pressure at every other node
    pairs = np.stack([corners, n + np.arange(len(corners))], axis=1)
    coupling = rng.normal(size=(2, len(pairs), 3)) * ~held[corners].transpose(2, 0, 1)
    with_water = np.zeros((2, len(pairs), 6, 6))
    with_water[:, :, :3, 3] = with_water[:, :, 3, :3] = -coupling
    with_water[:, :, 3, 3] = -gives_way
    pressures_held = np.tile(np.array([False, True, True])[None, :, None], (len(pairs), 1, 2))
    pressures_held[1] = True
    with_water[:, 1] = 0.0
    order = order_of([elements, pairs], kept, np.arange(n + len(pairs)) >= n, stiff)
    parts = [(elements, stiffness), (pairs, with_water)]
    factors = HarmonicFactors(order, parts, np.concatenate([held, pressures_held]))
    rhs = rng.normal(size=(n + len(pairs), 3, 2))
    rhs[n:, 1:] = 0.0
    swept, left = factors.forward(rhs)
    inside = np.stack([np.linalg.solve(factors.schur[k], left[..., k].ravel()) for k in range(2)], axis=-1)
    found = factors.backward(swept, inside.reshape(2, 3, 2))
    for k in range(2):
        squeeze = np.zeros((3 * n, len(pairs)))
        at = (3 * corners[:, None] + np.arange(3)).ravel()
        squeeze[at, np.repeat(np.arange(len(pairs)), 3)] = coupling[k].ravel()
        own = np.diag(np.where(np.arange(len(pairs)) == 1, -1.0, gives_way))
        squeeze[:, 1] = 0.0
        whole = np.block([[matrices[k], -squeeze], [-squeeze.T, -own]])
        wanted = np.linalg.solve(whole, np.concatenate([rhs[:n, :, k].ravel(), rhs[n:, 0, k]]))
        np.testing.assert_allclose(found[:n, :, k].ravel(), wanted[: 3 * n], rtol=1e-7, atol=1e-9)
        np.testing.assert_allclose(found[n:, 0, k], wanted[3 * n :], rtol=1e-7, atol=1e-9)


def test_water_that_gives_way_backwards_is_refused():
    elements, stiffness, held, _ = problem(1)
    n = len(held)
    pair, own = np.array([[3, n]]), np.zeros((1, 1, 6, 6))
    own[..., 3, 3] = 5.0
    order = order_of([elements, pair], np.array([1]), np.arange(n + 1) >= n)
    one_row = np.array([False, True, True])[None, :, None]
    with pytest.raises(LinearSolverError, match="water not held"):
        HarmonicFactors(order, [(elements, stiffness), (pair, own)], np.concatenate([held, one_row]))
