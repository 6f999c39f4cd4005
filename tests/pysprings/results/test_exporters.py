# SPDX-License-Identifier: MIT
"""Files for people and programs, read back with the readers those use: pandas, openpyxl, json."""

import json
import re

import numpy as np
import openpyxl
import pandas as pd
import pytest

from pysprings.core.errors import UserInputError
from pysprings.macro.comparison import compare
from pysprings.results import exporters
from pysprings.results.exporters.base import Source
from pysprings.results.exporters.header import header, range_of_path
from pysprings.results.exporters.xlsx import plain_names
from pysprings.results.report.load_cases import spring_tables
from pysprings.springs.checks import save_springs
from pysprings.springs.springs import Springs
from pysprings.springs.tip_zone import reslice
from tests.support import space_springs, written
from tests.support.commands import command
from tests.support.fans import fan_springs, potential
from tests.support.synthetic import Path, make_result, make_springs

PATHS = (Path("pull"), Path("high", arm=8.0, role="held-back"))
STEPS, RINGS, SLICES = 21, 13, 11
LOAD_COLUMNS = (
    "path,step,time_s,u_m,w_m,rotation_rad,H_N,V_N,M_Nm,"
    "H_outer_N,H_inner_N,H_lid_N,H_tip_N,F_pw_N,F_in_N,F_out_N,converged"
)
PY_COLUMNS = (
    "path,family,depth_m,depth_top_m,depth_bottom_m,side,component,step,y_m,p_N_per_m,"
    "rotation_rad,w_m,m_Nm_per_m,t_N_per_m,H_N,V_N,M_Nm,converged"
)


@pytest.fixture(scope="module")
def springs():
    return make_springs(PATHS)


@pytest.fixture(scope="module")
def folder(springs, tmp_path_factory):
    folder = tmp_path_factory.mktemp("tables")
    result = make_result(PATHS)
    result["paths/pull/converged"][-1:] = 0
    written.all_tables(folder, springs, result, compare(springs))
    written.workbook(folder / "springs.xlsx", springs)
    return folder


def test_load_displacement_has_the_contracts_columns(folder):
    file = folder / "load_displacement.csv"
    assert file.read_text().splitlines()[0] == LOAD_COLUMNS
    table = pd.read_csv(file)
    assert len(table) == 2 * STEPS
    pull = table[table["path"] == "pull"]
    assert pull["converged"].tolist() == [1] * (STEPS - 1) + [0]
    parts = pull[["H_outer_N", "H_inner_N", "H_lid_N", "H_tip_N"]].sum(axis=1)
    np.testing.assert_allclose(parts, pull["H_N"], rtol=1e-8, atol=1e-3)


def test_wide_table_has_pairs_of_columns_by_depth(folder, springs):
    """Rows are steps; each depth has its pair y, p beside each other; values: `test_user_numbers.py`."""
    wide, slices = pd.read_csv(folder / "py_wide.csv"), reslice(springs)["paths/pull"].sizes["depth"]
    assert len(wide) == 2 * STEPS and 5 < slices < RINGS
    assert wide.columns[5] == "y_m z=0 [0..0.204863853]"
    pairs = [name.split(" z=")[0] for name in wide.columns[5 : 5 + 4 * slices]]
    assert pairs == ["y_m", "p_N_per_m"] * slices + ["m_Nm_per_m", "t_N_per_m"] * slices
    assert exporters.text(springs, "wide") == (folder / "py_wide.csv").read_text()


def test_tables_of_springs_end_where_the_water_would_cavitate(springs, tmp_path):
    """A table answers no more than its springs: `predict` on it is extrapolated where that on the springs is."""
    tree, k = springs.copy(deep=True), 7
    for name in ("pull", "high"):
        path = tree[f"paths/{name}"].to_dataset(inherit=False)
        margin = np.where(np.arange(path.sizes["step"]) < k, 1e5, -1e3)
        tree[f"paths/{name}"] = path.assign(cavitation_margin=("step", margin, {"units": "Pa"}))
    given = Springs.of(tree)
    assert given.paths["pull"].n == k < STEPS
    names = {"csv": "py.csv", "wide": "py_wide.csv", "xlsx": "springs.xlsx"}
    for each, name in names.items():
        exporters.export(tree, each, tmp_path / name)
    for name in ("py.csv", "py_wide.csv"):
        ends = pd.read_csv(tmp_path / name).groupby("path")["step"].max()
        assert ends.to_dict() == {"pull": k - 1, "high": k - 1}
    assert set(compare(tree)["states"]) == {k - 1}  # a path held back measures no springs on suction that is not there
    book = openpyxl.load_workbook(tmp_path / "springs.xlsx")
    for sheet in ("p-y", "base", "load-displacement"):
        assert [row[0] for row in book[sheet].values].count("pull") == k
    (line,) = (each for each in header(Source(tree), "", "", "") if each.startswith("range of the springs"))
    assert f"1 lateral paths: |u| to {1e3 * np.abs(given.paths['pull'].u).max():.4g} mm" in line


def test_the_tip_of_a_bent_skirt_is_where_its_sections_lead(springs, tmp_path):
    """y with a parabola by depth: that of the last two slices goes on; of the lid it is u."""
    tree = springs.copy(deep=True)
    tree.attrs["caisson_behaviour"] = "elastic"
    for name in ("pull", "high"):
        path = tree[f"paths/{name}"].to_dataset(inherit=False)
        tree[f"paths/{name}"] = path.assign(y=path["y"] + 0.1 * path["rotation"] * path["depth"] ** 2)
    exporters.export(tree, "csv", tmp_path / "py.csv")
    exporters.export(tree, "xlsx", tmp_path / "springs.xlsx")
    table = pd.read_csv(tmp_path / "py.csv").query("path == 'pull'")
    net = table.query("family == 'py' and side == 'net' and component == 'total'").pivot(
        index="step", columns="depth_m", values="y_m"
    )
    (z0, z1), y = net.columns[-2:], net.to_numpy()[:, -2:]
    tip, lid = (table[table["family"] == family] for family in ("base", "lid"))
    expected = y[:, 1] + (y[:, 1] - y[:, 0]) / (z1 - z0) * (tip["depth_m"] - z1)
    np.testing.assert_allclose(tip["y_m"], expected, rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(lid["y_m"], tree["paths/pull"]["u"], rtol=1e-9)
    sheet = [row for row in openpyxl.load_workbook(tmp_path / "springs.xlsx")["base"].values if row[0] == "pull"]
    np.testing.assert_allclose([row[2] for row in sheet], 1e3 * expected, rtol=1e-6, atol=1e-9)
    assert any(line.startswith("elastic caisson") for line in header(Source(tree), "", "", ""))
    assert not any(line.startswith("elastic caisson") for line in header(Source(springs), "", "", ""))


def test_py_has_the_contracts_columns_and_no_comment(folder):
    file = folder / "py.csv"
    assert file.read_text().splitlines()[0] == PY_COLUMNS
    assert "#" not in file.read_text()
    table = pd.read_csv(file)
    assert table.groupby("family").size().to_dict() == {
        "base": 2 * STEPS,
        "lid": 2 * STEPS,
        "mtheta": 2 * SLICES * 3 * STEPS,
        "py": 2 * SLICES * 3 * 4 * STEPS,
    }


def test_the_table_alone_balances_the_load(folder):
    """Someone with py.csv and nothing else finds the applied load and moment again."""
    table = pd.read_csv(folder / "py.csv")
    load = pd.read_csv(folder / "load_displacement.csv")
    last = table[(table["path"] == "high") & (table["step"] == STEPS - 1)]
    dz = last["depth_bottom_m"] - last["depth_top_m"]
    net = (last["family"] == "py") & (last["side"] == "net") & (last["component"] == "total")
    shear = (last["family"] == "mtheta") & (last["side"] == "net")
    ends = last["family"].isin(["base", "lid"])
    lateral = (last["p_N_per_m"] * dz)[net].sum() + last["H_N"][ends].sum()
    moment = -(last["p_N_per_m"] * dz * last["depth_m"])[net].sum() + (last["m_Nm_per_m"] * dz)[shear].sum()
    moment += (last["M_Nm"] - last["H_N"] * last["depth_m"])[ends].sum()
    vertical = (last["t_N_per_m"] * dz)[shear].sum() + last["V_N"][ends].sum()
    applied = load[(load["path"] == "high") & (load["step"] == STEPS - 1)].iloc[0]
    np.testing.assert_allclose([lateral, moment, vertical], applied[["H_N", "M_Nm", "V_N"]].astype(float), rtol=1e-7)


@pytest.fixture(scope="module")
def book(folder):
    return openpyxl.load_workbook(folder / "springs.xlsx")


def test_workbook_sheets_frozen_and_charted(book):
    names = ["About", "charts", "p-y", "m-theta", "base", "lid", "load-displacement", "stiffness 6x6", "tidy"]
    assert book.sheetnames == names
    assert len(book["charts"]._charts) == 10
    assert {book[name].freeze_panes for name in names[2:7]} == {"C4"}


def test_workbook_says_what_it_is(book):
    words = "\n".join(str(cell.value) for row in book["About"].iter_rows() for cell in row if cell.value)
    expected = ["pysprings 0.0.0", "0" * 64, "kN, m, mm, mrad", "monotonic backbone, not cyclic", "M = H*arm"]
    expected += ["drained", "|u| to 5 mm", "Beyond this range every use is an extrapolation", "load -67"]
    assert [text for text in expected if text not in words] == []


def test_sheets_print_one_page_wide_and_can_be_filtered(book):
    for sheet in book:
        high = 0 if sheet.title in ("About", "charts", "stiffness 6x6") else None  # as many as needed; one
        assert (sheet.page_setup.orientation, sheet.page_setup.fitToHeight) == ("landscape", high)
        assert sheet.sheet_properties.pageSetUpPr.fitToPage
    for name in ("p-y", "m-theta", "base", "lid", "load-displacement"):
        assert book[name].auto_filter.ref.startswith("A3:") and book[name].print_title_rows == "$1:$3"


def test_tidy_sheet_has_a_row_for_each_path_step_and_depth(book, springs):
    springs = reslice(springs)
    rows = list(book["tidy"].iter_rows(values_only=True))
    heads, rows = rows[0], [row for row in rows[1:] if row[0] is not None]
    sizes = [path["y"].size for path in springs["paths"].children.values()]
    assert len(rows) == sum(sizes)
    name, path = next(iter(springs["paths"].children.items()))
    last = dict(zip(heads, rows[sizes[0] - 1], strict=True))
    assert last["path"] == name and last["slice top [m]"] == pytest.approx(0.8 * last["slice bottom [m]"])
    assert last["y [mm]"] == pytest.approx(1e3 * float(path["y"].transpose("step", "depth")[-1, -1]))
    assert last["p net [kN/m]"] == pytest.approx(1e-3 * float(path["p"].transpose("step", "depth")[-1, -1]))
    small = [cell for row in book["tidy"].iter_rows(min_row=2) for cell in row[4:] if 1e-9 < abs(cell.value or 0) < 0.1]
    assert {cell.number_format for cell in small} == {"General"}  # 0.000 hides digits


def test_all_tables_of_a_run_have_the_same_depths(book, folder, springs):
    """The long and the wide file, the workbook, the report, and the cards for SACS."""
    slices = [tuple(row) for row in reslice(springs)["paths/pull/depth_bounds"].values]
    long = pd.read_csv(folder / "py.csv").query("family == 'py'")[["depth_top_m", "depth_bottom_m"]].drop_duplicates()
    wide = re.findall(r"p_N_per_m z=\S+ \[(\S+)\.\.(\S+)\]", (folder / "py_wide.csv").read_text().splitlines()[0])
    sheet = [cells[1].value.split(" - ") for cells in book["p-y"].iter_cols(min_col=3) if "p net" in cells[2].value]
    page = [row[1].split(" to ") for row in spring_tables(springs)[0].rows[:-2]]
    exporters.export(springs, "sacs", folder / "sacs", springs="full")
    cards = re.findall(r"^SOIL P-Y.{16}(.{6})(.{6})", (folder / "sacs" / "caisson_sacs.inp").read_text(), re.M)
    for found, digits in ((long.values, 1e-9), (wide, 1e-8), (sheet, 6e-4), (page, 6e-3), (cards, 6e-4)):
        np.testing.assert_allclose(np.array(found, dtype=float), slices, atol=digits)


def test_stiffness_sheet_says_what_it_is(book):
    words = [book["stiffness 6x6"].cell(row, 1).value for row in range(9, 20)]
    assert any("Torsion (rz) is that of the full model at rest" in str(text) for text in words)
    assert "initial stiffness of the full model at the lid centre, 3 x 3" in words


def test_names_are_unique_and_legal():
    assert list(plain_names(["a-b", "a b", "A_B"]).values()) == ["a_b", "a_b_", "A_B__"]


@pytest.mark.slow
def test_workbook_of_a_fan(tmp_path):
    """Rays, their range and the fan's columns; one name a path and curve."""
    springs = fan_springs(potential, angles=(0.0, -40.0, 90.0), held_back=(8.0,))
    book = openpyxl.load_workbook(written.workbook(tmp_path / "fan.xlsx", springs))
    words = "\n".join(str(cell.value) for row in book["About"].iter_rows() for cell in row if cell.value)
    assert "ray_1 (-40.0 deg, to 8 mm)" in words
    assert "a curve in these sheets holds on its own ray only" in words
    headings = [cell.value for cell in book["load-displacement"][3]]
    assert "macro-model, fan springs: H [kN]" in headings
    assert {f"p_5.{name}" for name in ("ray_0", "ray_1", "ray_2", "pull_8")} <= set(book.defined_names)
    assert any("rotation at equal displacement" in str(row[1]) for row in book["About"].values)
    charts = {chart.title.tx.rich.p[0].r[0].t: chart.series[-1].xVal.numRef.f for chart in book["charts"]._charts}
    assert len(charts) == 4 * 5 - 1 and "ray_0: distributed moment by depth" not in charts  # it does not turn
    assert "!$E$" in charts["ray_2: load at the lid"]  # over its rotation: u is held


@pytest.mark.usefixtures("few_offered")  # its paths are not those of its elements
def test_paths_out_of_one_plane_are_in_the_workbook_and_named_beside_tables(tmp_path):
    """Motions and loads in six degrees of freedom; what has them by depth is named. A table of p-y has none of them."""
    tree = space_springs.calibrated().copy(deep=True)
    tree["paths/ray_0"].attrs["direction_rad"] = np.radians(30.0)
    book = openpyxl.load_workbook(written.workbook(tmp_path / "space.xlsx", tree))
    head, *rows = book["six degrees"].values
    found, own = pd.DataFrame(rows, columns=head).set_index("path"), tree["space/circle"]
    for column, name, factor in (("u_y [mm]", "u_y", 1e3), ("rot_x [mrad]", "rot_x", 1e3), ("M_x [kN m]", "M_x", 1e-3)):
        np.testing.assert_allclose(found.loc["circle", column].astype(float), factor * own[name].values, rtol=1e-9)
    ray = tree["paths/ray_0"]
    np.testing.assert_allclose(found.loc["ray_0", "H_y [kN]"].astype(float), 0.5e-3 * ray["H"].values, rtol=1e-9)
    about = {row[0]: str(row[1]) for row in book["About"].values if row and row[0]}
    assert about["path circle"].startswith("circle, memory") and "in springs.nc and its JSON" in about["path circle"]
    assert "which load_displacement.csv has, times what the extrapolation" in about["path circle"]
    assert "rotation +" in about["elbow, memory"] and "equal displacement" not in about["elbow, memory"]
    assert "in its own plane, 30 deg from x towards y" in about["path ray_0"]
    save_springs(tree, tmp_path / "springs.nc")
    for options in ((), ("--wide",)):
        done = command("springs", tmp_path / "springs.nc", *options)
        assert "note: circle, twist, elbow leave the plane" in done.err and "circle" not in done.out
    assert command("springs", tmp_path / "springs.nc", "--json").err == ""


def test_charts_point_at_the_data(folder):
    book = openpyxl.load_workbook(folder / "springs.xlsx")
    first = book["charts"]._charts[0]
    references = [(series.xVal.numRef.f, series.yVal.numRef.f) for series in first.series]
    assert references[0] == ("'load-displacement'!$C$4:$C$24", "'load-displacement'!$F$4:$F$24")
    headings = [book["load-displacement"][f"{column}3"].value for column in "CF"]
    assert headings == ["full model u [mm]", "full model H [kN]"]
    py = book["charts"]._charts[1].series[2]
    place = py.yVal.numRef.f.split("$")[1]
    assert book["p-y"][f"{place}3"].value == "p net [kN/m]"
    assert f"{book['p-y'][f'{place}1'].value:.2f} m" == py.tx.v


def test_only_a_path_with_a_free_head_has_a_height_of_the_load():
    """The file has `arm_m` 0 where u and rotation are imposed: no table calls that a load at mudline."""
    tree = make_springs((Path(arm=2.0), Path("slide", "translation")))
    words = {name: range_of_path("drained", path) for name, path in Springs.of(tree).paths.items()}
    assert "pull, load 2 m above mudline, " in words["pull"] and "mudline" not in words["slide"]
    height = compare(tree, "py").set_index("path")["arm_m"]
    assert height["pull"] == 2.0 and np.isnan(height["slide"])


def test_json(springs):
    document = json.loads(exporters.text(springs, "json"))
    assert document["attributes"]["schema"] == "pysprings-springs-4"
    p = document["paths"]["high"]["variables"]["p_component"]
    assert (p["units"], p["dims"]) == ("N m-1", ["depth", "side", "component", "step"])
    assert document["stiffness_initial"]["dofs"] == ["u", "w", "rotation"]
    np.testing.assert_array_equal(p["values"], springs["paths/high/p_component"].values)


def test_json_has_the_paths_out_of_one_plane_and_the_elements():
    """All that the NetCDF file has: a group of it that is not there is lost."""
    tree = space_springs.calibrated()
    document = json.loads(exporters.text(tree, "json"))
    (path, *_) = document["space"]
    found = document["space"][path]["variables"]["u_y"]
    assert found["units"] == "m"
    np.testing.assert_array_equal(found["values"], tree[f"space/{path}/u_y"].values)
    np.testing.assert_array_equal(document["memory"]["variables"]["rows"]["values"], tree["memory/rows"].values)
    assert set(tree.children) <= set(document)


def test_export_by_form(springs, tmp_path):
    forms = [each.name for each in exporters.EXPORTERS if each.is_spring_file]
    assert forms == ["csv", "wide", "xlsx", "nc", "json"]
    for form in forms:
        (file,) = exporters.export(springs, form, tmp_path / f"springs.{form}").files
        assert file.stat().st_size > 1000
    assert (tmp_path / "springs.csv").read_text() == exporters.text(springs, "csv")
    with pytest.raises(UserInputError, match="'ods' is not one of csv, wide, xlsx, nc, json, beam, paraview, openfast"):
        exporters.export(springs, "ods", tmp_path / "x")
    assert not (tmp_path / "x").exists()
