# SPDX-License-Identifier: MIT
"""`cases.csv` of a study: a row a case, which people read and edit; and tables of cases that people bring."""

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pysprings.core.errors import refused
from pysprings.core.files.storage import write_text
from pysprings.core.tables import Table, keyed_table
from pysprings.core.tables.cells import NotANumber, number, text_of
from pysprings.studies.sweep.plan import Axis, Case, Plan, Value, quantity, split

FILE = "cases.csv"
DONE, SHORT, FAILED, STOPPED, WAITING, SKIP, AGAIN = (
    "complete", "partial", "failed", "stopped", "waiting", "skip", "again",
)  # fmt: skip
ENDED = (DONE, SHORT, FAILED)
_EDITED = (SKIP, AGAIN)


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
    names = [axis.name for axis in plan.axes]
    table = keyed_table(file, ["id", *names], "cases")
    missing = [name for name in names if name not in table]
    if missing or table.head[:1] != ["id"]:
        raise refused(None, f"no column {', '.join(missing) or 'id'} (remove the file to have it made anew)", file)
    status, cases, asked = table.texts("status"), [], {}
    columns = [_values(table, name) for name in names]
    for k, text in enumerate(table.texts("id")):
        number = int(text) if text.isdigit() and int(text) > 0 else None
        if number is None or number in asked:
            table.fault(
                k, "id", f"'{text}' is no number of a case" if number is None else f"case {text} stands here twice"
            )
            continue
        cases.append(Case(number, tuple(column[k] for column in columns), int(table.lines[k])))
        asked[number] = status[k]
    table.faults.stop()
    if not cases:
        raise refused(None, "has no cases", file)
    whole = plan.is_grid and [case.values for case in cases] == [case.values for case in plan.cases]
    return replace(plan, cases=tuple(cases), is_grid=whole, from_file=str(file)), asked


def read_table(file: Path) -> tuple[tuple[Axis, ...], tuple[Case, ...]]:
    """Return axes and cases of a table: a scene key a column, KEY or KEY [unit]; a column id is not read."""
    table = keyed_table(file, ("id",), "cases")
    keys = [key for key in table.columns if key != "id"]
    if not table.faults.problems and (not keys or not len(table)):
        raise refused(None, "has no cases: a heading line with scene keys, then a row a case", file)
    columns = [_values(table, key) for key in keys]
    table.faults.stop()
    axes = tuple(Axis(key.replace(".", "_"), (key,)) for key in keys)
    rows = zip(zip(*columns, strict=True), table.lines.tolist(), strict=True)
    return axes, tuple(Case(k, values, line) for k, (values, line) in enumerate(rows, start=1))


def _values(table: Table, key: str) -> list[Value]:
    """Return the cells of a column as TOML has them; note blank cells, and what a workbook does not hold as a value."""
    values: list[Value] = []
    unit = table.columns[key][1].unit
    for k, cell in enumerate(table.cells(key)):
        text = text_of(cell)
        if isinstance(cell, bool) or text in ("true", "false"):
            values.append(text.lower() == "true")
            continue
        try:
            value = number(cell, table.style)
            values.append(text if value is None else quantity(value, unit))
            if value is None:
                table.fault(k, key, "blank: every case needs a value")
        except NotANumber as error:
            if not str(error).endswith("is not a number"):  # a word or a quantity is, for the scene to check
                table.fault(k, key, str(error))
            values.append(text)
    return values


def wants_again(asked: str) -> bool:
    """Return whether a person asked in cases.csv for a case to be repeated."""
    return asked == AGAIN


def is_skipped(asked: str) -> bool:
    """Return whether a person left a case out in cases.csv."""
    return asked == SKIP
