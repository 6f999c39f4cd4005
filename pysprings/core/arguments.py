# SPDX-License-Identifier: MIT
"""Checks of the numbers that Python callers pass in."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from pysprings.core.arrays import Array, Marks
from pysprings.core.errors import Problem, UserInputError
from pysprings.core.tables.headings import is_unit, split
from pysprings.core.units import QuantityError, quoted, unit_of

_SI = ("N", "N m", "m", "rad", "s")  # units of the numbers that callers pass in


def check_numbers(**values: Any) -> None:
    """Raise UserInputError, by name, for what is not one finite number (None: not given)."""
    _raise({name: _number_fault(name, value, arrays=False) for name, value in values.items()})


def check_arrays(**values: Any) -> None:
    """Raise UserInputError, by name, for what is neither a finite number nor an array of them (None: not given)."""
    _raise({name: _number_fault(name, value, arrays=True) for name, value in values.items()})


def check_shapes(**values: Any) -> None:
    """Raise UserInputError for what is no number (None: not given) or column, and columns that do not go together."""
    shapes = {name: np.shape(value) for name, value in values.items() if value is not None}
    _raise({name: f"give a column (n,), not the shape {shape}" for name, shape in shapes.items() if len(shape) > 1})
    try:
        np.broadcast_shapes(*shapes.values())
    except ValueError:
        have = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
        _raise({next(iter(shapes)): f"give arrays of one shape, or single numbers; here {have}"})
    first: dict[str, tuple[str, dict[Any, Any]]] = {}
    for name, value in values.items():
        kind, labels = _labels(value)
        beside, own = first.setdefault(kind, (name, labels))
        if labels and not _alike(labels, own):
            _raise({name: f"{kind} differ from those of {beside}, and numbers are taken by place: align them first"})


def _labels(value: Any) -> tuple[str, dict[Any, Any]]:
    """Return what the labels of an array are called, and its indexes by dimension (None: unlabelled); else nothing."""
    if dims := getattr(value, "dims", ()):  # of xarray
        return "dimensions or coordinates", {dim: value.indexes.get(dim) for dim in dims}
    index = getattr(value, "index", None)  # of pandas; a list has a method of this name
    return "row labels", {"row": index} if hasattr(index, "equals") else {}


def _alike(labels: dict[Any, Any], others: dict[Any, Any]) -> bool:
    pairs = ((labels[dim], others.get(dim)) for dim in labels)
    return list(labels) == list(others) and all(a is None or b is None or a.equals(b) for a, b in pairs)


def too_early(time: Array, rows: Array) -> Marks:
    """Return which times (n,) [s] do not grow from 0; a first row (n, m) of zeros is at rest, and may be at 0 s."""
    steps = np.diff(time, prepend=0.0)
    found: Marks = steps <= 0.0
    found[:1] &= rows[:1].any() or steps[:1] < 0.0
    return found


def check_columns(targets: Any, names: Sequence[str]) -> None:
    """Raise UserInputError where a table of pandas has columns of these names at other places, or in other units.

    Labels are those of tables: "H", "H [N]", "H_N".
    """
    own = []
    for label in map(str, getattr(targets, "columns", ())):
        name, unit = _parted(label, names)
        own.append(name or label.partition(" ")[0])
        _raise({"targets": _unit_fault(unit)})
    if set(own) & set(names) and own[: len(names)] != list(names):
        _raise({"targets": f"numbers are taken by place: give the columns {', '.join(names)}, not {', '.join(own)}"})


def _parted(label: Any, names: Sequence[str]) -> tuple[str, str | None]:
    """Return which of names a label has (blank: none), and its unit: in brackets, or behind the name."""
    for stem, unit in split(label) if isinstance(label, str) else ():
        name = next((each for each in names if each == stem.replace(" ", "_")), "")
        if (name or label.rstrip()[-1:] in "])") and (unit is None or is_unit(unit)):
            return name, unit
    return "", None


def check_rows(rows: Array, V: Any, time: Any) -> None:
    """Raise UserInputError for a V that is neither one number nor one of each row (n, m), and times `too_early`."""
    bad, n = [], len(rows)
    if V is not None and np.shape(V) not in ((), (n,)):
        bad.append(
            Problem(key="V", message=f"give one number, or one a row of targets ({n}), not the shape {np.shape(V)}")
        )
    if time is not None and (np.shape(time) != (n,) or too_early(np.asarray(time), rows).any()):
        bad.append(Problem(key="time", message=f"give one number a row of targets ({n}), growing from 0 s"))
    if bad:
        raise UserInputError(bad)


def _raise(faults: dict[str, str]) -> None:
    if bad := [Problem(key=name, message=message) for name, message in faults.items() if message]:
        raise UserInputError(bad)


def _number_fault(name: str, value: Any, arrays: bool) -> str:
    """Return why the value of an argument is no finite number in SI units; empty where it is one, or None."""
    if value is None:
        return ""
    if isinstance(value, str):
        return f"{quoted(value)} is a text: give a number in SI units (N, m, rad, N m)"
    if np.ma.is_masked(value):
        return "has masked values: leave them out"
    if fault := _unit_fault(getattr(value, "units", _parted(getattr(value, "name", None), [name])[1])):
        return fault
    data = np.asarray(value)
    if data.dtype.kind not in "iuf":
        return f"a number is needed, not {type(value).__name__}"
    if data.ndim and not arrays:
        return "one number is needed, not an array (`predict_batch` takes arrays)"
    return "" if np.isfinite(data).all() else "not a finite number"


def _unit_fault(unit: Any) -> str:
    """Return a sentence on the unit of a number (of pint; of an array of xarray; of a label) that is no SI unit."""
    try:
        if unit is None or unit_of(str(unit)) in [unit_of(each) for each in _SI]:
            return ""
    except QuantityError:
        pass
    return f"has the unit {quoted(str(unit))}: give numbers in SI units (N, m, rad, N m)"
