# SPDX-License-Identifier: MIT
"""A scene in a few lines of text, and as compact HTML for notebooks."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from pysprings.core.card import caisson_drawing, card

if TYPE_CHECKING:
    from pysprings.scene.scene_sections import SceneSections

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
    names = ", ".join(f"{each.name} ({each.law}) from {each.top:g} m" for each in layers[:MOST_LAYERS])
    more = f" and {len(layers) - MOST_LAYERS} more layers" if len(layers) > MOST_LAYERS else ""
    return f"{names}{more}; {scene.layer_drainage}"


def paths_text(scene: SceneSections) -> str:
    """Return how many load paths of each kind a run computes, and how many are held back."""
    kinds = Counter(path.kind for path in scene.load_paths)
    held = sum(path.role == "held-back" for path in scene.load_paths)
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
