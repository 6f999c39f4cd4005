# SPDX-License-Identifier: MIT
"""Load cases from a table: names, loads with units in the headings, directions, limit states, partial factors.

A row is a load; rows of one name act together and are added. `H` acts in the vertical plane of `direction` (an angle in
plan), `M` in that of `M direction` (that of H where not given), with M = H arm for a load above mudline. A case is its
load in the vertical plane of its force, and beside it the moment across that plane and the torsion, for the answer.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from pysprings.core.arrays import Array, Integers, Marks
from pysprings.core.loads import ROUNDING, in_plane
from pysprings.core.tables import Column, Table, one_table
from pysprings.core.tables.files import text_of
from pysprings.core.tables.headings import ANY, TEXT
from pysprings.core.text import MOST_LETTERS, number
from pysprings.core.units import quoted

TEXTS = ("name", "limit_state")
_NAMES = {
    "name": ("case", "load case", "lc", "id", "lastfall"), "limit_state": ("state", "limit state", "grenzzustand"),
    "H_N": ("horizontal", "horizontalkraft"), "M_Nm": ("moment", "biegemoment"), "V_N": ("vertical", "vertikalkraft"),
    "arm_m": ("height", "lever arm", "hebelarm"),
    "direction_rad": ("h direction", "azimuth", "richtung"), "M_direction_rad": (), "tilt_rad": ("tolerance",),
    "factor": (), "factor_H": (), "factor_M": (), "factor_V": (), "T_Nm": ("torsion", "m z", "mz"),
    "Fx_N": ("f x", "h x", "hx"), "Fy_N": ("f y", "h y", "hy"), "Fz_N": ("f z",),
    "Mx_Nm": ("m x",), "My_Nm": ("m y",),
}  # fmt: skip
COLUMNS = (
    *(Column(name, TEXT, _NAMES[name]) for name in TEXTS),
    *(
        replace(Column.named(name, others), example="m" if name == "arm_m" else "")
        for name, others in _NAMES.items()
        if name not in TEXTS
    ),
    Column("remark", ANY, ("remarks", "comment", "comments", "note", "notes", "description"), skipped="words"),
)
_COMPONENTS = ("Fx_N", "Fy_N", "Fz_N", "Mx_Nm", "My_Nm")
_FACTORS = ("factor", "factor_H", "factor_M", "factor_V")
FORMS = "H with M or arm, M alone, V alone, or Fx, Fy, Fz, Mx, My, Mz with z up"
MOST_FACTOR = 10.0
# beyond these the unit of a column is doubtful: unit of the words, its size in SI, range
_COMMON = {"arm_m": ("m", 1.0, 0.1, 500.0), "tilt_rad": ("deg", math.radians(1.0), 0.01, 5.0)}
_TURN = 2.0 * np.pi * (1.0 + 1e-9)


OPPOSED = "M turns against H"


def below_mudline(H: float, M: float) -> str:
    """Return the remark on a moment [N m] that turns against its force [N], as a load below mudline does."""
    return f"{OPPOSED}, as of a load {abs(M / H):.3g} m below mudline"


@dataclass(frozen=True)
class LoadCases:
    """Load cases, n of them, in SI with their partial factors.

    file : of the table.
    name, limit_state : by case; blank where not given.
    line : of the first row of each case.
    H, M : lateral load [N] and moment [N m] about the lid centre, in the plane of `direction`; M = H arm.
    V : vertical load [N], positive down; NaN where not given.
    direction : of the plane [rad], in plan.
    tilt : largest rotation that is tolerated [rad]; NaN where not given.
    across : moment about the direction of H [N m], right-handed with z up: it bends across the plane of H.
    torsion : moment about the vertical axis [N m], right-handed with z up.
    remarks : by case, what the reader did that a user may not expect; blank for nothing.
    """

    file: str
    name: tuple[str, ...]
    limit_state: tuple[str, ...]
    line: Integers
    H: Array
    M: Array
    V: Array
    direction: Array
    tilt: Array
    across: Array
    torsion: Array
    remarks: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.name)

    @property
    def loads(self) -> Array:
        """H and M of each case, (n, 2)."""
        return np.stack([self.H, self.M], axis=1)

    @property
    def lateral(self) -> Marks:
        """Which cases have a lateral load or a moment."""
        return (self.H != 0.0) | (self.M != 0.0) | (self.across != 0.0)

    @property
    def aside(self) -> Marks:
        """Which cases have a moment across the plane of H, or a torsion."""
        return (self.across != 0.0) | (self.torsion != 0.0)

    @property
    def opposed(self) -> Marks:
        """Which cases have an M that turns against H, as a load below mudline does."""
        return self.H * self.M < 0.0

    @property
    def notes(self) -> tuple[str, ...]:
        """What is to be remarked on each case: what the reader did, and an M that turns against H."""
        texts = []
        for text, H, M, opposed in zip(self.remarks, self.H, self.M, self.opposed, strict=True):
            texts.append("; ".join(filter(None, (text, below_mudline(H, M) if opposed else ""))))
        return tuple(texts)

    def twisted(self, radius: float | None) -> Marks:
        """Return which cases have a torsion that `bounded` does not bound: T/R above half of (H, M/D), or R unknown.

        T alone fails by friction on the wall, H by the ground: T/R is below the largest H where T has its own capacity.
        """
        if radius is None:
            return self.torsion != 0.0
        return self.torsion_share(radius) > 1.0

    def torsion_share(self, radius: float) -> Array:
        """Return T over the largest one that `bounded` bounds in a caisson of a radius [m], (n,); inf for T alone."""
        size = np.hypot(radius * self.H, 0.5 * np.hypot(self.M, self.across))
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.torsion != 0.0, np.abs(self.torsion) / (0.5 * size), 0.0)

    def bounded(self, radius: float | None, kept: bool | Marks = False) -> LoadCases:
        """Return the cases in one plane and without torsion, with loads on the safe side, and remarks that say so.

        All of the moment acts in the plane of H and overturns, and T over the radius of the caisson [m] is added to H
        (None: not known, T is left out): a bound in ground that is the same in all directions, but for cases that are
        `twisted`. In cases that are kept (n,) T stays what it is, beside H.
        """
        torsion, way = np.where(kept, self.torsion, 0.0), np.sign(self.H)
        way = np.where(way != 0.0, way, np.where(self.M != 0.0, np.sign(self.M), 1.0))
        aside = (self.across != 0.0) | (self.torsion != torsion)
        added = np.zeros(len(self)) if radius is None else np.abs(self.torsion - torsion) / radius
        H = np.where(aside, way * (np.abs(self.H) + added), self.H)
        M = np.where(aside, way * np.hypot(self.M, self.across), self.M)
        parts = zip(self.across, self.torsion - torsion, added, self.twisted(radius).tolist(), strict=True)
        remarks = tuple(
            "; ".join(filter(None, (text, _bound_words(*each)))) for text, each in zip(self.remarks, parts, strict=True)
        )
        return replace(self, H=H, M=M, across=np.zeros(len(self)), torsion=torsion, remarks=remarks)


def _bound_words(across: float, torsion: float, added: float, twisted: bool) -> str:
    """Return words on the loads of a bound: moment across the plane of H, torsion [N m], and what it adds to H [N]."""
    share = f"T/R = {number(1e-3 * added)} kN on H" if added else "left out, the radius is not known"
    texts = (
        f"moment across of {number(1e-3 * abs(across))} kN m turned into the plane of H" if across else "",
        f"torsion of {number(1e-3 * abs(torsion))} kN m as {share}{', no bound: T governs' * twisted}"
        if torsion
        else "",
    )
    return ", ".join(filter(None, texts))


def read_load_cases(path: str | os.PathLike[str]) -> LoadCases:
    """Read load cases from a CSV file or an Excel workbook with one sheet of them.

    Raises UserInputError: every fault of the table, each with file, line and column.
    """
    table = one_table(Path(path), COLUMNS, "load cases")
    if not table.head:
        table.fault(None, None, f"holds no table: expected a heading and a row a load ({FORMS})")
    _check_columns(table)
    table.stop_at_head()
    texts = {name: table.texts(name) for name in TEXTS}
    values = {column.name: table.numbers(column.name) for column in COLUMNS if column.unit not in (TEXT, ANY)}
    if not len(table):
        table.fault(None, None, "no rows")
    _check_texts(table, texts)
    for k in range(len(table)):
        _check_row(table, {name: column[k] for name, column in values.items()}, k)
    _check_blanks(table, values)
    table.faults.stop()
    cases = _added(table, texts, values)
    table.faults.stop()
    return cases


def _check_texts(table: Table, texts: dict[str, list[str]]) -> None:
    """Note texts that a spreadsheet would read as a formula, or that cannot be printed."""
    for name, column in texts.items():
        for k, text in enumerate(column):
            if text.startswith(tuple("=+-@")) or len(text) > MOST_LETTERS or not text.isprintable():
                rule = f"a name has at most {MOST_LETTERS} characters, the first none of = + - @"
                table.fault(k, name, f"{quoted(text)}: {rule}")
    for k, text in enumerate(texts["name"]):
        if not text and any(texts["name"]):
            table.fault(k, "name", "blank: write the name in every row (rows of one name act together)")


def _check_columns(table: Table) -> None:
    """Note loads that are missing or given twice by the columns of a table."""
    if table.faults.problems:
        return
    if not any(name in table for name in ("H_N", "M_Nm", "V_N", "T_Nm", *_COMPONENTS)):
        table.fault(None, None, f"no column with a load: expected {FORMS}")
    if "arm_m" in table and not any(name in table for name in ("H_N", "Fx_N", "Fy_N")):
        table.fault(None, "arm_m", "a height without H")
    for one, others in (("H_N", ("Fx_N", "Fy_N")), ("M_Nm", ("Mx_Nm", "My_Nm")), ("V_N", ("Fz_N",))):
        for other in others:
            if one in table and other in table:
                table.fault(None, other, f"gives what {quoted(table.key(one))} gives, too: keep one of them")
    if "direction_rad" in table and "H_N" not in table and any(name in table for name in ("Fx_N", "Fy_N")):
        table.fault(None, "direction_rad", "components have the axes x and y: they need no direction")
    if "factor" in table and any(name in table for name in _FACTORS[1:]):
        table.fault(None, "factor", "give either one factor on H, M and V, or factor H, factor M and factor V")


def _check_row(table: Table, row: dict[str, float], k: int) -> None:
    """Note blank loads, moments that are given twice, factors and tolerances that are not positive."""
    given = {name for name, value in row.items() if np.isfinite(value)}
    force, moment = given & {"H_N", "Fx_N", "Fy_N"}, given & {"M_Nm", "Mx_Nm", "My_Nm"}
    clean = not any(each.line == table.lines[k] for each in table.faults.problems)
    if clean and not force | moment | given & {"V_N", "Fz_N", "T_Nm"}:
        table.fault(k, None, f"no load: expected {FORMS}")
    if "arm_m" in given and moment:
        table.fault(k, "arm_m", "give either a moment or the height of H, not both (M = H arm): M is about the lid "
                    "centre; one at a height h becomes M + H h, Mx - Fy h, My + Fx h")  # fmt: skip
    if "arm_m" in given and not force and clean:
        table.fault(k, "arm_m", "a height without H")
    for name in _FACTORS:
        if row[name] < 0.0:
            table.fault(k, name, f"{row[name]:g} is negative: a partial factor is 0 or more")
        if row[name] > MOST_FACTOR:
            table.fault(k, name, f"{row[name]:g} is above {MOST_FACTOR:g}: 1.35 is usual, not 135")
    for name in ("direction_rad", "M_direction_rad"):
        if abs(row[name]) > _TURN:
            table.fault(k, name, f"{np.degrees(row[name]):.6g} deg is beyond one turn, 360 deg")
    if row["tilt_rad"] <= 0.0:
        table.fault(k, "tilt_rad", "a tolerance must be positive")


def _check_blanks(table: Table, values: dict[str, Array]) -> None:
    """Note blanks that would count as zero: the height or direction of a force that other rows have, a component."""
    for k in range(len(table)):
        force = any(np.nan_to_num(values[name][k]) != 0.0 for name in ("H_N", "Fx_N", "Fy_N"))
        moment = any(np.isfinite(values[name][k]) for name in ("M_Nm", "Mx_Nm", "My_Nm"))
        blank = [name for name in _COMPONENTS if name in table and np.isnan(values[name][k])]
        if force and not moment and np.isnan(values["arm_m"][k]):
            blank += [name for name in ("arm_m", "M_Nm") if name in table][:1]
        if (force or moment) and np.isfinite(values["direction_rad"]).any() and np.isnan(values["direction_rad"][k]):
            blank.append("direction_rad")
        for name in blank:
            table.fault(k, name, "blank: write 0 where it is none")


def _added(table: Table, texts: dict[str, list[str]], values: dict[str, Array]) -> LoadCases:
    """Return the cases: factored loads of one name, added as vectors."""
    groups: dict[str, list[int]] = {}
    for k, name in enumerate(texts["name"]):
        groups.setdefault(name or f"row {table.lines[k]}", []).append(k)
    loads, remarks = _factored(values)
    cases = []
    for name, rows in groups.items():
        state = _one_text(table, texts["limit_state"], rows)
        tilt = np.unique(values["tilt_rad"][rows][np.isfinite(values["tilt_rad"][rows])])
        if tilt.size > 1:
            table.fault(rows[1], "tilt_rad", f"rows of case '{name}' differ in their tolerance")
        H, M, across, direction = _in_plane(rows, loads)
        V = np.nan if np.isnan(loads["V"][rows]).all() else math.fsum(np.nan_to_num(loads["V"][rows]))
        numbers = (H, M, V, direction, float(tilt[0]) if tilt.size else np.nan, across, math.fsum(loads["T"][rows]))
        alike = [f"'{each}' is another case" for each in groups if each != name and each.lower() == name.lower()]
        words = [*(remarks[k] for k in rows), *_twice(table, rows), *alike]
        remark = "; ".join(dict.fromkeys(word for word in words if word))
        cases.append((name, state, int(table.lines[rows[0]]), *numbers, remark))
    columns = list(zip(*cases, strict=True))
    names = ("H", "M", "V", "direction", "tilt", "across", "torsion")
    arrays = {each: np.array(column, dtype=float) for each, column in zip(names, columns[3:10], strict=True)}
    lines = np.array(columns[2], dtype=np.int64)
    return LoadCases(table.place, columns[0], columns[1], line=lines, remarks=columns[10], **arrays)


def _twice(table: Table, rows: Sequence[int]) -> Iterator[str]:
    """Yield a remark on rows of one case that are the same in every cell: each of them counts."""
    first: dict[tuple[str, ...], int] = {}
    for k in rows:
        same = first.setdefault(tuple(text_of(cell) for cell in table.rows[k]), k)
        if same != k:
            yield f"the rows {table.lines[same]} and {table.lines[k]} are the same, and both count"


def _factored(values: dict[str, Array]) -> tuple[dict[str, Array], list[str]]:
    """Return loads of each row with their factors (V: NaN where there is none), and remarks by row.

    H and M are signed sizes in the planes of H_plane and M_plane [rad]. The moment of a force has the factor of the
    force: M = H arm, and M or T beside `factor H` without `factor M`.
    """
    by = {name: values[f"factor_{name}"] for name in "HMV"}
    given = {name: np.nan_to_num(column) for name, column in values.items()}
    moments = [given[name] != 0.0 for name in ("M_Nm", "T_Nm", "Mx_Nm", "My_Nm")]
    own = np.nan_to_num(by["H"], nan=1.0) != by["M"]
    unused = np.isfinite(by["M"]) & own & ~np.any(moments, axis=0) & (given["arm_m"] != 0.0)
    taken = np.isnan(by["M"]) & np.isfinite(by["H"]) & (by["H"] != 1.0) & np.any(moments, axis=0)
    by["M"] = np.where(np.isnan(by["M"]), by["H"], by["M"])
    one = np.nan_to_num(values["factor"], nan=1.0)
    H, M, V = (np.nan_to_num(by[name], nan=1.0) * one for name in "HMV")
    towards = given["direction_rad"]
    turning = np.where(np.isnan(values["M_direction_rad"]), towards, given["M_direction_rad"])
    force = _vector(given["H_N"], towards) + np.stack([given["Fx_N"], given["Fy_N"]], axis=1)
    # in planes of bending: My bends in that of x, -Mx in that of y, as forces at a height do
    bending = _vector(given["M_Nm"], turning) + np.stack([given["My_Nm"], -given["Mx_Nm"]], axis=1)
    bending = bending * M[:, None] + force * (given["arm_m"] * H)[:, None]
    down = np.where(np.isnan(values["V_N"]), -values["Fz_N"], values["V_N"])
    loads = {"H": force * H[:, None], "M": bending, "V": down * V, "T": given["T_Nm"] * M}
    loads["plane"] = np.where(force.any(axis=1), towards, turning)
    loads["has_plane"] = np.where((given["Fy_N"] == 0.0) & (given["Mx_Nm"] == 0.0), 1.0, 0.0)
    none = {"H_N": 0, "factor": 1, "factor_H": 1, "factor_V": 1}
    left = {name: np.isfinite(values[name]).any() & np.isnan(values[name]) for name in none}
    beside = {"H_N": np.any(moments, axis=0), "factor_H": force.any(axis=1), "factor_V": np.isfinite(down)}
    left |= {name: left[name] & rows for name, rows in beside.items()}
    idle = np.isfinite(by["V"]) & (by["V"] != 1.0) & np.isnan(down)
    odd, remarks = _odd(values), []
    for k, each in enumerate(taken):
        words = [f"factor H {values['factor_H'][k]:g} multiplies the moment, too (no factor M)"] if each else []
        words += ["factor M is not used: the moment of H at its height has the factor of H"] if unused[k] else []
        words += ["factor V is not used: V is blank"] if idle[k] else []
        blank = [name for name, rows in left.items() if rows[k]]
        words += [f"{name.removesuffix('_N').replace('_', ' ')} is blank: {none[name]}" for name in blank]
        remarks.append("; ".join([*words, *odd[k]]))
    return loads, remarks


def _odd(values: dict[str, Array]) -> list[list[str]]:
    """Return remarks by row on a V that is a pull in all rows, and on arms and tolerances of an unusual size."""
    texts: list[list[str]] = [[] for _ in values["V_N"]]
    for name, sign, words in (("Fz_N", 1.0, "Fz counts upwards"), ("V_N", -1.0, "V is positive down")):
        given = np.isfinite(values[name])
        if given.any() and (sign * values[name][given]).min() > 0.0:
            for k in np.flatnonzero(given):
                texts[k].append(f"V is a pull, as in all rows: {words}")
    for name, (unit, scale, low, high) in _COMMON.items():
        size = np.abs(values[name]) / scale
        for k in np.flatnonzero((size > 0.0) & ((size < low) | (size > high * (1.0 + 1e-9)))):
            common = f"outside the common range {low:g} to {high:g} {unit}: is its unit right?"
            texts[k].append(f"{name.split('_')[0]} is {size[k]:.3g} {unit}, {common}")
    return texts


def _vector(size: Array, angle: Array) -> Array:
    return size[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _one_text(table: Table, given: list[str], rows: Sequence[int]) -> str:
    texts = list(dict.fromkeys(given[k] for k in rows if given[k]))
    if len(texts) > 1:
        table.fault(rows[1], "limit_state", f"rows of one case differ: {', '.join(texts)}")
    return texts[0] if texts else ""


def _in_plane(rows: Sequence[int], loads: dict[str, Array]) -> tuple[float, ...]:
    """Return H, M, the moment about the direction of H, and that direction, of the sum of some rows.

    Rows of one direction keep it; else it is that of the sum of H (H > 0), or, without H, that of the moment.
    """
    H, M = (np.array([math.fsum(column) for column in loads[name][rows].T]) for name in ("H", "M"))
    sizes = {name: math.fsum(np.hypot(*loads[name][rows].T)) for name in ("H", "M")}
    acting, plane = [k for k in rows if loads["H"][k].any() or loads["M"][k].any()], None
    planes = set(loads["plane"][acting].tolist())
    if len(planes) == 1 and loads["has_plane"][acting].all():
        (angle,) = planes
        plane = np.array([[np.cos(angle), np.sin(angle)]])
    least = ROUNDING * np.array([[sizes["H"], sizes["M"]]])
    (row,) = zip(*vars(in_plane(H[None], M[None], least, plane)).values(), strict=True)
    return tuple(map(float, row))
