# SPDX-License-Identifier: MIT
"""The curves of two runs over each other: load, rotation or moment, and p-y at some depths, path by path."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pysprings.core.path_kinds import driven
from pysprings.results.plots.data import abscissa
from pysprings.results.plots.style import BLUE, DEG, MM, VERMILLION, new_figure, plain, styled, zero_lines
from pysprings.springs.dataset import get_path
from pysprings.springs.sums import net_p

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pysprings.results.analysis.two_runs import Run

DEPTHS = (0.15, 0.5, 0.85)  # of the skirt


@styled
def overlay(first: Run, second: Run, name: str) -> Figure:
    """Draw one path of two runs: first solid, second dashed."""
    figure = new_figure(9.6, 4.2)
    left, middle, right = figure.subplots(1, 3)
    for run, colour, line in ((first, BLUE, "-"), (second, VERMILLION, "--")):
        path = get_path(run.result, name)
        x, label = abscissa(path)
        load = {"u": "H", "w": "V", "rotation": "M"}[driven(path.attrs)]
        left.plot(x, 1e-3 * path[load].values, line, color=colour, label=plain(run.name))
        left.set_xlabel(label)
        left.set_ylabel(f"{load} [{'kN m' if load == 'M' else 'kN'}]")
        middle.plot(x, DEG * path["rotation"].values, line, color=colour)
        middle.set_xlabel(label)
        middle.set_ylabel("rotation [deg]")
        _springs(right, run, name, colour, line)
    for axes in (left, middle, right):
        zero_lines(axes)
    left.legend()
    figure.suptitle(f"path {plain(name)}: {plain(first.name)} and {plain(second.name)}")
    return figure


def _springs(axes: Axes, run: Run, name: str, colour: str, line: str) -> None:
    path = get_path(run.result, name)
    depth = path["depth"].values
    p = net_p(path.assign(p=path["p_component"])).values if "p_component" in path else path["p"].values
    y = path["y"].transpose("depth", "step").values
    for share in DEPTHS:
        k = int(np.argmin(np.abs(depth - share * float(path["depth_bounds"].values[-1, 1]))))
        axes.plot(MM * y[k], 1e-3 * p[k], line, color=colour, linewidth=1.2)
    axes.set_xlabel("y [mm]")
    axes.set_ylabel("p [kN/m], three depths")
