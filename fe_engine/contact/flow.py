# SPDX-License-Identifier: MIT
"""Flow of water in the interface (Cerfontaine, Charlier & Collin 2018, Eqs. 5-10).

Three pressures: p1 in the soil on side 1, p3 in the film, p2 on side 2. With the aperture h the film obeys

    dh/dt + div_s( -h^3/(12 mu_w) grad_s p3 ) = T_w (p1 - p3) - T_w (p3 - p2)

(the cubic law k_l = h^2/12 carried over the aperture h; T_w the transversal conductivity of each side). A closed
interface has the residual aperture h = D_0, which lets water along but stores none; an open one h = D_0 + g_N. A rigid
impervious side 2 takes no water, and its pressure does not exist.
"""

from __future__ import annotations

from fe_engine.compiled import lean


@lean
def transmissivity(residual_aperture, gap, viscosity):
    """Return the h^3/(12 mu_w) in m3/(Pa s), and its derivative with respect to an open gap."""
    h = residual_aperture + gap
    # Eq. 10, k_l = h^2/12, over the aperture h
    return h * h * h / (12.0 * viscosity), (h * h / (4.0 * viscosity) if gap > 0.0 else 0.0)


@lean
def exchange(transfer, second, pressures, gap_old, gap):
    """Return volumes by area over a time step, m: from side 1 into the film, on to side 2, and stored in the gap.

    transfer, second : conductivities T_w of side 1 and side 2 times the time step; pressures : (p1, p3, p2).
    """
    p1, p3, p2 = pressures
    return transfer * (p1 - p3), second * (p3 - p2), gap - gap_old  # Eqs. 6, 7 and 9, over dt and rho_w
