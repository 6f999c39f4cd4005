# SPDX-License-Identifier: MIT
"""Loads in six components on springs that answer in one vertical plane."""

import json
from pathlib import Path

import numpy as np
import pytest

from pysprings.core.errors import UserInputError
from pysprings.core.loads import in_plane
from pysprings.core.variables import TORSION
from pysprings.macro.batch import predict_batch
from pysprings.macro.stiffness import stiffness_six, turned
from pysprings.springs.checks import save_springs
from tests.support.commands import command
from tests.support.fans import fan_springs, potential
from tests.support.synthetic import TORSION as KNOWN

H, M = np.array([3e5, 2e5, 0.0, 0.0]), np.array([6e5, -2e5, 4e5, 0.0])
T = np.array([0.0, 1e6, 0.0, 2e6])


def components(angle, H=H, M=M):
    """Loads of a force H at height M/H towards an angle: z up, right-handed."""
    c, s = np.cos(angle), np.sin(angle)
    return {"H_x": c * H, "H_y": s * H, "M_x": -s * M, "M_y": c * M}


@pytest.mark.parametrize("angle", np.radians([0.0, 37.0, 90.0, 200.0]))
def test_a_load_in_any_plane_is_answered_there(angle):
    springs, c, s = fan_springs(potential), np.cos(angle), np.sin(angle)
    plane, turned = predict_batch(springs, H=H, M=M), predict_batch(springs, **components(angle), T=T)
    for name, along in (("u", ("u_x", c, "u_y", s)), ("rotation", ("rot_y", c, "rot_x", -s))):
        np.testing.assert_allclose(turned[name], plane[name], rtol=1e-9, atol=1e-15)
        for part, share in zip(along[::2], along[1::2], strict=True):
            np.testing.assert_allclose(turned[part], share * plane[name].values, rtol=1e-9, atol=1e-14)
    for name, given in components(angle).items():
        np.testing.assert_allclose(turned[name], given, atol=1e-6)
    np.testing.assert_allclose(turned["rot_z"], T / KNOWN)
    assert turned["linear_twist"].values.tolist() == [0, 1, 0, 1] and "least twist" in turned.attrs["remarks"][-1]
    for name, each in [*plane.data_vars.items(), *turned.data_vars.items()]:
        assert each.attrs.get("long_name") and each.attrs.get("units"), name
    assert "about x" in turned["M_x"].attrs["long_name"] and "size" in turned["u"].attrs["comment"]


def test_a_row_off_a_plane_has_no_answer_and_stops_no_other():
    springs = fan_springs(potential)
    given = components(0.5)
    given["M_x"] = given["M_x"] + np.array([0.0, 1e5, 0.0, 0.0])
    found, plane = predict_batch(springs, **given), predict_batch(springs, H=H, M=M)
    assert found["answered"].values.tolist() == [1, 0, 1, 1]
    np.testing.assert_allclose(found["u"][[0, 2, 3]], plane["u"][[0, 2, 3]], rtol=1e-9, atol=1e-15)
    blank = ("u", "w", "rotation", "u_x", "u_y", "rot_x", "rot_y", "utilisation", "capacity_H", "range_used")
    assert all(np.isnan(found[name][1]) for name in blank if name in found)
    assert f"moment of {100 * np.cos(0.5):.4g} kN m across" in found["why_not"].values[1]
    for name, value in given.items():
        np.testing.assert_allclose(found[name], value, atol=1e-6)


def test_torsion_that_is_not_known_has_no_twist():
    springs = fan_springs(potential)
    del springs.attrs[TORSION]
    found = predict_batch(springs, H=1e5, T=np.array([0.0, 1e5]))
    assert found["rot_z"].values[0] == 0.0 and np.isnan(found["rot_z"].values[1])
    assert found["answered"].values.tolist() == [1, 1] and "T is left out" in found.attrs["remarks"][-1]
    with pytest.raises(UserInputError, match="components, not both"):
        predict_batch(springs, H=1e5, H_x=1e5)


def test_the_command(tmp_path: Path):
    file = save_springs(fan_springs(potential), tmp_path / "springs.nc")
    loads = ("--Hx=-300 kN", "--Hy=400 kN", "--Mx=-800 kN m", "--My=-600 kN m")
    done = command("predict", file, *loads, "--T", "1 MN m", "--json")
    (state,) = json.loads(done.out)["states"]
    (plane,) = json.loads(command("predict", file, "--H", "500 kN", "--arm", "2 m", "--json").out)["states"]
    assert [state[name] for name in ("u_x", "u_y", "rot_x", "rot_y")] == pytest.approx(
        [-0.6 * plane["u"], 0.8 * plane["u"], -0.8 * plane["rotation"], -0.6 * plane["rotation"]]
    )
    assert (state["M_x"], state["rot_z"], state["linear_twist"]) == pytest.approx((-8e5, 1e6 / KNOWN, 1))
    for asked, text in (
        ((*loads[:2], "--Mx=1 MN m"), "--Mx: a moment of"),
        ((loads[0], "--H", "1 MN"), "--H: give either this or --Hx"),
        ((loads[0], "--T", "1 MN m", "--strict"), "--T: rot_z is T over the torsional stiffness at rest"),
    ):
        done = command("predict", file, *asked)
        assert done.code == 2 and text in done.err


def test_a_force_of_rounding_does_not_choose_the_plane():
    """H cos 90 deg of a load in y is 6e-11 N: the moment about x bends in the plane of y, with nothing across."""
    found = in_plane(np.array([[6e-11, 0.0]]), np.array([[0.0, 4e5]]))
    assert found.across[0] == 0.0 and found.M[0] == pytest.approx(4e5)


def test_a_matrix_turns_with_its_load():
    """K of a load in y: what holds along it stands at u_y."""
    springs = fan_springs(potential)
    along = stiffness_six(springs, H=2e5, arm=5.0)
    turned_ = turned(along, 0.5 * np.pi)
    np.testing.assert_allclose(turned_.values[1, 1], along.values[0, 0])
    np.testing.assert_allclose(turned_.values[1, 3], -along.values[0, 4])
    motion, c, s = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), np.cos(0.3), np.sin(0.3)
    own = [c * motion[0] + s * motion[1], c * motion[1] - s * motion[0], 3.0,
           c * motion[3] + s * motion[4], c * motion[4] - s * motion[3], 6.0]  # fmt: skip
    assert motion @ turned(along, 0.3).values @ motion == pytest.approx(np.array(own) @ along.values @ np.array(own))
