# SPDX-License-Identifier: MIT
"""The law "sand" on bricks and in series, drained, undrained and coupled."""

from typing import Any

import pytest

from pysprings.full_model.compute import compute
from tests.support import tiny

SERIES = {"discretisation": "fourier", "harmonics": 3}
SAND = {"yield_surface": "sand", "relative_density": 0.6, "K0": 0.5, "surcharge": 10e3}


def load(mode: str = "drained", rate: float | None = None, end: float = 2e-3, mesh: dict[str, Any] | None = None):
    """H [N] at the end of a pull that reaches it, in a model whose energy is in balance."""
    pull = {**tiny.PULL, "lateral_displacement": end} | ({} if rate is None else {"rate": rate})
    base = {**tiny.SECTIONS["mesh"], **(mesh or {})}
    soil = {**SAND, "hydraulic_conductivity": 1e-4}
    result = compute(
        tiny.sand(**{**tiny.SECTIONS, "mesh": base, "soil": soil, "paths": (pull,)}, drainage={"mode": mode})
    )
    assert result.record.status == "complete"
    assert result.record.paths["pull"].energy["imbalance_over_largest_term"] < 1e-3
    return float(result.recorded()["paths/pull"]["H"][-1])


def test_bricks_are_within_a_twentieth_of_the_series():
    """On meshes of 0.6 of `coarse`: 4 % at 2 mm."""
    bricks, series = (load(mesh={"refinement": 0.6, **each}) for each in ({}, SERIES))
    assert bricks == pytest.approx(series, rel=0.05)


@pytest.mark.slow
def test_a_coupled_pull_is_drained_when_slow_and_undrained_when_fast():
    """A fast pull drains the element below mudline alone, which an undrained one does not: within 0.5 %."""
    drained, undrained = load(), load("undrained")
    slow, middle, fast = (load("coupled", rate) for rate in (1e-9, 1e-4, 10.0))
    assert slow == pytest.approx(drained, rel=1e-5) and fast == pytest.approx(undrained, rel=5e-3)
    assert drained < middle < fast and undrained > 1.01 * drained
