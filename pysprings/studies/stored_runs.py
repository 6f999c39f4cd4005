# SPDX-License-Identifier: MIT
"""Runs of a study, each kept in a folder of its own: which have ended, and how far all of them are (light)."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pysprings.core import version
from pysprings.core.progress import Progress, duration
from pysprings.core.written import keep, own_folder
from pysprings.full_model.run_record import RunRecord, Status
from pysprings.scene.model import Scene
from pysprings.springs.checks import RESULT

RUNS = "runs"  # folder of the runs' folders
_TAKEN_UP = 0.3  # a run whose first news is beyond this share has not come so far in this call


@dataclass
class Whole:
    """Progress of all runs together, and the time left by what this call has needed so far.

    ``weights`` are the costs of the runs, in any unit; ``paths`` the names of the paths that each of them goes along.
    """

    weights: Mapping[str, float]
    report: Progress
    clock: Callable[[], float] = time.monotonic
    paths: Sequence[str] = ("pull",)
    _began: float = 0.0
    _done: dict[str, float] = field(default_factory=dict)  # share of each run
    _skipped: dict[str, float] = field(default_factory=dict)  # share of it that was there before

    def __post_init__(self) -> None:
        self._began = self.clock()

    def of(self, name: str, paths: Sequence[str] = ()) -> Progress:
        """Return the progress function of one run, which has ``paths`` of its own, or those of all."""
        own = list(paths or self.paths)

        def progress(path: str, fraction: float, message: str) -> None:
            if path not in own:  # the model is being made, or the coarser mesh runs
                self.report(name, self._done.get(name, 0.0), message)
                return
            fraction = (own.index(path) + fraction) / len(own)
            self._skipped.setdefault(name, fraction if fraction > _TAKEN_UP else 0.0)
            self._done[name] = fraction
            self.report(name, fraction, message)
            self._report()

        return progress

    def ended(self, name: str, worked: bool) -> None:
        """Count a run that has ended, by this call or before it."""
        self._done[name] = 1.0
        if not worked:
            self._skipped[name] = 1.0
        self._report()

    def _report(self) -> None:
        total = sum(self.weights.values())
        done = sum(self.weights[name] * share for name, share in self._done.items())
        worked = done - sum(self.weights[name] * share for name, share in self._skipped.items())
        text = ""
        if worked > 0.02 * total and done < total:
            text = f"about {duration((self.clock() - self._began) / worked * (total - done))} left"
        self.report("all runs", min(done / total, 1.0), text)


def run_folder(out: Path, name: str) -> Path:
    """Return the folder of a run of a study; UserInputError where the folder of all runs is a link.

    The folder of one run may be a link to where it has ended: it is read there. A run is neither made nor forgotten
    behind a link (`forget`, `pysprings.results.folder.run_or_go_on`).
    """
    return own_folder(out, RUNS) / name


def has_ended(folder: Path, scene: Scene) -> bool:
    """Return whether a folder holds the ended run (complete, or stopped by itself) of this scene and version.

    Springs belong to it unless its paths give none, as those out of one plane.
    """
    record = record_of(folder, scene)
    return (
        record is not None
        and record.status in (Status.COMPLETE, Status.PARTIAL)
        and record.stopped_by is None
        and (folder / "full_model.nc").exists()
        and (record.balance is None or (folder / "springs.nc").exists())
        and RunRecord.has_whole_results(folder)
    )


def why_stopped(record: RunRecord | None) -> str:
    """Return why an ended run did not reach its end; empty where it did."""
    if record is None:
        return "no run"
    return "" if record.reached else "; ".join(record.short)


def forget(folder: Path) -> None:
    """Mark the run of a folder to be repeated; its results stay until there are new ones."""
    from pysprings.full_model.checkpoint import Checkpoints

    own_folder(folder.parent, folder.name)
    keep(folder)
    (folder / "run.json").unlink(missing_ok=True)
    Checkpoints(folder).remove()


def record_of(folder: Path, scene: Scene) -> RunRecord | None:
    """Return the record of a folder if it belongs to this scene and version, else None."""
    record = RunRecord.read(folder)
    if record is None or (record.version, record.schema) != (version.__version__, RESULT) or not record.is_of(scene):
        return None
    return record
