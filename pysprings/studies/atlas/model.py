# SPDX-License-Identifier: MIT
"""`Atlas`: springs of any caisson of its family, with their predicted standard deviation and marks outside its hull."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pysprings.studies.atlas.data import Estimate
from pysprings.studies.atlas.emulator import Emulator
from pysprings.studies.atlas.families import FAMILIES, Family
from pysprings.studies.atlas.process import Process
from pysprings.studies.atlas.samples import FORCES, MOMENTS, ROWS, stiffness_of

if TYPE_CHECKING:
    from pysprings.scene.model import Scene

Array = NDArray[np.float64]
STIFFNESS_FLOOR = 1e-3  # standard deviation over the stiffness at the least: numbers of cells change with L/D


@dataclass(frozen=True, eq=False, kw_only=True)
class Atlas(Emulator):
    """An emulator by Gaussian processes over the principal components of the springs.

    Attributes
    ----------
    mean, modes : (ray, row, X) and (m, ray, row, X): principal components.
    processes : of the components; of the four numbers of the stiffness; of the settlement.
    """

    mean: Array
    modes: Array
    processes: tuple[Process, ...]
    stiffness: tuple[Process, ...]
    settlement: Process

    @property
    def source(self) -> str:
        """Where springs come from: for files and remarks."""
        return f"atlas {self.family.name}"

    def _expected(self, scene: Scene, inputs: Array, outside: tuple[str, ...]) -> Estimate:
        point, sizes = self.point(inputs), self.family.sizes(scene)
        means, errors = (np.array(each) for each in zip(*(one.at(point) for one in self.processes), strict=True))
        values = self.mean + np.tensordot(means, self.modes, axes=1)
        modes = self.factor * errors[:, None, None, None] * self.modes
        factor, spread = (np.array(each) for each in zip(*(one.at(point) for one in self.stiffness), strict=True))
        D, L = scene.caisson.outer_diameter, scene.caisson.skirt_length
        matrix = stiffness_of(factor, sizes.force, sizes.ratio, D, L)
        settled = self.settlement.at(point)[0] * D / sizes.ratio
        return Estimate(values, modes, matrix, _log_errors(factor, spread), settled, outside)


def _log_errors(factor: Array, spread: Array) -> Array:
    """Return standard deviations of log K_V, log K_H and log K_M by those of `factors`."""
    inner = np.exp(2.0 * factor[1]) * factor[2] ** 2
    outer = np.exp(2.0 * factor[3])
    share_ = inner / (inner + outer)
    slope = 2.0 * np.exp(2.0 * factor[1]) * factor[2] / (inner + outer)
    moment = np.sqrt((2 * share_ * spread[1]) ** 2 + (slope * spread[2]) ** 2 + (2 * (1 - share_) * spread[3]) ** 2)
    return np.hypot(np.array([spread[0], 2.0 * spread[1], moment]), STIFFNESS_FLOOR)


def sums(values: Array) -> tuple[Array, Array]:
    """Return H over F h and M over F L h (..., X) of rows (..., row, X)."""
    n = sum(name.startswith("p") for name in FORCES)
    middle = (np.arange(n) + 0.5) / n
    row = {name: ROWS.index(name) for name in ("H_tip", "H_lid")}
    p, tip, lid = values[..., :n, :], values[..., row["H_tip"], :], values[..., row["H_lid"], :]
    moments = values[..., len(FORCES) : len(FORCES) + len(MOMENTS), :]
    M = (middle[:, None] * p).sum(axis=-2) + moments.sum(axis=-2) + tip
    return p.sum(axis=-2) + tip + lid, M


def family_of(name: str) -> Family:
    """Return a family by its name. Raises UserInputError."""
    return FAMILIES.find(name, "family")
