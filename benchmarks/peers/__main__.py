# SPDX-License-Identifier: MIT
"""Elastic caisson and pushes with contact in pysprings, OpenSees and CalculiX, in one go (`make bench-peers`).

Answer, time and memory of each program, and what it lacks, as Markdown; missing programs are listed. The problems are
those of `problem`, one mesh for all. Times are those of a whole process on one thread, its start included.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from benchmarks.peers import problem
from benchmarks.peers.timed import timed, versions
from pysprings.core.text import markdown_table
from pysprings.core.version import __version__

CASES = {
    "elastic": "Stiffness H/u [MN/m], M/u [MN] of a bonded caisson",
    "smooth": "Push of 2 mm with contact, without friction; H [MN], M [MN m]",
    "rough": "Push of 2 mm with contact, friction 0.3; H [MN], M [MN m]",
}
HEADS = ["program", "version", "elements, contact", "H", "M", "wall [s]", "peak [MB]", "what it lacks here"]
ELEMENTS = {
    "pysprings": "bricks with mean dilatation; nodes, normals of the cylinder",
    "OpenSees": "bbarBrick; zeroLengthContactASDimplex on nodes, normals of the cylinder",
    "CalculiX": "C3D8; face to face, penalty, on flat faces",
}
LACKS = {  # in elastic soil, with contact
    "pysprings": ("", ""),
    "OpenSees": ("a rigid body of given motion: each node is held", "initial pressure of contacts"),
    "CalculiX": ("mean dilatation of C3D8", "pressure of pore water in contacts"),
}


def row(case: str, name: str, version: str | None, file: Path) -> list[str]:
    """Return the row of a program: answers and costs, or why there are none."""
    words, lacks = ELEMENTS[name], LACKS[name][case != "elastic"]
    if case == "elastic":
        words = words.split("; ")[0]
    if version is None:
        return [name, "missing", *[""] * 6]
    script = Path(__file__).parent / f"in_{name.lower()}.py"
    command = ["-m", "benchmarks.peers.problem", case] if name == "pysprings" else [str(script), case, str(file)]
    try:
        text, seconds, memory = timed([sys.executable, *command], file.parent)
    except subprocess.CalledProcessError as error:
        why = "no convergence" if "converge" in error.stderr + error.stdout else "no answer"
        return [name, version, words, why, "", "", "", lacks]
    answer = next(json.loads(line) for line in text.splitlines() if line.startswith("{"))
    H, M = (f"{answer[key] / 1e6:.6g}" for key in "HM")
    return [name, version, words, H, M, f"{seconds:.1f}", f"{memory:.0f}", lacks]


def main() -> None:
    """Print the answers of all programs that are there."""
    there: dict[str, str | None] = {"pysprings": __version__, **versions()}
    with tempfile.TemporaryDirectory() as folder:
        for case, words in CASES.items():
            file = problem.write(case, Path(folder) / f"{case}.npz")
            data = np.load(file)
            sizes = f"{len(data['nodes'])} nodes, {len(data['hexes'])} bricks, {len(data['node'])} contact nodes"
            rows = [row(case, name, version, file) for name, version in there.items()]
            print(f"## {case.title()}\n\n{words}; {sizes} (half model).\n\n{markdown_table(HEADS, rows)}", flush=True)


if __name__ == "__main__":
    main()
