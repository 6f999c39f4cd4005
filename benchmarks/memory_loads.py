# SPDX-License-Identifier: MIT
"""Springs with memory under other vertical loads: ``python -m benchmarks.memory_loads DIR [--case NAME] [--store]``.

Two caissons of `benchmarks.memory` have rays, and rays that turn back, under a second, larger vertical load, and rays
on which the vertical load changes. Held-back sequences are under the larger load, under one between the two, and under
a load that changes on the way. Each is followed by the springs (elements of both loads with their shares), and by the
elements of the vertical load at rest alone, which do not follow V. Springs are kept as DIR/NAME-loads.nc.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.evidence_store import store, to_csv
from benchmarks.memory import ANSWERS, errors_text, kept
from benchmarks.memory_paths import LOADED, cases, loaded_scene
from pysprings.macro.cycles import Followed, errors, follow_path
from pysprings.macro.model import MacroModel
from pysprings.macro.predict import sequence
from pysprings.springs.springs import Springs

COMMAND = "python -m benchmarks.memory_loads DIR --store"
HEAD = (
    "path", "V [MN]", "states", "answers", "memory [%]", "elements at rest load [%]", "work, memory [%]",
    "work, elements at rest load [%]", "w at the end [mm], full / memory",
)  # fmt: skip


def springs_of(name: str, folder: Path) -> Springs:
    """Return the springs of a case, from DIR/NAME-loads.nc, or from a run of the full model that is kept there."""
    return kept(folder / f"{name}-loads.nc", loaded_scene(cases()[name]))


def compared(springs: Springs) -> Iterator[list[str]]:
    """Yield a row a held-back sequence: what is compared, errors [%] and errors of the work [%] of both."""
    for path in springs.paths.values():
        if path.role == "held-back":
            models = [MacroModel.from_springs(springs, "memory", V=path.load), still(springs)]
            both = [follow_path(path, model) for model in models]
            found = [errors(one) for one in both]
            names = [name for name in ANSWERS if np.isfinite(found[0][f"{name}_error_pct"])]
            loads = path.given_loads[np.append(True, np.diff(path.given_loads) != 0.0)]
            yield [
                path.name, f"{loads.min() / 1e6:.3g}" + (f" to {loads.max() / 1e6:.3g}" if len(loads) > 1 else ""),
                f"{path.n - 1}", " / ".join(names), *(errors_text(row, names) for row in found),
                *(f"{row['work_error_pct']:+.3g}" for row in found), _heave(both[0], models[0]),
            ]  # fmt: skip


def still(springs: Springs) -> MacroModel:
    """Return the elements at the vertical load at rest, which a V that changes does not change."""
    model = MacroModel.from_springs(springs, "memory")
    assert model.memory is not None
    return replace(model, memory=replace(model.memory, changing=None))


def _heave(one: Followed, model: MacroModel) -> str:
    """Return w at the end [mm] since the start, of the full model and of the springs under the recorded V."""
    path, motions = one.path, one.macro[0]
    assert one.V is not None
    answer = sequence(model, motions[1:], control="state", V=one.V[1:], extrapolate=True, strict=False)
    start = float(sequence(model, motions[:1], control="state", V=path.load)["w"][0])
    last = len(motions) - 1
    return f"{1e3 * (path.w[last] - path.w[0]):.2f} / {1e3 * (float(answer['w'][-1]) - start):.2f}"


def main() -> None:
    """Read the options, run, print the tables, store them as evidence."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="folder of the springs")
    parser.add_argument("--case", choices=list(LOADED), action="append", help="only this caisson")
    parser.add_argument("--store", action="store_true", help="store the tables as evidence")
    given = parser.parse_args()
    tables = {}
    for name in given.case or LOADED:
        tables[f"memory-loads-{name}"] = to_csv([[*HEAD], *compared(springs_of(name, given.folder))])
        print(tables[f"memory-loads-{name}"], flush=True)
    if given.store:
        for path in store("memory-loads", tables, COMMAND, "Mesh `coarse`, 5 harmonics."):
            print(path)


if __name__ == "__main__":
    main()
