# SPDX-License-Identifier: MIT
"""Paths through localised sand with `viscous_displacement`: they reach their ends, and loads before are the same."""

import numpy as np
import pytest
import xarray as xr

from pysprings.full_model.compute import compute
from pysprings.full_model.run_record import Computed
from pysprings.scene.model import Scene
from pysprings.studies.stability import CASES
from tests.support import tiny

CASE = next(each for each in CASES if each.name == "K0-0.3-strong")
END = 3e-3  # m; without viscosity the path stops at 1.2 mm
FEW = {"max_iterations": 4, "first_step_fraction": 0.5}  # the first attempt takes more
NONE = 1e-12  # m: no viscosity in steps of any size
STOPS = (0.1e-3, 0.5e-3, 1e-3, 2e-3)  # m


def strong(viscous: float | None, **solver: float) -> Scene:
    """Sand of 40 degrees without hardening, dilation and cohesion, K0 0.3, in a series of three harmonics."""
    scene = CASE.scene("coarse", END, "fourier")
    (path,) = (each.model_dump(exclude_none=True) | {"report_at": STOPS} for each in scene.paths)
    return scene.replace(
        mesh={"harmonics": 3, "refinement": 0.8}, solver={"viscous_displacement": viscous, **solver}, paths=[path]
    )


def loads(result: Computed) -> np.ndarray:
    """Return the loads at the stops that the path came to."""
    path = result.recorded()["paths/path"]
    return np.array([float(path["H"][np.argmin(np.abs(path["u"].values - u))]) for u in STOPS if u <= path["u"].max()])


@pytest.mark.slow
def test_a_path_that_localises_goes_on_and_its_loads_before_are_the_same() -> None:
    """Within 0.1 % in load; step sizes agree within 1 %; energy balances; without viscosity it stops."""
    scenes = strong(NONE), strong(None), strong(None, max_step_fraction=0.03)
    stopped, ran, finer = (compute(each) for each in scenes)
    assert stopped.record.failures and ran.record.failures == finer.record.failures == []
    before, after, other = loads(stopped), loads(ran), loads(finer)
    assert len(before) == 3 and len(after) == len(STOPS)
    np.testing.assert_allclose(after[:3], before, rtol=1e-3)
    np.testing.assert_allclose(other, after, rtol=1e-2)
    energy = ran.record.paths["path"].energy
    assert energy["imbalance_over_largest_term"] < 1e-4


def test_a_path_without_a_failed_attempt_has_no_viscosity() -> None:
    """Every number is that of the run without it, and nothing names it."""
    plain, other = (
        compute(tiny.scene(solver={"viscous_displacement": each})).recorded()["paths/pull"].to_dataset()
        for each in (NONE, 1e-5)
    )
    xr.testing.assert_identical(other, plain)


@pytest.mark.slow
def test_overstress_grows_with_the_viscous_displacement_once_an_attempt_has_failed() -> None:
    """Few iterations are allowed, so that attempts fail."""
    found = []
    for viscous in (NONE, 1e-7, 1e-5):
        few = {"viscous_displacement": viscous} | FEW
        path = compute(tiny.scene(solver=few)).recorded()["paths/pull"]
        assert path.attrs.get("viscous_displacement_m") == viscous
        found.append(float(path["H"][-1]))
    assert found[0] < found[1] < found[2]
    assert found[1] == pytest.approx(found[0], rel=2e-3)
