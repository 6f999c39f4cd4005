# SPDX-License-Identifier: MIT
"""Springs of an atlas for commands that answer on springs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pysprings.cli.support import refuse

if TYPE_CHECKING:
    import xarray as xr

SHIPPED_ATLASES = "an atlas (clay, clay-gap, sand, or a .nc file)"


@dataclass(frozen=True)
class Asked:
    """What the options of a command say: atlas, scene file, D and L [m], changes KEY=VALUE, a file to save.

    V : vertical load [N] of the caisson, unless a change gives one; None: that of the scene.
    """

    atlas: str
    scene: Path | None
    D: float | None
    L: float | None
    changes: tuple[str, ...] = ()
    save: Path | None = None
    V: float | None = None


def refuse_without_atlas(options: Mapping[str, Any]) -> None:
    """Refuse options that need --atlas."""
    for option, value in options.items():
        if value not in (None, []):
            refuse(option, "is for springs of an atlas: give --atlas, too")


def springs_of_atlas(asked: Asked, strict: bool = False, extrapolate: bool = False) -> xr.DataTree:
    """Return the springs of an atlas for a scene file, or for the base scene of the atlas with other values.

    Raises UserInputError for scenes that the atlas does not cover; with ``strict`` also at the edge of its full models.
    """
    from pysprings.scene.changes import VERTICAL_LOAD, read_changes, vertical_load
    from pysprings.springs.checks import save_springs
    from pysprings.studies.atlas.model import open_atlas

    if asked.save is not None and asked.save.suffix != ".nc":
        refuse("--save-springs", "name a file that ends in .nc", asked.save)
    atlas = open_atlas(asked.atlas)
    changes = [atlas.named(change) for change in read_changes(asked.changes)]
    if asked.V is not None and all(change.keys != VERTICAL_LOAD for change in changes):
        changes.append(vertical_load(asked.V))
    if asked.scene is not None:
        if asked.D is not None or asked.L is not None:
            refuse("--D", "the scene file has it: give a scene file, or --D and --L", asked.scene)
        from pysprings.scene.load import SceneText

        scene = SceneText.read(asked.scene).scene(changes)
    else:
        scene = atlas.scene(asked.D, asked.L, changes)
    springs = atlas.springs(scene, extrapolate)
    if strict and (edge := str(springs.attrs["atlas_outside"])):
        refuse("--strict", edge)
    if asked.save is not None:
        save_springs(springs, asked.save)
    return springs
