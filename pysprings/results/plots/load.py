# SPDX-License-Identifier: MIT
"""Load against displacement, lateral (the paper's figure 10) and vertical, with the parts that carry it."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pysprings.core.path_kinds import driven
from pysprings.results.parts import converged
from pysprings.results.plots import style
from pysprings.results.plots.picture import Picture, abscissa, spread_depths, unit_text
from pysprings.results.plots.profiles import MOST_CURVES, depth_colours

SURFACES = {"outer": "skirt outside", "inner": "skirt inside", "lid": "lid", "tip": "tip"}


@style.styled
def load_displacement(path: xr.Dataset) -> Figure:
    """Draw the load of the whole caisson by component, vertical forces, rotation and heave along one path.

    Parameters
    ----------
    path
        One path: H and its parts [N] (M [N m] on a rotation path), F_in, F_out, F_pw [N], rotation [rad],
        w [m].
    """
    figure = style.new_figure(9.6, 7.0)
    axes = figure.subplots(2, 2)
    what = {"H": "Horizontal load", "M": "Moment about the lid centre"}
    letter = "M" if driven(path.attrs) == "rotation" else "H"
    _by_surface(axes[0, 0], path, letter, what[letter])
    _vertical_forces(axes[0, 1], path)
    _rotation(axes[1, 0], path)
    _heave(axes[1, 1], path)
    x, label = abscissa(path)
    for each in axes.flat:
        each.set_xlabel(label)
        if np.nanmin(x) >= 0:
            each.set_xlim(left=0)
        style.zero_lines(each)
    style.set_title(figure, "Load and motion of the caisson", path.attrs, _status(path))
    for each in (axes[0, 0], axes[0, 1]):
        style.legend_beside(each)
    return figure


# change of a vertical force from the start -> meaning, colour, line
_FORCES = {
    "F_in": ("shear inside", style.ORANGE, "-"),
    "F_out": ("shear outside", style.BLUE, "-"),
    "F_pw": ("water under the lid", style.SKY, "--"),
}


def _curve(axes: Axes, path: xr.Dataset, name: str, factor: float, **line: Any) -> None:
    """Draw a variable of the path over what drives it."""
    style.plot_path(axes, abscissa(path)[0], path[name].values * factor, converged(path), **line)


def _by_surface(axes: Axes, path: xr.Dataset, letter: str, title: str, sense: str = "") -> None:
    """Draw H, V or M of the whole caisson, and what each surface carries of it."""
    factor, unit = unit_text(path[letter].values)
    _curve(axes, path, letter, factor, color=style.INK, linewidth=2.4, label=f"total {letter}")
    for surface, name in SURFACES.items():
        if f"{letter}_{surface}" in path:
            _curve(axes, path, f"{letter}_{surface}", factor, color=style.SURFACE_COLOURS[surface], label=name)
    unit = f"{unit} m" if letter == "M" else unit
    axes.set(ylabel=f"{letter} [{unit}]{sense}", title=f"{title} and the surfaces that carry it")


def _vertical_forces(axes: Axes, path: xr.Dataset) -> None:
    names = [name for name in _FORCES if name in path]
    factor, unit = unit_text(np.stack([path[name].values for name in names]))
    for name in names:
        words, colour, dash = _FORCES[name]
        label = rf"$\Delta F_{{{name[2:]}}}$, {words}"
        _curve(axes, path, name, factor, color=colour, linestyle=dash, label=label)
    axes.set(ylabel=f"change of force [{unit}]", title="Vertical forces on the soil, down +, change from the start")


def _rotation(axes: Axes, path: xr.Dataset) -> None:
    _curve(axes, path, "rotation", style.MRAD, color=style.VERMILLION)
    axes.set(ylabel="rotation [mrad]", title="Rotation (positive leans towards +x)")
    ratio = style.DEG / style.MRAD
    both = (lambda mrad: np.multiply(mrad, ratio), lambda degrees: np.divide(degrees, ratio))
    degrees = axes.secondary_yaxis("right", functions=both)
    degrees.set_ylabel("rotation [deg]")


def _heave(axes: Axes, path: xr.Dataset) -> None:
    _curve(axes, path, "w", -style.MM, color=style.GREEN)
    axes.set(ylabel="heave \N{MINUS SIGN}w [mm], up +", title="Heave of the lid centre")


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


@style.styled
def vertical_springs(path: xr.Dataset) -> Figure:
    """Draw the vertical load V [N] with its parts, and the vertical reaction t [kN/m] by depth, over w [mm].

    Parameters
    ----------
    path
        A vertical path of a result: w [m], V [N] and V of each surface, t [N/m] by depth, side and step.
    """
    figure = style.new_figure(9.6, 4.8)
    left, right = figure.subplots(1, 2)
    x, label = abscissa(path)
    _by_surface(left, path, "V", "Vertical load", ", down +")
    _reactions(right, path, x)
    for axes in (left, right):
        axes.set_xlabel(label)
        style.zero_lines(axes)
        if x[-1] < x[0]:
            axes.invert_xaxis()
    style.legend_beside(left)
    style.legend_beside(right, title="depth")
    style.set_title(figure, "Vertical springs", path.attrs)
    return figure


def _reactions(axes: Axes, path: xr.Dataset, x: np.ndarray) -> None:
    good, rings = converged(path), spread_depths(path, MOST_CURVES)
    t = path["t"].sum("side").transpose("depth", "step").values * style.KN
    for ring, colour in zip(rings, depth_colours(len(rings)), strict=True):
        label = f"{float(path['depth'][ring]):.2f} m"
        style.plot_path(axes, x, t[ring], good, color=colour, linewidth=1.7, label=label)
    style.note_unconverged(axes, good)
    axes.set(ylabel="reaction t [kN/m], both sides", title="Vertical reaction by depth")


VERTICAL = Picture(
    name="vertical",
    caption="Vertical springs",
    function=vertical_springs,
    data=lambda view: (view.path,),
    applies=lambda view: view.is_vertical,
    section="",
)
