# SPDX-License-Identifier: MIT
"""Coupled and undrained scenes in Fourier series: film, balances, fields, limits of the rate, resume, forecast."""

import json
from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr

from fe_engine.assembly.fourier_pattern import make_pattern
from fe_engine.clock import Clock
from fe_engine.solve.step_size import GROWTH
from fe_engine.state import State
from pysprings.core import variables
from pysprings.full_model.checkpoint import Checkpoints
from pysprings.full_model.compute import compute, run
from pysprings.full_model.work import newton_of
from pysprings.model import water
from pysprings.model.contact import SURFACE
from pysprings.model.forecast.resources import size_of
from pysprings.model.fourier import build_fourier
from pysprings.model.stages import fast_paths
from pysprings.model.water import undrained_time
from pysprings.scene.model import Scene
from pysprings.scene.sections import PAPER
from pysprings.springs.checks import extract_springs
from pysprings.springs.sums import balance
from tests.support import tiny

SERIES: dict[str, Any] = {"discretisation": "fourier", "preset": "coarse", "refinement": 0.7, "harmonics": 2}

STEPS = {"first_step_fraction": 0.1, "max_step_fraction": 0.1}  # the same with and without water


def wet(mode: str = "coupled", rate: float = 1e-4, drainage: dict | None = None, **sections: Any) -> Scene:
    """The tiny scene with water, as a series."""
    return tiny.wet(mode, rate, drainage).replace(mesh=SERIES, **sections)


@cache
def coupled() -> xr.DataTree:
    return compute(wet(output={"paraview": True}, drainage={"mode": "coupled", "water_depth": 0.0})).recorded()


def load(result: xr.DataTree) -> float:
    return float(result["paths/pull/H"][-1])


# --- the film ---


def test_the_film_is_one_line_from_mudline_to_the_axis_with_the_area_of_the_caisson() -> None:
    built = build_fourier(wet())
    model, mesh, water = built.model, built.section.mesh, built.model.water
    assert water is not None and water.film is not None
    film, stations = water.film, model.stations
    r, z = mesh.nodes[mesh.corners[film.soil]].T
    assert len(np.unique(film.soil)) == film.n_nodes
    ends = {tuple(pair) for pair in film.ends}
    assert len(ends) == film.n_nodes - 1  # pieces of one line
    reached, last = {0}, 0
    while len(reached) != last:
        last = len(reached)
        reached |= {b for a, b in ends if a in reached} | {a for a, b in ends if b in reached}
    assert len(reached) == film.n_nodes
    # ends: mudline outside, which drains, and the axis under the lid
    assert film.area.sum() == pytest.approx(stations.area.sum(), rel=1e-12)
    np.testing.assert_allclose(film.weight.sum(axis=1), 1.0)
    at = 0.5 * (r[film.nodes].sum(axis=1)), 0.5 * z[film.nodes].sum(axis=1)
    np.testing.assert_allclose(at, mesh.nodes[stations.nodes[:, 0]].T, atol=1e-12)
    fixed = water.fixed[len(mesh.corners) :]
    np.testing.assert_allclose([r[fixed], z[fixed]], [[3.9], [0.0]])


def test_flow_points_follow_linear_pressures_along_the_walls_and_around() -> None:
    built = build_fourier(wet())
    model, mesh, water = built.model, built.section.mesh, built.model.water
    assert water is not None and water.film is not None
    film = water.film
    r, z = mesh.nodes[mesh.corners[film.soil]].T
    along = np.sum(film.slope * z[film.ends], axis=1)  # p = z
    upright = np.isin(model.stations.surface[film.station], (SURFACE["outer"], SURFACE["inner"]))
    np.testing.assert_allclose(np.abs(along), upright.astype(float), atol=1e-12)
    np.testing.assert_allclose(np.sum(film.over_radius * r[film.ends], axis=1), 1.0)  # p = r sin(theta) around
    tip = film.station[(z[film.ends] == 4.0).all(axis=1)]
    assert len(tip) > 0 and np.all(model.stations.surface[tip] == SURFACE["tip"])


# --- a run ---


def test_a_run_has_the_datasets_of_bricks_and_balances() -> None:
    tree = coupled()
    bricks = compute(tiny.wet(drainage={"water_depth": 0.0}).replace(output={"paraview": True})).recorded()
    assert tree.attrs["status"] == "complete"
    assert variables.tree_problems(tree, "result") == []
    path, other = tree["paths/pull"].to_dataset(), bricks["paths/pull"].to_dataset()
    assert set(path.data_vars) == set(other.data_vars)
    assert float((np.abs(path["water_imbalance"][1:]) / path["water_moved"][1:]).max()) < 1e-8
    record = json.loads(tree.attrs["run_json"])["paths"]["pull"]
    assert record["water"]["worst_imbalance_over_exchanged"] < 1e-8
    assert record["energy"]["imbalance_over_largest_term"] < 1e-3
    assert 0.4 < float(path["F_pw"][-1]) / float(other["F_pw"][-1]) < 2.5
    assert float(path["cavitation_margin"][-1]) == pytest.approx(float(other["cavitation_margin"][-1]), rel=0.1)


def test_water_is_a_part_of_the_reactions() -> None:
    path = coupled()["paths/pull"].to_dataset()
    assert float(np.abs(path["p_component"].sel(component="water")).max()) > 1.0
    np.testing.assert_allclose(path["p_component"].sum(["side", "component"]).T, path["p"].T, rtol=1e-10)
    parts = path["H_outer"] + path["H_inner"] + path["H_lid"] + path["H_tip"]
    np.testing.assert_allclose(parts, path["H"], rtol=1e-9, atol=1e-3)
    np.testing.assert_allclose(path["V"], float(path["V"][0]), rtol=1e-5)
    springs = extract_springs(coupled())
    assert max(balance(springs["paths/pull"].to_dataset()).values()) < 1e-9


def test_rows_of_water_are_the_pressure_on_the_walls() -> None:
    """p_w by depth from the pressures around the ring, whose product with cos(theta) is integrated exactly."""
    path = coupled()["paths/pull"].isel(step=-1).to_dataset()
    angle = path["azimuth"].values
    weight = np.full(len(angle), angle[1])
    weight[[0, -1]] *= 0.5
    water = path["p_component"].sel(component="water").transpose("side", "depth").values
    for i, (radius, sign) in enumerate(((3.9, 1.0), (3.8, -1.0))):
        pressure = path["pore_pressure"].isel(side=i).transpose("azimuth", "depth").values
        lateral = sign * 2.0 * radius * (weight * np.cos(angle)) @ pressure
        np.testing.assert_allclose(water[i], lateral, rtol=0.02, atol=0.02 * np.abs(water).max())


def test_pressures_in_the_plane_are_those_of_the_volume() -> None:
    tree = coupled()
    path = tree["paths/pull"].isel(step=-1)
    x, z = tree["section"]["section_x"].values, tree["section"]["section_depth"].values
    volume = np.stack([tree["volume"][f"volume_{a}"].values for a in "xyz"], axis=1)
    picked = np.flatnonzero(np.abs(x) > 2.0)[::7]
    assert len(picked) > 5
    for k in picked:
        same = np.argmin(np.linalg.norm(volume - [x[k], 0.0, z[k]], axis=1))
        found, wanted = path["section_pore_pressure"].values[k], path["volume_pore_pressure"].values[same]
        assert found == pytest.approx(wanted, rel=1e-5, abs=1e-6)
    free = (z == 0.0) & (np.abs(x) > 3.95)
    assert free.any() and np.all(path["section_pore_pressure"].values[free] == 0.0)
    assert float(path["pressure_max"]) >= path["section_pore_pressure"].values.max() > 0.0
    assert float(path["pressure_min"]) <= path["section_pore_pressure"].values.min() < 0.0


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*faster than water crosses")
def test_a_slow_push_is_drained_and_a_fast_one_undrained() -> None:
    drained, undrained = load(run(tiny.scene(mesh=SERIES).replace(solver=STEPS))), load(run(wet("undrained")))
    assert undrained > 1.02 * drained
    assert load(run(wet(rate=1e-10, solver=STEPS))) == pytest.approx(drained, rel=1e-4)
    assert load(run(wet(rate=10.0))) == pytest.approx(undrained, rel=0.03)
    assert drained < load(coupled()) < undrained


def test_undrained_is_the_fast_limit_but_for_the_element_that_mudline_drains(monkeypatch: pytest.MonkeyPatch) -> None:
    """Translation in a microsecond: what zero pressure at mudline takes falls with the height of the first element."""

    def translated(mode: str, refinement: float) -> Scene:
        path = {"name": "pull", "kind": "translation", "lateral_displacement": 1e-5}
        timed = path | ({"duration": 1e-6} if mode == "coupled" else {})
        return wet(mode).replace(mesh=SERIES | {"refinement": refinement}, paths=(timed,))

    def both(mode: str, refinement: float) -> np.ndarray:
        path = compute(translated(mode, refinement)).recorded()["paths/pull"]
        return np.array([path["H"][-1], path["M"][-1]])

    off = {each: np.abs(both("coupled", each) / both("undrained", each) - 1.0) for each in (0.7, 1.4)}
    assert np.all(off[0.7] > 1e-3) and np.all(off[1.4] < 0.7 * off[0.7])
    (remark,) = fast_paths(translated("coupled", 0.7), build_fourier(wet()).section.mesh)
    assert "'pull'" in remark and fast_paths(wet(), build_fourier(wet()).section.mesh) == []
    monkeypatch.setattr(water, "drained_corners", lambda _, section: np.zeros(len(section.mesh.corners), dtype=bool))
    np.testing.assert_allclose(both("coupled", 0.7), both("undrained", 0.7), rtol=1e-5)


def test_each_layer_has_its_own_conductivity() -> None:
    layers = (
        {"top": 0.0, "name": "above", "hydraulic_conductivity": 1e-4},
        {"top": 2.0, "name": "below", "hydraulic_conductivity": 1e-9},
    )
    given = wet(soil={"layers": layers})
    model = build_fourier(given).model
    depth = model.mesh.nodes[model.mesh.quads[:, :4]].mean(axis=1)[:, 1]
    assert model.water is not None
    np.testing.assert_allclose(model.water.mobility, np.where(depth < 2.0, 1e-4, 1e-9) / 9.81e3, rtol=1e-3)
    assert load(run(given)) > 1.001 * load(coupled())


@pytest.mark.parametrize("mode", ["coupled", "undrained"])
def test_a_stopped_run_goes_on_to_the_same_result(mode: str, tmp_path) -> None:
    given, left = wet(mode), 4

    def stop(path: str, fraction: float, message: str) -> None:
        nonlocal left
        left -= path != "model"
        if left == 0:
            raise KeyboardInterrupt

    whole = compute(given).recorded()
    stopped = compute(given, progress=stop, checkpoints=Checkpoints(tmp_path)).recorded()
    assert stopped.attrs["status"] == "interrupted"
    resumed = compute(given, checkpoints=Checkpoints(tmp_path), resume=True).recorded()
    xr.testing.assert_identical(whole["paths/pull"].to_dataset(), resumed["paths/pull"].to_dataset())


def test_increments_of_a_millionth_of_a_millimetre_converge() -> None:
    """The time step falls with the increment: what a residual leaves of volumes must not become a pressure."""
    tree = compute(wet(solver={"first_step_fraction": 2e-6, "max_step_fraction": 0.5})).recorded()
    record = json.loads(tree.attrs["run_json"])["paths"]["pull"]
    assert float(tree["paths/pull"]["u"][1]) == pytest.approx(1e-9, rel=1e-6)
    assert (tree.attrs["status"], record["cut_backs"]) == ("complete", 0)
    assert load(tree) == pytest.approx(load(coupled()), rel=2e-3)
    time = tree["paths/pull/time"].values  # whatever the first, the same steps as on other paths up to the end
    powers = np.log(np.diff(time)[1:-3]) / np.log(GROWTH)
    np.testing.assert_allclose(powers, powers[0].round() + np.arange(len(powers)), atol=1e-6)


@pytest.mark.parametrize("side", ["sealed", "drained"])
@pytest.mark.parametrize("mode", ["coupled", "undrained"])
def test_unknowns_are_counted_before_a_model_is_built(mode: str, side: str) -> None:
    given = wet(mode, domain={"side_drainage": side})
    model = build_fourier(given).model
    size = size_of(given)
    assert size.unknowns == make_pattern(model).n_unknowns + model.n_border
    assert 0 < size.film_pressures < size.pore_pressures


# --- stiffness at once ---


def stiffness(scene: Scene) -> np.ndarray:
    """K_H, K_C, K_M and K_free of the whole caisson in MN and m."""
    result = compute(scene.replace(paths=({**tiny.PULL, "lateral_displacement": 1e-7, "rate": 1e-4},))).recorded()
    k = result["stiffness_initial"].values / 1e6
    return np.array([k[0, 0], k[0, 2], k[2, 2], k[0, 0] - k[0, 2] * k[2, 0] / k[2, 2]])


@pytest.mark.parametrize("mode", ["coupled", "undrained"])
def test_undrained_stiffness_is_that_of_incompressible_soil(mode: str) -> None:
    """Axisymmetric mixed elements at nu = 0.5, bonded, no thickness: 4,747.4, -10,968.6, 99,721 and 3,541 MN, m."""
    scene = tiny.sand(
        domain=PAPER, soil={"yield_surface": "elastic"}, caisson={"skirt_thickness": 1e-3},
        interface={"normal_stiffness": 1e11, "shear_stiffness": 1e11, "friction_coefficient": 5.0},
        mesh={"discretisation": "fourier", "preset": "medium", "harmonics": 1},
        drainage={"mode": mode, "water_bulk_modulus": "incompressible"},
        paths=({**tiny.PULL, "rate": 1e-4},), solver={"first_step_fraction": 1.0, "max_step_fraction": 1.0},
        output={"figures": False},
    )  # fmt: skip
    found = stiffness(scene)
    np.testing.assert_allclose(found, [4747.4, -10968.6, 99721.0, 3541.0], rtol=6e-3)
    assert found[3] == pytest.approx(3541.0, rel=3e-3)


def test_a_long_step_has_the_drained_stiffness() -> None:
    slow, drained = wet(), tiny.scene(mesh=SERIES)
    found = []
    for each, time in ((slow, 1e12), (drained, 0.0), (slow, undrained_time(slow, build_fourier(slow).section.mesh))):
        built = build_fourier(each)
        newton = newton_of(each, built, Clock())
        newton.system.time_step = time
        found.append(newton.border_stiffness(State(built.model)))
    np.testing.assert_allclose(found[0], found[1], rtol=1e-6, atol=1e-6 * np.abs(found[1]).max())
    assert found[2][0, 0] > 1.05 * found[1][0, 0]
