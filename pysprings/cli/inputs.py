# SPDX-License-Identifier: MIT
"""Springs of result folders, spring files and tables."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pysprings.cli.folders import folders_of, refuse_other
from pysprings.cli.support import refuse, to_stderr
from pysprings.core.errors import PyspringsError
from pysprings.core.written import is_unfinished

if TYPE_CHECKING:
    import xarray as xr

    from pysprings.full_model.run_record import RunRecord
    from pysprings.macro.model import AnySprings


def springs_of(result: Path, strict: bool = False) -> xr.DataTree:
    """Open the springs of a result folder or spring file, as `read_springs`; refuse a run that has not ended.

    With `strict` a file without the checksum of this program, which another one has written or changed, is refused.
    """
    from pysprings.core.storage import CHANGED_ELSEWHERE, bytes_hold

    refuse_unfinished(result, strict)
    springs, file = read_springs(result), result / "springs.nc" if result.is_dir() else result
    if strict and bytes_hold(file) is None:
        refuse("--strict", CHANGED_ELSEWHERE, file)
    return springs


def refuse_unfinished(result: Path, strict: bool = False) -> None:
    """Refuse a folder whose run was killed or is still writing; warn of one whose run was interrupted.

    With `strict` an interrupted run is refused, too. A file that is named itself is complete: then the state of its
    folder causes a warning only.
    """
    from pysprings.full_model.run_record import RunRecord, Status

    folder = result if result.is_dir() else result.parent
    unfinished, record = is_unfinished(folder), RunRecord.read(folder)
    saved = not unfinished or (record is not None and _are_of(folder, record))
    onward = "`pysprings run SCENE --out DIR --resume` goes on with it"
    if record and record.status is Status.INTERRUPTED and saved:
        message = f"the run was interrupted: what is here is what had converged until then; {onward}"
        if strict:
            refuse("--strict", message, folder)
        to_stderr(f"warning: {folder}: {message}")
    elif record and saved and record.not_made and record.status is not Status.WRITING:
        to_stderr(f"warning: {folder}: {record.left_to_make}")
    elif unfinished or (record and record.status is Status.WRITING):
        message = "holds a run that has not ended (killed, or still running)"
        if result.is_dir():
            refuse(None, f"{message}: files here may be of a run before it, or not all there; {onward}", folder)
        to_stderr(f"warning: {folder}: {message}; this file may be of a run before it")


def _are_of(folder: Path, record: RunRecord) -> bool:
    """Return whether the checkpoints in a folder are those of its run, or of the same run with more harmonics."""
    from pysprings.full_model.checkpoint import Checkpoints
    from pysprings.scene.load import parse_scene

    checkpoints = Checkpoints(folder)
    if checkpoints.are_of(record.scene_sha256):
        return True
    try:
        more = parse_scene(record.scene_toml).replace(mesh={"harmonics": checkpoints.harmonics})
    except PyspringsError:  # of another version
        return False
    return checkpoints.harmonics is not None and checkpoints.are_of(more.sha256)


def read_springs(result: Path) -> xr.DataTree:
    """Open the springs of a result folder or spring file; extract them from a full-model file."""
    from pysprings.core.storage import read_tree
    from pysprings.springs.checks import validate_springs

    path = result / "springs.nc" if result.is_dir() else result
    if result.is_dir() and not path.exists():
        if found := folders_of(result):
            refuse(None, f"holds the estimates {', '.join(found)}: name the folder of one of them", result)
        refuse(None, "no springs.nc in this folder; is it a result of `pysprings run`?", result)
    tree = read_tree(path)
    if result.is_dir():
        refuse_other(result, str(tree.attrs.get("title", "")))
    if "section" in tree.children and "scene_toml" in tree.attrs:
        from pysprings.results.layout import open_result
        from pysprings.springs.checks import extract_springs

        return extract_springs(open_result(path))
    validate_springs(tree, file=path)
    return tree


def springs_or_table(
    source: Path, skirt_length: float | None, strict: bool = False, rate: float | None = None
) -> AnySprings:
    """Open the springs of a prediction: as `springs_of` does, or from a user's CSV or Excel table.

    rate : that of the springs [m/s, of rho]; None: all that there are.
    """
    from pysprings.core.tables import ENDINGS, is_table
    from pysprings.results.tables import open_table

    if is_table(source) and not source.is_dir():
        if rate is not None:
            refuse("--rate", "a table has no rates")
        return open_table(source, skirt_length)
    if skirt_length is not None:
        refuse("--skirt-length", f"is for tables ({', '.join(ENDINGS[:2])}); a spring file has it", source)
    springs = springs_of(source, strict)
    if rate is None:
        return springs
    from pysprings.springs.springs import Springs

    return Springs.of(springs).at_rate(rate)
