# SPDX-License-Identifier: MIT
"""Paths through localised sand without and with `[solver] viscous_displacement`: how far, which loads, at which cost.

    python -m benchmarks.localised [--viscous "0.0001 mm"] [--alone] [--steps] [--out FILE] CASE...

CASE is NAME:PRESET:DISCRETISATION with a NAME of `pysprings paper` or of the catalogue of `pysprings stability`, or a
scene file, whose first path is run; ``--alone`` leaves out the run without viscosity; ``--steps`` adds one whose
largest step is smaller by a third. Prints a line of comma-separated values a case, which --out also adds to a file:
where the path ended (mm), by how much the load differs from that of the run without viscosity at the same states, over
the part that both went through (per cent), what the energy balance leaves, increments, attempts given up, CPU seconds.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

import numpy as np

from pysprings.core.units import read
from pysprings.full_model.compute import compute
from pysprings.scene.load import Scene, load_scene
from pysprings.studies.paper.cases import CASES as PAPER
from pysprings.studies.stability.cases import CASES as CATALOGUE

STOPS = (0.0125, 0.025, 0.05, 0.1, 0.125, 0.25, 0.5, 0.75)  # of the path, where loads are compared
STEP = 0.033  # of the path; 0.05 without this
COLUMNS = ("case", "run", "status", "reason", "end", "load", "difference", "differs most at", "energy", "increments",
           "given up", "cpu")  # fmt: skip


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


def rows(case: str, viscous: float, steps: bool, alone: bool = False) -> list[str]:
    """Run a case without (not if ``alone``) and with viscosity; return its lines."""
    scene = scene_of(case)
    changes: dict[str, dict[str, Any]] = {} if alone else {"without": {}}
    changes["with"] = {"viscous_displacement": viscous}
    if steps:
        changes["smaller steps"] = {"viscous_displacement": viscous, "max_step_fraction": STEP}
    done, lines = {name: run(scene.replace(solver=each)) for name, each in changes.items()}, []
    for name, each in done.items():
        other = done.get("with" if name == "smaller steps" else "without")
        differs, at = ("", "")
        if other is not None:
            percent, u = difference(each, other)
            differs, at = f"{percent:.3f}", f"{u:.4g}"
        values = (case, name, each["status"], each["reason"], f"{each['u'][-1]:.4g}", f"{each['H'][-1]:.6g}",
                  differs, at, f"{each['energy']:.1e}", each["increments"], each["given up"],
                  f"{each['cpu']:.1f}")  # fmt: skip
        lines.append(",".join(str(value) for value in values))
    return lines


def main() -> None:
    """Run the cases of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case", nargs="+")
    parser.add_argument("--viscous", default="0.0001 mm")
    parser.add_argument("--alone", action="store_true", help="no run without viscosity")
    parser.add_argument("--steps", action="store_true")
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    viscous = read(given.viscous, "m")
    print(",".join(COLUMNS))
    for case in given.case:
        for line in rows(case, viscous, given.steps, given.alone):
            print(line, flush=True)
            if given.out is not None:
                with given.out.open("a", encoding="utf-8") as file:
                    file.write(line + "\n")


if __name__ == "__main__":
    main()
