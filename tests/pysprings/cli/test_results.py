# SPDX-License-Identifier: MIT
"""What is printed of a run, line by line, from a record that was made up."""

import re
from pathlib import Path
from typing import Any

import pytest

from pysprings.cli import results
from pysprings.core.errors import UserInputError
from pysprings.full_model.accuracy.measures import MEASURES
from pysprings.full_model.run_record import RunRecord

PATHS: dict[str, Any] = {
    "pull": {
        "status": "complete", "increments": 12, "iterations": 50, "median_iterations": 4.0, "max_iterations": 7,
        "cut_backs": 1, "iterations_in_cut_backs": 20, "worst_residual": 9.5e-6, "last_residual_ratio": 0.0123,
        "order_of_last_iterations": 1.96,
        "cut_backs_at": [
            {"place": "node 7 at x = 1 m", "load_fraction": 0.125, "stage": "path", "iterations": 20, "reason": "slow",
             "last_residuals": [0.5, 0.0123]}
        ],
        "contact_rings": {
            "alternation": 0.02468, "alternation_at": "outside, 1.5 m", "second_difference": 0.5,
            "second_difference_at": "", "isolated_open": 3, "stations": 99,
        },
        "energy": {
            "work_J": 1000.0, "initial_J": 2000.0, "elastic_J": 3000.0, "plastic_J": 4000.0, "penalty_J": 5000.0,
            "friction_J": 6000.0, "water_J": 7000.0, "imbalance_J": 8.0, "imbalance_over_largest_term": 8e-6,
        },
        "water": {
            "expelled_m3": 0.1, "compressed_m3": 0.2, "film_m3": 0.3, "outflow_m3": 0.4, "imbalance_m3": 5e-9,
            "worst_imbalance_over_exchanged": 6e-9, "pressure_min_Pa": -7000.0, "pressure_max_Pa": 80000.0,
        },
    },
    "turn": {"status": "partial", "increments": 1, "iterations": 5},
}  # fmt: skip
RECORD: dict[str, Any] = {
    "paths": PATHS, "wall_s": 3.456, "cpu_s": 6.5, "peak_memory_bytes": 250e6,
    "phases": {"mesh": {"wall_s": 0.125, "cpu_s": 0.25}, "solve": {"wall_s": 2.0}},
    "solver": {"factorisations": 9, "linear": "superlu"}, "mesh": {"nodes": 2000, "unknowns": 15000},
    "checkpoints": {"written": 4, "wall_s": 0.5, "share_of_wall": 0.0123},
    "resumed": [{"at_utc": "2026-01-31T00:00:00Z", "from": "path 'pull', step 3"}],
}  # fmt: skip


def lines(capsys: pytest.CaptureFixture[str]) -> list[str]:
    """The printed lines, with single spaces."""
    return [" ".join(line.split()) for line in capsys.readouterr().out.split("\n")]


def test_paths(capsys: pytest.CaptureFixture[str]) -> None:
    results.print_paths(RunRecord.from_dict(RECORD))
    found = [line for line in lines(capsys) if not re.match("[- ]*$|[A-Z].* [a-z].*[.]$", line)]
    assert found == [
        "Convergence:",
        "path status increments iterations median most cut-backs worst residual last ratio order",
        "pull complete 12 50 4 7 1 9.5e-06 0.0123 1.96",
        "turn partial 1 5 0 0 0 0 - -",
        "Attempts given up (cut-backs):",
        "path at iterations reason largest residual at last residuals",
        "pull 12.5 % of the path 20 slow node 7 at x = 1 m 0.5, 0.012",
        "Contact from station to station:",
        "path alternation largest second difference open stations between two loaded ones of stations",
        "pull 0.0247 (outside, 1.5 m) 0.5 3 99",
        "turn not measured: interface fields were not kept not measured: interface fields were not kept - -",
    ]
    results.print_paths(RunRecord.from_dict({"paths": {"turn": PATHS["turn"]}}))
    heads = ["Convergence:", "Contact from station to station:"]  # no cut-backs
    assert [line for line in lines(capsys) if line.endswith(":")] == heads


def test_many_cut_backs_are_cut_short(capsys: pytest.CaptureFixture[str]) -> None:
    one = {"place": "", "load_fraction": 1.0, "stage": "path", "iterations": 2, "reason": "no"}
    for count in (12, 15):
        results.print_paths(RunRecord.from_dict({"paths": {"a": {"cut_backs_at": [one] * count}}}))
        found = lines(capsys)
        assert found.count("a 100 % of the path 2 no - -") == 12
        assert [line for line in found if line.startswith("...")] == ["... and 3 more in run.json"] * (count == 15)


def test_water_and_energy(capsys: pytest.CaptureFixture[str]) -> None:
    results.print_balances(RunRecord.from_dict(RECORD))
    found = lines(capsys)
    assert found[:3] == [
        "",
        "Balance of the water:",
        "path expelled [m³] compressed [m³] in gaps [m³] outflow [m³] imbalance / exchanged pressure [kPa]",
    ]
    assert found[4] == "pull 0.1 0.2 0.3 0.4 6.0e-09 -7 to 80" and "expelled = compressed + in gaps" in found[5]
    assert found[6:9] == [
        "",
        "Balance of energy:",
        "path work [kJ] initial [kJ] elastic [kJ] plastic [kJ] penalty [kJ] friction [kJ] water [kJ] "
        "imbalance / largest",
    ]
    assert found[10] == "pull 1 2 3 4 5 6 7 8.0e-06" and "work + initial = elastic" in found[11]


def test_cost(capsys: pytest.CaptureFixture[str]) -> None:
    results.print_balances(RunRecord.from_dict({**RECORD, "paths": {}}))
    results.print_cost(RunRecord.from_dict(RECORD))
    found = lines(capsys)
    assert found[:3] == ["", "Cost by phase:", "phase wall [s] processor [s]"]
    assert found[4:] == [
        "mesh 0.12 0.25",
        "solve 2.00 -",
        "total 3.46 6.50",
        "",
        "3.46 s wall, 6.50 s CPU, 2,000 nodes, 15,000 unknowns; "
        "75 Newton iterations, those in cut-backs included; 9 factorisations (superlu); "
        "peak memory 250 MB",
        "checkpoints: 4 of paths, 0.50 s, 1.2 % of the time of the paths",
        "resumed 2026-01-31T00:00:00Z from path 'pull', step 3",
        "",
    ]


def test_target_and_estimate(capsys: pytest.CaptureFixture[str]) -> None:
    runs = [
        {"preset": "coarse", "refinement": 1.0},
        {"preset": "coarse", "refinement": 1.3, "load_max": 4.3, "py_rms": 1.0},
    ]
    target = {"target": "5%", "runs": runs, "missed": None}
    estimate = {"estimate_pct": {"load_max": 3.456, "py_rms": 2.0}, "unknowns": [12345, 6789], "safety": 1.5}
    results.print_estimate(RunRecord.from_dict({"target_error": target, "error_estimate": estimate}))
    load, py = (MEASURES[name].head for name in ("load_max", "py_rms"))
    assert capsys.readouterr().out.splitlines() == [
        "target error 5%: coarse, refinement 1: -",
        "target error 5%: coarse, refinement 1.3: load 4.3 %, p-y 1 %",
        f"estimated discretisation error: {load} 3.5 %, {py} 2 % (two meshes, 6,789 and 12,345 unknowns; "
        "safety factor 1.5 included)",
    ]
    results.print_estimate(RunRecord.from_dict({"error_estimate": estimate | {"harmonics": [5, 8]}}))
    assert "6,789 and 12,345 unknowns, 5 and 8 harmonics; safety" in capsys.readouterr().out
    nothing = {"estimate_pct": {}, "why_not": "no path in common"}
    results.print_estimate(RunRecord.from_dict({"error_estimate": nothing}))
    assert capsys.readouterr().out == "no estimate of the discretisation error: no path in common\n"


@pytest.mark.parametrize("show", ["paths", "balances", "cost", "estimate"])
def test_nothing_is_printed_of_what_is_not_there(show: str, capsys: pytest.CaptureFixture[str]) -> None:
    getattr(results, f"print_{show}")(RunRecord())
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize("text", [None, "{", "[]"])
def test_a_broken_record_is_refused_in_one_line(text: str | None, tmp_path: Path) -> None:
    if text is not None:
        (tmp_path / "run.json").write_text(text, encoding="utf-8")
    with pytest.raises(UserInputError) as refused:
        results.read_record(tmp_path)
    assert str(refused.value) == f"fatal: user input: {tmp_path}: run.json is missing or broken"
