# SPDX-License-Identifier: MIT
"""The catalogue of stiff and extreme cases in one picture: how each ends, its iterations, its cut-backs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.lines import Line2D

from pysprings.results.plots.style import BLUE, GREEN, GREY, ORANGE, VERMILLION, new_figure, styled

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = {"converged": BLUE, "warned": GREEN, "stopped": ORANGE, "refused": GREY, "unexplained": VERMILLION}
MARKERS = {"converged": "o", "warned": "D", "stopped": "s", "refused": "x", "unexplained": "*"}
_ROW = 0.21  # inches


@styled
def catalogue(table: pd.DataFrame) -> Figure:
    """Draw the table of `pysprings.studies.stability.catalogue.run_cases`: a row a case, from the first at the top."""
    figure = new_figure(10.0, 1.6 + _ROW * len(table))
    left, right = figure.subplots(1, 2, sharey=True, width_ratios=(1.0, 1.0))
    row = np.arange(len(table))
    _iterations(left, table, row)
    _cut_backs(right, table, row)
    left.set_yticks(row, [f"{case}" for case in table["case"]], fontsize=8)
    left.set_ylim(len(table) - 0.5, -0.5)
    for axes in (left, right):
        for start in _group_starts(table):
            axes.axhline(start - 0.5, color=GREY, lw=0.6)
    used = [outcome for outcome in COLOURS if (table["outcome"] == outcome).any()]
    handles = [Line2D([], [], color=COLOURS[o], marker=MARKERS[o], ls="", label=o) for o in used]
    figure.legend(handles=handles, loc="outside upper right", ncols=len(handles))
    figure.suptitle("Stiff and extreme cases", x=0.01, ha="left")
    return figure


def _iterations(axes: Axes, table: pd.DataFrame, row: np.ndarray) -> None:
    """Draw median (mark) and largest number (end of the line) of Newton iterations of the increments."""
    columns = (table[name].tolist() for name in ("outcome", "median_iterations", "max_iterations", "increments"))
    for y, outcome, median, most, increments in zip(row, *columns, strict=True):
        if increments:
            axes.plot([median, most], [y, y], color=COLOURS[outcome], lw=1.0)
        axes.plot(median if increments else 0.0, y, MARKERS[outcome], color=COLOURS[outcome], ms=5)
    axes.set_xlim(-0.5, None)
    axes.set_xlabel("Newton iterations of an increment: median, most")


def _cut_backs(axes: Axes, table: pd.DataFrame, row: np.ndarray) -> None:
    share = 100.0 * table["cut_backs"] / table["increments"].clip(lower=1)
    axes.barh(row, share.clip(upper=100.0), color=[COLOURS[outcome] for outcome in table["outcome"]], height=0.6)
    for y, cuts, increments in zip(row, table["cut_backs"].tolist(), table["increments"].tolist(), strict=True):
        if increments:
            axes.text(min(share.iloc[y], 100.0) + 1.0, y, f"{cuts} of {increments}", va="center", fontsize=7)
    axes.set_xlim(0.0, 118.0)
    axes.set_xlabel("steps cut, % of the increments")


def _group_starts(table: pd.DataFrame) -> list[int]:
    """Return the rows where another group of cases begins."""
    group = table["group"].to_numpy()
    return [int(k) + 1 for k in np.flatnonzero(group[1:] != group[:-1])]
