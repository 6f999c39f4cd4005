# SPDX-License-Identifier: MIT
"""The record of a run: attempts, order of convergence, cut-backs, cost."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from fe_engine.errors import NotConverged
from pysprings.core import variables
from pysprings.core.words import StopReason
from pysprings.full_model.record import (
    DEAD_LOAD,
    Meter,
    convergence_dataset,
    cut_back,
    peak_memory_bytes,
    summarise,
    with_attempts,
)
from pysprings.full_model.run_record import (
    CheckpointCost,
    CutBack,
    MeshFigures,
    PathFigures,
    RunRecord,
    SolverFigures,
    Status,
)
from pysprings.model.stages import dead_load_stage
from tests.support import tiny
from tests.support.files import record_of

COUNTS = {"n_open": 0, "n_slip": 1, "n_plastic": 2, "n_apex": 0, "damping": 1.0, "correction": 0.0}


def increment(step: int, residuals: list[float], converged: bool = True, stage: str = "pull") -> list[dict[str, Any]]:
    """Rows of one attempt."""
    head = {"stage": stage, "step": step, "load_fraction": 0.1 * step, "converged": converged, **COUNTS}
    return [{**head, "iteration": k, "residual": r} for k, r in enumerate(residuals)]


def path() -> xr.Dataset:
    return xr.Dataset(
        {name: ("step", [0.0, value]) for value, name in enumerate(("u", "w", "rotation", "H", "V", "M"))}
    )


QUADRATIC = [1e-1, 1e-2, 1e-4, 1e-8]
RECORD = increment(1, QUADRATIC) + increment(2, [1.0, 2.0, 4.0], False) + increment(2, [1e-2, 1e-9])
GIVEN_UP = [CutBack("path", 0.2, "stalls", "node 7", 2, [2.0, 4.0])]


def test_attempts_are_counted_step_by_step() -> None:
    rows = with_attempts(RECORD)
    assert [(row["increment"], row["attempt"]) for row in rows] == [(1, 1)] * 4 + [(2, 1)] * 3 + [(2, 2)] * 2


def test_increments_of_the_dead_load_come_before_step_1() -> None:
    dead = increment(1, [0.1, 1e-9], stage=DEAD_LOAD) + increment(2, [0.1, 1e-9], stage=DEAD_LOAD)
    rows = with_attempts(dead + increment(3, [0.1, 1e-9]) + increment(4, [0.1, 1e-9]))
    assert [row["increment"] for row in rows] == [-1, -1, 0, 0, 1, 1, 2, 2]
    assert dead_load_stage(1.0).name == DEAD_LOAD
    summary = summarise(dead + increment(3, [0.1, 1e-9]), [], path())
    assert (summary.increments, summary.increments_of_dead_load) == (3, 2)


def test_summary_counts_accepted_increments_and_given_up_ones_apart() -> None:
    summary = summarise(RECORD, GIVEN_UP, path())
    assert summary.increments == 2
    assert (summary.iterations, summary.median_iterations, summary.max_iterations) == (4, 2.0, 3)
    assert (summary.cut_backs, summary.iterations_in_cut_backs) == (1, 2)
    assert summary.cut_backs_at == GIVEN_UP
    assert summary.worst_residual == 1e-8
    assert summary.end == {"u": 0.0, "w": 1.0, "rotation": 2.0, "H": 3.0, "V": 4.0, "M": 5.0}
    assert summary.contact_rings is None
    assert summary.increments_of_dead_load is None and "increments_of_dead_load" not in summary.as_dict()


def test_order_and_ratio_of_the_last_iterations() -> None:
    summary = summarise(increment(1, QUADRATIC), [], path())
    assert summary.order_of_last_iterations == pytest.approx(2.0)
    assert summary.last_residual_ratio == pytest.approx(1e-4)
    linear = summarise(increment(1, [5e-2, 5e-3, 5e-4, 5e-5]), [], path())
    assert linear.order_of_last_iterations == pytest.approx(1.0)
    short = summarise(increment(1, [1e-2, 1e-9]), [], path())
    assert (short.order_of_last_iterations, short.last_residual_ratio) == (None, None)


def test_a_path_without_an_accepted_increment() -> None:
    summary = summarise(increment(1, [1.0, 2.0], False), GIVEN_UP, path())
    assert (summary.increments, summary.iterations, summary.median_iterations) == (0, 0, 0.0)
    assert summarise([], [], path()).increments == 0


def test_convergence_dataset_holds_every_row() -> None:
    data = convergence_dataset(RECORD)
    np.testing.assert_array_equal(data["residual"].values, [row["residual"] for row in RECORD])
    assert list(variables.problems(data, "convergence")) == []
    assert data["increment"].dtype == np.int32
    assert convergence_dataset([]).sizes["iteration"] == 0


def test_cut_back_says_where_and_why() -> None:
    history = [{"residual": 0.123456}, {"residual": 2.0}]
    found = cut_back("pull", 0.25, NotConverged("the residual stalls", "node 7", history))
    assert found.as_dict() == {
        "stage": "path", "load_fraction": 0.25, "reason": "the residual stalls", "place": "node 7",
        "iterations": 1, "last_residuals": [0.123, 2.0],
    }  # fmt: skip
    assert cut_back(DEAD_LOAD, 0.5, NotConverged("x")).stage == DEAD_LOAD
    assert cut_back("pull", 0.5, NotConverged("x")).iterations == 0


def test_phases_and_other_add_up_to_the_totals() -> None:
    record, readings = RunRecord(Status.COMPLETE), iter([0.0, 1.0, 3.0, 8.0, 8.5, 9.5, 10.0])
    meter = Meter(lambda: (10.0 + (at := next(readings)), 0.5 * at))
    with meter.clock.phase("mesh"):
        pass
    meter.charge(record)
    assert record.phases == {"mesh": {"wall_s": 2.0, "cpu_s": 1.0}, "other": {"wall_s": 6.0, "cpu_s": 3.0}}
    with meter.clock.phase("report"):
        pass
    meter.charge(record)
    assert (record.wall_s, record.cpu_s) == (10.0, 5.0)
    assert [(name, phase["wall_s"]) for name, phase in record.phases.items()] == [
        ("mesh", 2.0), ("report", 1.0), ("other", 7.0),
    ]  # fmt: skip


def test_the_record_as_json_leaves_out_what_a_run_does_not_have() -> None:
    path = PathFigures(Status.PARTIAL, StopReason.APEX, cut_backs_at=GIVEN_UP, contact_rings=None)
    data = json.loads(RunRecord(Status.PARTIAL, paths={"pull": path}).as_json())
    assert (data["status"], data["stopped_by"], data["failures"]) == ("partial", None, [])
    assert not {"checkpoints", "error_estimate", "target_error", "balance", "files"} & set(data)
    pull = data["paths"]["pull"]
    assert (pull["status"], pull["reason"], pull["contact_rings"]) == ("partial", "apex", None)
    assert pull["cut_backs_at"][0]["place"] == "node 7"
    assert not {"water", "increments_of_dead_load"} & set(pull)
    assert not {"harmonics", "azimuths"} & set(data["mesh"]) and not {"unit_s"} & set(data["solver"])
    checkpoints = CheckpointCost(3, 0.1, 0.01)
    assert RunRecord(Status.COMPLETE, checkpoints=checkpoints).as_dict()["checkpoints"]["written"] == 3


def test_peak_memory_is_that_of_this_process() -> None:
    assert 20e6 < peak_memory_bytes() < 50e9


def test_a_record_is_read_as_it_was_written(tmp_path: Path) -> None:
    cut = CutBack("path", 0.5, "slow", "node 7", 9, [0.1])
    stopped = PathFigures(Status.PARTIAL, StopReason.APEX, cut_backs_at=[cut], water={"film_m3": 1.0})
    whole = RunRecord(
        Status.PARTIAL, StopReason.OUT_OF_MEMORY, ["why"], mesh=MeshFigures("coarse", harmonics=5),
        solver=SolverFigures(unit_s=0.5), paths={"pull": stopped}, checkpoints=CheckpointCost(1, 0.5, 0.1), files=["a"],
    )  # fmt: skip
    (tmp_path / "run.json").write_text(whole.as_json(), encoding="utf-8")
    read = RunRecord.read(tmp_path)
    assert read == whole
    assert read is not None and read.reasons == [StopReason.APEX]
    assert RunRecord.from_dict(json.loads(whole.as_json()) | {"of a later version": 1}) == whole


@pytest.mark.parametrize("text", ["", "{", "[]", "7", '{"status": "never"}', '{"paths": [1]}', '{"mesh": "coarse"}'])
def test_a_broken_record_is_none(text: str, tmp_path: Path) -> None:
    (tmp_path / "run.json").write_text(text, encoding="utf-8")
    assert RunRecord.read(tmp_path) is None


def test_a_result_carries_its_record() -> None:
    record = RunRecord.of(tiny.result())
    assert record is not None and record.complete
    assert record.as_dict() == record_of(tiny.result())
