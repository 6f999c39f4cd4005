# SPDX-License-Identifier: MIT
"""One initial stiffness: every place where a run prints or stores one holds the full model's, to 1e-12."""

import html
import json
import re
import shutil
from pathlib import Path

import numpy as np
import openpyxl
import pytest
import xarray as xr

import pysprings
from pysprings.core.text import number
from pysprings.results.folder import run_to_folder
from pysprings.results.tables import open_table
from pysprings.studies.sweep.dataset import measure
from tests.support import tiny
from tests.support.commands import command
from tests.support.files import read_record


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run of one path, with the files of every exporter that writes a stiffness."""
    out = run_to_folder(tiny.scene(), tmp_path_factory.mktemp("stiffness") / "out")
    for program in ("openfast", "subdyn", "json", "opensees", "calculix", "sacs"):
        done = command("export", out, "--to", program)
        assert done.code == 0, done.err
    return out


@pytest.fixture(scope="module")
def full(folder: Path) -> np.ndarray:
    """The (3, 3) matrix of full_model.nc."""
    with xr.open_dataset(folder / "full_model.nc") as data:
        return data["stiffness_initial"].values


@pytest.fixture(scope="module")
def torsion(folder: Path) -> float:
    """The torsional stiffness of full_model.nc."""
    with xr.open_dataset(folder / "full_model.nc") as data:
        return float(data.attrs["torsional_stiffness_Nm_per_rad"])


def six(plane: np.ndarray, torsion: float) -> np.ndarray:
    """Return the axisymmetric (6, 6) matrix in axes with z up, entry by entry."""
    matrix = np.zeros((6, 6))
    for i, a in ((0, 0), (4, 2)):
        for j, b in ((0, 0), (4, 2)):
            matrix[i, j] = plane[a, b]
    for i, a, s in ((1, 0, 1.0), (3, 2, -1.0)):
        for j, b, t in ((1, 0, 1.0), (3, 2, -1.0)):
            matrix[i, j] = s * t * plane[a, b]
    matrix[2, 2], matrix[5, 5] = plane[1, 1], torsion
    return matrix


def write_scene(folder: Path) -> Path:
    """Return the file of the scene that ran into the folder."""
    return tiny.write(tiny.scene(), folder.parent / "scene.toml")


def same(made: object, expected: np.ndarray) -> None:
    np.testing.assert_allclose(np.array(made, dtype=float), expected, rtol=1e-12, atol=1e-15 * np.abs(expected).max())


def test_it_is_symmetric_and_no_spring_set_changes_it(folder: Path, full: np.ndarray, torsion: float) -> None:
    """The springs of one path are softer at rest: a stiffness that came from them would be another number."""
    np.testing.assert_array_equal(full, full.T)
    springs = pysprings.open_springs(folder / "springs.nc")
    own = pysprings.model_of(springs).tangent_stiffness().values
    assert abs(own[0, 0] / full[0, 0] - 1.0) > 0.01
    for kind in ("full", "py"):
        model = pysprings.model_of(springs, kind)
        same(pysprings.stiffness(model), full)
        same(pysprings.stiffness_six(model), six(full, torsion))
    same(pysprings.stiffness(springs), full)
    same(pysprings.stiffness_six(springs), six(full, torsion))
    same(pysprings.extract_springs(tiny.result())["stiffness_initial"], tiny.result()["stiffness_initial"].values)


def test_the_files_of_a_run(folder: Path, full: np.ndarray, torsion: float) -> None:
    with xr.open_dataset(folder / "springs.nc") as data:
        same(data["stiffness_initial"], full)
    same(read_record(folder)["stiffness_initial"]["matrix"], full)
    assert read_record(folder)["stiffness_initial"]["torsional_stiffness_Nm_per_rad"] == torsion
    page = (folder / "report.html").read_text(encoding="utf-8").split("Initial stiffness of the full model")[1]
    cells = re.findall(r"<td[^>]*>([^<]*)</td>", page.split("</table>")[0])
    numbers = [float(cell.replace(",", "")) for cell in cells if "[" not in cell]
    matrix = 1e6 * np.array(numbers).reshape(3, 3)  # no decimals from 10,000 on, else six digits
    np.testing.assert_allclose(matrix, full, rtol=5e-5, atol=1e-9 * np.abs(full).max())
    sheet = openpyxl.load_workbook(folder / "springs.xlsx")["stiffness 6x6"]
    same([[1e3 * cell.value for cell in row] for row in sheet["B3:G8"]], six(full, torsion))
    book = openpyxl.load_workbook(folder / "springs.xlsx")
    place = book.defined_names["K_3x3"].attr_text.split("!")[1].replace("$", "")
    same([[1e3 * cell.value for cell in row] for row in sheet[place]], full)


def test_the_files_for_other_programs(folder: Path, full: np.ndarray, torsion: float) -> None:
    up = six(full, torsion)
    made = json.loads((folder / "json" / "springs.json").read_text(encoding="utf-8"))
    same(made["stiffness_initial"]["values"], full)
    names = ["x", "y", "z", "tx", "ty", "tz"]
    for program in ("openfast", "subdyn"):
        text = (folder / program / "subdyn_ssi.dat").read_text(encoding="utf-8")
        entries = re.findall(r"^\s*(\S+)\s+K(t?[xyz])(t?[xyz])\s*$", text, re.M)
        assert len(entries) == 21
        for value, row, column in entries:
            assert float(value) == pytest.approx(up[names.index(row), names.index(column)], rel=1e-12, abs=1e-3)
    rows = re.findall(r"^(?:\s*-?[\d.]+E[+-]\d+){6}\s*$", (folder / "openfast" / "soildyn.dat").read_text(), re.M)
    same([[float(x) for x in row.split()] for row in rows], up)


def test_the_head_of_an_export_has_the_mesh_error_of_its_run(folder: Path) -> None:
    for file in ("subdyn/subdyn_ssi.dat", "opensees/caisson_opensees.py", "sacs/caisson_sacs.inp"):
        head = " ".join((folder / file).read_text(encoding="utf-8").replace("*", " ").split())
        assert "no estimate of the discretisation error: the run made none" in head
    lines = (folder / "opensees" / "caisson_opensees.py").read_text(encoding="utf-8").splitlines()
    assert sum(line.startswith("#") for line in lines) <= 26
    record = json.loads((folder / "run.json").read_text(encoding="utf-8"))
    estimate = {"estimate_pct": {"load_max": 7.5}, "unknowns": [200, 100], "safety": 2.0, "companion_paths": 3}
    estimate["companion_stopped"] = {"pull": "contact lost"}
    (folder / "other").mkdir()
    (folder / "other" / "run.json").write_text(json.dumps(record | {"error_estimate": estimate}), encoding="utf-8")
    shutil.copy(folder / "springs.nc", folder / "other")
    assert command("export", folder / "other", "--to", "subdyn").code == 0
    head = (folder / "other" / "subdyn" / "subdyn_ssi.dat").read_text(encoding="utf-8")
    assert "load max 7.5 %; companion stopped on 1 of 3 paths: pull (contact lost)" in head


def test_the_command(folder: Path, full: np.ndarray, torsion: float) -> None:
    asked = ("predict", folder, "--H", "100 kN", "--stiffness")
    document = json.loads(command(*asked, "--json").out)
    same(document["stiffness_6x6"]["matrix"], six(full, torsion))
    assert document["stiffness_6x6"]["long_name"].startswith("initial stiffness of the full model")
    printed = command(*asked).out.split("initial stiffness of the full model")[1].splitlines()[3:9]
    for line, row in zip(printed, six(full, torsion), strict=True):
        assert line.split()[1:] == [number(1e-6 * float(value), 5) for value in row]


def test_another_point_and_the_symmetric_part(folder: Path, full: np.ndarray, torsion: float) -> None:
    """About a point of depth d: M is more by H d, and u of the lid is that of the point and rotation d."""
    d, moved = 2.5, full.copy()
    moved[0, 2] = moved[2, 0] = full[0, 2] + d * full[0, 0]
    moved[2, 2] = full[2, 2] + 2.0 * d * full[0, 2] + d**2 * full[0, 0]
    asked = ("predict", folder, "--H", "100 kN", "--stiffness", "--json", "--reference-depth", f"{d} m")
    made = [json.loads(command(*asked, *more).out) for more in ((), ("--symmetric",), ("--secant",))]
    for document, expected in zip(made, (six(moved, torsion),) * 3, strict=True):
        same(document["stiffness_6x6"]["matrix"], expected)
        assert f"{d:g} m below mudline" in document["stiffness_6x6"]["long_name"]
    springs = pysprings.open_springs(folder / "springs.nc")
    same(pysprings.stiffness(springs, reference_depth=d), moved)
    same(pysprings.stiffness(springs, reference_depth=d, symmetric=True), moved)


def test_the_summary_wherever_it_stands(folder: Path, full: np.ndarray) -> None:
    """The end of `run`, page one of the report and sheet one of the workbook print the same four digits."""
    sizes = {"K_H": full[0, 0], "K_V": full[1, 1], "K_M": full[2, 2], "K_HM": full[0, 2]}
    printed = command("run", write_scene(folder), "--out", folder, "--resume")
    assert printed.code == 0, printed.err
    sheet = openpyxl.load_workbook(folder / "springs.xlsx").worksheets[0]
    book = "\n".join(str(cell.value) for row in sheet.iter_rows() for cell in row if cell.value is not None)
    page = html.unescape((folder / "report.html").read_text(encoding="utf-8"))
    for text in (printed.out, book, page, read_record(folder)["summary"]["initial stiffness"]):
        found = re.findall(r"(K_HM|K_H|K_V|K_M) (-?[\d.]+ [MG]?N)[ /]", text)
        assert {name for name, _ in found} == set(sizes)
        for name, value in found:
            number_, prefix = value.removesuffix("N").split(" ")
            assert number_ == f"{sizes[name] / {'M': 1e6, 'G': 1e9}[prefix]:.4g}"


def test_two_runs_beside_each_other(folder: Path, full: np.ndarray) -> None:
    rows = json.loads(command("diff", folder, folder, "--json").out)["rows"]
    made = [[row["first"], row["second"]] for row in rows if row["part"] == "initial stiffness"]
    assert rows[[row["quantity"] for row in rows].index("T per rotation")]["change"] == 0.0
    sizes = (full[0, 0], full[0, 2], full[2, 2], full[1, 1])
    assert made[:4] == [[1e-6 * size] * 2 for size in sizes]
    text = command("diff", folder, folder).out
    assert all(text.count(number(1e-6 * size, 5)) >= 2 for size in sizes) and "H per u [MN/m]" in text


def test_load_cases_have_the_stiffness_of_the_state_alone(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "cases.csv").write_text("case,H [kN],arm [m]\none,100,0\n", encoding="utf-8")
    assert command("design", folder, tmp_path / "cases.csv", "--out", tmp_path / "answers.csv").code == 0
    heads = (tmp_path / "answers.csv").read_text(encoding="utf-8").splitlines()[0].split(",")
    stiff = [head for head in heads if head.endswith("_N_per_m") or re.match(r"\w+_(u_rotation|rotation)_", head)]
    assert len(stiff) == 7
    assert all(head.startswith(("secant_", "tangent_")) for head in stiff)


def test_no_other_file_states_a_stiffness(folder: Path) -> None:
    """Files of nonlinear springs have curves; a line on stiffness with a number in it would be one to compare."""
    programs = ("opensees", "calculix", "sacs")
    files = [file for name in programs for file in sorted((folder / name).iterdir()) if file.is_file()]
    assert {file.parent.name for file in files} == set(programs)
    lines = [line for file in files for line in file.read_text(encoding="utf-8").splitlines()]
    assert [line for line in lines if re.search(r"stiffness.*\d{4}|\d{4}.*stiffness", line, re.I)] == []


def test_a_study_of_many_scenes(folder: Path, full: np.ndarray) -> None:
    same(measure(folder, tiny.scene(), ("pull",)).stiffness, full)


def test_a_stiffness_at_a_state_has_another_name(folder: Path) -> None:
    document = json.loads(command("predict", folder, "--H", "100 kN", "--stiffness", "--json").out)
    for key in ("stiffness", "stiffness_6x6_at_state"):
        assert document[key]["long_name"].startswith("tangent stiffness of the springs at the state")
    at_state, at_rest = document["stiffness_6x6_at_state"], document["stiffness_6x6"]  # symmetry: at rest w is apart
    assert "a lateral load softens it" in at_state["vertical"] and "vertical" not in at_rest
    assert at_state["vertical"] in command("predict", folder, "--H", "100 kN", "--stiffness").err
    springs = pysprings.open_springs(folder / "springs.nc")
    assert pysprings.stiffness(springs, H=1e5, secant=True).attrs["long_name"].startswith("secant stiffness of the spr")
    table = open_table(folder / "py.csv")
    assert "full model" not in pysprings.stiffness(table).attrs["long_name"]
