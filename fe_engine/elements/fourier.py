# SPDX-License-Identifier: MIT
"""Eight-node serendipity elements in (r, z), with Fourier series in azimuth over half a revolution, or a whole one.

    u_r = sum_k U_k cos(k theta),   u_theta = sum_k V_k sin(k theta),   u_z = sum_k W_k cos(k theta),   k = 0 .. N

Over a whole revolution u_theta of k = 0 is a constant V_0 (torsion), and behind these N + 1 slots stand N of the other
family, cos(k theta - pi/2) and sin(k theta - pi/2): sin, -cos, sin of k theta, k = 1 .. N. Either family has the same
strain operator and elastic stiffness. K is the number of slots, N + 1 or 2 N + 1.

Cylindrical axes (r, theta, z), z down, take the places of x, y, z in vectors and in Voigt order (rr tt zz rt tz zr).
The strains of a harmonic have amplitudes E_k (6,); the shears rt and tz go with sin(k theta), the others with
cos(k theta). Two by two Gauss points do not integrate the 1/r terms exactly; no point lies on the axis.

Node order: the corners (-1, -1), (1, -1), (1, 1), (-1, 1), then the middles of the sides that begin at them.
"""

from __future__ import annotations

import numpy as np

from fe_engine.compiled import lean

N_NODES, N_POINTS = 8, 4
LOCAL = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [0, -1], [1, 0], [0, 1], [-1, 0]], dtype=float)
GAUSS = LOCAL[:4] / np.sqrt(3.0)


def shape(xi: float, eta: float) -> np.ndarray:
    """Return the shape functions (8,) at a local point."""
    a, b = LOCAL[:4, 0], LOCAL[:4, 1]
    corner = 0.25 * (1.0 + a * xi) * (1.0 + b * eta) * (a * xi + b * eta - 1.0)
    along, across = 1.0 - xi * xi, 1.0 - eta * eta
    middle = [along * (1.0 - eta), across * (1.0 + xi), along * (1.0 + eta), across * (1.0 - xi)]
    return np.concatenate([corner, 0.5 * np.array(middle)])


def shape_gradient(xi: float, eta: float) -> np.ndarray:
    """Return the derivatives (8, 2) of the shape functions with respect to (xi, eta)."""
    a, b = LOCAL[:4, 0], LOCAL[:4, 1]
    corner = np.stack(
        [0.25 * a * (1.0 + b * eta) * (2.0 * a * xi + b * eta), 0.25 * b * (1.0 + a * xi) * (a * xi + 2.0 * b * eta)],
        axis=1,
    )
    along, across = 0.5 * (1.0 - xi * xi), 0.5 * (1.0 - eta * eta)
    middle = [
        [-xi * (1.0 - eta), -along], [across, -eta * (1.0 + xi)],
        [-xi * (1.0 + eta), along], [-across, -eta * (1.0 - xi)],
    ]  # fmt: skip
    return np.concatenate([corner, np.array(middle)])


def geometry(nodes: np.ndarray, quads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return what strains need, for nodes (n, 2) in (r, z) and elements (ne, 8).

    gradient : (ne, 4, 3, 8), of each Gauss point dN/dr, dN/dz and N/r in 1/m; volume : (ne, 4) m3 per radian.
    """
    corner = nodes[quads]
    gradient, volume = np.empty((len(quads), N_POINTS, 3, N_NODES)), np.empty((len(quads), N_POINTS))
    for g, (xi, eta) in enumerate(GAUSS):
        local, value = shape_gradient(xi, eta), shape(xi, eta)
        jacobian = np.einsum("ai,eaj->eij", local, corner)
        radius = corner[:, :, 0] @ value
        gradient[:, g, :2] = np.einsum("eji,ai->eja", np.linalg.inv(jacobian), local)
        gradient[:, g, 2] = value / radius[:, None]  # no point lies on the axis
        volume[:, g] = radius * np.linalg.det(jacobian)  # r dr dz
    return gradient, volume


def gauss_positions(nodes: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Return r and z (ne, 4, 2) of the Gauss points, m."""
    values = np.array([shape(xi, eta) for xi, eta in GAUSS])
    return np.einsum("ga,eai->egi", values, nodes[quads])


def span(whole: bool) -> float:
    """Return the angle of the revolution that a series goes through, rad."""
    return 2.0 * np.pi if whole else np.pi


def azimuths(number: int, whole: bool = False) -> np.ndarray:
    """Return equidistant azimuths (number,) of the half circle, the middles of its parts; the weight is pi/number.

    Their sums integrate products of two harmonics exactly as long as the sum of their numbers is below 2 number; those
    of the whole circle, with the weight 2 pi/number, as long as it is below number.
    """
    return (np.arange(number) + 0.5) * span(whole) / number


def numbers(harmonics: int, whole: bool = False) -> np.ndarray:
    """Return the number k (K,) of each slot."""
    k = np.arange(harmonics + 1)
    return np.concatenate([k, k[1:]]) if whole else k


def waves(angle: np.ndarray, harmonics: int, whole: bool = False) -> np.ndarray:
    """Return cos and sin (len(angle), K, 2) of k times each angle, as they stand in u_r and u_theta."""
    product = np.multiply.outer(np.asarray(angle, dtype=float), np.arange(harmonics + 1))
    wave = np.stack([np.cos(product), np.sin(product)], axis=-1)
    if not whole:
        return wave
    wave[:, 0, 1] = 1.0  # torsion
    return np.concatenate([wave, wave[:, 1:, ::-1] * [1.0, -1.0]], axis=1)


def strain_operator(gradient: np.ndarray, k: int) -> np.ndarray:
    """Return E_k (..., 6, 24) from the coefficients of harmonic k, three a node, for gradients (..., 3, 8)."""
    d_r, d_z, over_r = (gradient[..., i, :] for i in range(3))
    b = np.zeros((*gradient.shape[:-2], 6, 3 * N_NODES))
    # rr = du_r/dr;  tt = u_r/r + (du_theta/dtheta)/r;  zz = du_z/dz
    b[..., 0, 0::3], b[..., 1, 0::3], b[..., 1, 1::3], b[..., 2, 2::3] = d_r, over_r, k * over_r, d_z
    # rt = (du_r/dtheta)/r + du_theta/dr - u_theta/r, over sin(k theta)
    b[..., 3, 0::3], b[..., 3, 1::3] = -k * over_r, d_r - over_r
    b[..., 4, 1::3], b[..., 4, 2::3] = d_z, -k * over_r  # tz = du_theta/dz + (du_z/dtheta)/r, over sin(k theta)
    b[..., 5, 0::3], b[..., 5, 2::3] = d_z, d_r  # zr = du_r/dz + du_z/dr
    return b


def stiffness(gradient: np.ndarray, volume: np.ndarray, tangent: np.ndarray, k: int, whole: bool = False) -> np.ndarray:
    """Return the stiffnesses (ne, 24, 24) of harmonic k for isotropic tangents (ne, 4, 6, 6), Pa."""
    b = strain_operator(gradient, k)
    # int cos^2 and int sin^2 of k theta; V_0 is constant
    cosine, sine = (1.0, float(whole)) if k == 0 else (0.5, 0.5)
    weight = span(whole) * np.array([cosine, cosine, cosine, sine, sine, cosine])
    by_harmonic: np.ndarray = np.einsum("egir,i,egij,egjs,eg->ers", b, weight, tangent, b, volume, optimize=True)
    return by_harmonic


@lean
def amplitudes(gradient, move, numbers, out):
    """Write the strain amplitudes (K, 6) of coefficients (8, 3, K) of slots (K,) at a point with gradient (3, 8)."""
    for m in range(move.shape[2]):
        k = numbers[m]
        r_r, r_z, r_h, t_r, t_z, t_h, z_r, z_z, z_h = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for a in range(8):
            d_r, d_z, h = gradient[0, a], gradient[1, a], gradient[2, a]
            u, v, w = move[a, 0, m], move[a, 1, m], move[a, 2, m]
            r_r += d_r * u
            r_z += d_z * u
            r_h += h * u
            t_r += d_r * v
            t_z += d_z * v
            t_h += h * v
            z_r += d_r * w
            z_z += d_z * w
            z_h += h * w
        out[m, 0] = r_r
        out[m, 1] = r_h + k * t_h  # see strain_operator
        out[m, 2] = z_z
        out[m, 3] = t_r - t_h - k * r_h
        out[m, 4] = t_z - k * z_h
        out[m, 5] = r_z + z_r


@lean
def add_force(gradient, amplitude, numbers, nodes, force):
    """Add the forces (n, 3, K) of stress amplitudes (K, 6) on the nodes (8,): the transpose of `amplitudes`."""
    for m in range(amplitude.shape[0]):
        k, s = numbers[m], amplitude[m]
        radial, around, vertical = s[1] - k * s[3], k * s[1] - s[3], -k * s[4]  # what the rows of N/r collect
        for a in range(8):
            d_r, d_z, h, n = gradient[0, a], gradient[1, a], gradient[2, a], nodes[a]
            force[n, 0, m] += d_r * s[0] + h * radial + d_z * s[5]
            force[n, 1, m] += d_r * s[3] + h * around + d_z * s[4]
            force[n, 2, m] += d_r * s[5] + h * vertical + d_z * s[2]


@lean
def strain_at(amplitude, wave, out):
    """Write the strain (6,) at an azimuth with waves (K, 2) from amplitudes (K, 6); sums are numbers, for vectors."""
    rr, tt, zz, rt, tz, zr = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(amplitude.shape[0]):
        c, s = wave[k, 0], wave[k, 1]
        rr += c * amplitude[k, 0]
        tt += c * amplitude[k, 1]
        zz += c * amplitude[k, 2]
        rt += s * amplitude[k, 3]
        tz += s * amplitude[k, 4]
        zr += c * amplitude[k, 5]
    out[0], out[1], out[2], out[3], out[4], out[5] = rr, tt, zz, rt, tz, zr


@lean
def add_amplitudes(stress, wave, weight, out):
    """Add weight times a stress (6,) at an azimuth to the stress amplitudes (K, 6); the transpose of `strain_at`."""
    rr, tt, zz, rt, tz, zr = stress[0], stress[1], stress[2], stress[3], stress[4], stress[5]
    for k in range(out.shape[0]):
        c, s = weight * wave[k, 0], weight * wave[k, 1]
        # all are read before any is written: the compiler must assume that the arrays share memory
        a, b, d = out[k, 0] + c * rr, out[k, 1] + c * tt, out[k, 2] + c * zz
        e, f, g = out[k, 3] + s * rt, out[k, 4] + s * tz, out[k, 5] + c * zr
        out[k, 0], out[k, 1], out[k, 2], out[k, 3], out[k, 4], out[k, 5] = a, b, d, e, f, g
