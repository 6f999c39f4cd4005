# SPDX-License-Identifier: MIT
"""Write data/reference from the folder of `pysprings paper --mesh coarse`: see `make reference`."""

from __future__ import annotations

import argparse
import subprocess
from pathlib import Path

from pysprings.studies.paper import reference, runs


def commit_date() -> str:
    """Return the date of the commit that the results come from; "unknown" outside a repository."""
    command = ["git", "log", "-1", "--format=%cI"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.stdout.strip() or "unknown"


def main() -> None:
    """Read the options, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help=f"folder of `{reference.COMMAND}`")
    parser.add_argument("--to", type=Path, default=Path("data/reference"), help="where the references are")
    given = parser.parse_args()
    ended = runs.load_runs(given.folder, reference.MESH, reference.reference_cases())
    origin = {"command": f"{reference.COMMAND}; python -m benchmarks.paper_reference", "commit_date": commit_date()}
    for case in reference.reference_cases():
        if case.name not in ended or not ended[case.name].complete:
            raise SystemExit(f"{given.folder}: the run {case.name} is not there, or not complete")
        print(reference.write(ended[case.name], given.to, origin))


if __name__ == "__main__":
    main()
