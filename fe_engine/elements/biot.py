# SPDX-License-Identifier: MIT
"""Pore water in a hex8: seepage, storage, coupling and stabilisation (Biot 1941, u-p form).

With the excess pore pressure p (compression positive) on the nodes of the displacement, total stress
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
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fe_engine.elements import hex8


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


Values = float | np.ndarray


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
