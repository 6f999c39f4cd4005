# SPDX-License-Identifier: MIT
"""Tables of load cases: units, directions, partial factors, sums of loads, and every fault with its place."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import openpyxl
import pytest

from pysprings.core.errors import UserInputError
from pysprings.results.tables.load_cases import LoadCases, read_load_cases


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
    european = table(tmp_path, "case;limit state;H [MN];height [m];V [MN];tilt [deg]", "storm;ULS;2,5;20;3;0,25")
    for name in ("H", "M", "V", "direction", "tilt"):
        np.testing.assert_allclose(getattr(european, name), getattr(plain, name), rtol=1e-14)
    assert (plain.name, plain.limit_state, plain.line.tolist()) == (("storm",), ("ULS",), [2])
    assert (plain.H[0], plain.M[0], plain.V[0]) == (2.5e6, -50e6, 3e6)


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
    np.testing.assert_allclose(cases.M, [-(135e3 * 50 + 360e3 * 10) - 1.1e6, -10e3])
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
    np.testing.assert_allclose(cases.M, [-np.sqrt(2) * 2e6, -1e6, 5e5], rtol=1e-12)
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
    np.testing.assert_allclose(np.abs(cases.bounded(None).H), np.abs(cases.H))


def test_the_factor_of_a_force_is_that_of_its_moment(tmp_path: Path) -> None:
    head = "name,H [kN],M [kN m],T [kN m],factor H"
    cases = table(tmp_path, head, "a,1000,-2000,10,1.35", "b,1000,-2000,10,")
    np.testing.assert_allclose(cases.H, [1350e3, 1000e3])
    np.testing.assert_allclose(cases.M, [-2700e3, -2000e3])
    np.testing.assert_allclose(cases.torsion, [13.5e3, 10e3])
    assert cases.remarks == ("factor H 1.35 multiplies the moment, too (no factor M)", "")


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
        "2: arm [m]: give either a moment or the height of H, not both (M = -H arm)",
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
    ],
)  # fmt: skip
def test_tables_that_are_refused(tmp_path: Path, lines: tuple[str, ...], found: str) -> None:
    assert found in problems(tmp_path, *lines)
