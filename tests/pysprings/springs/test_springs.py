# SPDX-License-Identifier: MIT
"""`Springs`: typed attributes of a tree, what is found once, and the way back to a tree."""

import dataclasses
import warnings
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from pysprings import Springs, compare, open_springs, predict
from pysprings.core.errors import UserInputError
from pysprings.springs.checks import save_springs
from pysprings.springs.path import keeps_direction
from pysprings.springs.sums import action, resultants
from tests.support import synthetic
from tests.support.vertical import REST, vertical_springs

PATHS = (
    synthetic.Path("held", arm=8.0, role="held-back"),
    synthetic.Path("slide", "translation", size=1e-2, steps=12),
    synthetic.Path("turn", "rotation", size=-2e-3, steps=12),
)


@pytest.fixture(scope="module")
def tree() -> xr.DataTree:
    return synthetic.make_springs(PATHS)


def test_attributes_are_typed(tree: xr.DataTree) -> None:
    springs = Springs.of(tree)
    assert (springs.length, springs.diameter, springs.rest_load) == (4.0, 7.8, 2e6)
    assert (springs.drainage, springs.of_full_model, springs.first_steps) == ("drained", True, False)
    assert springs.stiffness is not None and springs.stiffness.shape == (3, 3)
    assert list(springs.paths) == ["held", "slide", "turn"]
    assert [path.name for path in springs.lateral] == ["slide", "turn"] and springs.vertical == ()
    held = springs.paths["held"]
    assert (held.kind, held.role, held.arm, held.load) == ("pull", "held-back", 8.0, 2e6)
    assert not held.calibrates and held.rules.free_head and held.end.how == "reached"
    assert springs.rays == {"slide": 0.0, "turn": 0.5 * np.pi}
    assert springs.pure_paths == ("slide", "turn")


def test_the_usual_path_calibrates_and_an_unknown_one_is_refused(tree: xr.DataTree) -> None:
    springs = Springs.of(tree)
    assert springs.path().name == "slide"
    with pytest.raises(UserInputError, match="path: no path 'none'; the springs have: held, slide, turn"):
        springs.path("none")


def test_a_path_is_its_converged_steps() -> None:
    tree = synthetic.make_springs(PATHS)
    tree["paths/slide/converged"].values[-1] = 0
    path = Springs.of(tree).path("slide")
    assert path.n == path.u.size == path.p.shape[1] == 12 and path.recorded.sizes["step"] == 13
    recorded = tree["paths/slide"].to_dataset()
    np.testing.assert_allclose(path.p, recorded["p_component"].sum(("side", "component")).values[:, :-1], rtol=1e-14)


def test_a_vertical_load_that_changes_is_in_the_words_of_its_path(tree: xr.DataTree) -> None:
    assert Springs.of(tree).path("slide").under("drained") == "V 2000 kN"
    tree = tree.copy(deep=True)
    tree["paths/slide/V"].values[6:] = 3e6
    assert Springs.of(tree).path("slide").under("drained") == "V 2000 kN at first, 2000 to 3000 kN on the way"


def test_derived_springs_are_made_once() -> None:
    springs = Springs.of(vertical_springs(heavier=(6e6,)))
    assert springs.at(V=3e6) is springs.at(V=3e6)
    assert springs.rays is springs.rays
    assert Springs.of(springs) is springs
    between = springs.at(V=3e6)
    assert between.blended_loads == (REST, 6e6) and between.at(V=5e6) is between
    assert between.reference.endswith("and 6000 kN (no full model)")
    path = springs.paths["slide_6"]
    assert springs.answering(path) is springs.answering(path)


def test_nothing_of_them_can_be_set(tree: xr.DataTree) -> None:
    springs = Springs.of(tree)
    with pytest.raises(dataclasses.FrozenInstanceError):
        springs.paths = {}  # type: ignore[misc]
    with pytest.raises(dataclasses.FrozenInstanceError):
        springs.path().name = "other"  # type: ignore[misc]


def test_they_are_written_and_read_as_the_tree_is(tree: xr.DataTree, tmp_path: Path) -> None:
    files = [save_springs(each, tmp_path / name) for each, name in ((Springs.of(tree).tree, "a.nc"), (tree, "b.nc"))]
    xr.testing.assert_identical(*map(open_springs, files))


def test_public_functions_take_trees_and_springs(tree: xr.DataTree) -> None:
    springs = Springs.of(tree)
    assert compare(springs).equals(compare(tree))
    given = {"H": 2e5, "arm": 1.0, "springs_kind": "full", "path": "held"}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a path of another load height
        xr.testing.assert_identical(predict(springs, **given), predict(tree, **given))


def test_reactions_sum_to_the_loads(tree: xr.DataTree) -> None:
    paths = Springs.of(tree).paths
    assert paths
    for path in paths.values():
        sums = resultants(path.dataset)
        for load in ("H", "V", "M"):
            np.testing.assert_allclose(sums[load], path[load], atol=1e-9 * np.abs(sums[load]).max())


def test_actions_of_single_reactions_are_those_of_the_sums(tree: xr.DataTree) -> None:
    path = Springs.of(tree).path("held")
    total = np.zeros((2, path.n))
    for name, values in (("p", path.p), ("m", path.m)):
        for z, dz, row in zip(path.depth, path.heights, values, strict=True):
            total += np.outer(action(name, z, dz, path.length), row)
    for name, z in (("H_tip", path.length), ("M_tip", path.length), ("H_lid", 0.0), ("M_lid", 0.0)):
        total += np.outer(action(name, z, 0.0, path.length), path[name])
    for row, load in zip(total, ("H", "M"), strict=True):
        np.testing.assert_allclose(row, path[load], atol=1e-9 * np.abs(path[load]).max())


@pytest.mark.parametrize("given", [True, False])
def test_the_vertical_load_of_each_state(given: bool) -> None:
    """Solver tolerances do not change it; where w is held it is that of the start."""
    tree = synthetic.make_springs(PATHS)
    path = tree["paths/held"]
    changes = np.zeros(path.sizes["step"])
    changes[-6:] = [2e5, 5e5, 1e6, 1e6 + 50.0, 1e6 - 50.0, 1e6 + 20.0]
    changes[1:4] = [30.0, -30.0, 10.0]
    path["V"].values = REST + changes
    path.attrs["heave"] = "free" if given else "fixed"
    wanted = np.full(changes.size, REST)
    wanted[-6:] += np.array([2e5, 5e5, 1e6, 1e6, 1e6, 1e6]) if given else 0.0
    np.testing.assert_array_equal(Springs.of(tree).paths["held"].given_loads, wanted)


@pytest.mark.parametrize(
    ("u", "turn", "keeps"),
    [
        ([0.0, 1.0, 2.0], [0.0, 0.5, 1.0], True),
        ([-1e-12, 1.0, 2.0], [1e-12, 0.5, 1.0], True),  # the origin is met to rounding only
        ([0.0, 1.0, 2.0], [0.0, 0.501, 1.0], True),  # within a thousandth of the size
        ([0.0, 1.0, 2.0], [0.0, 0.6, 1.0], False),
        ([0.1, 1.0, 2.0], [-0.1, 0.5, 1.0], False),  # starts aside
    ],
)
def test_directions(u: list[float], turn: list[float], keeps: bool) -> None:
    assert keeps_direction(np.array(u), np.array(turn)) is keeps
