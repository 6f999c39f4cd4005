# SPDX-License-Identifier: MIT
"""Cost and memory against unknowns, and error against harmonics, of Fourier series: the paper's drained pull.

    python -m benchmarks.fourier_growth growth [--end MM] [--out FILE] MESH...
    python -m benchmarks.fourier_growth harmonics [--mesh PRESET] [--out FILE]

MESH is PRESET[:FACTOR]:DISCRETISATION, series with N = 3; each runs in a process of its own, after a tiny run that
loads compiled code. `growth` prints a line of comma-separated values a mesh: CPU seconds of set-up and steps (without
start, compilation, files and pictures), peak memory, and the exponent of the CPU time between a mesh and the one before
it of the same discretisation. `harmonics` prints load, rotation, heave, p-y and peak contact pressure of N = 2 to 8 as
differences (per cent) from N = 10, at 1 mm, where the wall is closed (friction, surcharge 100 kPa), and at 20 mm, where
gap and lid are open.
"""

from __future__ import annotations

import argparse
import csv
import math
import multiprocessing
import time
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from pysprings import Scene
from pysprings.full_model.compute import compute
from pysprings.scene.extent import PAPER

GROWTH = ("discretisation", "mesh", "unknowns", "increments", "CPU s", "exponent", "memory GB")
HARMONICS = ("case", "N", "load %", "rotation %", "heave %", "p-y rms %", "peak pressure %")
FINEST = 10
CASES: dict[str, tuple[float, dict[str, Any]]] = {
    "closed, 1 mm": (1e-3, {"soil": {"surcharge": 1e5}}),
    "gap, 2.5 mm": (2.5e-3, {}),
    "gap and lift-off, 20 mm": (20e-3, {}),
}
_TINY: dict[str, Any] = {"preset": "coarse", "refinement": 0.5}


def scene_of(end: float, mesh: dict[str, Any], **sections: Any) -> Scene:
    """Return the paper's pull to ``end`` (m) on a mesh."""
    path = {"name": "pull", "kind": "pull", "lateral_displacement": end}
    output = {"figures": False, "section": False}
    return Scene(domain=PAPER, paths=(path,), mesh=mesh, output=output, **sections)


def mesh_of(name: str) -> dict[str, Any]:
    """Return the section [mesh] of PRESET[:FACTOR]:DISCRETISATION."""
    preset, *factor, discretisation = name.split(":")
    mesh: dict[str, Any] = {"preset": preset, "discretisation": discretisation}
    if factor:
        mesh["refinement"] = float(factor[0])
    return mesh | ({"harmonics": 3} if discretisation == "fourier" else {})


def measured(name: str, end: float) -> tuple[int, int, float, float]:
    """Run a mesh; return unknowns, increments, CPU s, and GB of peak memory of this process."""
    mesh = mesh_of(name)
    compute(scene_of(1e-4, mesh | _TINY))
    begun = time.process_time()
    record = compute(scene_of(end, mesh)).record
    cpu = time.process_time() - begun
    return record.mesh.unknowns, record.paths["pull"].increments, cpu, record.peak_memory_bytes / 1e9


def growth(meshes: list[str], end: float) -> list[list[str]]:
    """Measure meshes, each in a process of its own."""
    rows, last = [], dict[str, tuple[int, float]]()
    for name in meshes:
        with multiprocessing.get_context("spawn").Pool(1) as pool:
            unknowns, increments, cpu, memory = pool.apply(measured, (name, end))
        *mesh, kind = name.split(":")
        exponent = ""
        if kind in last:
            n, seconds = last[kind]
            exponent = f"{math.log(cpu / seconds) / math.log(unknowns / n):.2f}"
        last[kind] = unknowns, cpu
        word = "series" if kind == "fourier" else "bricks"
        rows.append([word, ":".join(mesh), str(unknowns), str(increments), f"{cpu:.3g}", exponent, f"{memory:.2f}"])
        print(",".join(rows[-1]), flush=True)
    return rows


def differences(path: xr.Dataset, finest: xr.Dataset) -> list[float]:
    """Return the differences (per cent) of a path from another one at their ends, in the order of `HARMONICS`."""
    a, b = path.isel(step=-1), finest.isel(step=-1)
    simple = [100.0 * float(a[name] / b[name] - 1.0) for name in ("H", "rotation", "w")]
    p, q = a["p"].values, b["p"].values
    rms = 100.0 * float(np.sqrt(np.mean((p - q) ** 2)) / np.abs(q).max())
    peak = 100.0 * float(a["normal_effective_stress"].max() / b["normal_effective_stress"].max() - 1.0)
    return [*simple, rms, peak]


def harmonics(preset: str) -> list[list[str]]:
    """Run the cases with 2 to 8 harmonics beside `FINEST`."""
    rows = []
    for case, (end, sections) in CASES.items():
        mesh = {"preset": preset, "discretisation": "fourier"}
        paths = {
            n: compute(scene_of(end, mesh | {"harmonics": n}, **sections)).recorded()["paths/pull"].to_dataset()
            for n in (FINEST, 2, 3, 4, 5, 6, 8)
        }
        for n, path in paths.items():
            if n != FINEST:
                found = differences(path, paths[FINEST])
                rows.append([case, str(n), *(f"{value:.2f}" for value in found)])
                print(",".join(rows[-1]), flush=True)
    return rows


def main() -> None:
    """Run what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("growth", "harmonics"))
    parser.add_argument("meshes", nargs="*", metavar="MESH")
    parser.add_argument("--end", type=float, default=1.0, help="lateral displacement, mm")
    parser.add_argument("--mesh", default="medium", help="preset of the harmonics")
    parser.add_argument("--out", type=Path)
    given = parser.parse_intermixed_args()
    head = GROWTH if given.what == "growth" else HARMONICS
    print(",".join(head))
    rows = growth(given.meshes, 1e-3 * given.end) if given.what == "growth" else harmonics(given.mesh)
    if given.out is not None:
        with given.out.open("w", newline="", encoding="utf-8") as stream:
            csv.writer(stream, lineterminator="\n").writerows([head, *rows])


if __name__ == "__main__":
    main()
