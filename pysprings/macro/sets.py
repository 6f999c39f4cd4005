# SPDX-License-Identifier: MIT
"""Which spring sets springs can give, and which one a prediction uses."""

from __future__ import annotations

import xarray as xr

from pysprings.core.errors import Problem, UserInputError
from pysprings.macro.fan import has_fan
from pysprings.macro.spring_sets import SPRING_SETS, SpringSet
from pysprings.macro.user_curves import FAMILIES, CurveSprings
from pysprings.springs.dataset import path_dataset, path_names
from pysprings.springs.rates import RateSet, rate_sets

Springs = xr.DataTree | CurveSprings


def spring_sets(springs: Springs, path: str | None = None) -> list[str]:
    """Return the names of the spring sets that springs can give.

    "full" needs the companions of p, "pisa" a pure translation and a pure rotation, a fan two rays at least.
    """
    lost = missing_companions(springs, path)
    return [each.name for each in SPRING_SETS if not (lost and each.companions) and _is_ready(springs, each)]


def missing_companions(springs: Springs, path: str | None = None) -> list[str]:
    """Return the families (mtheta, base, lid) that the springs do not have; a spring file has them all."""
    if isinstance(springs, CurveSprings):
        return springs.pick(path)[1].missing()
    name = path if path in path_names(springs) else next(iter(path_names(springs)), None)
    return [] if name is None or "m" in path_dataset(springs, name) else list(FAMILIES)


def choose_set(springs: Springs, name: str | None, path: str | None) -> SpringSet:
    """Return the spring set of a name (None: a fan, else the full set, else p-y alone).

    Raises
    ------
    UserInputError
        The name is unknown, or the springs cannot give the set.
    """
    lost = missing_companions(springs, path)
    if name is None:
        if len(lost) == len(FAMILIES):
            return SPRING_SETS["py"]
        rays = not isinstance(springs, CurveSprings) and has_fan(springs)
        name = "fan" if path is None and not lost and rays else "full"
    chosen = SPRING_SETS.find(name, "springs_kind")
    if chosen.companions and lost:
        message = (
            f"the set '{name}' needs the companions of p: {', '.join(lost)} missing "
            "(give zeros where there is none, or ask for the springs 'py')"
        )
        raise _refused("springs", message)
    if isinstance(springs, CurveSprings) and not chosen.curves:
        message = f"the set '{name}' needs recorded paths: rows with step, y_m and rotation_rad"
        raise _refused("springs", message)
    if chosen.several and not isinstance(springs, CurveSprings):
        _check_several(springs, chosen, path)
    return chosen


def _check_several(springs: xr.DataTree, chosen: SpringSet, path: str | None) -> None:
    """Refuse one path, or paths of several rates, for a set that several paths make together."""
    if path is not None:
        raise _refused("path", f"{chosen.several}: ask for the springs 'full' or 'py'")
    if len(sets := _rates(springs)) > 1:
        have = ", ".join(f"{1e3 * each.rate:.4g}" for each in sets)
        raise _refused(
            "rate", f"the calibration paths have several rates ({have} mm/s, of rho): give one in their range"
        )


def _rates(springs: xr.DataTree) -> list[RateSet]:
    """Return the sets of calibration paths by rate; none where the springs do not depend on it."""
    return rate_sets(springs) if springs.attrs.get("drainage") == "coupled" else []


def _is_ready(springs: Springs, each: SpringSet) -> bool:
    if isinstance(springs, CurveSprings):
        return each.curves
    return each.ready(springs) and not (each.several and len(_rates(springs)) > 1)


def _refused(key: str, message: str) -> UserInputError:
    return UserInputError([Problem(key=key, message=message)])
