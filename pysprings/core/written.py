# SPDX-License-Identifier: MIT
"""Result folders, light: files that a run has written (nothing else is removed), checkpoints, links, names, lock.

The list is in `run.json` (`files`) once everything is written. Until then it is a file of its own, a line each, so that
a run that was killed leaves it, too. One run at a time writes into a folder: the lock is the operating system's, on a
file in the folder; it dies with its process, however that ends. A second file names its holder, for the message of the
next run.
"""

import json
import os
import platform
import re
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path

from pysprings.core.errors import ResourceError, printable, refused

LIST = ".pysprings.files"
KEY = "files"  # of run.json
# a folder inside the result folder and a file in it: a forged list cannot lead elsewhere
_ENTRY = re.compile(r"[a-z][a-z0-9_-]*/[^/\\\x00]+")


def own_folder(folder: Path, name: str) -> Path:
    """Return the folder of a name inside a result folder, which need not exist.

    Raises UserInputError: a link is in its place, or a file: what is written or removed behind a link is outside the
    result folder.
    """
    place = folder / name
    if place.is_symlink() or (place.exists() and place.resolve().parent != folder.resolve()):
        message = (
            f"is a link to {os.path.realpath(place)}: nothing is written or removed behind it; "
            "remove the link, or have the whole result folder (--out) at the other place"
        )
        raise refused(None, message, place)
    if place.exists() and not place.is_dir():
        raise refused(None, "is a file; a run has a folder of this name", place)
    return place


def note(folder: Path, file: Path) -> None:
    """Add a file that has been written to the list of its result folder."""
    with (folder / LIST).open("a", encoding="utf-8", newline="\n") as stream:
        stream.write(file.relative_to(folder).as_posix() + "\n")


def noted(folder: Path) -> list[str]:
    """Return the entries of the list that is not yet in run.json, each once."""
    try:
        lines = (folder / LIST).read_text(encoding="utf-8").split("\n")
    except (OSError, ValueError):
        return []
    return sorted({line for line in lines if line})


def listed(folder: Path, folders: tuple[str, ...]) -> list[Path]:
    """Return the files in these folders that the runs of a result folder have written, by both lists."""
    names = {str(entry) for entry in [*_recorded(folder), *noted(folder)]}
    ours = sorted(entry for entry in names if _ENTRY.fullmatch(entry) and entry.split("/")[0] in folders)
    return [folder / entry for entry in ours if entry.split("/")[1] not in (".", "..")]


def keep(folder: Path) -> None:
    """Move the list of run.json to the file of its own, before the record is removed."""
    for path in [folder / str(entry) for entry in _recorded(folder)]:
        note(folder, path)


def _recorded(folder: Path) -> list[object]:
    names = _object(folder / "run.json").get(KEY)
    return names if isinstance(names, list) else []


def _object(file: Path) -> dict[str, object]:
    """Return the object of a JSON file; an empty one where there is none, or something else."""
    try:
        data = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return data if isinstance(data, dict) else {}


CHECKPOINT = "checkpoint"  # folder of the data from which an unfinished run continues
COMPANION = "coarser-"  # begins the names of checkpoints of the runs that estimate the error
_CHECKPOINT_FILE = re.compile(rf"({COMPANION}[a-z0-9]+-)?(start|path-\d{{3,}})\.npz")
WRITING = "writing"  # status in run.json until every file of the run is written


def is_unfinished(folder: Path) -> bool:
    """Return whether a folder holds the checkpoints of a run that was stopped: a run that ends removes them."""
    return bool(checkpoints_in(folder / CHECKPOINT))


def checkpoints_in(place: Path) -> list[Path]:
    """Return the checkpoint files in their folder; files with other names are left out."""
    return sorted(file for file in place.glob("*.npz") if _CHECKPOINT_FILE.fullmatch(file.name))


def refuse_links(folder: Path, names: Iterable[str] = (CHECKPOINT,)) -> None:
    """Raise UserInputError where a result folder has a link in the place of one of these folders."""
    for name in names:
        own_folder(folder, name)


_DEVICES = {"CON", "PRN", "AUX", "NUL", "CONIN$", "CONOUT$"}
_DEVICES |= {f"{kind}{number}" for kind in ("COM", "LPT") for number in "0123456789\u00b9\u00b2\u00b3"}


def is_device(name: str) -> bool:
    """Return True if Windows takes a file of this name, with any ending, for a device."""
    return name.split(".")[0].rstrip(" ").upper() in _DEVICES


LOCK, HOLDER = ".pysprings.lock", ".pysprings.lock.json"
_held: set[tuple[Path, int]] = set()  # folder and thread


@contextmanager
def new_folder(folder: Path) -> Iterator[None]:
    """Create a folder (and those above it) where it is not there; remove what is new again where it stays empty."""
    new = [each for each in (folder, *folder.parents) if not each.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    try:
        yield
    finally:
        with suppress(OSError):  # not empty: that is how it should be
            for each in new:
                each.rmdir()


@contextmanager
def exclusive(folder: Path, scene: str = "") -> Iterator[None]:
    """Hold the lock of an existing folder, for a scene (its SHA-256); the thread that holds it may take it again.

    Raises ResourceError: another run holds it, or the folder cannot be written to.
    """
    mine = folder.resolve(), threading.get_ident()
    if mine in _held:
        yield
        return
    from filelock import FileLock, Timeout

    lock = FileLock(folder / LOCK, timeout=0)
    try:
        lock.acquire()
    except Timeout:
        raise ResourceError(f"{folder}: {_holder(folder)}; wait for its end, or choose another folder") from None
    _held.add(mine)
    try:
        holder = {"pid": os.getpid(), "host": platform.node(), "since": datetime.now(UTC).isoformat(timespec="seconds"),
                  "scene": scene}  # fmt: skip
        (folder / HOLDER).unlink(missing_ok=True)  # a link of this name leads elsewhere
        (folder / HOLDER).write_text(json.dumps(holder), encoding="utf-8", newline="\n")
        yield
    finally:
        _held.discard(mine)
        with suppress(OSError):  # they may stay: the next run takes them over
            (folder / HOLDER).unlink(missing_ok=True)
            if os.name != "nt":  # removed while it is held: a process that has opened this file opens a new one
                (folder / LOCK).unlink(missing_ok=True)
        lock.release()
        if os.name == "nt":  # where an open file cannot be removed
            with suppress(OSError):
                (folder / LOCK).unlink(missing_ok=True)


def scene_of_holder(folder: Path) -> str:
    """Return the SHA-256 of the scene whose run holds a folder, or was killed while it did; blank for none."""
    return str(_object(folder / HOLDER).get("scene", ""))


def _holder(folder: Path) -> str:
    """Return a sentence on the process that writes into a folder."""
    holder = _object(folder / HOLDER)
    which = f" (process {holder['pid']} on {holder['host']})" if {"pid", "host"} <= holder.keys() else ""
    return printable(f"another run{which} writes into this folder")
