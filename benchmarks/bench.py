# SPDX-License-Identifier: MIT
"""What the solver costs, as ratios taken in one run: `make bench`, or `python -m benchmarks.bench [SECTION ...]`.

units    the paper's pull, drained, on `paper`: wall time in units of one factorisation and solve of its own tangent
growth   unit, wall time and memory against unknowns, drained and coupled, with fitted exponents
fine     the same pull on at least 100,000 nodes

Every run is a process of its own with warm caches; pictures are left out. Seconds depend on the machine, and on what
else it does; the ratios less so.
"""

import argparse
import os
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pysprings.full_model.run_record import RunRecord

MM = 1.0e-3
FINE = "fine"
GROWTH = {
    "drained": ("coarse:0.7", "coarse", "medium", "medium:1.4", "paper", "fine:1.02"),
    "coupled": ("coarse", "medium", "medium:1.4", "paper", "fine:0.92"),
}


def scene(mesh: str, end: float, mode: str = "drained") -> Any:
    """Return the paper's pull to an end (m) on a preset, with an optional factor ("medium:1.4"); no pictures."""
    from pysprings import Scene
    from pysprings.full_model.accuracy.presets import read_mesh
    from pysprings.scene.sections import PAPER, PAPER_SOIL

    path = {"name": "pull", "kind": "pull", "lateral_displacement": end}
    if mode == "coupled":
        path["rate"] = 0.05 * MM
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


def cost_per_unknown(run: RunRecord, beside: RunRecord) -> float:
    """Return the wall time by unknown of a run, over that of another."""
    each = [one.wall_s / one.mesh.unknowns for one in (run, beside)]
    return float(each[0] / each[1])


def units() -> None:
    """Print wall time to 2.5 and 20 mm in units of the tangent's own factorisation and solve."""
    for end in (2.5 * MM, 20.0 * MM):
        print(text_of(f"paper, to {end / MM:g} mm", record("paper", end)), flush=True)


def growth() -> None:
    """Print exponents of cost and memory over unknowns, to 1 mm."""
    for mode, meshes in GROWTH.items():
        runs = []
        for mesh in meshes:
            runs.append(record(mesh, 1.0 * MM, mode))
            print(text_of(f"{mesh}, {mode}", runs[-1]), flush=True)
        n = [run.mesh.unknowns for run in runs]
        for what, values in (
            ("unit", [run.solver.unit_s for run in runs]),
            ("wall", [run.wall_s for run in runs]),
            ("memory", [run.solver.peak_before_unit_bytes for run in runs]),
        ):
            slope, last = exponents(n, values)
            print(f"{mode}: {what} grows with unknowns to the power {slope:.2f} (last two meshes {last:.2f})")


def fine() -> None:
    """Print the cost of the paper's pull to 2.5 mm on `fine`, and its cost per unknown beside that of `paper`."""
    runs = {mesh: record(mesh, 2.5 * MM) for mesh in ("paper", FINE)}
    for mesh, run in runs.items():
        print(text_of(f"{mesh}, {run.mesh.nodes:,} nodes", run), flush=True)
    print(f"cost per unknown: {cost_per_unknown(runs[FINE], runs['paper']):.2f} times that of paper")


SECTIONS: dict[str, Callable[[], None]] = {"units": units, "growth": growth, "fine": fine}


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the sections that are asked for, or all."""
    parser = argparse.ArgumentParser("python -m benchmarks.bench", description="What the solver costs.")
    parser.add_argument("section", nargs="*", metavar="SECTION", help=", ".join(SECTIONS))
    chosen = parser.parse_args(arguments).section or list(SECTIONS)
    if unknown := [name for name in chosen if name not in SECTIONS]:
        parser.error(f"no section {', '.join(unknown)}; there are {', '.join(SECTIONS)}")
    print(f"{os.cpu_count()} processors")
    for mode in GROWTH:  # compiled code is kept on disk from here on
        record("coarse:0.5", 0.1 * MM, mode)
    for name in chosen:
        print(f"\n{name}: {SECTIONS[name].__doc__}", flush=True)
        SECTIONS[name]()


if __name__ == "__main__":
    main()
