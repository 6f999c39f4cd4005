# SPDX-License-Identifier: MIT
"""What water costs: the same push on the same mesh, drained and coupled, one after the other.

    python -m benchmarks.water_cost [--mesh medium] [--end-mm 2.5]

Ratios of one run are what to read: seconds depend on the machine and on what else it does.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from pysprings import Scene
from pysprings.full_model.compute import compute
from pysprings.scene.extent import PAPER

PHASES = ("assembly", "factorisation", "solve")


def record(mode: str, preset: str, end: float) -> dict[str, Any]:
    """Return the run.json of a pull to ``end`` (m) at the paper's rate."""
    path = {"name": "pull", "kind": "pull", "lateral_displacement": end, "rate": 0.05e-3}
    scene = Scene(
        domain=PAPER,
        mesh={"preset": preset, "discretisation": "hex8"},
        drainage={"mode": mode},
        paths=[path],
        output={"figures": False},
    )
    return compute(scene).record.as_dict()


def figures(run: dict[str, Any]) -> dict[str, float]:
    """Return what is compared."""
    path, solver = run["paths"]["pull"], run["solver"]
    counts = {
        "unknowns": run["mesh"]["unknowns"],
        "increments": path["increments"],
        "factorisations": solver["factorisations"],
        "wall [s]": run["wall_s"],
        "CPU [s]": run["cpu_s"],
    }
    return counts | {f"{name}, CPU [s]": run["phases"][name]["cpu_s"] for name in PHASES}


def main(arguments: Sequence[str] | None = None) -> None:
    """Run both and print them beside each other."""
    parser = argparse.ArgumentParser("python -m benchmarks.water_cost", description="What water costs.")
    parser.add_argument("--mesh", default="medium", choices=("coarse", "medium", "paper"))
    parser.add_argument("--end-mm", type=float, default=2.5)
    options = parser.parse_args(arguments)
    record("coupled", "coarse", 0.02e-3)  # compiles, so that neither run pays for it
    dry, wet = (figures(record(mode, options.mesh, 1e-3 * options.end_mm)) for mode in ("drained", "coupled"))
    print(f"{options.mesh}, to {options.end_mm:g} mm: drained, coupled, ratio")
    for name, value in dry.items():
        print(f"{name:22} {value:10.5g} {wet[name]:10.5g} {wet[name] / value:8.2f}")


if __name__ == "__main__":
    main()
