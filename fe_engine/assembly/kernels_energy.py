# SPDX-License-Identifier: MIT
"""Work done in hexahedra of soil in a step, in one compiled loop."""

from __future__ import annotations

import numpy as np

from fe_engine.assembly.kernels import gather, row_of
from fe_engine.compiled import njit
from fe_engine.elements.hex8 import strain_at
from fe_engine.soil.elastic import stored_density


@njit
def hex_work(elements, old, new):
    """Return (stored, dissipated, initial) work of a step in J; ``old`` and ``new`` are SoilState."""
    stored, dissipated, initial = 0.0, 0.0, 0.0
    move, strain = np.empty((8, 3)), np.empty(6)
    for e in range(elements.hexes.shape[0]):
        gather(elements.hexes[e], new.displacement, old.displacement, elements.frame_of, elements.frames, move)
        for g in range(8):
            row = row_of(elements.moduli, g)
            bulk, shear = elements.moduli[e, row, 0], elements.moduli[e, row, 1]
            strain_at(elements.gradient[e, g], elements.mean_gradient[e], move, strain)
            done, begun = 0.0, 0.0
            for i in range(6):
                # mean stress times strain: see balance.energy
                done += 0.5 * (old.stress[e, g, i] + new.stress[e, g, i]) * strain[i]
                begun += elements.initial_stress[e, g, i] * strain[i]
            # s:C^-1:s/2
            change = stored_density(bulk, shear, new.stress[e, g]) - stored_density(bulk, shear, old.stress[e, g])
            stored += elements.volume[e, g] * change
            dissipated += elements.volume[e, g] * (done - change)
            initial += elements.volume[e, g] * begun
    return stored, dissipated, initial
