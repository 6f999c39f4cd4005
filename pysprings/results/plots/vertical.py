# SPDX-License-Identifier: MIT
"""Vertical springs: the vertical load and what carries it, and t by depth, over the vertical displacement."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pysprings.results.analysis.parts import converged
from pysprings.results.plots.data import abscissa, spread_depths, unit_text
from pysprings.results.plots.load import SURFACES
from pysprings.results.plots.picture import Picture
from pysprings.results.plots.reactions import MOST_CURVES, depth_colours
from pysprings.results.plots.style import (
    INK,
    KN,
    SURFACE_COLOURS,
    legend_beside,
    new_figure,
    note_unconverged,
    plot_path,
    set_title,
    styled,
    zero_lines,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@styled
def vertical_springs(path: xr.Dataset) -> Figure:
    """Draw the vertical load V [N] with its parts, and the vertical reaction t [kN/m] by depth, over w [mm].

    Parameters
    ----------
    path
        A vertical path of a result: w [m], V [N] and V of each surface, t [N/m] by depth, side and step.
    """
    figure = new_figure(9.6, 4.8)
    left, right = figure.subplots(1, 2)
    x, label = abscissa(path)
    good = converged(path)
    factor, unit = unit_text(path["V"].values)
    plot_path(left, x, path["V"].values * factor, good, color=INK, linewidth=2.4, label="total V")
    for surface, name in SURFACES.items():
        if f"V_{surface}" in path:
            values = path[f"V_{surface}"].values * factor
            plot_path(left, x, values, good, color=SURFACE_COLOURS[surface], label=name)
    left.set_ylabel(f"V [{unit}], down +")
    left.set_title("Vertical load and the surfaces that carry it")
    _reactions(right, path, x)
    for axes in (left, right):
        axes.set_xlabel(label)
        zero_lines(axes)
        if x[-1] < x[0]:
            axes.invert_xaxis()
    legend_beside(left)
    legend_beside(right, title="depth")
    set_title(figure, "Vertical springs", path.attrs)
    return figure


def _reactions(axes: Axes, path: xr.Dataset, x: np.ndarray) -> None:
    good, rings = converged(path), spread_depths(path, MOST_CURVES)
    t = path["t"].sum("side").transpose("depth", "step").values * KN
    for ring, colour in zip(rings, depth_colours(len(rings)), strict=True):
        label = f"{float(path['depth'][ring]):.2f} m"
        plot_path(axes, x, t[ring], good, color=colour, linewidth=1.7, label=label)
    note_unconverged(axes, good)
    axes.set_ylabel("reaction t [kN/m], both sides")
    axes.set_title("Vertical reaction by depth")


PICTURE = Picture(
    name="vertical",
    caption="Vertical springs",
    function=vertical_springs,
    data=lambda view: (view.path,),
    applies=lambda view: view.is_vertical,
    section="",
)
