# SPDX-License-Identifier: MIT
"""w of springs with memory under a vertical load that changes: what the elements and the vertical springs each do."""

import warnings

import numpy as np
import pytest
import xarray as xr

from pysprings.core.errors import BeyondSprings
from pysprings.macro.model import MacroModel
from pysprings.macro.predict import MacroWarning, sequence
from pysprings.macro.vertical import build_vertical
from pysprings.memory.build import build_memory
from pysprings.memory.stepper import MemoryStepper
from pysprings.springs.springs import Springs
from tests.support import winkler
from tests.support.vertical import REST, K, vertical_path, vertical_springs, weaken

LOADS = np.array([[3e5, 0.0], [-1e5, 0.0], [3e5, 0.0], [0.0, 0.0]])


def tree() -> xr.DataTree:
    """Springs with memory whose elements settle, and vertical springs of a known curve."""
    found = winkler.with_invented_memory(settling=True)
    for name, end in (("down", 1e-2), ("up", -1e-2)):
        path = vertical_path(found["paths/ray_0"].to_dataset(inherit=False), end)
        found[f"paths/{name}"] = xr.DataTree(path)
    found["stiffness_initial"].values[1, 1] = K
    return found


def model() -> MacroModel:
    return MacroModel.from_springs(Springs.of(tree()), "memory")


def test_a_vertical_load_moves_w_on_the_curve_of_the_vertical_springs_and_changes_nothing_else() -> None:
    springs = model()
    change = np.array([0.0, 1e6, 2e6, 3e6])
    plain = sequence(springs, LOADS, extrapolate=True)
    with pytest.warns(MacroWarning, match="lateral springs unchanged"):
        moved = sequence(springs, LOADS, V=springs.rest_load + change, extrapolate=True)
    for name in ("H", "M", "u", "rotation"):
        np.testing.assert_array_equal(moved[name].values, plain[name].values)
    np.testing.assert_allclose((moved["w"] - plain["w"]).values, change / (K - change / 5e-3), atol=1e-7)
    np.testing.assert_array_equal(moved["off_load"].values, change > 0.0)
    assert np.ptp(plain["w"].values) > 1e-4


def test_a_vertical_load_that_goes_back_unloads_with_the_stiffness_at_rest() -> None:
    """Up to the largest V so far, and beyond it on the curve again; what both directions have taken adds up.

    By hand, from the curves of the support module: down w = V/(K - V/5e-3), up 1 MN at w = -1e6/(K - K/3).
    """
    springs = model()
    change = 1e6 * np.array([2.0, 1.0, 0.0, 2.0, 3.0, 0.0, -1.0, -0.5, 3.0, 4.0])
    answer = sequence(springs, np.zeros((10, 2)), V=springs.rest_load + change, extrapolate=True)

    def down(V: float) -> float:
        return V / (K - V / 5e-3)

    up = -1e6 / (K - K / 3.0)
    stays = [down(V) - V / K for V in (2e6, 2e6, 2e6, 2e6, 3e6, 3e6, 3e6, 3e6, 3e6, 4e6)]
    pulled = np.where(np.arange(10) >= 6, up + 1e6 / K, 0.0)
    np.testing.assert_allclose(answer["w"], change / K + stays + pulled, atol=2e-6)
    inside = [1, 2, 5, 7]
    np.testing.assert_allclose(answer["stiffness"].values[inside, 1, 1], springs.vertical.stiffness, rtol=1e-12)
    assert (answer["stiffness"].values[[0, 4, 9], 1, 1] < 0.9 * K).all()
    assert not answer["turned_back"].any()


def test_springs_without_memory_go_back_on_the_curve_of_the_vertical_springs() -> None:
    fan = MacroModel.from_springs(Springs.of(tree()), "fan")
    change = 1e6 * np.array([2.0, 0.0])
    with pytest.warns(MacroWarning):
        answer = sequence(fan, np.zeros((2, 2)), V=fan.rest_load + change, extrapolate=True)
    assert float(answer["w"][1]) == pytest.approx(0.0, abs=1e-9) and answer["turned_back"].values[1]


def test_a_vertical_load_that_the_vertical_springs_do_not_reach_is_refused() -> None:
    springs = model()
    with pytest.raises(BeyondSprings, match="is beyond the vertical springs"):
        sequence(springs, LOADS, V=springs.rest_load - 2.99e6)


def test_a_pull_alone_goes_up_the_curve_and_back_with_the_stiffness_at_rest() -> None:
    table = build_vertical(Springs.of(vertical_springs()))
    assert table is not None
    w, tangent, used, own = table.history(REST + np.array([-1e6, -5e5, -2e6, 0.0]))
    one, two = (-V / (K - K * V / 3e6) for V in (1e6, 2e6))
    np.testing.assert_allclose(w, [one, one + 5e5 / K, two, two + 2e6 / K], atol=2e-6)
    assert tangent[[1, 3]] == pytest.approx(table.stiffness) and tangent[0] < 0.8 * K
    assert used[0] == used[1] < used[2] == used[3] < 1.0 and own[3] == 0.0 < own[1] < own[0]


def test_after_a_vertical_load_that_nothing_carries_there_is_no_answer() -> None:
    """The end of a pull-out is flat: w stays undefined when V goes back."""
    table = build_vertical(Springs.of(vertical_springs(ends=(1e-2, -5e-2))))
    assert table is not None
    _, _, used, own = table.history(REST + np.array([-1e6, -2.99e6, 0.0]))
    assert np.isfinite(used[0]) and np.isnan(used[1:]).all() and np.isnan(own).tolist() == [False, True, False]


def test_steps_near_the_vertical_capacity_are_marked_as_in_a_sequence() -> None:
    near = weaken(tree(), "up", 1.0 / 6.0)  # ends 0.5 MN above rest
    for springs in (tree(), near):
        stepper, model = MemoryStepper(build_memory(Springs.of(springs))), MacroModel.from_springs(springs, "memory")
        marks = []
        for V in REST * np.array([1.0, 1.09, 1.12, 0.96, 0.93, 0.89]):
            stepper.advance(motion=(1e-3, 0.0), V=float(V))
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", MacroWarning)
                answer = sequence(model, np.array([[1e-3, 0.0]]), control="state", V=np.array([V]), extrapolate=True)
            assert stepper.marks.off_load is bool(answer["off_load"].values[-1])
            marks.append(int(stepper.marks.off_load))
        assert marks == ([0, 0, 1, 0, 1, 1] if springs is near else [0, 0, 1, 0, 0, 1])


def test_states_after_another_vertical_load_are_marked_too() -> None:
    """What V has done to the soil stays: H and M of the first V are in doubt from there on, and w beyond the curve."""
    springs = model()
    change = 1e6 * np.array([0.0, 1.0, 0.0, 0.0])
    with pytest.warns(MacroWarning, match=r"3 of 4 states are under another V than that of the elements \(.* MN\), or"):
        answer = sequence(springs, LOADS, V=springs.rest_load + change, extrapolate=True)
    np.testing.assert_array_equal(answer["off_load"], [0, 1, 1, 1])
    far = springs.rest_load + 1e6 * np.array([15.0, 0.0])
    with pytest.warns(MacroWarning, match="is beyond the vertical springs"):
        answer = sequence(springs, np.zeros((2, 2)), V=far, extrapolate=True)
    np.testing.assert_array_equal(answer["extrapolated"], [1, 1])
