# SPDX-License-Identifier: MIT
"""Uniaxial springs for other programs: their sums, their tables, and the programs themselves beside `predict`."""

import re
import shutil
import subprocess
import warnings
from itertools import pairwise, product
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from pysprings.core import variables
from pysprings.core.errors import UserInputError
from pysprings.macro.model import MacroModel
from pysprings.macro.predict import predict
from pysprings.results.exporters import Source, export
from pysprings.results.exporters.header import torsion_words
from pysprings.results.exporters.uniaxial_curve import Spring, table
from pysprings.results.exporters.uniaxial_sets import (
    Uniaxial,
    change_by_tables,
    errors_by_role,
    other_planes,
    tables,
    uniaxial,
    with_tables,
)
from pysprings.springs.springs import Springs
from tests.support import fans, space_paths, synthetic
from tests.support.in_opensees import answer_of
from tests.support.vertical import fan_with_vertical, vertical_springs

SUPPORT = Path(__file__).parents[2] / "support"
# H [N], height of the load [m], V [N] above that at rest: mudline, waves, wind, mooring line, towards -x
CASES = [(1.6e6, 0.0, 0.0), (1.0e6, 5.0, 1e6), (0.25e6, 30.0, 3e6), (1.4e6, -1.0, -1e6), (-1.2e6, 2.0, 5e6)]
FULL = 3001


@pytest.fixture(scope="session")
def source() -> Source:
    return Source(fan_with_vertical())


@pytest.fixture(scope="session")
def made(source: Source) -> Uniaxial:
    return uniaxial(Springs.of(source.springs))


@pytest.fixture(scope="session")
def expected(made: Uniaxial) -> np.ndarray:
    """u, rotation and change of w by `predict` in the cases."""
    rows = []
    for H, arm, V in CASES:
        answer = predict_quietly(made.model, H, arm)
        vertical = made.model.vertical
        assert vertical is not None
        rows.append([*answer, vertical.displacement(made.model.rest_load + V) - vertical.rest[0]])
    return np.array(rows)


def predict_quietly(model: MacroModel, H: float, arm: float) -> list[float]:
    with warnings.catch_warnings():  # the path behind a fan is one of its rays
        warnings.simplefilter("ignore")
        answer = predict(model, H=H, arm=arm)
    return [float(answer["u"]), float(answer["rotation"])]


def largest_error(model: MacroModel) -> float:
    """Error of the loads beside a coupled law in closed form, all over the plane of (u, rotation)."""
    errors = []
    for u, rotation in fans.scattered(100):
        own, exact = model.reactions(u, rotation)[0], fans.loads(fans.potential, u, rotation)
        errors.append(np.linalg.norm((own - exact) / [1.0, fans.LENGTH]) / np.linalg.norm(exact / [1.0, fans.LENGTH]))
    return max(errors)


def test_virtual_springs_answer_as_the_fan_in_every_direction(source: Source, made: Uniaxial) -> None:
    """A coupled law in closed form: within 3 % along a plane and between two, and at rest to 1e-4."""
    assert largest_error(made.model) < 0.03 and largest_error(made.between) < 0.03
    K = Springs.of(source.springs).lateral_stiffness
    for model in (made.model, made.between):
        np.testing.assert_allclose(model.reactions(0.0, 0.0)[1], K, rtol=1e-4)


def test_two_planes_carry_too_much_between_them_and_more_planes_less(source: Source) -> None:
    """Plastic springs in two planes carry sqrt(2) times the load at 45 degrees."""
    springs = Springs.of(source.springs)
    errors = [largest_error(uniaxial(springs, planes=planes).between) for planes in (2, 4, 8)]
    assert 0.3 < errors[0] < np.sqrt(2.0) - 1.0 and errors[1] < 0.06 and errors[2] < 0.03
    printed = [float(re.findall(r"([\d.]+) %", other_planes(springs, uniaxial(springs, planes=n)))[0]) for n in (2, 8)]
    assert printed[0] > 30.0 and printed[1] < 3.0
    with pytest.raises(UserInputError, match="3 is not an even number"):
        uniaxial(springs, planes=3)


@pytest.mark.parametrize("kind", ["pisa", "py"])
def test_springs_at_real_depths_spread_over_planes_answer_nearly_as_before(kind: str) -> None:
    springs = Springs.of(vertical_springs())
    two, eight = (uniaxial(springs, kind, planes=planes) for planes in (2, 8))
    for u, rotation in ((2e-3, 3e-4), (-4e-3, -1e-4), (4e-4, 2e-5)):
        exact = two.model.reactions(u, rotation)[0]
        for model in (eight.model, eight.between):
            np.testing.assert_allclose(model.reactions(u, rotation)[0], exact, rtol=0.02)


def test_a_linear_fan_is_exact() -> None:
    springs = Springs.of(fans.fan_springs(fans.linear))
    model = uniaxial(springs).model
    for u, rotation in fans.scattered(20):
        np.testing.assert_allclose(model.reactions(u, rotation)[0], fans.loads(fans.linear, u, rotation), rtol=1e-9)


@pytest.mark.parametrize("kind", ["pisa", "full", "py"])
def test_sets_at_real_depths_keep_resultant_and_moment(kind: str) -> None:
    """Springs of a set whose springs read what they act against: H and M of `predict` at imposed motions."""
    springs = Springs.of(vertical_springs())
    one = uniaxial(springs, kind)
    for u, rotation in ((2e-3, 3e-4), (-4e-3, -1e-4), (0.0, 5e-4)):
        H = M = 0.0
        for spring in one.springs:
            if spring.direction == "lateral":
                force = float(spring.force(np.array([u - spring.depth * rotation]))[0])
                H, M = H + force, M - force * spring.depth
            elif spring.direction == "rotation":
                M += float(spring.force(np.array([rotation]))[0])
        np.testing.assert_allclose([H, M], one.model.reactions(u, rotation)[0], rtol=1e-12, atol=1e-6)
    skirt = [spring for spring in one.springs if spring.name == "p"]
    assert skirt and all(0.0 <= spring.depth <= springs.length and spring.height > 0.0 for spring in skirt)


@pytest.mark.parametrize("kind", ["pisa", "py"])
def test_sets_at_real_depths_answer_as_predict_does(kind: str) -> None:
    springs = Springs.of(vertical_springs())
    model = MacroModel.from_springs(springs, kind)
    rings, zone = uniaxial(springs, kind), uniaxial(springs, kind, slices="zone")
    for u, rotation in ((2e-3, 3e-4), (-4e-3, -1e-4), (1e-3, 5e-4)):
        wanted = model.reactions(u, rotation)[0]
        np.testing.assert_allclose(rings.model.reactions(u, rotation)[0], wanted, rtol=1e-9)
        np.testing.assert_allclose(zone.model.reactions(u, rotation)[0], wanted, rtol=0.02)
    assert len(zone.springs) < len(rings.springs)
    with pytest.raises(UserInputError, match="virtual springs have no slices"):
        uniaxial(Springs.of(fans.fan_springs(fans.linear)), slices="zone")


def test_springs_that_read_another_displacement_are_named() -> None:
    one = uniaxial(Springs.of(synthetic.make_springs()), "full")
    own = one.model.table
    cross = own.a[:, 0] * own.b[:, 1] - own.a[:, 1] * own.b[:, 0]
    np.testing.assert_allclose(cross, 0.0, atol=1e-9 * np.abs(own.b).max())


@pytest.mark.parametrize("rounding", [0.0, 1e-19])
def test_a_rotation_that_is_rounding_carries_no_spring(rounding: float) -> None:
    """An imposed rotation of 0 comes back as 1e-20 under some vertical loads; moments grow along the path."""
    tree = vertical_springs()
    path = tree["paths/slide"].to_dataset(inherit=False)
    path["m"] = path["m"] + 1e8 * path["u"]
    path["rotation"] = rounding * path["u"]
    tree["paths/slide"].dataset = path
    made = uniaxial(Springs.of(tree), "full")
    assert "M_rest" not in {spring.name for spring in made.springs}
    assert "their moment is left out: its displacement does not grow on the path" in made.lost


@pytest.mark.parametrize("points", [5, 20, 41, 401])
def test_tables_are_bounded_by_their_printed_error(made: Uniaxial, points: int) -> None:
    for spring in made.springs:
        one = table(spring, points)
        assert one.q.size <= points
        assert (np.diff(one.q) > 0.0).all() and (np.diff(one.f) > 0.0).all()
        assert one.f[one.q == 0.0] == 0.0
        assert (one.q[0], one.q[-1]) == pytest.approx((spring.low, spring.high))
        x = np.random.default_rng(1).uniform(spring.low, spring.high, 5000)
        y = spring.force(x)
        left = np.abs(np.interp(x, one.q, one.f) - y).max() / np.abs(y).max()
        assert left <= one.error * (1.0 + 1e-3) + 1e-12
        assert one.error < {5: 0.2, 20: 0.03, 41: 0.01, 401: 1e-4}[points]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_spring_that_loses_all_of_its_reaction_keeps_its_way_there(sign: float) -> None:
    """As under a lid that lifts off: up to 1 in the middle, and 0 at the end."""
    spring = Spring("H_lid", "lateral", 0.0, 0.0, -1.0, 1.0, lambda x: sign * 4.0 * x * (1.0 - np.abs(x)))
    one = table(spring, 401)
    x = np.linspace(-1.0, 1.0, 101)
    np.testing.assert_allclose(np.interp(x, one.q, one.f), spring.force(x), atol=1e-3)


@pytest.mark.parametrize("program", ["calculix", "sacs"])
def test_errors_are_those_on_paths_at_the_vertical_load_of_the_springs(tmp_path: Path, program: str) -> None:
    tree = vertical_springs(heavier=(6e6,))
    lines = export(Source(tree), program, tmp_path, springs="pisa", V=6e6).remarks
    (errors,) = (line for line in lines if "calibration paths, largest" in line)
    assert "slide_6" in errors or "turn_6" in errors
    assert "% (slide_6), u up to half of the largest load" in errors
    assert not any(f"({name})" in line for line in lines for name in ("slide", "turn"))


def test_paths_on_which_the_vertical_load_changes_are_no_error_of_springs_at_one() -> None:
    tree = vertical_springs()
    for name, V in (("held", 0.0), ("changing", 2.0)):
        path = tree["paths/slide"].to_dataset(inherit=False)
        path["H"] = 2.0 * path["H"]
        path["V"] = path["V"] * (1.0 + V * path["u"] / path["u"][-1])
        path.attrs |= {"role": "memory", "heave": "free"}
        tree[f"paths/{name}"] = xr.DataTree(path)
    springs = Springs.of(tree)
    (line,) = (each for each in errors_by_role(springs, uniaxial(springs).model, "error") if "memory paths" in each)
    assert "(held)" in line and "(changing)" not in line


@pytest.mark.parametrize("program", ["calculix", "sacs"])
def test_what_lateral_motion_does_to_w_is_stated(tmp_path: Path, program: str) -> None:
    """w of the translation falls by 0.15 u^2/5 mm, u up to 10 mm."""
    lines = export(Source(vertical_springs()), program, tmp_path, points=20).remarks
    assert [line for line in lines if line.endswith("lateral springs it does, by -3 to +0 mm")]


def test_straight_lines_are_those_of_the_tables(made: Uniaxial) -> None:
    given = tables(made, 20)
    model = with_tables(made, given)
    for u, rotation in fans.scattered(30, size=6e-3):
        H = M = 0.0
        for each, c in product(given, np.cos(np.pi / made.planes * np.arange(made.planes))):
            if each.spring.direction == "lateral":
                force = c * float(np.interp(c * (u - each.spring.depth * rotation), each.q, each.f))
                H, M = H + force, M - force * each.spring.depth
            elif each.spring.direction == "rotation":
                M += c * float(np.interp(c * rotation, each.q, each.f))
        np.testing.assert_allclose(model.reactions(u, rotation)[0], [H, M], rtol=1e-6)


def test_the_error_of_the_tables_is_printed(source: Source, made: Uniaxial) -> None:
    springs = Springs.of(source.springs)
    shares = [
        [
            float(value)
            for value in re.findall(r"([\d.e-]+) %", change_by_tables(springs, made.model, with_tables(made, t)))
        ]
        for t in (tables(made, 20), tables(made, 401))
    ]
    assert len(shares[0]) == 4
    assert all(few > 50.0 * many for few, many in zip(*shares, strict=True))


def check(found: np.ndarray, expected: np.ndarray, error: float) -> None:
    """Compare u and rotation; w, of one curve whose table is not helped by others, to twice the error."""
    np.testing.assert_allclose(found[:, :2], expected[:, :2], rtol=error)
    np.testing.assert_allclose(found[:, 2], expected[:, 2], rtol=2.0 * error, atol=1e-12)


def test_linear_torsion_stands_beside_that_of_a_twist() -> None:
    """Winkler springs of the outside law yield along it."""
    springs = Springs.of(space_paths.springs(True))
    words = torsion_words(space_paths.TORSION, springs)
    turn, twist = (float(springs.space["twist"][name][-1]) for name in ("rot_z", "T"))
    assert f"T is {1e-6 * space_paths.TORSION * turn:.4g} MN m, {1e-6 * twist:.4g} in the full model" in words
    assert 0.0 < twist < 0.9 * space_paths.TORSION * turn


# --- OpenSees ---


def in_opensees(
    folder: Path, steps: int = 20, angle: float = 0.0, ending: str = "py", skirt: tuple[float, ...] = (),
    held: tuple[int, ...] = (), constraints: tuple[str | float, ...] = ("Transformation",), system: str = "FullGeneral",
    test: tuple[str, float] = ("NormDispIncr", 1e-13),
) -> np.ndarray:  # fmt: skip
    """u, rotation, w, motion across and number of nodes of the script under the cases in a direction."""
    cases = [(H, H * arm, V) for H, arm, V in CASES]
    task = {
        "script": str(folder / f"caisson_opensees.{ending}"),
        "loads": cases,
        "steps": steps,
        "angle": angle,
        "skirt": skirt,
        "held": held,
        "constraints": constraints,
        "system": system,
        "test": test,
    }
    rows = np.array(answer_of(SUPPORT / "opensees_caisson.py", task))
    assert not rows[:, 0].any()
    return rows[:, 1:]


@pytest.mark.parametrize(("points", "error"), [pytest.param(FULL, 1e-6, marks=pytest.mark.slow), (20, 5e-3)])
def test_opensees_finds_what_predict_finds(
    source: Source, expected: np.ndarray, tmp_path: Path, points: int, error: float
) -> None:
    export(source, "opensees", tmp_path, points=points)
    found = in_opensees(tmp_path)
    check(found, expected, error)
    assert found[:, 3].max() < 1e-9


@pytest.mark.parametrize("handler", [("Plain",), ("Transformation",), ("Penalty", 1e16, 1e16), ("Auto",)], ids=str)
def test_what_a_user_holds_by_fix_does_not_make_the_answer_depend_on_steps(
    source: Source, tmp_path: Path, handler: tuple[str | float, ...]
) -> None:
    """Torsion, and a tower in a plane, in 1, 2 and 20 steps; rigid links gave 0.04, 0.06 and 0.18 mm for one load."""
    export(source, "opensees", tmp_path, points=20)
    for held in ((0, 0, 0, 0, 0, 1), (0, 1, 0, 1, 0, 1)):
        rows = [in_opensees(tmp_path, steps, held=held, constraints=handler)[:, :3] for steps in (20, 1, 2)]
        for other in rows[1:]:
            np.testing.assert_allclose(other, rows[0], rtol=1e-6, atol=1e-12)


@pytest.mark.slow
def test_opensees_under_loads_between_two_planes(source: Source, made: Uniaxial, tmp_path: Path) -> None:
    """Planes from 20 degrees on, the load at 31.25: `predict` of the motion between two planes, the fan to 3 %."""
    export(source, "opensees", tmp_path, points=FULL, azimuth=np.radians(20.0))
    found = in_opensees(tmp_path, angle=np.radians(31.25))
    own = np.array([predict_quietly(made.between, H, arm) for H, arm, _ in CASES])
    np.testing.assert_allclose(found[:, :2], own, rtol=1e-6)
    fan = np.array([predict_quietly(MacroModel.from_springs(source.springs), H, arm) for H, arm, _ in CASES])
    np.testing.assert_allclose(found[:, :2], fan, rtol=0.05)


def test_tcl_and_python_hold_the_same_springs(source: Source, tmp_path: Path) -> None:
    export(source, "opensees", tmp_path, points=20)
    numbers = [
        [
            float(x)
            for x in re.findall(r"-?\d+\.?\d*(?:e[-+]?\d+)?", re.sub(r"(?m)^ *#.*$", "", text.split("attach")[0]))
        ]
        for text in ((tmp_path / f"caisson_opensees.{ending}").read_text() for ending in ("py", "tcl"))
    ]
    assert len(numbers[0]) > 500
    assert numbers[0] == numbers[1][: len(numbers[0])]


def test_hysteresis_is_on_request_and_labelled(source: Source, tmp_path: Path) -> None:
    plain = export(source, "opensees", tmp_path, points=20)
    assert not any("Masing" in remark for remark in plain.remarks)
    done = export(source, "opensees", tmp_path, points=20, material="masing")
    assert any("Masing" in remark for remark in done.remarks)
    assert "Masing" in (tmp_path / "caisson_opensees.py").read_text()
    monotonic = in_opensees(tmp_path)
    assert np.isfinite(monotonic).all()


def test_a_test_of_unbalanced_loads_is_met(source: Source, tmp_path: Path) -> None:
    """Beams too stiff leave rounding: 1e8 times the stiffest spring did not meet 0.5 N under some MN."""
    export(source, "opensees", tmp_path, points=20)
    found = in_opensees(tmp_path, test=("NormUnbalance", 0.5))
    np.testing.assert_allclose(found[:, :3], in_opensees(tmp_path)[:, :3], rtol=1e-5, atol=1e-12)


@pytest.mark.parametrize("ending", ["py", "tcl"])
def test_a_solver_for_positive_matrices_finds_the_same(source: Source, tmp_path: Path, ending: str) -> None:
    """Beams to virtual depths above the lid have a section of their size, not a negative one."""
    export(source, "opensees", tmp_path, points=20)
    whole, banded = (in_opensees(tmp_path, ending=ending, system=name) for name in ("FullGeneral", "BandSPD"))
    np.testing.assert_allclose(banded[:, :3], whole[:, :3], rtol=1e-6, atol=1e-12)


def test_tcl_and_python_give_the_same_answers(source: Source, tmp_path: Path) -> None:
    """The Tcl commands run in OpenSees, by the interpreter of Python's tkinter where that is there."""
    export(source, "opensees", tmp_path, points=20)
    np.testing.assert_allclose(in_opensees(tmp_path, ending="tcl"), in_opensees(tmp_path), rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("ending", ["py", "tcl"])
def test_springs_at_real_depths_hang_on_a_skirt_of_beams(tmp_path: Path, ending: str) -> None:
    """A rigid skirt with nodes at the springs answers as the rigid links do."""
    export(Source(vertical_springs()), "opensees", tmp_path, springs="pisa", slices="rings", points=20)
    made = uniaxial(Springs.of(vertical_springs()), "pisa")
    depths = tuple(each.depth for each in made.springs if each.name == "p" and each.depth)
    plain, hung = in_opensees(tmp_path, ending=ending), in_opensees(tmp_path, ending=ending, skirt=depths[1:])
    np.testing.assert_allclose(hung[:, :4], plain[:, :4], rtol=1e-7, atol=1e-12)
    hanging = sum(each.direction == "lateral" and each.depth in depths[1:] for each in made.springs)
    assert hanging >= len(depths) - 1 > 5
    assert hung[0, 4] == plain[0, 4] + len(depths[1:]) - hanging  # nodes of the skirt in place of those of springs


# --- CalculiX ---


def in_calculix(folder: Path, H: float, arm: float, V: float) -> np.ndarray:
    """u, rotation and w of the exported example under other loads."""
    text = (folder / "example_calculix.inp").read_text()
    text = text.replace("1, 1, 1.E6\n", f"1, 1, {H}\n1, 3, {-V}\n").replace("2, 2, 5.E6", f"2, 2, {H * arm}")
    (folder / "case.inp").write_text(text)
    done = subprocess.run(["ccx", "case"], cwd=folder, capture_output=True, text=True, timeout=280)
    assert done.returncode == 0 and "Job finished" in done.stdout, done.stdout[-2000:]
    lid, rotations = (
        [float(x) for x in line.split()[1:]] for line in (folder / "case.dat").read_text().splitlines()[-2:]
    )
    return np.array([lid[0], rotations[1], -lid[2]])


needs_ccx = pytest.mark.skipif(shutil.which("ccx") is None, reason="ccx is not installed (Debian: calculix-ccx)")


@needs_ccx
@pytest.mark.slow
@pytest.mark.parametrize(("points", "error"), [(FULL, 1e-6), (20, 5e-3)])
def test_calculix_finds_what_predict_finds(
    source: Source, made: Uniaxial, expected: np.ndarray, tmp_path: Path, points: int, error: float
) -> None:
    """Five cases; seven digits are printed. With few points also what their straight lines give, to 1e-6."""
    export(source, "calculix", tmp_path, points=points)
    answers = np.array([in_calculix(tmp_path, *case) for case in CASES])
    check(answers, expected, error)
    straight = with_tables(made, tables(made, points))
    loads = np.array([[H, H * arm] for H, arm, _ in CASES])
    np.testing.assert_allclose(answers[:, :2], straight.response.solve_cases(loads)[0], rtol=1e-6)


def spring_tables(text: str) -> list[list[tuple[float, float]]]:
    """Tables (displacement, force) of the nonlinear springs of a deck, in their order."""
    number = r"-?\d\.\d+E[-+]\d+"
    blocks = re.findall(rf"\*SPRING, ELSET=SPRING\d+, NONLINEAR\n(?:1, 1\n)?((?:{number}, {number}\n?)+)", text)
    rows = [[line.split(",") for line in block.splitlines()] for block in blocks]
    return [[(float(q), float(f)) for f, q in block] for block in rows]


def number_of_springs(source: Source) -> int:
    """Springs of all planes."""
    made = uniaxial(Springs.of(source.springs))
    return sum(made.planes if spring.odd else 1 for spring in made.springs)


def source_without_torsion(source: Source) -> Source:
    springs = source.springs.copy()
    del springs.attrs[variables.TORSION]
    return Source(springs)


def test_springs_in_parallel_carry_tables_that_are_too_long_for_calculix(source: Source, tmp_path: Path) -> None:
    export(source_without_torsion(source), "calculix", tmp_path, points=401)
    parts = spring_tables((tmp_path / "caisson_calculix.inp").read_text())
    made = uniaxial(Springs.of(source.springs))
    whole = [row for row in tables(made, 401) for _ in range(made.planes if row.spring.odd else 1)]
    assert len(whole) == number_of_springs(source) and len(parts) == 3 * len(whole)
    assert max(map(len, parts)) <= 200
    for k, row in enumerate(whole):
        x = np.linspace(row.q[1], row.q[-2], 1000)
        together = sum(np.interp(x, *np.array(part).T) for part in parts[3 * k : 3 * k + 3])
        np.testing.assert_allclose(together, np.interp(x, row.q, row.f), rtol=1e-9, atol=1e-9 * row.f.max())


def test_tables_of_calculix_rise_through_the_origin(source: Source, tmp_path: Path) -> None:
    export(source_without_torsion(source), "calculix", tmp_path, points=20)
    blocks = spring_tables((tmp_path / "caisson_calculix.inp").read_text())
    assert len(blocks) == number_of_springs(source)
    for block in blocks:
        assert all(b[0] > a[0] and b[1] > a[1] for a, b in pairwise(block))
        assert (0.0, 0.0) in block
    assert "*BOUNDARY\n2, 3" in (tmp_path / "example_calculix.inp").read_text()  # torsion is held without a value


@pytest.mark.slow
def test_headers_name_origin_conditions_and_losses(source: Source, tmp_path: Path) -> None:
    for name, files in {"opensees": ("py", "tcl"), "calculix": ("inp",)}.items():
        export(source, name, tmp_path, points=20)
        for ending in files:
            text = (tmp_path / f"caisson_{name}.{ending}").read_text()
            for words in (
                "written by pysprings", str(source.springs.attrs["scene_sha256"]), "z up", "units: m, rad, N, N m",
                "drainage: drained", "vertical load at rest", "not for cyclic", "lateral paths: |u| to",
                "largest errors of springs fan against the full model",
                "error of these springs beside the full model, calibration paths, largest: H", "degrees from a plane",
                "behind their range springs go on",
                "the tables change H by at most", "torsion is linear, with the stiffness of the full model",
            ):  # fmt: skip
                assert words in text, (name, words)
