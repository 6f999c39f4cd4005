# SPDX-License-Identifier: MIT
"""Increments and wall time before a run: beside runs that were measured, and what they depend on."""

import json
from pathlib import Path
from typing import Any

import pytest

from pysprings import Scene
from pysprings.model.forecast.resources import memory_bytes
from pysprings.model.forecast.run_time import (
    least_increments,
    likely_increments,
    path_seconds,
    seconds,
    superlu_bytes,
    superlu_time,
    uses_superlu,
)
from tests.support import tiny
from tests.support.commands import command


def pull(end: float, **sections: Any) -> Scene:
    """The default scene, pulled to an end (m), without pictures."""
    path = {"name": "pull", "kind": "pull", "lateral_displacement": end, "rate": 5e-5}
    return tiny.paper(**{"output": {"figures": False}, "paths": [path]} | sections)


def test_least_increments_are_those_of_a_run_without_cut_backs() -> None:
    """Whose first row is the state at rest."""
    assert least_increments(tiny.scene()) == [tiny.result()["paths/pull"].sizes["step"] - 1]


@pytest.mark.parametrize(("largest", "measured"), [(0.3, 11), (0.1, 15), (None, 23), (0.02, 52)])
def test_least_increments_follow_the_largest_step(largest: float | None, measured: int) -> None:
    """The runs of docs/evidence/accuracy.md: to 2.5 mm, nothing cut."""
    assert least_increments(pull(2.5e-3, solver={"max_step_fraction": largest})) == [measured]


def test_least_increments_of_the_smallest_steps_and_of_several_stages() -> None:
    fine = tiny.scene(solver={"first_step_fraction": 1e-9, "max_step_fraction": 1e-8})
    assert 100_000_000 < least_increments(fine)[0] < 100_000_010
    there_and_back = tiny.PULL | {"role": "held-back", "then": ["0 mm", "1 mm"]}
    assert least_increments(tiny.scene(paths=[there_and_back])) == [3 * least_increments(tiny.scene())[0]]


def test_more_increments_are_likely_once_the_lid_lifts_off() -> None:
    """Measured: 23 to 2.5 mm on every mesh; 35 on `coarse` and 54 on `paper` to 20 mm."""
    assert likely_increments(pull(2.5e-3)) == [23.0]
    assert 35.0 < likely_increments(pull(20e-3))[0] < 54.0
    turn = [{"name": "turn", "kind": "rotation", "rotation": 5e-3}]
    assert likely_increments(pull(0.0025, paths=turn))[0] > least_increments(pull(0.0025, paths=turn))[0]


@pytest.mark.parametrize(
    ("unknowns", "end", "mode", "measured"),
    [
        (4_631, 2.5e-3, "drained", 2.38),
        (13_863, 2.5e-3, "drained", 5.2),
        (52_099, 2.5e-3, "drained", 21.6),
        (292_749, 2.5e-3, "drained", 264.0),
        (52_099, 20e-3, "drained", 80.0),
        (19_315, 2.5e-3, "coupled", 13.7),
        (71_241, 1.0e-3, "coupled", 53.0),
    ],
)
def test_time_is_what_was_measured(unknowns: int, end: float, mode: str, measured: float) -> None:
    """On two cores: `coarse`, `medium`, `paper` and `fine` drained, `medium` and `paper` coupled."""
    pytest.importorskip("pypardiso")  # measured with Pardiso
    assert seconds(pull(end, drainage={"mode": mode}), unknowns) == pytest.approx(measured, rel=0.15)


@pytest.mark.parametrize(
    ("unknowns", "end", "mode", "measured"),
    [
        (4_153, 2.5e-3, "drained", 0.49),
        (6_290, 2.5e-3, "drained", 0.70),
        (7_243, 2.5e-3, "drained", 0.83),
        (4_776, 2.5e-3, "coupled", 0.91),
        (7_183, 2.5e-3, "coupled", 1.43),
        (6_290, 20e-3, "drained", 2.10),
        (7_243, 20e-3, "drained", 2.45),
    ],
)
def test_time_of_a_series_is_what_was_measured(unknowns: int, end: float, mode: str, measured: float) -> None:
    """CPU seconds of one thread, N 3 at the default tolerance; start and error estimate are not in those."""
    scene = pull(end, drainage={"mode": mode}, mesh={"discretisation": "fourier", "preset": "paper"})
    assert (seconds(scene, unknowns) - 1.0) / 1.85 == pytest.approx(measured, rel=0.4)


def test_the_error_estimate_has_all_paths_and_four_of_a_fan_with_more_harmonics() -> None:
    mesh = {"discretisation": "fourier"}
    one, ten = (pull(0.0, paths=_turns(names), mesh=mesh) for names in ("a", "abcdefghij"))
    assert (seconds(ten, 9_000) - 1.0) / (seconds(one, 9_000) - 1.0) == pytest.approx(
        10 * (1.35 + 0.5 * 0.4) / 1.85, rel=1e-6
    )


def test_cost_grows_with_the_mesh_and_the_paths() -> None:
    small, large = 5_000, 50_000
    assert 10 * memory_bytes(small) > memory_bytes(large) > memory_bytes(small) > 0.2e9
    scene = tiny.paper(output={"figures": False})
    assert seconds(scene, small) < seconds(tiny.paper(), small)  # pictures take their time
    assert seconds(scene, large) > 10 * seconds(scene, small)  # more than in proportion
    two, one = (pull(0.0, paths=_turns(names)) for names in ("ab", "a"))
    assert seconds(two, large) == pytest.approx(2 * seconds(one, large), rel=0.05)
    assert seconds(scene.replace(soil={"yield_surface": "elastic"}), large) < seconds(scene, large)


def _turns(names: str) -> list[dict[str, Any]]:
    return [{"name": name, "kind": "rotation", "rotation": 1e-3} for name in names]


def test_water_costs_more_symmetric_factors_less_and_given_forces_what_motions_do() -> None:
    scene, n = pull(2.5e-3), 20_000
    assert seconds(scene, n, water=True) > 1.2 * seconds(scene, n) > 1.2 * seconds(scene, n, symmetric=True)
    load = pull(2.5e-3, paths=[{"name": "load", "kind": "load", "lateral_force": 1e6}])
    assert seconds(load, n) == pytest.approx(seconds(scene, n), rel=0.3)


# --- what SuperLU costs beside Pardiso: the laws beside runs that were measured, and what `check` prints ---

BRICKS = {"mesh": {"discretisation": "hex8"}, "solver": {"linear": "superlu"}}


@pytest.mark.parametrize(("unknowns", "ratio", "peak"), [(4_631, 11.9 / 4.1, 0.45e9), (13_863, 81.6 / 13.8, 1.08e9)])
def test_laws_are_near_what_was_measured(unknowns: int, ratio: float, peak: float) -> None:
    """Drained, to 2.5 mm, `coarse` and `medium`."""
    assert superlu_time(unknowns) == pytest.approx(ratio, rel=0.05)
    assert memory_bytes(unknowns) + superlu_bytes(unknowns) == pytest.approx(peak, rel=0.15)
    assert superlu_time(100) == 1.0


def test_a_series_uses_neither() -> None:
    assert uses_superlu(tiny.paper(**BRICKS))
    assert not uses_superlu(tiny.paper(solver={"linear": "superlu"}, mesh={"discretisation": "fourier"}))


def test_check_prints_what_the_extra_would_save(tmp_path: Path) -> None:
    scene = tiny.write(tiny.paper(**BRICKS), tmp_path / "bricks.toml")
    about = json.loads(command("check", scene, "--json").out)
    assert 0.0 < about["time_with_pardiso_s"] < about["time_s"]
    assert 0.0 < about["memory_with_pardiso_GB"] < about["memory_GB"]
    assert "time with Pardiso (extra mkl)" in command("check", scene).out
    assert "Pardiso" not in command("check", scene, "--discretisation", "fourier").out


def test_fits_of_springs_with_memory_take_their_time() -> None:
    """7 s a set, in space 18 s more; measured: 5.8 to 10 s, and 18."""
    fan = {"reach": 0.02, "held_back": False, "vertical": False, "rays": [0.0]}
    clay = {"yield_surface": "tresca", "undrained_shear_strength": 30e3, "rigidity_ratio": 200.0}
    plain, few, many = (
        Scene(soil=clay | {"effective_unit_weight": 7e3}, springs=fan | more, output={"figures": False},
              interface={"adhesion_factor": 0.5})
        for more in (
            {"vertical_loads": [3e6]}, {"memory": True}, {"memory": True, "vertical_loads": [3e6], "directions": True}
        )
    )  # fmt: skip
    of_paths = (seconds(plain, 5000) - 1.0) / sum(path_seconds(plain, 5000))
    fits = [seconds(each, 5000) - 1.0 - of_paths * sum(path_seconds(each, 5000)) for each in (few, many)]
    assert fits == pytest.approx([7.0, 32.0])
