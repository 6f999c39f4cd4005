# SPDX-License-Identifier: MIT
"""`pysprings compile`: the loops of a kind of scene compiled beforehand, which its first run does otherwise."""

from __future__ import annotations

import gc
import tempfile
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pysprings.cli.options import Changes, Json, argument
from pysprings.cli.scene import load
from pysprings.cli.support import print_json, to_stderr
from pysprings.core import jit
from pysprings.core.path_kinds import MEMORY
from pysprings.core.progress import Progress

if TYPE_CHECKING:
    from pysprings.core.workers import Task
    from pysprings.scene.model import Scene


def compile(  # the name of the command
    scene: Annotated[Path | None, argument("[SCENE]", "scene file (TOML) [default: all templates]")] = None,
    changes: Changes = None,
    as_json: Json = False,
) -> None:
    """Compile what runs of a scene, or of all templates, need.

    A small model of the scene is run and thrown away; the compiled loops are kept until the program changes.
    """
    from pysprings.scene.load import parse_scene
    from pysprings.scene.template import template_names, template_text

    templates = {name: parse_scene(template_text(name)) for name in template_names()} if scene is None else {}
    scenes = templates if scene is None else {str(scene): load(scene, None, changes)}
    seconds = {name: compiled(each, jobs=None) for name, each in scenes.items()}
    if as_json:
        print_json({"compiled_s": seconds})
    else:
        for name, value in seconds.items():
            print(f"{name}: {f'compiled in {value:.0f} s' if value else 'was compiled before'}")


def compiled(scene: Scene, quiet: bool = False, jobs: int | None = 1) -> float:
    """Compile the loops of a scene, and return the time [s].

    More ``jobs`` than one compile those of springs beside; None: as many as the machine has cores.
    """
    from pysprings.core.workers import Task, cores, run_tasks

    jobs = jobs or cores()
    found: list[float] = []

    def begun(*_: object) -> None:
        if not (quiet or found):
            to_stderr("note: compiling the loops of this kind of scene, once; it takes about half a minute")
        found.append(0.0)

    def done(_: Task, seconds: Any) -> None:
        if isinstance(seconds, float):  # an error: a run of the scene itself shows what is wrong
            found.append(seconds)

    mark = jit.mark_of(_kind(scene))
    tasks = [Task("model", _model, (scene,), 2.0, begun), Task("springs", _springs, (), 1.0, begun)]
    run_tasks(tasks, jobs, done)
    if mark is not None:
        mark.touch()
    return sum(found) if jobs == 1 else max(found, default=0.0)


def _model(scene: Scene, progress: Progress) -> float:
    """Run a small model of a scene, which compiles its loops; return the seconds of wall time that this took."""
    from pysprings.full_model.accuracy.two_mesh import few
    from pysprings.full_model.compute import run
    from pysprings.results.folder import Writing, run_to_folder
    from pysprings.studies.accuracy.runs import warm_up_scene

    with _watched(progress) as seconds, tempfile.TemporaryDirectory() as folder, suppress(Exception):
        small = warm_up_scene(scene, scene.mesh.discretisation)
        if any(path.role == MEMORY for path in small.all_paths):  # loops of the elements that are fitted to them, too
            run_to_folder(small, folder, estimate_error=False, writing=Writing(figures="none"))
        else:
            run(few(small), estimate_error=False)
    return seconds()


def _springs(progress: Progress) -> float:
    """Predict with the springs of an atlas, which compiles the loops of fans; return the seconds that this took."""
    from pysprings.macro.predict import curve
    from pysprings.studies.atlas.model import open_atlas, shipped

    with _watched(progress) as seconds:
        atlas = open_atlas(shipped()[0])
        curve(atlas.springs(atlas.scene()), u_max=1e-3, n=2)
    return seconds()


@contextmanager
def _watched(progress: Progress) -> Iterator[Callable[[], float]]:
    """Report that compilation begins; yield a function that returns the seconds that it has taken; no warnings."""
    gc.disable()  # of Numba's trees, which stay reachable: looking through them takes a twentieth of the time
    try:
        silence = warnings.catch_warnings(action="ignore")  # of a mesh that nobody uses
        with jit.compilation(lambda: progress("compiling", 0.0, "")) as seconds, silence:
            yield seconds
    finally:
        gc.enable()


def compile_first(scene: Scene, quiet: bool = False, jobs: int | None = 1) -> None:
    """Compile the loops of a scene whose kind has not run yet, before worker processes would each do so."""
    mark = jit.mark_of(_kind(scene))
    if mark is None or mark.exists():
        return
    seconds = compiled(scene, quiet, jobs)
    if seconds and not quiet:
        to_stderr(f"note: compiled in {seconds:.0f} s; later runs have the loops")


def _kind(scene: Scene) -> str:
    """Return what decides the loops that runs of a scene need."""
    paths = sorted({f"{path.kind} {bool(path.rate)}" for path in scene.all_paths})
    words = scene.mesh.discretisation, scene.caisson.behaviour, scene.drainage.mode, scene.solver.linear
    laws = sorted({stratum.law for stratum in scene.ground.strata})
    contact = scene.interface.opening, scene.interface.adhesion_factor is not None
    return repr((words, laws, paths, contact, scene.springs.memory))
