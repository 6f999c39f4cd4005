# SPDX-License-Identifier: MIT
"""Compiled loops over the rows of a sparse matrix, on the cores that there are.

Each row is summed in the order of its entries, whatever the number of threads.
"""

from __future__ import annotations

import numba as nb
import numpy as np
from scipy.sparse import csr_matrix

from fe_engine.compiled import njit


def times(matrix: csr_matrix, vector: np.ndarray) -> np.ndarray:
    """Return the product (n,) of a matrix (n, n) and a vector (n,): SciPy's has one thread, and waits for memory."""
    out = np.empty(matrix.shape[0])
    _times(matrix.data, matrix.indices, matrix.indptr, vector, out)
    return out


def scaled_entries(matrix: csr_matrix, scale: np.ndarray, kind: type = np.float64) -> np.ndarray:
    """Return entries (nnz,) of D A D in the precision ``kind``, with D (n,) on the diagonal; on the pattern of A."""
    out = np.empty(matrix.nnz, dtype=kind)
    _scaled_entries(matrix.data, matrix.indices, matrix.indptr, scale, out)
    return out


@njit(parallel=True)
def _times(data, indices, indptr, vector, out):
    for row in nb.prange(len(out)):
        total = 0.0
        for k in range(indptr[row], indptr[row + 1]):
            total += data[k] * vector[indices[k]]
        out[row] = total


@njit(parallel=True)
def _scaled_entries(data, indices, indptr, scale, out):
    for row in nb.prange(len(indptr) - 1):
        for k in range(indptr[row], indptr[row + 1]):
            out[k] = scale[row] * data[k] * scale[indices[k]]
