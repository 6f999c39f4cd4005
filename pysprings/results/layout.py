# SPDX-License-Identifier: MIT
"""The result folder of a run: its result, names of files and pictures, and what a new run removes (light)."""

import os
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import xarray as xr

from pysprings.core.errors import refused
from pysprings.core.path_kinds import beam_order, has_free_head
from pysprings.core.storage import read_tree
from pysprings.core.written import CHECKPOINT, LIST, listed, refuse_links
from pysprings.full_model.run_record import ATTRIBUTE
from pysprings.results.exporters import EXPORTERS
from pysprings.springs.checks import RESULT

FIGURES = "figures"  # folder of the pictures
PARAVIEW = "paraview"  # folder of the files for ParaView: the name of that exporter

# in the order in which people read them: the report first
_BEFORE = {"report.html": "report: open it in a browser", "load_displacement.csv": "load-displacement tables"}
_AFTER = {
    "compare.csv": "prediction with the springs beside the full model",
    "full_model.nc": "full model (NetCDF)",
    "run.json": "status, solver, cost",
}

LOAD_CASES = "design.csv"  # answers to load cases, which `pysprings design --report` puts there

OF_FREE_HEADS = ("caisson", "macro_against_full", "stress_outside", "section", "gap")  # pictures about loads and states
_STATE = re.compile(r"last|[0-9.]+mm")


def run_files() -> dict[str, str]:
    """Return name -> meaning of the files that a run writes into its folder, in reading order."""
    tables = {each.file: each.description for each in EXPORTERS if each.of_every_run}
    return {**_BEFORE, **tables, **_AFTER}


def own_folders() -> tuple[str, ...]:
    """Return the names of folders inside a result folder that runs and exports use."""
    return CHECKPOINT, FIGURES, *EXPORTERS.names()


def refuse_linked_folders(folder: Path) -> None:
    """Raise UserInputError where a result folder has a link in the place of a folder of its own."""
    refuse_links(folder, own_folders())


def results_in(folder: Path) -> list[str]:
    """Return the files of a run that a folder holds."""
    return [name for name in run_files() if (folder / name).exists()]


def picture_kind(stem: str, path: str) -> tuple[str, str] | None:
    """Split the name of a picture in (kind, state); None when it is not of the path (of the whole run: ``""``)."""
    from pysprings.results.plots.draw import PICTURES

    if not path:
        return (stem, "") if stem in PICTURES and PICTURES[stem].scope == "run" else None
    rest = stem.removeprefix(f"{path}_")
    if rest == stem:
        return None
    if rest in PICTURES:
        return rest, ""
    kind, _, state = rest.rpartition("_")
    return (kind, state) if kind in PICTURES and _STATE.fullmatch(state) else None


class Drawn(NamedTuple):
    """A picture of a run by its kind, path (blank for the whole run) and state (blank for none)."""

    kind: str
    path: str
    state: str

    @property
    def stem(self) -> str:
        """Name of its files, without suffix."""
        return "_".join(filter(None, (self.path, self.kind, self.state)))


def stands_for(kind: str, known: Iterable[Drawn], paths: Mapping[str, Mapping[Any, Any]]) -> Drawn | None:
    """Return the picture of a kind that the report shows, of those that are known; None where there is none.

    The first path that has one: of those with a free head before others in the parts about loads and states, of that
    whose springs a beam would take (`beam_order`) elsewhere. Of several states the last. `paths` has the attributes of
    each path by its name.
    """
    free = kind in OF_FREE_HEADS
    order = sorted(paths, key=lambda name: (not has_free_head(paths[name]),) if free else beam_order(paths[name]))
    rank = {name: number for number, name in enumerate(("", *order))}
    found = [each for each in known if each.kind == kind]
    return min(found, key=lambda each: (each.state != "last", rank[each.path]), default=None)


def pictures_in(folder: Path) -> list[Path]:
    """Return the pictures of runs in a result folder; files with other names are left out."""
    files = [path for path in sorted((folder / FIGURES).glob("*")) if path.suffix in (".png", ".svg")]
    return [path for path in files if picture_kind(path.stem, "") or _shows_a_path(path.stem)]


def _shows_a_path(stem: str) -> bool:
    """Return whether a name is `path_kind` or `path_kind_state` for any path."""
    parts = stem.split("_")
    return any(picture_kind(stem, "_".join(parts[:n])) for n in range(1, len(parts)))


def remove_results(folder: Path) -> None:
    """Remove all files of an earlier run from its folder; everything else in the folder stays.

    In the folders of pictures and exports these are the files that runs and exports have listed; none behind a link.
    """
    refuse_linked_folders(folder)
    inside = tuple(name for name in own_folders() if name != CHECKPOINT)
    for path in [*listed(folder, inside), *(folder / name for name in (*run_files(), LOAD_CASES)), folder / LIST]:
        path.unlink(missing_ok=True)


OTHER_SIGNS = "its moments and rotations have other signs; make it again with `pysprings run`"  # of earlier versions


def open_result(path: str | os.PathLike[str]) -> xr.DataTree:
    """Read the result of a full model: ``full_model.nc``, or the folder of a run that holds it.

    Raises
    ------
    UserInputError
        The file is missing, broken, or no result of a full model.
    """
    file = Path(path)
    file = file / "full_model.nc" if file.is_dir() else file
    tree = read_tree(file)
    if tree.attrs.get("schema") != RESULT:
        if ATTRIBUTE not in tree.attrs:
            raise refused(None, "is no result of a full model (springs: open_springs)", file)
        raise refused("schema", f"a result of another version, not {RESULT}: {OTHER_SIGNS}", file)
    return tree
