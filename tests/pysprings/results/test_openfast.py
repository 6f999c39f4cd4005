# SPDX-License-Identifier: MIT
"""The OpenFAST export: labels and matrix read back by the rules of the program, and SoilDyn's own driver."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.optimize import brentq

from pysprings.core import variables
from pysprings.core.errors import UserInputError
from pysprings.macro.answer import trace
from pysprings.macro.model import MacroModel
from pysprings.macro.predict import MacroWarning, impose, predict
from pysprings.macro.stiffness import stiffness, stiffness_six
from pysprings.memory.elements import PLATES
from pysprings.results.exporters import Source, export
from pysprings.results.exporters.soildyn.library import COMPILERS, build, library_input, library_name
from pysprings.results.exporters.subdyn import labels, linear, linear_errors, secants
from pysprings.results.tables import open_table
from pysprings.springs.springs import Springs
from tests.support import loaded, openfast, rates, subdyn, synthetic, winkler, written
from tests.support.commands import command
from tests.support.fans import LENGTH
from tests.support.vertical import K as K_REST, fan_with_vertical, vertical_springs

TORSION = synthetic.TORSION


@pytest.fixture(scope="session")
def source() -> Source:
    return Source(vertical_springs())  # compared once, exported often


@pytest.fixture
def folder(source: Source, tmp_path: Path) -> Path:
    export(source, "openfast", tmp_path, x=1.5, y=-2.0, z=-30.0)
    return tmp_path


def test_a_mudline_above_still_water_is_refused_before_anything_is_written(source: Source, tmp_path: Path) -> None:
    with pytest.raises(UserInputError, match=r"30 m is above still water, the mudline below it: such as -30 m"):
        export(source, "openfast", tmp_path / "out", z=30.0)
    assert not list(tmp_path.rglob("*.dat"))


def read_ssi(file: Path) -> dict[str, float]:
    """Values by label, as SubDyn reads them: comments left out, labels in any case."""
    lines = [line.split() for line in file.read_text().splitlines() if line[0] not in "!#%"]
    return {label.lower(): float(value) for value, label in lines}


def matrix_of(values: dict[str, float], letter: str) -> np.ndarray:
    """Symmetric matrix of SubDyn's labels."""
    names = ("x", "y", "z", "tx", "ty", "tz")
    return np.array(
        [[values.get(f"{letter}{a}{b}", values.get(f"{letter}{b}{a}")) for b in names] for a in names], dtype=float
    )


def soildyn_matrix(file: Path) -> np.ndarray:
    return np.array([[float(cell) for cell in line.split()] for line in file.read_text().splitlines()[9:15]])


def test_all_labels_in_the_order_of_the_program(folder: Path) -> None:
    pairs = "xx xy yy xz yz zz xtx ytx ztx txtx xty yty zty txty tyty xtz ytz ztz txtz tytz tztz"
    order = [f"K{pair}" for pair in pairs.split()]
    assert [label for label, *_ in labels("K")] == order
    values = read_ssi(folder / "subdyn_ssi.dat")
    assert list(values) == [label.lower() for label in [*order, *(f"M{label[1:]}" for label in order)]]
    assert len(values) == 42
    assert not matrix_of(values, "m").any()


def test_the_matrix_holds_the_caisson_with_z_up(folder: Path) -> None:
    springs = vertical_springs()
    values = read_ssi(folder / "subdyn_ssi.dat")
    K = matrix_of(values, "k")
    np.testing.assert_array_equal(K, soildyn_matrix(folder / "soildyn.dat"))
    np.testing.assert_allclose(K, K.T)
    assert np.linalg.eigvalsh(K).min() > 0.0
    assert values["kxty"] < 0.0 < values["kytx"]  # a foundation below its joint
    assert (values["kxx"], values["kytx"], values["ktxtx"]) == (values["kyy"], -values["kxty"], values["ktyty"])
    assert values["ktztz"] == TORSION
    # in the frame of `stiffness_six`
    ours = stiffness_six(springs).values
    ours[5, 5] = TORSION
    for k in range(6):
        motion = np.eye(6)[k] + 0.3 * np.arange(6)
        assert motion @ K @ motion == pytest.approx(motion @ ours @ motion, rel=1e-12)


def test_the_header_names_origin_conditions_and_errors(folder: Path) -> None:
    springs = vertical_springs()
    for name in ("subdyn_ssi.dat", "soildyn.dat"):
        text = (folder / name).read_text()
        for words in (
            "written by pysprings", str(springs.attrs["scene_sha256"]), "z up", "N m/rad", "drainage: drained",
            "vertical load at rest: 2000 kN", "not cyclic", "lateral paths: |u| to", "largest errors of springs",
            "foundation matrix: stiffness at rest", "error of the linear response in H and M",
            "all six flags of the base reaction joint are 0",
        ):  # fmt: skip
            assert words in text, (name, words)


@pytest.mark.parametrize("kind", ["fan", "memory"])
@pytest.mark.parametrize(("V", "at"), [(None, loaded.REST), (loaded.HEAVY, loaded.HEAVY)])
def test_range_and_errors_are_those_of_the_springs_in_the_file(
    tmp_path: Path, kind: str, V: float | None, at: float
) -> None:
    """Of several vertical loads those of one; a path held back at another load is no check of these."""
    tree = loaded.springs().tree.copy()
    light = tree["paths/ray_0_1"].to_dataset(inherit=False)
    tree["paths/held"] = xr.DataTree(light.assign_attrs(role="held-back"))
    export(Source(tree), "openfast", tmp_path, springs=kind, V=V)
    lines = (tmp_path / "caisson.txt").read_text().splitlines()
    own = loaded.springs().at(V=at).lateral
    (ranges,) = (line for line in lines if "lateral paths: |u| to" in line)
    assert f"|H| to {1e-3 * max(np.abs(path['H']).max() for path in own):.5g} kN" in ranges
    assert f"! lateral springs at V = {1e-3 * at:g} kN" in lines
    assert any("no path is held back at V = 4000 kN" in line for line in lines) == (at == loaded.HEAVY)
    (errors,) = (line for line in lines if f"largest errors of springs {kind}" in line)
    assert ("1 held-back paths" in errors) == (at == loaded.REST)
    assert ("displacement at equal load" in errors) == ("that up to half of the largest load" in errors)
    assert any(f"fan of {len(own)} rays" in line for line in lines)


def test_the_head_has_what_springs_at_other_vertical_loads_carry(tmp_path: Path) -> None:
    """Of ray_0, H at the end of both, and of the rotation M; springs at one load have no other."""
    export(Source(loaded.springs().tree), "openfast", tmp_path / "several")
    head = (tmp_path / "several" / "caisson.txt").read_text()
    rest, heavy = (loaded.springs().at(V=V) for V in (loaded.REST, loaded.HEAVY))
    (line,) = re.findall(rf"! springs at V = {1e-3 * loaded.HEAVY:g} kN; (.*)\n", head)
    found = re.findall(r"([HM]) (\S+) kN(?: m)? in place of (\S+) \((\S+) %\) at (\S+) (?:mm|mrad) of", line)
    assert [row[0] for row in found] == ["H", "M"]
    for (load, *numbers), one, two in zip(found, rest.pure_paths, heavy.pure_paths, strict=True):
        name, paths = "u" if load == "H" else "rotation", (heavy.paths[two], rest.paths[one])
        motion = [np.abs(path[name]) for path in paths]
        end = min(each.max() for each in motion)
        their, own = (np.interp(end, x, np.abs(path[load])) for x, path in zip(motion, paths, strict=True))
        assert [float(each) for each in numbers] == pytest.approx(
            [1e-3 * their, 1e-3 * own, 100.0 * (their / own - 1.0), 1e3 * end], rel=2e-3, abs=0.06
        )
    export(vertical_springs(), "openfast", tmp_path / "one")
    assert "lateral springs at V = 2000 kN: at another V they are not" in (tmp_path / "one/caisson.txt").read_text()


def test_torsion_that_no_full_model_has_computed_is_named(tmp_path: Path) -> None:
    unknown = vertical_springs().copy()
    del unknown.attrs[variables.TORSION]
    for springs, words in ((unknown, "torsion is not known"), (vertical_springs(), "torsion is linear")):
        remarks = export(Source(springs), "openfast", tmp_path).remarks
        assert sum(words in text for text in remarks) == (2 if springs is unknown else 1)


def test_the_linear_error_is_that_of_the_matrix(source: Source, tmp_path: Path) -> None:
    """On the recorded end of a translation: K u less H, over the largest H."""
    springs = source.springs
    remarks = export(source, "openfast", tmp_path).remarks
    (line,) = [remark.split() for remark in remarks if remark.startswith("slide ")]
    path = springs["paths/slide"]
    K = springs["stiffness_initial"].values
    u, rotation, H = (float(path[name][-1]) for name in ("u", "rotation", "H"))
    error = 100.0 * (K[0, 0] * u + K[0, 2] * rotation - H) / float(np.abs(path["H"]).max())
    assert line[2:4] == [f"{1e3 * u:.3g}", f"{1e3 * rotation:.3g}"]
    assert line[6] == f"{error:+.1f}"


@pytest.mark.parametrize(("name", "motion", "load", "column"), [("slide", "u", "H", -3), ("turn", "rotation", "M", -1)])
def test_the_secants_beside_a_matrix_carry_the_recorded_loads(
    source: Source, name: str, motion: str, load: str, column: int
) -> None:
    path = source.springs[f"paths/{name}"]
    size, loads = (np.abs(path[key].values) for key in (motion, load))
    rows = [line.split() for line in secants(Springs.of(source.springs))[3:]]
    assert rows[0][-3] == f"{1e-6 * float(source.springs['stiffness_initial'][0, 0]):.4g}"
    K = MacroModel.from_springs(source.springs).tangent_stiffness().values
    own = (K[0, 0], 0.5 * (K[0, 2] + K[2, 0]), K[2, 2])
    assert rows[1] == ["springs", "at", "rest", *(f"{1e-6 * value:.4g}" for value in own)]
    shown = {row[1]: row for row in rows if row[0] == f"{name},"}
    assert list(shown) == ["10", "50"]
    for share, row in shown.items():
        step = int(np.argmin(np.abs(size - 0.01 * float(share) * size.max())))
        assert float(row[-5 if motion == "u" else -4]) == pytest.approx(1e3 * size[step], rel=5e-3)
        assert 1e6 * float(row[column]) * size[step] == pytest.approx(loads[step], rel=1e-3)


def test_missing_torsion_is_a_remark(tmp_path: Path) -> None:
    springs = synthetic.make_springs()
    assert not any("Ktztz" in remark for remark in export(springs, "openfast", tmp_path).remarks)
    del springs.attrs[variables.TORSION]
    assert any("Ktztz is 0" in remark for remark in export(springs, "openfast", tmp_path).remarks)


def test_springs_without_a_vertical_stiffness_are_refused(tmp_path: Path) -> None:
    table, _ = written.tables(tmp_path, synthetic.make_springs())
    with pytest.raises(UserInputError, match="no vertical stiffness"):
        export(open_table(table), "openfast", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_command(tmp_path: Path) -> None:
    export(vertical_springs(), "nc", tmp_path / "springs.nc")
    done = command("export", tmp_path, "--to", "openfast", "--option", "z=-30 m")
    assert done.code == 0, done.err
    names = ("subdyn_ssi.dat", "subdyn_spring.dat", "soildyn.dat", "caisson.txt", "soildyn_nonlinear.dat")
    assert done.out.split() == [str(tmp_path / "openfast" / name) for name in names]
    assert "note: linear: " in done.err and "note: in SubDyn all six flags" in done.err
    assert "all six flags" in (tmp_path / "openfast" / "soildyn_nonlinear.dat").read_text()
    assert "all six flags" in command("export", tmp_path, "--to", "subdyn").err
    assert "0 0 -30 " in (tmp_path / "openfast" / "soildyn.dat").read_text()


# --- the program itself ---


def test_soildyn_reacts_with_the_matrix_in_all_directions(folder: Path) -> None:
    K = soildyn_matrix(folder / "soildyn.dat")
    size = np.array([1e-3, 1e-3, 1e-3, 1e-6, 1e-6, 1e-6])
    motions = np.concatenate([np.diag(size), -np.diag(size), np.random.default_rng(1).uniform(-1, 1, (20, 6)) * size])
    motions = np.concatenate([np.zeros((1, 6)), motions])
    done = openfast.drive(folder, motions)
    assert done.code == 0, done.log
    expected = -motions @ K.T  # SoilDyn returns the action of the soil, in kN
    np.testing.assert_allclose(1e3 * done.channels[:, :6], expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max())


# --- SubDyn ---


@pytest.fixture
def matrix_folder(source: Source, tmp_path: Path) -> Path:
    export(source, "subdyn", tmp_path)
    return tmp_path


MOTION = 1e-2 * np.array([1e-3, 2e-3, -1e-3, 1e-5, 2e-5, 3e-5])  # loads act on the moved tower: small


def loads_of_the_matrix(folder: Path) -> np.ndarray:
    """Loads (6,) that hold the top of a rigid tower on the matrix of the SSI file."""
    K, h = matrix_of(read_ssi(folder / "subdyn_ssi.dat"), "k"), subdyn.TOP - subdyn.BASE
    T = np.eye(6)
    T[0, 4], T[1, 3] = -h, h
    return T.T @ K @ T @ MOTION


def test_subdyn_reads_all_values_of_the_ssi_file_and_reacts_with_them(matrix_folder: Path) -> None:
    (matrix_folder / "ssi.dat").write_text(subdyn.tower('1 0 0 0 0 0 0 "subdyn_ssi.dat"'))
    loads = subdyn.interface_loads(matrix_folder, "ssi", MOTION)
    np.testing.assert_allclose(loads, loads_of_the_matrix(matrix_folder), rtol=1e-3)  # the tower is stiff, not rigid
    values = read_ssi(matrix_folder / "subdyn_ssi.dat")
    lines = [
        line.split("=") for line in (matrix_folder / "ssi.SD.ech").read_text().splitlines() if line.count("=") == 1
    ]
    echo = {right.strip().lower(): float(left) for left, right in lines if right.strip().lower() in values}
    assert len(echo) == 42
    for label, value in values.items():
        assert echo[label] == pytest.approx(value, rel=1e-4)


def test_the_spring_element_reacts_as_the_ssi_file(matrix_folder: Path) -> None:
    rows = (matrix_folder / "subdyn_spring.dat").read_text().splitlines()
    spring = rows[next(k for k, row in enumerate(rows) if row.startswith("PropSetID")) + 2]
    member = next(row for row in rows if row.startswith("<MemberID>"))
    member = (
        member.replace("<MemberID>", "2").replace("<joint of the tower>", "1").replace("<joint of the ground>", "3")
    )
    text = subdyn.tower("3 1 1 1 1 1 1", f"3 0 0 {subdyn.BASE} 1 0 0 0 0", member, spring, rows[-1])
    (matrix_folder / "spring.dat").write_text(text)
    loads = subdyn.interface_loads(matrix_folder, "spring", MOTION)
    np.testing.assert_allclose(loads, loads_of_the_matrix(matrix_folder), rtol=1e-3)


# --- the nonlinear foundation in SoilDyn ---


@pytest.fixture(scope="session")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if not any(shutil.which(name) for name in COMPILERS):
        pytest.skip("there is no C compiler")
    return build(tmp_path_factory.mktemp("library"))


@pytest.fixture(scope="session")
def fan() -> Source:
    return Source(fan_with_vertical())


@pytest.fixture
def soil(library: Path, fan: Source, tmp_path: Path) -> Path:
    """Folder with library, spring file and the input of one point."""
    export(fan, "openfast", tmp_path, z=-30.0)
    shutil.copy(library, tmp_path)
    return tmp_path


def random_motions(n: int, seed: int) -> np.ndarray:
    """Motions (n, 6) in planes of all directions, within the range of `fan_with_vertical`, a tenth of them twists."""
    random = np.random.default_rng(seed)
    rho, phi, direction = 7.5e-3 * random.random(n), *(2 * np.pi * random.random((2, n)))
    u, rotation = rho * np.cos(phi), rho * np.sin(phi) / LENGTH
    c, s = np.cos(direction), np.sin(direction)
    down, twist = random.uniform(-9e-3, 9e-3, n), random.uniform(-1e-4, 1e-4, n)
    # SoilDyn makes a rotation matrix of the angles and angles of the matrix: a twist besides would turn the others
    twist[n // 10 :], rotation[: n // 10] = 0.0, 0.0
    return np.stack([u * c, u * s, -down, -rotation * s, rotation * c, twist], axis=1)


def soil_action(model: MacroModel, motions: np.ndarray) -> np.ndarray:
    """Action of the soil (n, 6) [N, N m] in the frame of OpenFAST by the macro-model, at motions in one plane."""
    out = np.zeros_like(motions)
    for row, (x, y, z, rx, ry, rz) in zip(out, motions, strict=True):
        c, s = (x, y) / np.hypot(x, y)
        u, rotation = x * c + y * s, ry * c - rx * s
        H, M = model.reactions(u, rotation)[0]
        V = brentq(lambda V, z=z, u=u, rotation=rotation: vertical_of(model, u, rotation, V) + z, -3e6, 1e8, xtol=1e-3)
        row[:] = -H * c, -H * s, V, M * s, -M * c, -TORSION * rz
    return out


def vertical_of(model: MacroModel, u: float, rotation: float, V: float) -> float:
    """w [m] of `predict` under V at an imposed motion, from the parts that `impose` adds."""
    assert model.vertical is not None
    rows = model.table.rows(np.array([[u, rotation]]))
    w, V_path = (float(rows[model.table.name == name][0, 0]) for name in ("w", "V"))
    return w + model.vertical.displacement(V) - model.vertical.displacement(V_path)


@pytest.mark.slow
def test_soildyn_reacts_as_predict_in_a_thousand_states(soil: Path) -> None:
    model = MacroModel.from_springs(fan_with_vertical())
    motions = random_motions(1000, seed=4)
    assert (motions.min(axis=0) < 0.0).all() and (motions.max(axis=0) > 0.0).all()
    done = openfast.drive(soil, motions, "soildyn_nonlinear.dat")
    assert done.code == 0, done.log
    passed = done.channels[:, 6:12] * np.radians([*np.degrees([1.0, 1.0, 1.0]), 1.0, 1.0, 1.0])  # angles in degrees
    np.testing.assert_allclose(passed, motions, atol=1e-6)
    expected = soil_action(model, passed)
    sizes = np.abs(expected).max(axis=0)
    np.testing.assert_allclose(1e3 * done.channels[:, :6] / sizes, expected / sizes, rtol=1e-6, atol=1e-6)
    for u, rotation, V in ((3e-3, -5e-4, 4e6), (-2e-3, 8e-4, -1e6)):  # the parts above are those of `impose`
        with pytest.warns(MacroWarning):
            answer = impose(model, u=u, rotation=rotation, V=V, extrapolate=True)
        assert float(answer["w"]) == pytest.approx(vertical_of(model, u, rotation, V), rel=1e-12)


def test_four_points_are_independent(soil: Path, source: Source) -> None:
    """Each reacts to its own springs: two are of another caisson, and all have the same motion."""
    export(source, "openfast", soil / "other")
    head = (soil / "soildyn_nonlinear.dat").read_text().splitlines()[:2]
    places = [(x, y, -30.0) for x in (-6.0, 6.0) for y in (-6.0, 6.0)]
    text = library_input(head, f"./{library_name()}", "./caisson.txt", places)
    rows = text.splitlines()
    first = next(k for k, row in enumerate(rows) if row.endswith('"./caisson.txt"'))
    for k in (first + 1, first + 3):
        rows[k] = rows[k].replace("./caisson.txt", "./other/caisson.txt")
    (soil / "four.dat").write_text("\n".join(rows) + "\n")
    motions = random_motions(50, seed=6)
    done = openfast.drive(soil, motions, "four.dat", matrix=True)
    assert done.code == 0, done.log
    assert done.log.count("Stiffness matrix for point") == 8
    points = [done.channels[:, 12 * k : 12 * k + 6] for k in range(4)]
    np.testing.assert_array_equal(points[0], points[2])
    np.testing.assert_array_equal(points[1], points[3])
    assert np.abs(points[0] - points[1]).max() > 0.05 * np.abs(points[0]).max()
    alone = openfast.drive(soil, motions, "soildyn_nonlinear.dat").channels[:, :6]
    np.testing.assert_allclose(points[0], alone, rtol=1e-12)


@pytest.mark.parametrize("content", ["", "not springs\n", "pysprings_soildyn 1\nlength_m 4\n"])
def test_a_wrong_file_stops_soildyn_with_a_text(soil: Path, content: str) -> None:
    (soil / "caisson.txt").write_text(content)
    done = openfast.drive(soil, random_motions(3, seed=8), "soildyn_nonlinear.dat")
    assert done.code > 0  # no signal
    assert "pysprings SoilDyn library: fatal: " in done.log
    assert "caisson.txt" in done.log
    assert "Unknown error from REDWIN DLL: 102" in done.log


def test_a_missing_file_stops_soildyn_with_a_text(soil: Path) -> None:
    (soil / "caisson.txt").unlink()
    done = openfast.drive(soil, random_motions(3, seed=8), "soildyn_nonlinear.dat")
    assert done.code > 0
    assert "caisson.txt not found" in done.log


def test_a_moment_that_is_rounding_has_no_error_of_the_matrix() -> None:
    tree = vertical_springs()
    for name, path in tree["paths"].children.items():
        data = path.to_dataset(inherit=False)
        tree[f"paths/{name}"].dataset = data.assign(M=1e-9 * data["H"])
    springs = Springs.of(tree)
    rows = [line.split() for line in linear_errors(springs, springs.lateral_stiffness)[3:]]
    assert rows
    assert all(row[-3:] == ["-"] * 3 and "-" not in row[:-3] for row in rows)


def test_errors_of_the_matrix_at_rest_are_those_of_the_symmetric_one_that_is_written() -> None:
    """Friction makes H per rotation another than M per u; the formats take their mean, which has a line."""
    tree = vertical_springs()
    K = tree["stiffness_initial"].values.copy()
    K[0, -1], K[-1, 0] = 1.1 * K[0, -1], 0.9 * K[-1, 0]
    tree["stiffness_initial"].values = K
    springs = Springs.of(tree)
    own = linear(springs, {"at": "", "rate": None, "matrix": "secant"})
    written = own.stiffness[np.ix_([0, 4], [0, 4])]
    assert written[0, 1] == written[1, 0] == pytest.approx(0.5 * (K[0, -1] + K[-1, 0]))
    rows = linear_errors(springs, written)
    assert own.lines[-len(rows) :] == rows != linear_errors(springs, K[np.ix_([0, -1], [0, -1])])
    both = f"H per rotation {1e-6 * K[0, -1]:.4g} and M per u {1e-6 * K[-1, 0]:.4g} MN/rad"
    assert f"the matrix is symmetric: Kxty is the mean of {both} of the full model" in own.lines


def test_soildyn_follows_a_sequence_with_memory(library: Path, tmp_path: Path) -> None:
    """Turning motions in a plane at an angle: SoilDyn keeps the state of the elements from step to step."""
    rows = winkler.mixed()
    springs = winkler.with_invented_memory(rows[~np.isin(rows[:, 0], PLATES)])
    export(springs, "openfast", tmp_path, z=-30.0, springs="memory")
    shutil.copy(library, tmp_path)
    t = np.linspace(0.0, 1.0, 200)[1:]
    states = np.stack([6e-3 * np.sin(14.0 * t) * t, 1.5e-3 * np.sin(9.0 * t)], axis=1)
    c, s = np.cos(0.7), np.sin(0.7)
    motions = np.zeros((len(states), 6))
    motions[:, 0], motions[:, 1] = c * states[:, 0], s * states[:, 0]
    motions[:, 3], motions[:, 4] = -s * states[:, 1], c * states[:, 1]
    done = openfast.drive(tmp_path, motions, "soildyn_nonlinear.dat")
    assert done.code == 0, done.log
    passed = done.channels[:, 6:12] * [1.0, 1.0, 1.0, *np.radians([1.0, 1.0, 1.0])]  # angles in degrees
    loads = trace(MacroModel.from_springs(springs, "memory"), "state", np.stack(
        [passed[:, 0] * c + passed[:, 1] * s, passed[:, 4] * c - passed[:, 3] * s], axis=1))  # fmt: skip
    H, M = loads["H"].values, loads["M"].values
    expected = -np.stack([H * c, H * s, -M * s, M * c], axis=1)
    np.testing.assert_allclose(
        1e3 * done.channels[:, [0, 1, 3, 4]], expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max(axis=0).max()
    )


@pytest.mark.filterwarnings("ignore::pysprings.macro.answer.MacroWarning")
def test_a_matrix_between_two_vertical_loads_is_one_with_z_up(tmp_path: Path) -> None:
    """w, which is coupled there, is down in the springs: its rows and columns change their sign."""
    springs = vertical_springs(heavier=(4e6,))
    done = export(Source(springs), "subdyn", tmp_path, at="H=0.15 MN, arm=2 m, V=3 MN", matrix="tangent")
    K = matrix_of(read_ssi(tmp_path / "subdyn_ssi.dat"), "k")[np.ix_([0, 2, 4], [0, 2, 4])]
    down = stiffness(springs, H=1.5e5, arm=2.0, V=3e6, symmetric=True).values
    assert down[0, 1] and down[1, 2] and any("w is coupled" in text for text in done.remarks)
    np.testing.assert_allclose(K, down * np.outer([1, -1, 1], [1, -1, 1]), rtol=1e-6)


@pytest.mark.parametrize("program", ["openfast", "subdyn"])
def test_the_matrix_at_a_load_times_the_motion_is_that_load(tmp_path: Path, program: str) -> None:
    """The secant of SubDyn's file; `soildyn.dat` has the same, and a share of a path that of its motion."""
    source = Source(fan_with_vertical())
    state = predict(source.springs, H=2e5, arm=5.0)
    done = export(source, program, tmp_path, at="H=0.2 MN, arm=5 m")
    K = matrix_of(read_ssi(tmp_path / "subdyn_ssi.dat"), "k")[np.ix_([0, 4], [0, 4])]
    np.testing.assert_allclose(K @ [state["u"], state["rotation"]], [2e5, 1e6], rtol=1e-3)
    assert "secant stiffness of the springs" in done.remarks[0] and "(H=0.2 MN, arm=5 m)" in done.remarks[0]
    assert "w is not coupled with u" in done.remarks[1]
    if program == "openfast":
        np.testing.assert_allclose(soildyn_matrix(tmp_path / "soildyn.dat")[np.ix_([0, 4], [0, 4])], K, rtol=1e-6)
    export(source, program, tmp_path, at="H=0.2 MN, arm=5 m", matrix="tangent")
    tangent = matrix_of(read_ssi(tmp_path / "subdyn_ssi.dat"), "k")[np.ix_([0, 4], [0, 4])]
    assert tangent[0, 0] < 0.99 * K[0, 0]
    path = Springs.of(source.springs).path()
    export(source, program, tmp_path, at=f"50 % of {path.name}")
    K = matrix_of(read_ssi(tmp_path / "subdyn_ssi.dat"), "k")[np.ix_([0, 4], [0, 4])]
    way = np.hypot(path.u, path.turn)
    step = int(np.argmin(np.abs(way - 0.5 * way.max())))
    loads = np.array([path["H"][step], path["M"][step]])
    np.testing.assert_allclose(
        K @ [path.u[step], path.rotation[step]], loads, rtol=2e-2, atol=2e-2 * max(map(abs, loads))
    )


@pytest.mark.filterwarnings("ignore::pysprings.macro.answer.MacroWarning")
@pytest.mark.parametrize("at", ["H=0.1 MN, arm=2 m", "50 % of slide0"])
def test_a_matrix_at_a_load_has_the_springs_of_its_rate(tmp_path: Path, at: str) -> None:
    """Without a rate, springs at several are refused, and nothing is written."""
    springs = rates.with_vertical(1e-5)
    for asked in ({"at": at}, {}):
        with pytest.raises(UserInputError, match="several rates"):
            export(springs, "openfast", tmp_path / "none", **asked)
    assert not (tmp_path / "none").exists()
    own = Springs.of(springs).at_rate(1e-3)
    state, found = predict(own, H=1e5, arm=2.0), []
    if "%" in at:
        path = Springs.of(springs).paths["slide0"]
        step = int(np.argmin(np.abs(path.u - 0.5 * path.u.max())))
        state = impose(own, u=float(path.u[step]), rotation=float(path.rotation[step]))
    for program in ("openfast", "subdyn"):
        done = export(springs, program, tmp_path / program, at=at, rate=1e-3)
        assert "of the springs at 1 mm/s (of rho)" in done.remarks
        found.append(matrix_of(read_ssi(tmp_path / program / "subdyn_ssi.dat"), "k")[np.ix_([0, 4], [0, 4])])
    np.testing.assert_allclose(found[0], found[1])
    np.testing.assert_allclose(found[0] @ [state["u"], state["rotation"]], [state["H"], state["M"]], rtol=1e-3)


@pytest.mark.filterwarnings("ignore::pysprings.macro.answer.MacroWarning")
def test_the_tangent_at_a_share_of_a_path_between_two_vertical_loads_is_that_of_both(tmp_path: Path) -> None:
    tree = vertical_springs(heavier=(3e6, 4e6))
    between = tree["paths/slide_3"].to_dataset(inherit=False)
    tree["paths/between"] = xr.DataTree(between.assign_attrs(role="held-back"))
    springs = tree.filter(lambda node: not node.name or not node.name.endswith("_3"))
    path = Springs.of(springs).paths["between"]
    export(Source(springs), "subdyn", tmp_path, at="50 % of between", matrix="tangent")
    step = int(np.argmin(np.abs(path.u - 0.5 * path.u.max())))
    state = {"u": float(path.u[step]), "rotation": float(path.rotation[step]), "V": 3e6}
    K = stiffness_six(springs, symmetric=True, **state).values
    assert K[0, 2]
    up = np.array([1, 1, -1, 1, 1, 1])  # w is down
    found = matrix_of(read_ssi(tmp_path / "subdyn_ssi.dat"), "k")
    np.testing.assert_allclose(found, K * np.outer(up, up), rtol=1e-6, atol=1.0)


def test_the_vertical_tangent_at_a_share_of_a_path_is_that_under_its_load(tmp_path: Path) -> None:
    source, found = Source(vertical_springs(heavier=(3e6,))), list[float]()
    for at in ("50 % of slide_3", "H=0.1 MN, V=3 MN"):
        export(source, "subdyn", tmp_path, at=at, matrix="tangent")
        found.append(matrix_of(read_ssi(tmp_path / "subdyn_ssi.dat"), "k")[2, 2])
    assert found[0] == pytest.approx(found[1], rel=1e-2) and found[0] < 0.99 * K_REST  # lateral loads differ


def test_marks_of_the_state_of_a_matrix_stand_beside_it(source: Source, tmp_path: Path) -> None:
    lines = export(source, "subdyn", tmp_path, at="H=0.1 MN, arm=5 m").remarks
    assert [line for line in lines if line.startswith("supported in part: ") and "calibration paths" in line]


def test_places_of_a_matrix_that_are_refused(source: Source, tmp_path: Path) -> None:
    for text, words in (
        ("H=0.2, arms=3 m, V=x", "expected a quantity with unit.*'arms=3 m' is not one of H=VALUE.*V: expected"),
        ("120 % of {}", "not above 0 and up to 100 %"), ("50 % of nowhere", "nowhere"),
    ):  # fmt: skip
        at = text.format(Springs.of(source.springs).path().name)
        with pytest.raises(UserInputError, match=f"(?s){words}"):
            export(source, "subdyn", tmp_path, at=at)


def test_a_share_of_a_path_at_another_vertical_load_has_the_springs_of_that_load(tmp_path: Path) -> None:
    springs = vertical_springs(heavier=(6e6,))
    path = Springs.of(springs).paths["slide_6"]
    export(springs, "subdyn", tmp_path, at="100 % of slide_6")
    K = matrix_of(read_ssi(tmp_path / "subdyn_ssi.dat"), "k")[np.ix_([0, 4], [0, 4])]
    loads = np.array([path["H"][-1], path["M"][-1]])
    np.testing.assert_allclose(K @ [path.u[-1], path.rotation[-1]], loads, atol=2e-2 * np.abs(loads).max())
