# SPDX-License-Identifier: MIT
"""Where the interface stands in the sparse matrix: the equations of its nodes and of its film, and their entries.

Stations and film reach these equations alone, so that what contact adds to a tangent is a small block of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fe_engine.assembly.pattern import Pattern
from fe_engine.model import Model


@dataclass(frozen=True)
class ContactBlock:
    """Equations (m,) of the interface; positions (k,) of the block's entries in the matrix; row, column (k,) in it."""

    equations: np.ndarray
    positions: np.ndarray
    row: np.ndarray
    column: np.ndarray


def contact_block(model: Model, pattern: Pattern) -> ContactBlock | None:
    """Find the block; None where border dofs reach other equations, too (nodes that follow them)."""
    if model.stations is None or len(model.followers):
        return None
    nodes = np.concatenate([np.unique(model.stations.nodes), np.arange(model.mesh.n_nodes, pattern.n_nodes)])
    equations = np.sort(pattern.equation[nodes].ravel())
    equations = equations[equations >= 0]
    local = np.full(pattern.n_free, -1)
    local[equations] = np.arange(len(equations))
    counts = pattern.indptr[equations + 1] - pattern.indptr[equations]
    first = np.repeat(pattern.indptr[equations] - np.concatenate([[0], np.cumsum(counts)[:-1]]), counts)
    positions = first + np.arange(counts.sum())
    column = local[pattern.indices[positions]]
    inside = column >= 0
    row = np.repeat(np.arange(len(equations)), counts)
    return ContactBlock(equations, positions[inside], row[inside], column[inside])
