# SPDX-License-Identifier: MIT
"""Ridge regression: what the reactions of springs with memory are shared out by."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def ridge_fit(X: Array, Y: Array, weights: Array, ridge: float) -> Array:
    """Return the coefficients (columns of Y, columns of X) of a weighted ridge regression.

    ridge: shrinkage, as a share of the largest singular value of the regressors, each of the size 1.
    """
    size = np.linalg.norm(X * weights[:, None], axis=0)
    size = np.where(size > 0.0, size, 1.0)
    U, s, Vt = np.linalg.svd(X * weights[:, None] / size, full_matrices=False)
    shrunk = s / (s**2 + (ridge * s[0]) ** 2)
    coefficients: Array = ((Vt.T * shrunk) @ (U.T @ (Y * weights[:, None]))).T / size
    return coefficients
