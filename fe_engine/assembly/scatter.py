# SPDX-License-Identifier: MIT
"""Where local forces and stiffnesses go: equations, border dofs, entries of the sparse pattern."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fe_engine.compiled import njit


class Forces(NamedTuple):
    """Forces on the free dofs (n_free,) and on the border dofs (nb,), in N; kernels add to them."""

    free: np.ndarray
    border: np.ndarray


class Targets(NamedTuple):
    """Arrays of a bordered tangent that kernels add to: entries, columns (n_free, nb), rows (nb, n_free), corner.

    Without ``with_tangent`` the arrays are empty.
    """

    with_tangent: bool
    data: np.ndarray
    columns: np.ndarray
    rows: np.ndarray
    corner: np.ndarray


NOWHERE = Targets(False, np.zeros(0), np.zeros((0, 0)), np.zeros((0, 0)), np.zeros((0, 0)))


class Scatter(NamedTuple):
    """Where local entries go: see pattern.Pattern."""

    equation: np.ndarray
    weight: np.ndarray
    rank: np.ndarray
    indptr: np.ndarray


@njit
def scatter_force(nodes, scatter, force, forces):
    """Add the force (3 nn,) on nodes (nn,)."""
    for a in range(len(nodes)):
        for i in range(3):
            eq = scatter.equation[nodes[a], i]
            if eq >= 0:
                forces.free[eq] += force[3 * a + i]
            elif eq <= -2:
                forces.border[-2 - eq] += scatter.weight[nodes[a], i] * force[3 * a + i]


@njit
def scatter_stiffness(nodes, scatter, offset, stiffness, targets):
    """Add the stiffness (3 nn, 3 nn) between nodes (nn,); offset (nn, nn) leads to their entries."""
    _, data, columns, rows, corner = targets
    for a in range(len(nodes)):
        for i in range(3):
            r = scatter.equation[nodes[a], i]
            if r == -1:
                continue
            for b in range(len(nodes)):
                for j in range(3):
                    c = scatter.equation[nodes[b], j]
                    if c == -1:
                        continue
                    value = stiffness[3 * a + i, 3 * b + j]
                    if r >= 0 and c >= 0:
                        data[scatter.indptr[r] + offset[a, b] + scatter.rank[nodes[b], j]] += value
                    elif r >= 0:
                        columns[r, -2 - c] += scatter.weight[nodes[b], j] * value
                    elif c >= 0:
                        rows[-2 - r, c] += scatter.weight[nodes[a], i] * value
                    else:
                        corner[-2 - r, -2 - c] += scatter.weight[nodes[a], i] * scatter.weight[nodes[b], j] * value


@njit
def add_dof(scatter, node, i, value, forces):
    """Add a force to dof i of a node."""
    eq = scatter.equation[node, i]
    if eq >= 0:
        forces.free[eq] += value
    elif eq <= -2:
        forces.border[-2 - eq] += scatter.weight[node, i] * value


@njit
def add_border(scatter, node, i, m, column, row, targets):
    """Couple dof i of a node with border dof m."""
    eq = scatter.equation[node, i]
    if eq >= 0:
        targets.columns[eq, m] += column
        targets.rows[m, eq] += row
    elif eq <= -2:
        share = scatter.weight[node, i]
        targets.corner[-2 - eq, m] += share * column
        targets.corner[m, -2 - eq] += share * row


@njit
def add_entry(scatter, row_node, i, column_node, j, offset, value, targets):
    """Add one entry of the tangent; ``offset`` leads from the row to the column's node."""
    r, c = scatter.equation[row_node, i], scatter.equation[column_node, j]
    if r == -1 or c == -1:
        return
    if r >= 0 and c >= 0:
        targets.data[scatter.indptr[r] + offset + scatter.rank[column_node, j]] += value
    elif r >= 0:
        targets.columns[r, -2 - c] += scatter.weight[column_node, j] * value
    elif c >= 0:
        targets.rows[-2 - r, c] += scatter.weight[row_node, i] * value
    else:
        targets.corner[-2 - r, -2 - c] += scatter.weight[row_node, i] * scatter.weight[column_node, j] * value
