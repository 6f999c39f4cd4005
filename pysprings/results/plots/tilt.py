# SPDX-License-Identifier: MIT
"""Load against rotation under loads at each height, with limits of tilt."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from pysprings.results.analysis.parts import settings
from pysprings.results.plots.overview import draw_paths, lateral_paths
from pysprings.results.plots.picture import Picture
from pysprings.results.plots.style import DEG, INK, MN, legend_beside, new_figure, plain, set_title, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LIMITS = (0.25, 0.5)  # deg: usual tolerances of a wind turbine, over its life and after installation with it


@styled
def tilt(tree: xr.DataTree, limits: Iterable[float] = LIMITS) -> Figure:
    """Draw H [MN] and M [MN m] against the size of the rotation [deg] on the free-head paths of a result or springs.

    Parameters
    ----------
    tree
        Result or spring set.
    limits
        Tilts [deg] that are marked; a limit far beyond the range is left out.
    """
    figure = new_figure(9.6, 4.2)
    left, right = figure.subplots(1, 2)
    for axes, load, unit in ((left, "H", "MN"), (right, "M", "MN m")):
        draw_tilt(axes, tree, load, limits)
        axes.set_ylabel(f"size of {load} [{unit}]")
    left.set_title("Load")
    right.set_title("Moment about the lid centre")
    set_title(figure, "Load against tilt, by height of the load", settings(tree))
    for axes in (left, right):
        legend_beside(axes, 8.0)
    return figure


def draw_tilt(axes: Axes, tree: xr.DataTree, load: str, limits: Iterable[float] = LIMITS) -> None:
    """Draw the size of a load against the size of the rotation on given axes."""
    free = lateral_paths(tree, free_head=True)
    paths = [each._replace(name=_name(each.name, each.data), data=_sizes(each.data)) for each in free]
    draw_paths(axes, paths, ("rotation", DEG), (load, MN))
    largest = max((float(path["rotation"].max()) * DEG for _, path, _ in paths), default=0.0)
    shown = [limit for limit in limits if limit <= 1.5 * largest]
    for limit in shown:
        axes.axvline(limit, color=INK, linewidth=1.0, linestyle=":", gid="limit", label="_limit")
        axes.annotate(f"{limit:g}°", (limit, 1.0), (-2, -2), xycoords=("data", "axes fraction"),
                      textcoords="offset points", va="top", ha="right", fontsize=8)  # fmt: skip
    axes.set_xlim(0.0, 1.05 * max([largest, *shown]) or 1.0)
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("size of the rotation [deg]")


def _sizes(path: xr.Dataset) -> xr.Dataset:
    names = ["H", "M", "rotation"]
    return path[[*names, "converged"]].assign({name: np.abs(path[name]) for name in names})


def _name(name: str, path: xr.Dataset) -> str:
    if "arm_m" not in path.attrs or "arm_from_m" in path.attrs:
        return name
    return plain(f"{name}: {float(path.attrs['arm_m']):.3g} m above")


PICTURE = Picture(
    name="tilt",
    caption="Load and moment against tilt, with limits of tilt",
    function=tilt,
    data=lambda view: (view.result,),
    scope="run",
    applies=lambda view: bool(lateral_paths(view.result, free_head=True)),
    section="tilt",
)
