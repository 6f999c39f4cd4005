# SPDX-License-Identifier: MIT
"""Runs with water through the tool: limits of the rate, what is written, rests, cavitation."""

import json
from functools import cache

import numpy as np
import pytest
import xarray as xr

from fe_engine.solve.globalisation import EXACT
from pysprings.full_model import work
from pysprings.full_model.cavitation import ATMOSPHERE, VAPOUR, Margin, smallest_margin, warning
from pysprings.full_model.compute import compute, run
from pysprings.model.build import build_model
from pysprings.model.stages import path_stages
from tests.support import tiny


@cache
def coupled() -> xr.DataTree:
    return run(tiny.wet())


def loads(result: xr.DataTree) -> np.ndarray:
    return result["paths/pull/H"].values


def test_water_is_a_part_of_the_reactions() -> None:
    path = coupled()["paths/pull"].to_dataset()
    water = path["p_component"].sel(component="water")
    assert float(np.abs(water).max()) > 1.0
    np.testing.assert_allclose(path["p_component"].sum(["side", "component"]).T, path["p"].T, rtol=1e-10)
    height = path["depth_bounds"].diff("bound").isel(bound=0)
    skirt = (path["p"] * height).sum("depth")
    np.testing.assert_allclose(skirt + path["H_lid"] + path["H_tip"], path["H"], rtol=1e-9, atol=1e-3)
    parts = path["H_outer"] + path["H_inner"] + path["H_lid"] + path["H_tip"]
    np.testing.assert_allclose(parts, path["H"], rtol=1e-9, atol=1e-3)


def test_vertical_equilibrium_holds_with_the_water_under_the_lid() -> None:
    path = coupled()["paths/pull"].to_dataset()
    assert float(path["F_pw"][-1]) != 0.0
    np.testing.assert_allclose(path["V"], float(path["V"][0]), rtol=1e-5)  # no vertical load is added


def test_time_and_volumes() -> None:
    path = coupled()["paths/pull"].to_dataset()
    assert float(path["time"][-1]) == pytest.approx(0.5e-3 / 1e-4)
    assert np.all(np.diff(path["time"]) > 0.0)
    imbalance = np.abs(path["water_imbalance"][1:]) / path["water_moved"][1:]
    assert float(imbalance.max()) < 1e-8
    summary = json.loads(coupled().attrs["run_json"])["paths"]["pull"]
    assert summary["water"]["worst_imbalance_over_exchanged"] < 1e-8
    assert sum(summary["steps_limited_by"].values()) == summary["increments"]


@pytest.mark.filterwarnings("ignore:.*faster than water crosses")
def test_a_slow_push_is_drained_and_a_fast_one_undrained() -> None:
    drained, undrained = loads(run(tiny.scene(paths=({**tiny.PULL, "rate": 1e-4},)))), loads(run(tiny.wet("undrained")))
    assert undrained[-1] > 1.02 * drained[-1]
    np.testing.assert_allclose(loads(run(tiny.wet(rate=1e-10))), drained, rtol=1e-4, atol=1.0)
    np.testing.assert_allclose(loads(run(tiny.wet(rate=10.0))), undrained, rtol=0.03, atol=1.0)
    assert drained[-1] < loads(coupled())[-1] < undrained[-1]


@pytest.mark.parametrize(("mode", "exact"), [("coupled", False), ("undrained", True)])
def test_linear_systems_are_solved_exactly_where_nothing_flows(
    monkeypatch: pytest.MonkeyPatch, mode: str, exact: bool
) -> None:
    seen = []
    monkeypatch.setattr(work, "Newton", lambda system, solver, settings: seen.append(settings) or 1 / 0)
    with pytest.raises(ZeroDivisionError):
        run(tiny.wet(mode))
    assert [settings.shares for settings in seen] == [(EXACT, EXACT) if exact else None]


def test_an_undrained_scene_needs_no_time() -> None:
    no_rate = tiny.wet("undrained", rate=None)  # type: ignore[arg-type]
    np.testing.assert_array_equal(loads(run(no_rate)), loads(run(tiny.wet("undrained"))))


def test_pressures_die_away_in_a_rest() -> None:
    result = run(tiny.wet(rate=1e-2, role="held-back", then=("rest 30 day",)))
    path = result["paths/pull"].to_dataset()
    end = int(np.argmax(path["u"].values >= 0.5e-3 * (1 - 1e-9)))
    assert float(path["u"][-1]) == pytest.approx(0.5e-3, rel=1e-12)
    assert float(path["pressure_max"][-1]) < 1e-4 * float(path["pressure_max"][end])
    assert float(path["time"][-1]) == pytest.approx(0.5e-3 / 1e-2 + 30 * 86400)
    assert float(path["H"][-1]) < float(path["H"][end])


def test_stages_follow_each_other() -> None:
    scene = tiny.wet(role="held-back", then=("rest 2 hour", "1 mm at 0.1 mm/s", "0 mm in 10 min"))
    stages = path_stages(scene, scene.paths[0], 0.0)
    assert [float(stage.target[0]) for stage in stages] == [0.5e-3, 0.5e-3, 1e-3, 0.0]
    assert [stage.duration for stage in stages] == pytest.approx([5.0, 7200.0, 5.0, 600.0])
    assert [stage.name for stage in stages] == ["pull", "pull, then 1", "pull, then 2", "pull, then 3"]
    assert stages[1].first_fraction < 1e-3


@pytest.mark.parametrize("mode", ["coupled", "undrained"])
def test_water_carries_a_vertical_load_that_comes_fast(mode: str) -> None:
    """Under the same V there is no pressure left where it takes ten days to come; without flow time counts nothing."""
    pressure = []
    for time in ("0.1 s", "10 day"):
        path = run(tiny.wet(mode, role="held-back", then=(f"V 1.2 MN in {time}",)))["paths/pull"].to_dataset()
        assert float(path["V"][-1]) == pytest.approx(1.2e6, rel=1e-4)
        pressure.append(float(path["pressure_max"][-1]))
    assert pressure[0] > 5e3
    assert pressure[1] == pressure[0] if mode == "undrained" else pressure[1] < 1e-4 * pressure[0]


def test_a_dead_load_is_drained() -> None:
    scene = tiny.wet().replace(caisson={"vertical_load": 1.5e6})
    path = run(scene)["paths/pull"].to_dataset()
    assert abs(float(path["pressure_max"][0])) < 1e-3
    assert float(path["V"][0]) == pytest.approx(1.5e6, rel=1e-5)


def test_suction_beyond_cavitation_is_warned_of_with_place_and_value() -> None:
    strong = {"water_depth": 0.0, "water_bulk_modulus": "incompressible"}
    scene = tiny.wet("undrained", drainage=strong).replace(soil={"cohesion": 1e6})
    path = {**tiny.PULL, "lateral_displacement": 20e-3}
    result = compute(scene.replace(paths=(path,))).recorded()
    (text,) = json.loads(result.attrs["run_json"])["warnings"]
    assert "would cavitate" in text and "z=" in text and "kPa" in text
    margin = result["paths/pull/cavitation_margin"].values
    assert margin[0] == pytest.approx(ATMOSPHERE - VAPOUR)
    assert margin.min() < 0.0
    deep = compute(scene.replace(paths=(path,), drainage={"water_depth": 5000.0})).recorded()
    assert json.loads(deep.attrs["run_json"])["warnings"] == []


@pytest.mark.parametrize(
    ("motion", "words"),
    [("u", "u = 2 mm on"), ("w", "w = 2 mm (V = -3000 kN) on"), ("rotation", "rotation = 0.1146 deg")],
)
def test_cavitation_is_named_by_the_motion_of_its_path(motion: str, words: str) -> None:
    zero, moved = np.array([0.0, 1e-17, -1e-17]), np.array([0.0, 2e-3, 4e-3])
    values = {name: moved if name == motion else zero for name in ("u", "w", "rotation")}
    values |= {"V": np.array([5e6, -3e6, -4e6]), "cavitation_margin": np.array([1e5, -1.0, -2.0])}
    states = xr.Dataset({name: ("step", each) for name, each in values.items()})
    margin = Margin(-1.0, -4.7e5, (-4.0, 0.0, 8.0))
    assert words in warning("pull_out", states, 8.0, margin)
    parts = {f"{to}_{axis}": share * states[name] for name, to in (("u", "u"), ("rotation", "rot"))
             for axis, share in (("x", 0.6), ("y", -0.8))}  # fmt: skip
    assert words in warning("pull_out", states.drop_vars(["u", "rotation"]).assign(parts), 8.0, margin)


def test_margin_of_cavitation() -> None:
    found = smallest_margin(np.array([[0.0, 0, 1], [2, 3, 4]]), np.array([0.0, -5e4]), 1e4, 10.0)
    assert found.place == (2.0, 3.0, 4.0)
    assert found.margin == pytest.approx(ATMOSPHERE - VAPOUR + 1e4 * 14 - 5e4)
    assert found.pressure == -5e4


def test_film_joins_lid_and_skirt_and_drains_at_mudline() -> None:
    built = build_model(tiny.wet())
    water, nodes = built.model.water, built.model.mesh.nodes
    assert water is not None and water.film is not None
    film_at = nodes[built.film_mesh_node]
    assert len(np.unique(built.film_mesh_node)) == water.film.n_nodes  # one film, not one for each surface
    drained = water.fixed[len(nodes) :]
    radius = np.hypot(film_at[:, 0], film_at[:, 1])
    assert np.all(film_at[drained, 2] == 0.0) and np.all(radius[drained] > radius[film_at[:, 2] == 0.0].max() - 1e-9)
    assert drained.sum() == built.caisson.walls["outside"].shape[0]
    stations = built.model.stations
    assert stations is not None
    area = np.zeros(water.film.n_nodes)
    np.add.at(area, water.film.nodes, water.film.weight * stations.area[:, None])
    assert area.sum() == pytest.approx(stations.area.sum())
    np.testing.assert_array_equal(film_at[water.film.nodes[:, 0]], nodes[stations.nodes[:, 0]])


def test_drained_carries_no_pressure() -> None:
    built = build_model(tiny.scene())
    assert built.model.water is None and len(built.film_mesh_node) == 0
    path = tiny.result()["paths/pull"]
    assert not {"water_moved", "pressure_min", "lid_pore_pressure"} & set(path.data_vars)
