# SPDX-License-Identifier: MIT
"""Normal effective stress around the caisson, drawn radially (the paper's figures 7, 8 and 14)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Arc, Circle, Patch, Wedge

from pysprings.results.analysis.parts import pick_step
from pysprings.results.plots.data import depth_words, pick_depths, step_text
from pysprings.results.plots.picture import Picture
from pysprings.results.plots.style import (
    DEG,
    GREY,
    INK,
    KPA,
    PALE,
    SIDE_COLOURS,
    STEEL,
    VERMILLION,
    new_figure,
    set_title,
    styled,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

TRACE = 1.0  # drawn radius of the caisson: the circle of zero stress
MOST_RADIUS = 2.5
FINER = 10  # drawn points per station
TIMES = "\N{MULTIPLICATION SIGN}"
GAP_LOOK: Any = {"facecolor": "#f6cfb9", "edgecolor": VERMILLION, "hatch": "////", "linewidth": 0.0}


@dataclass(frozen=True)
class Ring:
    """Normal effective stress at one depth of one side of the skirt, over the half model.

    azimuth [rad] (0 at the front) and stress, initial [Pa], all of shape (azimuth,).
    """

    depth: float
    azimuth: NDArray[np.float64]
    stress: NDArray[np.float64]
    initial: NDArray[np.float64]

    @property
    def ratio(self) -> NDArray[np.float64]:
        """Return stress over initial stress, NaN where the initial stress is zero."""
        return np.divide(self.stress, self.initial, out=np.full_like(self.stress, np.nan), where=self.initial > 0)

    def gaps(self) -> list[tuple[float, float]]:
        """Return the zones (from, to) [rad] of the half ring where p'_N = 0.

        A station represents the arc that reaches half-way to its neighbours.
        """
        middle = (self.azimuth[1:] + self.azimuth[:-1]) / 2
        edges = np.concatenate([[0.0], middle, [np.pi]])
        zones: list[tuple[float, float]] = []
        for k in np.flatnonzero(self.stress <= 0.0):
            if zones and zones[-1][1] == edges[k]:
                zones[-1] = (zones[-1][0], float(edges[k + 1]))
            else:
                zones.append((float(edges[k]), float(edges[k + 1])))
        return zones

    def closed(self, values: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Mirror values of the half ring; return (azimuth, values) of a closed curve."""
        angle = np.concatenate([self.azimuth, 2 * np.pi - self.azimuth[::-1], self.azimuth[:1]])
        return angle, np.concatenate([values, values[::-1], values[:1]])


def ring(path: xr.Dataset, step: int, depth: int, side: str) -> Ring:
    """Take one ring of a path: step and depth by index, side ``"outside"`` or ``"inside"``."""
    field = path["normal_effective_stress"].sel(side=side).isel(depth=depth).transpose("step", "azimuth").values
    azimuth = path["azimuth"].values
    order = np.argsort(azimuth)
    return Ring(float(path["depth"][depth]), azimuth[order], field[step][order], field[0][order])


@styled
def stress_rose(
    path: xr.Dataset,
    step: int | None = None,
    displacement: float | None = None,
    depths: Iterable[float] | None = None,
    side: str = "outside",
) -> Figure:
    """Draw p'_N around the caisson at four depths, normalised by its initial value.

    The trace of the caisson is the zero circle and the magnitude goes outward (the paper's figure 7). Zones
    with p'_N = 0 are shaded. The half model is mirrored to the full ring; the front is on the right.

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
    step = pick_step(path, step, displacement)
    rings = [ring(path, step, k, side) for k in pick_depths(path, depths)]
    largest = max([2.0] + [float(np.nanmax(r.ratio)) for r in rings if np.isfinite(r.ratio).any()])
    scale = min(0.5, (MOST_RADIUS - TRACE) / largest)
    columns = min(2, len(rings))
    rows = -(-len(rings) // columns)
    frame = _frame(rings, scale)
    figure = new_figure(4.5 * columns, 4.5 * rows * (frame[3] - frame[2]) / (frame[1] - frame[0]) + 1.6)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in panels:
        axes.set_axis_off()
    for axes, each in zip(panels, rings, strict=False):
        axes.set(xlim=frame[:2], ylim=frame[2:])
        _draw(axes, each, scale, SIDE_COLOURS[side])
    figure.legend(
        handles=_legend(SIDE_COLOURS[side], any(each.gaps() for each in rings)),
        loc="outside lower center",
        ncols=2,
    )
    title = rf"Normal effective stress $p'_N$ / initial, {side} of the skirt"
    set_title(figure, title, path.attrs, f"at {step_text(path, step)}", depth_words(path, depths))
    return figure


def _draw(axes: Axes, each: Ring, scale: float, colour: str) -> None:
    axes.set_aspect("equal")
    draw_gaps(axes, each, TRACE, scale)
    axes.add_patch(Circle((0, 0), TRACE, facecolor=PALE, edgecolor=STEEL, linewidth=2.0, zorder=3))
    axes.add_patch(Circle((0, 0), TRACE + scale, fill=False, edgecolor=INK, linestyle="--", linewidth=1.1, zorder=3))
    _grid_rings(axes, each, scale)
    angle, ratio = refine(*each.closed(each.ratio))
    radius = TRACE + scale * ratio
    axes.plot(
        radius * np.cos(angle),
        radius * np.sin(angle),
        color=colour,
        linewidth=2.0,
        marker="o",
        markersize=3.5,
        markevery=FINER,
        zorder=5,
        gid="stress",
    )
    _centre_text(axes, each)
    axes.annotate(
        "",
        (0.93, 0),
        xytext=(0.66, 0),
        zorder=6,
        arrowprops={"arrowstyle": "-|>", "color": INK, "linewidth": 1.6},
    )


def draw_gaps(axes: Axes, each: Ring, radius: float, width: float) -> None:
    """Shade the zones of a ring without contact stress, from a drawn radius outward."""
    for start, stop in each.gaps():
        for low, high in ((start, stop), (2 * np.pi - stop, 2 * np.pi - start)):
            wedge = Wedge((0, 0), radius + width, low * DEG, high * DEG, width=width, gid="gap", **GAP_LOOK)
            axes.add_patch(wedge)


def _frame(rings: list[Ring], scale: float) -> tuple[float, float, float, float]:
    """Return (left, right, bottom, top) that holds every curve: one frame, one scale for all panels."""
    x, y = [-TRACE - scale, TRACE + scale], [-TRACE - scale, TRACE + scale]
    for each in rings:
        angle, ratio = each.closed(np.nan_to_num(each.ratio))
        x += list((TRACE + scale * ratio) * np.cos(angle))
        y += list((TRACE + scale * ratio) * np.sin(angle))
    return min(x) - 0.12, max(x) + 0.12, min(y) - 0.12, max(y) + 0.12


def refine(angle: NDArray[np.float64], values: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
    """Put nine points between stations, linear in azimuth: chords would dip inside the trace at a gap."""
    turn = np.unwrap(angle)
    fine = np.interp(np.arange(FINER * (turn.size - 1) + 1) / FINER, np.arange(turn.size), turn)
    return fine, np.interp(fine, turn, values)


def _grid_rings(axes: Axes, each: Ring, scale: float) -> None:
    """Draw dotted half circles at multiples of the initial stress, numbered where the curve is farthest."""
    largest = float(np.nanmax(each.ratio)) if np.isfinite(each.ratio).any() else 1.0
    every = 1 if scale > 0.25 else max(1, round(0.25 / scale))
    for multiple in range(1, int(np.floor(max(largest, 1.0))) + 1, every):
        radius = TRACE + scale * multiple
        if multiple > 1:
            turn = 180.0 if _leans_back(each) else 0.0
            axes.add_patch(
                Arc(
                    (0, 0),
                    2 * radius,
                    2 * radius,
                    angle=turn,
                    theta1=-90,
                    theta2=90,
                    edgecolor=GREY,
                    linestyle=":",
                    linewidth=0.9,
                    zorder=2,
                )
            )
        angle = _free_angle(axes, each, multiple, radius)
        text = axes.text(
            radius * np.cos(angle),
            -radius * np.sin(angle),
            f"{multiple}{TIMES}",
            ha="center",
            va="center",
            fontsize=7.5,
            color=INK,
            zorder=6,
            clip_on=True,
        )
        text.set_bbox({"facecolor": "white", "edgecolor": "none", "pad": 0.6})


def _leans_back(each: Ring) -> bool:
    """Return whether the stress is larger at the back than at the front."""
    return bool(each.ratio[-1] > each.ratio[0])


def _free_angle(axes: Axes, each: Ring, multiple: int, radius: float) -> float:
    """Choose the azimuth [rad] inside the frame at which the curve is farthest from a circle."""
    angle = np.radians(np.arange(15, 81, 5))
    if _leans_back(each):
        angle = np.pi - angle
    (left, right), (bottom, _) = axes.get_xlim(), axes.get_ylim()
    x, y = radius * np.cos(angle), -radius * np.sin(angle)
    away = np.abs(np.interp(angle, each.azimuth, np.nan_to_num(each.ratio)) - multiple)
    away[(x < left + 0.08) | (x > right - 0.08) | (y < bottom + 0.08)] = -1.0
    return float(angle[np.argmax(away)])


def _centre_text(axes: Axes, each: Ring) -> None:
    """Write depth, initial stress and the front and back ratios in the middle of the disc."""
    axes.text(-0.05, 0.42, f"depth {each.depth:.2f} m", ha="center", va="center", fontweight="bold", zorder=6)
    initial = float(np.mean(each.initial)) * KPA
    lines = [
        f"initial {initial:.3g} kPa",
        f"front {each.ratio[0]:.2f} {TIMES} initial",
        f"back {each.ratio[-1]:.2f} {TIMES} initial",
    ]
    if not np.isfinite(each.ratio).any():
        lines = ["initial stress is 0:", "no ratio"]
    axes.text(-0.12, -0.1, "\n".join(lines), ha="center", va="center", fontsize=8.5, linespacing=1.4, zorder=6)
    axes.text(0.79, 0.13, "front", ha="center", va="center", fontsize=8, zorder=6)


def _legend(colour: str, gaps: bool) -> list[Line2D | Patch]:
    words = "no contact stress: $p'_N = 0$" if gaps else "no contact stress, $p'_N = 0$: nowhere here"
    return [
        Line2D(
            [],
            [],
            color=colour,
            linewidth=2.0,
            marker="o",
            markersize=3,
            label="now, at the stations (distance from the trace)",
        ),
        Line2D([], [], color=INK, linestyle="--", linewidth=1.1, label="initial stress (circle 1)"),
        Line2D([], [], color=STEEL, linewidth=2.0, label="trace of the caisson = zero"),
        Patch(label=words, **GAP_LOOK),
    ]


def _picture(side: str) -> Picture:
    return Picture(
        name=f"stress_{side}",
        caption=f"Normal effective stress around the caisson, {side}",
        function=partial(stress_rose, side=side),
        data=lambda view: (view.path, view.step),
        scope="state",
        applies=lambda view: "normal_effective_stress" in view.path,
        tall=True,
        section="states" if side == "outside" else "",
    )


OUTSIDE, INSIDE = _picture("outside"), _picture("inside")
