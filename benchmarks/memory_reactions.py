# SPDX-License-Identifier: MIT
"""Reactions of springs with memory along sequences: ``python -m benchmarks.memory_reactions SPRINGS [--store NOTE]``.

SPRINGS is the spring file of a fan with rays that turn back and held-back sequences, as `benchmarks.memory` keeps them
(DIR/NAME.nc). The table has the errors of the reactions by family, and of p by depth.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from benchmarks.evidence_store import store, to_csv
from pysprings.macro.cycle_reactions import by_depth, reaction_errors
from pysprings.macro.cycles import sequences
from pysprings.springs.file import open_springs
from pysprings.springs.springs import Springs

COMMAND = "python -m benchmarks.memory_reactions SPRINGS --store"
_FAMILIES = ("p", "m", "t", "H_tip", "M_tip", "H_lid", "M_lid", "V_tip", "V_lid", "w")


def reactions(springs: Springs) -> Iterator[list[str]]:
    """Yield a row a sequence: errors [%] of p at each depth, and of each family of reactions."""
    for number, one in enumerate(sequences(springs, ("memory",))):
        depths = by_depth(one)
        if not number:
            yield ["path", "role", *(f"p at {z:.3g} m" for z in depths["depth_m"]), *_FAMILIES[1:]]
        row = reaction_errors(one)
        found = [*depths["p_error_pct"], *(row[f"{name}_error_pct"] for name in _FAMILIES[1:])]
        yield [one.path.name, one.path.role, *(f"{value:.3g}" for value in found)]


def main() -> None:
    """Read the options, print the table, store it as evidence."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("springs", type=Path, help="spring file with memory and held-back sequences")
    parser.add_argument("--store", metavar="NOTE", help="store the table as evidence, with a note on the springs")
    given = parser.parse_args()
    springs = Springs.of(open_springs(given.springs)).at(V=None)
    tables = {"memory-reactions": to_csv([*reactions(springs)])}
    print(*tables.values())
    if given.store:
        for path in store("memory-reactions", tables, COMMAND, given.store):
            print(path)


if __name__ == "__main__":
    main()
