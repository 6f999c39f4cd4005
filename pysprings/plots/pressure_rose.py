# SPDX-License-Identifier: MIT
"""Excess pore pressure around the caisson, drawn radially from its trace (the paper's figure 15)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from pysprings.plots.data import pick_depths, pick_step, step_text
from pysprings.plots.rose import TRACE, refine
from pysprings.plots.style import GREY, INK, KPA, PALE, SIDE_COLOURS, STEEL, new_figure, set_title, styled

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

REACH = 0.6  # drawn length of the largest pressure, in radii of the trace


@styled
def pressure_rose(
    path: xr.Dataset,
    step: int | None = None,
    displacement: float | None = None,
    depths: Iterable[float] | None = None,
) -> Figure:
    """Draw the excess pore pressure in the interface at four depths, on both sides of the skirt.

    The trace of the caisson is zero; pressure goes outward from it, suction inward, on one scale for all panels. The
    half model is mirrored to the full ring; the front is on the right.

    Parameters
    ----------
    path
        One path with pore_pressure (step, side, azimuth, depth) [Pa], compression positive, over hydrostatic.
    step, displacement
        A step, or the lateral displacement [m] it should be nearest to; default the last converged step.
    depths
        Depths [m], nearest rings; default 1/16, 5/16, 9/16 and 13/16 of the skirt.
    """
    step = pick_step(path, step, displacement)
    order = np.argsort(path["azimuth"].values)
    azimuth = path["azimuth"].values[order]
    field = path["pore_pressure"].isel(step=step).transpose("side", "depth", "azimuth").values[:, :, order]
    chosen = pick_depths(path, depths)
    largest = float(np.abs(field[:, chosen]).max()) or 1.0
    columns = min(2, len(chosen))
    rows = -(-len(chosen) // columns)
    figure = new_figure(4.3 * columns, 4.1 * rows + 1.2)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in panels:
        axes.set_axis_off()
    for axes, k in zip(panels, chosen, strict=False):
        rings = {str(side): field[s, k] for s, side in enumerate(path["side"].values)}
        _draw(axes, azimuth, rings, REACH / largest, float(path["depth"][k]))
    figure.legend(handles=_legend(rings, largest), loc="outside lower center", ncols=2)
    set_title(figure, "Excess pore pressure around the skirt", path.attrs, f"at {step_text(path, step)}")
    return figure


def _draw(
    axes: Axes, azimuth: NDArray[np.float64], rings: dict[str, NDArray[np.float64]], scale: float, depth: float
) -> None:
    axes.set_aspect("equal")
    reach = TRACE + REACH + 0.1
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach))
    axes.add_patch(Circle((0, 0), TRACE - REACH, facecolor=PALE, edgecolor="none", zorder=1))
    for radius in (TRACE - REACH, TRACE + REACH):
        axes.add_patch(Circle((0, 0), radius, fill=False, edgecolor=GREY, linestyle=":", linewidth=0.9, zorder=2))
    axes.add_patch(Circle((0, 0), TRACE, fill=False, edgecolor=STEEL, linewidth=2.0, zorder=3))
    for side, values in rings.items():
        angle = np.concatenate([azimuth, 2 * np.pi - azimuth[::-1], azimuth[:1]])
        angle, pressure = refine(angle, np.concatenate([values, values[::-1], values[:1]]))
        distance = TRACE + scale * pressure
        axes.plot(distance * np.cos(angle), distance * np.sin(angle), color=SIDE_COLOURS[side], gid=f"pressure_{side}",
                  linestyle="-" if side == "outside" else "--", linewidth=2.0, zorder=5)  # fmt: skip
    axes.annotate("", (TRACE - 0.04, 0), xytext=(TRACE - 0.25, 0), zorder=6,
                  arrowprops={"arrowstyle": "-|>", "color": INK, "linewidth": 1.4})  # fmt: skip
    lines = [f"depth {depth:.2f} m"]
    lines += [f"{side}: {_show(values[0])} front, {_show(values[-1])} back" for side, values in rings.items()]
    axes.set_title("\n".join(lines), loc="center", fontsize=9)


def _show(pressure: float) -> str:
    return f"{pressure * KPA:.3g} kPa".replace("-", "\N{MINUS SIGN}")


def _legend(sides: Iterable[str], largest: float) -> list[Line2D]:
    curves = [
        Line2D([], [], color=SIDE_COLOURS[side], linestyle="-" if side == "outside" else "--", label=side)
        for side in sides
    ]
    trace = Line2D([], [], color=STEEL, linewidth=2.0, label="trace of the caisson = zero")
    words = f"{_show(largest)} outward, {_show(-largest)} inward"
    return [*curves, trace, Line2D([], [], color=GREY, linestyle=":", label=words)]
