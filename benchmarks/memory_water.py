# SPDX-License-Identifier: MIT
"""Springs with memory of runs with excess pressure: ``python -m benchmarks.memory_water DIR [--store]``.

The paper's caisson, coupled with rays, and rays that turn back, at two rates, and undrained. Held-back paths are at the
faster rate, between both, with rests, and monotonic. Each is followed by the springs at its rate: errors of what
answers, of the work, of p, and of the water's part of p. Springs are kept as DIR/coupled.nc and DIR/undrained.nc.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.evidence_store import store, to_csv
from benchmarks.memory import ANSWERS, errors_text, kept
from benchmarks.memory_paths import wet_scene
from pysprings.macro.cycle_reactions import reaction_errors
from pysprings.macro.cycles import SETS, errors, follow_path
from pysprings.macro.model import MacroModel
from pysprings.springs.springs import Springs

MODES = ("coupled", "undrained")
COMMAND = "python -m benchmarks.memory_water DIR --store"
HEAD = (
    "path", "rate [mm/s]", "states", "answers", "fan [%]", "memory [%]", "work, fan [%]", "work, memory [%]",
    "p, fan [%]", "p, memory [%]", "p_water, fan [%]", "p_water, memory [%]", "largest p_water over p [%]",
)  # fmt: skip


def compared(springs: Springs) -> Iterator[list[str]]:
    """Yield a row a held-back path: its rate, what is compared, then errors [%] of fan and memory."""
    for path in springs.paths.values():
        if path.role == "held-back":
            own = springs.answering(path)
            both = [follow_path(path, MacroModel.from_springs(own, name)) for name in SETS]
            found, reactions = [errors(one) for one in both], [reaction_errors(one) for one in both]
            names = [name for name in ANSWERS if np.isfinite(found[0][f"{name}_error_pct"])]
            rate = f"{1e3 * path.rate:.3g}" if path.rate and springs.rate_sets else "-"
            yield [
                path.name, rate, f"{path.n - 1}", " / ".join(names),
                *(errors_text(row, names) for row in found), *(f"{row['work_error_pct']:+.3g}" for row in found),
                *(f"{row[f'{name}_error_pct']:.3g}" for name in ("p", "p_water") for row in reactions),
                f"{100.0 * np.abs(path.water).max() / np.abs(path.p).max():.3g}",
            ]  # fmt: skip


def main() -> None:
    """Read the options, run, print the table, store it as evidence."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="folder of the springs")
    parser.add_argument("--store", action="store_true", help="store the table as evidence")
    given = parser.parse_args()
    tables = {}
    for mode in MODES:
        springs = kept(given.folder / f"{mode}.nc", wet_scene(mode))
        tables[f"memory-water-{mode}"] = to_csv([[*HEAD], *compared(springs)])
        print(tables[f"memory-water-{mode}"], flush=True)
    if given.store:
        for path in store("memory-water", tables, COMMAND, "Mesh `coarse`, 5 harmonics."):
            print(path)


if __name__ == "__main__":
    main()
