# SPDX-License-Identifier: MIT
"""p-y curves by depth, net and by side (the paper's figure 16)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np

from pysprings.results.analysis.parts import converged
from pysprings.results.plots.data import depth_words, lateral_reaction, pick_depths, spread_depths
from pysprings.results.plots.picture import Picture
from pysprings.results.plots.profiles import limits_without_edge
from pysprings.results.plots.style import (
    DEPTH_COLOURS,
    KN,
    MM,
    new_figure,
    note_unconverged,
    plot_path,
    set_title,
    styled,
    zero_lines,
)
from pysprings.springs.tip_zone import edge_rings

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_CURVES = 8
EDGE_WORDS = "dotted: edge ring of the tip, whose p depends on the mesh; it does not set the scale"
PANELS = {"net": "net (outside + inside)", "outside": "outside of the skirt", "inside": "inside of the skirt"}


@styled
def py_curves(path: xr.Dataset, depths: Iterable[float] | None = None) -> Figure:
    """Draw the lateral soil reaction p [kN/m] against the displacement y [mm] of the mean fibre, by depth.

    Parameters
    ----------
    path
        One path of a result or of a spring set.
    depths
        Depths [m]; the nearest rings are drawn, and named in the title. Default: at most eight rings, evenly over it.
    """
    figure = new_figure(9.6, 7.4)
    grid = figure.add_gridspec(2, 2, height_ratios=[1.25, 1.0])
    places = {"net": grid[0, :], "outside": grid[1, 0], "inside": grid[1, 1]}
    for side in lateral_reaction(path):
        if side in PANELS:
            draw_py(figure.add_subplot(places[side]), path, depths, side)
    for axes in figure.axes:
        zero_lines(axes)
    handles, names = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside right center", title="depth")
    set_title(
        figure,
        "p-y curves by depth below mudline",
        path.attrs,
        EDGE_WORDS,
        depth_words(path, depths),
    )
    return figure


def depth_colours(n: int) -> list[Any]:
    """Return n colours from shallow (light) to deep (dark), readable on white and in grey print."""
    return list(mpl.colormaps[DEPTH_COLOURS](np.linspace(0.12, 1.0, n)))


def draw_py(axes: Axes, path: xr.Dataset, depths: Iterable[float] | None = None, side: str = "net") -> None:
    """Draw p against y by depth on given axes: net, outside or inside; the edge ring does not set the scale."""
    rings = spread_depths(path, MOST_CURVES) if depths is None else pick_depths(path, depths)
    p = lateral_reaction(path)[side]
    good, edge = converged(path), edge_rings(path)
    y = path["y"].transpose("depth", "step").values
    for ring, colour in zip(rings, depth_colours(len(rings)), strict=True):
        depth, line = float(path["depth"][ring]), ":" if edge[ring] else "-"
        name = f"{depth:.2f} m"
        plot_path(axes, y[ring] * MM, p[ring] * KN, good, color=colour, linewidth=1.7, linestyle=line, label=name)
    within = [ring for ring in rings if not edge[ring]]
    limits_without_edge(axes, p[within] * KN, "y")
    note_unconverged(axes, good)
    axes.set_xlabel("displacement y of the mean fibre [mm]")
    axes.set_ylabel("reaction p [kN/m]")
    axes.set_title(PANELS[side])


PICTURE = Picture(
    name="py",
    caption="p-y curves by depth",
    function=py_curves,
    data=lambda view: (view.reactions,),
    applies=lambda view: not view.is_vertical,
    section="springs",
)
