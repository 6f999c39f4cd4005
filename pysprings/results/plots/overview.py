# SPDX-License-Identifier: MIT
"""All lateral paths of a run over each other: load against displacement, moment against rotation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import matplotlib as mpl
import numpy as np
import xarray as xr

from pysprings.core.path_kinds import PATH_KINDS
from pysprings.results.analysis.parts import converged, settings
from pysprings.results.plots.picture import Picture
from pysprings.results.plots.style import (
    DEG,
    MM,
    MN,
    PATH_COLOURS,
    legend_beside,
    new_figure,
    plain,
    plot_path,
    set_title,
    styled,
    zero_lines,
)
from pysprings.springs.dataset import path_dataset, path_names

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class LateralPath(NamedTuple):
    """A path that moves the caisson sideways, with the colour that it has in all pictures of its run."""

    name: str
    data: xr.Dataset
    colour: Any


def lateral_paths(tree: xr.DataTree, free_head: bool = False) -> list[LateralPath]:
    """Return the paths that move the caisson sideways; of those with a free head alone."""
    found = []
    for name in path_names(tree):
        path = path_dataset(tree, name)
        kind = PATH_KINDS[str(path.attrs["kind"])]
        if kind.drives != "w" and converged(path).sum() > 1:
            found.append((name, path, kind.free_head))
    colours = mpl.colormaps[PATH_COLOURS](np.linspace(0.05, 0.92, len(found)))
    paths = [LateralPath(name, path, colour) for (name, path, _), colour in zip(found, colours, strict=True)]
    return [path for path, (*_, free) in zip(paths, found, strict=True) if free or not free_head]


def draw_paths(axes: Axes, paths: Sequence[LateralPath], x: tuple[str, float], y: tuple[str, float]) -> None:
    """Draw a variable of each path against another, (name, factor) each; held-back paths are dashed.

    The names of the paths are the labels of the lines.
    """
    for name, path, colour in paths:
        line = "--" if path.attrs.get("role") == "held-back" else "-"
        across, up = path[x[0]].values * x[1], path[y[0]].values * y[1]
        plot_path(axes, across, up, converged(path), color=colour, linestyle=line, label=plain(name), linewidth=1.5)
    zero_lines(axes)


@styled
def overview(tree: xr.DataTree) -> Figure:
    """Draw H [MN] against u [mm], and M [MN m] against rotation [deg], of all lateral paths of a result or springs."""
    paths = lateral_paths(tree)
    figure = new_figure(9.6, 4.4)
    left, right = figure.subplots(1, 2)
    draw_paths(left, [each for each in paths if np.ptp(each.data["u"].values) > 0], ("u", MM), ("H", MN))
    left.set(xlabel="lateral displacement u of the lid centre [mm]", ylabel="H [MN]", title="Load")
    draw_paths(
        right, [each for each in paths if np.ptp(each.data["rotation"].values) > 0], ("rotation", DEG), ("M", MN)
    )
    right.set(xlabel="rotation [deg]", ylabel="M about the lid centre [MN m]", title="Moment")
    set_title(figure, "All lateral paths (dashed: held back)", settings(tree))
    for axes in (left, right):
        legend_beside(axes, 8.0)
    return figure


PICTURE = Picture(
    name="overview",
    caption="Load and moment on all lateral paths",
    function=overview,
    data=lambda view: (view.result,),
    scope="run",
    applies=lambda view: bool(lateral_paths(view.result)),
    section="capacity",
)
