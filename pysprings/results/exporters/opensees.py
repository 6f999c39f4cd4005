# SPDX-License-Identifier: MIT
"""OpenSees: uniaxial springs at the ends of stiff beams under a node of the lid, as Python (openseespy) and Tcl.

Rigid links would make the lid a retained node: Transformation then loses freedoms of a lid that fix() holds after the
first step, and the answer depends on the steps.

`ElasticMultiLinear` has no hysteresis and is the default. `MultiLinear` unloads and reloads by Masing's rule, which
sand and clay around a caisson do not follow; it is written on request, and labelled.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pysprings.core.text import commented
from pysprings.results.exporters.base import Exported, Options, Source, Target, rendered
from pysprings.results.exporters.uniaxial_curve import Table
from pysprings.results.exporters.uniaxial_sets import Prepared, errors_on_reversals, prepare

_FRAME = (
    "3D (ndm 3, ndf 6), z up; springs in vertical planes at depths below the lid node, which is at mudline, at the "
    "ends of stiff beams: any constraint handler works, and fix() may hold any freedom of the lid"
)
_MASING = (
    "MultiLinear unloads and reloads by Masing's rule, symmetric; on the paper's caisson in sand its load was off by "
    "50 to 75 % of the peak where the load turned"
)
_RIGID = 1e6  # stiffness of a beam over that of the stiffest spring: answers differ by 4e-8, loads round to 0.1 N
_DIRECTIONS = {"lateral": (1, 2), "rotation": (5, 4), "vertical": (3,)}


def _cells(values: NDArray) -> list[str]:
    return [f"{float(value) + 0.0:.12g}" for value in values]


def _spring(row: Table) -> dict[str, Any]:
    """Return a spring as the templates have it; vertical ones are turned upwards."""
    spring, up = row.spring, -1 if row.spring.direction == "vertical" else 1
    depth = spring.depth if spring.direction == "lateral" else 0.0
    return {
        "name": spring.name, "depth": f"{depth:.12g}", "directions": _DIRECTIONS[spring.direction],
        "strain": _cells(up * row.q[::up]), "stress": _cells(up * row.f[::up]),
    }  # fmt: skip


def _values(made: Prepared) -> dict[str, Any]:
    """Return header, springs, directions of the axes, torsion [N m/rad] and the stiffness of beams [N/m]."""
    half = np.array(made.angles[: len(made.angles) // 2])
    rigid = _RIGID * max(float(np.abs(np.diff(row.f) / np.diff(row.q)).max()) for row in made.tables)
    return {
        "head": commented("#", made.head), "springs": [_spring(row) for row in made.tables],
        "axes": [(f"{c:.15g}", f"{s:.15g}") for c, s in zip(np.cos(half), np.sin(half), strict=True)],
        "torsion": f"{made.torsion:.12g}", "rigid": f"{rigid:.3e}",
    }  # fmt: skip


def write(source: Source, target: Target, options: Options) -> Exported:
    """Write the springs in Python and in Tcl."""
    made = prepare(source, options, "OpenSees springs", _FRAME)
    masing, first = options["material"] == "masing", int(options["first"])
    if masing:
        label = [_MASING, *errors_on_reversals(made.springs, made.made, made.tables)]
        made = replace(made, head=[*made.head, *label], lost=[*made.lost, *label])
    values = _values(made) | {"masing": int(masing), "first": first}
    files = [
        target.write(f"caisson_opensees.{ending}", rendered(f"opensees.{ending}.j2", **values))
        for ending in ("py", "tcl")
    ]
    return Exported(files, made.lost)
