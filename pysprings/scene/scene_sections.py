# SPDX-License-Identifier: MIT
"""All sections of a scene, and what follows from them together."""

from collections.abc import Mapping
from functools import cached_property
from typing import Annotated, Any, Self, cast

from pydantic import Field as Key

from pysprings.core.words import AUTO, Discretisation
from pysprings.scene import sections
from pysprings.scene.design_load import Design
from pysprings.scene.fan import fan_paths, space_paths
from pysprings.scene.fields import Text
from pysprings.scene.ground import Ground, make_ground


class SceneSections(sections.Section):
    """The values of a scene, each valid for itself, and what follows from them, found once."""

    title: Annotated[str, Text("title of tables and pictures")] = "Suction caisson"
    caisson: sections.Caisson = sections.Caisson()
    domain: sections.Domain = sections.Domain()
    soil: sections.Soil = sections.Soil()
    interface: sections.Interface = sections.Interface()
    drainage: sections.Drainage = sections.Drainage()
    springs: sections.Springs = sections.Springs()
    paths: tuple[sections.Path, ...] = Key((), validation_alias="path")
    mesh: sections.Mesh = sections.Mesh()
    solver: sections.Solver = sections.Solver()
    limit: sections.Limit = sections.Limit()
    design: Design = Design()
    output: sections.Output = sections.Output()

    @property
    def discretisation(self) -> Discretisation:
        """Return the discretisation of the scene: where it is left open, series unless only bricks can represent it."""
        chosen = self.mesh.discretisation
        if chosen != AUTO:
            return cast(Discretisation, chosen)
        needs_bricks = self.drainage.stabilisation != 1.0 or self.mesh.azimuth is not None
        return "hex8" if needs_bricks else "fourier"

    @cached_property
    def extent(self) -> sections.Extent:
        """Radius and depth of the domain."""
        return sections.make_extent(self.domain, self.caisson, self.soil)

    @cached_property
    def ground(self) -> Ground:
        """The ground by depth; a soil without layers is one."""
        return make_ground(self.soil, self.extent)

    @property
    def layer_drainage(self) -> str:
        """How the water takes part: drainage.mode, "total-stress" for undrained clay, or several of them."""
        return ", ".join(sorted({each.drainage_in(self.drainage.mode) for each in self.ground.strata}))

    @cached_property
    def load_paths(self) -> tuple[sections.Path, ...]:
        """The paths of a run in one plane: those of the scene, then those of its fan; a pull where there are none."""
        plane = (path for path in self.paths if not path.in_space)
        found = (*plane, *fan_paths(self.springs, self.caisson))
        return found if found or self.paths else (sections.PAPER_PATH,)

    @cached_property
    def all_paths(self) -> tuple[sections.Path, ...]:
        """The paths of a run: those in one plane, then those that leave it, of the scene and of its fan."""
        own = (path for path in self.paths if path.in_space)
        return (*self.load_paths, *own, *space_paths(self.springs, self.caisson))

    def vertical_load_of(self, path: sections.Path) -> float | str:
        """Return the vertical load of a path: its own, or the caisson's (N, positive down, or "balanced")."""
        return self.caisson.vertical_load if path.vertical_load is None else path.vertical_load

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy with some sections replaced, unchecked; what follows from them is found anew."""
        copied = super().model_copy(update=update, deep=deep)
        for name in set(copied.__dict__) - set(type(self).model_fields):
            del copied.__dict__[name]
        return copied
