# SPDX-License-Identifier: MIT
"""Errors of springs with memory beside what is aimed at, for held-back paths of `benchmarks.memory`.

Errors are in %: the largest distance along the path over the largest value of the full model on it. The work of a pair
of branches of a loop is compared over the largest one of the loop, peaks, secants and work of cycles one by one; heave
is the change of w. Paths of loads beyond twice the reach have no aim, and a climb is compared as far as the reach.
"""

from collections.abc import Iterable
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

LIMITS = {  # of the error [%], by family of paths and quantity
    "pulls": {"H, more than the fan": 0.3, "rotation, more than the fan": 0.3},
    "climb": {"H at the motion": 5.0, "M at the motion": 5.0, "u at the load": 4.0, "rotation at the load": 4.0},
    "swipe": {"H": 12.0, "M": 12.0},
    "loops": {"H": 10.0, "work of pairs of branches": 5.0},
    "ten cycles": {"peaks": 5.0, "secant": 5.0, "work of cycles": 10.0, "heave": 15.0},
    "loads": {"u": 4.0, "rotation": 4.0},  # in the reach of the fan
    "reversed ray": {"H": 12.0, "M": 12.0},
}
CLAY, BEYOND = 5.0, 10.0  # in clay all but pulls; loads up to twice the reach [%]
FAMILIES = tuple(LIMITS)


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
    fan, found = MacroModel.from_springs(springs, "fan"), list[Aim]()
    for path in springs.paths.values():
        if path.role == "calibration" or path.is_vertical or path.remembers:
            continue
        family, values = _errors_of(path, model, fan)
        used = float(_used(path, fan).max())
        for (quantity, limit), error in zip(LIMITS[family].items(), values, strict=True):
            if clay and family != "pulls":
                limit = CLAY
            elif family == "loads" and used > 1.0 + RANGE_SLACK:
                limit = BEYOND if used <= 2.0 else np.inf
            found.append(Aim(family, path.name, quantity, error, limit))
    return found


def _errors_of(path: SpringPath, model: MacroModel, fan: MacroModel) -> tuple[str, list[float]]:
    """Return the family of a path and its errors [%], in the order of the quantities of LIMITS."""
    if path.name == "climb":
        path = _within_reach(path, fan)
    one = follow_path(path, model)
    if path.name.startswith("pull_"):
        without = follow_path(path, fan)
        return "pulls", [_error(one, name) - _error(without, name) for name in ("H", "rotation")]
    if path.name.startswith("loop_"):
        return "loops", loop_errors(one)
    if path.name.startswith("ten_cycles"):
        return "ten cycles", _ten_cycles(one)
    if path.name == "climb":
        return "climb", [*_at_the_motion(one, model), *(_error(one, name) for name in ("u", "rotation"))]
    if path.name in ("swipe", "ray_40_reversed"):
        return "swipe" if path.name == "swipe" else "reversed ray", [_error(one, name) for name in "HM"]
    return "loads", [_error(one, name) for name in ("u", "rotation")]


def _error(one: Followed, name: str) -> float:
    row = errors(one)
    return float(row[f"{name}_error_pct"]) if row["answered"] else np.inf


def loop_errors(one: Followed) -> list[float]:
    """Return the errors [%] of H, and of the work of pairs of branches over the largest of them."""
    pairs = cycles(one)[["cycle_full_J", "cycle_macro_J"]].dropna().to_numpy()
    return [_error(one, "H"), 100.0 * float(np.abs(pairs[:, 1] - pairs[:, 0]).max() / np.abs(pairs[:, 0]).max())]


def _ten_cycles(one: Followed) -> list[float]:
    table, found = cycles(one), list[float]()
    for start, end in (("F_end", ""), ("secant", ""), ("cycle", "_J")):
        full, macro = (table[f"{start}_{who}{end}"].to_numpy() for who in ("full", "macro"))
        known = np.isfinite(full) & np.isfinite(macro)
        found.append(100.0 * float(np.abs(macro[known] / full[known] - 1.0).max()))
    return [*found, float(reaction_errors(one)["w_error_pct"])]


def _at_the_motion(one: Followed, model: MacroModel) -> list[float]:
    motions = np.stack([one.path.u, one.path.rotation], axis=1)
    loads = np.stack([one.path[name] - one.path[name][0] for name in "HM"], axis=1)
    carried = model.solve("state", motions)[1]
    found: list[float] = (100.0 * np.abs(carried - loads).max(axis=0) / np.abs(loads).max(axis=0)).tolist()
    return found


def _used(path: SpringPath, fan: MacroModel) -> Array:
    """Return the motions of a path, without its first state, over the reach of the rays beside them."""
    table = fan.table
    assert isinstance(table, FanTable)
    states = np.stack([path.u, path.rotation], axis=1)[1:]
    return table.support(states)[0]


def _within_reach(path: SpringPath, fan: MacroModel) -> SpringPath:
    """Return a path as far as the reach of the rays."""
    beyond = np.flatnonzero(_used(path, fan) > 1.0 + RANGE_SLACK)
    return path.at_steps(range(1 + int(beyond[0]))) if beyond.size else path


def met(found: Iterable[Aim]) -> str:
    """Return how many aims are met of how many, as "3 of 4"."""
    counted = [one for one in found if np.isfinite(one.limit)]
    return f"{sum(one.met for one in counted)} of {len(counted)}"
