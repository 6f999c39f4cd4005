# SPDX-License-Identifier: MIT
"""The catalogue of stiff and extreme cases: what is in it, which endings there are, none unexplained."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from pysprings.core.errors import ResourceError, UserInputError
from pysprings.core.units import read, si_of
from pysprings.core.words import StopReason
from pysprings.full_model.run_record import PathFigures, RunRecord, Status
from pysprings.studies import stability as stability
from pysprings.studies.stability import CASES, Case
from tests.support.commands import command

NAMES = [case.name for case in CASES]


def record(
    reason: StopReason | None = None, failures: tuple[str, ...] = (), warnings: tuple[str, ...] = ()
) -> RunRecord:
    path = PathFigures(Status.COMPLETE if reason is None else Status.PARTIAL, reason)
    return RunRecord(path.status, failures=list(failures), warnings=list(warnings), paths={"pull": path})


def test_names_are_unique_and_the_groups_are_not_names() -> None:
    assert len(set(NAMES)) == len(NAMES)
    assert not {case.group for case in CASES} & set(NAMES)


@pytest.mark.parametrize("case", CASES, ids=NAMES)
def test_every_case_is_a_scene_or_is_refused_with_a_line(case: Case) -> None:
    try:
        scene = case.scene("coarse")
    except ValueError as error:
        assert stability._refusal(error)
        return
    assert scene.mesh.preset == "coarse"
    changed = scene.model_dump()
    for section, values in case.changes.items():
        for key, value in values.items():
            assert has(changed[section]["layers" if key == "layer" else key], value), (
                f"{section}.{key} is not what the catalogue has"
            )


def has(found: Any, wanted: Any) -> bool:
    """Whether a value of a scene, in SI, is what was given; tables and layers have what was given of them."""
    if isinstance(wanted, dict):
        return all(has(found[key], value) for key, value in wanted.items())
    if isinstance(wanted, list):
        return len(found) == len(wanted) and all(map(has, found, wanted))
    if isinstance(wanted, str) and isinstance(found, float):
        return found == read(wanted, si_of(wanted.partition(" ")[2]))
    return bool(found == wanted)


def test_endings() -> None:
    assert stability._ending(record())["outcome"] == "converged"
    assert stability._ending(record(warnings=("water would cavitate",))) == {
        "outcome": "warned",
        "detail": "water would cavitate",
    }
    why = ("path 'pull' stopped: words that name no reason",)
    assert stability._ending(record(StopReason.LOCALISATION, why)) == {"outcome": "stopped", "detail": why[0]}
    for reason in (StopReason.UNEXPLAINED, StopReason.OUT_OF_MEMORY):
        assert stability._ending(record(reason, why))["outcome"] == "unexplained"


def test_an_error_of_the_tool_is_unexplained_and_a_bug_is_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(kind: type[Exception]) -> Any:
        def compute(_: Any) -> None:
            raise kind("no memory")

        return compute

    monkeypatch.setattr(stability, "compute", fail(ResourceError))
    assert stability.run_case(CASES[0]).outcome == "unexplained"
    monkeypatch.setattr(stability, "compute", fail(ZeroDivisionError))
    with pytest.raises(ZeroDivisionError):
        stability.run_case(CASES[0])


def test_cases_are_chosen_by_name_and_group() -> None:
    assert [case.name for case in stability.cases_named(["smooth"])] == ["smooth"]
    assert {case.group for case in stability.cases_named(["water"])} == {"water"}
    assert len(stability.cases_named(["hard"])) >= 12
    with pytest.raises(UserInputError, match="--case smoth: no such case"):
        stability.cases_named(["smoth"])


@pytest.mark.parametrize("given", [("--refinement", "-1"), ("--refinement", "nan"), ("--reach", "0 mm")])
def test_a_setting_that_no_case_takes_is_refused(given: tuple[str, str]) -> None:
    done = command("stability", "--case", "soft", *given)
    assert (done.code, "fatal: user input: --refinement, --reach:" in done.err) == (2, True)


def test_a_shorter_reach_leaves_what_a_case_says_itself() -> None:
    by_name = {case.name: case for case in CASES}
    assert by_name["paper"].scene("coarse", 3e-3).paths[0].lateral_displacement == 3e-3
    assert by_name["push-0.5m"].scene("coarse", 3e-3).paths[0].lateral_displacement == 0.5
    assert by_name["beyond-capacity"].scene("coarse", 3e-3).paths[0].lateral_force == 20e6


def test_cases_without_a_named_reason_end_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Exit code 3, after the table; a case that is explained is no failure."""

    def fail(_: Any) -> None:
        raise ResourceError("no memory")

    monkeypatch.setattr(stability, "compute", fail)
    done = command("stability", "--case", "soft", "--case", "paper", "--refinement", "0.6", "--jobs", "1")
    assert (done.code, done.err) == (3, "fatal: not converged: 2 cases ended without a named reason\n")
    assert "0 converged, 0 warned, 0 stopped, 0 refused, 2 unexplained" in done.out


@pytest.mark.slow
def test_the_command_runs_cases_and_writes_table_and_picture(tmp_path: Path) -> None:
    given = [
        "stability",
        "--case",
        "K0-3",
        "--case",
        "soft",
        "--refinement",
        "0.6",
        "--reach",
        "10 mm",
        "--out",
        str(tmp_path),
        "--json",
    ]
    done = command(*given)
    assert done.code == 0, done.err
    answer = json.loads(done.out)
    assert answer["summary"]["converged"] == 1 and answer["summary"]["refused"] == 1
    table = pd.read_csv(tmp_path / "stability.csv")
    assert list(table["case"]) == ["soft", "K0-3"]
    soft = table.iloc[0]
    assert soft["u_mm"] == pytest.approx(10.0)
    assert soft["energy_imbalance"] < 1e-6
    assert 1e2 < soft["condition"] < 1e8
    assert "| soft | converged |" in (tmp_path / "stability.md").read_text()
    assert (tmp_path / "stability.png").stat().st_size > 10_000


def test_a_case_that_is_pulled_out_ends_at_its_w_and_v() -> None:
    """u and H are 0 there; after a pull of 0.2 m V is the resistance of the skirt."""
    (case,) = stability.cases_named(["clay-pull-out"])
    ended = stability.run_case(case, refinement=0.4)
    assert (ended.outcome, ended.H_kN) == ("converged", pytest.approx(0.0, abs=1.0))
    assert ended.w_mm == pytest.approx(-200.0, abs=5.0) and ended.V_kN < -100.0


@pytest.mark.slow
def test_cases_in_worker_processes_are_the_same_in_the_same_order() -> None:
    cases, reported = stability.cases_named(["soft", "K0-3", "paper"]), []
    alone = stability.run_cases(cases, "coarse", 0.6, reach=2e-3)
    both = stability.run_cases(cases, "coarse", 0.6, report=lambda row: reported.append(row.case), reach=2e-3, jobs=2)
    assert reported == list(alone["case"]) and len(reported) == 3
    less = ["wall_s", "worst_residual", "condition", "energy_imbalance"]  # bricks: MKL rounds by its threads
    for name in less[1:]:
        np.testing.assert_allclose(alone[name].astype(float), both[name].astype(float), rtol=1e-2, atol=1e-6)
    u = ["u_mm", "H_kN"]
    np.testing.assert_allclose(alone[u].astype(float), both[u].astype(float), rtol=1e-6)
    pd.testing.assert_frame_equal(alone.drop(columns=less + u), both.drop(columns=less + u))


def test_the_share_of_cut_backs_counts_cases_that_reached_their_end() -> None:
    rows = [
        {"outcome": "converged", "increments": 30, "cut_backs": 3, "median_iterations": 4.0, "energy_imbalance": 1e-8},
        {"outcome": "warned", "increments": 10, "cut_backs": 1, "median_iterations": 2.0, "energy_imbalance": 1e-7},
        {"outcome": "stopped", "increments": 9, "cut_backs": 90, "median_iterations": 9.0, "energy_imbalance": 1.0},
    ]
    total = stability.summary(pd.DataFrame(rows))
    assert total["cut_backs_over_increments"] == pytest.approx(0.1)
    assert total["median_iterations"] == 3.0
    assert total["worst_energy_imbalance"] == 1e-7
    assert "4 steps cut in 40 increments (10 %)" in stability.closing(total)


@pytest.mark.slow
def test_no_case_ends_without_a_named_reason() -> None:
    """The whole catalogue on a mesh of 0.45 times `coarse`; on 0.6 of it: `make stability`."""
    table = stability.run_cases(CASES, "coarse", 0.45)
    assert not table.loc[table["outcome"] == "unexplained", ["case", "detail"]].to_numpy().tolist()
    reached = table[table["outcome"].isin(("converged", "warned"))]
    assert len(reached) >= 45
    assert reached["median_iterations"].max() <= 6
    assert reached["energy_imbalance"].max() < 1e-5
    assert np.nanmax(reached["water_imbalance"].to_numpy(dtype=float)) < 1e-5


@pytest.mark.slow
def test_an_undrained_push_takes_no_more_steps_than_a_drained_one() -> None:
    """With earlier factors, as from 2,000 unknowns on. With loosely solved systems 25 steps were cut."""
    (case,) = stability.cases_named(["undrained"])
    outcome = stability.run_case(case, "coarse")
    assert outcome.outcome == "converged"
    assert outcome.increments <= 35
    assert outcome.cut_backs <= 2
