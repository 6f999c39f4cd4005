# SPDX-License-Identifier: MIT
"""Springs that are curves of their own, as in a user's table: no recorded path of a full model stands behind them."""

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pysprings.core.errors import refused
from pysprings.core.text import suggestion
from pysprings.macro.curve_table import Row, SpringTable, stack
from pysprings.springs.path import SpringPath
from pysprings.springs.sums import action

Array = NDArray[np.float64]

# What each companion family of a table holds.
FAMILIES = {"mtheta": ("m",), "base": ("H_tip", "M_tip"), "lid": ("H_lid", "M_lid")}


@dataclass(frozen=True, slots=True)
class Curve:
    """One curve: spring (p, m, H_tip, M_tip, H_lid, M_lid), depth [m], displacements q (0 first) and reactions r."""

    name: str
    depth: float
    q: Array
    r: Array


@dataclass(frozen=True, slots=True)
class CurveSet:
    """Curves of one name: depths (n,) and slices (n, 2) of p [m], all curves, a sentence on what was assumed.

    straight: curves are straight lines between their points, not smooth.
    """

    depth: Array
    bounds: Array
    curves: list[Curve]
    note: str = ""
    straight: bool = False

    @property
    def length(self) -> float:
        """Skirt length [m]: the bottom of the lowest slice."""
        return float(self.bounds[-1, 1])

    def missing(self) -> list[str]:
        """Return the companion families that the full set needs and the table does not have."""
        there = {curve.name for curve in self.curves}
        return [family for family, names in FAMILIES.items() if not set(names) <= there]

    def table(self, companions: bool) -> SpringTable:
        """Return the rows of all curves, or those of p alone."""
        heights = dict(zip(self.depth, self.bounds[:, 1] - self.bounds[:, 0], strict=True))
        used = [curve for curve in self.curves if companions or curve.name == "p"]
        return stack([self._row(curve, heights.get(curve.depth, 0.0)) for curve in used], self.straight)

    def _row(self, curve: Curve, dz: float) -> Row:
        at = self.length if curve.name.endswith("tip") else 0.0 if curve.name.endswith("lid") else curve.depth
        turns = curve.name == "m" or curve.name.startswith("M_")
        carrier = "rotation" if turns else "u" if curve.name == "H_lid" else "y"
        b = action(curve.name, at, dz, self.length)
        return Row(curve.name, at, carrier, (0.0, 1.0) if turns else (1.0, -at), b, curve.q, curve.r)


@dataclass(frozen=True, slots=True)
class CurveSprings:
    """Sets of curves by name (the column `path` of a table), and the file they come from."""

    source: str
    sets: dict[str, CurveSet]

    def pick(self, name: str | None) -> tuple[str, CurveSet]:
        """Return the set of a name, or the first one."""
        chosen = next(iter(self.sets)) if name is None else name
        if chosen not in self.sets:
            raise refused(
                "path",
                f"no path '{chosen}'{suggestion(chosen, self.sets)}; the table has: {', '.join(self.sets)}",
                self.source,
            )
        return chosen, self.sets[chosen]

    def origin(self, name: str) -> SpringPath:
        """Return depths and slices of a set as a path without states: nothing was recorded."""
        chosen = self.sets[name]
        data = {"depth_bounds": (("depth", "bound"), chosen.bounds)}
        return SpringPath(name, xr.Dataset(data, {"depth": chosen.depth}, {"kind": "table"}), chosen.length)
