# SPDX-License-Identifier: MIT
"""Limits of bricks and of Fourier series beside each other: pulls of several caissons and grounds, drained.

    python -m benchmarks.two_limits [--out FILE] [--end MM] [--bricks MESH ...] [--series MESH ...] CASE...

Each limit is extrapolated from its meshes as in `pysprings accuracy` (the finest as it is where no order can be
fitted). Prints a line of comma-separated values a case: the largest difference of load and rotation over the path and
the root mean square one of p(y), per cent of the largest value; what each limit is uncertain by, which is its distance
from the finest mesh; and whether the limits differ by more than both uncertainties together.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pysprings import Scene
from pysprings.full_model.accuracy import measures
from pysprings.full_model.accuracy.curves import Sample, curves_of, samples
from pysprings.full_model.accuracy.richardson import Reference, cell_size
from pysprings.full_model.accuracy.settings import read_mesh
from pysprings.full_model.compute import compute
from pysprings.scene.extent import PAPER

BRICKS, SERIES = (
    ("medium:0.7", "medium", "medium:1.4"),
    ("fourier-coarse@5", "fourier-coarse:2@5", "fourier-coarse:3@5"),
)
MEASURES = ("load_max", "rotation_max", "py_rms")
HEAD = ("case", "to", "measure", "limits differ by %", "bricks uncertain by %", "series uncertain by %", "explained")


def _caisson(diameter: float, ratio: float) -> dict[str, Any]:
    length = ratio * diameter
    shape = {"outer_diameter": diameter, "skirt_length": length, "skirt_thickness": diameter / 78.0}
    return {"caisson": shape, "domain": {"radius": 3.1 * diameter, "depth": length + diameter}}


# Name -> (end of the pull, mm; sections of the scene)
CASES: dict[str, tuple[float, dict[str, Any]]] = {
    "the paper's": (2.5, {"domain": PAPER}),
    "L/D 0.25, 12 m": (4.0, _caisson(12.0, 0.25)),
    "L/D 1, 6 m": (2.5, _caisson(6.0, 1.0)),
    "loose over dense sand": (2.5, {"domain": PAPER, "soil": {"layer": [
        {"top": 0.0, "name": "loose", "friction_angle_final": 0.5236, "young_modulus": 60e6},
        {"top": 2.5, "name": "dense", "friction_angle_final": 0.6632, "young_modulus": 200e6},
    ]}}),
    "cohesion 15 kPa, gap": (2.5, {"domain": PAPER, "soil": {
        "cohesion": 15e3, "K0": 0.6, "friction_angle_initial": "auto"}}),
}  # fmt: skip


def scene_of(case: str, end: float | None) -> Scene:
    """Return the scene of a case, pulled to ``end`` (mm) or to its own."""
    usual, sections = CASES[case]
    path = {"name": "pull", "kind": "pull", "lateral_displacement": 1e-3 * (end or usual)}
    output = {"figures": False, "section": False}
    return Scene(paths=(path,), output=output, **sections)


def limit(each: dict[str, Sample], names: Sequence[str], sizes: Sequence[float]) -> dict[str, Reference]:
    """Return the limit of each quantity from samples on ever finer meshes."""
    return measures.reference_of([each[name] for name in names], sizes)


def rows(case: str, meshes: dict[str, Sequence[str]], end: float | None) -> list[list[str]]:
    """Run a case on all meshes; return its lines."""
    scene = scene_of(case, end)
    trees = {
        name: compute(read_mesh(name).scene(scene)).recorded() for family in meshes.values() for name in family
    }  # fmt: skip
    by_path = samples({name: curves_of(tree) for name, tree in trees.items()})["pull"]
    sizes = {name: cell_size(tree.attrs["n_unknowns"], tree.attrs.get("harmonics")) for name, tree in trees.items()}
    limits = {kind: limit(by_path, family, [sizes[name] for name in family]) for kind, family in meshes.items()}
    values = {kind: {name: each.values for name, each in found.items()} for kind, found in limits.items()}
    apart = measures.errors(values["bricks"], values["series"])
    doubt = {kind: measures.uncertainty(found) for kind, found in limits.items()}
    last = f"{1e3 * scene.paths[0].lateral_displacement:g} mm"  # type: ignore[operator]
    lines = []
    for name in MEASURES:
        bricks, series = doubt["bricks"][name], doubt["series"][name]
        explained = "yes" if apart[name] <= bricks + series else "no"
        lines.append([case, last, name, *(f"{value:.2f}" for value in (apart[name], bricks, series)), explained])
    return lines


def main() -> None:
    """Run the cases of the command line, all of them by default."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case", nargs="*", default=list(CASES))
    parser.add_argument("--out", type=Path)
    parser.add_argument("--end", type=float, help="of every pull, mm")
    parser.add_argument("--bricks", nargs="+", default=BRICKS)
    parser.add_argument("--series", nargs="+", default=SERIES)
    given = parser.parse_args()
    lines = [list(HEAD)]
    print(",".join(f'"{cell}"' for cell in HEAD))
    for case in given.case:
        lines += (found := rows(case, {"bricks": given.bricks, "series": given.series}, given.end))
        for line in found:
            print(",".join(f'"{cell}"' for cell in line), flush=True)
        if given.out is not None:
            text = [",".join(f'"{cell}"' for cell in line) for line in lines]
            given.out.write_text("\n".join(text) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
