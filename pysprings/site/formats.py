# SPDX-License-Identifier: MIT
"""Cone penetration tests in GEF, AGS 4 and XML of the Dutch BRO: plain readers, which need no further package.

GEF is a header and columns, AGS a CSV file of groups, and one element of the XML holds all rows: reading them takes a
page each. pygef would bring polars (172 MB), python-ags4 holds pandas below 3.
"""

import csv
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from pysprings.core.arrays import Array
from pysprings.core.errors import Problem, UserInputError
from pysprings.core.text import one_line
from pysprings.core.units import quoted
from pysprings.scene.defaults import wrong_value
from pysprings.scene.profile_table import WATER
from pysprings.site.sounding import Sounding, sounding, usable

MOST_FAULTS = 5  # rows of a file that are named
MOST_NAMED = 200  # characters of a description
_DEPTHS = re.compile(r"^[\d.]+ ?m to [\d.]+ ?m[ :-]*")  # before it
_UNITS = {
    "m": 1.0, "cm": 1e-2, "mm": 1e-3, "mpa": 1e6, "mn/m2": 1e6, "n/mm2": 1e6, "kpa": 1e3, "kn/m2": 1e3, "pa": 1.0,
    "bar": 1e5, "%": 1e-2,
}  # fmt: skip
_LENGTHS, _EXPECTED = ("m", "cm", "mm"), {"depth": "m", "Rf": "%"}


def refused(path: Path, message: str, line: int | None = None) -> UserInputError:
    """Return the error for one fault of a file."""
    return UserInputError([Problem(str(path), line, message=message)])


def _scale(path: Path, channel: str, unit: str, line: int, what: str) -> float:
    """Return the factor to SI of a unit, whose word may be followed by its meaning; refuse one of another kind."""
    word = unit.replace("²", "2").split("(")[0].split()[:1]
    name = word[0].lower() if word else ""
    kind = "m" if name in _LENGTHS else name if name == "%" else "MPa"
    expected = _EXPECTED.get(channel, "MPa")
    if name not in _UNITS or kind != expected:
        raise refused(path, f"{what}: the unit is {quoted(unit)}, expected one such as {expected}", line)
    return _UNITS[name]


# --- GEF ---

# quantities of GEF-CPT-Report by channel; the corrected depth comes before the length of the rods
_GEF = {"depth": (11, 1), "qc": (2,), "qt": (13,), "fs": (3,), "Rf": (4,), "u2": (6,)}


def read_gef(path: Path, text: str) -> list[Sounding]:
    """Return the test of a GEF file, of any version.

    Raises UserInputError: a file of another kind, without the columns of depth and cone resistance, or rows that are no
    numbers.
    """
    lines = text.splitlines()
    end = next((k for k, line in enumerate(lines) if line.upper().startswith("#EOH")), None)
    if end is None:
        raise refused(path, "has no line #EOH: it is no GEF file, or not all of it")
    head = [(k + 1, match[1].upper(), [part.strip() for part in match[2].split(",")])
            for k, line in enumerate(lines[:end]) if (match := re.match(r"#\s*(\w+)\s*=\s*(.*)", line))]  # fmt: skip
    for line, key, parts in head:
        if key in ("PROCEDURECODE", "REPORTCODE") and "CPT" not in parts[0].upper():
            raise refused(path, f"is a GEF file of the kind {quoted(parts[0])}, no CPT", line)
    columns = _gef_columns(path, head)
    first = {key: parts[0] for _, key, parts in reversed(head)}
    rows = _gef_rows(path, lines, end + 1, first, max(at for at, _ in columns.values()))
    voids = {number - 1: _number(text, np.nan) for number, text in _numbered(head, "COLUMNVOID").items()}
    given = {}
    for channel, (at, scale) in columns.items():
        values = rows[:, at]
        given[channel] = np.where(values == voids.get(at, np.nan), np.nan, values) * scale
    measured = _numbered(head, "MEASUREMENTVAR")
    return [sounding(str(path), first.get("TESTID", path.stem), given, _number(measured.get(3)) or None,
                     _number(measured.get(13)))]  # fmt: skip


def _numbered(head: Sequence[tuple[int, str, list[str]]], key: str) -> dict[int, str]:
    """Return the second part of the lines of a key by their number."""
    return {
        int(parts[0]): parts[1] for _, name, parts in head if name == key and len(parts) > 1 and parts[0].isdecimal()
    }


def _gef_columns(path: Path, head: Sequence[tuple[int, str, list[str]]]) -> dict[str, tuple[int, float]]:
    """Return place and factor to SI of each channel."""
    infos = {int(parts[3]): (line, int(parts[0]) - 1, parts[1]) for line, key, parts in head
             if key == "COLUMNINFO" and len(parts) > 3 and parts[0].isdecimal() and parts[3].isdecimal()}  # fmt: skip
    columns = {}
    for channel, quantities in _GEF.items():
        number = next((each for each in quantities if each in infos), None)
        if number is not None:
            line, at, unit = infos[number]
            columns[channel] = (at, _scale(path, channel, unit, line, f"COLUMNINFO {at + 1}"))
    if "depth" not in columns or not {"qc", "qt"} & set(columns):
        raise refused(path, "has no column of depth (quantity 1 or 11) and cone resistance (2 or 13) in #COLUMNINFO")
    return columns


def _gef_rows(path: Path, lines: Sequence[str], start: int, head: dict[str, str], last: int) -> Array:
    """Return the rows below the header (n, columns)."""
    record, separator = head.get("RECORDSEPARATOR", "!") or "!", head.get("COLUMNSEPARATOR") or None
    rows: list[list[float]] = []
    wrong = []
    for k, line in enumerate(lines[start:], start=start + 1):
        cells = [cell.strip() for cell in line.replace(record, "").strip().split(separator)]
        if not any(cells):
            continue
        try:
            rows.append([float(cell) for cell in cells[: last + 1]])
        except ValueError:
            wrong.append(Problem(str(path), k, message=f"{quoted(line.strip())} is no row of numbers"))
            continue
        if len(rows[-1]) <= last:
            message = f"the row has {len(rows.pop())} values, the columns of the header need {last + 1}"
            wrong.append(Problem(str(path), k, message=message))
    if wrong:
        raise UserInputError(wrong[:MOST_FAULTS])
    return np.array(rows).reshape(-1, last + 1)


def _number(text: str | None, default: float = 0.0) -> float:
    try:
        return float(text or default)
    except ValueError:
        return default


# --- AGS 4 ---

_AGS = {"depth": "SCPT_DPTH", "qc": "SCPT_RES", "qt": "SCPT_QT", "fs": "SCPT_FRES", "Rf": "SCPT_FRR", "u2": "SCPT_PWP2"}


_PRESSURE, _ANGLE, _WEIGHT = (
    {"kpa": 1e3, "kn/m2": 1e3, "mpa": 1e6},
    {"deg": np.pi / 180},
    {"kn/m3": 1e3, "mg/m3": 9.81e3},
)
# group, heading of the value, key of a scene, factors to SI, what is taken off: the weight of water. Of the AGS 4
# dictionary: TRIT is triaxial tests of total stress (UU), TREG those of effective stress, with phi alone as strength
_AGS_VALUES = (
    ("TRIT", "TRIT_CU", "undrained_shear_strength", _PRESSURE, 0.0),
    ("TREG", "TREG_PHI", "friction_angle_final", _ANGLE, 0.0),
    ("LDEN", "LDEN_BDEN", "effective_unit_weight", _WEIGHT, WATER),
)  # fmt: skip
Groups = dict[str, tuple[list[str], list[str], list[tuple[int, list[str]]]]]


def read_ags(path: Path, text: str) -> Groups:
    """Return the groups of an AGS 4 file: headings, units, rows with their lines.

    Raises UserInputError: AGS 3, or a file without tests, laboratory tests and layers that are read.
    """
    if text.lstrip().startswith('"**'):
        raise refused(path, "is an AGS 3 file: save it as AGS 4, or its group STCN as CSV")
    try:
        groups = dict(_ags_groups(text))
    except csv.Error as error:
        raise refused(path, f"is no AGS file ({error})") from None
    known = ("SCPT", "GEOL", *dict.fromkeys(each[0] for each in _AGS_VALUES))
    if set(known).isdisjoint(groups):
        raise refused(
            path, f"holds none of the groups {', '.join(known)}; its groups are {', '.join(groups) or 'none'}"
        )
    return groups


def ags_points(path: Path, groups: Groups) -> tuple[Array, dict[str, Array]]:
    """Return depths (n,) below mudline [m] and values (n,) by key in SI of laboratory tests: triaxial tests, densities.

    Raises UserInputError: units that are not known, cells that are no numbers.
    """
    depths, found = [], []
    for group, name, key, factors, less in _AGS_VALUES:
        head, units, rows = groups.get(group, ([], [], []))
        if not rows or not {name, "SPEC_DPTH"} <= set(head):
            continue
        unit = units[head.index(name)].strip().lower() if head.index(name) < len(units) else ""
        if unit not in factors:
            raise refused(
                path, f"{name}: the unit is {quoted(unit)}, expected one of {', '.join(factors)}", _line_of(units)
            )
        values = factors[unit] * _ags_column(path, head, head.index(name), rows) - less
        wrong = [
            Problem(str(path), line, key=name, message=text)
            for (line, _), value in zip(rows, values.tolist(), strict=True)
            if np.isfinite(value) and (text := wrong_value(key, value))
        ]
        if wrong:
            raise UserInputError(wrong)
        depths.append(_ags_column(path, head, head.index("SPEC_DPTH"), rows))
        found.append((key, values))
    depth = np.concatenate(depths) if depths else np.empty(0)
    out = {key: np.full(depth.shape, np.nan) for key, _ in found}
    ends = np.cumsum([0, *(len(each) for each in depths)])
    for k, (key, values) in enumerate(found):
        out[key][ends[k] : ends[k + 1]] = values
    return depth, {key: values for key, values in out.items() if np.isfinite(values).any()}


def ags_layers(path: Path, groups: Groups) -> list[tuple[int, float, float, str]]:
    """Return line, top and bottom [m] and description of the layers of a borehole; none of several boreholes."""
    head, _, rows = groups.get("GEOL", ([], [], []))
    if not rows or not {"LOCA_ID", "GEOL_TOP", "GEOL_BASE", "GEOL_DESC"} <= set(head):
        return []
    if len({cells[head.index("LOCA_ID")] for _, cells in rows}) > 1:
        return []
    tops, bottoms = (_ags_column(path, head, head.index(name), rows) for name in ("GEOL_TOP", "GEOL_BASE"))
    names = [_DEPTHS.sub("", one_line(cells[head.index("GEOL_DESC")]))[:MOST_NAMED] for _, cells in rows]
    lines = zip((line for line, _ in rows), tops.tolist(), bottoms.tolist(), names, strict=True)
    return [each for each in lines if each[2] > each[1]]


def ags_soundings(path: Path, groups: Groups) -> list[Sounding]:
    """Return the cone penetration tests (groups SCPG, SCPT), one a location: its pushes are joined.

    Raises UserInputError: headings without depth and cone resistance, wrong units, cells that are no numbers.
    """
    if "SCPT" not in groups:
        return []
    head, units, rows = groups["SCPT"]
    columns = {channel: head.index(name) for channel, name in _AGS.items() if name in head}
    if "depth" not in columns or not {"qc", "qt"} & set(columns) or not rows:
        raise refused(path, "the group SCPT needs SCPT_DPTH and SCPT_RES, and rows of DATA")
    scales = {channel: _scale(path, channel, units[at] if at < len(units) else "", _line_of(units), head[at])
              for channel, at in columns.items()}  # fmt: skip
    ratios = _ags_ratios(groups)
    by_location: dict[str, list[tuple[int, list[str]]]] = {}
    place = head.index("LOCA_ID") if "LOCA_ID" in head else None
    for line, cells in rows:
        by_location.setdefault(cells[place] if place is not None else path.stem, []).append((line, cells))

    def test(name: str, own: Sequence[tuple[int, list[str]]]) -> Sounding:
        given = {channel: scale * _ags_column(path, head, columns[channel], own) for channel, scale in scales.items()}
        return sounding(str(path), name, given, ratios.get(name))

    return usable(partial(test, *each) for each in by_location.items())


def _ags_groups(text: str) -> Iterator[tuple[str, tuple[list[str], list[str], list[tuple[int, list[str]]]]]]:
    """Yield name, headings, units (behind their line) and rows of DATA, with their lines, of each group."""
    reader = csv.reader(text.splitlines())
    name, head, units = "", [""], [""]
    rows: list[tuple[int, list[str]]] = []
    for cells in reader:
        kind = cells[0] if cells else ""
        if kind == "GROUP":
            if name:
                yield name, (head, units, rows)
            name, head, units, rows = cells[1] if len(cells) > 1 else "", [""], [""], []
        elif kind == "HEADING":
            head = cells
        elif kind == "UNIT":
            units = [str(reader.line_num), *cells[1:]]
        elif kind == "DATA":
            rows.append((reader.line_num, cells + [""] * (len(head) - len(cells))))
    if name:
        yield name, (head, units, rows)


def _line_of(units: Sequence[str]) -> int:
    return int(units[0]) if units[0].isdecimal() else 1


def _ags_ratios(groups: Groups) -> dict[str, float]:
    """Return the area ratio of the cone by location."""
    head, _, rows = groups.get("SCPG", ([], [], []))
    if not {"LOCA_ID", "SCPG_CAR"} <= set(head):
        return {}
    pairs = ((cells[head.index("LOCA_ID")], _number(cells[head.index("SCPG_CAR")])) for _, cells in rows)
    return {name: ratio for name, ratio in pairs if ratio}


def _ags_column(path: Path, head: Sequence[str], at: int, rows: Sequence[tuple[int, list[str]]]) -> Array:
    out, wrong = [], []
    for line, cells in rows:
        try:
            out.append(float(cells[at]) if cells[at].strip() else np.nan)
        except ValueError:
            wrong.append(Problem(str(path), line, key=head[at], message=f"{quoted(cells[at])} is not a number"))
    if wrong:
        raise UserInputError(wrong[:MOST_FAULTS])
    return np.array(out)


# --- XML of the BRO ---

_BRO = {"qc": "coneResistance", "qt": "correctedConeResistance", "fs": "localFriction", "Rf": "frictionRatio",
        "u2": "porePressureU2"}  # fmt: skip
_BRO_VOID = -999999.0


def read_bro(path: Path, raw: bytes) -> list[Sounding]:
    """Return the tests of an XML file of the Dutch registry of the subsurface (BRO); its stresses are in MPa.

    Raises UserInputError: no XML, or no cone penetration test in it.
    """
    try:
        root = ElementTree.fromstring(raw)
    except ElementTree.ParseError as error:
        raise refused(path, f"is no well-formed XML ({error})", error.position[0]) from None
    except (LookupError, ValueError) as error:  # of its encoding
        raise refused(path, f"is no XML that can be read ({error})", 1) from None
    for each in root.iter():
        each.tag = each.tag.rpartition("}")[2]
    tests = [each for each in root.iter("CPT_O") if each.find(".//cptResult/values") is not None]
    if not tests:
        raise refused(path, f"holds no cone penetration test of the BRO (CPT_O with cptResult): its root is {root.tag}")
    return usable(partial(_bro_test, path, each) for each in tests)


def _bro_test(path: Path, test: ElementTree.Element) -> Sounding:
    names = [each.tag for each in test.iterfind(".//parameters/*")]
    encoding = test.find(".//cptResult//TextEncoding")
    marks = {} if encoding is None else encoding.attrib
    block, token = marks.get("blockSeparator", ";"), marks.get("tokenSeparator", ",")
    text = test.findtext(".//cptResult/values") or ""
    rows = [row.split(token) for row in text.strip().split(block) if row.strip()]
    try:
        values = np.array(rows, dtype=float)
    except ValueError:
        values = np.empty((0, 0))
    if "coneResistance" not in names or values.ndim != 2 or values.shape[1:] != (len(names),):
        raise refused(path, f"its rows do not have the {len(names)} values that its element parameters lists")
    values[values == _BRO_VOID] = np.nan
    column = {name: values[:, k] for k, name in enumerate(names)}
    given = {
        channel: column[name] * (0.01 if channel == "Rf" else 1e6) for channel, name in _BRO.items() if name in column
    }
    depth, length = (column.get(each, np.full(len(values), np.nan)) for each in ("depth", "penetrationLength"))
    given["depth"] = np.where(np.isfinite(depth), depth, length)
    name = test.findtext("broId") or path.stem
    ratio, drilled = (_number(test.findtext(f".//{each}")) for each in ("coneSurfaceQuotient", "predrilledDepth"))
    return sounding(str(path), name, given, ratio or None, drilled)
