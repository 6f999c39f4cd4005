# SPDX-License-Identifier: MIT
"""How paths ended is kept in the springs, and what lies beyond an end is refused by every question."""

import json
import warnings
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from pysprings import extract_springs
from pysprings.core import variables
from pysprings.core.errors import BeyondSprings, UserInputError
from pysprings.core.text import with_prefix
from pysprings.full_model import compute
from pysprings.macro.answer import trace
from pysprings.macro.batch import predict_batch
from pysprings.macro.predict import MacroModel, MacroWarning, curve, impose, predict, sequence, way_to_load
from pysprings.macro.stiffness import stiffness
from pysprings.springs.checks import open_springs, save_springs, validate_springs
from pysprings.springs.path import paths_of
from pysprings.springs.path_ends import PathEnd, end_of
from pysprings.springs.springs import Springs
from tests.support import tiny
from tests.support.commands import command
from tests.support.fans import fan_springs, potential
from tests.support.synthetic import make_springs
from tests.support.vertical import REST, vertical_springs

REASON = "limit load: 1.2 % of the initial stiffness is left"


def ended(tree: xr.DataTree, name: str, how: str, why: str = "") -> xr.DataTree:
    """The springs with a path that ended so; loads at the end are its last ones."""
    path = tree[f"paths/{name}"]
    path.attrs |= {"end": how, "end_reason": why, "status": "complete" if how == "reached" else "partial"}
    path.attrs |= {"end_H_N": float(path["H"][-1]), "end_M_Nm": float(path["M"][-1])}
    return tree


@pytest.fixture
def limited() -> xr.DataTree:
    """Springs of one pull at mudline that met a limit load at 5 mm."""
    return ended(make_springs(), "pull", "limit load", REASON)


def capacity(tree: xr.DataTree) -> float:
    return float(tree["paths/pull/H"][-1])


ASKED = {
    "load": lambda tree, H: predict(tree, H=1.001 * H),
    "the other way": lambda tree, H: predict(tree, H=-1.001 * H),
    "motion": lambda tree, H: impose(tree, u=5.1e-3),
    "curve": lambda tree, H: curve(tree, u_max=6e-3),
    "both motions": lambda tree, H: impose(tree, u=6e-3, rotation=9e-4),
    "sequence": lambda tree, H: sequence(tree, np.array([[0.5 * H, 0.0], [1.1 * H, 0.0], [0.5 * H, 0.0]])),
    "stiffness at a load": lambda tree, H: stiffness(tree, H=1.1 * H),
    "stiffness at a motion": lambda tree, H: stiffness(tree, u=6e-3, rotation=9e-4),
}


@pytest.mark.parametrize("ask", ASKED.values(), ids=ASKED.keys())
@pytest.mark.parametrize("how", ["limit load", "stopped"])
def test_every_question_beyond_an_end_is_refused_in_one_line(ask, how):
    why = REASON if how == "limit load" else "apex: 31 % of the soil there has no confining stress left"
    tree = ended(make_springs(), "pull", how, why)
    with pytest.raises(BeyondSprings) as caught:
        ask(tree, capacity(tree))
    (problem,) = caught.value.problems
    limit = how == "limit load"
    words = "met a limit load of the full model" if limit else "stopped"
    head = "the answer is beyond what the full model carried: " if limit else "beyond the range of path 'pull'"
    assert problem.message.startswith(head)
    assert f"path 'pull' {words} at H = {with_prefix(capacity(tree), 'N')}" in problem.message
    assert why in problem.message


def test_up_to_the_end_there_is_an_answer_and_beyond_a_reached_one_a_warning(limited):
    H = capacity(limited)
    answer = way_to_load(limited, H=0.999 * H, strict=True)
    assert (answer.attrs["path_end"], answer["beyond_end"].values.sum()) == ("limit load", 0)
    assert list(variables.problems(answer, "prediction")) == []
    assert answer.attrs["capacity_H_N"] == pytest.approx(H)
    assert answer.attrs["capacity_kind"] == "limit load of the full model"
    assert float(answer["utilisation"][-1]) == pytest.approx(0.999)
    with pytest.raises(BeyondSprings, match="beyond the range"):
        predict(make_springs(), H=1.1 * H)
    with pytest.warns(MacroWarning, match="beyond the range"):
        reached = predict(make_springs(), H=1.1 * H, extrapolate=True)
    assert reached.attrs["path_end"] == "reached"


def test_a_batch_marks_its_cases_and_gives_no_motion(limited):
    H = capacity(limited)
    batch = predict_batch(limited, H=np.array([0.5 * H, 1.5 * H, -1.5 * H]))
    assert batch["beyond_end"].values.tolist() == [0, 1, 1]
    assert batch["converged"].values.tolist() == [1, 0, 0]
    for name in ("u", "w", "rotation"):
        assert np.isfinite(batch[name].values).tolist() == [True, False, False]
    assert batch["utilisation"].values == pytest.approx([0.5, 1.5, 1.5])
    assert batch["why_not"].values.tolist() == ["", *["beyond a limit load of the full model"] * 2]
    everywhere = predict_batch(limited, H=np.array([0.5 * H]), V=500e6)
    assert everywhere["extrapolated"].values.tolist() == [1]
    assert everywhere["answered"].values.tolist() == [0]
    assert np.isnan(everywhere["w"].values).all()


def test_a_ray_that_stopped_ends_its_sectors_only():
    """The ray at 40 degrees has a limit load half way: beside it there is no answer beyond, elsewhere there is."""
    tree = fan_springs(potential)
    data = tree["paths/ray_3"].to_dataset(inherit=False)
    tree["paths/ray_3"] = xr.DataTree(data.isel(step=slice(0, 16)))
    ended(tree, "ray_3", "limit load", REASON)
    model = MacroModel.from_springs(tree)

    def refused(rho: float, angle: float) -> int:
        state = rho * np.array([[np.cos(np.radians(angle)), np.sin(np.radians(angle)) / 4.0]])
        return int(trace(model, "state", state)["beyond_end"][0])

    end = float(np.hypot(data["u"][15], 4.0 * data["rotation"][15]))
    assert [refused(0.99 * end, angle) for angle in (40.0, 35.0, 45.0, 0.0)] == [0, 0, 0, 0]
    assert [refused(1.01 * end, angle) for angle in (40.0, 35.0, 45.0)] == [1, 1, 1]
    assert [refused(1.01 * end, angle) for angle in (20.0, 30.0, 50.0, 0.0)] == [0, 0, 0, 0]
    assert [refused(1.01 * end, angle) for angle in (-140.0, -145.0, 180.0)] == [1, 1, 0]


def test_a_limit_load_of_a_held_back_path_bounds_the_fan():
    """In its direction, either way, at its vertical load; other directions are as before."""
    tree = ended(fan_springs(potential, held_back=(8.0,)), "pull_8", "limit load", REASON)
    H = float(tree["paths/pull_8/H"][-1])
    for factor in (1.01, -1.01):
        with pytest.raises(BeyondSprings, match="path 'pull_8' met a limit load"):
            predict(tree, H=factor * H, arm=8.0)
    assert predict(tree, H=0.99 * H, arm=8.0)["beyond_end"].values.sum() == 0
    assert predict(tree, H=1.01 * H, arm=6.0)["beyond_end"].values.sum() == 0
    with pytest.warns(MacroWarning, match="is not that of path"):
        predict(tree, H=1.01 * H, arm=8.0, V=3e6)


@pytest.mark.parametrize("status", ["complete", "partial"])
def test_a_file_without_ends_is_read_and_marked(tmp_path, status):
    """What is marked as partial has stopped somewhere; of the others the end is not known."""
    tree = make_springs()
    del tree["paths/pull"].attrs["end"]
    tree["paths/pull"].attrs["status"] = status
    old = open_springs(save_springs(tree, tmp_path / "springs.nc"))
    answer = predict(old, H=1e5)
    unknown = status == "complete"
    assert answer.attrs["path_end"] == ("not known" if unknown else "stopped")
    assert ("how their paths ended is not known" in " ".join(answer.attrs["remarks"])) is unknown
    if not unknown:
        with pytest.raises(BeyondSprings, match=r"path 'pull' stopped \(reason not recorded\)"):
            predict(old, H=9e9)


@pytest.mark.parametrize(
    ("attrs", "key"), [({"end": "fine"}, "end"), ({"end_H_N": "2 MN"}, "end_H_N"), ({"end": "limit load"}, "end_H_N")]
)
def test_wrong_ends_are_refused(attrs, key):
    tree = make_springs()
    tree["paths/pull"].attrs |= attrs
    with pytest.raises(UserInputError) as caught:
        validate_springs(tree)
    assert [problem.key for problem in caught.value.problems] == [f"paths/pull/{key}"]


@pytest.mark.parametrize(("V", "known"), [(3.9e6, True), (1e5, True), (4.1e6, False), (-1e5, False), (500e6, False)])
def test_a_vertical_load_without_vertical_springs_is_known_from_0_to_twice_that_of_the_paths(V, known):
    """Alone, with a lateral load and in a sequence; 2 MN is the vertical load of the paths."""
    tree = make_springs()
    for ask in (
        lambda: predict(tree, V=V),
        lambda: predict(tree, H=1e5, V=V),
        lambda: sequence(tree, np.array([[1e5, 0.0]]), V=[V]),
    ):
        if known:
            with pytest.warns(MacroWarning, match="elastic vertical stiffness"):
                ask()
        else:
            with pytest.raises(BeyondSprings, match=r"V is known from 0 N to 4 MN .*add a path of kind 'vertical'"):
                ask()


def test_a_vertical_path_that_stopped_ends_its_direction_only():
    tree = vertical_springs(ends=(5e-3, -1e-2))
    path = paths_of(tree)["down"].dataset
    end = float(path["V"][-1])
    ended(tree, "down", "stopped", "apex: no confining stress")
    assert predict(tree, V=end - 1e4)["beyond_end"].values.sum() == 0
    with pytest.raises(BeyondSprings, match=r"V = .* beyond the vertical springs .*path 'down' stopped"):
        predict(tree, V=end + 1e6)
    assert predict(tree, V=REST - 1e6)["beyond_end"].values.sum() == 0


def test_between_two_vertical_loads_a_path_ends_with_the_shorter_one():
    tree = vertical_springs(ends=(), heavier=(4e6,))
    short = tree["paths/slide_4"].to_dataset(inherit=False)
    tree["paths/slide_4"] = xr.DataTree(short.isel(step=slice(0, 8)))
    ended(tree, "slide_4", "stopped", "localisation")
    between = Springs.of(tree).at(V=3e6).path("slide").dataset
    end = end_of("slide", between)
    assert (end.how, end.why) == ("stopped", "as path 'slide_4': localisation")
    assert pytest.approx(float(between["H"][-1])) == end.H
    assert end_of("turn", Springs.of(tree).at(V=3e6).path("turn").dataset).how == "reached"


@pytest.fixture(scope="module")
def storm() -> xr.DataTree:
    """A run of the full model under a load that the soil does not carry."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return extract_springs(compute.run(tiny.overloaded_scene()))


def test_a_limit_load_of_the_full_model_is_kept_and_bounds_the_command(storm, tmp_path):
    file = save_springs(storm, tmp_path / "springs.nc")
    attrs, path = open_springs(file)["paths/storm"].attrs, paths_of(storm)["storm"].dataset
    assert attrs["end"] == "limit load"
    assert attrs["end_reason"].startswith("limit load")
    assert attrs["end_H_N"] == float(path["H"][-1])
    assert attrs["end_M_Nm"] == float(path["M"][-1])
    inside, beyond = (f"{factor * attrs['end_H_N']:.9g} N" for factor in (0.98, 1.02))
    done = command("predict", str(file), "--H", beyond)
    assert (done.code, done.out) == (2, "")
    assert len(done.err.splitlines()) == 1
    assert done.err.startswith("fatal: user input: springs: ")
    assert "path 'storm' met a limit load of the full model at H = " in done.err
    done = command("predict", str(file), "--H", inside, "--json")
    assert done.code == 0
    assert json.loads(done.out)["attributes"]["path_end"] == "limit load"


def test_what_iteration_leaves_on_a_vertical_path_is_no_load() -> None:
    end = PathEnd("down", "reached", H=-42.0, M=-750.0, V=1e7, u=0.0, rotation=0.0)
    assert str(end) == "path 'down' reached its aim"
    assert "at H = 42 kN" in str(replace(end, H=42e3))


def test_a_path_that_came_to_its_aim_is_kept_as_reached():
    attrs = extract_springs(tiny.result())["paths/pull"].attrs
    assert (attrs["end"], attrs["end_reason"]) == ("reached", "")
    assert attrs["end_H_N"] > 0.0
