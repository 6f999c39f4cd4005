# SPDX-License-Identifier: MIT
"""The design load of a scene, which the summary of a run answers, and its table of load cases."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from pysprings.core.errors import Problem, UserInputError, refused
from pysprings.core.loads import fewest_loads
from pysprings.core.tables.load_cases import read_load_cases
from pysprings.core.units import QuantityError, quoted, read, show
from pysprings.core.words import FROM_CASES
from pysprings.scene.fields import Quantity, Text
from pysprings.scene.positions import Clash, KeyPath
from pysprings.scene.sections import Section

BALANCED = "balanced"  # vertical load of a caisson whose scene gives none
MOST_SETS = 8  # of springs at further vertical loads, from a table of cases
_ARM = Quantity("m", "[-1e3, 1e3]", "its height above mudline; 0 when left out", "20 m")
_TILT = Quantity("deg", "[1e-4, 30]", "rotation that is tolerated; 0.25 deg when left out", "0.5 deg")
_CASES = "table of load cases (CSV, Excel); its path is relative to the scene file"
USUAL_TILT = math.radians(0.25)  # the usual tolerance of offshore wind turbines over their life


class Design(Section):
    """A lateral load and the rotation that is tolerated: the summary of a run gives the tilt at this load.

    The load acts at the vertical load of the caisson. `cases` is the table that `pysprings design` answers where it is
    given none, and from which `[springs] vertical_loads = "from cases"` takes its loads: nothing else that is computed
    depends on this section.
    """

    lateral_force: Annotated[float | None, Quantity("MN", "[-1e4, 1e4]", "lateral design load", "2.5 MN")] = None
    arm: Annotated[float | None, _ARM] = None
    tilt: Annotated[float | None, _TILT] = None
    cases: Annotated[str | None, Text(_CASES)] = None


def design_clashes(design: Design) -> Iterator[Clash]:
    """Give a height without a load, and a load of zero."""
    if design.lateral_force is None and design.arm is not None:
        yield Clash((("design", "arm"),), "is the height of a load: give lateral_force, too")
    if design.lateral_force == 0.0:
        yield Clash((("design", "lateral_force"),), "a load of zero turns nothing: leave [design] out")


def take_cases(data: dict[str, Any], folder: Path) -> tuple[list[tuple[KeyPath, str]], Sequence[Problem]]:
    """Put the path of the table of cases, seen from here, and the loads of `vertical_loads = "from cases"` into data.

    The loads are the fewest that are within 10 % of every V of a case with a lateral load which is not within 10 % of
    that of the caisson. Return what is wrong with keys of the scene, and with the table.
    """
    design, springs, caisson = (data.get(name) for name in ("design", "springs", "caisson"))
    file = design.get("cases") if isinstance(design, dict) else None
    if isinstance(design, dict) and isinstance(file, str):
        file = design["cases"] = str(folder / file)
    key = "springs", "vertical_loads"
    if not isinstance(springs, dict) or springs.get(key[1]) != FROM_CASES:
        return [], []
    springs[key[1]] = []
    load = caisson.get("vertical_load", BALANCED) if isinstance(caisson, dict) else BALANCED
    if not isinstance(file, str) or springs.get("reach") is None:
        return [(key, f'{quoted(FROM_CASES)} needs [design] cases = "loads.csv" and [springs] reach')], []
    if load == BALANCED:
        text = f'springs.vertical_loads = {quoted(FROM_CASES)} needs a number here: V of most cases, such as "3 MN"'
        return [(("caisson", "vertical_load"), text)], []
    try:
        springs[key[1]] = [f"{V:.12g} N" for V in _loads_of(file, read(load, "N"))]
    except (TypeError, AttributeError, QuantityError):
        return [], []  # [caisson] refuses its load
    except UserInputError as error:
        return [], error.problems
    return [], []


def _loads_of(file: str, rest: float) -> tuple[float, ...]:
    """Return the further vertical loads [N] of a table of cases, beside the one at rest. Raises UserInputError."""
    cases = read_load_cases(file)
    given = ~np.isnan(cases.V)
    if not (given & cases.lateral).any():
        text = "no case has one" if not given.any() else "no case that has one has a lateral load"
        raise refused("V", f"{text}: springs.vertical_loads takes its loads from this column", file)
    found = fewest_loads(cases.V[given & cases.lateral].tolist(), rest)
    if len(found) > MOST_SETS:
        span = f"from {show(found[0], 'MN')} to {show(found[-1], 'MN')}"
        text = f"{span}: {len(found)} further sets of springs, at most {MOST_SETS}; list springs.vertical_loads instead"
        raise refused("V", text, file)
    return found
