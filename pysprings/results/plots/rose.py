# SPDX-License-Identifier: MIT
"""Stresses and pressures around the caisson, drawn radially by the paper's rule (its figures 7, 8, 9, 14 and 15).

Application point: where the radial direction meets the trace of the caisson. Magnitude: distance from the trace. Sense:
positive outside the trace, negative inside.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch, Wedge

from pysprings.core.arrays import Array
from pysprings.results.parts import pick_step
from pysprings.results.plots import style
from pysprings.results.plots.picture import Part, Picture, depth_words, heading, of_state, pick_depths, step_text

TRACE = 1.0  # drawn radius of the caisson: the circle of zero
GAP_WIDTH = 0.12  # drawn width of the zones without contact
FINER = 10  # drawn points per station
TIMES = "\N{MULTIPLICATION SIGN}"
GAP_LOOK: Any = {"facecolor": "#f6cfb9", "edgecolor": style.VERMILLION, "hatch": "////", "linewidth": 0.0}
DASHES: Any = {"outside": "-", "inside": "--"}


@dataclass(frozen=True)
class Quantity:
    """What is drawn: a field (step, side, azimuth, depth) [Pa] of a path, even in azimuth, and its look.

    normalised : over the initial normal effective stress of each ring; zones without contact stress are then shaded.
    reach : drawn length of the largest value, in radii of the trace. marks, places : azimuths [rad] whose values stand
    above a panel, and their words. signed : values below zero exist; where not, a circle shows the initial value.
    """

    name: str
    title: str
    gid: str
    normalised: bool = True
    sides: tuple[str, ...] = ("outside", "inside")
    reach: float = 0.6
    marks: tuple[float, ...] = (0.0, np.pi)
    places: tuple[str, ...] = ("front", "back")
    signed: bool = True

    def words(self, value: float) -> str:
        """Return a value with its unit; without one over the initial stress."""
        text = f"{value:.2g}" if self.normalised else f"{value * style.KPA:.3g} kPa"
        return ("0" if self.normalised and abs(value) < 5e-4 else text).replace("-", "\N{MINUS SIGN}")


STRESS = Quantity("normal_effective_stress", "Normal effective stress $p'_N$ / initial", "stress", reach=1.2,
                  signed=False)  # fmt: skip
PRESSURE = Quantity("pore_pressure", "Excess pore pressure around the skirt", "pressure", normalised=False)
PRESSURE_RATIO = replace(PRESSURE, title="Excess pore pressure around the skirt / initial $p'_N$", normalised=True)
SHEAR = Quantity("shear_lateral", "Shear stress in the loading direction / initial $p'_N$, on the soil, along +x "
                 "positive", "shear", marks=(0.0, np.pi / 2.0, np.pi), places=("front", "side", "back"))  # fmt: skip


@style.styled
def stress_rose(
    path: xr.Dataset, step: int | None = None, displacement: float | None = None,
    depths: Iterable[float] | None = None, side: str = "outside",
) -> Figure:  # fmt: skip
    """Draw p'_N around the caisson at four depths, normalised by its initial value.

    The trace of the caisson is the zero circle and the magnitude goes outward. Zones with p'_N = 0 are shaded. The half
    model is mirrored to the full ring; +x is on the right, and the arrow points to the front.

    Parameters
    ----------
    path
        One path with normal_effective_stress (step, side, azimuth, depth) [Pa], compression positive.
    step, displacement
        A step, or the lateral displacement [m] it should be nearest to; default the last converged step.
    depths
        Depths [m], nearest rings; default 1/16, 5/16, 9/16 and 13/16 of the skirt.
    side
        ``"outside"`` or ``"inside"`` of the skirt.
    """
    quantity = replace(STRESS, title=f"{STRESS.title}, {side} of the skirt", sides=(side,))
    return _rose(path, quantity, step, displacement, depths)


@style.styled
def pressure_rose(
    path: xr.Dataset, step: int | None = None, displacement: float | None = None,
    depths: Iterable[float] | None = None, normalised: bool = False,
) -> Figure:  # fmt: skip
    """Draw the excess pore pressure in the interface at four depths, on both sides of the skirt; suction goes inward.

    Parameters as those of `stress_rose`; path with pore_pressure (step, side, azimuth, depth) [Pa], compression
    positive, over hydrostatic. normalised : over the initial normal effective stress of each ring, as the paper does,
    instead of kPa; zones without contact stress are then marked.
    """
    return _rose(path, PRESSURE_RATIO if normalised else PRESSURE, step, displacement, depths)


@style.styled
def shear_rose(
    path: xr.Dataset, step: int | None = None, displacement: float | None = None,
    depths: Iterable[float] | None = None,
) -> Figure:  # fmt: skip
    """Draw the shear stress in the loading direction over the initial p'_N at four depths, on both sides of the skirt.

    Parameters as those of `stress_rose`; path with shear_lateral (step, side, azimuth, depth) [Pa], the traction of
    the caisson on the soil, positive along +x.
    """
    return _rose(path, SHEAR, step, displacement, depths)


@dataclass(frozen=True)
class _Ring:
    """A side of the skirt at one depth over the half model: azimuth [rad] (0 at +x), stress, initial [Pa]."""

    azimuth: Array
    stress: Array
    initial: Array
    values: Array

    def gaps(self) -> list[tuple[float, float]]:
        """Return the zones (from, to) [rad] where p'_N = 0; a station represents the arc half-way to its neighbours."""
        edges = np.concatenate([[0.0], (self.azimuth[1:] + self.azimuth[:-1]) / 2, [np.pi]])
        zones: list[tuple[float, float]] = []
        for k in np.flatnonzero(self.stress <= 0.0):
            start = zones.pop()[0] if zones and zones[-1][1] == edges[k] else float(edges[k])
            zones.append((start, float(edges[k + 1])))
        return zones


def _ring(path: xr.Dataset, quantity: Quantity, step: int, depth: int, side: str) -> _Ring:
    names = {quantity.name, *(["normal_effective_stress"] if quantity.normalised else ())}
    at = path[sorted(names)].sel(side=side).isel(depth=depth).sortby("azimuth").transpose("step", "azimuth")
    values = contact = at[quantity.name].values.astype(float)
    values = values[step]
    if quantity.normalised:
        contact = at["normal_effective_stress"].values.astype(float)
        values = np.divide(values, contact[0], out=np.full_like(values, np.nan), where=contact[0] > 0)
    return _Ring(at["azimuth"].values, contact[step], contact[0], values)


def _rose(
    path: xr.Dataset, quantity: Quantity, step: int | None, displacement: float | None, depths: Iterable[float] | None,
) -> Figure:  # fmt: skip
    """Draw a quantity around the caisson, one panel a depth, one scale."""
    step = pick_step(path, step, displacement)
    chosen, front = pick_depths(path, depths), heading(path, step)
    quantity = quantity if front > 0.0 else replace(quantity, places=quantity.places[::-1])
    rings = {k: {side: _ring(path, quantity, step, k, side) for side in quantity.sides} for k in chosen}
    sizes = [np.nan_to_num(np.abs(ring.values)).max() for sides in rings.values() for ring in sides.values()]
    largest = float(max(sizes)) or 1.0
    if not quantity.signed:
        largest = max(largest, 1.0)  # the circle of the initial value stays in view
    columns = min(2, len(chosen))
    rows = -(-len(chosen) // columns)
    figure = style.new_figure(4.3 * columns, 4.1 * rows + 1.2)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in panels:
        axes.set_axis_off()
    for axes, (k, sides) in zip(panels, rings.items(), strict=False):
        _frame(axes, quantity, quantity.reach / largest, front)
        _draw(axes, sides, quantity, quantity.reach / largest)
        axes.set_title(_words(float(path["depth"][k]), sides, quantity), loc="center", fontsize=9)
    gaps = quantity.normalised and any(ring.gaps() for sides in rings.values() for ring in sides.values())
    figure.legend(handles=_legend(quantity, largest, gaps), loc="outside lower center", ncols=2)
    style.set_title(figure, quantity.title, path.attrs, f"at {step_text(path, step)}", depth_words(path, depths))
    return figure


def _frame(axes: Axes, quantity: Quantity, scale: float, front: float) -> None:
    """Draw the trace, circles of the largest value outward and inward, or of the initial value; arrow to the front."""
    axes.set_aspect("equal")
    reach = TRACE + quantity.reach + 0.1
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach))
    inner = TRACE - quantity.reach if quantity.signed else TRACE
    axes.add_patch(Circle((0, 0), inner, facecolor=style.PALE, edgecolor="none", zorder=1))
    for radius in {inner, TRACE + quantity.reach} - {TRACE}:
        axes.add_patch(Circle((0, 0), radius, fill=False, edgecolor=style.GREY, linestyle=":", linewidth=0.9, zorder=2))
    axes.add_patch(Circle((0, 0), TRACE, fill=False, edgecolor=style.STEEL, linewidth=2.0, zorder=3))
    if not quantity.signed:
        axes.add_patch(Circle((0, 0), TRACE + scale, fill=False, edgecolor=style.INK, linestyle="--", linewidth=1.1,
                              zorder=3))  # fmt: skip
    axes.annotate("", (0.36 * front, 0), xytext=(-0.36 * front, 0), zorder=6,
                  arrowprops={"arrowstyle": "-|>", "color": style.INK, "linewidth": 1.4})  # fmt: skip


def _draw(axes: Axes, sides: Mapping[str, _Ring], quantity: Quantity, scale: float) -> None:
    """Draw the curves of the sides, mirrored to the full ring, and shade their zones without contact."""
    for number, (side, ring) in enumerate(sides.items()):
        if quantity.normalised:
            inward = TRACE if side == "outside" or not quantity.signed else TRACE - (number + 1) * GAP_WIDTH
            _shade_gaps(axes, ring, inward)
        turn = np.concatenate([ring.azimuth, 2 * np.pi - ring.azimuth[::-1], ring.azimuth[:1] + 2 * np.pi])
        values = np.concatenate([ring.values, ring.values[::-1], ring.values[:1]])
        # linear in azimuth between stations: chords would dip inside the trace at a gap
        place = np.arange(FINER * (turn.size - 1) + 1) / FINER
        angle = np.interp(place, np.arange(turn.size), turn)
        distance = TRACE + scale * np.interp(place, np.arange(turn.size), values)
        axes.plot(distance * np.cos(angle), distance * np.sin(angle), color=style.SIDE_COLOURS[side],
                  gid=f"{quantity.gid}_{side}", linestyle=DASHES[side], linewidth=2.0, zorder=5)  # fmt: skip


def _shade_gaps(axes: Axes, ring: _Ring, radius: float) -> None:
    for start, stop in ring.gaps():
        for low, high in ((start, stop), (2 * np.pi - stop, 2 * np.pi - start)):
            arc = low * style.DEG, high * style.DEG
            axes.add_patch(Wedge((0, 0), radius + GAP_WIDTH, *arc, width=GAP_WIDTH, gid="gap", **GAP_LOOK))


def _words(depth: float, sides: Mapping[str, _Ring], quantity: Quantity) -> str:
    lines = [f"depth {depth:.2f} m"]
    for side, ring in sides.items():
        values = [quantity.words(float(np.interp(mark, ring.azimuth, ring.values))) for mark in quantity.marks]
        text = ", ".join(f"{value} {place}" for value, place in zip(values, quantity.places, strict=True))
        if quantity.normalised and not np.isfinite(ring.values).any():
            text = "the initial stress is 0, no ratio"
        lines.append(f"{side}: {text}")
    if not quantity.signed:
        lines.append(f"initial {style.KPA * float(np.mean([ring.initial for ring in sides.values()])):.3g} kPa")
    return "\n".join(lines)


def _legend(quantity: Quantity, largest: float, gaps: bool) -> list[Line2D | Patch]:
    unit = f" {TIMES} initial $p'_N$" if quantity.normalised else ""
    words = f"{quantity.words(largest)}{unit} outward"
    words += f", {quantity.words(-largest)} inward" if quantity.signed else ""
    handles: list[Line2D | Patch] = [
        Line2D([], [], color=style.SIDE_COLOURS[side], linestyle=DASHES[side], label=side) for side in quantity.sides
    ]
    handles.append(Line2D([], [], color=style.STEEL, linewidth=2.0, label="trace of the caisson = zero"))
    if not quantity.signed:
        handles.append(Line2D([], [], color=style.INK, linestyle="--", linewidth=1.1, label="initial stress"))
    handles.append(Line2D([], [], color=style.GREY, linestyle=":", label=words))
    return [*handles, Patch(label="no contact: $p'_N = 0$", **GAP_LOOK)] if gaps else handles


def _stress(side: str, section: Part) -> Picture:
    caption = f"Normal effective stress around the caisson, {side}"
    draw = partial(stress_rose, side=side)
    return of_state(f"stress_{side}", caption, draw, ("normal_effective_stress",), section)


OUTSIDE, INSIDE = _stress("outside", "states"), _stress("inside", "")
PORE_PRESSURE = of_state(
    "pressure", "Excess pore pressure around the skirt", pressure_rose, ("pressure_min", "pore_pressure")
)
