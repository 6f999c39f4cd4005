# SPDX-License-Identifier: MIT
"""Gaussian processes of an atlas: fitted with scikit-learn, evaluated with NumPy alone.

Kernel: s^2 (1 + r sqrt(5) + 5 r^2/3) exp(-r sqrt(5)) (Matern 5/2; Rasmussen & Williams 2006, equation 4.17) over the
inputs divided by a length each, and a noise: meshes of two caissons differ in their slices.
"""

import warnings
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_LENGTHS = (0.25, 50.0)
_NOISE = (1e-6, 0.1)


@dataclass(frozen=True, eq=False)
class Process:
    """A Gaussian process of values (n,) at points (n, d), all between 0 and 1.

    Attributes
    ----------
    points, values : what is known.
    mean, size : of the values; the process is that of (values - mean)/size.
    variance, lengths, noise : of the kernel.
    """

    points: Array
    values: Array
    mean: float
    size: float
    variance: float
    lengths: Array
    noise: float

    @cached_property
    def inverse(self) -> Array:
        """Inverse of the covariance of what is known."""
        matrix = self._covariance(self.points) + self.noise * np.eye(len(self.points))
        return np.asarray(np.linalg.inv(matrix))

    @cached_property
    def weights(self) -> Array:
        """Weights (n,) of the known points in a mean."""
        return np.asarray(self.inverse @ ((self.values - self.mean) / self.size))

    def _covariance(self, points: Array) -> Array:
        way = (points[:, None, :] - self.points[None, :, :]) / self.lengths
        r = np.sqrt(5.0 * (way**2).sum(axis=2))
        return np.asarray(self.variance * (1.0 + r + r**2 / 3.0) * np.exp(-r))

    def at(self, point: Array) -> tuple[float, float]:
        """Return mean and standard deviation of a new full model at a point (d,), its noise included."""
        near = self._covariance(point[None, :])[0]
        left = self.variance + self.noise - near @ self.inverse @ near
        return self.mean + self.size * float(near @ self.weights), self.size * float(np.sqrt(max(left, 0.0)))

    def left_out(self) -> tuple[Array, Array]:
        """Return mean and standard deviation (n,) at every known point from all others, with the same kernel.

        Rasmussen & Williams (2006), equations 5.12.
        """
        diagonal = np.diag(self.inverse)
        return self.values - self.size * self.weights / diagonal, self.size / np.sqrt(diagonal)


def fit(points: Array, values: Array, seed: int = 0) -> Process:
    """Return the process with the kernel of the largest likelihood."""
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

    mean, size = float(values.mean()), float(values.std()) or 1.0
    kernel = ConstantKernel(10.0, (1e-2, 1e5)) * Matern(np.ones(points.shape[1]), _LENGTHS, nu=2.5)
    model = GaussianProcessRegressor(kernel + WhiteKernel(1e-3, _NOISE), n_restarts_optimizer=1, random_state=seed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a length at its bound: the input does not matter
        model.fit(points, (values - mean) / size)
    product, noise = model.kernel_.k1, model.kernel_.k2
    lengths = np.broadcast_to(product.k2.length_scale, points.shape[1]).astype(float)
    return Process(points, values, mean, size, float(product.k1.constant_value), lengths, float(noise.noise_level))


def filled(points: Array, values: Array) -> Array:
    """Return values (n, m) with rows that are missing (NaN) estimated from the others, column by column.

    One smooth process for all columns: what a case did not reach is that of its neighbours. Columns need some known
    row each.
    """
    out = values.copy()
    way = points[:, None, :] - points[None, :, :]
    covariance = 30.0 * np.exp(-0.5 * ((way / 2.0) ** 2).sum(axis=2))
    known = np.isfinite(values)
    patterns, which = np.unique(known.T, axis=0, return_inverse=True)
    for number, there in enumerate(patterns):
        if there.all():
            continue
        columns = np.flatnonzero(which.ravel() == number)
        own = values[np.ix_(there, columns)]
        matrix = covariance[np.ix_(there, there)] + 1e-4 * np.eye(int(there.sum()))
        mean = own.mean(axis=0)
        out[np.ix_(~there, columns)] = mean + covariance[np.ix_(~there, there)] @ np.linalg.solve(matrix, own - mean)
    return out
