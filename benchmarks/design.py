# SPDX-License-Identifier: MIT
"""Time of many load cases on the springs of a run: ``python -m benchmarks.design RESULT [--cases 1000]``.

Loads of both signs and many directions, each case at a vertical load of its own, within the capacity and beyond it.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

from pysprings.cli.inputs import springs_of
from pysprings.macro.capacity import capacities
from pysprings.macro.model import MacroModel
from pysprings.results.tables.load_cases import LoadCases
from pysprings.studies.design.answers import answer_cases


def cases_of(model: MacroModel, count: int) -> LoadCases:
    """Return cases in random directions with utilisations from 0 to 1.2."""
    random = np.random.default_rng(1)
    angle = random.uniform(-np.pi, np.pi, count)
    largest = capacities(model, np.stack([np.cos(angle), model.length * np.sin(angle)], axis=1))
    share, none = random.uniform(0.0, 1.2, count), np.full(count, np.nan)
    V = model.rest_load * random.uniform(0.9, 1.1, count)
    names = tuple(f"case {k}" for k in range(count))
    line = np.arange(count, dtype=np.int64)
    return LoadCases(
        "",
        names,
        ("ULS",) * count,
        line,
        share * largest.H,
        share * largest.M,
        V,
        0.0 * share,
        none,
        0.0 * share,
        0.0 * share,
        ("",) * count,
    )


def main() -> None:
    """Print the seconds and the counts of the verdicts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("result", type=Path)
    parser.add_argument("--cases", type=int, default=1000)
    given = parser.parse_args()
    springs = springs_of(given.result)
    cases = cases_of(MacroModel.from_springs(springs), given.cases)
    answer_cases(springs, cases_of(MacroModel.from_springs(springs), 2))  # compiled loops
    wall, cpu = time.perf_counter(), time.process_time()
    table = answer_cases(springs, cases, tilt=0.01)
    print(f"{len(table):,} cases: {time.perf_counter() - wall:.2f} s, CPU {time.process_time() - cpu:.2f} s")
    print(table["verdict"].value_counts().to_string())


if __name__ == "__main__":
    main()
