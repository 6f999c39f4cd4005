# SPDX-License-Identifier: MIT
"""What bricks and Fourier series differ by: one setting of a mesh changed at a time, drained pulls of `two_limits`.

    python -m benchmarks.limit_causes [--case CASE] [--end MM] [--runs FOLDER] [--out FILE]

Prints a line of comma-separated values a change: load and rotation at the end and p(y) (root mean square over slices
and displacements, over the largest p) beside the same mesh without it, per cent, and its unknowns. Load and rotation
have a sign: positive is more than without the change.

Then what each mesh tends to with all changes: what the sizes of a group (section, cells around, cells across the tip,
harmonics) tend to is found from that group alone, by Richardson's extrapolation where an order can be fitted, else
from its finest member, and the effects of the groups are added up. The last line is by how much these limits of both
differ (load and rotation: the largest difference up to the end).
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

import xarray as xr

from benchmarks.kept_runs import result_of
from benchmarks.two_limits import CASES, scene_of
from pysprings import Scene
from pysprings.full_model.accuracy import measures
from pysprings.full_model.accuracy.curves import LOAD, OTHER, PY, Sample, curves_of, samples
from pysprings.full_model.accuracy.settings import read_mesh
from pysprings.model import fourier_mesh, mesh

UNCHANGED = "as it is"
HEAD = ("mesh", "change", "unknowns", "load %", "rotation %", "p-y rms %")
_PRESETS = {"bricks": mesh.PRESETS, "series": fourier_mesh.PRESETS}


class Change(NamedTuple):
    """What is changed of a mesh: keys of [mesh] and [solver] of the scene, counts of the preset.

    ``group`` and ``size`` (of cells; 1 without the change) are those of changes that a limit is found from.
    """

    words: str
    mesh: Mapping[str, Any] = {}
    solver: Mapping[str, Any] = {}
    counts: Mapping[str, Any] = {}
    group: str = ""
    size: float = 1.0


def _section(factor: float, **more: int) -> Change:
    words = f"section {factor:g} times as fine"
    return Change(words, {"refinement": factor} | more, group="section", size=1.0 / factor)


def _around(cells: int) -> Change:
    return Change(f"{cells} cells around", {"azimuth": cells}, group="around", size=12.0 / cells)


def _harmonics(number: int) -> Change:
    return Change(f"N {number}", {"harmonics": number}, group="harmonics", size=6.0 / (number + 1))


def _tip(cells: int) -> Change:
    return Change(f"{cells} cells across the tip", counts={"tip": cells}, group="tip", size=1.0 / cells)


# Mesh without a change -> its changes
BRICKS = "medium"
SERIES = "fourier-medium@5"
_STEPS = Change("steps of 2.5 %", solver={"max_step_fraction": 0.025})
CHANGES: dict[str, tuple[Change, ...]] = {
    BRICKS: (
        _section(0.7, azimuth=12), _section(1.4, azimuth=12), *map(_around, (8, 16, 24)), *map(_tip, (2, 4)), _STEPS,
    ),
    SERIES: (
        _section(0.7), _section(1.4), _section(2.0), *map(_harmonics, (3, 4, 6, 8, 10, 14)), _tip(2), _STEPS,
        Change("tolerance 1e-5", solver={"tolerance": 1e-5}),
    ),
}  # fmt: skip


@contextmanager
def counted(kind: str, preset: str, counts: Mapping[str, Any]) -> Iterator[None]:
    """Give a preset other counts while the context lasts."""
    changed: Any = replace(_PRESETS[kind][preset], **counts)
    with mock.patch.dict(_PRESETS[kind], {preset: changed}):
        yield


def run(name: str, change: Change, scene: Scene, folder: Path | None) -> xr.DataTree:
    """Return the result of a scene on a mesh with a change."""
    setting = read_mesh(name)
    base = setting.scene(scene)
    own = {"preset": setting.mesh, "refinement": setting.refinement, "discretisation": setting.discretisation,
           "harmonics": setting.harmonics} | dict(change.mesh)  # fmt: skip
    solver = {"tolerance": base.solver.tolerance} | dict(change.solver)
    changed = base.replace(mesh=own, solver=solver, title=change.words)  # runs are kept by what is in the scene
    with counted("bricks" if setting.discretisation == "hex8" else "series", setting.mesh, change.counts):
        return result_of(changed, folder)


def runs(
    changes: Mapping[str, Sequence[Change]], scene: Scene, folder: Path | None
) -> dict[str, dict[str, xr.DataTree]]:
    """Return the results by mesh and change, the unchanged one first."""
    return {
        name: {each.words: run(name, each, scene, folder) for each in (Change(UNCHANGED), *chosen)}
        for name, chosen in changes.items()
    }


def line(name: str, words: str, unknowns: str, sample: Sample, plain: Sample) -> list[str]:
    """Return the line of what differs from a mesh without a change."""
    signed = [100.0 * float(sample[key][-1] / plain[key][-1] - 1.0) for key in (LOAD, OTHER)]
    numbers = [*(f"{value:+.2f}" for value in signed), f"{measures.errors(sample, plain)['py_rms']:.2f}"]
    return [name, words, unknowns, *numbers]


def together(changes: Sequence[Change], each: Mapping[str, Sample]) -> tuple[Sample, str]:
    """Return what a mesh tends to with all groups of changes, and how each limit was found."""
    plain = each[UNCHANGED]
    limit = {key: plain[key].copy() for key in (LOAD, OTHER, PY)}
    notes = []
    for group in dict.fromkeys(change.group for change in changes if change.group):
        mine = sorted([Change(UNCHANGED), *(c for c in changes if c.group == group)], key=lambda c: -c.size)
        found = measures.reference_of([each[c.words] for c in mine], [c.size for c in mine])
        order = found[LOAD].order
        notes.append(f"{group} ({mine[-1].words if order is None else f'order {order:.1f}'})")
        for key in limit:
            limit[key] += found[key].values - plain[key]
    return limit, ", ".join(notes)


def study(changes: Mapping[str, Sequence[Change]], scene: Scene, folder: Path | None) -> list[list[str]]:
    """Return the lines of both discretisations, and by how much their limits differ."""
    trees = runs(changes, scene, folder)
    flat = {(name, words): curves_of(tree) for name, found in trees.items() for words, tree in found.items()}
    sampled = samples({f"{name} {words}": curves for (name, words), curves in flat.items()})["pull"]
    lines, limits = [], []
    for name, chosen in changes.items():
        each = {words: sampled[f"{name} {words}"] for words in trees[name]}
        plain = trees[name][UNCHANGED]["paths/pull"]
        at = f"{1e-3 * float(plain['H'][-1]):.1f} kN", f"{1e3 * float(plain['rotation'][-1]):.4f} mrad"
        unknowns = {words: str(tree.attrs["n_unknowns"]) for words, tree in trees[name].items()}
        lines.append([name, UNCHANGED, unknowns[UNCHANGED], *at, ""])
        lines += [line(name, c.words, unknowns[c.words], each[c.words], each[UNCHANGED]) for c in chosen]
        limit, notes = together(chosen, each)
        lines.append(line(name, f"limits together: {notes}", "", limit, each[UNCHANGED]))
        limits.append(limit)
    apart = measures.errors(*limits)
    names = ("load_max", "rotation_max", "py_rms")
    return [*lines, ["both", "limits together differ by", "", *(f"{apart[key]:.2f}" for key in names)]]


def main() -> None:
    """Run the changes of both discretisations."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--case", default="cohesion 15 kPa, gap", choices=CASES)
    parser.add_argument("--end", type=float, default=2.5, help="mm")
    parser.add_argument("--runs", type=Path, help="folder in which runs are kept")
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    table = [list(HEAD), *study(CHANGES, scene_of(given.case, (given.end,)), given.runs)]
    csv.writer(sys.stdout, lineterminator="\n").writerows(table)
    if given.out is not None:
        with given.out.open("w", newline="", encoding="utf-8") as stream:
            csv.writer(stream, lineterminator="\n").writerows(table)


if __name__ == "__main__":
    main()
