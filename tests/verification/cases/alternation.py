# SPDX-License-Identifier: MIT
"""Contact pressure and opening around the skirt do not alternate from point to point (coarse mesh, every step to 5 mm).

The tool's stations (one a node) beside 2x2 Gauss points a face, which alternate: each Gauss point ties the four
nodes of its face together by a penalty that is stiff beside the soil, and on the flat facets of a circle the normal
turns at every node, so that slip along the wall opens one side of the node and closes the other. With the normals
of the circle the second cause is gone and the first remains.
"""

from dataclasses import fields
from functools import cache

from tests.verification.cases.drained_push import END, design_push, long_push
from tests.verification.pushes import Push, push, push_scene
from tests.verification.rings import Alternation, alternation, skirt_rings
from tests.verification.rows import Row

_CASE = "contact around the ring"
_SOURCE = "no alternation (Schellekens & de Borst 1993)"


def measure(run: Push) -> Alternation:
    """Alternation on both walls: the worst over all steps of a push."""
    each = [alternation(skirt_rings(run, state)) for state in run.states]
    return Alternation(*(max(getattr(one, f.name) for one in each) for f in fields(Alternation)))


@cache
def rows() -> tuple[Row, ...]:
    """The tool's own stations, judged; 0.05 is a swing of 1.3 % of the mean pressure from point to point."""
    return _judged("nodal stations, to 2.5 mm", measure(design_push()))


@cache
def slow_rows() -> tuple[Row, ...]:
    """The tool's stations at 5 mm; Gauss stations with normals of facets and of the circle beside them at 2.5 mm."""
    ours = measure(design_push())
    found = [*_judged("nodal stations, to 5 mm", measure(long_push()))]
    for name, facets in (("facet", True), ("circle", False)):
        other = measure(push(push_scene(END), gauss=True, facets=facets))
        found += _beside(f"Gauss stations, {name} normals", other, ours)
    return tuple(found)


def _judged(name: str, ours: Alternation) -> tuple[Row, ...]:
    case = f"{_CASE}, {name}"
    return (
        Row.error(case, "swing of second differences over mean pressure", ours.swing, _SOURCE, 0.05),
        Row.error(case, "open stations between two loaded ones", ours.isolated, _SOURCE, 0.0),
    )


def _beside(name: str, other: Alternation, ours: Alternation) -> list[Row]:
    case, source = f"{_CASE}, {name}", "nodal stations"
    figures = [
        ("swing of second differences over mean pressure", "", other.swing, ours.swing),
        ("open stations between two loaded ones", "", other.isolated, ours.isolated),
        ("widest opening between two loaded ones", "mm", 1e3 * other.widest, 1e3 * ours.widest),
    ]
    return [Row(case, *figure, source, None) for figure in figures]
