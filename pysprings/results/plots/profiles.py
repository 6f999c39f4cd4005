# SPDX-License-Identifier: MIT
"""Reactions by depth at load levels of a path: p, m and t, and how much of its largest value p has reached."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
import xarray as xr

from pysprings.core.path_kinds import driven
from pysprings.results.analysis.parts import converged
from pysprings.results.plots.data import lateral_reaction
from pysprings.results.plots.picture import Picture
from pysprings.results.plots.style import KN, new_figure, set_title, styled
from pysprings.springs.edge import edge_rings

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

LEVELS = (0.25, 0.5, 0.75, 1.0)  # of the largest load of the path


def level_steps(path: xr.Dataset, levels: Sequence[float] = LEVELS) -> dict[float, int]:
    """Return level -> converged step nearest to that share of the largest load (H; M on a rotation), once each."""
    load = np.abs(path["M" if driven(path.attrs) == "rotation" else "H"].values)
    good = np.flatnonzero(converged(path))
    if good.size == 0 or load[good].max() == 0.0:
        return {}
    good = good[: int(np.argmax(load[good])) + 1]
    steps = {level: int(good[np.argmin(np.abs(load[good] - level * load[good[-1]]))]) for level in levels}
    return {level: step for level, step in steps.items() if step != steps.get(levels[-1]) or level == levels[-1]}


@styled
def profiles(path: xr.Dataset, levels: Sequence[float] = LEVELS) -> Figure:
    """Draw p, m and t by depth at shares of the largest load, and p over its largest value at each depth.

    Hollow marks are the edge rings of the tip (`pysprings.springs.edge`): the scale of p leaves them out.

    Parameters
    ----------
    path
        One path of a result or of a spring set.
    levels
        Shares of the largest load of the path.
    """
    figure = new_figure(9.6, 4.4)
    panels = figure.subplots(1, 4, sharey=True)
    p = lateral_reaction(path)["net"]
    steps = level_steps(path, levels)
    last = next(reversed(steps.values()), 0)
    largest = np.maximum.accumulate(np.abs(p), axis=1)[:, last]
    share = np.abs(p) / np.where(largest > 0.0, largest, 1.0)[:, None]
    drawn = (("p [kN/m]", KN * p), ("m [kN m/m]", KN * _net(path, "m")), ("t [kN/m]", KN * _net(path, "t")),
             ("p / largest p so far", share))  # fmt: skip
    for axes, (label, values) in zip(panels, drawn, strict=True):
        _draw(axes, path, values, steps)
        axes.set_xlabel(label)
    panels[0].set_ylabel("depth [m]")
    panels[0].set_ylim(float(path["depth_bounds"].values.max()), 0.0)
    panels[3].set_xlim(0.0, 1.05)
    panels[3].set_title("mobilisation")
    handles, names = panels[0].get_legend_handles_labels()
    if names:
        figure.legend(handles, names, loc="outside lower center", ncols=len(names))
    set_title(figure, "Reactions by depth at load levels (hollow: edge ring of the tip)", path.attrs)
    return figure


def _net(path: xr.Dataset, name: str) -> NDArray[np.float64]:
    values: NDArray[np.float64] = path[name].sum("side").transpose("depth", "step").values
    return values


def _draw(axes: Axes, path: xr.Dataset, values: NDArray[np.float64], steps: dict[float, int]) -> None:
    edge, depth = edge_rings(path), path["depth"].values
    colours = mpl.colormaps["cividis_r"](np.linspace(0.1, 1.0, max(len(steps), 1)))
    for (level, step), colour in zip(steps.items(), colours, strict=False):
        word = f"{100 * level:.0f} % of the largest load"
        axes.plot(values[:, step], depth, "-", color=colour, label=word, linewidth=1.5)
        axes.plot(values[~edge, step], depth[~edge], "o", color=colour, markersize=4, label="_in")
        axes.plot(values[edge, step], depth[edge], "o", color=colour, markerfacecolor="white", markersize=5,
                  label="_edge", gid="edge")  # fmt: skip
    limits_without_edge(axes, values[~edge][:, list(steps.values())], "x")
    axes.axvline(0.0, color="#7a7a7a", linewidth=0.8, zorder=1)
    axes.locator_params(axis="x", nbins=4)


def limits_without_edge(axes: Axes, values: NDArray[np.float64], which: str) -> None:
    """Set the limits of an axis so that they hold the values and zero, with room for the beginning of an edge ring."""
    if values.size == 0 or not np.isfinite(values).any():
        return
    low, high = min(float(np.nanmin(values)), 0.0), max(float(np.nanmax(values)), 0.0)
    room = 0.15 * ((high - low) or 1.0)
    (axes.set_xlim if which == "x" else axes.set_ylim)(low - room, high + room)


PICTURE = Picture(
    name="profiles",
    caption="Reactions by depth at load levels; mobilisation",
    draw=lambda view: profiles(view.reactions),
    applies=lambda view: not view.is_vertical,
    section="springs",
)
