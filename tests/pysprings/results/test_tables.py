# SPDX-License-Identifier: MIT
"""Springs from tables: what we write predicts the same when read back; users' curves; every refusal, all at once."""

import warnings
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pysprings import open_table
from pysprings.core import variables
from pysprings.core.errors import UserInputError
from pysprings.macro.answer import trace
from pysprings.macro.model import APART
from pysprings.macro.predict import MacroModel, MacroWarning, curve, impose, predict, way_to_load, way_to_motion
from pysprings.results.tables.sequence import read_sequence
from pysprings.springs.tip_zone import reslice
from tests.support import synthetic, written
from tests.support.commands import command
from tests.support.fans import fan_springs, potential

HEAD = "depth_m,depth_top_m,depth_bottom_m,y_m,p_N_per_m"
K = 2e8  # N/m per m


def write(path: Path, *lines: str) -> Path:
    path.write_text("\n".join(lines) + "\n")
    return path


def linear_rows(family: str = "") -> list[str]:
    """p = K y in four slices of 1 m."""
    front = f"{family}," if family else ""
    return [f"{front}{z},{z - 0.5},{z + 0.5},{y},{K * y}" for z in (0.5, 1.5, 2.5, 3.5) for y in (1e-3, 1e-2)]


def problems(path: Path, **options: float) -> list[str]:
    with pytest.raises(UserInputError) as caught:
        open_table(path, **options)
    return [f"{each.line}: {each.key}: {each.message}" for each in caught.value.problems]


@pytest.mark.parametrize("form", [0, 1], ids=["long", "wide"])
@pytest.mark.parametrize("spring_set", ["py", "full"])
@pytest.mark.parametrize("path", [None, "high"])
def test_our_own_table_predicts_what_the_springs_do(tmp_path, spring_set, path, form):
    """y of the deep rings turns back at an arm of 8 m: the record of the path is needed, and is in the table.

    Tables have the slices of `reslice`.
    """
    springs = synthetic.make_springs((synthetic.Path("pull"), synthetic.Path("high", arm=8.0)))
    file = written.tables(tmp_path, springs)[form]
    springs = reslice(springs)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MacroWarning)
        ours, theirs = (
            curve(source, u_max=2e-3, arm=4.0, n=5, springs_kind=spring_set, path=path, extrapolate=True)
            for source in (springs, open_table(file))
        )
    for name in ("u", "rotation", "H", "M", "p", "range_used", "off_path", "usable"):
        np.testing.assert_allclose(theirs[name], ours[name], rtol=1e-7, atol=1e-9 * np.abs(ours[name]).max())
    assert "w" not in theirs
    assert "V" not in theirs
    assert "w and V are left out" in " ".join(theirs.attrs["remarks"])
    assert list(variables.problems(theirs, "prediction")) == []


@pytest.mark.slow
def test_our_own_table_makes_the_same_fan(tmp_path):
    springs = fan_springs(potential)
    file = written.tables(tmp_path, springs)[0]
    table = open_table(file)
    ours, theirs = (curve(source, u_max=3e-3, arm=2.0, n=7) for source in (springs, table))
    assert theirs.attrs["springs"] == "fan"
    assert "the fan starts with that of the first recorded steps" in " ".join(theirs.attrs["remarks"])
    np.testing.assert_allclose(theirs["H"], ours["H"], rtol=5e-3)  # the initial slope is that of the first steps
    np.testing.assert_allclose(theirs["rotation"], ours["rotation"], rtol=5e-3)
    np.testing.assert_allclose(table["stiffness_initial"], springs["stiffness_initial"][::2, ::2], rtol=2e-2)


def test_wide_table_faults_name_their_line(tmp_path):
    """A word for a number, a quantity in another unit, a row that is too long."""
    file = written.tables(tmp_path, synthetic.make_springs())[1]
    head, *rows = file.read_text().splitlines()
    cells = rows[3].split(",")
    cells[5] = "much"
    assert problems(write(tmp_path / "word.csv", head, *rows[:3], ",".join(cells), *rows[4:])) == [
        '5: y_m: "much" is not a number'
    ]
    (found,) = problems(write(tmp_path / "unit.csv", head.replace("p_N_per_m z=0 ", "p_kN_per_m z=0 "), *rows))
    assert found.startswith('1: "p_kN_per_m z=0 [0..')
    assert "unknown column" in found
    found = problems(write(tmp_path / "long.csv", head, rows[0] + ",1", *rows[1:]))
    assert found[0].startswith("2: None: more cells than")


def test_minimal_table_and_its_closed_form(tmp_path):
    """Slices of 1 m: H = K sum y, M = -K sum z y with y = u - rotation z; the answer says that it is p-y alone."""
    rows = [f"{z},{y},{K * y}" for z in (0.5, 1.5, 2.5, 3.5) for y in (0.0, 1e-3, 1e-2)]
    table = open_table(write(tmp_path / "py.csv", "depth_m,y_m,p_N_per_m", *rows), skirt_length=4.0)
    z = np.array([0.5, 1.5, 2.5, 3.5])
    k = K * np.array([[4.0, -z.sum()], [-z.sum(), (z**2).sum()]])
    answer = way_to_load(table, H=1e5, arm=2.0, extrapolate=True)
    expected = np.linalg.solve(k, [1e5, 2e5])
    np.testing.assert_allclose([answer["u"][-1], answer["rotation"][-1]], expected, rtol=1e-9)
    assert answer.attrs["springs"] == "py"
    assert answer.attrs["remarks"][0].startswith("p-y springs alone: no distributed moment, tip and lid springs")
    assert "the last one at 4 m (the skirt length)" in " ".join(answer.attrs["remarks"])
    assert list(variables.problems(answer, "prediction")) == []
    assert MacroModel.from_springs(table).tangent_stiffness().dims == ("dof", "dof_conjugate")
    np.testing.assert_allclose(MacroModel.from_springs(table).tangent_stiffness(), k)
    with pytest.raises(UserInputError, match="V: these springs come from a table"):
        predict(table, H=1e5, V=1e6)


def test_slices_are_assumed_and_said(tmp_path):
    rows = [f"{z},0.001,1e5" for z in (1.0, 2.0, 4.0)]
    table = open_table(write(tmp_path / "py.csv", "depth_m,y_m,p_N_per_m", *rows))
    np.testing.assert_allclose(table.sets["table"].bounds, [[0.0, 1.5], [1.5, 3.0], [3.0, 5.0]])
    assert "the last one at 5 m (assumed skirt length)" in table.sets["table"].note


def test_negative_y_is_the_odd_reflection(tmp_path):
    """A curve given for y < 0 is the same spring; the rotated lower part of the skirt reads y < 0."""
    curves = [f"{z},{s * y},{s * p}" for z, s in ((1, 1), (3, -1)) for y, p in ((1e-3, 2e5), (5e-3, 5e5), (1e-2, 6e5))]
    table = open_table(write(tmp_path / "py.csv", "depth_m,y_m,p_N_per_m", *curves))
    model = MacroModel.from_springs(table)
    for y, p in ((5e-3, 5e5), (-5e-3, -5e5), (-1e-2, -6e5)):
        answer = trace(model, "state", np.array([[y, 0.0], [-y, 0.0], [2.0 * y, y]]))
        np.testing.assert_allclose(answer["p"].values[:, :2], [[p, -p], [p, -p]])
        np.testing.assert_allclose(answer["y"].values[:, 2], [y, -y])
        np.testing.assert_allclose(answer["p"].values[:, 2], [p, -p])


def test_a_little_pull_along_is_rounding_and_more_is_refused(tmp_path):
    """Up to 2 % of the largest load of the curve, whatever the unit of the numbers."""
    for largest in (4e5, 4e-2):
        for share, refused in ((-0.019, False), (-0.021, True)):
            rows = [f"1,{y},{p * largest}" for y, p in ((1e-3, share), (2e-3, 0.5), (3e-3, 1.0))]
            file = write(tmp_path / "py.csv", "depth_m,y_m,p_N_per_m", *rows)
            if refused:
                assert problems(file)[0].startswith("2: p_N_per_m: ")
            else:
                assert open_table(file).sets["table"].curves[0].r.tolist() == [
                    0.0,
                    share * largest,
                    0.5 * largest,
                    largest,
                ]


def test_beyond_the_table_is_marked(tmp_path):
    table = open_table(write(tmp_path / "py.csv", HEAD, *linear_rows()))
    with pytest.warns(MacroWarning, match=r"beyond the range of path 'table'.*1\.2 times"):
        far = curve(MacroModel.from_springs(table), u_max=1.2e-2, n=3, arm=-2.0, extrapolate=True)
    assert far["extrapolated"].values.tolist() == [0, 0, 1]


def companions() -> list[str]:
    blank = ",,,"
    head = "family,depth_m,depth_top_m,depth_bottom_m,y_m,p_N_per_m,rotation_rad,m_Nm_per_m,H_N,M_Nm"
    p = [f"{row},,,," for row in linear_rows("py")]
    m = [f"mtheta,{z},{blank}{q},{3e9 * q},," for z in (0.5, 1.5, 2.5, 3.5) for q in (1e-3, 1e-2)]
    m = [row.replace(f",{blank}", ",,,,,", 1) for row in m]
    ends = [
        f"{name},{z},,,{q},,{q},,{5e8 * q},{7e9 * q}" for name, z in (("base", 4), ("lid", 0)) for q in (0.001, 0.01)
    ]
    return [head, *p, *m, *ends]


def full_stiffness() -> np.ndarray:
    z = np.array([0.5, 1.5, 2.5, 3.5])
    k = K * np.array([[4.0, -z.sum()], [-z.sum(), (z**2).sum()]])
    k += 5e8 * np.array([[1.0, -4.0], [-4.0, 16.0]]) + 5e8 * np.array([[1.0, 0.0], [0.0, 0.0]])
    return k + np.array([[0.0, 0.0], [0.0, 4.0 * 3e9 + 2.0 * 7e9]])


def test_companions_by_family(tmp_path):
    table = open_table(write(tmp_path / "springs.csv", *companions()))
    model = MacroModel.from_springs(table)
    remark = "a table without a vertical path has no vertical springs: w and V are left out"
    assert (model.spring_set, model.remarks) == ("full", (APART, remark))
    np.testing.assert_allclose(model.tangent_stiffness(1e-3, -1e-4), full_stiffness())
    assert MacroModel.from_springs(table, "py").remarks[0].startswith("p-y springs alone")


def test_companions_by_sheet(tmp_path):
    rows = pd.DataFrame([row.split(",") for row in companions()[1:]], columns=companions()[0].split(","))
    with pd.ExcelWriter(tmp_path / "springs.xlsx") as book:
        for family, part in rows.groupby("family"):
            numbers = part.drop(columns="family").replace("", None).astype(float).dropna(axis=1, how="all")
            numbers.to_excel(
                book, sheet_name={"py": "p-y", "mtheta": "m-theta"}.get(str(family), str(family)), index=False
            )
    table = open_table(tmp_path / "springs.xlsx")
    np.testing.assert_allclose(MacroModel.from_springs(table).tangent_stiffness(), full_stiffness())


def test_part_of_the_companions_is_refused(tmp_path):
    rows = [row for row in companions() if not row.startswith(("lid", "base"))]
    table = open_table(write(tmp_path / "springs.csv", *rows))
    expected = r"the set 'full' needs the companions of p: base, lid missing \(give zeros if there are none, or"
    with pytest.raises(UserInputError, match=expected):
        predict(table, H=1e5)
    assert predict(table, H=1e5, arm=-2.0, springs_kind="py").attrs["springs"] == "py"
    alone = open_table(write(tmp_path / "py.csv", HEAD, *linear_rows()))
    with pytest.raises(UserInputError, match="mtheta, base, lid missing"):
        predict(alone, H=1e5, springs_kind="full")


def test_every_fault_of_the_numbers_at_once(tmp_path):
    rows = (
        "0.5,0,1,0.001,200e3",
        "0.5,0,1,0.0005,400e3",  # 3
        "1.5,1.2,2,0.001,abc",  # 4: two faults
        "1.5,1.2,2,0.001,7e5",  # 5
        "3,1.9,4,0.001,inf",  # 6: two faults
        "3,1.9,4,-0.002,-4e5",  # 7
        "5,4,6,0.001,-2e5",  # 8
        "7,6,8,0,3e5",  # 9
        "7,6,8,0.001,3e5,9",  # 10
        "7,6,8.5,0.002,",  # 11: two faults
    )
    found = problems(write(tmp_path / "py.csv", HEAD, *rows))
    assert found == [
        "3: y_m: 0.0005 does not grow (0.001 before): a curve needs one value a displacement, in order",
        '4: p_N_per_m: "abc" is not a number',
        "4: depth_top_m: gap of 0.2 m below the slice that ends at 1 m: slices must touch, from 0 on",
        "5: y_m: 0.001 stands twice at its depth: a curve needs one value a displacement, in order",
        '6: p_N_per_m: "inf" is not a finite number',
        "6: depth_top_m: overlap of 0.1 m with the slice that ends at 2 m: slices must touch, from 0 on",
        "7: y_m: -0.002 has another sign than before: give one direction, the other is its odd reflection",
        "8: p_N_per_m: -200000 pulls along with y_m = 0.001: reactions count positive against the displacement",
        "9: p_N_per_m: 300000 at zero displacement: curves pass through the origin",
        "10: None: more cells than the 5 columns of the heading",
        "11: depth_bottom_m: 8.5 at a depth whose slice had 8",
        "11: p_N_per_m: blank",
    ]


@pytest.mark.parametrize(
    ("head", "found"),
    [
        ("depth_m,y_mN,p_N_per_m", ['1: "y_mN": wrong unit "mN": expected a length such as \'y [mm]\'']),
        (
            "depth,y [deg],p [kN]",
            [
                "1: \"depth\": no unit: write 'depth [mm]'",
                '1: "y [deg]": wrong unit "deg": expected a length such as \'y [mm]\'',
                '1: "p [kN]": wrong unit "kN": expected N/m such as \'p [kN/m]\'',
            ],
        ),
        ("depth_m,y_m", ["1: p_N_per_m: missing column (needed: depth_m, y_m, p_N_per_m)"]),
        ("depth_m,y_m,p_N_per_m,y_m", ['1: "y_m": column stands 2 times']),
        ("depth_m,y_m,p_N_per_m,famly", ["1: \"famly\": unknown column (did you mean 'family'?)"]),
        ("depth_m\ty_m\tp_N_per_m", ["None: None: no rows of p-y curves (family py)"]),  # tabs separate, too
        ("depth_m,y_m,y [mm],p_N_per_m", ['1: "y_m": column stands 2 times ("y_m", "y [mm]")']),
        (
            "",
            [
                f"1: {name}: missing column (needed: depth_m, y_m, p_N_per_m)"
                for name in ("depth_m", "y_m", "p_N_per_m")
            ],
        ),
    ],
)
def test_columns_are_refused(tmp_path, head, found):
    assert problems(write(tmp_path / "py.csv", head)) == found


def test_other_refusals(tmp_path):
    file = write(tmp_path / "a.csv", "family,depth_m,y_m,p_N_per_m", "px,1,0.001,1e5", "py,1,0.001,1e5")
    assert problems(file) == ['2: family: "px" is not one of py, mtheta, base, lid, tz']
    file = write(tmp_path / "b.csv", "depth_m,side,y_m,p_N_per_m", "1,outside,0.001,1e5")
    assert problems(file) == ["2: side: only parts are given: side 'net' and component 'total' (or blanks) are needed"]
    file = write(tmp_path / "c.csv", "depth_m,y_m,p_N_per_m", "-1,0.001,1e5", "5,0.001,1e5")
    assert problems(file) == ["2: depth_m: -1 is above mudline (depth counts downwards)"]
    file = write(tmp_path / "d.csv", HEAD, *linear_rows())
    assert problems(file, skirt_length=5.0) == ["8: depth_bottom_m: slices end at 4 m, not at the skirt length 5 m"]
    (tmp_path / "e.xlsx").write_text("not a workbook")
    assert problems(tmp_path / "e.xlsx")[0].startswith("None: None: not an Excel workbook")
    book = written.workbook(tmp_path / "springs.xlsx", synthetic.make_springs())
    assert "is the workbook for people" in problems(book)[0]
    assert problems(tmp_path / "none.csv") == ["None: None: no such file"]


def test_faults_of_a_record(tmp_path):
    springs = synthetic.make_springs((synthetic.Path(steps=3),), synthetic.Caisson(rings=3))
    file = written.tables(tmp_path, springs)[0]
    table = pd.read_csv(file)
    py = table[(table["family"] == "py") & (table["side"] == "net") & (table["component"] == "total")]
    moved = py.index[7]
    table.loc[moved, "y_m"] += 1e-4
    doubled = pd.concat([table, py.iloc[[2]]])
    doubled.to_csv(tmp_path / "a.csv", index=False)
    assert problems(tmp_path / "a.csv") == [f"{len(doubled) + 1}: step: step 2 at depth 0 m stands twice"]
    table.to_csv(tmp_path / "b.csv", index=False)
    assert [text.split(" is not u")[0] for text in problems(tmp_path / "b.csv")] == [f"{moved + 2}: y_m:"]
    table.drop(index=[py.index[5], moved]).to_csv(tmp_path / "c.csv", index=False)
    assert "has 2 of 4 steps (py)" in problems(tmp_path / "c.csv")[0]
    table[table["family"] != "lid"].to_csv(tmp_path / "d.csv", index=False)
    assert "companions mtheta, base without lid" in problems(tmp_path / "d.csv")[0]
    table[table["family"] == "py"].drop(index=moved).to_csv(tmp_path / "e.csv", index=False)
    assert len(problems(tmp_path / "e.csv")) == 1
    alone = pd.read_csv(file)
    alone[alone["family"] == "py"].to_csv(tmp_path / "g.csv", index=False)
    with pytest.warns(MacroWarning, match="off the path"):
        answer = curve(open_table(tmp_path / "g.csv"), u_max=1e-4, n=3)
    assert answer.attrs["springs"] == "py"


def test_many_faults_are_counted(tmp_path):
    file = write(tmp_path / "py.csv", "depth_m,y_m,p_N_per_m", *["1,0.001,x", "2,x,1e5"] * 50)
    with pytest.raises(UserInputError) as caught:
        open_table(file)
    assert len(caught.value.problems) == 100
    lines = str(caught.value).splitlines()
    assert len(lines) == 21
    assert lines[-1] == "fatal: user input: and 80 more problems"


@pytest.mark.parametrize("sign", [1, -1])
def test_states_beyond_the_peak_of_a_softening_curve_are_marked(tmp_path, sign):
    """p of the upper slice falls from 5e5 to 1e5 N/m beyond 5 mm; that of the lower one by 1 % of its peak."""
    upper = [(1e-3, 2e5), (5e-3, 5e5), (1e-2, 1e5)]
    lower = [(1e-3, 2e5), (5e-3, 5e5), (1e-2, 4.95e5)]
    rows = [f"{z},{y},{p}" for z, curve_ in ((1, upper), (3, lower)) for y, p in curve_]
    table = open_table(write(tmp_path / "py.csv", "depth_m,y_m,p_N_per_m", *rows), skirt_length=4.0)
    before = impose(table, u=sign * 4.9e-3, rotation=0.0, strict=True)
    assert before.attrs["warnings"] == []
    with pytest.warns(
        MacroWarning, match=r"^1 of 2 states are .*\(p at 1 m falls from 0\.5 MN/m to 0\.1 MN/m\): .*one of several"
    ):
        way_to_motion(table, u=sign * 8e-3, rotation=0.0, n=1)
    with pytest.raises(UserInputError, match=r"strict: .*a curve that softens"):
        impose(table, u=sign * 8e-3, rotation=0.0, strict=True)


@pytest.mark.parametrize("ending", ["xls", "ods", "XLSX"])
@pytest.mark.parametrize("options", [(), ("--skirt-length", "4 m")])
def test_tables_of_other_formats_are_named(tmp_path, ending, options):
    file = write(tmp_path / f"py.{ending}", "depth_m,y_m,p_N_per_m", "1,0.001,1e5")
    done = command("predict", str(file), "--H", "10 kN", *options)
    words = {"xls": "is a workbook of the old Excel format", "ods": "is a spreadsheet of another program"}
    assert done.code == 2
    assert done.err.startswith(f"fatal: user input: {file}: {words.get(ending, 'not an Excel workbook')}")


def test_a_table_of_a_million_lines_is_refused_before_it_is_read(tmp_path):
    """By its lines, counted: the first cell that is wrong is not reached."""
    file = write(tmp_path / "py.csv", "depth_m,y_m,p_N_per_m", *["x,0,1"] * 1_000_000)
    (line,) = problems(file)
    assert line.endswith(
        "is too large for a table (1,000,001 lines, at most 300,000; springs.nc of a run has no such limit)"
    )


def test_units_of_headings_and_decimal_commas(tmp_path):
    """The same springs in SI with commas, and as a European spreadsheet writes them in kN and mm."""
    plain = write(tmp_path / "si.csv", "depth_m,y_m,p_N_per_m", "1.5,0.00125,125000", "3,0.00125,2e5")
    european = write(tmp_path / "eu.csv", "depth (m);y [mm];p [kN/m]", "1,5;1,25;125", "3;1,25;200")
    ours, theirs = (predict(open_table(file, skirt_length=4.0), H=1e4) for file in (plain, european))
    np.testing.assert_allclose(theirs["u"], ours["u"], rtol=1e-12)
    assert float(ours["u"]) > 0.0


def test_the_command_takes_tables(tmp_path):
    file = write(tmp_path / "py.csv", "depth_m,y_m,p_N_per_m", "1,0.001,1e5", "3,0.001,2e5")
    done = command("predict", str(file), "--H", "10 kN", "--skirt-length", "4 m")
    assert done.code == 0
    assert done.out.split()[:2] == ["u", "[mm]"]
    assert done.err.splitlines()[0].startswith("note: p-y springs alone")
    bad = write(tmp_path / "bad.csv", "depth_m,y_deg,p_N_per_m", "1,0.001,1e5")
    done = command("predict", str(bad), "--H", "10 kN")
    assert (done.code, done.out) == (2, "")
    assert done.err == (
        f'fatal: user input: {bad}:1: "y_deg": wrong unit "deg": expected a length such as \'y [mm]\'\n'
    )
    nc = command("predict", str(tmp_path), "--H", "10 kN", "--skirt-length", "4 m")
    assert "--skirt-length: is for tables" in nc.err


@pytest.mark.parametrize("form", [0, 1], ids=["long", "wide"])
def test_stiffness_of_a_table_is_that_of_the_first_steps(tmp_path, form):
    """Load over motion of a pure translation and a pure rotation at their first step; lid and tip carry moments."""
    ways = (synthetic.Path("slide", "translation", size=1e-2), synthetic.Path("turn", "rotation", size=-2e-3))
    springs = synthetic.make_springs(ways)
    for key in ("M_lid", "M_tip", "H_lid", "H_tip"):
        share = [abs(float(springs[f"paths/{way.name}/{key}"][1])) for way in ways]
        assert max(share) > 1e3, key
    slide, turn = (springs[f"paths/{way.name}"] for way in ways)
    columns = [[float(path[load][1]) / float(path[by][1]) for load in ("H", "M")]
               for path, by in ((slide, "u"), (turn, "rotation"))]  # fmt: skip
    table = open_table(written.tables(tmp_path, springs)[form])
    np.testing.assert_allclose(table["stiffness_initial"], np.transpose(columns), rtol=1e-8)


def test_text_of_no_encoding_is_refused(tmp_path):
    (tmp_path / "a.csv").write_bytes("depth_m,y_m,p_N_per_m".encode("utf-16-be"))
    (problem,) = problems(tmp_path / "a.csv")
    assert problem.startswith("None: None: not a CSV file in UTF-8, UTF-16 or Windows-1252: save it")


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("1,1.5,2,1e-3,1e5", "2: depth_top_m: depth 1 m is not in its slice 1.5 to 2 m"),
        ("1,0,0.5,1e-3,1e5", "2: depth_top_m: depth 1 m is not in its slice 0 to 0.5 m"),
        ("1,1,1,1e-3,1e5", "2: depth_top_m: depth 1 m is not in its slice 1 to 1 m"),
    ],
)
def test_a_depth_outside_of_its_slice_is_refused(tmp_path, row, message):
    assert message in problems(write(tmp_path / "a.csv", HEAD, row))


def test_two_curves_at_one_depth_are_a_layer_boundary(tmp_path):
    rows = ("1,0.01,50", "1,0.05,100", "3,0.01,60", "3,0.05,120", "3,0.01,400", "3,0.05,900")
    found = problems(write(tmp_path / "a.csv", "depth [m],y [m],p [kN/m]", *rows), skirt_length=5.0)
    assert any("0.01 begins a second curve at 3 m: at a layer boundary write the two curves" in each for each in found)


@pytest.mark.parametrize("first", ["0,0,0", "5,0,0"])
def test_a_first_row_of_zeros_is_the_state_at_rest_and_may_be_at_0_s(tmp_path, first):
    file = write(tmp_path / "a.csv", "time [s],H [kN],M [kNm]", first, "10,100,500", "20,-100,-500")
    found = read_sequence(file)
    assert found.time is not None and found.time.tolist() == [float(first[0]), 10.0, 20.0]
    assert (1e-3 * found.targets[:, 0]).tolist() == pytest.approx([0.0, 100.0, -100.0])
