# SPDX-License-Identifier: MIT
"""What an atlas holds, and what it expects of a scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pysprings.scene.load import SceneText
from pysprings.studies.atlas.families import Family
from pysprings.studies.atlas.process import Process

if TYPE_CHECKING:
    from pysprings.scene.model import Scene

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Estimate:
    """What an atlas expects of a scene: values (ray, row, X), modes (m, ray, row, X) of one standard deviation each.

    Attributes
    ----------
    stiffness : (3, 3) initial stiffness.
    stiffness_error : standard deviations of the logarithms of K_V, K_H, K_M.
    settled : w at rest [m].
    outside : why the scene is at the edge of what the atlas covers; none inside the hull of its full models.
    """

    values: Array
    modes: Array
    stiffness: Array
    stiffness_error: Array
    settled: float
    outside: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class AtlasData:
    """The content of an atlas: an emulator over the full models of a study.

    Attributes
    ----------
    family : what decides.
    text : the base scene.
    inputs : (n, d) of the full models.
    rays, angles, X : grid of the springs: names and directions [rad] of the rays, motions.
    reach : largest rho over D.
    mean, modes : (ray, row, X) and (m, ray, row, X): principal components.
    processes : of the components; of the four numbers of the stiffness; of the settlement.
    rest : (2, ray, X) standard deviation of H over F h and M over F L h that the components leave.
    factor : of all standard deviations, such that 95 % of the cases left out lie in the band of 95 %.
    fan : standard deviations of what rays do not say of pulls where the soil has failed: over the load, and over the
        rotation. From held-back pulls (`pysprings.studies.atlas.check`); 0 where there were none.
    about : where the atlas comes from: words for files and reports.
    """

    family: Family
    text: SceneText
    inputs: Array
    rays: tuple[str, ...]
    angles: Array
    X: Array
    reach: float
    mean: Array
    modes: Array
    processes: tuple[Process, ...]
    stiffness: tuple[Process, ...]
    settlement: Process
    rest: Array
    factor: float
    fan: tuple[float, float] = (0.0, 0.0)
    about: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def base(self) -> Scene:
        """The base scene."""
        return self.text.scene()
