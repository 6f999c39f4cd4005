# SPDX-License-Identifier: MIT
"""Undrained clay in total stress: von Mises' surface with hyperbolic mobilisation (see `mobilised`).

    f = II - x s,      II = sqrt(s:s/2),      flow associated, no plastic change of volume.

s is the strength in simple shear and in plane strain. In triaxial tests (sigma_1 - sigma_3)/2 reaches sqrt(3)/2 s:
where su is that of triaxial compression, s = 2 su/sqrt(3), which is 15.5 % too strong in plane strain.
"""

from __future__ import annotations

from fe_engine.compiled import lean
from fe_engine.conventions import OK, REGIME_CONE, REGIME_ELASTIC
from fe_engine.soil import mobilised
from fe_engine.soil.elastic import add_elastic_stress, elastic_tangent
from fe_engine.soil.law import SoilLaw
from fe_engine.soil.mobilised import BULK, KAPPA, SHEAR, SQRT3, radius, returned
from fe_engine.soil.plasol import second_invariant


@lean
def yield_function(p, stress, kappa):
    """Yield function f in Pa of a stress (6,); negative inside the elastic domain."""
    return second_invariant(stress, (stress[0] + stress[1] + stress[2]) / 3.0) - radius(p, kappa)  # f = II - x s


@lean
def update(p, strain, old, new, tangent, with_tangent):
    """Advance one Gauss point by the strain increment (6,), see law.SoilLaw; return (status, regime)."""
    stress_old, history_old = old
    stress, history = new
    for i in range(6):
        stress[i] = stress_old[i]
    add_elastic_stress(p[BULK], p[SHEAR], strain, stress)
    kappa = history_old[KAPPA]
    mean = (stress[0] + stress[1] + stress[2]) / 3.0
    trial = second_invariant(stress, mean)
    if trial <= radius(p, kappa):  # f of the trial state
        history[KAPPA] = kappa
        if with_tangent:
            elastic_tangent(p[BULK], p[SHEAR], 1.0, tangent)
        return OK, REGIME_ELASTIC
    shear, slope = returned(p, kappa, trial, p[SHEAR])
    ratio = shear / trial  # s shrinks along s_tr
    history[KAPPA] = kappa + (trial - shear) / (SQRT3 * p[SHEAR])  # g/sqrt3, where G g is what II has lost
    if with_tangent:
        elastic_tangent(0.0, p[SHEAR], ratio, tangent)  # 2 G ratio I_dev
        factor = p[SHEAR] * (slope - ratio) / (trial * trial)  # along s_tr the stress changes by slope, not by ratio
        for i in range(6):
            direction = stress[i] - (mean if i < 3 else 0.0)
            for j in range(6):
                tangent[i, j] += factor * direction * (stress[j] - (mean if j < 3 else 0.0))
                if i < 3 and j < 3:
                    tangent[i, j] += p[BULK]
    for i in range(3):
        stress[i] = ratio * (stress[i] - mean) + mean
        stress[i + 3] *= ratio
    return OK, REGIME_CONE


LAW = SoilLaw(
    "von-mises", mobilised.PARAMETERS, mobilised.HISTORY, mobilised.pack, mobilised.elastic_moduli, update,
)  # fmt: skip
