# SPDX-License-Identifier: MIT
"""Rigid body on springs beside the full model: load, rotation, its point, and the displacement at equal load.

Of a path that turns back: load over motion, and secant stiffness and damping by amplitude, of both models. Runs over
each other (`overlay`): load, rotation or moment, and p-y at some depths, path by path.
"""

from collections.abc import Mapping
from itertools import cycle
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pysprings.core.path_kinds import MEMORY, PATH_KINDS, driven, turns_back
from pysprings.macro.cycles import Followed, control_of, cycles, measured
from pysprings.macro.spring_sets import SPRING_SETS
from pysprings.results.parts import converged
from pysprings.results.plots import overview, style
from pysprings.results.plots.picture import Picture, abscissa, unit_text
from pysprings.springs.path import SpringPath

LOOKS = {
    "fan": (style.GREEN, "-.", "^"),
    "full": (style.BLUE, "--", "o"),
    "pisa": (style.ORANGE, ":", "D"),
    "py": (style.VERMILLION, "--", "s"),
    "memory": (style.PURPLE, "-", "v"),
}
FULL_NAME = "full model (3D finite elements)"
SMALLEST = 0.01  # states below this share of the largest displacement have no error and no point of rotation


@style.styled
def macro_against_full(full: xr.Dataset, curves: Mapping[str, xr.Dataset]) -> Figure:
    """Draw the full model and predictions of the rigid body on springs along the same path.

    Parameters
    ----------
    full
        The full model's path: u [m], H [N] (M [N m] on a rotation path), rotation [rad], all by step.
    curves
        Predictions by spring set (``"fan"``, ``"full"``, ``"py"``, or any name), with the same variables by step; with
        ``u_at_load`` [m] the displacement error at equal load is drawn, too. A free head shows its point of rotation;
        where motions are imposed the other load stands beside.
    """
    kind = PATH_KINDS[full.attrs["kind"]]
    driver, load, free = driven(full.attrs), kind.load, kind.free_head
    label = "rotation [mrad]" if driver == "rotation" else "lateral displacement u of the lid [mm]"
    figure = style.new_figure(9.6, 8.6 if free else 4.8)
    left, right, *below = figure.subplots(2 if free else 1, 2).ravel()
    for axes, name in ((left, load), (right, kind.companion or load)):
        factor, unit = (style.MRAD, "mrad") if name == "rotation" else unit_text(full[name].values)
        _draw(axes, full, curves, driver, name, factor)
        axes.set(xlabel=label, ylabel=f"{name} [{unit}{' m' * (name == 'M')}]")
        if np.nanmin(full[driver].values) >= 0:
            axes.set_xlim(left=0)
        style.zero_lines(axes)
    left.set_title("Load")
    right.set_title("Motion that comes with it" if kind.companion == "rotation" else "Load that comes with it")
    if free:
        _draw_error_at_load(below[0], full, curves)
        _draw_point(below[1], full, curves)
    handles, names = left.get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=2 if len(names) > 3 else len(names))
    style.set_title(figure, "Rigid body on springs against the full model", full.attrs)
    return figure


def _line_style(kind: str) -> dict[str, Any]:
    colour, dash, marker = LOOKS.get(kind, (style.GREEN, "-.", "^"))
    return {"color": colour, "linestyle": dash, "marker": marker, "markersize": 4.5}


def _draw_error_at_load(axes: Axes, full: xr.Dataset, curves: Mapping[str, xr.Dataset]) -> None:
    """Draw the displacement of the prediction over that of the full model under the same load, less 1."""
    for kind, curve in curves.items():
        if "u_at_load" not in curve:
            continue
        u = full["u"].values[converged(full)][: curve.sizes["step"]]  # a curve holds the converged steps
        shown = np.abs(u) > SMALLEST * np.abs(u).max()
        error = 100.0 * (curve["u_at_load"].values[shown] / u[shown] - 1.0)
        axes.plot(u[shown] * style.MM, error, markevery=max(1, shown.sum() // 12), **_line_style(kind))
    axes.set_yscale("symlog", linthresh=10.0)
    axes.axhline(0.0, color=style.INK, linewidth=2.6)
    axes.set(
        xlabel="lateral displacement u of the full model [mm]",
        ylabel="error of u [%] (linear to 10 %)",
        title="Displacement at equal load",
    )


def _draw_point(axes: Axes, full: xr.Dataset, curves: Mapping[str, xr.Dataset]) -> None:
    """Draw the depth of the point of the axis at rest, downwards, over the range of the full model with a margin."""
    depths = [_point(full)]
    axes.plot(full["u"].values * style.MM, depths[0], color=style.INK, linewidth=2.6)
    for kind, curve in curves.items():
        depth = _point(curve)
        axes.plot(curve["u"].values * style.MM, depth, markevery=max(1, depth.size // 12), **_line_style(kind))
    known = depths[0][np.isfinite(depths[0])]
    if known.size:
        low, high = np.percentile(known, [5, 95])
        room = max(high - low, 0.5 * abs(high), 1e-3)
        axes.set_ylim(high + room, low - room)
    axes.set(xlabel="lateral displacement u of the lid [mm]", ylabel="depth [m]", title="Point of rotation")


def _point(data: xr.Dataset) -> np.ndarray:
    """Return the depth u/rotation [m] by step; NaN where the motion is too small."""
    u, rotation = data["u"].values, data["rotation"].values
    shown = (np.abs(u) > SMALLEST * np.abs(u).max(initial=0.0)) & (rotation != 0.0)
    return np.where(shown, u / np.where(shown, rotation, 1.0), np.nan)


def _draw(axes: Axes, full: xr.Dataset, curves: Mapping[str, xr.Dataset], driver: str, name: str, scale: float) -> None:
    drive = style.MRAD if driver == "rotation" else style.MM
    looks: list[tuple[xr.Dataset, dict[str, Any]]] = [
        (full, {"color": style.INK, "linewidth": 2.6, "label": FULL_NAME})
    ]
    for kind, curve in curves.items():
        label = f"macro-model, {SPRING_SETS[kind].label}" if kind in SPRING_SETS else kind
        every = max(1, curve.sizes["step"] // 12)
        looks.append((curve, {**_line_style(kind), "markevery": every, "label": label}))
    for data, look in looks:
        style.plot_path(axes, data[driver].values * drive, data[name].values * scale, converged(data), **look)
    style.note_unconverged(axes, np.concatenate([converged(data) for data, _ in looks]))


PICTURE = Picture(
    name="macro_against_full",
    caption="Rigid body on springs against the full model",
    function=macro_against_full,
    data=lambda view: (view.path, view.predictions),
    applies=lambda view: not view.is_vertical and bool(view.predictions),
    section="comparison",
)


FULL = "full model"


@style.styled
def memory_loops(path: SpringPath, answers: Mapping[str, xr.Dataset]) -> Figure:
    """Draw H over u and M over the rotation, and secant stiffness and damping ratio of each cycle over its amplitude.

    Where one of both motions is held, both loads are drawn over the other.

    Parameters
    ----------
    path
        A path that turns back, with u [m], rotation [rad], H [N] and M [N m] by step.
    answers
        Answers of springs along it, by spring set, with the same variables.
    """
    figure = style.new_figure(9.6, 7.6)
    axes = figure.subplots(2, 2)
    motions = {"H": ("u", style.MM, "u [mm]"), "M": ("rotation", style.MRAD, "rotation [mrad]")}
    moved = [load for load, (name, *_) in motions.items() if np.ptp(path[name]) > overview.SMALLEST]
    for panel, y in zip(axes[0], motions, strict=True):
        x, scale, label = motions[y if y in moved or not moved else moved[0]]
        factor, unit = unit_text(path[y])
        panel.plot(path[x] * scale, path[y] * factor, color=style.INK, linewidth=2.2, label=FULL)
        for name, answer in answers.items():
            colour, dash, _ = LOOKS[name]
            values = answer[x].values * scale, answer[y].values * factor
            panel.plot(*values, color=colour, linestyle=dash, label=SPRING_SETS[name].label)
        panel.set(xlabel=label, ylabel=f"{y} [{unit} m]" if y == "M" else f"{y} [{unit}]")
        style.zero_lines(panel)
    axes[0, 0].legend(loc="best", fontsize=8)
    for name, answer in answers.items():
        _measures(axes[1], path, name, answer)
    style.set_title(figure, "Loops", dict(path.dataset.attrs))
    return figure


def _measures(panels: np.ndarray, path: SpringPath, name: str, answer: xr.Dataset) -> None:
    """Draw secant stiffness and damping ratio by branch over the amplitude of the motion."""
    n = answer.sizes["step"]
    full = np.stack([path.u, path.rotation], axis=1)[:n], np.stack([path["H"], path["M"]], axis=1)[:n]
    motions, loads = (
        np.stack([answer[a].values, answer[b].values], axis=1) for a, b in (("u", "rotation"), ("H", "M"))
    )
    one = Followed(path, name, control_of(path), full, (motions, loads), "", V=path.given_loads[:n])
    table, (by_rotation, _) = cycles(one), measured(one)
    ends = np.concatenate([-table["x_end_full"][:1], table["x_end_full"]])  # the first branch is half of one
    amplitude = 0.5 * np.abs(np.diff(ends)) * style.MM
    colour, _, marker = LOOKS[name]
    factor, unit = unit_text(table["secant_full"].to_numpy())
    secant, motion = (
        (f"dM/d(rotation) [{unit} m/rad]", "rotation [mrad]") if by_rotation else (f"dH/du [{unit}/m]", "u [mm]")
    )
    rows = (("secant", factor, f"secant stiffness {secant}"), ("damping", 1.0, "damping ratio of the cycle"))
    for panel, (what, scale, words) in zip(panels, rows, strict=True):
        for whose, look in (("full", (style.INK, "o", FULL)), ("macro", (colour, marker, SPRING_SETS[name].label))):
            looks = dict(zip(("color", "marker", "label"), look, strict=True))
            values = table[f"{what}_{whose}"].to_numpy() * scale
            panel.plot(amplitude, values, linestyle="none", markersize=6, fillstyle="none", **looks)
        top = panel.dataLim.y1 if np.isfinite(panel.dataLim.y1) else 1.0  # no cycle closes
        panel.set(xlabel=f"amplitude of {motion}", ylabel=words, ylim=(0.0, 1.05 * top))


LOOPS = Picture(
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


_RUNS = ((style.BLUE, "-"), (style.VERMILLION, "--"), (style.GREEN, "-."), (style.PURPLE, ":"))
DEPTHS = (0.15, 0.5, 0.85)  # of the skirt
NOISE = 1e-12  # deg, of a translation


@style.styled
def overlay(runs: Mapping[str, xr.Dataset], name: str) -> Figure:
    """Draw one path as some runs recorded it, by name of the run: load, rotation, and p-y at three depths."""
    figure = style.new_figure(11.4, 4.2)
    left, middle, right = figure.subplots(1, 3)
    for (run, path), (colour, line) in zip(runs.items(), cycle(_RUNS), strict=False):
        x, label = abscissa(path)
        load = {"u": "H", "w": "V", "rotation": "M"}[driven(path.attrs)]
        left.plot(x, 1e-3 * path[load].values, line, color=colour, label=style.plain(run))
        left.set_xlabel(label)
        left.set_ylabel(f"{load} [{'kN m' if load == 'M' else 'kN'}]")
        turned = style.DEG * path["rotation"].values
        middle.plot(x, np.where(np.abs(turned) < NOISE, 0.0, turned), line, color=colour)
        middle.set_xlabel(label)
        middle.set_ylabel("rotation [deg]")
        _springs(right, path, colour, line)
    for axes in (left, middle, right):
        style.zero_lines(axes)
    left.legend()
    figure.suptitle(f"path {style.plain(name)}: {' and '.join(style.plain(run) for run in runs)}")
    return figure


def _springs(axes: Axes, path: xr.Dataset, colour: str, line: str) -> None:
    depth = path["depth"].values
    p = path["p"].transpose("depth", "step").values
    y = path["y"].transpose("depth", "step").values
    for share in DEPTHS:
        k = int(np.argmin(np.abs(depth - share * float(path["depth_bounds"].values[-1, 1]))))
        axes.plot(style.MM * y[k], 1e-3 * p[k], line, color=colour, linewidth=1.2)
    axes.set_xlabel("y [mm]")
    axes.set_ylabel("p [kN/m], three depths")
