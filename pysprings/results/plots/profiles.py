# SPDX-License-Identifier: MIT
"""p-y curves by depth, net and by side (the paper's figure 16); p, m and t by depth at load levels of a path.

Beside p stands how much of its largest value it has reached.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pysprings.core.arrays import Array
from pysprings.core.path_kinds import driven
from pysprings.results.parts import converged
from pysprings.results.plots import style
from pysprings.results.plots.picture import Picture, depth_words, lateral_reaction, pick_depths, spread_depths
from pysprings.springs.tip_zone import edge_rings

MOST_CURVES = 8
EDGE_WORDS = "dotted: edge ring of the tip, whose p depends on the mesh; it does not set the scale"
PANELS = {"net": "net (outside + inside)", "outside": "outside of the skirt", "inside": "inside of the skirt"}


@style.styled
def py_curves(path: xr.Dataset, depths: Iterable[float] | None = None) -> Figure:
    """Draw the lateral soil reaction p [kN/m] against the displacement y [mm] of the mean fibre, by depth.

    Parameters
    ----------
    path
        One path of a result or of a spring set.
    depths
        Depths [m]; the nearest rings are drawn, and named in the title. Default: at most eight rings, evenly over it.
    """
    figure = style.new_figure(9.6, 7.4)
    grid = figure.add_gridspec(2, 2, height_ratios=[1.25, 1.0])
    places = {"net": grid[0, :], "outside": grid[1, 0], "inside": grid[1, 1]}
    for side in lateral_reaction(path):
        if side in PANELS:
            draw_py(figure.add_subplot(places[side]), path, depths, side)
    for axes in figure.axes:
        style.zero_lines(axes)
    handles, names = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside right center", title="depth")
    style.set_title(figure, "p-y curves by depth below mudline", path.attrs, EDGE_WORDS, depth_words(path, depths))
    return figure


def depth_colours(n: int) -> list[Any]:
    """Return n colours from shallow (light) to deep (dark), readable on white and in grey print."""
    return list(mpl.colormaps[style.DEPTH_COLOURS](np.linspace(0.12, 1.0, n)))


def draw_py(axes: Axes, path: xr.Dataset, depths: Iterable[float] | None = None, side: str = "net") -> None:
    """Draw p against y by depth on given axes: net, outside or inside; the edge ring does not set the scale."""
    rings = spread_depths(path, MOST_CURVES) if depths is None else pick_depths(path, depths)
    p = lateral_reaction(path)[side]
    good, edge = converged(path), edge_rings(path)
    y = path["y"].transpose("depth", "step").values
    for ring, colour in zip(rings, depth_colours(len(rings)), strict=True):
        depth, line = float(path["depth"][ring]), ":" if edge[ring] else "-"
        name = f"{depth:.2f} m"
        style.plot_path(
            axes, y[ring] * style.MM, p[ring] * style.KN, good, color=colour, linewidth=1.7, linestyle=line, label=name
        )
    within = [ring for ring in rings if not edge[ring]]
    limits_without_edge(axes, p[within] * style.KN, "y")
    style.note_unconverged(axes, good)
    axes.set(xlabel="displacement y of the mean fibre [mm]", ylabel="reaction p [kN/m]", title=PANELS[side])


def _of_lateral(name: str, caption: str, function: Callable[..., Figure]) -> Picture:
    """Return a picture of the reactions on a lateral path."""
    return Picture(
        name, caption, function, lambda view: (view.reactions,), "path", lambda view: not view.is_vertical, "springs"
    )


PY = _of_lateral("py", "p-y curves by depth", py_curves)


LEVELS = (0.25, 0.5, 0.75, 1.0)  # of the largest load of the path
# label of the axis of each quantity
QUANTITIES = {
    "p": "p [kN/m]", "m": "m [kN m/m]", "t": "t [kN/m]", "mobilisation": "p / largest p so far",
}  # fmt: skip


def level_steps(path: xr.Dataset, levels: Sequence[float] = LEVELS) -> dict[float, int]:
    """Return level -> converged step nearest to that share of the largest load (H; M on a rotation), once each."""
    load = np.abs(path["M" if driven(path.attrs) == "rotation" else "H"].values)
    good = np.flatnonzero(converged(path))
    if good.size == 0 or load[good].max() == 0.0:
        return {}
    good = good[: int(np.argmax(load[good])) + 1]
    steps = {level: int(good[np.argmin(np.abs(load[good] - level * load[good[-1]]))]) for level in levels}
    return {level: step for level, step in steps.items() if step != steps.get(levels[-1]) or level == levels[-1]}


@style.styled
def profiles(path: xr.Dataset, levels: Sequence[float] = LEVELS) -> Figure:
    """Draw p, m and t by depth at shares of the largest load, and p over its largest value at each depth.

    Hollow marks are the edge rings of the tip (`pysprings.springs.tip_zone`): the scale of p leaves them out.

    Parameters
    ----------
    path
        One path of a result or of a spring set.
    levels
        Shares of the largest load of the path.
    """
    figure = style.new_figure(9.6, 4.4)
    panels = figure.subplots(1, 4, sharey=True)
    for axes, quantity in zip(panels, QUANTITIES, strict=True):
        draw_profile(axes, path, quantity, levels)
    panels[0].set_ylabel("depth [m]")
    panels[0].set_ylim(float(path["depth_bounds"].values.max()), 0.0)
    panels[3].set_title("mobilisation")
    handles, names = panels[0].get_legend_handles_labels()
    if names:
        figure.legend(handles, names, loc="outside lower center", ncols=len(names))
    style.set_title(figure, "Reactions by depth at load levels (hollow: edge ring of the tip)", path.attrs)
    return figure


def draw_profile(axes: Axes, path: xr.Dataset, quantity: str = "p", levels: Sequence[float] = LEVELS) -> None:
    """Draw p, m, t or "mobilisation" by depth (downwards) at shares of the largest load on given axes.

    Mobilisation is p over its largest value so far at its depth.
    """
    steps, edge, depth = level_steps(path, levels), edge_rings(path), path["depth"].values
    values = _values(path, quantity, next(reversed(steps.values()), 0))
    colours = mpl.colormaps[style.LEVEL_COLOURS](np.linspace(0.1, 1.0, max(len(steps), 1)))
    for (level, step), colour in zip(steps.items(), colours, strict=False):
        word = f"{100 * level:.0f} % of the largest load"
        axes.plot(values[:, step], depth, "-", color=colour, label=word, linewidth=1.5)
        axes.plot(values[~edge, step], depth[~edge], "o", color=colour, markersize=4, label="_in")
        axes.plot(values[edge, step], depth[edge], "o", color=colour, markerfacecolor="white", markersize=5,
                  label="_edge", gid="edge")  # fmt: skip
    limits_without_edge(axes, values[~edge][:, list(steps.values())], "x")
    axes.axvline(0.0, color=style.GREY, linewidth=0.8, zorder=1)
    axes.locator_params(axis="x", nbins=4)
    axes.set_xlabel(QUANTITIES[quantity])
    axes.set_ylim(float(path["depth_bounds"].values.max()), 0.0)
    if quantity == "mobilisation":
        axes.set_xlim(0.0, 1.05)


def _values(path: xr.Dataset, quantity: str, last: int) -> Array:
    """Return a quantity (depth, step) in the unit of its axis; `last` is the step up to which p is the largest."""
    if quantity in ("m", "t"):
        values: Array = path[quantity].sum("side").transpose("depth", "step").values
        return style.KN * values
    p = lateral_reaction(path)["net"]
    if quantity == "p":
        return style.KN * p
    largest = np.maximum.accumulate(np.abs(p), axis=1)[:, last]
    return np.abs(p) / np.where(largest > 0.0, largest, 1.0)[:, None]


def limits_without_edge(axes: Axes, values: Array, which: str) -> None:
    """Set the limits of an axis so that they hold the values and zero, with room for the beginning of an edge ring."""
    if values.size == 0 or not np.isfinite(values).any():
        return
    low, high = min(float(np.nanmin(values)), 0.0), max(float(np.nanmax(values)), 0.0)
    room = 0.15 * ((high - low) or 1.0)
    (axes.set_xlim if which == "x" else axes.set_ylim)(low - room, high + room)


PICTURE = _of_lateral("profiles", "Reactions by depth at load levels; mobilisation", profiles)
