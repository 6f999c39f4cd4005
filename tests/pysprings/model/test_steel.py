# SPDX-License-Identifier: MIT
"""The elastic caisson: its mesh fits the soil's, it balances, is the rigid one where it is stiff, and turns oval."""

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from pysprings.core.errors import UserInputError
from pysprings.full_model.compute import compute
from pysprings.macro.predict import predict
from pysprings.model.build import build_model
from pysprings.springs import checks
from pysprings.springs.checks import extract_springs, open_springs, save_springs
from pysprings.springs.path import paths_of
from pysprings.springs.sums import balance
from tests.support import tiny

MESHES = [{}, {"azimuth": 12}, {"preset": "fine", "refinement": 0.4}]


@cache
def result(young: float = 200e9, behaviour: str = "elastic", mode: str = "drained") -> xr.DataTree:
    path = tiny.PULL | {"rate": 5e-5}
    caisson = {"behaviour": behaviour, "young_modulus": young}
    return compute(tiny.scene(caisson=caisson, drainage={"mode": mode}, paths=(path,))).recorded()


@pytest.mark.parametrize("mesh", MESHES)
def test_every_station_stands_between_soil_and_steel_at_one_place(mesh: dict) -> None:
    built = build_model(tiny.paper(mesh=mesh, caisson={"behaviour": "elastic"}))
    stations, nodes, first = built.model.stations, built.model.mesh.nodes, built.caisson.mesh.n_nodes
    assert stations is not None
    of_steel = stations.nodes >= first
    assert (stations.weight[of_steel] <= 0.0).all() and (stations.weight[~of_steel] >= 0.0).all()
    for side in (of_steel, ~of_steel):
        share = np.where(side, stations.weight, 0.0)
        np.testing.assert_allclose(np.abs(share.sum(axis=1)), 1.0, rtol=1e-12)
        place = np.einsum("sa,sai->si", np.abs(share), nodes[stations.nodes])
        np.testing.assert_allclose(place, stations.position, atol=1e-9)


@pytest.mark.parametrize("mesh", MESHES)
def test_the_steel_has_the_volume_of_skirt_and_lid(mesh: dict) -> None:
    from fe_engine.elements import hex8

    scene = tiny.paper(mesh=mesh, caisson={"behaviour": "elastic"})
    built = build_model(scene)
    assert built.steel is not None
    _, volume, _ = hex8.geometry(built.model.mesh.nodes, built.steel.hexes)
    assert volume.min() > 0.0
    lid, skirt = 0.4 * 3.9**2, 4.0 * (3.9**2 - 3.8**2)
    assert volume.sum() == pytest.approx(0.5 * np.pi * (lid + skirt), rel=1e-3)


def test_loads_balance_and_energy_is_kept() -> None:
    tree = result()
    assert tree.attrs["status"] == "complete"
    record = json.loads(tree.attrs["run_json"])
    assert record["mesh"]["steel_elements"] == 26
    assert record["paths"]["pull"]["energy"]["imbalance_over_largest_term"] < 1e-6
    found = balance(paths_of(extract_springs(tree))["pull"].recorded)
    assert max(found.values()) < 1e-12


def test_stiff_steel_is_the_rigid_caisson() -> None:
    """E = 1e6 GPa, the stiffest that a scene may hold: within 0.2 % in load, 0.5 % in rotation."""
    stiff, rigid = (result(*given)["paths/pull"].to_dataset() for given in ((1e15,), (200e9, "rigid")))
    np.testing.assert_allclose(stiff["H"], rigid["H"], rtol=2e-3)
    np.testing.assert_allclose(stiff["rotation"][1:], rigid["rotation"][1:], rtol=5e-3)
    np.testing.assert_allclose(stiff["p"], rigid["p"], atol=5e-3 * float(abs(rigid["p"]).max()))
    assert float(abs(stiff["diameter_change_x"]).max()) < 1e-7
    ordinary = result()["paths/pull"]
    assert float(ordinary["H"][-1]) < 0.99 * float(rigid["H"][-1])


def test_the_section_is_the_rigid_one_and_what_has_bent() -> None:
    path = result()["paths/pull"].to_dataset()
    rigid = path["u"] - path["rotation"] * path["depth"]
    difference = (path["y"] - rigid).isel(step=-1)
    assert 1e-6 < float(abs(difference).max()) < 0.2 * float(path["u"][-1])
    oval = path[["diameter_change_x", "diameter_change_y"]].isel(step=-1, depth=-1)
    assert float(oval["diameter_change_x"]) > 1e-7 > -1e-7 > float(oval["diameter_change_y"])
    assert "diameter_change_x" not in result(200e9, "rigid")["paths/pull"]


def test_springs_of_an_elastic_caisson_are_read_back_and_predict_their_own_path(tmp_path: Path) -> None:
    made = extract_springs(result())
    save_springs(made, tmp_path / "springs.nc")
    tree = open_springs(tmp_path / "springs.nc")
    path = paths_of(tree)["pull"].recorded
    answer = predict(tree, H=float(path["H"][-1]), arm=0.0)
    assert float(answer["u"].values.ravel()[-1]) == pytest.approx(float(path["u"][-1]), rel=1e-3)
    made.attrs["caisson_behaviour"] = "rigid"
    with pytest.raises(UserInputError, match=r"y.*is not u - rotation"):
        checks.validate_springs(made)


def test_water_does_not_pass_through_the_steel() -> None:
    """Balanced at every step, and by nothing but the film: a seal of the film's other side changes nothing."""
    path = result(mode="coupled")["paths/pull"].to_dataset()
    assert float(abs(path["water_imbalance"]).max()) < 1e-9 * float(abs(path["water_moved"]).max())
    rigid = result(1e15, "elastic", "coupled")["paths/pull"], result(200e9, "rigid", "coupled")["paths/pull"]
    np.testing.assert_allclose(rigid[0]["F_pw"], rigid[1]["F_pw"], rtol=5e-3, atol=1.0)


def test_a_thicker_skirt_bends_less() -> None:
    def oval(thickness: float) -> float:
        caisson = {"behaviour": "elastic", "skirt_thickness": thickness}
        return float(abs(compute(tiny.scene(caisson=caisson)).recorded()["paths/pull"]["diameter_change_y"]).max())

    assert oval(0.4) < 0.8 * oval(0.05)


def test_the_picture_shows_both_diameters_and_the_mean_fibre_by_depth() -> None:
    from pysprings.results import plots

    path = plots.path_data(result(), "pull")
    left, right = plots.ovalisation(path).axes
    lines = [line for line in left.get_lines() if not str(line.get_label()).startswith("_")]
    for line, name in zip(lines, ("diameter_change_x", "diameter_change_y"), strict=True):
        np.testing.assert_allclose(line.get_xdata(), 1e3 * path[name].isel(step=-1))
        np.testing.assert_array_equal(line.get_ydata(), path["depth"])
    fibre = next(line for line in right.get_lines() if line.get_label() == "mean fibre of the skirt")
    np.testing.assert_allclose(fibre.get_xdata(), 1e3 * path["y"].isel(step=-1))
    assert left.get_ylim()[0] > left.get_ylim()[1]


@pytest.mark.slow
def test_a_run_draws_it() -> None:
    from pysprings.results.plots.files import figures

    drawn = {name for name, _ in figures(result(), None, {})}
    assert "pull_ovalisation_last" in drawn
