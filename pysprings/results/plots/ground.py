# SPDX-License-Identifier: MIT
"""The ground by depth beside the caisson, and the first picture of the report: the caisson in its ground with the load.

By depth: layers and mesh, vertical stress, stiffness, strength; beside the load its curve, and the error of springs.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.collections import PolyCollection

from pysprings.core.errors import PyspringsError
from pysprings.core.path_kinds import MEMORY, driven, has_free_head, height_of_load, turns_back
from pysprings.core.text import percent
from pysprings.macro import measures
from pysprings.macro.spring_sets import SPRING_SETS
from pysprings.results.parts import converged
from pysprings.results.plots import style
from pysprings.results.plots.comparison import LOOKS
from pysprings.results.plots.overview import SMALLEST
from pysprings.results.plots.picture import Picture, View, skirt_length, unit_text
from pysprings.results.plots.section import quad_corners
from pysprings.scene.soils import SOIL_LAWS
from pysprings.springs.path import SpringPath

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pysprings.scene.ground import Ground
    from pysprings.scene.model import Scene


MPA, DEGREES = 1e-6, 180.0 / np.pi
_SU, _AFTER = "undrained_shear_strength", "cyclic_strength_Pa"
_DEEPEST = 2.5  # skirt lengths that are drawn
_DEPTHS = 41  # of each layer
_LAYERS = (style.SOIL, style.PALE)
# key of the ground, heading, factor, colour
_COLUMNS = (
    ("friction_angle_final", "friction\nangle [deg]", DEGREES, style.PURPLE),
    (_SU, "su [kPa]", style.KPA, style.VERMILLION),
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
        shown = SOIL_LAWS[stratum.law].shown
        after = [shown(stratum, each).get(_AFTER, np.nan) for each in depth if key == _SU]
        if np.isfinite(after).any():
            axes.plot(factor * np.array(after), depth, color=colour, linestyle=":", gid=_AFTER)
            heading = f"{heading.splitlines()[0]}\ndotted: after cycles"
    axes.set_xlabel(heading)


PICTURE = Picture(
    "ground",
    "Ground by depth: layers with the caisson and the mesh; vertical effective stress, shear modulus and strength.",
    ground_profile,
    scope="run",
    applies=_applies,
    section="ground",
)


SETS = ("fan", "full", "py")  # the best first
HIGHEST, DEEPEST = 1.2, 1.7  # diameters above mudline, skirt lengths below, that are drawn
SIZE = 0.9  # of arrows, radii


@style.styled
def caisson(view: View) -> Figure:
    """Draw caisson, ground and load of a path; H over u (M over the rotation) of full model and best springs.

    Raises ValueError where the result does not hold its scene, or there is no prediction.
    """
    sets = (MEMORY, *SETS) if turns_back(view.path.attrs) else SETS
    scene, kind = scene_of(view), next((name for name in sets if name in view.predictions), None)
    if scene is None or kind is None:
        raise ValueError("the result holds no scene, or no springs of the path")
    figure = style.new_figure(9.6, 4.4)
    left, right = figure.subplots(1, 2)
    _in_ground(left, view, scene)
    _curve(right, view, kind)
    style.set_title(figure, "", view.with_settings(view.path).attrs)
    return figure


def _in_ground(axes: Axes, view: View, scene: Scene) -> None:
    """Draw the caisson in its layers, with H at its height, or the motion that is imposed, and V."""
    radius, side = 0.5 * scene.caisson.outer_diameter, scene.caisson.skirt_length
    deepest, attrs = min(DEEPEST * side, scene.extent.ground), view.path.attrs
    draw_section(axes, view, scene, deepest)
    arm = float(attrs.get("arm_m", 0.0)) if has_free_head(attrs) else 0.0
    at = -min(max(arm, 0.0), HIGHEST * 2.0 * radius)
    arrow: Any = {"arrowprops": {"arrowstyle": "-|>", "color": style.VERMILLION, "linewidth": 2.2}, "va": "center"}
    tip = 0.0 if at < -0.2 * radius else -1.05 * radius  # beside the lid
    shown = view.path["H" if has_free_head(attrs) else "u"].values[converged(view.path)]
    turns = not has_free_head(attrs) and np.abs(shown).max(initial=0.0) <= SMALLEST
    words = "rotation alone" if turns else "motion of the lid"
    if has_free_head(attrs):
        words = "H, height varies" if height_of_load(attrs) is None else f"H at {arm:.4g} m"
    along = ((tip, at), (tip - SIZE * radius, at))
    if not turns:
        axes.annotate("", *(along[::-1] if shown.size and shown[-1] < 0.0 else along), **arrow)
    axes.annotate(words, (tip - 0.5 * SIZE * radius, at), (0, 5), textcoords="offset points", ha="center", va="bottom")
    V = float(view.path["V"].values[0]) if "V" in view.path else np.nan
    if np.isfinite(V):
        top, sign = at - 0.9 * SIZE * radius, -1.0 if V >= 0.0 else 1.0
        ends = ((0.0, at), (0.0, top)) if sign < 0.0 else ((0.0, top), (0.0, at))
        axes.annotate("", *ends, **arrow)
        axes.annotate(f"V {V * style.MN:.4g} MN", (0.0, top), (4, 0), textcoords="offset points", va="center")
    if at < 0.0:
        axes.plot([0.0, 0.0], [at, 0.0], color=style.STEEL, linewidth=1.5)
    axes.set_ylim(deepest, at - 1.4 * SIZE * radius)
    axes.set_ylabel("depth [m]")
    axes.set_aspect("equal", adjustable="box")


def _curve(axes: Axes, view: View, kind: str) -> None:
    """Draw the load over the motion of both models; the title has the largest difference."""
    full, found = view.path, view.predictions[kind]
    turns = driven(full.attrs) == "rotation"
    load, motion, label = ("M", "rotation", "rotation [mrad]") if turns else ("H", "u", "u of the lid centre [mm]")
    good, (factor, unit) = converged(full), unit_text(full[load].values)
    colour, dash, _ = LOOKS[kind]
    for data, look in ((full, {"color": style.INK, "linewidth": 2.6, "label": "full model"}),
                       (found, {"color": colour, "linestyle": dash, "label": SPRING_SETS[kind].label})):  # fmt: skip
        style.plot_path(axes, data[motion].values * style.MM, data[load].values * factor, converged(data), **look)
    whole = int(good.sum())
    n = min(found.sizes["step"], whole)
    path = SpringPath(str(full.attrs["path"]), full.isel(step=np.flatnonzero(good)[:n]), skirt_length(full))
    errors = measures.errors(path, found.isel(step=slice(n)), measures.abscissa(path), (load,))
    worst = abs(errors[f"{load}_error_max_pct"])
    error = percent(worst) if np.isfinite(worst) else "not known"
    error += f", first {n} of {whole} states alone" * (n < whole)
    axes.set(xlabel=label, ylabel=f"{load} [{unit}{' m' if turns else ''}]")
    axes.set_title(f"largest error of the springs in {load}: {error}")
    axes.legend(loc="lower right")


CAISSON = Picture(
    name="caisson",
    caption="The caisson in its ground with the load; the load of the full model and of the springs on this path",
    function=caisson,
    applies=lambda view: not view.is_vertical and bool(view.predictions) and scene_of(view) is not None
    and any(name in view.predictions for name in SETS),
    section="first",
)  # fmt: skip
