# SPDX-License-Identifier: MIT
"""OpenFAST: the foundation as one matrix (SubDyn, SoilDyn), and the nonlinear one of the SoilDyn library.

Formats as OpenFAST 5.0.0 reads them (commit 2895884).
"""

from pathlib import Path

from pysprings.core.errors import refused
from pysprings.core.variables import known_torsion
from pysprings.macro.model import MacroModel, spring_sets
from pysprings.macro.space import SpaceAnswers
from pysprings.macro.spring_sets import MEMORY
from pysprings.results.exporters.base import Exported, Options, Source, Target
from pysprings.results.exporters.header import BACKBONE, header, springs_at, torsion_words
from pysprings.results.exporters.soildyn.library import library_input, library_name, matrix_input, spring_text
from pysprings.results.exporters.subdyn import FRAME, FREE_BASE, UNITS, matrix_of, write_subdyn

_SPRING_FILE = "caisson.txt"
_NO_FAN = "no nonlinear foundation: it needs a fan of load paths (template 'fan'); the matrices are linear"
_BUILD = "build the library with: pysprings soildyn DIR; OpenFAST loads {library} from its working folder"
_LOST = {
    "fan": ("nonlinear elastic: no hysteresis, no memory of earlier loads",),
    "memory": ("no degradation by the number of cycles", "a vertical load that changes: the elements hold for one"),
}  # fmt: skip
_OTHER = "`springs=memory` has elements that remember earlier loads"
_READ = "SubDyn 5.0.0 writes NaN for base reactions with a library: read Sld1Fxg and the like"
_CYCLES = "elements that remember reversals, for tens of cycles"


def _nonlinear(source: Source, target: Target, options: Options) -> tuple[list[Path], list[str]]:
    """Write the spring file and the SoilDyn input for the library; return them, and what is lost."""
    at, load = springs_at(source, options)
    if not at.has_fan:
        return [], [_NO_FAN]
    kind = str(options["springs"])
    model = MacroModel.from_springs(at.whole or at, kind, V=load)
    elements, torsion = model.response.element_rows, known_torsion(model.attrs)
    lost = [*_LOST[kind], *[_OTHER] * (kind == "fan" and MEMORY.name in spring_sets(at)), *model.response.plane_notes()]
    lost += [SpaceAnswers.of(at).errors] if elements.in_space else []
    lost += [*([] if elements.twists else [torsion_words(torsion, at)]), _READ]
    use = _CYCLES if len(elements.rows) else BACKBONE
    head = [*header(source, "OpenFAST nonlinear foundation", FRAME, "m, rad, N, N m", use, at, kind), *lost, FREE_BASE]
    head += [f"fan of {len(at.rays)} rays; displacement 0: at rest under {1e-3 * model.rest_load:.6g} kN"]
    total, stop = options["reaction_at_rest"] == "load", options["beyond"] == "stop"
    text = spring_text(head, model, 0.0 if elements.twists else torsion or 0.0, total, stop)
    library = f"./{library_name()}"
    files = [
        target.write(_SPRING_FILE, text),
        target.write("soildyn_nonlinear.dat", library_input(head, library, f"./{_SPRING_FILE}", [_place(options)])),
    ]
    return files, [*lost, _BUILD.format(library=library)]


def _place(options: Options) -> tuple[float, float, float]:
    if (z := float(options["z"] or 0.0)) > 0.0:
        raise refused("--option z", f"{z:g} m is above still water, the mudline below it: such as -{z:g} m")
    return float(options["x"] or 0.0), float(options["y"] or 0.0), z


def write(source: Source, target: Target, options: Options) -> Exported:
    """Write matrices, and the spring file of the nonlinear foundation where there is a fan."""
    found, place = matrix_of(source, options), _place(options)
    head = [*header(source, f"OpenFAST foundation matrix: {found.name}", FRAME, UNITS), *found.lines]
    more, remarks = _nonlinear(source, target, options)  # the first: it may refuse the options
    files = [
        *write_subdyn(head, found.stiffness, target),
        target.write("soildyn.dat", matrix_input([*head, FREE_BASE], found.stiffness, place)),
    ]
    return Exported([*files, *more], [*found.lines, *remarks, FREE_BASE])
