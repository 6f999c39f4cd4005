# SPDX-License-Identifier: MIT
"""Paths that leave the plane of one load: scene keys, refusals, and what a run makes of them."""

from functools import cache

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from fe_engine.assembly.fourier_film import line_water, pack_film
from fe_engine.assembly.kernels_water import Step
from fe_engine.balance.water import WaterBalance
from fe_engine.clock import Clock
from fe_engine.solve.stepping import fewest_increments
from fe_engine.state import State
from pysprings import Scene, extract_springs
from pysprings.core.errors import UserInputError
from pysprings.core.path_kinds import LOADS, MOTIONS
from pysprings.core.units import ATMOSPHERE, VAPOUR
from pysprings.full_model.accuracy.measures import off_plane_error
from pysprings.full_model.accuracy.own_estimate import companions_of, with_estimate
from pysprings.full_model.compute import compute
from pysprings.full_model.diagnosis import DisplacementLimit
from pysprings.full_model.paths import PathRun, _take, largest_motion
from pysprings.full_model.run_record import RunRecord
from pysprings.full_model.work import prepare
from pysprings.model.stages import path_stages
from pysprings.results.exporters.tables import load_displacement
from pysprings.results.folder import run_to_folder
from pysprings.results.layout import open_result
from pysprings.results.summary import summary
from pysprings.scene.load import parse_scene
from pysprings.scene.sections import PAPER, PAPER_SOIL
from tests.support import tiny
from tests.support.files import read_record

HELD = {"role": "held-back"}
PULL = {"name": "pull", "kind": "pull", "lateral_displacement": 1e-3, "direction": np.radians(30.0)}
TWIST = {"name": "twist", "kind": "twist", "twist": 1e-3, "report_at": (5e-4,), "then": ["0 mrad"]} | HELD
ELBOW = {"name": "elbow", "kind": "translation", "lateral_displacement": 1e-3, "then": ["2 mm towards 90 deg"]} | HELD
FREE = {
    "name": "free",
    "kind": "pull",
    "lateral_displacement": 1e-3,
    "arm": 4.0,
    "then": ["1 mm towards 90 deg"],
} | HELD
LOAD = {"name": "load", "kind": "load", "H_x": 1e6, "M_x": 4e6, "T": 5e5, "V": 2e6} | HELD
MOTION = {"name": "motion", "kind": "motion", "u_x": 1e-3, "rot_z": 5e-4, "heave": "fixed"} | HELD
PATHS = (PULL, TWIST, ELBOW, FREE, LOAD, MOTION)
PROBE = {"name": "probe", "kind": "probe", "lateral_displacement": 2e-3, "load_angle": 0.4} | HELD


def scene(*paths, **sections):
    mesh = {"preset": "coarse", "harmonics": 2}
    return Scene(domain=PAPER, soil=PAPER_SOIL, paths=paths, **{"mesh": mesh, "solver": {"tolerance": 1e-4}} | sections)


@cache
def result():
    return compute(scene(*PATHS)).recorded()


@cache
def table():
    return load_displacement(result()).set_index("path")


def last(name):
    return table().loc[name].iloc[-1]


def test_all_paths_have_the_columns_of_six_degrees_of_freedom():
    units = {"T": "Nm", "M": "Nm", "H": "N", "V": "N", "u": "m", "w": "m", "r": "rad"}
    names = [f"{name}_{units[name[0]]}" for name in (*MOTIONS, *LOADS)]
    assert list(table().columns) == ["step", "time_s", *names, "converged"]
    assert set(table().index) == {path["name"] for path in PATHS}
    assert (table()["converged"] == 1).all()


def test_a_path_in_one_plane_stays_with_the_half_model_and_is_turned_in_the_table():
    half, row = result()["paths/pull"].to_dataset(), last("pull")
    c, s = np.cos(np.radians(30.0)), np.sin(np.radians(30.0))
    assert row[["u_x_m", "u_y_m"]].tolist() == pytest.approx([1e-3 * c, 1e-3 * s])
    H, M, turn = (float(half[name][-1]) for name in ("H", "M", "rotation"))
    assert row[["H_x_N", "H_y_N"]].tolist() == pytest.approx([H * c, H * s])
    # it leans towards the load: about -x and +y
    assert row[["rot_x_rad", "rot_y_rad"]].tolist() == pytest.approx([-turn * s, turn * c])
    assert row[["M_x_Nm", "M_y_Nm"]].tolist() == pytest.approx([-M * s, M * c], abs=1.0)
    assert turn > 0.0
    alone = compute(scene({k: v for k, v in PULL.items() if k != "direction"})).recorded()["paths/pull"].to_dataset()
    for name in ("u", "H", "M", "p"):
        np.testing.assert_array_equal(alone[name].values, half[name].values)


def test_springs_are_made_of_the_paths_in_one_plane():
    assert list(extract_springs(result())["paths"].children) == ["pull"]
    assert list(result()["space"].children) == [path["name"] for path in PATHS[1:]]


def test_given_loads_and_motions_are_there():
    row = last("load")
    wanted = [1e6, 0.0, 2e6, 4e6, 0.0, 5e5]
    assert row[
        [f"{name}_N" if name in ("H_x", "H_y", "V") else f"{name}_Nm" for name in LOADS]
    ].tolist() == pytest.approx(wanted, abs=200.0)
    assert row["u_x_m"] > 0.0 and row["u_y_m"] < 0.0 < row["rot_x_rad"]  # M about +x leans it towards -y
    assert row["rot_z_rad"] > 0.0 and row["w_m"] > 0.0
    row = last("motion")
    assert row[["u_x_m", "u_y_m", "w_m", "rot_x_rad", "rot_y_rad", "rot_z_rad"]].tolist() == pytest.approx(
        [1e-3, 0.0, 0.0, 0.0, 0.0, 5e-4], abs=1e-15
    )
    assert row["H_x_N"] > 0.0 and row["T_Nm"] > 0.0 and row["M_y_Nm"] < 0.0  # held upright, as in the half model


def test_a_head_is_free_under_a_load_at_a_height_in_either_direction():
    row = last("free")
    assert row["u_y_m"] == pytest.approx(1e-3)
    assert row["M_y_Nm"] == pytest.approx(4.0 * row["H_x_N"], abs=100.0)
    assert row["M_x_Nm"] == pytest.approx(-4.0 * row["H_y_N"], abs=100.0)
    assert row["T_Nm"] == pytest.approx(0.0, abs=100.0)


def test_a_probe_without_torsion_is_that_of_the_half_model_in_any_direction():
    """R, its motion, and what is across, N 3: within 0.2 % of the load; other azimuths."""
    solver = {"tolerance": 1e-4, "max_step_fraction": 0.05}
    given = {"mesh": {"preset": "coarse", "harmonics": 3}, "solver": solver}
    turn, plan = np.radians(37.0), {"torsion_angle": 0.0, "direction": np.radians(37.0)}
    half, whole = (compute(scene(PROBE | more, **given)).recorded() for more in ({}, plan))
    half, whole = half["paths/probe"].to_dataset(), whole["space/probe"].to_dataset().isel(step=-1)
    assert (whole.attrs["load_angle_rad"], whole.attrs["torsion_angle_rad"]) == (0.4, 0.0)
    along, across = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    for name, lean in (("H", None), ("u", None), ("M", "M"), ("rotation", "rot")):
        key = lean or name
        pair = np.array([float(whole[f"{key}_x"]), float(whole[f"{key}_y"])])
        pair = pair if lean is None else np.array([pair[1], -pair[0]])
        wanted = float(half[name][-1])
        assert pair @ along == pytest.approx(wanted, rel=2e-3), name
        assert abs(pair @ across) < 2e-3 * abs(wanted), name
    assert abs(float(whole["T"])) < 1e-4 * abs(float(half["M"][-1]))


def test_a_probe_with_torsion_keeps_its_direction_and_alone_it_is_the_limit_of_friction():
    """In elastic soil friction alone ends it: sum of mu p r over walls, lid and tip, less the lid's ring (0.2 %)."""
    mu, weight, given = 0.4, 10e3, {"load_angle": 0.0, "lateral_displacement": 0.05}
    soil = {"yield_surface": "elastic", "shear_modulus": 10e6, "poisson_ratio": 0.3, "effective_unit_weight": weight,
            "surcharge": weight, "K0": 0.5}  # fmt: skip
    caisson = {"outer_diameter": 8.0, "skirt_length": 4.0, "skirt_thickness": 0.08}
    alone = PROBE | given | {"name": "alone", "torsion_angle": np.pi / 2}
    both = PROBE | {"name": "both", "torsion_angle": 0.5, "direction": 1.0}
    rough = Scene(
        soil=soil, caisson=caisson, paths=(alone, both), mesh={"preset": "coarse", "harmonics": 1},
        interface={"friction_coefficient": mu}, domain={"radius": 40.0, "depth": 30.0}, solver={"tolerance": 1e-4},
    )  # fmt: skip
    run = compute(rough)
    paths = run.recorded()["space"]
    outer, inner, tip = 4.0, 3.92, 4.0
    walls = 2.0 * np.pi * (outer**2 + inner**2) * 0.5 * weight * (tip + 0.5 * tip**2)
    ends = 2.0 / 3.0 * np.pi * weight * (inner**3 + (outer**3 - inner**3) * (1.0 + tip))
    end = paths["alone"].isel(step=-1)
    assert float(end["T"]) == pytest.approx(mu * (walls + ends), rel=5e-3)
    assert 8.0 * float(end["rot_z"]) == pytest.approx(0.05)
    step = paths["both"].to_dataset().isel(step=-1)
    size, a, b = float(step["T"]) / 8.0 / np.sin(0.5), 0.4, 0.5
    plan = size * np.cos(b) * np.array([np.cos(1.0), np.sin(1.0)])
    wanted = [*np.cos(a) * plan, -8.0 * np.sin(a) * plan[1], 8.0 * np.sin(a) * plan[0]]
    assert [float(step[name]) for name in ("H_x", "H_y", "M_x", "M_y")] == pytest.approx(wanted, rel=1e-4)
    wall, turn = (np.array([float(step[f"{name}_x"]), float(step[f"{name}_y"])]) for name in ("u", "rot"))
    plan /= np.linalg.norm(plan)
    lean = turn[1] * plan[0] - turn[0] * plan[1]
    moved = np.cos(b) * (np.cos(a) * wall @ plan + 8.0 * np.sin(a) * lean) + 8.0 * np.sin(b) * float(step["rot_z"])
    assert moved == pytest.approx(2e-3)


SEA = {"mode": "coupled", "water_depth": 5.0}
WATER = {"drainage": SEA, "mesh": {"preset": "coarse", "harmonics": 3, "refinement": 0.7}}


@cache
def wet(angle, mode="coupled"):
    """A push of 2 mm in 0.4 s, held upright: of the half model without an angle, else towards it."""
    sections = WATER | {"drainage": SEA | {"mode": mode}, "solver": {"tolerance": 1e-5}}
    path: dict[str, object] = {"name": "push", **HELD}
    if angle is None:
        path |= {"kind": "translation", "lateral_displacement": 2e-3} | ({"rate": 5e-3} if mode == "coupled" else {})
    else:
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        path |= {"kind": "motion", "u_x": 2e-3 * c} | ({"u_y": 2e-3 * s} if s else {})
        path |= {"duration": 0.4} if mode == "coupled" else {}
    return compute(scene(path, **sections))


@pytest.mark.parametrize("mode", ["coupled", "undrained"])
def test_a_push_in_wet_soil_is_that_of_the_half_model_in_any_direction(mode):
    """Turned by 37 degrees within 0.1 %, across 0.1 %; beside the half model 0.3 %, whose azimuths are others."""
    half, found = wet(None, mode).recorded()["paths/push"].to_dataset().isel(step=-1), []
    dry = compute(scene({"name": "push", "kind": "translation", "lateral_displacement": 2e-3},
                        **WATER | {"drainage": {"mode": "drained"}})).recorded()["paths/push"]  # fmt: skip
    for angle in (0.0, 37.0):
        run = wet(angle, mode)
        path = run.recorded()["space/push"].to_dataset().isel(step=-1)
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        along = float(c * path["H_x"] + s * path["H_y"]), float(c * path["M_y"] - s * path["M_x"])
        assert abs(float(c * path["H_y"] - s * path["H_x"])) < 1e-3 * along[0]
        height = path["depth_bounds"][:, 1] - path["depth_bounds"][:, 0]
        skirt = float(((c * path["p_x"] + s * path["p_y"]).sum("side") * height).sum())
        pore = float(np.abs(path["pore_pressure"]).max())
        found.append((*along, skirt, pore, float(path["cavitation_margin"])))
        assert run.record.status == "complete" and float(path["time"]) > 0.0
    heights = half["depth_bounds"][:, 1] - half["depth_bounds"][:, 0]
    known = float(half["H"]), float(half["M"]), float((half["p"] * heights).sum())
    assert found[1][:2] == pytest.approx(found[0][:2], rel=1e-3) and found[1][2] == pytest.approx(found[0][2], rel=2e-3)
    assert found[0][:3] == pytest.approx(known, rel=3e-3)
    assert found[0][3] == pytest.approx(float(np.abs(half["pore_pressure"]).max()), rel=0.12)  # at azimuths
    assert abs(known[0] / float(dry["H"][-1]) - 1.0) > 2e-3  # the water counts
    margins = float(half["cavitation_margin"]), found[0][4], found[1][4]
    suction = [ATMOSPHERE - VAPOUR + 5.0 * 9.81e3 - each for each in margins]
    near = 0.02 if mode == "coupled" else 0.16  # at one point near the tip, and at the azimuths of each model
    assert suction[1:] == pytest.approx([suction[0], suction[1]], rel=near)


def test_a_thin_caisson_bends_alike_in_any_direction():
    """Turned by 37 degrees within 0.15 %; beside the half model 0.5 %. Ten times softer than steel it carries less."""
    path = {"name": "push", "kind": "motion", **HELD}
    soft = {"mesh": WATER["mesh"], "caisson": {"behaviour": "elastic", "young_modulus": 20e9, "skirt_thickness": 0.03}}
    given = {"kind": "translation", "lateral_displacement": 2e-3}
    half, rigid = (compute(scene(path | given, **soft | more)).recorded()["paths/push"].to_dataset().isel(step=-1)
                   for more in ({}, {"caisson": {"skirt_thickness": 0.03}}))  # fmt: skip
    found = []
    for angle in (0.0, 37.0):
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        motion = {"u_x": 2e-3 * c} | ({"u_y": 2e-3 * s} if s else {})
        end = compute(scene(path | motion, **soft)).recorded()["space/push"].to_dataset().isel(step=-1)
        assert abs(float(c * end["H_y"] - s * end["H_x"])) < 2e-3 * float(half["H"])
        found.append((float(c * end["H_x"] + s * end["H_y"]), float(c * end["M_y"] - s * end["M_x"])))
    assert found[1] == pytest.approx(found[0], rel=1.5e-3)
    assert found[0] == pytest.approx((float(half["H"]), float(half["M"])), rel=5e-3)
    assert float(half["H"]) < 0.99 * float(rigid["H"])


def test_the_water_of_the_whole_model_balances():
    """What the soil loses stays in the gaps or flows out, on the way round a corner with both families."""
    path = ELBOW | {"duration": 20.0, "then": ["2 mm towards 90 deg in 1 min"]}
    work = prepare(scene(path, **WATER), Clock(), lambda *_: None)
    run = PathRun(work, work.scene.all_paths[0])
    run.run()
    balance = run.water.now(run.state.committed)
    assert run.collector.rows[-1]["time"] == pytest.approx(80.0)
    assert abs(balance.outflow) > 1e-6 and abs(balance.imbalance) < 1e-3 * balance.moved
    half = prepare(scene({"name": "p", "kind": "pull", "lateral_displacement": 1e-3, "rate": 5e-5}, **WATER), Clock(),
                   lambda *_: None)  # fmt: skip
    state = State(work.model_of(path_of(work)).built.model)
    state.trial.pressure[:, 0] = 1e3  # one pressure everywhere compresses twice what it does in the half model
    other = State(half.built.model)
    other.trial.pressure[:, 0] = 1e3
    volumes = [WaterBalance(each.system, each_state.committed).now(each_state.trial).compressed
               for each, each_state in ((work.model_of(path_of(work)), state), (half, other))]  # fmt: skip
    assert volumes[0] == pytest.approx(2.0 * volumes[1]) and volumes[0] > 0.0


def test_the_film_of_the_whole_model_flows_as_that_of_the_half_in_both_families():
    """Of each wave the flow along and around is twice that of half the circle, cos and sin alike."""
    pull, none = {"name": "p", "kind": "pull", "lateral_displacement": 1e-3, "rate": 5e-5}, lambda *_: None
    work = prepare(scene(ELBOW | {"duration": 20.0, "then": ["2 mm towards 90 deg in 1 min"]}, **WATER), Clock(), none)
    half, whole = (prepare(scene(pull, **WATER), Clock(), none).built.model, work.model_of(path_of(work)).built.model)

    def flow(model, slot):
        film, pressure = pack_film(model), np.zeros((model.n_pressures, len(model.numbers)))
        pressure[-model.water.film.n_nodes :, slot] = np.linspace(1e3, 2e3, model.water.film.n_nodes) ** 2
        rows = np.zeros_like(pressure)
        line_water(film, Step(1.0, 1.0), np.full(len(model.stations), 1e-4), pressure, rows)
        return -float((rows * pressure).sum())

    numbers = list(whole.numbers)
    assert sorted(numbers) == [0, 1, 1, 2, 2, 3, 3] and list(half.numbers) == [0, 1, 2, 3]
    flows = [flow(whole, slot) / flow(half, int(k)) for slot, k in enumerate(numbers)]
    assert flows == pytest.approx([2.0] * 7, rel=1e-9)
    assert flow(half, 2) > 1.01 * flow(half, 1)  # around, too


def path_of(work):
    return work.scene.all_paths[0]


def test_a_twist_turns_back_with_friction_and_moves_nothing_else():
    twist = table().loc["twist"]
    assert 5e-4 in twist["rot_z_rad"].round(12).tolist()
    assert twist["T_Nm"].max() > 0.0 > twist["T_Nm"].iloc[-1]
    assert np.abs(twist[["u_x_m", "u_y_m", "rot_x_rad", "rot_y_rad"]].to_numpy()).max() < 1e-9


def test_the_reactions_by_depth_lid_and_tip_carry_the_load():
    """p and torque of the skirt are most of H and of T, along the motion, and the rest of them is at lid and tip."""
    elbow = result()["space/elbow"].to_dataset()
    height = elbow["depth_bounds"][:, 1] - elbow["depth_bounds"][:, 0]
    skirt = {name: float((elbow[name].sum("side") * height).sum("depth")[-1]) for name in ("p_x", "p_y")}
    assert 0.8 < skirt["p_y"] / float(elbow["H_y"][-1]) < 1.0
    twist = result()["space/twist"].to_dataset()
    at = int(np.argmax(twist["T"].values))
    torque = float((twist["torque"].sum("side") * height).sum("depth")[at])
    assert 0.4 < torque / float(twist["T"][at]) < 1.0
    around = twist["shear_around"].sel(side="outside").isel(step=at)
    assert float(around.min()) > 0.0  # the caisson takes the soil along, everywhere


def test_reactions_by_depth_are_the_sums_of_the_fields_around_the_walls():
    """Normal stress and both shears at their azimuths, over both walls; K0 p' at the beginning (K0 is 1)."""
    path = result()["space/elbow"].to_dataset().isel(step=[0, -1])
    at_rest = path["normal_effective_stress"].isel(step=0) - 10.56e3 * (1.0 + path["depth"])
    assert np.abs(at_rest).max() < 1e-3
    angle, step = path["azimuth"].values[:, None], 2.0 * np.pi / path.sizes["azimuth"]
    for side, radius, sign in (("outside", 3.9, 1.0), ("inside", 3.9 - scene().caisson.skirt_thickness, -1.0)):
        at = path.isel(step=1).sel(side=side)
        normal, around, down = (at[name].transpose("azimuth", "depth").values for name in (
            "normal_effective_stress", "shear_around", "shear_vertical"))  # fmt: skip
        wanted = {
            "p_x": sign * normal * np.cos(angle) - around * np.sin(angle),
            "p_y": sign * normal * np.sin(angle) + around * np.cos(angle), "t": down, "torque": radius * around,
        }  # fmt: skip
        for name, parts in wanted.items():
            sums = radius * step * parts.sum(axis=0)
            np.testing.assert_allclose(at[name], sums, rtol=1e-6, atol=1e-6 * np.abs(normal).max(), err_msg=name)
    assert path["p_x"].sum() > 0.0 < path["p_y"].sum()
    load = result()["space/load"].to_dataset()
    height = load["depth_bounds"][:, 1] - load["depth_bounds"][:, 0]
    carried = (load["t"].sum("side") * height).sum("depth")
    assert 0.0 < float((carried[-1] - carried[0]) / (load["V"][-1] - load["V"][0])) < 1.0  # V grows


def test_the_first_part_of_a_path_is_that_of_the_half_model():
    """N 2 has other azimuths in the half circle: H within 1 %."""
    half = compute(scene({"name": "way", "kind": "translation", "lateral_displacement": 1e-3})).recorded()
    elbow = table().loc["elbow"]
    row = elbow[np.isclose(elbow["u_x_m"], 1e-3) & (elbow["u_y_m"] == 0.0)].iloc[-1]
    path = half["paths/way"].to_dataset()
    assert row["H_x_N"] == pytest.approx(float(path["H"][-1]), rel=0.01)
    assert row["M_y_Nm"] == pytest.approx(float(path["M"][-1]), rel=0.01)


@pytest.mark.slow
def test_a_turned_path_has_a_turned_answer():
    ends = []
    for angle in (0.0, 37.0):
        turned = {"direction": np.radians(angle), "then": [f"2 mm towards {90.0 + angle} deg"]}
        path = compute(scene(ELBOW | turned, mesh={"preset": "coarse", "harmonics": 3})).recorded()["space/elbow"]
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        back = np.array([[c, s], [-s, c]])
        ends.append([back @ [float(path[f"{name}_{axis}"][-1]) for axis in "xy"] for name in "HM"])
    for straight, turned in zip(*ends, strict=True):
        assert np.abs(turned - straight).max() < 0.02 * np.abs(straight).max()


def test_a_circle_goes_at_one_velocity():
    """The radius is eleven times as long as a side: in the same time its water would drain less."""
    given = scene({"name": "round", "kind": "circle", "radius": 5e-3, "duration": 60.0} | HELD, **WATER)
    stages = path_stages(given, given.all_paths[0], 0.0)
    ends = np.array([[0.0, 0.0], *(stage.target[:2] for stage in stages)])
    times = np.array([stage.duration for stage in stages])
    np.testing.assert_allclose(np.linalg.norm(np.diff(ends, axis=0), axis=1) / times, 5e-3 * 7.2812 / 60.0, rtol=1e-4)
    assert times.sum() == pytest.approx(60.0)


def test_a_circle_is_one_side_after_the_other_around():
    path = scene({"name": "round", "kind": "circle", "radius": 5e-3, "direction": np.pi / 2} | HELD).all_paths[0]
    stages = path_stages(scene(), path, 0.0)
    at = np.array([stage.target[:2] for stage in stages])
    np.testing.assert_allclose(at[0], [0.0, 5e-3], atol=1e-15)
    np.testing.assert_allclose(np.hypot(*at.T), 5e-3)
    np.testing.assert_allclose(at[-1], at[0], atol=1e-15)
    assert at[1, 0] < 0.0  # from +x towards +y
    assert np.unwrap(np.arctan2(at[:, 1], at[:, 0]))[[0, -1]].tolist() == pytest.approx([np.pi / 2, 2.5 * np.pi])
    assert sum(map(fewest_increments, stages)) > 2 * (len(stages) - 1)
    assert [stage.continues for stage in stages] == [False, False] + 71 * [True]


def test_parts_of_a_path_take_their_time_and_its_soil_relaxes_in_what_moves():
    """The dead load's w, from which an imposed one counts, is no motion of the path."""
    given = ELBOW | {"heave": "fixed", "duration": 60.0, "then": ["1 mm towards 90 deg in 10 min"]}
    path = scene(given).all_paths[0]
    stages = path_stages(scene(given), path, 0.0, rest=0.02)
    assert [stage.duration for stage in stages] == [60.0, 600.0]
    assert stages[0].lag == stages[1].lag == pytest.approx(3e-8 * 7.8 / 1e-3)
    assert [stage.target[-1] for stage in stages] == [0.02, 0.02]


def test_a_path_from_elsewhere_needs_no_engine():
    """Its rows, and the stiffness at rest: that of the half model and of torsion is the whole one's."""
    given, works = scene(TWIST), []
    for _ in range(2):
        works.append(prepare(given, Clock(), lambda *_: None))
        works[-1].take_up(False, "")
    path = given.all_paths[0]
    run = PathRun(works[0], path)
    run.run()
    for work in works:
        _take(work, path, run.gathered().saved())
    whole = works[1].model_of(path)
    assert "newton" not in vars(whole)
    assert works[1].paths["/space/twist"].identical(works[0].paths["/space/twist"])
    own = whole.newton.border_stiffness(State(whole.built.model))
    np.testing.assert_allclose(whole.stiffness, own, atol=1e-9 * np.abs(own).max())
    work_done = float(np.trapezoid(*(works[0].paths["/space/twist"][name] for name in ("T", "rot_z"))))
    assert works[0].figures["twist"].energy["work_J"] == pytest.approx(work_done, rel=1e-6)


def test_motions_are_judged_alike_in_any_direction():
    limit = DisplacementLimit(8.0, 4.0, 0.1, 0.1, rest=0.02)
    for u, w, turn in ((0.5, 0.02, -0.02), (0.1, 0.02, 0.06), (0.1, 0.4, 0.0)):
        for c, s in ((0.6, 0.8), (-1.0, 0.0)):
            space = np.array([c * u, s * u, w, -s * turn, c * turn, 0.0])
            assert limit.share(space) == pytest.approx(limit.share(np.array([u, w, turn])))
    assert limit.share(np.array([0.0, 0.0, 0.02, 0.0, 0.0, -0.15])) == pytest.approx(1.5)
    names = ("u_x", "u_y", "w", "rot_x", "rot_y", "rot_z")
    for motion, largest in (
        ((0.3, -0.4, 0.1, 0.03, 0.04, 0.1), (0.5, 0.05)),
        ((0.0, 0.1, -0.7, 0.0, -0.04, 0.1), (0.7, 0.04)),
        ((0.1, 0.0, 0.2, 0.0, 0.0, -0.1), (0.39, 0.0)),
    ):
        path = xr.Dataset({name: ("step", [0.0, value]) for name, value in zip(names, motion, strict=True)})
        assert largest_motion(path, 3.9) == pytest.approx(largest)


@pytest.mark.parametrize(("path", "sections", "text"), [
    (TWIST, {"mesh": {"discretisation": "hex8"}}, "bricks have half of a caisson"),
    (TWIST, {"drainage": {"mode": "coupled"}}, "needs duration here"),
    (ELBOW, {"drainage": {"mode": "coupled"}}, "needs duration here"),
    (PROBE | {"torsion_angle": 0.5}, {"drainage": {"mode": "coupled"}}, "needs duration here"),
    (ELBOW | {"duration": 9.0}, {"drainage": {"mode": "coupled"}}, "needs a time"),
    (TWIST, {"output": {"paraview": True}}, "half of a caisson"),
    (TWIST | {"role": "calibration"}, {}, 'role = "memory" or "held-back"'),
    ({"name": "a", "kind": "twist"} | HELD, {}, "needs twist"),
    ({"name": "a", "kind": "motion"} | HELD, {}, "needs one of u_x"),
    (PROBE | {"load_angle": None, "torsion_angle": 0.5}, {}, "needs a load_angle"),
    (PROBE | {"lateral_displacement": None, "torsion_angle": 0.5}, {}, "needs lateral_displacement"),
    (PULL | {"torsion_angle": 0.5} | HELD, {}, "torsion_angle: a path of kind \"pull\""),
    (TWIST | {"H_x": 1e6}, {}, "does not use it"),
    (PULL | {"T": 1e6} | HELD, {}, "does not use it"),
    (TWIST | {"then": ["rest 1 hour"]}, {}, 'goes on with "20 mrad" alone'),
    (ELBOW | {"then": ["2 mm towards 90 deg", "3 mm"]}, {}, 'goes on with "12 mm towards 90 deg" alone'),
    (MOTION | {"then": ["2 mm"]}, {}, "does not use it"),
    (LOAD | {"heave": "fixed"}, {}, "cannot have a vertical load"),
    (PULL | {"T": 0.0} | HELD, {}, "T: a path of kind \"pull\" that leaves a plane does not use it"),
    (TWIST | {"report_at": (2e-3,)}, {}, "is not on the way from 0 to twist"),
    ({"name": "a", "kind": "vertical", "vertical_displacement": 1e-3, "then": ["2 mm towards 9 deg"]} | HELD,
     {}, "cannot go on in another direction"),
    ({"name": "a", "kind": "vertical", "vertical_displacement": 1e-3, "direction": 1.0}, {}, "does not use it"),
    ({"name": "a", "kind": "pull", "lateral_displacement": 1e-3, "twist": 0.1}, {}, "does not use it"),
    (ELBOW | {"then": ["-2 mm towards 90 deg"]}, {}, "must be positive"),
])  # fmt: skip
def test_what_cannot_be_is_refused_in_one_line(path, sections, text):
    with pytest.raises((UserInputError, ValueError), match=text) as caught:
        Scene(**{"domain": PAPER, "soil": PAPER_SOIL, "paths": (path,)} | sections)
    assert sum(text in line for line in str(caught.value).splitlines()) == 1


def test_paths_survive_a_scene_file_and_count_in_its_digest():
    given = scene(*PATHS)
    again = parse_scene(given.to_toml())
    assert again == given and again.sha256 == given.sha256
    for change in ({"T": 6e5}, {"V": 3e6}):
        assert scene(*PATHS[:4], LOAD | change, MOTION).sha256 != given.sha256
    assert tiny.sand(paths=(PULL,)).sha256 != tiny.sand(paths=({**PULL, "direction": 0.1},)).sha256


def test_a_run_without_a_path_in_one_plane_has_no_springs():
    run = compute(scene(TWIST))
    assert run.record.status == "complete"
    assert "paths" not in run.tree.children
    assert isinstance(load_displacement(run.recorded()), pd.DataFrame)
    end = run.record.paths["twist"].end
    assert set(end) == {*MOTIONS, *LOADS} and end["T"] < 0.0
    assert run.record.paths["twist"].energy["imbalance_over_largest_term"] < 1e-3
    assert any(
        "off a plane, reactions of one mesh, not extrapolated" in text and "twist" in text
        for text in run.record.remarks
    )


def test_runs_of_a_path_off_a_plane_are_compared_after_equal_ways():
    """Whatever their steps: an elbow of loads that grow along x, then along y; the coarser run is 5 % stiffer."""

    def elbow(n, factor, end=2.0):
        x = np.concatenate([np.linspace(0.0, 1.0, n), np.ones(2 * n)])
        y = np.concatenate([np.zeros(n), np.linspace(0.0, end - 1.0, 2 * n)])
        zero, up = 0.0 * x, np.concatenate([np.linspace(0.0, 4.0, n), np.full(2 * n, 4.0)])
        values = {"u_x": x, "u_y": y, "rot_x": zero, "rot_y": zero, "rot_z": zero, "H_x": factor * (x - 0.5 * y),
                  "H_y": factor * y, "M_x": zero, "M_y": -factor * up, "T": factor * y}  # fmt: skip
        return xr.Dataset({name: ("step", value) for name, value in values.items()}, attrs={"kind": "translation"})

    for coarse, wanted in ((elbow(11, 1.05), 5.0), (elbow(11, 0.97, 1.6), 3.0), (elbow(11, 1.0), 0.0)):
        assert off_plane_error(elbow(7, 1.0), coarse, 4.0, 2.0) == pytest.approx(wanted, abs=0.15)
    assert np.isnan(off_plane_error(elbow(7, 1.0), elbow(7, 1.0).isel(step=[0]), 4.0, 2.0))


def test_a_run_estimates_the_error_of_a_path_off_a_plane():
    """The estimate covers what a finer section and more harmonics change; harmonics that a scene names stay."""
    given = scene(TWIST, mesh={"preset": "coarse", "harmonics": 1})
    estimated = with_estimate(given, compute(given), companions_of(given, compute), compute)
    found = estimated.record.error_estimate
    assert found["by_path"]["twist"]["load_pct"] == found["estimate_pct"]["load_max"] and found["harmonics"] == [1, 3]
    fine = compute(scene(TWIST, mesh={"preset": "coarse", "harmonics": 1, "refinement": 1.6})).recorded()
    paths = [each["space/twist"].to_dataset() for each in (fine, estimated.recorded())]
    assert 0.01 < off_plane_error(*paths, 4.0, 3.9) < found["estimate_pct"]["load_max"] < 20.0


def test_the_summary_has_loads_and_motions_by_components(tmp_path):
    turned = {"name": "turned", "kind": "twist", "twist": 1e-3} | HELD
    small = scene(turned, mesh={"preset": "coarse", "harmonics": 1, "refinement": 0.6})
    record = read_record(run_to_folder(small, tmp_path / "out", estimate_error=False))
    end = record["paths"]["turned"]["end"]
    loads = f"V {1e-6 * end['V']:.3g} MN; T {1e-6 * end['T']:.3g} MN m"
    assert record["summary"]["off a plane"] == f"turned: {loads}; rot_z 1 mrad"
    assert record["summary"]["springs"] == "none: there is no path in one plane"
    tree = open_result(tmp_path / "out" / "full_model.nc")
    left = RunRecord.read(tmp_path / "out")
    left.paths["turned"].end["M_x"] = 5e-6 * max(abs(end["T"]), small.caisson.skirt_length * end["V"])  # of iteration
    assert summary(tree, left)["off a plane"] == record["summary"]["off a plane"]
    states = tree["space/turned"].to_dataset()
    margin = np.where(states["step"] < 4, 1e5, -1.0)
    tree["space/turned"].dataset = states.assign(cavitation_margin=("step", margin))
    text = summary(tree, RunRecord.read(tmp_path / "out"))["off a plane"]
    assert text.startswith("turned before cavitation: V ") and f"; T {1e-6 * float(states['T'][3]):.3g} MN m;" in text
