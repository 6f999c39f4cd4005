# SPDX-License-Identifier: MIT
"""The scene: its sections, which must fit together, as one frozen value with a checksum."""

import hashlib
import json
from collections import Counter
from typing import Any, Self

from pydantic import PrivateAttr, model_validator

from pysprings.core.card import caisson_drawing, card
from pysprings.core.path_kinds import LOADS, MOTIONS
from pysprings.scene.checks import clashes, dotted
from pysprings.scene.fields import refuse
from pysprings.scene.scene_sections import SceneSections
from pysprings.scene.sections import Limit
from pysprings.scene.soils.cyclic import CYCLIC
from pysprings.scene.toml import to_toml

# keys of paths that leave a plane
SPACE = ("torsion_angle", "direction", "twist", "radius", *(name for name in MOTIONS if name != "w"), *LOADS)


class Scene(SceneSections):
    """Everything that decides a run: `pysprings.Scene(soil={"K0": 0.9})` changes one value."""

    _source: tuple[str, str] = PrivateAttr(("", ""))  # TOML text, and the sha256 of the scene that it gave
    _of_ranges: str | None = PrivateAttr(None)  # digest of all estimates of the text; None of one without ranges
    _estimate: str | None = PrivateAttr(None)  # whose values it has, of a text with ranges

    @model_validator(mode="after")
    def _refuse_clashes(self) -> Self:
        problems = list(clashes(self))
        if problems:
            lines = "; ".join(f"{dotted(clash.keys[0])}: {clash.message}" for clash in problems)
            raise refuse(lines, clashes=problems)
        return self

    @property
    def sha256(self) -> str:
        """SHA-256 (hex) of all values, whatever units and order the file wrote them in.

        Keys of a series, layers, clay, probes, directions, viscosity, [limit] and [design] count where used: other
        scenes keep the number.
        """
        values = self.model_dump(mode="json")
        del values["springs"]
        values["paths"] = [path.model_dump(mode="json") for path in self.all_paths]
        if self.discretisation == "hex8":
            for key in ("discretisation", "harmonics"):
                del values["mesh"][key]
        else:
            values["mesh"]["discretisation"] = self.discretisation
        if self.mesh.halvings == 0:
            del values["mesh"]["halvings"]
        if not self.soil.layers:
            del values["soil"]["layers"]
        for table in (values["soil"], *values["soil"].get("layers", ())):
            for key in [key for key, value in table.items() if value is None]:
                del table[key]
            for value in table.values():
                if isinstance(value, dict) and value.get("follows", "") is None:
                    del value["follows"]
        for path in values["paths"]:
            for key in ("load_angle", *SPACE):
                if path[key] is None:
                    del path[key]
            path["then"] = [_digested(each) for each in path["then"]]
        if values["interface"]["adhesion_factor"] is None:
            del values["interface"]["adhesion_factor"]
        if values["interface"]["opening"] == "vented":
            del values["interface"]["opening"]
        if values["solver"]["viscous_displacement"] is None:
            del values["solver"]["viscous_displacement"]
        if self.limit == Limit():
            del values["limit"]
        del values["design"]["cases"]
        if not any(values["design"].values()):
            del values["design"]
        canonical = json.dumps(values, sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(canonical.encode()).hexdigest()

    @property
    def ranges_sha256(self) -> str | None:
        """SHA-256 (hex) that the estimates of one scene share, whatever mesh they run on; None without ranges."""
        return self._of_ranges

    @property
    def estimate(self) -> str | None:
        """Which values of the ranges of its text the scene has: low, best or high; None without ranges."""
        return self._estimate

    @property
    def source_text(self) -> str:
        """The TOML text that the scene was read from; `to_toml()` for one made or changed in Python."""
        text, digest = self._source
        return text if text and digest == self.sha256 else self.to_toml()

    def to_toml(self) -> str:
        """Return the whole scene as TOML; loading it gives an equal scene."""
        return to_toml(self)

    def replace(self, **sections: Any) -> Self:
        """Return a validated copy with some values changed: `scene.replace(mesh={"preset": "paper"})`.

        A table is merged key by key; anything else (title, paths) is replaced. Paths take the place of a fan, too.
        """
        data = self.model_dump(exclude_unset=True)
        if "paths" in sections:
            data["springs"] = {}
        for name, change in sections.items():
            merge = isinstance(change, dict) and isinstance(data.get(name, None), dict)
            data[name] = {**data[name], **change} if merge else change
        changed = self.model_validate(data)
        changed._of_ranges, changed._estimate = self._of_ranges, self._estimate
        return changed

    def _repr_html_(self) -> str:
        """Show the scene in a notebook."""
        return scene_card(self)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Scene) and self.model_dump() == other.model_dump()

    def __hash__(self) -> int:
        return hash(self.sha256)


def _digested(then: list[Any]) -> list[Any]:
    """Return what counts of a part that follows: what was not there in earlier scenes, only where it is given."""
    if then[5] is not None or (then[3] is None and then[4] is not None):
        return then
    return then[:5] if then[3] is not None else then[:3]


# --- a scene in words ---

MOST_LAYERS = 4  # that are named


def caisson_text(scene: SceneSections, vertical_load: float | None = None) -> str:
    """Return size, behaviour and vertical load of the caisson; ``vertical_load`` (N) is the number behind a word."""
    each = scene.caisson
    ratio = each.skirt_length / each.outer_diameter
    number = vertical_load if isinstance(each.vertical_load, str) else each.vertical_load
    load = "" if number is None else f"{1e-6 * number:.4g} MN"
    if isinstance(each.vertical_load, str):
        load = f"{load} ({each.vertical_load})" if load else each.vertical_load
    return (
        f"D {each.outer_diameter:g} m, L {each.skirt_length:g} m (L/D {ratio:.2g}), skirt "
        f"{1e3 * each.skirt_thickness:g} mm, {each.behaviour}; vertical load {load}"
    )


def ground_text(scene: SceneSections) -> str:
    """Return the layers with their laws, and the drainage."""
    layers = [each for each in scene.ground.strata if not each.like]
    laws = [", ".join((each.law, *(own.text for own in (each.tables.get(CYCLIC),) if own))) for each in layers]
    shown = list(zip(layers, laws, strict=True))[:MOST_LAYERS]
    names = ", ".join(f"{each.name} ({law}) from {each.top:g} m" for each, law in shown)
    more = f" and {len(layers) - MOST_LAYERS} more layers" if len(layers) > MOST_LAYERS else ""
    return f"{names}{more}; {scene.layer_drainage}"


def paths_text(scene: SceneSections) -> str:
    """Return how many load paths of each kind a run computes, and how many are held back."""
    kinds = Counter(path.kind for path in scene.all_paths)
    held = sum(path.role == "held-back" for path in scene.all_paths)
    words = ", ".join(f"{number} {kind}" for kind, number in kinds.items())
    return words + (f"; {held} held back" if held else "")


def scene_card(scene: SceneSections) -> str:
    """Return a scene as HTML of a few kB."""
    layers = [(each.top, each.name) for each in scene.ground.strata if not each.like]
    size = scene.caisson.outer_diameter, scene.caisson.skirt_length
    lines = {
        "caisson": caisson_text(scene),
        "ground": ground_text(scene),
        "paths": paths_text(scene),
        "mesh": f"{scene.mesh.preset}, refinement {scene.mesh.refinement:g}, {scene.mesh.discretisation}",
    }
    return card(scene.title, lines, [caisson_drawing(*size, layers if len(layers) > 1 else ())])
