# SPDX-License-Identifier: MIT
"""Every row of the verification table within its tolerance, and the means by which the table judges."""

import csv
import math

import numpy as np
import pytest

from tests.verification import table
from tests.verification.cases import (
    cavity,
    clay,
    cryer,
    film_transfer,
    mandel,
    porous_interface,
    stefan_film,
    terzaghi,
    triaxial,
    undrained_column,
)
from tests.verification.rings import Ring, alternation
from tests.verification.rows import HEADINGS, Row, cells, failures, fitted_rate


@pytest.mark.parametrize("name", table.QUICK)
def test_quick_cases(name):
    assert not failures(table.QUICK[name]())


@pytest.mark.slow
@pytest.mark.parametrize("name", table.SLOW | table.LONG)
def test_slow_cases(name):
    assert not failures((table.SLOW | table.LONG)[name]())


@pytest.mark.long
@pytest.mark.parametrize("name", table.LONGEST)
def test_long_cases(name):
    assert not failures(table.LONGEST[name]())


@pytest.mark.parametrize("e", triaxial.TABLE)
def test_triaxial_closed_form_is_the_printed_table(e):
    angle, ratio, strain = triaxial.TABLE[e]
    q, axial, _ = triaxial.closed_form(e)
    assert triaxial.friction_angle(e) == pytest.approx(angle, abs=0.51e-3)
    assert axial == pytest.approx(strain, abs=0.51e-6)
    assert q / triaxial.S3 == pytest.approx(ratio, abs=0.51e-4)


@pytest.mark.parametrize("b", cavity.TABLE)
def test_cavity_closed_form_is_the_printed_table(b):
    pressure, associated = cavity.TABLE[b][0], cavity.TABLE[b][2]
    assert cavity.closed_form(b, 0.0) == pytest.approx((1e3 * pressure, cavity.TABLE[b][1]), rel=2e-5)
    assert cavity.closed_form(b, 30.0) == pytest.approx((1e3 * pressure, associated), rel=2e-5)


@pytest.mark.parametrize("b", clay.SPHERE)
def test_sphere_closed_form_is_the_printed_table(b):
    assert clay.sphere_closed_form(b)[0] == pytest.approx(clay.SPHERE[b], abs=0.51e-5)


@pytest.mark.parametrize("b", clay.CYLINDER)
def test_cylinder_closed_form_is_the_printed_table(b):
    assert clay.cylinder_closed_form(b)[0] == pytest.approx(clay.CYLINDER[b], abs=0.51e-5)


@pytest.mark.parametrize("alpha", [0.5, 0.65, 1.0])
def test_lower_bound_of_the_flow_is_the_printed_number(alpha):
    assert clay.pile_lower_bound(alpha) == pytest.approx(clay.FLOW[alpha][0], abs=0.51e-3)


@pytest.mark.parametrize("time", sorted(terzaghi.SETTLEMENT | terzaghi.BASE_PRESSURE))
def test_terzaghi_series_is_the_printed_table(time):
    degree, base = terzaghi.closed_form(time)
    assert degree == pytest.approx(terzaghi.SETTLEMENT.get(time, degree), abs=0.51e-5)
    assert base == pytest.approx(terzaghi.BASE_PRESSURE.get(time, base), abs=0.51e-5)


def test_terzaghi_series_in_steps_tends_to_the_series():
    steps = np.full(10_000, 0.5 / 10_000)
    assert terzaghi.closed_form(0.5, steps) == pytest.approx(terzaghi.closed_form(0.5), rel=1e-4)


@pytest.mark.parametrize("case", [mandel, cryer])
def test_series_with_a_peak_are_the_printed_tables(case):
    for time, pressure in case.CENTRE.items():
        assert case.closed_form(time) == pytest.approx(pressure, abs=0.51e-4)
    assert case.closed_form(case.PEAK_TIME) == pytest.approx(case.PEAK, abs=0.51e-3)
    around = [case.closed_form(case.PEAK_TIME + step) for step in (-2e-3, 2e-3)]
    assert max(around) < case.closed_form(case.PEAK_TIME)


def test_mandel_series_ends_drained_at_the_side():
    assert mandel.closed_form(0.1, x=1.0) == pytest.approx(0.0, abs=1e-12)


def test_column_with_a_film_of_no_resistance_is_terzaghis():
    for time in (0.05, 0.2, 1.0):
        assert porous_interface.closed_form(time, 1e-9) == pytest.approx(terzaghi.closed_form(time), rel=1e-4)


def test_film_closed_forms_are_the_printed_numbers():
    suction, force = stefan_film.closed_form()
    assert (suction, force) == pytest.approx((stefan_film.PRESSURE, stefan_film.FORCE), rel=1e-3)
    over_film = film_transfer.SPEED / film_transfer.TRANSFER
    assert over_film == pytest.approx(film_transfer.OVER_FILM)


def test_checkerboard_measures_an_alternation_and_no_slope():
    mesh, _ = undrained_column.undrained_pressure(True, 0.0)
    z = mesh.nodes[:, 2]
    levels = np.round(z * undrained_column.CELLS[2]).astype(int)
    assert undrained_column.checkerboard(mesh, 0.1 * z) < 0.002
    assert undrained_column.checkerboard(mesh, 0.1 * (-1.0) ** levels) > 0.03


@pytest.mark.parametrize("ours, reference, tolerance, holds", [
    (1.009, 1.0, 0.01, True),
    (1.011, 1.0, 0.01, False),
    (-0.989, -1.0, 0.01, False),
    (1e-7, 0.0, 1e-6, True),
    (-2e-6, 0.0, 1e-6, False),
    (math.nan, 1.0, 0.01, False),
    (math.nan, 0.0, 0.01, False),
    (2.0, 1.0, None, True),
])  # fmt: skip
def test_row_judges_relative_to_the_reference(ours, reference, tolerance, holds):
    row = Row("case", "quantity", "", ours, reference, "source", tolerance)
    assert row.holds is holds
    assert ("OUT OF TOLERANCE" in cells(row)[4]) is not holds
    assert failures([row]) == ([] if holds else [str(row)])


@pytest.mark.parametrize("limit, ours, holds", [
    ("at most", 5.0, True), ("at most", 5.01, False), ("at most", math.nan, False),
    ("at least", 5.0, True), ("at least", 4.99, False), ("at least", math.nan, False),
])  # fmt: skip
def test_row_judges_by_a_limit(limit, ours, holds):
    row = {"at most": Row.at_most, "at least": Row.at_least}[limit]("case", "quantity", ours, 5.0, "source")
    assert row.holds is holds
    assert ("OUT OF TOLERANCE" in cells(row)[4]) is not holds
    assert cells(row)[3] == f"{limit} 5"
    assert "shown only" not in cells(row)[4]
    assert failures([row]) == ([] if holds else [str(row)])


def _judged(found: float):
    return lambda: (Row("case", "quantity", "m", found, 1.0, "source", 0.01),)


def _broken() -> tuple[Row, ...]:
    raise ValueError("no such thing")


@pytest.mark.parametrize("case, code", [(_judged(1.0), 0), (_judged(1.1), 1), (_broken, 1)])
@pytest.mark.parametrize("options", [[], ["--quick"], ["--markdown"]])
def test_table_exits_1_when_a_row_is_out_or_a_case_fails(monkeypatch, capsys, case, code, options):
    monkeypatch.setattr(table, "QUICK", {"good": _judged(1.0), "one": case})
    monkeypatch.setattr(table, "SLOW", {})
    monkeypatch.setattr(table, "LONG", {"long": _judged(1.0)})
    monkeypatch.setattr(table, "LONGEST", {})
    assert table.main(options) == code
    out, err = capsys.readouterr()
    assert ("long" in err) == ("--quick" not in options)
    assert (out.splitlines()[1] == "| --- | --- | --: | --: | --: | --- |") == ("--markdown" in options)
    assert f"{code} out of tolerance" in err


def test_table_of_one_case_replaces_its_rows_in_a_file(monkeypatch, tmp_path):
    def one(case: str, found: float):
        return lambda: (Row(case, "quantity", "m", found, 1.0, "source", 0.01),)

    for name in ("SLOW", "LONG", "LONGEST"):
        monkeypatch.setattr(table, name, {})
    file = tmp_path / "rows.csv"
    monkeypatch.setattr(table, "QUICK", {"a": one("first", 1.0), "b": one("second", 1.0)})
    assert table.main(["--out", str(file)]) == 0
    monkeypatch.setattr(table, "QUICK", {"a": one("first", 1.001), "b": one("second", 1.002)})
    assert table.main(["--only", "a", "--out", str(file)]) == 0
    with file.open(newline="") as stream:
        found = [(row["case"], float(row["ours_exact"])) for row in csv.DictReader(stream)]
    assert found == [("second", 1.0), ("first", 1.001)]


def test_fitted_rate():
    size = np.array([0.4, 0.2, 0.1])
    assert fitted_rate(size, -3.0 * size**1.7) == pytest.approx(1.7)


def _ring(pressure: np.ndarray, azimuth: np.ndarray) -> Ring:
    return Ring(azimuth, np.maximum(pressure, 0.0), np.where(pressure > 0.0, 0.0, 20e-6))


STATIONS = {
    "nodal": np.linspace(0.0, np.pi, 9),
    "gauss": np.concatenate([np.pi / 8 * (k + np.array([0.5 - 0.5 / 3**0.5, 0.5 + 0.5 / 3**0.5])) for k in range(8)]),
}


@pytest.mark.parametrize("rule", STATIONS)
def test_alternation_does_not_see_a_smooth_ring_or_an_open_side(rule):
    azimuth = STATIONS[rule]
    smooth = _ring(3e4 + 2e4 * np.cos(azimuth), azimuth)
    opened = _ring(1e4 + 2e4 * np.cos(azimuth), azimuth)
    step = _ring(np.where(azimuth < 1.5, 0.0, 5e4 + 1e4 * azimuth), azimuth)
    for ring in (smooth, opened, step):
        found = alternation([ring])
        assert found.swing < 1e-9
        assert (found.isolated, found.widest) == (0, 0.0)


@pytest.mark.parametrize("rule", STATIONS)
def test_alternation_sees_a_swing_from_point_to_point(rule):
    azimuth = STATIONS[rule]
    sign = (-1.0) ** np.arange(len(azimuth))
    found = alternation([_ring(3e4 + 2e4 * np.cos(azimuth) + 1e3 * sign, azimuth)])
    assert found.swing == pytest.approx(4.0 / 30.0, rel=0.35)
    assert found.isolated == 0


@pytest.mark.parametrize("rule", STATIONS)
def test_alternation_sees_one_point_that_stands_out(rule):
    azimuth = STATIONS[rule]
    pressure = np.full(len(azimuth), 3e4)
    pressure[3] += 3e3
    assert alternation([_ring(pressure, azimuth)]).swing == pytest.approx(0.1, rel=0.35)


def test_alternation_counts_open_stations_between_loaded_ones():
    azimuth = STATIONS["nodal"]
    pressure = np.array([5.0, 4.0, 0.0, 3.0, 0.0, 0.0, 2.0, 1.0, 0.0]) * 1e3
    found = alternation([_ring(pressure, azimuth)])
    # the third; the last stands in the symmetry plane, between two images of the one before it
    assert (found.isolated, found.widest) == (1, 20e-6)


def test_rows_are_stored_as_they_are_printed(tmp_path):
    rows = [Row("a, b", "x", "m", 1 / 3, 0.25, "closed form", 0.5), Row("c", "y", "", 2.0, 0.0, "ours", None)]
    table.write_rows(rows, tmp_path / "rows.csv")
    with (tmp_path / "rows.csv").open(newline="", encoding="utf-8") as stream:
        heads, *stored = csv.reader(stream)
    assert heads[:6] == list(HEADINGS)
    assert [tuple(line[:6]) for line in stored] == [cells(row) for row in rows]
    assert [float(line[6]) for line in stored] == [1 / 3, 2.0]
    assert [line[8] for line in stored] == ["0.5", ""]
