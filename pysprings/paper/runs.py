# SPDX-License-Identifier: MIT
"""The paper's runs, each in a folder of its own: what has ended stays, what was interrupted goes on."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pysprings
from pysprings.errors import RunIncomplete, UserInputError
from pysprings.paper.cases import CASES, PATH, Case
from pysprings.progress import duration
from pysprings.result_files import CHECKPOINT, is_unfinished

if TYPE_CHECKING:
    import xarray as xr

    from pysprings.progress import Progress
    from pysprings.scene import Scene

RUNS = "runs"  # folder of the runs' folders
_COUPLED = 1.6  # cost of a run with water over that of a drained one
NEEDED = ("full_model.nc", "springs.nc", "run.json")


@dataclass(frozen=True)
class Run:
    """A run as it ended: its case, its folder, its path (converged steps), full model, record."""

    case: Case
    folder: Path
    result: xr.DataTree
    path: xr.Dataset
    record: Mapping[str, Any]

    @property
    def complete(self) -> bool:
        """Whether it reached its end."""
        return self.record.get("status") == "complete"

    @property
    def remark(self) -> str:
        """Words for a run that stopped early; empty for a complete one."""
        if self.complete:
            return ""
        return f"{self.case.name}: stopped at u = {1e3 * float(self.path['u'].values[-1]):.3g} mm"


@dataclass
class Whole:
    """Progress of all runs together, and the time left by what this session has needed so far."""

    weights: Mapping[str, float]
    report: Progress
    clock: Callable[[], float] = time.monotonic
    done: float = 0.0  # weight of what has ended
    _began: float = 0.0
    _worked: float = 0.0  # weight of what this session has run itself
    _skipped: dict[str, float] = field(default_factory=dict)  # where a resumed run started

    def __post_init__(self) -> None:
        self._began = self.clock()

    def of(self, name: str) -> Progress:
        """Return the progress function of one run."""

        def progress(path: str, fraction: float, message: str) -> None:
            if path != PATH:  # the model is being made
                self.report(name, 0.0, message)
                return
            start = self._skipped.setdefault(name, fraction if fraction > 0.3 else 0.0)
            self.report(name, fraction, message)
            self._tell(self.weights[name] * fraction, self.weights[name] * (fraction - start))

        return progress

    def ended(self, name: str, worked: bool) -> None:
        """Count a run that has ended, by this session or before it."""
        self.done += self.weights[name]
        if worked:
            self._worked += self.weights[name] * (1.0 - self._skipped.get(name, 0.0))
        self._tell(0.0, 0.0)

    def _tell(self, now: float, worked: float) -> None:
        total = sum(self.weights.values())
        whole = min((self.done + now) / total, 1.0)
        pace = self._worked + worked
        text = ""
        if pace > 0.02 * total and whole < 1.0:
            text = f"about {duration((self.clock() - self._began) / pace * (total - self.done - now))} left"
        self.report("all runs", whole, text)


def run_all(out: Path, mesh: str, report: Progress, cases: Sequence[Case] = CASES) -> list[str]:
    """Run every case below a folder that has not ended there; return what the runs that stopped early say.

    KeyboardInterrupt passes through: the same call goes on.
    """
    whole = Whole({case.name: 1.0 if case.drained else _COUPLED for case in cases}, report)
    stopped = []
    for case in cases:
        scene, folder = case.scene(mesh), out / RUNS / case.name
        worked = not has_ended(folder, scene)
        if worked:
            try:
                _run(scene, folder, whole.of(case.name))
            except RunIncomplete as error:
                stopped.append(f"{case.name}: {error}")
        whole.ended(case.name, worked)
    return stopped


def _run(scene: Scene, folder: Path, progress: Progress) -> None:
    from pysprings.folder import run_to_folder

    resume = is_unfinished(folder)
    try:
        run_to_folder(scene, folder, progress=progress, resume=resume)
    except UserInputError:
        if not resume:
            raise
        # the checkpoints belong to another scene, mesh or version, or are damaged
        run_to_folder(scene, folder, progress=progress)


def has_ended(folder: Path, scene: Scene) -> bool:
    """Tell whether a folder holds the ended run (complete, or stopped by itself) of this scene and version."""
    record = read_record(folder)
    return (
        record.get("status") in ("complete", "partial")
        and not record.get("stopped_by")
        and record.get("scene_sha256") == scene.sha256
        and record.get("version") == pysprings.__version__
        and all((folder / name).exists() for name in NEEDED)
        and not (folder / CHECKPOINT).exists()
    )


def forget(out: Path, cases: Sequence[Case] = CASES) -> None:
    """Have every run below a folder made again; results stay until there are others."""
    from pysprings.checkpoint import Checkpoints

    for case in cases:
        folder = out / RUNS / case.name
        (folder / "run.json").unlink(missing_ok=True)
        Checkpoints(folder).remove()


def read_record(folder: Path) -> dict[str, Any]:
    """Return run.json of a folder; empty where there is none or it is broken."""
    try:
        found = json.loads((folder / "run.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def load_runs(out: Path, mesh: str, cases: Sequence[Case] = CASES) -> dict[str, Run]:
    """Read the runs below a folder that belong to this mesh and version and have a converged step, by name."""
    from pysprings.springs import path_names
    from pysprings.storage import read_tree

    runs = {}
    for case in cases:
        folder, record = out / RUNS / case.name, read_record(out / RUNS / case.name)
        if record.get("scene_sha256") != case.scene(mesh).sha256 or not (folder / "full_model.nc").exists():
            continue
        result = read_tree(folder / "full_model.nc")
        if PATH in path_names(result) and int(result[f"paths/{PATH}"]["converged"].sum()) > 1:
            runs[case.name] = Run(case, folder, result, path_of(result), record)
    return runs


def path_of(result: xr.DataTree) -> xr.Dataset:
    """Return the path of a run (converged steps) with the nodes of the symmetry plane and the size of the caisson."""
    from pysprings.plots.data import section_data, settings
    from pysprings.springs import get_path

    path = get_path(result, PATH)
    plane = section_data(result)
    if plane is not None and "section_ux" in path:
        path = path.assign({name: plane[name] for name in ("section_x", "section_depth")})
    return path.assign_attrs({**settings(result), **path.attrs})
