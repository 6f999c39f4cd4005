# SPDX-License-Identifier: MIT
"""Families of atlases, a module for each ground. Other packages call `FAMILIES.register`."""

from pysprings.core.registry import Registry
from pysprings.studies.atlas.families import clay, sand
from pysprings.studies.atlas.families.base import Family

FAMILIES: Registry[Family] = Registry("family of atlases", (clay.FAMILY, clay.GAP_FAMILY, sand.FAMILY))

__all__ = ["FAMILIES", "Family"]
