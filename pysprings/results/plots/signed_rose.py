# SPDX-License-Identifier: MIT
"""A signed quantity around the caisson, drawn radially by the paper's rule (its figure 7).

Application point: where the radial direction meets the trace of the caisson. Magnitude: distance from the trace. Sense:
positive outside the trace, negative inside.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch

from pysprings.results.analysis.parts import pick_step
from pysprings.results.plots.data import depth_words, pick_depths, step_text
from pysprings.results.plots.rose import GAP_LOOK, TRACE, draw_gaps, refine, ring
from pysprings.results.plots.style import GREY, INK, KPA, PALE, SIDE_COLOURS, STEEL, new_figure, set_title

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

REACH = 0.6  # drawn length of the largest value, in radii of the trace
GAP_WIDTH = 0.12  # drawn width of the zones without contact
TIMES = "\N{MULTIPLICATION SIGN}"


@dataclass(frozen=True)
class Quantity:
    """What is drawn: name in the dataset, title, name of the curves, and whether over the initial normal stress."""

    name: str
    title: str
    gid: str
    normalised: bool
    marks: tuple[float, ...] = (0.0, np.pi)  # azimuths [rad] whose values stand above a panel
    places: tuple[str, ...] = ("front", "back")


def draw_signed_rose(
    path: xr.Dataset, quantity: Quantity, step: int | None, displacement: float | None, depths: Iterable[float] | None,
    sides: Iterable[str] = ("outside", "inside"),
) -> Figure:  # fmt: skip
    """Draw a field (step, side, azimuth, depth) [Pa] of one path around the caisson, four panels, one scale.

    The half model is mirrored to the full ring (the fields drawn are even); the front is on the right.
    """
    step = pick_step(path, step, displacement)
    chosen, sides = pick_depths(path, depths), list(sides)
    order = np.argsort(path["azimuth"].values)
    azimuth = path["azimuth"].values[order]
    rings = {k: {side: _values(path, quantity, step, k, side, order) for side in sides} for k in chosen}
    largest = max(float(np.nanmax(np.abs(v))) for values in rings.values() for v in values.values()) or 1.0
    columns = min(2, len(chosen))
    rows = -(-len(chosen) // columns)
    figure = new_figure(4.3 * columns, 4.1 * rows + 1.2)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in panels:
        axes.set_axis_off()
    for axes, k in zip(panels, chosen, strict=False):
        _frame(axes)
        if quantity.normalised:
            for number, side in enumerate(sides):
                inward = TRACE if side == "outside" else TRACE - (number + 1) * GAP_WIDTH
                draw_gaps(axes, ring(path, step, k, side), inward, GAP_WIDTH)
        _draw(axes, azimuth, rings[k], REACH / largest, quantity)
        axes.set_title(_words(float(path["depth"][k]), azimuth, rings[k], quantity), loc="center", fontsize=9)
    gaps = quantity.normalised and any(ring(path, step, k, side).gaps() for k in chosen for side in sides)
    figure.legend(handles=_legend(sides, largest, quantity, gaps), loc="outside lower center", ncols=2)
    set_title(
        figure,
        quantity.title,
        path.attrs,
        f"at {step_text(path, step)}",
        depth_words(path, depths),
    )
    return figure


def _values(
    path: xr.Dataset, quantity: Quantity, step: int, depth: int, side: str, order: NDArray[np.intp]
) -> NDArray[np.float64]:
    """Return a ring of the quantity: Pa, or over the initial normal effective stress."""
    field = path[quantity.name].sel(side=side).isel(step=step, depth=depth).values.astype(float)[order]
    if not quantity.normalised:
        return np.asarray(field)
    initial = ring(path, step, depth, side).initial
    return np.divide(field, initial, out=np.full_like(field, np.nan), where=initial > 0)


def _frame(axes: Axes) -> None:
    axes.set_aspect("equal")
    reach = TRACE + REACH + 0.1
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach))
    axes.add_patch(Circle((0, 0), TRACE - REACH, facecolor=PALE, edgecolor="none", zorder=1))
    for radius in (TRACE - REACH, TRACE + REACH):
        axes.add_patch(Circle((0, 0), radius, fill=False, edgecolor=GREY, linestyle=":", linewidth=0.9, zorder=2))
    axes.add_patch(Circle((0, 0), TRACE, fill=False, edgecolor=STEEL, linewidth=2.0, zorder=3))


def _draw(
    axes: Axes, azimuth: NDArray[np.float64], rings: Mapping[str, NDArray[np.float64]], scale: float, what: Quantity
) -> None:
    for side, values in rings.items():
        angle = np.concatenate([azimuth, 2 * np.pi - azimuth[::-1], azimuth[:1]])
        angle, drawn = refine(angle, np.concatenate([values, values[::-1], values[:1]]))
        distance = TRACE + scale * drawn
        axes.plot(distance * np.cos(angle), distance * np.sin(angle), color=SIDE_COLOURS[side],
                  gid=f"{what.gid}_{side}", linestyle="-" if side == "outside" else "--", linewidth=2.0,
                  zorder=5)  # fmt: skip
    axes.annotate("", (TRACE - 0.64, 0), xytext=(-0.36, 0), zorder=6,
                  arrowprops={"arrowstyle": "-|>", "color": INK, "linewidth": 1.4})  # fmt: skip


def _words(
    depth: float, azimuth: NDArray[np.float64], rings: Mapping[str, NDArray[np.float64]], what: Quantity
) -> str:  # fmt: skip
    lines = [f"depth {depth:.2f} m"]
    for side, values in rings.items():
        at = [
            f"{_show(float(np.interp(mark, azimuth, values)), what)} {place}"
            for mark, place in zip(what.marks, what.places, strict=True)
        ]
        lines.append(f"{side}: {', '.join(at)}")
    return "\n".join(lines)


def _show(value: float, what: Quantity) -> str:
    text = f"{value:.2g}" if what.normalised else f"{value * KPA:.3g} kPa"
    if what.normalised and abs(value) < 5e-4:
        text = "0"
    return text.replace("-", "\N{MINUS SIGN}")


def _legend(sides: Iterable[str], largest: float, what: Quantity, gaps: bool) -> list[Line2D | Patch]:
    curves: list[Line2D | Patch] = [
        Line2D([], [], color=SIDE_COLOURS[side], linestyle="-" if side == "outside" else "--", label=side)
        for side in sides
    ]
    trace = Line2D([], [], color=STEEL, linewidth=2.0, label="trace of the caisson = zero")
    unit = f" {TIMES} initial $p'_N$" if what.normalised else ""
    words = f"{_show(largest, what)}{unit} outward, {_show(-largest, what)} inward"
    scale = Line2D([], [], color=GREY, linestyle=":", label=words)
    gap = [Patch(label="no contact: $p'_N = 0$", **GAP_LOOK)] if gaps else []
    return [*curves, trace, scale, *gap]
