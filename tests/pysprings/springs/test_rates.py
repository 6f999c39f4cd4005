# SPDX-License-Identifier: MIT
"""Springs at a rate between those of the runs they come from."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from pysprings.core.errors import UserInputError
from pysprings.macro.answer import MacroWarning
from pysprings.macro.batch import predict_batch
from pysprings.macro.comparison import compare, merge_slices
from pysprings.macro.model import MacroModel, spring_sets
from pysprings.macro.predict import impose, sequence
from pysprings.macro.stiffness import stiffness_six
from pysprings.macro.vertical_answer import with_vertical_use
from pysprings.results import exporters
from pysprings.results.exporters.subdyn import linear
from pysprings.springs.card import stiffness_text
from pysprings.springs.checks import save_springs
from pysprings.springs.path import SpringPath, paths_of, same_way
from pysprings.springs.path_sets import blend
from pysprings.springs.springs import Springs
from pysprings.springs.sums import balance
from tests.support import synthetic, wet
from tests.support.commands import command
from tests.support.rates import at_two_rates, with_vertical
from tests.support.vertical import RAYS, REST

LENGTH = 4.0


def test_a_rate_far_from_both_of_the_springs_is_a_remark() -> None:
    """That is more than half a decade."""
    springs = Springs.of(at_two_rates())
    texts = [" ".join(MacroModel.from_springs(springs.at_rate(rate)).remarks) for rate in (1e-5, 3e-5, 1e-4)]
    words = "the rate is between those of the springs, 0.01 and 1 mm/s, more than half a decade from both: interpolated"
    assert [words in text for text in texts] == [False, False, True]


def test_merged_slices_are_answered_at_a_rate() -> None:
    """They have lost a part of the moment: their reactions do not sum to M, which a file's must."""
    coarse = merge_slices(at_two_rates(), 3)
    assert balance(coarse.path("turn0").dataset)["M"] > 1e-6
    assert list(Springs.of(coarse).at_rate(1e-4).paths) == ["slide0", "turn0"]


def test_sets_are_found_by_rate_slowest_first() -> None:
    sets = Springs.of(at_two_rates(speeds=(1e-3, 1e-5))).rate_sets
    assert [each.rate for each in sets] == pytest.approx([1e-5, 1e-3])
    assert [set(each.paths) for each in sets] == [{"slide1", "turn1"}, {"slide0", "turn0"}]


def test_half_way_in_the_logarithm_is_the_mean() -> None:
    springs = at_two_rates()
    found = Springs.of(springs).at_rate(1e-4)
    assert list(found.paths) == ["slide0", "turn0"]
    assert found.attrs["rate_m_per_s"] == 1e-4
    for name in ("slide", "turn"):
        new, slow = found.path(f"{name}0").dataset, paths_of(springs)[f"{name}0"].dataset
        for variable in ("p", "m", "H", "M_lid"):
            np.testing.assert_allclose(new[variable], 1.1 * slow[variable], rtol=1e-12, atol=1e-9)
        np.testing.assert_array_equal(new["y"], slow["y"])
        assert max(balance(new).values()) < 1e-9  # the reactions still sum to the load
        np.testing.assert_allclose(new["p_component"], 1.1 * slow["p_component"], atol=1e-9)


def test_at_the_rate_of_a_set_its_own_springs_are_given() -> None:
    springs = at_two_rates()
    found = Springs.of(springs).at_rate(1.02e-3)
    np.testing.assert_array_equal(found.path("slide1").dataset["p"], paths_of(springs)["slide1"].dataset["p"])


@pytest.mark.parametrize("rate", [0.9e-5, 1.1e-3])
def test_beyond_the_slowest_and_the_fastest_nothing_is_extrapolated(rate: float) -> None:
    with pytest.raises(UserInputError, match=r"outside the rates of the springs \(0\.01, 1 mm/s"):
        Springs.of(at_two_rates()).at_rate(rate)


@pytest.mark.parametrize("rate", [-1e-4, 0.0, np.nan])
def test_a_rate_is_positive(rate: float) -> None:
    with pytest.raises(UserInputError, match=r"rate: (-0\.1|0|nan) mm/s is not positive"):
        Springs.of(at_two_rates()).at(rate=rate)


def test_drained_springs_have_no_rate() -> None:
    with pytest.raises(UserInputError, match="drained: they do not depend on a rate"):
        Springs.of(synthetic.make_springs(RAYS)).at_rate(1e-4)


def test_paths_without_a_partner_are_left_out_and_none_at_all_is_refused() -> None:
    springs = at_two_rates()
    lone, none = without(springs, "turn1"), without(springs, "turn1", "slide0")
    assert list(Springs.of(lone).at_rate(1e-4).paths) == ["slide0"]
    with pytest.raises(UserInputError, match="different directions"):
        Springs.of(none).at_rate(1e-4)


def without(springs: xr.DataTree, *names: str) -> xr.DataTree:
    """The springs less some paths."""
    kept = [node for node in springs.subtree if node.path.split("/")[-1] not in names]
    return xr.DataTree.from_dict({node.path: node.to_dataset(inherit=False) for node in kept})


def test_a_shorter_fast_path_shortens_the_answer() -> None:
    springs = at_two_rates()
    given = Springs.of(springs)
    fast = given.path("slide1").at_steps(range(7))
    found = blend(given.path("slide0"), fast, 0.5)
    assert found.u[-1] == pytest.approx(fast.u[-1])
    assert found.n == 7


def test_beside_a_set_between_its_steps_the_answer_is_that_of_the_set() -> None:
    """Paths of two sets have steps of their own; a straight line between those of the other is 3 % low."""
    given = Springs.of(at_two_rates())
    fast = given.path("slide1")
    found = blend(given.path("slide0"), fast.at_steps([0, 1, 2, 3, 5, 7, 9, 12]), 1.0)
    np.testing.assert_allclose(found["H"], fast["H"], rtol=6e-3)
    assert balance(found.dataset)["H"] < 1e-9  # sums stay sums


# --- what the macro-model makes of them ---


def test_a_fan_of_several_rates_is_refused_until_a_rate_is_given() -> None:
    springs = at_two_rates()
    for kind in (None, "fan", "pisa"):
        with pytest.raises(UserInputError, match=r"several rates \(0\.01, 1 mm/s, of rho\): give one"):
            MacroModel.from_springs(springs, kind)
    assert "fan" not in spring_sets(springs) and "full" in spring_sets(springs)
    found = Springs.of(springs).at_rate(1e-4)
    assert {"fan", "pisa"} <= set(spring_sets(found))
    slow = Springs.of(springs).at_rate(1e-5)
    loads = [MacroModel.from_springs(each, "fan").reactions(4e-3, -5e-4)[0] for each in (slow, found)]
    # the initial stiffness, the same at all rates, shapes the curve between recorded states
    np.testing.assert_allclose(loads[1], 1.1 * loads[0], rtol=1e-3)


def test_every_answer_names_the_rate_of_its_springs() -> None:
    """Asked for, between two sets, of one set, of one path; drained springs have none."""
    springs = Springs.of(at_two_rates())
    words = "those of {} mm/s (of rho)"
    for rate, known in ((1e-4, "0.1"), (1e-5, "0.01")):
        model = MacroModel.from_springs(springs.at_rate(rate))
        assert sum(words.format(known) in text for text in model.remarks) == 1, model.remarks
    assert words.format("1") in "; ".join(MacroModel.from_springs(springs, "full", "slide1").remarks)
    one = MacroModel.from_springs(at_two_rates(speeds=(2e-3,)))
    assert any(words.format("2") in text for text in one.remarks)
    assert not any("of rho" in text for text in MacroModel.from_springs(synthetic.make_springs(RAYS)).remarks)


@pytest.mark.parametrize(("asked", "named"), [(1e-5, "0.01"), (1e-4, "0.1"), (1e-3, "1"), (None, "0.01, 1")])
def test_a_file_for_another_program_names_the_rate_of_its_springs(
    tmp_path: Path, asked: float | None, named: str
) -> None:
    """A matrix at rest is that of all rates."""
    tree = at_two_rates()
    if asked is None:
        (file, *_) = exporters.export(tree, "subdyn", tmp_path).files
        text = file.read_text()
    else:
        text = exporters.text(tree, "beam", rate=asked)
    assert f"coupled; rate: {named.replace(', ', ' mm/s, ')} mm/s; vertical load" in text


def test_compare_answers_every_path_at_its_own_rate() -> None:
    frame = compare(at_two_rates())
    fan = frame[frame["springs"] == "fan"].set_index("path")
    assert set(fan.index) == {"slide0", "turn0", "slide1", "turn1"}
    assert fan["H_error_max_pct"].abs().max() < 1e-6  # each set holds on its own paths


def test_a_path_beyond_the_sets_is_answered_by_the_nearest_one() -> None:
    springs = at_two_rates()
    fast = paths_of(springs)["slide1"].dataset.assign_attrs(role="held-back")
    fast["time"] = fast["time"] / 100.0
    springs["paths/faster"] = xr.DataTree(fast)
    given = Springs.of(springs)
    assert list(given.answering(given.path("faster")).paths) == ["slide1", "turn1", "faster"]


def test_a_chain_of_rates_is_one_set_where_each_is_near_the_next() -> None:
    """1, 2.5 and 6.25: the last is more than half a decade from the first, and near the second."""
    speeds = (1e-5, 2.5e-5, 6.25e-5)
    (found,) = Springs.of(at_two_rates(speeds=speeds)).rate_sets
    assert found.rate == pytest.approx((speeds[0] * speeds[1] * speeds[2]) ** (1.0 / 3.0))
    assert set(found.paths) == {f"{name}{number}" for name in ("slide", "turn") for number in range(3)}
    apart = Springs.of(at_two_rates(speeds=(1e-5, 2.5e-5, 8e-5))).rate_sets  # 3.2 from the second: a set of its own
    assert [each.rate for each in apart] == pytest.approx([1e-5 * 2.5**0.5, 8e-5])
    assert [set(each.paths) for each in apart] == [{"slide0", "slide1", "turn0", "turn1"}, {"slide2", "turn2"}]


def test_a_rest_does_not_change_the_rate_of_a_path() -> None:
    """An hour at its last turn: the speed of the motion stays."""
    path = wet.coupled(turning=(0.0,)).paths["turning_0"]
    assert path.rate == pytest.approx(wet.RATE, rel=1e-9)
    turn = int(np.argmin(path.u))
    rested = path.recorded.isel(step=[*range(turn + 1), *range(turn, path.n)])
    later = np.where(np.arange(path.n + 1) > turn, 3600.0, 0.0)
    rested = rested.assign(time=("step", rested["time"].values + later))
    assert SpringPath("rested", rested.assign_attrs(path.attrs), LENGTH).rate == pytest.approx(wet.RATE, rel=1e-9)


# --- vertical springs, which have a rate of their own ---

CASES = "name,H [kN],arm [m],V [MN]\nat rest,100,2,2\npushed,100,2,2.5\npulled,0,0,-0.2\n"


@pytest.mark.parametrize(("rate", "marks"), [(1e-5, [0, 0, 0]), (2.5e-5, [0, 0, 0]), (1e-3, [0, 1, 1])])
def test_a_vertical_load_on_springs_of_another_rate_is_marked(rate: float, marks: list[int]) -> None:
    """From half a decade on, row by row; within 5 % nothing is said."""
    springs = Springs.of(with_vertical(1e-5)).at_rate(rate)
    answers = predict_batch(springs, H=1e5, arm=2.0, V=np.array([REST, 1.2 * REST, -0.1 * REST]))
    assert answers["off_rate"].values.tolist() == marks
    assert predict_batch(springs, H=1e5, arm=2.0)["off_rate"].values.tolist() == [0]
    words = [text for text in answers.attrs["remarks"] if "what they add to w, and the largest V are those of" in text]
    assert [text.split("those of ")[1] for text in words] == ["0.01 mm/s (of w)"] * (rate > 1e-5)
    one = with_vertical_use(MacroModel.from_springs(springs), answers.rename(case="step"))
    assert one.attrs["capacity_V_from"].startswith("path 'up' (0.01 mm/s), at")


@pytest.mark.parametrize(("rate", "factor"), [(1e-5, 1.0), (1e-4, 1.25), (1e-3, 1.5)])
def test_vertical_springs_are_those_of_the_rate_or_between_two(rate: float, factor: float) -> None:
    """1.5 times stronger a hundred times as fast, in the middle of both by logarithm 1.25 times."""
    slow, whole = (Springs.of(with_vertical(*rates)) for rates in ((1e-5,), (1e-5, 1e-3)))
    model, own = (MacroModel.from_springs(each) for each in (whole.at_rate(rate), slow.at_rate(1e-5)))
    for sign, end in ((1.0, 0.9e-2), (-1.0, -0.9e-2)):
        w = own.vertical.rest[0] + np.array([0.2, 1.0]) * end
        there, here = (each.vertical.reactions(w)[-1] - REST for each in (model, own))
        np.testing.assert_allclose(there, factor * here, rtol=0.02)  # the stiffness at rest is that of the slow ones
        assert model.vertical.branch(sign).rate == pytest.approx(rate)
    answers = predict_batch(whole.at_rate(rate), H=1e5, arm=2.0, V=np.array([REST, 1.2 * REST, -0.1 * REST]))
    assert not answers["off_rate"].any()
    assert "what they add to w, and the largest V" not in str(answers.attrs["remarks"])
    assert len(whole.at_rate(rate).vertical) == 2
    alike = [same_way(whole.paths["down"], whole.paths[name]) for name in ("down_rate_1", "up_rate_1")]
    ones = [MacroModel.from_springs(whole, "full", name).vertical.path for name in ("slide0", "slide1")]  # at its rate
    assert alike == [True, False] and ones == ["down, up", "down_rate_1, up_rate_1"]


def test_a_step_at_its_rate_keeps_the_mark_of_its_vertical_load() -> None:
    springs = Springs.of(with_vertical(1e-5)).at_rate(1e-3)
    motions, loads = np.array([[1e-3, 0.0], [2e-3, 0.0]]), np.array([REST, 1.05 * REST])
    with pytest.warns(MacroWarning, match="vertical springs of another rate"):
        answer = sequence(springs, motions, control="state", V=loads, time=np.array([1.0, 2.0]))
    assert answer["off_rate"].values.tolist() == [0, 1]


def test_load_cases_are_answered_at_a_rate(tmp_path: Path) -> None:
    (cases := tmp_path / "cases.csv").write_text(CASES)
    save_springs(with_vertical(1e-5), file := tmp_path / "springs.nc")
    refused = command("design", file, cases)
    assert refused.code == 2 and "several rates (0.01, 1 mm/s, of rho): give one" in refused.err
    fast, slow = (
        json.loads(command("design", file, cases, "--rate", rate, "--json").out)["cases"]
        for rate in ("1 mm/s", "0.01 mm/s")
    )
    assert fast[0]["u_m"] < slow[0]["u_m"]
    assert [{row["rate_m_per_s"] for row in rows} for rows in (fast, slow)] == [{1e-3}, {1e-5}]
    words = "V carried by vertical springs of another rate"
    assert [words in row["marks"] for row in fast] == [False, True, True] and words not in str(slow)
    assert (fast[2]["verdict"], slow[2]["verdict"]) == ("supported in part", "ok")


def test_curves_for_a_beam_program_are_those_of_a_rate(tmp_path: Path) -> None:
    save_springs(at_two_rates(), file := tmp_path / "springs.nc")
    found = command("springs", file, "--for", "beam", "--rate", "0.1 mm/s")
    assert found.code == 0 and "; rate: 0.1 mm/s;" in found.out
    assert "several rates" in command("springs", file, "--for", "beam").err
    assert ", at 0.01 mm/s of w\n" in exporters.text(with_vertical(1e-5), "beam", rate=1e-3)
    assert "--rate: is an option of --for beam" in command("springs", file, "--rate", "0.1 mm/s").err


def test_errors_name_the_rates_of_the_paths_that_are_held_back() -> None:
    tree = at_two_rates(speeds=(1e-5, 1e-3, 1e-4))
    for name in ("slide2", "turn2"):
        tree[f"paths/{name}"] = xr.DataTree(
            tree[f"paths/{name}"].to_dataset(inherit=False).assign_attrs(role="held-back")
        )
    assert "full model, 2 held-back paths at 0.1 mm/s (of rho): load " in exporters.text(tree, "beam", rate=1e-3)
    springs = Springs.of(tree)
    assert springs.paces(["slide0", "slide2"]) == " at 0.01 to 0.1 mm/s (of rho)"
    assert springs.at_rate(1e-3).paces(["slide0"]) == ""


def test_an_initial_stiffness_where_water_flows_is_named_as_that_of_a_sudden_load() -> None:
    """A slow load meets a softer, drained one; springs of drained ground have no such words."""
    drained, coupled = synthetic.make_springs(RAYS), at_two_rates()
    words = "(of a load so sudden that no water moves)"
    options = {"at": None, "rate": None}
    files = [linear(Springs.of(tree), options).lines[0] for tree in (coupled, drained)]
    for text in (stiffness_text(Springs.of(coupled)), stiffness_six(coupled).attrs["long_name"], files[0]):
        assert words in text
    one = Springs.of(coupled).at_rate(1e-3)
    with pytest.warns(MacroWarning, match=r"elastic vertical stiffness \(of a load so sudden"):
        impose(one, u=1e-3, rotation=0.0, V=1.05 * REST)
    for text in (stiffness_text(Springs.of(drained)), stiffness_six(drained).attrs["long_name"], files[1]):
        assert words not in text
