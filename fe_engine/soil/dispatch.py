# SPDX-License-Identifier: MIT
"""Choice of the soil law by its integer code, in one visible chain (keeps numba's cache valid)."""

from __future__ import annotations

from fe_engine.compiled import njit
from fe_engine.conventions import ELASTIC, OK, REGIME_ELASTIC, VAN_EEKELEN
from fe_engine.soil import plasol, van_eekelen
from fe_engine.soil.elastic import add_elastic_stress, elastic_tangent

N_PARAMETERS = plasol.N_PARAMETERS
N_HISTORY = plasol.N_HISTORY
_plasol_update = plasol.update
_van_eekelen_update = van_eekelen.update


@njit
def update_soil(law, p, strain, stress_old, history_old, stress, history, tangent, want_tangent):
    """Advance one Gauss point by a strain increment with the law of the given code.

    Shapes: strain, stress (6,), history (N_HISTORY,), tangent (6, 6). Returns (status, regime).
    """
    if law == ELASTIC:
        for i in range(6):
            stress[i] = stress_old[i]
        add_elastic_stress(p[0], p[1], strain, stress)
        if want_tangent:
            elastic_tangent(p[0], p[1], 1.0, tangent)
        return OK, REGIME_ELASTIC
    if law == VAN_EEKELEN:
        return _van_eekelen_update(p, strain, stress_old, history_old, stress, history, tangent, want_tangent)
    return _plasol_update(p, strain, stress_old, history_old, stress, history, tangent, want_tangent)
