# SPDX-License-Identifier: MIT
"""What exporters of uniaxial springs share: header, tables, and the sentences on what is lost.

Springs that unload and reload by Masing's rule stand beside paths of the full model that turn back.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pysprings.core.errors import refused
from pysprings.core.variables import known_torsion
from pysprings.results.exporters.base import Options, Source
from pysprings.results.exporters.header import header, springs_at, torsion_words
from pysprings.results.exporters.uniaxial.curve import FAR, Spring, Table, cosines
from pysprings.results.exporters.uniaxial.sets import (
    Uniaxial,
    change_by_tables,
    errors_by_role,
    other_planes,
    tables,
    uniaxial,
    with_tables,
)  # fmt: skip
from pysprings.springs.springs import Springs

Array = NDArray[np.float64]


def masing(q: Array, f: Array, x: Array) -> Array:
    """Return the reactions (n,) along displacements x (n,) that start at rest (Masing 1926; Iwan 1967).

    The curve through the points q >= 0, f is a sum of sliders in parallel, each elastic up to one of its points.
    """
    slope = np.diff(f) / np.diff(q)
    stiffness, limit = slope - np.append(slope[1:], 0.0), q[1:]
    spring, out = np.zeros(limit.size), np.empty(x.size)
    for i, move in enumerate(np.diff(x, prepend=0.0)):
        spring = np.clip(spring + move, -limit, limit)
        out[i] = stiffness @ spring
    return out


def errors_on_reversals(springs: Springs, made: Uniaxial, tables: list[Table]) -> list[str]:
    """Return a sentence for each lateral path that turns back: H and M of Masing's rule beside the full model."""
    lines = []
    for path in springs.paths.values():
        if path.is_vertical or not path.turns_back:
            continue
        u, rotation = path.u - path.u[0], path.rotation - path.rotation[0]
        found = masing_loads(made, tables, u, rotation)
        parts = []
        for key, own in zip("HM", found, strict=True):
            exact = path[key] - path[key][0]
            parts.append(f"{key} by {100.0 * np.abs(own - exact).max() / max(np.abs(exact).max(), 1e-300):.0f} %")
        lines.append(
            f"Masing's rule on path {path.name} ({path.role}): off by {' and '.join(parts)} of the largest load"
        )
    return lines or ["the springs hold no path that turns back: the error of Masing's rule is not known for them"]


def masing_loads(made: Uniaxial, tables: list[Table], u: Array, rotation: Array) -> tuple[Array, Array]:
    """Return H [N] and M [N m] (n,) along a motion in one of the planes, from rest, by Masing's rule."""
    H, M = np.zeros_like(u), np.zeros_like(u)
    for each in tables:
        if not each.spring.odd:
            continue
        q, f = each.q[each.q >= 0.0], each.f[each.q >= 0.0]
        lateral = each.spring.direction == "lateral"
        read = u - each.spring.depth * rotation if lateral else rotation
        force = sum(n * c * masing(q, f, c * read) for c, n in zip(*cosines(made.planes), strict=True))
        H += force if lateral else 0.0
        M += -force * each.spring.depth if lateral else force
    return H, M


FEWEST = 5
UNITS = "m, rad, N, N m; reactions are those of a spring, p times the height of its slice"
ELASTIC = "nonlinear elastic (monotonic backbone): no hysteresis, no memory; not for cyclic degradation"
NOT_ODD = "vertical spring: change of V from the state at rest; lateral springs do not depend on V"
BEHIND = (
    f"behind their range springs go on with their last slope to {FAR:g} times the range: no load that the full model "
    "has carried"
)


@dataclass(frozen=True, slots=True, eq=False)
class Prepared:
    """Header lines, tables, sentences on what is lost, and the springs behind them: uniaxial ones, and the spring set.

    angles (planes,) are those of the planes of lateral and rotational springs from x towards y [rad].
    """

    head: list[str]
    tables: list[Table]
    lost: list[str]
    made: Uniaxial
    springs: Springs
    angles: tuple[float, ...]
    torsion: float


def prepare(source: Source, given: Options, target: str, frame: str) -> Prepared:
    """Return the tables of an export for a program (``target``) and its axes (``frame``), which the header names.

    A far point stands behind each end of a table, for programs that extrapolate badly.
    """
    points = int(given["points"])
    if points < FEWEST:
        raise refused("--option points", f"{points} is not from {FEWEST} to any number")
    springs, load = springs_at(source, given)
    made = uniaxial(springs, given["springs"] or None, load, int(given["planes"]), str(given["slices"]))
    rows = tables(made, points)
    torsion, first = known_torsion(springs.attrs), float(given["azimuth"] or 0.0)
    lost = [f"springs '{made.model.spring_set}'", *made.lost, ELASTIC, NOT_ODD, other_planes(springs, made)]
    lost += [BEHIND, torsion_words(torsion)]
    lost += [
        f"tables of at most {points} points: {100.0 * max(row.error for row in rows):.2g} % from the curves at most",
        change_by_tables(springs, made.model, with_tables(made, rows)),
        *errors_by_role(springs, made.model, "error of these springs beside the full model"),
    ]
    angles = tuple(first + np.pi / made.planes * k for k in range(made.planes))
    return Prepared([*header(source, target, frame, UNITS), *lost], rows, lost, made, springs, angles, torsion or 0.0)


Terms = dict[str, float]


def read_by(spring: Spring, angle: float) -> Terms:
    """Return the displacement that a spring reads as factors of ux, uy, uz, rx, ry, rz of the lid, z up.

    angle [rad] is that of its plane from x towards y; the point at a depth moves by u + rotation x (0, 0, -depth).
    """
    c, s = float(np.cos(angle)), float(np.sin(angle))
    if spring.direction == "vertical":
        terms = {"uz": -1.0}
    elif spring.direction == "rotation":
        terms = {"ry": c, "rx": -s}
    else:
        terms = {"ux": c, "uy": s, "ry": -spring.depth * c, "rx": spring.depth * s}
    return {name: factor for name, factor in terms.items() if abs(factor) > 1e-12}
