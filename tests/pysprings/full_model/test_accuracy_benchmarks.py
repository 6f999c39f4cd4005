# SPDX-License-Identifier: MIT
"""What the benchmarks of cost and of error estimates make of their runs: ratios, exponents, coverage."""

import math
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

import pysprings
from benchmarks import bench, error_estimates
from pysprings import Scene
from pysprings.core.errors import PyspringsError
from pysprings.full_model.run_record import Computed, RunRecord, Status
from tests.support import tiny
from tests.support.synthetic import Path as Pull, make_result


def run(unknowns: int, wall: float, unit: float) -> RunRecord:
    return RunRecord.from_dict({
        "mesh": {"unknowns": unknowns}, "wall_s": wall, "paths": {"pull": {"increments": 23}},
        "solver": {"factorisations": 15, "solves": 820, "unit_s": unit, "peak_before_unit_bytes": 0.94e9},
        "phases": {"assembly": {"wall_s": 0.25 * wall}, "solve": {"wall_s": 0.75 * wall}},
    })  # fmt: skip


def test_exponents_of_a_power_law_and_of_its_end() -> None:
    n = [1e3, 4e3, 2e4]
    assert bench.exponents(n, [7.0 * x**1.5 for x in n]) == pytest.approx((1.5, 1.5))
    fitted, last = bench.exponents([1.0, 10.0, 100.0], [1.0, 10.0, 1000.0])
    assert last == pytest.approx(2.0)
    assert fitted == pytest.approx(1.5)  # of 0, 1, 3 over 0, 1, 2 by hand


def test_a_run_in_units_and_shares() -> None:
    first, second = bench.text_of("paper", run(52_099, 37.0, 0.5)).splitlines()
    assert "52,099 unknowns" in first and "37.0 s" in first and "74.0 units" in first and "0.94 GB" in first
    assert second.strip() == "solve 75 %, assembly 25 %"


def test_cost_per_unknown_of_two_meshes_is_that_of_the_second_over_the_first(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    runs = {"a": run(1_000, 2.0, 1.0), "b": run(3_000, 12.0, 1.0)}
    monkeypatch.setattr(bench, "record", lambda mesh, _end, _mode: runs[mesh])
    bench.measure([("a", 1e-3, "drained"), ("b", 1e-3, "drained")])
    assert "cost per unknown: 2.00 times that of the first" in capsys.readouterr().out


def test_meshes_of_the_benchmark_are_scenes() -> None:
    assert set(bench.GROWTH) >= {"drained", "coupled"}
    for mode, meshes in bench.GROWTH.items():
        assert len(meshes) > 1
        for mesh in meshes:
            found = bench.scene(mesh, 1e-3, mode)
            assert found.drainage.mode == mode
            assert found.paths[0].lateral_displacement == 1e-3


def test_results_are_kept_by_scene_and_version(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    attrs = {"status": "complete", "pysprings_version": pysprings.__version__}

    def compute(scene: Scene) -> Computed:
        asked.append(scene.title)
        found = make_result((Pull(steps=3),))
        found.attrs |= attrs
        return Computed(found, RunRecord(Status(attrs["status"]), failures=["stuck"]))

    monkeypatch.setattr(error_estimates, "compute", compute)
    for _ in range(2):
        error_estimates.result_of(tiny.paper(title="a"), tmp_path)
    assert asked == ["a"]
    monkeypatch.setattr("pysprings.core.version.__version__", "99")
    attrs |= {"pysprings_version": "99", "status": "partial"}
    for _ in range(2):
        with pytest.raises(PyspringsError, match="stuck"):
            error_estimates.result_of(tiny.paper(title="a"), tmp_path)
    assert asked == ["a", "a"]
    attrs |= {"status": "interrupted"}
    with pytest.raises(KeyboardInterrupt):
        error_estimates.result_of(tiny.paper(title="b"), tmp_path)
    assert len(list(tmp_path.iterdir())) == 1


def lines(*each: tuple[float, float], scene: str = "a", quantity: str = "load_max") -> list[dict[str, Any]]:
    """Lines of true errors and estimates, made with a safety factor of 3."""
    return [
        {"scene": scene, "mesh": "coarse"} | error_estimates.line_of(quantity, estimate, true, 0.1, 3.0)
        for true, estimate in each
    ]


def test_coverage_counts_and_says_which_factor_nine_in_ten_need() -> None:
    """Of true errors from 1 to 10 an estimate of 8.5 covers 8; another scene stopped, a truth is not known."""
    found = [*lines(*((float(k), 8.5) for k in range(1, 11))), {"scene": "b", "mesh": "coarse", "why": "stopped"}]
    found += [*lines((math.nan, 1.0)), *lines((1.0, 2.0), quantity="py_rms"), *lines((math.nan, 2.0), scene="later-1")]
    load, py = error_estimates.coverage(pd.DataFrame(found)).to_dict("records")
    assert load == {
        "quantity": "load, coarse", "estimates": 10, "true error covered": 8,
        "median of estimate over true error": pytest.approx(0.5 * (8.5 / 5.0 + 8.5 / 6.0)),
        "median of true error [%]": 5.5, "largest true error [%]": 10.0,
        "safety that nine of ten need": pytest.approx(3.0 * 9.0 / 8.5),
        "safety that all need": pytest.approx(3.0 * 10.0 / 8.5),
    }  # fmt: skip
    assert py["quantity"] == "p-y, coarse" and py["estimates"] == 1


def test_the_table_counts_scenes_drawn_afterwards_apart() -> None:
    both, later = error_estimates.coverage(
        pd.DataFrame(lines((3.0, 2.0)) + lines((1.0, 2.0), scene="later-1"))
    ).to_dict("records")
    assert [*both.values()][:6] == ["load, coarse", 2, 1, pytest.approx(4.0 / 3.0), 2.0, 3.0]
    assert [*later.values()][:6] == ["load, coarse, drawn afterwards", 1, 1, 2.0, 1.0, 1.0]


@pytest.mark.parametrize(("estimate", "true", "factor"), [(2.0, 4.0, 6.0), (0.0, 0.0, 0.0), (0.0, 1.0, math.inf)])
def test_safety_that_is_needed(estimate: float, true: float, factor: float) -> None:
    assert error_estimates.line_of("load_max", estimate, true, 0.0, 3.0)["needed"] == factor


def test_held_out_scenes_are_scenes_and_are_pushed_as_far_as_asked() -> None:
    assert error_estimates.SCENES
    for name in error_estimates.SCENES:
        whole, half = error_estimates.scene_of(name, 1.0), error_estimates.scene_of(name, 0.5)
        for key in ("lateral_displacement", "rotation"):
            far = getattr(whole.paths[0], key)
            assert (far is None) == (getattr(half.paths[0], key) is None)
            if far is not None:
                assert getattr(half.paths[0], key) == pytest.approx(0.5 * far)
