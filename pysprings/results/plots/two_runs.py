# SPDX-License-Identifier: MIT
"""The curves of runs over each other: load, rotation or moment, and p-y at some depths, path by path."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np

from pysprings.core.path_kinds import driven
from pysprings.results.plots import style
from pysprings.results.plots.picture import abscissa

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LOOKS = ((style.BLUE, "-"), (style.VERMILLION, "--"), (style.GREEN, "-."), (style.PURPLE, ":"))
DEPTHS = (0.15, 0.5, 0.85)  # of the skirt
NOISE = 1e-12  # deg, of a translation


@style.styled
def overlay(runs: Mapping[str, xr.Dataset], name: str) -> Figure:
    """Draw one path as some runs recorded it, by name of the run: load, rotation, and p-y at three depths."""
    figure = style.new_figure(11.4, 4.2)
    left, middle, right = figure.subplots(1, 3)
    for (run, path), (colour, line) in zip(runs.items(), cycle(LOOKS), strict=False):
        x, label = abscissa(path)
        load = {"u": "H", "w": "V", "rotation": "M"}[driven(path.attrs)]
        left.plot(x, 1e-3 * path[load].values, line, color=colour, label=style.plain(run))
        left.set_xlabel(label)
        left.set_ylabel(f"{load} [{'kN m' if load == 'M' else 'kN'}]")
        turned = style.DEG * path["rotation"].values
        middle.plot(x, np.where(np.abs(turned) < NOISE, 0.0, turned), line, color=colour)
        middle.set_xlabel(label)
        middle.set_ylabel("rotation [deg]")
        _springs(right, path, colour, line)
    for axes in (left, middle, right):
        style.zero_lines(axes)
    left.legend()
    figure.suptitle(f"path {style.plain(name)}: {' and '.join(style.plain(run) for run in runs)}")
    return figure


def _springs(axes: Axes, path: xr.Dataset, colour: str, line: str) -> None:
    depth = path["depth"].values
    p = path["p"].transpose("depth", "step").values
    y = path["y"].transpose("depth", "step").values
    for share in DEPTHS:
        k = int(np.argmin(np.abs(depth - share * float(path["depth_bounds"].values[-1, 1]))))
        axes.plot(style.MM * y[k], 1e-3 * p[k], line, color=colour, linewidth=1.2)
    axes.set_xlabel("y [mm]")
    axes.set_ylabel("p [kN/m], three depths")
