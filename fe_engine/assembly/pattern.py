# SPDX-License-Identifier: MIT
"""Equation numbers and the fixed sparsity pattern of the tangent.

Every nodal dof is free (equation >= 0), fixed (-1), or follows border dof j (-2 - j) with a weight. With water a
node has a fourth dof, its pressure, and the film's nodes stand behind those of the mesh with that dof alone. The free
equations form the sparse matrix; the few border dofs (rigid body, imposed patterns) stand beside it as dense
columns and rows, so that the sparse part is factorised without dense rows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from fe_engine.compiled import njit
from fe_engine.errors import ModelError
from fe_engine.model import Model

FIXED = -1


@dataclass(frozen=True)
class Pattern:
    """Equation numbers, CSR structure, and where each node pair of an element or station lands in a row.

    equation : (n, 3), with water (n + nf, 4); weight : the same shape, of followers; rank : number of free dofs of
    the node before this one; indptr, indices : CSR of the free equations; element_offset : (ne, 8, 8),
    linear_offset (nl, 8, 8), station_offset (ns, nn, nn), film_offset (ns, nn + k, nn + k) and face_offset
    (m, 4 + 4 nn, 4 + 4 nn): position inside the row of node a where the free dofs of node b begin. station_film
    (ns, nn + k) are the mesh nodes and the film nodes of each station, face_nodes (m, 4 + 4 nn) the film nodes of each
    face and the mesh nodes that its gaps hang on; film nodes are numbered behind the mesh here.

    Row r of a dof of node a, whose neighbours b are in ascending order::

        | free dofs of b_0 | free dofs of b_1 | free dofs of b_2 | ..
        ^ indptr[r]        ^ + offset[a, b_1] ^ + offset[a, b_2]       dof j of node b stands at + rank[b, j]
    """

    equation: np.ndarray
    weight: np.ndarray
    rank: np.ndarray
    indptr: np.ndarray
    indices: np.ndarray
    element_offset: np.ndarray
    linear_offset: np.ndarray
    station_offset: np.ndarray
    station_film: np.ndarray
    film_offset: np.ndarray
    face_nodes: np.ndarray
    face_offset: np.ndarray

    @property
    def n_nodes(self) -> int:
        """Number of nodes of mesh and film."""
        return len(self.equation)

    @property
    def n_unknowns(self) -> int:
        """Number of free dofs: that of the equations."""
        return self.n_free

    @property
    def n_free(self) -> int:
        """Number of sparse equations."""
        return len(self.indptr) - 1


def make_pattern(model: Model) -> Pattern:
    """Count the equations and lay out the matrix."""
    equation, weight = _number(model)
    stations = np.zeros((0, 1), dtype=np.int64) if model.stations is None else model.stations.nodes
    station_film, face_nodes = _film_groups(model, stations)
    linear = np.zeros((0, 8), dtype=np.int64) if model.linear is None else model.linear.hexes
    groups = [model.mesh.hexes, linear, stations, station_film, face_nodes]
    start, neighbours = _node_graph(len(equation), groups)
    free = equation >= 0
    rank: np.ndarray = np.subtract(np.cumsum(free, axis=1), free).astype(np.int8)
    offset, indptr, indices = _csr(start, neighbours, equation, free.sum(axis=1))
    element, linear_offset, station, film, face = (_lookup(group, start, neighbours, offset) for group in groups)
    return Pattern(
        equation, weight, rank, indptr, indices, element, linear_offset, station, station_film, film, face_nodes, face
    )


def _film_groups(model: Model, stations: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the nodes (of mesh and film) that meet in a station and in a face of the film."""
    if model.water is None or model.water.film is None:
        return np.zeros((0, 1), dtype=np.int64), np.zeros((0, 1), dtype=np.int64)
    film, n = model.water.film, model.mesh.n_nodes
    moving = stations[film.corners].reshape(len(film.faces), 4 * stations.shape[1])
    return np.hstack([stations, n + film.nodes]), np.hstack([n + film.faces, moving])


def _number(model: Model) -> tuple[np.ndarray, np.ndarray]:
    n, water = model.mesh.n_nodes, model.water
    fixed = model.fixed
    if water is not None:
        fixed = np.ones((n + model.n_film, 4), dtype=bool)
        fixed[:n, :3] = model.fixed
        fixed[:, 3] = water.fixed
    equation = np.zeros(fixed.shape, dtype=np.int64)
    weight = np.ones(fixed.shape)
    equation[fixed] = FIXED
    for node, component, border, share in model.followers:
        if not 0 <= border < model.n_border:
            raise ModelError(f"node {int(node)} follows border dof {int(border)}, which does not exist")
        equation[int(node), int(component)] = -2 - int(border)
        weight[int(node), int(component)] = share
    free = equation == 0
    equation[free] = np.arange(int(free.sum()))
    return equation, weight


def _node_graph(n: int, groups: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return sorted neighbour lists (start, neighbours) of the nodes that share an element or a station."""
    width = np.concatenate([np.full(len(group), group.shape[1]) for group in groups])
    starts = np.concatenate([[0], np.cumsum(width)])
    nodes = np.concatenate([group.ravel() for group in groups])
    meets = csr_matrix((np.ones(len(nodes), dtype=np.int32), nodes, starts), shape=(len(width), n))
    graph = (meets.T @ meets).tocsr()  # nodes of one group meet
    graph.sort_indices()
    return graph.indptr.astype(np.int64), graph.indices.astype(np.int64)


@njit
def _csr(start, neighbours, equation, count):
    """Return the row offsets of each node pair and the CSR arrays of the free equations."""
    n = len(count)
    offset = np.zeros(len(neighbours), dtype=np.int32)
    n_free = 0
    nnz = 0
    for a in range(n):
        width = 0
        for k in range(start[a], start[a + 1]):
            offset[k] = width
            width += count[neighbours[k]]  # free dofs of a node stand side by side in a row
        n_free += count[a]
        nnz += width * count[a]
    indptr = np.zeros(n_free + 1, dtype=np.int64)
    indices = np.empty(nnz, dtype=np.int32)
    row = 0
    position = 0
    for a in range(n):
        for i in range(equation.shape[1]):
            if equation[a, i] < 0:
                continue
            for k in range(start[a], start[a + 1]):
                b = neighbours[k]
                for j in range(equation.shape[1]):
                    if equation[b, j] >= 0:
                        indices[position] = equation[b, j]
                        position += 1
            row += 1
            indptr[row] = position
    return offset, indptr, indices


@njit
def _lookup(group, start, neighbours, offset):
    """Offset (ng, nn, nn) of each node pair of each element or station."""
    ng, nn = group.shape
    out = np.zeros((ng, nn, nn), dtype=np.int32)
    for e in range(ng):
        for a in range(nn):
            node = group[e, a]
            row = neighbours[start[node] : start[node + 1]]
            for b in range(nn):
                out[e, a, b] = offset[start[node] + np.searchsorted(row, group[e, b])]
    return out
