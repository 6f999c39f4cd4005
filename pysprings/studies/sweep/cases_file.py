# SPDX-License-Identifier: MIT
"""`cases.csv` of a study: a row a case, which people read and edit; and tables of cases that people bring."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pysprings.core.errors import Problem, UserInputError, refused
from pysprings.core.files.storage import write_text
from pysprings.studies.sweep.plan import Axis, Case, Plan, Value, quantity, split

FILE = "cases.csv"
DONE, SHORT, FAILED, STOPPED, WAITING, SKIP, AGAIN = (
    "complete", "partial", "failed", "stopped", "waiting", "skip", "again",
)  # fmt: skip
ENDED = (DONE, SHORT, FAILED)
_EDITED = (SKIP, AGAIN)
_HEADING = re.compile(r"\s*(?P<key>[^\[\]]+?)\s*(?:\[(?P<unit>[^\]]*)\])?\s*")


@dataclass(frozen=True)
class State:
    """How a case stands: status, why it did not reach its end, seconds of its run, folder name (hash)."""

    status: str = WAITING
    reason: str = ""
    seconds: float = 0.0
    hash: str = ""


def write_cases(folder: Path, plan: Plan, states: Mapping[int, State]) -> Path:
    """Write cases.csv; ``states`` by number of the case."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    units = [_common_unit([case.values[k] for case in plan.cases]) for k in range(len(plan.axes))]
    names = [f"{axis.name} [{unit}]" if unit else axis.name for axis, unit in zip(plan.axes, units, strict=True)]
    writer.writerow(["id", *names, "status", "reason", "seconds", "hash"])
    for case in plan.cases:
        state = states.get(case.number, State())
        cells = [_cell(value, unit) for value, unit in zip(case.values, units, strict=True)]
        seconds = f"{state.seconds:.1f}" if state.seconds else ""
        writer.writerow([case.id, *cells, state.status, state.reason, seconds, state.hash])
    return write_text(stream.getvalue(), folder / FILE)


def _common_unit(values: Sequence[Value]) -> str:
    """Return the unit that all values of a column have; empty where they differ or have none."""
    units = {split(value)[1] for value in values}
    return units.pop() if len(units) == 1 else ""


def _cell(value: Value, unit: str) -> str:
    number, own = split(value)
    if unit and not isinstance(number, str):
        return str(value).removesuffix(own).strip()
    return str(value).lower() if isinstance(value, bool) else str(value)


def read_cases(folder: Path, plan: Plan) -> tuple[Plan, dict[int, str]]:
    """Return the plan with the rows of cases.csv as they stand there, and the status of each row.

    Rows may be changed, added and removed; ``skip`` and ``again`` in the column status leave a case out or repeat it.
    Raises UserInputError with the line of what cannot be read.
    """
    file = folder / FILE
    heads, rows = _read(file)
    columns = _columns(file, heads, plan.axes)
    cases, asked, problems = [], {}, []
    for line, row in rows:
        number = _number(row[0])
        if number is None or number in asked:
            text = f"'{row[0]}' is no number of a case" if number is None else f"case {row[0]} stands here twice"
            problems.append(Problem(str(file), line, None, "id", text))
            continue
        values = tuple(_value(row[at], unit) for at, unit in columns)
        cases.append(Case(number, values))
        asked[number] = row[heads.index("status")].strip() if "status" in heads else ""
    if problems:
        raise UserInputError(problems)
    if not cases:
        raise refused(None, "has no cases", file)
    whole = plan.is_grid and [case.values for case in cases] == [case.values for case in plan.cases]
    return replace(plan, cases=tuple(cases), is_grid=whole, from_file=str(file)), asked


def _number(text: str) -> int | None:
    return int(text) if text.strip().isdigit() and int(text) > 0 else None


def _columns(file: Path, heads: Sequence[str], axes: Sequence[Axis]) -> list[tuple[int, str]]:
    """Return place and unit of the column of each axis."""
    found = {
        match["key"]: (k, match["unit"] or "") for k, head in enumerate(heads) if (match := _HEADING.fullmatch(head))
    }
    missing = [axis.name for axis in axes if axis.name not in found]
    if missing or heads[0] != "id":
        raise refused(None, f"no column {', '.join(missing) or 'id'} (remove the file to have it made anew)", file)
    return [found[axis.name] for axis in axes]


def read_table(file: Path) -> tuple[tuple[Axis, ...], tuple[Case, ...]]:
    """Return axes and cases of a table: a scene key a column, KEY or KEY [unit]; a column id is not read."""
    heads, rows = _read(file)
    axes, columns = [], []
    for at, head in enumerate(heads):
        match = _HEADING.fullmatch(head)
        if match is None:
            raise refused(head, "expected a scene key, or KEY [unit]", file)
        if match["key"] != "id":
            axes.append(Axis(match["key"].replace(".", "_"), (match["key"],)))
            columns.append((at, match["unit"] or ""))
    if not axes or not rows:
        raise refused(None, "has no cases: a heading line with scene keys, then a row a case", file)
    cases = [Case(k + 1, tuple(_value(row[at], unit) for at, unit in columns)) for k, (_, row) in enumerate(rows)]
    return tuple(axes), tuple(cases)


def _value(text: str, unit: str) -> Value:
    """Return a cell as TOML has it."""
    text = text.strip()
    if text in ("true", "false"):
        return text == "true"
    try:
        return quantity(float(text), unit)
    except ValueError:
        return text


def _read(file: Path) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """Return headings and (line, cells) of a table; a decimal comma goes with a semicolon between cells."""
    try:
        text = file.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise refused(None, "is not UTF-8 text", file) from None
    except OSError as error:
        raise refused(None, f"cannot be read ({error.strerror})", file) from None
    first = text.split("\n", 1)[0]
    semicolons = first.count(";") > first.count(",")
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=";" if semicolons else ",")
    lines = [(reader.line_num, row) for row in reader if any(cell.strip() for cell in row)]
    if not lines:
        raise refused(None, "is empty", file)
    heads = [head.strip() for head in lines[0][1]]
    wrong = [Problem(str(file), line, None, None, f"{len(row)} cells under {len(heads)} headings")
             for line, row in lines[1:] if len(row) != len(heads)]  # fmt: skip
    if wrong:
        raise UserInputError(wrong)
    if semicolons:
        lines = [(line, [re.sub(r"^\s*(-?\d+),(\d+)", r"\1.\2", cell) for cell in row]) for line, row in lines]
    return heads, lines[1:]


def wants_again(asked: str) -> bool:
    """Return whether a person asked in cases.csv for a case to be repeated."""
    return asked == AGAIN


def is_skipped(asked: str) -> bool:
    """Return whether a person left a case out in cases.csv."""
    return asked == SKIP
