# SPDX-License-Identifier: MIT
"""Which spring sets springs can give, and which one a prediction takes."""

from __future__ import annotations

import xarray as xr

from pysprings.core.errors import Problem, UserInputError
from pysprings.macro.curve_table import SPRING_SETS, SpringSet
from pysprings.macro.fan import has_fan, pure_paths
from pysprings.macro.user_curves import FAMILIES, CurveSprings
from pysprings.springs.dataset import path_dataset, path_names
from pysprings.springs.rates import RateSet, rate_sets

Springs = xr.DataTree | CurveSprings

ALONE = (
    "p-y springs alone: no distributed moment, tip and lid springs; on a caisson they carry a fraction of the load "
    "(`pysprings compare` measures it)"
)


def spring_sets(springs: Springs, path: str | None = None) -> list[SpringSet]:
    """Return the spring sets that springs can give.

    "full" needs the companions of p, "pisa" a pure translation and a pure rotation, a fan two rays at least.
    """
    if missing_companions(springs, path):
        return ["py"]
    needs = {"pisa": _pisa, "fan": _fan}
    return [name for name in SPRING_SETS if name not in needs or needs[name](springs)]


def missing_companions(springs: Springs, path: str | None = None) -> list[str]:
    """Return the families (mtheta, base, lid) that the springs do not have; a spring file has them all."""
    if isinstance(springs, CurveSprings):
        return springs.pick(path)[1].missing()
    name = path if path in path_names(springs) else next(iter(path_names(springs)), None)
    return [] if name is None or "m" in path_dataset(springs, name) else list(FAMILIES)


def choose_set(springs: Springs, name: str | None, path: str | None) -> SpringSet:
    """Return the spring set asked for (None: the best there is); refuse one that the springs cannot give."""
    lost = missing_companions(springs, path)
    if name is None:
        if len(lost) == len(FAMILIES):
            return "py"
        rays = not isinstance(springs, CurveSprings) and has_fan(springs)
        name = "fan" if path is None and not lost and rays else "full"
    for known in SPRING_SETS:
        if name == known:
            if known != "py" and lost:
                raise _refused(
                    "springs",
                    f"the set '{known}' needs the companions of p: {', '.join(lost)} missing "
                    "(give zeros where there is none, or ask for the springs 'py')",
                )
            if known in _SEVERAL:
                _check_several(springs, known, path)
            return known
    raise _refused("springs_kind", f"'{name}' is not one of {', '.join(SPRING_SETS)}")


_SEVERAL = ("fan", "pisa")  # sets that several calibration paths make together


def _check_several(springs: Springs, name: str, path: str | None) -> None:
    """Refuse a set of several paths where they are not there, or do not belong together."""
    if isinstance(springs, CurveSprings):
        words = "a fan needs" if name == "fan" else "the set 'pisa' needs"
        raise _refused("springs", f"{words} recorded paths: rows with step, y_m and rotation_rad")
    if path is not None:
        words = "a fan comes from all" if name == "fan" else "the set 'pisa' comes from several"
        raise _refused("path", f"{words} calibration paths: ask for the springs 'full' or 'py'")
    if len(sets := _rates(springs)) > 1:
        have = ", ".join(f"{1e3 * each.rate:.4g}" for each in sets)
        raise _refused(
            "rate", f"the calibration paths have several rates ({have} mm/s, of rho): give one in their range"
        )
    if name == "pisa" and pure_paths(springs) is None:
        raise _refused("springs", "the set 'pisa' needs a pure translation and a pure rotation to calibrate it")


def _rates(springs: xr.DataTree) -> list[RateSet]:
    """Sets of calibration paths by rate; none where the springs do not depend on it."""
    return rate_sets(springs) if springs.attrs.get("drainage") == "coupled" else []


def _pisa(springs: Springs) -> bool:
    return not isinstance(springs, CurveSprings) and pure_paths(springs) is not None and len(_rates(springs)) < 2


def _fan(springs: Springs) -> bool:
    return not isinstance(springs, CurveSprings) and has_fan(springs) and len(_rates(springs)) < 2


def _refused(key: str, message: str) -> UserInputError:
    return UserInputError([Problem(key=key, message=message)])
