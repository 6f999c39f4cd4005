# SPDX-License-Identifier: MIT
"""Options of exporters of uniaxial springs (light: loads nothing)."""

from __future__ import annotations

from pysprings.results.exporters.base import Option

VIRTUAL = "virtual"
RINGS, ZONE = "rings", "zone"
SETS = (VIRTUAL, "pisa", "full", "py")


def table_options(points: int, most: int | None = None) -> tuple[Option, ...]:
    """Return the options of an exporter of tables with a default (and largest) number of points."""
    limit = f", at most {most}" if most else ""
    return (
        Option("springs", "virtual: a fan at virtual depths (default with a fan); pisa, full, py: at real depths",
               choices=("", *SETS), default=""),
        Option("slices", "zone: those of the tables, the last fifth of the skirt as one (default); rings: those of the "
               "mesh, as `predict` has them", choices=("", RINGS, ZONE), default=""),
        Option("points", f"points of a table within its range{limit}", points),
        Option("planes", "even number of vertical planes with springs; 0: 8 of virtual springs, 2 of others", 0),
        Option("azimuth", "direction of the first plane, from x towards y; that of the load where there are two",
               unit="rad", example="30 deg"),
        Option("V", "vertical load of the lateral springs, of springs at several", unit="N", example="2 MN"),
        Option("rate", "rate of loading, of springs at several", unit="m/s", example="0.5 mm/s"),
        Option("torsion", "stiffness about the vertical axis, which springs do not give", unit="N m/rad",
               example="1e9 N m/rad", least=0.0),
    )  # fmt: skip
