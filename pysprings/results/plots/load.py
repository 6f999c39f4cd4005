# SPDX-License-Identifier: MIT
"""Load against displacement, lateral (the paper's figure 10) and vertical, with its parts; the Newton record."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from pysprings.core.path_kinds import driven
from pysprings.results.parts import Attempt, attempts, converged, failed_steps
from pysprings.results.plots import style
from pysprings.results.plots.picture import Picture, View, abscissa, skirt_length, spread_depths, unit_text
from pysprings.results.plots.profiles import MOST_CURVES, depth_colours
from pysprings.results.plots.style import BLUE, GREEN, GREY, SKY, VERMILLION, new_figure, set_title, styled

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
    if {"M_tip", "H_tip"} <= {*path.variables}:  # that of the tip is about the tip
        path = path.assign(M_tip=path["M_tip"] - skirt_length(path) * path["H_tip"])
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
    axes.set(ylabel=f"{letter} [{unit}]{sense}", title=f"{title}, and by surface")


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


NEWTON = Picture(
    name="newton",
    caption="Newton iterations",
    function=newton_record,
    data=_data,
    applies=lambda view: view.convergence is not None,
    section="",
)
