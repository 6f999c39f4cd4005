# SPDX-License-Identifier: MIT
"""Which spring sets springs can give, and which one a prediction takes."""

from __future__ import annotations

import xarray as xr

from pysprings.errors import Problem, UserInputError
from pysprings.macro_curves import FAMILIES, CurveSprings
from pysprings.macro_fan import has_fan
from pysprings.macro_tables import SPRING_SETS, SpringSet
from pysprings.springs import path_dataset, path_names

Springs = xr.DataTree | CurveSprings

ALONE = (
    "p-y springs alone: no distributed moment, tip and lid springs; on a caisson they carry a fraction of the load "
    "(`pysprings compare` measures it)"
)


def spring_sets(springs: Springs, path: str | None = None) -> list[SpringSet]:
    """Return the spring sets that springs can give: "full" needs the companions of p, a fan two rays at least."""
    lost = missing_companions(springs, path)
    return [name for name in SPRING_SETS if name == "py" or (not lost and (name != "fan" or _fan(springs)))]


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
        name = "fan" if path is None and not lost and _fan(springs) else "full"
    for known in SPRING_SETS:
        if name == known:
            if known != "py" and lost:
                raise _refused(
                    "springs",
                    f"the set '{known}' needs the companions of p: {', '.join(lost)} missing "
                    "(give zeros where there is none, or ask for the springs 'py')",
                )
            if known == "fan" and isinstance(springs, CurveSprings):
                raise _refused("springs", "a fan needs recorded paths: rows with step, y_m and rotation_rad")
            if known == "fan" and path is not None:
                raise _refused("path", "a fan comes from all calibration paths: ask for the springs 'full' or 'py'")
            return known
    raise _refused("springs_kind", f"'{name}' is not one of {', '.join(SPRING_SETS)}")


def _fan(springs: Springs) -> bool:
    return not isinstance(springs, CurveSprings) and has_fan(springs)


def _refused(key: str, message: str) -> UserInputError:
    return UserInputError([Problem(key=key, message=message)])
