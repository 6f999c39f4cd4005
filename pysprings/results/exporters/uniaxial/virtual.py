# SPDX-License-Identifier: MIT
"""A fan as uniaxial springs at virtual depths: the coupling of u and rotation for programs with uncoupled springs.

A lateral spring at depth z of a rigid body reads u - z rotation. With z = -L tan(angle) it reads the component of
(u, rotation L) in a direction; a rotational spring reads -90 deg. The springs stand at depths where there may be no
skirt: they represent the foundation as a whole, not its parts.

Each direction has a sum of curves k q/(1 + (|q|/d)^4)^(1/4), k >= 0, and a straight line, in several planes
(`planes`). k comes from non-negative least squares over the loads of the fan, relative errors, with the initial
stiffness as heavy rows.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pysprings.macro.curve_table import Row, SpringTable, stack
from pysprings.macro.fan import FanTable
from pysprings.macro.model import MacroModel
from pysprings.results.exporters.uniaxial.planes import KNOTS, SCALES, SIZES, curves, in_planes

Array = NDArray[np.float64]

DIRECTIONS = np.radians(np.arange(80.0, -91.0, -10.0))  # from the highest to the deepest
STEP = np.radians(5.0)  # between the states of the fit
HEAVY = 3.0  # weight of the initial stiffness, of which there are few rows
LEAST = 1e-6  # springs with less than this share of the stiffness are left out


def virtual_table(model: MacroModel, planes: int = 2) -> SpringTable:
    """Return the laws of the springs at virtual depths, in each plane, of a model on a fan."""
    table = model.table
    assert isinstance(table, FanTable)
    reach = float(table.range.max())
    weights = _fit(model, table, reach, planes)
    rows = [_row(angle, each, reach, table.length) for angle, each in zip(DIRECTIONS, weights, strict=True)]
    total = max(float(each.sum()) for each in weights)
    return stack([row for row, each in zip(rows, weights, strict=True) if each.sum() > LEAST * total])


def _fit(model: MacroModel, table: FanTable, reach: float, planes: int) -> Array:
    """Return the stiffness (directions, scales) [N/m] of the curves."""
    from scipy.optimize import nnls

    states = _states(table)
    L = table.length
    loads = np.array([model.reactions(u, v / L)[0] / [1.0, L] for u, v in states])
    along = np.stack([np.cos(DIRECTIONS), np.sin(DIRECTIONS)])  # (2, directions)
    forces = in_planes(states @ along, reach, planes)  # (states, directions, scales)
    columns = np.einsum("id,sdk->sidk", along, forces) / np.linalg.norm(loads, axis=1)[:, None, None, None]
    K = model.reactions(0.0, 0.0)[1] / [[1.0, L], [L, L * L]]
    size = np.linalg.norm(K)
    initial = 0.5 * planes * np.einsum("id,jd,k->ijdk", along, along, np.ones(SCALES.size)) / size
    heavy = HEAVY * np.sqrt(len(states) / 4.0)
    n = DIRECTIONS.size * SCALES.size
    left = np.concatenate([columns.reshape(-1, n), heavy * initial.reshape(-1, n)])
    right = np.concatenate([(loads / np.linalg.norm(loads, axis=1)[:, None]).ravel(), heavy * (K / size).ravel()])
    scale = np.linalg.norm(left, axis=0)
    k: Array = nnls(left / scale, right, maxiter=30 * n)[0] / scale
    return k.reshape(DIRECTIONS.size, SCALES.size)


def _states(table: FanTable) -> Array:
    """Return states (n, 2) = (u, rotation L) [m] in half the plane, each up to the range of the fan there."""
    angles = -np.arange(-0.5 * np.pi, 0.5 * np.pi, STEP) - STEP
    ends = np.array([[np.cos(a), np.sin(a) / table.length] for a in angles])
    used = table.support(ends, table.rows(ends)[1])[0]
    states: Array = (ends * [1.0, table.length] / used[:, None])[:, None, :] * SIZES[:, None]
    return states.reshape(-1, 2)


def _row(angle: float, weights: Array, reach: float, length: float) -> Row:
    """Return the spring of a direction: lateral at depth -L tan(angle), or rotational at -90 deg."""
    q = KNOTS * reach  # component of (u, rotation L) in the direction
    r = curves(q, reach) @ weights
    if abs(np.cos(angle)) < 1e-6:
        return Row("virtual", 0.0, "rotation", (0.0, 1.0), (0.0, 1.0), q / length, r * length)
    depth = float(-length * np.tan(angle))
    return Row("virtual", depth, "y", (1.0, -depth), (1.0, -depth), q / np.cos(angle), r * np.cos(angle))
