# SPDX-License-Identifier: MIT
"""Factors of the matrices of all harmonics on one section, which have the same pattern of 3 x 3 blocks a pair of nodes.

Each matrix is K = L D L^T with the retained nodes I last. All others are eliminated,

    forward:  D^-1 L^-1 of the eliminated part, and the right-hand side that is left for I,
    backward: the eliminated unknowns from those of I,

and their Schur complement S on I stays, dense: whatever is added to S, a solve goes through the factors once in each
direction. Four harmonics at a time go through the loops, as lanes of a vector; missing ones are unit matrices.
Pressures are nodes of their own, with one row: each pivot of such a quasi-definite matrix has its sign in any order
(Vanderbei 1995).

Where the right-hand side has something on few nodes alone, and the unknowns are asked for on these alone, only the
columns that these nodes depend on are gone through (Gilbert & Peierls 1988), in single precision: see `Near`.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, identity
from scipy.sparse.linalg import splu

from fe_engine.compiled import njit
from fe_engine.errors import LinearSolverError

LANES = 4
KEPT_BYTES = 5.0e8  # of factors with water that a system keeps for further time steps
_SYMMETRIC = {"SymmetricMode": True}
Part = tuple[np.ndarray, np.ndarray]  # nodes (ne, nn) and matrices (N + 1, ne, 3 nn, 3 nn) of elements
# first lane in use, first slot in it, number of slots, L below its diagonal, inverted pivots
_Group = tuple[int, int, int, np.ndarray, np.ndarray]


class Near(NamedTuple):
    """Some nodes of the section, the columns of L that they depend on, and these factors in single precision.

    number, place : (p,) 0, 1, .. and where the nodes stand in the elimination; columns : (c,) ascending, out of
        ``eliminated`` ones.
    group : (G, 4) first lane in use, first slot in it, number of slots, number of the factors; pointer, row : of L;
        lower, inverse : (F, ..) its blocks and the inverted pivots.
    """

    number: np.ndarray
    place: np.ndarray
    columns: np.ndarray
    eliminated: int
    group: np.ndarray
    pointer: np.ndarray
    row: np.ndarray
    lower: np.ndarray
    inverse: np.ndarray


class Order(NamedTuple):
    """Where nodes stand in the elimination.

    node : (n,) at each place, ``retained`` (nk,) last; definite : (n,) whether the pivot there is positive.
    pointer, row : rows (CSC, below the diagonal) of columns of L.
    """

    node: np.ndarray
    retained: np.ndarray
    definite: np.ndarray
    pointer: np.ndarray
    row: np.ndarray


class HarmonicFactors:
    """Factors for vectors (n, 3, K) on the nodes of a section, K slots (see elements.fourier).

    Both families of a whole circle go through the same factors.

    Attributes
    ----------
    n_nodes : n; retained : (nk,) nodes that are not eliminated; schur : (N + 1, 3 nk, 3 nk) of each
        harmonic, three rows a node.
    """

    def __init__(self, order: Order, parts: Sequence[Part], held: np.ndarray) -> None:
        """Factorise.

        Parameters
        ----------
        order : of the elements of all parts; parts : nodes (ne, nn) and matrices (N + 1, ne, 3 nn, 3 nn) of elements.
        held : (n, 3, K) bool, where a unit row and column stand; no stiffness may be there; alike in both families.
        """
        n_waves, n = len(parts[0][1]), len(held)
        self.retained = retained = order.retained
        self.n_waves, self.n_nodes = held.shape[2], n
        self._node, self._pointer, self._row = order.node, order.pointer, order.row
        self._place = np.empty(n, dtype=np.int64)
        self._place[self._node] = np.arange(n)
        self._n_eliminated = n - len(retained)
        self._groups: list[_Group] = []
        self.schur = np.empty((n_waves, 3 * len(retained), 3 * len(retained)))
        for first in range(0, n_waves, LANES):
            ks = range(first, min(first + LANES, n_waves))
            diagonal, lower = np.zeros((n, 3, 3, LANES)), np.zeros((len(self._row), 3, 3, LANES))
            for elements, stiffness in parts:
                for lane, k in enumerate(ks):
                    _assemble(self._place[elements], stiffness[k], self._pointer, self._row, lane, diagonal, lower)
            unit = np.ones((n, 3, LANES), dtype=bool)
            unit[:, :, : len(ks)] = held[self._node][:, :, first : first + len(ks)]
            node, i, lane_of = np.nonzero(unit)
            diagonal[node, i, i, lane_of] = 1.0
            inverse = np.zeros((self._n_eliminated, 3, 3, LANES))
            if not _factorise(self._n_eliminated, self._pointer, self._row, order.definite, diagonal, lower, inverse):
                raise LinearSolverError("the stiffness of a harmonic is not positive definite, or its water not held")
            for lane, k in enumerate(ks):
                self.schur[k] = self._dense(diagonal[..., lane], lower[..., lane])
            used = self._pointer[self._n_eliminated]
            factors = np.ascontiguousarray(lower[:used]), inverse
            self._groups.append((0, first, len(ks), *factors))
            if self.n_waves > n_waves:
                lane = int(first == 0)
                self._groups.append((lane, n_waves - 1 + first + lane, len(ks) - lane, *factors))
        self._all = np.arange(n), np.arange(self._n_eliminated)

    @property
    def n_bytes(self) -> float:
        """Bytes of the factors, those in single precision included."""
        return 1.5 * sum(lower.nbytes + inverse.nbytes for *_, lower, inverse in self._groups)

    def near(self, nodes: np.ndarray) -> Near:
        """Return what solves for these nodes (p,) need."""
        place = self._place[nodes]
        met = _on_the_way(place, self._n_eliminated, self._pointer, self._row)
        columns = np.flatnonzero(met[: self._n_eliminated])
        return Near(
            np.arange(len(nodes)), place, columns, self._n_eliminated, self._single[0], self._pointer, self._row,
            *self._single[1:],
        )  # fmt: skip

    @cached_property
    def _single(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Groups (G, 4), and their factors in single precision, see `Near`."""
        different: dict[int, _Group] = {}
        for each in self._groups:
            different.setdefault(id(each[3]), each)
        numbers = {key: number for number, key in enumerate(different)}
        group = np.array([(*each[:3], numbers[id(each[3])]) for each in self._groups])
        lower, inverse = (
            np.stack([each[i] for each in different.values()], dtype=np.float32, casting="same_kind") for i in (3, 4)
        )
        return group, lower, inverse

    def forward(self, rhs: np.ndarray) -> tuple[list[np.ndarray], np.ndarray]:
        """Eliminate rhs (n, 3, K): return what `backward` needs, and what is left (nk, 3, K) for the retained nodes."""
        swept, left, (place, columns) = [], np.empty((len(self.retained), 3, self.n_waves)), self._all
        for lane, first, count, lower, inverse in self._groups:
            x = np.zeros((self.n_nodes, 3, LANES))
            put(self._node, place, rhs, lane, first, count, x)
            forward(columns, self._pointer, self._row, lower, inverse, x)
            left[:, :, first : first + count] = x[self._n_eliminated :, :, lane : lane + count]
            swept.append(x)
        return swept, left

    def backward(self, swept: list[np.ndarray], retained: np.ndarray) -> np.ndarray:
        """Return the unknowns (n, 3, K), those of the retained nodes (nk, 3, K) being known; uses up ``swept``."""
        out, (place, columns) = np.zeros((self.n_nodes, 3, self.n_waves)), self._all
        for (lane, first, count, lower, _), x in zip(self._groups, swept, strict=True):
            x[self._n_eliminated :, :, lane : lane + count] = retained[:, :, first : first + count]
            backward(columns, self._pointer, self._row, lower, x)
            take(self._node, place, x, lane, first, count, out)
        return out

    def _dense(self, diagonal: np.ndarray, lower: np.ndarray) -> np.ndarray:
        """Return the Schur complement (3 nk, 3 nk) of one lane."""
        m, size = self._n_eliminated, len(self.retained)
        dense = np.zeros((size, 3, size, 3))
        for j in range(size):
            dense[j, :, j] = diagonal[m + j]
            entries = slice(self._pointer[m + j], self._pointer[m + j + 1])
            rows = self._row[entries] - m
            dense[rows, :, j] = lower[entries]
            dense[j, :, rows] = lower[entries].transpose(0, 2, 1)
        return dense.reshape(3 * size, 3 * size)


def order_of(elements: Sequence[np.ndarray], retained: np.ndarray, pressures: np.ndarray, stiff: bool = False) -> Order:
    """Return the order of the elimination.

    Parameters
    ----------
    elements : nodes (ne, nn) that share rows; retained : (nk,) nodes that stay.
    pressures : (n,) bool, nodes with one row; where water is ``stiff``, each stands right behind the last of the nodes
        that it shares rows with: alone it would have hardly a pivot.
    """
    n, follows = len(pressures), pressures & stiff
    graph = _graph(elements, n)
    last = np.zeros(n, dtype=bool)
    last[retained] = True
    lead, inner = np.flatnonzero(~last & ~follows), np.flatnonzero(~last)
    first = splu(graph[lead][:, lead], permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=_SYMMETRIC)
    rank = np.full(n, -1)
    rank[lead] = first.perm_c
    for each in elements:
        at = follows[each]
        np.maximum.at(rank, each[at], np.broadcast_to(rank[each].max(axis=1, keepdims=True), each.shape)[at])
    rank[follows & (rank < 0)] = n  # beside retained nodes alone
    sequence = np.concatenate([inner[np.lexsort((follows[inner], rank[inner]))], retained])
    factors = splu(graph[sequence][:, sequence], permc_spec="NATURAL", diag_pivot_thresh=0.0, options=_SYMMETRIC)
    # SuperLU numbers a natural order anew, along the tree in which columns depend on each other
    moved = np.argsort(factors.perm_c)
    if not np.array_equal(moved[len(inner) :], np.arange(len(inner), n)):
        raise LinearSolverError("the nodes of the interface are not connected through the soil")
    lower = csc_matrix(factors.L)
    lower.sort_indices()
    pointer = (lower.indptr - np.arange(n + 1)).astype(np.int64)  # the first of each column is its diagonal
    row, node = np.delete(lower.indices, lower.indptr[:-1]).astype(np.int32), sequence[moved]
    return Order(node, retained, ~pressures[node], pointer, row)


def _graph(elements: Sequence[np.ndarray], n: int) -> csc_matrix:
    """Return a matrix (n, n) with entries for nodes that share an element; its dominance avoids cancellation."""
    row = np.concatenate([np.repeat(each, each.shape[1], axis=1).ravel() for each in elements])
    column = np.concatenate([np.tile(each, (1, each.shape[1])).ravel() for each in elements])
    pairs = coo_matrix((np.ones(len(row)), (row, column)), shape=(n, n)).tocsc()
    pairs.data[:] = -1.0
    heavy = 2.0 * float(np.diff(pairs.indptr).max())
    return (pairs + heavy * identity(n, format="csc")).tocsc()


@njit
def _assemble(numbers, stiffness, pointer, row, lane, diagonal, lower):
    """Add the stiffnesses (ne, 3 nn, 3 nn) of one harmonic to the blocks on and below the diagonal."""
    for e in range(numbers.shape[0]):
        for a in range(numbers.shape[1]):
            for b in range(numbers.shape[1]):
                i, j = numbers[e, a], numbers[e, b]
                if i < j:
                    continue
                if i == j:
                    for r in range(3):
                        for c in range(3):
                            diagonal[i, r, c, lane] += stiffness[e, 3 * a + r, 3 * b + c]
                    continue
                p = pointer[j] + np.searchsorted(row[pointer[j] : pointer[j + 1]], i)
                for r in range(3):
                    for c in range(3):
                        lower[p, r, c, lane] += stiffness[e, 3 * a + r, 3 * b + c]


@njit
def _factorise(n_eliminated, pointer, row, definite, diagonal, lower, inverse):
    """Eliminate column by column, in place; ``inverse`` gets the inverted pivots. False where one has no such sign."""
    longest = 0
    for j in range(n_eliminated):
        longest = max(longest, pointer[j + 1] - pointer[j])
    column = np.empty((longest, 3, 3, LANES))  # of A, where ``lower`` gets that of L
    for j in range(n_eliminated):
        for k in range(LANES):
            if not _invert(diagonal[j, :, :, k], inverse[j, :, :, k], definite[j]):
                return False
        start, end = pointer[j], pointer[j + 1]
        for p in range(start, end):
            for r in range(3):
                for c in range(3):
                    for k in range(LANES):  # one by one: what Numba has for slices takes seconds to compile
                        column[p - start, r, c, k] = lower[p, r, c, k]
            for r in range(3):
                for c in range(3):
                    for k in range(LANES):
                        total = 0.0
                        for h in range(3):
                            total += column[p - start, r, h, k] * inverse[j, h, c, k]
                        lower[p, r, c, k] = total
        for q in range(start, end):
            target = row[q]
            wide = definite[j] and definite[target]
            _update(lower[q], column[q - start], diagonal[target])
            at = pointer[target]
            for p in range(q + 1, end):
                while row[at] != row[p]:
                    at += 1
                if wide and definite[row[p]]:
                    _update(lower[p], column[q - start], lower[at])
                else:  # a pressure has one row
                    rows, columns, depth = definite[row[p]], definite[target], definite[j]
                    _update_part(lower[p], column[q - start], lower[at], rows, columns, depth)
    return True


@njit
def _update(left, right, out):
    """Subtract left right^T, lane by lane."""
    for r in range(3):
        for c in range(3):
            for k in range(LANES):
                total = left[r, 0, k] * right[c, 0, k] + left[r, 1, k] * right[c, 1, k]
                out[r, c, k] -= total + left[r, 2, k] * right[c, 2, k]


@njit
def _update_part(left, right, out, rows, columns, depth):
    """Subtract left right^T, of the first row, column or product alone where there are not three of them."""
    for r in range(3 if rows else 1):
        for c in range(3 if columns else 1):
            for h in range(3 if depth else 1):
                for k in range(LANES):
                    out[r, c, k] -= left[r, h, k] * right[c, h, k]


@njit
def _invert(a, out, definite):
    """Invert a symmetric 3 x 3 matrix; False where it is not positive definite, or has none but a negative first pivot.

    A pressure that is held has a pivot of 1.
    """
    m00 = a[1, 1] * a[2, 2] - a[1, 2] * a[2, 1]
    m01 = a[0, 2] * a[2, 1] - a[0, 1] * a[2, 2]
    m02 = a[0, 1] * a[1, 2] - a[0, 2] * a[1, 1]
    determinant = a[0, 0] * m00 + a[1, 0] * m01 + a[2, 0] * m02
    minor = a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0]
    if definite or a[0, 0] == 1.0:
        if not (a[0, 0] > 0.0 and minor > 0.0 and determinant > 0.0):
            return False
    elif not (a[0, 0] < 0.0 and minor < 0.0 and determinant < 0.0):
        return False
    d = 1.0 / determinant
    out[0, 0], out[0, 1], out[0, 2] = d * m00, d * m01, d * m02
    out[1, 1], out[2, 2] = d * (a[0, 0] * a[2, 2] - a[0, 2] * a[2, 0]), d * minor
    out[1, 2] = d * (a[0, 2] * a[1, 0] - a[0, 0] * a[1, 2])
    out[1, 0], out[2, 0], out[2, 1] = out[0, 1], out[0, 2], out[1, 2]
    return True


@njit
def _on_the_way(place, n_eliminated, pointer, row):
    """Return whether unknowns (n,) are on the way of those at these places through the eliminated columns."""
    met = np.zeros(len(pointer) - 1, dtype=np.bool_)
    for p in place:
        met[p] = True
    for j in range(n_eliminated):
        if met[j]:
            for p in range(pointer[j], pointer[j + 1]):
                met[row[p]] = True
    return met


@njit
def put(node, place, rhs, lane, first, count, x):
    """Write rows of nodes of rhs (n, 3, K), ``count`` slots from ``first`` on, at their places in the lanes of x."""
    for j in range(len(node)):
        for i in range(3):
            for k in range(count):
                x[place[j], i, lane + k] = rhs[node[j], i, first + k]


@njit
def take(node, place, x, lane, first, count, out):
    """Write rows at these places of x to the nodes of out (n, 3, K): the way back of `put`."""
    for j in range(len(node)):
        for i in range(3):
            for k in range(count):
                out[node[j], i, first + k] = x[place[j], i, lane + k]


@njit
def forward(columns, pointer, row, lower, inverse, x):
    """Solve with L, then with the pivots; lanes are written out: the arrays might share memory."""
    for j in columns:
        u0, u1, u2, u3 = x[j, 0, 0], x[j, 0, 1], x[j, 0, 2], x[j, 0, 3]
        v0, v1, v2, v3 = x[j, 1, 0], x[j, 1, 1], x[j, 1, 2], x[j, 1, 3]
        w0, w1, w2, w3 = x[j, 2, 0], x[j, 2, 1], x[j, 2, 2], x[j, 2, 3]
        for p in range(pointer[j], pointer[j + 1]):
            i = row[p]
            for a in range(3):
                f = lower[p, a]
                t0 = x[i, a, 0] - f[0, 0] * u0 - f[1, 0] * v0 - f[2, 0] * w0
                t1 = x[i, a, 1] - f[0, 1] * u1 - f[1, 1] * v1 - f[2, 1] * w1
                t2 = x[i, a, 2] - f[0, 2] * u2 - f[1, 2] * v2 - f[2, 2] * w2
                t3 = x[i, a, 3] - f[0, 3] * u3 - f[1, 3] * v3 - f[2, 3] * w3
                x[i, a, 0], x[i, a, 1], x[i, a, 2], x[i, a, 3] = t0, t1, t2, t3
        for a in range(3):
            f = inverse[j, a]
            x[j, a, 0] = f[0, 0] * u0 + f[1, 0] * v0 + f[2, 0] * w0
            x[j, a, 1] = f[0, 1] * u1 + f[1, 1] * v1 + f[2, 1] * w1
            x[j, a, 2] = f[0, 2] * u2 + f[1, 2] * v2 + f[2, 2] * w2
            x[j, a, 3] = f[0, 3] * u3 + f[1, 3] * v3 + f[2, 3] * w3


@njit
def backward(columns, pointer, row, lower, x):
    """Solve with the transpose of L, columns backwards; lanes are written out as in `forward`."""
    for j in columns[::-1]:
        u0, u1, u2, u3 = x[j, 0, 0], x[j, 0, 1], x[j, 0, 2], x[j, 0, 3]
        v0, v1, v2, v3 = x[j, 1, 0], x[j, 1, 1], x[j, 1, 2], x[j, 1, 3]
        w0, w1, w2, w3 = x[j, 2, 0], x[j, 2, 1], x[j, 2, 2], x[j, 2, 3]
        for p in range(pointer[j], pointer[j + 1]):
            i = row[p]
            for a in range(3):
                f = lower[p, a]
                t0, t1, t2, t3 = x[i, a, 0], x[i, a, 1], x[i, a, 2], x[i, a, 3]
                u0, u1, u2, u3 = u0 - f[0, 0] * t0, u1 - f[0, 1] * t1, u2 - f[0, 2] * t2, u3 - f[0, 3] * t3
                v0, v1, v2, v3 = v0 - f[1, 0] * t0, v1 - f[1, 1] * t1, v2 - f[1, 2] * t2, v3 - f[1, 3] * t3
                w0, w1, w2, w3 = w0 - f[2, 0] * t0, w1 - f[2, 1] * t1, w2 - f[2, 2] * t2, w3 - f[2, 3] * t3
        x[j, 0, 0], x[j, 0, 1], x[j, 0, 2], x[j, 0, 3] = u0, u1, u2, u3
        x[j, 1, 0], x[j, 1, 1], x[j, 1, 2], x[j, 1, 3] = v0, v1, v2, v3
        x[j, 2, 0], x[j, 2, 1], x[j, 2, 2], x[j, 2, 3] = w0, w1, w2, w3
