# SPDX-License-Identifier: MIT
"""Scenes in Fourier series: section, stiffness, run, balance, fields around the ring, resume, ParaView, refusals."""

import json
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr

from fe_engine.clock import Clock
from fe_engine.mesh import measure_quality
from fe_engine.solve.stepping import Driver
from fe_engine.state import State
from pysprings.core import variables
from pysprings.core.errors import UserInputError
from pysprings.full_model.checkpoint import Checkpoints
from pysprings.full_model.compute import compute
from pysprings.full_model.fourier_collect import around, output_azimuths
from pysprings.full_model.record import DEAD_LOAD
from pysprings.full_model.work import newton_of
from pysprings.model.contact import SURFACE
from pysprings.model.forecast.resources import size_of
from pysprings.model.fourier import build_fourier, build_on_section, section_counts_of
from pysprings.model.stages import path_stages
from pysprings.scene.model import Scene
from pysprings.scene.sections import PAPER
from pysprings.springs.checks import extract_springs
from pysprings.springs.sums import balance
from tests.support import tiny
from tests.support.commands import command
from tests.support.two_paths import SECOND, drained

SERIES: dict[str, Any] = {"discretisation": "fourier", "preset": "coarse", "refinement": 0.7, "harmonics": 2}


def scene(**sections: Any) -> Scene:
    """The tiny scene as a series, with some values changed."""
    return tiny.scene(mesh=SERIES).replace(**sections)


@cache
def result() -> xr.DataTree:
    return compute(scene(output={"paraview": True})).recorded()


# --- section and stations ---


def test_areas_of_the_stations_are_those_of_the_caisson():
    given = scene()
    stations = build_fourier(given).model.stations
    outer, inner = (
        0.5 * given.caisson.outer_diameter,
        0.5 * given.caisson.outer_diameter - given.caisson.skirt_thickness,
    )
    length = given.caisson.skirt_length
    wanted = {
        "outer": np.pi * outer * length, "inner": np.pi * inner * length, "lid": 0.5 * np.pi * inner**2,
        "tip": 0.5 * np.pi * (outer**2 - inner**2),
    }  # fmt: skip
    found = {name: stations.area[stations.surface == SURFACE[name]].sum() for name in wanted}
    assert found == pytest.approx(wanted, rel=1e-12)


def test_only_the_corners_of_skirt_lid_and_tip_carry_two_stations():
    built = build_fourier(scene())
    stations, section = built.model.stations, built.section
    pairs = list(zip(stations.nodes[:, 0].tolist(), stations.azimuth.tolist(), strict=True))
    twice = {pair for pair in pairs if pairs.count(pair) > 1}
    corners = {int(section.walls["inside"][0]), int(section.tip[0]), int(section.tip[-1])}
    assert {node for node, _ in twice} == corners
    assert len(twice) == 3 * 3  # three azimuths each


def test_the_load_does_not_depend_on_the_elements_across_the_tip():
    given = scene(soil={"yield_surface": "drucker-prager"})
    loads = [pulled(given, replace(section_counts_of(given), tip=tip)) for tip in (1, 3)]
    assert loads[0] == pytest.approx(loads[1], rel=1.5e-3)
    assert loads[0] > 0.0


def pulled(given, counts):
    """Return the load (N, half the caisson) at the end of the first path of a scene on these counts."""
    built = build_on_section(given, counts)
    newton = newton_of(given, built, Clock())
    driver, loads = Driver(newton, State(built.model)), []
    for stage in path_stages(given, given.paths[0], built.extra_load):
        driver.run(stage, lambda step: loads.append(float(step.multipliers[0])))
    return loads[-1]


def test_the_slot_of_the_skirt_holds_no_elements():
    given = scene()
    section = build_fourier(given).section
    centre = section.mesh.nodes[section.mesh.quads[:, :4]].mean(axis=1)
    outer, thickness = 0.5 * given.caisson.outer_diameter, given.caisson.skirt_thickness
    inside = (centre[:, 0] > outer - thickness) & (centre[:, 0] < outer)
    assert (centre[inside, 1] > given.caisson.skirt_length).all()
    assert inside.any()


@pytest.mark.parametrize("preset", ["coarse", "fine"])
def test_halvings_add_lines_beside_the_skirt_and_move_none(preset):
    """Twice: elements at walls and tip are a quarter in size, four stand across the tip for one; sums of areas stay."""
    scene = tiny.sand(mesh={"discretisation": "fourier", "preset": preset})
    whole, halved = (build_fourier(scene.replace(mesh={"halvings": times})) for times in (0, 2))
    tip, radius = scene.caisson.skirt_length, 0.5 * scene.caisson.outer_diameter
    for axis, at in ((0, radius), (0, radius - scene.caisson.skirt_thickness), (1, tip)):
        before, after = (
            np.unique(each.section.mesh.nodes[each.section.mesh.corners, axis]) for each in (whole, halved)
        )
        assert np.isin(before, after).all()
        for side in (-1, 1):
            gaps = [np.min(side * (levels - at)[side * (levels - at) > 1e-9]) for levels in (before, after)]
            assert gaps[1] == pytest.approx(0.25 * gaps[0])
    areas = [each.model.stations.area.sum() for each in (whole, halved)]
    assert areas[1] == pytest.approx(areas[0], rel=1e-12)
    assert size_of(scene.replace(mesh={"halvings": 2})).elements == halved.section.mesh.n_elements
    assert scene.replace(mesh={"halvings": 0}).sha256 == scene.sha256 != scene.replace(mesh={"halvings": 1}).sha256


@pytest.mark.parametrize(
    "penalty, wanted", [(1e10, (4051.0, -10295.0, 88840.0, 2858.0)), (1e9, (3913, -9802, 82876, 2753))]
)
def test_elastic_stiffness_is_that_of_an_independent_solution(penalty, wanted):
    """Rigid caisson of no thickness in the paper's soil and domain, stiffness over (u, rotation) in MN and m."""
    given = tiny.sand(
        domain=PAPER, soil={"yield_surface": "elastic"}, caisson={"skirt_thickness": 5e-3},
        interface={"normal_stiffness": penalty, "shear_stiffness": penalty, "friction_coefficient": 5.0},
        mesh={"discretisation": "fourier", "preset": "paper", "harmonics": 1},
    )  # fmt: skip
    built = build_fourier(given)
    k = 2e-6 * newton_of(given, built, Clock()).border_stiffness(State(built.model))
    found = [k[0, 0], k[0, 2], k[2, 2], k[0, 0] - k[0, 2] ** 2 / k[2, 2]]
    np.testing.assert_allclose(found, wanted, rtol=4e-3)


# --- fields around the ring ---


def test_fields_between_stations_are_the_trigonometric_polynomial_through_them():
    stations, there = (np.arange(4) + 0.5) * np.pi / 4, output_azimuths(3)
    even, odd = around(stations, there)
    for k in range(4):
        np.testing.assert_allclose(even @ np.cos(k * stations), np.cos(k * there), atol=1e-12)
    for k in range(1, 5):
        np.testing.assert_allclose(odd @ np.sin(k * stations), np.sin(k * there), atol=1e-12)
    assert (there[0], there[-1]) == (0.0, np.pi)


# --- a run ---


@pytest.mark.slow
@pytest.mark.parametrize(("harmonics", "end"), [(10, 2.5e-3), (3, 20e-3)])
def test_soft_sand_and_lift_off_do_not_stop_a_pull(harmonics, end):
    """Exact Newton steps follow soft modes of sand that is about to localise, and stop both runs before their end."""
    mesh = {"discretisation": "fourier", "preset": "medium", "harmonics": harmonics}
    pull = {"name": "pull", "kind": "pull", "lateral_displacement": end}
    found = compute(tiny.sand(domain=PAPER, paths=(pull,), mesh=mesh, solver={"tolerance": 1e-3})).recorded()
    assert found.attrs["status"] == "complete"
    assert float(found["paths/pull"]["u"][-1]) == pytest.approx(end)


def test_a_run_is_complete_and_has_the_datasets_of_bricks():
    tree, bricks = result(), compute(tiny.scene(output={"paraview": True})).recorded()
    assert tree.attrs["status"] == "complete"
    assert variables.tree_problems(tree, "result") == []
    assert set(tree["paths/pull"].data_vars) == set(bricks["paths/pull"].data_vars)
    record = json.loads(tree.attrs["run_json"])
    assert record["mesh"]["discretisation"] == "fourier"
    assert record["mesh"]["harmonics"] == 2
    assert record["paths"]["pull"]["energy"]["imbalance_over_largest_term"] < 1e-3
    assert tree["paths/pull"]["H"].values[-1] == pytest.approx(bricks["paths/pull"]["H"].values[-1], rel=0.3)


def test_springs_of_a_run_balance_its_load():
    springs = extract_springs(result())
    path = springs["paths/pull"].to_dataset()
    assert max(balance(path).values()) < 1e-9
    np.testing.assert_allclose(path["M"].values, 0.0, atol=1e-3 * float(np.abs(path["H"]).max()))


def test_resultants_of_surfaces_add_up_to_the_load():
    path = result()["paths/pull"]
    for name in ("H", "V"):
        parts = sum(path[f"{name}_{surface}"] for surface in ("outer", "inner", "lid", "tip"))
        np.testing.assert_allclose(parts, path[name], rtol=1e-9, atol=1.0)


def test_contact_fields_integrate_to_the_reaction_of_the_soil():
    """p of both sides from the fields by azimuth, whose mean over a slice and around the ring is exact."""
    path = result()["paths/pull"].isel(step=-1)
    given, angle = scene(), path["azimuth"].values
    weight = np.full(len(angle), angle[1])
    weight[[0, -1]] *= 0.5
    total = 0.0
    for side, radius, sign in (("outside", 3.9, -1.0), ("inside", 3.8, 1.0)):
        normal = path["normal_effective_stress"].sel(side=side).values
        shear = path["shear_lateral"].sel(side=side).values
        lateral = sign * -1.0 * normal * np.cos(angle)[:, None] + shear
        total = total + 2.0 * radius * weight @ lateral
    assert given.caisson.outer_diameter == 7.8
    np.testing.assert_allclose(total, path["p"].values, rtol=0.02, atol=0.02 * np.abs(path["p"]).max())


def test_the_initial_state_is_geostatic_everywhere():
    path = result()["paths/pull"].isel(step=0)
    wanted = 10.56e3 * (1.0 + path["depth"].values)
    field = path["normal_effective_stress"].transpose("side", "azimuth", "depth").values
    np.testing.assert_allclose(field, np.broadcast_to(wanted, field.shape), rtol=1e-9)
    assert float(path["gap"].max()) == 0.0


def test_paraview_fields_are_those_of_the_series():
    tree = result()
    volume, path = tree["volume"], tree["paths/pull"].isel(step=-1)
    nodes = np.stack([volume[f"volume_{a}"].values for a in "xyz"], axis=1)
    quality = measure_quality(nodes, volume["volume_hex"].values[nodes[volume["volume_hex"].values, 1].min(axis=1) > 1])
    assert quality.min_jacobian > 0.0
    weight = path["volume_szz"].values / -(10.56e3 * (1.0 + nodes[volume["volume_hex"].values, 2].mean(axis=1)))
    far = np.hypot(*nodes[volume["volume_hex"].values, :2].mean(axis=1).T) > 14.0
    assert far.any()
    np.testing.assert_allclose(weight[far], 1.0, rtol=0.1)
    beside = np.argmin(np.linalg.norm(nodes - [3.9, 0.0, 0.0], axis=1))
    behind = np.argmin(np.linalg.norm(nodes + [3.9, 0.0, 0.0], axis=1))
    u = float(path["u"])
    assert 0.3 * u < path["volume_ux"].values[beside] < 1.1 * u
    assert 0.3 * u < path["volume_ux"].values[behind] < 1.1 * u


def test_the_plane_of_symmetry_moves_as_the_volume():
    tree = result()
    path = tree["paths/pull"].isel(step=-1)
    x, z = tree["section"]["section_x"].values, tree["section"]["section_depth"].values
    volume = np.stack([tree["volume"][f"volume_{a}"].values for a in "xyz"], axis=1)
    picked = np.flatnonzero((np.abs(x) > 2.0) & (z < 8.0))[::7]
    assert len(picked) > 5
    for k in picked:
        same = np.argmin(np.linalg.norm(volume - [x[k], 0.0, z[k]], axis=1))
        assert path["section_ux"].values[k] == pytest.approx(path["volume_ux"].values[same], rel=1e-5, abs=1e-12)
        assert path["section_uz"].values[k] == pytest.approx(path["volume_uz"].values[same], rel=1e-5, abs=1e-12)


@pytest.mark.parametrize("kind", ["rotation", "load", "vertical", "swipe"])
def test_other_paths_run_as_with_bricks(kind):
    paths: dict[str, dict[str, Any]] = {
        "rotation": {"rotation": -1e-4}, "load": {"lateral_force": 1e5, "arm": 5.0},
        "vertical": {"vertical_displacement": 5e-4},
        "swipe": {"lateral_displacement": 3e-4, "rotation": 1e-4, "role": "held-back"},
    }  # fmt: skip
    path = {"name": "path", "kind": kind, **paths[kind]}
    series, bricks = (compute(each.replace(paths=(path,))).recorded() for each in (scene(), tiny.scene()))
    assert series.attrs["status"] == "complete"
    for name in ("u", "w", "rotation", "H", "V", "M"):
        found, wanted = (tree["paths/path"][name].values for tree in (series, bricks))
        scale = {"H": 5e5, "V": 5e5, "M": 2e6}.get(name, 1e-3)
        assert found[-1] == pytest.approx(wanted[-1], rel=0.35, abs=0.03 * scale)


class _Stop:
    """Stops a run after so many reports of a path."""

    def __init__(self, after: int) -> None:
        self.left = after

    def __call__(self, path: str, fraction: float, message: str) -> None:
        if path not in ("model",):
            self.left -= 1
            if self.left == 0:
                raise KeyboardInterrupt


@pytest.mark.parametrize("after", [1, 4, 7])
def test_a_stopped_run_goes_on_to_the_same_result(after, tmp_path):
    loaded = drained().replace(mesh=SERIES)
    whole = compute(loaded).recorded()
    stopped = compute(loaded, progress=_Stop(after), checkpoints=Checkpoints(tmp_path)).recorded()
    assert stopped.attrs["status"] == "interrupted"
    assert Checkpoints(tmp_path).harmonics == 2 and Checkpoints(tmp_path / "none").harmonics is None
    resumed = compute(loaded, checkpoints=Checkpoints(tmp_path), resume=True).recorded()
    assert resumed.attrs["status"] == "complete"
    for name in ("pull", "second"):
        xr.testing.assert_identical(whole[f"paths/{name}"].to_dataset(), resumed[f"paths/{name}"].to_dataset())


# --- what is refused ---


def test_paths_with_one_dead_load_share_its_steps_and_are_as_if_alone():
    """The second path has another load: it takes up nothing."""
    other = {**SECOND, "name": "other", "role": "held-back", "vertical_load": 1.2e6}
    given = drained().replace(mesh=SERIES, paths=(tiny.PULL, other, SECOND, {**SECOND, "name": "third"}))
    stages: list[tuple[str, str]] = []
    together = compute(given, progress=lambda name, _, text: stages.append((name, text)))
    assert {name for name, text in stages if text.endswith(DEAD_LOAD)} == {"pull", "other"}
    for path in given.paths[1:]:
        alone = compute(given.replace(paths=(path,)))
        for group in (f"paths/{path.name}", f"paths/{path.name}/convergence"):
            xr.testing.assert_identical(together.tree[group].to_dataset(), alone.tree[group].to_dataset())
        assert alone.record.paths[path.name] == together.record.paths[path.name]


def test_what_a_series_cannot_carry_is_refused():
    path = '[[path]]\nname = "p"\nkind = "pull"\nlateral_displacement = "1 mm"\nrate = "0.05 mm/s"\n'
    water = '[drainage]\nmode = "coupled"\nstabilisation = 0.5\n'
    with pytest.raises(UserInputError, match=r"drainage\.stabilisation"):
        tiny.parsed('[mesh]\ndiscretisation = "fourier"\n' + water + path)


@pytest.mark.parametrize("mesh", ['discretisation = "fourier"\nazimuth = 16', 'harmonics = 3\ndiscretisation = "hex8"'])
def test_counts_of_the_other_discretisation_are_refused(mesh):
    with pytest.raises(UserInputError, match=r"mesh\.(azimuth|harmonics)"):
        tiny.parsed(f"[mesh]\n{mesh}\n")


def test_the_command_line_chooses_the_discretisation(tmp_path):
    file = tiny.write(tiny.scene(), tmp_path / "scene.toml")
    done = command("check", str(file), "--discretisation", "fourier", "--json")
    assert done.code == 0, done.err
    about = json.loads(done.out)
    counts = section_counts_of(tiny.scene(mesh={"discretisation": "fourier"}))
    elements = (counts.plug + counts.tip + counts.outer) * (counts.skirt + counts.below) - counts.tip * counts.skirt
    assert f'"elements": {elements}' in json.dumps(about)
