# SPDX-License-Identifier: MIT
"""The runs of a capacity study: probes in directions of the load, and rays for the springs, by V and strength (light).

Directions are angles a in the plane of H and M/D. Springs and full model are odd in a lateral load, so that half of the
plane is enough: from 90 degrees (a moment as by a load above mudline) over 0 (a force at mudline) towards -90. With
torsion the load leaves that plane by an angle b, R (cos b cos a, cos b sin a, sin b) in (H, M/D, T/D). A mirror image
in the plane of H turns T alone over: b from 0 to 90 degrees is enough, and at 90 there is one direction.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from pysprings.core.errors import refused
from pysprings.scene.design_strength import StrengthFactors, with_design_strength
from pysprings.scene.fan import ray_name
from pysprings.scene.model import Scene

CHARACTERISTIC, DESIGN = "characteristic", "design"
FEWEST, MOST = 2, 72
TORSION_ALONE = 0.5 * math.pi * (1.0 - 1e-12)  # as read in degrees
Direction = tuple[float, float]  # a, b [rad]
PROBE = "probe"
# Angles of the rays [deg] in the plane of (u, rotation * skirt length). Under a free head the caisson turns about a
# point in the skirt or below it (25 to 80 degrees); there a small change of the motion turns the load by much.
RAYS = (-55.0, -25.0, 0.0, 25.0, 36.0, 44.0, 50.0, 56.0, 62.0, 70.0, 80.0, 90.0)
# Rays reach further than the limit of motion in their direction, so that the states between two rays are in range
_SPARE = 1.02
# Directions that are compared when reaching for the limit between two rays
_BETWEEN = 33
_OUTPUT = {"interface_fields": False, "section": False, "figures": False, "paraview": False}


@dataclass(frozen=True)
class Request:
    """What is asked for: vertical loads [N] or "balanced", number of directions, rays or none, factors on strength.

    torsion : angles out of the plane of H and M/D [rad], beside 0; each has all directions, that of T alone has one.
    estimate : whether a coarser mesh shows the error of each; None: with series.
    """

    loads: tuple[float | str, ...]
    directions: int = 8
    rays: bool = True
    factors: StrengthFactors = field(default_factory=StrengthFactors)
    torsion: tuple[float, ...] = ()
    estimate: bool | None = None

    def __post_init__(self) -> None:
        if not FEWEST <= self.directions <= MOST:
            raise refused("--directions", f"{self.directions} is not in [{FEWEST}, {MOST}]")
        for each in self.torsion:
            if not 0.0 < each <= 0.5 * math.pi:
                raise refused("--torsion", f"{math.degrees(each):g} deg is not in (0, 90] deg")

    @property
    def all_directions(self) -> list[Direction]:
        """Return the directions (a, b) [rad]: those in the plane of H and M, then those with torsion."""
        plane, beyond = angles(self.directions), sorted(set(self.torsion))
        turned = [(a, b) for b in beyond for a in plane if b < TORSION_ALONE]
        return [(a, 0.0) for a in plane] + turned + [(0.0, b) for b in beyond if b >= TORSION_ALONE]


@dataclass(frozen=True)
class Group:
    """Runs at one vertical load (N, or "balanced") and one strength."""

    strength: str
    load: float | str
    scene: Scene

    @property
    def name(self) -> str:
        """Name of the group in folders."""
        load = self.load if isinstance(self.load, str) else f"V{1e-3 * self.load:.6g}kN"
        return f"{self.strength}-{load}"

    def probe_name(self, direction: Direction) -> str:
        """Return the name of the run in a direction."""
        a, b = map(math.degrees, direction)
        return f"{self.name}-{a:+.4g}deg{f'-T{b:.4g}deg' if b else ''}"

    def probe(self, direction: Direction) -> Scene:
        """Return the scene that pushes the caisson to failure in a direction; with torsion it is the whole caisson."""
        diameter, (a, b) = self.scene.caisson.outer_diameter, direction
        shift, turn = motion_limit(self.scene)
        plane = shift * abs(math.cos(a)) + turn * diameter * abs(math.sin(a))
        reach = math.cos(b) * plane + math.sin(b) * turn * diameter
        path = {"name": PROBE, "kind": PROBE, "load_angle": a, "lateral_displacement": reach, "role": "held-back"}
        return self._with_paths([path | ({"torsion_angle": b} if b else {})])

    def rays(self) -> Scene:
        """Return the scene with the rays that the springs are made from."""
        length = self.scene.caisson.skirt_length
        degrees = [RAYS[-1] - 180.0, *RAYS, RAYS[0] + 180.0]
        paths = []
        for before, degree, behind in zip(degrees, degrees[1:], degrees[2:], strict=False):
            angle = math.radians(degree)
            low, high = math.radians(before), math.radians(behind)  # no state at the limit between them is further
            rho = _SPARE * max(self._limit(low + (high - low) * k / (_BETWEEN - 1)) for k in range(_BETWEEN))
            u, turn = rho * math.cos(angle), rho * math.sin(angle) / length
            name = ray_name(degree)
            if abs(degree) == 90.0:
                paths.append({"name": name, "kind": "rotation", "rotation": turn})
            else:
                moved = {"name": name, "kind": "translation", "lateral_displacement": u}
                paths.append(moved | ({"rotation": turn} if degree else {}))
        return self._with_paths(paths)

    def _limit(self, angle: float) -> float:
        """Return rho [m] at the limit of motion in a direction of (u, rotation * skirt length)."""
        shift, turn = motion_limit(self.scene)
        u, v = math.cos(angle), math.sin(angle)
        lateral = max(abs(u), abs(u - v)) / shift
        return 1.0 / max(lateral, abs(v) / (turn * self.scene.caisson.skirt_length))

    def _with_paths(self, paths: Sequence[dict[str, Any]]) -> Scene:
        return self.scene.replace(paths=paths, output=_OUTPUT, caisson={"vertical_load": self.load})


def motion_limit(scene: Scene) -> tuple[float, float]:
    """Return the displacement [m] and the rotation [rad] that end a path to failure."""
    limit = scene.limit
    return limit.displacement_over_diameter * scene.caisson.outer_diameter, limit.rotation


def angles(count: int) -> list[float]:
    """Return directions [rad] of half the plane, 90 degrees last."""
    return [math.pi * (k / count - 0.5) for k in range(1, count + 1)]


def groups(scene: Scene, request: Request) -> Iterator[Group]:
    """Yield the groups of a study: every vertical load with the strength of the scene, then with design strength."""
    strengths = [(CHARACTERISTIC, scene)]
    if request.factors != StrengthFactors():
        strengths.append((DESIGN, with_design_strength(scene, request.factors)))
    seen = set()
    for strength, each in strengths:
        for load in request.loads:
            group = Group(strength, load, each)
            if group.name not in seen:
                seen.add(group.name)
                yield group
