# SPDX-License-Identifier: MIT
"""The largest known load along a load: closed forms, limit loads, ranges, largest motion; load cases at once."""

import json
from pathlib import Path

import numpy as np
import pytest

from pysprings.cli.predictions import capacity
from pysprings.core.errors import BeyondSprings
from pysprings.core.text import with_prefix
from pysprings.core.words import NOT_KNOWN
from pysprings.macro.batch import predict_batch
from pysprings.macro.capacity import capacities
from pysprings.macro.predict import MacroModel, MacroWarning, curve, predict
from pysprings.results.tables import open_table
from tests.support.closed_forms import bilinear_springs
from tests.support.commands import command
from tests.support.fans import A, fan_springs, linear
from tests.support.vertical import REST, down_curve, fan_with_vertical, vertical_springs, weaken


@pytest.mark.parametrize("arm", [0.0, 3.0, 30.0, -4.0])
def test_the_load_at_the_end_of_the_range_is_the_largest_that_is_answered(bent: MacroModel, arm: float) -> None:
    """Just below there is an answer, just above there is none; the same in the opposite direction."""
    ends = [capacities(bent, np.array([[H, H * arm]])) for H in (1e5, -1e5)]
    np.testing.assert_allclose(ends[0].H, -ends[1].H, rtol=1e-9)
    largest = float(ends[0].H[0])
    answer = predict(bent, H=0.9999 * largest, arm=arm)
    assert float(answer["utilisation"]) == pytest.approx(0.9999, rel=1e-6)
    assert answer.attrs["capacity_kind"] in ("end of the range", "limit load of the springs")
    with pytest.raises(BeyondSprings, match="beyond the range"):
        predict(bent, H=1.0001 * largest, arm=arm)


def test_a_perfectly_plastic_soil_has_its_collapse_load(tmp_path) -> None:
    """p = 1e5 N/m on slices of 1 m, turning about depth z0: H = 1e5 (2 z0 - 4), M = 1e5 (8 - z0^2), for whole z0."""
    rows = [f"{z},{y},{p}" for z in (0.5, 1.5, 2.5, 3.5) for y, p in ((1e-3, 1e5), (2e-3, 1e5), (1e-2, 1e5))]
    (tmp_path / "py.csv").write_text("\n".join(["depth_m,y_m,p_N_per_m", *rows]) + "\n")
    model = MacroModel.from_springs(open_table(tmp_path / "py.csv", skirt_length=4.0))
    flat = capacities(model, np.array([[1e3, -2e3]]))
    assert (float(flat.H[0]), float(flat.M[0])) == pytest.approx((4e5, -8e5), rel=1e-6)
    turning = capacities(model, np.array([[2e3, -1e3]]))  # about 3 m: H = 2e5, M = -1e5
    assert (float(turning.H[0]), float(turning.M[0])) == pytest.approx((2e5, -1e5), rel=1e-3)
    assert flat.kind[0] == turning.kind[0] == "limit load of the springs"


def test_the_end_of_the_range_is_no_capacity() -> None:
    """A uniform p that hardens to 5e5 N/m over 4 m at 3 mm: 2 MN at half depth, and stiffness is left."""
    answer = predict(tree := bilinear_springs(), H=1e6, M=-2e6)
    assert answer.attrs["capacity_H_N"] == pytest.approx(2e6, rel=1e-5)
    assert answer.attrs["capacity_kind"] == "end of the range"
    assert answer.attrs["capacity_from"].endswith("more is not known")
    (path,) = tree["paths"].children.values()
    path.attrs |= {"end": "stopped", "end_reason": "the water would cavitate beyond (node 3); last residuals: 1"}
    stopped = predict(tree, H=1e6, M=-2e6).attrs["capacity_from"]
    assert stopped.endswith(f"more is not known; path '{path.name}' stopped: the water would cavitate beyond")
    assert float(answer["utilisation"]) == pytest.approx(0.5, rel=1e-5)


@pytest.mark.parametrize(("power", "kind"), [(0.3, "end of the range"), (0.02, "limit load of the springs")])
def test_a_load_that_still_grows_is_no_limit_load(power: float, kind: str) -> None:
    """R ~ motion^n: less than 2 % of the initial stiffness is left at the end of both; only one has stopped growing."""

    def law(z, y, rotation):
        stress = np.array(linear(z, y, rotation))
        q = (stress[0] * y + stress[1] * rotation) / A
        return stress * (1.0 + q / 5e-6**2) ** (0.5 * (power - 1.0))

    answer = capacities(MacroModel.from_springs(fan_springs(law)), np.array([[1e3, 2e3]]))
    assert answer.kind[0] == kind
    assert float(str(answer.source[0]).split(" % of the initial")[0].split("; ")[-1].split()[-1]) < 2.0


def test_the_largest_motion_ends_a_capacity() -> None:
    """The same springs on a caisson of 20 mm: a tenth of the diameter is 2 mm, where p is 4e5 N/m."""
    tree = bilinear_springs()
    tree.attrs["outer_diameter_m"] = 0.02
    answer = predict(tree, H=1e6, M=-2e6)
    assert answer.attrs["capacity_H_N"] == pytest.approx(1.6e6, rel=1e-4)
    assert answer.attrs["capacity_kind"] == "largest motion"


def test_the_largest_motion_is_that_of_the_scene() -> None:
    """A twentieth of 40 mm is 2 mm, too; the words name the share."""
    tree = bilinear_springs()
    tree.attrs |= {"outer_diameter_m": 0.04, "limit_displacement_over_diameter": 0.05, "limit_rotation_rad": 0.5}
    answer = predict(tree, H=1e6, M=-2e6)
    assert answer.attrs["capacity_H_N"] == pytest.approx(1.6e6, rel=1e-4)
    assert answer.attrs["capacity_from"].startswith("5 % of the diameter or 28.6479 deg")


def test_a_curve_has_one_capacity_and_its_share_by_state(bent: MacroModel) -> None:
    answer = curve(bent, u_max=2e-3, arm=2.0, n=6)
    np.testing.assert_allclose(answer["utilisation"] * answer.attrs["capacity_H_N"], answer["H"], rtol=1e-6, atol=1e-3)
    assert "capacity_H_N" not in predict(vertical_springs(), V=REST + 1e5).attrs


def test_load_cases_at_several_vertical_loads_are_predict_case_by_case() -> None:
    """Each at its V, in the order of the cases, on springs of two vertical loads."""
    tree = vertical_springs(heavier=(6e6,))
    H = np.array([1e5, 2e5, -1e5, 3e5, 2e5])
    V = np.array([6e6, 2e6, 3e6, 2e6, 6e6])
    cases = predict_batch(tree, H=H, M=2.0 * H, V=V)
    assert cases["answered"].values.tolist() == [1] * 5
    for k in range(H.size):
        with pytest.warns(UserWarning):  # two rays are 90 degrees apart
            one = predict(tree, H=H[k], M=2.0 * H[k], V=V[k])
        for name in ("u", "rotation", "w", "V", "utilisation", "stiffness"):
            np.testing.assert_allclose(cases[name][k], one[name], rtol=1e-6, atol=1e-12)


def test_springs_at_one_depth_have_no_known_capacity(tmp_path: Path) -> None:
    """One spring has a singular stiffness: no motion balances a load, and no number looks like a utilisation."""
    file = tmp_path / "t.csv"
    file.write_text("depth_m,y_m,p_N_per_m\n0.5,0.01,400e3\n", encoding="utf-8")
    done = command("predict", str(file), "--u", "1 mm", "--rotation", "-0.1 mrad", "--skirt-length", "4 m", "--json")
    assert done.code == 0, done.err
    assert json.loads(done.out)["attributes"]["capacity_kind"] == NOT_KNOWN
    assert "e+308" not in done.out


@pytest.mark.filterwarnings("ignore::pysprings.macro.predict.MacroWarning")
def test_beyond_the_largest_vertical_load_no_lateral_load_is_known() -> None:
    """The springs hold a pull of 0.79 MN: under -0.7 MN a lateral capacity is known, under -1 MN none."""
    tree, pull = vertical_springs(), REST + float(down_curve(np.array(-1e-2)))
    assert -1e6 < pull < -0.7e6
    held, lost = (predict(tree, H=1e5, arm=2.0, V=V, extrapolate=True) for V in (-0.7e6, -1e6))
    assert held.attrs["capacity_kind"] != NOT_KNOWN and float(held["utilisation"]) > 0.0
    assert lost.attrs["capacity_kind"] == NOT_KNOWN and np.isnan(lost.attrs["capacity_H_N"])
    assert np.isnan(float(lost["utilisation"]))
    assert capacity(lost) == "capacity in this direction: not known (V is beyond the largest known vertical load)"
    cases = predict_batch(tree, H=np.full(2, 1e5), arm=2.0, V=np.array([-0.7e6, -1e6]))
    for name in ("capacity_H", "capacity_M", "utilisation"):
        assert np.isfinite(cases[name].values).tolist() == [True, False]


def test_a_vertical_load_near_that_of_the_springs_takes_its_part_of_the_largest_load() -> None:
    """Within 10 % on the push and the pull side: by the chord to the end of the vertical path there, never more."""
    tree, load = weaken(fan_with_vertical(), "up", 1.0 / 6.0), np.array([[1e6, 2e6]])
    model = MacroModel.from_springs(tree)
    own = capacities(model, load, REST)
    assert "leaves at least" not in own.source[0] and model.vertical is not None
    ends = {branch.sign: branch.largest for branch in model.vertical.branches}
    for V in REST * np.array([0.96, 1.08]):
        end = ends[np.sign(V - REST)]
        found, left = capacities(model, load, V), (V - end) / (REST - end)
        assert 0.8 < left < 1.0 and float(found.H[0]) == pytest.approx(left * float(own.H[0]), rel=1e-9)
        answer = predict(model, H=2e5, M=4e5, V=float(V))
        assert float(answer["utilisation"]) == pytest.approx(2e5 / (left * float(own.H[0])), rel=1e-6)
        assert f"of which this V leaves at least {100.0 * left:.1f} %" in answer.attrs["capacity_from"]
        batch = predict_batch(model, H=np.array([2e5]), M=np.array([4e5]), V=np.array([V]))
        assert float(batch["utilisation"][0]) == pytest.approx(float(answer["utilisation"]), rel=1e-9)
    limited = tree.copy(deep=True)
    limited["paths/ray_0"].attrs |= {"end": "limit load", "end_H_N": 3e5, "end_M_Nm": 0.0}
    found = [capacities(MacroModel.from_springs(limited), np.array([[1e5, 0.0]]), V) for V in (REST, 0.96 * REST)]
    assert [each.kind[0] for each in found] == ["limit load of the full model"] * 2
    assert float(found[1].H[0]) == pytest.approx(3e5 * (0.96 * REST - ends[-1.0]) / (REST - ends[-1.0]), rel=1e-9)
    del limited["paths"]["up"]
    alone = capacities(MacroModel.from_springs(limited), np.array([[1e5, 0.0]]), 0.96 * REST)
    assert float(alone.H[0]) == pytest.approx(3e5, rel=1e-9)
    assert alone.source[0].endswith("of which this V may leave less: no path leads to it")
    far = capacities(model, load, 0.5 * REST)  # marked
    assert float(far.H[0]) == float(own.H[0]) or far.kind[0] == NOT_KNOWN
    with pytest.warns(MacroWarning, match="lateral springs unchanged"):
        answer = predict(model, H=2e5, M=4e5, V=1.5 * REST)
    words = f"; at V = {with_prefix(REST, 'N')} of the springs, not at this V"
    assert answer.attrs["capacity_from"].endswith(words)
    both = predict_batch(model, H=2e5, M=4e5, V=np.array([REST, 1.5 * REST]))["capacity_from"].values
    assert [text.endswith(words) for text in both] == [False, True]
