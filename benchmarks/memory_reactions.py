# SPDX-License-Identifier: MIT
"""Reactions of springs with memory along sequences: ``python -m benchmarks.memory_reactions SPRINGS [--store NOTE]``.

SPRINGS is the spring file of a fan with rays that turn back and held-back sequences, as `benchmarks.memory` keeps them
(DIR/NAME.nc). One table has the errors of the reactions by family and of p by depth; the other one those of the
sequences with other weights of the rays that turn back in the calibration.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.evidence_store import store, to_csv
from benchmarks.memory import stiffness_of
from pysprings.macro.cycle_reactions import by_depth, reaction_errors
from pysprings.macro.cycles import errors, follow_path, sequences
from pysprings.macro.memory.calibration import calibrate
from pysprings.macro.memory.model import MemoryModel
from pysprings.macro.memory.samples import samples
from pysprings.macro.model import MacroModel
from pysprings.springs.alike import same_load
from pysprings.springs.file import open_springs
from pysprings.springs.path import SpringPath
from pysprings.springs.springs import Springs

COMMAND = "python -m benchmarks.memory_reactions SPRINGS --store"
WEIGHTS = (1.5, 0.8, 0.5)
_FAMILIES = ("p", "m", "t", "H_tip", "M_tip", "H_lid", "M_lid", "V_tip", "V_lid", "w")
_ANSWERS = ("u", "rotation", "H", "M")


def reactions(springs: Springs) -> Iterator[list[str]]:
    """Yield a row a sequence: errors [%] of p at each depth, and of each family of reactions."""
    for number, one in enumerate(sequences(springs, ("memory",))):
        depths = by_depth(one)
        if not number:
            yield ["path", "role", *(f"p at {z:.3g} m" for z in depths["depth_m"]), *_FAMILIES[1:]]
        row = reaction_errors(one)
        found = [*depths["p_error_pct"], *(row[f"{name}_error_pct"] for name in _FAMILIES[1:])]
        yield [one.path.name, one.path.role, *(f"{value:.3g}" for value in found)]


def weighed(springs: Springs, weights: tuple[float, ...] = WEIGHTS) -> Iterator[list[str]]:
    """Yield a row a path that turns back or is held back: errors [%] of what answers, by weight of turning rays."""
    model = MacroModel.from_springs(springs, "memory")
    assert model.memory is not None
    table = model.memory.table
    sets = [calibrate(samples(springs, table, weight), table, stiffness_of(springs)) for weight in weights]
    models = [MacroModel.from_springs(springs, "fan"), *(replace(model, memory=MemoryModel(e, table)) for e in sets)]
    yield ["path", "role", "answers", "fan", *(f"weight {weight:g}" for weight in weights)]
    for path in springs.paths.values():
        if path.role != "calibration" and not path.is_vertical and same_load(path.load, springs.rest_load):
            yield [path.name, path.role, *_errors(path, models)]


def _errors(path: SpringPath, models: list[MacroModel]) -> list[str]:
    found = [errors(follow_path(path, model)) for model in models]
    names = [name for name in _ANSWERS if np.isfinite(found[0][f"{name}_error_pct"])]
    return [" / ".join(names), *(" / ".join(f"{row[f'{name}_error_pct']:.3g}" for name in names) for row in found)]


def main() -> None:
    """Read the options, print both tables, store them as evidence."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("springs", type=Path, help="spring file with memory and held-back sequences")
    parser.add_argument("--store", metavar="NOTE", help="store the tables as evidence, with a note on the springs")
    given = parser.parse_args()
    springs = Springs.of(open_springs(given.springs)).at(V=None)
    tables = {"memory-reactions": to_csv([*reactions(springs)]), "memory-weights": to_csv([*weighed(springs)])}
    print(*tables.values(), sep="\n")
    if given.store:
        for path in store("memory-reactions", tables, COMMAND, given.store):
            print(path)


if __name__ == "__main__":
    main()
