# SPDX-License-Identifier: MIT
"""Rays between those of an atlas, from the potential that loads along rays have nearly.

Along rays of constant direction phi of (u, rotation L) = rho (cos phi, sin phi) the loads (H, M/L) of a soil that flows
associated are close to the gradient of a potential W(rho, phi): radial part F_r = dW/drho, tangential part
F_t = dW/dphi / rho. So each ray has W and its slope in phi, and F_r and its slope d(rho F_t)/drho. Between two rays
both follow A + B cos 2x + C sin 2x + D sin 4x, x from the middle of the gap: exact for a linear response. Reactions by
depth are blended linearly, and changed in proportion to their size as far as H and M ask for.

What the interpolation misses is seen where a ray is left out. By the third power of the angle between the rays it is
added to the new rays; its size counts as their standard deviation.

Gaussian processes of an atlas are fitted with scikit-learn, and evaluated with NumPy alone. Kernel:
s^2 (1 + r sqrt(5) + 5 r^2/3) exp(-r sqrt(5)) (Matern 5/2; Rasmussen & Williams 2006, equation 4.17) over the inputs
divided by a length each, and a noise: meshes of two caissons differ in their slices.
"""

import warnings
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from pysprings.core.arrays import Array

_LENGTHS = (0.25, 50.0)
_NOISE = (1e-6, 0.1)


@dataclass(frozen=True, eq=False)
class Process:
    """A Gaussian process of values (n,) at points (n, d), all between 0 and 1.

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
    with warnings.catch_warnings(action="ignore"):  # a length at its bound: the input does not matter
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


WIDEST = np.radians(35.0)  # between two rays that get others in between
PARTS = 3


@dataclass(frozen=True)
class _Ray:
    """A ray, or its mirror image: angle, number and sign; rows (row, knot), loads (2, knot), motions (knot,)."""

    angle: float
    number: int
    sign: float
    rows: Array
    loads: Array
    rho: Array

    @cached_property
    def potential(self) -> tuple[Array, Array, Array, Array]:
        """W and its slope in phi, F_r and its slope in phi, by knot."""
        from scipy.interpolate import PchipInterpolator

        direction = np.array([np.cos(self.angle), np.sin(self.angle)])
        radial = direction @ self.loads
        turning = self.rho * (np.array([-direction[1], direction[0]]) @ self.loads)
        W = PchipInterpolator(self.rho, radial).antiderivative()(self.rho)
        return W, turning, radial, PchipInterpolator(self.rho, turning).derivative()(self.rho)


def between(rows: Array, modes: Array, action: Array, angles: Array, rho: Array) -> tuple[Array, Array, Array]:
    """Return rows (ray, row, knot), modes (m + 2, ray, row, knot) and angles with new rays in every narrow gap.

    The last two modes are the corrections of H (at the lid, row `action` (1, 0)) and M of the new rays: their size is
    what is not known of them.

    action : (row, 2) share of a row in (H, M/L).
    rho : (knot,) 0 first.
    """
    order = np.argsort(angles)
    rows, angles = rows[order], angles[order]
    modes = np.concatenate([modes[:, order], np.zeros((2, *rows.shape))])
    n = angles.size
    rays = [_Ray(float(angles[k]), k, 1.0, rows[k], action.T @ rows[k], rho) for k in range(n)]
    last = rays[-1]
    rays = [_Ray(last.angle - np.pi, n - 1, -1.0, -last.rows, -last.loads, rho), *rays]
    errors = _errors(rays)
    new: list[tuple[Array, Array, float]] = []
    for k, (low, high) in enumerate(pairwise(rays)):
        gap = high.angle - low.angle
        for t in np.arange(1, PARTS) / PARTS if gap <= WIDEST else ():
            angle = low.angle + gap * float(t)
            correction = _correction(errors[k], errors[k + 1], gap, float(t), rho.size)
            blend = _stencil(angle, low.angle, high.angle)
            row = blend[0] * low.rows + blend[1] * high.rows
            mode = blend[0] * low.sign * modes[:, low.number] + blend[1] * high.sign * modes[:, high.number]
            mode[-2:] = _unknown(correction, action)
            loads = _loads(angle, (low, high)) + correction
            new.append((_summing(row, action, loads), mode, angle))
    if not new:
        return rows, modes, angles
    whole = np.concatenate([angles, [angle for *_, angle in new]])
    order = np.argsort(whole)
    return (
        np.concatenate([rows, np.stack([row for row, *_ in new])])[order],
        np.concatenate([modes, np.stack([mode for _, mode, _ in new], axis=1)], axis=1)[:, order], whole[order],
    )  # fmt: skip


def _errors(rays: list[_Ray]) -> list[tuple[Array, float] | None]:
    """Return what the interpolation misses at every ray from those beside it (2, knot), and their angle apart."""
    found: list[tuple[Array, float] | None] = [None]
    for low, ray, high in zip(rays, rays[1:], rays[2:], strict=False):
        wide = max(ray.angle - low.angle, high.angle - ray.angle) > WIDEST
        missed = None if wide else ray.loads - _loads(ray.angle, (low, high))
        found.append(None if missed is None else (missed, high.angle - low.angle))
    return [*found, None]


def _correction(
    low: tuple[Array, float] | None, high: tuple[Array, float] | None, gap: float, t: float, knots: int
) -> Array:
    """Return the correction (2, knot) at a place t of a gap: errors at its ends, by the third power of the angles."""
    known = [each for each in (low, high) if each is not None]
    if not known:
        return np.zeros((2, knots))
    size = np.mean([missed * (gap / apart) ** 3 for missed, apart in known], axis=0)
    return np.asarray(16.0 * t**2 * (1.0 - t) ** 2 * size)


def _unknown(correction: Array, action: Array) -> Array:
    """Return two modes (2, row, knot): the sizes of the corrections of H and of M."""
    out = np.zeros((2, len(action), correction.shape[1]))
    force = int(np.argmax((action == [1.0, 0.0]).all(axis=1)))
    moment = int(np.argmax((action[:, 0] == 0.0) & (action[:, 1] != 0.0)))
    out[0, force], out[1, moment] = correction[0], correction[1] / action[moment, 1]
    return out


def _stencil(angle: float, low: float, high: float) -> tuple[float, float]:
    """Return the shares of two rays in a direction between them: exact for a linear response."""
    size = np.sin(high - low)
    return float(np.sin(high - angle) / size), float(np.sin(angle - low) / size)


def _loads(angle: float, ends: tuple[_Ray, _Ray]) -> Array:
    """Return (H, M/L) (2, knot) of a ray between two others."""
    half = 0.5 * (ends[1].angle - ends[0].angle)
    x = angle - 0.5 * (ends[0].angle + ends[1].angle)
    (W0, S0, F0, G0), (W1, S1, F1, G1) = (ray.potential for ray in ends)
    radial, _ = _harmonic(x, half, (F0, G0), (F1, G1))
    _, slope = _harmonic(x, half, (W0, S0), (W1, S1))
    rho = ends[0].rho
    tangential = np.divide(slope, rho, out=np.zeros_like(slope), where=rho > 0.0)
    along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    return np.asarray(np.outer(along, radial) + np.outer(across, tangential))


def _harmonic(x: float, half: float, low: tuple[Array, Array], high: tuple[Array, Array]) -> tuple[Array, Array]:
    """Return A + B cos 2x + C sin 2x + D sin 4x and its slope, with values and slopes given at x = -half and half."""
    (value0, slope0), (value1, slope1) = low, high
    c2, s2, c4, s4 = (f(k * half) for k in (2.0, 4.0) for f in (np.cos, np.sin))
    B = -0.5 * (slope1 - slope0) / (2.0 * s2)
    A = 0.5 * (value0 + value1) - B * c2
    odd, turn = 0.5 * (value1 - value0), 0.5 * (slope0 + slope1)
    D = (turn * s2 - 2.0 * c2 * odd) / (4.0 * c4 * s2 - 2.0 * c2 * s4)
    C = (odd - D * s4) / s2
    value = A + B * np.cos(2 * x) + C * np.sin(2 * x) + D * np.sin(4 * x)
    return value, -2.0 * B * np.sin(2 * x) + 2.0 * C * np.cos(2 * x) + 4.0 * D * np.cos(4 * x)


def _summing(rows: Array, action: Array, loads: Array) -> Array:
    """Return rows (row, knot) changed in proportion to their size such that action.T @ rows = loads (2, knot)."""
    size = np.abs(rows)
    missing = loads - action.T @ rows
    response = np.einsum("rk,ra,rb->kab", size, action, action)
    multiplier = np.einsum("kab,bk->ak", np.linalg.pinv(response, hermitian=True), missing)
    return np.asarray(rows + size * (action @ multiplier))
