# SPDX-License-Identifier: MIT
"""``python -m validation.paper``: run the reproduction with its progress, print the claims and the files."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from pysprings.cli.folders import refuse_no_folder
from pysprings.cli.guard import guarded
from pysprings.cli.support import interruptible, to_stderr
from pysprings.core.errors import RunIncomplete
from pysprings.core.progress import reporter
from pysprings.core.words import MeshPreset
from validation.paper import study, text


@guarded
def paper(
    mesh: Annotated[MeshPreset, typer.Option("--mesh", help="mesh preset of the runs")] = "medium",
    out: Annotated[Path | None, typer.Option("--out", help="result folder \\[default: out/paper-MESH]")] = None,
    sensitivity: Annotated[bool, typer.Option("--sensitivity", help="also vary what the paper leaves open")] = False,
    sensitivity_mesh: Annotated[MeshPreset, typer.Option("--sensitivity-mesh", help="their mesh preset")] = "coarse",
    force: Annotated[bool, typer.Option("--force", help="forget what has run in the folder, and begin anew")] = False,
) -> None:
    """Reproduce Cerfontaine, Charlier & Collin (2018): its runs, the paper's figures, its claims beside ours.

    Runs that have ended in the folder are not run again; interrupted ones go on.
    """
    folder = out or Path("out") / f"paper-{mesh}"
    refuse_no_folder(folder)
    try:
        with interruptible(), reporter(sys.stderr) as progress:
            stopped = study.study(folder, mesh, progress, sensitivity_mesh if sensitivity else None, force=force)
    except KeyboardInterrupt:
        to_stderr(f"what has run is kept in {folder}; the same command goes on")
        raise
    for line in text.claim_lines(study.read_claims(folder)):
        print(line)
    print()
    for name, meaning in study.FILES.items():
        if (folder / name).exists():
            print(f"{folder / name}: {meaning}")
    if stopped:
        raise RunIncomplete("; ".join(stopped), folder)


if __name__ == "__main__":
    typer.run(paper)
