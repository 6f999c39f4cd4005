# SPDX-License-Identifier: MIT
"""Load cases in the plane of V and H, with the vertical loads of the springs and the largest that these carry."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pysprings.core.errors import PyspringsError
from pysprings.core.loads import CLOSE_LOAD, close_loads
from pysprings.core.words import RANGE_END
from pysprings.macro.model import AnySprings, MacroModel, typed
from pysprings.macro.vertical_answer import largest_vertical
from pysprings.results.look import CASE_MARKS, OTHER_CASE
from pysprings.results.plots import style
from pysprings.springs.springs import Springs

MOST_NAMED = 12  # cases with their names: those of the largest utilisation


@style.styled
def load_cases(table: pd.DataFrame, springs: AnySprings | None) -> Figure:
    """Draw |H| over V [MN] of load cases, and above each the largest known load in its direction at its V.

    table : Answers to load cases in SI (`pysprings design`), a row a case.
    springs : Those that answered: their vertical loads are grey lines in bands of 10 %, the largest that they carry
        blue. None: they were several, whose lines differ.
    """
    figure = style.new_figure(9.6, 4.8)
    axes = figure.subplots()
    shown = table[table["V_N"].notna() & table["H_N"].notna()]
    if springs is not None:
        _springs(axes, springs)
    _capacities(axes, shown)
    for verdict, part in shown.groupby("verdict"):
        mark, colour = CASE_MARKS.get(str(verdict), OTHER_CASE)
        look: Any = {"color": colour, "markersize": 7, "linestyle": "none", "zorder": 4}
        axes.plot(style.MN * part["V_N"], style.MN * part["H_N"].abs(), mark, label=f"load case, {verdict}", **look)
    named = shown.sort_values("utilisation").drop_duplicates("name").tail(MOST_NAMED).sort_values("V_N")
    for k, row in enumerate(named.to_dict("records")):
        place, beside = (
            (style.MN * row["V_N"], style.MN * abs(row["H_N"])),
            (6, -10 if k % 2 else 3),
        )  # below and above in turn
        axes.annotate(style.plain(row["name"]), place, beside, textcoords="offset points", fontsize=8, zorder=5)
    axes.set(xlabel="V [MN], down +", ylabel="H, size [MN]")
    axes.set_ylim(bottom=0.0)
    if axes.get_legend_handles_labels()[0]:  # none where no case has a V that is known, and springs draw nothing
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    figure.suptitle("Load cases: vertical and lateral load")
    return figure


def _springs(axes: Axes, springs: AnySprings) -> None:
    """Draw the vertical loads of the springs, and the largest downwards and upwards."""
    given = typed(springs)
    sets = [each.V for each in given.load_sets] if isinstance(given, Springs) else []
    for k, V in enumerate(sets):
        ends = sorted((V * (1.0 - CLOSE_LOAD), V / (1.0 - CLOSE_LOAD)))
        axes.axvspan(
            style.MN * ends[0],
            style.MN * ends[1],
            color=style.PALE,
            zorder=0,
            label="10 % from these" * (not k) or None,
        )
        label = "V of lateral springs" * (not k) or None
        axes.axvline(style.MN * V, color=style.GREY, linewidth=1.2, zorder=1, label=label)
    try:
        model = MacroModel.from_springs(given)
    except PyspringsError:  # of several rates: none is asked for
        return
    for sign, words in ((1.0, "push"), (-1.0, "pull")):
        V, kind, _ = largest_vertical(model, sign)
        if kind:
            dash: Any = "--" if kind == RANGE_END else "-"
            label = f"largest {words}: {style.MN * V:.3g} MN, {kind}"
            axes.axvline(style.MN * V, color=style.BLUE, linewidth=1.6, linestyle=dash, zorder=2, label=label)


def _capacities(axes: Axes, shown: pd.DataFrame) -> None:
    """Draw the largest known H of each case, open where it is the end of the range, and the way to it.

    Cases of one load height are joined over V. Where springs have no set within 10 % of V it is not that at V: grey.
    """
    known = shown[np.isfinite(shown["H_capacity_N"].astype(float)) & (shown["H_N"] != 0.0)]
    close = close_loads(*(known.get(name, known["V_N"]).to_numpy(float) for name in ("V_N", "V_springs_N")))
    near = known[close]
    for arm, part in near.groupby((near["M_Nm"] / near["H_N"]).round(2)):
        ordered = part.drop_duplicates("V_N").sort_values("V_N")
        if len(ordered) > 1:
            ends = style.MN * ordered["V_N"], style.MN * ordered["H_capacity_N"].abs()
            axes.plot(*ends, color=style.INK, linewidth=1.0, linestyle=":", zorder=2)
            place = (ends[0].iloc[-1], ends[1].iloc[-1])
            axes.annotate(f"load at {arm:g} m", place, (6, -3), textcoords="offset points", fontsize=8)
    for row in known.to_dict("records"):
        heights = [style.MN * abs(row["H_N"]), style.MN * abs(row["H_capacity_N"])]
        axes.plot([style.MN * row["V_N"]] * 2, heights, color=style.GREY, linewidth=0.8, zorder=2)
    end = near["capacity_kind"] == RANGE_END
    for part, colour, face, words in (
        (near[~end], style.INK, style.INK, "largest H in the direction of the case"),
        (near[end], style.INK, "white", "largest H known, capacity is larger"),
        (known[~close], style.GREY, style.GREY, "largest H of springs that are not of this V"),
    ):
        if len(part):
            axes.plot(
                style.MN * part["V_N"], style.MN * part["H_capacity_N"].abs(), "o", color=colour, markerfacecolor=face,
                markersize=5, linestyle="none", label=words, zorder=3,
            )  # fmt: skip
