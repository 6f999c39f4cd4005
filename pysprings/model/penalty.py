# SPDX-License-Identifier: MIT
"""Penalty stiffness of the interface: what "auto" means, what a penalty costs, and how stiff is too stiff.

A caisson that is held through springs K_N and K_T has less stiffness than a bonded one. For the paper's geometry an
independent elastic solution loses 0.49 % at K D/E = 390 and 4.1 % at 39 (K_free of a free-head pull), so that the loss
is x/(1 + x) with x = 1.9 E/(K D) within a tenth. "auto" is K = 390 E/D: the paper's 1e10 N/m3 for its E and D.

Beyond ten times that nothing is gained (5e-4 of the stiffness), and the tractions at tip and lid edges, where wall and
base hold the same nodes, hang on differences of displacements that no longer decide anything: Newton then cycles among
them (a hundred times that took 78 increments, 19 of them cut, where ten times takes 23 and none, on the `paper` mesh to
2.5 mm). A stiffer penalty is therefore replaced by the limit, and the run reports it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from pysprings.scene.defaults import defaulted

if TYPE_CHECKING:
    from pysprings.scene.load import Scene

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
            limit = f"{STIFFEST * unit:.3g} N/m3 ({STIFFEST:g} E/D)"
            cost = f"costs {100.0 * _loss(STIFFEST):.1g} % of the elastic stiffness"
            remarks.append(
                f"interface.{name}: {value:.3g} N/m3 is too stiff to solve with; {limit} is used, which {cost}"
            )
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
