# SPDX-License-Identifier: MIT
"""Spring files: round trip, refusals with a clear line each, sums that balance."""

import numpy as np
import pytest

from pysprings.core.errors import UserInputError
from pysprings.core.storage import write_tree
from pysprings.springs.checks import open_springs, save_springs, validate_springs
from pysprings.springs.path import SpringPath, paths_of
from pysprings.springs.springs import Springs
from pysprings.springs.sums import balance, by_depth, slice_heights
from tests.support.synthetic import DEAD_LOAD, Path, make_result, make_springs

PATHS = (Path("held", arm=8.0, role="held-back"), Path("pull"), Path("push", kind="translation"))


def test_round_trip(tmp_path):
    tree = make_springs(PATHS)
    assert open_springs(save_springs(tree, tmp_path / "springs.nc")).identical(tree)
    assert open_springs(tmp_path).identical(tree)  # the folder of a run


def test_paths_by_role_and_default():
    tree = make_springs(PATHS)
    assert list(paths_of(tree)) == ["held", "pull", "push"]
    assert Springs.of(tree).path().dataset.attrs["path"] == "pull"
    with pytest.raises(UserInputError, match="no path 'x'; the springs have: held, pull, push"):
        Springs.of(tree).path("x")


def test_only_converged_steps_are_given():
    tree = make_springs()
    tree["paths/pull/converged"][-2:] = 0
    assert Springs.of(tree).path().dataset.sizes["step"] == 19


def test_sums_over_depth():
    path = Springs.of(make_springs()).path().dataset
    assert slice_heights(path).sum() == pytest.approx(4.0)
    lateral = slice_heights(path) @ by_depth(path, "p") + path["H_tip"].values + path["H_lid"].values
    np.testing.assert_allclose(lateral, path["H"].values, atol=1e-8 * np.abs(path["H"].values).max())


def test_balance_sees_a_missing_reaction():
    path = Springs.of(make_springs()).path().dataset
    assert max(balance(path).values()) < 1e-14
    assert balance(path.assign(H_lid=0.0 * path["H_lid"]))["H"] > 1e-3
    assert balance(path.assign(M_tip=0.0 * path["M_tip"]))["M"] > 1e-3
    assert balance(path.assign(V_tip=0.0 * path["V_tip"]))["V"] > 1e-3


def _attribute(name, value):
    def spoil(tree):
        tree.attrs[name] = value

    return spoil


def _values(name, change):
    def spoil(tree):
        data = tree[f"paths/pull/{name}"]
        data.values = change(data.values)

    return spoil


def _one_nan(values):
    values[3] = np.nan
    return values


def _kind(tree):
    tree["paths/pull"].attrs["kind"] = "push"


def _no_path(tree):
    del tree["paths"]["pull"]


def _nan_stiffness(tree):
    tree["stiffness_initial"].values[0, 0] = np.nan


@pytest.mark.parametrize(
    ("spoil", "key", "words"),
    [
        (_attribute("schema", "pysprings-springs-9"), "schema", "another version: 'pysprings-springs-9'"),
        (_attribute("skirt_length_m", "4 m"), "skirt_length_m", "not a number"),
        (_attribute("drainage", 1), "drainage", "missing attribute"),
        (_no_path, "paths", "no path in the file"),
        (_nan_stiffness, "stiffness_initial", "not finite"),
        (_kind, "paths/pull/kind", "must be one of pull, translation, rotation, swipe, load"),
        (_values("H", _one_nan), "paths/pull/H", "not finite at a converged step"),
        (_values("converged", lambda v: 0 * v), "paths/pull/converged", "at least one converged step"),
        (_values("y", lambda v: -v), "paths/pull/y", "is not u - rotation*depth"),
        (_values("depth_bounds", lambda v: 0.9 * v), "paths/pull/depth_bounds", "must cover 0 to 4 m"),
        (_values("depth_bounds", lambda v: v[:, ::-1]), "paths/pull/depth_bounds", "between its top and its bottom"),
    ],
)
def test_refusals(tmp_path, spoil, key, words):
    tree = make_springs()
    spoil(tree)
    file = write_tree(tree, tmp_path / "bad.nc")
    with pytest.raises(UserInputError) as caught:
        open_springs(file)
    assert any(problem.key == key and words in problem.message for problem in caught.value.problems)
    assert {problem.file for problem in caught.value.problems} == {str(file)}


def test_p_that_is_not_the_sum_of_its_parts_is_refused():
    tree = make_springs()
    tree["paths/pull/p_component"].values[2, 1, 0, 5] += 1.0
    with pytest.raises(UserInputError, match="paths/pull/p: is not the sum of p_component"):
        validate_springs(tree)


@pytest.mark.parametrize(
    ("name", "factor", "load"),
    [("p", 2.0, "H"), ("p", -1.0, "H"), ("H", 2.0, "H"), ("M_tip", 2.0, "M"), ("V", 1.0 + 1e-5, "V"), ("t", 0.0, "V")],
)
def test_reactions_that_do_not_sum_to_the_load_are_refused(tmp_path, name, factor, load):
    """With path, step and both figures; the last step is the worst of a growing load."""
    tree = make_springs(PATHS)
    for part in (name, "p_component") if name == "p" else (name,):
        tree[f"paths/pull/{part}"].values[..., -1] *= factor
    file = write_tree(tree, tmp_path / "bad.nc")
    with pytest.raises(UserInputError) as caught:
        open_springs(file)
    problems = {problem.key: problem for problem in caught.value.problems}
    assert set(problems) <= {f"paths/pull/{each}" for each in "HVM"}
    problem = problems[f"paths/pull/{load}"]
    assert problem.file == str(file)
    assert "step 20: the reactions sum to " in problem.message
    given = float(tree[f"paths/pull/{load}"][-1])
    assert f"the load is {given:.6g} N" in problem.message


def test_single_precision_and_steps_that_did_not_converge_are_accepted(tmp_path):
    tree = make_springs(PATHS)
    for name in ("p", "m", "t", "H", "M", "V", "H_tip", "H_lid", "M_tip", "M_lid", "V_tip", "V_lid"):
        values = tree[f"paths/pull/{name}"].values
        values[...] = values.astype(np.float32)
    tree["paths/pull/converged"][-1:] = 0
    tree["paths/pull/H"][-1:] = 9e9
    open_springs(write_tree(tree, tmp_path / "springs.nc"))


def test_the_vertical_load_of_a_path_is_that_of_its_first_state():
    data = Springs.of(make_springs(PATHS)).path().dataset
    data["V"] = data["V"] + 3e5 * data["u"]
    assert SpringPath("pull", data, 4.0).load == float(data["V"][0]) == DEAD_LOAD
    assert SpringPath("pull", data.drop_vars("V"), 4.0).load == 0.0  # a table need not have it


def test_wrong_depth_order_is_refused():
    tree = make_springs()
    path = tree["paths/pull"].to_dataset(inherit=False)
    tree["paths/pull"].dataset = path.assign_coords(depth=path["depth"].copy(data=path["depth"].values[::-1]))
    with pytest.raises(UserInputError, match="depth: must increase"):
        validate_springs(tree)


def test_a_result_is_not_a_spring_file(tmp_path):
    file = write_tree(make_result(), tmp_path / "full_model.nc")
    with pytest.raises(UserInputError, match="a full-model result, not a spring file"):
        open_springs(file)


def test_all_faults_come_at_once_and_nothing_is_written(tmp_path):
    tree = make_springs()
    tree["paths/pull/H"].attrs["units"] = "kN"
    del tree.attrs["drainage"]
    with pytest.raises(UserInputError) as caught:
        save_springs(tree, tmp_path / "springs.nc")
    assert {problem.key for problem in caught.value.problems} == {"drainage", "paths/pull/H"}
    assert list(tmp_path.iterdir()) == []


def test_many_numbers_in_an_attribute_are_no_text_on_several_lines() -> None:
    """As the errors of stored elements are: NumPy prints them over several lines."""
    springs = make_springs()
    springs.attrs["H_errors"] = np.linspace(0.0, 1.0, 100)
    validate_springs(springs)
