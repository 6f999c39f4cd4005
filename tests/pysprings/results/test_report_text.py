# SPDX-License-Identifier: MIT
"""All that a report says of a run, line by line, in the stored texts; the numbers are tested in `test_report.py`."""

import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from pysprings.full_model.run_record import RunRecord, Status
from pysprings.macro.comparison import compare
from pysprings.results.report.inputs import ReportData
from pysprings.results.report.page import render
from tests.support import stored, synthetic, vertical
from tests.support.files import Outline

PATHS = (
    synthetic.Path("pull", arm=8.0, steps=8),
    synthetic.Path("turn", "rotation", size=2e-3, steps=6, role="held-back"),
)
ENERGY = ("work", "initial", "elastic", "plastic", "penalty", "friction", "water")
WATER = {
    "expelled_m3": 2e-3, "compressed_m3": 1e-4, "film_m3": 4e-4, "outflow_m3": 1.5e-3,
    "worst_imbalance_over_exchanged": 3e-12, "pressure_min_Pa": -7.9e3, "pressure_max_Pa": 1e2,
}  # fmt: skip
CUT_BACK = {
    "stage": "dead load", "load_fraction": 0.0625, "reason": "the residual stalls", "place": "node 7, direction z",
    "iterations": 9, "last_residuals": [0.0123, 0.5],
}  # fmt: skip
RINGS = {
    "alternation": 0.9142, "alternation_at": "outside, azimuth 90°", "second_difference": 1.8512,
    "second_difference_at": "", "isolated_open": 1, "stations": 442,
}  # fmt: skip
RUN = RunRecord.from_dict({
    "status": "partial",
    "started_utc": "2020-01-02T03:04:05Z",
    "failures": ["pull: stopped at 12 %"],
    "warnings": ["the domain is small", "water would cavitate"],
    "phases": {"mesh": {"wall_s": 0.2, "cpu_s": 0.3}, "factorisation": {"wall_s": 12.54, "cpu_s": 24.0, "calls": 7}},
    "wall_s": 33.25,
    "cpu_s": 61.5,
    "peak_memory_bytes": 512_000_000,
    "solver": {"factorisations": 77, "solves": 311, "worst_linear_residual": 3.21e-9, "tolerance": 1e-6},
    "python": "3.0",
    "platform": "a machine",
    "environment": {"numpy": "9.9"},
    "mesh": {"min_scaled_jacobian": 0.31, "max_aspect": 12.3, "interface_stations": 221},
    "left_out": [
        {"what": "installation", "why": "the caisson is wished in place", "saved": {}},
        {"what": "half", "why": "symmetry", "saved": {"basis": "counts", "unknowns": 4251, "memory_bytes": 40118655}},
    ],
    "paths": {
        "pull": {
            "status": "partial", "increments": 7, "iterations": 27, "median_iterations": 3.0, "max_iterations": 5,
            "cut_backs": 2, "worst_residual": 5e-8, "last_residual_ratio": 0.0123,
            "order_of_last_iterations": 1.98, "cut_backs_at": [CUT_BACK], "water": WATER,
            "energy": {f"{name}_J": 1e3 * (k + 2) for k, name in enumerate(ENERGY)}
            | {"imbalance_over_largest_term": 4e-9},
        },
        "turn": {"cut_backs_at": [{**CUT_BACK, "place": "", "last_residuals": []}], "contact_rings": RINGS},
    },
    "error_estimate": {
        "unknowns": [4000, 1500], "cell_ratio": 1.3867, "safety": 1.5, "order": {"load_max": 1.7, "py_rms": 1.2},
        "difference_pct": {"load_max": 4.0, "py_rms": 3.0}, "estimate_pct": {"load_max": 8.12, "py_rms": 9.5},
    },
})  # fmt: skip


def stopped() -> tuple[xr.DataTree, xr.DataTree]:
    """Two paths, one of which stopped before its end and has a step that did not converge."""
    result, springs = synthetic.make_result(PATHS), synthetic.make_springs(PATHS)
    for tree in (result, springs):
        tree["paths/pull"]["converged"][-1] = 0
        tree["paths/pull"].attrs["status"] = "partial"
    stress = result["paths/turn/normal_effective_stress"]
    stress[3, 0, 8, 4] = 0.0
    return result, springs


def down() -> tuple[xr.DataTree, xr.DataTree]:
    """Springs of rays and of a vertical path, in the place of a result that kept neither stresses nor a record."""
    springs = vertical.vertical_springs((1e-2,))
    result = springs.copy(deep=True)
    for path in result["paths"].children.values():
        steps = path.sizes["step"]
        path.dataset = path.to_dataset(inherit=False).assign(converged=("step", np.ones(steps, dtype=np.int8)))
    return result, springs


ROUNDING = re.compile(r"-?\d\.?\d*e-([1-9]\d)|0\.0e\+00")
NONE = RunRecord(Status.COMPLETE, error_estimate={"estimate_pct": {}, "why_not": "no path in common"})


@pytest.mark.parametrize(("made", "run"), [(stopped, RUN), (down, NONE)])
def test_all_that_a_report_says(made, run) -> None:
    result, springs = made()
    result.attrs["scene_toml"] = ""  # `test_report.py` has the inputs
    text = render(ReportData(result, springs, compare(springs), run))
    about = "the report of the caisson of tests/support/invented_soil.py"
    lines = [ROUNDING.sub("rounding", line) for line in Outline(text).lines]
    assert len(lines) > 100
    stored.compare(lines, Path(__file__).parent / "reports" / f"{made.__name__}.txt", about)
