# SPDX-License-Identifier: MIT
"""`pysprings atlas`: an emulator over a study, with its errors; springs of an atlas."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pysprings.cli.folders import refuse_read
from pysprings.cli.options import Json, argument, option
from pysprings.cli.support import print_json, print_table, refuse
from pysprings.core.columns import Column, Table

if TYPE_CHECKING:
    import xarray as xr

    from pysprings.scene.model import Scene
    from pysprings.studies.atlas.model import Atlas

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
    for name, value in options.items():
        if value not in (None, []):
            refuse(name, "is for springs of an atlas: give --atlas, too")


def springs_of_atlas(asked: Asked, strict: bool = False, extrapolate: bool = False) -> xr.DataTree:
    """Return the springs of an atlas for a scene file, or for the base scene of the atlas with other values.

    Raises UserInputError for scenes that the atlas does not cover; with ``strict`` also at the edge of its full models.
    """
    from pysprings.springs.checks import save_springs
    from pysprings.studies.atlas.model import open_atlas

    if asked.save is not None and asked.save.suffix != ".nc":
        refuse("--save-springs", "name a file that ends in .nc", asked.save)
    atlas = open_atlas(asked.atlas)
    scene = scene_of(atlas, asked)
    springs = atlas.springs(scene, extrapolate)
    if strict and (edge := str(springs.attrs["atlas_outside"])):
        refuse("--strict", edge)
    if asked.save is not None:
        save_springs(springs, asked.save)
    return springs


def scene_of(atlas: Atlas, asked: Asked) -> Scene:
    """Return the scene that options ask for: that of the scene file, or the atlas's base scene with other values."""
    from pysprings.scene.changes import VERTICAL_LOAD, read_changes, vertical_load
    from pysprings.scene.load import SceneText

    text = None if asked.scene is None else SceneText.read(asked.scene)
    changes = [atlas.named(change, text) for change in read_changes(asked.changes)]
    if asked.V is not None and all(change.keys != VERTICAL_LOAD for change in changes):
        changes.append(vertical_load(asked.V))
    if text is None:
        return atlas.scene(asked.D, asked.L, changes)
    if asked.D is not None or asked.L is not None:
        refuse("--D", "the scene file has it: give a scene file, or --D and --L", asked.scene)
    return text.scene(changes)


def atlas(
    study: Annotated[Path, argument("STUDY", "study.nc, or the folder of `pysprings sweep`")],
    family: Annotated[str, option("--family", "ground: clay, clay-gap or sand", "NAME")],
    held_back: Annotated[
        Path | None, option("--held-back", "study of pulls that the atlas is checked on", "STUDY")
    ] = None,
    out: Annotated[Path | None, option("--out", "file [default: FAMILY.nc]", "FILE")] = None,
    at: Annotated[str | None, option("--at", "where pulls are compared [default: 0.001,0.01]", "U/D[,U/D]")] = None,
    table: Annotated[Path | None, option("--table", "write the comparison, a row a quantity: .csv", "FILE")] = None,
    as_json: Json = False,
) -> None:
    """Make springs of any caisson between the cases of a study.

    Errors of cases that are left out one by one, and of held-back pulls, are printed and stored in the file.
    """
    from pysprings.studies.atlas import build
    from pysprings.studies.atlas.families import FAMILIES
    from pysprings.studies.atlas.model import write_atlas

    target = out or Path(f"{family}.nc")
    if target.suffix != ".nc" or target.is_dir():
        refuse("--out", "name a file that ends in .nc", target)
    refuse_read("--out", target, study, held_back)
    if table is not None and (table.suffix != ".csv" or held_back is None):
        refuse("--table", "is the comparison with --held-back: name a file that ends in .csv", table)
    made, left, compared = build.atlas_of(study, FAMILIES.find(family, "family"), held_back, _shares(at))
    frames, file = {"Cases left out": build.left_summary(left)}, write_atlas(made, target)
    if table is not None and compared is not None:
        from pysprings.results.exporters.csv import write_frame

        write_frame(compared, table)
    if compared is not None:
        frames["Cases held back"] = build.summary(compared)
    if as_json:
        print_json(
            {"atlas": str(target), "about": dict(made.about)} | {k: f.to_dict("records") for k, f in frames.items()}
        )
        return
    for name, frame in frames.items():
        print(f"{name}:")
        print_table(Table.of([Column(str(name), str(name), 3) for name in frame], frame.to_dict("records")))
        print()
    print(f"held back: {made.about['held back']}")
    print(f"{file} ({file.stat().st_size / 1e6:.2f} MB)")
    print(f"next: {next_command(made, target)}")


def next_command(made: Atlas, file: Path) -> str:
    """Return a command that the atlas answers: of its base scene, or the page where that is not among its cases."""
    D, L = made.base.caisson.outer_diameter, made.base.caisson.skirt_length
    if made.beyond(made.base):
        return f"pysprings explore --atlas {shlex.quote(str(file))}"
    return f'pysprings predict --atlas {shlex.quote(str(file))} --D "{D:g} m" --L "{L:g} m" --u-max "{D:g} mm"'


def _shares(text: str | None) -> tuple[float, ...]:
    from pysprings.studies.atlas.build import AT

    if text is None:
        return AT
    try:
        shares = tuple(float(part) for part in text.split(","))
    except ValueError:
        shares = ()
    if not shares or any(not 0.0 < share < 0.2 for share in shares):
        refuse("--at", f"'{text}' is no list of displacements over the diameter, such as 0.001,0.01")
    return shares
