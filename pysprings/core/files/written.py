# SPDX-License-Identifier: MIT
"""Which files a run has written into the folders inside its result folder: nothing else is removed there (light).

The list is in `run.json` (`files`) once everything is written. Until then it is a file of its own, a line each, so that
a run that was killed leaves it, too.
"""

from __future__ import annotations

import json
import os
import re
from pathlib import Path

from pysprings.core.errors import refused

LIST = ".pysprings.files"
KEY = "files"  # of run.json
# a folder inside the result folder and a file in it: a forged list cannot lead elsewhere
_ENTRY = re.compile(r"[a-z][a-z0-9_-]*/[^/\\\x00]+")


def own_folder(folder: Path, name: str) -> Path:
    """Return the folder of a name inside a result folder, which need not exist.

    Raises
    ------
    UserInputError
        A link is in its place, or a file: what is written or removed behind a link is outside the result folder.
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
    try:
        record = json.loads((folder / "run.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return []
    names = record.get(KEY) if isinstance(record, dict) else None
    return names if isinstance(names, list) else []
