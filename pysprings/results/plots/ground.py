# SPDX-License-Identifier: MIT
"""The ground by depth beside the caisson: layers and mesh, vertical stress, stiffness, strength."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.collections import PolyCollection

from pysprings.core.errors import PyspringsError
from pysprings.results.plots import style
from pysprings.results.plots.picture import Picture, View
from pysprings.results.plots.section import quad_corners

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pysprings.scene.ground import Ground
    from pysprings.scene.model import Scene

MPA, DEGREES = 1e-6, 180.0 / np.pi
_DEEPEST = 2.5  # skirt lengths that are drawn
_DEPTHS = 41  # of each layer
_LAYERS = (style.SOIL, style.PALE)
# key of the ground, heading, factor, colour
_COLUMNS = (
    ("friction_angle_final", "friction\nangle [deg]", DEGREES, style.PURPLE),
    ("undrained_shear_strength", "su [kPa]", style.KPA, style.VERMILLION),
)


@lru_cache(maxsize=4)
def _scene(text: str) -> Scene | None:
    """Return the scene of a result; None where this version cannot read it."""
    from pysprings.scene.load import parse_scene

    try:
        return parse_scene(text)
    except PyspringsError:
        return None


def scene_of(view: View) -> Scene | None:
    """Return the scene of the result of a view; None where this version cannot read it."""
    return _scene(str(view.result.attrs.get("scene_toml", "")))


def _applies(view: View) -> bool:
    """Return whether the ground of the run differs from depth to depth, or is undrained clay."""
    scene = scene_of(view)
    return scene is not None and not (scene.ground.is_uniform and not scene.ground.total_stress)


@style.styled
def ground_profile(view: View) -> Figure:
    """Draw layers, caisson and mesh, and by depth vertical effective stress, G, friction angle and su.

    Raises ValueError where the result does not hold its scene.
    """
    scene = scene_of(view)
    if scene is None:
        raise ValueError("the result does not hold its scene")
    ground = scene.ground
    columns = [each for each in _COLUMNS if any(each[0] in stratum.values for stratum in ground.strata)]
    figure = style.new_figure(9.0, 5.2)
    widths = [1.6, *(2 + len(columns)) * [1.0]]
    panels = figure.subplots(1, len(widths), sharey=True, width_ratios=widths)
    deepest = min(_DEEPEST * scene.caisson.skirt_length, scene.extent.ground)
    draw_section(panels[0], view, scene, deepest)
    _draw_curves(panels[1], ground, deepest, "vertical", style.KPA, style.BLUE, "vertical effective\nstress [kPa]")
    _draw_curves(panels[2], ground, deepest, "shear", MPA, style.GREEN, "shear modulus\nG [MPa]")
    for axes, (key, heading, factor, colour) in zip(panels[3:], columns, strict=True):
        _draw_curves(axes, ground, deepest, key, factor, colour, heading)
    for axes in panels[1:]:
        axes.axhline(scene.caisson.skirt_length, color=style.STEEL, linewidth=0.8, linestyle="--")
        axes.set_xlim(left=0.0)
    panels[0].set_ylim(deepest, 0.0)
    panels[0].set_ylabel("depth [m]")
    style.set_title(figure, "Ground by depth", view.with_settings(view.path).attrs, "dashed: level of the skirt tip")
    return figure


def draw_section(axes: Axes, view: View, scene: Scene, deepest: float) -> None:
    """Draw layers with their names, the mesh where it was kept, and the caisson."""
    radius = 0.5 * scene.caisson.outer_diameter
    for number, stratum in enumerate(scene.ground.strata):
        if stratum.top < deepest:
            axes.axhspan(stratum.top, min(stratum.bottom, deepest), color=_LAYERS[number % 2], zorder=0)
            name = style.plain(stratum.name[:40])
            axes.annotate(name, (-2.9 * radius, stratum.top), (2, -3), textcoords="offset points", va="top", fontsize=8)
    if view.section is not None:
        cells = PolyCollection(list(quad_corners(view.section)), facecolor="none", edgecolor="#9a8f78", linewidth=0.3)
        cells.set_gid("mesh")
        axes.add_collection(cells)
    side = scene.caisson.skirt_length
    axes.plot(
        [-radius, -radius, radius, radius], [side, 0.0, 0.0, side], color=style.STEEL, linewidth=3.0, gid="caisson"
    )
    axes.set_xlim(-3.0 * radius, 3.0 * radius)
    axes.set_xlabel("x [m]")
    axes.grid(False)


def _draw_curves(
    axes: Axes, ground: Ground, deepest: float, key: str, factor: float, colour: str, heading: str
) -> None:  # fmt: skip
    """Draw a value of the ground, a line for each layer that has it; values of one layer do not reach into the next."""
    for stratum in ground.strata:
        if stratum.top >= deepest or (key not in (*stratum.values, "vertical", "shear")):
            continue
        depth = np.linspace(stratum.top, min(stratum.bottom, deepest), _DEPTHS)
        of = {"vertical": stratum.vertical_stress, "shear": stratum.shear_modulus}
        value = of[key](depth) if key in of else stratum.value(key, depth)
        axes.plot(factor * value, depth, color=colour, gid=key)
    axes.set_xlabel(heading)


PICTURE = Picture(
    "ground",
    "Ground by depth: layers with the caisson and the mesh; vertical effective stress, shear modulus and strength.",
    ground_profile,
    scope="run",
    applies=_applies,
    section="ground",
)
