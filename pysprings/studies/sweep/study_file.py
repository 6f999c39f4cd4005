# SPDX-License-Identifier: MIT
"""Study files: TOML text -> `Plan`, or every problem at once with file, line and key.

title = "..."                       # of tables and pictures
scene = "base.toml"                 # scene file, relative to the study file
keep = "springs"                    # or "all": every file of a run
cases = "cases.csv"                 # a table in place of axes: a heading KEY or KEY [unit] a column

[sampling]                          # without it: all combinations of the axes
method = "latin-hypercube"          # or "one-at-a-time": each range of the scene from low to high, without axes
cases = 80
seed = 1

[[axis]]
key = "caisson.skirt_length"        # or keys = [...], which take the same value
name = "length"                     # by default the last part of the key
values = ["4 m", "6 m"]             # a list; or
from = "2 m"                        # a range: count = 5; spacing = "log" by ratio
to = "8 m"
"""

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field as Named, ValidationError

from pysprings.core.errors import Problem, UserInputError
from pysprings.core.text import suggestion
from pysprings.core.units import QuantityError, quoted, unit_of
from pysprings.scene.fields import Choice, Count, Text
from pysprings.scene.load import SceneText, read_text, toml_of
from pysprings.scene.positions import KeyPath, nearest
from pysprings.scene.sections import Section
from pysprings.studies.sweep import plan as plans
from pysprings.studies.sweep.dataset import NAMES
from pysprings.studies.sweep.plan import Axis, Keep, Plan, read_table

MOST_CASES = 1_000_000
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
TAKEN = ("id", "status", "reason", "seconds", "hash", *NAMES)  # columns of cases.csv, and what study.nc has
# Sections of a study file; what must not be missing is noted by the checks, so that all comes at once
_Word = Annotated[str, Text("a name")]
_Cases = Annotated[int | None, Count(1, MOST_CASES, "number of cases")]
_Seed = Annotated[int | None, Count(0, 2**32 - 1, "seed")]
_Values = Annotated[int | None, Count(2, MOST_CASES, "number of values")]


class Sampling(Section):
    """The section [sampling]."""

    method: Annotated[str, Choice(("latin-hypercube", "one-at-a-time"), "how cases are chosen")] = ""
    cases: _Cases = None
    seed: _Seed = None


class AxisTable(Section):
    """A section [[axis]]."""

    key: _Word = ""
    keys: tuple[_Word, ...] = ()
    name: _Word = ""
    values: list[Any] | None = None
    low: Annotated[Any, Named(alias="from")] = None
    to: Any = None
    count: _Values = None
    spacing: Annotated[str, Choice(("linear", "log"), "how values are spaced")] = "linear"


class StudyFile(Section):
    """A whole study file."""

    title: _Word = ""
    scene: _Word = ""
    keep: Annotated[Keep, Choice(("springs", "all"), "files of a case that are kept")] = "springs"
    cases: _Word = ""
    sampling: Sampling | None = None
    axis: tuple[AxisTable, ...] = ()


_TABLES: dict[Any, type[Section]] = {"axis": AxisTable, "sampling": Sampling}
_EXPECTED: dict[Any, str] = {
    "axis": "[[axis]] sections (double brackets): what the study varies", "sampling": "a table [sampling]",
    "values": 'a list such as ["4 m", "6 m"]', "keys": "a list of keys of the scene",
}  # fmt: skip


def read_study(path: Path) -> Plan:
    """Read a study file, its base scene, and its table of cases if any.

    Raises UserInputError: one problem per thing that is wrong with the study; those of its base scene come first.
    """
    reader = _Reader(path)
    if not reader.study.scene:
        reader.fault(("scene",), "missing: the file of the base scene")
        reader.stop()
    scene = SceneText.read(path.parent / reader.study.scene)
    scene.scene()
    title, keep = reader.study.title or path.stem, reader.study.keep
    if "cases" in reader.data:
        table = path.parent / reader.table_of_cases()
        return Plan(str(path), title, scene, *read_table(table), keep, False, str(table))
    sample = reader.study.sampling
    if sample is not None and sample.method == "one-at-a-time":
        for key in {"axis"} & reader.data.keys():
            reader.fault((key,), "one-at-a-time varies the ranges of the scene: no [[axis]]", key=True)
        reader.stop()
        return Plan(str(path), title, scene, *plans.one_at_a_time(scene), keep, False)
    axes = reader.axes()
    if sample is None:
        number = math.prod(len(axis.values) for axis in axes)
        if not reader.problems and number > MOST_CASES:
            reader.fault(("axis",), f"{number:,} combinations; a study has {MOST_CASES:,} cases at most")
        reader.stop()
        return Plan(str(path), title, scene, axes, plans.grid(axes), keep)
    for key in ("method", "cases", "seed"):
        if key not in reader.data["sampling"]:
            reader.fault(("sampling", key), "missing: the same sample needs its method, number of cases and seed")
    reader.stop()
    cases = plans.latin_hypercube(axes, sample.cases or 1, sample.seed or 0)
    return Plan(str(path), title, scene, axes, cases, keep, False)


class _Reader:
    """The tables of a study file, as far as they are right, and what is wrong with them."""

    def __init__(self, file: Path) -> None:
        self.file, self.problems = file, list[Problem]()
        self.data, self.places = toml_of(read_text(file, "study"), str(file))
        try:
            self.study = StudyFile.model_validate(self.data)
        except ValidationError as error:
            right = toml_of(read_text(file, "study"), str(file))[0]
            for item in reversed(error.errors(include_url=False)):
                self._refuse(item, right)
            self.study = StudyFile.model_validate(right)

    def _refuse(self, item: Any, right: dict[str, Any]) -> None:
        """Note an error of pydantic, and leave its key out of what is right."""
        path: KeyPath = item["loc"]
        section = _TABLES.get(path[0], StudyFile) if len(path) > 1 else StudyFile
        if item["type"] == "extra_forbidden":
            known = [str(info.alias or name) for name, info in section.model_fields.items()]
            self.fault(path, f"unknown key{suggestion(str(path[-1]), known)}", key=True)
        elif item["type"] == "scene":
            self.fault(path, item["ctx"]["message"])
        else:
            self.fault(path, f"expected {_EXPECTED.get(path[-1], 'a table')}, got {quoted(item['input'])}")
        own = path[:3] if path[0] == "axis" and len(path) > 2 else path[: 2 if path[0] == "sampling" else 1]
        table: Any = right
        for part in own[:-1]:
            table = table[part]
        table.pop(own[-1], None)

    def fault(self, path: KeyPath, message: str, key: bool = False) -> None:
        """Note a problem at a key path."""
        place = nearest(self.places, path)
        line, col = place.key if key else place.value
        name = ".".join(str(part + 1 if isinstance(part, int) else part) for part in path)
        self.problems.append(Problem(str(self.file), line, col, name, message))

    def stop(self) -> None:
        """Raise UserInputError where there is any problem."""
        if self.problems:
            raise UserInputError(sorted(self.problems, key=lambda each: (each.line or 0, each.col or 0)))

    def table_of_cases(self) -> str:
        """Return the name of the table of cases."""
        for key in ("axis", "sampling"):
            if key in self.data:
                self.fault((key,), "give either cases = FILE or [[axis]] sections", key=True)
        self.stop()
        return self.study.cases

    def axes(self) -> tuple[Axis, ...]:
        """Return the axes that are right; note what is wrong with the others."""
        if "axis" not in self.data:
            self.fault(("axis",), f"expected {_EXPECTED['axis']}")
        axes: list[Axis] = []
        for number, table in enumerate(self.study.axis):
            axis = self._axis(table, ("axis", number))
            if axis.name in [each.name for each in axes if axis.name]:
                self.fault(("axis", number), f"the name '{axis.name}' is that of another axis; give name = \"...\"")
            axes.append(axis)
        return tuple(axes)

    def _axis(self, table: AxisTable, at: KeyPath) -> Axis:
        keys = table.keys or tuple(filter(None, [table.key]))
        if not keys:
            self.fault((*at, "key"), 'expected a key of the scene such as "caisson.skirt_length"')
            return Axis("", ())
        name = table.name or keys[0].split(".")[-1]
        if name in TAKEN:
            self.fault((*at, "name"), f'{quoted(name)} is taken by the files of a study; give name = "..."')
        elif not _NAME.fullmatch(name):
            self.fault((*at, "name"), f"{quoted(name)} is no name of an axis (a letter, then letters, digits or _)")
        listed, sampled = table.values is not None, self.study.sampling is not None
        axis = Axis(name, keys, place=nearest(self.places, (*at, "values" if listed else "from")).key)
        odd = dict.fromkeys(("from", "to", "count", "spacing"), "give either values, or from and to") if listed else {}
        if sampled:
            odd |= {"count": "a sample has its number of cases in [sampling]", "values": "a sample needs from and to"}
        for key in odd.keys() & self.data["axis"][at[1]].keys():
            self.fault((*at, key), odd[key], key=True)
        return self._listed(table.values or [], at, axis) if listed else self._ranged(table, at, axis)

    def _listed(self, values: list[Any], at: KeyPath, axis: Axis) -> Axis:
        """Return an axis with a list of values."""
        if not values:
            self.fault((*at, "values"), f"expected {_EXPECTED['values']}")
        for number, value in enumerate(values):
            if not isinstance(value, str | int | float | bool):
                self.fault((*at, "values", number), f"expected a text or a number, got {quoted(value)}")
            elif value in values[:number]:
                self.fault((*at, "values", number), f"{quoted(value)} stands in the list already")
        return replace(axis, values=tuple(values))

    def _ranged(self, table: AxisTable, at: KeyPath, axis: Axis) -> Axis:
        """Return an axis from one end to the other."""
        if table.low is None or table.to is None:
            self.fault(at, "an axis needs values, or from and to")
            return axis
        (low, unit), (high, other) = (plans.split(each) for each in (table.low, table.to))
        if not isinstance(low, float | int) or not isinstance(high, float | int):
            self.fault((*at, "from"), "expected a number, with its unit in quotes, at both ends")
            return axis
        before, log = len(self.problems), table.spacing == "log"
        high = self._in_unit((*at, "to"), high, other, unit)
        if len(self.problems) == before and not low < high:
            self.fault((*at, "to"), f"must be above from ({low:g} {unit})".replace(" )", ")"))
        if log and low <= 0.0:
            self.fault((*at, "from"), 'must be positive where spacing is "log"')
        axis = replace(axis, low=low, high=high, unit=unit, log=log)
        if self.study.sampling is None and "count" not in self.data["axis"][at[1]]:
            self.fault(at, "a range needs count, its number of values")
        return replace(axis, values=plans.span(axis, table.count)) if table.count and not self.problems else axis

    def _in_unit(self, path: KeyPath, number: float, unit: str, wanted: str) -> float:
        """Return a number in another unit of the same dimension."""
        if unit == wanted:
            return number
        try:
            (scale, dimension), (other, same) = (unit_of(each) for each in (unit, wanted))
        except QuantityError as error:
            self.fault(path, str(error))
            return number
        if dimension != same:
            self.fault(path, f"{quoted(unit)} and {quoted(wanted)} are units of different quantities")
            return number
        return float(f"{number * scale / other:.15g}")
