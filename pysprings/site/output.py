# SPDX-License-Identifier: MIT
"""A proposal as text, as a document, and as the table that a person edits and `soil.profile` reads."""

import csv
import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pysprings.core.columns import Column, Table
from pysprings.core.errors import UserInputError
from pysprings.core.text import one_line
from pysprings.core.units import read, si_of
from pysprings.core.words import ESTIMATES
from pysprings.scene.profile_table import field_of, read_layers
from pysprings.scene.sections import BY_LAYER
from pysprings.site.proposal import Proposal, Unit, Value


@dataclass(frozen=True)
class Shown:
    """How a value is written: heading of the table, symbol, unit, factor from SI."""

    head: str
    symbol: str
    unit: str
    factor: float = 1.0


VALUES = {
    "effective_unit_weight": Shown("Effective unit weight", "gamma'", "kN/m3", 1e-3),
    "relative_density": Shown("Relative density", "D_r", "-"),
    "friction_angle_final": Shown("phi", "phi", "deg", 180.0 / np.pi),
    "dilation_angle": Shown("psi", "psi", "deg", 180.0 / np.pi),
    "cohesion": Shown("Cohesion", "c", "kPa", 1e-3),
    "K0": Shown("K0", "K0", "-"),
    "undrained_shear_strength": Shown("su", "su", "kPa", 1e-3),
    "young_modulus": Shown("Young modulus", "E", "MPa", 1e-6),
    "shear_modulus": Shown("G", "G_0", "MPa", 1e-6),
    "degradation_strain": Shown("Degradation strain", "gamma_0.7", "-"),
    "degradation_limit": Shown("Degradation limit", "G_ur/G_0", "-"),
    "mobilisation_strain": Shown("Mobilisation strain", "B", "-"),
    "strain_at_half_strength": Shown("Strain at half strength", "gamma_50", "-"),
}


def _shown(key: str) -> Shown:
    """Return how a value that tables of layers give is written."""
    unit, words = field_of(key).unit, key.replace("_", " ")
    return Shown(words, words, "-") if unit == "1" else Shown(words, words, unit, 1.0 / read(f"1 {unit}", si_of(unit)))


VALUES |= {key: _shown(key) for key in BY_LAYER if key not in VALUES}


def _rounded(value: float) -> float:
    return float(f"{value:.3g}")


def _span(line: Sequence[float], factor: float) -> str:
    """Return a value, or those at top and bottom."""
    top, bottom = (_rounded(each * factor) for each in line)
    return f"{top:g}" if top == bottom else f"{top:g} to {bottom:g}"


def layer_table(proposal: Proposal) -> Table:
    """Return the layers: ends, soil, I_c, rows."""
    columns = (Column("layer", "n", "d"), Column("z [m]", "z", words=True), Column("soil", "name", words=True),
               Column("as", "kind", words=True), Column("I_c", "index", ".2f"),
               Column("rows", "rows", "d"))  # fmt: skip
    rows = [{"n": k, "z": f"{unit.top:g} to {unit.bottom:g}", "name": unit.name, "kind": unit.kind,
             "index": unit.index, "rows": unit.rows} for k, unit in enumerate(proposal.units, start=1)]  # fmt: skip
    return Table.of(columns, rows)


def value_table(proposal: Proposal) -> Table:
    """Return low, best and high of each value by layer, with where they come from."""
    columns = (Column("layer", "n", "d"), Column("value", "value", words=True),
               *(Column(each, each, words=True) for each in ESTIMATES), Column("from", "from", words=True))  # fmt: skip
    rows = []
    for k, unit in enumerate(proposal.units, start=1):
        for key, shown, value in _of(unit):
            spans: dict[str, Any] = {
                each: _span(line, shown.factor) for each, line in zip(ESTIMATES, value.lines, strict=True)
            }
            name = f"{shown.symbol} [{shown.unit}]"
            mark = " *" if value.outside else ""
            rows.append({"n": k, "value": name, **spans, "from": "; ".join(value.sources) + mark, "key": key})
    return Table.of(columns, rows)


def _of(unit: Unit) -> Iterator[tuple[str, Shown, Value]]:
    for key, shown in VALUES.items():
        if key in unit.values:
            yield key, shown, unit.values[key]


def remarks(proposal: Proposal) -> list[str]:
    """Return what was assumed, what is outside its range, and what is missing, a sentence each."""
    out = list(proposal.notes)
    angles = [unit.values["friction_angle_final"] for unit in proposal.units if "friction_angle_final" in unit.values]
    if not all(each.measured for each in angles):
        out.append("phi of correlations are peak angles of triaxial compression, without softening")
    if any(unit.law == "sand" for unit in proposal.units):
        out.append("law sand computes phi, psi, G_0 and gamma_0.7 from D_r and the stress: those of correlations are "
                   "shown beside it, and not written")  # fmt: skip
        out.append("B and G_ur/G_0 of sand differ from sand to sand: best is a soft one, high four others; fit them to "
                   "triaxial tests (pysprings element --fit)")  # fmt: skip
    for k, unit in enumerate(proposal.units, start=1):
        marks = [f"{shown.symbol} outside the range of {', '.join(value.outside)}"
                 for _, shown, value in _of(unit) if value.outside]  # fmt: skip
        out += [f"layer {k}: {each}" for each in [*unit.remarks, *marks]]
    return out


def document(proposal: Proposal) -> dict[str, Any]:
    """Return the proposal as plain data, in SI."""
    test = proposal.sounding
    layers = [
        {
            "name": unit.name, "kind": unit.kind, "top_m": unit.top, "bottom_m": unit.bottom,
            "behaviour_index": unit.index, "rows": unit.rows, "remarks": unit.remarks,
            "values": {
                key: {**{each: line.tolist() for each, line in zip(ESTIMATES, value.lines, strict=True)},
                      "from": list(value.sources), "outside": list(value.outside)}
                for key, _, value in _of(unit)
            },
        }
        for unit in proposal.units
    ]  # fmt: skip
    about = {} if test is None else {"test": test.name, "rows": len(test.depth), "area_ratio": test.area_ratio}
    return {**about, "layers": layers, "notes": proposal.notes}


def cells(proposal: Proposal, files: Sequence[str]) -> list[list[Any]]:
    """Return the rows of the table of `soil.profile`, with remarks behind a # below it."""
    heads: list[tuple[str, str, int, int]] = []  # heading, key, estimate, end
    values = [unit.written for unit in proposal.units]
    for key, shown in VALUES.items():
        own = [each[key].lines for each in values if key in each]
        if not own:
            continue
        ranged = any(np.ptp(lines, axis=0).any() for lines in own)
        by_depth = any(np.ptp(lines, axis=1).any() for lines in own)
        for k in range(3) if ranged else (1,):
            for end, word in ((0, " from"), (1, " to")) if by_depth else ((0, ""),):
                estimate = f" {ESTIMATES[k]}" if ranged else ""
                heads.append((f"{shown.head}{estimate}{word} [{shown.unit}]", key, k, end))
    marked = any(map(_mark, proposal.units))
    table: list[list[Any]] = [
        ["Depth from [m]", "Depth to [m]", "Soil type", "law", *(head[0] for head in heads), *["Remark"] * marked]
    ]
    for unit, each in zip(proposal.units, values, strict=True):
        row = [_rounded(each[key].lines[k, end] * VALUES[key].factor) if key in each else None
               for _, key, k, end in heads]  # fmt: skip
        table.append([unit.top, unit.bottom, unit.name, unit.law, *row, *[_mark(unit) or None] * marked])
    sources = [f"layer {k}, {shown.symbol}: {'; '.join(value.sources)}"
               for k, unit in enumerate(proposal.units, start=1) for key, shown, value in _of(unit)
               if key in unit.written]  # fmt: skip
    head = f"proposed by pysprings ground from {', '.join(files)}: to be read and edited before a run"
    return [*table, *([f"# {one_line(text)}"] for text in [head, *sources, *remarks(proposal)])]


def _mark(unit: Unit) -> str:
    """Return what results of a layer have to state: its remark, values on correlations outside their range."""
    odd = [shown.symbol for key, shown, value in _of(unit)
           if key in unit.written and not all(each.endswith("left out") for each in value.outside)]  # fmt: skip
    outside = f"{', '.join(odd)} outside the range of their correlations" if odd else ""
    return "; ".join(filter(None, (unit.remark, unit.unknown, outside)))


def write_table(rows: Sequence[Sequence[Any]], path: Path) -> None:
    """Write rows of cells as CSV or, by the ending, as an Excel workbook.

    Raises UserInputError: another ending.
    """
    from pysprings.core.storage import replacing, write_text

    if path.suffix.lower() == ".csv":
        stream = io.StringIO(newline="")
        csv.writer(stream, lineterminator="\n").writerows(rows)
        write_text(stream.getvalue(), path)
        return
    import openpyxl

    book = openpyxl.Workbook(write_only=True)
    sheet = book.create_sheet("site")
    for row in rows:
        sheet.append(list(row))
    with replacing(path) as target:
        book.save(target)


def faults_of(path: Path) -> list[str]:
    """Return what `soil.profile` would refuse of a written table."""
    try:
        read_layers(path)
    except UserInputError as error:
        return [str(each) for each in error.problems]
    return []
