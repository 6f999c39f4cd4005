# SPDX-License-Identifier: MIT
"""Limits of bricks and of Fourier series beside each other: pulls of several caissons and grounds.

    python -m benchmarks.two_limits [--out FILE] [--runs FOLDER] [--ends MM ...] [--bricks FACTOR ...]
        [--series FACTOR ...] [--with-water NUMBER] CASE...

One run a mesh leads to the largest displacement; the curves up to each end are rows of their own. The meshes are those
of `mesh_changes.families`: sections refined alone, cells across the tip among them, by the factors given, and more
cells around (bricks) or harmonics (series) on the coarsest section. What each of these groups tends to is found from
its own meshes that reach the end: sections and cells around as in `pysprings accuracy` (the finest as it is where no
order can be fitted, or fewer than three do), harmonics from the highest. Where the lid lifts off in water, cells below
mudline are a third group: the water force depends on them more than on the rest of the section. The effects of the
groups are added up.

Prints a line of comma-separated values an end and measure: the largest difference of load and rotation up to the end
and the root mean square one of p(y), per cent of the largest value; the same at the end itself, where every run has a
state; of runs with water also, at the end, the load over that of the drained run on the same mesh, that ratio times the
drained limit, the water force under the lid and the largest difference of the pressure at five points; the aim, and
whether the values at the end meet it; what each limit is uncertain by up to the end, which is the sum of the distances
of the groups' limits from their finest meshes; and whether the limits differ by more than both uncertainties together.
Runs with water are those on the sections, the coarsest NUMBER of them, and below the lid. Runs in the folder are not
repeated.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from benchmarks.mesh_changes import BRICK_SECTIONS, SERIES_SECTIONS, Family, Limit, families, run, together
from pysprings import Scene
from pysprings.full_model.accuracy import measures
from pysprings.full_model.accuracy.curves import LOAD, OTHER, PY, Sample, curves_of, samples
from pysprings.scene.extent import PAPER

OVER_DRAINED, BY_DRAINED, WATER_FORCE, PRESSURES = (
    "load_over_drained", "load_by_drained", "water_force", "pore_pressures",
)  # fmt: skip
# Measure -> its words
WORDS = {
    "load_max": "load, %", "rotation_max": "rotation, %", "py_rms": "p-y rms, %",
    OVER_DRAINED: "load over the drained one, %", BY_DRAINED: "drained limit times that, %", WATER_FORCE: "F_pw, %",
    PRESSURES: "p at five points, kPa",
}  # fmt: skip
MEASURED, WATER = ("load_max", "rotation_max", "py_rms"), (OVER_DRAINED, BY_DRAINED, WATER_FORCE, PRESSURES)
HEAD = (
    "case", "to", "measure", "limits differ up to there by", "at it by", "aim", "met", "bricks uncertain by",
    "series uncertain by", "explained", "finest meshes",
)  # fmt: skip
DRY_AIMS = {"load_max": 0.5, "rotation_max": 0.5, "py_rms": 0.5}
GAP_AIMS = {"load_max": 1.0, "rotation_max": 1.0, "py_rms": 1.0}
WET_AIMS = {"load_max": 1.0, OVER_DRAINED: 1.0, BY_DRAINED: 1.0, WATER_FORCE: 5.0, PRESSURES: 0.3}
# Side, azimuth and depth (m) of the pressures that are compared
POINTS = (
    ("inside", 0.0, 0.25), ("inside", 0.0, 2.25), ("outside", np.pi, 2.25), ("outside", np.pi, 3.9),
    ("outside", 0.0, 3.25),
)  # fmt: skip


class Case(NamedTuple):
    """Ends of the pull (mm), sections of the scene, aims by measure, and the rate (mm/s) of a pull with water.

    ``viscous`` is solver.viscous_displacement in mm; ``lid``: whether the lid lifts off in water, so that cells below
    it are a group of their own.
    """

    ends: tuple[float, ...]
    sections: dict[str, Any]
    aims: Mapping[str, float] = DRY_AIMS
    rate: float | None = None
    viscous: float = 1e-5
    lid: bool = False


def _caisson(diameter: float, ratio: float) -> dict[str, Any]:
    length = ratio * diameter
    shape = {"outer_diameter": diameter, "skirt_length": length, "skirt_thickness": diameter / 78.0}
    return {"caisson": shape, "domain": {"radius": 3.1 * diameter, "depth": length + diameter}}


# With viscosity, runs get through sand that localises beside small cells, and with more of it through lift-off of the
# lid. 0.0001 mm changes loads up to 2.5 mm by 0.1 %, by more on some meshes than on others: no order survives that.
_PAPER, _MORE = {"domain": PAPER}, 1e-4
_NEAR, _FAR = (1.0, 2.5, 5.0), (20.0,)
CASES: dict[str, Case] = {
    "the paper's": Case(_NEAR, _PAPER),
    "the paper's, viscous": Case(_FAR, _PAPER, viscous=_MORE),
    "the paper's, 0.05 mm/s": Case(_NEAR, _PAPER, WET_AIMS, 0.05),
    "the paper's, 0.5 mm/s": Case(_NEAR, _PAPER, WET_AIMS, 0.5),
    "the paper's, 0.05 mm/s, viscous": Case(_FAR, _PAPER, WET_AIMS, 0.05, _MORE, lid=True),
    "the paper's, 0.5 mm/s, viscous": Case(_FAR, _PAPER, WET_AIMS, 0.5, _MORE, lid=True),
    "L/D 0.25, 12 m": Case((4.0,), _caisson(12.0, 0.25)),
    "L/D 1, 6 m": Case((2.5,), _caisson(6.0, 1.0)),
    "loose over dense sand": Case((2.5,), {"domain": PAPER, "soil": {"layer": [
        {"top": 0.0, "name": "loose", "friction_angle_final": 0.5236, "young_modulus": 60e6},
        {"top": 2.5, "name": "dense", "friction_angle_final": 0.6632, "young_modulus": 200e6},
    ]}}),
    "cohesion 15 kPa, gap": Case((2.5,), {"domain": PAPER, "soil": {
        "cohesion": 15e3, "K0": 0.6, "friction_angle_initial": "auto"}}, GAP_AIMS),
}  # fmt: skip


def scene_of(case: str, ends: Sequence[float] = (), drained: bool = False) -> Scene:
    """Return the scene of a case, pulled to the last of ``ends`` (mm; none: its own) with a state at each.

    ``drained``: without the water that the case may have.
    """
    own = CASES[case]
    *before, end = sorted(ends or own.ends)
    path = {"name": "pull", "kind": "pull", "lateral_displacement": 1e-3 * end, "report_at": [1e-3 * u for u in before]}
    wet: dict[str, Any] = {}
    if own.rate is not None and not drained:
        path |= {"rate": 1e-3 * own.rate}
        wet = {"drainage": {"mode": "coupled"}}
    return Scene(
        paths=(path,),
        output={"figures": False, "section": False},
        solver={"viscous_displacement": 1e-3 * own.viscous},
        **wet,
        **own.sections,
    )


@dataclass(frozen=True)
class Limits:
    """Limits of both discretisations up to one end, and the finest section that each rests on."""

    bricks: Limit
    series: Limit
    finest: tuple[str, str]

    def line(self, case: str, end: float, name: str) -> list[str]:
        """Return the line of a measure."""
        bricks, series = self.bricks.values, self.series.values
        apart, there = difference(name, bricks, series), difference(name, at_end(bricks), at_end(series))
        doubt = [doubt_of(name, each) for each in (self.bricks, self.series)]
        aim = CASES[case].aims.get(name)
        met = "" if aim is None else "yes" if there <= aim else "no"
        judged = ["" if name in WATER else f"{apart:.2f}", f"{there:.2f}", "" if aim is None else f"{aim:g}", met]
        explained = "yes" if apart <= sum(doubt) else "no"
        return [
            case,
            f"{end:g} mm",
            WORDS[name],
            *judged,
            *(f"{value:.2f}" for value in doubt),
            explained,
            "; ".join(self.finest),
        ]


def doubt_of(name: str, limit: Limit) -> float:
    """Return what a limit is uncertain by in a measure: the sum over its groups."""
    return sum(difference(name, limit.values, beside) for beside in limit.beside)


def at_end(sample: Sample) -> Sample:
    """Return the last point of the curves of a sample, where every run has a state; what is no curve stays."""
    return {key: values[..., -1:] if key in (LOAD, OTHER, PY) else values for key, values in sample.items()}


def difference(name: str, one: Sample, other: Sample) -> float:
    """Return by how much two samples differ in a measure: kPa of pressures, else per cent."""
    if name == PRESSURES:
        return 1e-3 * float(np.abs(one[name] - other[name]).max())
    if name == OVER_DRAINED:
        return 100.0 * float(np.abs(one[name] - other[name]).max())
    if name in (BY_DRAINED, WATER_FORCE):
        return 100.0 * float(np.abs((one[name] - other[name]) / one[name]).max())
    return measures.errors(other, one)[name]


def until(path: xr.Dataset, end: float) -> xr.Dataset:
    """Return the states of a path up to a displacement (mm) at which it has one."""
    return path.isel(step=path["u"].values <= 1e-3 * end * (1.0 + 1e-9))


def water_sample(path: xr.Dataset) -> Sample:
    """Return the water force (N) and the pressures at POINTS (Pa) in the last state of a path with water."""
    state = path.isel(step=-1)
    lines = [
        state["pore_pressure"].sel(side=side).sel(azimuth=azimuth, method="nearest") for side, azimuth, _ in POINTS
    ]
    pressures = [np.interp(depth, state["depth"], line) for line, (_, _, depth) in zip(lines, POINTS, strict=True)]
    return {WATER_FORCE: np.array([float(state["F_pw"])]), PRESSURES: np.array(pressures, dtype=float)}


def cut(trees: Mapping[str, xr.DataTree], end: float) -> dict[str, xr.DataTree]:
    """Return the runs that reach an end (mm), up to it."""
    reached = {}
    for name, tree in trees.items():
        path = until(tree["paths/pull"].to_dataset(), end)
        if path["u"].values[-1] > 1e-3 * end * (1.0 - 1e-9):
            reached[name] = tree.copy()
            reached[name]["paths/pull"] = xr.DataTree(path)
    return reached


def _samples(reached: Mapping[str, xr.DataTree], dry: Mapping[str, xr.DataTree]) -> dict[str, Sample]:
    """Return the samples of runs up to one end; with water where there are drained runs beside them."""
    each = samples({name: curves_of(tree) for name, tree in reached.items()})["pull"]
    for name, beside in dry.items():
        path = reached[name]["paths/pull"].to_dataset()
        ratio = float(path["H"][-1] / beside["paths/pull"]["H"][-1])
        each[name] = each[name] | water_sample(path) | {OVER_DRAINED: np.array([ratio])}
    return each


def limits(
    trees: Mapping[str, xr.DataTree], found: Mapping[str, Family], end: float,
    drained: Mapping[str, xr.DataTree] | None = None,
) -> Limits | None:  # fmt: skip
    """Return the limits up to an end (mm) from the runs (by the words of their mesh) that reach it; None without any.

    ``drained`` are the runs without water on the same meshes, and on others, of runs with water.
    """
    reached, dry = cut(trees, end), cut(drained or {}, end)
    if drained is not None:
        reached = {name: tree for name, tree in reached.items() if name in dry}
    reach = {kind: [c.words for c in family.sections if c.words in reached] for kind, family in found.items()}
    if not all(reach.values()):
        return None
    each = _samples(reached, {name: tree for name, tree in dry.items() if name in reached})
    tend = {kind: together(family, each) for kind, family in found.items()}
    if drained is not None:
        plain = _samples(dry, {})
        tend = {kind: with_drained(limit, together(found[kind], plain)) for kind, limit in tend.items()}
    return Limits(tend["bricks"], tend["series"], (reach["bricks"][-1], reach["series"][-1]))


def with_drained(limit: Limit, drained: Limit) -> Limit:
    """Return a limit with water together with that of its load at the end: the drained limit times the ratio of both.

    Cells of a size change both loads alike: the ratio is nearly the same on all meshes, and the drained limit may rest
    on finer ones, and on more cells around. What is beside it: each part beside its limit, the other at its own.
    """
    load, ratio = drained.values[LOAD][-1:], limit.values[OVER_DRAINED]
    beside = [each | {BY_DRAINED: load * each[OVER_DRAINED]} for each in limit.beside]
    beside += [limit.values | {BY_DRAINED: each[LOAD][-1:] * ratio} for each in drained.beside]
    return Limit(limit.values | {BY_DRAINED: load * ratio}, tuple(beside), limit.notes)


def rows(
    case: str, found: Mapping[str, Family], ends: Sequence[float] = (), folder: Path | None = None,
    with_water: int | None = None,
) -> list[list[str]]:  # fmt: skip
    """Run a case on all meshes; return its lines, those of the ends that both discretisations reach.

    Runs with water are those on the sections, the coarsest ``with_water`` of them (None: all), and below the lid.
    """
    wet, lines = CASES[case].rate is not None, []
    plain, scene = scene_of(case, ends, drained=True), scene_of(case, ends)
    drained = {c.words: run(f.mesh, c, plain, folder) for f in found.values() for c in f.changes}
    with_it = {c.words: (f, c) for f in found.values() for c in (*f.sections[:with_water], *f.lid) if wet}
    trees = {words: run(f.mesh, c, scene, folder) for words, (f, c) in with_it.items()}
    for end in sorted(ends or CASES[case].ends):
        tend = limits(trees, found, end, drained) if wet else limits(drained, found, end)
        if tend is not None:
            lines += [tend.line(case, end, name) for name in (*MEASURED, *(WATER if wet else ()))]
    return lines


def main() -> None:
    """Run the cases of the command line, all of them by default."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case", nargs="*", default=list(CASES))
    parser.add_argument("--out", type=Path)
    parser.add_argument("--runs", type=Path, help="folder in which runs are kept")
    parser.add_argument("--ends", type=float, nargs="+", default=(), help="of every pull, mm")
    parser.add_argument("--bricks", type=float, nargs="+", default=BRICK_SECTIONS, help="sections, coarse to fine")
    parser.add_argument("--series", type=float, nargs="+", default=SERIES_SECTIONS, help="sections, coarse to fine")
    parser.add_argument("--with-water", type=int, help="number of sections that runs with water use, the coarsest")
    given = parser.parse_args()
    lines = [list(HEAD)]
    screen = csv.writer(sys.stdout, lineterminator="\n")
    screen.writerow(HEAD)
    for case in given.case:
        found = families(given.bricks, given.series, CASES[case].lid)
        lines += (new := rows(case, found, given.ends, given.runs, given.with_water))
        screen.writerows(new)
        sys.stdout.flush()
        if given.out is not None:
            with given.out.open("w", newline="", encoding="utf-8") as stream:
                csv.writer(stream, lineterminator="\n").writerows(lines)


if __name__ == "__main__":
    main()
