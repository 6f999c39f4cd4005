# SPDX-License-Identifier: MIT
"""What springs of an emulator are made of: its rays and motions, its base scene, what it expects of a scene."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pysprings.scene.load import SceneText
from pysprings.studies.atlas.families import Family

if TYPE_CHECKING:
    from pysprings.scene.model import Scene

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Dense:
    """Rays close to each other: angles [rad], and `Grid.rest` (2, ray, X) on them."""

    angles: Array
    rest: Array


@dataclass(frozen=True)
class Estimate:
    """What is expected of a scene: values (ray, row, X), modes (m, ray, row, X) of one standard deviation each.

    Attributes
    ----------
    stiffness : (3, 3) initial stiffness.
    stiffness_error : standard deviations of the logarithms of K_V, K_H, K_M.
    settled : w at rest [m].
    outside : why the scene is at the edge of what is covered; none inside the hull of the full models.
    dense : rays that are so close that none are needed in between, in place of those of the study.
    """

    values: Array
    modes: Array
    stiffness: Array
    stiffness_error: Array
    settled: float
    outside: tuple[str, ...]
    dense: Dense | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Grid(ABC):
    """The full models of a study, and the rays and motions on which springs between them are expected.

    Attributes
    ----------
    family : what decides.
    text : the base scene.
    inputs : (n, d) of the full models.
    rays, angles, X : grid of the springs: names and directions [rad] of the rays, motions.
    reach : largest rho over D.
    rest : (2, ray, X) standard deviation of H over F h and M over F L h that `Estimate.modes` do not hold.
    factor : of all standard deviations, such that 95 % of the cases left out lie in the band of 95 %.
    fan : standard deviations of what rays do not say of pulls where the soil has failed: over the load, and over the
        rotation. From held-back pulls (`pysprings.studies.atlas.check`); 0 where there were none.
    about : where it comes from: words for files and reports.
    """

    family: Family
    text: SceneText
    inputs: Array
    rays: tuple[str, ...]
    angles: Array
    X: Array
    reach: float
    rest: Array
    factor: float = 1.0
    fan: tuple[float, float] = (0.0, 0.0)
    about: Mapping[str, str] = field(default_factory=dict)

    @property
    @abstractmethod
    def source(self) -> str:
        """Where springs come from: for files and remarks."""

    @cached_property
    def base(self) -> Scene:
        """The base scene."""
        return self.text.scene()
