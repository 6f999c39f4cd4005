# SPDX-License-Identifier: MIT
"""All lateral paths of a run over each other: load against displacement, moment against rotation; tilt with limits."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pysprings.core.path_kinds import PATH_KINDS, bends, has_free_head, height_of_load
from pysprings.core.words import SOLVED, TILTS
from pysprings.results.parts import ROUNDING, converged, load_sizes, settings
from pysprings.results.plots import style
from pysprings.results.plots.picture import Part, Picture, View
from pysprings.springs.path import paths_of
from pysprings.springs.path_ends import MARGIN, before_cavitation

SMALLEST = 1e-9  # m or rad: a smaller motion is none
_ROW = 0.06  # share of the height of a panel for a line of text


class LateralPath(NamedTuple):
    """A path that moves the caisson sideways, with the colour that it has in all pictures of its run."""

    name: str
    data: xr.Dataset
    colour: Any


def lateral_paths(tree: xr.DataTree, free_head: bool = False) -> list[LateralPath]:
    """Return the paths that move the caisson sideways, before cavitation; of those with a free head alone."""
    found = []
    for name, path in paths_of(tree).items():
        if not path.is_vertical and path.n > 1:
            found.append((name, before_cavitation(path.recorded), PATH_KINDS[path.kind].free_head))
    colours = mpl.colormaps[style.PATH_COLOURS](np.linspace(0.05, 0.92, len(found)))
    paths = [LateralPath(name, path, colour) for (name, path, _), colour in zip(found, colours, strict=True)]
    return [path for path, (*_, free) in zip(paths, found, strict=True) if free or not free_head]


def _until(tree: xr.DataTree) -> str:
    """Return what ends curves before their last state."""
    cut = any(MARGIN in path and (path[MARGIN] < 0.0).any() for path in paths_of(tree).values() if not path.is_vertical)
    return "to where water would cavitate, beyond which no load is a capacity" if cut else ""


def draw_paths(
    axes: Axes, paths: Sequence[LateralPath], x: tuple[str, float], y: tuple[str, float], least: float = 0.0
) -> None:
    """Draw a variable of each path that moves in it against another, (name, factor) each; held-back paths are dashed.

    The names of the paths are the labels of the lines. A path on which y stays below `least` (N or N m) has none.
    """
    for name, path, colour in (each for each in paths if np.ptp(each.data[x[0]].values) > SMALLEST):
        line = "--" if path.attrs.get("role") == "held-back" else "-"
        across, up = path[x[0]].values * x[1], path[y[0]].values * y[1]
        up = up if np.abs(up).max() > least * y[1] else 0.0 * up
        style.plot_path(
            axes, across, up, converged(path), color=colour, linestyle=line, label=style.plain(name), linewidth=1.5
        )
    style.zero_lines(axes)


@style.styled
def overview(tree: xr.DataTree) -> Figure:
    """Draw H [MN] against u [mm], and M [MN m] against rotation [deg], of all lateral paths of a result or springs."""
    paths, least = lateral_paths(tree), _unsolved(tree)
    figure = style.new_figure(9.6, 4.8)
    left, right = figure.subplots(1, 2)
    draw_paths(left, paths, ("u", style.MM), ("H", style.MN), least["H"])
    left.set(xlabel="lateral displacement u of the lid centre [mm]", ylabel="H [MN]", title="Load")
    draw_paths(right, paths, ("rotation", style.DEG), ("M", style.MN), least["M"])
    right.set(xlabel="rotation [deg]", ylabel="M about the lid centre [MN m]", title="Moment")
    style.set_title(figure, "All lateral paths (dashed: held back)", settings(tree), _until(tree))
    _name_below(figure)
    return figure


def _unsolved(tree: xr.DataTree) -> dict[str, float]:
    """Return H [N] and M [N m] that the tolerance of the solver leaves of zero beside the largest load."""
    known = float(tree.attrs.get("outer_diameter_m", 1.0))
    most = SOLVED * max(load_sizes((path for _, path, _ in lateral_paths(tree)), known).values())
    return {"H": most / known, "M": most}


def _name_below(figure: Figure) -> None:
    """Name the curves of all panels below them, once."""
    lines = {str(line.get_label()): line for axes in figure.axes for line in axes.get_lines()}
    named = {name: line for name, line in lines.items() if not name.startswith("_")}
    figure.legend(list(named.values()), list(named), loc="outside lower center", ncols=5, fontsize=8)


def _of_run(
    name: str, caption: str, function: Callable[..., Figure], section: Part, free_head: bool = False
) -> Picture:
    """Return a picture of all lateral paths of a run; of those with a free head alone."""

    def applies(view: View) -> bool:
        return bool(lateral_paths(view.result, free_head))

    return Picture(name, caption, function, lambda view: (view.result,), "run", applies, section)


PICTURE = _of_run("overview", "Load and moment on all lateral paths", overview, "capacity")


@style.styled
def tilt(tree: xr.DataTree, limits: Iterable[float] = TILTS) -> Figure:
    """Draw H [MN] and M [MN m] against the size of the rotation [deg] on the free-head paths of a result or springs.

    Parameters
    ----------
    tree
        Result or spring set.
    limits
        Tilts [deg] that are marked; a limit far beyond the range is left out.
    """
    figure = style.new_figure(9.6, 4.2)
    left, right = figure.subplots(1, 2)
    for axes, load, unit in ((left, "H", "MN"), (right, "M", "MN m")):
        draw_tilt(axes, tree, load, limits)
        axes.set_ylabel(f"size of {load} [{unit}]")
    left.set_title("Load")
    right.set_title("Moment about the lid centre")
    style.set_title(figure, "Load against tilt, by height of the load", settings(tree), _until(tree))
    for axes in (left, right):
        style.legend_beside(axes, 8.0)
    return figure


def draw_tilt(axes: Axes, tree: xr.DataTree, load: str, limits: Iterable[float] = TILTS) -> None:
    """Draw the size of a load against the size of the rotation on given axes."""
    free = lateral_paths(tree, free_head=True)
    paths = [each._replace(name=_name(each.name, each.data), data=_sizes(each.data)) for each in free]
    draw_paths(axes, paths, ("rotation", style.DEG), (load, style.MN), _unsolved(tree)[load])
    largest = max((float(path["rotation"].max()) * style.DEG for _, path, _ in paths), default=0.0)
    shown = [limit for limit in limits if limit <= 1.5 * largest]
    end = 1.05 * max([largest, *shown]) or 1.0
    for k, limit in enumerate(shown):  # a line of text each, above all curves
        axes.axvline(limit, color=style.INK, linewidth=1.0, linestyle=":", gid="limit", label="_limit")
        side, align = (-2, "right") if limit > 0.5 * end else (2, "left")
        axes.annotate(f"{limit:g}°", (limit, 1.0), (side, -2 - 10 * k), xycoords=("data", "axes fraction"),
                      textcoords="offset points", va="top", ha=align, fontsize=8,
                      bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5})  # fmt: skip
    axes.set_xlim(0.0, end)
    axes.set_ylim(0.0, (1.0 + _ROW * len(shown)) * axes.get_ylim()[1])
    axes.set_xlabel("size of the rotation [deg]")


def _sizes(path: xr.Dataset) -> xr.Dataset:
    names = ["H", "M", "rotation"]
    return path[[*names, "converged"]].assign({name: np.abs(path[name]) for name in names})


def _name(name: str, path: xr.Dataset) -> str:
    height = height_of_load(path.attrs)
    return style.plain(name if height is None else f"{name}: {height:.3g} m above")


TILT = _of_run("tilt", "Load and moment against tilt, with limits of tilt", tilt, "tilt", free_head=True)


@style.styled
def secant_stiffness(tree: xr.DataTree) -> Figure:
    """Draw H/u [MN/m] against u/D, and M/rotation [MN m/rad] against rotation [rad], of all lateral paths.

    The initial stiffness with the other motion held is a line. On a path with a free head the secant is below it: its
    head moves and turns.
    """
    figure = style.new_figure(9.6, 4.8)
    left, right = figure.subplots(1, 2)
    diameter = float(tree.attrs.get("outer_diameter_m", np.nan))
    known = diameter if np.isfinite(diameter) else 1.0
    sizes = load_sizes((path for _, path, _ in lateral_paths(tree)), known)
    least = ROUNDING * max(sizes.values())
    draw_secant(left, tree, "H", "u", known, least / known)
    left.set(xlabel="u / D" if np.isfinite(diameter) else "u [m]", ylabel="H / u [MN/m]", title="Horizontal motion")
    draw_secant(right, tree, "M", "rotation", 1.0, least)
    right.set(xlabel="rotation [rad]", ylabel="M / rotation [MN m/rad]", title="Rotation")
    style.set_title(figure, "Secant stiffness against motion (dashed: held back)", settings(tree), _until(tree))
    _name_below(figure)
    return figure


def draw_secant(axes: Axes, tree: xr.DataTree, load: str, motion: str, over: float, least: float = 0.0) -> None:
    """Draw load over motion against motion / `over` on given axes, for the states where the load drives the motion.

    Loads up to `least` (N or N m) are zero; a path that turns back shows the states of its largest motion so far.
    """
    for name, path, colour in lateral_paths(tree):
        if motion == "rotation" and bends(path.attrs) and not has_free_head(path.attrs):
            continue  # M of a swipe is there before the rotation
        x, y = path[motion].values, path[load].values
        farthest = np.abs(x) >= np.maximum.accumulate(np.abs(x))
        shown = converged(path) & farthest & (np.abs(x) > SMALLEST) & (x * y > 0.0) & (np.abs(y) > least)
        if shown.sum() > 1:
            line = "--" if path.attrs.get("role") == "held-back" else "-"
            size, secant = np.abs(x[shown]) / over, style.MN * y[shown] / x[shown]
            axes.plot(size, secant, line, color=colour, label=style.plain(name), linewidth=1.5)
    axes.set_xscale("log")
    axes.set_ylim(bottom=0.0)
    if "stiffness_initial" in tree.dataset and tree.dataset["stiffness_initial"].shape == (3, 3):
        k = {"u": 0, "rotation": 2}[motion]
        value = style.MN * float(tree.dataset["stiffness_initial"].values[k, k])
        axes.axhline(value, color=style.GREY, linestyle=":", gid="initial", label="_initial")
        axes.set_ylim(top=1.15 * max(value, axes.get_ylim()[1] / 1.15))


SECANT = _of_run(
    "secant_stiffness",
    "Secant stiffness against motion; dotted: initial stiffness of the full model",
    secant_stiffness,
    "capacity",
)
