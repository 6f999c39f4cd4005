# SPDX-License-Identifier: MIT
"""What the solver costs, as ratios taken in one run: `make bench`, or `python -m benchmarks.bench [SECTION ...]`.

units    the paper's pull, drained, on `paper`: wall time in units of one factorisation and solve of its own tangent
growth   unit, wall time and memory against unknowns, drained and coupled, with fitted exponents
fine     the same pull on at least 100,000 nodes, its cost by unknown beside that of `paper`

Every run is a process of its own with warm caches; pictures are left out. Seconds depend on the machine, and on what
else it does; the ratios less so.
"""

import argparse
import os
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pysprings.full_model.run_record import RunRecord

MM = 1.0e-3
GROWTH = {
    "drained": ("coarse:0.7", "coarse", "medium", "medium:1.4", "paper", "fine:1.02"),
    "coupled": ("coarse", "medium", "medium:1.4", "paper", "fine:0.92"),
}
SECTIONS = {  # mesh, end [m], mode of its runs
    "units": [("paper", end * MM, "drained") for end in (2.5, 20.0)],
    "growth": [(mesh, MM, mode) for mode, meshes in GROWTH.items() for mesh in meshes],
    "fine": [(mesh, 2.5 * MM, "drained") for mesh in ("paper", "fine")],
}


def scene(mesh: str, end: float, mode: str = "drained") -> Any:
    """Return the paper's pull to an end (m) on a preset, with an optional factor ("medium:1.4"); no pictures."""
    from pysprings import Scene
    from pysprings.full_model.accuracy.presets import read_mesh
    from pysprings.scene.sections import PAPER, PAPER_SOIL

    rate = {"rate": 0.05 * MM} if mode == "coupled" else {}
    path = {"name": "pull", "kind": "pull", "lateral_displacement": end} | rate
    output = {"figures": False, "section": False}
    paper = Scene(domain=PAPER, soil=PAPER_SOIL, paths=(path,), drainage={"mode": mode}, output=output)
    return read_mesh(mesh).scene(paper)


def record(mesh: str, end: float, mode: str = "drained") -> RunRecord:
    """Return the record of the paper's pull to an end (m), see `scene`, in a process of its own; its unit timed."""
    from pysprings.studies.accuracy.runs import run_in_child

    with tempfile.TemporaryDirectory() as folder:
        run_in_child(scene(mesh, end, mode), Path(folder) / "run", lambda *_: None)
        ended = RunRecord.read(Path(folder) / "run")
    assert ended is not None
    return ended


def text_of(name: str, run: RunRecord) -> str:
    """Return two lines on a run: size, increments, wall [s], unit [s], ratio, memory [GB]; profile [% of wall]."""
    solver, wall, unit, peak = run.solver, run.wall_s, run.solver.unit_s, run.solver.peak_before_unit_bytes
    assert unit is not None and peak is not None  # both are measured on demand
    shares = sorted(((cost["wall_s"] / wall, phase) for phase, cost in run.phases.items()), reverse=True)
    return (
        f"{name:22} {run.mesh.unknowns:8,} unknowns  {run.paths['pull'].increments:3} increments  "
        f"{solver.factorisations:4} factorisations  {solver.solves:6} solves  {wall:7.1f} s  "
        f"unit {unit:.3f} s  {wall / unit:6.1f} units  {peak / 1e9:5.2f} GB\n"
        f"{'':22}  {', '.join(f'{phase} {100 * share:.0f} %' for share, phase in shares)}"
    )


def exponents(n: Sequence[float], values: Sequence[float]) -> tuple[float, float]:
    """Return exponents p of values ~ n^p: fitted to all (least squares of the logarithms), and of the last two."""
    x, y = np.log(n), np.log(values)
    return float(np.polyfit(x, y, 1)[0]), float((y[-1] - y[-2]) / (x[-1] - x[-2]))


def measure(runs: Sequence[tuple[str, float, str]]) -> None:
    """Print the cost of runs (mesh, end [m], mode); by mode its growth over meshes, or the last beside the first."""
    for mode in dict.fromkeys(mode for *_, mode in runs):
        found = []
        for mesh, end in (each[:2] for each in runs if each[2] == mode):
            found.append(record(mesh, end, mode))
            print(text_of(f"{mesh}, {mode}, to {end / MM:g} mm", found[-1]), flush=True)
        if len(found) == 2:
            first, other = (run.wall_s / run.mesh.unknowns for run in found)
            print(f"cost per unknown: {other / first:.2f} times that of the first")
            continue
        table = [(run.solver.unit_s, run.wall_s, run.solver.peak_before_unit_bytes) for run in found]
        for what, values in zip(("unit", "wall", "memory"), zip(*table, strict=True), strict=True):
            slope, last = exponents([run.mesh.unknowns for run in found], values)
            print(f"{mode}: {what} grows with unknowns to the power {slope:.2f} (last two meshes {last:.2f})")


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the sections that are asked for, or all."""
    parser = argparse.ArgumentParser("python -m benchmarks.bench", description="What the solver costs.")
    parser.add_argument("section", nargs="*", choices=list(SECTIONS), default=list(SECTIONS))
    chosen = parser.parse_args(arguments).section
    print(f"{os.cpu_count()} processors")
    for mode in GROWTH:  # compiled code is kept on disk from here on
        record("coarse:0.5", 0.1 * MM, mode)
    for name in chosen:
        print(f"\n{name}", flush=True)
        measure(SECTIONS[name])


if __name__ == "__main__":
    main()
