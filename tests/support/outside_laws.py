# SPDX-License-Identifier: MIT
"""A soil law and a contact law from outside the package, and a run with them; prints the run as JSON.

Runs as a program, since laws are added before loops are compiled: ``python -m tests.support.outside_laws``.
"""

import json

import numpy as np

from fe_engine.compiled import njit
from fe_engine.contact.law import ContactLaw
from fe_engine.contact.laws import CONTACT_LAWS
from fe_engine.conventions import CONTACT_STICK, OK, REGIME_ELASTIC
from fe_engine.soil import elastic
from fe_engine.soil.law import SoilLaw
from fe_engine.soil.laws import SOIL_LAWS

add_elastic_stress, elastic_tangent = elastic.add_elastic_stress, elastic.elastic_tangent
HISTORY = ("e_xx", "e_yy", "e_zz", "g_xy", "g_yz", "g_zx", "length", "updates", *(f"unused_{k}" for k in range(60)))


@njit
def recorded(p, strain, old, new, tangent, with_tangent):
    """Return the elasticity whose history keeps the strain, its length and the number of increments."""
    square = 0.0
    for i in range(6):
        new.stress[i] = old.stress[i]
        new.history[i] = old.history[i] + strain[i]
        square += strain[i] ** 2
    for i in range(8, old.history.size):
        new.history[i] = old.history[i]
    new.history[6] = old.history[6] + square**0.5
    new.history[7] = old.history[7] + 1.0
    add_elastic_stress(p[0], p[1], strain, new.stress)
    if with_tangent:
        elastic_tangent(p[0], p[1], 1.0, tangent)
    return OK, REGIME_ELASTIC


@njit
def bonded(p, slide, traction):
    """Return the springs in all directions that neither open nor slip."""
    traction[0] = -slide.initial_pressure + p[0] * slide.jump[0]
    for i in range(1, 3):
        traction[i] = slide.traction_old[i] + p[1] * (slide.jump[i] - slide.jump_old[i])
    return CONTACT_STICK


@njit
def bonded_linear(p, slide, guess, traction, tangent):
    """Return the same with its tangent."""
    for i in range(3):
        for j in range(3):
            tangent[i, j] = 0.0
        tangent[i, i] = p[min(i, 1)]
    return bonded(p, slide, traction)


RECORDED = SoilLaw(
    "recorded", ("bulk", "shear"), HISTORY, elastic.pack, elastic.elastic_moduli, recorded, symmetric=True, yields=False
)
BONDED = ContactLaw(
    "bonded", ("normal", "shear"), lambda kn, kt: np.array([kn, kt]), bonded, bonded_linear,
    lambda p, pressure, jump: np.zeros(len(jump)), lambda p: (p[..., 0], p[..., 1]),
    lambda p: np.ones(p.shape[:-1], dtype=bool),
)  # fmt: skip


def main() -> None:
    """Add both laws, lift a footing with them, print forces, history and stress."""
    SOIL_LAWS.add(RECORDED)
    CONTACT_LAWS.add(BONDED)
    from dataclasses import replace

    from tests.support import models

    model = models.footing(models.soil(RECORDED))
    model = replace(model, contact=BONDED.pack(1e9, 5e8)[None], contact_laws=(BONDED,))
    # pulled up further than the initial penetration: contact of the package would open
    run = models.run(model, models.stage({0: 1e-3, 1: -2e-3, 2: 0.0}))
    fields = run.state.committed
    results = {
        "force": run.steps[-1].multipliers.tolist(),
        "history": fields.history.tolist(),
        "change": (fields.stress - model.initial_stress).tolist(),
        "steps": len(run.steps),
        "open": int(run.steps[-1].increment.residual.n_open),
    }
    print(json.dumps(results))


if __name__ == "__main__":
    main()
