# SPDX-License-Identifier: MIT
"""What exporters of uniaxial springs share: header, tables, and the sentences on what is lost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pysprings.core.errors import refused
from pysprings.results.exporters.base import Options, Source
from pysprings.results.exporters.conditions import springs_at
from pysprings.results.exporters.header import header
from pysprings.results.exporters.uniaxial.curve import FAR, Spring, Table
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

FEWEST = 5
UNITS = "m, rad, N, N m; reactions are those of a spring, p times the height of its slice"
ELASTIC = "nonlinear elastic (monotonic backbone): no hysteresis, no memory; not for cyclic degradation"
NOT_ODD = "vertical spring: change of V from the state at rest; lateral springs do not depend on V"
BEHIND = "behind their range springs go on with their last slope{}: no load that the full model has carried"
FREE = "torsion is not known from lateral loading: rotation about z is free; give --option torsion"


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


def prepare(
    source: Source,
    given: Options,
    target: str,
    frame: str,
    most: int | None = None,
    far: bool = True,
) -> Prepared:
    """Return the tables of an export.

    Parameters
    ----------
    target, frame
        Program and axes, for the header.
    most
        Largest number of points of a table.
    far
        Adds a point behind each end, for programs that extrapolate badly.
    """
    points = int(given["points"])
    if points < FEWEST or (most is not None and points > most):
        raise refused("--option points", f"{points} is not from {FEWEST} to {most or 'any number'}")
    springs, load = springs_at(source, given)
    made = uniaxial(springs, given["springs"] or None, load, int(given["planes"]), str(given["slices"]))
    rows = tables(made, points, far)
    torsion, first = float(given["torsion"] or 0.0), float(given["azimuth"] or 0.0)
    lost = [f"springs '{made.model.spring_set}'", *made.lost, ELASTIC, NOT_ODD, other_planes(springs, made)]
    lost += [BEHIND.format(f" to {FAR:g} times the range" if far else ""), *([] if torsion else [FREE])]
    lost += [
        f"tables of at most {points} points: {100.0 * max(row.error for row in rows):.2g} % from the curves at most",
        change_by_tables(springs, made.model, with_tables(made, rows)),
        *errors_by_role(springs, made.model, "error of these springs beside the full model"),
    ]
    angles = tuple(first + np.pi / made.planes * k for k in range(made.planes))
    return Prepared([*header(source, target, frame, UNITS), *lost], rows, lost, made, springs, angles, torsion)


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
