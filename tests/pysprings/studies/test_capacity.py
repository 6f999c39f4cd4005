# SPDX-License-Identifier: MIT
"""The capacity study: its runs, the criterion of failure, chords of the envelope, files, and a run that goes on."""

import json
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from pysprings.core import version
from pysprings.core.errors import UserInputError
from pysprings.core.storage import write_tree
from pysprings.core.tables.load_cases import LoadCases, read_load_cases
from pysprings.core.words import StopReason
from pysprings.full_model.run_record import MeshFigures, RunRecord, Status
from pysprings.scene.design_strength import StrengthFactors
from pysprings.springs.checks import RESULT, save_springs
from pysprings.springs.springs import Springs
from pysprings.studies import stored_runs
from pysprings.studies.capacity import picture, plan, points, study
from pysprings.studies.capacity.envelope import utilisation
from pysprings.studies.capacity.picture import envelopes
from pysprings.studies.capacity.points import Capacity, Criterion, assess
from tests.support import rates, synthetic, tiny, vertical
from tests.support.commands import command
from tests.support.place import ROOT

SCENE = tiny.scene()
D, L = SCENE.caisson.outer_diameter, SCENE.caisson.skirt_length


def group(load: float | str = 1e6) -> plan.Group:
    return plan.Group(plan.CHARACTERISTIC, load, SCENE)


def test_directions_fill_half_the_plane() -> None:
    np.testing.assert_allclose(np.degrees(plan.angles(8)), [-67.5, -45, -22.5, 0, 22.5, 45, 67.5, 90])
    with pytest.raises(UserInputError, match=r"--directions: 1 is not in \[2, 72\]"):
        plan.Request((1e6,), directions=1)


def test_groups_are_loads_by_strengths() -> None:
    request = plan.Request(("balanced", 2e6, 2e6), factors=StrengthFactors(tan_phi=1.25))
    names = [each.name for each in plan.groups(SCENE, request)]
    assert names == ["characteristic-balanced", "characteristic-V2000kN", "design-balanced", "design-V2000kN"]


@pytest.mark.parametrize("angle", [-math.pi / 2, -0.3, 0.0, 1.2])
def test_probes_reach_the_limit_of_motion(angle: float) -> None:
    """No motion within 10 % of D and 5 degrees has a larger conjugate displacement than that imposed."""
    scene = group().probe((angle, 0.0))
    (path,) = scene.paths
    assert (path.kind, path.load_angle) == ("probe", angle)
    assert scene.caisson.vertical_load == 1e6 != SCENE.caisson.vertical_load  # that its files state, and springs answer
    u, turn = 0.1 * D * np.sign(math.cos(angle)), math.radians(5.0) * np.sign(math.sin(angle))
    assert path.lateral_displacement == pytest.approx(u * math.cos(angle) + turn * D * math.sin(angle))


def test_rays_cover_the_limit_of_motion() -> None:
    """At the limit of motion in any direction rho is within the range of both rays beside it."""
    paths = group().rays().paths
    assert len(paths) == len(plan.RAYS)
    ends = [(each.lateral_displacement or 0.0, (each.rotation or 0.0) * L) for each in paths]
    angle = np.array([math.atan2(v, u) for u, v in ends])
    rho = np.array([math.hypot(u, v) for u, v in ends])
    np.testing.assert_allclose(np.degrees(angle), plan.RAYS)
    for degrees in np.linspace(-89.9, 89.9, 181):
        u, v = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        at_limit = 1.0 / max(abs(u) / (0.1 * D), abs(u - v) / (0.1 * D), abs(v) / L / math.radians(5.0))
        above = int(np.searchsorted(angle, math.radians(degrees)))
        beside = [rho[above - 1], rho[above % len(rho)]]  # above the last ray is the mirror image of the first
        assert min(beside) > at_limit, degrees


def test_with_torsion_every_direction_leaves_the_plane_and_torsion_alone_is_one() -> None:
    request = plan.Request((1e6,), directions=2, torsion=(math.pi / 2, math.radians(30.0)))
    names = [group().probe_name(each) for each in request.all_directions]
    ends = ["+0deg", "+90deg", "+0deg-T30deg", "+90deg-T30deg", "+0deg-T90deg"]
    assert names == [f"characteristic-V1000kN-{end}" for end in ends]
    series = plan.Group(plan.CHARACTERISTIC, 1e6, SCENE.replace(mesh={"discretisation": "fourier"}))
    (path,) = series.probe(request.all_directions[3]).paths
    assert path.in_space and (path.load_angle, path.torsion_angle) == request.all_directions[3]
    reach = math.radians(5.0) * D * (math.cos(math.radians(30.0)) + 0.5)  # rotation and twist at their limits
    assert path.lateral_displacement == pytest.approx(reach)
    with pytest.raises(UserInputError, match=r"--torsion: 120 deg is not in \(0, 90\] deg"):
        plan.Request((1e6,), torsion=(math.radians(120.0),))


def curve(load: np.ndarray, motion: np.ndarray, direction: plan.Direction = (0.0, 0.0)) -> np.ndarray:
    """Return states of a load R [N] in a direction, along its conjugate displacement [m]."""
    states = np.zeros((len(load), 12))
    states[:, 8] = 1e6
    along = points.along_load(direction, D)
    states[:, [6, 10, 11]] = load[:, None] * along
    states[:, [0, 4, 5]] = motion[:, None] * along / (along @ along)
    return states


def test_criteria_of_failure() -> None:
    """Peak, plateau, load at the limit of motion (interpolated there), and a run that stopped before."""
    u = np.linspace(0.0, 0.12 * D, 13)
    peak = assess(curve(np.where(u < 0.05 * D, u, 0.08 * D - 0.6 * u) * 1e6, u), SCENE, (0.0, 0.0))
    assert peak.criterion is Criterion.PEAK and peak.moved < 1.0
    plateau = assess(curve(1e6 * np.tanh(40.0 * u / D), u), SCENE, (0.0, 0.0))
    assert plateau.criterion is Criterion.PLATEAU and pytest.approx(1e6, rel=1e-2) == plateau.H
    rising = assess(curve(1e6 * u, u), SCENE, (0.0, 0.0))
    assert rising.criterion is Criterion.MOTION
    assert (rising.u, rising.H, rising.growth) == pytest.approx((0.1 * D, 0.1 * D * 1e6, 1.0))
    stopped = assess(curve(1e6 * u[:5], u[:5]), SCENE, (0.0, 0.0), "localisation")
    assert (stopped.criterion, stopped.is_capacity, stopped.why) == (Criterion.NONE, False, "localisation")


def test_a_fall_within_the_error_of_the_mesh_is_no_peak(tmp_path: Path) -> None:
    """Of a plateau that two meshes reach at different motions; one that ends just before the limit has ended there."""
    u = np.linspace(0.0, 0.0999 * D, 40)
    states = curve(1e6 * (np.tanh(60.0 * u / D) - 0.06 * u / D), u)
    assert assess(states, SCENE, (0.0, 0.0)).criterion is Criterion.PEAK
    assert assess(states, SCENE, (0.0, 0.0), mesh_error=0.5).criterion is Criterion.PLATEAU
    rising = curve(1e6 * u, u)
    assert assess(rising, SCENE, (0.0, 0.0), "displacement limit").criterion is Criterion.NONE
    path = pd.DataFrame({"u_m": u, "H_N": 1e6 * u, "V_N": 1e6, "converged": 1})
    path.assign(w_m=0.0, rotation_rad=0.0, M_Nm=0.0).to_csv(tmp_path / "load_displacement.csv")
    ended, error = SimpleNamespace(reason=StopReason.DISPLACEMENT_LIMIT), {"by_path": {"probe": {"load_pct": 2.0}}}
    record: Any = SimpleNamespace(failures=["displacement limit"], paths={"probe": ended}, error_estimate=error)
    at_limit = points.point_of(tmp_path, record, SCENE, (0.0, 0.0))
    assert at_limit is not None
    assert (at_limit.criterion, at_limit.why, at_limit.mesh_error) == (Criterion.MOTION, "", 2.0)


def write_probe(folder: Path, u: np.ndarray, margin: np.ndarray, group: str = "paths") -> None:
    """Write the path of a load that grows with u (n,) [m], and its margin to cavitation (n,) [Pa]."""
    columns = points.PLANE if group == "paths" else points.SPACE
    path = pd.DataFrame({name: curve(1e6 * u, u)[:, column] for name, column in columns.items()})
    path.assign(converged=1).to_csv(folder / "load_displacement.csv")
    data = {"cavitation_margin": ("step", margin), "converged": ("step", np.ones(u.size, dtype=np.int8))}
    write_tree(xr.DataTree.from_dict({f"/{group}/probe": xr.Dataset(data)}), folder / "full_model.nc")


WET = SCENE.replace(drainage={"mode": "undrained", "water_depth": 10.0})


@pytest.mark.parametrize("group", ["paths", "space"])
def test_what_a_probe_carries_by_water_that_would_cavitate_is_no_capacity(group: str, tmp_path: Path) -> None:
    """Of a load that grows to the limit of motion, with a margin that falls below 0 at a tenth of it."""
    u = np.linspace(0.0, 0.1 * D, 41)
    for first, size, criterion in ((10, 9, Criterion.NONE), (1, 1, Criterion.NONE), (41, 40, Criterion.MOTION)):
        write_probe(tmp_path, u, np.where(np.arange(41) < first, 1e5, -1e5), group)
        ended = SimpleNamespace(reason=StopReason.DISPLACEMENT_LIMIT)
        record: Any = SimpleNamespace(failures=[], paths={"probe": ended}, error_estimate=None)
        point = points.point_of(tmp_path, record, WET, (0.0, 0.0))
        assert point is not None
        assert (point.criterion, point.H) == (criterion, pytest.approx(1e6 * u[size]))
        assert (point.why == points.CAVITATES) is (criterion is Criterion.NONE)


def test_a_probe_whose_water_would_cavitate_runs_once(tmp_path: Path) -> None:
    """Smaller steps change nothing there."""
    request = plan.Request((1e6,))
    probe = points.planned(plan.groups(WET, request), request)[0]
    folder = tmp_path / "runs" / probe.name
    folder.mkdir(parents=True)
    write_probe(folder, np.linspace(0.0, 0.01 * D, 5), 1.0 - np.arange(5.0))
    record = RunRecord(Status.COMPLETE, scene_sha256=probe.scene.sha256, version=version.__version__, schema=RESULT)
    (folder / "run.json").write_text(record.as_json(), encoding="utf-8")
    done = points.carry_out(probe, tmp_path, lambda *_: None)
    assert done.point is not None and done.point.why == points.CAVITATES
    assert [each.name for each in folder.parent.iterdir()] == [probe.name]


@pytest.mark.slow
def test_collapse_in_clay_is_that_of_both_meshes(tmp_path: Path) -> None:
    """H of a force at mudline 4.82 A su, M of a couple 1.53 A D su (independent series on quadratic elements).

    The mesh `coarse` alone is 3.0 and 8.2 % above.
    """
    scene, out = ROOT / "data/scenes/capacity-clay.toml", tmp_path / "out"
    arguments = ("--V", "0 N", "--directions", "2", "--no-macro", "--mesh", "coarse", "--json", "--out", out)
    done = command("capacity", scene, *arguments)
    force, couple = json.loads(done.out)["rows"]
    area = 25.0 * math.pi
    for found, known, stated in (
        (force["H_N"], 4.82 * area * 1e4, force["mesh_error_pct"]),
        (couple["M_Nm"], 1.53 * area * 10.0 * 1e4, couple["mesh_error_pct"]),
    ):
        assert known < found < 1.015 * known and 100.0 * (found / known - 1.0) < stated < 5.0
    assert [row["criterion"] for row in (force, couple)] == ["plateau", "plateau"]


def test_the_limit_of_motion_counts_twist_and_what_moves_across() -> None:
    """A load with torsion: R from H, M and T; the twist comes to 5 degrees, or u_y to 10 % of D, before H does."""
    direction = (0.4, 0.9)
    q = np.linspace(0.0, 1.0, 101)
    states = curve(1e6 * q, q, direction)
    point = assess(states, SCENE, direction)
    assert point.criterion is Criterion.MOTION
    assert max(point.u / (0.1 * D), abs(point.twist) / math.radians(5.0)) == pytest.approx(1.0)
    np.testing.assert_allclose([point.H, point.M, point.T], point.size * points.along_load(direction, D))
    alone = assess(curve(1e6 * np.sqrt(q), q, (0.0, math.pi / 2)), SCENE, (0.0, math.pi / 2))
    assert alone.growth == pytest.approx(0.5, abs=0.01) and pytest.approx(alone.size * D) == alone.T
    states[:, 1] = 200.0 * states[:, 0]
    across = assess(states, SCENE, direction)
    tip = max(abs(across.u), abs(across.u - across.rotation * L))
    assert math.hypot(tip, 200.0 * across.u) == pytest.approx(0.1 * D) and across.size < 0.6 * point.size


def circle(count: int = 8, known: bool = True) -> pd.DataFrame:
    """Return an envelope of radius 1 MN in H and 2 MN m in M, at V = 1 MN."""
    angle = np.array(plan.angles(count))
    return pd.DataFrame({
        "strength": "characteristic", "vertical_load": "given", "V_N": 1e6, "direction_deg": np.degrees(angle),
        "torsion_deg": 0.0, "T_Nm": 0.0, "twist_rad": 0.0,
        "H_N": 1e6 * np.cos(angle), "M_Nm": 2e6 * np.sin(angle), "size_N": 1e6, "criterion": "displacement limit",
        "is_capacity": int(known), "u_m": 0.1, "w_m": 0.0, "rotation_rad": -0.01, "growth": 0.1, "moved": 1.0,
        "mesh_error_pct": 1.0 + np.arange(count),
        "H_macro_N": 0.98e6 * np.cos(angle), "M_macro_Nm": 1.96e6 * np.sin(angle),
        "criterion_macro": "largest motion", "difference_pct": -2.0, "run": "run",
    })  # fmt: skip


def cases_file(folder: Path) -> Path:
    file = folder / "cases.csv"
    rows = ["on,1000,0,1000", "half,-500,0,", "moment,0,1000,1000", "outside,1000,-2000,1000", "other V,500,0,2000"]
    file.write_text("\n".join(["name,H [kN],M [kN m],V [kN]", *rows]) + "\n", encoding="utf-8")
    return file


def test_utilisation_by_chords(tmp_path: Path) -> None:
    cases = read_load_cases(cases_file(tmp_path))
    found = utilisation(circle(), cases).set_index("name")
    assert found["utilisation"]["on"] == pytest.approx(1.0)
    assert found["utilisation"]["half"] == pytest.approx(0.5)
    assert found["utilisation"]["moment"] == pytest.approx(0.5)
    chord = math.cos(math.pi / 16)  # half way between two directions of the unit circle, or a point of it
    assert found["utilisation"]["outside"] == pytest.approx(math.sqrt(2.0), rel=1.0 - chord)
    assert found.loc["other V", ["utilisation", "H_capacity_N", "M_capacity_Nm", "mesh_error_pct"]].isna().all()
    assert found["off_load"]["other V"] == 1
    assert found["H_capacity_N"]["half"] == pytest.approx(-1e6)
    assert found["mesh_error_pct"][["on", "half", "moment", "outside"]].tolist() == [4.0, 4.0, 8.0, 2.0]
    assert utilisation(circle(known=False), cases)["upper_bound"].tolist() == (1 - found["off_load"]).tolist()
    one = circle()
    one.loc[one["mesh_error_pct"] == 4.0, "mesh_error_pct"] = np.nan  # of one mesh: what it hides may be the larger
    assert utilisation(one, cases).set_index("name")["mesh_error_pct"][["on", "half"]].isna().all()


def sphere(known: bool = True) -> pd.DataFrame:
    """Return the circle with torsion of 3 MN m: at 30 and 60 degrees out of the plane, and alone."""
    rows = [circle()]
    for b in np.radians([30.0, 60.0, 90.0]):
        turned = circle() if b < 1.5 else circle().iloc[[3]]
        shares = {"H_N": np.cos(b), "M_Nm": np.cos(b)}
        rows.append(turned.assign(
            torsion_deg=np.degrees(b), T_Nm=3e6 * np.sin(b), criterion_macro="", difference_pct=np.nan,
            H_macro_N=np.nan, M_macro_Nm=np.nan, is_capacity=int(known),
            **{name: turned[name] * share for name, share in shares.items()}))  # fmt: skip
    return pd.concat(rows, ignore_index=True)


def torsion_cases(folder: Path) -> LoadCases:
    file = folder / "torsion.csv"
    rows = ["plane,500,0,1000,0", "alone,0,0,1000,-1500", "both,-400,600,1000,-1200", "beyond,600,1600,1000,2400"]
    file.write_text("\n".join(["name,H [kN],M [kN m],V [kN],T [kN m]", *rows]) + "\n", encoding="utf-8")
    return read_load_cases(file).bounded(0.5 * D, kept=True)


def test_utilisation_with_torsion_is_that_of_neighbours(tmp_path: Path) -> None:
    """An ellipsoid, in every octant: faces lie up to 8 % inside, a dent counts; without points with T no answer."""
    cases = torsion_cases(tmp_path)
    found = utilisation(sphere(), cases).set_index("name")
    assert found["utilisation"][["plane", "alone"]].tolist() == pytest.approx([0.5, 0.5])
    for name, H, M, T in (("both", 0.4, 0.3, 0.4), ("beyond", 0.6, 0.8, 0.8)):
        true = math.sqrt(H * H + M * M + T * T)
        assert true * 0.9999 <= found["utilisation"][name] < 1.08 * true
        assert found["T_capacity_Nm"][name] == pytest.approx(found["T_Nm"][name] / found["utilisation"][name])
    assert utilisation(sphere(known=False), cases)["upper_bound"].tolist() == [0, 1, 1, 1]
    assert utilisation(circle(), cases)["utilisation"].isna().tolist() == [False, True, True, True]
    dent = sphere()
    dent.loc[dent["torsion_deg"] > 89.0, "T_Nm"] *= 0.5
    assert utilisation(dent, cases).set_index("name")["utilisation"]["alone"] == pytest.approx(1.0)


@pytest.mark.parametrize("rows", [[], [3], [3, 24], [24]])
def test_directions_that_are_missing_leave_no_number(tmp_path: Path, rows: list[int]) -> None:
    """One probe of the plane, of torsion, or of both: what they do not enclose has no utilisation, and no bound."""
    table = sphere().iloc[rows] if rows else sphere().iloc[8:]
    for cases in (read_load_cases(cases_file(tmp_path)), torsion_cases(tmp_path)):
        found = utilisation(table, cases)
        enclosed = found["T_Nm"].ne(0.0) if not rows else found["name"].isin(["none"])
        assert found["utilisation"].notna().tolist() == enclosed.tolist() and not found["upper_bound"].any()
        unknown = found[found["utilisation"].isna() & (found["off_load"] == 0)]
        texts = [row[-1] for row in picture.table_of_cases(unknown).rows]
        assert texts and all("no capacity in its direction" in text for text in texts)
    study.write(tmp_path, Capacity(SCENE, plan.Request((1e6,)), table, found, ()))
    assert (tmp_path / "capacity.png").exists() and (tmp_path / "report.html").exists()


def test_load_cases_with_torsion_ask_for_the_capacity_of_t_alone(tmp_path: Path) -> None:
    """T at its own capacity, 5.676 MN m on a radius of 4 m, is used up; T/R on H would be 0.75 of 1.901 MN."""
    series, cases = SCENE.replace(mesh={"discretisation": "fourier"}), torsion_cases(tmp_path)
    request = plan.Request((1e6,), directions=2)
    assert study.with_torsion(series, request, cases).all_directions[2:] == [(0.0, math.pi / 2)]
    asked = plan.Request((1e6,), directions=2, torsion=(0.5,))
    assert study.with_torsion(series, asked, cases) == asked
    assert study.with_torsion(series, request, read_load_cases(cases_file(tmp_path))) == request
    bricks = SCENE.replace(mesh={"discretisation": "hex8"})
    assert study.with_torsion(bricks, request, cases) == request
    file = tmp_path / "alone.csv"
    file.write_text("name,H [kN],V [kN],T [kN m]\nalone,0,1000,5676\nlittle,950.5,1000,567.6\n", encoding="utf-8")
    read = read_load_cases(file)
    plane = circle().assign(H_N=lambda t: 1.901 * t["H_N"])
    found = utilisation(plane, read.bounded(4.0, read.twisted(4.0)))
    assert np.isnan(found["utilisation"][0]) and found["utilisation"][1] == pytest.approx(0.5 + 0.1419 / 1.901)
    alone = circle().iloc[[3]].assign(H_N=0.0, M_Nm=0.0, T_Nm=5.676e6, torsion_deg=90.0)
    both = utilisation(pd.concat([plane, alone], ignore_index=True), read.bounded(4.0, kept=True))
    assert both["utilisation"].tolist() == pytest.approx([1.0, 0.6])


def test_water_that_flows_has_no_capacity(tmp_path: Path) -> None:
    with pytest.raises(UserInputError, match=r"drainage\.mode: a capacity has no time for water to flow"):
        study.study(tiny.wet(), tmp_path / "out", plan.Request((1e6,)), lambda *_: None)
    assert not (tmp_path / "out").exists()


def test_torsion_is_drawn_and_printed(tmp_path: Path) -> None:
    request = plan.Request((1e6,), torsion=(math.radians(30.0), math.pi / 2))
    outcome = Capacity(SCENE, request, sphere(), utilisation(sphere(), torsion_cases(tmp_path)), ())
    study.write(tmp_path, outcome)
    written = pd.read_csv(tmp_path / "capacity.csv")
    assert written["T_Nm"].max() == pytest.approx(3e6) and len(written) == 25
    assert picture.closing(outcome.table) == "macro-model against full model in 8 of 8 directions: -2.0 to -2.0 %"
    plane, torsion = envelopes(outcome.table, SCENE, outcome.cases).axes
    names = torsion.get_legend_handles_labels()[1]
    assert names[0] == "-67.5 deg, characteristic strength" and len(names) == 9  # eight directions, load cases
    for line in torsion.lines[:8]:
        size, T = np.array(line.get_xdata()), np.array(line.get_ydata())
        assert T.tolist() == pytest.approx([0.0, 1.5, 1.5 * math.sqrt(3.0), 3.0]) and size[-1] == pytest.approx(0.0)
    assert [text.get_text() for text in plane.texts] == ["plane"]
    assert [text.get_text() for text in torsion.texts] == ["alone", "both", "beyond"]
    assert "at 90 it is T alone" in (tmp_path / "report.html").read_text()


def test_files_and_words(tmp_path: Path) -> None:
    table = circle()
    used = utilisation(table, read_load_cases(cases_file(tmp_path)))
    outcome = Capacity(SCENE, plan.Request((1e6,)), table, used, ("a ray stopped",))
    study.write(tmp_path, outcome)
    written = pd.read_csv(tmp_path / "capacity.csv")
    np.testing.assert_allclose(written["H_N"], table["H_N"], atol=1e-3)
    data = json.loads((tmp_path / "capacity.json").read_text())
    assert len(data["rows"]) == 8 and data["remarks"] == ["a ray stopped"] and len(data["cases"]) == 5
    page = (tmp_path / "report.html").read_text()
    assert "a ray stopped" in page and "10 % of the diameter or 5 deg" in page and "no envelope at this V" in page
    assert picture.closing(table) == "macro-model against full model in 8 of 8 directions: -2.0 to -2.0 %"
    axes = envelopes(table, SCENE, outcome.cases).axes
    labels = axes[0].get_legend_handles_labels()[1]
    alone = Capacity(SCENE, plan.Request((1e6,)), table.assign(mesh_error_pct=np.nan), None, ())
    shown = picture.table_of(alone)
    assert {row[shown.columns.index("mesh error [%]")] for row in shown.rows} == {"-"}
    assert shown.note.endswith("'-': of one mesh, not known.")
    twisted = sphere().iloc[-1:].assign(u_m=3.2e-18, rotation_rad=-2e-19, twist_rad=0.022)
    shown = picture.table_of(Capacity(SCENE, plan.Request((1e6,)), twisted, None, ()))
    row = dict(zip(shown.columns, shown.rows[0], strict=True))
    assert [row[name] for name in ("u [mm]", "rotation [deg]", "twist [deg]")] == ["0", "0", "1.26"]
    lines = ["full model, characteristic strength", "macro-model, characteristic strength"]
    assert labels == [*lines, "load cases", "load cases of another V"]  # the panel is at 1 MN, that case at 2 MN
    drawn = {str(line.get_label()): line for line in axes[0].get_lines()}
    assert [len(drawn[label].get_xdata()) for label in labels[2:]] == [4, 1]
    assert drawn[labels[3]].get_markerfacecolor() == "white" and drawn[labels[3]].get_xdata()[0] == 0.5


def test_the_key_of_an_envelope_does_not_hide_it() -> None:
    """In clay an envelope leans: a force forwards carries most with a moment backwards."""
    table = circle()
    figure = envelopes(table.assign(H_N=table["H_N"] - 0.8 * table["M_Nm"] / D), SCENE)
    (axes,) = figure.axes
    figure.draw_without_rendering()
    box, corners = axes.get_legend().get_window_extent(), axes.get_lines()[0].get_xydata()
    assert not any(box.contains(*corner) for corner in axes.transData.transform(corners))


@pytest.mark.slow
def test_a_study_goes_on_where_it_was(tmp_path: Path) -> None:
    """Two directions; a third call runs nothing; other directions run beside those that are there."""
    limit = {"displacement_over_diameter": 0.001, "rotation": math.radians(0.05)}
    scene = tiny.scene(limit=limit)
    file = tiny.write(scene, tmp_path / "tiny.toml")
    arguments = ("capacity", file, "--V", "1 MN", "--no-macro", "--discretisation", "hex8", "--out", tmp_path / "out")
    done = command(*arguments, "--directions", "2", "--json")
    assert done.code == 0, done.err
    rows = json.loads(done.out)["rows"]
    assert [row["direction_deg"] for row in rows] == pytest.approx([0.0, 90.0])
    assert all(row["criterion"] == "displacement limit" and row["V_N"] == 1e6 for row in rows)
    records = sorted((tmp_path / "out/runs").glob("*/run.json"))
    series = (
        "capacity",
        file,
        "--V",
        "1 MN",
        "--no-macro",
        "--directions",
        "2",
        "--json",
        "--discretisation",
        "fourier",
    )
    one, two = (command(*series, "--out", tmp_path / jobs, "--jobs", jobs) for jobs in ("1", "2"))
    assert one.code == two.code == 0, one.err + two.err
    assert one.out.replace(str(tmp_path / "1"), "") == two.out.replace(str(tmp_path / "2"), "")
    assert all(row["mesh_error_pct"] > 0.0 for row in json.loads(one.out)["rows"])
    assert [row["criterion"] for row in json.loads(one.out)["rows"]] == ["displacement limit"] * 2
    alone = command(*series, "--out", tmp_path / "3", "--no-estimate-error")
    assert [row["mesh_error_pct"] for row in json.loads(alone.out)["rows"]] == [None, None]
    assert command(*series, "--out", tmp_path / "3").out.replace(str(tmp_path / "3"), str(tmp_path / "1")) == one.out
    stamps = [record.stat().st_mtime_ns for record in records]
    again = command(*arguments, "--directions", "4")
    assert again.code == 0 and "displacement limit" in again.out
    assert [record.stat().st_mtime_ns for record in records] == stamps
    assert len(list((tmp_path / "out/runs").glob("*/run.json"))) == 4


@pytest.mark.parametrize(
    ("asked", "balance", "files", "ended"),
    [
        (None, {}, ("full_model.nc", "springs.nc"), True),
        (5, {}, ("full_model.nc", "springs.nc"), True),
        (3, {}, ("full_model.nc", "springs.nc"), False),  # another number was asked for
        (None, None, ("full_model.nc",), True),  # a path out of one plane gives no springs
        (None, {}, ("full_model.nc",), False),
        (None, {}, ("springs.nc",), False),
    ],
)
def test_a_run_whose_series_chose_its_harmonics_or_that_gives_no_springs_has_ended(
    asked: int | None, balance: dict[str, Any] | None, files: tuple[str, ...], ended: bool, tmp_path: Path
) -> None:
    scene = SCENE.replace(mesh={"discretisation": "fourier", "harmonics": None, "azimuth": None})
    ran = scene.replace(mesh={"harmonics": 5})
    record = RunRecord(
        Status.COMPLETE, scene_sha256=ran.sha256, version=version.__version__, schema=RESULT, balance=balance,
        mesh=MeshFigures(harmonics=5),
    )  # fmt: skip
    (tmp_path / "run.json").write_text(record.as_json(), encoding="utf-8")
    for name in files:
        (tmp_path / name).touch()
    assert stored_runs.has_ended(tmp_path, scene.replace(mesh={"harmonics": asked})) is ended


@pytest.mark.parametrize("step", [1e-6, -1e-6, -2e-3])
def test_a_flat_end_of_tiny_steps_is_no_failure(step: float) -> None:
    """A probe that localisation stops at an eighth of its way: the last steps, 0.01 % of it, are flat or fall."""
    u = np.append(np.linspace(0.0, 0.012 * D, 9), 0.0120012 * D)
    load = np.append(1e6 * np.sqrt(u[:-1]), 1e6 * np.sqrt(u[-2]) * (1.0 + step))
    stopped = assess(curve(load, u), SCENE, (0.0, 0.0), "localisation")
    assert (stopped.criterion, stopped.why) == (Criterion.NONE, "localisation")
    assert stopped.growth == pytest.approx(0.5, abs=0.05)


@pytest.mark.slow
def test_a_vertical_load_that_is_not_carried_is_named_once(tmp_path: Path) -> None:
    """Far beyond what pulls the caisson out: no direction has a capacity, and the other runs are left out."""
    file = tiny.write(SCENE, tmp_path / "tiny.toml")
    done = command("capacity", file, "--V", "-500 MN", "--out", tmp_path / "out")
    assert done.code == 3
    assert "does not carry this vertical load: path 'probe' stopped during its dead load" in done.err
    assert len(list((tmp_path / "out/runs").iterdir())) == 2  # the first probe, and again with small steps
    assert not (tmp_path / "out/capacity.csv").exists()


def test_runs_have_names_and_springs() -> None:
    request = plan.Request((1e6,), directions=2)
    every = points.planned(plan.groups(SCENE, request), request)
    assert [each.name for each in every] == [
        "characteristic-V1000kN-+0deg", "characteristic-V1000kN-+90deg", "characteristic-V1000kN-rays"
    ]  # fmt: skip
    assert [each.direction is None for each in every] == [False, False, True]


def test_springs_beside_the_full_model_are_those_of_its_vertical_load() -> None:
    """Of springs at 2 and 4 MN: those at each load; none at 8 MN, where they do not hold."""
    given = Springs.of(vertical.vertical_springs(heavier=(4e6,)))
    found = {V: study.model_at(given, V) for V in (2e6, 4e6, 8e6)}
    assert [model and model.origin.load for model, _ in found.values()] == [2e6, 4e6, None]
    assert [why for _, why in found.values()][:2] == ["", ""] and "those at V = 4 MN" in found[8e6][1]


def test_springs_in_which_water_takes_part_otherwise_have_a_remark() -> None:
    remarks = []
    for springs in (rates.at_two_rates(speeds=(1e-3,)), vertical.vertical_springs()):
        remarks.append(study.assess(SCENE, plan.Request((1e6,)), [], springs).remarks)
    assert remarks == [("the springs beside the full model are coupled, its probes drained",), ()]


def test_suction_that_is_not_checked_has_a_remark() -> None:
    """Sand that dilates carries ten times its drained load by a suction of many atmospheres."""
    for drainage, words in (
        ({"mode": "undrained"}, True),
        ({"mode": "undrained", "water_depth": 9.0}, False),
        ({}, False),
    ):
        remarks = study.assess(SCENE.replace(drainage=drainage), plan.Request((1e6,)), []).remarks
        assert ("not checked against cavitation: drainage.water_depth" in "".join(remarks)) is words


def test_refusals(tmp_path: Path) -> None:
    file = tiny.write(SCENE, tmp_path / "tiny.toml")
    other = save_springs(synthetic.make_springs(caisson=synthetic.Caisson(length=5.0)), tmp_path / "other.nc")
    several = save_springs(rates.at_two_rates(), tmp_path / "several.nc")
    for given, message in (
        (("--V", "3"), "--V 3: expected a quantity with unit"),
        (("--factor", "0.5"), '--factor: "0.5": expected a number'),
        (("--directions", "1"), "--directions: 1 is not in [2, 72]"),
        (("--torsion", "0 deg"), "--torsion: 0 deg is not in (0, 90] deg"),
        (("--torsion", "45"), "--torsion 45: expected a quantity with unit"),
        (
            ("--torsion", "45 deg", "--discretisation", "hex8"),
            "--torsion: the load leaves the plane of H and M: bricks have half of a caisson",
        ),
        (("--springs", tmp_path / "no"), "--springs: no such file or folder"),
        (("--springs", other), "--springs: skirt length 5 m; that of the scene is 4 m"),
        (("--springs", several), "--springs: are at several rates, and a capacity has none"),
        (("--springs", other, "--factor", "1.25"), "--springs: are of one strength"),
    ):
        done = command("capacity", file, *given, "--out", tmp_path / "out")
        assert (done.code, message in done.err) == (2, True), done.err
    assert not (tmp_path / "out").exists()
