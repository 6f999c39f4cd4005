# SPDX-License-Identifier: MIT
"""How far the pore water is from cavitation: absolute pressure over vapour pressure.

    p_abs = p_atm + gamma_w (water depth + z) + p,   p the excess pressure at depth z below mudline

Below the vapour pressure water boils and carries no further suction, which the equations do not include.
"""

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr

from pysprings.core.units import ATMOSPHERE, VAPOUR


@dataclass(frozen=True)
class Margin:
    """Lowest absolute pressure over vapour pressure (Pa), the excess pressure there (Pa) and the place (m)."""

    margin: float
    pressure: float
    place: tuple[float, float, float]


class Watch:
    """What looks at the suction of each state of a path.

    sea : unit weight of water (N/m3) and its depth (m); None: nothing is looked at. water_position : (n, 3) m.
    cavitation : margin of the first state in which the water would cavitate.
    """

    sea: tuple[float, float] | None
    water_position: np.ndarray
    cavitation: Margin | None = None

    def suction(self, pressure: np.ndarray) -> dict[str, float]:
        """Return what a row of the path has on a state with excess pressures (n,) Pa."""
        if self.sea is None:
            return {}
        smallest = smallest_margin(self.water_position, pressure, *self.sea)
        if smallest.margin < 0.0 and self.cavitation is None:
            self.cavitation = smallest
        return {"cavitation_margin": smallest.margin}


def smallest_margin(position: np.ndarray, pressure: np.ndarray, unit_weight: float, water_depth: float) -> Margin:
    """Find the point nearest to cavitation.

    position : (n, 3) m, z down from mudline; pressure : (n,) excess, Pa; unit_weight of water in N/m3;
    water_depth in m above mudline.
    """
    margin = ATMOSPHERE - VAPOUR + unit_weight * (water_depth + position[:, 2]) + pressure
    worst = int(np.argmin(margin))
    x, y, z = (float(value) for value in position[worst])
    return Margin(float(margin[worst]), float(pressure[worst]), (x, y, z))


def warning(path: str, states: xr.Dataset, length: float, margin: Margin) -> str:
    """Return one line on where and when water would cavitate.

    states : of the path, with the margin by step; length : of the skirt (m).
    """
    first = int(np.argmax(states["cavitation_margin"].values < 0.0))
    plane = ("u_x", "u_y"), ("rot_x", "rot_y")  # of a path that leaves a plane
    now = {name: float(each.values[first]) for name, each in states.items() if each.dims == ("step",)}
    u, rotation = (
        now[name] if name in now else math.hypot(*(now[part] for part in parts))
        for name, parts in zip(("u", "rotation"), plane, strict=True)
    )
    settled = now["w"] - float(states["w"].values[0])
    ways = (
        (abs(u), f"u = {1e3 * u:.4g} mm"),
        (abs(rotation) * length, f"rotation = {math.degrees(rotation):.4g} deg"),
        (abs(settled), f"w = {1e3 * now['w']:.4g} mm (V = {1e-3 * now['V']:.5g} kN)"),
    )
    x, y, z = margin.place
    where = f"x={x:.3f}, y={y:.3f}, z={z:.3f} m"
    return (
        f"path '{path}': water would cavitate from {max(ways)[1]} on, first at {where}, where the excess "
        f"pressure is {margin.pressure / 1e3:.4g} kPa; reality has no such suction, and springs end there"
    )
