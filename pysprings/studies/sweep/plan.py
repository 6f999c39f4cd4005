# SPDX-License-Identifier: MIT
"""The cases of a study: axes of scene values, the rows that they make, and tables of them.

`cases.csv` has a row a case, which people read and edit; people may bring tables of cases, too.
"""

import csv
import hashlib
import io
import itertools
import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from pysprings.core.errors import Problem, UserInputError, refused
from pysprings.core.storage import write_text
from pysprings.core.tables import Table, keyed_table
from pysprings.core.tables.files import NotANumber, text_of
from pysprings.core.text import is_formula
from pysprings.core.units import quoted
from pysprings.core.words import ESTIMATES
from pysprings.scene.changes import OPTION, Change
from pysprings.scene.defaults import implausible
from pysprings.scene.load import SceneText
from pysprings.scene.model import Scene

DIGITS = 6  # figures of a value that a range or a sample makes
Keep = Literal["springs", "all"]
Value = str | float | int | bool


@dataclass(frozen=True)
class Axis:
    """A value of the scene that a study varies.

    name : column of cases.csv, dimension of study.nc.
    keys : keys of the scene that take the value.
    values : the values of a list or range, as TOML has them; none for a sampled axis.
    low, high, unit, log : ends of a sampled axis in its unit ("" for a pure number), and whether its logarithm varies.
    place : line and column in the study file.
    words : what the words among its values stand for: those of a range.
    """

    name: str
    keys: tuple[str, ...]
    values: tuple[Value, ...] = ()
    low: float = math.nan
    high: float = math.nan
    unit: str = ""
    log: bool = False
    place: tuple[int, int] | None = None
    words: Mapping[Any, Any] = field(default_factory=dict)

    def at(self, share: float) -> Value:
        """Return the value at a share of the way between the ends, rounded to `DIGITS` figures."""
        ratio, way = self.high / self.low if self.log else 1.0, self.high - self.low
        number = self.low * ratio**share if self.log else self.low + share * way
        return quantity(float(f"{number:.{DIGITS}g}"), self.unit)


@dataclass(frozen=True)
class Case:
    """A row of a study: its number from 1, a value for each axis, and its line in the table that it comes from."""

    number: int
    values: tuple[Value, ...]
    line: int | None = field(default=None, compare=False)

    @property
    def id(self) -> str:
        """Name in tables and messages."""
        return f"{self.number:05d}"


@dataclass(frozen=True)
class Plan:
    """What a study runs.

    file, title : of the study.
    scene : text of the base scene.
    axes, cases : what varies, and the rows.
    keep : the files of a case: its springs and record alone, or all files of a run.
    is_grid : whether the cases are all combinations of the values of the axes.
    from_file : whether the values come from cases.csv or a table, not from the axes.
    """

    file: str
    title: str
    scene: SceneText
    axes: tuple[Axis, ...]
    cases: tuple[Case, ...]
    keep: Keep = "springs"
    is_grid: bool = True
    from_file: str = ""

    @property
    def digest(self) -> str:
        """Number of what the study file asks for, the base scene included."""
        axes = [(axis.name, axis.keys) for axis in self.axes]
        whole = [self.scene.text, axes, [case.values for case in self.cases]]
        return hashlib.sha256(json.dumps(whole).encode()).hexdigest()

    def changes(self, case: Case) -> list[Change]:
        """Return what a case changes in the base scene."""
        pairs = zip(self.axes, case.values, strict=True)
        return [
            Change(tuple(key.split(".")), axis.words.get(value, value)) for axis, value in pairs for key in axis.keys
        ]

    def scene_of(self, case: Case) -> Scene:
        """Return the scene of a case. Raises UserInputError."""
        return self.scene.scene(self.changes(case))

    def checked(self) -> tuple[list[str], list[str]]:
        """Return the folder name of every case, and sentences on values beyond their common range.

        A name is the first letters of the number of the scene; a sentence stands once, at the first case that has it.
        Raises UserInputError: the values of a case make no scene; every problem once, at its axis or its row.
        """
        names, odd, problems = [], dict[str, str](), dict[tuple[Any, ...], Problem]()
        for case in self.cases:
            try:
                scene = self.scene_of(case)
                names.append(scene.sha256[:16])
                for text in implausible(scene):
                    odd.setdefault(text, f"case {case.id}: {text}")
                found = self._formulas(case)
            except UserInputError as error:
                found = [*error.problems]
            for each in found:
                problem = self._placed(each, case)
                problems.setdefault((problem.line, problem.key, problem.message), problem)
        if problems:
            raise UserInputError(sorted(problems.values(), key=lambda each: each.line or 0))
        return names, list(odd.values())

    def _formulas(self, case: Case) -> list[Problem]:
        """Return a problem for each text of a case that a spreadsheet would take for a formula: cases.csv holds it."""
        words = "begins as a formula does: with = + - or @"
        return [
            Problem(OPTION, key=f"{OPTION} {axis.keys[0]}", message=f"{quoted(value)} {words}")
            for axis, value in zip(self.axes, case.values, strict=True)
            if isinstance(value, str) and is_formula(value)
        ]

    def _placed(self, problem: Problem, case: Case) -> Problem:
        """Return a problem of a case at the axis, or the row, that its value comes from."""
        if problem.file != OPTION and not (problem.key or "").startswith(OPTION):
            return problem
        key = (problem.key or "").removeprefix(OPTION).strip()
        axis = next((each for each in self.axes if any(_same(key, own) for own in each.keys)), None)
        text = f"case {case.id}: {problem.message}"
        if self.from_file:
            return Problem(self.from_file, case.line, None, key, text)
        line, col = (axis.place if axis else None) or (None, None)
        return Problem(self.file, line, col, key, text if axis is None else problem.message)


def _same(key: str, own: str) -> bool:
    """Return whether a key of a message, with list numbers for names, is that of an axis."""
    a, b = key.replace("[", ".").replace("]", "").split("."), own.split(".")
    return a[0] == b[0] and (a[-1] == b[-1] or (len(b) > 1 and b[-2] in a[1:]))


def quantity(number: float, unit: str) -> Value:
    """Return a value as TOML has it: a text with its unit, or a pure number (whole ones without a point)."""
    text = f"{number:.12g}"
    if unit:
        return f"{text} {unit}"
    return int(text) if text.lstrip("-").isdigit() else float(text)


def split(value: Value) -> tuple[float | str, str]:
    """Return number and unit of a value; a word stays as it is."""
    if isinstance(value, bool) or not isinstance(value, str):
        return (str(value).lower(), "") if isinstance(value, bool) else (value, "")
    head, _, unit = value.strip().partition(" ")
    try:
        return float(head), unit.strip()
    except ValueError:
        return value, ""


def grid(axes: Sequence[Axis]) -> tuple[Case, ...]:
    """Return all combinations of the values of the axes; the last axis varies first."""
    rows = itertools.product(*(axis.values for axis in axes))
    return tuple(Case(k + 1, tuple(row)) for k, row in enumerate(rows))


def latin_hypercube(axes: Sequence[Axis], cases: int, seed: int) -> tuple[Case, ...]:
    """Return cases of a Latin hypercube (McKay, Beckman & Conover 1979) between the ends of the axes."""
    from scipy.stats import qmc

    shares = qmc.LatinHypercube(len(axes), seed=np.random.default_rng(seed)).random(cases)
    rows = ([axis.at(float(share)) for axis, share in zip(axes, row, strict=True)] for row in shares)
    return tuple(Case(k + 1, tuple(row)) for k, row in enumerate(rows))


def one_at_a_time(scene: SceneText) -> tuple[tuple[Axis, ...], tuple[Case, ...]]:
    """Return an axis for each range of a scene, and its cases: all best, then one low or high at a time.

    Raises UserInputError where no value has a range.
    """
    axes: list[Axis] = []
    ranges, layers = scene.ranges, {name: str(k) for k, name in enumerate(scene.layers, start=1)}
    short = [_short(keys) for keys, _ in ranges]
    for (keys, table), name in zip(ranges, short, strict=True):
        if short.count(name) > 1:  # cut to the same letters
            name = _short([*keys[:2], *(layers.get(each, each) for each in keys[2:3]), *keys[3:]])
        name = f"{name}_{len(axes) + 1}" if name in [each.name for each in axes] else name
        axes.append(Axis(name, (".".join(keys),), ESTIMATES, words=table))
    if not axes:
        raise refused("sampling.method", "no value of the scene has a range { low, best, high }")
    rows = [["best"] * len(axes)]
    for k in range(len(axes)):
        rows += [[end if j == k else "best" for j in range(len(axes))] for end in ("low", "high")]
    return tuple(axes), tuple(Case(k + 1, tuple(row)) for k, row in enumerate(rows))


def _short(keys: Sequence[str]) -> str:
    """Return the name of an axis from the keys of a value: that of its layer, cut, or "layer_2" of a number."""
    left = {"soil"} if any(each.isdigit() for each in keys) else {"soil", "layer"}
    *above, key = (re.sub(r"\W+", "_", each) for each in keys if each not in left)
    return f"{'_'.join(above)[: 36 - len(key)]}_{key}".lstrip("_0123456789")


def span(axis: Axis, count: int) -> tuple[Value, ...]:
    """Return evenly spaced values from one end of an axis to the other."""
    return tuple(axis.at(k / (count - 1)) for k in range(count)) if count > 1 else (axis.at(0.0),)


CASES = "cases.csv"
SCHEMA = "pysprings-study-3"  # of study.nc, and of what a case holds
DONE, SHORT, FAILED, STOPPED, WAITING, SKIP, AGAIN = (
    "complete", "partial", "failed", "stopped", "waiting", "skip", "again",
)  # fmt: skip
OPEN = (WAITING, STOPPED)  # of cases that are still to be run


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
    return write_text(stream.getvalue(), folder / CASES)


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
    file = folder / CASES
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
            value = table.number(key, cell)
            values.append(text if value is None else quantity(value, unit))
            if value is None:
                table.fault(k, key, "blank: every case needs a value")
        except NotANumber as error:
            if not str(error).endswith("is not a number"):  # a word or a quantity is, for the scene to check
                table.fault(k, key, str(error))
            values.append(text)
    return values
