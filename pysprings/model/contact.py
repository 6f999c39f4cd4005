# SPDX-License-Identifier: MIT
"""Scene -> contact law of the stations: friction beside sand, adhesion beside undrained clay, tension by surface.

Scenes without adhesion and with free opening have Coulomb's law. Others have the law with adhesion everywhere:

    beside undrained clay   shear up to alpha su(z), no friction; sealed: suction down to cavitation,
    beside another soil     shear up to alpha c(z) + mu p'; sealed is vented: a drained soil holds no suction.

Pressures count from the hydrostatic pressure of the water, see `fe_engine.contact.adhesion`.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from fe_engine.contact import adhesion, coulomb
from fe_engine.contact.law import ContactLaw
from pysprings.core.magnitudes import ATMOSPHERE, VAPOUR
from pysprings.model.mesh import SURFACES
from pysprings.model.penalty import penalty_at
from pysprings.scene.by_depth import of_surface
from pysprings.scene.interface import adhesion_factor, uses_adhesion

if TYPE_CHECKING:
    from fe_engine.elements.interface import Stations
    from fe_engine.fourier_model import FourierModel
    from fe_engine.model import Model
    from pysprings.scene.load import Scene

SURFACE = {name: code for code, name in enumerate(SURFACES)}
_BELOW = 1.0e-6  # m
# names of the surfaces in a scene
_NAMES = {"outer": "outside", "inner": "inside", "lid": "lid", "tip": "tip"}


def contact_of(scene: Scene, stations: Stations, wall: np.ndarray) -> tuple[ContactLaw, np.ndarray]:
    """Return the law of the stations and the parameters (ns, n) of each; smooth under the lid at the skirt.

    ``wall`` are the nodes of the inner wall: the skirt's station on the same node as one of the lid has its shear
    already. With both, the stations alternate between stick and slip at lift-off.
    """
    shared = (stations.surface == SURFACE["lid"]) & np.isin(stations.nodes[:, 0], wall)
    depth = stations.position[:, 2]
    kn, kt = penalty_at(scene, depth)
    mu = scene.interface.friction_coefficient
    if not uses_adhesion(scene):
        rows = np.array([coulomb.pack(normal, shear, mu) for normal, shear in zip(kn, kt, strict=True)])
        rows[shared, coulomb.MU] = 0.0
        return coulomb.LAW, rows
    limit, tension = _limits(scene, stations)
    friction = np.where(scene.ground.in_total_stress(_beside(stations)), 0.0, mu)
    rows = adhesion.pack(kn, kt, friction, limit, tension)
    rows[shared, adhesion.MU] = rows[shared, adhesion.ADHESION] = 0.0
    return adhesion.LAW, rows


def largest_tension(model: Model | FourierModel) -> np.ndarray:
    """Return the tension (ns,) in Pa that each station carries before it opens; infinite where it is bonded."""
    law = model.contact_laws[0]
    found = np.zeros(len(model.initial_pressure))
    if "tension" in law.parameters:
        found += model.contact[:, law.parameters.index("tension")]
    return found


def _beside(stations: Stations) -> np.ndarray:
    """Return depths (ns,) m of the soil beside the stations; below the tip it is that of the layer below."""
    below = np.where(stations.surface == SURFACE["tip"], _BELOW, 0.0)
    return np.asarray(stations.position[:, 2] + below)


def _limits(scene: Scene, stations: Stations) -> tuple[np.ndarray, np.ndarray]:
    """Return the adhesion and largest tension (ns,) of the stations, Pa."""
    ground, drainage = scene.ground, scene.drainage
    limit, tension = np.zeros(len(stations)), np.zeros(len(stations))
    number = ground.number(_beside(stations))
    for surface, name in _NAMES.items():
        opening = of_surface(scene.interface.opening, name)
        for k in np.unique(number):
            stratum = ground.strata[k]
            mine = (number == k) & (stations.surface == SURFACE[surface])
            depth = stations.position[mine, 2]
            limit[mine] = adhesion_factor(scene.interface, stratum, name, depth) * stratum.strength(depth)
            if opening == "bonded":
                tension[mine] = math.inf
            elif opening == "sealed" and stratum.total_stress:
                head = drainage.water_unit_weight * ((drainage.water_depth or 0.0) + depth)
                tension[mine] = ATMOSPHERE - VAPOUR + head
    return limit, tension
