# SPDX-License-Identifier: MIT
"""Scene -> contact law of the stations: friction beside sand, adhesion beside undrained clay, tension by surface.

Scenes without adhesion and with free opening have Coulomb's law. Others have the law with adhesion everywhere:

    beside undrained clay   shear up to alpha su(z), no friction; sealed: suction down to cavitation,
    beside another soil     shear up to alpha c(z) + mu p'; sealed is vented: a drained soil holds no suction.

Pressures count from the hydrostatic pressure of the water, see `fe_engine.contact.adhesion`.

A caisson that is held through springs K_N and K_T has less stiffness than a bonded one. For the paper's geometry an
independent elastic solution loses 0.49 % at K D/E = 390 and 4.1 % at 39 (K_free of a free-head pull), so that the loss
is x/(1 + x) with x = 1.9 E/(K D) within a tenth. "auto" is K = 390 E/D: the paper's 1e10 N/m3 for its E and D.

Beyond ten times that nothing is gained (5e-4 of the stiffness), and the tractions at tip and lid edges, where wall and
base hold the same nodes, hang on differences of displacements that no longer decide anything: Newton then cycles among
them (a hundred times that took 78 increments, 19 of them cut, where ten times takes 23 and none, on the `paper` mesh to
2.5 mm). A stiffer penalty is therefore replaced by the limit, and the run reports it.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from fe_engine.contact import adhesion, coulomb
from fe_engine.contact.law import ContactLaw
from fe_engine.elements.interface import Stations
from fe_engine.fourier_model import FourierModel
from fe_engine.model import Model
from pysprings.core.text import with_prefix
from pysprings.core.units import ATMOSPHERE, VAPOUR
from pysprings.model.mesh import SURFACES
from pysprings.scene.by_depth import of_surface
from pysprings.scene.defaults import defaulted
from pysprings.scene.interface import adhesion_factor, uses_adhesion
from pysprings.scene.model import Scene

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


# --- penalty stiffness of the interface ---

AUTO = 390.0  # K D/E
STIFFEST = 10.0 * AUTO
_LEAST_SHARE = 0.02  # of the largest penalty: soil that is much softer lies open or yields at once
_LOSS = 1.9


@dataclass(frozen=True)
class Penalty:
    """Stiffness (N/m3) that the model uses; what it costs; ``remarks`` list where it is not the scene's.

    ``penetration`` (m) is that of the largest initial contact pressure, ``stiffness_loss`` (-) the share of the bonded
    stiffness of a free-head pull that the penalty takes away, about.
    """

    normal: float
    shear: float
    penetration: float
    stiffness_loss: float
    remarks: tuple[str, ...]


def penalty_of(scene: Scene) -> Penalty:
    """Return the penalty stiffness that a scene is run with, that beside the stiffest soil along the skirt."""
    unit = float(np.max(_young(scene, _along_skirt(scene)))) / scene.caisson.outer_diameter
    values, remarks = [], []
    for name in ("normal_stiffness", "shear_stiffness"):
        given = getattr(scene.interface, name)
        value = AUTO * unit if given == "auto" else float(given)
        if value > STIFFEST * unit:
            most, own = (with_prefix(each, "N/m3", 3) for each in (STIFFEST * unit, value))
            limit = f"{most} ({STIFFEST:g} E/D)"
            cost = f"costs {100.0 * _loss(STIFFEST):.1g} % of the elastic stiffness"
            remarks.append(f"interface.{name}: {own} is too stiff to solve with; {limit} is used, which {cost}")
            value = STIFFEST * unit
        values.append(value)
    return Penalty(values[0], values[1], _pressure(scene) / values[0], _loss(min(values) / unit), tuple(remarks))


def defaults_of(scene: Scene, vertical_load: float) -> list[dict[str, Any]]:
    """Return what a scene does not give, by key, value and unit; ``vertical_load`` (N) is that of the built model."""
    penalty = penalty_of(scene)
    known = {"normal": penalty.normal, "shear": penalty.shear}
    numbers = {f"interface.{name}_stiffness": value for name, value in known.items()}
    return defaulted(scene, {**numbers, "caisson.vertical_load": vertical_load})


def penalty_at(scene: Scene, depth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the penalty stiffnesses (n,), normal and shear in N/m3, of stations at depths (n,) in m.

    "auto" follows the soil beside the station, and is no less than a share of the largest.
    """
    by_part, penalty, local = [], penalty_of(scene), _young(scene, depth)
    largest = np.max(_young(scene, _along_skirt(scene)))
    share = np.maximum(local / largest, _LEAST_SHARE)
    for name, value in (("normal_stiffness", penalty.normal), ("shear_stiffness", penalty.shear)):
        by_soil = getattr(scene.interface, name) == "auto"
        by_part.append(value * (np.minimum(share, 1.0) if by_soil else np.ones(len(depth))))
    return by_part[0], by_part[1]


def _young(scene: Scene, depth: np.ndarray) -> np.ndarray:
    return scene.ground.value("young_modulus", depth)


def _along_skirt(scene: Scene) -> np.ndarray:
    """Return the depths (n,) m from mudline to tip, one just below each boundary of layers among them."""
    length = scene.caisson.skirt_length
    below = [line + 1e-6 * length for line in scene.ground.lines if line < length]
    return np.concatenate([np.linspace(0.0, length, 33), below])


def _loss(ratio: float) -> float:
    return _LOSS / (ratio + _LOSS)


def _pressure(scene: Scene) -> float:
    """Return the largest initial contact pressure in Pa, at the tip."""
    ground, depth = scene.ground, np.array(scene.caisson.skirt_length)
    return float(np.maximum(ground.value("K0", depth), 1.0) * ground.vertical_stress(depth))
