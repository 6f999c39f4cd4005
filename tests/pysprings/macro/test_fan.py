# SPDX-License-Identifier: MIT
"""A fan of rays: exact for a linear response, odd, continuous, marked outside; load paths it was not made from."""

from itertools import pairwise

import numpy as np
import pytest
import xarray as xr

from pysprings.core import variables
from pysprings.core.errors import BeyondSprings, UserInputError
from pysprings.macro.answer import trace
from pysprings.macro.comparison import compare
from pysprings.macro.comparison_text import to_text
from pysprings.macro.fan import build_fan, last_slopes
from pysprings.macro.model import spring_sets
from pysprings.macro.predict import MacroModel, MacroWarning, curve, predict, way_to_load
from pysprings.springs.path import paths_of
from pysprings.springs.springs import Springs
from pysprings.springs.sums import balance, secant_slopes
from tests.support.fans import ANGLES, DEPTH, HEIGHT, LENGTH, RHO, fan_springs, linear, loads, potential, scattered
from tests.support.synthetic import make_springs


@pytest.mark.parametrize("angles", [ANGLES, (0.0, 90.0), (-60.0, 20.0, 70.0), (180.0, -155.0, 100.0)])
def test_exact_for_a_linear_response(angles):
    """At every state of the plane, however wide the sectors, rays with u < 0 included; tangent too."""
    springs = fan_springs(linear, angles)
    model = MacroModel.from_springs(springs, "fan")
    k = springs["stiffness_initial"].values[np.ix_([0, 2], [0, 2])]
    for state in scattered():
        force, tangent = model.reactions(*state)
        np.testing.assert_allclose(force, k @ state, rtol=1e-10, atol=1e-9 * np.abs(k @ state).max())
        np.testing.assert_allclose(tangent, k, rtol=1e-7)


@pytest.mark.parametrize("arm", [0.0, 0.5, 8.0, 40.0, -3.0])
def test_elastic_limit_is_the_full_model_at_all_load_heights(arm):
    """By construction, for a law that yields from the start: the slopes at the origin sum to the full stiffness."""
    springs = fan_springs(potential, rho=np.linspace(0.0, 8e-3, 9))  # first step far beyond the elastic limit
    k = springs["stiffness_initial"].values[np.ix_([0, 2], [0, 2])]
    answer = predict(springs, H=10.0, arm=arm, n=2)
    expected = np.linalg.solve(k, [10.0, arm * 10.0])
    np.testing.assert_allclose([answer["u"], answer["rotation"]], expected, rtol=1e-4)


def test_recorded_states_come_back_and_the_reactions_sum_to_the_load(bent):
    springs = fan_springs(potential)
    for name in Springs.of(springs).rays:
        path = paths_of(springs)[name].dataset
        states = np.stack([path["u"].values, path["rotation"].values], axis=1)
        found = np.array([bent.reactions(*state)[0] for state in states])
        np.testing.assert_allclose(found, np.stack([path["H"], path["M"]], axis=1), rtol=1e-9, atol=1e-3)
    states = scattered(40)
    rows = bent.table.rows(states)
    forces = np.array([bent.reactions(*state)[0] for state in states])
    np.testing.assert_allclose(rows.T @ bent.table.b, forces, rtol=1e-9, atol=1e-6)
    z, t = DEPTH, bent.table
    p, m = rows[t.name == "p"], rows[t.name == "m"]
    np.testing.assert_allclose(HEIGHT @ p, forces[:, 0], rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(HEIGHT @ m - (HEIGHT * z) @ p, forces[:, 1], rtol=1e-9, atol=1e-6)
    vertical = HEIGHT @ rows[t.name == "t"] + rows[t.name == "V_tip"] + rows[t.name == "V_lid"]
    np.testing.assert_allclose(vertical, rows[t.name == "V"], rtol=1e-9)


def test_odd_symmetry(bent):
    """A motion mirrored has mirrored loads; heave and V are the same, and w goes through the origin with no sign."""
    states = scattered(50)
    for state in states:
        (there, tangent), (back, tangent_back) = bent.reactions(*state), bent.reactions(*-state)
        np.testing.assert_allclose(back, -there, rtol=1e-12)
        np.testing.assert_allclose(tangent_back, tangent, rtol=1e-10, atol=1e-3)
    one, other = trace(bent, "state", states), trace(bent, "state", -states)
    np.testing.assert_allclose(other["w"], one["w"], rtol=1e-9)
    np.testing.assert_allclose(other["V"], one["V"], rtol=1e-9)
    assert (one["w"] < 0.0).all()


def test_continuous_across_rays_with_its_slope(bent):
    """Loads and tangent just before and behind every ray and its mirror image, and across the negative u axis."""
    rays = np.concatenate([bent.table.angle, bent.table.angle + np.pi, [np.pi]])
    for phi in rays:
        sides = []
        for shift in (-1e-9, 1e-9):
            u, v = 4e-3 * np.cos(phi + shift), 4e-3 * np.sin(phi + shift)
            sides.append(bent.reactions(u, v / LENGTH))
        np.testing.assert_allclose(sides[0][0], sides[1][0], rtol=1e-6, atol=1.0)
        np.testing.assert_allclose(sides[0][1], sides[1][1], rtol=1e-5, atol=1e-5 * np.abs(sides[0][1]).max())


@pytest.mark.parametrize("state", [(1e-3, -2e-4), (3e-3, -7e-4), (2e-3, 1e-4), (-3e-4, -1.5e-3), (0.0, 1e-3)])
def test_tangent_by_taylor_slope(bent, state):
    x, d = np.array(state), np.array([1.0e-4, -2.3e-5])
    force, tangent = bent.reactions(*x)
    steps = 0.1 / 2.0 ** np.arange(4)
    rest = [np.abs(bent.reactions(*(x + h * d))[0] - force - h * tangent @ d) / [1.0, LENGTH] for h in steps]
    assert np.polyfit(np.log(steps), np.log(np.linalg.norm(rest, axis=1)), 1)[0] == pytest.approx(2.0, abs=0.2)


@pytest.mark.slow
def test_error_falls_with_the_third_power_of_the_angle_between_rays():
    """At fixed rho, in the middle of sectors of 15, 7.5 and 3.75 degrees; plain secants give the second power."""
    errors = []
    for width in (15.0, 7.5, 3.75):
        model = MacroModel.from_springs(fan_springs(potential, np.arange(-90.0 + width, 90.1, width)), "fan")
        phi = np.radians(np.arange(-90.0, 90.0, width) + 0.5 * width)
        worst = 0.0
        for u, v in RHO[20] * np.stack([np.cos(phi), np.sin(phi)], axis=1):
            missing = (model.reactions(u, v / LENGTH)[0] - loads(potential, u, v / LENGTH)) / [1.0, LENGTH]
            worst = max(worst, float(np.linalg.norm(missing)))
        errors.append(worst)
    rates = [np.log2(a / b) for a, b in pairwise(errors)]
    assert min(rates) > 2.7


@pytest.mark.slow
def test_pulls_that_the_fan_was_not_made_from():
    """Coupled nonlinear soil: load and rotation within 1 % at every state of pulls at five load heights."""
    springs = fan_springs(potential, held_back=(0.0, 2.0, 8.0, 40.0, -2.0))
    assert max(balance(paths_of(springs)["pull_8"].dataset).values()) < 1e-9
    frame = compare(springs)
    held = frame[frame["role"] == "held-back"]
    fan = held[held["springs"] == "fan"]
    assert len(fan) == 5
    assert fan[["H_error_max_pct", "rotation_error_max_pct"]].abs().max(axis=None) < 1.0
    assert fan[["eta_small", "eta_large"]].min(axis=None) > 0.995
    assert not fan[["extrapolated_states", "off_path_states"]].to_numpy().any()
    assert fan["springs_from"].tolist() == ["8 paths"] * 5
    assert held[held["springs"] == "full"]["eta_large"].max() < 0.9  # springs of one path do not do it


def test_compare_keeps_the_roles_apart():
    springs = fan_springs(potential, held_back=(0.0,))
    text = to_text(compare(springs))
    titles = "calibration paths: springs are made", "held-back paths: springs are checked"
    places = [text.index(words) for words in (titles[0], "ray_0", "ray_7", titles[1], "pull_0")]
    assert places == sorted(places)
    one = compare(springs, "fan")
    assert set(one["springs"]) == {"fan"}
    assert one.loc[one["role"] == "calibration", "H_error_between_pct"].abs().max() < 2.0


def test_beyond_the_range_is_marked_warned_and_refused():
    springs = fan_springs(potential)
    with pytest.warns(MacroWarning, match=r"beyond the range of the fan of 8 paths: they reach 1\.\d+ times"):
        far = curve(springs, u_max=9e-3, n=4, extrapolate=True)
    assert far["extrapolated"].values.tolist() == [0, 0, 0, 1]
    with pytest.raises(BeyondSprings, match=r"springs: beyond the range.*path 'ray_\d' reached its aim") as caught:
        curve(springs, u_max=9e-3, n=4, strict=True)
    assert len(str(caught.value).splitlines()) == 1
    inside = curve(springs, u_max=5e-3, n=4, strict=True)
    assert not inside["extrapolated"].any()


def test_the_shorter_ray_of_a_sector_limits_the_range():
    springs = fan_springs(linear, (0.0, 45.0, 90.0))
    data = springs["paths/ray_0"].to_dataset(inherit=False)
    springs["paths/ray_0"] = xr.DataTree(data.isel(step=slice(0, 13)))
    model = MacroModel.from_springs(springs, "fan")
    between = 0.9 * RHO[-1] * np.array([[np.cos(0.4), np.sin(0.4) / LENGTH]])
    on_the_long_one = 0.9 * RHO[-1] * np.array([[1.0, 1.0 / LENGTH]]) / np.sqrt(2.0)
    assert trace(model, "state", between)["extrapolated"].values.tolist() == [1]
    assert trace(model, "state", on_the_long_one)["extrapolated"].values.tolist() == [0]


def test_a_wide_sector_is_marked_and_refused_but_not_its_rays():
    springs = fan_springs(linear, (0.0, 50.0, 90.0))  # 90 degrees between -90 and 0
    model = MacroModel.from_springs(springs, "fan")
    states = np.array([[1e-3, 0.0], [1e-3, -1e-4], [1e-3, 1e-4], [0.0, 1e-4], [-1e-3, 1e-4], [0.0, 0.0]])
    alone = [int(trace(model, "state", state[None])["off_path"][0]) for state in states]
    assert alone == [0, 1, 0, 0, 1, 0]
    force, moment = (float(x) for x in model.reactions(1e-3, -1e-4)[0])
    with pytest.warns(MacroWarning, match=r"between calibration paths 90 degrees apart.*limit 60"):
        predict(springs, H=force, M=moment)
    with pytest.raises(UserInputError, match=r"strict: .*90 degrees apart"):
        predict(springs, H=force, M=moment, strict=True)


def test_which_paths_are_rays():
    """Calibration paths of constant ratio; of two at the same angle the longer one; a pull is curved."""
    springs = fan_springs(potential, (0.0, -30.0, 179.5, 90.0), held_back=(8.0,))
    assert list(Springs.of(springs).rays) == ["ray_1", "ray_0", "ray_3"]
    springs["paths/pull_8"].attrs["role"] = "calibration"
    assert "pull_8" not in Springs.of(springs).rays
    springs["paths/ray_1"].attrs["role"] = "held-back"
    assert "ray_1" not in Springs.of(springs).rays


def test_an_origin_met_to_rounding_only_is_an_origin():
    """A dead load before the path leaves displacements of 1e-19 m in any direction."""
    springs = fan_springs(linear)
    for name in Springs.of(springs).rays:
        path = springs[f"paths/{name}"]
        u, rotation = path["u"].values.copy(), path["rotation"].values.copy()
        u[0], rotation[0] = -1e-19, 1e-20
        path["u"].values, path["rotation"].values = u, rotation
    assert len(Springs.of(springs).rays) == len(ANGLES)
    assert (build_fan(Springs.of(springs)).rho[:, 0] == 0.0).all()


def test_default_is_the_fan_where_there_is_one():
    springs = fan_springs(linear)
    assert spring_sets(springs) == ["py", "pisa", "full", "fan"]
    assert MacroModel.from_springs(springs).spring_set == "fan"
    assert MacroModel.from_springs(springs, path="ray_1").spring_set == "full"
    answer = way_to_load(springs, H=1e4)
    assert answer.attrs["springs"] == "fan"
    assert "ray_1 (20.0 deg)" in answer.attrs["rays"]
    assert list(variables.problems(answer, "prediction")) == []
    alone = make_springs()
    assert not Springs.of(alone).has_fan
    assert spring_sets(alone) == ["py", "full"]
    assert MacroModel.from_springs(alone).spring_set == "full"


def test_refusals():
    with pytest.raises(UserInputError, match=r"a fan needs at least 2 calibration paths.*there are 0"):
        predict(make_springs(), H=1e5, springs_kind="fan")
    springs = fan_springs(linear)
    with pytest.raises(UserInputError, match="path: a fan comes from all calibration paths"):
        predict(springs, H=1e5, springs_kind="fan", path="ray_1")
    with pytest.raises(UserInputError, match="no springs 'fan' here; there are: py, full"):
        compare(make_springs(), "fan")
    data = springs["paths/ray_1"].to_dataset(inherit=False)
    springs["paths/ray_1"].dataset = data.assign_coords(depth=data["depth"].values * 0.999)
    with pytest.raises(UserInputError, match="differ in their depths"):
        build_fan(Springs.of(springs))


def test_strict_refuses_springs_of_one_path_on_another():
    with pytest.raises(UserInputError, match=r"strict: .*off the path 'pull'"):
        curve(make_springs(), u_max=1e-3, arm=8.0, strict=True)
    assert curve(make_springs(), u_max=1e-3, arm=0.0, strict=True).sizes["step"] == 50


def test_slopes_from_secants():
    """Exact for a straight line and for the linear part of any sum; close for a hyperbola with graded steps."""
    rho = 2e-5 * (1.5 ** np.arange(16) - 1.0)
    line = 3.0 * rho[None, :]
    np.testing.assert_allclose(secant_slopes(rho, line, np.array([3.0])), 3.0)
    bend = (rho / (1.0 + rho / 1e-3))[None, :]
    found = secant_slopes(rho, bend, np.array([1.0]))
    np.testing.assert_allclose(found[0], 1.0 / (1.0 + rho / 1e-3) ** 2, atol=0.02)
    np.testing.assert_allclose(secant_slopes(rho, bend + line, np.array([4.0])), found + 3.0)
    np.testing.assert_allclose(secant_slopes(rho, bend + 7.0, np.array([1.0])), found, atol=1e-9)
    two = secant_slopes(np.array([0.0, 1.0]), np.array([[0.0, 2.0]]), np.array([3.0]))
    np.testing.assert_allclose(two, [[3.0, 2.0 - 0.5 / np.log(2.0)]])


@pytest.mark.parametrize("turned", [range(8), (1, 4, 6)], ids=["all", "some"])
def test_rays_calibrated_towards_minus_x_make_the_same_fan(turned):
    """A path and its mirror image hold the same springs: every row, w, V and t too, at states all over the plane."""
    mirrored = tuple(a + 180.0 * (k in turned) for k, a in enumerate(ANGLES))
    one, other = (fan_springs(potential, angles) for angles in (ANGLES, mirrored))
    assert [paths_of(other)[f"ray_{k}"].u[-1] < -1e-6 for k in range(7)] == [k in turned for k in range(7)]
    for name in Springs.of(other).rays:  # shear and tip that change along the way, evenly in the mirror image
        for tree in (one, other):
            path = tree[f"paths/{name}"].to_dataset(inherit=False)
            grown = 1e6 * np.hypot(path["u"].values, LENGTH * path["rotation"].values)
            path["t"] = path["t"] + xr.DataArray(grown, dims="step")
            path["V_tip"] = path["V_tip"] - 2.0 * LENGTH * grown  # both sides: V is constant
            tree[f"paths/{name}"].dataset = path
    tables = [build_fan(Springs.of(tree)) for tree in (one, other)]
    states = scattered(60)
    rows, found = (table.rows(states) for table in tables)
    assert tables[0].name.tolist() == tables[1].name.tolist()
    for name in np.unique(tables[0].name):
        mine = tables[0].name == name
        size = np.abs(rows[mine]).max()
        np.testing.assert_allclose(found[mine], rows[mine], rtol=1e-9, atol=1e-9 * size, err_msg=name)
    u, rotation = states.T
    traces = [
        trace(MacroModel.from_springs(tree, "fan"), "state", np.stack([u, rotation], axis=1)) for tree in (one, other)
    ]
    assert (traces[0]["w"] < 0.0).all()
    for name in ("H", "M", "V", "w", "p"):
        size = float(np.abs(traces[0][name]).max())
        np.testing.assert_allclose(traces[1][name], traces[0][name], rtol=1e-9, atol=1e-9 * size, err_msg=name)


def test_a_ray_that_stopped_in_tiny_steps_goes_on_with_its_secant():
    """The slope over a last step of 1e-5 of the range is noise; curves beside it are read beyond their end."""
    rho = np.append(np.linspace(0.0, 1.0, 51), 1.0 + 1e-5)
    r = np.stack([np.sqrt(rho), 2.0 * rho])
    r[0, -1] += 1e-3  # what a residual leaves: a slope of 100 over that step
    slopes = secant_slopes(rho, r, np.array([7.0, 2.0]))[:, -1]
    assert slopes[0] > 10.0
    tamed = last_slopes(rho, r, slopes)
    assert tamed[0] == pytest.approx(0.5, abs=0.06)
    assert tamed[1] == pytest.approx(2.0)  # a linear response stays one
    np.testing.assert_array_equal(last_slopes(rho[:-1], r[:, :-1], slopes), slopes)
