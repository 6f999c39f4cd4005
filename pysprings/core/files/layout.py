# SPDX-License-Identifier: MIT
"""Result folders of runs: status while files are written, checkpoints, links (light)."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from pysprings.core.files.written import own_folder

CHECKPOINT = "checkpoint"  # folder of the data from which an unfinished run continues
_CHECKPOINT_FILE = re.compile(r"(start|path-\d{3,}|state-[ab])\.npz")
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
