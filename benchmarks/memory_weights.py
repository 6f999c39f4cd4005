# SPDX-License-Identifier: MIT
"""Aims met by rays that turn back, and weight: ``python -m benchmarks.memory_weights DIR [--case NAME] [--store]``.

DIR has the springs of `benchmarks.memory`. Each caisson is calibrated on two or on three rays that turn back, with each
weight, and on four, the one at -40 degrees among them, which is otherwise held back. The table has how many of the
aims of `benchmarks.memory_aims` are met, and the errors above their limits added up [%], in all and by family.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from benchmarks.evidence_store import store, to_csv
from benchmarks.memory import is_clay, springs_of, stiffness_of
from benchmarks.memory_aims import FAMILIES, aims, met, over
from benchmarks.memory_paths import cases
from pysprings.core.path_kinds import MEMORY
from pysprings.macro.fan import FanTable
from pysprings.macro.memory.calibration import calibrate
from pysprings.macro.memory.model import MemoryModel
from pysprings.macro.memory.samples import samples
from pysprings.macro.model import MacroModel
from pysprings.springs.path import SpringPath
from pysprings.springs.springs import Springs

COMMAND = "python -m benchmarks.memory_weights DIR --store"
MIDDLE = "ray_minus_30_reversed"
FOURTH = "ray_minus_40_reversed"
# rays that turn back (without and with -30 degrees, and with -40 degrees), weight
CHOICES = ((2, 0.7), (3, 1.5), (3, 1.0), (3, 0.7), (3, 0.4), (4, 0.7))
HEADS = ["caisson", "rays", "weight", "aims met", "above the limits [%]", *FAMILIES]


def calibrated(springs: Springs, rays: int, weight: float) -> MacroModel:
    """Return springs with memory, calibrated on two to four rays that turn back, with this weight of them."""
    fan = MacroModel.from_springs(springs, "fan")
    table = fan.table
    assert isinstance(table, FanTable)
    if rays == 4:
        fourth = springs.paths[FOURTH]
        known = fourth.dataset.assign_attrs(role=MEMORY)
        others = [path for path in springs.paths.values() if path.name != FOURTH]
        springs = springs.with_paths([*others, SpringPath(FOURTH, known, springs.length)])
    ways = [way for way in samples(springs, table, weight) if rays > 2 or way.name != MIDDLE]
    memory = MemoryModel(calibrate(ways, table, stiffness_of(springs)), table)
    return replace(fan, memory=memory, spring_set="memory")


def rows_of(
    title: str, springs: Springs, clay: bool, choices: Sequence[tuple[int, float]] = CHOICES
) -> Iterator[list[str]]:
    """Yield a row a choice of rays and weight."""
    for rays, weight in choices:
        found = aims(springs, calibrated(springs, rays, weight), clay)
        parts = [[one for one in found if one.family == family] for family in FAMILIES]
        numbers = [f"{rays}", f"{weight:g}", met(found), f"{over(found):.1f}"]
        yield [title, *numbers, *(f"{met(part)}: {over(part):.1f}" for part in parts)]


def main() -> None:
    """Read the options, print the table, store it as evidence."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="folder of the springs")
    parser.add_argument("--case", choices=list(cases()), action="append", help="only this caisson")
    parser.add_argument("--store", action="store_true", help="store the table as evidence")
    given = parser.parse_args()
    table = [HEADS]
    for name in given.case or cases():
        case = cases()[name]
        for row in rows_of(case.title, springs_of(case, given.folder), is_clay(case)):
            print(row, flush=True)
            table.append(row)
    if given.store:
        for path in store("memory-weights", {"memory-weights": to_csv(table)}, COMMAND, "Mesh `coarse`, 5 harmonics."):
            print(path)


if __name__ == "__main__":
    main()
