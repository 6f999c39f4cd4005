# SPDX-License-Identifier: MIT
"""Rays between those of an atlas, from the potential that loads along rays have nearly.

Along rays of constant direction phi of (u, rotation L) = rho (cos phi, sin phi) the loads (H, M/L) of a soil that flows
associated are close to the gradient of a potential W(rho, phi): radial part F_r = dW/drho, tangential part
F_t = dW/dphi / rho. So each ray has W and its slope in phi, and F_r and its slope d(rho F_t)/drho. Between two rays
both follow A + B cos 2x + C sin 2x + D sin 4x, x from the middle of the gap: exact for a linear response. Reactions by
depth are blended linearly, and changed in proportion to their size as far as H and M ask for.

What the interpolation misses is seen where a ray is left out. By the third power of the angle between the rays it is
added to the new rays; its size counts as their standard deviation.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
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

    Parameters
    ----------
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
    pure = [int(np.argmax((action == each).all(axis=1))) for each in ((1.0, 0.0),)]
    moment = int(np.argmax((action[:, 0] == 0.0) & (action[:, 1] != 0.0)))
    out[0, pure[0]], out[1, moment] = correction[0], correction[1] / action[moment, 1]
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
