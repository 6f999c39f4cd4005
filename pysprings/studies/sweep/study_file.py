# SPDX-License-Identifier: MIT
"""Study files: TOML text -> `Plan`, or every problem at once with file, line and key.

title = "..."                       # of tables and pictures
scene = "base.toml"                 # scene file, relative to the study file
keep = "springs"                    # or "all": every file of a run
cases = "cases.csv"                 # a table in place of axes: a heading KEY or KEY [unit] a column

[sampling]                          # without it: all combinations of the axes
method = "latin-hypercube"
cases = 80
seed = 1

[[axis]]
key = "caisson.skirt_length"        # or keys = [...], which take the same value
name = "length"                     # by default the last part of the key
values = ["4 m", "6 m"]             # a list; or
from = "2 m"                        # a range: count = 5; spacing = "log" by ratio
to = "8 m"
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pysprings.core.errors import Problem, UserInputError, refused
from pysprings.core.units import QuantityError, quoted, unit_of
from pysprings.scene.fields import suggestion
from pysprings.scene.load import SceneText
from pysprings.scene.positions import KeyPath, Place, TooDeep, locate, nearest, refuse_depth
from pysprings.studies.sweep import plan as plans
from pysprings.studies.sweep.plan import Axis, Plan

MOST_CASES = 1_000_000
MAX_BYTES = 256 * 1024
METHOD = "latin-hypercube"
_TOP = ("title", "scene", "keep", "cases", "sampling", "axis")
_AXIS = ("key", "keys", "name", "values", "from", "to", "count", "spacing")
_SAMPLING = ("method", "cases", "seed")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
# columns of cases.csv and variables of study.nc
TAKEN = ("id", "status", "reason", "seconds", "hash", "case", "ray", "reach", "depth", "dof", "dof_conjugate")


class _Reader:
    """Reads the tables of a study and gathers what is wrong with them."""

    def __init__(self, file: Path, data: dict[str, Any], places: dict[KeyPath, Place]) -> None:
        self.file, self.data, self.places = file, data, places
        self.problems: list[Problem] = []

    def fault(self, path: KeyPath, message: str, key: bool = False) -> None:
        """Note a problem at a key path."""
        place = nearest(self.places, path)
        line, col = place.key if key else place.value
        name = ".".join(str(part + 1 if isinstance(part, int) else part) for part in path)
        self.problems.append(Problem(str(self.file), line, col, name, message))

    def known(self, table: Any, path: KeyPath, words: Sequence[str]) -> bool:
        """Note unknown keys of a table; return whether it is a table."""
        if not isinstance(table, dict):
            self.fault(path, "expected a table")
            return False
        for key in [each for each in table if each not in words]:
            self.fault((*path, key), f"unknown key{suggestion(key, words)}", key=True)
        return True

    def text(self, table: dict[str, Any], path: KeyPath, default: str = "") -> str:
        """Return a text of a table."""
        value = table.get(str(path[-1]), default)
        if not isinstance(value, str):
            self.fault(path, f"expected a text in quotes, got {quoted(value)}")
            return default
        return value

    def whole(self, table: dict[str, Any], path: KeyPath, low: int, high: int, default: int) -> int:
        """Return a whole number of a table."""
        value = table.get(str(path[-1]), default)
        if isinstance(value, bool) or not isinstance(value, int):
            self.fault(path, f"expected a whole number such as {low}, got {quoted(value)}")
            return default
        if not low <= value <= high:
            self.fault(path, f"{value} is not in [{low}, {high}]")
            return default
        return value


def read_study(path: Path) -> Plan:
    """Read a study file, its base scene, and its table of cases if any.

    Raises
    ------
    UserInputError
        One problem per thing that is wrong with the study; those of its base scene come first.
    """
    reader = _open(path)
    reader.known(reader.data, (), _TOP)
    name = reader.text(reader.data, ("scene",))
    if not name:
        reader.fault(("scene",), "missing: the file of the base scene")
        raise UserInputError(reader.problems)
    scene = SceneText.read(path.parent / name)
    scene.scene()
    title = reader.text(reader.data, ("title",), path.stem)
    keep = reader.text(reader.data, ("keep",), "springs")
    if keep not in ("springs", "all"):
        reader.fault(("keep",), f'{quoted(keep)} is not one of "springs", "all"')
    if "cases" in reader.data:
        return _tabled(reader, path, title, scene, keep)
    sampled = "sampling" in reader.data
    axes = _axes(reader, sampled)
    method = _sampling(reader) if sampled else (0, 0)
    if not reader.problems and not sampled:
        _few(reader, axes)
    if reader.problems:
        raise UserInputError(reader.problems)
    cases = plans.latin_hypercube(axes, *method) if sampled else plans.grid(axes)
    return Plan(str(path), title, scene, axes, cases, "all" if keep == "all" else "springs", not sampled)


def _open(path: Path) -> _Reader:
    """Return the reader of a study file."""
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise refused(None, f"cannot be read ({error.strerror})", path) from None
    if len(raw) > MAX_BYTES:
        raise refused(None, f"is too large for a study (more than {MAX_BYTES // 1024} KiB)", path)
    try:
        text = raw.decode("utf-8-sig")
        refuse_depth(text)
        return _Reader(path, tomllib.loads(text), locate(text))
    except UnicodeDecodeError:
        raise refused(None, "is not UTF-8 text", path) from None
    except TooDeep as error:
        raise UserInputError([Problem(str(path), *error.place, message=str(error))]) from None
    except (ValueError, RecursionError) as error:
        raise refused(None, f"not valid TOML: {error}", path) from None


def _few(reader: _Reader, axes: Sequence[Axis]) -> None:
    number = 1
    for axis in axes:
        number *= len(axis.values)
    if number > MOST_CASES:
        reader.fault(("axis",), f"{number:,} combinations; a study has {MOST_CASES:,} cases at most")


def _sampling(reader: _Reader) -> tuple[int, int]:
    """Return number of cases and seed of a sample."""
    table = reader.data["sampling"]
    if not reader.known(table, ("sampling",), _SAMPLING):
        return 1, 0
    if (method := table.get("method")) != METHOD:
        reader.fault(("sampling", "method"), f'expected "{METHOD}", got {quoted(method)}')
    for key in ("cases", "seed"):
        if key not in table:
            reader.fault(("sampling", key), "missing: the same sample needs its number of cases and its seed")
    cases = reader.whole(table, ("sampling", "cases"), 1, MOST_CASES, 1)
    return cases, reader.whole(table, ("sampling", "seed"), 0, 2**32 - 1, 0)


def _axes(reader: _Reader, sampled: bool) -> tuple[Axis, ...]:
    tables = reader.data.get("axis", [])
    if not isinstance(tables, list) or not tables:
        reader.fault(("axis",), "expected [[axis]] sections (double brackets): what the study varies")
        return ()
    axes = [axis for number, table in enumerate(tables) if (axis := _axis(reader, table, number, sampled))]
    for number, axis in enumerate(axes):
        if axis.name in [each.name for each in axes[:number]]:
            reader.fault(("axis", number), f"the name '{axis.name}' is that of another axis; give name = \"...\"")
    return tuple(axes)


def _axis(reader: _Reader, table: Any, number: int, sampled: bool) -> Axis | None:
    """Return an axis; None where something is wrong with it."""
    at: KeyPath = ("axis", number)
    before = len(reader.problems)
    if not reader.known(table, at, _AXIS):
        return None
    keys = table.get("keys", [table["key"]] if "key" in table else [])
    if not keys or not isinstance(keys, list) or not all(isinstance(key, str) and key for key in keys):
        reader.fault((*at, "key"), 'expected a key of the scene such as "caisson.skirt_length"')
        return None
    name = reader.text(table, (*at, "name"), keys[0].split(".")[-1])
    if not _NAME.fullmatch(name) or name in TAKEN:
        reader.fault((*at, "name"), f"{quoted(name)} is no name of an axis (a letter, then letters, digits or _)")
    place = nearest(reader.places, (*at, "values" if "values" in table else "from")).key
    if "values" in table:
        axis = _listed(reader, table, at, sampled, Axis(name, tuple(keys), place=place))
    else:
        axis = _ranged(reader, table, at, sampled, Axis(name, tuple(keys), place=place))
    return axis if len(reader.problems) == before else None


def _listed(reader: _Reader, table: dict[str, Any], at: KeyPath, sampled: bool, axis: Axis) -> Axis:
    """Return an axis with a list of values."""
    values = table["values"]
    for key in ("from", "to", "count", "spacing"):
        if key in table:
            reader.fault((*at, key), "give either values, or from and to", key=True)
    if sampled:
        reader.fault((*at, "values"), "a sample needs from and to", key=True)
    if not isinstance(values, list) or not values:
        reader.fault((*at, "values"), 'expected a list such as ["4 m", "6 m"]')
        return axis
    for number, value in enumerate(values):
        if not isinstance(value, str | int | float | bool):
            reader.fault((*at, "values", number), f"expected a text or a number, got {quoted(value)}")
        elif value in values[:number]:
            reader.fault((*at, "values", number), f"{quoted(value)} stands in the list already")
    return Axis(axis.name, axis.keys, tuple(values), place=axis.place)


def _ranged(reader: _Reader, table: dict[str, Any], at: KeyPath, sampled: bool, axis: Axis) -> Axis:
    """Return an axis from one end to the other."""
    if not {"from", "to"} <= set(table):
        reader.fault(at, "an axis needs values, or from and to")
        return axis
    (low, unit), (high, other) = (plans.split(table[key]) for key in ("from", "to"))
    if isinstance(low, str) or isinstance(high, str):
        reader.fault((*at, "from"), "expected a number, with its unit in quotes, at both ends")
        return axis
    known = len(reader.problems)
    high = _in_unit(reader, (*at, "to"), high, other, unit)
    if len(reader.problems) == known and not low < high:
        reader.fault((*at, "to"), f"must be above from ({low:g} {unit})".replace(" )", ")"))
    spacing = reader.text(table, (*at, "spacing"), "linear")
    if spacing not in ("linear", "log"):
        reader.fault((*at, "spacing"), f'{quoted(spacing)} is not one of "linear", "log"')
    if spacing == "log" and low <= 0.0:
        reader.fault((*at, "from"), 'must be positive where spacing is "log"')
    ends = Axis(axis.name, axis.keys, (), low, high, unit, spacing == "log", axis.place)
    if sampled:
        if "count" in table:
            reader.fault((*at, "count"), "a sample has its number of cases in [sampling]", key=True)
        return ends
    if "count" not in table:
        reader.fault(at, "a range needs count, its number of values")
        return ends
    count = reader.whole(table, (*at, "count"), 2, MOST_CASES, 2)
    if reader.problems:
        return ends
    return Axis(axis.name, axis.keys, plans.span(ends, count), low, high, unit, ends.log, axis.place)


def _in_unit(reader: _Reader, path: KeyPath, number: float, unit: str, wanted: str) -> float:
    """Return a number in another unit of the same dimension."""
    if unit == wanted:
        return number
    try:
        (scale, dimension), (other, same) = (unit_of(each) for each in (unit, wanted))
    except QuantityError as error:
        reader.fault(path, str(error))
        return number
    if dimension != same:
        reader.fault(path, f"{quoted(unit)} and {quoted(wanted)} are units of different quantities")
        return number
    return float(f"{number * scale / other:.15g}")


def _tabled(reader: _Reader, path: Path, title: str, scene: SceneText, keep: str) -> Plan:
    """Return the plan of a study whose cases stand in a table."""
    from pysprings.studies.sweep.cases_file import read_table

    for key in ("axis", "sampling"):
        if key in reader.data:
            reader.fault((key,), "give either cases = FILE or [[axis]] sections", key=True)
    name = reader.text(reader.data, ("cases",))
    if reader.problems:
        raise UserInputError(reader.problems)
    axes, cases = read_table(path.parent / name)
    kept: plans.Keep = "all" if keep == "all" else "springs"
    return Plan(str(path), title, scene, axes, cases, kept, False, str(path.parent / name))
