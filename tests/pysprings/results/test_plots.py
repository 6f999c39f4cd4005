# SPDX-License-Identifier: MIT
"""Figures show the dataset's numbers in the labelled units, and no unconverged step as if it were one."""

import json
import struct
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib import rc_context
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.patches import Wedge

from pysprings.core.errors import UserInputError
from pysprings.core.registry import Registry
from pysprings.results import layout, parts, plots
from pysprings.results.plots import files, gap, picture, rose, section
from pysprings.results.plots.draw import PICTURES
from pysprings.results.plots.picture import View
from pysprings.results.plots.profiles import PANELS
from pysprings.results.plots.style import new_figure
from pysprings.results.report.page import live_parts, pictures_by_part
from tests.support import synthetic

PULL = synthetic.Path("pull", size=2e-2, steps=24)
ROTATION = synthetic.Path("turn", "rotation", size=4e-3, steps=10)


def section_with_caisson(c: synthetic.Caisson) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes x, depth (m) and quads of a symmetry plane whose cells leave the rigid skirt out."""
    inner = c.radius - c.thickness
    half = np.concatenate([np.linspace(0, inner, 7), [c.radius], np.linspace(c.radius, 24, 9)[1:]])
    xs = np.concatenate([-half[:0:-1], half])
    zs = np.concatenate([np.linspace(0, c.length, 7), np.linspace(c.length, 12, 5)[1:]])
    x, depth = (v.ravel() for v in np.meshgrid(xs, zs))
    first = (np.arange(len(zs) - 1)[:, None] * len(xs) + np.arange(len(xs) - 1)).ravel()
    quads = np.stack([first, first + 1, first + len(xs) + 1, first + len(xs)], axis=1)
    middle_x, middle_z = np.abs(x[quads].mean(axis=1)), depth[quads].mean(axis=1)
    return x, depth, quads[~((middle_x > inner) & (middle_x < c.radius) & (middle_z < c.length))]


@pytest.fixture(scope="module")
def trees() -> tuple[xr.DataTree, xr.DataTree]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(synthetic, "section_mesh", section_with_caisson)
        return synthetic.make_result((PULL, ROTATION)), synthetic.make_springs((PULL, ROTATION))


@pytest.fixture
def pull(trees: tuple[xr.DataTree, xr.DataTree]) -> xr.Dataset:
    result, springs = trees
    path = plots.path_data(result, "pull")
    return path.assign_attrs({**parts.settings(springs), **path.attrs}).copy(deep=True)


@pytest.fixture
def plane(trees: tuple[xr.DataTree, xr.DataTree]) -> xr.Dataset:
    found = plots.section_data(trees[0])
    assert found is not None
    return found


@pytest.fixture(scope="module")
def loads(trees: tuple[xr.DataTree, xr.DataTree]) -> Figure:
    return plots.load_displacement(plots.path_data(trees[0], "pull"))


def curve(figure: Figure, panel: int, label: str) -> tuple[np.ndarray, np.ndarray]:
    """The drawn data of the line with this label."""
    line = next(line for line in figure.axes[panel].get_lines() if str(line.get_label()).startswith(label))
    return np.asarray(line.get_xdata()), np.asarray(line.get_ydata())


def title(figure: Figure) -> str:
    return figure.get_suptitle()


# ---------------------------------------------------------------- load and motion


@pytest.mark.parametrize(
    ("panel", "label", "variable", "factor"),
    [
        (0, "total H", "H", 1e-6),
        (0, "skirt outside", "H_outer", 1e-6),
        (0, "skirt inside", "H_inner", 1e-6),
        (0, "lid", "H_lid", 1e-6),
        (0, "tip", "H_tip", 1e-6),
        (1, r"$\Delta F_{in}$", "F_in", 1e-3),
        (1, r"$\Delta F_{out}$", "F_out", 1e-3),
        (1, r"$\Delta F_{pw}$", "F_pw", 1e-3),
    ],
)
def test_loads_are_drawn_in_the_labelled_unit(
    pull: xr.Dataset, loads: Figure, panel: int, label: str, variable: str, factor: float
) -> None:
    x, y = curve(loads, panel, label)
    np.testing.assert_allclose(x, pull["u"].values * 1e3)
    np.testing.assert_allclose(y, pull[variable].values * factor)
    assert {1e-6: "[MN]", 1e-3: "[kN]"}[factor] in loads.axes[panel].get_ylabel()


def test_small_loads_are_in_kilonewton(pull: xr.Dataset) -> None:
    for name in ("H", "H_outer", "H_inner", "H_lid", "H_tip"):
        pull[name] = pull[name] * 1e-2
    figure = plots.load_displacement(pull)
    np.testing.assert_allclose(curve(figure, 0, "total H")[1], pull["H"].values * 1e-3)
    assert "[kN]" in figure.axes[0].get_ylabel()


def test_rotation_and_heave(pull: xr.Dataset, loads: Figure) -> None:
    np.testing.assert_allclose(loads.axes[2].get_lines()[0].get_ydata(), pull["rotation"].values * 1e3)
    np.testing.assert_allclose(loads.axes[3].get_lines()[0].get_ydata(), -pull["w"].values * 1e3)


def test_a_rotation_path_shows_moment_against_rotation(trees: tuple[xr.DataTree, xr.DataTree]) -> None:
    path = plots.path_data(trees[0], "turn")
    figure = plots.load_displacement(path)
    x, y = curve(figure, 0, "total M")
    np.testing.assert_allclose(x, path["rotation"].values * 1e3)
    np.testing.assert_allclose(y, path["M"].values * 1e-6)
    assert figure.axes[0].get_ylabel() == "M [MN m]"
    parts_of_it = [curve(figure, 0, name)[1] for name in ("skirt outside", "skirt inside", "lid", "tip")]
    np.testing.assert_allclose(np.sum(parts_of_it, axis=0), y, rtol=1e-9)  # all about the lid centre


@pytest.mark.slow
def test_title_states_path_drainage_and_size(pull: xr.Dataset, plane: xr.Dataset) -> None:
    for figure in (
        plots.load_displacement(pull),
        plots.py_curves(pull),
        plots.stress_rose(pull),
        plots.gap_map(pull),
        plots.section_displacement(plane, pull),
        plots.macro_against_full(pull, {"full": pull}),
    ):
        for words in ("path pull", "drained", "D = 7.8 m", "L = 4 m"):
            assert words in title(figure)


def test_title_says_when_a_path_stopped_early(pull: xr.Dataset) -> None:
    assert "stopped" not in title(plots.macro_against_full(pull, {}))
    pull.attrs["status"] = "partial"
    assert "partial: stopped before its end" in title(plots.macro_against_full(pull, {}))


def test_what_is_carried_beyond_cavitation_is_not_drawn_beside_other_paths_and_named_on_its_own(
    trees: tuple[xr.DataTree, xr.DataTree],
) -> None:
    """As in the tables of the report, of which these are the pictures; the curves of the page are those, too."""
    tree = trees[0].copy(deep=True)
    path = tree["paths/pull"].to_dataset(inherit=False)
    margin = np.where(np.arange(path.sizes["step"]) < 10, 1e5, -1e3)
    tree["paths/pull"].dataset = path.assign(cavitation_margin=("step", margin, {"units": "Pa"}))
    last = 1e3 * float(path["u"][9])
    for draw, factor in ((plots.overview, 1.0), (plots.secant_stiffness, 1e-3)):
        figure = draw(tree)
        assert max(curve(figure, 0, "pull")[0]) == pytest.approx(factor * last)
        assert "to where water would cavitate" in title(figure) and "cavitate" not in title(draw(trees[0]))
    assert max(curve(plots.tilt(tree), 0, "pull")[0]) == pytest.approx(np.degrees(float(path["rotation"][9])))
    own = title(plots.load_displacement(plots.path_data(tree, "pull")))
    assert f"no capacity where water would cavitate, beyond u = {last:.3g} mm" in own
    live = live_parts(tree)
    assert live is None or max(json.loads(live.data)["paths"][0]["u"]) == pytest.approx(last, rel=1e-3)


def test_text_of_a_scene_is_not_read_as_a_formula(pull: xr.Dataset) -> None:
    pull.attrs["path"] = r"a$\frac{"
    figure = plots.macro_against_full(pull, {})
    figure.draw_without_rendering()
    assert r"a\$\frac{" in title(figure)


# ---------------------------------------------------------------- unconverged steps


def test_unconverged_steps_are_crosses_and_no_part_of_a_curve(pull: xr.Dataset) -> None:
    pull["converged"][[10, 24]] = 0
    figure = plots.load_displacement(pull)
    _, y = curve(figure, 0, "total H")
    assert np.flatnonzero(np.isnan(y)).tolist() == [10, 24]
    crosses = [line for line in figure.axes[0].get_lines() if line.get_gid() == "unconverged"]
    assert len(crosses) == 5
    assert all(line.get_linestyle() == "None" and line.get_marker() == "x" for line in crosses)
    np.testing.assert_allclose(crosses[0].get_xdata(), pull["u"].values[[10, 24]] * 1e3)
    np.testing.assert_allclose(crosses[0].get_ydata(), pull["H"].values[[10, 24]] * 1e-6)
    assert "2 of 25 steps did not converge" in title(figure)


def test_depths_of_py_curves_stand_in_one_key(pull: xr.Dataset) -> None:
    pull["converged"][24] = 0
    figure = plots.py_curves(pull, depths=[0.4])
    ring = picture.pick_depths(pull, [0.4])[0]
    words = [f"{float(pull['depth'][ring]):.2f} m", "not converged"]
    assert [text.get_text() for text in figure.legends[0].get_texts()] == words


def test_curves_are_named_in_the_order_of_their_ends(pull: xr.Dataset) -> None:
    axes = plots.load_displacement(pull).axes[0]
    named = [text.get_text() for text in axes.get_legend().get_texts()]
    ends = {str(line.get_label()): line.get_ydata()[-1] for line in axes.get_lines()}
    assert named[0] == "total H" and len(named) > 2
    assert [ends[name] for name in named] == sorted((ends[name] for name in named), reverse=True)


def test_default_state_is_the_last_converged_one(pull: xr.Dataset) -> None:
    assert parts.pick_step(pull) == 24
    pull["converged"][20:] = 0
    assert parts.pick_step(pull) == 19
    assert parts.pick_step(pull, displacement=1.0) == 19
    nearest = int(np.abs(pull["u"].values - 2.5e-3).argmin())
    assert parts.pick_step(pull, displacement=2.5e-3) == nearest
    assert "NOT CONVERGED" in title(plots.stress_rose(pull, step=-1))
    with pytest.raises(IndexError, match="step 99 is not among the 25 steps"):
        parts.pick_step(pull, step=99)


@pytest.mark.slow
def test_a_path_that_never_converged_still_draws(trees: tuple[xr.DataTree, xr.DataTree]) -> None:
    result = trees[0].copy(deep=True)
    result["paths/pull"]["converged"][1:] = 0
    planned = {each.place.stem: each for each in files.path_plan(View(result, path=parts.path_data(result, "pull")))}
    assert "pull_load_displacement" in planned
    assert "pull_macro_against_full" not in planned
    for each in planned.values():
        figure = each.picture.draw(each.view)
        figure.set_layout_engine("none")  # it takes most of the time
        figure.draw_without_rendering()


# ---------------------------------------------------------------- p-y


def test_py_panels_hold_net_and_sides(pull: xr.Dataset) -> None:
    depths = pull["depth"].values[[0, 4, 9]]
    figure = plots.py_curves(pull, depths)
    sides = pull["p_component"].sum("component")
    wanted = {"net": pull["p"], "outside": sides.sel(side="outside"), "inside": sides.sel(side="inside")}
    by_title = {axes.get_title(loc="left"): axes for axes in figure.axes}
    for side, values in wanted.items():
        lines = [line for line in by_title[PANELS[side]].get_lines() if str(line.get_label()).endswith(" m")]
        assert len(lines) == 3
        for line, ring in zip(lines, (0, 4, 9), strict=True):
            np.testing.assert_allclose(line.get_xdata(), pull["y"].values[ring] * 1e3)
            np.testing.assert_allclose(line.get_ydata(), values.transpose("depth", "step").values[ring] * 1e-3)


def test_py_from_springs_equals_py_from_the_result(pull: xr.Dataset, trees: tuple[xr.DataTree, xr.DataTree]) -> None:
    springs = plots.path_data(trees[1], "pull")
    assert set(picture.lateral_reaction(pull)) >= {"net", "outside", "inside"}
    for side, p in picture.lateral_reaction(pull).items():
        np.testing.assert_allclose(picture.lateral_reaction(springs)[side], p, rtol=1e-12, atol=1e-6)


# ---------------------------------------------------------------- rose


def test_rose_follows_the_papers_rule(pull: xr.Dataset) -> None:
    """Radius = trace + scale * stress / initial at every station and at its mirror image."""
    figure = plots.stress_rose(pull, displacement=2.5e-3, side="outside")
    step, rings = parts.pick_step(pull, displacement=2.5e-3), picture.pick_depths(pull)
    assert len(rings) == 4
    field = pull["normal_effective_stress"].sel(side="outside").transpose("step", "azimuth", "depth").values
    scale = initial_circle(figure, 0) - rose.TRACE
    for panel, k in enumerate(rings):
        (line,) = [line for line in figure.axes[panel].get_lines() if line.get_gid() == "stress_outside"]
        x, y = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
        n = pull.sizes["azimuth"]
        stations = np.hypot(x, y)[::10]  # nine points lie between two stations
        ratio = field[step, :, k] / field[0, :, k]
        np.testing.assert_allclose(stations[:n], rose.TRACE + scale * ratio, rtol=1e-12)
        np.testing.assert_allclose(stations[n:-1], stations[:n][::-1], rtol=1e-12)
        np.testing.assert_allclose(np.arctan2(y, x)[: 10 * (n - 1) + 1 : 10], pull["azimuth"].values, atol=1e-12)
        assert np.hypot(x, y).min() >= rose.TRACE - 1e-9  # never inside the trace: p'_N >= 0


def initial_circle(figure: Figure, panel: int) -> float:
    """Radius of the dashed circle."""
    (circle,) = [p for p in figure.axes[panel].patches if getattr(p, "radius", 0) and p.get_linestyle() == "--"]
    return float(circle.radius)


def shaded(figure: Figure, panel: int) -> list[tuple[float, float]]:
    """Shaded zones (from, to) in degrees."""
    return sorted(
        (p.theta1 % 360, p.theta2 % 360 or 360.0)
        for p in figure.axes[panel].patches
        if isinstance(p, Wedge) and p.get_gid() == "gap"
    )


def test_gap_zones_are_shaded_exactly_where_the_stress_is_zero(pull: xr.Dataset) -> None:
    rings = picture.pick_depths(pull)
    field = pull["normal_effective_stress"].transpose("step", "side", "azimuth", "depth")
    field[24, 0] = np.maximum(field[24, 0], 1.0)  # no gap, then two zones on the first ring
    field[24, 0, [3, 4, 16], rings[0]] = 0.0
    pull["normal_effective_stress"] = field
    figure = plots.stress_rose(pull)
    step = 180 / 16
    zones = [(2.5 * step, 4.5 * step), (15.5 * step, 180.0)]
    mirrored = [(360 - b, 360 - a) for a, b in zones]
    np.testing.assert_allclose(shaded(figure, 0), sorted(zones + mirrored))
    assert all(shaded(figure, panel) == [] for panel in (1, 2, 3))


def test_rose_sides_differ(pull: xr.Dataset) -> None:
    outside, inside = (plots.stress_rose(pull, side=side) for side in ("outside", "inside"))
    assert shaded(outside, 0) and shaded(inside, 0)
    assert shaded(outside, 0)[0][0] > 90 and shaded(inside, 0)[0][0] < 90  # back of the outside, front of the inside


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_front_is_where_the_caisson_goes(pull: xr.Dataset, plane: xr.Dataset, sign: float) -> None:
    """Towards -x the front is at azimuth 180 deg, and the load acts to the left; a pure rotation goes by its lean."""
    leans = pull.assign(u=0.0 * pull["u"], rotation=sign * pull["rotation"])
    path = leans.assign(u=sign * pull["u"], H=sign * pull["H"])
    first, last = ("front", "back") if sign > 0.0 else ("back", "front")
    for each in (path, leans):
        panel = plots.stress_rose(each).axes[0]
        (arrow,) = panel.texts
        assert np.sign(arrow.xy[0] - arrow.xyann[0]) == sign
        field = pull["normal_effective_stress"].transpose("step", "side", "azimuth", "depth").values
        ring = field[:, 0, :, picture.pick_depths(pull)[0]]
        ends = [f"{ring[-1, k] / ring[0, k]:.2g} {words}" for k, words in ((0, first), (-1, last))]
        assert f"outside: {ends[0]}, {ends[1]}" in panel.get_title(loc="center")
        skirt, _, lid, tip = plots.gap_map(each).axes[:4]
        for axes in (skirt, tip):
            words = [label.get_text() for label in axes.get_xticklabels()]
            assert (words[0], words[-1]) == (f"0\n{first}", f"180\n{last}")
        assert lid.get_xlabel() == f"x [m], front on the {'right' if sign > 0.0 else 'left'}"
    arrow = next(text for text in plots.section_displacement(plane, path).axes[0].texts if text.get_text() == "")
    assert np.sign(arrow.xy[0] - arrow.xyann[0]) == sign


def test_rose_without_initial_stress_says_so(pull: xr.Dataset) -> None:
    field = pull["normal_effective_stress"].transpose("step", "side", "azimuth", "depth")
    field[0] = 0.0
    pull["normal_effective_stress"] = field
    assert "initial stress is 0" in plots.stress_rose(pull).axes[0].get_title(loc="center")


def test_depths_default_to_the_papers(pull: xr.Dataset) -> None:
    fine = xr.Dataset({"y": ("depth", np.zeros(81))}, {"depth": np.linspace(0, 4, 81)}, {"skirt_length_m": 4.0})
    assert fine["depth"].values[picture.pick_depths(fine)].tolist() == pytest.approx([0.25, 1.25, 2.25, 3.25])


def test_depths_that_are_not_there_are_named_or_refused(pull: xr.Dataset) -> None:
    ring = float(pull["depth"][4])
    for draw in (plots.py_curves, plots.stress_rose, plots.shear_rose):
        words = title(draw(pull, depths=[ring + 0.02])).replace("\n", " ")  # wrapped to a narrow figure
        assert f"nearest depths with results: {ring:.2f} m for {ring + 0.02:g} m" in words
        assert "nearest" not in title(draw(pull, depths=[ring])) + title(draw(pull))
        with pytest.raises(UserInputError, match=r"-1, 44 m is not on the skirt, 0 to 4 m"):
            draw(pull, depths=[-1.0, ring, 44.0])


# ---------------------------------------------------------------- gap


def test_gap_map_shows_widths_in_mm_and_closed_cells_empty(pull: xr.Dataset) -> None:
    figure = plots.gap_map(pull)
    for side in ("outside", "inside"):
        (mesh,) = [c for axes in figure.axes for c in axes.collections if c.get_gid() == f"gap {side}"]
        drawn = mesh.get_array().reshape(pull.sizes["depth"], pull.sizes["azimuth"])
        width = pull["gap"].sel(side=side).isel(step=-1).transpose("depth", "azimuth").values
        assert (np.ma.getmaskarray(drawn) == (width <= 0)).all()
        np.testing.assert_allclose(drawn.filled(0.0), width * 1e3)


def test_the_tip_shows_its_stations_of_every_radius(pull: xr.Dataset) -> None:
    pull["tip_x"] = pull["tip_x"] * np.linspace(0.98, 1.0, pull["tip_x"].size)
    (points,) = [each for each in plots.gap_map(pull).axes[3].collections if each.get_gid() == "gap tip"]
    shades = points.cmap(points.norm(np.asarray(points.get_array())))
    assert (1.0 - shades[:, :3]).max(axis=1).min() > 0.2  # none is white as the page


def test_wide_titles_are_wrapped_to_the_figure(pull: xr.Dataset) -> None:
    figure = plots.stress_rose(pull.assign_attrs(cavitates="u = 25.9 mm", path="pull_of_a_long_name"))
    figure.draw_without_rendering()
    (box,) = (text.get_window_extent() for text in figure.texts)
    assert 0.0 < box.x0 < box.x1 < figure.bbox.width


def test_gap_titles_state_where_and_how_wide(pull: xr.Dataset) -> None:
    pull["gap"] = xr.zeros_like(pull["gap"])
    pull["gap"].loc[{"step": 24, "side": "inside", "azimuth": pull["azimuth"][4], "depth": pull["depth"][2]}] = 3.21e-3
    pull["lid_gap"][24] = 0.0
    pull["tip_gap"][24] = 0.0
    figure = plots.gap_map(pull)
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    place = f"azimuth 45°, depth {float(pull['depth'][2]):.2f} m"
    assert f"inside: max 3.21 mm\nat {place}" in titles
    assert {f"{part}: closed everywhere" for part in ("outside", "under the lid", "under the tip")} < set(titles)
    assert f"max 3.21 mm: inside, {place}" in title(figure)


def test_lid_map_takes_the_nearest_station_of_the_mirrored_half() -> None:
    x, y, width = (np.array([1.0, 0.0, -1.0, 0.3]), np.array([0.0, 1.0, 0.0, 0.2]), np.array([1.0, 2.0, 3.0, 4.0]))
    image = gap.nearest_station_image(x, y, width, n=41)
    assert [image[20, 40], image[40, 20], image[0, 20], image[20, 0]] == [1.0, 2.0, 2.0, 3.0]
    assert image[24, 26] == image[16, 26] == 4.0
    assert np.ma.getmaskarray(image)[0, 0]


# ---------------------------------------------------------------- section


def test_mesh_draws_every_cell_and_leaves_the_caisson_out(plane: xr.Dataset) -> None:
    figure = plots.mesh(plane)
    for axes in figure.axes:
        (cells,) = [c for c in axes.collections if isinstance(c, PolyCollection)]
        assert len(cells.get_paths()) == plane.sizes["section_cell"]
        (caisson,) = [patch for patch in axes.patches if patch.get_gid() == "caisson"]
        outline = caisson.get_xy()
        assert np.abs(outline[:, 0]).max() == pytest.approx(3.9)
        assert outline[:, 1].max() == pytest.approx(4.0)
        assert 3.8 in np.round(outline[:, 0], 9)
        middle = section.quad_corners(plane).mean(axis=1)
        in_skirt = (np.abs(middle[:, 0]) > 3.8) & (np.abs(middle[:, 0]) < 3.9) & (middle[:, 1] < 4)
        assert not in_skirt.any()
        assert axes.yaxis_inverted()
    assert "2,000 nodes" in title(figure)


def test_caisson_is_measured_in_the_section(plane: xr.Dataset) -> None:
    bare = plane.drop_attrs()
    np.testing.assert_allclose(picture.caisson_size(bare), (3.8, 3.9, 4.0))


def test_section_displacement_is_drawn_at_the_nodes_in_mm(pull: xr.Dataset, plane: xr.Dataset) -> None:
    figure = plots.section_displacement(plane, pull, step=12)
    for axes, name in zip(figure.axes[:2], ("section_ux", "section_uz"), strict=True):
        (shade,) = [
            c
            for c in axes.collections
            if c.get_array() is not None and c.get_array().size == plane.sizes["section_node"]
        ]
        np.testing.assert_allclose(shade.get_array(), pull[name].values[12] * 1e3)


@pytest.mark.parametrize(
    ("factor", "offset", "size"), [(1.0, 0.0, 4.0), (-1.0, 0.0, 4.0), (0.5, 3.0, 5.0)], ids=["up", "down", "one sign"]
)
def test_colours_of_a_field_are_symmetric_about_zero(pull, plane, factor, offset, size) -> None:
    """From -2 to 4 mm, scaled and moved."""
    shape = np.linspace(-2.0, 4.0, plane.sizes["section_node"])
    values = np.broadcast_to(factor * shape + offset, pull["section_ux"].shape)
    figure = plots.section_displacement(plane, pull.assign(section_ux=(pull["section_ux"].dims, 1e-3 * values)), step=3)
    drawn = [c for c in figure.axes[0].collections if c.get_array() is not None]
    (shade,) = [c for c in drawn if c.get_array().size == plane.sizes["section_node"]]
    assert (shade.norm.vmin, shade.norm.vmax) == pytest.approx((-size, size))
    (bar,) = [axes for axes in figure.axes if axes.get_label() == "<colorbar>"][:1]
    assert bar.get_ylim() == pytest.approx((-size, size))


def test_the_frame_is_around_the_caisson_and_within_the_section(plane: xr.Dataset) -> None:
    near = plots.mesh(plane).axes[1]
    reach, floor = float(plane["section_x"].max()), float(plane["section_depth"].max())
    (left, right), (bottom, top) = near.get_xlim(), near.get_ylim()
    assert -left == right and 3.9 < right <= reach
    assert 4.0 < bottom <= floor and top == pytest.approx(-0.28 * 3.9)


def test_triangles_cover_the_cells(plane: xr.Dataset) -> None:
    x, depth = plane["section_x"].values, plane["section_depth"].values
    t = section.triangles(plane)
    area = 0.5 * np.abs(
        (x[t[:, 1]] - x[t[:, 0]]) * (depth[t[:, 2]] - depth[t[:, 0]])
        - (x[t[:, 2]] - x[t[:, 0]]) * (depth[t[:, 1]] - depth[t[:, 0]])
    )
    assert area.sum() == pytest.approx(48 * 12 - 2 * 0.1 * 4)
    assert area @ depth[t].mean(axis=1) == pytest.approx(48 * 12**2 / 2 - 2 * 0.1 * 4**2 / 2)
    assert area @ x[t].mean(axis=1) == pytest.approx(0.0, abs=1e-9)


# ---------------------------------------------------------------- macro-model, Newton


def test_macro_curves_are_those_given(pull: xr.Dataset) -> None:
    py = pull.assign(H=pull["H"] * 0.4, rotation=pull["rotation"] * 1.8)
    figure = plots.macro_against_full(pull, {"full": pull, "py": py})
    for label, path in (("full model", pull), ("macro-model, full", pull), ("macro-model, p-y", py)):
        np.testing.assert_allclose(curve(figure, 0, label)[1], path["H"].values * 1e-6)
        np.testing.assert_allclose(curve(figure, 1, label)[1], path["rotation"].values * 1e3)
        np.testing.assert_allclose(curve(figure, 0, label)[0], path["u"].values * 1e3)


def test_macro_shows_displacement_at_equal_load_and_the_point_of_rotation(pull: xr.Dataset) -> None:
    softer = pull.assign(u_at_load=1.25 * pull["u"], rotation=2.0 * pull["rotation"])
    figure = plots.macro_against_full(pull, {"py": softer})
    assert [axes.get_title(loc="left") or axes.get_title() for axes in figure.axes][2:] == [
        "Displacement at equal load",
        "Point of rotation",
    ]
    error, point = figure.axes[2].lines[0], figure.axes[3].lines
    np.testing.assert_allclose(error.get_ydata(), 25.0)
    good = np.isfinite(point[0].get_ydata())
    np.testing.assert_allclose(point[1].get_ydata()[good], 0.5 * point[0].get_ydata()[good])
    low, high = figure.axes[3].get_ylim()
    assert low > high  # depth downwards
    # where motions are imposed the other load is what the springs answer, not u or rotation, which are given
    stiffer = {"py": pull.assign(M=1.5 * pull["M"], H=1.2 * pull["H"])}
    for kind, load, other, driver in (("translation", "H", "M", "u"), ("rotation", "M", "H", "rotation")):
        pushed = plots.macro_against_full(pull.assign_attrs(kind=kind), stiffer)
        assert len(pushed.axes) == 2
        for axes, name in zip(pushed.axes, (load, other), strict=True):
            known, own = axes.lines[:2]
            np.testing.assert_allclose(known.get_xdata(), 1e3 * pull[driver])
            np.testing.assert_allclose(own.get_ydata(), {"M": 1.5, "H": 1.2}[name] * known.get_ydata())
            assert axes.get_ylabel().split(" ")[0] == name


@pytest.fixture
def record(trees: tuple[xr.DataTree, xr.DataTree]) -> xr.Dataset:
    found = plots.convergence_data(trees[0], "pull")
    assert found is not None
    return found.assign_attrs(tolerance=1e-6)


def test_attempts_tell_cut_backs_from_accepted_increments(record: xr.Dataset) -> None:
    tries = parts.attempts(record)
    assert [(t.step, t.number) for t in tries if not t.accepted] == [(2, 0)]
    assert sum(t.accepted for t in tries) == 24
    assert sum(t.rows.size for t in tries) == record.sizes["iteration"]
    assert [t.step for t in parts.attempts(record, failed_steps=(24,)) if not t.accepted] == [2, 24]


def test_the_last_step_of_a_partial_path_failed(pull: xr.Dataset, record: xr.Dataset) -> None:
    assert parts.failed_steps(pull, record) == ()
    for status in ("partial", "limit load"):
        stopped = pull.assign_attrs(status=status)
        assert parts.failed_steps(stopped.isel(step=slice(-1)), record) == (24,)
        assert parts.failed_steps(stopped, record) == ()  # its last step was taken
    pull["converged"][20] = 0
    assert parts.failed_steps(pull, record) == (20,)


def test_newton_figure_counts_and_marks(record: xr.Dataset) -> None:
    figure = plots.newton_record(record)
    bars = [(p.get_gid(), p.get_height(), p.get_y()) for p in figure.axes[0].patches]
    assert bars.count(("cut back", 3, 0)) == 1
    assert bars.count(("accepted", 3, 3)) == 1  # on top of the attempt that was given up
    assert bars.count(("accepted", 3, 0)) == 23
    drawn = np.concatenate([line.get_ydata() for line in figure.axes[1].get_lines() if line.get_gid()])
    np.testing.assert_allclose(drawn, record["residual"].values)
    assert figure.axes[1].get_yscale() == "log"
    assert "attempts given up: 1" in title(figure)
    assert any(np.allclose(line.get_ydata(), 1e-6) for line in figure.axes[1].get_lines())


# ---------------------------------------------------------------- files and style


STEMS = [
    "mesh",
    "overview",
    "tilt",
    "secant_stiffness",
    "pull_load_displacement",
    "pull_macro_against_full",
    "pull_py",
    "pull_profiles",
    "pull_stress_outside_2.5mm",
    "pull_stress_inside_2.5mm",
    "pull_gap_2.5mm",
    "pull_section_2.5mm",
    "pull_stress_outside_last",
    "pull_stress_inside_last",
    "pull_gap_last",
    "pull_section_last",
    "pull_newton",
]
# Every figure is empty: the tests are about the names of the files.
BLANK = Registry("picture", [replace(each, function=lambda *_: Figure(figsize=(1, 1))) for each in PICTURES])


def test_every_figure_that_a_result_allows_is_written(trees: tuple[xr.DataTree, xr.DataTree], tmp_path: Path) -> None:
    result, springs = trees
    curves = {"pull": {"full": plots.path_data(result, "pull")}}
    written = plots.save_all(
        result, springs, tmp_path / "figures", curves=curves, formats=files.FORMATS, pictures=BLANK
    )
    of_pull = [file for file in written if not file.name.startswith("turn")]
    assert [file.name for file in of_pull] == [f"{stem}.{form}" for stem in STEMS for form in ("png", "svg")]
    assert {file.name for file in (tmp_path / "figures").iterdir()} == {file.name for file in written}
    assert layout.pictures_in(tmp_path) == sorted(written)
    kinds = [layout.picture_kind(stem, "pull" if stem.startswith("pull") else "") for stem in STEMS]
    others = {
        "pressure",
        "section_pressure",
        "vertical",
        "ovalisation",
        "ground",
        "loops",
        "caisson",
    }  # drained, lateral, one way
    assert {kind[0] for kind in kinds if kind} == set(PICTURES.names()) - others


def test_a_report_has_the_pictures_that_were_drawn_for_it_and_no_fewer(
    trees: tuple[xr.DataTree, xr.DataTree], tmp_path: Path
) -> None:
    """Drawn for the report: every file is in the page, and the page is the one that all pictures make."""
    result, springs = trees
    curves = {"pull": {"full": plots.path_data(result, "pull")}}
    paths = {name: result[f"paths/{name}"].attrs for name in ("pull", "turn")}
    pages = {}
    for which in ("report", "all"):
        written = plots.save_all(result, springs, tmp_path / which, curves, which=which, pictures=BLANK)
        parts_of = pictures_by_part(written, paths)
        pages[which] = {part: [each.caption for each in shown] for part, shown in parts_of.items()}
    assert pages["report"] == pages["all"]
    drawn = [file.stem for file in (tmp_path / "report").iterdir()]
    assert len(drawn) == sum(map(len, pages["report"].values())) < len(list((tmp_path / "all").iterdir()))
    assert {"overview", "pull_macro_against_full", "pull_stress_outside_last"} <= set(drawn)
    assert plots.save_all(result, springs, tmp_path / "none", curves, which="none", pictures=BLANK) == []


@pytest.mark.parametrize(
    ("left_out", "gone"),
    [
        (["normal_effective_stress", "shear_lateral", "shear_vertical", "pore_pressure", "gap"], ("stress", "gap")),
        (["section_ux", "section_uz"], ("section",)),
    ],
)
def test_figures_of_what_was_not_kept_are_left_out(
    trees: tuple[xr.DataTree, xr.DataTree], left_out: list[str], gone: tuple[str, ...]
) -> None:
    result = trees[0].copy()
    result["paths/pull"].dataset = result["paths/pull"].to_dataset(inherit=False).drop_vars(left_out)
    names = [name for name, _ in files.figures(result, None, {}, pictures=BLANK) if not name.startswith("turn")]
    wanted = [stem for stem in STEMS if not any(kind in stem for kind in (*gone, "macro"))]
    assert names == wanted


@pytest.mark.slow
def test_save_all_writes_readable_pictures_whole(trees: tuple[xr.DataTree, xr.DataTree], tmp_path: Path) -> None:
    result, springs = trees
    curves = {"pull": {"full": plots.path_data(result, "pull")}}
    written = plots.save_all(result, springs, tmp_path / "figures", curves=curves, formats=files.FORMATS)
    assert {f"{stem}.png" for stem in STEMS} <= {file.name for file in written}
    assert {file for file in (tmp_path / "figures").iterdir()} == set(written)  # nothing half-written is left
    assert all(f.read_bytes().startswith(b"\x89PNG") for f in written if f.suffix == ".png")
    assert all(b"</svg>" in f.read_bytes() and f.stat().st_size <= 400_000 for f in written if f.suffix == ".svg")


def test_the_edge_ring_is_dotted_and_does_not_set_the_scale(pull: xr.Dataset) -> None:
    path = pull.copy(deep=True)
    path["p_component"][-1] *= 50.0
    axes = plots.py_curves(path).axes[0]
    dotted = [line for line in axes.get_lines() if line.get_linestyle() == ":"]
    assert [str(line.get_label()) for line in dotted] == [f"{float(path['depth'][-1]):.2f} m"]
    inner = path["p_component"].sum(("side", "component")).transpose("depth", "step").values[:-1] * 1e-3
    top = axes.get_ylim()[1]
    assert inner.max() < top < 1.3 * inner.max() < np.nanmax(dotted[0].get_ydata())


def test_profiles_stand_at_shares_of_the_largest_load(pull: xr.Dataset) -> None:
    figure = plots.profiles(pull, levels=(0.5, 1.0))
    lines = [line for line in figure.axes[0].get_lines() if str(line.get_label()).endswith("of the largest load")]
    assert [str(line.get_label())[:5] for line in lines] == ["50 % ", "100 %"]
    p = pull["p_component"].sum(("side", "component")).transpose("depth", "step").values * 1e-3
    assert np.allclose(lines[1].get_xdata(), p[:, -1])
    half = int(np.abs(pull["H"].values - 0.5 * pull["H"].values.max()).argmin())
    assert np.allclose(lines[0].get_xdata(), p[:, half])


def test_the_load_arrow_is_at_the_height_of_the_load(pull: xr.Dataset, plane: xr.Dataset) -> None:
    near = plots.section_displacement(plane, pull.assign_attrs(arm_m=0.5)).axes[0]
    far = plots.section_displacement(plane, pull.assign_attrs(arm_m=40.0)).axes[0]
    texts = [next(text for text in axes.texts if "above mudline" in text.get_text()) for axes in (near, far)]
    assert texts[0].xy[1] == pytest.approx(-0.5) and texts[0].get_text() == "H at 0.5 m above mudline"
    assert texts[1].xy[1] > min(far.get_ylim()) and texts[1].get_text().endswith("(beyond the frame)")


def simple_figure() -> Figure:
    """Lines, markers, text and a clipped patch: what a drawing may write with a random id."""
    figure = new_figure(3, 2)
    axes = figure.subplots()
    axes.plot([0, 1, 2], [0, 2, 1], marker="o")
    axes.fill_between([0, 1, 2], [0, 1, 1])
    axes.set_title("title")
    return figure


def test_a_picture_is_whole_and_a_large_drawing_is_kept_as_png_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    png, svg = plots.save(simple_figure(), tmp_path / "small", files.FORMATS)
    assert png.read_bytes().startswith(b"\x89PNG") and b"</svg>" in svg.read_bytes()
    monkeypatch.setattr(files, "LARGEST_SVG", 100)
    for formats in (("png", "svg"), ("svg",)):
        assert plots.save(simple_figure(), tmp_path / "small", formats) == [png]
        assert list(tmp_path.iterdir()) == [png]


def test_files_of_other_formats_go(tmp_path: Path) -> None:
    for formats in (("png", "svg"), ("svg",), ("png",), ()):
        written = files.redraw(simple_figure, tmp_path / "small", formats)
        assert [file.suffix for file in written] == [f".{each}" for each in formats]
        assert sorted(tmp_path.iterdir()) == sorted(written)


def test_a_picture_is_as_wide_as_the_text_of_the_report(tmp_path: Path) -> None:
    figure = simple_figure()
    figure.set_size_inches(9.6, 2.0)
    (png,) = plots.save(figure, tmp_path / "wide")
    assert struct.unpack(">I", png.read_bytes()[16:20]) == (960,)


def test_a_failed_write_keeps_the_old_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    old = tmp_path / "load.png"
    old.write_bytes(b"old")
    figure = simple_figure()

    def fail(*args: object, **kwargs: object) -> None:
        Path(str(args[0])).write_bytes(b"half")
        raise OSError("disk full")

    monkeypatch.setattr(figure, "savefig", fail)
    with pytest.raises(OSError, match="disk full"):
        plots.save(figure, tmp_path / "load")
    assert old.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [old]


def test_svg_is_the_same_twice(tmp_path: Path) -> None:
    first, second = (plots.save(simple_figure(), tmp_path / name, ("svg",))[0].read_text() for name in ("a", "b"))
    assert first == second


def test_the_users_settings_do_not_leak_in(pull: xr.Dataset) -> None:
    with rc_context({"lines.linewidth": 9.0, "font.size": 30.0}):
        figure = plots.py_curves(pull)
    assert figure.axes[0].get_lines()[0].get_linewidth() == 1.7
    assert figure.axes[0].xaxis.label.get_fontsize() == 10.0


@pytest.mark.slow
def test_no_pyplot(tmp_path: Path) -> None:
    code = "import sys, pysprings.results.plots; sys.exit('matplotlib.pyplot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_colours_of_the_surfaces_differ(loads: Figure) -> None:
    named = [line for line in loads.axes[0].get_lines() if not str(line.get_label()).startswith("_")]
    assert len({to_hex(line.get_color()) for line in named}) == 5


# --- water ---


def with_water() -> tuple[xr.Dataset, xr.Dataset]:
    """A path with suction inside the skirt, and its section."""
    result = synthetic.make_result()
    path, plane = plots.path_data(result, "pull"), plots.section_data(result)
    assert plane is not None
    azimuth = xr.DataArray(np.cos(path["azimuth"].values), dims="azimuth")
    inside = xr.where(path["side"] == "inside", -8e3, 1e3)
    path["pore_pressure"] = (inside * (1.0 + 0.2 * azimuth) * xr.ones_like(path["pore_pressure"])).transpose(
        *path["pore_pressure"].dims
    )
    steps, nodes = path.sizes["step"], plane.sizes["section_node"]
    path["section_pore_pressure"] = (("step", "section_node"), np.linspace(-8e3, 0.0, steps * nodes).reshape(steps, -1))
    path["pressure_min"] = ("step", np.full(steps, -8e3))
    return path, plane


def test_pressure_rose_draws_suction_inside_the_trace() -> None:
    figure = plots.pressure_rose(with_water()[0])
    assert figure.axes
    for axes in figure.axes:
        radius = {line.get_gid(): np.hypot(*line.get_data()) for line in axes.lines}
        assert np.all(radius["pressure_inside"] < 1.0) and np.all(radius["pressure_outside"] > 1.0)
        # -9.6 kPa at the front is the largest, on one scale with +1.2 kPa
        assert 1.0 - radius["pressure_inside"][0] == pytest.approx(8.0 * (radius["pressure_outside"][0] - 1.0))


def test_section_pressure_shows_kilopascals() -> None:
    path, plane = with_water()
    figure = plots.section_pressure(plane, path)
    assert any(axes.get_ylabel() == "kPa" for axes in figure.axes)


def state_pictures(path: xr.Dataset, plane: xr.Dataset) -> set[str]:
    """Names of the pictures of states that apply to a path."""
    view = View(xr.DataTree(), section=plane, path=path, step=0)
    return {picture.name for picture in PICTURES if picture.scope == "state" and picture.applies(view)}


def test_a_wet_run_has_pictures_of_its_water_and_a_drained_one_none() -> None:
    path, plane = with_water()
    assert {"pressure", "section_pressure"} <= state_pictures(path, plane)
    assert layout.picture_kind("pull_section_pressure_last", "pull") == ("section_pressure", "last")
    dry = path.drop_vars(["pressure_min", "section_pore_pressure"])
    assert "section" in state_pictures(dry, plane)
    assert not {"pressure", "section_pressure"} & state_pictures(dry, plane)


@pytest.mark.parametrize(("attrs", "top"), [({"lid_thickness_m": 0.3}, -0.3), ({}, -0.39)])
def test_outline_of_the_caisson(plane: xr.Dataset, attrs: dict[str, float], top: float) -> None:
    """Clockwise from the left end of the lid; a lid of unknown thickness is drawn as a tenth of the radius."""
    found = section.caisson_polygon(plane.assign_attrs(attrs))
    right = [(3.9, top), (3.9, 4.0), (3.8, 4.0), (3.8, 0.0)]
    np.testing.assert_allclose(found, [(-3.9, top), *right, *[(-x, z) for x, z in reversed(right)]], atol=1e-12)


def test_a_moment_that_is_rounding_has_no_secant() -> None:
    """A pull at mudline with M of rounding, positive with the rotation at every step, beside a rotation."""
    tree = synthetic.make_result((PULL, ROTATION))
    path = tree["paths/pull"]
    path["M"] = 1e-9 * path["H"] * np.sign(path["rotation"])
    left, right = (axes.get_lines() for axes in plots.secant_stiffness(tree).axes)
    assert {str(line.get_label()) for line in left} >= {"pull"}
    assert {str(line.get_label()) for line in right} & {"pull", "turn"} == {"turn"}


def test_a_moment_that_the_solver_leaves_of_zero_is_drawn_as_zero() -> None:
    """A pull at mudline whose M is 7 N m of 2.6 MN: the panel would show it in full height, as a result."""
    tree = synthetic.make_result((PULL,))
    path = tree["paths/pull"]
    path["M"] = 3e-6 * path["H"] * (-1.0) ** np.arange(path.sizes["step"])
    for figure, panel in ((plots.overview(tree), 1), (plots.tilt(tree), 1)):
        (line, *_) = (each for each in figure.axes[panel].get_lines() if str(each.get_label()).startswith("pull"))
        assert np.abs(line.get_ydata()).max() == 0.0 and np.abs(line.get_xdata()).max() > 0.0
        assert np.abs(figure.axes[0].get_lines()[0].get_ydata()).max() > 0.0


def test_the_names_of_many_paths_stand_below_and_a_motion_of_rounding_is_not_drawn() -> None:
    """Forty paths, one of them a rotation whose u is what the solver leaves of 0."""
    tree = synthetic.make_result((*(synthetic.Path(f"pull_{k}", steps=3) for k in range(40)), ROTATION))
    tree["paths/turn"]["u"] = 1e-18 * tree["paths/turn"]["rotation"]
    figure = plots.overview(tree)
    assert ["turn" in {str(line.get_label()) for line in axes.get_lines()} for axes in figure.axes] == [False, True]
    figure.draw_without_rendering()
    (names,) = figure.legends
    assert len(names.get_texts()) == 41
    assert not any(names.get_window_extent().overlaps(axes.get_tightbbox()) for axes in figure.axes)


def test_a_path_that_turns_back_has_the_secants_of_its_largest_motion_so_far() -> None:
    tree = synthetic.make_result((synthetic.Path("pull", steps=4),))
    path = tree["paths/pull"]
    path["u"][:], path["H"][:] = [0.0, 2e-3, -1e-3, -2.5e-3, 1e-3], [0.0, 4e5, -3e5, -5e5, 4e5]
    (line, *_) = plots.secant_stiffness(tree).axes[0].get_lines()
    assert line.get_ydata().tolist() == pytest.approx([200.0, 200.0])


@pytest.mark.parametrize("reach", [0.35, 0.6, 4.5, 9.0])
def test_the_names_of_limits_of_tilt_are_free_of_each_other_and_of_the_curves(reach: float) -> None:
    """Limits are close to each other, and to the axis of loads, where paths turn by several degrees."""
    tree = synthetic.make_result((PULL,))
    path = tree["paths/pull"]
    path["rotation"].values[:] *= np.radians(reach) / np.abs(path["rotation"].values).max()
    figure = plots.tilt(tree)
    figure.canvas.draw()
    for axes in figure.axes:
        boxes = [text.get_window_extent() for text in axes.texts]
        assert len(boxes) == 2
        assert not boxes[0].overlaps(boxes[1])
        (line,) = (line for line in axes.get_lines() if line.get_label().startswith("pull"))
        inside = axes.transData.transform(np.column_stack(line.get_data()))
        assert all(box.y0 > inside[:, 1].max() and box.x0 > axes.bbox.x0 and box.x1 < axes.bbox.x1 for box in boxes)
