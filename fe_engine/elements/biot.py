# SPDX-License-Identifier: MIT
"""Pore water of elements: seepage, storage, coupling and stabilisation (Biot 1941, u-p form).

Bricks. With the excess pore pressure p (compression positive) on the nodes of the displacement, total stress
sigma = sigma' - p I, and theta the mean volumetric strain of the element (the same B-bar as in hex8),

    force of the water on node a      f_a = -mean(grad N_a) int p dV
    water that leaves node a          V_a dtheta + (S M + T)_ab dp_b + dt H_ab p_b = 0       (backward Euler)

    V_a = int N_a dV,  M_ab = int N_a N_b dV,  H_ab = int (k/gamma_w) grad N_a . grad N_b dV

Force and volume change are transposes of each other. T is the polynomial pressure projection
(Dohrmann & Bochev 2004; White & Borja 2008)

    T_ab = tau int (N_a - mean N_a) (N_b - mean N_b) dV,   tau = max(1/(2G), 3/(K + 4G/3)),

which the equal order of displacement and pressure needs where k dt tends to 0: theta sees the element's mean pressure
only, and T holds what it does not see. T is zero for a pressure that is constant in the element. The second value of
tau is ours: in a column (modulus M = K + 4G/3) the undrained matrix of the pressures is that of the means,
(1 2 1)/(4M), plus tau (-1 2 -1)/12; from tau = 3/M on it has no positive off-diagonal, and pressures cannot overshoot.

Series. Pressures p = sum_k P_k cos(k theta), k = 0 .. N, are linear between the corners of the quadratic elements of
`elements.fourier` (Taylor & Hood 1973), so that no stabilisation is needed. With the amplitudes E_k of the strain and
the bilinear functions L_a of the corners, harmonic by harmonic,

    force of the water       f = -Q P,   Q = c int (E_rr + E_tt + E_zz) L_a r dr dz
    water that leaves a      Q^T du + S M dP + dt H P = 0,   M = c int L_a L_b r dr dz       (backward Euler)
    H = (k/gamma_w) int (c L_a,r L_b,r + c L_a,z L_b,z + s k^2 L_a L_b/r^2) r dr dz

over half a revolution: c = pi, s = 0 for k = 0, else c = s = pi/2. Pressures of k >= 1 vanish on the axis. Over a whole
revolution c and s are twice as large, and the other family, p = sum P_k sin(k theta), has the same matrices.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fe_engine.elements import fourier, hex8, interface

N_CORNERS = 4  # of an element of the section: they have the pressures
Values = float | np.ndarray


@dataclass(frozen=True)
class Pores:
    """Constant matrices of the elements.

    seepage : (ne, 8, 8) H in m3/(Pa s); storage : (ne, 8, 8) S M + T in m3/Pa; compression : (ne, 8, 8) S M alone;
    volume : (ne, 8) V_a in m3; coupling : (ne, 8, 3) mean gradients in the nodal axes, 1/m.
    """

    seepage: np.ndarray
    storage: np.ndarray
    compression: np.ndarray
    volume: np.ndarray
    coupling: np.ndarray

    @property
    def arrays(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """What the compiled loops need: seepage, storage, volume, coupling."""
        return self.seepage, self.storage, self.volume, self.coupling

    def only(self, wet: np.ndarray | None) -> Pores:
        """Return the matrices with zeros for elements without water; ``wet`` (ne,) bool, None: all hold water."""
        if wet is None:
            return self
        parts = self.seepage, self.storage, self.compression, self.volume, self.coupling
        return Pores(*(part * wet.reshape(-1, *[1] * (part.ndim - 1)) for part in parts))


def projection_factor(bulk: np.ndarray, shear: np.ndarray) -> np.ndarray:
    """Return the factor tau of the pressure projection in 1/Pa, from the elastic moduli (...,) of the soil in Pa."""
    return np.asarray(np.maximum(0.5 / shear, 3.0 / (bulk + 4.0 * shear / 3.0)))  # White & Borja 2008, and ours


def make_pores(
    gradient: np.ndarray, volume: np.ndarray, coupling: np.ndarray, mobility: Values, storage: float, tau: Values
) -> Pores:
    """Integrate the matrices.

    Parameters
    ----------
    gradient, volume : of hex8.geometry.
    coupling : (ne, 8, 3) mean gradients in the nodal axes.
    mobility : k/gamma_w in m2/(Pa s), one value or (ne,); storage : S in 1/Pa; tau : 1/Pa, one value or (ne,).
    """
    n = hex8.GAUSS_SHAPES
    nodal = np.einsum("eg,ga->ea", volume, n)  # V_a
    mass = np.einsum("eg,ga,gb->eab", volume, n, n)  # M_ab
    # T/tau: mean N_a = V_a/V (Dohrmann & Bochev 2004)
    projection = mass - nodal[:, :, None] * nodal[:, None, :] / volume.sum(axis=1)[:, None, None]
    mobility, tau = (np.reshape(each, (-1, 1, 1)) for each in (mobility, tau))
    seepage = mobility * np.einsum("eg,egai,egbi->eab", volume, gradient, gradient, optimize=True)  # H_ab, Darcy
    return Pores(seepage, storage * mass + tau * projection, storage * mass, nodal, coupling)


@dataclass(frozen=True)
class PoreMatrices:
    """Matrices of the elements, for the K slots of a series.

    coupling : (K, ne, 24, 4) Q in m2; seepage : (K, ne, 4, 4) H in m3/(Pa s); storage : (K, ne, 4, 4) S M in m3/Pa.
    """

    coupling: np.ndarray
    seepage: np.ndarray
    storage: np.ndarray

    def only(self, wet: np.ndarray | None) -> PoreMatrices:
        """Return the matrices with zeros for elements without water; ``wet`` (ne,) bool, None: all hold water."""
        if wet is None:
            return self
        return PoreMatrices(*(part * wet[:, None, None] for part in (self.coupling, self.seepage, self.storage)))


def corner_gradients(nodes: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Return the gradients (ne, 4 Gauss points, 2, 4 corners) of the bilinear functions along r and z, 1/m."""
    slopes = np.empty((len(quads), fourier.N_POINTS, 2, N_CORNERS))
    for g, point in enumerate(fourier.GAUSS):
        jacobian = np.einsum("ai,eaj->eij", fourier.shape_gradient(*point), nodes[quads])
        slopes[:, g] = np.einsum("eji,ai->eja", np.linalg.inv(jacobian), interface.shape_gradient(*point))
    return slopes


def pore_matrices(
    nodes: np.ndarray, quads: np.ndarray, harmonics: int, mobility: Values, storage: float, whole: bool = False
) -> PoreMatrices:
    """Integrate the matrices; over the whole circle they are twice those over half of it, and those of both families.

    Parameters
    ----------
    nodes : (n, 2) r and z in m; quads : (ne, 8).
    mobility : k/gamma_w in m2/(Pa s), one value or (ne,); storage : S in 1/Pa.
    """
    gradient, volume = fourier.geometry(nodes, quads)
    value, slope = interface.GAUSS_SHAPES, corner_gradients(nodes, quads)
    radius = fourier.gauss_positions(nodes, quads)[..., 0]
    along = np.einsum("eg,egia,egib->eab", volume, slope, slope, optimize=True)
    mass = np.einsum("eg,ga,gb->eab", volume, value, value)
    around = np.einsum("eg,ga,gb->eab", volume / radius**2, value, value)
    coupling, seepage, stored = [], [], []
    angle = fourier.span(whole)
    for k in range(harmonics + 1):
        c, s = (angle, 0.0) if k == 0 else (0.5 * angle, 0.5 * angle)  # int cos^2 and int sin^2 of k theta
        swelling = fourier.strain_operator(gradient, k)[..., :3, :].sum(axis=-2)  # E_rr + E_tt + E_zz
        coupling.append(c * np.einsum("eg,egr,ga->era", volume, swelling, value, optimize=True))  # Q
        # H, Darcy along r, z and theta
        seepage.append(np.reshape(mobility, (-1, 1, 1)) * (c * along + s * k * k * around))
        stored.append(storage * c * mass)  # S M
    slots = fourier.numbers(harmonics, whole)
    return PoreMatrices(*(np.array(each)[slots] for each in (coupling, seepage, stored)))
