# SPDX-License-Identifier: MIT
"""The runs of a study, each in a folder and a process of its own: ended runs stay, interrupted ones are resumed.

The peak memory of a process is that of its run, and a lack of memory ends only it.
"""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pysprings.core.errors import ResourceError, RunIncomplete, UserInputError
from pysprings.core.progress import Progress
from pysprings.core.workers import Task, Workers
from pysprings.full_model.accuracy.presets import Setting
from pysprings.full_model.run_record import RunRecord
from pysprings.model.forecast.resources import size_of
from pysprings.model.forecast.run_time import seconds
from pysprings.scene.model import Scene
from pysprings.studies.stored_runs import Whole, has_ended, record_of, run_folder, why_stopped

WARM_UP = "warm-up"
_WARM_UP: dict[str, dict[str, Any]] = {
    "mesh": {"preset": "coarse", "refinement": 0.4, "azimuth": None},
    "solver": {"max_step_fraction": 0.5},
}
Run = Callable[[Scene, Path, Progress], None]
_SHORT = 0.1  # of the reach: soil yields and contact slides there


@dataclass(frozen=True)
class Ended:
    """How the run of a setting ended: its folder, its record, and ``why`` it did not reach its end, if so."""

    setting: Setting
    folder: Path
    record: RunRecord | None
    why: str = ""

    @property
    def complete(self) -> bool:
        """Whether the run reached its end."""
        return not self.why and self.record is not None and self.record.reached


def study_scene(scene: Scene) -> Scene:
    """Return the scene as the study runs it: contact stresses kept, nothing drawn, no section, no ParaView files."""
    output = {"interface_fields": True, "section": False, "figures": False, "paraview": False}
    return scene.replace(output=output)


def run_all(scene: Scene, settings: Sequence[Setting], out: Path, report: Progress, run: Run) -> list[Ended]:
    """Run every setting that has not ended below a folder; a run that stops early, or does not fit, is a row, too.

    KeyboardInterrupt passes through: the same call goes on.
    """
    scenes = {each.name: each.scene(study_scene(scene)) for each in settings}
    weights = {name: seconds(each, size_of(each).unknowns) for name, each in scenes.items()}
    missing = {name for name, each in scenes.items() if not has_ended(run_folder(out, name), each)}
    for kind in dict.fromkeys(each.discretisation for each in settings if each.name in missing):
        name, small = f"{WARM_UP}-{kind}", warm_up_scene(study_scene(scene), kind)
        if not has_ended(run_folder(out, name), small):
            report(name, 0.0, "compiled code")
            _run(small, run_folder(out, name), lambda *_: None, run)
            report(name, 1.0, "")
    whole = Whole(weights, report, paths=tuple(path.name for path in scene.load_paths))
    finished = []
    for setting in settings:
        folder, why = run_folder(out, setting.name), ""
        if setting.name in missing:
            why = _run(scenes[setting.name], folder, whole.of(setting.name), run)
        whole.ended(setting.name, setting.name in missing)
        record = record_of(folder, scenes[setting.name])
        stopped = why_stopped(record)
        finished.append(Ended(setting, folder, record, why or (f"{_NOT_CONVERGED}{stopped}" if stopped else "")))
    return finished


def _run(scene: Scene, folder: Path, progress: Progress, run: Run) -> str:
    """Run one; return why it stopped early, or could not be run."""
    try:
        with warnings.catch_warnings(action="ignore"):  # a run's own warnings are in its record
            run(scene, folder, progress)
    except RunIncomplete as error:
        return f"{_NOT_CONVERGED}{error}"
    except ResourceError as error:
        return f"resources: {error}"
    except UserInputError as error:  # for example a mesh so coarse that its cells cannot be graded
        return "\n".join(error.lines)
    return ""


_NOT_CONVERGED = "not converged: "


def warm_up_scene(scene: Scene, kind: str) -> Scene:
    """Return a scene on a small mesh of a discretisation, its fan short, its steps large: it needs the same code.

    Compiled code stays on disk, so that no run of the table pays for it.
    """
    mesh = _WARM_UP["mesh"] | {"discretisation": kind, "harmonics": None}
    reach = None if scene.springs.reach is None else _SHORT * scene.springs.reach
    return scene.replace(**_WARM_UP | {"mesh": mesh, "springs": {"reach": reach}})


def run_here(scene: Scene, folder: Path, progress: Progress) -> None:
    """Run a scene into a folder, or go on there, and time its unit; raises as `run_to_folder` does."""
    from pysprings.results.folder import run_or_go_on

    run_or_go_on(scene, folder, progress, time_unit=True)


def run_in_child(scene: Scene, folder: Path, progress: Progress) -> None:
    """Run a scene in a new process. KeyboardInterrupt passes through after the process has saved converged steps."""
    answers: list[Exception | None] = []
    with Workers(1, threads=None) as workers:
        task = Task("the run", run_here, (scene, folder))
        workers.run([task], lambda _, answer: answers.append(answer), progress, lambda _: None)
    if answers[0] is not None:
        raise answers[0]
