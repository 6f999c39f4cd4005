# SPDX-License-Identifier: MIT
"""The paper's curves: components of the load (10, 12), p-y by drainage (16), rate and friction (17)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from matplotlib.lines import Line2D

from pysprings.results.plots.profiles import depth_colours
from pysprings.results.plots.style import (
    BLUE,
    GREEN,
    GREY,
    INK,
    KN,
    MM,
    ORANGE,
    SKY,
    VERMILLION,
    legend_beside,
    new_figure,
    set_title,
    styled,
    zero_lines,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure
    from numpy.typing import NDArray


class RateAndFriction(Protocol):
    """Rate [m/s] (None: drained) and friction coefficient of a run."""

    @property
    def rate(self) -> float | None: ...
    @property
    def friction(self) -> float: ...


Curve = Callable[["xr.Dataset", float], tuple["NDArray[np.float64]", "NDArray[np.float64]"]]
LATERAL = r"lateral displacement $\Delta y$ of the lid centre [mm] (x in this tool)"
# label, variable, colour, dash
_COMPONENTS = (
    (r"$\Delta F_{tot}$, horizontal load", "H", INK, "-"),
    (r"$\Delta F_{in}$, shear inside", "F_in", ORANGE, "-"),
    (r"$\Delta F_{out}$, shear outside", "F_out", BLUE, "-"),
    (r"$\Delta F_{pw}$, water under the lid", "F_pw", SKY, "--"),
)
_MARKERS = ("o", "s", "^", "D")


@styled
def load_components(path: xr.Dataset, beside: xr.Dataset | None = None) -> Figure:
    """Draw the horizontal load and the changes of vertical force [kN] against the displacement, on one pair of axes.

    Parameters
    ----------
    path
        One path: u [m], H, F_in, F_out, F_pw [N], by step.
    beside
        Another path, whose horizontal load is drawn thin: the drained one beside a partially drained one.
    """
    figure = new_figure(8.6, 4.8)
    axes = figure.subplots()
    u = path["u"].values * MM
    if beside is not None:
        axes.plot(beside["u"].values * MM, beside["H"].values * KN, color=GREY, linestyle=":",
                  label=r"$\Delta F_{tot}$, drained")  # fmt: skip
    for label, name, colour, dash in _COMPONENTS:
        axes.plot(u, (path[name].values - path[name].values[0]) * KN, color=colour, linestyle=dash, label=label)
    axes.set_xlabel(LATERAL)
    axes.set_ylabel("force, change from the start [kN]")
    axes.set_xlim(left=0)
    zero_lines(axes)
    legend_beside(axes)
    words = "vertical forces: of the caisson on the soil and the water, down +; whole caisson"
    set_title(figure, "Horizontal load, shear forces on the skirt, water under the lid", path.attrs, words)
    return figure


@styled
def py_by_drainage(drained: xr.Dataset, partially: xr.Dataset, depths: Sequence[float], curve: Curve) -> Figure:
    """Draw p [kN/m] against y [mm] at depths [m]: drained with open markers, partially drained with filled ones.

    curve(path, depth) gives y [m] and p [N/m] by step.
    """
    figure = new_figure(8.6, 5.4)
    axes = figure.subplots()
    looks = list(zip(depths, depth_colours(len(depths)), _MARKERS, strict=False))
    for path, filled in ((drained, False), (partially, True)):
        for depth, colour, marker in looks:
            y, p = curve(path, depth)
            axes.plot(y * MM, p * KN, color=colour, marker=marker, markersize=5.5, linewidth=1.3,
                      linestyle="-" if filled else "--", markerfacecolor=colour if filled else "white",
                      markevery=_spaced(y), gid=f"{'filled' if filled else 'open'} {depth:g}")  # fmt: skip
    axes.set_xlabel("displacement y of the mean fibre of the caisson [mm]")
    axes.set_ylabel("lateral reaction p [kN/m]")
    zero_lines(axes)
    handles = [Line2D([], [], color=c, marker=k, label=f"depth {d:g} m", markersize=5.5) for d, c, k in looks]
    handles += [
        Line2D([], [], color=INK, marker="o", linestyle="--", markerfacecolor="white", label="drained"),
        Line2D([], [], color=INK, marker="o", label="partially drained"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    set_title(figure, "p-y curves, drained and partially drained", drop_drainage(partially.attrs), _rate(partially))
    return figure


def drop_drainage(attrs: Mapping[Any, Any]) -> dict[Any, Any]:
    """Return the attributes of one of several paths of a figure without what is not common to all."""
    return {key: value for key, value in attrs.items() if key not in ("drainage", "status")}


def _rate(path: xr.Dataset) -> str:
    rate = path.attrs.get("rate_m_per_s")
    return "" if rate is None else f"partially drained: {rate * MM:g} mm/s"


def _spaced(x: NDArray[np.float64], n: int = 11) -> list[int]:
    """Choose steps for markers, about evenly over the range of x, the last one included."""
    positions = np.linspace(x[0], x[-1], n)[1:]
    return sorted({int(np.argmin(np.abs(x - value))) for value in positions})


@styled
def idealisations(paths: Mapping[str, xr.Dataset], depths: Sequence[float], curve: Curve) -> Figure:
    """Draw load [kN] against displacement [mm], and p [kN/m] against y [mm] at depths [m], of several runs.

    paths : label -> path with u [m], H [N]. curve(path, depth) gives y [m] and p [N/m] by step.
    """
    figure = new_figure(9.6, 4.8)
    left, right = figure.subplots(1, 2)
    looks = list(zip(paths.items(), (INK, BLUE, VERMILLION), ("-", "--", ":"), strict=False))
    for (label, path), colour, dash in looks:
        left.plot(path["u"] * MM, path["H"] * KN, color=colour, linestyle=dash, label=label)
        for depth, marker in zip(depths, _MARKERS, strict=False):
            y, p = curve(path, depth)
            right.plot(
                y * MM, p * KN, color=colour, linestyle=dash, marker=marker, markersize=5, markevery=_spaced(y, 6)
            )
    left.set_xlabel(LATERAL.removesuffix(" (x in this tool)"))
    left.set_ylabel("horizontal load [kN]")
    right.set_xlabel("displacement y of the mean fibre [mm]")
    right.set_ylabel("lateral reaction p [kN/m]")
    for axes in (left, right):
        zero_lines(axes)
    left.legend(loc="lower right", bbox_to_anchor=(1.0, 0.08), frameon=False)
    marks = [Line2D([], [], color=GREY, marker=k, label=f"{d:g} m") for d, k in zip(depths, _MARKERS, strict=False)]
    right.legend(handles=marks, title="depth", loc="lower right", bbox_to_anchor=(1.0, 0.08), frameon=False)
    set_title(figure, "What the idealisations change", drop_drainage(next(iter(paths.values())).attrs), "drained")
    return figure


@styled
def rates_and_friction(paths: Mapping[str, tuple[xr.Dataset, RateAndFriction]]) -> Figure:
    """Draw the horizontal load [kN] against the displacement for rates and friction coefficients.

    paths : label -> (path with u [m], H [N]; its rate and friction coefficient). One colour a rate, solid with friction
    and dashed without.
    """
    figure = new_figure(8.6, 5.0)
    axes = figure.subplots()
    colours: dict[Any, str] = {}
    for label, (path, case) in paths.items():
        colour = colours.setdefault(case.rate, (INK, BLUE, VERMILLION, GREEN)[len(colours) % 4])
        axes.plot(path["u"].values * MM, path["H"].values * KN, color=colour, linestyle="-" if case.friction else "--",
                  label=label)  # fmt: skip
    axes.set_xlabel(LATERAL)
    axes.set_ylabel(r"horizontal load $\Delta F_{tot}$ [kN]")
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)
    legend_beside(axes)
    attrs = drop_drainage(next(iter(paths.values()))[0].attrs) if paths else {}
    set_title(figure, "Load for loading rates v and friction coefficients \N{GREEK SMALL LETTER MU}", attrs)
    return figure
