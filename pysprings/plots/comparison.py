# SPDX-License-Identifier: MIT
"""Rigid body on springs beside the full model: load and rotation against displacement."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from pysprings.plots.data import converged, unit_text
from pysprings.plots.style import (
    BLUE,
    GREEN,
    INK,
    MM,
    MRAD,
    VERMILLION,
    new_figure,
    note_unconverged,
    plot_path,
    set_title,
    styled,
    zero_lines,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LOOKS = {"fan": (GREEN, "-.", "^"), "full": (BLUE, "--", "o"), "py": (VERMILLION, "--", "s")}
NAMES = {
    "fan": "macro-model, fan of all calibration paths",
    "full": "macro-model, full spring set of one path",
    "py": "macro-model, p-y springs only",
}


@styled
def macro_against_full(full: xr.Dataset, curves: Mapping[str, xr.Dataset]) -> Figure:
    """Draw the full model and predictions of the rigid body on springs along the same path.

    Parameters
    ----------
    full
        The full model's path: u [m], H [N] (M [N m] on a rotation path), rotation [rad], all by step.
    curves
        Predictions by spring set (``"fan"``, ``"full"``, ``"py"``, or any name), with the same variables by step.
    """
    rotates = full.attrs.get("kind") == "rotation"
    load = "M" if rotates else "H"
    driver, label = ("rotation", "rotation [mrad]") if rotates else ("u", "lateral displacement u of the lid [mm]")
    answer, reply = ("u", "u [mm]") if rotates else ("rotation", "rotation [mrad]")
    figure = new_figure(9.6, 4.8)
    left, right = figure.subplots(1, 2)
    factor, unit = unit_text(full[load].values)
    sides = ((left, load, factor), (right, answer, MM if answer == "u" else MRAD))
    for axes, name, scale in sides:
        _draw(axes, full, curves, driver, name, scale)
        axes.set_xlabel(label)
        if np.nanmin(full[driver].values) >= 0:
            axes.set_xlim(left=0)
        zero_lines(axes)
    left.set_ylabel(f"{load} [{unit}{' m' if rotates else ''}]")
    right.set_ylabel(reply)
    left.set_title("Load")
    right.set_title("Motion that comes with it")
    handles, names = left.get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=2 if len(names) > 3 else len(names))
    set_title(figure, "Rigid body on springs against the full model", full.attrs)
    return figure


def _draw(axes: Axes, full: xr.Dataset, curves: Mapping[str, xr.Dataset], driver: str, name: str, scale: float) -> None:
    drive = MRAD if driver == "rotation" else MM
    plot_path(
        axes,
        full[driver].values * drive,
        full[name].values * scale,
        converged(full),
        color=INK,
        linewidth=2.6,
        label="full model (3D finite elements)",
    )
    flags = [converged(full)]
    for kind, curve in curves.items():
        colour, dash, marker = LOOKS.get(kind, (GREEN, "-.", "^"))
        good = converged(curve)
        flags.append(good)
        plot_path(
            axes,
            curve[driver].values * drive,
            curve[name].values * scale,
            good,
            color=colour,
            linestyle=dash,
            marker=marker,
            markersize=4.5,
            markevery=max(1, good.size // 12),
            label=NAMES.get(kind, kind),
        )
    note_unconverged(axes, np.concatenate(flags))
