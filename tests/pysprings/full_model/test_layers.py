# SPDX-License-Identifier: MIT
"""Layered ground in both discretisations: independent elastic stiffnesses, a soil cut into layers, a checked pull."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

from fe_engine.clock import Clock
from fe_engine.state import State
from pysprings import Scene
from pysprings.full_model.compute import compute
from pysprings.full_model.work import newton_of
from pysprings.model.fourier import build
from pysprings.scene.sections import PAPER
from pysprings.springs.checks import extract_springs
from pysprings.springs.sums import balance
from tests.support import tiny

TWO = [{"top": 0.0, "young_modulus": 20e6}, {"top": 2.0, "young_modulus": 80e6}]
LINEAR = [{"top": 0.0, "young_modulus": {"top": 10e6, "gradient": 10e6}}]
LOOSE_OVER_DENSE: list[dict[str, Any]] = [
    {"top": 0.0, "name": "loose", "friction_angle_final": np.radians(28.0), "young_modulus": 60e6},
    {
        "top": 1.0,
        "name": "dense",
        "law": "van-eekelen",
        "friction_angle_final": np.radians(38.0),
        "young_modulus": {"reference": 150e6, "reference_stress": 100e3, "exponent": 0.5},
    },
]


def stiffness(scene: Scene) -> np.ndarray:
    """Stiffness (3, 3) over (u, w, rotation) of the whole caisson at rest, in MN and m."""
    built = build(scene)
    return 2e-6 * newton_of(scene, built, Clock()).border_stiffness(State(built.model))


@pytest.mark.parametrize(
    ("layers", "wanted"),
    [
        pytest.param(TWO, (1316.7, -4021.1, 30555.0, 787.5, 0.13160), id="two layers"),
        pytest.param(LINEAR, (955.3, -2858.7, 22040.0, 584.5, 0.12971), id="linear"),
    ],
)
def test_elastic_stiffness_is_that_of_an_independent_solution(layers, wanted):
    """Rigid caisson of no thickness in the paper's domain; E by layer and by depth, penalty 1e10 N/m3."""
    scene = tiny.sand(
        domain=PAPER, soil={"yield_surface": "elastic", "layers": layers}, caisson={"skirt_thickness": 5e-3},
        interface={"normal_stiffness": 1e10, "shear_stiffness": 1e10, "friction_coefficient": 5.0},
        mesh={"discretisation": "fourier", "preset": "fine", "harmonics": 1},
    )  # fmt: skip
    k = stiffness(scene)
    found = [k[0, 0], k[0, 2], k[2, 2], k[0, 0] - k[0, 2] ** 2 / k[2, 2], -k[0, 2] / k[2, 2]]
    np.testing.assert_allclose(found, wanted, rtol=5e-3)


@pytest.mark.parametrize("mesh", [{"preset": "coarse"}, {"discretisation": "fourier", "preset": "coarse"}])
def test_a_soil_cut_along_its_mesh_is_the_same_soil(mesh):
    whole = tiny.sand(domain=PAPER, soil={"yield_surface": "elastic"}, mesh={"discretisation": "hex8"} | mesh)
    levels = np.unique(np.round(build(whole).model.mesh.nodes[:, -1], 12))
    tops = [0.0, *(float(z) for z in levels[2:-2:4])]
    assert len(tops) >= 3
    cut = whole.replace(soil={"layers": [{"top": z} for z in tops]})
    np.testing.assert_allclose(stiffness(cut), stiffness(whole), rtol=1e-9)


@pytest.mark.parametrize("discretisation", ["hex8", "fourier"])
def test_a_pull_in_layered_sand_has_springs_that_balance(discretisation):
    scene = tiny.scene(
        mesh={"discretisation": discretisation}, soil={"layers": LOOSE_OVER_DENSE, "poisson_ratio": 0.25}
    )
    result = compute(scene).recorded()
    assert result.attrs["status"] == "complete"
    springs = extract_springs(result)
    assert max(balance(springs["paths/pull"].to_dataset()).values()) < 1e-8
    bounds = springs["paths/pull"]["depth_bounds"].values
    assert 1.0 in bounds and not ((bounds[:, 0] < 1.0) & (bounds[:, 1] > 1.0)).any()
    uniform = compute(scene.replace(soil={"layers": []})).tree
    load, other = (float(each["paths/pull"]["H"][-1]) for each in (result, uniform))
    assert load == pytest.approx(other, rel=0.5)
    assert abs(load / other - 1.0) > 0.02


def coupled(*conductivity: float) -> xr.Dataset:
    """A slow coupled pull, the conductivity (m/s) of each layer given."""
    layers = [{"top": top, "hydraulic_conductivity": k} for top, k in zip((0.0, 1.0), conductivity, strict=False)]
    path = {**tiny.PULL, "rate": 1e-4}
    return compute(tiny.scene(drainage={"mode": "coupled"}, soil={"layers": layers}, paths=(path,))).tree["paths/pull"]


def test_water_flows_by_layer():
    open_, tight, mixed = (float(abs(coupled(*k)["F_pw"][-1])) for k in ((1e-3, 1e-3), (1e-5, 1e-5), (1e-5, 1e-3)))
    assert open_ < 0.9 * mixed
    assert mixed < 0.99 * tight


def test_layers_of_one_conductivity_are_one_soil_for_the_water():
    path = {**tiny.PULL, "rate": 1e-4}
    whole = tiny.scene(drainage={"mode": "coupled"}, soil={"hydraulic_conductivity": 1e-5}, paths=(path,))
    levels = np.unique(np.round(build(whole).model.mesh.nodes[:, -1], 12))
    tops = [0.0, float(levels[3])]
    layers = [{"top": top, "hydraulic_conductivity": 1e-5} for top in tops]
    cut = compute(whole.replace(soil={"layers": layers})).tree["paths/pull"]
    np.testing.assert_allclose(cut["F_pw"], compute(whole).tree["paths/pull"]["F_pw"], rtol=1e-6, atol=1.0)


@pytest.mark.parametrize("discretisation", ["hex8", "fourier"])
def test_a_stiffness_that_changes_takes_part_in_a_run(discretisation):
    """From one initial stiffness: degradation lowers the load, and the balance of energy holds."""
    young = {"reference": 80e6, "reference_stress": 100e3, "exponent": 0.5}
    path = {**tiny.PULL, "lateral_displacement": 2e-3}
    ends, stiffnesses = [], []
    for changes in ({}, {"young_modulus": young | {"follows": "stress"}}, {"degradation_strain": 1e-4}):
        layer = {"top": 0.0, "young_modulus": young} | changes
        scene = tiny.scene(mesh={"discretisation": discretisation}, soil={"layers": [layer]}, paths=(path,))
        result = compute(scene)
        figures = result.record.paths["pull"]
        assert (figures.status.value, figures.cut_backs) == ("complete", 0)
        assert abs(figures.energy["imbalance_over_largest_term"]) < 1e-5
        ends.append(float(result.tree["paths/pull"]["H"][-1]))
        stiffnesses.append(float(result.recorded()["stiffness_initial"][0, 0]))
    assert stiffnesses == pytest.approx(stiffnesses[:1] * 3, rel=1e-12)
    assert 1e-4 < abs(ends[1] / ends[0] - 1.0) < 0.1
    assert 0.5 * ends[0] < ends[2] < 0.9 * ends[0]
