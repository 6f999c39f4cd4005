# SPDX-License-Identifier: MIT
"""The design load of a scene, which the summary of a run answers."""

import math
from collections.abc import Iterator
from typing import Annotated

from pysprings.scene.fields import Quantity
from pysprings.scene.positions import Clash
from pysprings.scene.sections import Section

USUAL_TILT = math.radians(0.25)  # the usual tolerance of offshore wind turbines over their life


class Design(Section):
    """A lateral load and the rotation that is tolerated: the summary of a run gives the tilt at this load.

    The load acts at the vertical load of the caisson. Nothing that is computed depends on it.
    """

    lateral_force: Annotated[
        float | None, Quantity("MN", "[-1e4, 1e4]", "lateral design load", "2.5 MN", optional=True)
    ] = None
    arm: Annotated[
        float | None, Quantity("m", "[-1e3, 1e3]", "its height above mudline; 0 when left out", "20 m", optional=True)
    ] = None
    tilt: Annotated[
        float | None,
        Quantity("deg", "[1e-4, 30]", "rotation that is tolerated; 0.25 deg when left out", "0.5 deg", optional=True),
    ] = None


def design_clashes(design: Design) -> Iterator[Clash]:
    """Give a height without a load, and a load of zero."""
    if design.lateral_force is None and design.arm is not None:
        yield Clash((("design", "arm"),), "is the height of a load: give lateral_force, too")
    if design.lateral_force == 0.0:
        yield Clash((("design", "lateral_force"),), "a load of zero turns nothing: leave [design] out")
