# SPDX-License-Identifier: MIT
"""Parts of a path that change the vertical load: V is the one given, what is imposed stays, energy balances."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

from fe_engine.errors import NotConverged
from fe_engine.solve.newton import Increment, Newton
from fe_engine.state import State
from pysprings import Scene
from pysprings.full_model import paths
from pysprings.full_model.compute import compute
from pysprings.full_model.run_record import LimitLoad
from tests.support import tiny
from tests.support.files import record_of

SERIES = {"discretisation": "fourier", "preset": "coarse", "refinement": 0.7, "harmonics": 2}
STICKS = {"friction_coefficient": 5.0}
ELASTIC = {"yield_surface": "elastic", "K0": 1.0, "surcharge": 1e6}
MOTIONS: dict[str, dict[str, Any]] = {
    "pull": {"lateral_displacement": 0.2e-3, "arm": 5.0},
    "translation": {"lateral_displacement": 0.2e-3, "rotation": 2e-5},
    "rotation": {"rotation": 5e-5},
    "swipe": {"lateral_displacement": 0.2e-3, "rotation": 2e-5},
    "load": {"lateral_force": 2e5, "arm": 5.0},
}


def scene(*then: str, kind: str = "pull", **sections: Any) -> Scene:
    """Return a path of the tiny scene, as a series, which goes on."""
    path = {"name": "path", "kind": kind, "role": "held-back", "then": then, **MOTIONS[kind]}
    return tiny.scene(mesh=SERIES).replace(paths=(path,), **sections)


def ran(given: Scene) -> tuple[xr.Dataset, dict[str, Any]]:
    """Return the recorded path of a run, and its figures."""
    result = compute(given).recorded()
    assert result.attrs["status"] == "complete"
    return result["paths/path"].to_dataset(), record_of(result)["paths"]["path"]


def under(path: xr.Dataset, load: float) -> np.ndarray:
    """Return the states under a vertical load (N)."""
    found = np.flatnonzero(np.abs(path["V"].values - load) < 1e-4 * abs(load))
    assert found.size
    return found


@pytest.mark.parametrize("kind", list(MOTIONS))
def test_v_is_the_one_given_and_the_lateral_motion_stays(kind: str) -> None:
    """Through a part of sand that yields; the part after it begins where the first one ended, under the new V."""
    path, figures = ran(scene("V 1.2 MN", kind=kind))
    start = float(path["V"][0])
    assert abs(start - 1.2e6) > 1e5
    first, last = under(path, start)[-1], path.sizes["step"] - 1
    np.testing.assert_allclose(path["V"][: first + 1], start, rtol=1e-5)
    assert float(path["V"][-1]) == pytest.approx(1.2e6, rel=1e-5) and last > first + 2
    held = {"pull": ("u",), "load": ("H", "M")}.get(kind, ("u", "rotation"))
    for name in held:
        scale = float(np.abs(path[name]).max())
        np.testing.assert_allclose(path[name][first:], path[name][first], rtol=1e-4, atol=1e-4 * scale)
    if kind == "pull":
        np.testing.assert_allclose(path["M"][first:], 5.0 * path["H"][first:], rtol=1e-3)
    assert float(path["w"][-1]) > float(path["w"][first]) + 1e-5
    assert figures["energy"]["imbalance_over_largest_term"] < 1e-6


def test_parts_after_it_keep_the_new_load() -> None:
    path, figures = ran(scene("V 1.2 MN", "-0.1 mm", "V 0.9 MN", "0.1 mm"))
    u, V = path["u"].values, path["V"].values
    loads = {round(float(load), -4) for load in V[np.flatnonzero(np.abs(np.diff(u)) > 1e-9) + 1]}
    assert loads == {round(float(V[0]), -4), 1.2e6, 0.9e6}
    assert V[-1] == pytest.approx(0.9e6, rel=1e-4) and u[-1] == pytest.approx(1e-4)
    assert figures["energy"]["imbalance_over_largest_term"] < 1e-6


def test_an_elastic_caisson_that_sticks_comes_back() -> None:
    """Back to the first V: w, H and rotation of the state before."""
    path, _ = ran(scene("V 3 MN", "V 9 MN", "V 3 MN", soil=ELASTIC, interface=STICKS))
    before, after = under(path, 3e6)[0], path.sizes["step"] - 1
    assert before < after and float(path["V"][-1]) == pytest.approx(3e6, rel=1e-6)
    for name in ("w", "H", "rotation", "u"):
        found = path[name].values
        assert found[after] == pytest.approx(found[before], rel=1e-6)
    w, most = path["w"].values, int(np.argmax(path["V"].values))
    assert w[most] - w[before] > 1e-5


@pytest.mark.parametrize("kind", ["pull", "translation"])
def test_a_load_that_the_soil_does_not_carry_is_a_limit_load(kind: str) -> None:
    """Pulled out on its way: the vertical force is given there, though the lateral motion is imposed."""
    path, figures = ran(scene("V -3 MN", kind=kind, interface={"friction_coefficient": 0.05}))
    assert figures["status"] == path.attrs["status"] == "limit load"
    assert figures["limit_load"]["criterion"].startswith("limit load: ")
    assert -3e6 < float(path["V"][-1]) < float(path["V"][0])


def test_pull_out_ends_as_a_limit_load_at_its_first_failed_attempt(monkeypatch: pytest.MonkeyPatch) -> None:
    """V of a path that goes on to its end is no more than 0.5 % larger. The attempt is made to fail, once a run."""
    path = {"name": "path", "kind": "vertical", "vertical_displacement": -10e-3}
    mesh = SERIES | {"refinement": 1.0, "harmonics": 1}
    free = {"first_step_fraction": None, "max_step_fraction": None, "tolerance": 1e-4}
    given = tiny.scene(mesh=mesh, solver=free).replace(paths=(path,))
    solve, failed = Newton.solve, []

    def fails(self: Newton, state: State, *rest: Any, **more: Any) -> Increment:
        if state.committed.border[1] < -8.5e-3 and not failed:
            failed.append(state.committed.border[1])
            raise NotConverged("made to fail", "", [])
        return solve(self, state, *rest, **more)

    monkeypatch.setattr(Newton, "solve", fails)
    ended, record = ran(given)
    assert record["status"] == "limit load" and record["cut_backs"] >= 1
    limit = LimitLoad(**record["limit_load"])
    assert limit.is_vertical and str(limit).startswith("V = -18")
    assert float(ended["w"][-1]) >= failed.pop() > -10e-3
    monkeypatch.setattr(paths, "FLAT", -np.inf)
    whole, record = ran(given)
    assert record["status"] == "complete" and float(whole["w"][-1]) == pytest.approx(-10e-3)
    assert float(whole["V"].min()) == pytest.approx(float(ended["V"].min()), rel=5e-3)
