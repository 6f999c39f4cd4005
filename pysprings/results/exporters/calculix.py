# SPDX-License-Identifier: MIT
"""CalculiX: `*SPRING, NONLINEAR` between ground and points of a rigid caisson, with an example.

The points follow the lid by `*EQUATION`; the lid is a reference node with a node of rotations (`*RIGID BODY`). The
syntax is that of Abaqus, where the lid would be one node with six degrees of freedom (not run there).
"""

import math
from collections.abc import Iterator
from itertools import count

import numpy as np

from pysprings.core.arrays import Array
from pysprings.core.text import commented
from pysprings.results.exporters.base import Exported, Options, Source, Target, rendered
from pysprings.results.exporters.uniaxial_sets import Prepared, Terms, prepare, read_by

Pair = tuple[Array, Array]

PIECE = 200  # points: CalculiX 2.20 reads these of a table; longer ones give wrong answers


Lid = dict[str, tuple[int, int]]  # (node, degree of freedom) of ux, uy, uz, rx, ry, rz of the lid


def _elements(made: Prepared, lid: Lid, first: int) -> Iterator[str]:
    """Yield nodes, elements, equations and tables of all springs."""
    numbers = count(first)
    tag = first
    for row in made.tables:
        for angle in made.angles if row.spring.odd else (0.0,):
            place = f"{row.spring.name}, depth {row.spring.depth:.6g} m, plane at {math.degrees(angle):g} degrees"
            yield from commented("**", [place])
            yield from _spring(tag, read_by(row.spring, angle), (row.q, row.f), lid, numbers)
            tag += 2
    if made.torsion:
        yield "** torsion"
        q = np.array([-1.0, 0.0, 1.0])
        yield from _spring(tag, {"rz": 1.0}, (q, made.torsion * q), lid, numbers)


def _spring(tag: int, terms: Terms, table: Pair, lid: Lid, numbers: Iterator[int]) -> Iterator[str]:
    """Yield a spring between ground, node `tag`, and a node whose displacement 1 is what the spring reads.

    SPRINGA between nodes at a distance: CalculiX 2.20 iterates with its tangent, but not with those of SPRING1 and
    SPRING2, which converge slowly (routine springstiff_n2f: it sets the displacement for the first alone).
    """
    distance = max(1.0, 10.0 ** math.ceil(math.log10(2.0 * abs(table[0]).max())))
    yield f"*NODE, NSET=CAISSON\n{tag}, {-distance:g}, 0., 0.\n{tag + 1}, 0., 0., 0."
    yield f"*BOUNDARY\n{tag}, 1, 3\n{tag + 1}, 2, 3"
    parts = [f"{tag + 1}, 1, 1."]
    parts += [f"{lid[name][0]}, {lid[name][1]}, {-factor:.12E}" for name, factor in terms.items()]
    yield f"*EQUATION\n{len(parts)}"
    yield from (", ".join(parts[k : k + 4]) for k in range(0, len(parts), 4))
    for q, f in _pieces(*table):
        number = next(numbers)
        yield f"*ELEMENT, TYPE=SPRINGA, ELSET=SPRING{number}\n{number}, {tag}, {tag + 1}"
        yield f"*SPRING, ELSET=SPRING{number}, NONLINEAR"
        # numbers have a decimal point: CalculiX takes integers for degrees of freedom
        yield from (f"{y + 0.0:.11E}, {x + 0.0:.11E}" for x, y in zip(q, f, strict=True))


def _pieces(q: Array, f: Array) -> Iterator[Pair]:
    """Yield a curve as parts of at most `PIECE` points whose sum it is; each is constant behind its ends."""
    step = PIECE - 1
    for k in range(0, q.size - 1, step):
        x, y = q[k : k + step + 1], f[k : k + step + 1]
        yield x, y - (0.0 if x[0] <= 0.0 <= x[-1] else y[0] if x[0] > 0.0 else y[-1])


_FRAME = (
    "z up; lid at mudline: node LID (displacements 1 to 3) and node ROT (rotations, as its displacements 1 to 3), of a "
    "*RIGID BODY of the structure (REF NODE, ROT NODE); coordinates of the other nodes do not matter"
)


def write(source: Source, target: Target, options: Options) -> Exported:
    """Write the springs, and an example that includes them."""
    made = prepare(source, options, "CalculiX springs", _FRAME)
    node, rotations, first = (int(options[name]) for name in ("lid", "rotations", "first"))
    lid = {f"u{axis}": (node, k) for k, axis in enumerate("xyz", 1)}
    lid |= {f"r{axis}": (rotations, k) for k, axis in enumerate("xyz", 1)}
    values = {
        "head": commented("**", made.head), "elements": "\n".join(_elements(made, lid, first)),
        "lid": node, "rotations": rotations, "torsion": made.torsion,
    }  # fmt: skip
    files = [
        target.write("caisson_calculix.inp", rendered("calculix.inp.j2", **values)),
        target.write("example_calculix.inp", rendered("calculix_example.inp.j2", **values)),
    ]
    return Exported(files, made.lost)
