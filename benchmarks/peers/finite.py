# SPDX-License-Identifier: MIT
"""The elastic caisson and the pushes with contact in all programs."""

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.peers import problem
from benchmarks.peers.timed import timed
from pysprings.core.version import __version__

HEADS = ["program", "version", "elements, contact", "H", "M", "wall [s]", "peak [MB]", "what it lacks here"]
PYSPRINGS = "bricks with mean dilatation; nodes, normals of the cylinder"
ELEMENTS = {
    "OpenSees": "bbarBrick; zeroLengthContactASDimplex on nodes, normals of the cylinder",
    "CalculiX": "C3D8; face to face, penalty, on flat faces",
    "Kratos": "SmallDisplacementElement3D8N",
}
LACKS = {
    ("OpenSees", "elastic"): "a rigid body of given motion: each node is held",
    ("CalculiX", "elastic"): "mean dilatation of C3D8",
    ("Kratos", "elastic"): "mean dilatation",
    ("OpenSees", "smooth"): "initial pressure of contacts",
    ("OpenSees", "rough"): "initial pressure of contacts",
    ("CalculiX", "smooth"): "pressure of pore water in contacts",
    ("CalculiX", "rough"): "pressure of pore water in contacts",
}
NO_CONTACT = "not set up: contact is a package of its own (mortar)"


def table(case: str, there: dict[str, str | None], folder: Path) -> list[list[str]]:
    """Return the rows of a case: programs, answers, costs."""
    file = problem.write(case, folder / f"{case}.npz")
    rows = [_row(case, "pysprings", __version__, ["-m", "benchmarks.peers.in_pysprings", case], folder)]
    for name, version in there.items():
        if version is None:
            rows.append([name, "missing", *[""] * 6])
        elif name == "Kratos" and case != "elastic":
            rows.append([name, version, "", "", "", "", "", NO_CONTACT])
        else:
            script = Path(__file__).parent / f"in_{name.lower()}.py"
            rows.append(_row(case, name, version, [str(script), case, str(file)], folder))
    return rows


def sizes(folder: Path) -> str:
    """Return a sentence on the mesh."""
    data = np.load(folder / "elastic.npz")
    return f"{len(data['nodes'])} nodes, {len(data['hexes'])} bricks, {len(data['node'])} contact nodes (half model)"


def _row(case: str, name: str, version: str, command: list[str], folder: Path) -> list[str]:
    what = ELEMENTS.get(name, PYSPRINGS).split("; ")
    words = what[0] if case == "elastic" else "; ".join(what)
    lacks = LACKS.get((name, case), "")
    try:
        text, seconds, memory = timed([sys.executable, *command], folder)
    except subprocess.CalledProcessError as error:
        why = "no convergence" if "converge" in error.stderr + error.stdout else "no answer"
        return [name, version, words, why, "", "", "", lacks]
    answer = next(json.loads(line) for line in text.splitlines() if line.startswith("{"))
    return [name, version, words, *_loads(case, answer), f"{seconds:.1f}", f"{memory:.0f}", lacks]


def _loads(case: str, answer: dict[str, float]) -> Iterator[str]:
    """Yield H and M in words: stiffness of the elastic caisson, loads of the others."""
    units = ("MN/m", "MN") if case == "elastic" else ("MN", "MN m")
    yield from (f"{answer[key] / 1e6:.6g} {unit}" for key, unit in zip("HM", units, strict=True))
