# SPDX-License-Identifier: MIT
"""Secant stiffness against the size of the motion: H/u over u/D, M/rotation over the rotation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from pysprings.results.analysis.parts import ROUNDING, converged, load_sizes, settings
from pysprings.results.plots.overview import lateral_paths
from pysprings.results.plots.picture import Picture
from pysprings.results.plots.style import GREY, MN, new_figure, plain, set_title, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SMALLEST = 1e-9  # m or rad: a smaller motion has no secant


@styled
def secant_stiffness(tree: xr.DataTree) -> Figure:
    """Draw H/u [MN/m] against u/D, and M/rotation [MN m/rad] against rotation [rad], of all lateral paths.

    The initial stiffness with the other motion held is a line. On a path with a free head the secant is below it: its
    head moves and turns.
    """
    figure = new_figure(9.6, 4.8)
    left, right = figure.subplots(1, 2)
    diameter = float(tree.attrs.get("outer_diameter_m", np.nan))
    known = diameter if np.isfinite(diameter) else 1.0
    sizes = load_sizes((path for _, path, _ in lateral_paths(tree)), known)
    least = ROUNDING * max(sizes.values())
    draw_secant(left, tree, "H", "u", known, least / known)
    left.set(xlabel="u / D" if np.isfinite(diameter) else "u [m]", ylabel="H / u [MN/m]", title="Horizontal motion")
    draw_secant(right, tree, "M", "rotation", 1.0, least)
    right.set(xlabel="rotation [rad]", ylabel="M / rotation [MN m/rad]", title="Rotation")
    set_title(figure, "Secant stiffness against motion (dashed: held back)", settings(tree))
    lines = {str(line.get_label()): line for axes in (left, right) for line in axes.get_lines()}
    named = {name: line for name, line in lines.items() if not name.startswith("_")}
    figure.legend(list(named.values()), list(named), loc="outside lower center", ncols=5, fontsize=8)
    return figure


def draw_secant(axes: Axes, tree: xr.DataTree, load: str, motion: str, over: float, least: float = 0.0) -> None:
    """Draw load over motion against motion / `over` on given axes, for the states where the load drives the motion.

    Loads up to `least` (N or N m) are zero.
    """
    for name, path, colour in lateral_paths(tree):
        x, y = path[motion].values, path[load].values
        shown = converged(path) & (np.abs(x) > SMALLEST) & (x * y > 0.0) & (np.abs(y) > least)
        if shown.sum() > 1:
            line = "--" if path.attrs.get("role") == "held-back" else "-"
            size, secant = np.abs(x[shown]) / over, MN * y[shown] / x[shown]
            axes.plot(size, secant, line, color=colour, label=plain(name), linewidth=1.5)
    axes.set_xscale("log")
    axes.set_ylim(bottom=0.0)
    if "stiffness_initial" in tree.dataset and tree.dataset["stiffness_initial"].shape == (3, 3):
        k = {"u": 0, "rotation": 2}[motion]
        value = MN * float(tree.dataset["stiffness_initial"].values[k, k])
        axes.axhline(value, color=GREY, linestyle=":", gid="initial", label="_initial")
        axes.set_ylim(top=1.15 * max(value, axes.get_ylim()[1] / 1.15))


PICTURE = Picture(
    name="secant_stiffness",
    caption="Secant stiffness against motion; dotted: initial stiffness of the full model",
    function=secant_stiffness,
    data=lambda view: (view.result,),
    scope="run",
    applies=lambda view: bool(lateral_paths(view.result)),
    section="capacity",
)
