# SPDX-License-Identifier: MIT
"""Work done in hexahedra of soil in a step, in one compiled loop."""

from __future__ import annotations

import numpy as np

from fe_engine.assembly.kernels import gather
from fe_engine.compiled import njit
from fe_engine.elements.hex8 import strain_at
from fe_engine.soil.elastic import stored_density
from fe_engine.soil.plasol import BULK, SHEAR


@njit
def hex_work(hexes, geometry, material, parameters, frames, old, new, initial_stress):
    """Return (stored, dissipated, initial) work of a step in J; ``old`` and ``new`` are (displacement, stress)."""
    gradient, mean_gradient, volume = geometry
    stored, dissipated, initial = 0.0, 0.0, 0.0
    move, strain = np.empty((8, 3)), np.empty(6)
    for e in range(hexes.shape[0]):
        p = parameters[material[e]]
        gather(hexes[e], new[0], old[0], frames, move)
        for g in range(8):
            strain_at(gradient[e, g], mean_gradient[e], move, strain)
            done, begun = 0.0, 0.0
            for i in range(6):
                done += 0.5 * (old[1][e, g, i] + new[1][e, g, i]) * strain[i]
                begun += initial_stress[e, g, i] * strain[i]
            kept = stored_density(p[BULK], p[SHEAR], new[1][e, g]) - stored_density(p[BULK], p[SHEAR], old[1][e, g])
            stored += volume[e, g] * kept
            dissipated += volume[e, g] * (done - kept)
            initial += volume[e, g] * begun
    return stored, dissipated, initial
