# SPDX-License-Identifier: MIT
"""The Newton record of a path: iterations by increment with cut-backs, and every residual."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from pysprings.results.parts import Attempt, attempts, failed_steps
from pysprings.results.plots.picture import Picture, View
from pysprings.results.plots.style import BLUE, GREEN, GREY, SKY, VERMILLION, new_figure, set_title, styled

LOST = {"color": VERMILLION, "hatch": "////", "gid": "cut back"}  # bars of attempts that were given up


@styled
def newton_record(record: xr.Dataset, failed_steps: tuple[int, ...] = ()) -> Figure:
    """Draw iterations by increment (cut-backs apart) and the history of the relative residual.

    Parameters
    ----------
    record
        ``/paths/<name>/convergence``: increment, attempt, iteration, residual (relative), all (iteration,).
        attrs ``tolerance`` draws the line to reach.
    failed_steps
        Steps that did not converge: all their attempts count as given up.
    """
    tries = attempts(record, failed_steps)
    figure = new_figure(9.6, 6.4)
    above, below = figure.subplots(2, 1)
    _bars(above, tries)
    _residuals(below, record, tries)
    accepted = [each.iterations for each in tries if each.accepted]
    given_up = sum(not each.accepted for each in tries)
    median = f"median {np.median(accepted):g}, most {max(accepted)} per increment; " if accepted else ""
    worst = [float(record["residual"].values[each.rows[-1]]) for each in tries if each.accepted]
    reached = f"; worst accepted residual {max(worst):.1e}" if worst else ""
    set_title(figure, "Newton iterations", record.attrs, f"{median}attempts given up: {given_up}{reached}")
    return figure


def _bars(axes: Axes, tries: list[Attempt]) -> None:
    height: dict[int, int] = {}
    for each in tries:
        base = height.get(each.step, 0)
        look: Any = {"color": BLUE, "gid": "accepted"} if each.accepted else LOST
        axes.bar(each.step, each.iterations, bottom=base, width=0.8, edgecolor="white", linewidth=0.6, **look)
        height[each.step] = base + each.iterations
    axes.set(
        xlabel="increment (0 and below: dead load)" if min(height, default=1) < 1 else "increment", ylabel="iterations"
    )
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_title("Iterations by increment")
    axes.set_xlim(min(height, default=1) - 0.8, max(height, default=1) + 0.8)
    handles = [Patch(facecolor=BLUE, label="accepted")]
    if any(not each.accepted for each in tries):
        handles.append(Patch(facecolor=VERMILLION, edgecolor="white", hatch="////", label="given up: step cut back"))
        axes.set_ylim(top=max(height.values()) * 1.25)
    axes.legend(handles=handles, loc="upper right", ncols=2)


def _residuals(axes: Axes, record: xr.Dataset, tries: list[Attempt]) -> None:
    residual = record["residual"].values.astype(float)
    shown = np.where(residual > 0, residual, np.nan)
    for k, each in enumerate(tries):
        colour = (BLUE, SKY)[k % 2] if each.accepted else VERMILLION
        axes.semilogy(
            each.rows + 1,
            shown[each.rows],
            color=colour,
            marker="o" if each.accepted else "x",
            markersize=3.5,
            linewidth=1.0,
            gid="accepted" if each.accepted else "cut back",
        )
    dots: Any = {"color": BLUE, "marker": "o", "markersize": 3.5, "linewidth": 1.0}
    handles = [Line2D([], [], label="one increment (two blues in turn)", **dots)]
    if any(not each.accepted for each in tries):
        handles.append(Line2D([], [], color=VERMILLION, marker="x", linewidth=1.0, label="given up"))
    if "tolerance" in record.attrs:
        axes.axhline(float(record.attrs["tolerance"]), color=GREEN, linestyle="--", linewidth=1.4)
        handles.append(Line2D([], [], color=GREEN, linestyle="--", label=f"tolerance {record.attrs['tolerance']:g}"))
    axes.set(
        xlabel="iteration, counted over the whole path",
        ylabel="relative residual [-]",
        title="Residual at every iteration",
    )
    axes.legend(handles=handles, loc="upper right", ncols=3)
    low, high = np.nanmin(shown, initial=1e-8), np.nanmax(shown, initial=1.0)
    axes.set_ylim(low / 3, high * 100)
    axes.axhline(1.0, color=GREY, linewidth=0.6)


def _data(view: View) -> tuple[xr.Dataset, tuple[int, ...]]:
    record = view.convergence
    assert record is not None  # `applies` has tested it
    return record.assign_attrs({**view.path.attrs, **record.attrs}), failed_steps(view.path, record)


PICTURE = Picture(
    name="newton",
    caption="Newton iterations",
    function=newton_record,
    data=_data,
    applies=lambda view: view.convergence is not None,
    section="",
)
