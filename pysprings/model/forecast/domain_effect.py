# SPDX-License-Identifier: MIT
"""How much the bounded domain of soil stiffens the caisson: bounds, and a warning where the domain is tight.

The bottom of the domain is fixed and its side holds the soil, so that the caisson is stiffer than on the half-space.
`domain_table.json` holds by how much, in percent of K_H, K_V and K_M of unbounded soil, for elastic, homogeneous soil
and 2,352 domains (`python -m benchmarks.domain_table`). Between its entries logarithms are interpolated; a margin makes
the result a bound: see MARGIN. Stiffness that grows with depth is stiffened less; a soft layer below a stiff one is
not covered.
"""

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from pysprings.core.units import show
from pysprings.scene.model import Scene

TABLE = Path(__file__).with_name("domain_table.json")
SIDES = ("roller", "fixed")
STIFFNESSES = ("H", "V", "M")
MARGIN = 1.15  # on the interpolated table; tests compare the result with the engine in domains between the entries
# percent: a domain that may stiffen the caisson more is warned of (the paper's own is just below); `check` shows the
# figures of every one
TIGHT = {"H": 60.0, "V": 150.0, "M": 60.0}
MOST_SHOWN = 900.0  # percent: beyond, the table has no figure
_LEAST = 1e-3  # percent


@dataclass(frozen=True)
class DomainEffect:
    """Radius of the domain and depth of the soil below the tip over the diameter; bounds of the stiffening, percent.

    ``percent`` are the bounds of K_H, K_V and K_M by the name of the load; ``remarks`` warns where the domain is tight.
    """

    radius: float
    below_tip: float
    percent: dict[str, float]
    remarks: tuple[str, ...]

    @property
    def most(self) -> float:
        """Return the largest of the bounds, percent."""
        return max(self.percent.values())


def domain_effect(scene: Scene) -> DomainEffect:
    """Return bounds of how much the domain of a scene stiffens its caisson."""
    caisson, extent = scene.caisson, scene.extent
    diameter, below = caisson.outer_diameter, extent.depth - caisson.skirt_length
    radius, tip = extent.radius / diameter, below / diameter
    ratio = 0.5  # water that has no time to flow holds its volume
    if scene.drainage.mode == "drained":
        ratio = float(scene.ground.value("poisson_ratio", np.array(caisson.skirt_length)))
    at = (caisson.skirt_length / diameter, ratio, radius - 0.5, tip)
    bounds = dict(zip(STIFFNESSES, _bounds(at, scene.domain.side).tolist(), strict=True))
    if all(value <= TIGHT[name] for name, value in bounds.items()):
        return DomainEffect(radius, tip, bounds, ())
    most = ", ".join(f"K_{name} {_shown(value)}" for name, value in bounds.items())
    remark = (
        f"tight domain: domain.radius {show(extent.radius, 'm')} ({radius:.2g} diameters) and domain.depth "
        f"{show(extent.depth, 'm')} ({show(below, 'm')}, {tip:.2g} diameters, of soil below the tip) make the caisson "
        f"stiffer than unbounded soil does, by at most {most}; leave [domain] out, or enlarge it, unless rock or a "
        "wall is there"
    )
    return DomainEffect(radius, tip, bounds, (remark,))


def _shown(percent: float) -> str:
    return f"{percent:.0f} %" if percent < MOST_SHOWN else f"more than {MOST_SHOWN:g} %"


def _bounds(at: tuple[float, float, float, float], side: str) -> np.ndarray:
    """Return the bounds (3,) in percent at L/D, nu, and diameters of soil beside the skirt and below the tip."""
    from scipy.interpolate import interpn  # 0.2 s

    axes, table = _table()
    inside = [np.clip(value, axis[0], axis[-1]) for value, axis in zip(at, axes, strict=True)]
    # beyond the largest domains of the table what a domain adds falls as one over its size
    farther = min(max(at[2] / axes[2][-1], 1.0), max(at[3] / axes[3][-1], 1.0))
    grid = tuple(np.log(axis) for axis in axes)
    value = np.exp(interpn(grid, table[SIDES.index(side)], np.log(inside)))[0]
    tight = at[2] < axes[2][0] or at[3] < axes[3][0]
    return np.full(3, np.inf) if tight else np.asarray(MARGIN * value / farther)


@cache
def _table() -> tuple[tuple[np.ndarray, ...], np.ndarray]:
    """Return the axes and logarithms of the percents by side, falling with the size of the domain."""
    stored = json.loads(TABLE.read_text(encoding="utf-8"))
    axes = tuple(np.array(stored[name]) for name in ("slenderness", "poisson", "room", "room"))
    sizes = [len(axis) for axis in axes]
    table = np.abs(stored["percent"]).reshape(*sizes[:2], len(SIDES), *sizes[2:], len(STIFFNESSES))
    for axis in (3, 4):  # a larger domain than one that stiffens less is not trusted to stiffen more
        table = np.flip(np.maximum.accumulate(np.flip(table, axis), axis), axis)
    return axes, np.log(np.moveaxis(table, 2, 0).clip(_LEAST))
