# SPDX-License-Identifier: MIT
"""Loops of a path that turns back: load over motion, and secant stiffness and damping by amplitude, of both models."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from pysprings.core.path_kinds import MEMORY, turns_back
from pysprings.macro.cycles import Followed, cycles
from pysprings.macro.spring_sets import SPRING_SETS
from pysprings.macro.ways import Control
from pysprings.results.plots.comparison import LOOKS
from pysprings.results.plots.data import unit_text
from pysprings.results.plots.picture import Picture
from pysprings.results.plots.style import INK, MM, MRAD, new_figure, set_title, styled, zero_lines
from pysprings.springs.path import SpringPath

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FULL = "full model"


@styled
def memory_loops(path: SpringPath, answers: Mapping[str, xr.Dataset]) -> Figure:
    """Draw H over u and M over the rotation, and secant stiffness and damping ratio of each cycle over its amplitude.

    Parameters
    ----------
    path
        A path that turns back, with u [m], rotation [rad], H [N] and M [N m] by step.
    answers
        Answers of springs along it, by spring set, with the same variables.
    """
    figure = new_figure(9.6, 7.6)
    axes = figure.subplots(2, 2)
    for panel, (x, y, scale, label) in zip(
        axes[0], (("u", "H", MM, "u [mm]"), ("rotation", "M", MRAD, "rotation [mrad]")), strict=True
    ):
        factor, unit = unit_text(path[y])
        panel.plot(path[x] * scale, path[y] * factor, color=INK, linewidth=2.2, label=FULL)
        for name, answer in answers.items():
            colour, dash, _ = LOOKS[name]
            values = answer[x].values * scale, answer[y].values * factor
            panel.plot(*values, color=colour, linestyle=dash, label=_label(name))
        panel.set(xlabel=label, ylabel=f"{y} [{unit} m]" if y == "M" else f"{y} [{unit}]")
        zero_lines(panel)
    axes[0, 0].legend(loc="best", fontsize=8)
    for name, answer in answers.items():
        _measures(axes[1], path, name, answer)
    set_title(figure, "Loops", dict(path.dataset.attrs))
    return figure


def _measures(panels: np.ndarray, path: SpringPath, name: str, answer: xr.Dataset) -> None:
    """Draw secant stiffness and damping ratio by branch over the amplitude of the motion."""
    n = answer.sizes["step"]
    full = np.stack([path.u, path.rotation], axis=1)[:n], np.stack([path["H"], path["M"]], axis=1)[:n]
    motions, loads = (
        np.stack([answer[a].values, answer[b].values], axis=1) for a, b in (("u", "rotation"), ("H", "M"))
    )
    control: Control = "displacement" if path.rules.free_head else "state"
    table = cycles(Followed(path, name, control, full, (motions, loads), ""))
    ends = np.concatenate([[0.0], table["x_end_full"]])
    amplitude = 0.5 * np.abs(np.diff(ends)) * MM
    colour, _, marker = LOOKS[name]
    secants = table["secant_full"].abs().max()
    factor, unit = unit_text(np.array([secants]))
    _points(panels[0], amplitude, table["secant_full"].to_numpy() * factor, INK, "o", FULL)
    _points(panels[0], amplitude, table["secant_macro"].to_numpy() * factor, colour, marker, _label(name))
    panels[0].set(xlabel="amplitude of u [mm]", ylabel=f"secant stiffness dH/du [{unit}/m]", ylim=(0, None))
    _points(panels[1], amplitude, table["damping_full"].to_numpy(), INK, "o", FULL)
    _points(panels[1], amplitude, table["damping_macro"].to_numpy(), colour, marker, _label(name))
    panels[1].set(xlabel="amplitude of u [mm]", ylabel="damping ratio of the cycle", ylim=(0, None))


def _points(axes: Axes, x: np.ndarray, y: np.ndarray, colour: str, marker: str, label: str) -> None:
    axes.plot(x, y, linestyle="none", marker=marker, markersize=6, fillstyle="none", color=colour, label=label)


def _label(name: str) -> str:
    return SPRING_SETS[name].label


PICTURE = Picture(
    name="loops",
    caption="Loops, secant stiffness and damping of the full model and of springs with memory",
    function=memory_loops,
    data=lambda view: (
        SpringPath(view.path.attrs["path"], view.path, float(view.path.attrs["skirt_length_m"])),
        {MEMORY: view.predictions[MEMORY]},
    ),
    applies=lambda view: turns_back(view.path.attrs) and "u" in view.path and MEMORY in view.predictions,
    section="",
)
