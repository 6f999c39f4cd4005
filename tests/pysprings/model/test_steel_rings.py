# SPDX-License-Identifier: MIT
"""The elastic caisson in Fourier series: fits the section, balances, is the rigid one where stiff, and near bricks."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import xarray as xr

from fe_engine.clock import Clock
from fe_engine.elements import fourier as elements
from fe_engine.solve.stepping import Driver
from fe_engine.state import State, initial_fields
from pysprings.full_model.compute import compute
from pysprings.full_model.fourier_collect import FourierCollector
from pysprings.full_model.work import newton_of
from pysprings.model.forecast import resources
from pysprings.model.forecast.estimate import describe
from pysprings.model.fourier import build, build_fourier
from pysprings.model.stages import path_stages
from pysprings.springs.checks import extract_springs
from pysprings.springs.path import paths_of
from pysprings.springs.sums import balance
from tests.support import tiny

SERIES = {"discretisation": "fourier", "preset": "coarse", "harmonics": 2}
LINEAR = {
    "soil": {"yield_surface": "elastic", "surcharge": 1e6},
    "interface": {"friction_coefficient": 5.0, "normal_stiffness": 1e10, "shear_stiffness": 1e10},
}


def scene(behaviour: str = "elastic", young: float = 200e9, mode: str = "drained", **sections):
    """The tiny scene as a series with elastic steel."""
    mesh = SERIES | {"refinement": 0.7} | sections.pop("mesh", {})
    caisson = {"behaviour": behaviour, "young_modulus": young}
    path = tiny.PULL | {"rate": 5e-5}
    return tiny.scene(caisson=caisson, drainage={"mode": mode}, paths=(path,), mesh=mesh).replace(**sections)


@cache
def result(behaviour: str = "elastic", young: float = 200e9, mode: str = "drained") -> xr.DataTree:
    return compute(scene(behaviour, young, mode, output={"paraview": True})).recorded()


@pytest.mark.parametrize("mesh", [{}, {"preset": "medium"}, {"refinement": 0.3}])
def test_stations_join_soil_and_steel_at_one_place_and_the_steel_has_its_volume(mesh):
    built = build_fourier(scene(mesh=mesh))
    model, steel = built.model, built.steel
    nodes = model.mesh.nodes[model.stations.nodes]
    np.testing.assert_allclose(nodes[:, 0], nodes[:, 1], atol=1e-12)
    assert (model.stations.nodes[:, 1] >= model.n_soil).all() and (model.stations.nodes[:, 0] < model.n_soil).all()
    _, volume = elements.geometry(model.mesh.nodes, steel.quads)
    lid, skirt = 0.4 * 3.9**2, 4.0 * (3.9**2 - 3.8**2)
    assert np.pi * volume.sum() == pytest.approx(0.5 * np.pi * (lid + skirt), rel=1e-12)
    edge = model.mesh.nodes[steel.held, 0].max()
    assert edge == pytest.approx(0.25 * 3.8, rel=1e-12)  # an edge of elements
    assert np.isin(steel.held, steel.quads[:, :4])[model.mesh.nodes[steel.held, 0] == edge].any()


@pytest.mark.parametrize("mode", ["drained", "coupled"])
def test_counts_without_a_model_are_those_of_the_model(mode):
    given = scene(mode=mode, output={"paraview": True})
    about, size = describe(given), resources.size_of(given)
    assert about["mesh"]["steel_elements"] == build_fourier(given).steel.n_elements > 0
    counts = about["mesh"]["nodes"], about["mesh"]["elements"], about["unknowns"]
    assert (size.nodes, size.elements, size.unknowns) == counts
    path = result(mode=mode)["paths/pull"].to_dataset(inherit=False)
    assert size.step_bytes == pytest.approx(path.nbytes / path.sizes["step"], rel=0.15)


@pytest.mark.parametrize("mode", ["drained", "coupled"])
def test_loads_balance_and_energy_and_water_are_kept(mode):
    tree = result(mode=mode)
    assert tree.attrs["status"] == "complete"
    record = json.loads(tree.attrs["run_json"])
    assert record["paths"]["pull"]["energy"]["imbalance_over_largest_term"] < 1e-5
    found = balance(paths_of(extract_springs(tree))["pull"].recorded)
    assert max(found.values()) < 1e-9
    path = tree["paths/pull"].to_dataset()
    if mode == "coupled":
        assert float(abs(path["water_imbalance"]).max()) < 1e-8 * float(abs(path["water_moved"]).max())


@pytest.mark.parametrize("mode", ["drained", "coupled"])
def test_stiff_steel_is_the_rigid_caisson(mode):
    """E = 1e6 GPa, the stiffest that a scene may hold, beside a rigid body on the same section."""
    given = scene("elastic", 1e15, mode)
    built = build_fourier(given)
    s, n = built.model.stations, built.model.n_soil
    rigid = replace(
        built.model, mesh=built.section.mesh, fixed=built.model.fixed[:n], linear=None,
        stations=replace(s, nodes=s.nodes[:, :1], weight=s.weight[:, :1]),
    )  # fmt: skip
    stiff, exact = (pulled(given, replace(built, model=each)) for each in (built.model, rigid))
    assert len(stiff) > 3
    np.testing.assert_allclose(stiff, exact, rtol=1e-4)
    ordinary = pulled(given, build_fourier(scene("elastic", 200e9, mode)))
    assert ordinary[-1] < 0.99 * exact[-1]


def pulled(given, built):
    """Loads (N, half the caisson) of the steps of the pull, on a model."""
    driver, loads = Driver(newton_of(given, built, Clock()), State(built.model)), []
    for stage in path_stages(given, given.paths[0], built.extra_load):
        driver.run(stage, lambda step: loads.append(float(step.multipliers[0])))
    return loads


def test_the_section_is_the_rigid_one_and_what_has_bent_and_turns_oval():
    path = result()["paths/pull"].to_dataset()
    difference = (path["y"] - path["u"] + path["rotation"] * path["depth"]).isel(step=-1)
    assert 1e-6 < float(abs(difference).max()) < 0.2 * float(path["u"][-1])
    last = path[["diameter_change_x", "diameter_change_y"]].isel(step=-1, depth=-1)
    assert max(abs(float(last[name])) for name in last) > 1e-7
    assert "diameter_change_x" not in result("rigid")["paths/pull"]


def test_mean_fibre_and_diameters_are_those_of_the_walls_around_the_ring():
    """Beside plain sums over 64 azimuths of both walls."""
    from pysprings.full_model.work import newton_of

    given = scene()
    built = build_fourier(given)
    system = newton_of(given, built, Clock()).system
    state = initial_fields(built.model)
    state.displacement[:] = 1e-3 * np.random.default_rng(2).normal(size=state.displacement.shape)
    state.displacement[:, 1, 0] = 0.0
    found = FourierCollector(built, system, False, False)._shape(state, np.zeros(len(built.section.depth) // 2))
    angle = 2.0 * np.pi * np.arange(64) / 64
    wave = elements.waves(angle, built.model.harmonics)
    ux, uy = 0.0, 0.0
    for wall in built.steel.walls.values():
        r, t = (np.einsum("jk,nk->jn", wave[..., i], state.displacement[wall[1::2], i]) for i in (0, 1))
        ux += 0.5 * (np.cos(angle)[:, None] * r - np.sin(angle)[:, None] * t)
        uy += 0.5 * (np.sin(angle)[:, None] * r + np.cos(angle)[:, None] * t)
    np.testing.assert_allclose(found["y"], ux.mean(axis=0), atol=1e-15)
    np.testing.assert_allclose(found["diameter_change_x"], ux[0] - ux[32], atol=1e-15)
    np.testing.assert_allclose(found["diameter_change_y"], uy[16] - uy[48], atol=1e-15)


def test_paraview_has_the_steel_behind_the_soil():
    tree = result(mode="coupled")
    volume, path = tree["volume"].to_dataset(), tree["paths/pull"].to_dataset().isel(step=-1)
    steel = volume["volume_steel"].values == 1
    assert steel.any() and not steel.all()
    assert np.isnan(path["volume_sxx"].values[steel]).all() and not np.isnan(path["volume_sxx"].values[~steel]).any()
    points = np.stack([volume[f"volume_{axis}"] for axis in "xyz"], axis=1)
    top = np.argmin(np.abs(points - [0.0, 0.0, -0.4]).sum(axis=1))  # on the patch: moves with the rigid motion
    assert float(path["volume_ux"][top]) == pytest.approx(float(path["u"] + 0.4 * path["rotation"]), rel=1e-5)


@pytest.mark.slow
def test_stiffness_approaches_that_of_bricks():
    """Linear scene, free head: bricks come down to the series as their lid is refined (`medium` 0.7 %)."""
    stiffness = {}
    for name, mesh in {
        "series": SERIES | {"preset": "medium"},
        "bricks": {"discretisation": "hex8", "preset": "medium"},
    }.items():
        path = {"name": "pull", "kind": "pull", "lateral_displacement": 1e-5}
        given = tiny.paper(caisson={"behaviour": "elastic"}, mesh=mesh, paths=(path,), **LINEAR)
        ran = compute(given).recorded()["paths/pull"]
        stiffness[name] = float(ran["H"][-1] / ran["u"][-1])
    assert stiffness["series"] == pytest.approx(2676e6, rel=1e-3)
    assert stiffness["bricks"] == pytest.approx(stiffness["series"], rel=1e-2)
    assert stiffness["bricks"] > stiffness["series"]


def test_a_scene_that_leaves_the_discretisation_open_takes_series():
    given = tiny.sand(caisson={"behaviour": "elastic"}, mesh={"preset": "coarse"})
    assert given.discretisation == "fourier"
    assert build(given).steel is not None


def test_the_elements_of_a_thin_lid_are_fine_enough_for_the_preset():
    """M on a rotation about a lid of 0.1 m; with the elements of a rigid caisson it was 17 % above."""
    path = {"name": "turn", "kind": "rotation", "rotation": 1e-5}
    thin = {"behaviour": "elastic", "skirt_thickness": 0.03, "lid_thickness": 0.1}
    M = [
        float(
            compute(tiny.paper(caisson=thin, mesh=SERIES | size, paths=(path,), **LINEAR)).recorded()["paths/turn"][
                "M"
            ][-1]
        )
        for size in ({}, {"refinement": 2.0})
    ]
    assert M[0] == pytest.approx(M[1], rel=0.05)
