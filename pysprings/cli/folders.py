# SPDX-License-Identifier: MIT
"""Result folders of commands: created, locked, and protected from replacement; folders of several estimates."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from pysprings.cli.support import print_json, print_table, refuse, to_stderr
from pysprings.core.text import shared
from pysprings.core.words import ESTIMATES, OF_ESTIMATE
from pysprings.core.written import exclusive, is_unfinished, new_folder, scene_of_holder

if TYPE_CHECKING:
    from pysprings.full_model.run_record import RunRecord
    from pysprings.scene.model import Scene


@contextmanager
def result_folder(out: Path, scene: Scene, force: bool, resume: bool = False) -> Iterator[bool]:
    """Create a result folder and hold its lock; refuse a folder whose contents conflict with `force` and `resume`.

    A new folder is removed again if it stays empty. The block has whether there is something to resume: not where a
    run of the same scene was killed before its first checkpoint.
    """
    from pysprings.results.layout import refuse_linked_folders, results_in

    if force and resume:
        refuse("--resume", "goes on with a run, --force begins anew: give one of them")
    refuse_no_folder(out)
    with ExitStack() as stack:
        try:
            stack.enter_context(new_folder(out))
        except OSError as error:
            refuse("--out", f"cannot be created ({error.strerror})", out)
        if not os.access(out, os.W_OK | os.X_OK):
            refuse("--out", "is not writable", out)
        killed = resume and scene_of_holder(out) == scene.sha256
        stack.enter_context(exclusive(out, scene.sha256))
        refuse_linked_folders(out)
        resume = resume and not (killed and not results_in(out) and not is_unfinished(out))
        if not force:
            _refuse_contents(out, resume)
        yield resume


def refuse_no_folder(out: Path) -> None:
    """Refuse a result folder that is a file, or a link to nothing."""
    if out.is_symlink() and not out.exists():
        refuse("--out", f"is a link to {os.readlink(out)}, which is not there", out)
    if out.exists() and not out.is_dir():
        refuse("--out", "is a file, not a folder", out)


def refuse_read(option: str, file: Path | None, *read: Path | None) -> None:
    """Refuse to write over a file that the command reads, or over what other commands read of the folder of a run."""
    names = ("springs.nc", "full_model.nc", "run.json")
    inputs = [each / name for each in read if each for name in (names if each.is_dir() else ("",))]
    if file is not None and file.exists() and any(each.exists() and file.samefile(each) for each in inputs):
        refuse(option, "is read by this command, and would be lost: name another file", file)


def _refuse_contents(out: Path, resume: bool) -> None:
    """Refuse a folder with an interrupted run or with results, and with `resume` one without either."""
    from pysprings.results.layout import results_in

    results, unfinished = results_in(out), is_unfinished(out)
    if resume and not unfinished and "run.json" not in results:
        refuse("--resume", "nothing to resume: no interrupted run in this folder", out)
    if unfinished and not resume:
        refuse("--out", "holds an interrupted run; --resume goes on with it, --force begins anew", out)
    if results and not resume:
        refuse(
            "--out", f"holds results already ({', '.join(results)}); choose another folder, or --force to replace", out
        )


def refuse_other_run(folder: Path, record: RunRecord, scene: Scene) -> None:
    """Refuse to resume in a folder whose results belong to another scene or mesh, or are interrupted."""
    from pysprings.full_model.run_record import Status

    if not record.is_of(scene):
        refuse("--resume", "the results here are those of another scene or mesh; --force begins anew", folder)
    if record.status in (Status.INTERRUPTED, Status.WRITING):
        message = "nothing to resume: the run here was interrupted, and its checkpoints are gone; --force begins anew"
        refuse("--resume", message, folder)


def record_stamp(folder: Path) -> tuple[int, int] | None:
    """Return a stamp that changes when a run writes its record; None without a record."""
    record = folder / "run.json"
    return (record.stat().st_ino, record.stat().st_mtime_ns) if record.exists() else None


def chosen(given: Sequence[str] | None) -> tuple[str, ...]:
    """Return each estimate of `--estimate` once, in the order of `ESTIMATES`; refuse other words."""
    if wrong := [each for each in given or () if each not in ESTIMATES]:
        refuse("--estimate", f"'{wrong[0]}' is none of {', '.join(ESTIMATES)}")
    return tuple(each for each in ESTIMATES if each in (given or ()))


def refuse_without_ranges(scene: Path) -> None:
    """Refuse a scene in which no value has a range."""
    from pysprings.scene.load import SceneText

    text = SceneText.read(scene)
    if not text.has_ranges:
        text.scene()  # a table of layers that cannot be read has none: its own problems stand first
        refuse("--estimate", "no value of the scene has a range { low, best, high }: all estimates are the same", scene)


def folders_of(folder: Path) -> dict[str, Path]:
    """Return the folders of runs by estimate that a folder holds; none of a folder of one run."""
    if (folder / "run.json").exists():
        return {}
    return {name: folder / name for name in ESTIMATES if (folder / name / "springs.nc").exists()}


def refuse_other(folder: Path, title: str) -> None:
    """Refuse springs in the folder of one estimate whose title names another one: they were copied there."""
    if folder.name in ESTIMATES and OF_ESTIMATE.format(folder.name) not in title:
        for other in (each for each in ESTIMATES if OF_ESTIMATE.format(each) in title):
            refuse(None, f"springs.nc is that of the {other} estimate: {title}", folder)


def all_folders_of(folder: Path) -> dict[str, Path]:
    """Return the folders of runs by estimate as `folders_of` does; refuse those that are not of one scene.

    Raises UserInputError: one has no springs, or ran with other values: the largest over the estimates is not known.
    """
    from pysprings.full_model.run_record import RunRecord

    found = folders_of(folder)
    lost = [name for name in ESTIMATES if found and name not in found and (folder / name).is_dir()]
    if lost:
        refuse(None, f"estimate {', '.join(lost)} has no springs.nc: its run has not ended", folder)
    records = {name: record for name, place in found.items() if (record := RunRecord.read(place))}
    if len({record.ranges_sha256 for record in records.values()}) > 1:
        ran = ", ".join(f"{name} ran {record.started_utc or 'at a time not known'}" for name, record in records.items())
        refuse(None, f"the estimates are those of different scenes ({ran}): run all of one scene", folder)
    return found


def show_together(folder: Path, estimates: Sequence[str], as_json: bool, quiet: bool) -> None:
    """Write and print what shows the runs side by side; nothing is made of fewer than two with springs."""
    from pysprings.cli.compare import open_run
    from pysprings.cli.results import results
    from pysprings.results.estimates import table_of, write_together

    files: list[Path] = []
    runs = {name: open_run(place, name) for name, place in folders_of(folder).items() if name in estimates}
    if len(runs) > 1:
        files, loads = write_together(folder, runs)
        if not as_json and not quiet:
            print_table(table_of(loads))
            for each in shared({name: run.record.remarks for name, run in runs.items()}):
                to_stderr(f"note: {each}")
    else:
        to_stderr("note: fewer than two estimates have springs: nothing is set side by side")
    if as_json:
        print_json({"files": [str(file) for file in files],
                    "estimates": {name: results(folder / name) for name in runs}})  # fmt: skip
    elif not quiet:
        print("\n".join(["", *map(str, [*(folder / name for name in runs), *files])]))
