# SPDX-License-Identifier: MIT
"""The ground of a scene by depth as `check` prints it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pysprings.scene.ground import ground_of
from pysprings.scene.interface import adhesion_factor, uses_adhesion

if TYPE_CHECKING:
    from pysprings.scene.load import Scene


def profile(scene: Scene) -> list[dict[str, Any]]:
    """Return a row for top and bottom of each layer, in SI; adhesion factors where the interface has adhesion."""
    rows, ground = [], ground_of(scene)
    for stratum in ground.strata:
        for depth in (stratum.top, stratum.bottom):
            row = stratum.row(depth)
            if uses_adhesion(scene) and stratum.top <= scene.caisson.skirt_length:
                for side in ("outside", "inside"):
                    factor = adhesion_factor(scene.interface, stratum, side, np.array(depth))
                    row[f"adhesion_factor_{side}"] = float(factor)
            rows.append(row)
    return rows
