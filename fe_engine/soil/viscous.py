# SPDX-License-Identifier: MIT
"""Viscoplasticity of Duvaut & Lions (1972), laid over any law: stress beyond yield relaxes towards the law's own.

With the stress sigma* and the history q* to which the law returns the trial state, and a relaxation time T,

    dsigma/dt = C : deps/dt - (sigma - sigma*)/T,       dq/dt = (q* - q)/T.

Backward Euler over a step dt (Simo, Kennedy & Govindjee 1988, closed form) needs the share s = dt/(dt + T) alone:

    sigma = sigma_trial + s (sigma* - sigma_trial),     q = q_old + s (q* - q_old),     C_T = C + s (C* - C).

s = 1 is the law itself. As dt -> 0 the tangent becomes the elastic one, so that a small enough step has a solution
however the law localises. A law whose stiffness changes has a trial stress of its own: `following`. In steady flow the
overstress is T times the elastic stress rate of the plastic strain.
"""

from __future__ import annotations

from fe_engine.compiled import lean
from fe_engine.soil.elastic import add_elastic_stress


def share_of(step: float, lag: float) -> float:
    """Return s of a step and a relaxation time, both in the same unit; 1 without a relaxation time."""
    return step / (step + lag) if lag > 0.0 else 1.0  # backward Euler of Duvaut & Lions 1972


@lean
def relax(moduli, share, strain, old, new):
    """Turn the rate-independent state ``new`` (Point) of a step by the strain (6,) into the viscous one, in place.

    ``moduli`` (2,) are K and G in Pa, ``old`` (Point) is the state before the step, ``share`` s.
    """
    rest = 1.0 - share
    for i in range(6):
        # s sigma* + (1 - s)(sigma_old + C : d eps), Simo et al. 1988
        new.stress[i] = share * new.stress[i] + rest * old.stress[i]
    add_elastic_stress(rest * moduli[0], rest * moduli[1], strain, new.stress)
    for i in range(len(old.history)):
        new.history[i] = share * new.history[i] + rest * old.history[i]  # q_old + s (q* - q_old)


@lean
def relax_point(p, moduli, share, strain, old, new, tangent, with_tangent):
    """Relax a point of a law of constant stiffness, see law.SoilLaw: its tangent stays as it is."""
    relax(moduli, share, strain, old, new)
