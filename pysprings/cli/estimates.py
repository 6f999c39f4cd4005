# SPDX-License-Identifier: MIT
"""Runs of several estimates of one scene: what must hold before, and what is shown after."""

from collections.abc import Sequence
from pathlib import Path

from pysprings.cli.folders import refuse_no_folder
from pysprings.cli.support import print_json, print_table, refuse, to_stderr
from pysprings.core.words import ESTIMATES


def chosen(given: Sequence[str] | None) -> tuple[str, ...]:
    """Return each estimate of `--estimate` once, in the order of `ESTIMATES`; refuse other words."""
    if wrong := [each for each in given or () if each not in ESTIMATES]:
        refuse("--estimate", f"'{wrong[0]}' is none of {', '.join(ESTIMATES)}")
    return tuple(each for each in ESTIMATES if each in (given or ()))


def refuse_without_ranges(scene: Path) -> None:
    """Refuse a scene in which no value has a range."""
    from pysprings.scene.load import SceneText

    if not SceneText.read(scene).has_ranges:
        refuse("--estimate", "no value of the scene has a range { low, best, high }: all estimates are the same", scene)


def ready_to_run(scene: Path, folder: Path) -> None:
    """Refuse a scene without ranges, and a folder that holds one run itself."""
    refuse_without_ranges(scene)
    refuse_no_folder(folder)
    if (folder / "run.json").exists():
        refuse("--out", "holds one run: choose another folder for several estimates", folder)


def show_together(folder: Path, estimates: Sequence[str], as_json: bool, quiet: bool) -> None:
    """Write and print what shows the runs side by side; nothing is made of fewer than two with springs."""
    from pysprings.cli.compare import open_run
    from pysprings.cli.results import results
    from pysprings.results.estimates import folders_of, table_of, write_together

    files: list[Path] = []
    runs = {name: open_run(place, name) for name, place in folders_of(folder).items() if name in estimates}
    if len(runs) > 1:
        files, loads = write_together(folder, runs)
        if not as_json and not quiet:
            print_table(table_of(loads))
    else:
        to_stderr("note: fewer than two estimates have springs: nothing is set side by side")
    if as_json:
        print_json({"files": [str(file) for file in files],
                    "estimates": {name: results(folder / name) for name in runs}})  # fmt: skip
    elif not quiet:
        print("\n".join(["", *map(str, [*(folder / name for name in runs), *files])]))
