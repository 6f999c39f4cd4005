# SPDX-License-Identifier: MIT
"""Penalty stiffness of the interface: what "auto" means, what a penalty costs, and how stiff is too stiff.

A caisson that is held through springs K_N and K_T has less stiffness than a bonded one. For the paper's geometry an
independent elastic solution loses 0.49 % at K D/E = 390 and 4.1 % at 39 (K_free of a free-head pull), so that the loss
is x/(1 + x) with x = 1.9 E/(K D) within a tenth. "auto" is K = 390 E/D: the paper's 1e10 N/m3 for its E and D.

Beyond ten times that nothing is gained (5e-4 of the stiffness), and the tractions at tip and lid edges, where wall and
base hold the same nodes, hang on differences of displacements that no longer decide anything: Newton then cycles among
them (a hundred times that took 78 increments, 19 of them cut, where ten times takes 23 and none, on the `paper` mesh to
2.5 mm). A stiffer penalty is therefore replaced by the limit, and the run says so.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pysprings.scene.load import Scene

AUTO = 390.0  # K D/E
STIFFEST = 10.0 * AUTO
_LOSS = 1.9


@dataclass(frozen=True)
class Penalty:
    """Stiffness (N/m3) that the model uses; what it costs; ``remarks`` say where it is not the scene's.

    ``penetration`` (m) is that of the largest initial contact pressure, ``stiffness_loss`` (-) the share of the bonded
    stiffness of a free-head pull that the penalty takes away, about.
    """

    normal: float
    shear: float
    penetration: float
    stiffness_loss: float
    remarks: tuple[str, ...]


def penalty_of(scene: Scene) -> Penalty:
    """Return the penalty stiffness that a scene is run with."""
    unit = scene.soil.young_modulus / scene.caisson.outer_diameter
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


def _loss(ratio: float) -> float:
    return _LOSS / (ratio + _LOSS)


def _pressure(scene: Scene) -> float:
    """Largest initial contact pressure in Pa, at the tip."""
    soil = scene.soil
    vertical = soil.surcharge + soil.effective_unit_weight * scene.caisson.skirt_length
    return max(soil.K0, 1.0) * vertical
