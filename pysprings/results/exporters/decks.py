# SPDX-License-Identifier: MIT
"""CalculiX and Abaqus: `*SPRING, NONLINEAR` between ground and points of a rigid caisson, with an example.

The points follow the lid by `*EQUATION`. In CalculiX the lid is a reference node with a node of rotations
(`*RIGID BODY`), in Abaqus a node with six degrees of freedom.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count
from typing import TYPE_CHECKING

from pysprings.results.exporters.base import Exported, Exporter, Option, Options, Source, Target
from pysprings.results.exporters.uniaxial.options import table_options

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from pysprings.results.exporters.uniaxial.export import Prepared, Terms

    Array = NDArray[np.float64]
    Pair = tuple[Array, Array]

PIECE = 200  # points: CalculiX 2.20 reads these of a table; longer ones give wrong answers


@dataclass(frozen=True, slots=True)
class _Program:
    """How a program takes springs.

    Attributes
    ----------
    lid : (node, degree of freedom) of ux, uy, uz, rx, ry, rz of the lid.
    axial : SPRINGA to a node at a distance. CalculiX 2.20 iterates with the tangent of SPRINGA, but not of SPRING1 and
        SPRING2, which converge slowly (routine springstiff_n2f: it sets the displacement for the first alone).
    piece : largest number of points of a table; springs in parallel carry longer ones.
    """

    lid: dict[str, tuple[int, int]]
    axial: bool
    piece: int | None


def _elements(made: Prepared, program: _Program, first: int) -> Iterator[str]:
    """Yield nodes, elements, equations and tables of all springs."""
    import numpy as np

    from pysprings.results.exporters.uniaxial.export import read_by

    numbers = count(first)
    tag = first
    for row in made.tables:
        for angle in made.angles if row.spring.odd else (0.0,):
            yield f"** {row.spring.name}, depth {row.spring.depth:.6g} m, plane at {math.degrees(angle):g} degrees"
            yield from _spring(tag, read_by(row.spring, angle), (row.q, row.f), program, numbers)
            tag += 2
    if made.torsion:
        yield "** torsion"
        q = np.array([-1.0, 0.0, 1.0])
        yield from _spring(tag, {"rz": 1.0}, (q, made.torsion * q), program, numbers)


def _spring(tag: int, terms: Terms, table: Pair, program: _Program, numbers: Iterator[int]) -> Iterator[str]:
    """Yield a spring between ground, node `tag`, and a node whose displacement 1 is what the spring reads."""
    distance = max(1.0, 10.0 ** math.ceil(math.log10(2.0 * abs(table[0]).max()))) if program.axial else 0.0
    yield f"*NODE, NSET=CAISSON\n{tag}, {-distance:g}, 0., 0.\n{tag + 1}, 0., 0., 0."
    yield f"*BOUNDARY\n{tag}, 1, 3" + (f"\n{tag + 1}, 2, 3" if program.axial else "")
    parts = [f"{tag + 1}, 1, 1."]
    parts += [f"{program.lid[name][0]}, {program.lid[name][1]}, {-factor:.12E}" for name, factor in terms.items()]
    yield f"*EQUATION\n{len(parts)}"
    yield from (", ".join(parts[k : k + 4]) for k in range(0, len(parts), 4))
    for q, f in _pieces(*table, program.piece):
        number = next(numbers)
        kind, nodes = ("SPRINGA", (tag, tag + 1)) if program.axial else ("SPRING2", (tag + 1, tag))
        yield f"*ELEMENT, TYPE={kind}, ELSET=SPRING{number}\n{number}, {nodes[0]}, {nodes[1]}"
        yield f"*SPRING, ELSET=SPRING{number}, NONLINEAR"
        # the relative displacement of SPRING2 is that of the first node less that of the second
        yield from [] if program.axial else ["1, 1"]
        # numbers have a decimal point: CalculiX takes integers for degrees of freedom
        yield from (f"{y + 0.0:.11E}, {x + 0.0:.11E}" for x, y in zip(q, f, strict=True))


def _pieces(q: Array, f: Array, most: int | None) -> Iterator[Pair]:
    """Yield a curve as parts of at most `most` points whose sum it is; each is constant behind its ends."""
    step = (most or q.size) - 1
    for k in range(0, q.size - 1, step):
        x, y = q[k : k + step + 1], f[k : k + step + 1]
        yield x, y - (0.0 if x[0] <= 0.0 <= x[-1] else y[0] if x[0] > 0.0 else y[-1])


def _header(made: Prepared) -> str:
    return "".join(f"** {line}\n" for line in made.head)


def _include(made: Prepared, program: _Program, first: int, more: str = "") -> str:
    return _header(made) + more + "\n".join(_elements(made, program, first)) + "\n"


_EXAMPLE = """{head}** A running example: a rigid caisson under H = 1 MN at 5 m above the lid; replace it by the model.
{lid}
*INCLUDE, INPUT={include}
*STEP, INC=1000{step}
{controls}*STATIC
1., 1.
*CLOAD
{lid_node}, 1, 1.E6
{turn_node}, {turn_dof}, 5.E6
*NODE PRINT, NSET=LID
U
*END STEP
"""


def _nodes(options: Options) -> tuple[int, int, int]:
    return int(options["lid"]), int(options["rotations"]), int(options["first"])


_CALCULIX_FRAME = (
    "z up; lid at mudline: node LID (displacements 1 to 3) and node ROT (rotations, as its displacements 1 to 3), of a "
    "*RIGID BODY of the structure (REF NODE, ROT NODE); coordinates of the other nodes do not matter"
)
_NONLINEAR = """** In a linear step CalculiX takes the initial stiffness of nonlinear springs, without a message.
** A material with *PLASTIC, which nothing uses, makes it so.
*MATERIAL, NAME=PYSPRINGS_NONLINEAR
*ELASTIC
1., 0.
*PLASTIC
1.E30, 0.
"""
# corners of tables make its iteration converge slowly, by a factor of about 0.8
_CONTROLS = """*CONTROLS, PARAMETERS=TIME INCREMENTATION
500, 500, 9, 500, 10, 4, , 5, ,
*CONTROLS, PARAMETERS=FIELD
1.E-8, 1.E10, 1., , 1.E-8, , 1.E-10, 1.E-9
"""


def _write_calculix(source: Source, target: Target, options: Options) -> Exported:
    from pysprings.results.exporters.uniaxial.export import prepare

    made = prepare(source, options, "CalculiX springs", _CALCULIX_FRAME)
    node, rotations, first = _nodes(options)
    moves = {f"u{axis}": (node, k) for k, axis in enumerate("xyz", 1)}
    turns = {f"r{axis}": (rotations, k) for k, axis in enumerate("xyz", 1)}
    program = _Program(moves | turns, axial=True, piece=PIECE)
    body = f"*NODE, NSET=LID\n{node}, 0., 0., 0.\n{rotations}, 0., 0., 0."
    body += "" if made.torsion else f"\n*BOUNDARY\n{rotations}, 3"
    example = _EXAMPLE.format(
        head=_header(made), lid=body, include="caisson_calculix.inp", step="", controls=_CONTROLS, lid_node=node,
        turn_node=rotations, turn_dof=2,
    )  # fmt: skip
    files = [
        target.write("caisson_calculix.inp", _include(made, program, first, _NONLINEAR)),
        target.write("example_calculix.inp", example),
    ]
    return Exported(files, made.lost)


def _write_abaqus(source: Source, target: Target, options: Options) -> Exported:
    from pysprings.results.exporters.uniaxial.export import prepare

    frame = "z up; lid at mudline: node LID with six degrees of freedom; coordinates of the other nodes do not matter"
    made = prepare(source, options, "Abaqus springs (not run in Abaqus; the same tables run in CalculiX)", frame)
    node, _, first = _nodes(options)
    names = ("ux", "uy", "uz", "rx", "ry", "rz")
    program = _Program({name: (node, k) for k, name in enumerate(names, 1)}, axial=False, piece=None)
    body = f"*NODE, NSET=LID\n{node}, 0., 0., 0.\n*ELEMENT, TYPE=MASS, ELSET=LIDMASS\n{first - 1}, {node}\n"
    body += f"*MASS, ELSET=LIDMASS\n1.\n*ELEMENT, TYPE=ROTARYI, ELSET=LIDTURN\n{first - 2}, {node}\n"
    body += "*ROTARY INERTIA, ELSET=LIDTURN\n1., 1., 1."  # the rotations of the lid are there with an element alone
    body += "" if made.torsion else f"\n*BOUNDARY\n{node}, 6"
    example = _EXAMPLE.format(
        head=_header(made), lid=body, include="caisson_abaqus.inp", step=", NLGEOM=NO", controls="",
        lid_node=node, turn_node=node, turn_dof=5,
    )  # fmt: skip
    files = [
        target.write("caisson_abaqus.inp", _include(made, program, first)),
        target.write("example_abaqus.inp", example),
    ]
    return Exported(files, made.lost)


_NODES = (
    Option("lid", "node of the lid", 1),
    Option("rotations", "node of the rotations of the lid (CalculiX)", 2),
    Option("first", "first number of nodes and elements", 900001),
)
CALCULIX = Exporter(
    name="calculix",
    description="springs for CalculiX: *SPRING, NONLINEAR as include file, and an example",
    write=_write_calculix,
    suffixes=(".inp",),
    options=(*table_options(401), *_NODES),
)
ABAQUS = Exporter(
    name="abaqus",
    description="springs for Abaqus: *SPRING, NONLINEAR as include file, and an example; not run in Abaqus",
    write=_write_abaqus,
    suffixes=(".inp",),
    options=(*table_options(401), *_NODES),
)
