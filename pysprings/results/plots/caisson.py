# SPDX-License-Identifier: MIT
"""The first picture of the report: the caisson in its ground with the load, and the load curve with its error."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pysprings.core.path_kinds import driven, has_free_head
from pysprings.macro.spring_sets import SPRING_SETS
from pysprings.results.parts import converged
from pysprings.results.plots import style
from pysprings.results.plots.comparison import LOOKS, SMALLEST
from pysprings.results.plots.ground import draw_section, scene_of
from pysprings.results.plots.picture import Picture, View, unit_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pysprings.scene.model import Scene

SETS = ("fan", "full", "py")  # the best first
HIGHEST, DEEPEST = 1.2, 1.7  # diameters above mudline, skirt lengths below, that are drawn
SIZE = 0.9  # of arrows, radii


@style.styled
def caisson(view: View) -> Figure:
    """Draw caisson, ground and load of a path; H over u (M over the rotation) of full model and best springs.

    Raises ValueError where the result does not hold its scene, or there is no prediction.
    """
    scene, kind = scene_of(view), next((name for name in SETS if name in view.predictions), None)
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
    words = f"H at {arm:.4g} m" if has_free_head(attrs) else "motion of the lid"
    tip = 0.0 if at < -0.2 * radius else -1.05 * radius  # beside the lid
    axes.annotate("", (tip, at), (tip - SIZE * radius, at), **arrow)
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
    size, ours = (np.abs(each[load].values[keep][:n]) for each, keep in ((full, good), (found, slice(None))))
    shown = size > SMALLEST * size.max(initial=0.0)
    error = f"{100.0 * np.abs(ours[shown] / size[shown] - 1.0).max():.2g} %" if shown.any() else "not known"
    error += f", first {n} of {whole} states alone" * (n < whole)
    axes.set(xlabel=label, ylabel=f"{load} [{unit}{' m' if turns else ''}]")
    axes.set_title(f"largest error of the springs in {load}: {error}")
    axes.legend(loc="lower right")


PICTURE = Picture(
    name="caisson",
    caption="The caisson in its ground with the load; the load of the full model and of the springs on this path",
    function=caisson,
    applies=lambda view: not view.is_vertical and bool(view.predictions) and scene_of(view) is not None
    and any(name in view.predictions for name in SETS),
    section="first",
)  # fmt: skip
