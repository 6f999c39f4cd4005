# SPDX-License-Identifier: MIT
"""Where the interface is open, and how wide: skirt by azimuth and depth, lid in plan, tip by azimuth.

Of an elastic skirt, how it has bent: change of its diameters by depth, and its mean fibre beside the rigid motion.
"""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from pysprings.core.arrays import Array
from pysprings.results.parts import Opening, openings, pick_step, plan_gap, skirt_gap
from pysprings.results.plots import style
from pysprings.results.plots.picture import heading, of_state, step_text


@style.styled
def gap_map(path: xr.Dataset, step: int | None = None, displacement: float | None = None) -> Figure:
    """Draw the gap opening [mm] at a step: outside and inside of the skirt, under the lid, under the tip.

    Parameters
    ----------
    path
        One path with gap (step, side, azimuth, depth) [m]; lid_x, lid_y, lid_gap and tip_* when present.
    step, displacement
        A step, or the lateral displacement [m] it should be nearest to; default the last converged step.
    """
    step = pick_step(path, step, displacement)
    by_surface = {each.surface: each for each in openings(path, step)}
    figure = style.new_figure(10.0, 7.6)
    outside, inside, lid, tip = figure.subplots(2, 2).ravel()
    norm = _skirt_norm(path, step)
    for axes, side in ((outside, "outside"), (inside, "inside")):
        if side in by_surface:
            _draw_skirt(axes, path, step, side, norm)
            axes.set_title(by_surface[side].text())
    _draw_lid(lid, path, step, by_surface.get("under the lid"))
    _draw_tip(tip, path, step, by_surface.get("under the tip"))
    widest = max(by_surface.values(), key=lambda each: each.width)
    summary = "closed everywhere"
    if widest.width > 0:
        summary = f"max {widest.width * style.MM:.3g} mm: {widest.surface}, {widest.place}"
    style.set_title(figure, f"Gap opening at {step_text(path, step)}", path.attrs, summary)
    return figure


def cell_edges(centres: Array, low: float, high: float) -> Array:
    """Return the edges half-way between sorted stations, closed by the ends of the range."""
    return np.concatenate([[low], (centres[1:] + centres[:-1]) / 2, [high]])


def _skirt_norm(path: xr.Dataset, step: int) -> Normalize:
    """Return one colour scale [mm] for both sides of the skirt, so that they can be compared."""
    widest = max(float(np.nanmax(skirt_gap(path, step, str(side)), initial=0.0)) for side in path["side"].values)
    return Normalize(0.0, widest * style.MM if widest > 0 else 1.0)


def _draw_skirt(axes: Axes, path: xr.Dataset, step: int, side: str, norm: Normalize) -> None:
    gap = skirt_gap(path, step, side) * style.MM
    azimuth, depth = path["azimuth"].values, path["depth"].values
    edges = (
        cell_edges(azimuth, 0.0, np.pi) * style.DEG,
        cell_edges(depth, 0.0, float(path["depth_bounds"].values.max())),
    )
    axes.set_facecolor(style.PALE)
    drawn = axes.pcolormesh(
        *edges, np.ma.masked_less_equal(gap, 0.0), norm=norm, cmap=style.GAP_COLOURS, gid=f"gap {side}"
    )
    _around(axes, heading(path, step))
    axes.set(ylim=(edges[1][-1], 0), ylabel="depth below mudline [m]")
    axes.grid(False)
    _bar(axes, drawn, gap)


def _around(axes: Axes, front: float) -> None:
    """Give a panel the azimuth of the half model as its axis; front as of `heading`."""
    axes.set(xlim=(0, 180), xlabel="azimuth [deg]")
    first, last = ("front", "back") if front > 0.0 else ("back", "front")
    axes.set_xticks(range(0, 181, 30), [f"0\n{first}", "30", "60", "90\nside", "120", "150", f"180\n{last}"])


def nearest_station_image(x: Array, y: Array, values: Array, n: int = 241) -> np.ma.MaskedArray:
    """Fill a disc with the value of the nearest station of the mirrored half model, shape (n, n): y, x.

    The square reaches from minus to plus the largest radius of the stations; outside the disc is masked.
    """
    from scipy.spatial import cKDTree

    radius = float(np.hypot(x, y).max())
    line = np.linspace(-radius, radius, n)
    grid_x, grid_y = np.meshgrid(line, line)
    tree = cKDTree(np.column_stack([x, np.abs(y)]))
    _, nearest = tree.query(np.column_stack([grid_x.ravel(), np.abs(grid_y.ravel())]))
    return np.ma.masked_where(np.hypot(grid_x, grid_y) > radius, values[nearest].reshape(n, n))


def _draw_lid(axes: Axes, path: xr.Dataset, step: int, opening: Opening | None) -> None:
    if opening is None:
        axes.set_axis_off()
        return
    x, y, gap = plan_gap(path, step, "lid")
    radius = float(np.hypot(x, y).max())
    axes.add_patch(Circle((0, 0), radius, facecolor=style.PALE, edgecolor=style.STEEL, linewidth=1.5, zorder=1))
    image = nearest_station_image(x, y, gap * style.MM)
    drawn = axes.imshow(
        np.ma.masked_less_equal(image, 0.0),
        extent=(-radius, radius, -radius, radius),
        origin="lower",
        zorder=2,
        cmap=style.GAP_COLOURS,
        norm=Normalize(0.0, opening.width * style.MM or 1.0),
        interpolation="nearest",
        gid="gap lid",
    )
    axes.plot(np.r_[x, x], np.r_[y, -y], linestyle="none", marker=".", markersize=1.5, color=style.GREY, zorder=3)
    front = "right" if heading(path, step) > 0.0 else "left"
    axes.set(aspect="equal", xlabel=f"x [m], front on the {front}", ylabel="y [m]", title=opening.text())
    axes.grid(False)
    _bar(axes, drawn, gap)


def _draw_tip(axes: Axes, path: xr.Dataset, step: int, opening: Opening | None) -> None:
    if opening is None:
        axes.set_axis_off()
        return
    x, y, gap = plan_gap(path, step, "tip")
    azimuth, radius = np.arctan2(np.abs(y), x) * style.DEG, np.hypot(x, y)
    order = np.argsort(azimuth)
    several = np.ptp(radius) > 1e-6 * radius.max()
    drawn = axes.scatter(
        azimuth[order],
        gap[order] * style.MM,
        c=radius[order] if several else style.PURPLE,
        cmap=style.RADIUS_COLOURS if several else None,
        s=22,
        linewidths=0,
        gid="gap tip",
        zorder=3,
        clip_on=False,
    )
    _around(axes, heading(path, step))
    axes.set(ylim=(0, 1.08 * opening.width * style.MM or 1), ylabel="gap [mm]", title=opening.text())
    if several:
        axes.figure.colorbar(drawn, ax=axes, label="radius of the point [m]", pad=0.02)


def _bar(axes: Axes, drawn: ScalarMappable, values: Array) -> None:
    """Add a colour bar [mm]; where nothing is open, a remark instead."""
    if np.nanmax(values, initial=0.0) > 0:
        axes.figure.colorbar(drawn, ax=axes, label="gap [mm] (grey: closed)", pad=0.02)
    else:
        text = axes.text(0.5, 0.5, "closed", transform=axes.transAxes, ha="center", va="center", fontsize=12)
        text.set_bbox({"facecolor": "white", "edgecolor": style.GREY, "pad": 4})


PICTURE = of_state("gap", "Gap opening", gap_map, ("gap",), "states")


@style.styled
def ovalisation(path: xr.Dataset, step: int | None = None, displacement: float | None = None) -> Figure:
    """Draw the change of the skirt's diameters [mm] and the displacement of its mean fibre [mm] by depth.

    Parameters
    ----------
    path
        One path of an elastic caisson: diameter_change_x, diameter_change_y and y (depth, step) [m], u, rotation.
    step, displacement
        A step, or the lateral displacement [m] it should be nearest to; default the last converged step.
    """
    step = pick_step(path, step, displacement)
    state = path.isel(step=step)
    depth = path["depth"].values
    figure = style.new_figure(8.6, 4.6)
    left, right = figure.subplots(1, 2, sharey=True)
    left.plot(
        state["diameter_change_x"] * style.MM, depth, "-o", color=style.VERMILLION, label="in the loading direction, x"
    )
    left.plot(state["diameter_change_y"] * style.MM, depth, "--s", color=style.BLUE, label="across it, y")
    left.set(xlabel="change of diameter [mm], growth +", title="Ovalisation of the skirt")
    rigid = float(state["u"]) - float(state["rotation"]) * depth
    right.plot(state["y"] * style.MM, depth, "-o", color=style.INK, label="mean fibre of the skirt")
    right.plot(rigid * style.MM, depth, ":", color=style.INK, label="rigid motion of the lid's centre")
    right.set(xlabel="lateral displacement [mm], towards +x", title="Where the sections are")
    left.set_ylabel("depth below mudline [m]")
    # room for the keys above mudline
    left.set_ylim(1.04 * depth[-1], -0.25 * depth[-1])
    left.set_yticks([tick for tick in left.get_yticks() if 0.0 <= tick <= depth[-1]])
    for axes in (left, right):
        style.zero_lines(axes)
        axes.margins(x=0.1)
        axes.legend(loc="upper center", frameon=False)
    style.set_title(figure, f"Elastic caisson at {step_text(path, step)}", path.attrs)
    return figure


OVALISATION = of_state(
    "ovalisation", "Ovalisation of the skirt, and its mean fibre by depth", ovalisation, ("diameter_change_x",)
)
