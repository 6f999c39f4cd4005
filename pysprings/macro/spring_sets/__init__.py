# SPDX-License-Identifier: MIT
"""Spring sets of the macro-model, a module each (light). A new set is one module here and one entry below.

Other packages call `SPRING_SETS.register`, or declare an entry point in the group `pysprings.spring_sets`.
"""

from __future__ import annotations

from pysprings.core.registry import Registry
from pysprings.macro.spring_sets import fan, full, memory, pisa, py
from pysprings.macro.spring_sets.base import Built, SpringSet

SPRING_SETS: Registry[SpringSet] = Registry(
    "spring set",
    (py.SPRING_SET, pisa.SPRING_SET, full.SPRING_SET, fan.SPRING_SET, memory.SPRING_SET),
    group="pysprings.spring_sets",
)

__all__ = ["SPRING_SETS", "Built", "SpringSet"]
