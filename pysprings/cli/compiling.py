# SPDX-License-Identifier: MIT
"""`pysprings compile`: the loops of a kind of scene compiled beforehand, which its first run does otherwise."""

from __future__ import annotations

import tempfile
import warnings
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from pysprings.cli.options import Changes, Json, argument
from pysprings.cli.scene import load
from pysprings.cli.support import print_json, to_stderr
from pysprings.core import jit

if TYPE_CHECKING:
    from pysprings.scene.model import Scene


def compile(  # the name of the command
    scene: Annotated[Path | None, argument("[SCENE]", "scene file (TOML) \\[default: all templates]")] = None,
    changes: Changes = None,
    as_json: Json = False,
) -> None:
    """Compile beforehand what runs need: of one scene, or of the kinds of scenes of all templates.

    A small model of the scene is run and thrown away; the compiled loops are kept until the program changes.
    """
    scenes = _templates() if scene is None else {str(scene): load(scene, None, changes)}
    seconds = {name: compiled(each) for name, each in scenes.items()}
    if as_json:
        print_json({"compiled_s": seconds})
    else:
        for name, value in seconds.items():
            print(f"{name}: {f'compiled in {value:.0f} s' if value else 'was compiled before'}")


def _templates() -> dict[str, Scene]:
    from pysprings.scene.load import parse_scene
    from pysprings.scene.template import template_names, template_text

    return {name: parse_scene(template_text(name)) for name in template_names()}


def compiled(scene: Scene, quiet: bool = False) -> float:
    """Run a small model of a scene, which compiles its loops; return the seconds of wall time that this took."""
    from pysprings.results.folder import Writing, run_to_folder
    from pysprings.studies.accuracy.runs import warm_up_scene

    def begun() -> None:
        if not quiet:
            to_stderr("note: compiling the loops of this kind of scene, once; it takes about half a minute")

    mark = jit.mark_of(_kind(scene))
    with tempfile.TemporaryDirectory() as folder, jit.compilation(begun) as seconds, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a mesh that nobody uses
        with suppress(Exception):  # a run of the scene itself says what is wrong
            small = warm_up_scene(scene, scene.mesh.discretisation)
            run_to_folder(small, folder, estimate_error=False, writing=Writing(figures="none"))
    if mark is not None:
        mark.touch()
    return seconds()


def compile_first(scene: Scene, quiet: bool = False) -> None:
    """Compile the loops of a scene whose kind has not run yet, before worker processes would each do so."""
    mark = jit.mark_of(_kind(scene))
    if mark is None or mark.exists():
        return
    seconds = compiled(scene, quiet)
    if seconds and not quiet:
        to_stderr(f"note: compiled in {seconds:.0f} s; later runs have the loops")


def _kind(scene: Scene) -> str:
    """Return what decides the loops that runs of a scene need."""
    paths = sorted({f"{path.kind} {bool(path.rate)}" for path in scene.all_paths})
    words = scene.mesh.discretisation, scene.caisson.behaviour, scene.drainage.mode, scene.solver.linear
    laws = sorted({stratum.law for stratum in scene.ground.strata})
    contact = scene.interface.opening, scene.interface.adhesion_factor is not None
    return repr((words, laws, paths, contact, scene.springs.memory))
