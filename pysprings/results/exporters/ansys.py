# SPDX-License-Identifier: MIT
"""ANSYS: COMBIN39 springs as an APDL include; at most 20 points a table, the last slope goes on behind its ends."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from pysprings.results.exporters.base import Exported, Exporter, Option, Options, Source, Target
from pysprings.results.exporters.uniaxial.options import table_options

if TYPE_CHECKING:
    from pysprings.results.exporters.uniaxial.export import Prepared, Terms

POINTS = 20
_FRAME = "z up; lid at mudline: node LID with six degrees of freedom in the global axes"
_LABELS = {"ux": "UX", "uy": "UY", "uz": "UZ", "rx": "ROTX", "ry": "ROTY", "rz": "ROTZ"}


def _lines(made: Prepared, lid: int, first: int) -> Iterator[str]:
    from pysprings.results.exporters.uniaxial.export import read_by

    yield from (f"! {line}" for line in made.head)
    tag = first
    for row in made.tables:
        yield f"! {row.spring.name}, depth {row.spring.depth:.6g} m"
        values = [value + 0.0 for pair in zip(row.q, row.f, strict=True) for value in pair]
        for angle in made.angles if row.spring.odd else (0.0,):
            yield from _spring(tag, read_by(row.spring, angle), values, lid)
            tag += 2
    if made.torsion:
        end = 0.1
        yield from _spring(tag, {"rz": 1.0}, [-end, -made.torsion * end, 0.0, 0.0, end, made.torsion * end], lid)


def _spring(tag: int, terms: Terms, values: list[float], lid: int) -> Iterator[str]:
    """Yield a spring: real constants D1, F1, D2, F2 ..., and a node whose UX is what it reads of the lid."""
    yield f"ET,{tag},COMBIN39\nKEYOPT,{tag},1,0\nKEYOPT,{tag},2,0\nKEYOPT,{tag},3,1\nKEYOPT,{tag},4,0"
    cells = [f"{value:.10g}" for value in values]
    yield f"R,{tag},{','.join(cells[:6])}"
    yield from (f"RMORE,{','.join(cells[k : k + 6])}" for k in range(6, len(cells), 6))
    yield f"N,{tag},0,0,0\nD,{tag},UX,0\nN,{tag + 1},0,0,0"
    parts = [f"{tag + 1},UX,-1", *(f"{lid},{_LABELS[name]},{factor:.12g}" for name, factor in terms.items())]
    # three terms a command; a second one with the number of the first adds terms
    yield from (f"CE,{'HIGH' if k else 'NEXT'},0,{','.join(parts[k : k + 3])}" for k in range(0, len(parts), 3))
    yield f"TYPE,{tag}\nREAL,{tag}\nEN,{tag},{tag},{tag + 1}"


def _write(source: Source, target: Target, options: Options) -> Exported:
    from pysprings.results.exporters.uniaxial.export import prepare

    made = prepare(source, options, "ANSYS COMBIN39 (APDL, not run in ANSYS)", _FRAME, most=POINTS, far=False)
    lines = _lines(made, int(options["lid"]), int(options["first"]))
    return Exported([target.write("caisson_ansys.inp", "\n".join(lines) + "\n")], made.lost)


ANSYS = Exporter(
    name="ansys",
    description="springs for ANSYS: COMBIN39 as APDL include; not run in ANSYS",
    write=_write,
    suffixes=(".inp",),
    options=(
        *table_options(POINTS, POINTS),
        Option("lid", "node of the lid", 1),
        Option("first", "first number of nodes, elements, types and real constants", 900001),
    ),
)
