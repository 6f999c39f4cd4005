# SPDX-License-Identifier: MIT
"""Rigid body on springs against closed forms, an independent root finder and the model behind the springs."""

import subprocess
import sys

import numpy as np
import pandas as pd
import pint
import pytest
import xarray as xr
from scipy.interpolate import PchipInterpolator
from scipy.optimize import root

from pysprings.core import variables
from pysprings.core.errors import BeyondSprings, RunIncomplete, UserInputError
from pysprings.core.storage import write_tree
from pysprings.macro.answer import trace
from pysprings.macro.batch import predict_batch
from pysprings.macro.curve_table import pchip_slopes
from pysprings.macro.predict import (
    MacroModel,
    MacroWarning,
    PredictionNotConverged,
    curve,
    impose,
    model_of,
    predict,
    sequence,
)
from pysprings.macro.stiffness import stiffness, stiffness_six
from tests.support.closed_forms import (
    DEPTH,
    LENGTH,
    RINGS,
    bilinear_springs,
    linear_springs,
    linear_stiffness,
    springs_of,
)
from tests.support.synthetic import Path, make_springs


@pytest.mark.parametrize("spring_set", ["py", "full"])
@pytest.mark.parametrize("arm", [0.0, 8.0, -2.0])
def test_linear_springs_closed_form(spring_set, arm):
    force = 1e5
    expected = np.linalg.solve(linear_stiffness(spring_set), [force, force * arm])
    model = MacroModel.from_springs(linear_springs(), spring_set)
    states, loads, message = model.solve("load", np.array([[force, force * arm]]))
    assert message == ""
    np.testing.assert_allclose(states[0], expected, rtol=1e-10, atol=1e-18)
    np.testing.assert_allclose(loads[0], [force, force * arm], rtol=1e-9, atol=1e-3)
    np.testing.assert_allclose(model.reactions(*expected)[1], linear_stiffness(spring_set), rtol=1e-12)


def test_displacement_control_is_load_control_backwards():
    springs = linear_springs()
    pulled = curve(springs, u_max=1e-3, arm=0.5, n=5)
    k = linear_stiffness("full")
    ratio = -(k[1, 0] - 0.5 * k[0, 0]) / (k[1, 1] - 0.5 * k[0, 1])  # rotation/u from M - arm*H = 0
    np.testing.assert_allclose(pulled["rotation"], ratio * pulled["u"], rtol=1e-10)
    np.testing.assert_allclose(pulled["M"], 0.5 * pulled["H"], rtol=1e-9, atol=1e-3)
    loaded = predict(springs, H=float(pulled["H"][-1]), arm=0.5)
    assert float(loaded["u"]) == pytest.approx(1e-3, rel=1e-9)


def test_arm_sign():
    """A load above mudline tips the caisson over: M > 0, a larger rotation, softer than at mudline."""
    springs = make_springs()
    with pytest.warns(MacroWarning):
        low, high = (predict(springs, H=5e5, arm=arm) for arm in (0.0, 4.0))
    assert float(high["M"]) == pytest.approx(2e6)
    assert float(high["rotation"]) > float(low["rotation"]) > 0.0
    assert float(high["u"]) > float(low["u"]) > 0.0


def test_moment_is_the_same_as_its_arm():
    springs = make_springs()
    with pytest.warns(MacroWarning):
        by_arm, by_moment = predict(springs, H=5e5, arm=3.0), predict(springs, H=5e5, M=1.5e6)
    xr.testing.assert_allclose(by_arm.drop_attrs(), by_moment.drop_attrs(), rtol=1e-12)


def test_curves_hit_recorded_points_and_go_on_with_the_last_slope():
    model = MacroModel.from_springs(bilinear_springs())
    for u, p in ((1e-3, 3e5), (2e-3, 4e5), (3e-3, 5e5), (5e-3, 7e5), (-2e-3, -4e5)):
        assert model.reactions(u, 0.0)[0][0] == pytest.approx(p * LENGTH)
    answer = trace(model, "state", np.array([[3e-3, 0.0], [5e-3, 0.0]]))
    assert answer["extrapolated"].values.tolist() == [0, 1]
    assert answer["range_used"].values == pytest.approx([1.0, 5.0 / 3.0])


def test_a_softening_curve_is_held_flat():
    u = np.array([0.0, 1e-3, 2e-3, 3e-3])
    p = np.tile([0.0, 4e5, 5e5, 4.5e5], (RINGS, 1))
    springs = springs_of(p, np.zeros((RINGS, 1)), {}, u, 0.0 * u)
    model = MacroModel.from_springs(springs)
    assert model.reactions(9e-3, 0.0)[0][0] == pytest.approx(4.5e5 * LENGTH)


def test_interpolation_is_scipys_pchip():
    path = make_springs()["paths/pull"].to_dataset(inherit=False)
    model = MacroModel.from_springs(make_springs())
    p = path["p"].values
    row = 3
    y = path["y"].values[row]
    scipy_curve = PchipInterpolator(y, p[row] - p[row, 0])
    at = np.linspace(0.0, y[-1], 57)
    depth = float(path["depth"][row])
    states = np.stack([at, np.zeros_like(at)], 1) if depth == 0 else np.stack([0 * at, -at / depth], 1)
    answer = trace(model, "state", states)
    np.testing.assert_allclose(answer["p"].values[row], scipy_curve(at), rtol=1e-10, atol=1e-6)


def test_a_curve_of_few_points_that_still_grows_goes_on_growing():
    """Points 1 and 10 mm, 200 and 400 kN/m: the last slope has their sign, so the springs end, and are no limit load.

    The curve has no curvature at its end; SciPy's is flat there.
    """
    q, r = np.array([0.0, 1e-3, 1e-2]), np.array([0.0, 200e3, 400e3])
    assert PchipInterpolator(q, r).derivative()(q[-1]) == pytest.approx(0.0, abs=1.0)
    inner, last = pchip_slopes(q, r)[1:]
    assert last == pytest.approx(0.5 * (3.0 * (r[2] - r[1]) / (q[2] - q[1]) - inner)) and 0.0 < last < inner
    assert pchip_slopes(q, -r) == pytest.approx(-pchip_slopes(q, r))
    u = q[:, None] * np.ones(RINGS)
    springs = springs_of(np.tile(r, (RINGS, 1)), np.zeros((RINGS, 1)), {}, u[:, 0], 0.0 * q)
    answer = predict(springs, H=0.5 * r[-1] * LENGTH, arm=-0.5 * LENGTH, springs_kind="py")
    assert answer.attrs["capacity_kind"] == "end of the range"


@pytest.mark.parametrize("arm", [0.0, 2.0, 8.0])
@pytest.mark.parametrize("spring_set", ["py", "full"])
def test_equilibrium_by_scipy_root(arm, spring_set):
    """The same springs summed in plain Python, the same equations solved by MINPACK."""
    path = make_springs()["paths/pull"].to_dataset(inherit=False)
    height = np.diff(path["depth_bounds"].values)[:, 0]
    depth = path["depth"].values

    def odd(x, y):
        knots, values = np.abs(x), np.where(x < 0, -y, y)
        inside = PchipInterpolator(knots, values - values[0])
        return lambda q: np.sign(q) * inside(abs(q))

    u, rotation = path["u"].values, path["rotation"].values
    p = path["p"].values
    m = path["m"].sum("side").transpose("depth", "step").values
    lateral = [odd(path["y"].values[k], p[k]) for k in range(depth.size)]
    moment = [odd(rotation, m[k]) for k in range(depth.size)]
    tip, lid = odd(u - LENGTH * rotation, path["H_tip"].values), odd(u, path["H_lid"].values)
    tip_moment, lid_moment = odd(rotation, path["M_tip"].values), odd(rotation, path["M_lid"].values)

    def loads(state):
        force = sum(f(state[0] - state[1] * z) * dz for f, z, dz in zip(lateral, depth, height, strict=True))
        turn = -sum(f(state[0] - state[1] * z) * z * dz for f, z, dz in zip(lateral, depth, height, strict=True))
        if spring_set == "full":
            t = tip(state[0] - LENGTH * state[1])
            force += t + lid(state[0])
            turn += sum(f(state[1]) * dz for f, dz in zip(moment, height, strict=True))
            turn += tip_moment(state[1]) - LENGTH * t + lid_moment(state[1])
        return np.array([force, turn])

    target = 5e4
    answer = trace(MacroModel.from_springs(make_springs(), spring_set), "load", np.array([[target, arm * target]]))
    start = np.array([answer["u"].values[0], answer["rotation"].values[0]]) * 0.9
    scale = np.array([1e-3, 1e-3])
    exact = root(lambda x: (loads(x * scale) - [target, arm * target]) / 1e6, start / scale, tol=1e-13)
    assert exact.success
    assert int(answer["extrapolated"][0]) == 0
    np.testing.assert_allclose([answer["u"].values[0], answer["rotation"].values[0]], exact.x * scale, rtol=1e-8)


@pytest.mark.parametrize("state", [(1e-3, 2e-4), (3.3e-3, 7e-4), (2e-3, -1e-4), (6e-3, 3e-3), (-1.1e-3, -3e-4)])
def test_tangent_by_taylor_slope(state):
    """Remainder of F(x + h d) - F(x) - h K d falls with h^2: slope 2 in the log."""
    model = MacroModel.from_springs(make_springs())
    x, d = np.array(state), np.array([1.0e-4, 2.3e-5])
    force, tangent = model.reactions(*x)
    steps = 0.1 / 2.0 ** np.arange(4)
    rest = [np.abs(model.reactions(*(x + h * d))[0] - force - h * tangent @ d) / [1.0, LENGTH] for h in steps]
    slope = np.polyfit(np.log(steps), np.log(np.linalg.norm(rest, axis=1)), 1)[0]
    assert slope == pytest.approx(2.0, abs=0.15)


OWN = [Path(arm=arm) for arm in (-3.0, 0.0, 1.0, 3.5, 3.9, 5.0, 8.0, 16.0, 200.0)]
OWN += [Path(arm=40.0, size=2e-2), Path(size=2e-2)]


@pytest.mark.parametrize("path", OWN, ids=lambda path: f"arm {path.arm} m to {path.size} m")
def test_own_path_with_the_full_set(path):
    """Every recorded state comes back, also where y near the tip turns back or changes sign."""
    springs = make_springs((path,))
    full = springs["paths/pull"]
    targets = np.stack([full["u"].values, full["rotation"].values], 1)
    answer = trace(MacroModel.from_springs(springs), "displacement", targets, path.arm)
    np.testing.assert_allclose(answer["H"], full["H"], rtol=1e-8, atol=1e-3)
    np.testing.assert_allclose(answer["rotation"], full["rotation"], rtol=1e-8, atol=1e-15)
    np.testing.assert_allclose(answer["w"], full["w"], atol=1e-12)
    assert not answer["extrapolated"].any()
    assert not answer["off_path"].any()


def test_a_lid_that_pulls_along_is_kept_where_nothing_else_can_carry_it():
    """On a translation there is no rotation to read a negative lid force from; left out, the load would be off."""
    springs = make_springs((Path("push", kind="translation"),))
    path = springs["paths/push"]
    lid = path["H_lid"].values
    path["H"].values = path["H"].values - 1.1 * lid
    path["H_lid"].values = -0.1 * lid
    end = springs["paths/push"].to_dataset(inherit=False).isel(step=-1)
    answer = trace(MacroModel.from_springs(springs), "state", np.array([[float(end["u"]), 0.0]]), 0.0)
    assert float(answer["H"][-1]) == pytest.approx(float(end["H"]), rel=1e-9)


def test_plain_py_springs_miss_most_of_the_load():
    springs = make_springs()
    full = springs["paths/pull"]
    with pytest.warns(MacroWarning):
        plain = curve(springs, u_max=5e-3, n=3, springs_kind="py", extrapolate=True)
    assert float(plain["H"][-1]) < 0.5 * float(full["H"][-1])


def test_unusable_depths_are_named():
    """At 8 m the tip moves slightly backwards: near it, p is read from u or the rotation instead of y."""
    springs = make_springs((Path(arm=8.0),))
    model = MacroModel.from_springs(springs)
    odd_ones = [j for j, own in enumerate(model.table.natural) if not own]
    assert odd_ones
    assert {model.table.carrier[j] for j in odd_ones} <= {"u", "rotation"}
    answer = trace(model, "displacement", np.array([[1e-3, 0.0]]), 8.0)
    depth = answer["depth"].values[answer["usable"].values == 0]
    assert set(depth) == {model.table.depth[j] for j in odd_ones if model.table.name[j] == "p"}
    assert (depth > 2.5).all()
    for k in range(model.table.count.size):  # no spring pulls along with what it reads
        assert (model.table.r[k, : model.table.count[k]] >= -0.02 * np.abs(model.table.r[k]).max()).all()


def test_a_curve_that_turns_back_keeps_its_monotonic_part_in_the_py_set():
    u = np.linspace(0.0, 4e-3, 5)
    rotation = np.array([0.0, 0.1, 0.2, 0.5, 0.9]) * 1e-3  # y(tip) = 0, 0.6, 1.2, 1.0, 0.4 mm
    p = 1e8 * (u - rotation * DEPTH[:, None])
    springs = springs_of(p, np.zeros((RINGS, 5)), {}, u, rotation)
    table = MacroModel.from_springs(springs, "py").table
    tip = table.depth.tolist().index(LENGTH)
    assert table.cut[tip]
    assert table.range[tip] == pytest.approx(1.2e-3)
    assert not table.cut[0]
    whole = MacroModel.from_springs(springs, "full").table
    assert not whole.cut.any()
    assert whole.carrier[tip] == "u"


@pytest.mark.parametrize("spring_set", ["full", "py"])
def test_springs_of_a_path_that_turns_back_end_where_it_turns(spring_set):
    """Every curve is kept to there: beyond it no answer is plain."""
    tree = make_springs((Path("push", "translation"), Path("back", "translation")))
    there = tree["paths/back"].to_dataset(inherit=False)
    back = there.isel(step=[*range(there.sizes["step"]), *range(there.sizes["step"] - 2, 0, -1)])
    tree["paths/back"].dataset = back.assign_coords(step=np.arange(back.sizes["step"])).assign_attrs(then_parts=1)
    end = float(there["u"][-1])
    model = MacroModel.from_springs(tree, spring_set, "back")
    answer = trace(model, "state", np.array([[0.5 * end, 0.0], [end, 0.0], [2.0 * end, 0.0]]))
    np.testing.assert_allclose(answer["range_used"], [0.5, 1.0, 2.0])
    assert answer["extrapolated"].values.tolist() == [0, 0, 1]


def test_springs_of_a_pull_that_turns_back_are_those_without_its_turn():
    """Where y goes the other way, reactions are read from u on both: the sums are the loads of the path up to there."""
    tree = make_springs((Path("pull"), Path("back")))
    there = tree["paths/pull"].to_dataset(inherit=False)
    there = there.assign(rotation=there["u"] / (0.8 * LENGTH))
    there = there.assign(y=(there["u"] - there["rotation"] * there["depth"]).transpose(*there["y"].dims))
    back = there.isel(step=[*range(n := there.sizes["step"]), *range(n - 2, n // 2, -1)])
    tree["paths/pull"].dataset = there
    tree["paths/back"].dataset = back.assign_coords(step=np.arange(back.sizes["step"])).assign_attrs(then_parts=1)
    pull, turned = (MacroModel.from_springs(tree, "full", name) for name in ("pull", "back"))
    assert "u" in [carrier for name, carrier in zip(pull.table.name, pull.table.carrier, strict=True) if name == "p"]
    states = np.stack([there["u"], there["rotation"]], axis=1)
    one, other = (trace(model, "state", states) for model in (pull, turned))
    for name in ("H", "M", "p", "range_used"):
        np.testing.assert_array_equal(one[name], other[name])
    np.testing.assert_allclose(one["range_used"][-1], 1.0)


def test_springs_of_a_pull_that_rests_are_those_without_its_rest():
    """While u rests the free rotation creeps on: it carries no curve in place of u and y."""
    tree = make_springs((Path("pull"), Path("rested")))
    there = tree["paths/pull"].to_dataset(inherit=False)
    n = there.sizes["step"]
    rested = there.isel(step=[*range(n), *[n - 1] * 3]).assign_coords(step=np.arange(n + 3))
    turn = there["rotation"].values[-1] * (1.0 + 1e-3 * np.arange(1, 4))
    rested["rotation"] = ("step", np.concatenate([there["rotation"].values, turn]))
    rested["y"] = (rested["u"] - rested["rotation"] * rested["depth"]).transpose(*there["y"].dims)
    tree["paths/rested"].dataset = rested.assign_attrs(then_parts=1)
    pull, other = (MacroModel.from_springs(tree, "full", name) for name in ("pull", "rested"))
    assert pull.table.carrier == other.table.carrier
    states = np.stack([there["u"], there["rotation"]], axis=1)
    for name in ("H", "M", "p", "range_used"):
        np.testing.assert_array_equal(trace(pull, "state", states)[name], trace(other, "state", states)[name])


@pytest.mark.parametrize("spring_set", ["full", "py"])
def test_where_springs_of_a_path_end_they_leave_it_and_keep_its_w(spring_set):
    """A caisson that slides, then turns at the same u: every curve ends at the corner, so does what goes with them."""
    tree = make_springs((Path("push", "translation"), Path("swipe", "translation")))
    slid = tree["paths/swipe"].to_dataset(inherit=False)
    n = slid.sizes["step"]
    there = slid.isel(step=[*range(n), *[n - 1] * n])
    turn, w = np.repeat([0.0, 1e-3], n) * np.linspace(0.0, 1.0, 2 * n), np.linspace(0.0, -1e-4, 2 * n)
    there = there.assign(rotation=("step", turn), w=("step", w)).assign_coords(step=np.arange(2 * n))
    y = (there["u"] - there["rotation"] * there["depth"]).transpose(*there["y"].dims)
    tree["paths/swipe"].dataset = there.assign(y=y).assign_attrs(kind="swipe")
    end = float(slid["u"][-1])
    model = MacroModel.from_springs(tree, spring_set, "swipe")
    answer = trace(model, "state", np.array([[0.5 * end, 0.0], [end, 0.0], [end, 1e-3]]))
    np.testing.assert_allclose(answer["w"][:2], np.interp([0.5 * end, end], slid["u"], w[:n]))
    assert answer["off_path"].values.tolist() == [0, 0, 1]


def test_springs_are_odd():
    springs = make_springs()
    right, left = curve(springs, u_max=3e-3, n=7), curve(springs, u_max=-3e-3, n=7)
    for name in ("H", "rotation", "p"):
        np.testing.assert_allclose(left[name], -right[name], rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(left["w"], right["w"])
    assert not left["off_path"].any()


def test_other_vertical_load_is_elastic_and_marked():
    springs = make_springs()
    same = curve(springs, u_max=2e-3, n=4, V=2.0e6)
    assert same.attrs["warnings"] == []
    with pytest.warns(MacroWarning, match=r"V = 2.7 MN is not that of path 'pull' \(2 MN\)"):
        more = curve(springs, u_max=2e-3, n=4, V=2.7e6)
    np.testing.assert_allclose(more["w"] - same["w"], 0.7e6 / 3.5e9)
    np.testing.assert_allclose(more["H"], same["H"])


def test_beyond_the_range_and_off_the_path_are_marked_with_numbers():
    springs = make_springs()
    with pytest.raises(BeyondSprings, match=r"beyond the range of path 'pull'.*limit 1.*path 'pull' reached its aim"):
        curve(springs, u_max=8e-3, n=3)
    with pytest.warns(MacroWarning, match=r"beyond the range of path 'pull'.*limit 1"):
        far = curve(springs, u_max=8e-3, n=3, extrapolate=True)
    assert far["extrapolated"].values.tolist() == [0, 0, 1]
    with pytest.warns(MacroWarning, match=r"off the path 'pull' \(load height 0 m\).*limit 10%"):
        other = curve(springs, u_max=1e-3, arm=8.0, n=3)
    assert other["off_path"].values.tolist() == [0, 1, 1]


def test_load_that_cannot_be_carried_names_what_was_reached():
    u = np.array([0.0, 1e-3, 2e-3, 3e-3])
    p = np.tile([0.0, 4e5, 5e5, 4.9e5], (RINGS, 1))
    springs = springs_of(p, np.zeros((RINGS, 1)), {}, u, 0.0 * u)
    expected = r"no equilibrium beyond H = (1\.9\d*|2) MN with M = .* on the way to H = 2\.\d+ MN.*last step: u = "
    with pytest.raises(PredictionNotConverged, match=expected) as caught:
        predict(springs, H=3e6, M=-6e6)  # the resultant of a uniform p: pure translation, up to 5e5 N/m * 4 m
    assert isinstance(caught.value, RunIncomplete)
    model = MacroModel.from_springs(springs)
    part = trace(model, "load", np.linspace(0, 1, 11)[:, None] * [3e6, -6e6])
    assert part.attrs["status"] == "partial"
    assert part.sizes["step"] == 7
    assert np.isfinite(part["u"]).all()


@pytest.mark.parametrize(
    ("arguments", "key"),
    [
        ({"H": 1e5, "arm": 1.0, "M": 1e5}, "arm"),
        ({"H": float("nan")}, "H"),
        ({"H": 1e5, "V": float("inf")}, "V"),
        ({"H": "1 MN"}, "H"),
        ({"H": [1e6]}, "H"),
        ({"H": True}, "H"),
        ({"H": 1 + 2j}, "H"),
        ({"H": 1e5, "arm": "2 m"}, "arm"),
        ({"V": [2e6]}, "V"),
        ({"H": 1e5, "springs_kind": "best"}, "springs_kind"),
        ({"H": 1e5, "path": "push"}, "path"),
    ],
)
def test_bad_arguments_are_refused(arguments, key):
    with pytest.raises(UserInputError) as caught:
        predict(make_springs(), **arguments)
    assert [problem.key for problem in caught.value.problems] == [key]


@pytest.mark.parametrize(
    ("ask", "key", "words"),
    [
        (lambda springs: predict(springs, H="1 MN"), "H", '"1 MN" is a text: give a number in SI units'),
        (lambda springs: predict(springs, H=True), "H", "a number is needed, not bool"),
        (lambda springs: predict(springs, M=[1e6, 2e6]), "M", "one number is needed, not an array"),
        (lambda springs: curve(springs, u_max="5 mm"), "u_max", "is a text"),
        (lambda springs: curve(springs, u_max=1e-3, n=2.5), "n", "at least 2 are needed"),
        (lambda springs: curve(springs, u_max=1e-3, n=1), "n", "at least 2 are needed"),
        (lambda springs: impose(springs, u=1e-3, arm="8 m"), "arm", "is a text"),
        (lambda springs: impose(springs, rotation=False), "rotation", "not bool"),
        (lambda springs: sequence(springs, [["1 MN", 0.0]]), "targets", "a number is needed"),
        (lambda springs: sequence(springs, [[1e5, 0.0]], V="2 MN"), "V", "is a text"),
        (
            lambda springs: sequence(springs, [[1e-4, 0.0]], control="displacements"),
            "control",
            "expected one of displacement,",
        ),
        (lambda springs: sequence(springs, [[1e5, 0.0]], arm=2.0), "arm", "give M"),
        (lambda springs: impose(springs, u=1e-3, rotation=1e-4, arm=2.0), "arm", "both loads are answers"),
        (lambda springs: predict_batch(springs, H=["1 MN"]), "H", "a number is needed, not list"),
        (lambda springs: predict_batch(springs, H=[True]), "H", "a number is needed"),
        (lambda springs: predict_batch(springs, H=[1e5, np.nan]), "H", "not a finite number"),
        (lambda springs: predict_batch(springs, H=[1e5, 2e5], arm=[1.0, 2.0, 3.0]), "H", "of one shape, or single"),
        (lambda springs: predict_batch(springs, H=[[1e5, 2e5]]), "H", "give a column (n,), not the shape (1, 2)"),
        (lambda springs: predict(springs, H=pint.UnitRegistry().Quantity(1, "MN")), "H", 'has the unit "meganewton"'),
        (lambda springs: predict(springs, H=xr.DataArray(300.0, attrs={"units": "kN"})), "H", 'has the unit "kN"'),
        (lambda springs: predict(springs, H=np.ma.masked), "H", "has masked values"),
        (lambda springs: predict_batch(springs, H=np.ma.array([1e5, 9e5], mask=[0, 1])), "H", "has masked values"),
        (
            lambda springs: predict_batch(springs, H=pd.Series([1e5, 2e5]), arm=pd.Series([2.0, 3.0], index=[1, 0])),
            "arm",
            "row labels differ from those of H",
        ),
        (
            lambda springs: predict_batch(
                springs, H=xr.DataArray([1e5, 2e5], dims="a"), arm=xr.DataArray([1.0, 2.0], dims="b")
            ),
            "arm",
            "dimensions or coordinates differ from those of H",
        ),
        (
            lambda springs: sequence(springs, pd.DataFrame({"M [N m]": [2e5], "H [N]": [1e5]})),
            "targets",
            "give the columns H, M, not M, H",
        ),
        (
            lambda springs: sequence(springs, pd.DataFrame({"M_Nm": [2e5], "H_N": [1e5]})),
            "targets",
            "give the columns H, M, not M, H",
        ),
        (lambda springs: sequence(springs, pd.DataFrame({"H_kN": [1e2], "M_kNm": [2e2]})), "targets", 'unit "kN"'),
        (lambda springs: predict_batch(springs, H=pd.Series([1e2], name="Fx [kN]")), "H", 'has the unit "kN"'),
        (lambda springs: predict_batch(springs, H=1e5, M=pd.Series([2e2], name="M_kNm")), "M", 'has the unit "kNm"'),
        (
            lambda springs: sequence(springs, pd.DataFrame({"u": [0.0], "rotation": [1e-4]}), control="rotation"),
            "targets",
            "give the columns rotation, not u, rotation",
        ),
        (lambda springs: stiffness(springs, H="1 MN"), "H", "is a text"),
        (lambda springs: model_of(springs, V=np.nan), "V", "not a finite number"),
        (lambda springs: predict("springs.nc", H=1e5), "springs", "a str holds none: open them first"),
        (lambda springs: stiffness(springs, H=1e5, u=1e-3), "u", "give a load or a motion"),
        (lambda springs: stiffness(springs, u="1 mm"), "u", "is a text"),
        (lambda springs: stiffness(springs, V="2 MN"), "V", "is a text"),
    ],
)
def test_what_is_no_number_is_refused_in_one_line(ask, key, words):
    with pytest.raises(UserInputError) as caught:
        ask(make_springs())
    (problem,) = caught.value.problems
    assert (problem.key, words in problem.message) == (key, True)


@pytest.mark.parametrize("ask", [stiffness, stiffness_six])
@pytest.mark.parametrize("load", [{"H_x": 1e5, "M_y": 2e5}, {"H": 1e5, "height": 2.0}])
def test_a_stiffness_under_words_that_it_does_not_take_is_not_that_at_rest(ask, load):
    with pytest.raises(TypeError, match=r"unexpected keyword argument '(H_x|height)'"):
        ask(make_springs(), **load)


def test_numbers_of_numpy_and_whole_numbers_are_numbers():
    springs = make_springs()
    expected = float(predict(springs, H=1e5)["u"])
    of_xarray = xr.DataArray(1e5, attrs={"units": "N"})
    for force in (100_000, np.float32(1e5), np.int64(100_000), np.array(1e5), of_xarray):
        assert float(predict(springs, H=force)["u"]) == expected
    for names in (["H [N]", "M [N m]"], ["H_N", "M_Nm"]):
        table = pd.DataFrame([[1e5, 0.0]], columns=names)
        assert float(sequence(springs, table)["u"][-1]) == pytest.approx(expected)
    answer = predict(springs, H=of_xarray)
    assert float(impose(springs, u=answer["u"])["H"]) == pytest.approx(1e5)


def test_tangent_stiffness_at_mudline():
    matrix = stiffness(linear_springs(), u=1e-3, rotation=1.5e-4)
    k = linear_stiffness("full")
    expected = [[k[0, 0], 0.0, k[0, 1]], [0.0, 3.5e9, 0.0], [k[1, 0], 0.0, k[1, 1]]]
    np.testing.assert_allclose(matrix, expected, rtol=1e-12)
    assert float(matrix.sel(dof="u", dof_conjugate="rotation")) < 0.0  # K_C < 0


def test_prediction_agrees_with_the_table_of_variables():
    assert list(variables.problems(curve(make_springs(), u_max=1e-3, n=3), "prediction")) == []


def test_the_skirt_of_an_elastic_caisson_has_no_displacement_in_an_answer():
    """It bends against the lid centre, whose motion the springs answer."""
    springs = make_springs()
    rigid = predict(springs, H=1e5)
    springs.attrs["caisson_behaviour"] = "elastic"
    elastic = predict(springs, H=1e5)
    assert np.isnan(elastic["y"]).all() and np.isfinite(rigid["y"]).all()
    np.testing.assert_array_equal(elastic["p"], rigid["p"])


def test_the_command_loads_neither_the_engine_nor_scipy(tmp_path):
    """A fan answers in the time of NumPy, pandas and xarray: SciPy takes 0.3 s, tables of estimates 5 % of a start."""
    write_tree(make_springs(), tmp_path / "springs.nc")
    code = f"""import sys
from pysprings.cli.app import main
sys.argv = ["pysprings", "predict", {str(tmp_path)!r}, "--H", "100 kN"]
try:
    main()
except SystemExit as end:
    assert not end.code
loaded = {{name for name in sys.modules if name.startswith(("fe_engine", "scipy", "pysprings.results.estimates"))}}
sys.exit(", ".join(sorted(loaded)) or 0)"""
    done = subprocess.run([sys.executable, "-c", code], check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
