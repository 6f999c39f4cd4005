# SPDX-License-Identifier: MIT
"""Files of tests, points and layers: the same numbers from every format, or one clear line."""

from pathlib import Path

import numpy as np
import openpyxl
import pytest

from pysprings.core.errors import UserInputError
from pysprings.site.files import read_site
from pysprings.site.proposal import Options, propose

DEPTH = [0.5, 1.0, 1.5, 2.0]
CONE = [1.2, 4.2, 9.5, 16.0]  # MPa
SLEEVE = [0.004, 0.02, 0.06, 0.11]
PRESSURE = [0.005, 0.01, 0.015, 0.02]

GEF = """\
#GEFID= 1, 1, 0
#PROCEDURECODE= GEF-CPT-Report, 1, 1, 2
#TESTID= A-1
#COLUMN= 4
#COLUMNINFO= 1, m (meter), penetration length, 1
#COLUMNINFO= 2, MPa, cone resistance, 2
#COLUMNINFO= 3, Mpa, sleeve friction, 3
#COLUMNINFO= 4, kPa, pore pressure, 6
#COLUMNVOID= 2, -9999
#COLUMNSEPARATOR= ;
#RECORDSEPARATOR= !
#MEASUREMENTVAR= 3, 0.75, -, net area ratio
#EOH=
0.50;1.2;0.004;5;!
1.00;4.2;0.020;10;!
1.20;-9999;0.020;10;!
1.50;9.5;0.060;15;!
2.00;16.0;0.110;20;!
"""
OLD_GEF = """\
#GEFID = 1,0,0
#COLUMNINFO = 1, m, depth, 1
#COLUMNINFO = 2, MPa, cone, 2
#COLUMNINFO = 3, MPa, friction, 3
#EOH =
 -5.0E-01  1.2E+00 4.0E-03
 -1.0E+00  4.2E+00 2.0E-02
 -1.5E+00  9.5E+00 6.0E-02
 -2.0E+00  1.6E+01 1.1E-01
"""
AGS = """\
"GROUP","SCPG"
"HEADING","LOCA_ID","SCPG_TESN","SCPG_CAR"
"UNIT","","",""
"TYPE","ID","X","2DP"
"DATA","A-1","1","0.75"

"GROUP","SCPT"
"HEADING","LOCA_ID","SCPG_TESN","SCPT_DPTH","SCPT_RES","SCPT_FRES","SCPT_PWP2"
"UNIT","","","m","MN/m2","kN/m2","kN/m2"
"TYPE","ID","X","2DP","3DP","3DP","1DP"
"DATA","A-1","2","1.50","9.5","60","15"
"DATA","A-1","2","2.00","16.0","110","20"
"DATA","A-1","1","0.50","1.2","4","5"
"DATA","A-1","1","1.00","4.2","20","10"
"""
LAB = """\
"GROUP","TRIT"
"HEADING","LOCA_ID","SPEC_DPTH","TRIT_CU"
"UNIT","","m","kPa"
"TYPE","ID","2DP","1DP"
"DATA","B-1","6.00","60"
"DATA","B-1","8.00","80"

"GROUP","LDEN"
"HEADING","LOCA_ID","SPEC_DPTH","LDEN_BDEN"
"UNIT","","m","Mg/m3"
"DATA","B-1","7.00","1.9"

"GROUP","GEOL"
"HEADING","LOCA_ID","GEOL_TOP","GEOL_BASE","GEOL_DESC"
"UNIT","","m","m",""
"DATA","B-1","0.00","5.00","0.00 m to 5.00 m - dense clayey SAND"
"DATA","B-1","5.00","9.00","5.00 m to 9.00 m - stiff sandy CLAY with partings of sand"
"""
NAMES = (
    "penetrationLength",
    "depth",
    "elapsedTime",
    "coneResistance",
    "localFriction",
    "porePressureU2",
    "frictionRatio",
)


def bro(rows: str = "", names: tuple[str, ...] = NAMES) -> str:
    lines = zip(DEPTH, CONE, SLEEVE, PRESSURE, strict=True)
    rows = rows or ";".join(f"{z},{z},-999999,{q},{f},{u},-999999" for z, q, f, u in lines)
    flags = "".join(f"<c:{name}>ja</c:{name}>" for name in names)
    encoding = '<s:encoding><s:TextEncoding decimalSeparator="." tokenSeparator="," blockSeparator=";"/></s:encoding>'
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<dispatchDataResponse xmlns="urn:d" xmlns:c="urn:c" xmlns:s="urn:s"><CPT_O><c:broId>A-1</c:broId>
<c:predrilledDepth uom="m">0.3</c:predrilledDepth><c:coneSurfaceQuotient uom="1">0.75</c:coneSurfaceQuotient>
<c:cptResult>{encoding}<c:values>{rows};</c:values></c:cptResult><c:parameters>{flags}</c:parameters>
</CPT_O></dispatchDataResponse>"""


CSV = "z [m],qc [MPa],fs [MPa],u2 [MPa],Location,remark\n" + "".join(
    f"{z},{q},{f},{u},A-1,x\n" for z, q, f, u in zip(DEPTH, CONE, SLEEVE, PRESSURE, strict=True)
)
DUTCH = "Diepte[m];Conuswaarden[MN/m²];Plaatselijke wrijving [kPa];Phi'[°];\n" + "".join(
    f"{z};{q};{1e3 * f};0;\n".replace(".", ",") for z, q, f in zip(DEPTH, CONE, SLEEVE, strict=True)
)
PERCENT = "depth_m,cone resistance (kPa),Rf (%)\n" + "".join(
    f"{z},{1e3 * q},{100 * f / q}\n" for z, q, f in zip(DEPTH, CONE, SLEEVE, strict=True)
)
GERMAN = "Tiefe (m);Spitzendruck (MN/m²);Mantelreibung (kPa);Porenwasserdruck u2 (kPa)\r\n" + "".join(
    f"{z};{q};{1e3 * f};{1e3 * u}\r\n".replace(".", ",")
    for z, q, f, u in zip(DEPTH, CONE, SLEEVE, PRESSURE, strict=True)
)
NAMED = CSV.replace("qc", "Cone resistance qc").replace("fs", "Sleeve friction fs").replace("u2", "Pore pressure u2")
LEVELS = GEF.replace("4, kPa, pore pressure, 6", "4, m, corrected depth, 11")
LEVELS = (
    LEVELS.replace(";5;!", ";-1.7;!")
    .replace(";10;!", ";-2.2;!")
    .replace(";15;!", ";-2.7;!")
    .replace(";20;!", ";-3.2;!")
)
BEDS = "Depth from [m],Depth to [m],Soil type,Dr [-],su from [kPa],su to [kPa]\n"
SOFT = "z [m],qc [MPa],fs [MPa],u2 [MPa]\n" + "".join(f"{z},0.1,0.002,0.25\n" for z in DEPTH)
ELEVATIONS = "z [m],qc [MPa],fs [MPa]\n" + "".join(f"{-25 - z},{q},0.01\n" for z, q in zip(DEPTH, CONE, strict=True))
# from a mudline at +0.8 and at +30 m
ACROSS, HIGH = (
    "z [m],qc [MPa],fs [MPa]\n" + "".join(f"{z0 - 2 * z},{q},0.01\n" for z, q in zip(DEPTH, CONE, strict=True))
    for z0 in (1.8, 31.0)
)


def read(tmp_path: Path, name: str, text: str):
    (tmp_path / name).write_text(text, encoding="utf-8")
    return read_site([tmp_path / name])


@pytest.mark.filterwarnings("ignore::pysprings.core.tables.TableNote")
@pytest.mark.parametrize(
    ("name", "text", "pressure"),
    [
        ("a.gef", GEF, True), ("old.GEF", OLD_GEF, False), ("a.ags", AGS, True), ("a.xml", bro(), True),
        ("a.csv", CSV, True), ("dutch.csv", DUTCH, False), ("percent.csv", PERCENT, False), ("gef.txt", GEF, True),
        ("named.csv", NAMED, True), ("german.csv", GERMAN, True),
    ],
)  # fmt: skip
def test_a_cone_penetration_test_has_the_same_numbers_from_every_format(tmp_path, name, text, pressure) -> None:
    (test,) = read(tmp_path, name, text).soundings
    assert test.depth == pytest.approx(DEPTH)
    assert test.cone == pytest.approx(np.multiply(CONE, 1e6))
    assert test.sleeve == pytest.approx(np.multiply(SLEEVE, 1e6))
    assert test.pressure == pytest.approx(np.multiply(PRESSURE, 1e6) if pressure else np.full(4, np.nan), nan_ok=True)
    if name in ("a.gef", "a.ags", "a.xml"):
        assert (test.name, test.area_ratio) == ("A-1", 0.75)


@pytest.mark.filterwarnings("ignore::pysprings.core.tables.TableNote")
@pytest.mark.parametrize("code", ["-9999", "-999.25", "999", "1e30", "-1e30", "9999"])
@pytest.mark.parametrize("column", ["qc", "fs", "u2", "z"])
def test_codes_for_no_value_are_no_measurements(tmp_path, column, code) -> None:
    """Once in megapascals, once in kilopascals, in which 999 is a pressure that a test may have."""
    for unit, factor in (("MPa", 1.0), ("kPa", 1e3)):
        rows = []
        for z, q, f, u in zip(DEPTH * 2, CONE * 2, SLEEVE * 2, PRESSURE * 2, strict=True):
            z += 2.0 * (len(rows) > 3)
            row = {"z": f"{z}", "qc": f"{factor * q}", "fs": f"{factor * f}", "u2": f"{factor * u}"}
            if len(rows) in (2, 5):
                if column == "qc" and unit == "kPa" and code in ("999", "9999"):
                    row["fs"] = "9"  # such cone resistances may be true: they stay
                else:
                    row[column] = code
            rows.append(row)
        text = f"z [m],qc [{unit}],fs [{unit}],u2 [{unit}]\n" + "\n".join(",".join(row.values()) for row in rows)
        (test,) = read(tmp_path, f"{unit}.csv", text).soundings
        assert test.depth.max() <= 4.0 and test.cone.max() == 16e6 and np.nanmax(test.sleeve) == pytest.approx(0.11e6)
        assert np.nanmax(test.pressure) == pytest.approx(0.02e6) and np.nanmin(test.pressure) > 0.0
        assert len(test.depth) == (6 if column in ("qc", "z") and len(test.depth) < 8 else 8)
        if len(test.depth) == 6 or column in ("fs", "u2"):
            assert any("taken as missing" in each or "left out" in each for each in test.notes), test.notes


def test_a_test_that_is_refused_does_not_hold_up_the_others(tmp_path) -> None:
    ags = AGS + "".join(f'"DATA","B-2","1","{z}","{q}","20","5"\n' for z, q in ((1, 2), (2, 3)))
    csv = (CSV + "1,2,0.02,0.01,B-2,x\n2,3,0.03,0.01,B-2,x\n").replace(",remark", "").replace(",x\n", "\n")
    for name, text in (("a.ags", ags), ("a.csv", csv)):
        with pytest.warns(UserWarning, match=rf"left out: \S*{name}: B-2: 2 rows with depth and cone resistance"):
            (test,) = read(tmp_path, name, text).soundings
        assert test.name == "A-1"


def test_a_friction_ratio_that_a_workbook_shows_in_percent_needs_no_unit(tmp_path) -> None:
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.append(["Depth [m]", "qc [MPa]", "Rf"])
    for z, q, f in zip(DEPTH, CONE, SLEEVE, strict=True):
        sheet.append([z, q, f / q])
        sheet.cell(sheet.max_row, 3).number_format = "0.0%"
    book.save(tmp_path / "a.xlsx")
    (test,) = read_site([tmp_path / "a.xlsx"]).soundings
    assert test.sleeve == pytest.approx(np.multiply(SLEEVE, 1e6))


def test_friction_ratios_of_almost_no_cone_resistance_do_not_refuse_a_test(tmp_path) -> None:
    rows = [(0.1, 0.001, 800, 0.01), (0.2, 0.001, 700, 0.01)]
    rows += [(z, q, 1, 0.01 * q) for z, q in zip(DEPTH, CONE, strict=True)]
    for head, columns in (("Rf [%]", 3), ("Rf [%],fs [MPa]", 4), ("Rf,fs [MPa]", 4)):
        text = f"z [m],qc [MPa],{head}\n" + "\n".join(",".join(map(str, row[:columns])) for row in rows)
        (test,) = read(tmp_path, "a.csv", text).soundings
        assert test.sleeve[2:] == pytest.approx(np.multiply(CONE, 0.01e6))
        left_out = "2 values of friction ratio beyond 500% are left out" in test.notes
        assert left_out == (columns == 3) == bool(np.isnan(test.sleeve[:2]).all())


def test_what_is_left_out_of_a_test_is_stated(tmp_path) -> None:
    text = "z [m],qc [MPa],fs [MPa],u2 [MPa]\n-0.5,0.1,0.01,0\n1.5,2,0,\n1,1,0.01,0.1\n2,3,,0.2\n3,,0.03,0.2\n"
    (test,) = read(tmp_path, "a.csv", text).soundings
    assert test.depth.tolist() == [1.0, 1.5, 2.0] and test.pressure == pytest.approx([1e5, 1.5e5, 2e5])
    assert np.isnan(test.sleeve).tolist() == [False, True, True]
    for note in ("1 rows above mudline are left out", "2 rows without positive sleeve friction have no I_c",
                 "rows are not in the order of their depth: sorted", "1 rows without u2: between its neighbours",
                 "1 of 5 rows without depth or positive cone resistance are left out"):  # fmt: skip
        assert any(note in each for each in test.notes), (note, test.notes)


def test_an_area_ratio_in_percent_is_no_area_ratio(tmp_path) -> None:
    for name, text in (("a.gef", GEF.replace("3, 0.75", "3, 75")), ("a.ags", AGS.replace('"1","0.75"', '"1","75"'))):
        (test,) = read(tmp_path, name, text).soundings
        assert test.area_ratio is None and test.total_cone == pytest.approx(test.cone + 0.2 * test.pressure)
        assert any("the area ratio 75 of the file is no share of 0.1 to 1" in each for each in test.notes)


@pytest.mark.parametrize("line", ["Net area ratio,0.70", "# net area ratio a: 0.70 [-]", "Net area ratio;0.70", "x"])
def test_the_area_ratio_above_the_heading_counts_and_other_values_are_remarked_on(line, tmp_path) -> None:
    text = f"Site A 12\n{line}\nPre-drilled depth,1 m\n" + CSV.replace(",remark", "").replace(",x", "")
    (test,) = read(tmp_path, "a.csv", text.replace(",", ";") if ";" in line else text).soundings
    assert test.area_ratio == (None if line == "x" else 0.7)
    assert "what stands above the heading does not count: Pre-drilled depth 1 m" in test.notes


def test_pore_pressures_that_are_nothing_are_remarked_on(tmp_path) -> None:
    rows = "".join(f"{z},{q},{f},0.0001\n" for z, q, f in zip(DEPTH, CONE, SLEEVE, strict=True))
    (test,) = read(tmp_path, "a.csv", "z [m],qc [MPa],fs [MPa],u2 [MPa]\n" + rows).soundings
    assert any("u2 is below 2% of the hydrostatic pressure everywhere" in each for each in test.notes)


def test_a_cone_whose_zero_is_off_is_remarked_on(tmp_path) -> None:
    text = "z [m],qc [MPa],fs [MPa]\n0.5,-0.12,0.001\n" + "".join(f"{z},{z - 0.3},0.01\n" for z in (1, 2, 3))
    (test,) = read(tmp_path, "a.csv", text).soundings
    assert "1 cone resistances are negative, down to -120 kPa: is the zero of the cone right?" in test.notes


def test_points_above_mudline_are_noted(tmp_path) -> None:
    with pytest.warns(UserWarning, match="1 rows without a depth of 0 or more are not used"):
        points = read(tmp_path, "a.csv", "Depth [m],su [kPa]\n-1,10\n1,20\n").points
    assert points.depth.tolist() == [1.0]


def test_rows_above_the_predrilled_depth_do_not_count(tmp_path) -> None:
    text = bro().replace('<c:predrilledDepth uom="m">0.3', '<c:predrilledDepth uom="m">0.8')
    (test,) = read(tmp_path, "a.xml", text).soundings
    assert test.depth.tolist() == DEPTH[1:] and "pre-drilled depth of 0.8 m" in test.notes[0]


def test_negative_depths_below_a_predrilled_depth_are_depths(tmp_path) -> None:
    """As in a public file of 2013: drilled to 6.0 m, corrected depths from -6.019 m on."""
    head, _, rows = GEF.partition("#EOH=\n")
    rows = "\n".join(f"-{6.019 + k / 50:.3f};{row.split(';', 1)[1]}" for k, row in enumerate(rows.split()))
    (test,) = read(tmp_path, "a.gef", f"{head}#MEASUREMENTVAR= 13, 6.0, m, pre-drilled\n#EOH=\n{rows}\n").soundings
    assert test.depth == pytest.approx([6.019, 6.039, 6.079, 6.099])
    assert "depths are negative: taken as depths below mudline" in test.notes


def test_a_table_with_several_locations_holds_several_tests(tmp_path) -> None:
    text = CSV + CSV.split("\n", 1)[1].replace("A-1", "B-2")
    with pytest.warns(UserWarning, match='not used: "remark"'):
        site = read(tmp_path, "a.csv", text)
    assert [(test.name, len(test.depth)) for test in site.soundings] == [("A-1", 4), ("B-2", 4)]


def test_points_by_depth(tmp_path) -> None:
    text = "Location,Depth [m],Su peak [kPa],epsilon 50 [%],Total unit weight [kN/m3],Vs [m/s]\n"
    text += "A,2,31,0.8,18,120\nB,6,48,-,19,"
    with pytest.warns(UserWarning, match="Location"):
        points = read(tmp_path, "lab.csv", text).points
    assert points.depth.tolist() == [2.0, 6.0]
    assert points.values["undrained_shear_strength"] == pytest.approx([31e3, 48e3])
    assert points.values["strain_at_half_strength"] == pytest.approx([0.012, np.nan], nan_ok=True)
    assert points.values["effective_unit_weight"] == pytest.approx([8190.0, 9190.0])
    assert points.values["shear_modulus"] == pytest.approx([18e3 / 9.81 * 120.0**2, np.nan], nan_ok=True)


def test_laboratory_tests_and_layers_of_ags(tmp_path) -> None:
    site = read(tmp_path, "lab.ags", LAB)
    assert site.points.depth.tolist() == [6.0, 8.0, 7.0]
    assert site.points.values["undrained_shear_strength"] == pytest.approx([60e3, 80e3, np.nan], nan_ok=True)
    assert site.points.values["effective_unit_weight"] == pytest.approx([np.nan, np.nan, 0.9 * 9810.0], nan_ok=True)
    assert [(bed.top, bed.bottom, bed.name) for bed in site.beds] == [
        (0.0, 5.0, "dense clayey SAND"), (5.0, 9.0, "stiff sandy CLAY with partings of sand")]  # fmt: skip
    found = propose(site, Options())
    assert [unit.kind for unit in found.units] == ["sand", "clay"]
    assert "su of TRIT_CU: unconsolidated undrained triaxial tests (UU), of total stress" in found.notes


def test_layers_with_relative_density(tmp_path) -> None:
    text = (
        "Depth from [m],Depth to [m],Soil type,Dr from [%],Dr to [%],Total unit weight [kN/m3]\n0,4,SAND,50,70,19.81\n"
    )
    (bed,) = read(tmp_path, "layers.csv", text).beds
    assert (bed.top, bed.bottom, bed.name) == (0.0, 4.0, "SAND")
    assert bed.values == {
        "relative_density": pytest.approx((0.5, 0.7)),
        "effective_unit_weight": pytest.approx((1e4, 1e4)),
    }


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.gef", GEF.replace("GEF-CPT-Report", "GEF-BORE-Report"), 'a.gef:2: is a GEF file of the kind "GEF-BORE-Rep'),
        ("a.gef", GEF.replace("2, MPa, cone", "2, kN, cone"), 'a.gef:6: COLUMNINFO 2: the unit is "kN", expected'),
        ("a.gef", GEF.replace("0.50;1.2;0.004;5;!", "0.50;1.2;0.004;!"), 'a.gef:14: "0.50;1.2;0.004;!" is no row'),
        ("a.gef", GEF.replace("resistance, 2", "resistance, 99"), "has no column of depth (quantity 1 or 11) and cone"),
        ("a.gef", GEF.replace("0.50;1.2", "0.50;x"), 'a.gef:14: "0.50;x;0.004;5;!" is no row of numbers'),
        ("a.gef", OLD_GEF.replace("1.2E+00 4.0E-03", "1.2E+00"), "a.gef:6: the row has 2 values, the columns of the"),
        ("a.gef", GEF.replace("VOID= 2", "VOID= x").replace("VAR= 3", "VAR= y").replace("1.2;", "x;"), "a.gef:14: "),
        ("a.gef", GEF.split("#EOH")[0], "has no line #EOH"),
        ("a.ags", AGS.replace("MN/m2", "lbf"), 'a.ags:9: SCPT_RES: the unit is "lbf"'),
        ("a.ags", AGS.replace('"9.5"', '"n.m."'), 'a.ags:11: SCPT_RES: "n.m." is not a number'),
        ("a.ags", AGS.replace('"SCPT"', '"HDPH"'), "holds none of the groups SCPT, GEOL, TRIT, TREG, LDEN; its groups"),
        ("a.ags", LAB.replace('"kPa"', '"psf"'), 'a.ags:3: TRIT_CU: the unit is "psf", expected one of kpa, kn/m2'),
        ("a.ags", '"**PROJ"\n"*PROJ_ID"\n', "is an AGS 3 file: save it as AGS 4"),
        ("a.xml", bro("0.5,1"), "its rows do not have the 7 values that its element parameters lists"),
        ("a.xml", "<root></root>", "holds no cone penetration test of the BRO"),
        ("a.xml", "<root>", "a.xml:1: is no well-formed XML"),
        ("a.asc", "Program UNIPLOT", "is of no kind that is read: a CPT is read from GEF, AGS 4, XML of the BRO"),
        ("a.csv", "depth [m],qc [kN]\n1,2\n", 'a.csv:1: "qc [kN]": wrong unit "kN": expected a pressure or'),
        ("a.csv", "depth [m],qc [MPa]\n1,x\n2,3\n", 'a.csv:2: qc [MPa]: "x" is not a number'),
        ("a.csv", "depth [m],qc [MPa]\n1,2\n2,3\n", "2 rows with depth and cone resistance: a CPT needs three"),
        ("a.csv", CSV.replace("qc [MPa]", "qc [GPa]"), "has a cone resistance of 1.6e+04 MPa, beyond 200 MPa: is the"),
        ("a.csv", CSV.replace("fs [MPa]", "fs [GPa]"), "has a sleeve friction of 110 MPa, beyond 5 MPa: is the unit"),
        ("a.csv", CSV.replace("qc [MPa]", "qc [Pa]"), "has no cone resistance above 0.016 kPa: is the unit right?"),
        ("a.csv", "depth [m],qc [MPa]\n", "a.csv:1: has no rows below its headings"),
        ("a.csv", "depth [m],su [kPa]\n-3,20\n", "a.csv:1: no row has a depth below mudline, 0 or more"),
        ("a.xml", bro().replace("UTF-8", "UTF-99"), "a.xml:1: is no XML that can be read (unknown encoding: UTF-99)"),
        ("a.csv", "name,H [kN]\na,1\n", "no headings of a CPT (depth [m], qc [MPa]), points"),
        ("a.csv", "depth [m],N [-]\n1,2\n", "a.csv:1: no column of values: su [kPa], Total unit weight"),
        ("a.csv", "Depth from [m],Depth to [m],su [kPa]\n0,0,20\n", "a.csv:2: Depth to [m]: is blank, or not below"),
        ("none.gef", None, "none.gef: no such file"),
        ("a.csv", CSV.replace("fs [MPa]", "fs [kPa]"), "has a sleeve friction of only 0.000554 % of the cone resist"),
        ("a.csv", CSV.replace("u2 [MPa]", "u2 [GPa]"), "has a pore pressure u2 of 20 MPa, beyond 10 MPa: is the unit"),
        ("a.csv", CSV.replace("z [m]", "z [cm]"), "ends at a depth of "),
        ("a.csv", SOFT, "has a pore pressure u2 of 2.5 times the cone resistance: is the unit right?"),
        ("a.csv", PERCENT.replace("Rf (%)", "Rf"), "a.csv:1: Rf: has no unit: write 'Rf [%]', or 'Rf [-]' for a share"),
        ("a.csv", CSV + CSV.split("\n", 1)[1], "a.csv: A-1: the depth falls from 2 to 0.5 m from one row to the nex"),
        ("a.csv", CSV + "1,2,0.02,0.01,B,x\n3,4,0.04,0.02,,x\n", "a.csv:7: Location: is blank: name the test of each"),
        ("a.csv", ELEVATIONS, "a.csv: a: depths are negative and begin at -25.5 m: elevations of another le"),
        ("a.csv", ACROSS, "a.csv: a: depths are negative and begin at 0.8 m: elevations of another level?"),
        ("a.csv", HIGH, "a.csv: a: depths fall from row to row and begin at 30 m: elevations of another level?"),
        ("a.csv", "depth [m],su [kPa]\n3,9\n1,9\n-4,9\n", "a.csv:1: depths fall from 3 to -4 m: elevations of another"),
        ("a.csv", "depth [m],su [kPa],Vs [m/s]\n1,20,90\n", "a.csv:1: Vs [m/s]: needs the total unit weight beside"),
        ("a.gef", GEF.replace("#EOH", "#MEASUREMENTVAR= 13, 9, m, x\n#EOH"), "below the pre-drilled depth of 9 m"),
        ("a.gef", GEF.replace("INFO= 3,", "INFO= 0,"), "a.gef:7: COLUMNINFO 0: columns count from 1"),
        ("a.gef", GEF.replace("friction, 3", "cone, 2"), "a.gef:7: COLUMNINFO 3: column 2 has the quantity 2, too"),
        ("a.gef", LEVELS, "a.gef: the corrected depth is -1.7 m where the length of the rods is 0.5 m: elevations of"),
        ("a.gef", GEF.split("0.50;")[0].replace("INFO= 3,", f"INFO= {'9' * 30},"), "a.gef:13: has no rows below #EOH"),
        ("a.ags", AGS + "\n" + AGS[AGS.index('"GROUP","SCPT"') :], "a.ags: holds the group SCPT twice"),
        ("a.ags", LAB.replace('"","m","m",""', '"","cm","ft",""'), 'a.ags:15: GEOL_BASE: the unit is "ft", expected'),
        ("a.csv", "depth [m],su [kPa]\n1,20\n2,-9999\n", "a.csv:3: su [kPa]: undrained_shear_strength -9999 kPa is"),
        ("a.csv", "depth [m],su [kPa]\n1,20\n2,9999\n", "a.csv:3: su [kPa]: undrained_shear_strength 9999 kPa look"),
        ("a.csv", "depth [m],Dr\n1,60\n", "a.csv:2: Dr: relative_density 60 is not in [0.01, 1.2]"),
        ("a.csv", BEDS + "0,5,SAND,60,,\n", "a.csv:2: Dr [-]: relative_density 60 is not in [0.01, 1.2]"),
        ("a.csv", BEDS + "0,5,CLAY,,20,\n", "a.csv:2: su to [kPa]: blank beside the value at the other end of the"),
        ("a.csv", BEDS + "0,5,CLAY,,,20\n", "a.csv:2: su from [kPa]: blank beside the value at the other end of the"),
        ("a.csv", BEDS + "0,5,CLAY,,9,9\n6,9,CLAY,,9,9\n", "a.csv:2: Depth to [m]: the layers leave a gap"),
        ("a.csv", BEDS + "0,5,CLAY,,9,9\n4,9,CLAY,,9,9\n", "a.csv:2: Depth to [m]: the layers overlap"),
        ("a.csv", BEDS + "2,5,CLAY,,9,9\n", "a.csv:2: Depth from [m]: the first layer begins at 2 m: it begins"),
        ("a.ags", LAB.replace('"1.9"', '"1900"'), "a.ags:11: LDEN_BDEN: effective_unit_weight 18629.2 kN/m^3 is"),
    ],
)  # fmt: skip
@pytest.mark.filterwarnings("ignore::pysprings.core.tables.TableNote")
def test_what_cannot_be_read_is_refused_in_one_line(tmp_path, name, text, message) -> None:
    with pytest.raises(UserInputError) as error:
        if text is None:
            read_site([tmp_path / name])
        read(tmp_path, name, text)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_all_faults_of_a_file_are_named_at_once(tmp_path) -> None:
    gef = GEF.replace("2, MPa, cone", "2, kN, cone").replace("4, kPa, pore", "4, psi, pore").replace("16.0", "x")
    ags = AGS.replace('"9.5","60"', '"x","y"').replace('"1.2","4"', '"z","4"')
    with pytest.raises(UserInputError) as error:
        read(tmp_path, "a.gef", gef)
    assert [(each.line, each.key) for each in error.value.problems] == [
        (6, "COLUMNINFO 2"), (8, "COLUMNINFO 4"), (18, None)]  # fmt: skip
    with pytest.raises(UserInputError) as error:
        read(tmp_path, "a.ags", ags)
    assert [(each.line, each.key) for each in error.value.problems] == [
        (11, "SCPT_RES"), (11, "SCPT_FRES"), (13, "SCPT_RES")]  # fmt: skip


def test_the_length_of_the_rods_is_no_depth_where_they_lean(tmp_path) -> None:
    """60 degrees from 0.5 m on: half a metre of depth for a metre of rods; a depth of the file stays."""
    tilted = GEF.replace("4, kPa, pore pressure, 6", "4, degrees, inclination, 8").replace(
        "1.00;4.2;0.020;10", "1.00;4.2;0.020;60"
    )
    tilted = (
        tilted.replace("0.060;15", "0.060;60")
        .replace("0.110;20", "0.110;60")
        .replace("1.20;-9999;0.020;10", "1.20;4;0.020;60")
    )
    (test,) = read(tmp_path, "a.gef", tilted).soundings
    assert test.depth == pytest.approx([0.5, 0.75, 0.85, 1.0, 1.25])
    assert "depths follow from the length of the rods and their inclination, 0.75 m less at the most" in test.notes
    parts = tilted.replace("inclination, 8", "inclination, 9")
    (test,) = read(tmp_path, "a.gef", parts).soundings
    assert test.depth == pytest.approx([0.5, 0.75, 0.85, 1.0, 1.25])
    leaning = bro(
        ";".join(f"{z},{y},{q},0.01,60" for z, y, q in ((1, -999999, 2), (2, -999999, 3), (4, 3.9, 3))),
        ("penetrationLength", "depth", "coneResistance", "localFriction", "inclinationResultant"),
    )
    (test,) = read(tmp_path, "a.xml", leaning).soundings
    assert test.depth == pytest.approx([1.0, 1.5, 3.9])


def test_depths_that_are_missing_have_the_sign_of_the_others(tmp_path) -> None:
    """As in a public file of 2013: negative corrected depths, and none above what was drilled."""
    head = GEF.replace("4, kPa, pore pressure, 6", "4, m, corrected depth, 11").partition("#EOH=\n")[0]
    rows = "0.50;1.2;0.004;-9;!\n1.00;4.2;0.020;-1.00;!\n1.50;9.5;0.060;-1.49;!\n2.00;16.0;0.110;-1.98;!\n"
    (test,) = read(tmp_path, "a.gef", f"{head}#COLUMNVOID= 4, -9\n#EOH=\n{rows}").soundings
    assert test.depth == pytest.approx([0.5, 1.0, 1.49, 1.98])


def test_each_push_has_the_area_ratio_of_its_cone(tmp_path) -> None:
    ags = AGS.replace('"A-1","1","0.75"\n', '"A-1","1","0.75"\n"DATA","A-1","2","0.5"\n')
    (test,) = read(tmp_path, "a.ags", ags).soundings
    assert test.total_cone == pytest.approx(test.cone + test.pressure * (0.25, 0.25, 0.5, 0.5))
    assert "area ratios 0.5, 0.75: each push has that of its cone" in test.notes
    text = CSV.replace(",remark", ",area ratio [-]").replace(",x\n", ",0.6\n")
    (test,) = read(tmp_path, "a.csv", text).soundings
    assert test.total_cone == pytest.approx(test.cone + 0.4 * test.pressure)
    (tmp_path / "qt.csv").write_text(CSV.replace("qc [", "qt [").replace(",remark", "").replace(",x\n", "\n"))
    (note,) = (
        each for each in propose(read_site([tmp_path / "qt.csv"]), Options(area_ratio=0.6)).notes if "ratio" in each
    )
    assert note == "--area-ratio does not count in 4 of 4 rows: the file gives their q_t"


def test_a_code_for_no_value_is_found_beside_larger_values_of_the_other_sign(tmp_path) -> None:
    text = CSV.replace("0.015,", "-0.999,").replace("0.02,A", "0.6,A").replace(",remark", "").replace(",x\n", "\n")
    (test,) = read(tmp_path, "a.csv", text).soundings
    assert np.nanmin(test.pressure) == pytest.approx(0.005e6)
    assert "1 values of pore pressure u2 are -0.999 MPa: taken as missing" in test.notes


@pytest.mark.parametrize(("soil", "cone", "where"), [("sand", 10.0, "in sand"), ("clay", 0.1, "at mudline")])
def test_pore_pressures_from_the_water_surface_are_remarked_on(tmp_path, soil, cone, where) -> None:
    for water, level in ((0.0, None), (30.0, 294)):
        rows = "".join(
            f"{z},{cone + z / 20},{(cone + z / 20) / 200},{9.81e-3 * (z + water)}\n" for z in np.arange(0.1, 9, 0.1)
        )
        (test,) = read(tmp_path, f"{soil}.csv", "z [m],qc [MPa],fs [MPa],u2 [MPa]\n" + rows).soundings
        found = [each for each in test.notes if "water surface" in each]
        assert len(found) == (level is not None)
        assert (
            not found or f"u2 is {level} kPa above the hydrostatic pressure of depths below mudline {where}" in found[0]
        )


def test_a_separator_may_be_a_comma_and_a_name_may_hold_commas(tmp_path) -> None:
    text = GEF.replace(";", ",").replace("sleeve friction, 3", "friction, local, 3")
    (test,) = read(tmp_path, "a.gef", text).soundings
    assert test.sleeve == pytest.approx(np.multiply(SLEEVE, 1e6))


def test_layers_of_another_place_and_of_several_boreholes_are_remarked_on(tmp_path) -> None:
    with pytest.warns(UserWarning, match="rows of GEOL are those of B-1 beside the CPT of A-1: all count"):
        assert len(read(tmp_path, "a.ags", AGS + "\n" + LAB[LAB.index('"GROUP","GEOL"') :]).beds) == 2
    with pytest.warns(UserWarning, match="rows of TRIT are those of B-1, B-2: all count"):
        read(tmp_path, "c.ags", LAB.replace('"B-1","8.00"', '"B-2","8.00"'))
    with pytest.warns(UserWarning, match="not used: layers of 2 boreholes"):
        assert not read(
            tmp_path, "b.ags", AGS + "\n" + LAB[LAB.index('"GROUP","GEOL"') :] + '"DATA","C","0","5","SAND"\n'
        ).beds


def test_a_pore_pressure_of_no_place_is_taken_as_that_behind_the_cone(tmp_path) -> None:
    (test,) = read(tmp_path, "a.csv", CSV.replace("u2 [", "u [").replace(",remark", "").replace(",x\n", "\n")).soundings
    assert "u is taken as u2, behind the cone" in test.notes and np.isfinite(test.pressure).all()


def test_pore_pressures_of_exactly_zero_are_remarked_on(tmp_path) -> None:
    (test,) = read(
        tmp_path, "a.csv", CSV.replace("0.015,", "0,").replace(",remark", "").replace(",x\n", "\n")
    ).soundings
    assert "1 rows have a u2 of exactly 0: not measured?" in test.notes
