# SPDX-License-Identifier: MIT
"""Load and cost of Fourier series beside bricks: the pull of the paper's caisson, presets by harmonics.

    python -m benchmarks.fourier [--end MM] [--rate MM_PER_S] [--tolerance T]
        [--series PRESET:N ...] [--bricks PRESET ...]

Drained, or coupled where a rate is given. One line a run: unknowns, increments, cut-backs, Newton and GMRES iterations,
load, rotation, heave, CPU seconds (without start, compilation, files and pictures). Runs share one process; the first
one compiles and is not shown.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

from fe_engine.clock import Clock
from fe_engine.errors import NotConverged
from fe_engine.solve.fourier_stage import FourierStage
from fe_engine.solve.stepping import Driver
from fe_engine.state import State
from pysprings import Scene
from pysprings.core.threads import blas_on_one_thread
from pysprings.full_model.discretise import make_engine
from pysprings.model.discretise import build
from pysprings.model.stages import path_stages
from pysprings.scene.extent import PAPER

SERIES = ("coarse:2", "coarse:3", "medium:2", "medium:3", "medium:5", "paper:3", "paper:5", "fine:5")  # preset:N
HEAD = "mesh             unknowns steps cuts Newton GMRES   u mm     H MN  rot mrad    w mm  CPU s"


def scene_of(end: float, tolerance: float, rate: float | None = None, **mesh: Any) -> Scene:
    """Return the paper's pull to ``end`` (m): coupled at a ``rate`` (m/s), or drained."""
    path: dict[str, Any] = {"name": "pull", "kind": "pull", "lateral_displacement": end}
    if rate is None:
        return Scene(domain=PAPER, paths=(path,), mesh=mesh, solver={"tolerance": tolerance})
    wet = path | {"rate": rate}
    return Scene(domain=PAPER, paths=(wet,), mesh=mesh, solver={"tolerance": tolerance}, drainage={"mode": "coupled"})


def line(scene: Scene) -> str:
    """Run a scene; return its line of the table."""
    start = time.process_time()
    built = build(scene)
    engine = make_engine(scene, built, Clock())
    driver, loads = Driver(engine.newton, State(built.model)), []
    try:
        for stage in path_stages(scene, scene.paths[0], built.extra_load):
            driver.run(stage, lambda step: loads.append(2e-6 * float(step.multipliers[0])))
    except NotConverged:
        pass  # the table shows how far it came
    seconds = time.process_time() - start
    newton = sum(row["iteration"] > 0 for row in driver.record)
    name, gmres = f"{scene.mesh.preset} bricks", 0
    if isinstance(engine.newton.stage, FourierStage):
        name, gmres = f"{scene.mesh.preset} N {scene.mesh.harmonics}", engine.newton.stage.n_iterations
    u, w, turn = (1e3 * float(value) for value in driver.state.committed.border)
    engine.newton.close()
    counts = f"{len(loads):>6}{driver.n_cut_backs:>5}{newton:>7}{gmres:>6}"
    motion = f"{u:>7.2f}{loads[-1]:>9.4f}{turn:>10.4f}{w:>8.3f}"
    return f"{name:<16}{engine.system.pattern.n_unknowns + 3:>9,}{counts}{motion}{seconds:>7.2f}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--end", type=float, default=2.5, help="lateral displacement, mm")
    parser.add_argument("--rate", type=float, help="rate of the pull, mm/s: with water")
    parser.add_argument("--tolerance", type=float, default=1e-3)
    parser.add_argument("--series", nargs="+", default=SERIES, help="presets with numbers of harmonics")
    parser.add_argument("--bricks", nargs="*", default=[], help="presets of bricks to run, too")
    given = parser.parse_args()
    rate = None if given.rate is None else 1e-3 * given.rate
    with blas_on_one_thread():
        line(scene_of(1e-4, given.tolerance, rate, discretisation="fourier"))
        print(HEAD)
        for name in given.series:
            preset, harmonics = name.split(":")
            mesh = {"discretisation": "fourier", "preset": preset, "harmonics": int(harmonics)}
            print(line(scene_of(1e-3 * given.end, given.tolerance, rate, **mesh)), flush=True)
        for preset in given.bricks:
            print(line(scene_of(1e-3 * given.end, 1e-5, rate, discretisation="hex8", preset=preset)), flush=True)


if __name__ == "__main__":
    main()
