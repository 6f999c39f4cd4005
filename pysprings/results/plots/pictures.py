# SPDX-License-Identifier: MIT
"""Pictures of a run in reading order. A new picture is one module in this folder and one entry here.

Other packages call `PICTURES.register`, or declare an entry point in the group `pysprings.pictures`.
"""

from __future__ import annotations

from pysprings.core.registry import Registry
from pysprings.results.plots import (
    comparison,
    gap,
    ground,
    load,
    loops,
    newton,
    overview,
    profiles,
    reactions,
    rose,
    section,
    steel,
)
from pysprings.results.plots.picture import Picture

PICTURES: Registry[Picture] = Registry(
    "picture",
    (
        section.MESH,
        ground.PICTURE,
        overview.PICTURE,
        overview.TILT,
        overview.SECANT,
        load.PICTURE,
        comparison.PICTURE,
        loops.PICTURE,
        reactions.PICTURE,
        profiles.PICTURE,
        load.VERTICAL,
        rose.OUTSIDE,
        rose.INSIDE,
        gap.PICTURE,
        steel.PICTURE,
        section.DISPLACEMENT,
        rose.PORE_PRESSURE,
        section.PRESSURE,
        newton.PICTURE,
    ),
    group="pysprings.pictures",
)
