# SPDX-License-Identifier: MIT
"""Springs in the space of both planes in the SoilDyn library, beside `pysprings.memory.space_model`."""

import shutil
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from pysprings.macro.model import MacroModel
from pysprings.memory.calibration import MOST_NUMBERS, SpaceElements, way_of
from pysprings.memory.model import MemorySprings
from pysprings.memory.offered import Offered, evened, numbers_in_space
from pysprings.memory.space_model import SpaceSprings
from pysprings.results.exporters import export
from pysprings.results.exporters.soildyn.library import spring_text
from tests.support import loaded, openfast, space_paths
from tests.support.fans import RHO
from tests.support.foundation import FORCE, Point, PointOn, needs_compiler
from tests.support.space_springs import calibrated, elements

pytestmark = needs_compiler
LATERAL = [0, 1, 3, 4, 5]  # of six: SPACE_TURNS, and SPACE_LOADS
RADIUS, TWIST = 4.0, 5e-3
S_WAY = 5  # of springs.h
DIRECTIONS = 8  # of the mean out of one plane, MEAN of springs.c


def with_space(elements: SpaceElements) -> tuple[MacroModel, SpaceSprings]:
    """Model with vertical springs, a fan that heaves, and elements in space; and these alone."""
    given = loaded.springs().at()
    model = MacroModel.from_springs(given, "memory")
    assert isinstance(model.response, MemorySprings)
    own = replace(model.response.elements, space=elements)
    space = SpaceSprings.from_elements(own, given, model.rest_load, (1e6, 1e6))
    return replace(model, response=replace(model.response, elements=own)), space


def invented(n: int = 8) -> tuple[MacroModel, SpaceSprings]:
    """Elements of all kinds, with torsion."""
    return with_space(set_of(elements(1, n), TWIST))


def set_of(rows: np.ndarray, twist: float, even: np.ndarray | None = None, way: float = 0.0) -> SpaceElements:
    """Elements that share out no p; w and V are those of the fan, or follow `even` by element that was offered."""
    none, given = np.zeros((0, 2)), np.zeros((2, 2 * len(Offered.of_space(rows).rows)))
    return SpaceElements(rows, RADIUS, twist, none, none, given if even is None else even, 4.0, way, 0.0, 0.0, {})


def walk(seed: int, n: int) -> np.ndarray:
    """Motions (n, 6) in the frame of OpenFAST in steps of all sizes, within the range of the fan."""
    random = np.random.default_rng(seed)
    sizes = 10.0 ** random.uniform(-2.0, 0.0, (n, 1))
    way = np.cumsum(sizes * random.normal(size=(n, 6)), axis=0)
    size = np.array([1.0, 1.0, 1.0, 0.25, 0.25, 0.25])  # over the skirt length, and the radius
    return 0.5 * RHO[-1] * size * np.sin(way)


def vertical_load(model: MacroModel, d: np.ndarray) -> float:
    """V at a motion (6,): of the vertical springs at w less that of the fan, which is blended between two planes."""
    a, b = d[:2], model.length * np.array([d[4], -d[3]])
    aa, bb, ab = a @ a, b @ b, a @ b
    plane, phi = np.hypot(aa - bb, 2.0 * ab) / (aa + bb), 0.5 * np.arctan2(2.0 * ab, aa - bb)
    angles = np.concatenate([[phi], np.pi * np.arange(DIRECTIONS) / DIRECTIONS])
    states = np.sqrt(aa + bb) * np.stack([np.cos(angles), np.sin(angles) / model.length], axis=1)
    rows = model.table.rows(states)
    w, V = (plane * of[0] + (1.0 - plane) * of[1:].mean() for of in (rows[model.table.name == n][0] for n in "wV"))
    return carried(model, d, w, V)


def carried(model: MacroModel, d: np.ndarray, w: float, V: float) -> float:
    """V of the vertical springs at a motion (6,), where the lateral ones have moved by w and carry V."""
    assert model.vertical is not None
    change = -d[2] - w + model.vertical.displacement(V)
    return float(brentq(lambda load: model.vertical.displacement(load) - change, -3e6, 1e8, xtol=1e-4))


def test_a_random_walk_in_six_motions_is_that_of_python(point_on: PointOn) -> None:
    """All kinds of elements, round, spread and of torsion; between the steps some are tried and rejected."""
    model, space = invented()
    point, motions = point_on(model, 0.0), walk(3, 150)
    found = []
    for k, d in enumerate(motions):
        kept = point.state.copy()
        if k % 3 == 0:
            point.forces(-1.2 * d)
            point.state[:] = kept
        found.append(point.forces(d))
    turns, pushes, message = space.solve("state", motions[:, LATERAL])
    assert message == "" and np.abs(turns - motions[:, LATERAL]).max() < 1e-12
    expected = np.zeros((len(motions), 6))
    expected[:, LATERAL], expected[:, 2] = pushes, [-vertical_load(model, d) for d in motions]
    sizes = np.abs(expected).max(axis=0)
    assert (sizes > 1e4).all() and (np.ptp(expected, axis=0) > 0.3 * sizes).all()
    np.testing.assert_allclose(found / sizes, expected / sizes, rtol=1e-6, atol=1e-6)


def test_settlement_adds_up_by_cycles_as_in_python(point_on: PointOn) -> None:
    """w and V follow ways and stored energies of round and spread elements, turned or not; a twist leaves w."""
    rows, random = elements(1, 8), np.random.default_rng(11)
    choice = Offered.of_space(rows)
    even = random.uniform(0.0, 0.02, (2, 2 * len(choice.rows))) * [[1.0], [1e7]]
    model, space = with_space(set_of(rows, TWIST, even, 1e3))
    point, rest = point_on(model, 0.0), model.response.rest
    for angle in (0.0, 1.1):
        u = 0.4 * RHO[-1] * np.sin(np.linspace(0.0, 6.0 * np.pi, 700))
        c, s = np.cos(angle), np.sin(angle)
        motions = np.stack([c * u, s * u, 0.0 * u, -0.1 * s * u, 0.1 * c * u + 0.02 * np.abs(u), 0.01 * u], axis=1)
        point.state[:] = 0.0
        found = np.array([point.forces(d)[2] for d in motions])
        ways = evened(choice, space.motions_of(motions[:, LATERAL]), space.largest, 4.0) @ even.T
        np.testing.assert_allclose(space.heave(motions[:, LATERAL]) - float(space.origin["w"][0]), ways[:, 0])
        w, V = rest[0] + ways[:, 0], rest[1] + ways[:, 1]
        expected = [-carried(model, *row) for row in zip(motions, w, V, strict=True)]
        assert np.ptp(expected) > 0.1 * rest[1]
        np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())
        come = way_of(space.motions_of(motions[:, LATERAL])[:, :4])
        assert point.state.flat[S_WAY] == pytest.approx(come, rel=1e-12)
        peaks = w[[*range(58, 700, 117)]] - rest[0]
        assert peaks[-1] > 1.4 * peaks[0] > 0.0
    again = motions.copy()
    again[:, 5] = 0.0
    np.testing.assert_array_equal(space.heave(again[:, LATERAL]), space.heave(motions[:, LATERAL]))


def test_the_stiffness_at_rest_is_axisymmetric_and_that_of_the_elements(point_on: PointOn) -> None:
    """As SoilDyn asks for it; elsewhere it is the slope of the forces."""
    model, space = with_space(SpaceSprings.of(calibrated()).elements)
    point = point_on(model, 0.0)
    K = point.stiffness(np.zeros(6))
    np.testing.assert_allclose(K, K.T)
    assert (K[0, 0], K[0, 4], K[3, 3]) == (K[1, 1], -K[1, 3], K[4, 4])
    small = 1e-9 * np.array([1.0, -0.4, 0.0, 0.1, 0.2, 0.3])
    own = space.tangents(small[None, LATERAL])[0]
    np.testing.assert_allclose(K[np.ix_(LATERAL, LATERAL)], own, rtol=1e-6, atol=1e-6 * own.max())
    for d in walk(5, 20):
        point.forces(d)
    aim, kept = walk(5, 21)[20], point.state.copy()
    D, step = point.stiffness(aim), 1e-7
    for j in range(6):
        ends = []
        for sign in (1.0, -1.0):
            point.state[:] = kept
            ends.append(point.forces(aim + sign * step * np.eye(6)[j]))
        np.testing.assert_allclose(D[:, j], (ends[0] - ends[1]) / (2.0 * step), rtol=0.05, atol=1e-3 * np.abs(D).max())


def test_after_a_twist_alone_the_stiffness_at_the_origin_is_not_that_at_rest(point_on: PointOn) -> None:
    """There and back by twists that yield, to where torsion is loaded still."""
    model, _ = invented()
    point, twist = point_on(model, 0.0), np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    rest = point.stiffness(0.0 * twist)[5, 5]
    point.state[:] = 0.0
    for size in (2.0 * TWIST, 0.0):
        left = point.forces(size * twist)[5]
    assert point.state.flat[S_WAY] == 0.0 and abs(left) > 0.0
    kept, slopes = point.state.copy(), []
    for step in (1e-7, -1e-7):
        point.state[:] = kept
        slopes.append((point.forces(step * twist)[5] - left) / step)
    point.state[:] = kept
    own = point.stiffness(0.0 * twist)[5, 5]
    assert own == pytest.approx(np.mean(slopes), rel=1e-3) and own != pytest.approx(rest, rel=1e-3)


@pytest.mark.parametrize("degrees", [7.5, 22.5, 37.0, 45.0, 90.0, 163.0])
def test_a_path_that_is_turned_has_a_turned_answer(point_on: PointOn, degrees: float) -> None:
    """Within 2 % of the largest load of each path: an elbow, a circle, and a random walk in all motions."""
    model, _ = with_space(SpaceSprings.of(calibrated()).elements)
    point, angle = point_on(model, 0.0), np.radians(degrees)
    plane = np.array([[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
    turn, rest = np.kron(np.eye(2), plane), point.state.copy()
    ways = [np.insert(way, 2, 0.0, axis=1) for way in (
        space_paths.elbow(0.4 * RHO[-1], 0.6 * RHO[-1], 0.1 / space_paths.LENGTH), space_paths.circle(0.4 * RHO[-1])
    )]  # fmt: skip
    for way in (*ways, walk(7, 100)):
        answers = []
        for motions in (way, way @ turn.T):
            point.state[:] = rest
            answers.append(np.array([point.forces(d) for d in motions]))
        missing = (answers[1] @ turn - answers[0]) / [1.0, 1.0, np.inf, *[space_paths.LENGTH] * 2, RADIUS]
        size = np.linalg.norm(answers[0] / [1.0, 1.0, np.inf, *[space_paths.LENGTH] * 2, np.inf], axis=1).max()
        assert np.abs(missing).max() < 0.02 * size


def test_elements_are_used_as_far_as_the_rays_beside_the_larger_motion(point_on: PointOn) -> None:
    """A short ray elsewhere that stopped: 5e-8 m across stopped OpenFAST, where `sequence_in_space` goes on."""
    model, space = invented()
    table, short = model.table, 0
    count, rays = table.count.copy(), space.rays.copy()
    count[short] = int(np.searchsorted(table.rho[short], 0.2 * RHO[-1]))
    rays[short, 1] = table.rho[short, count[short] - 1]
    response = replace(model.response, table=replace(table, count=count))
    ends = {**model.ends, table.path[short]: replace(model.ends[table.path[short]], how="stopped")}
    point = point_on(replace(model, response=response, ends=ends), 0.0)
    space, answered = replace(space, rays=rays), 0
    for d in (*(0.5 * RHO[-1] * np.array([1.0, across, 0.0, 0.0, 0.1, 0.0]) for across in (1e-5, 0.05)), *walk(9, 60)):
        code, used = point.ask(FORCE, d), float(space.range_used(d[None, LATERAL])[0])
        assert point.state.flat[0] == pytest.approx(used, rel=1e-9)
        answered += code == 0
        assert code == 0 or used > 1.0
    assert 10 < answered < 62


def test_the_export_has_the_set_in_space_with_its_errors_and_marks(tmp_path: Path) -> None:
    done = export(calibrated(), "openfast", tmp_path, springs="memory")
    text = (tmp_path / "caisson.txt").read_text()
    for words in ("elements in the space of both planes", "share no friction", "held-back paths: elbow H"):
        (line,) = [remark for remark in done.remarks if words in remark]
        assert line in text.replace("\n! ", " ")
    assert "torsion_Nm 0\n" in text and "45 degrees" not in text and "torsion is linear" not in text


def test_without_a_twist_torsion_is_linear(point_on: PointOn) -> None:
    model, _ = with_space(set_of(elements()[:-3], 0.0))
    assert not any("share no friction" in line for line in model.response.plane_notes())
    point = point_on(model, 3e9)
    for twist in (1e-4, 1e-2):
        assert point.forces(np.array([1e-4, 1e-4, 0, 0, 0, twist]))[5] == pytest.approx(3e9 * twist)


def test_a_twist_beyond_its_path_is_marked(point_on: PointOn, library: Path, capfd: pytest.CaptureFixture[str]) -> None:
    point, largest = point_on(invented()[0], 0.0), TWIST / RADIUS
    for share, warned in ((0.5, 0), (0.999, 0), (1.5, 1)):
        point.forces(np.array([1e-4, 0, 0, 0, 0, share * largest]))
        assert point.state.ravel()[0] == pytest.approx(share, rel=1e-9)
        assert capfd.readouterr().out.count(f"beyond the calibrated range ({share:.3g} laterally") == warned
    text = Path("caisson.txt").read_text()
    _, _, radius, twist, *_ = next(line for line in text.splitlines() if line.startswith("memory ")).split()
    for given, words in ((f"{radius} 0", "have a largest twist"), (f"-{radius} {twist}", "are not negative")):
        Path("caisson.txt").write_text(text.replace(f"{radius} {twist}", given))
        assert Point(library, "./caisson.txt").code == 102 and words in capfd.readouterr().out


def test_soildyn_follows_a_way_around_with_torsion(library: Path, tmp_path: Path) -> None:
    """The program keeps the state from step to step; angles are small, as it makes rotations of them."""
    model, space = invented()
    export(calibrated(), "openfast", tmp_path, z=-30.0, springs="memory")
    (tmp_path / "caisson.txt").write_text(spring_text([], model, 0.0, True, False))
    shutil.copy(library, tmp_path)
    motions = np.concatenate([np.zeros((1, 6)), walk(9, 200)])
    done = openfast.drive(tmp_path, motions, "soildyn_nonlinear.dat")
    assert done.code == 0, done.log
    passed = done.channels[:, 6:12] * [1.0, 1.0, 1.0, *np.radians([1.0, 1.0, 1.0])]  # angles in degrees
    np.testing.assert_allclose(passed, motions, atol=2e-6)
    expected = -space.solve("state", passed[:, LATERAL])[1]
    size = np.abs(expected).max(axis=0)
    np.testing.assert_allclose(1e3 * done.channels[:, LATERAL] / size, expected / size, rtol=1e-6, atol=1e-6)


def test_ten_thousand_calls_a_second_with_a_full_state(point_on: PointOn) -> None:
    model, space = invented(27)
    assert 0.9 * MOST_NUMBERS < numbers_in_space(space.elements.rows) <= MOST_NUMBERS
    point, n = point_on(model, 0.0), 2000
    way = np.linspace(walk(3, 1)[0], 0.2 * walk(4, 1)[0], n)
    start = time.process_time()
    for d in way:
        point.forces(d)
    assert n / (time.process_time() - start) > 1e4
