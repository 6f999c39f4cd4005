# SPDX-License-Identifier: MIT
"""What a capacity study has shown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import pandas as pd

from pysprings.studies.capacity import plan

if TYPE_CHECKING:
    from pysprings.scene.model import Scene


@dataclass(frozen=True, eq=False)
class Capacity:
    """What a study has shown.

    Attributes
    ----------
    scene, request : what was asked for.
    table : a row a direction, vertical load and strength (SI).
    cases : utilisation of the load cases; None without cases.
    remarks : sentences on runs that stopped, and on springs that are missing.
    """

    scene: Scene
    request: plan.Request
    table: pd.DataFrame
    cases: pd.DataFrame | None
    remarks: tuple[str, ...]
