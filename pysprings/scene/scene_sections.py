# SPDX-License-Identifier: MIT
"""All sections of a scene, and what follows from them together."""

from __future__ import annotations

from typing import Annotated, cast

from pydantic import Field as Key

from pysprings.core.words import AUTO, Discretisation
from pysprings.scene.design_load import Design
from pysprings.scene.fan import fan_paths
from pysprings.scene.fields import Text
from pysprings.scene.sections import (
    PAPER_PATH,
    Caisson,
    Domain,
    Drainage,
    Interface,
    Limit,
    Mesh,
    Output,
    Path,
    Section,
    Soil,
    Solver,
    Springs,
)


class SceneSections(Section):
    """The values of a scene, each valid for itself."""

    title: Annotated[str, Text("title of tables and pictures")] = "Suction caisson in sand, drained"
    caisson: Caisson = Caisson()
    domain: Domain = Domain()
    soil: Soil = Soil()
    interface: Interface = Interface()
    drainage: Drainage = Drainage()
    springs: Springs = Springs()
    paths: tuple[Path, ...] = Key((), validation_alias="path")
    mesh: Mesh = Mesh()
    solver: Solver = Solver()
    limit: Limit = Limit()
    design: Design = Design()
    output: Output = Output()

    @property
    def discretisation(self) -> Discretisation:
        """Return the discretisation of the scene: where it is left open, series unless only bricks can represent it."""
        chosen = self.mesh.discretisation
        if chosen != AUTO:
            return cast(Discretisation, chosen)
        needs_bricks = self.drainage.stabilisation != 1.0 or self.mesh.azimuth is not None
        return "hex8" if needs_bricks else "fourier"

    @property
    def load_paths(self) -> tuple[Path, ...]:
        """Return the paths of a run: those of the scene, then those of its fan; a pull where there are none."""
        return (*self.paths, *fan_paths(self.springs, self.caisson)) or (PAPER_PATH,)

    def vertical_load_of(self, path: Path) -> float | str:
        """Return the vertical load of a path: its own, or the caisson's (N, positive down, or "balanced")."""
        return self.caisson.vertical_load if path.vertical_load is None else path.vertical_load
