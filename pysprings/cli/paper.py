# SPDX-License-Identifier: MIT
"""`pysprings paper`: runs the reproduction with its progress, prints the claims and the files."""

from __future__ import annotations

import sys
from pathlib import Path

from pysprings.cli.folders import refuse_no_folder
from pysprings.cli.support import interruptible, print_json, to_stderr
from pysprings.core.errors import RunIncomplete
from pysprings.core.progress import reporter
from pysprings.studies.paper import study, text


def run(out: Path, mesh: str, sensitivity_mesh: str | None, force: bool, as_json: bool) -> None:
    """Run or go on; raise RunIncomplete at the end where a run has stopped by itself."""
    refuse_no_folder(out)
    try:
        with interruptible(), reporter(sys.stderr) as progress:
            stopped = study.study(out, mesh, progress, sensitivity_mesh, force=force)
    except KeyboardInterrupt:
        to_stderr(f"what has run is kept in {out}; the same command goes on")
        raise
    _print(out, mesh, stopped, as_json)
    if stopped:
        raise RunIncomplete("; ".join(stopped), out)


def _print(out: Path, mesh: str, stopped: list[str], as_json: bool) -> None:
    table = study.read_claims(out)
    if as_json:
        claims = table.to_dict(orient="records")
        print_json({"folder": str(out), "mesh": mesh, "stopped": stopped, "claims": claims})
        return
    for line in text.claim_lines(table):
        print(line)
    print()
    for name, meaning in study.FILES.items():
        if (out / name).exists():
            print(f"{out / name}: {meaning}")
