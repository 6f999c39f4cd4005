# SPDX-License-Identifier: MIT
"""Families of atlases, a module each. Other packages call `FAMILIES.register`."""

from pysprings.core.registry import Registry
from pysprings.studies.atlas.families import clay, clay_gap, sand
from pysprings.studies.atlas.families.base import Family

FAMILIES: Registry[Family] = Registry("family of atlases", (clay.FAMILY, clay_gap.FAMILY, sand.FAMILY))

__all__ = ["FAMILIES", "Family"]
