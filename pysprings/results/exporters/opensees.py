# SPDX-License-Identifier: MIT
"""OpenSees: uniaxial springs at the ends of stiff beams under a node of the lid, as Python (openseespy) and Tcl.

Rigid links would make the lid a retained node: Transformation then loses freedoms of a lid that fix() holds after the
first step, and the answer depends on the steps.

`ElasticMultiLinear` has no hysteresis and is the default. `MultiLinear` unloads and reloads by Masing's rule, which
sand and clay around a caisson do not follow; it is written on request, and labelled.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pysprings.core.text import commented
from pysprings.results.exporters.base import Exported, Options, Source, Target
from pysprings.results.exporters.uniaxial_sets import Prepared, errors_on_reversals, prepare

_FRAME = (
    "3D (ndm 3, ndf 6), z up; springs in vertical planes at depths below the lid node, which is at mudline, at the "
    "ends of stiff beams: any constraint handler works, and fix() may hold any freedom of the lid"
)
_MASING = (
    "MultiLinear unloads and reloads by Masing's rule, symmetric; on the paper's caisson in sand its load was off by "
    "50 to 75 % of the peak where the load turned"
)
_RIGID = 1e8  # stiffness of a beam over that of the stiffest spring: answers differ by less than 1e-9
_DIRECTIONS = {"lateral": (1, 2), "rotation": (5, 4), "vertical": (3,)}
_PYTHON = '''

def attach(ops, lid, first={first}, skirt=None):
    """Hang the caisson on the node lid of a model (ndm 3, ndf 6); nodes, materials, elements from first on.

    skirt: {{depth: node}} of a skirt of beams; lateral springs at these depths (to 1 mm) hang on its nodes.
    """
    x, y, z = ops.nodeCoord(lid)
    tag = element = first
    ops.geomTransf("Linear", first, 1.0, 0.0, 0.0)
    for depth, directions, strain, stress in SPRINGS:
        ground, node = tag, lid
        ops.node(ground, x, y, z - depth)
        ops.fix(ground, 1, 1, 1, 1, 1, 1)
        own = [beam for at, beam in (skirt or {{}}).items() if directions == (1, 2) and abs(at - depth) < 1e-3]
        if own:
            node = own[0]
        elif depth:
            node = tag + 1  # at the end of a beam that is far stiffer than any spring
            ops.node(node, x, y, z - depth)
            size = depth, RIGID, RIGID, depth, depth**3 / 3.0, depth**3 / 3.0
            ops.element("elasticBeamColumn", element, lid, node, *size, first)
            element += 1
        if MASING and directions != (3,):
            pairs = [value for pair in zip(strain, stress) if pair[0] > 0.0 for value in pair]
            ops.uniaxialMaterial("MultiLinear", tag, *pairs)
        else:
            ops.uniaxialMaterial("ElasticMultiLinear", tag, "-strain", *strain, "-stress", *stress)
        acts = ["-mat", *[tag] * len(directions), "-dir", *directions]
        for c, s in AXES if directions != (3,) else [(1.0, 0.0)]:
            axes = ["-orient", c, s, 0.0, -s, c, 0.0]
            ops.element("zeroLength", element, ground, node, *acts, *axes)
            element += 1
        tag += 2
    if TORSION:
        ops.node(tag, x, y, z)
        ops.fix(tag, 1, 1, 1, 1, 1, 1)
        ops.uniaxialMaterial("Elastic", tag, TORSION)
        ops.element("zeroLength", element, tag, lid, "-mat", tag, "-dir", 6)
'''
_TCL = """
proc attach_caisson {{lid {{first {first}}} {{skirt {{}}}}}} {{
    # hangs the caisson on the node lid of a model (ndm 3, ndf 6); tags of nodes, materials and elements from first on;
    # skirt: depth node depth node ... of a skirt of beams; lateral springs at these depths (to 1 mm) hang on its nodes
    global PYSPRINGS
    lassign [nodeCoord $lid] x y z
    set tag $first
    set number $first
    geomTransf Linear $first 1.0 0.0 0.0
    foreach spring $PYSPRINGS(springs) {{
        lassign $spring depth directions strain stress
        set at [expr {{$z - $depth}}]
        set node $lid
        node $tag $x $y $at
        fix $tag 1 1 1 1 1 1
        foreach {{level beam}} $skirt {{
            if {{$directions == "1 2" && abs($level - $depth) < 1e-3}} {{ set node $beam }}
        }}
        if {{$depth != 0 && $node == $lid}} {{
            set node [expr {{$tag + 1}}]
            node $node $x $y $at
            set inertia [expr {{$depth**3 / 3.0}}]
            element elasticBeamColumn $number $lid $node $depth $PYSPRINGS(rigid) $PYSPRINGS(rigid) $depth \\
                $inertia $inertia $first
            incr number
        }}
        if {{$PYSPRINGS(masing) && $directions != 3}} {{
            set pairs {{}}
            foreach e $strain s $stress {{ if {{$e > 0}} {{ lappend pairs $e $s }} }}
            uniaxialMaterial MultiLinear $tag {{*}}$pairs
        }} else {{
            uniaxialMaterial ElasticMultiLinear $tag 0.0 -strain {{*}}$strain -stress {{*}}$stress
        }}
        set materials [lrepeat [llength $directions] $tag]
        set axes $PYSPRINGS(axes)
        if {{$directions == 3}} {{ set axes {{{{1.0 0.0}}}} }}
        foreach axis $axes {{
            lassign $axis c s
            element zeroLength $number $tag $node -mat {{*}}$materials -dir {{*}}$directions \\
                -orient $c $s 0.0 [expr {{-$s}}] $c 0.0
            incr number
        }}
        incr tag 2
    }}
    if {{$PYSPRINGS(torsion) != 0}} {{
        node $tag $x $y $z
        fix $tag 1 1 1 1 1 1
        uniaxialMaterial Elastic $tag $PYSPRINGS(torsion)
        element zeroLength $number $tag $lid -mat $tag -dir 6
    }}
}}
"""


@dataclass(frozen=True, slots=True)
class _Words:
    """How a language writes the data: lines around springs and numbers, and assignments."""

    begin: str
    spring: str
    between: str
    ends: str
    end: str
    comma: str
    axes: str
    value: str


_IN_PYTHON = _Words(
    "SPRINGS = [", "    ({depth:.12g}, ({directions},), [", "    ], [", "    ]),", "]", ",",
    "AXES = [{pairs}]  # cos, sin of the first of two planes at right angles", "{upper} = {value}",
)  # fmt: skip
_IN_TCL = _Words(
    "set PYSPRINGS(springs) {{", "    {{{depth:.12g} {{{directions}}} {{", "    }} {{", "    }}}}", "}}", "",
    "set PYSPRINGS(axes) {{{pairs}}}", "set PYSPRINGS({lower}) {value}",
)  # fmt: skip


def _numbers(values: NDArray, comma: str) -> Iterator[str]:
    cells = [f"{float(value) + 0.0:.12g}" for value in values]
    yield from (f"        {f'{comma} '.join(cells[k : k + 8])}{comma}" for k in range(0, len(cells), 8))


def _data(made: Prepared, words: _Words, masing: bool) -> Iterator[str]:
    """Yield header and data in the words of a language; vertical springs are turned upwards."""
    yield from commented("#", made.head)
    yield "# depth below the lid node [m]; directions of OpenSees; displacements [m, rad]; reactions [N, N m]"
    yield words.begin.format()
    for row in made.tables:
        up = -1 if row.spring.direction == "vertical" else 1
        directions = f"{words.comma} ".join(map(str, _DIRECTIONS[row.spring.direction]))
        yield from commented("    #", [row.spring.name] if words is _IN_PYTHON else [])
        depth = row.spring.depth if row.spring.direction == "lateral" else 0.0
        yield words.spring.format(depth=depth, directions=directions)
        yield from _numbers(up * row.q[::up], words.comma)
        yield words.between.format()
        yield from _numbers(up * row.f[::up], words.comma)
        yield words.ends.format()
    yield words.end.format()
    yield from _settings(made, words, masing)


def _settings(made: Prepared, words: _Words, masing: bool) -> Iterator[str]:
    """Yield axes of the springs, torsion [N m/rad], unloading by Masing's rule (1) or not (0), beams [N/m]."""
    half = np.array(made.angles[: len(made.angles) // 2])
    pairs = [(f"{c:.15g}", f"{s:.15g}") for c, s in zip(np.cos(half), np.sin(half), strict=True)]
    if words is _IN_PYTHON:
        yield words.axes.format(pairs=", ".join(f"({c}, {s})" for c, s in pairs))
    else:
        yield words.axes.format(pairs=" ".join(f"{{{c} {s}}}" for c, s in pairs))
    rigid = _RIGID * max(float(np.abs(np.diff(row.f) / np.diff(row.q)).max()) for row in made.tables)
    settings = ("torsion", f"{made.torsion:.12g}"), ("masing", str(int(masing))), ("rigid", f"{rigid:.3e}")
    for name, value in settings:
        yield words.value.format(lower=name, upper=name.upper(), value=value)


def write(source: Source, target: Target, options: Options) -> Exported:
    """Write the springs in Python and in Tcl."""
    made = prepare(source, options, "OpenSees springs", _FRAME)
    masing, first = options["material"] == "masing", int(options["first"])
    if masing:
        label = [_MASING, *errors_on_reversals(made.springs, made.made, made.tables)]
        made = replace(made, head=[*made.head, *label], lost=[*made.lost, *label])
    files = []
    for ending, words, attach in (("py", _IN_PYTHON, _PYTHON), ("tcl", _IN_TCL, _TCL)):
        text = "\n".join(line for line in _data(made, words, masing) if line)
        files.append(target.write(f"caisson_opensees.{ending}", text + "\n" + attach.format(first=first)))
    return Exported(files, made.lost)
