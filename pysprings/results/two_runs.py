# SPDX-License-Identifier: MIT
"""Two runs beside each other: what differs in their scenes, initial stiffness, paths and limit loads."""

import math
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr

from pysprings.core.arrays import Array
from pysprings.core.loads import same_load
from pysprings.core.path_kinds import height_of_load
from pysprings.core.text import number, percent
from pysprings.core.variables import EXTRAPOLATED, known_torsion
from pysprings.full_model.run_record import RunRecord
from pysprings.macro.measures import carried
from pysprings.results.parts import node
from pysprings.springs.path import RecordedPath, SpacePath, is_rate, paths_of, space_paths_of
from pysprings.springs.path_ends import RESIDUAL, before_cavitation, end_of

POINTS = 200  # of the range that both paths have, where their loads are compared


@dataclass(frozen=True)
class Run:
    """A run: its name, full-model result and record."""

    name: str
    result: xr.DataTree
    record: RunRecord


@dataclass(frozen=True, slots=True)
class Row:
    """A quantity of both runs: numbers in its unit, or texts; change [%] of the second to the first of numbers."""

    part: str
    quantity: str
    first: str | float
    second: str | float
    change: float | None = None
    unit: str = ""

    @property
    def cells(self) -> tuple[str, str, str, str]:
        """Part, quantity with its unit, and both values as texts."""
        unit = f" [{self.unit}]" if self.unit else ""
        return self.part, f"{self.quantity}{unit}", number(self.first, 5), number(self.second, 5)


def differences(first: Run, second: Run) -> list[Row]:
    """Return the rows of a comparison: keys of the scenes that differ, and the numbers of both runs."""
    return [*_scene(first, second), *_setting(first, second), *_stiffness(first, second), *_paths(first, second)]


def common_paths(first: Run, second: Run) -> list[str]:
    """Return the names of the paths in a plane that both runs have, of one kind and sense, beyond the initial state."""
    others = paths_of(second.result)
    return [
        name for name, path in paths_of(first.result).items()
        if name in others and path.kind == others[name].kind and min(path.n, others[name].n) > 1
        and farthest(path[path.rules.drives]) * farthest(others[name][path.rules.drives]) > 0.0
    ]  # fmt: skip


def _scene(first: Run, second: Run) -> Iterator[Row]:
    values = [dict(_flat("", tomllib.loads(each.record.scene_toml))) for each in (first, second)]
    for key in dict.fromkeys([*values[0], *values[1]]):
        a, b = (each.get(key, "-") for each in values)
        if a != b:
            yield Row("scene", key, a, b)


def _flat(name: str, value: Any) -> Iterator[tuple[str, str]]:
    """Yield the values of a scene file by dotted key; paths and layers by their names, and numbers of one name."""
    if isinstance(value, dict):
        for key, each in value.items():
            yield from _flat(f"{name}.{key}".lstrip("."), each)
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        names = [str(each.get("name", k)) for k, each in enumerate(value, 1)]
        for k, (own, each) in enumerate(zip(names, value, strict=True)):
            number_of_name = f" ({names[: k + 1].count(own)})" if names.count(own) > 1 else ""
            yield from _flat(f"{name}.{own}{number_of_name}", each)
    else:
        yield name, str(value)


def _setting(first: Run, second: Run) -> Iterator[Row]:
    a, b = first.record, second.record
    unknowns = ("unknowns", a.mesh.unknowns, b.mesh.unknowns)
    for words, one, other in (("version", a.version, b.version), unknowns, ("status", str(a.status), str(b.status))):
        if one != other:
            yield Row("run", words, one, other)
    yield _row("run", "wall", "s", a.wall_s, b.wall_s)


def _stiffness(first: Run, second: Run) -> Iterator[Row]:
    a, b = (each.result.dataset["stiffness_initial"].values for each in (first, second))
    for words, unit, i, j in (
        ("H per u", "MN/m", 0, 0), ("H per rotation", "MN/rad", 0, 2), ("M per rotation", "MN m/rad", 2, 2),
        ("V per w", "MN/m", 1, 1),
    ):  # fmt: skip
        yield _row("initial stiffness", words, unit, 1e-6 * float(a[i, j]), 1e-6 * float(b[i, j]))
    torsion = [1e-6 * known for each in (first, second) if (known := known_torsion(each.result.attrs)) is not None]
    if len(torsion) == 2:
        yield _row("initial stiffness", "T per rotation", "MN m/rad", *torsion)


def _paths(first: Run, second: Run) -> Iterator[Row]:
    one, other = ({**paths_of(run.result), **space_paths_of(run.result)} for run in (first, second))
    spaces = (name for name, path in one.items() if isinstance(path, SpacePath) and name in other)
    across = [name for name in spaces if isinstance(other[name], SpacePath) and one[name].kind == other[name].kind]
    common = [*common_paths(first, second), *across]
    for name in (name for name in dict.fromkeys([*one, *other]) if name not in common):
        kinds = [each[name].kind if name in each else "-" for each in (one, other)]
        yield Row(f"path {name}", "not compared", kinds[0], kinds[1])
    for name in common:
        part, a, b = f"path {name}", one[name], other[name]
        if not same_load(a.load, b.load):
            yield _row(part, "V at its start", "kN", 1e-3 * a.load, 1e-3 * b.load)
        heights = [height for each in (a, b) if (height := height_of_load(each.attrs)) is not None]
        if len(heights) == 2 and not math.isclose(*heights):
            yield _row(part, "height of its load", "m", *heights)
        if isinstance(a, SpacePath) and isinstance(b, SpacePath):
            yield from _in_space(part, a, b, [0.5 * each.result.attrs["outer_diameter_m"] for each in (first, second)])
            continue
        if a.rate and b.rate and not is_rate(a.rate, b.rate):
            yield _row(part, "rate", "mm/s", 1e3 * a.rate, 1e3 * b.rate)
        yield from _along(part, a, b)
        yield Row(part, "error of the mesh on the load", _mesh(first, name), _mesh(second, name))
        ends = [end_of(name, before_cavitation(each.dataset)) for each in (a, b)]
        if any(end.failed for end in ends):
            yield Row(part, "end", ends[0].words, ends[1].words)


def _in_space(part: str, a: SpacePath, b: SpacePath, radii: list[float]) -> Iterator[Row]:
    """Yield the largest H, M and T of both on the way that both have come, and their largest difference there."""
    motions = [path.motions(R) for path, R in zip((a, b), radii, strict=True)]
    ways = [np.linalg.norm(np.diff(each, axis=0, prepend=each[:1]), axis=1).cumsum() for each in motions]
    grid = np.unique(np.minimum(np.concatenate(ways), min(way[-1] for way in ways)))
    one, other = (
        np.array([np.interp(grid, *growing(way, load)) for load in path.loads(radii[0]).T])
        for way, path in zip(ways, (a, replace(b, length=a.length)), strict=True)
    )
    for name, rows, arm in (("H", [0, 2], 1.0), ("M", [1, 3], a.length), ("T", [4], radii[0])):
        sizes = [float(np.linalg.norm(each[rows], axis=0).max()) for each in (one, other, other - one)]
        if sizes[0] > RESIDUAL * np.abs(one).max():
            yield _row(part, f"largest {name}", LOAD_UNITS[name][0], *(1e-3 * arm * size for size in sizes[:2]))
            share = 100.0 * sizes[2] / sizes[0]
            yield Row(part, f"largest difference of {name}", "", share, unit="% of the largest of the first")


def _mesh(run: Run, name: str) -> str:
    """Return what the loads of a path come from, and the estimate of their error."""
    error = paths_of(run.result)[name].end.mesh_error
    meshes = "two meshes" if EXTRAPOLATED in node(run.result, f"paths/{name}").children else "one mesh"
    return f"{percent(error) if np.isfinite(error) else 'not known'} ({meshes})"


def _along(part: str, a: RecordedPath, b: RecordedPath) -> Iterator[Row]:
    """Yield the loads of both at the largest motion that both have reached, and their largest difference on the way.

    What the iteration leaves of H beside M, or of M beside H, is no load.
    """
    driver, load, loads = a.rules.drives, a.rules.load, [carried(each) for each in (a, b)]
    if load == "H" and not all("H" in each for each in loads):
        load = "M"
    end = min(float(moved(each[driver])[-1]) for each in (a, b))
    at = f"at {driver} = {in_words(np.copysign(end, farthest(a[driver])), driver)}"
    quantities = [a.rules.load] + [
        each for each in ("M", "rotation") if each in a.rules.answers and a.rules.load == "H"
    ]
    for quantity in quantities:
        unit, factor = LOAD_UNITS[quantity]
        values = [factor * float(np.interp(end, *curve(each.dataset, driver, quantity))) for each in (a, b)]
        if quantity in ("H", "M"):
            values = [value * (quantity in each) for value, each in zip(values, loads, strict=True)]
        yield _row(part, f"{quantity} {at}", unit, *values)
    ways = [_way_come(each, a.length) for each in (a, b)]
    grid = np.linspace(0.0, min(way[-1] for way in ways), POINTS)
    one, other = (np.interp(grid, *growing(way, each[load])) for way, each in zip(ways, (a, b), strict=True))
    if (size := float(np.abs(one).max())) and (load == "V" or all(load in each for each in loads)):
        share = 100.0 * float(np.abs(other - one).max()) / size
        yield Row(part, f"largest difference of {load}", "", share, unit="% of the largest of the first")


LOAD_UNITS = {"H": ("kN", 1e-3), "V": ("kN", 1e-3), "M": ("kN m", 1e-3), "T": ("kN m", 1e-3), "rotation": ("mrad", 1e3)}


def moved(values: Array, side: float = 0.0) -> Array:
    """Return the largest distance from the first value so far to one side: -1 or 1, 0: where it is farthest."""
    return np.maximum.accumulate((side or np.sign(farthest(values))) * (values - values[0]))


def farthest(values: Array) -> float:
    """Return the distance from the first value, with its sign, where it is largest."""
    change = values - values[0]
    return float(change[np.argmax(np.abs(change))])


def in_words(motion: float, driver: str) -> str:
    """Return words for a motion [m or rad] from the state at rest, where w has the settlement under the dead load."""
    return f"{1e3 * motion:.4g} {'mrad' if driver == 'rotation' else 'mm'}{' from rest' if driver == 'w' else ''}"


def curve(path: xr.Dataset, driver: str, quantity: str) -> tuple[Array, Array]:
    """Return the motion from the initial state on, as it grows, and a quantity."""
    return growing(moved(path[driver].values), path[quantity].values)


def growing(x: Array, values: Array) -> tuple[Array, Array]:
    """Return a motion where it grows, and a quantity there."""
    grows = np.concatenate([[True], np.diff(x) > 0.0])
    return x[grows], values[grows]


def _way_come(path: RecordedPath, length: float) -> Array:
    """Return the way come along a path, back and forth [m or rad]; with the rotation, times length, where it bends."""
    driver = path[path.rules.drives]
    steps = np.abs(np.diff(driver, prepend=driver[:1]))
    turns = length * np.abs(np.diff(path.rotation, prepend=path.rotation[:1])) if path.bends else 0.0
    return np.cumsum(steps + turns)


def _row(part: str, quantity: str, unit: str, first: float, second: float) -> Row:
    change = 100.0 * (second / first - 1.0) if first and np.isfinite([first, second]).all() else None
    return Row(part, quantity, first + 0.0, second + 0.0, change, unit)  # no -0.0
