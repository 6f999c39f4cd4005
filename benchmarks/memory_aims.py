# SPDX-License-Identifier: MIT
"""Errors of springs with memory beside what is aimed at, for held-back paths of `benchmarks.memory`.

Errors are in %: the largest distance along the path over the largest value of the full model on it. The work of a pair
of branches of a loop is compared over the largest one of the loop, peaks, secants and work of cycles one by one; heave
is the change of w. Paths of loads beyond twice the reach have no aim, and a climb is compared as far as the reach.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pysprings.macro.cycles import Followed, cycles, errors, follow_path, reaction_errors
from pysprings.macro.fan import FanTable
from pysprings.macro.model import MacroModel
from pysprings.macro.ways import RANGE_SLACK
from pysprings.springs.path import SpringPath
from pysprings.springs.springs import Springs

Array = NDArray[np.float64]

PULLS, CLAY = 0.3, 5.0  # what a pull may lose against the fan; all other aims in clay [%]
INSIDE, BEYOND = 4.0, 10.0  # sequences of loads in the reach, and up to twice the reach [%]
FAMILIES = ("pulls", "climb", "swipe", "loops", "ten cycles", "loads", "reversed ray")
_RAY, _SWIPE, _LOOP_H, _LOOP_WORK = 12.0, 12.0, 10.0, 5.0
_CLIMB_MOTION, _CLIMB_LOAD, _PEAKS, _CYCLE_WORK, _HEAVE = 5.0, 4.0, 5.0, 10.0, 15.0


@dataclass(frozen=True, slots=True)
class Aim:
    """An error [%] of a held-back path beside its limit [%]; inf where the springs do not answer to its end."""

    family: str
    path: str
    quantity: str
    error: float
    limit: float

    @property
    def met(self) -> bool:
        """Whether the error is within the limit."""
        return self.error <= self.limit

    @property
    def over(self) -> float:
        """Error above the limit [%]."""
        return max(0.0, self.error - self.limit)


def aims(springs: Springs, model: MacroModel, clay: bool) -> list[Aim]:
    """Return what is aimed at on each held-back path, with the errors of a model; clay has limits of its own."""
    fan = MacroModel.from_springs(springs, "fan")
    found = []
    for path in springs.paths.values():
        if path.role != "calibration" and not path.is_vertical and not path.remembers:
            for family, quantity, error, limit in _of_path(path, model, fan):
                found.append(Aim(family, path.name, quantity, error, CLAY if clay and family != "pulls" else limit))
    return found


def _of_path(path: SpringPath, model: MacroModel, fan: MacroModel) -> Iterable[tuple[str, str, float, float]]:
    """Return (family, quantity, error, limit) of a path."""
    if path.name == "climb":
        path = _within_reach(path, fan)
    one = follow_path(path, model)
    if path.name.startswith("pull_"):
        return _pull(one, follow_path(path, fan))
    if path.name.startswith("loop_"):
        return _loop(one)
    if path.name.startswith("ten_cycles"):
        return _ten_cycles(one)
    if path.name == "climb":
        return _climb(one, model)
    if path.name in ("swipe", "ray_40_reversed"):
        family, limit = ("swipe", _SWIPE) if path.name == "swipe" else ("reversed ray", _RAY)
        return ((family, name, _error(one, name), limit) for name in ("H", "M"))
    used = _reach_used(path, fan)
    limit = INSIDE if used <= 1.0 + RANGE_SLACK else BEYOND if used <= 2.0 else np.inf
    return (("loads", name, _error(one, name), limit) for name in ("u", "rotation"))


def _error(one: Followed, name: str) -> float:
    row = errors(one)
    return float(row[f"{name}_error_pct"]) if row["answered"] else np.inf


def _pull(one: Followed, fan: Followed) -> Iterator[tuple[str, str, float, float]]:
    for name in ("H", "rotation"):
        yield "pulls", f"{name}, more than the fan", _error(one, name) - _error(fan, name), PULLS


def _loop(one: Followed) -> Iterator[tuple[str, str, float, float]]:
    pairs = cycles(one)[["cycle_full_J", "cycle_macro_J"]].dropna().to_numpy()
    work = 100.0 * float(np.abs(pairs[:, 1] - pairs[:, 0]).max() / np.abs(pairs[:, 0]).max())
    yield "loops", "H", _error(one, "H"), _LOOP_H
    yield "loops", "work of pairs of branches", work, _LOOP_WORK


def _ten_cycles(one: Followed) -> Iterator[tuple[str, str, float, float]]:
    table = cycles(one)
    pairs = {"peaks": ("F_end", ""), "secant": ("secant", ""), "work of cycles": ("cycle", "_J")}
    for name, (start, end) in pairs.items():
        full, macro = (table[f"{start}_{who}{end}"].to_numpy() for who in ("full", "macro"))
        known = np.isfinite(full) & np.isfinite(macro)
        error = 100.0 * float(np.abs(macro[known] / full[known] - 1.0).max())
        yield "ten cycles", name, error, _CYCLE_WORK if name.startswith("work") else _PEAKS
    yield "ten cycles", "heave", float(reaction_errors(one)["w_error_pct"]), _HEAVE


def _climb(one: Followed, model: MacroModel) -> Iterator[tuple[str, str, float, float]]:
    path = one.path
    motions = np.stack([path.u, path.rotation], axis=1)
    loads = np.stack([path["H"] - path["H"][0], path["M"] - path["M"][0]], axis=1)
    carried = model.solve("state", motions)[1]
    at_motion = 100.0 * np.abs(carried - loads).max(axis=0) / np.abs(loads).max(axis=0)
    yield from (("climb", f"{name} at the motion", float(at_motion[k]), _CLIMB_MOTION) for k, name in enumerate("HM"))
    yield from (("climb", f"{name} at the load", _error(one, name), _CLIMB_LOAD) for name in ("u", "rotation"))


def _reach_used(path: SpringPath, fan: MacroModel) -> float:
    """Return the largest motion of a path over the reach of the rays beside it."""
    return float(_used(path, fan).max())


def _used(path: SpringPath, fan: MacroModel) -> Array:
    """Return the motions of a path, without its first state, over the reach of the rays beside them."""
    table = fan.table
    assert isinstance(table, FanTable)
    states = np.stack([path.u, path.rotation], axis=1)[1:]
    return table.support(states, table.rows(states)[1])[0]


def _within_reach(path: SpringPath, fan: MacroModel) -> SpringPath:
    """Return a path as far as the reach of the rays."""
    beyond = np.flatnonzero(_used(path, fan) > 1.0 + RANGE_SLACK)
    return path.at_steps(range(1 + int(beyond[0]))) if beyond.size else path


def met(found: Iterable[Aim]) -> str:
    """Return how many aims are met of how many, as "3 of 4"."""
    counted = [one for one in found if np.isfinite(one.limit)]
    return f"{sum(one.met for one in counted)} of {len(counted)}"


def over(found: Iterable[Aim]) -> float:
    """Return the errors above their limits added up [%]; a path without an answer counts as 100 %."""
    return float(sum(min(one.over, 100.0) for one in found if np.isfinite(one.limit)))
