# SPDX-License-Identifier: MIT
"""The result folder of a run: names of its files and pictures, and what a new run clears away (light)."""

from __future__ import annotations

import re
from pathlib import Path

from pysprings.core.files.written import LIST, listed, own_folder

# files of a run, in the order in which people want to hear of them
FILES = {
    "report.html": "report: open it in a browser",
    "load_displacement.csv": "load-displacement tables",
    "py.csv": "p-y tables",
    "py_wide.csv": "the same, a pair of columns y, p by depth, for spreadsheets",
    "springs.xlsx": "springs as a spreadsheet",
    "springs.nc": "springs (NetCDF), for `pysprings springs, predict, compare`",
    "compare.csv": "prediction with the springs beside the full model",
    "full_model.nc": "full model (NetCDF)",
    "run.json": "status, solver, cost",
}

FIGURES = "figures"  # folder of the pictures
PARAVIEW = "paraview"  # folder of the files for ParaView, on request
CHECKPOINT = "checkpoint"  # folder of what an unfinished run needs to go on
OWN_FOLDERS = (CHECKPOINT, FIGURES, PARAVIEW)
_CHECKPOINT_FILE = re.compile(r"(start|path-\d{3,}|state-[ab])\.npz")
WRITING = "writing"  # status in run.json until every file of the run is written

# Kinds of pictures with their captions, in reading order. A picture is called `kind` when it shows the whole run,
# `path_kind` when it shows a path, and `path_kind_state` when it shows one state: the last, or one at 2.5 mm.
PICTURES = {
    "mesh": "Mesh in the symmetry plane",
    "load_displacement": "Load by component, vertical forces, rotation and heave",
    "macro_against_full": "Rigid body on springs against the full model",
    "py": "p-y curves by depth",
    "vertical": "Vertical springs",
    "stress_outside": "Normal effective stress around the caisson, outside",
    "stress_inside": "Normal effective stress around the caisson, inside",
    "gap": "Gap opening",
    "ovalisation": "Ovalisation of the skirt, and its mean fibre by depth",
    "section": "Displacement in the symmetry plane",
    "pressure": "Excess pore pressure around the skirt",
    "section_pressure": "Excess pore pressure in the symmetry plane",
    "newton": "Newton iterations",
}
WHOLE_RUN = ("mesh",)
_STATE = re.compile(r"last|[0-9.]+mm")


def results_in(folder: Path) -> list[str]:
    """Return the files of a run that a folder holds."""
    return [name for name in FILES if (folder / name).exists()]


def is_unfinished(folder: Path) -> bool:
    """Tell whether a folder holds the checkpoints of a run that was stopped: an ended one removes them."""
    return bool(checkpoints_in(folder / CHECKPOINT))


def checkpoints_in(place: Path) -> list[Path]:
    """Return the checkpoint files in their folder; files with other names are somebody else's."""
    return sorted(file for file in place.glob("*.npz") if _CHECKPOINT_FILE.fullmatch(file.name))


def refuse_links(folder: Path) -> None:
    """Refuse a result folder that has a link in the place of a folder of its own (UserInputError)."""
    for name in OWN_FOLDERS:
        own_folder(folder, name)


def picture_kind(stem: str, path: str) -> tuple[str, str] | None:
    """Split a picture's name in (kind, state); None when it is not of the path (of the whole run: ``""``)."""
    if not path:
        return (stem, "") if stem in WHOLE_RUN else None
    rest = stem.removeprefix(f"{path}_")
    if rest == stem:
        return None
    if rest in PICTURES:
        return rest, ""
    kind, _, state = rest.rpartition("_")
    return (kind, state) if kind in PICTURES and _STATE.fullmatch(state) else None


def pictures_in(folder: Path) -> list[Path]:
    """Return the pictures of runs in a result folder; files with other names are somebody else's."""
    files = [path for path in sorted((folder / FIGURES).glob("*")) if path.suffix in (".png", ".svg")]
    return [path for path in files if path.stem in WHOLE_RUN or _shows_a_path(path.stem)]


def _shows_a_path(stem: str) -> bool:
    """Tell whether a name is `path_kind` or `path_kind_state` for any path."""
    parts = stem.split("_")
    return any(picture_kind(stem, "_".join(parts[:n])) for n in range(1, len(parts)))


def remove_results(folder: Path) -> None:
    """Remove all files of an earlier run from its folder; everything else in the folder stays.

    In the folders of pictures and ParaView files these are the ones that the run has listed; none behind a link.
    """
    refuse_links(folder)
    for path in [*listed(folder, (FIGURES, PARAVIEW)), *(folder / name for name in FILES), folder / LIST]:
        path.unlink(missing_ok=True)
