# SPDX-License-Identifier: MIT
"""Whole runs on a tiny mesh: what the result holds, what decides it, and how a run ends that cannot go on."""

import warnings
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from fe_engine.errors import LinearSolverError
from fe_engine.solve import step_size
from fe_engine.solve.newton import Newton
from pysprings.core import variables
from pysprings.core.errors import ResourceError, RunIncomplete, UserInputError
from pysprings.core.path_kinds import LOADS, MOTIONS
from pysprings.core.words import Diagnosis, StopReason
from pysprings.full_model import work
from pysprings.full_model.compute import compute, run
from pysprings.full_model.diagnosis import too_far
from pysprings.full_model.result_tree import raise_if_incomplete
from pysprings.full_model.run_record import LimitLoad, RunRecord
from pysprings.macro.comparison import compare
from pysprings.results.parts import settings
from pysprings.springs.checks import extract_springs
from pysprings.springs.springs import Springs
from pysprings.springs.sums import balance
from tests.support import tiny
from tests.support.files import record_of


def end(result: xr.DataTree, name: str, path: str = "pull") -> float:
    return float(result[f"paths/{path}/{name}"][-1])


# --- a run that goes well ---


def test_every_variable_is_in_the_table_with_units_and_dimensions() -> None:
    assert variables.tree_problems(tiny.result(), "result") == []


def test_the_path_ends_where_the_scene_says() -> None:
    path = tiny.result()["paths/pull"]
    assert path.attrs["status"] == "complete"
    assert float(path["u"][0]) == 0.0
    assert abs(float(path["H"][0])) < 1e-12 * abs(float(path["H"][-1]))  # the rings' initial pressures cancel
    assert end(tiny.result(), "u") == pytest.approx(0.5e-3, rel=1e-9)
    assert (np.diff(path["u"]) > 0).all() and (np.diff(path["H"]) > 0).all()
    assert end(tiny.result(), "rotation") > 0.0  # a pull at the lid with free head
    assert abs(end(tiny.result(), "M")) < 1e-4 * end(tiny.result(), "H") * 4.0
    assert (path["converged"] == 1).all()


def test_reactions_balance_forces_and_moments() -> None:
    result = tiny.result()
    missing = balance(Springs.of(extract_springs(result)).path().dataset)
    assert max(missing.values()) < 1e-6
    path = result["paths/pull"].to_dataset(inherit=False)
    for load in "HVM":
        parts = sum(path[f"{load}_{part}"] for part in ("outer", "inner", "lid", "tip"))
        if load == "M":  # that of the tip is about its own depth
            parts = parts - 4.0 * path["H_tip"]
        np.testing.assert_allclose(parts, path[load], rtol=1e-9, atol=1e-3)
    np.testing.assert_allclose(path["V"], result.attrs["vertical_load_N"], rtol=1e-5)


def test_the_macro_model_follows_its_own_path() -> None:
    frame = compare(extract_springs(tiny.result())).set_index("springs")
    for answer in ("H", "rotation"):
        assert abs(frame.loc["full", f"{answer}_error_max_pct"]) < 2.0
    assert np.isfinite(frame.loc["py", "H_error_max_pct"])


def test_the_initial_stiffness_is_that_of_a_small_translation() -> None:
    stiffness = tiny.result()["stiffness_initial"].values
    # symmetric up to the friction of the first slip
    assert stiffness[0, 2] == pytest.approx(stiffness[2, 0], rel=1e-6)
    small = run(tiny.scene(paths=[{"name": "t", "kind": "translation", "lateral_displacement": 1e-8}]))
    assert end(small, "H", "t") / 1e-8 == pytest.approx(stiffness[0, 0], rel=1e-2)
    assert end(small, "M", "t") / 1e-8 == pytest.approx(stiffness[2, 0], rel=1e-2)


def test_attributes_and_record() -> None:
    scene, result = tiny.scene(), tiny.result()
    record = record_of(result)
    assert result.attrs["status"] == record["status"] == "complete"
    assert result.attrs["scene_sha256"] == record["scene_sha256"] == scene.sha256
    assert tiny.parsed(result.attrs["scene_toml"]) == tiny.parsed(record["scene_toml"]) == scene
    assert "scene_toml_given" not in result.attrs
    assert result.attrs["n_nodes"] == record["mesh"]["nodes"] == 216
    assert result.attrs["n_unknowns"] == record["mesh"]["unknowns"]
    assert result.attrs["lid_thickness_m"] == settings(result)["lid_thickness_m"] == 0.4
    path = record["paths"]["pull"]
    assert path["increments"] == result["paths/pull"].sizes["step"] - 1
    assert path["cut_backs"] == len(path["cut_backs_at"])
    assert path["worst_residual"] <= record["solver"]["tolerance"]
    assert path["contact_rings"]["isolated_open"] == 0
    spent = path["iterations"] + path["iterations_in_cut_backs"]
    assert record["solver"]["factorisations"] == spent + 1  # and that of the initial stiffness
    assert record["peak_memory_bytes"] > 1e7
    assert {entry["what"] for entry in record["left_out"]}


def test_phases_add_up_to_wall_and_cpu_time() -> None:
    record = record_of(tiny.result())
    assert set(record["phases"]) == {"mesh", "set-up", "assembly", "factorisation", "solve", "output", "other"}
    for key in ("wall_s", "cpu_s"):
        assert sum(phase[key] for phase in record["phases"].values()) == pytest.approx(record[key], abs=0.01)


def test_the_convergence_group_has_every_iteration() -> None:
    result = tiny.result()
    group, path = result["paths/pull/convergence"], record_of(result)["paths"]["pull"]
    iterations = int((group["iteration"] > 0).sum())
    assert iterations == path["iterations"] + path["iterations_in_cut_backs"]
    assert int(group["increment"].max()) == path["increments"]


# --- what decides a result ---


def test_friction_carries_part_of_the_load() -> None:
    """The coefficient of the scene arrives in the law: without friction the load is lower, with more it is higher."""
    load = {0.5: end(tiny.result(), "H")}
    for mu in (0.0, 0.1):
        load[mu] = end(run(tiny.scene(interface={"friction_coefficient": mu})), "H")
    assert load[0.0] < 0.75 * load[0.5]
    assert load[0.0] < load[0.1] < load[0.5]


def test_report_at_lands_on_its_values() -> None:
    path = {**tiny.PULL, "report_at": (0.1e-3, 0.33e-3)}
    u = run(tiny.scene(paths=(path,)))["paths/pull/u"].values
    assert min(abs(u - 0.1e-3)) < 1e-15 and min(abs(u - 0.33e-3)) < 1e-15


def test_a_rate_gives_the_time_of_each_step() -> None:
    path = run(tiny.scene(paths=({**tiny.PULL, "rate": 0.05e-3},)))["paths/pull"]
    np.testing.assert_allclose(path["time"], path["u"] / 0.05e-3, atol=1e-12)
    assert path.attrs["rate_m_per_s"] == 0.05e-3
    assert (tiny.result()["paths/pull/time"] == 0.0).all()


def test_kinds_of_paths_in_one_run() -> None:
    paths = (
        {"name": "push", "kind": "translation", "lateral_displacement": 1e-4, "heave": "fixed"},
        {"name": "turn", "kind": "rotation", "rotation": 1e-5},
        {"name": "wind", "kind": "load", "lateral_force": 1e5, "arm": 10.0, "role": "held-back"},
    )
    result = run(tiny.scene(paths=paths))
    assert list(result["paths"].children) == ["push", "turn", "wind"]
    assert np.abs(result["paths/push/rotation"]).max() < 1e-18 and np.abs(result["paths/push/w"]).max() < 1e-18
    assert end(result, "rotation", "turn") == pytest.approx(1e-5) and abs(end(result, "u", "turn")) < 1e-18
    assert end(result, "H", "wind") == pytest.approx(1e5, rel=1e-5)
    assert end(result, "M", "wind") == pytest.approx(1e6, rel=1e-5)
    assert result["paths/wind"].attrs["role"] == "held-back"
    assert compare(extract_springs(result)).shape[0] == 12  # push and turn make a fan, and the set pisa


def test_a_dead_load_settles_the_caisson_before_the_path() -> None:
    result = run(tiny.scene(caisson={"vertical_load": "1.5 MN"}))
    path = result["paths/pull"]
    assert float(path["w"][0]) > 0.0 and float(path["u"][0]) == pytest.approx(0.0, abs=1e-15)
    np.testing.assert_allclose(path["V"], 1.5e6, rtol=1e-5)
    assert result.attrs["vertical_load_N"] == pytest.approx(1.5e6)
    assert float(path["F_in"][0]) == float(path["F_out"][0]) == 0.0
    steps = result["paths/pull/convergence/increment"].values
    assert steps.min() < 1 and steps.max() == path.sizes["step"] - 1
    assert record_of(result)["paths"]["pull"]["increments_of_dead_load"] == 1 - steps.min()


def test_another_mesh_is_recorded_as_the_scene_that_ran() -> None:
    text = "# mine\n" + tiny.scene(mesh={"refinement": 0.3, "preset": "coarse"}).to_toml()
    given = tiny.parsed(text)
    ran = given.replace(mesh={"preset": "medium"})
    result = run(given, mesh="medium", linear="superlu")
    ran = ran.replace(solver={"linear": "superlu"})
    assert result.attrs["mesh_preset"] == "medium"
    assert result.attrs["solver"] == record_of(result)["solver"]["linear"] == "superlu"
    assert result.attrs["scene_sha256"] == record_of(result)["scene_sha256"] == ran.sha256
    assert tiny.parsed(result.attrs["scene_toml"]) == tiny.parsed(record_of(result)["scene_toml"]) == ran
    assert result.attrs["scene_toml_given"] == text
    assert result.equals(run(ran))


def test_the_users_own_words_are_kept_when_nothing_is_changed() -> None:
    text = "# mine\n" + tiny.scene().to_toml()
    result = run(tiny.parsed(text), mesh="coarse")
    assert result.attrs["scene_toml"] == text
    assert "scene_toml_given" not in result.attrs


def test_what_the_scene_leaves_out_is_not_there() -> None:
    result = run(tiny.scene(output={"interface_fields": False, "section": False}))
    assert variables.tree_problems(result, "result") == []
    path = result["paths/pull"]
    assert not {"gap", "normal_effective_stress", "section_ux"} & set(path.data_vars)
    xr.testing.assert_identical(path["p_component"].drop_attrs(), tiny.result()["paths/pull/p_component"].drop_attrs())
    assert record_of(result)["paths"]["pull"]["contact_rings"] is None


def test_progress_is_told_by_path() -> None:
    """The model with its size, then each increment with its share of the path and its iterations."""
    noted: list[tuple[str, float, str]] = []
    scene = tiny.scene(caisson={"vertical_load": "1 MN"}, paths=({**tiny.PULL, "then": ["0 mm"], "role": "held-back"},))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = run(scene, progress=lambda *args: noted.append(args))
    nodes, unknowns = result.attrs["n_nodes"], result.attrs["n_unknowns"]
    assert noted[:2] == [("model", 0.0, "mesh"), ("model", 1.0, f"{nodes} nodes, {unknowns} unknowns")]
    record = result["paths/pull/convergence"].to_dataset()
    dead = int((record["increment"] < 1).any())
    assert dead and noted[2] == ("pull", 0.0, "dead load")
    own = [each for each in noted[2:] if each[2] != "dead load"]
    path = result["paths/pull"]
    assert len(own) == path.sizes["step"] - 1 and {name for name, *_ in own} == {"pull"}
    for step, (_, fraction, message) in enumerate(own, start=1):
        rows = record.isel(iteration=np.flatnonzero(record["increment"].values == step))
        last = rows["iteration"].values[rows["attempt"].values == rows["attempt"].values.max()]
        assert message == f"step {step}, {len(last) - 1} iterations"
        travelled = float(np.abs(np.diff(path["u"].values[: step + 1])).sum())
        assert fraction == pytest.approx(travelled / 1e-3, rel=1e-6)  # there, and back


# --- a run that ends early ---


def test_a_path_that_cannot_converge_is_kept_up_to_there(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its message has the part of the path, the reason, the place and the last residuals."""
    monkeypatch.setattr(step_size, "SMALLEST", 0.02)  # no endless halving
    scene = tiny.scene(solver={"max_iterations": 2, "tolerance": 1e-8, "max_step_fraction": 0.3})
    with pytest.warns(UserWarning, match="path 'pull' stopped on its way to"):
        result = run(scene)
    assert result.attrs["status"] == result["paths/pull"].attrs["status"] == "partial"
    path, record = result["paths/pull"], record_of(result)
    assert 0.0 < float(path["u"][-1]) < 0.5e-3
    assert (path["converged"] == 1).all()
    (failure,) = record["failures"]
    last = record["paths"]["pull"]["cut_backs_at"][-1]
    assert f"(no convergence in 2 iterations ({last['place']}); last residuals: " in failure
    percent = float(failure.partition(" on its way to ")[2].partition(" %")[0])
    assert percent == pytest.approx(100 * last["load_fraction"], rel=1e-3)
    assert "direction" in last["place"] and "x=" in last["place"]
    assert last["iterations"] == 2 and len(last["last_residuals"]) == 3
    group = result["paths/pull/convergence"]
    failed = group["increment"] == path.sizes["step"]  # the step that was never reached: its attempts are recorded
    assert int(failed.sum()) >= 3
    assert float(group["residual"][failed][-1]) == pytest.approx(last["last_residuals"][-1], rel=0.01)
    assert len(record["paths"]["pull"]["cut_backs_at"]) == record["paths"]["pull"]["cut_backs"] >= 1
    with pytest.raises(RunIncomplete, match="no convergence in 2 iterations") as stopped:
        raise_if_incomplete(compute(scene))
    assert [str(reason) for reason in stopped.value.reasons] == [record["paths"]["pull"]["reason"]]
    assert f" %: {record['paths']['pull']['reason']}" in failure


def test_a_first_step_that_fails_leaves_the_initial_state_and_the_record() -> None:
    result = compute(tiny.stuck_scene()).recorded()
    assert result["paths/pull"].sizes["step"] == 1
    assert result["paths/pull/convergence"].sizes["iteration"] >= 3
    assert variables.tree_problems(result, "result") == []
    with pytest.raises(UserInputError, match="no springs can be made"):
        extract_springs(result)


def test_a_load_that_the_soil_does_not_carry_ends_in_a_limit_load() -> None:
    """It is a result: no failure, and the record has loads, motion and criterion of the last converged state."""
    computed = compute(tiny.overloaded_scene())
    raise_if_incomplete(computed)
    result = computed.recorded()
    record = record_of(result)
    assert (record["status"], record["failures"]) == ("complete", [])
    path, limit = result["paths/storm"], record["paths"]["storm"]["limit_load"]
    assert path.attrs["status"] == record["paths"]["storm"]["status"] == "limit load"
    assert "the caisson has moved by" in limit["criterion"]
    assert limit["criterion"].startswith("limit load: ")
    keys = {"H": "H_N", "V": "V_N", "M": "M_Nm", "u": "u_m", "w": "w_m", "rotation": "rotation_rad"}
    assert {key: limit[key] for key in keys.values()} == {key: float(path[name][-1]) for name, key in keys.items()}
    assert np.abs(path["u"][:-1]).max() < 0.1 * 7.8
    assert 1e6 < float(path["H"][-1]) < 1e7
    assert RunRecord.of(result) == computed.record


CLAY = {"friction_angle_initial": 0.0, "friction_angle_final": 0.0, "cohesion": 40e3, "young_modulus": 20e6}
SOFT = {"yield_surface": "elastic", "young_modulus": 1e6}


@pytest.mark.parametrize(("soil", "reason"), [(CLAY, "limit load"), (SOFT, "displacement limit")])
def test_a_load_ends_where_the_caisson_has_moved_too_far(soil: dict[str, Any], reason: str) -> None:
    """Clay as cohesion alone has no peak: it went on to 4 m and 72 deg. A soft soil still resists: another name."""
    path = {"name": "storm", "kind": "load", "lateral_force": 2e7, "arm": 10.0}
    steps = {"first_step_fraction": 0.02, "max_step_fraction": 0.1}
    result = compute(tiny.scene(soil=soil, solver=steps, paths=(path,))).recorded()
    figures = record_of(result)["paths"]["storm"]
    assert (figures["status"], figures["reason"]) == ("limit load", reason)
    assert figures["limit_load"]["criterion"].startswith(f"{reason}: the caisson has moved by ")
    assert "(limit 10 % of the diameter, 5 deg)" in figures["limit_load"]["criterion"]
    data = result["paths/storm"]
    tip = data["u"] + 4.0 * data["rotation"]
    share = np.max([np.abs(data["u"]) / 0.78, np.abs(tip) / 0.78, np.abs(np.rad2deg(data["rotation"])) / 5.0], axis=0)
    assert (share[:-1] <= 1.0).all()
    assert 1.0 < share[-1] <= 1.1
    assert (data["converged"] == 1).all()


def test_motions_that_are_imposed_do_not_show_what_is_left_of_the_stiffness() -> None:
    """A probe of a capacity imposes a motion: at its limit no share of the initial stiffness is stated."""
    driver: Any = SimpleNamespace(stiffness=None)
    assert too_far(driver, np.eye(3), "it has moved") == Diagnosis(StopReason.DISPLACEMENT_LIMIT, "it has moved")
    driver = SimpleNamespace(stiffness=0.996, newton=SimpleNamespace(scale=np.ones(3)))
    assert too_far(driver, np.eye(3), "it has moved").detail == "it has moved; 100 % of the initial stiffness is left"


def test_what_the_solver_leaves_of_zero_is_no_part_of_a_limit_load() -> None:
    text = str(LimitLoad(2.4e6, 4.4e-3, -8.2, 0.438, 0.0, 0.0, "x"))
    assert text.startswith("H = 2400 kN, M = 0 kN m, V = 0 kN at u = 438 mm")


@pytest.mark.parametrize(
    ("loads", "words"),
    [
        ({"H_x": 3e6, "H_y": -4e6, "M_y": 5e6, "T": 9e6}, "H = 5000 kN, M = 5000 kN m, V = 2000 kN, T = 9000 kN m"),
        ({"T": -9e6}, "H = 0 kN, M = 0 kN m, V = 2000 kN, T = -9000 kN m at u = 0 mm, rotation = 0 deg"),
    ],
)  # fmt: skip
def test_a_limit_load_off_a_plane_has_its_torsion(loads: dict[str, float], words: str) -> None:
    """T alone is no vertical load: V is the dead load then, and no limit."""
    end = dict.fromkeys((*MOTIONS, *LOADS), 1e-12) | {"V": 2e6, "rot_z": -0.1} | loads
    limit = LimitLoad.at(end, "x")
    assert not limit.is_vertical and str(limit).startswith(words)
    again = LimitLoad.from_dict({name: getattr(limit, name) for name in limit.__dataclass_fields__})
    assert again.T_Nm == loads["T"] and str(limit).endswith("twist = -5.73 deg (x)")
    planar = dict.fromkeys(("u", "w", "rotation", "H", "M"), 1e-12) | {"V": 2e6}
    assert LimitLoad.at(planar, "x").is_vertical and "T = " not in str(LimitLoad.at(planar | {"H": 1e6}, "x"))


def test_the_largest_motion_under_a_load_is_a_key_of_the_scene() -> None:
    """The same load with 2 % of the diameter ends earlier, at a smaller load; the number of the scene is another."""
    ends = []
    for share in (0.1, 0.02):
        scene = tiny.overloaded_scene(limit={"displacement_over_diameter": share})
        path = compute(scene).tree["paths/storm"]
        moved = np.abs([path["u"][-1], path["w"][-1] - path["w"][0]]).max() / (share * 7.8)
        assert 1.0 < max(moved, float(np.abs(path["rotation"][-1])) / np.radians(5.0)) <= 1.1
        ends.append((scene.sha256, float(path["H"][-1])))
    assert ends[0][0] == tiny.overloaded_scene().sha256 != ends[1][0]
    assert ends[1][1] < ends[0][1]


def test_a_pull_goes_as_far_as_it_is_told() -> None:
    """Only a given load is stopped: an imposed displacement beyond a tenth of the diameter is run, and named."""
    path = {"name": "pull", "kind": "pull", "lateral_displacement": 1.0}
    result = compute(tiny.scene(soil=SOFT, interface={"friction_coefficient": 0.0}, paths=(path,))).recorded()
    assert end(result, "u") == pytest.approx(1.0)
    assert record_of(result)["failures"] == []


def test_a_dead_load_that_the_soil_does_not_carry() -> None:
    """The state it reached is kept as the path's first, marked as not converged."""
    lift = tiny.scene(caisson={"vertical_load": "-3 MN"}, interface={"friction_coefficient": 0.05})
    result = compute(lift).recorded()
    (failure,) = record_of(result)["failures"]
    assert "stopped during its dead load: " in failure
    path = result["paths/pull"]
    assert path["converged"].values.tolist() == [0]
    assert record_of(result)["paths"]["pull"]["cut_backs_at"][-1]["stage"] == "dead load"
    assert path["convergence/increment"].values.max() == 0


def test_other_paths_go_on_after_one_that_stopped() -> None:
    storm = tiny.overloaded_scene().paths[0].model_dump()
    scene = tiny.scene(paths=(storm, tiny.PULL), interface={"friction_coefficient": 0.0})
    result = compute(scene).recorded()
    assert [result[f"paths/{name}"].attrs["status"] for name in ("storm", "pull")] == ["limit load", "complete"]
    assert result.attrs["status"] == "complete"


def test_an_interrupt_keeps_the_converged_steps() -> None:
    def progress(path: str, fraction: float, _message: str) -> None:
        if path == "pull" and fraction > 0.2:
            raise KeyboardInterrupt

    done = compute(tiny.scene(paths=(tiny.PULL, {**tiny.PULL, "name": "later"})), progress=progress)
    result = done.recorded()
    path = result["paths/pull"]
    assert result.attrs["status"] == path.attrs["status"] == "interrupted"
    assert path.sizes["step"] >= 3 and float(path["u"][-1]) < 0.5e-3
    np.testing.assert_allclose(path["H"], tiny.result()["paths/pull/H"][: path.sizes["step"]], rtol=1e-9)
    assert list(result["paths"].children) == ["pull"]
    with pytest.raises(KeyboardInterrupt):
        raise_if_incomplete(done)


def test_a_linear_solver_that_is_not_there_is_a_missing_resource(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(*_: object, **_options: object) -> None:
        raise LinearSolverError("pardiso does not load here: no library")

    monkeypatch.setattr(work, "LinearSolver", missing)
    with pytest.raises(ResourceError, match="pardiso does not load here"):
        run(tiny.scene())


def test_a_singular_start_is_a_run_that_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    def singular(*_: object) -> None:
        raise LinearSolverError("zero pivot")

    monkeypatch.setattr(Newton, "border_stiffness", singular)
    with pytest.raises(RunIncomplete, match="stiffness of the initial state cannot be computed: zero pivot"):
        run(tiny.scene())


def test_a_swipe_turns_at_the_displacement_it_has_reached() -> None:
    path = {"name": "swipe", "kind": "swipe", "lateral_displacement": 2e-4, "rotation": 5e-5, "role": "held-back"}
    swipe = run(tiny.scene(paths=(path,)))["paths/swipe"].to_dataset()
    turned = np.abs(swipe["rotation"].values) > 1e-12
    assert 1 < turned.sum() < turned.size - 1
    np.testing.assert_allclose(swipe["u"][turned], 2e-4, rtol=1e-9)
    assert float(swipe["rotation"][-1]) == pytest.approx(5e-5)
    assert float(swipe["H"][-1]) < float(swipe["H"][~turned][-1])  # H falls while the caisson turns back
    np.testing.assert_allclose(swipe["V"], swipe["V"][0], rtol=1e-4)


def test_a_probe_keeps_the_direction_of_its_load() -> None:
    """In elastic soil without friction losses its motion is that of the initial stiffness under the same load."""
    angle, diameter = -1.0, 7.8
    path = {"name": "probe", "kind": "probe", "lateral_displacement": 1e-5, "load_angle": angle, "role": "held-back"}
    result = run(tiny.scene(paths=(path,), soil={"yield_surface": "elastic"}, interface={"friction_coefficient": 5.0}))
    probe = result["paths/probe"].to_dataset()
    assert probe.attrs["load_angle_rad"] == angle
    H, M = probe["H"].values[1:], probe["M"].values[1:]
    np.testing.assert_allclose(M / diameter * np.cos(angle), H * np.sin(angle), rtol=1e-6)
    u, rotation = probe["u"].values, probe["rotation"].values
    assert u[-1] * np.cos(angle) + rotation[-1] * diameter * np.sin(angle) == pytest.approx(1e-5)
    motion = np.linalg.solve(result["stiffness_initial"].values, [H[0], 0.0, M[0]])
    np.testing.assert_allclose([u[1], rotation[1]], motion[[0, 2]], rtol=1e-2)
