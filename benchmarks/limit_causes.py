# SPDX-License-Identifier: MIT
"""What bricks and Fourier series differ by: one setting of a mesh changed at a time, drained pulls of `two_limits`.

    python -m benchmarks.limit_causes [--case CASE] [--end MM] [--runs FOLDER] [--out FILE]

The meshes are those of `mesh_changes.families`. Prints a line of comma-separated values a change: load and rotation at
the end, p(y) (root mean square over slices and displacements, over the largest p) and the stiffness at rest, of elastic
soil with all contact closed, beside the mesh named first, per cent, and its unknowns. All but p(y) have a sign:
positive is more than without the change.

Then what each mesh tends to: the sections alone, and more cells around or harmonics alone, each group to its own limit,
their effects added up, as in `two_limits`. The last line is by how much these limits of both differ (load and rotation:
the largest difference up to the end).
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Mapping
from pathlib import Path

import xarray as xr

from benchmarks.mesh_changes import Change, Family, families, run, series, together
from benchmarks.two_limits import CASES, cut, scene_of
from pysprings import Scene
from pysprings.full_model.accuracy import measures
from pysprings.full_model.accuracy.curves import LOAD, OTHER, STIFFNESS, Sample, curves_of, samples
from pysprings.model import fourier_mesh, mesh

HEAD = ("beside", "change", "unknowns", "load %", "rotation %", "p-y rms %", "initial stiffness %")


def _also(base: Change, words: str, counts: Mapping[str, float] | None = None, **solver: float) -> Change:
    return base._replace(
        words=f"{base.words}, {words}", counts=dict(base.counts) | dict(counts or {}), solver=solver
    )  # fmt: skip


def _tip(base: Change, number: int) -> Change:
    """Return so many cells across the tip, whatever the section."""
    return _also(base, f"{number} across the tip", {"tip": number * base.size})


def changed_section(family: Family) -> Change:
    """Return the section that is changed: of bricks the second, whose tip has three cells."""
    return family.sections[1 if family.extrapolated else 0]


def changes_of(family: Family) -> list[Change]:
    """Return the changes of one section of a family, without those that its limit is found from."""
    base = changed_section(family)
    if family.extrapolated:
        size, coarse = base.size, mesh.PRESETS["medium"]
        wide = {"wall": coarse.wall / size, "toe": coarse.toe / size}
        return [
            *(_tip(base, n) for n in (1, 2, 6, 12)), _also(base, "cells beside wall and tip as in `medium`", wide),
            _also(base, "steps of 2.5 %", max_step_fraction=0.025),
        ]  # fmt: skip
    size, coarse = base.size, fourier_mesh.PRESETS["coarse"]
    half = {"wall": coarse.wall / 2.0, "toe": coarse.toe / 2.0}
    return [
        *(series(1.0 / size, n) for n in (3, 4, 6, 14)), *(_tip(base, n) for n in (1, 4)),
        _also(base, "cells beside wall and tip half as large", half),
        _also(base, "steps of 2.5 %", max_step_fraction=0.025), _also(base, "tolerance 1e-5", tolerance=1e-5),
    ]  # fmt: skip


def runs(found: Mapping[str, Family], scene: Scene, folder: Path | None) -> dict[str, dict[str, xr.DataTree]]:
    """Return the results by kind and words of the mesh."""
    return {
        kind: {c.words: run(family.mesh, c, scene, folder) for c in (*family.changes, *changes_of(family))}
        for kind, family in found.items()
    }


def line(beside: str, words: str, unknowns: str, sample: Sample, plain: Sample) -> list[str]:
    """Return the line of what differs from a mesh without a change."""
    load, turn, rest = (f"{100.0 * float(sample[k][-1] / plain[k][-1] - 1.0):+.2f}" for k in (LOAD, OTHER, STIFFNESS))
    return [beside, words, unknowns, load, turn, f"{measures.errors(sample, plain)['py_rms']:.2f}", rest]


def study(found: Mapping[str, Family], scene: Scene, end: float, folder: Path | None) -> list[list[str]]:
    """Return the lines of both discretisations up to an end (mm), and by how much their limits differ."""
    trees = {kind: cut(of_kind, end) for kind, of_kind in runs(found, scene, folder).items()}
    sampled = samples({words: curves_of(tree) for of_kind in trees.values() for words, tree in of_kind.items()})["pull"]
    lines, limits = [], []
    for kind, family in found.items():
        base, first = changed_section(family).words, family.sections[0].words
        plain = trees[kind][base]["paths/pull"]
        at = f"{1e-3 * float(plain['H'][-1]):.1f} kN", f"{1e3 * float(plain['rotation'][-1]):.4f} mrad"
        unknowns = {words: str(tree.attrs["n_unknowns"]) for words, tree in trees[kind].items()}
        rest = f"{1e-6 * float(sampled[base][STIFFNESS][0]):.1f} MN/m"
        lines.append([base, "as it is", unknowns[base], *at, "", rest])
        ring = {change.words for change in family.around}
        for words in trees[kind]:
            if words != base:
                beside = first if words in ring and words != first else base
                lines.append(line(beside, words, unknowns[words], sampled[words], sampled[beside]))
        limit = together(family, {words: sampled[words] for words in trees[kind]})
        lines.append(line(base, f"limits together: {'; '.join(limit.notes)}", "", limit.values, sampled[base]))
        limits.append(limit.values)
    apart = measures.errors(*limits)
    names = ("load_max", "rotation_max", "py_rms", "stiffness")
    return [*lines, ["both", "limits together differ by", "", *(f"{apart[key]:.2f}" for key in names)]]


def main() -> None:
    """Run the changes of both discretisations."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--case", default="cohesion 15 kPa, gap", choices=CASES)
    parser.add_argument("--end", type=float, default=2.5, help="mm")
    parser.add_argument("--runs", type=Path, help="folder in which runs are kept")
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    ends = [end for end in CASES[given.case].ends if end < given.end]
    table = [list(HEAD), *study(families(), scene_of(given.case, (*ends, given.end)), given.end, given.runs)]
    csv.writer(sys.stdout, lineterminator="\n").writerows(table)
    if given.out is not None:
        with given.out.open("w", newline="", encoding="utf-8") as stream:
            csv.writer(stream, lineterminator="\n").writerows(table)


if __name__ == "__main__":
    main()
