# SPDX-License-Identifier: MIT
"""The fan of load paths that a scene asks for by its reach."""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise, product
from typing import Any

from pysprings.core.path_kinds import MEMORY, PATH_KINDS, VERTICAL
from pysprings.scene.sections import Caisson, Path, Springs
from pysprings.scene.then import Then

# Directions of (u, rotation * skirt length), degrees. Pulls with a free head lie between 10 (short skirts, load at
# mudline) and 60 (load far above), so that the rays are dense there; -45 is a load far below mudline.
RAYS = (0, 20, 30, 40, 50, 60, -45, 90)
ARMS = (0.0, 0.5, 1.0, 2.0, 5.0)  # heights of the loads of held-back pulls, diameters
_RAY = {kind.drives: name for name, kind in PATH_KINDS.items() if kind.straight}
_PULL = next(name for name, kind in PATH_KINDS.items() if kind.free_head and not kind.force)
# The part of a fan on which meshes are compared: in the default scene it has the largest differences of the whole fan.
FEW_RAYS, FEW_ARMS = (0, 50, 90), ARMS[-1:]
_SHARE = 0.5  # of the reach: vertical paths and held-back pulls
# Rays that turn back, degrees: a translation, and the directions between which pulls with a free head lie. Ends over
# the reach: what an unloading looks like depends on how large the motion before was. The middle one twice: what a
# second cycle of the same size carries more than the first is hardening.
REVERSED = (0, 30, 50)
CHANGING = 0.12  # over the reach: ends of rays on which V changes
TURNS = (0.12, -0.12, 0.24, -0.24, 0.24, -0.24, 0.4, -0.4, 0.4)
# Out of one plane, over the reach: radius of the circle, ends of the twist at the wall, and legs with their directions
# [deg] of the bow tie, and of the walk that is held back: one way round shows little of turning back
CIRCLE, TWIST = 0.25, (0.12, -0.12, 0.4, -0.4, 1.0)
BOW = ((0.45, 30), (0.45, 270), (0.9, 150), (0.45, 270), (0.45, 30))
WALK = ((0.25, 0), (0.5, 90), (0.75, 225), (0.5, 315), (0.35, 80))
MOST_TWIST = 0.5  # rad


def fan_paths(springs: Springs, caisson: Caisson) -> tuple[Path, ...]:
    """Return the paths of a fan: rays at every vertical load and rate, vertical and reversed ones, held-back pulls."""
    if springs.reach is None:
        return ()
    rates = springs.rates or (None,)
    angles = tuple(float(f"{math.degrees(angle):.9g}") for angle in springs.rays) or RAYS
    parts = [*_rays(springs, caisson, rates, angles)]
    if springs.vertical:
        parts += _vertical(springs, rates)
    if springs.memory:
        parts += _reversed(springs, caisson, rates)
        parts += _changing(springs, caisson)
    if springs.held_back:
        parts += _pulls(springs, caisson, rates[0])
    return tuple(Path(**part) for part in parts)


def space_paths(springs: Springs, caisson: Caisson) -> tuple[Path, ...]:
    """Return the paths of a fan that leave one plane: a circle, a bow tie, a twist, and a walk that is held back."""
    if springs.reach is None or not springs.directions:
        return ()
    wall = min(springs.reach / (0.5 * caisson.outer_diameter), MOST_TWIST)
    twist = {"name": "twist", "kind": "twist", "twist": TWIST[0] * wall, "role": MEMORY}
    twist["then"] = tuple(Then(end * wall) for end in TWIST[1:])
    circle = {"name": "circle", "kind": "circle", "radius": CIRCLE * springs.reach, "role": MEMORY}
    parts: list[dict[str, Any]] = [circle, {"name": "bow", "role": MEMORY, **_legs(springs.reach, BOW)}, twist]
    if springs.held_back:
        parts.append({"name": "walk", "role": "held-back", **_legs(springs.reach, WALK)})
    return tuple(Path(**part) for part in parts)


def _legs(reach: float, legs: Sequence[tuple[float, float]]) -> dict[str, Any]:
    """Return the motion of a free-head pull along legs: lengths over the reach, directions [deg]."""
    (first, angle), *more = ((share * reach, math.radians(degrees)) for share, degrees in legs)
    then = tuple(Then(length, towards=towards) for length, towards in more)
    return {"kind": _PULL, "lateral_displacement": first, "direction": angle, "then": then}


def few_paths(springs: Springs, caisson: Caisson) -> tuple[Path, ...]:
    """Return the part of a fan on which meshes are compared: few rays, and the held-back pull of the highest load."""
    if springs.reach is None:
        return ()
    rates = springs.rates or (None,)
    parts = [*_rays(springs, caisson, rates, FEW_RAYS)]
    if springs.held_back:
        parts += _pulls(springs, caisson, rates[0], FEW_ARMS)
    return tuple(Path(**part) for part in parts)


def _rays(
    springs: Springs, caisson: Caisson, rates: tuple[float | None, ...], angles: tuple[float, ...]
) -> Iterator[dict[str, Any]]:
    assert springs.reach is not None
    loads = (None, *springs.vertical_loads)
    for number, load in enumerate(loads):
        for pace, rate in enumerate(rates):
            suffix = _suffix(number, pace)
            for angle in angles:
                yield {
                    "name": ray_name(angle) + suffix, **_motion(springs.reach, angle, caisson), "vertical_load": load,
                    "duration": None if rate is None else springs.reach / rate,
                }  # fmt: skip


def _motion(rho: float, angle: float, caisson: Caisson) -> dict[str, Any]:
    """Return kind and motion of a ray of a size [m] and an angle [deg]."""
    along, turn = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    motion: dict[str, Any] = {"kind": _RAY["rotation" if angle == 90 else "u"]}
    if angle:
        motion["rotation"] = rho * turn / caisson.skirt_length
    if angle != 90:
        motion["lateral_displacement"] = rho * along
    return motion


def _reversed(springs: Springs, caisson: Caisson, rates: tuple[float | None, ...]) -> Iterator[dict[str, Any]]:
    """Yield the rays that turn back, with a small and a large amplitude, at every vertical load and rate."""
    assert springs.reach is not None
    ways = [springs.reach * abs(end - start) for start, end in pairwise((0.0, *TURNS))]
    loads = enumerate((None, *springs.vertical_loads))
    for (number, load), (pace, rate), angle in product(loads, enumerate(rates), REVERSED):
        times = [None if rate is None else way / rate for way in ways]
        motion = _motion(TURNS[0] * springs.reach, angle, caisson)
        first = motion[PATH_KINDS[motion["kind"]].imposed]
        yield {
            "name": f"{ray_name(angle)}_reversed{_suffix(number, pace)}", **motion,
            "role": MEMORY, "duration": times[0], "vertical_load": load,
            "then": tuple(Then(first * end / TURNS[0], time=t) for end, t in zip(TURNS[1:], times[1:], strict=True)),
        }  # fmt: skip


def _changing(springs: Springs, caisson: Caisson) -> Iterator[dict[str, Any]]:
    """Yield the rays that turn back while the vertical load goes to the largest of `vertical_loads`, half back, there.

    To the smallest where none is above the one at rest. Half back is between it and that at rest; half of it where that
    is the balanced one, which the scene does not have.
    """
    assert springs.reach is not None
    if not springs.vertical_loads or springs.rates:
        return
    rest = 0.0 if isinstance(caisson.vertical_load, str) else caisson.vertical_load
    most = max(springs.vertical_loads, key=lambda V: (rest < V, abs(V - rest)))
    for angle in REVERSED:
        motion = _motion(CHANGING * springs.reach, angle, caisson)
        first = motion[PATH_KINDS[motion["kind"]].imposed]
        yield {
            "name": f"{ray_name(angle)}_loads", **motion, "role": MEMORY,
            "then": tuple(
                part for load, end in ((most, -first), (0.5 * (rest + most), first), (most, -first))
                for part in (Then(None, load=load), Then(end))
            ),
        }  # fmt: skip


def _suffix(number: int, pace: int) -> str:
    """Return what names of paths at a further vertical load or rate end with."""
    return (f"_load_{number}" if number else "") + (f"_rate_{pace}" if pace else "")


def ray_name(angle: float) -> str:
    """Return the name of a ray of an angle [deg]."""
    return f"ray_{'minus_' if angle < 0 else ''}{abs(angle):g}".replace(".", "_")


def _vertical(springs: Springs, rates: tuple[float | None, ...]) -> Iterator[dict[str, Any]]:
    assert springs.reach is not None
    for (pace, rate), (name, sign) in product(enumerate(rates), (("down", 1.0), ("up", -1.0))):
        way = sign * _SHARE * springs.reach
        yield {"name": name + _suffix(0, pace), "kind": VERTICAL, "vertical_displacement": way, "rate": rate}


def _pulls(
    springs: Springs, caisson: Caisson, rate: float | None, arms: tuple[float, ...] = ARMS
) -> Iterator[dict[str, Any]]:
    assert springs.reach is not None
    for arm in arms:
        yield {
            "name": f"pull_{arm:g}_D".replace(".", "_"), "kind": _PULL, "arm": arm * caisson.outer_diameter,
            "lateral_displacement": _SHARE * springs.reach, "role": "held-back", "rate": rate,
        }  # fmt: skip
