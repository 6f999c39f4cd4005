# SPDX-License-Identifier: MIT
"""The SoilDyn library: its C source, and the command that builds it with the compiler of the system.

The spring file of the library is the macro-model as text, a fan or springs with memory (`spring_file.c`). Beside it the
input files of SoilDyn, as OpenFAST 5.0.0 reads them (commit 2895884): one matrix, or points of a library.
"""

import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np

from pysprings.core.arrays import Array
from pysprings.core.errors import ResourceError, refused
from pysprings.core.text import commented, one_line
from pysprings.macro.fan import FanTable
from pysprings.macro.model import MacroModel
from pysprings.macro.vertical import Branch
from pysprings.results.exporters.base import rendered

Place = tuple[float, float, float]

MATRIX, LIBRARY = 1, 3  # CalcOption
# reactions of the soil (kN, kN m) and motions (m, deg), by point
_FORCES, _MOTIONS = ("Fx", "Fy", "Fz", "Mx", "My", "Mz"), ("TDx", "TDy", "TDz", "RDx", "RDy", "RDz")


def library_input(head: Sequence[str], library: str, springs: str, places: Sequence[Place]) -> str:
    """Return an input file with points on the springs of a library.

    library : Shared library, relative to the working folder of OpenFAST.
    springs : Spring file, relative to the input file; at most 45 letters with the folder of the input file.
    places : Points (x, y, z) [m].
    """
    points = [f'{x:.10g} {y:.10g} {z:.10g} "{springs}" "{springs}"' for x, y, z in places]
    return matrix_input(head, np.zeros((6, 6)), places[0], points, library)


def matrix_input(
    head: Sequence[str], stiffness: Array, place: Place, points: Sequence[str] = (), library: str = "unused"
) -> str:
    """Return an input file with one matrix (6, 6) at a place [m], or points of a library; the header ends it, too."""
    option = LIBRARY if points else MATRIX
    return rendered(
        "soildyn.dat.j2", title=one_line(head[0]), option=option, place=" ".join(f"{each:.10g}" for each in place),
        stiffness=[[f"{value:.15E}" for value in row] for row in stiffness], points=points, library=library,
        outputs=_outputs(max(1, len(points))), head=commented("!", head),
    )  # fmt: skip


def _outputs(points: int) -> list[str]:
    """Return the output channels of up to nine points, as many as SoilDyn has."""
    names = [[f"Sld{k + 1}{name}g" for name in each] for k in range(min(points, 9)) for each in (_FORCES, _MOTIONS)]
    return [f'"{", ".join(row)}"' for row in names]


VERSION = 7
PROPS, STATES = 20000, 1200  # numbers that SoilDyn keeps for a point, and of its state
_SCALARS, _RAY_HEAD, _COLUMNS, _BRANCH_HEAD, _BRANCH = 25, 3, 9, 2, 3  # of `springs.h`
_STATE_HEAD = 11
_BETWEEN = (
    "springs with memory between two vertical loads or rates have elements of both, and SoilDyn keeps a state for "
    "those of one: give the V or rate of one"
)


def spring_text(
    head: Sequence[str], model: MacroModel, torsion: float, reaction_at_rest: bool, stop_beyond: bool
) -> str:
    """Return the spring file of a model.

    head : Lines of the header.
    model : Macro-model on a fan, of springs with a vertical stiffness.
    torsion : Stiffness about the vertical axis [N m/rad], beside that of elements of torsion.
    reaction_at_rest : With it the reaction at rest is the vertical load at rest, else the change from there.
    stop_beyond : The library stops beyond the calibrated range instead of extrapolating with a warning.

    Raises UserInputError: no fan, no vertical stiffness, more numbers than SoilDyn keeps, or elements of several loads
    or rates.
    """
    table = model.table
    if not isinstance(table, FanTable):
        raise refused("springs", "the SoilDyn library needs a fan of load paths: see the template 'fan'")
    if model.stiffness_initial is None:
        raise refused("springs", "springs from a table have no vertical stiffness: SoilDyn needs springs.nc")
    _check_size(model, table)
    w, V = (table.r[table.name == name][0][:, 0] for name in ("w", "V"))  # by ray
    rest = (float(w[0]), float(V[0])) if model.vertical is None else model.vertical.rest
    lines = commented("!", head)
    lines += [
        f"pysprings_soildyn {VERSION}",
        _row("length_m", [table.length]),
        _row("torsion_Nm", [torsion]),
        _row("rest_w_m_V_N", rest),
        _row("offset_N", [0.0 if reaction_at_rest else rest[1]]),
        _row("vertical_stiffness_N_per_m", [float(model.stiffness_initial[1, 1])]),
        _row("settled_m", [model.settled]),
        _row("elastic_V_N", np.clip(model.elastic_loads, -1e300, 1e300)),
        f"stop_beyond_range {int(stop_beyond)}",
        f"rays {table.angle.size}",
        *_ray_lines(model, table),
        *_branch_lines(model, "down", 1.0),
        *_branch_lines(model, "up", -1.0),
        *_element_lines(model),
        "end",
    ]
    return "\n".join(lines) + "\n"


def _check_size(model: MacroModel, table: FanTable) -> None:
    branches = () if model.vertical is None else model.vertical.branches
    size = _SCALARS + sum(_RAY_HEAD + _COLUMNS * int(n) for n in table.count)
    size += sum(_BRANCH_HEAD + _BRANCH * branch.x.size for branch in branches)
    elements = model.response.element_rows
    size += elements.rows.size
    if size > PROPS:
        raise refused("springs", f"{size} numbers: SoilDyn keeps {PROPS} for a point; use fewer rays or steps")
    if elements.sets > 1:
        raise refused("springs", _BETWEEN)
    kept = _STATE_HEAD + elements.numbers
    if kept > STATES:
        raise refused("springs", f"{kept} numbers of {len(elements.rows)} elements: SoilDyn keeps {STATES} of a state")


def _ray_lines(model: MacroModel, table: FanTable) -> Iterator[str]:
    """Yield each ray: angle, knots, whether its path failed; then rho, H, M, w and V with their slopes by knot."""
    _, _, knots, loads, slopes, _ = table.solver_arrays
    down = [(table.r[table.name == name][0], table.slope[table.name == name][0]) for name in ("w", "V")]
    yield "! ray: angle of (u, rotation L) [rad], knots, 1 if its path stopped; rho, H, dH, M, dM, w, dw, V, dV"
    for k, path in enumerate(table.path):
        n = int(table.count[k])
        columns = [knots[2 * k], loads[2 * k], slopes[2 * k], loads[2 * k + 1], slopes[2 * k + 1]]
        columns += [each[k] for pair in down for each in pair]
        yield from commented("!", [f"path {path}"])
        yield _row("ray", [table.angle[k], n, float(model.ends[path].failed)])
        yield from (_row("", row) for row in np.stack(columns, axis=1)[:n])


def _branch_lines(model: MacroModel, word: str, sign: float) -> Iterator[str]:
    """Yield a vertical curve: knots, whether its path failed; then |w - w0|, V and its slope by knot."""
    branch: Branch | None = None if model.vertical is None else model.vertical.branch(sign)
    if branch is None:
        yield f"{word} 0 0"
        return
    yield _row(word, [branch.x.size, float(model.ends[branch.path].failed)])
    yield from (_row("", row) for row in np.stack([branch.x, branch.r[-1], branch.slope[-1]], axis=1))


def _element_lines(model: MacroModel) -> Iterator[str]:
    """Yield the elements with a memory: their number; what they have in common; a row for each."""
    elements = model.response.element_rows
    yield f"elements {len(elements.rows)}"
    if not len(elements.rows):
        return
    yield "! largest step [m]; radius [m] and largest twist [m] of elements of torsion, 0 without any;"
    yield "! way of the calibration [m], 0 where w and V are those of the fan; 1/s of the ways over their sizes;"
    yield "! w [m] and V [N] at rest"
    yield _row("memory", elements.head)
    yield "! kind (0 plastic, 1 gap, 2 reversible, 3 frictional), g11, g12, g22, b11, b12, b22 [N/m], d [m], a, h [m],"
    yield "! of a gap g11 [m]: by how much its walls press on the plate at rest,"
    yield "! of a frictional one g11, g12: direction of the friction, g22: its coefficient,"
    yield "! of both b11, b12: direction of the walls, b22: their stiffness [N/m],"
    yield "! then its direction (px, py, pz), without one it takes both planes,"
    yield "! then the factors of w and V [1, N/m]: two of the way, two of the stored part"
    yield from (_row("", row) for row in elements.rows)


def _row(word: str, values: Iterable[float]) -> str:
    return " ".join(filter(None, [word, *(f"{value:.17g}" for value in values)]))


_NAMES_OF_SOURCES = ("foundation.c", "springs.c", "memory.c", "spring_file.c")
SOURCES = tuple(Path(__file__).with_name(name) for name in _NAMES_OF_SOURCES)
COMPILERS = ("cc", "gcc", "clang")
_NAMES = {"linux": "libpysprings_soildyn.so", "darwin": "libpysprings_soildyn.dylib", "win32": "pysprings_soildyn.dll"}


def library_name(platform: str = sys.platform) -> str:
    """Return the file name of the library on a platform (`sys.platform`)."""
    return _NAMES.get(platform, _NAMES["linux"])


def compiler(given: str | None = None) -> list[str]:
    """Return the command of the C compiler: the given one, that of the variable CC, or the first that is installed.

    Raises ResourceError: there is none.
    """
    named = given or os.environ.get("CC")
    words = shlex.split(named) if named else [name for name in COMPILERS if shutil.which(name)][:1]
    if not words or shutil.which(words[0]) is None:
        looked = named or ", ".join(COMPILERS)
        raise ResourceError(f"no C compiler ({looked}): install one, or name it by --compiler or the variable CC")
    return words


def build_command(words: list[str], output: Path, platform: str = sys.platform) -> list[str]:
    """Return the command that compiles and links the library into a file.

    words : Compiler with options of the user's own; `cl` is that of Visual Studio, all others take options as gcc.
    """
    if Path(words[0]).stem.lower() == "cl":
        return [*words, "/nologo", "/O2", "/LD", *map(str, SOURCES), f"/Fe:{output}"]
    shared = ["-dynamiclib"] if platform == "darwin" else ["-shared", *(["-fPIC"] if platform != "win32" else [])]
    return [*words, "-std=c99", "-O2", "-fvisibility=hidden", *shared, *map(str, SOURCES), "-o", str(output), "-lm"]


def build(folder: Path, given: str | None = None) -> Path:
    """Build the library into a folder, which need not exist; return its path.

    Raises ResourceError: no compiler, or it fails; the message holds its last lines.
    """
    words = compiler(given)
    folder.mkdir(parents=True, exist_ok=True)
    output = folder.resolve() / library_name()
    command = build_command(words, output)
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        last = (done.stderr or done.stdout).strip().splitlines()[-5:]
        raise ResourceError(f"the C compiler failed ({' '.join(command)}): {' | '.join(last)}")
    return folder / output.name
