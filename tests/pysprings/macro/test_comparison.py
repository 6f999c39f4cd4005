# SPDX-License-Identifier: MIT
"""Comparison with the full model: eta of known areas, errors by path and spring set, table and JSON."""

import json

import numpy as np
import pytest
import xarray as xr

from pysprings.macro.comparison import compare, curves, states
from pysprings.macro.comparison_text import to_dict, to_text
from pysprings.macro.measures import abscissa, errors, eta
from pysprings.macro.predict import MacroModel, MacroWarning, predict
from pysprings.springs.path import SpringPath, paths_of
from tests.support.synthetic import Path, make_springs

PATHS = (
    Path("pull"),
    Path("high", arm=8.0, role="held-back"),
    Path("push", kind="translation"),
    Path("turn", kind="rotation", size=1e-3),
)


@pytest.fixture(scope="module")
def springs():
    return make_springs(PATHS)


@pytest.fixture(scope="module")
def frame(springs):
    return compare(springs)


def row(frame, path, spring_set):
    (found,) = [r for _, r in frame.iterrows() if r["path"] == path and r["springs"] == spring_set]
    return found


def test_eta_of_known_areas():
    x = np.array([0.0, 1.0, 2.0])
    reference = np.array([0.0, 10.0, 10.0])  # area 15
    assert eta(x, reference, reference) == 1.0
    assert eta(x, reference, 0.9 * reference) == pytest.approx(0.9)
    assert eta(x, reference, np.array([0.0, 10.0, 8.0])) == pytest.approx(1 - 1 / 15)
    assert eta(x, reference, np.array([0.0, 10.0, 8.0]), end=1.0) == 1.0
    assert eta(x, reference, np.array([0.0, 8.0, 10.0]), end=0.5) == pytest.approx(0.8)
    assert eta(-x, -reference, -0.9 * reference, end=0.5) == pytest.approx(0.9)
    assert np.isnan(eta(x, 0.0 * x, x))


def test_what_the_iteration_leaves_of_a_moment_has_no_error(springs):
    """A probe of a capacity keeps M at 0 to the tolerance of the solver, beside which every M is a multiple."""
    data = paths_of(springs)["push"].dataset
    noise = 1e-5 * np.abs(data["H"].values) * np.sin(np.arange(data.sizes["step"]))
    path = SpringPath("push", data.assign(M=("step", noise)), 4.0)
    answer = xr.Dataset({"H": 1.1 * data["H"], "M": 0.0 * data["M"] + 1e3})
    found = errors(path, answer, path.u, ("H", "M"))
    assert found["H_error_max_pct"] == pytest.approx(10.0)
    assert np.isnan([found["M_error_max_pct"], found["M_error_end_pct"]]).all()
    assert np.isfinite(errors(SpringPath("push", data, 4.0), answer, path.u, ("M",))["M_error_max_pct"])


def test_a_force_that_is_none_has_no_eta():
    """Of a couple: eta was -14,326."""
    tree = make_springs((Path("pull"), Path("push", kind="translation", role="held-back")))
    path = tree["paths/push"].to_dataset(inherit=False)
    tree["paths/push"].dataset = path.assign(H=1e-6 * path["H"])
    found = row(compare(tree), "push", "full")
    assert np.isnan([found["eta_small"], found["eta_large"], found["H_error_max_pct"]]).all()
    assert np.isfinite(found["M_error_max_pct"])


def test_one_row_a_path_and_spring_set(frame):
    found = list(zip(frame["path"], frame["springs"], strict=True))
    assert found == [(path.name, spring_set) for path in PATHS for spring_set in ("py", "pisa", "full", "fan")]
    assert set(frame["status"]) == {"complete"}


@pytest.mark.parametrize("path", ["pull", "push", "turn"])
def test_own_path_full_set_within_two_percent(frame, path):
    own = row(frame, path, "full")
    errors = own[[name for name in frame.columns if "_error_" in name]].astype(float)
    assert np.nanmax(np.abs(errors)) < 2.0  # states between those of the springs included
    assert own["eta_large"] > 0.9999
    assert own["eta_small"] > 0.9999
    assert own["rotation_point_macro_m"] == pytest.approx(own["rotation_point_full_m"], rel=1e-6, nan_ok=True)


def test_errors_are_those_of_the_states(springs, frame):
    full, macro = paths_of(springs)["pull"].dataset, curves(springs, "pull")["py"]
    error = 100 * (macro["H"].values[1:] / full["H"].values[1:] - 1)
    counted = error[np.abs(full["u"].values[1:]) >= 0.01 * 5e-3]
    found = row(frame, "pull", "py")
    assert found["H_error_end_pct"] == pytest.approx(error[-1])
    assert found["H_error_max_pct"] == pytest.approx(counted[np.argmax(np.abs(counted))])
    assert found["H_error_end_pct"] < -50.0
    assert found["rotation_error_end_pct"] > 50.0
    area = np.trapezoid(full["H"].values, full["u"].values)
    apart = np.trapezoid(np.abs(full["H"].values - macro["H"].values), full["u"].values)
    assert found["eta_large"] == pytest.approx(1 - apart / area)
    assert found["small_at"] == pytest.approx(7.8e-4)


def test_held_back_path_is_answered_by_the_first_calibration_path(frame):
    held = row(frame, "high", "full")
    assert held["springs_from"] == "pull"
    assert held["role"] == "held-back"
    assert abs(held["rotation_error_max_pct"]) > 5.0
    assert held["off_path_states"] == 20
    assert np.isnan(held["H_error_between_pct"])


def test_imposed_motion_has_errors_of_load_and_moment(frame):
    turned = row(frame, "turn", "py")
    assert np.isnan(turned["rotation_error_max_pct"])
    assert turned["M_error_max_pct"] < -10.0  # p-y alone has no shear moment
    assert turned["small_at"] == pytest.approx(7.8e-4 / 4.0)


def test_small_first_steps_are_left_out():
    springs = make_springs((Path(steps=60),))
    first = springs["paths/pull/H"].values
    first[1] *= 1.5  # at 0.2 % of the end
    plain = row(compare(springs), "pull", "py")
    assert plain["H_error_max_pct"] > -70.0


def test_text_table_reads_and_names_its_terms(frame):
    text = to_text(frame)
    lines = text.splitlines()
    assert lines[0] == "calibration paths: springs are made from them"
    assert lines[1].split()[:4] == ["path", "arm", "[m]", "springs"]
    assert "held-back paths: springs are checked on them" in lines
    assert max(map(len, lines)) < 200
    assert "nan" not in text
    assert "-0.00" not in text
    for words in ("1% of the largest", "outer diameter / 10000", "lateral p-y alone"):
        assert words in text


def test_dict_is_strict_json(frame):
    document = json.loads(json.dumps(to_dict(frame), allow_nan=False))
    assert len(document["rows"]) == 16
    assert document["rows"][0]["M_error_max_pct"] is None
    assert document["scene_sha256"] == "0" * 64


def test_states_side_by_side(springs):
    table = states(springs)
    assert len(table) == 4 * 4 * 21
    full = table[(table["path"] == "push") & (table["springs"] == "full")]
    np.testing.assert_allclose(full["M_macro_Nm"], full["M_full_Nm"], rtol=1e-9, atol=1e-3)


def test_a_path_that_ends_early_is_a_row_with_its_reason():
    """It cannot stop the table: what was reached is compared, and the reason is written."""
    springs = make_springs((Path("pull"),))
    data = springs["paths/pull"].to_dataset(inherit=False).copy(deep=True)
    for name in ("p", "m", "H_tip", "M_tip", "H_lid", "M_lid"):
        data[name].values[..., 1:] *= -1.0  # springs that push instead of resisting
    springs["paths/pull"].dataset = data
    found = compare(springs)
    assert len(found) == 2
    ended = row(found, "pull", "py")
    assert "no equilibrium beyond" in ended["status"]
    assert "no equilibrium beyond" in to_text(found)


def test_a_translation_has_no_point_of_rotation_though_its_zero_is_rounded():
    springs = make_springs((Path("push", kind="translation"), Path("pull")))
    springs["paths/push/rotation"].values = springs["paths/push/rotation"].values + 1e-21
    frame = compare(springs)
    assert np.isnan(row(frame, "push", "full")["rotation_point_full_m"])
    assert row(frame, "pull", "full")["rotation_point_full_m"] > 0.0


def test_displacement_at_equal_load(springs, frame):
    """u of the macro-model under the recorded H and M, found again by `predict`; none where u is 0."""
    full, model = paths_of(springs)["high"].dataset, MacroModel.from_springs(springs, "fan")
    trace = curves(springs, "high")["fan"]
    with pytest.warns(MacroWarning):
        asked = predict(model, H=float(full["H"][-1]), M=float(full["M"][-1]), extrapolate=True)
    assert float(trace["u_at_load"][-1]) == pytest.approx(float(asked["u"]), rel=1e-6)
    error = 100.0 * (trace["u_at_load"].values[1:] / full["u"].values[1:] - 1.0)
    counted = error[np.abs(full["u"].values[1:]) >= 0.01 * 5e-3]
    found = row(frame, "high", "fan")
    assert found["u_error_end_pct"] == pytest.approx(error[-1])
    assert found["u_error_max_pct"] == pytest.approx(counted[np.argmax(np.abs(counted))])
    low = np.hypot(full["H"], full["M"] / paths_of(springs)["high"].length).values[1:]
    low = error[(np.abs(full["u"].values[1:]) >= 0.01 * 5e-3) & (low <= 0.5 * low.max())]
    assert found["u_error_half_pct"] == pytest.approx(low[np.argmax(np.abs(low))])
    assert abs(found["u_error_half_pct"]) < abs(found["u_error_max_pct"])
    assert found["states_at_load"] == found["states"]
    assert row(frame, "pull", "full")["u_error_max_pct"] == pytest.approx(0.0, abs=1e-5)
    assert row(frame, "pull", "py")["u_error_end_pct"] > 100.0
    assert np.isnan(row(frame, "turn", "full")["u_error_max_pct"])


def test_load_that_the_springs_cannot_carry_is_counted_not_invented():
    """p-y springs flat at the end: the states beyond their capacity have no displacement."""
    springs = make_springs((Path("push", kind="translation"),))
    path = springs["paths/push"]
    p = path["p"].values.copy()
    p[..., 5:] = p[..., 5:6] * 0.999
    path["p"].values = p
    (found,) = [r for _, r in compare(springs, "py").iterrows()]
    assert 0 < found["states_at_load"] < found["states"]
    assert np.isfinite(found["u_error_end_pct"])


def test_depth_of_the_rotation_point(springs, frame):
    full, trace = paths_of(springs)["high"].dataset, curves(springs, "high")["fan"]
    u = full["u"].values
    counted = u >= 0.01 * u[-1]
    depths = [-data["u"].values[counted] / data["rotation"].values[counted] for data in (full, trace)]
    found = row(frame, "high", "fan")
    assert found["rotation_point_error_max_m"] == pytest.approx(np.abs(depths[1] - depths[0]).max())
    assert row(frame, "pull", "full")["rotation_point_error_max_m"] == pytest.approx(0.0, abs=1e-6)
    assert row(frame, "high", "py")["rotation_point_error_max_m"] > 0.1
    assert np.isnan(row(frame, "push", "full")["rotation_point_error_max_m"])


def test_text_and_json_have_displacement_and_rotation_point(frame):
    assert "u max [%]" in to_text(frame)
    assert "z_rot max [m]" in to_text(frame)
    document = to_dict(frame)
    assert {"u_error", "rotation_point"} <= set(document["definitions"])
    (turn,) = [r for r in document["rows"] if (r["path"], r["springs"]) == ("turn", "full")]
    assert turn["u_error_max_pct"] is None


def of_kind(data: xr.Dataset, kind: str) -> SpringPath:
    return SpringPath("path", data.assign_attrs(kind=kind), 4.0)


def test_a_swipe_counts_by_the_way_it_has_come() -> None:
    u, rotation = np.array([0.0, 1e-3, 2e-3, 2e-3, 2e-3]), np.array([0.0, 0.0, 0.0, -1e-3, -2e-3])
    data = xr.Dataset({"u": ("step", u), "rotation": ("step", rotation)})
    np.testing.assert_allclose(abscissa(of_kind(data, "swipe")), [0.0, 1e-3, 2e-3, 6e-3, 10e-3])
    np.testing.assert_array_equal(abscissa(of_kind(data, "pull")), u)


def test_a_load_that_climbs_is_followed_by_its_states() -> None:
    climbing = of_kind(xr.Dataset(attrs={"arm_from_m": 0.0}), "load")
    assert not climbing.rules.free_head and climbing.rules.answers == ("H", "M")
    assert of_kind(xr.Dataset(), "load").rules.free_head


def test_errors_of_a_swipe_are_relative_to_its_largest_load() -> None:
    path = {"u": [1e-3, 1e-3, 1e-3], "rotation": [0.0, -1e-3, -2e-3]}
    loads = {"H": [2.0, 0.0, -1.0], "M": [4.0, 4.0, 4.0]}
    full = xr.Dataset({k: ("step", np.array(v)) for k, v in (path | loads).items()})
    answer = full.assign(H=full["H"] + 0.1, M=1.01 * full["M"])
    found = errors(of_kind(full, "swipe"), answer, np.array([1e-3, 2e-3, 3e-3]), ("H", "M"))
    assert found["H_error_max_pct"] == pytest.approx(5.0)
    assert found["M_error_end_pct"] == pytest.approx(1.0)


@pytest.mark.parametrize(("M", "error"), [([-0.01, 4.0, 8.0], 1.25), ([0.01, 4.0, 8.0], 1000.0)])
def test_errors_of_a_moment_that_changes_its_sign_are_relative_to_its_largest(M: list[float], error: float) -> None:
    u = np.array([1e-3, 2e-3, 3e-3])
    full = xr.Dataset({"u": ("step", u), "rotation": ("step", 0.5 * u), "M": ("step", np.array(M))})
    found = errors(of_kind(full, "translation"), full.assign(M=full["M"] + 0.1), u, ("M",))
    assert found["M_error_max_pct"] == pytest.approx(error)
    assert found["M_error_end_pct"] == pytest.approx(1.25)
