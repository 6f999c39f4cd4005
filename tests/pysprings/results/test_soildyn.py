# SPDX-License-Identifier: MIT
"""The SoilDyn library beside `predict`: called as OpenFAST calls it, on arrays of the caller."""

import re
import warnings
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from pysprings.core.errors import ResourceError, UserInputError
from pysprings.macro.answer import trace
from pysprings.macro.model import MacroModel
from pysprings.macro.predict import MacroWarning, impose
from pysprings.results.exporters import Source, export
from pysprings.results.exporters.soildyn.library import build_command, compiler, library_name, spring_text
from tests.support import fans, synthetic, vertical
from tests.support.commands import command
from tests.support.foundation import FORCE, Point, PointOn, needs_compiler

pytestmark = needs_compiler
TORSION = synthetic.TORSION


@pytest.fixture(scope="session")
def source() -> Source:
    return Source(vertical.fan_with_vertical())  # compared once, exported often


@pytest.fixture
def springs(source: Source) -> xr.DataTree:
    return source.springs


@pytest.fixture
def point(library: Path, source: Source, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Point:
    export(source, "openfast", tmp_path)
    monkeypatch.chdir(tmp_path)
    return Point(library, "./caisson.txt")


def states(model: MacroModel, n: int, seed: int = 2) -> np.ndarray:
    """Rows u, rotation, change of w from rest, direction: all over the range."""
    random = np.random.default_rng(seed)
    rho, phi = 7e-3 * random.random(n), 2.0 * np.pi * random.random(n)
    return np.stack(
        [
            rho * np.cos(phi),
            rho * np.sin(phi) / model.length,
            random.uniform(-8e-3, 8e-3, n),
            2.0 * np.pi * random.random(n),
        ],
        axis=1,
    )


def motion(u: float, rotation: float, w: float, direction: float, twist: float = 0.0) -> np.ndarray:
    """Motion (6,) in the frame of OpenFAST (z up) of one in the plane at an angle from x, seen from above."""
    c, s = np.cos(direction), np.sin(direction)
    return np.array([u * c, u * s, -w, -rotation * s, rotation * c, twist])


def in_plane(force: np.ndarray, direction: float) -> tuple[float, float, float, float, float]:
    """H, M, V in the plane of motion, and force and moment across it, from forces on the soil with z up."""
    c, s = np.cos(direction), np.sin(direction)
    across = force[1] * c - force[0] * s, force[3] * c + force[4] * s
    return force[0] * c + force[1] * s, force[4] * c - force[3] * s, -force[2], *across


@pytest.mark.slow
def test_forces_are_those_of_predict(point: Point, springs: xr.DataTree) -> None:
    model = MacroModel.from_springs(springs)
    assert model.vertical is not None
    for u, rotation, w, direction in states(model, 200):
        H, M, V, *across = in_plane(point.forces(motion(u, rotation, w, direction, 1e-4)), direction)
        expected = model.reactions(u, rotation)[0]
        np.testing.assert_allclose([H, M], expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
        np.testing.assert_allclose(across, 0.0, atol=1e-9 * np.abs(expected).max())
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MacroWarning)
            answer = impose(model, u=u, rotation=rotation, V=V, extrapolate=True)
        np.testing.assert_allclose([answer["H"], answer["M"]], [H, M], rtol=1e-9)
        assert float(answer["w"]) == pytest.approx(w, rel=1e-6, abs=1e-10)
    assert point.forces(motion(0.0, 0.0, 0.0, 0.0, 1e-3))[5] == pytest.approx(TORSION * 1e-3, rel=1e-12)


def test_a_vertical_load_is_marked_as_predict_does(point_on: PointOn, capfd: pytest.CaptureFixture[str]) -> None:
    """More than 10 % from that of the lateral springs, or less and near the end of a vertical path; and said once."""
    model = MacroModel.from_springs(vertical.weaken(vertical.fan_with_vertical(), "up", 1.0 / 6.0))
    point, seen, log, first = point_on(model), set(), "", 0.0
    assert point.ask(FORCE, motion(0.0, 0.0, -5e-3, 0.0)) == 0
    assert point.state.ravel()[3] == 0.0 and capfd.readouterr().out == ""  # no lateral motion, which needs no springs
    for w in np.concatenate([[0.0], np.linspace(-2e-3, 2e-3, 60), [0.0]]):
        V = -point.forces(motion(1e-3, 2e-4, w, 0.3))[2]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MacroWarning)
            answer = impose(model, u=1e-3, rotation=2e-4, V=V, extrapolate=True)
        assert point.state.ravel()[3] == float(answer["off_load"]), w
        change = V / model.origin.load - 1.0
        log += capfd.readouterr().out
        first = first or V * bool(answer["off_load"])
        seen.add((abs(change) > 0.1, change > 0.0, bool(answer["off_load"])))
    assert {(False, False, False), (False, False, True), (False, True, False), (True, True, True)} <= seen
    (text,) = re.findall(r"the vertical load, (.*) kN, is not that of the lateral springs, (.*) kN, or near its", log)
    assert [float(each) for each in text] == pytest.approx([1e-3 * first, 1e-3 * model.origin.load], rel=1e-3)


def test_pushing_down_and_pulling_out_differ(point: Point, springs: xr.DataTree) -> None:
    """Forces on the soil with z up: the dead load at rest; 5 mm down press harder than 5 mm up pull."""
    rest = MacroModel.from_springs(springs).rest_load
    down, up = (rest + vertical.down_curve(np.array(w)) for w in (5e-3, -5e-3))
    assert point.forces(np.zeros(6))[2] == pytest.approx(-rest, rel=1e-12)
    assert -point.forces(motion(0, 0, 5e-3, 0))[2] == pytest.approx(float(down), rel=1e-2)
    assert -point.forces(motion(0, 0, -5e-3, 0))[2] == pytest.approx(float(up), rel=1e-2)
    assert abs(up - rest) < 0.5 * abs(down - rest)


def test_stiffness_at_rest_is_that_of_the_matrices(point: Point, springs: xr.DataTree) -> None:
    from pysprings.results.exporters.subdyn import at_lid
    from pysprings.springs.springs import Springs

    K = at_lid(Springs.of(springs))
    np.testing.assert_allclose(point.stiffness(np.zeros(6)), K, rtol=1e-7, atol=1e-7 * K[0, 0])


def test_stiffness_is_the_slope_of_the_forces(point: Point) -> None:
    """Taylor: what is left of the force after the linear part falls with the square of the step."""
    random = np.random.default_rng(5)
    d = np.array([2e-3, -1e-3, -1e-3, 3e-4, 4e-4, 1e-4])
    K, F = point.stiffness(d), point.forces(d)
    size = np.array([1e-4, 1e-4, 1e-4, 2e-5, 2e-5, 2e-5])
    for _ in range(5):
        step = random.uniform(-1, 1, 6) * size
        left = [np.linalg.norm(point.forces(d + h * step) - F - h * K @ step) for h in (1.0, 0.25)]
        assert left[0] > 10.0 * left[1]


def test_out_of_one_plane_the_law_is_linear_for_linear_springs_and_turns_with_the_motion(
    point_on: PointOn, point: Point
) -> None:
    random = np.random.default_rng(7)
    motions = random.uniform(-1, 1, (20, 6)) * [2e-3, 2e-3, 0.0, 4e-4, 4e-4, 1e-4]
    turn = np.kron(np.eye(2), np.array([[np.cos(0.7), -np.sin(0.7), 0], [np.sin(0.7), np.cos(0.7), 0], [0, 0, 1]]))
    for d in motions:
        np.testing.assert_allclose(point.forces(turn @ d), turn @ point.forces(d), rtol=1e-9, atol=1.0)
    other = point_on(MacroModel.from_springs(fans.fan_springs(fans.linear)), total=False, name="linear")
    K, rest = other.stiffness(np.zeros(6)), other.forces(np.zeros(6))
    assert rest[2] == 0.0
    lateral = [0, 1, 3, 4, 5]
    for d in motions:
        np.testing.assert_allclose(other.forces(d)[lateral], (K @ d)[lateral], rtol=1e-6, atol=1.0)


def test_forces_vary_smoothly_where_both_planes_move_alike(point: Point) -> None:
    """Where displacement and rotation have the same size across each other, no direction is preferred."""
    L = fans.LENGTH
    around = [
        point.forces(np.array([2e-3, 0.0, 0.0, (2e-3 + e) / L, f / L, 0.0]))
        for e in (-1e-9, 1e-9)
        for f in (-1e-9, 1e-9)
    ]
    assert np.ptp(around, axis=0).max() < 1e-5 * np.abs(around).max()


def test_nothing_is_remembered_but_in_the_arrays_of_the_caller(point: Point, library: Path) -> None:
    other = Point(library, "./caisson.txt")
    motions = np.random.default_rng(3).uniform(-1, 1, (30, 6)) * [3e-3, 3e-3, 2e-3, 5e-4, 5e-4, 1e-4]
    first = []
    for d in motions:
        kept = point.props.copy(), point.state.copy()
        point.forces(-2.0 * d)  # a rejected step
        point.props[:], point.state[:] = kept
        first.append(point.forces(d))
    second = [other.forces(d) for d in motions[::-1]][::-1]
    np.testing.assert_array_equal(first, second)


def test_marks_are_in_the_state_and_beyond_the_range_warns_once(
    point: Point, capfd: pytest.CaptureFixture[str]
) -> None:
    point.forces(motion(0.5 * fans.RHO[-1], 0.0, 0.0, 0.0))
    assert point.state.ravel()[0] == pytest.approx(0.5)
    assert "calibrated range" not in capfd.readouterr().out
    for _ in range(2):
        point.forces(motion(1.5 * fans.RHO[-1], 0.0, 0.0, 0.3))
    assert point.state.ravel()[0] == pytest.approx(1.5)
    assert capfd.readouterr().out.count("warning: springs: beyond the calibrated range (1.5 laterally") == 1


def test_a_motion_between_rays_too_far_apart_is_marked_as_predict_does(
    point_on: PointOn, source: Source, capfd: pytest.CaptureFixture[str]
) -> None:
    """Of a fan without the rays below 0 degrees: from there to -90, that at 90; and said once."""
    springs, angles = source.springs.copy(deep=True), [-80.0, -45.0, -10.0, 0.0, 10.0, 100.0, 135.0, 180.0]
    model = MacroModel.from_springs(springs)
    for name, ray in zip(model.table.path, np.degrees(model.table.angle), strict=True):
        if -85.0 < ray < -5.0 or 95.0 < ray < 175.0:
            del springs["paths"][name]
    model = MacroModel.from_springs(springs)
    point, marked = point_on(model), []
    for angle in np.radians(angles):
        u, rotation = 1e-3 * np.cos(angle), 1e-3 * np.sin(angle) / model.length
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MacroWarning)
            marked.append(int(impose(model, u=u, rotation=rotation)["off_path"]))
        point.forces(motion(u, rotation, 0.0, 0.3))
        assert point.state.ravel()[4] == marked[-1], angle
    assert 0 < sum(marked) < len(marked)
    assert capfd.readouterr().out.count("between load paths more than 60 degrees apart") == 1


def test_beyond_what_the_full_model_carried_it_stops(
    point_on: PointOn, source: Source, capfd: pytest.CaptureFixture[str]
) -> None:
    springs = source.springs
    stopping = point_on(MacroModel.from_springs(springs), stop=True)
    far = motion(1.01 * fans.RHO[-1], 0.0, 0.0, 0.0)
    assert stopping.ask(FORCE, far) == 104
    assert "beyond the calibrated range" in capfd.readouterr().out
    failed = springs.copy(deep=True)
    failed["paths/ray_0"].attrs |= {"end": "limit load", "end_H_N": 1e6, "end_M_Nm": 0.0}
    ended = point_on(MacroModel.from_springs(failed))
    assert ended.ask(FORCE, 0.99 * far) == 0
    assert ended.ask(FORCE, far) == 104
    assert ended.ask(FORCE, motion(0.0, 1.01 * fans.RHO[-1] / fans.LENGTH, 0.0, 0.0)) == 0  # another ray
    assert "met a limit load" in capfd.readouterr().out
    elastic = point_on(MacroModel.from_springs(fans.fan_springs(fans.potential)))
    assert elastic.ask(FORCE, motion(0.0, 0.0, -5e-3, 0.0)) == 104
    assert "vertical load is not known" in capfd.readouterr().out


@pytest.mark.slow
def test_the_thresholds_are_those_of_predict(point_on: PointOn, source: Source) -> None:
    """Just within and just beyond the range, on rays, near them and between, one of them with a limit load."""
    springs = source.springs.copy(deep=True)
    springs["paths/ray_0"].attrs |= {"end": "limit load", "end_H_N": 1e12, "end_M_Nm": 0.0}
    springs["paths/ray_6"].dataset = springs["paths/ray_6"].to_dataset(inherit=False).isel(step=slice(20))
    model = MacroModel.from_springs(springs)
    stopping, going = point_on(model, stop=True, name="stopping"), point_on(model)
    rays = np.radians(fans.ANGLES)
    angles = np.concatenate([rays, rays + 0.9e-3, rays - 1.1e-3, np.random.default_rng(5).uniform(-1.5, 1.5, 20)])
    seen = []
    for angle in angles:
        once = np.array([np.cos(angle), np.sin(angle) / model.length])
        reach = 1.0 / float(model.response.range_used(once[None])[0])
        for share in (1.0 - 2e-6, 1.0 + 0.5e-6, 1.0 + 2e-6, 1.2):
            u, rotation = share * reach * once
            answer = trace(model, "state", np.array([[u, rotation]]), 0.0, None).isel(step=-1)  # marks of `predict`
            marks = [int(answer["extrapolated"]), int(answer["beyond_end"])]
            found = [each.ask(FORCE, motion(u, rotation, 0.0, 0.4)) == 104 for each in (stopping, going)]
            assert going.state.ravel()[0] == pytest.approx(float(answer["range_used"]), rel=1e-9)
            assert found == [bool(mark) for mark in marks], (angle, share)
            seen.append(tuple(marks))
    assert set(seen) == {(0, 0), (1, 0), (1, 1)}


def test_wrong_files_give_a_line_and_no_crash(point: Point, library: Path, capfd: pytest.CaptureFixture[str]) -> None:
    text = Path("caisson.txt").read_text()
    rows = text.splitlines()
    first = next(k for k, row in enumerate(rows) if row.startswith("ray "))
    cases = {
        "early": (text[: len(text) // 2], "ends early|missing|expected"),
        "empty": ("", "ends early"),
        "other": ("some text\n", "another keyword"),
        "version": (text.replace("pysprings_soildyn 7", "pysprings_soildyn 6"), "version 7"),
        "number": (text.replace("length_m ", "length_m x"), "number is missing"),
        "nan": (text.replace("length_m ", "length_m nan "), "not finite"),
        "order": (
            "\n".join([*rows[: first + 1], rows[first + 3], rows[first + 2], *rows[first + 4 :]]),
            "start at 0 and increase",
        ),
        "many": (
            "\n".join([*rows[:first], " ".join([*rows[first].split()[:2], "1000000", "0"]), *rows[first + 1 :]]),
            "20,000|two points",
        ),
        "end": (text.removesuffix("end\n"), "last line 'end'"),
        "binary": ("\x00\xff" * 4000, "ends early|another keyword"),
    }
    for name, (content, words) in cases.items():
        Path(f"{name}.txt").write_text(content, encoding="latin-1")
        broken = Point(library, f"./{name}.txt")
        said = capfd.readouterr().out
        assert broken.code == 102, name
        assert any(word in said for word in words.split("|")), (name, said)
        assert f"./{name}.txt" in said
        assert broken.ask(FORCE, np.zeros(6)) == 103  # no numbers from a file that was refused
        capfd.readouterr()
    assert Point(library, "./nothing.txt").code == 101
    assert "cannot be opened" in capfd.readouterr().out
    assert point.ask(FORCE, np.full(6, np.nan)) == 106
    assert point.ask(9, np.zeros(6)) == 105


def test_springs_without_a_fan_are_linear_alone(tmp_path: Path) -> None:
    done = export(synthetic.make_springs(), "openfast", tmp_path)
    assert not (tmp_path / "caisson.txt").exists()
    assert any("needs a fan" in remark for remark in done.remarks)


def test_more_numbers_than_soildyn_keeps_are_refused() -> None:
    rho = 8e-3 * np.linspace(0.0, 1.0, 300)
    many = fans.fan_springs(fans.potential, rho=rho)
    with pytest.raises(UserInputError, match="SoilDyn keeps 20000"):
        spring_text([], MacroModel.from_springs(many), TORSION, True, False)


def test_the_command_builds_the_library(tmp_path: Path) -> None:
    done = command("soildyn", tmp_path / "new" / "folder")
    assert done.code == 0, done.err
    assert Path(done.out.strip()).is_file()
    missing = command("soildyn", tmp_path, "--compiler", "no-such-compiler -O3")
    assert missing.code == 4
    assert "no-such-compiler" in missing.err
    failing = command("soildyn", tmp_path, "--compiler", "false")
    assert failing.code == 4
    assert "the C compiler failed" in failing.err


def test_commands_of_other_systems() -> None:
    out = Path("lib")
    assert "-dynamiclib" in build_command(["clang"], out, "darwin")
    assert build_command(["cl"], out, "win32")[1:4] == ["/nologo", "/O2", "/LD"]
    assert [library_name(each) for each in ("linux", "darwin", "win32")] == [
        "libpysprings_soildyn.so", "libpysprings_soildyn.dylib", "pysprings_soildyn.dll",
    ]  # fmt: skip
    with pytest.raises(ResourceError, match="no C compiler"):
        compiler("no-such-compiler")
