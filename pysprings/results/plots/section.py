# SPDX-License-Identifier: MIT
"""Figures in the symmetry plane: the mesh with the caisson in it, and the displacement of the soil."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation

from pysprings.core.arrays import Array, Integers
from pysprings.core.path_kinds import has_free_head, height_of_load
from pysprings.results.parts import pick_step
from pysprings.results.plots import style
from pysprings.results.plots.picture import Picture, caisson_size, step_text

LID_SHARE = 0.05  # thickness of a drawn lid over the diameter, where the scene's is not known


@style.styled
def mesh(section: xr.Dataset) -> Figure:
    """Draw the mesh in the symmetry plane with the caisson, whole and near the caisson.

    Parameters
    ----------
    section
        ``/section`` of a result: section_x, section_depth (section_node) [m] and section_quad
        (section_cell, corner).
    """
    figure = style.new_figure(8.2, 8.4, compressed=True)
    whole, near = figure.subplots(2, 1, height_ratios=[1, 1.75])
    for axes in (whole, near):
        _draw_mesh(axes, section)
        _draw_caisson(axes, section)
        _label_axes(axes)
    whole.set_title("whole section")
    whole.set_ylim(top=-1.6)
    left, right, top, bottom = _zoom(near, section, 1.6, 1.8)
    near.set_title("near the caisson (frame above)")
    look: Any = {"fill": False, "edgecolor": style.VERMILLION, "linewidth": 1.5, "zorder": 6}
    whole.add_patch(Rectangle((left, top), right - left, bottom - top, **look))
    _load_arrow(near, section)
    style.set_title(figure, "Mesh in the symmetry plane", section.attrs, _mesh_counts(section))
    return figure


@style.styled
def section_displacement(
    section: xr.Dataset, path: xr.Dataset, step: int | None = None, displacement: float | None = None
) -> Figure:
    """Draw lateral and vertical displacement [mm] of the soil in the symmetry plane (paper's figures 5, 6).

    Parameters
    ----------
    section
        ``/section`` of a result.
    path
        One path with section_ux, section_uz (step, section_node) [m].
    step, displacement
        A step, or the lateral displacement [m] it should be nearest to; default the last converged step.
    """
    step = pick_step(path, step, displacement)
    figure = style.new_figure(8.2, 9.0, compressed=True)
    lateral, vertical = figure.subplots(2, 1)
    for axes, name, title in (
        (lateral, "section_ux", "lateral displacement of the soil, towards +x [mm]"),
        (vertical, "section_uz", "vertical displacement of the soil, down + [mm]"),
    ):
        values = path[name].transpose("step", "section_node").values[step] * style.MM
        _draw_field(axes, section, values)
        axes.set_title(title)
    _load_arrow(lateral, section, path, step)
    factor = _draw_moved_caisson(lateral, section, path, step)
    _draw_moved_caisson(vertical, section, path, step)
    elastic = path.attrs.get("caisson_behaviour") == "elastic"
    motion = "rigid motion of the lid's centre" if elastic else "caisson's motion"
    moved = f"dashed: the {motion}, {factor:g} times" if factor else ""
    style.set_title(figure, f"Displacement in the symmetry plane at {step_text(path, step)}", path.attrs, moved)
    return figure


@style.styled
def section_pressure(
    section: xr.Dataset, path: xr.Dataset, step: int | None = None, displacement: float | None = None
) -> Figure:
    """Draw the excess pore pressure [kPa] of the soil in the symmetry plane (paper's figure 13).

    Parameters
    ----------
    section
        ``/section`` of a result.
    path
        One path with section_pore_pressure (step, section_node) [Pa].
    step, displacement
        A step, or the lateral displacement [m] it should be nearest to; default the last converged step.
    """
    step = pick_step(path, step, displacement)
    figure = style.new_figure(8.2, 5.4, compressed=True)
    axes = figure.subplots()
    _draw_field(axes, section, path["section_pore_pressure"].isel(step=step).values * style.KPA, "kPa")
    _load_arrow(axes, section, path, step)
    style.set_title(figure, "Excess pore pressure in the symmetry plane", path.attrs, f"at {step_text(path, step)}")
    return figure


def quad_corners(section: xr.Dataset) -> Array:
    """Return the corners of the section's cells, shape (cell, corner, 2): x and depth [m]."""
    nodes = np.column_stack([section["section_x"].values, section["section_depth"].values])
    return nodes[section["section_quad"].transpose("section_cell", "corner").values.astype(int)]


def triangles(section: xr.Dataset) -> Integers:
    """Split each cell of the section in two triangles, shape (2 n_cell, 3), node numbers; voids stay void."""
    quads = section["section_quad"].transpose("section_cell", "corner").values.astype(int)
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def _draw_mesh(axes: Axes, section: xr.Dataset) -> None:
    cells = PolyCollection(list(quad_corners(section)), facecolor=style.SOIL, edgecolor="#9a8f78", linewidth=0.35)
    cells.set_gid("mesh")
    axes.add_collection(cells)
    axes.autoscale_view()
    axes.grid(False)


def _draw_field(axes: Axes, section: xr.Dataset, values: Array, unit: str = "mm") -> None:
    """Draw values at the nodes as colour with their contours, and the caisson, in its neighbourhood."""
    grid = Triangulation(section["section_x"].values, section["section_depth"].values, triangles(section))
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    size = max(high, -low, 1e-9)
    shade = axes.tripcolor(grid, values, shading="gouraud", norm=Normalize(-size, size), cmap=style.SIGNED_COLOURS,
                           rasterized=True)  # fmt: skip
    bar = axes.figure.colorbar(shade, ax=axes, label=unit, shrink=0.85, pad=0.02)
    levels = np.asarray(MaxNLocator(9).tick_values(low, high) if high > low else [])
    if levels.size:
        lines = axes.tricontour(grid, values, levels=levels, colors="black", linewidths=0.5, linestyles="solid")
        bar.add_lines(lines)
    axes.grid(False)
    _draw_caisson(axes, section)
    _zoom(axes, section, 2.6, 2.4)
    _label_axes(axes)


def caisson_polygon(section: xr.Dataset) -> Array:
    """Return the outline of the caisson in the symmetry plane, shape (9, 2): x and depth [m]."""
    inner, outer, length = caisson_size(section)
    top = -float(section.attrs.get("lid_thickness_m", 2 * LID_SHARE * outer))
    right = [(outer, top), (outer, length), (inner, length), (inner, 0.0)]
    return np.array([(-outer, top), *right, *((-x, z) for x, z in reversed(right))])


def _draw_caisson(axes: Axes, section: xr.Dataset) -> None:
    outline = caisson_polygon(section)
    if np.isfinite(outline).all():
        axes.add_patch(
            Polygon(outline, closed=True, facecolor=style.STEEL, edgecolor=style.STEEL, linewidth=1.0, zorder=4)
        )
        axes.patches[-1].set_gid("caisson")


def _draw_moved_caisson(axes: Axes, section: xr.Dataset, path: xr.Dataset, step: int) -> float:
    """Draw the displaced outline, exaggerated; return the factor (0 when nothing moved)."""
    outline = caisson_polygon(section)
    u, w, rotation = (float(path[name][step]) for name in ("u", "w", "rotation"))
    motion = np.column_stack([u - rotation * outline[:, 1], w + rotation * outline[:, 0]])
    largest = float(np.abs(motion).max())
    if not np.isfinite(largest) or largest < 1e-12:
        return 0.0
    exact = 0.15 * outline[:, 0].max() / largest
    factor = float(f"{exact:.0e}")  # one digit: a round number to read
    axes.plot(*(outline + factor * motion).T, color=style.VERMILLION, linewidth=1.4, linestyle="--", zorder=7)
    return factor


def _zoom(axes: Axes, section: xr.Dataset, radii: float, lengths: float) -> tuple[float, float, float, float]:
    """Frame the neighbourhood of the caisson; return its (left, right, top, bottom) [m]."""
    _, outer, length = caisson_size(section)
    reach, floor = section["section_x"].values.max(), section["section_depth"].values.max()
    half = float(np.nanmin([radii * outer, reach]))
    bottom = float(np.nanmin([lengths * length, floor]))
    top = -0.28 * (outer if np.isfinite(outer) else half)
    axes.set_xlim(-half, half)
    axes.set_ylim(bottom, top)
    return -half, half, top, bottom


def _label_axes(axes: Axes) -> None:
    axes.set_aspect("equal")
    if not axes.yaxis_inverted():
        axes.invert_yaxis()
    axes.set(xlabel="x, loading direction [m]", ylabel="depth below mudline [m]")


def _load_arrow(axes: Axes, section: xr.Dataset, path: xr.Dataset | None = None, step: int = 0) -> None:
    """Mark where the load of a path acts, and its sense at a step: at its arm, or at the frame's edge with the arm.

    Without a path, or where no load height is given, the arrow is the positive sense of H at the lid.
    """
    _, outer, _ = caisson_size(section)
    if not np.isfinite(outer):
        return
    arm = None if path is None else height_of_load(path.attrs)
    if path is not None and arm is None and has_free_head(path.attrs) and path["H"][step]:  # it changes
        arm = float(path["M"][step] / path["H"][step])
    if arm is None:
        start, depth, words, sense = 1.03 * outer, -0.12 * outer, "H, u", 1.0
    else:
        assert path is not None
        sense = -1.0 if float(path["H"][step]) < 0.0 else 1.0
        top = min(axes.get_ylim())
        start, depth = 0.0, max(-arm, 0.75 * top)
        beyond = " (beyond the frame)" if -arm < 0.75 * top else ""
        words = f"H at {arm:.4g} m above mudline{beyond}"
    axes.annotate("", (start + sense * 0.32 * outer, depth), xytext=(start, depth), zorder=8,
                  arrowprops={"arrowstyle": "-|>", "color": style.INK, "linewidth": 1.6})  # fmt: skip
    text = axes.annotate(words, (start + 0.37 * outer, depth), va="center", ha="left", fontsize=9, zorder=8)
    text.set_bbox({"facecolor": "white", "edgecolor": "none", "pad": 0.8, "alpha": 0.85})


def _mesh_counts(section: xr.Dataset) -> str:
    attrs: dict[Any, Any] = section.attrs
    words = [f"preset {attrs['mesh_preset']}"] if attrs.get("mesh_preset") else []
    for key, name in (("n_nodes", "nodes"), ("n_elements", "elements"), ("n_unknowns", "unknowns")):
        if key in attrs:
            words.append(f"{int(attrs[key]):,} {name}")
    return ", ".join(words)


MESH = Picture(
    name="mesh",
    caption="Mesh in the symmetry plane",
    function=mesh,
    data=lambda view: (view.plane,),
    scope="run",
    applies=lambda view: view.section is not None,
    section="numerics",
)
DISPLACEMENT = Picture(
    name="section",
    caption="Displacement in the symmetry plane",
    function=section_displacement,
    data=lambda view: (view.plane, view.path, view.step),
    scope="state",
    applies=lambda view: view.section is not None and "section_ux" in view.path,
    section="states",
)
PRESSURE = Picture(
    name="section_pressure",
    caption="Excess pore pressure in the symmetry plane",
    function=section_pressure,
    data=lambda view: (view.plane, view.path, view.step),
    scope="state",
    applies=lambda view: view.section is not None and "section_pore_pressure" in view.path,
    section="",
)
