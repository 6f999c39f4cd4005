# SPDX-License-Identifier: MIT
"""Error against run time: every setting of a study, the full model and the macro-model, and the Pareto front."""

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from pysprings.full_model.accuracy.presets import BRICKS, FOURIER, MESH
from pysprings.results.plots.style import BLUE, GREEN, GREY, INK, ORANGE, PURPLE, VERMILLION, new_figure, plain, styled


def front(cost: Sequence[float], error: Sequence[float]) -> list[int]:
    """Return the numbers of the choices that none is both cheaper and better than, by cost; NaN is never among them.

    >>> front([1.0, 2.0, 3.0, 4.0], [9.0, 4.0, 5.0, 1.0])
    [0, 1, 3]
    """
    costs, errors = np.asarray(cost, dtype=float), np.asarray(error, dtype=float)
    counted = np.flatnonzero(np.isfinite(costs) & np.isfinite(errors))
    best, best_ones = np.inf, []
    for k in counted[np.lexsort((errors[counted], costs[counted]))]:
        if errors[k] < best:
            best = errors[k]
            best_ones.append(int(k))
    return best_ones


# group of settings, or discretisation of a mesh -> mark, colour
MARKS = {
    "bricks": ("o", BLUE),
    "Fourier series": ("P", INK),
    "steps": ("s", ORANGE),
    "tolerance": ("D", GREEN),
    "linear solver": ("^", PURPLE),
    "macro-model": ("x", VERMILLION),
}
# panels: model, column of the error, title, axis of the time and its factor from seconds
KINDS = {"bricks": BRICKS, "Fourier series": FOURIER}  # names of the meshes of each discretisation
PANELS = (
    ("full", "load_max_pct", "full model, load: largest", "wall time of the whole run [s]", 1.0),
    ("full", "py_rms_pct", "full model, p-y: root mean square", "wall time of the whole run [s]", 1.0),
    ("macro", "load_max_pct", "macro-model, load: largest", "time of a curve of 50 points [ms]", 1e3),
)
LEAST = 1e-3  # %: smaller errors are drawn there


@styled
def error_against_time(table: pd.DataFrame, title: str, targets: Collection[float] = ()) -> Figure:
    """Draw the table of a study (`pysprings.studies.accuracy`): error [%] over wall time [s], both logarithmic.

    Marks with a white middle show the uncertainty of the reference itself. Dotted lines: ``targets`` [%].
    """
    figure = new_figure(14.0, 5.2)
    every = figure.subplots(1, len(PANELS), sharey=True)
    for axes, (model, column, words, label, factor) in zip(every, PANELS, strict=True):
        shown = table[(table["model"] == model) & (table["status"] == "complete")]
        shown = shown[shown[column].notna()]
        _panel(axes, shown.assign(time=factor * shown["wall_s"].astype(float)), column, targets)
        axes.set(title=words, xlabel=label)
    every[0].set_ylabel("error beside the reference [% of the largest]")
    every[0].yaxis.set_major_formatter("{x:g}")
    known = {text: handle for axes in every for handle, text in zip(*axes.get_legend_handles_labels(), strict=True)}
    figure.legend(known.values(), known.keys(), loc="outside lower center", ncols=max(len(known), 1))
    figure.suptitle(plain(f"Error against time: {title}"))
    return figure


def _panel(axes: Axes, shown: pd.DataFrame, column: str, targets: Collection[float]) -> None:
    axes.set(xscale="log", yscale="log")
    for group, (mark, colour) in MARKS.items():
        part = shown[shown["group"] == group]
        if group in KINDS:
            part = shown[(shown["group"] == MESH) & (shown["discretisation"] == KINDS[group])]
        if len(part):
            _marks(axes, part, column, mark, colour, group)
    for name, kind in KINDS.items():
        _front(axes, shown[shown["discretisation"] == kind], column, name, MARKS[name][1])
    _names(axes, shown, column)
    for limit in targets:
        axes.axhline(limit, color=GREY, linewidth=0.9, linestyle=":")
        axes.annotate(
            f" {limit:g} %", (1.0, limit), xycoords=("axes fraction", "data"), fontsize=8, va="center", color=GREY
        )
    if len(shown):  # whole decades: a range of less has no room for its labels
        low, high = np.log10(shown["time"].min()), np.log10(shown["time"].max())
        axes.set_xlim(10.0 ** np.floor(low - 0.02), 10.0 ** np.ceil(high + 0.02))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())


def _names(axes: Axes, shown: pd.DataFrame, column: str) -> None:
    """Write the names of the meshes at their marks, above and below in turn."""
    part = shown[shown["group"] == MESH].sort_values("time")
    for k, row in enumerate(part.to_dict("records")):
        above = k % 2 == 0
        axes.annotate(
            str(row["name"]).removeprefix(f"{FOURIER}-"), (row["time"], max(row[column], LEAST)),
            textcoords="offset points", xytext=(0, 7 if above else -7), fontsize=7.5,
            ha="center", va="bottom" if above else "top", color=BLUE if row["discretisation"] == BRICKS else INK,
        )  # fmt: skip


def _marks(axes: Axes, part: pd.DataFrame, column: str, mark: str, colour: str, group: str) -> None:
    quantity = column.split("_")[0]
    values = part[column].clip(lower=LEAST)
    look: dict[str, Any] = {"color": colour}
    if mark != "x":  # which has no middle
        face = ["white" if quantity in own.split(", ") else colour for own in part["reference"]]
        look = {"facecolors": face, "edgecolors": colour}
    axes.scatter(part["time"], values, marker=mark, s=34, linewidths=1.3, zorder=3, label=group, **look)


def _front(axes: Axes, shown: pd.DataFrame, column: str, name: str, colour: str) -> None:
    """Draw the Pareto front of a discretisation by steps: any time between two runs gives the error of the cheaper."""
    best = shown.iloc[front(shown["time"].tolist(), shown[column].tolist())]
    if len(best) > 1:
        errors = best[column].clip(lower=LEAST)
        label = f"Pareto front, {name}"
        axes.step(best["time"], errors, where="post", linewidth=1.2, zorder=2, label=label, color=colour)
