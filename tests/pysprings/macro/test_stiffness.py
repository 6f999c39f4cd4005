# SPDX-License-Identifier: MIT
"""Stiffness at a state: tangent and secant, reference point, axes, symmetric part, and out of the plane of the load."""

from dataclasses import replace

import numpy as np
import pytest

from pysprings.core.errors import UserInputError
from pysprings.macro.predict import MacroModel, curve, model_of, predict
from pysprings.macro.stiffness import at_states, secant, stiffness, stiffness_six
from tests.support.closed_forms import linear_springs
from tests.support.vertical import REST, vertical_springs

LOAD = {"H": 6e5, "arm": 2.0}


def test_the_secant_times_the_motion_is_the_load(bent: MacroModel) -> None:
    """And it lies between the initial stiffness and the tangent, as the springs soften."""
    state = predict(bent, **LOAD)
    matrix = stiffness(bent, **LOAD, secant=True).values
    motion = np.array([float(state["u"]), float(state["rotation"])])
    np.testing.assert_allclose(matrix[::2, ::2] @ motion, [6e5, 1.2e6], rtol=1e-9)
    tangent, rest = stiffness(bent, **LOAD).values, stiffness(bent).values
    assert tangent[0, 0] < matrix[0, 0] < rest[0, 0]
    assert tangent[2, 2] < matrix[2, 2] < rest[2, 2]


def test_of_linear_springs_secant_and_tangent_are_one() -> None:
    at = {"u": 1e-3, "rotation": 1.5e-4}
    tangent = stiffness(linear_springs(), **at).values
    np.testing.assert_allclose(stiffness(linear_springs(), **at, secant=True), tangent, rtol=1e-10)


def test_the_secant_of_w_is_the_change_of_v_over_that_of_w() -> None:
    tree = vertical_springs()
    V = REST + 2e6
    w = float(predict(tree, V=V)["w"])
    assert float(stiffness(tree, V=V, secant=True)[1, 1]) == pytest.approx(2e6 / w, rel=1e-9)


@pytest.mark.parametrize("V", [REST, np.nextafter(REST, np.inf)])
def test_the_secant_of_w_at_rest_is_the_tangent(V: float) -> None:
    """It is no difference of two equal loads over a rounding of w."""
    model = model_of(vertical_springs())
    assert model.vertical is not None
    rested = replace(model, vertical=replace(model.vertical, rest=(0.0, V)))
    assert secant(rested, 1e-3, 1e-4, V)[1, 1] == pytest.approx(secant(rested, 1e-3, 1e-4)[1, 1])


@pytest.mark.parametrize("depth", [4.0, -10.0])
def test_about_another_point_the_work_is_the_same(bent: MacroModel, depth: float) -> None:
    """u at the point is u - rotation z, the moment about it M + H z: loads of a unit motion there, one by one."""
    at_lid, at_point = stiffness(bent).values, stiffness(bent, reference_depth=depth).values
    for motion in np.eye(3):
        u, w, rotation = motion
        H, V, M = at_lid @ [u + rotation * depth, w, rotation]
        np.testing.assert_allclose(at_point @ motion, [H, V, M + H * depth], rtol=1e-12, atol=1e-3)
    assert f"{depth:g} m below mudline" in stiffness(bent, reference_depth=depth).attrs["long_name"]


def test_the_symmetric_part_is_that_of_the_matrix(bent: MacroModel) -> None:
    matrix = stiffness(bent, **LOAD).values
    np.testing.assert_allclose(stiffness(bent, **LOAD, symmetric=True), 0.5 * (matrix + matrix.T))


def test_out_of_the_plane_the_response_does_not_depend_on_the_direction(bent: MacroModel) -> None:
    """A small turn of the motion about the vertical turns the loads alike: K d(motion) = d(loads), exactly."""
    state = predict(bent, **LOAD)
    u, rotation = float(state["u"]), float(state["rotation"])
    six = stiffness_six(bent, **LOAD).values
    turned = six @ np.array([0.0, u, 0.0, -rotation, 0.0, 0.0])  # per radian of the turn
    np.testing.assert_allclose(turned, [0.0, 6e5, 0.0, -1.2e6, 0.0, 0.0], rtol=1e-9, atol=1e-3)
    np.testing.assert_allclose(six[np.ix_([0, 2, 4], [0, 2, 4])], stiffness(bent, **LOAD).values)
    assert six[0, 4] < 0.0 < six[1, 3]


@pytest.mark.filterwarnings("ignore::pysprings.macro.answer.MacroWarning")
@pytest.mark.parametrize("share", [1.2, 1.6, 1.99])
def test_between_springs_at_two_vertical_loads_w_is_coupled(share: float) -> None:
    """The matrix times a small change of the motion is that of the loads, V among them; also near the heavier one."""
    springs = vertical_springs(heavier=(2.0 * REST,))
    loads = np.array([1.5e5, share * REST, 3e5])
    K = stiffness(springs, **dict(zip("HVM", loads, strict=True))).values

    def motion(loads: np.ndarray) -> np.ndarray:
        state = predict(springs, **dict(zip("HVM", loads, strict=True)))
        return np.array([float(state[name]) for name in ("u", "w", "rotation")])

    for change in 1e-3 * loads * np.array([[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0], [1.0, 2.0, -1.0]]):
        moved = motion(loads + change) - motion(loads - change)
        error = np.abs(K @ moved - 2.0 * change) / np.abs(change).max()
        assert (error < [1e-3, 1e-2, 1e-3]).all()  # of V the difference is over 5 % of the way between both loads
    six = stiffness_six(springs, **dict(zip("HVM", loads, strict=True)))
    np.testing.assert_allclose(six.values[np.ix_([0, 2, 4], [0, 2, 4])], K)
    assert K[1, 0] and K[0, 1] and six.attrs["vertical"].startswith("w is coupled")
    states = curve(springs, u_max=1e-4, V=loads[1], n=3)  # the first is at rest
    tangents = at_states(model_of(springs, V=loads[1]), states, {}).values
    for found, u, rotation in zip(tangents, states["u"].values, states["rotation"].values, strict=True):
        alone = stiffness(springs, u=float(u), rotation=float(rotation), V=loads[1])
        np.testing.assert_allclose(found, alone, rtol=1e-9, atol=1.0)
    assert not tangents[0, 1, ::2].any() and "w is coupled" in alone.attrs["comment"]
    springs["stiffness_initial"].values[1, 0] = 1e-9  # rounding
    assert "uncoupled" in stiffness(springs).attrs["comment"]


@pytest.mark.filterwarnings("ignore::pysprings.macro.answer.MacroWarning")
@pytest.mark.parametrize(("heavier", "V"), [((), 1.05 * REST), ((2.0 * REST,), 2.1 * REST)])
def test_elsewhere_the_stiffness_of_w_is_that_under_v_alone(heavier: tuple[float, ...], V: float) -> None:
    springs = vertical_springs(heavier=heavier)
    six, alone = stiffness_six(springs, H=1.5e5, V=V), stiffness(springs, V=V)
    assert (
        not six.values[2, [0, 4]].any()
        and "uncoupled" in alone.attrs["comment"]
        and six.values[2, 2] == pytest.approx(float(alone[1, 1]))
    )
    assert six.attrs["vertical"].startswith("w is not coupled") and "vertical" not in stiffness_six(springs).attrs


def test_questions_without_an_answer_are_refused(bent: MacroModel) -> None:
    for asked in ({"H": 1e5, "reference_depth": "4 m"}, {"reference_depth": float("nan")}, {"H": "1 MN"}):
        with pytest.raises(UserInputError):
            stiffness(bent, **asked)
    with pytest.raises(UserInputError, match="beyond the range"):
        stiffness(bent, H=9e9)
