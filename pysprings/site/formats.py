# SPDX-License-Identifier: MIT
"""Cone penetration tests in GEF, AGS 4 and XML of the Dutch BRO: plain readers, which need no further package.

GEF is a header and columns, AGS a CSV file of groups, and one element of the XML holds all rows: reading them takes a
page each. pygef would bring polars (172 MB), python-ags4 holds pandas below 3.
"""

import csv
import re
import warnings
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from pysprings.core.arrays import Array
from pysprings.core.errors import Problem, UserInputError
from pysprings.core.tables import Faults, TableNote
from pysprings.core.text import one_line
from pysprings.core.units import quoted
from pysprings.scene.defaults import wrong_value
from pysprings.scene.profile_table import WATER
from pysprings.site.sounding import ANOTHER_LEVEL, Sounding, sounding, usable

MOST_NAMED, MOST_PLACES = 200, 5  # characters of a description; locations that are named
_DEPTHS = re.compile(r"^[\d.]+ ?m to [\d.]+ ?m[ :-]*")  # before it
_UNITS = {
    "m": 1.0, "cm": 1e-2, "mm": 1e-3, "mpa": 1e6, "mn/m2": 1e6, "n/mm2": 1e6, "kpa": 1e3, "kn/m2": 1e3, "pa": 1.0,
    "bar": 1e5, "%": 1e-2,
}  # fmt: skip
_LENGTHS, _EXPECTED = ("m", "cm", "mm"), {"depth": "m", "length": "m", "Rf": "%"}
LEAST_OFF, MOST_OFF = 0.01, 0.5  # m, between depth and length of the rods: stated; where they begin: refused


def refused(path: Path, message: str, line: int | None = None) -> UserInputError:
    """Return the error for one fault of a file."""
    return UserInputError([Problem(str(path), line, message=message)])


def _scale(faults: Faults, path: Path, channel: str, unit: str, line: int, what: str) -> float:
    """Return the factor to SI of a unit, whose word may be followed by its meaning; note one of another kind."""
    word = unit.replace("²", "2").split("(")[0].split()[:1]
    name = word[0].lower() if word else ""
    kind = "m" if name in _LENGTHS else name if name == "%" else "MPa"
    expected = _EXPECTED.get(channel, "MPa")
    if name not in _UNITS or kind != expected:
        faults.add((str(path), line), what, f"the unit is {quoted(unit)}, expected one such as {expected}")
    return _UNITS.get(name, np.nan)


def _along(depth: Array, length: Array, tilt: Array) -> tuple[Array, list[str]]:
    """Return depths (n,) in m and a note: those of a file, else the length of the rods (m) along their tilt (rad).

    A tilt that is not known, or beyond a right angle, is none. Where depths are negative the lengths become so, too.
    """
    steps = np.nan_to_num(np.diff(length, prepend=length[:1]))
    off = np.cumsum(steps * (1.0 - np.cos(np.where(np.abs(tilt) < np.pi / 2.0, tilt, 0.0))))
    own, both = ~np.isfinite(depth) & np.isfinite(length), np.isfinite(depth * length)
    most = float(np.abs(off)[own].max(initial=0.0))
    note = f"depths follow from the length of the rods and their inclination, {most:.2g} m less at the most"
    along = (length - off) * (-1.0 if both.any() and np.median((depth * length)[both]) < 0.0 else 1.0)
    return np.where(own, along, depth), [note] * (most >= LEAST_OFF)


# --- GEF ---

# quantities of GEF-CPT-Report by channel; tilts, the resultant and its parts, are in degrees
_GEF = {"depth": 11, "length": 1, "qc": 2, "qt": 13, "fs": 3, "Rf": 4, "u2": 6, "tilt": 8, "tilt x": 9, "tilt y": 10}


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
    faults = Faults()
    columns = _gef_columns(path, head, faults)
    first = {key: parts[0] or ",".join(parts) for _, key, parts in reversed(head)}  # a separator may be the comma
    rows = _gef_rows(path, lines, end + 1, first, max(at for at, _ in columns.values()), faults)
    voids = {number - 1: _number(text, np.nan) for number, text in _numbered(head, "COLUMNVOID").items()}
    given = dict.fromkeys(_GEF, np.full(len(rows), np.nan))
    for channel, (at, scale) in columns.items():
        values = rows[:, at]
        given[channel] = np.where(values == voids.get(at, np.nan), np.nan, values) * scale
    parts = np.hypot(*(np.nan_to_num(given[each]) for each in ("tilt x", "tilt y")))
    tilt = np.where(np.isfinite(given["tilt"]), given["tilt"], parts)
    _refuse_levels(path, given["depth"], given["length"])
    given["depth"], notes = _along(given["depth"], given["length"], tilt)
    measured = _numbered(head, "MEASUREMENTVAR")
    return [sounding(str(path), first.get("TESTID", path.stem), given, _number(measured.get(3)) or None,
                     _number(measured.get(13)), notes)]  # fmt: skip


def _refuse_levels(path: Path, depth: Array, length: Array) -> None:
    """Refuse corrected depths that do not begin where the lengths of the rods do: elevations of another level."""
    known = np.flatnonzero(np.isfinite(depth * length))
    if not len(known):
        return
    down = -1.0 if np.median(depth[known]) < 0.0 else 1.0
    first, rods = float(depth[known[0]]), float(length[known[0]])
    if abs(down * first - abs(rods)) > MOST_OFF:
        text = f"the corrected depth is {first:g} m where the length of the rods is {rods:g} m"
        raise refused(path, f"{text}: {ANOTHER_LEVEL}")


def _numbered(head: Sequence[tuple[int, str, list[str]]], key: str) -> dict[int, str]:
    """Return the second part of the lines of a key by their number."""
    return {
        int(parts[0]): parts[1] for _, name, parts in head if name == key and len(parts) > 1 and parts[0].isdecimal()
    }


def _gef_columns(
    path: Path, head: Sequence[tuple[int, str, list[str]]], faults: Faults
) -> dict[str, tuple[int, float]]:
    """Return place and factor to SI of each channel."""
    infos: dict[int, tuple[int, int, str]] = {}
    for line, key, parts in head:
        numbers = [int(each) for each in parts[3:] if each.isdecimal()]  # behind a name that may hold commas
        if key == "COLUMNINFO" and numbers and parts[0].isdecimal():
            quantity, own = numbers[-1], (line, int(parts[0]) - 1, parts[1])
            if infos.setdefault(quantity, own) is not own and quantity in _GEF.values():
                text = f"column {infos[quantity][1] + 1} has the quantity {quantity}, too: which of them counts?"
                faults.add((str(path), line), f"COLUMNINFO {parts[0]}", text)
    columns = {}
    for channel, (line, at, unit) in ((name, infos[number]) for name, number in _GEF.items() if number in infos):
        if at < 0:
            faults.add((str(path), line), f"COLUMNINFO {at + 1}", "columns count from 1")
        tilt = channel.startswith("tilt")
        scale = np.pi / 180.0 if tilt else _scale(faults, path, channel, unit, line, f"COLUMNINFO {at + 1}")
        columns[channel] = (at, scale)
    if not {"depth", "length"} & set(columns) or not {"qc", "qt"} & set(columns):
        raise refused(path, "has no column of depth (quantity 1 or 11) and cone resistance (2 or 13) in #COLUMNINFO")
    return columns


def _gef_rows(path: Path, lines: Sequence[str], start: int, head: dict[str, str], last: int, faults: Faults) -> Array:
    """Return the rows below the header (n, columns)."""
    record, separator = head.get("RECORDSEPARATOR", "!") or "!", head.get("COLUMNSEPARATOR") or None
    rows: list[list[float]] = []
    for k, line in enumerate(lines[start:], start=start + 1):
        cells = [cell.strip() for cell in line.replace(record, "").strip().split(separator)]
        if not any(cells):
            continue
        try:
            rows.append([float(cell) for cell in cells[: last + 1]])
        except ValueError:
            faults.add((str(path), k), None, f"{quoted(line.strip())} is no row of numbers")
            continue
        if len(rows[-1]) <= last:
            message = f"the row has {len(rows.pop())} values, the columns of the header need {last + 1}"
            faults.add((str(path), k), None, message)
    faults.stop()
    if not rows:
        raise refused(path, "has no rows below #EOH", start)
    return np.array(rows)


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
Group = tuple[list[str], list[str], list[tuple[int, list[str]]]]  # headings, units, rows with their lines
Groups = dict[str, Group]


def read_ags(path: Path, text: str) -> Groups:
    """Return the groups of an AGS 4 file: headings, units, rows with their lines.

    Raises UserInputError: AGS 3, or a file without tests, laboratory tests and layers that are read.
    """
    if text.lstrip().startswith('"**'):
        raise refused(path, "is an AGS 3 file: save it as AGS 4, or its group STCN as CSV")
    groups: Groups = {}
    try:
        for name, group in _ags_groups(text):
            if groups.setdefault(name, group) is not group:
                raise refused(path, f"holds the group {name} twice: a file of each, or one group with all rows")
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
    depths, found, faults = [], [], Faults()
    for group, name, key, factors, less in _AGS_VALUES:
        head, units, rows = table = groups.get(group, ([], [], []))
        if not rows or not {name, "SPEC_DPTH"} <= set(head):
            continue
        unit = _unit_of(table, name).strip().lower()
        if unit not in factors:
            text = f"the unit is {quoted(unit)}, expected one of {', '.join(factors)}"
            faults.add((str(path), _line_of(units)), name, text)
        values = _ags_column(path, table, name, factors.get(unit, np.nan), faults) - less
        for (line, _), value in zip(rows, values.tolist(), strict=True):
            if np.isfinite(value) and (wrong := wrong_value(key, value)):
                faults.add((str(path), line), name, wrong)
        depths.append(_ags_lengths(path, table, "SPEC_DPTH", faults))
        _warn_of_places(path, groups, group)
        found.append((key, values))
    faults.stop()
    depth = np.concatenate(depths) if depths else np.empty(0)
    out = {key: np.full(depth.shape, np.nan) for key, _ in found}
    ends = np.cumsum([0, *(len(each) for each in depths)])
    for k, (key, values) in enumerate(found):
        out[key][ends[k] : ends[k + 1]] = values
    return depth, {key: values for key, values in out.items() if np.isfinite(values).any()}


def ags_layers(path: Path, groups: Groups) -> list[tuple[int, float, float, str]]:
    """Return line, top and bottom [m] and description of the layers of a borehole; none of several boreholes.

    Warns of layers that are not used, and of those beside a test of another place.
    """
    head, _, rows = table = groups.get("GEOL", ([], [], []))
    if not rows or not {"LOCA_ID", "GEOL_TOP", "GEOL_BASE", "GEOL_DESC"} <= set(head):
        return []
    if (count := len(_ags_places(groups, "GEOL"))) > 1:
        warnings.warn(
            f"{path}: not used: layers of {count} boreholes (GEOL): give those of one", TableNote, stacklevel=2
        )
        return []
    _warn_of_places(path, groups, "GEOL")
    faults = Faults()
    tops, bottoms = (_ags_lengths(path, table, name, faults) for name in ("GEOL_TOP", "GEOL_BASE"))
    faults.stop()
    names = [_DEPTHS.sub("", one_line(cells[head.index("GEOL_DESC")]))[:MOST_NAMED] for _, cells in rows]
    lines = zip((line for line, _ in rows), tops.tolist(), bottoms.tolist(), names, strict=True)
    return [each for each in lines if each[2] > each[1]]


def ags_soundings(path: Path, groups: Groups) -> list[Sounding]:
    """Return the cone penetration tests (groups SCPG, SCPT), one a location: its pushes are joined.

    Raises UserInputError: headings without depth and cone resistance, wrong units, cells that are no numbers.
    """
    if "SCPT" not in groups:
        return []
    head, units, rows = table = groups["SCPT"]
    columns = {channel: name for channel, name in _AGS.items() if name in head}
    if "depth" not in columns or not {"qc", "qt"} & set(columns) or not rows:
        raise refused(path, "the group SCPT needs SCPT_DPTH and SCPT_RES, and rows of DATA")
    faults = Faults()
    scales = {
        channel: _scale(faults, path, channel, _unit_of(table, name), _line_of(units), name)
        for channel, name in columns.items()
    }
    faults.stop()
    location, push = (_ags_words(table, name) for name in ("LOCA_ID", "SCPG_TESN"))
    ratios, places = _ags_ratios(groups), dict[str, list[int]]()
    for k, each in enumerate(location):
        places.setdefault(each, []).append(k)

    def test(name: str) -> Sounding:
        own = places[name]
        group, wrong = (head, units, [rows[k] for k in own]), Faults()
        part = dict.fromkeys(_AGS, np.full(len(own), np.nan))
        for channel, scale in scales.items():
            part[channel] = _ags_column(path, group, columns[channel], scale, wrong)
        wrong.stop()
        by_push = ratios.get(name, {})
        if len(set(by_push.values())) < 2:
            return sounding(str(path), name or path.stem, part, next(iter(by_push.values()), None))
        part["area ratio"] = np.array([by_push.get(push[k], np.nan) for k in own])
        named = ", ".join(f"{each:g}" for each in sorted({*by_push.values()}))
        return sounding(str(path), name, part, remarks=[f"area ratios {named}: each push has that of its cone"])

    return usable(partial(test, name) for name in places)


def _ags_groups(text: str) -> Iterator[tuple[str, Group]]:
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


def _unit_of(group: Group, name: str) -> str:
    head, units, _ = group
    return units[at] if (at := head.index(name)) < len(units) else ""


def _ags_words(group: Group, name: str) -> list[str]:
    """Return a column of a group as texts, blank where the group does not have it."""
    head, _, rows = group
    return [cells[head.index(name)] if name in head else "" for _, cells in rows]


def _ags_places(groups: Groups, name: str) -> set[str]:
    """Return the locations of a group."""
    return {*_ags_words(groups.get(name, ([], [], [])), "LOCA_ID")} - {""}


def _warn_of_places(path: Path, groups: Groups, name: str) -> None:
    """Warn of a group whose rows are of several locations, or of another one than the test."""
    own, tests = _ags_places(groups, name), _ags_places(groups, "SCPT")
    if len(own) > 1 or (tests and own - tests):
        beside = f" beside the CPT of {', '.join(sorted(tests)[:MOST_PLACES])}" if tests else ""
        places = ", ".join(sorted(own)[:MOST_PLACES])
        warnings.warn(f"{path}: rows of {name} are those of {places}{beside}: all count", TableNote, stacklevel=2)


def _ags_ratios(groups: Groups) -> dict[str, dict[str, float]]:
    """Return the area ratio of the cone by location and push."""
    ratios: dict[str, dict[str, float]] = {}
    group = groups.get("SCPG", ([], [], []))
    for place, push, text in zip(
        *(_ags_words(group, each) for each in ("LOCA_ID", "SCPG_TESN", "SCPG_CAR")), strict=True
    ):
        if ratio := _number(text):
            ratios.setdefault(place, {})[push] = ratio
    return ratios


def _ags_lengths(path: Path, group: Group, name: str, faults: Faults) -> Array:
    """Return a column of depths (n,) in m."""
    return _ags_column(
        path, group, name, _scale(faults, path, "depth", _unit_of(group, name), _line_of(group[1]), name), faults
    )


def _ags_column(path: Path, group: Group, name: str, scale: float, faults: Faults) -> Array:
    """Return a column of a group (n,) times a factor, NaN where it is blank; note cells that are no numbers."""
    head, _, rows = group
    out, at = np.full(len(rows), np.nan), head.index(name)
    for k, (line, cells) in enumerate(rows):
        try:
            out[k] = scale * float(cells[at]) if cells[at].strip() else np.nan
        except ValueError:
            faults.add((str(path), line), name, f"{quoted(cells[at])} is not a number")
    return out


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
    depth, length, tilt = (column.get(each, np.full(len(values), np.nan))
                           for each in ("depth", "penetrationLength", "inclinationResultant"))  # fmt: skip
    given["depth"], notes = _along(depth, length, np.radians(tilt))
    name = test.findtext("broId") or path.stem
    ratio, drilled = (_number(test.findtext(f".//{each}")) for each in ("coneSurfaceQuotient", "predrilledDepth"))
    return sounding(str(path), name, given, ratio or None, drilled, notes)
