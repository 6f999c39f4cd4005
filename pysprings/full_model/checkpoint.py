# SPDX-License-Identifier: MIT
"""Checkpoints of a run: the data that a stopped run needs to go on, in checksummed files.

A folder holds a file for what all paths share, one for each path that has ended, and two for the path on its way, which
are written in turn: a checkpoint never replaces the one before it. Each file is a line of JSON (format, SHA-256 of the
rest) and NumPy's npz archive without pickled objects. Each holds which run it belongs to.

Checkpoints of the path on its way may cost SHARE of the time that the run has taken: where a step takes longer than
1/SHARE checkpoints there is one at every step, elsewhere as often as that allows. What has been computed since is
computed again.
"""

from __future__ import annotations

import hashlib
import io
import json
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from pysprings.core.errors import ResourceError, refused
from pysprings.core.files.storage import leftovers, replacing
from pysprings.core.files.written import CHECKPOINT, checkpoints_in, own_folder

FORMAT = "pysprings-checkpoint-2"
SHARE = 0.02  # of the wall time of a run
_GENERATIONS = ("state-a.npz", "state-b.npz")
_START, _PATH = "start.npz", "path-{:03d}.npz"
_META = "meta"


@dataclass(frozen=True)
class Saved:
    """Content of one checkpoint file: plain data, and arrays by name."""

    meta: dict[str, Any]
    arrays: dict[str, np.ndarray]


class Damaged(Exception):
    """A checkpoint file that is not what was written."""


@dataclass
class Loaded:
    """Content of a folder of checkpoints: shared data, ended paths by name, the path on its way, damaged files."""

    shared: Saved | None = None
    paths: dict[str, Saved] = field(default_factory=dict)
    state: Saved | None = None
    damaged: list[str] = field(default_factory=list)
    environments: list[dict[str, str]] = field(default_factory=list)  # in which the files were written

    @property
    def newest(self) -> Saved | None:
        """The checkpoint that was written last."""
        saved_states = [*self.paths.values(), *([] if self.state is None else [self.state])]
        return max(saved_states, key=lambda saved: saved.meta["cost"]["wall_s"], default=None)

    @property
    def place(self) -> str:
        """Words for the place from which the run goes on."""
        newest = self.newest
        if newest is None:
            return "the initial state"
        name, step = newest.meta["path"], newest.meta["n_rows"] - 1
        if name in self.paths:
            return f"the end of path '{name}'"
        return f"path '{name}', {f'step {step}' if step >= 0 else 'its dead load'}"


@dataclass
class Checkpoints:
    """The checkpoints of one run in ``folder / "checkpoint"``.

    Attributes
    ----------
    identity : what has to be the same for a run to go on, by name: scene, mesh, version, engine, linear solver.
    environment : what the run is computed with (`full_model.environment`); another one is noted, not refused.
    spent : wall seconds that checkpoints have cost; ``written`` how many of the path on its way there were.
    """

    folder: Path
    identity: dict[str, str] = field(default_factory=dict)
    environment: dict[str, str] = field(default_factory=dict)
    spent: float = 0.0
    written: int = 0
    _last_cost: float = 0.0
    _sequence: int = 0
    _since: tuple[float, float] = field(default_factory=lambda: (time.perf_counter(), time.process_time()))

    @property
    def place(self) -> Path:
        """The folder of the files; UserInputError where a link is in its place."""
        return own_folder(self.folder, CHECKPOINT)

    def begin(self, shared: Saved, anew: bool = True) -> None:
        """Write what the paths of a run share; throw away the checkpoints of an earlier run where it begins anew."""
        if anew:
            self.remove()
        self._write(_START, shared)

    def is_due(self) -> bool:
        """Return whether one more checkpoint of the path on its way keeps their cost within its share."""
        return self.spent + self._last_cost <= SHARE * self.elapsed()["wall_s"]

    def elapsed(self) -> dict[str, float]:
        """Return the wall and CPU seconds of the run, its earlier parts included."""
        return {"wall_s": time.perf_counter() - self._since[0], "cpu_s": time.process_time() - self._since[1]}

    def go_on_from(self, wall: float, cpu: float, written: int, spent: float) -> None:
        """Count on from earlier parts of the run: their wall and CPU seconds, checkpoints, and what these cost."""
        self._since = self._since[0] - wall, self._since[1] - cpu
        self.written += written
        self.spent += spent

    @contextmanager
    def charged(self) -> Iterator[None]:
        """Count a block as cost of checkpoints."""
        began = time.perf_counter()
        try:
            yield
        finally:
            self.spent += time.perf_counter() - began

    def save_state(self, saved: Saved) -> None:
        """Write where the path on its way stands, over the older of the two generations."""
        self._sequence += 1
        name = _GENERATIONS[self._sequence % 2]
        before = self.spent
        self._write(name, Saved(saved.meta | {"sequence": self._sequence}, saved.arrays))
        self._last_cost = self.spent - before
        self.written += 1

    def save_path(self, number: int, saved: Saved) -> None:
        """Write a path that has ended."""
        self._write(_PATH.format(number), saved)

    def _write(self, name: str, saved: Saved) -> None:
        file = self.place / name
        try:
            with self.charged():
                about = {"identity": self.identity, "environment": self.environment}
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
        loaded.shared = self._read(_START, loaded)
        for file in [file for file in checkpoints_in(self.place) if file.name.startswith("path-")]:
            if (saved := self._read(file.name, loaded)) is not None:
                loaded.paths[saved.meta["path"]] = saved
        states = [saved for name in _GENERATIONS if (saved := self._read(name, loaded)) is not None]
        loaded.state = max(states, key=lambda saved: saved.meta["sequence"], default=None)
        self._sequence = 0 if loaded.state is None else loaded.state.meta["sequence"]
        if loaded.shared is None and not loaded.paths and loaded.state is None:
            what = f"every checkpoint is damaged ({'; '.join(loaded.damaged)})" if loaded.damaged else "no checkpoint"
            raise refused(None, f"nothing to resume: {what}; --force begins anew", self.folder)
        return loaded

    def _read(self, name: str, loaded: Loaded) -> Saved | None:
        """Read a file; None where it is not there or damaged, which is noted."""
        file = self.place / name
        if not file.exists():
            return None
        try:
            saved = read(file)
        except Damaged as error:
            loaded.damaged.append(f"{name}: {error}")
            return None
        self._refuse_another_run(saved.meta["identity"])
        loaded.environments.append(saved.meta["environment"])
        return saved

    def _refuse_another_run(self, other: Mapping[str, str]) -> None:
        for name, value in self.identity.items():
            if other.get(name) != value:
                what = f"its {name} was {other.get(name, 'unknown')} and is {value}"
                message = f"--resume: another run was interrupted here: {what}; --force begins anew"
                raise refused(None, message, self.folder)

    def remove(self) -> None:
        """Remove the checkpoints, by their names; the folder stays where it holds something else."""
        place = self.place
        if place.is_dir():
            for file in [*checkpoints_in(place), *leftovers(place)]:
                file.unlink(missing_ok=True)
            if not any(place.iterdir()):
                place.rmdir()

    @property
    def harmonics(self) -> int | None:
        """Number of harmonics of the run that was interrupted here; None of bricks, and where nothing can be read."""
        try:
            number = read(self.place / _START).meta["harmonics"]
        except (OSError, Damaged, LookupError, TypeError):
            return None
        return None if number is None else int(number)

    def are_of(self, scene_sha256: str) -> bool:
        """Return whether the checkpoints can be read and belong to a run of this scene."""
        try:
            digests = read(self.place / _START).meta["identity"]["scene"]
        except (OSError, Damaged, LookupError, TypeError):
            return False
        return bool(digests == scene_identity(scene_sha256))


def scene_identity(sha256: str) -> str:
    """Return how checkpoints name a scene."""
    return f"sha256 {sha256}"


def write(file: Path, saved: Saved) -> None:
    """Write a checkpoint file; atomic, on the disk when this returns."""
    packed = io.BytesIO()
    meta = json.dumps(saved.meta, default=lambda value: value.tolist()).encode("utf-8")
    arrays: dict[str, Any] = {_META: np.frombuffer(meta, dtype=np.uint8), **saved.arrays}
    np.savez(packed, **arrays)
    content = packed.getbuffer()
    head = {"format": FORMAT, "sha256": hashlib.sha256(content).hexdigest()}
    with replacing(file) as temporary, temporary.open("wb") as stream:
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
