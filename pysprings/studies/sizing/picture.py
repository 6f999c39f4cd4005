# SPDX-License-Identifier: MIT
"""The candidates of a sizing in the plane of D and L, coloured by whether they meet the load cases."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from pysprings.results.plots.style import BLUE, GREY, VERMILLION, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@styled
def candidates(table: pd.DataFrame, best: pd.Series) -> Figure:
    """Draw every caisson that was tried, its steel in tonnes as the size of the dot, and the best one."""
    figure = new_figure(6.4, 4.6)
    axes = figure.subplots()
    for met, colour, label in ((True, BLUE, "meets the load cases"), (False, GREY, "does not")):
        part = table[(table["use"] <= 1.0) == met]
        axes.scatter(part["D_m"], part["L_m"], s=10.0 + 60.0 * part["steel_t"] / table["steel_t"].max(), c=colour,
                     label=label, alpha=0.7)  # fmt: skip
    axes.plot(
        best["D_m"], best["L_m"], "*", color=VERMILLION, markersize=16, label=f"least steel: {best['steel_t']:.3g} t"
    )
    axes.set_xlabel("outer diameter D [m]")
    axes.set_ylabel("skirt length L [m]")
    axes.legend(loc="best")
    return figure
