# SPDX-License-Identifier: MIT
"""Paths through localised sand without and with `[solver] viscous_displacement`: how far, which loads, at which cost.

    python -m benchmarks.localised [--viscous LENGTH ...] [--alone] [--steps] [--out FILE] CASE...

CASE is NAME:PRESET:DISCRETISATION with a NAME of `pysprings paper` or of the catalogue of `pysprings stability`, or a
scene file, whose first path is run; ``--alone`` leaves out the run without viscosity; ``--steps`` adds one whose
largest step is smaller by a third. Each LENGTH ("0.0001 mm" where none is given) has runs of its own. Prints a line of
comma-separated values a run, which --out also adds to a file: where the path ended (mm), by how much the load differs
at the same states, over the part that both went through (per cent), from that of the run without viscosity, or of
smaller steps from that of the run with it, what the energy balance leaves, increments, attempts given up, CPU seconds.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pysprings.core.units import read
from pysprings.full_model.compute import compute
from pysprings.scene.load import Scene, load_scene
from pysprings.studies.paper.cases import CASES as PAPER
from pysprings.studies.stability.cases import CASES as CATALOGUE

STOPS = (0.0125, 0.025, 0.05, 0.1, 0.125, 0.25, 0.5, 0.75)  # of the path, where loads are compared
SMALLER = {"max_step_fraction": 0.033}  # of the path; 0.05 without this
COLUMNS = ("case", "run", "length", "status", "reason", "end", "load", "difference", "differs most at", "energy",
           "increments", "given up", "cpu")  # fmt: skip


def scene_of(case: str) -> Scene:
    """Return the scene of a case with its first path alone, which has stops, and without pictures."""
    if Path(case).suffix == ".toml":
        scene = load_scene(Path(case))
    else:
        name, preset, discretisation = case.split(":")
        known = {each.name: each for each in (*CATALOGUE, *PAPER)}
        scene = known[name].scene(preset).replace(mesh={"discretisation": discretisation})
    path = scene.load_paths[0].model_dump(exclude_none=True)
    end = path["lateral_displacement"]
    path["report_at"] = sorted({*(share * end for share in STOPS), *path["report_at"]})
    output = {"figures": False, "section": False, "interface_fields": False}
    return scene.replace(paths=[path], output=output)


def run(scene: Scene) -> dict[str, Any]:
    """Run a scene: u (n,) mm and H (n,) kN of the states of its path, how it ended, and its cost."""
    begun = time.process_time()
    result = compute(scene)
    name = scene.paths[0].name
    path, figures = result.recorded()[f"paths/{name}"], result.record.paths[name]
    return {
        "u": 1e3 * path["u"].values, "H": 1e-3 * path["H"].values, "status": str(figures.status),
        "reason": str(figures.reason or ""), "energy": figures.energy["imbalance_over_largest_term"],
        "increments": figures.increments, "given up": figures.cut_backs, "cpu": time.process_time() - begun,
    }  # fmt: skip


def difference(own: dict[str, Any], other: dict[str, Any]) -> tuple[float, float]:
    """Return the largest difference of H, per cent, at displacements that both ended a step at, and where (mm)."""
    shared = [(i, int(np.argmin(np.abs(other["u"] - u)))) for i, u in enumerate(own["u"]) if u != 0.0]
    shared = [(i, j) for i, j in shared if abs(own["u"][i] - other["u"][j]) < 1e-9 * abs(own["u"][i])]
    if not shared:
        return float("nan"), float("nan")
    found = [(100.0 * (own["H"][i] / other["H"][j] - 1.0), float(own["u"][i])) for i, j in shared]
    return max(found, key=lambda pair: abs(pair[0]))


def rows(case: str, lengths: Sequence[str], steps: bool, alone: bool = False) -> Iterator[list[str]]:
    """Run a case without viscosity (not if ``alone``) and with that of each length; yield its lines."""
    scene = scene_of(case)
    plain = None if alone else run(scene)
    if plain is not None:
        yield line(case, "without", "", plain, plain)
    for length in lengths:
        viscous = {"viscous_displacement": read(length, "m")}
        relaxed = run(scene.replace(solver=viscous))
        yield line(case, "with", length, relaxed, plain)
        if steps:
            yield line(case, "smaller steps", length, run(scene.replace(solver=viscous | SMALLER)), relaxed)


def line(case: str, name: str, length: str, own: dict[str, Any], other: dict[str, Any] | None) -> list[str]:
    """Return the line of a run beside another one (None: there is none)."""
    differs, at = ("", "")
    if other is not None:
        percent, u = difference(own, other)
        differs, at = f"{percent:.3f}", f"{u:.4g}"
    counts = (own["increments"], own["given up"])
    return [case, name, length, own["status"], own["reason"], f"{own['u'][-1]:.4g}", f"{own['H'][-1]:.6g}",
            differs, at, f"{own['energy']:.1e}", *map(str, counts), f"{own['cpu']:.1f}"]  # fmt: skip


def main() -> None:
    """Run the cases of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case", nargs="+")
    parser.add_argument("--viscous", nargs="+", default=["0.0001 mm"], metavar="LENGTH")
    parser.add_argument("--alone", action="store_true", help="no run without viscosity")
    parser.add_argument("--steps", action="store_true")
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    print(",".join(COLUMNS))
    for case in given.case:
        for each in rows(case, given.viscous, given.steps, given.alone):
            print(",".join(each), flush=True)
            if given.out is not None:
                with given.out.open("a", encoding="utf-8") as file:
                    file.write(",".join(each) + "\n")


if __name__ == "__main__":
    main()
