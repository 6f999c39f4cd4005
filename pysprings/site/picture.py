# SPDX-License-Identifier: MIT
"""The picture of a proposal: rows of the test, points, and lines low, best and high by depth."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pysprings.results.plots.style import BLUE, GREEN, GREY, INK, ORANGE, PALE, SKY, new_figure, plain, styled
from pysprings.site.correlations import SAND, clay
from pysprings.site.output import VALUES
from pysprings.site.proposal import LINEAR, Proposal, Value, layers_of
from pysprings.site.sounding import SAND_TO, ZONES

PANELS = ("effective_unit_weight", "relative_density", "friction_angle_final", "undrained_shear_strength",
          "shear_modulus")  # fmt: skip
_COLOURS = {"sand": "#f7ecd0", "clay": "#dfe7ee"}
_LINES = (("low", BLUE, "--"), ("best", INK, "-"), ("high", GREEN, "--"))


@styled
def profile(proposal: Proposal, title: str) -> Figure:
    """Draw q_t and I_c of the test, and a panel for each value, over depth; layers are shaded by their kind."""
    keys = [key for key in PANELS if any(key in unit.values for unit in proposal.units)]
    test = proposal.sounding is not None
    figure = new_figure(2.1 * (len(keys) + 2 * test) + 0.9, 7.2)
    panels = list(np.atleast_1d(figure.subplots(1, len(keys) + 2 * test, sharey=True)))
    if test:
        panels[0].plot(proposal.rows.cone * 1e-6, proposal.depth, color=INK, linewidth=0.8)
        panels[0].set_xlabel("q_t [MPa]")
        _index(panels[1], proposal)
    for axes, key in zip(panels[2 * test :], keys, strict=True):
        _value(axes, proposal, key)
    for axes in panels:
        for k, unit in enumerate(proposal.units, start=1):
            axes.axhspan(unit.top, unit.bottom, color=_COLOURS[unit.kind], zorder=0, linewidth=0)
            axes.axhline(unit.bottom, color=GREY, linewidth=0.6, zorder=1)
            if axes is panels[0]:
                axes.text(0.98, 0.5 * (unit.top + unit.bottom), str(k), transform=axes.get_yaxis_transform(),
                          ha="right", va="center", color=GREY, fontsize=9)  # fmt: skip
    panels[0].set_ylim(proposal.units[-1].bottom, 0.0)
    panels[0].set_ylabel("depth below mudline [m]")
    figure.suptitle(plain(title))
    handles = {label: line for axes in panels for line, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=6, fontsize=8.5)
    return figure


def _index(axes: Axes, proposal: Proposal) -> None:
    axes.plot(proposal.rows.index, proposal.depth, ".", color=SKY, markersize=1.5)
    for end, _ in ZONES[:-1]:
        axes.axvline(end, color=INK if end == SAND_TO else PALE, linewidth=0.8)
    for unit in proposal.units:
        axes.plot([unit.index] * 2, [unit.top, unit.bottom], color=INK)
    axes.set_xlim(1.0, 4.2)
    axes.set_xlabel("I_c [-]")


def _value(axes: Axes, proposal: Proposal, key: str) -> None:
    """Draw the rows of each correlation and measured points as dots, and the three lines of each layer.

    Lines are thin where the law of the layer does not use the value.
    """
    shown = VALUES[key]
    for k, unit in enumerate(proposal.units):
        if (value := unit.values.get(key)) is None:
            continue
        _dots(axes, proposal, k, key, value)
        wide = 1.8 if key in unit.written else 0.6
        for (label, colour, style), line in zip(_LINES, value.lines, strict=True):
            own = label if key in unit.written else "thin: not used by the law" if label == "best" else None
            axes.plot(line * shown.factor, [unit.top, unit.bottom], style, color=colour, linewidth=wide, label=own)
    points = proposal.points
    if points is not None and key in points.values:
        axes.plot(points.values[key] * shown.factor, points.depth, "o", color=ORANGE, markeredgecolor=INK,
                  markersize=5, label="measured", zorder=4)  # fmt: skip
    low, high = axes.get_xlim()
    lines = [line for unit in proposal.units if key in unit.values for line in unit.values[key].lines]
    if key in LINEAR and points is None and lines:  # a row of the next layer would take the whole width
        high = min(high, 2.0 * shown.factor * float(np.max(lines)))
    axes.set_xlim(0.0 if key in LINEAR else low, high)
    axes.set_xlabel(f"{shown.symbol} [{shown.unit}]")


def _dots(axes: Axes, proposal: Proposal, k: int, key: str, value: Value) -> None:
    unit, own = proposal.units[k], layers_of(proposal.units, proposal.depth) == k
    if proposal.sounding is None or not own.any():
        return
    rows = proposal.rows.part(own)
    if "relative_density" in unit.values:
        rows = rows.with_density(float(unit.values["relative_density"].lines[1].mean()))
    for each in SAND if unit.kind == "sand" else clay(proposal.cone_factors):
        if each.gives == key and each.name in value.sources:
            axes.plot(each.of(rows) * VALUES[key].factor, proposal.depth[own], ".", color=GREY, alpha=0.6,
                      markersize=3, label="correlations, row by row")  # fmt: skip
