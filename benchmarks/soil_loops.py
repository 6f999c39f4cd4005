# SPDX-License-Identifier: MIT
"""Loops of a caisson in isotropic and in kinematic soil laws: ``python -m benchmarks.soil_loops [--store]``.

Two caissons of `benchmarks.memory_paths` on `coarse`, each in two laws that have the same curve of first loading, are
pulled one diameter above mudline in cycles of growing amplitude, two of each. What counts is the last full cycle of an
amplitude, from its second to its last turn.
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from benchmarks.evidence_store import store, to_csv
from benchmarks.memory_paths import iwan_clay, iwan_sand
from pysprings.full_model.compute import run
from pysprings.scene.load import Scene

COMMAND = "python -m benchmarks.soil_loops --store"
AMPLITUDES = (0.1, 0.25, 0.5, 1.0, 2.0)  # mm over 1,000 times the factor of a case
CASES = (
    ("sand", "drucker-prager", iwan_sand, 2e-3), ("sand", "iwan-sand", iwan_sand, 2e-3),
    ("clay", "von-mises", iwan_clay, 10e-3), ("clay", "iwan-clay", iwan_clay, 10e-3),
)  # fmt: skip
HEADS = [
    "soil", "law", "amplitude [mm]", "H of the first turn [MN]", "H of the last turn [MN]", "secant [MN/m]",
    "damping ratio", "heave [mm]",
]  # fmt: skip


def scene_of(base: Scene, size: float) -> Scene:
    """Return the scene with cycles of growing amplitude, in m for a factor of 1."""
    D = base.caisson.outer_diameter
    ends = [sign * share * size for share in AMPLITUDES for sign in (1.0, -1.0, 1.0, -1.0)]
    path = {"name": "growing", "kind": "pull", "arm": D, "lateral_displacement": ends[0], "role": "held-back"}
    data = base.model_dump() | {"paths": [path | {"then": [(x, None, None) for x in ends[1:]]}]}
    data["mesh"] = data["mesh"] | {"preset": "coarse", "harmonics": 5}
    data["output"] = data["output"] | {"interface_fields": False, "section": False, "figures": False}
    return Scene.model_validate(data)


def rows(soil: str, law: str, base: Scene, size: float) -> list[list[str]]:
    """Return a row an amplitude that the path reached."""
    data: Any = run(scene_of(base, size), estimate_error=False)["paths/growing"].to_dataset()
    u, H, w = (data[name].values for name in ("u", "H", "w"))
    turning = data["rotation"].values
    M = data["M"].values
    turns = [0, *(np.flatnonzero(np.diff(np.sign(np.diff(u)))) + 1), len(u) - 1]
    out = []
    for number, share in enumerate(AMPLITUDES):
        at = turns[1 + 4 * number : 5 + 4 * number]
        if len(at) < 4:
            break
        part = slice(at[1], at[3] + 1)
        work = float(np.trapezoid(H[part], u[part]) + np.trapezoid(M[part], turning[part]))
        last = at[2], at[3]
        dH, dM, du, dr = (float(values[last[0]] - values[last[1]]) for values in (H, M, u, turning))
        out.append([
            soil, law, f"{1e3 * share * size:.3g}", f"{1e-6 * H[at[0]]:.4g}", f"{1e-6 * H[at[2]]:.4g}",
            f"{1e-6 * dH / du:.4g}", f"{2.0 * work / (np.pi * (dH * du + dM * dr)):.3f}",
            f"{-1e3 * (w[at[3]] - w[0]):.2f}",
        ])  # fmt: skip
    return out


def main() -> None:
    """Read the options, run the laws, print the table, store it as evidence."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--store", action="store_true", help="store the table as evidence")
    given = parser.parse_args()
    table = [HEADS]
    for soil, law, base, size in CASES:
        table += rows(soil, law, base(law), size)
        print(table[-1], flush=True)
    print(to_csv(table))
    if given.store:
        for path in store("soil-loops", {"soil-loops": to_csv(table)}, COMMAND, "Mesh `coarse`, 5 harmonics."):
            print(path)


if __name__ == "__main__":
    main()
