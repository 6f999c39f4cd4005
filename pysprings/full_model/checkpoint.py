# SPDX-License-Identifier: MIT
"""Checkpoints of a run: the data that a stopped run needs to go on, in checksummed files.

A folder holds a file for what all paths share and one a path, which is written when the path ends, and after EVERY
seconds on its way: what has been computed since is computed again. The runs on a coarser mesh (`accuracy.own_estimate`)
have files of the same kinds, with a prefix. Of a path they hold what it has gathered, and where it stands between two
increments. Each file replaces the one before it at once; it is a line of JSON (format,
SHA-256 of the rest) and NumPy's npz archive without pickled objects, and holds which run it belongs to.
"""

import hashlib
import io
import json
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, Self

import numpy as np

from fe_engine.errors import NotConverged
from fe_engine.linear.preconditioner import Origin
from fe_engine.solve.step_size import StepSize
from fe_engine.solve.stepping import Position
from pysprings.core.errors import ResourceError, refused
from pysprings.core.process import uninterrupted
from pysprings.core.storage import leftovers, replacing
from pysprings.core.words import StopReason
from pysprings.core.written import CHECKPOINT, COMPANION, checkpoints_in, own_folder
from pysprings.full_model.cavitation import Margin
from pysprings.full_model.run_record import Ending, Status

FORMAT = "pysprings-checkpoint-3"
EVERY = 60.0  # s between two checkpoints of a path on its way
_START, _PATH = "start.npz", "path-{:03d}.npz"
_META = "meta"


@dataclass(frozen=True)
class Saved:
    """Content of one checkpoint file: plain data, and arrays by name."""

    meta: dict[str, Any]
    arrays: dict[str, np.ndarray]


@dataclass(frozen=True)
class Cost:
    """What a part of a run has cost: a path, what comes before the first one, or all of it so far.

    wall, cpu : seconds by phase; ``cpu_s`` are CPU seconds of everything, phases or not.
    factorisations, solves : of the linear solver; ``worst`` is its largest residual until then.
    checkpoints, spent : number of checkpoints of paths, and their wall seconds.
    condition : estimate of the condition of the last matrix of a run.
    """

    wall: dict[str, float]
    cpu: dict[str, float]
    cpu_s: float
    factorisations: int
    solves: int
    worst: float
    checkpoints: int
    spent: float
    condition: float | None

    @property
    def of_solver(self) -> Self:
        """The counts of the linear solver, without time."""
        return replace(self, wall={}, cpu={}, cpu_s=0.0, checkpoints=0, spent=0.0)

    def since(self, before: Self) -> Self:
        """Return the part that came after ``before``."""
        sums = ("cpu_s", "factorisations", "solves", "checkpoints", "spent")
        changes: dict[str, Any] = {name: getattr(self, name) - getattr(before, name) for name in sums}
        for name in ("wall", "cpu"):
            old = getattr(before, name)
            changes[name] = {phase: value - old.get(phase, 0.0) for phase, value in getattr(self, name).items()}
        return replace(self, **changes)


class Damaged(Exception):
    """A checkpoint file that is not what was written."""


@dataclass
class Loaded:
    """Content of a folder of checkpoints: shared data, paths by name, whole or on their way, damaged files.

    environments : in which the files were written.
    resumed : earlier continuations (`Checkpoints.resumed`); ``elapsed`` the wall seconds of the run until then.
    """

    shared: Saved | None = None
    paths: dict[str, Saved] = field(default_factory=dict)
    damaged: list[str] = field(default_factory=list)
    environments: list[dict[str, str]] = field(default_factory=list)
    resumed: list[dict[str, str]] = field(default_factory=list)
    elapsed: float = 0.0

    @property
    def any(self) -> bool:
        """Whether there was anything to read."""
        return self.shared is not None or bool(self.paths)

    @property
    def place(self) -> str:
        """Words for the place from which the run goes on."""
        on_their_way = [saved.meta for saved in self.paths.values() if "stage" in saved.meta]
        if not self.paths:
            return "the initial state"
        if not on_their_way:
            return f"the end of path '{list(self.paths)[-1]}'"
        steps = [(meta["path"], meta["n_rows"] - 1) for meta in on_their_way]
        return "; ".join(f"path '{name}', {f'step {step}' if step >= 0 else 'its dead load'}" for name, step in steps)


@dataclass
class Checkpoints:
    """The checkpoints of one run in ``folder / "checkpoint"``.

    prefix : of the names of the files; empty for those of the run itself.
    identity : what has to be the same for a run to go on, by name: scene, mesh, version, engine, linear solver.
    environment : what the run is computed with (`full_model.work`); another one is noted, not refused.
    resumed : time and place of each continuation.
    written, spent : number of checkpoints of paths, and the wall seconds that they have cost.
    began : when the run began, on the monotonic clock that all processes share; earlier when parts of it came before.
    """

    folder: Path
    prefix: str = ""
    identity: dict[str, str] = field(default_factory=dict)
    environment: dict[str, str] = field(default_factory=dict)
    resumed: list[dict[str, str]] = field(default_factory=list)
    written: int = 0
    spent: float = 0.0
    began: float = field(default_factory=time.monotonic)

    @property
    def place(self) -> Path:
        """The folder of the files; UserInputError where a link is in its place."""
        return own_folder(self.folder, CHECKPOINT)

    def companion(self, name: str) -> Self:
        """Return the checkpoints of a run beside this one."""
        return type(self)(self.folder, f"{COMPANION}{name}-")

    @property
    def elapsed(self) -> float:
        """Wall seconds of the run, its earlier parts included."""
        return time.monotonic() - self.began

    def begin(self, shared: Saved, anew: bool = True) -> None:
        """Write what the paths of a run share; throw away the checkpoints of an earlier run where it begins anew."""
        for file in self._files() if anew else []:
            file.unlink(missing_ok=True)
        self._write(_START, shared)

    def save_path(self, number: int, saved: Saved) -> None:
        """Write a path that has ended, or where it stands on its way, in the place of what there is of it."""
        self.written += 1
        self._write(_PATH.format(number), saved)

    def path(self, number: int) -> Saved | None:
        """Return what there is of a path; None where there is nothing, or nothing whole."""
        try:
            return read(self.place / (self.prefix + _PATH.format(number)))
        except (OSError, Damaged):
            return None

    @contextmanager
    def charged(self) -> Iterator[None]:
        """Count a block as cost of checkpoints."""
        began = time.perf_counter()
        try:
            yield
        finally:
            self.spent += time.perf_counter() - began

    def _write(self, name: str, saved: Saved) -> None:
        file = self.place / (self.prefix + name)
        about = {
            "identity": self.identity, "environment": self.environment, "resumed": self.resumed, "elapsed": self.elapsed
        }  # fmt: skip
        try:
            with self.charged():
                write(file, Saved(about | saved.meta, saved.arrays))
        except OSError as error:
            raise ResourceError(
                f"{file}: the checkpoint cannot be written ({error.strerror or error}); the run stops here, what had "
                "been saved stays: make room, and go on with --resume"
            ) from error

    def load(self) -> Loaded:
        """Read what is there; UserInputError where there is nothing, or where it belongs to another run."""
        loaded = Loaded()
        if not self.place.is_dir():
            raise refused(None, "nothing to resume: no interrupted run in this folder", self.folder)
        for file in self._files():
            saved = self._read(file, loaded)
            if saved is not None and file.name == self.prefix + _START:
                loaded.shared = saved
            elif saved is not None:
                loaded.paths[saved.meta["path"]] = saved
        if not loaded.any:
            what = f"every checkpoint is damaged ({'; '.join(loaded.damaged)})" if loaded.damaged else "no checkpoint"
            raise refused(None, f"nothing to resume: {what}; --force begins anew", self.folder)
        self.resumed, self.began = loaded.resumed, self.began - loaded.elapsed
        return loaded

    def _files(self) -> list[Path]:
        """Return the files of this run that are there."""
        own = self.prefix or (_START[:5], _PATH[:5])
        return [file for file in checkpoints_in(self.place) if file.name.startswith(own)]

    def _read(self, file: Path, loaded: Loaded) -> Saved | None:
        """Read a file; None where it is damaged, which is noted."""
        try:
            saved = read(file)
        except Damaged as error:
            loaded.damaged.append(f"{file.name}: {error}")
            return None
        self._refuse_another_run(saved.meta["identity"])
        loaded.environments.append(saved.meta["environment"])
        loaded.resumed = max(loaded.resumed, saved.meta["resumed"], key=len)
        loaded.elapsed = max(loaded.elapsed, saved.meta["elapsed"])
        return saved

    def _refuse_another_run(self, other: Mapping[str, str]) -> None:
        for name, value in self.identity.items():
            if other.get(name) != value:
                what = f"its {name} was {other.get(name, 'unknown')} and is {value}"
                message = f"--resume: another run was interrupted here: {what}; --force begins anew"
                raise refused(None, message, self.folder)

    def remove(self) -> None:
        """Remove all checkpoints, by their names; the folder stays where it holds something else."""
        place = self.place
        if place.is_dir():
            for file in [*checkpoints_in(place), *leftovers(place)]:
                file.unlink(missing_ok=True)
            if not any(place.iterdir()):
                place.rmdir()

    @property
    def harmonics(self) -> int | None:
        """Number of harmonics of the run that was interrupted here; None of bricks, and where nothing can be read."""
        number = self._about().get("harmonics")
        return None if number is None else int(number)

    def are_of(self, scene_sha256: str) -> bool:
        """Return whether the checkpoints can be read and belong to a run of this scene."""
        return bool(self._about().get("identity", {}).get("scene") == scene_identity(scene_sha256))

    def _about(self) -> dict[str, Any]:
        """Return what is known of the run that was interrupted here; nothing where it cannot be read."""
        try:
            return read(self.place / _START).meta
        except (OSError, Damaged, LookupError, TypeError):
            return {}


def scene_identity(sha256: str) -> str:
    """Return how checkpoints name a scene."""
    return f"sha256 {sha256}"


@uninterrupted()  # one within a ZIP archive may end in a ValueError of its close
def write(file: Path, saved: Saved) -> None:
    """Write a checkpoint file; atomic, on the disk when this returns. An interrupt waits for it."""
    packed = io.BytesIO()
    meta = json.dumps(saved.meta, default=lambda value: value.tolist()).encode("utf-8")
    arrays: dict[str, Any] = {_META: np.frombuffer(meta, dtype=np.uint8), **saved.arrays}
    np.savez(packed, **arrays)
    with packed.getbuffer() as content, replacing(file) as temporary, temporary.open("wb") as stream:
        head = {"format": FORMAT, "sha256": hashlib.sha256(content).hexdigest()}
        stream.write(json.dumps(head).encode("utf-8") + b"\n")
        stream.write(content)


def read(file: Path) -> Saved:
    """Read a checkpoint file; Damaged where it is not what was written."""
    with file.open("rb") as stream:
        line, content = stream.readline(1000), stream.read()
    try:
        head = json.loads(line)
        known = head["format"] == FORMAT
        whole = head["sha256"] == hashlib.sha256(content).hexdigest()
    except (ValueError, LookupError, TypeError):
        known = whole = False
    if not whole:
        raise Damaged("its checksum is wrong")
    if not known:
        raise Damaged(f"not of the format {FORMAT}")
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
    except ValueError as error:
        raise Damaged(str(error)) from error
    return Saved(json.loads(arrays.pop(_META).tobytes()), arrays)


Row = dict[str, Any]
Attempt = tuple[str, float, NotConverged]  # stage, fraction of it that was aimed at, error

_FIELD, _ROW, _LAST, _FACTORS = "field/", "row/", "last/", "factors/"  # names of arrays in a file


@dataclass(frozen=True)
class Gathered:
    """Rows, iterations and balances of a path, whole or as far as it went.

    rows : one a step, with the same names.
    record : one entry per iteration; ``given_up`` the failed attempts; ``limits`` what limited each step.
    cavitation : margin of the first step whose water would cavitate.
    energy : totals of the energy balance.
    cost : of the path until then.
    """

    path: str
    ending: Ending
    rows: list[Row]
    record: list[Row]
    given_up: list[Attempt]
    limits: list[str]
    cavitation: Margin | None
    energy: Any
    n_steps: int
    cost: Cost

    def saved(self) -> Saved:
        """Return the content of a checkpoint file."""
        meta = {
            "path": self.path,
            "ending": asdict(self.ending),
            "n_rows": len(self.rows),
            "record": self.record,
            "given_up": [(stage, fraction, _plain(error)) for stage, fraction, error in self.given_up],
            "limits": self.limits,
            "cavitation": None if self.cavitation is None else asdict(self.cavitation),
            "energy": self.energy,
            "n_steps": self.n_steps,
            "cost": asdict(self.cost),
        }
        names = self.rows[0] if self.rows else {}
        return Saved(meta, {_ROW + name: np.array([row[name] for row in self.rows]) for name in names})

    @classmethod
    def of(cls, saved: Saved) -> Self:
        """Return what a checkpoint file holds."""
        meta, columns = saved.meta, _part(saved, _ROW)
        ending = meta["ending"]
        reason = None if ending["reason"] is None else StopReason(ending["reason"])
        return cls(
            path=meta["path"],
            ending=Ending(Status(ending["status"]), reason, ending["why"], ending["failure"]),
            rows=[{name: values[k] for name, values in columns.items()} for k in range(meta["n_rows"])],
            record=meta["record"],
            given_up=[(stage, fraction, NotConverged(**error)) for stage, fraction, error in meta["given_up"]],
            limits=meta["limits"],
            cavitation=None if meta["cavitation"] is None else _margin(meta["cavitation"]),
            energy=meta["energy"],
            n_steps=meta["n_steps"],
            cost=Cost(**meta["cost"]),
        )


@dataclass(frozen=True)
class Standing:
    """State of a path after a step, from which it goes on: copies of its changing fields.

    stage, time : number of the stage, and time [s] since the start of the path.
    fields : committed state.
    position : where the driver goes on in the stage; ``force`` and ``stiffness`` are the driver's.
    factors : what the factors of the linear solver were made from; None where nothing is kept.
    water : totals of the water balance; None when drained.
    """

    stage: int
    time: float
    fields: Mapping[str, np.ndarray]
    position: Position
    force: np.ndarray | None
    stiffness: float | None
    factors: Origin | None
    water: Any

    def saved(self, gathered: Gathered) -> Saved:
        """Return the content of a checkpoint file, together with what the path has gathered until then."""
        at, whole = self.position, gathered.saved()
        meta = whole.meta | {
            "stage": self.stage, "time": self.time, "stiffness": self.stiffness, "water": self.water,
            "force": self.force, "start": at.start, "done": at.done, "next": asdict(at.next),
            "last_size": None if at.last is None else at.last[0],
        }  # fmt: skip
        arrays = whole.arrays | {_FIELD + name: values for name, values in self.fields.items()}
        if at.last is not None:
            arrays |= {_LAST + "free": at.last[1], _LAST + "border": at.last[2]}
        if self.factors is not None:
            arrays |= {_FACTORS + name: values for name, values in vars(self.factors).items()}
        return Saved(meta, arrays)

    @classmethod
    def of(cls, saved: Saved) -> Self | None:
        """Return what a checkpoint file holds; None for that of a path that has ended."""
        meta = saved.meta
        if "stage" not in meta:
            return None
        position = Position(np.array(meta["start"]), meta["done"], StepSize(**meta["next"]))
        if meta["last_size"] is not None:
            last = _part(saved, _LAST)
            position = replace(position, last=(meta["last_size"], last["free"], last["border"]))
        factors = _part(saved, _FACTORS)
        return cls(
            stage=meta["stage"],
            time=meta["time"],
            fields=_part(saved, _FIELD),
            position=position,
            force=None if meta["force"] is None else np.array(meta["force"]),
            stiffness=meta["stiffness"],
            factors=Origin(**factors) if factors else None,
            water=None if meta["water"] is None else tuple(meta["water"]),
        )


def _part(saved: Saved, prefix: str) -> dict[str, np.ndarray]:
    """Return the arrays of a file whose names have a prefix, without it."""
    return {name.removeprefix(prefix): values for name, values in saved.arrays.items() if name.startswith(prefix)}


def _margin(margin: Mapping[str, Any]) -> Margin:
    x, y, z = margin["place"]
    return Margin(margin["margin"], margin["pressure"], (x, y, z))


def _plain(error: NotConverged) -> dict[str, Any]:
    return {"reason": error.reason, "place": error.place, "history": error.history}
