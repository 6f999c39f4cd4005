# SPDX-License-Identifier: MIT
"""Files of a site investigation -> tests, points by depth, layers; the kind of a table is found by its headings."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np

from pysprings.core.arrays import Array
from pysprings.core.tables import ENDINGS, Column, Sheet, Table, TableNote, is_table, one_table, sheets_of, split
from pysprings.core.tables.files import text_of
from pysprings.core.tables.headings import TEXT
from pysprings.core.text import suggestion
from pysprings.core.units import quoted
from pysprings.core.words import ESTIMATES
from pysprings.scene.defaults import wrong_value
from pysprings.scene.profile_table import (
    EPS50,
    NAMES,
    REMARK,
    SAME,
    TOTAL,
    VELOCITY,
    WATER,
    check_joints,
    columns,
    row_ends,
)
from pysprings.scene.sections import BY_LAYER
from pysprings.scene.soils import SOIL_LAWS
from pysprings.site.formats import ags_layers, ags_points, ags_soundings, read_ags, read_bro, read_gef, refused
from pysprings.site.sounding import ANOTHER_LEVEL, Sounding, are_elevations, sounding, usable

_DEPTHS = ("depth", "z", *NAMES["depth"], "penetration length", "sondeerlengte", "diepte", "tiefe", "dybde",
           "profondeur", "scpt dpth")  # fmt: skip
_CONE = ("qc", "q c", "cone resistance", "cone resistance qc", "tip resistance", "cone tip resistance",
         "conusweerstand", "conuswaarde", "conuswaarden", "puntdruk", "spitzendruck", "scpt res")  # fmt: skip
_TOTAL_CONE = ("qt", "q t", "corrected cone resistance", "corrected cone resistance qt",
               "total cone resistance", "scpt qt")  # fmt: skip
_TEST_COLUMNS = (
    Column("depth", "m", _DEPTHS, "m"), Column("qc", "Pa", _CONE, "MPa"), Column("qt", "Pa", _TOTAL_CONE, "MPa"),
    Column("fs", "Pa", ("f s", "sleeve friction", "sleeve friction fs", "local friction", "plaatselijke wrijving",
                        "kleef", "mantelreibung", "scpt fres"), "MPa"),
    Column("u2", "Pa", ("u 2", "pore pressure u2", "pore pressure", "waterspanning u2",
                         "porenwasserdruck", "porenwasserdruck u2", "scpt pwp2"), "MPa"),
    Column("u", "Pa", (), "MPa"), Column("Qt", "*", ("Qtn",), skipped="follows from the others"),
    Column("area ratio", "1", ("cone area ratio", "net area ratio"), "", "", 0.01),
    Column("Rf", "1", ("r f", "friction ratio", "friction ratio rf", "wrijvingsgetal"), "", "", 0.01),
    Column("location", TEXT, ("location identifier", "loca id", "borehole", "hole", "cpt", "bh")),
)  # fmt: skip
_PEAKS = ("su peak q", "su uu", "su dss", "su cauc", "cu peak", "failure shear stress", "peak shear stress")


@dataclass(frozen=True)
class Points:
    """Values by depth: of tests in a laboratory or in the ground (n,), NaN where a row has none, by key in SI."""

    place: str
    depth: Array
    values: dict[str, Array]

    def down_to(self, depth: float) -> Points | None:
        """Return the points down to a depth (m); None without any."""
        own = self.depth <= depth
        values = {key: each[own] for key, each in self.values.items()}
        return Points(self.place, self.depth[own], values) if own.any() else None


@dataclass(frozen=True)
class Bed:
    """A layer of a table: file and line, ends [m], name, values at both ends by key in SI, law and remark or blank."""

    place: str
    line: int | None
    top: float
    bottom: float
    name: str
    values: dict[str, tuple[float, float]]
    law: str = ""
    remark: str = ""

    def down_to(self, depth: float) -> Bed:
        """Return the layer down to a depth (m), with the values that it has there."""
        if depth >= self.bottom:
            return self
        share = (depth - self.top) / (self.bottom - self.top)
        values = {key: (first, first + share * (last - first)) for key, (first, last) in self.values.items()}
        return replace(self, bottom=depth, values=values)


@dataclass
class Site:
    """All that the files hold."""

    soundings: list[Sounding] = field(default_factory=list)
    beds: list[Bed] = field(default_factory=list)
    points: Points | None = None
    notes: list[str] = field(default_factory=list)

    def down_to(self, depth: float) -> Site:
        """Return what lies above a depth (m): layers end there, with the values that they have there."""
        return replace(
            self, beds=[bed.down_to(depth) for bed in self.beds if bed.top < depth],
            points=self.points and self.points.down_to(depth),
        )  # fmt: skip


def read_site(files: Sequence[Path]) -> Site:
    """Return what the files hold: cone penetration tests, points by depth, one table of layers.

    Raises UserInputError: a file of no such kind, or one with faults: file, line, what is wrong.
    """
    site = Site()
    for path in files:
        raw = _start(path)
        if not is_table(path) or raw.lstrip(b"\xef\xbb\xbf \r\n").startswith((b"#GEFID", b'"GROUP"')):
            _add_format(site, path, raw)
        else:
            _add_table(site, path)
        if len({bed.place for bed in site.beds}) > 1:
            raise refused(path, "is a second table of layers: give one")
    return site


def _start(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise refused(path, "no such file" if isinstance(error, FileNotFoundError) else f"cannot be read: {error}") \
            from None  # fmt: skip


def _add_format(site: Site, path: Path, raw: bytes) -> None:
    """Read a file in one of the formats of `formats`."""
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    start = text.lstrip()[:200].upper()
    if re.match(r"#\w+\s*=", start):
        site.soundings += read_gef(path, text)
    elif start.startswith(('"GROUP"', '"**')):
        groups = read_ags(path, text)
        tests, layers = ags_soundings(path, groups), ags_layers(path, groups)
        depth, values = ags_points(path, groups)
        if not (tests or values or layers):
            raise refused(path, "holds no CPT, no strength or density of a laboratory, and no layers of one borehole")
        site.soundings += tests
        site.points = _joined(site.points, Points(str(path), depth, values)) if values else site.points
        if "undrained_shear_strength" in values:
            site.notes.append("su of TRIT_CU: unconsolidated undrained triaxial tests (UU), of total stress")
        site.beds += [Bed(str(path), line, top, bottom, name or "layer", {})
                      for line, top, bottom, name in layers]  # fmt: skip
    elif start.startswith("<"):
        site.soundings += read_bro(path, raw)
    else:
        kinds = f"a CPT is read from GEF, AGS 4, XML of the BRO, {', '.join(ENDINGS)}"
        raise refused(path, f"is of no kind that is read: {kinds}; save it as CSV with depth [m], qc [MPa], fs [MPa]")


def _add_table(site: Site, path: Path) -> None:
    """Read a table by the kind that its headings show."""
    sheets = sheets_of(path)
    texts = {cell for sheet in sheets for _, cells in sheet.lines[:30] for cell in cells if isinstance(cell, str)}
    stems = {stem.lower() for text in texts for stem, _ in split(text)}
    if stems & set(_DEPTHS) and stems & {*_CONE, *_TOTAL_CONE}:
        site.soundings += _tests(path, sheets)
    elif stems & {"top", *NAMES["top"]}:
        site.beds += _beds(path, sheets)
    elif stems & set(_DEPTHS):
        site.points = _joined(site.points, _points(path, sheets))
    else:
        what = "of a CPT (depth [m], qc [MPa]), points (depth [m], su [kPa] ...) or layers (Depth from [m] ...)"
        raise refused(path, f"no headings {what} were found")


def _table(path: Path, columns: Sequence[Column], what: str, sheets: list[Sheet]) -> Table:
    """Return the table of a file, without unknown columns; refuse one without rows."""
    table = one_table(path, columns, what, lenient=True, sheets=sheets)
    if not len(table):
        raise refused(path, "has no rows below its headings", table.head_line)
    if ranged := [table.key(name) for name in table.columns if {*name.split()} & {*ESTIMATES}]:
        text = f"has a range already ({quoted(ranged[0])}): name it in soil.profile, or give one value for each"
        raise refused(path, text, table.head_line)
    return table


def _tests(path: Path, sheets: list[Sheet]) -> list[Sounding]:
    """Return the tests of a table, one a location."""
    table = _table(path, _TEST_COLUMNS, "a CPT", sheets)
    names = table.texts("location")
    for k in [k for k, each in enumerate(names) if not each] if len(set(names) - {""}) > 1 else ():
        table.fault(k, "location", "is blank: name the test of each row")
    if "fs" not in table:  # else it does not count
        table.fault_without_unit("Rf")
    given = {
        name: table.numbers(name, most=False) for name in ("depth", "qc", "qt", "fs", "Rf", "u2", "u", "area ratio")
    }
    table.faults.stop()
    plain = np.isnan(given["u2"]) & np.isfinite(given["u"])
    given["u2"] = np.where(plain, given.pop("u"), given["u2"])
    ratio, notes = _above(table)
    notes += ["u is taken as u2, behind the cone"] * bool(plain.any())
    locations = list(dict.fromkeys(each for each in names if each)) or [""]

    def test(name: str) -> Sounding:
        own = np.array([each in (name, "") for each in names])
        part = {key: value[own] for key, value in given.items()}
        return sounding(table.place, name or path.stem, part, ratio, remarks=notes)

    return usable(partial(test, name) for name in locations)


def _above(table: Table) -> tuple[float | None, list[str]]:
    """Return the net area ratio in the lines above the heading, and a note of other values that stand there."""
    ratio, others = None, list[str]()
    for _, cells in table.above:
        texts = [text for text in map(text_of, cells) if text]
        found = re.search(r"area ratio\D*?(\d*[.,]?\d+)", line := " ".join(texts), re.IGNORECASE)
        if found and ratio is None:
            ratio = float(found[1].replace(",", "."))
        elif any(re.search(r"\d", text) for text in texts[1:]):
            others.append(line)
    return ratio, [f"what stands above the heading does not count: {'; '.join(others[:3])}"] * bool(others)


def _value_columns() -> tuple[Column, ...]:
    """Return the columns of `soil.profile`, and strengths of tests by other names."""
    return (*columns(), Column("su peak", "Pa", _PEAKS, "kPa"))


def _points(path: Path, sheets: list[Sheet]) -> Points:
    table = _table(path, _value_columns(), "points by depth", sheets)
    depth = table.numbers("depth", most=False)
    values = _values(table)
    table.faults.stop()
    if not values:
        message = "no column of values: su [kPa], Total unit weight [kN/m3], Gmax [MPa], Vs [m/s], Dr [-], phi [deg]"
        raise refused(path, message, table.head_line)
    good = np.isfinite(depth) & (depth >= 0.0)
    if are_elevations(known := depth[np.isfinite(depth)]) and known.max() > 0.0:
        text = f"depths fall from {known[0]:g} to {known[-1]:g} m: {ANOTHER_LEVEL}"
        raise refused(path, text, table.head_line)
    if not good.any():
        raise refused(path, "no row has a depth below mudline, 0 or more", table.head_line)
    if count := int((~good).sum()):
        warnings.warn(f"{table.place}: {count} rows without a depth of 0 or more are not used", TableNote, stacklevel=2)
    return Points(table.place, depth[good], {key: value[good] for key, value in values.items()})


def _joined(first: Points | None, other: Points) -> Points:
    """Return the points of two files as one."""
    if first is None:
        return other
    values = {
        key: np.concatenate([each.values.get(key, np.full(each.depth.shape, np.nan)) for each in (first, other)])
        for key in {**first.values, **other.values}
    }
    return Points(first.place, np.concatenate([first.depth, other.depth]), values)


# the column that gives a key, too: its name, and the key from its values and total unit weights
_OTHERS: dict[str, tuple[str, Callable[[Array, Array], Array]]] = {
    "undrained_shear_strength": ("su peak", lambda values, _: values),
    "effective_unit_weight": (TOTAL, lambda values, _: values - WATER),
    "strain_at_half_strength": (EPS50, lambda values, _: 1.5 * values),
    "shear_modulus": (VELOCITY, lambda values, total: total / 9.81 * values**2),
}


def _values(table: Table, end: str = "") -> dict[str, Array]:
    """Return the values of the rows by key, in SI; those at one end of each layer where it has them."""

    def column(name: str) -> Array:
        own = table.numbers(name, most=False)
        if not end or f"{name} {end}" not in table:
            return own
        there = table.numbers(f"{name} {end}", most=False)
        other = table.numbers(f"{name} {'to' if end == 'from' else 'from'}", most=False)
        for k in np.flatnonzero(np.isnan(there) & np.isnan(own) & np.isfinite(other)).tolist():
            table.fault(k, f"{name} {end}", "blank beside the value at the other end of the layer")
        return np.where(np.isfinite(there), there, own)

    out, total = {}, column(TOTAL)
    if VELOCITY in table and TOTAL not in table:
        table.fault(None, VELOCITY, "needs the total unit weight beside it: G = rho Vs^2")
    for key in BY_LAYER:
        given, (name, of) = column(key), _OTHERS.get(key, (key, lambda values, _: values))
        values = np.where(np.isfinite(given), given, of(column(name), total))
        for k in np.flatnonzero(np.isfinite(values)).tolist():
            source = key if np.isfinite(given[k]) else name
            if wrong := wrong_value(key, float(values[k])):
                table.fault(k, f"{source} {end}" if f"{source} {end}" in table else source, wrong)
        out[key] = values
    return {key: values for key, values in out.items() if np.isfinite(values).any()}


def _beds(path: Path, sheets: list[Sheet]) -> list[Bed]:
    table = _table(path, _value_columns(), "layers", sheets)
    ends = {name: table.numbers(name, most=False) for name in ("top", "bottom")}
    firsts, lasts = _values(table, "from"), _values(table, "to")
    tops, bottoms = row_ends(table, ends)
    check_joints(table, tops, bottoms)
    if len(tops) and abs(tops[0]) > SAME:
        table.fault(0, "top", f"the first layer begins at {tops[0]:g} m: it begins at mudline, 0 m")
    bottoms = np.where(np.isfinite(bottoms), bottoms, np.append(tops[1:], np.nan))
    for k in np.flatnonzero(~(bottoms > tops)).tolist():
        table.fault(k, "bottom", "is blank, or not below the top of the layer")
    table.faults.stop()
    names, laws, remarks = table.texts("name"), table.texts("law"), table.texts(REMARK)
    for k in [k for k, law in enumerate(laws) if law and law not in SOIL_LAWS]:
        table.fault(k, "law", f"{quoted(laws[k])} is not one of {', '.join(SOIL_LAWS)}{suggestion(laws[k], SOIL_LAWS)}")
    table.faults.stop()
    return [
        Bed(table.place, int(table.lines[k]), float(tops[k]), float(bottoms[k]), names[k] or f"layer {k + 1}",
            {key: (float(first[k]), float(lasts.get(key, first)[k])) for key, first in firsts.items()
             if np.isfinite(first[k]) and np.isfinite(lasts.get(key, first)[k])}, laws[k], remarks[k])
        for k in range(len(table))
    ]  # fmt: skip
