# SPDX-License-Identifier: MIT
"""Paths that leave the plane of one load: which keys they use, and where they cannot be computed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from pysprings.core.path_kinds import CALIBRATION, LOADS, MOTIONS, UNITS
from pysprings.scene.positions import Clash, KeyPath

if TYPE_CHECKING:
    from pysprings.scene.scene_sections import SceneSections
    from pysprings.scene.sections import Path

TURNS = tuple(name for name in MOTIONS if name != "w")  # motions of a path of kind "motion": w is free, or held
_USES = {
    "twist": ("twist", "report_at", "then"),
    "circle": ("radius", "direction"),
    "motion": TURNS,
    "load": LOADS,
    "pull": ("lateral_displacement", "arm", "direction", "then"),
    "translation": ("lateral_displacement", "direction", "then"),
}
_KEYS = (*UNITS, "arm", "arm_from", "load_angle", "rate", "direction", "report_at", "then", *TURNS, *LOADS)


def space_clashes(scene: SceneSections) -> Iterator[Clash]:
    """Check that the model of a scene carries its paths that leave a plane."""
    for index, path in enumerate(scene.paths):
        if path.in_space:
            here: KeyPath = ("path", index)
            for key, text in _refusals(scene):
                yield Clash((here, key), f"path '{path.name}' leaves the plane of one load: {text}")
    if scene.springs.reach is not None and scene.springs.directions:
        if not scene.springs.memory:
            keys = ("springs", "directions"), ("springs", "memory")
            yield Clash(keys, "springs with memory alone answer in all directions: memory = true is needed, too")
        for key, text in _refusals(scene):
            yield Clash((("springs", "directions"), key), f"its paths leave the plane of one load: {text}")


def _refusals(scene: SceneSections) -> Iterator[tuple[KeyPath, str]]:
    if scene.discretisation != "fourier":
        yield ("mesh", "discretisation"), 'bricks have half of a caisson; it needs mesh.discretisation = "fourier"'
    if scene.drainage.mode != "drained":
        yield ("drainage", "mode"), 'it needs drainage.mode = "drained" (undrained clay: law "tresca" or "von-mises")'
    if scene.caisson.behaviour != "rigid":
        yield ("caisson", "behaviour"), 'it needs caisson.behaviour = "rigid"'
    if scene.output.paraview:
        yield ("output", "paraview"), "output.paraview writes the half of a caisson"


def space_path(here: KeyPath, path: Path) -> Iterator[Clash]:
    """Check one path that leaves a plane."""
    kind, where = path.kind, (*here, "kind")
    uses = _USES.get(kind, ())
    for name in _KEYS:
        value = getattr(path, name)
        if name not in uses and value not in (None, ()) and (value or name != "arm"):
            yield Clash(((*here, name), where), f'a path of kind "{kind}" that leaves a plane does not use it')
    if not uses:
        return
    if path.role == CALIBRATION:
        text = 'fans are made from paths in one plane: this path needs role = "memory" or "held-back"'
        yield Clash(((*here, "role"), where), text)
    ends = [getattr(path, name) for name in uses if name not in ("report_at", "then", "direction", "arm")]
    if not any(ends):
        named = uses[0] if len(ends) == 1 else f"one of {', '.join(uses)} other than zero"
        yield Clash((here, where), f'a path of kind "{kind}" needs {named}')
    if path.heave == "fixed" and path.V is not None:
        yield Clash(((*here, "V"), (*here, "heave")), 'heave = "fixed" imposes w: it cannot have a vertical load')
    for entry, then in enumerate(path.then):
        if then.value is None or (kind != "twist" and then.towards is None):
            form = "20 mrad" if kind == "twist" else "12 mm towards 90 deg"
            text = f'a path that leaves a plane goes on with "{form}" alone'
            yield Clash(((*here, "then", entry), (*here, "then")), text)
