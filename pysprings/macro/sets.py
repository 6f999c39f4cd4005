# SPDX-License-Identifier: MIT
"""Which spring sets springs can give, and which one a prediction uses."""

from __future__ import annotations

import xarray as xr

from pysprings.core.errors import refused
from pysprings.macro.fan import has_fan
from pysprings.macro.spring_sets import SPRING_SETS, SpringSet
from pysprings.macro.user_curves import FAMILIES, CurveSprings
from pysprings.springs.springs import Springs

Typed = Springs | CurveSprings
AnySprings = Typed | xr.DataTree


def typed(springs: AnySprings) -> Typed:
    """Return a tree as `Springs`; all others as they are."""
    return springs if isinstance(springs, CurveSprings) else Springs.of(springs)


def spring_sets(springs: AnySprings, path: str | None = None) -> list[str]:
    """Return the names of the spring sets that springs can give.

    "full" needs the companions of p, "pisa" a pure translation and a pure rotation, a fan two rays at least.
    """
    given = typed(springs)
    lost = missing_companions(given, path)
    return [each.name for each in SPRING_SETS if not (lost and each.companions) and _is_ready(given, each)]


def missing_companions(springs: Typed, path: str | None = None) -> list[str]:
    """Return the families (mtheta, base, lid) that the springs do not have; a spring file has them all."""
    if isinstance(springs, CurveSprings):
        return springs.pick(path)[1].missing()
    name = path if path in springs.paths else next(iter(springs.paths), None)
    return [] if name is None or "m" in springs.paths[name] else list(FAMILIES)


def choose_set(springs: Typed, name: str | None, path: str | None) -> SpringSet:
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
            "(give zeros if there are none, or ask for the springs 'py')"
        )
        raise refused("springs", message)
    if isinstance(springs, CurveSprings):
        if not chosen.curves:
            raise refused("springs", f"the set '{name}' needs recorded paths: rows with step, y_m and rotation_rad")
    elif chosen.several:
        _check_several(springs, chosen, path)
    return chosen


def _check_several(springs: Springs, chosen: SpringSet, path: str | None) -> None:
    """Refuse one path, or paths of several rates, for a set that several paths make together."""
    if path is not None:
        raise refused("path", f"{chosen.several}: ask for the springs 'full' or 'py'")
    if len(springs.rate_sets) > 1:
        have = ", ".join(f"{1e3 * each.rate:.4g}" for each in springs.rate_sets)
        raise refused(
            "rate", f"the calibration paths have several rates ({have} mm/s, of rho): give one in their range"
        )


def _is_ready(springs: Typed, each: SpringSet) -> bool:
    if isinstance(springs, CurveSprings):
        return each.curves
    return each.ready(springs) and not (each.several and len(springs.rate_sets) > 1)
