# SPDX-License-Identifier: MIT
"""Tables of load cases: units, directions, partial factors, sums of loads, and every fault with its place."""

from pathlib import Path

import numpy as np
import openpyxl
import pytest

from pysprings.core.errors import UserInputError
from pysprings.core.tables.load_cases import LoadCases, read_load_cases


def table(folder: Path, *lines: str) -> LoadCases:
    file = folder / "cases.csv"
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return read_load_cases(file)


def problems(folder: Path, *lines: str) -> list[str]:
    with pytest.raises(UserInputError) as caught:
        table(folder, *lines)
    assert all(each.file == str(folder / "cases.csv") for each in caught.value.problems)
    return [f"{each.line}: {each.key}: {each.message}" for each in caught.value.problems]


def test_a_european_table_reads_as_a_plain_one(tmp_path: Path) -> None:
    plain = table(tmp_path, "name,limit_state,H_N,arm_m,V_N,tilt_rad", "storm,ULS,2.5e6,20,3e6,0.0043633231299858239")
    for head in (
        "case;limit state;H [MN];height [m];V [MN];tilt [deg]",
        "Lastfall;Grenzzustand;Horizontalkraft [MN];Hebelarm [m];Vertikalkraft [MN];tilt [deg]",
    ):
        european = table(tmp_path, head, "storm;ULS;2,5;20;3;0,25")
        for name in ("H", "M", "V", "direction", "tilt"):
            np.testing.assert_allclose(getattr(european, name), getattr(plain, name), rtol=1e-14)
    assert (plain.name, plain.limit_state, plain.line.tolist()) == (("storm",), ("ULS",), [2])
    assert (plain.H[0], plain.M[0], plain.V[0]) == (2.5e6, 50e6, 3e6)


def test_a_workbook(tmp_path: Path) -> None:
    book = openpyxl.Workbook()
    for row in (("name", "H [kN]", "M [MN m]"), ("a", 100, -2), (None, None, None), ("b", -50.5, 0)):
        book.active.append(row)
    book.save(tmp_path / "cases.xlsx")
    cases = read_load_cases(tmp_path / "cases.xlsx")
    assert cases.name == ("a", "b")
    assert cases.line.tolist() == [2, 4]
    np.testing.assert_allclose(cases.loads, [[1e5, -2e6], [-50.5e3, 0.0]])
    assert np.isnan(cases.V).all() and np.isnan(cases.tilt).all()


def test_partial_factors_and_sums_of_loads(tmp_path: Path) -> None:
    """Wind and waves of one case: the moment of a force has the factor of the force."""
    cases = table(
        tmp_path,
        "name,H [kN],arm [m],M [kN m],V [kN],factor H,factor M,factor V",
        "storm,100,50,,200,1.35,,0.9",
        "storm,300,10,,,1.2,,",
        "storm,,,-1000,,,1.1,",
        "calm,10,1,,,,,",
    )
    assert cases.name == ("storm", "calm")
    np.testing.assert_allclose(cases.H, [495e3, 10e3])
    np.testing.assert_allclose(cases.M, [135e3 * 50 + 360e3 * 10 - 1.1e6, 10e3])
    np.testing.assert_allclose(cases.V, [180e3, np.nan])


def test_directions_are_added_as_vectors(tmp_path: Path) -> None:
    """Equal forces at 0 and 90 degrees act at 45 degrees; opposite ones at two heights leave a couple."""
    cases = table(
        tmp_path,
        "name,H [kN],arm [m],direction [deg]",
        "both,100,20,0",
        "both,100,20,90",
        "couple,100,30,10",
        "couple,100,20,190",
        "back,-100,5,30",
    )
    np.testing.assert_allclose(cases.H, [np.sqrt(2) * 1e5, 0.0, -1e5], atol=1e-6)
    np.testing.assert_allclose(cases.M, [np.sqrt(2) * 2e6, 1e6, -5e5], rtol=1e-12)
    np.testing.assert_allclose(np.degrees(cases.direction), [45.0, 10.0, 30.0], atol=1e-9)


def test_what_lies_beside_the_plane_of_the_force_is_kept_by_row(tmp_path: Path) -> None:
    """A moment across the plane of H and a torsion are read, not refused: no row blocks the others."""
    head = "name,H [kN],arm [m],direction [deg],Mz [kN m]"
    cases = table(tmp_path, head, "skew,100,50,0,", "skew,100,10,30,7", "plain,1,1,0,")
    angle = np.radians(15.0)  # of the sum of two equal forces: the arms differ by 40 m across it
    np.testing.assert_allclose(cases.across, [-(5e6 - 1e6) * -np.sin(angle), 0.0], atol=1e-6)
    np.testing.assert_allclose(np.degrees(cases.direction), [15.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(np.abs(cases.M), [6e6 * np.cos(angle), 1e3])
    assert cases.torsion.tolist() == [7e3, 0.0]
    bound = cases.bounded(radius=3.5)  # one plane, overturning; T/R beside H
    np.testing.assert_allclose(np.abs(bound.H), [np.abs(cases.H[0]) + 2e3, 1e3])
    np.testing.assert_allclose(np.abs(bound.M), [np.hypot(cases.M[0], cases.across[0]), 1e3])
    assert not bound.opposed.any() and not bound.aside.any()
    assert "turned into the plane of H, torsion of 7 kN m as T/R = 2 kN on H" in bound.remarks[0]
    assert bound.remarks[1] == ""
    assert table(tmp_path, "name,H [kN],M [kN m]", "a,nan,2", "b,3,2").remarks == ("H is blank: 0", "")
    np.testing.assert_allclose(np.abs(cases.bounded(None).H), np.abs(cases.H))


def test_a_torsion_that_governs_has_no_bound(tmp_path: Path) -> None:
    """T/R (R 4 m) above half of (H, M/8 m), or R unknown; kept torsions stay beside H, with a moment across turned."""
    rows = ("alone,0,0,0,-90", "less,100,0,0,199", "more,100,0,0,-201", "moment,0,1600,0,399", "across,100,0,900,300")
    cases = table(tmp_path, "name,Fx [kN],My [kN m],Mx [kN m],Mz [kN m],Fy [kN],Fz [kN]", *(f"{r},0,0" for r in rows))
    assert cases.twisted(4.0).tolist() == [True, False, True, False, False]
    assert cases.twisted(None).all() and not cases.twisted(4.0)[cases.torsion == 0.0].any()
    words = [", no bound: T governs" in text for text in cases.bounded(4.0).remarks]
    assert words == [True, False, True, False, False]
    kept = cases.bounded(4.0, cases.twisted(4.0))
    assert kept.torsion.tolist() == [-90e3, 0.0, -201e3, 0.0, 0.0] and kept.remarks[0] == ""
    np.testing.assert_allclose(kept.H, [0.0, 100e3 + 199e3 / 4, 100e3, 399e3 / 4, 175e3])
    np.testing.assert_allclose(kept.M, [0.0, 0.0, 0.0, 1600e3, 900e3])
    below = table(tmp_path, "name,H [kN],M [kN m],T [kN m]", "a,100,-300,200")  # M turns against H, and T alone is kept
    assert below.bounded(4.0, kept=True).M.tolist() == [-300e3] and below.bounded(4.0).M.tolist() == [300e3]


def test_the_factor_of_a_force_is_that_of_its_moment(tmp_path: Path) -> None:
    head = "name,H [kN],M [kN m],T [kN m],factor H"
    cases = table(tmp_path, head, "a,1000,-2000,10,1.35", "b,1000,-2000,10,")
    np.testing.assert_allclose(cases.H, [1350e3, 1000e3])
    np.testing.assert_allclose(cases.M, [-2700e3, -2000e3])
    np.testing.assert_allclose(cases.torsion, [13.5e3, 10e3])
    assert cases.remarks == ("factor H 1.35 multiplies the moment, too (no factor M)", "factor H is blank: 1")
    cases = table(
        tmp_path, "name,H [kN],arm [m],factor H,factor M", "a,1000,2,1.35,1.0", "b,1000,2,1.35,1.35", "c,1,0,2,1"
    )
    np.testing.assert_allclose(cases.M, [2700e3, 2700e3, 0.0])
    words = "factor M is not used: the moment of H at its height has the factor of H"
    assert cases.remarks == (words, "", "")


def test_six_components(tmp_path: Path) -> None:
    """z up, right-handed: My = Fx h and Mx = -Fy h of a force at height h; a moment across is none of both."""
    head = "load case,Fx [kN],Fy [kN],Fz [kN],Mx [kNm],My [kNm],Mz [kNm]"
    rows = ("a,1200,0,-9000,0,42000,0", "b,1500,300,-9000,-9000,45000,500", "c,0,100,0,-500,200,0", "d,-10,0,0,0,-50,0")
    cases = table(tmp_path, head, *rows, "e,300,-700,0,300,-700,0")  # all across: no M, of either sign, in rounding
    np.testing.assert_allclose(np.abs(cases.H), [1200e3, np.hypot(1500e3, 300e3), 1e5, 1e4, np.hypot(3e5, 7e5)])
    np.testing.assert_allclose(np.abs(cases.M), [42e6, 30.0 * np.hypot(1500e3, 300e3), 5e5, 5e4, 0.0])
    assert not cases.opposed.any()
    np.testing.assert_allclose(cases.V, [9e6, 9e6, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(np.degrees(cases.direction), [0.0, 11.309932474, 90.0, 0.0, -66.801409486], atol=1e-9)
    np.testing.assert_allclose(cases.torsion, [0.0, 5e5, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(cases.across, [0.0, 0.0, 2e5, 0.0, np.sqrt(58e10)], atol=1e-6)  # right-handed about y


def test_a_table_with_z_down_has_a_remark_in_every_row(tmp_path: Path) -> None:
    """Its weights are pulls here; a pull beside pushes, as of a leg, is none."""
    head = "load case,Fx [kN],Fy [kN],Fz [kN],Mx [kNm],My [kNm],Mz [kNm]"
    down = table(tmp_path, head, "a,10,0,9500,0,400,0", "b,10,0,4500,0,400,0")
    assert all(text == "V is a pull, as in all rows: Fz counts upwards" for text in down.notes)
    assert not any(table(tmp_path, head, "a,10,0,9500,0,400,0", "b,10,0,-4500,0,400,0").notes)
    head = "case,H [kN],arm [m],V [kN]"
    up = table(tmp_path, head, "a,10,3,-9500", "b,10,3,-4500")
    assert all(text == "V is a pull, as in all rows: V is positive down" for text in up.notes)
    assert not any(table(tmp_path, head, "a,10,3,-9500", "b,10,3,4500").notes)


def test_an_arm_in_mm_and_a_tolerance_in_rad_have_a_remark(tmp_path: Path) -> None:
    """300 kN at 8 mm in place of 8 m was ok with 0.28 mm for 0.69; 0.25 rad, 14 deg, for 0.25 deg is never exceeded."""
    head = "case,H [kN],arm [mm],tilt [rad]"
    odd = table(tmp_path, head, "a,300,8,0.25", "b,300,8000,0.0044", "c,300,0,7e-5", "d,300,8e5,0.0044")
    assert odd.notes == (
        "arm is 0.008 m, outside the common range 0.1 to 500 m: is its unit right?; "
        "tilt is 14.3 deg, outside the common range 0.01 to 5 deg: is its unit right?",
        "",
        "tilt is 0.00401 deg, outside the common range 0.01 to 5 deg: is its unit right?",
        "arm is 800 m, outside the common range 0.1 to 500 m: is its unit right?",
    )


def test_the_order_and_the_parts_of_loads_change_no_case(tmp_path: Path) -> None:
    """100 random tables: shuffled, and with a load in two halves; a repeated row counts twice and has a remark."""
    random = np.random.default_rng(40)
    head = "name,H [kN],arm [m],V [kN],direction [deg],T [kN m],factor"
    for _ in range(100):
        rows = [
            f"{name},{H},{arm},{V},{angle},{T},{factor}"
            for name, H, arm, V, angle, T, factor in zip(
                random.choice(list("abc"), 6), random.integers(-900, 900, 6), random.integers(0, 60, 6),
                random.integers(0, 9000, 6), 45 * random.integers(0, 8, 6), random.integers(0, 9, 6),
                random.choice([1.0, 1.35], 6), strict=True,
            )
        ]  # fmt: skip
        first = rows[0].split(",")
        half = ",".join([first[0], str(int(first[1]) / 2), first[2], str(int(first[3]) / 2), first[4],
                         str(int(first[5]) / 2), first[6]])  # fmt: skip
        whole = by_name(table(tmp_path, head, *rows))
        shuffled = by_name(table(tmp_path, head, *random.permutation(rows)))
        halved = by_name(table(tmp_path, head, half, *rows[1:], half))
        assert whole.keys() == shuffled.keys() == halved.keys()
        for name, values in whole.items():
            assert shuffled[name] == values
            np.testing.assert_allclose(halved[name], values, rtol=1e-9, atol=1e-3)
    twice = table(tmp_path, "name,H [kN]", "a,5", "b,1", "a,5")
    assert table(tmp_path, "name,H [kN]", "Storm,5", "storm,1").remarks[0] == "'storm' is another case"
    assert (twice.H.tolist(), twice.remarks) == ([1e4, 1e3], ("the rows 2 and 4 are the same, and both count", ""))


def by_name(cases: LoadCases) -> dict[str, tuple[float, ...]]:
    columns = (cases.H, cases.M, cases.V, cases.direction, cases.across, cases.torsion)
    return {name: tuple(float(each[k]) for each in columns) for k, name in enumerate(cases.name)}


def test_a_factor_of_a_blank_v_is_not_used_with_a_remark(tmp_path: Path) -> None:
    cases = table(tmp_path, "name,H [kN],V [kN],factor V", "a,1,,1.1", "b,1,,1", "c,1,2,1.1", "d,1,,")
    assert cases.remarks == ("factor V is not used: V is blank", "", "", "")
    assert cases.V.tolist() == pytest.approx([np.nan, np.nan, 2.2e3, np.nan], nan_ok=True)


def test_every_fault_with_its_place(tmp_path: Path) -> None:
    found = problems(
        tmp_path,
        "name,limit_state,H [kN],M [kN m],arm [m],V [kN],factor,tilt [deg]",
        "a,ULS,1,2,3,,,",
        "b,ULS,,,4,,,",
        "c,ULS,x,,,,,",
        "d,ULS,1,,,,-1,-2",
        "e,ULS,,,,,,",
        "f,ULS,1,,,,,,9",
    )
    assert found == [
        "2: arm [m]: give either a moment or the height of H, not both (M = H arm): M is about the lid centre; "
        "one at a height h becomes M + H h, Mx - Fy h, My + Fx h",
        f"3: None: no load: expected {FORMS}",
        "3: arm [m]: a height without H",
        '4: H [kN]: "x" is not a number',
        "5: factor: -1 is negative: a partial factor is 0 or more",
        "5: tilt [deg]: a tolerance must be positive",
        "5: arm [m]: blank: write 0 where it is none",
        f"6: None: no load: expected {FORMS}",
        "7: None: more cells than the 8 columns of the heading",
        "7: arm [m]: blank: write 0 where it is none",
    ]


FORMS = "H with M or arm, M alone, V alone, or Fx, Fy, Fz, Mx, My, Mz with z up"


@pytest.mark.parametrize(
    ("lines", "found"),
    [
        (("",), f"1: None: holds no table: expected a heading and a row a load ({FORMS})"),
        (("name,H [kN]",), "1: None: no rows"),
        (("name,arm [m]", "a,1"), f"1: None: no column with a load: expected {FORMS}"),
        (("name,M [kN m],arm [m]", "a,1,"), "1: arm [m]: a height without H"),
        (("name,H [kN],factor,factor H", "a,1,1,1"),
         "1: factor: give either one factor on H, M and V, or factor H, factor M and factor V"),
        (("name,limit state,H [kN]", "a,ULS,1", "a,SLS,1"), "3: limit state: rows of one case differ: ULS, SLS"),
        (("name,H [kN],tilt [deg]", "a,1,1", "a,1,2"), "3: tilt [deg]: rows of case 'a' differ in their tolerance"),
        (("name,H [kN]", "=A1,1"), "2: name: \"=A1\": a name has at most 60 characters, the first none of = + - @"),
        (("name,Fx [kN],H [kN]", "a,1,1"), '1: Fx [kN]: gives what "H [kN]" gives, too: keep one of them'),
        (("name,Fx [kN],Fy [kN],Mx [kN m]", "a,1,,2"), "2: Fy [kN]: blank: write 0 where it is none"),
        (("name,Fx [kN],Fy [kN],direction [deg]", "a,1,1,5"),
         "1: direction [deg]: components have the axes x and y: they need no direction"),
        (("name,H [kN],height [m]", "a,1,2", "b,1,"), "3: height [m]: blank: write 0 where it is none"),
        (("name,H [kN],M [kN m]", "a,1,2", "b,1,-"), "3: M [kN m]: blank: write 0 where it is none"),
        (("name,H [kN],direction [deg]", "a,1,2", "b,1,"), "3: direction [deg]: blank: write 0 where it is none"),
        (("name,H [kN]", "storm,500", ",300"),
         "3: name: blank: write the name in every row (rows of one name act together)"),
        (("name,H [kN],arm [m]", "a,1,2", "name,H [kN],arm [m]"), '3: H [kN]: "H [kN]" is not a number'),
        (("name,H [kN],arm [m]", ",MN,", "a,1,2"), '2: H [kN]: "MN" is not a number'),
    ],
)  # fmt: skip
def test_tables_that_are_refused(tmp_path: Path, lines: tuple[str, ...], found: str) -> None:
    assert found in problems(tmp_path, *lines)
