# SPDX-License-Identifier: MIT
"""Cost of an iteration in layered ground beside homogeneous ground on the same mesh: `make bench SECTION=layers`.

    python -m benchmarks.layered_cost [--pairs N] [--preset coarse] [--out FILE]

The paper's caisson is pulled to 1 mm, in pairs of runs that take turns. Layers begin at lines of the homogeneous mesh,
so that both meshes are equal; each layer has E, linear in depth, and friction angle of its own. The cost is CPU time of
the increments (without set-up, compilation, files) over Newton iterations. Prints CSV: iterations and CPU milliseconds
an iteration of both, median of the ratios of the pairs, and the smallest and largest.
"""

from __future__ import annotations

import argparse
import csv
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fe_engine.clock import Clock
from fe_engine.solve.stepping import Driver
from fe_engine.state import State
from pysprings import Scene
from pysprings.core.threads import blas_on_one_thread
from pysprings.full_model.discretise import make_engine
from pysprings.model.discretise import build
from pysprings.model.stages import path_stages
from pysprings.scene.extent import PAPER

HEAD = (
    "discretisation", "unknowns", "layers", "iterations", "iterations, layered", "ms an iteration",
    "ms an iteration, layered", "ratio", "least", "largest",
)  # fmt: skip
_YOUNG, _FRICTION = 200e6, np.radians(30.0)


def scenes(discretisation: str, preset: str) -> tuple[Scene, Scene]:
    """Return the homogeneous scene and one of layers on the same mesh."""
    path = {"name": "pull", "kind": "pull", "lateral_displacement": 1e-3}
    whole = Scene(domain=PAPER, paths=(path,), mesh={"discretisation": discretisation, "preset": preset})
    levels = np.unique(np.round(build(whole).model.mesh.nodes[:, -1], 12))
    tops = [0.0, *(float(z) for z in levels[2:-2:4])]  # ends of quadratic elements, too
    layers = [_layer(top, n % 2) for n, top in enumerate(tops)]
    return whole, whole.replace(soil={"layers": layers})


def _layer(top: float, odd: int) -> dict[str, Any]:
    factor = 1.1 if odd else 0.9
    young = {"top": factor * _YOUNG, "bottom": _YOUNG / factor}
    return {"top": top, "young_modulus": young, "friction_angle_final": factor * _FRICTION}


def cost(scene: Scene) -> tuple[float, int, int]:
    """Return CPU seconds of the increments, Newton iterations and unknowns of a run."""
    built = build(scene)
    engine = make_engine(scene, built, Clock())
    driver = Driver(engine.newton, State(built.model))
    begun = time.process_time()
    for stage in path_stages(scene, scene.paths[0], built.extra_load):
        driver.run(stage, lambda step: None)
    seconds = time.process_time() - begun
    engine.newton.close()
    return seconds, sum(row["iteration"] > 0 for row in driver.record), engine.system.pattern.n_unknowns


def compare(discretisation: str, preset: str, pairs: int) -> tuple[object, ...]:
    """Return the row of a discretisation."""
    both = scenes(discretisation, preset)
    nodes = [build(scene).model.mesh.nodes for scene in both]
    assert nodes[0].shape == nodes[1].shape and np.allclose(*nodes, rtol=0.0, atol=1e-9), (
        "the layered mesh is another one"
    )
    for scene in both:  # compiles
        cost(scene)
    each: list[list[float]] = [[], []]
    counts = [0, 0]
    unknowns = 0
    for pair in range(pairs):
        for k in (0, 1) if pair % 2 == 0 else (1, 0):
            seconds, counts[k], unknowns = cost(both[k])
            each[k].append(1e3 * seconds / counts[k])
    ratio = np.array(each[1]) / np.array(each[0])
    milliseconds = [f"{np.median(found):.1f}" for found in each]
    layers = len(both[1].soil.layers)
    ends = (f"{value:.3f}" for value in (np.median(ratio), ratio.min(), ratio.max()))
    return (discretisation, unknowns, layers, *counts, *milliseconds, *ends)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pairs", type=int, default=7)
    parser.add_argument("--preset", default="coarse")
    parser.add_argument("--out", type=Path)
    given = parser.parse_args(arguments)
    with blas_on_one_thread():
        table = [HEAD, *(compare(each, given.preset, given.pairs) for each in ("fourier", "hex8"))]
    csv.writer(sys.stdout, lineterminator="\n").writerows(table)
    if given.out:
        with given.out.open("w", newline="", encoding="utf-8") as stream:
            csv.writer(stream, lineterminator="\n").writerows(table)


if __name__ == "__main__":
    main()
