# SPDX-License-Identifier: MIT
"""Errors of springs on sequences that turn back: ``python -m benchmarks.memory DIR [--case NAME] [--store]``.

Five caissons (`benchmarks.memory_paths`) run their fans, rays that turn back, and sequences that are held back;
springs are kept as DIR/NAME.nc, so that a second call computes no full model (a run takes minutes). Three kinds of
springs follow the sequences as the full model was driven: the fan, which is nonlinear elastic; a Masing set, perfectly
plastic elements fitted to the rays and pulls of the fan, which is what monotonic data give; and the set "memory". Its
errors stand beside what is aimed at (`benchmarks.memory_aims`).
"""

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.memory_aims import FAMILIES, Aim, aims, met
from benchmarks.memory_paths import Case, cases, scene_of
from pysprings.full_model.compute import run
from pysprings.macro.cycles import errors, follow_path
from pysprings.macro.fan import FanTable, build_fan
from pysprings.macro.model import MacroModel
from pysprings.memory.build import with_memory
from pysprings.memory.calibration import calibrate
from pysprings.memory.model import MemorySprings
from pysprings.memory.offered import candidates
from pysprings.memory.shares import samples
from pysprings.springs.checks import extract_springs, open_springs, save_springs
from pysprings.springs.path import SpringPath
from pysprings.springs.springs import Springs
from tools.evidence_store import store, to_csv

COMMAND = "python -m benchmarks.memory DIR --store"
_PERFECT = 3  # column of the gain in the parameters of a candidate: 0 is perfectly plastic
ANSWERS = ("u", "rotation", "H", "M")


def springs_of(case: Case, folder: Path) -> Springs:
    """Return the springs of a case, from DIR/NAME.nc, or from a run of the full model that is kept there."""
    file = folder / f"{case.name}.nc"
    if not file.exists():
        folder.mkdir(parents=True, exist_ok=True)
        save_springs(with_memory(extract_springs(run(scene_of(case), estimate_error=False))), file)
    return Springs.of(open_springs(file)).at(V=None)


def masing(springs: Springs, table: FanTable) -> MemorySprings:
    """Return perfectly plastic elements that are fitted to the rays, and to pulls of the fan."""
    ways = [way for way in samples(springs, table) if not way.turns]
    every = candidates(max(float(np.hypot(*way.motions.T).max()) for way in ways if way.recorded))
    perfect = every.plastic[:, _PERFECT] == 0.0
    scale = np.array([1.0, springs.length])
    stiffness = springs.lateral_stiffness / scale / scale[:, None]  # (2, 2) for (u, rotation*L) [N/m]
    elements = calibrate(ways, table, stiffness, every.chosen(np.pad(perfect, (0, sum(map(len, every[1:]))))))
    return MemorySprings(table, springs.paths[table.path[0]], table.path, elements=elements)


def compared(springs: Springs) -> Iterator[dict[str, str]]:
    """Yield a row a held-back path: what is compared, then errors [%] and error of the work [%] of each springs."""
    fan, memory = (MacroModel.from_springs(springs, name) for name in ("fan", "memory"))
    kinds = {"fan": fan, "Masing": replace(memory, response=masing(springs, build_fan(springs))), "memory": memory}
    for path in springs.paths.values():
        if path.role != "calibration" and not path.is_vertical:
            found = {kind: errors(follow_path(path, model)) for kind, model in kinds.items()}
            names = [name for name in ANSWERS if np.isfinite(found["fan"][f"{name}_error_pct"])]
            row = {"path": path.name, "role": path.role, "states": f"{path.n - 1}", "answers": " / ".join(names)}
            for kind, each in found.items():
                row[f"{kind} [%]"] = " / ".join(_number(each[f"{name}_error_pct"], each) for name in names)
            row |= {f"work, {kind} [%]": _number(each["work_error_pct"], each, "+") for kind, each in found.items()}
            yield row | {"w at the end [mm], full / memory": _heave(path, memory)}


def _number(value: float, row: dict[str, Any], sign: str = "") -> str:
    return f"{value:{sign}.3g}" if row["answered"] else "no answer"


def _heave(path: SpringPath, memory: MacroModel) -> str:
    """Return w at the end [mm], of the full model and of the springs with memory."""
    motions = follow_path(path, memory).macro[0]
    assert isinstance(memory.response, MemorySprings)
    w = memory.response.reactions(motions)[list(memory.response.table.name).index("w")]
    last = len(motions) - 1
    return f"{1e3 * (path.w[last] - path.w[0]):.2f} / {1e3 * (w[-1] - path.w[0]):.2f}"


def aims_table(found: dict[str, list[Aim]]) -> list[list[str]]:
    """Return a row a family of aims: how many are met in each caisson, and the farthest one above its limit."""
    rows = [["aim", *found], ["all", *(met(one) for one in found.values())]]
    for family in FAMILIES:
        parts = [[one for one in each if one.family == family] for each in found.values()]
        rows.append([family, *(f"{met(part)}{_farthest(part)}" for part in parts)])
    return rows


def _farthest(part: list[Aim]) -> str:
    worst = max(part, key=lambda one: one.over)
    error = f"{worst.error:.3g}" if np.isfinite(worst.error) else "no answer"
    return "" if worst.met else f"; {worst.path}, {worst.quantity}: {error} for {worst.limit:g}"


def main() -> None:
    """Read the options, run, print the tables, store them as evidence."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="folder of the springs")
    parser.add_argument("--case", choices=list(cases()), action="append", help="only this caisson")
    parser.add_argument("--store", action="store_true", help="store the tables as evidence")
    given = parser.parse_args()
    tables, found = {}, dict[str, list[Aim]]()
    for name in given.case or cases():
        springs = springs_of(cases()[name], given.folder)
        tables[f"memory-{name}"] = pd.DataFrame(compared(springs)).to_csv(index=False, lineterminator="\n")
        # clay has aims of its own
        found[name] = aims(springs, MacroModel.from_springs(springs, "memory"), name.startswith("clay"))
        print(tables[f"memory-{name}"], flush=True)
    tables["memory-aims"] = to_csv(aims_table(found))
    print(tables["memory-aims"])
    if given.store:
        print(*store("memory", tables, COMMAND, "Mesh `coarse`, 5 harmonics."), sep="\n")


if __name__ == "__main__":
    main()
