# SPDX-License-Identifier: MIT
"""Load against displacement, lateral (the paper's figure 10) and vertical, with the parts that carry it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pysprings.core.path_kinds import driven
from pysprings.results.analysis.parts import converged
from pysprings.results.plots.data import abscissa, spread_depths, unit_text
from pysprings.results.plots.picture import Picture
from pysprings.results.plots.profiles import MOST_CURVES, depth_colours
from pysprings.results.plots.style import (
    BLUE,
    DEG,
    GREEN,
    INK,
    KN,
    MM,
    MRAD,
    ORANGE,
    SKY,
    SURFACE_COLOURS,
    VERMILLION,
    legend_beside,
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
    from numpy.typing import ArrayLike, NDArray

SURFACES = {"outer": "skirt outside", "inner": "skirt inside", "lid": "lid", "tip": "tip"}


@styled
def load_displacement(path: xr.Dataset) -> Figure:
    """Draw the load of the whole caisson by component, vertical forces, rotation and heave along one path.

    Parameters
    ----------
    path
        One path: H and its parts [N] (M [N m] on a rotation path), F_in, F_out, F_pw [N], rotation [rad],
        w [m].
    """
    figure = new_figure(9.6, 7.0)
    axes = figure.subplots(2, 2)
    _components(axes[0, 0], path)
    _vertical_forces(axes[0, 1], path)
    _rotation(axes[1, 0], path)
    _heave(axes[1, 1], path)
    x, label = abscissa(path)
    for each in axes.flat:
        each.set_xlabel(label)
        if np.nanmin(x) >= 0:
            each.set_xlim(left=0)
        zero_lines(each)
    set_title(figure, "Load and motion of the caisson", path.attrs, _status(path))
    for each in (axes[0, 0], axes[0, 1]):
        legend_beside(each)
    return figure


def _components(axes: Axes, path: xr.Dataset) -> None:
    letter, unit_end = ("M", " m") if driven(path.attrs) == "rotation" else ("H", "")
    good, (x, _) = converged(path), abscissa(path)
    factor, unit = unit_text(path[letter].values)
    plot_path(axes, x, path[letter].values * factor, good, color=INK, linewidth=2.4, label=f"total {letter}")
    for surface, name in SURFACES.items():
        variable = f"{letter}_{surface}"
        if variable in path:
            plot_path(axes, x, path[variable].values * factor, good, color=SURFACE_COLOURS[surface], label=name)
    axes.set_ylabel(f"{letter} [{unit}{unit_end}]")
    what = "Moment about the lid centre" if letter == "M" else "Horizontal load"
    axes.set_title(f"{what} and the surfaces that carry it")


def _vertical_forces(axes: Axes, path: xr.Dataset) -> None:
    good, (x, _) = converged(path), abscissa(path)
    names = [name for name in ("F_in", "F_out", "F_pw") if name in path]
    factor, unit = unit_text(np.stack([path[name].values for name in names]))
    meaning = {"F_in": "shear inside", "F_out": "shear outside", "F_pw": "water under the lid"}
    look = {"F_in": (ORANGE, "-"), "F_out": (BLUE, "-"), "F_pw": (SKY, "--")}
    for name in names:
        colour, dash = look[name]
        plot_path(
            axes,
            x,
            path[name].values * factor,
            good,
            color=colour,
            linestyle=dash,
            label=rf"$\Delta F_{{{name[2:]}}}$, {meaning[name]}",
        )
    axes.set_ylabel(f"change of force [{unit}]")
    axes.set_title("Vertical forces on the soil, down +, change from the start")


def _rotation(axes: Axes, path: xr.Dataset) -> None:
    good, (x, _) = converged(path), abscissa(path)
    plot_path(axes, x, path["rotation"].values * MRAD, good, color=VERMILLION)
    axes.set_ylabel("rotation [mrad]")
    degrees = axes.secondary_yaxis("right", functions=(_degrees, _milliradians))
    degrees.set_ylabel("rotation [deg]")
    axes.set_title("Rotation (positive leans towards +x)")


def _degrees(mrad: ArrayLike) -> NDArray[np.float64]:
    return np.asarray(mrad) * (DEG / MRAD)


def _milliradians(degrees: ArrayLike) -> NDArray[np.float64]:
    return np.asarray(degrees) * (MRAD / DEG)


def _heave(axes: Axes, path: xr.Dataset) -> None:
    good, (x, _) = converged(path), abscissa(path)
    plot_path(axes, x, -path["w"].values * MM, good, color=GREEN)
    axes.set_ylabel("heave \N{MINUS SIGN}w [mm], up +")
    axes.set_title("Heave of the lid centre")


def _status(path: xr.Dataset) -> str:
    good = converged(path)
    if good.all():
        return ""
    return f"{int((~good).sum())} of {good.size} steps did not converge: crosses, not part of the curves"


PICTURE = Picture(
    name="load_displacement",
    caption="Load by component, vertical forces, rotation and heave",
    function=load_displacement,
    data=lambda view: (view.path,),
    applies=lambda view: not view.is_vertical and "F_in" in view.path,
    section="",
)


@styled
def vertical_springs(path: xr.Dataset) -> Figure:
    """Draw the vertical load V [N] with its parts, and the vertical reaction t [kN/m] by depth, over w [mm].

    Parameters
    ----------
    path
        A vertical path of a result: w [m], V [N] and V of each surface, t [N/m] by depth, side and step.
    """
    figure = new_figure(9.6, 4.8)
    left, right = figure.subplots(1, 2)
    x, label = abscissa(path)
    good = converged(path)
    factor, unit = unit_text(path["V"].values)
    plot_path(left, x, path["V"].values * factor, good, color=INK, linewidth=2.4, label="total V")
    for surface, name in SURFACES.items():
        if f"V_{surface}" in path:
            values = path[f"V_{surface}"].values * factor
            plot_path(left, x, values, good, color=SURFACE_COLOURS[surface], label=name)
    left.set_ylabel(f"V [{unit}], down +")
    left.set_title("Vertical load and the surfaces that carry it")
    _reactions(right, path, x)
    for axes in (left, right):
        axes.set_xlabel(label)
        zero_lines(axes)
        if x[-1] < x[0]:
            axes.invert_xaxis()
    legend_beside(left)
    legend_beside(right, title="depth")
    set_title(figure, "Vertical springs", path.attrs)
    return figure


def _reactions(axes: Axes, path: xr.Dataset, x: np.ndarray) -> None:
    good, rings = converged(path), spread_depths(path, MOST_CURVES)
    t = path["t"].sum("side").transpose("depth", "step").values * KN
    for ring, colour in zip(rings, depth_colours(len(rings)), strict=True):
        label = f"{float(path['depth'][ring]):.2f} m"
        plot_path(axes, x, t[ring], good, color=colour, linewidth=1.7, label=label)
    note_unconverged(axes, good)
    axes.set_ylabel("reaction t [kN/m], both sides")
    axes.set_title("Vertical reaction by depth")


VERTICAL = Picture(
    name="vertical",
    caption="Vertical springs",
    function=vertical_springs,
    data=lambda view: (view.path,),
    applies=lambda view: view.is_vertical,
    section="",
)
