# SPDX-License-Identifier: MIT
"""Errors of springs on sequences that turn back: ``python -m benchmarks.memory DIR [--case NAME] [--store]``.

Five caissons (`benchmarks.memory_paths`) run their fans, rays that turn back, and sequences that are held back;
springs are kept as DIR/NAME.nc, so that a second call computes no full model (a run takes minutes). Three kinds of
springs follow the sequences as the full model was driven: the fan, which is nonlinear elastic; a Masing set, perfectly
plastic elements fitted to the rays and pulls of the fan, which is what monotonic data give; and the set "memory". Its
errors stand beside what is aimed at (`benchmarks.memory_aims`).
"""

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.memory_aims import FAMILIES, Aim, aims, met
from benchmarks.memory_paths import Case, cases, scene_of
from pysprings import Scene
from pysprings.full_model.compute import run
from pysprings.macro.cycles import errors, follow_path
from pysprings.macro.fan import FanTable, build_fan
from pysprings.macro.model import MacroModel
from pysprings.memory.build import build_memory, with_memory
from pysprings.memory.calibration import calibrate
from pysprings.memory.elements import REVERSIBLE, STATES
from pysprings.memory.model import MemorySprings
from pysprings.memory.offered import candidates
from pysprings.memory.shares import samples
from pysprings.springs.checks import extract_springs, open_springs, save_springs
from pysprings.springs.path import SpringPath
from pysprings.springs.springs import Springs
from tools.evidence_store import store, to_csv

COMMAND = "python -m benchmarks.memory DIR --store"
STEPS = 100_000
_PERFECT = 3  # column of the gain in the parameters of a candidate: 0 is perfectly plastic
ANSWERS = ("u", "rotation", "H", "M")


def springs_of(case: Case, folder: Path) -> Springs:
    """Return the springs of a case, from DIR/NAME.nc, or from a run of the full model that is kept there."""
    return kept(folder / f"{case.name}.nc", scene_of(case)).at(V=None)


def kept(path: Path, scene: Scene) -> Springs:
    """Return the springs with memory of a file, which a run of the scene makes where there is none."""
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        save_springs(with_memory(extract_springs(run(scene, estimate_error=False))), path)
    return Springs.of(open_springs(path))


def masing(springs: Springs, table: FanTable) -> MemorySprings:
    """Return perfectly plastic elements that are fitted to the rays, and to pulls of the fan."""
    ways = [way for way in samples(springs, table) if not way.turns]
    reach = max(float(np.hypot(*way.motions.T).max()) for way in ways if way.recorded)
    every = candidates(reach)
    perfect = every.plastic[:, _PERFECT] == 0.0
    choice = every.chosen(np.pad(perfect, (0, sum(map(len, every[1:])))))
    elements = calibrate(ways, table, stiffness_of(springs), choice)
    return MemorySprings(table, springs.paths[table.path[0]], table.path, elements=elements)


def stiffness_of(springs: Springs) -> np.ndarray:
    """Return the initial stiffness (2, 2) for (u, rotation*L) [N/m]."""
    scale = np.array([1.0, springs.length])
    return springs.lateral_stiffness / scale / scale[:, None]


def compared(springs: Springs) -> Iterator[list[str]]:
    """Yield a row a held-back path: what is compared, then errors [%] and error of the work [%] of each springs."""
    fan, memory = (MacroModel.from_springs(springs, name) for name in ("fan", "memory"))
    kinds = {"fan": fan, "Masing": replace(memory, response=masing(springs, build_fan(springs))), "memory": memory}
    for path in springs.paths.values():
        if path.role != "calibration" and not path.is_vertical:
            found = {name: errors(follow_path(path, model)) for name, model in kinds.items()}
            names = [name for name in ANSWERS if np.isfinite(found["fan"][f"{name}_error_pct"])]
            yield [
                path.name, path.role, f"{path.n - 1}", " / ".join(names),
                *(errors_text(row, names) for row in found.values()),
                *(_number(row["work_error_pct"], row, "+") for row in found.values()),
                _heave(path, memory),
            ]  # fmt: skip


def errors_text(row: dict[str, Any], names: list[str]) -> str:
    """Return the errors [%] of the answers of a sequence."""
    return " / ".join(_number(row[f"{name}_error_pct"], row) for name in names)


def _number(value: float, row: dict[str, Any], sign: str = "") -> str:
    return f"{value:{sign}.3g}" if row["answered"] else "no answer"


def _heave(path: SpringPath, memory: MacroModel) -> str:
    """Return w at the end [mm], of the full model and of the springs with memory."""
    motions = follow_path(path, memory).macro[0]
    assert isinstance(memory.response, MemorySprings)
    w = memory.response.reactions(motions)[list(memory.response.table.name).index("w")]
    last = len(motions) - 1
    return f"{1e3 * (path.w[last] - path.w[0]):.2f} / {1e3 * (w[-1] - path.w[0]):.2f}"


def is_clay(case: Case) -> bool:
    """Return whether a case is of clay, which has aims of its own."""
    return case.name.startswith("clay")


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


def cost(springs: Springs) -> list[str]:
    """Return elements, numbers of the state, residual, seconds of the calibration and of 100,000 steps of loads."""
    model = build_memory(springs.at())
    ways = samples(springs, model.table)
    seconds = _seconds(lambda: calibrate(ways, model.table, stiffness_of(springs)))
    largest = abs(float(model.solve("state", np.array([[0.3 * model.elements.reach, 0.0]]))[1][0, 0]))
    t = np.linspace(0.0, 200.0 * np.pi, STEPS)
    loads = np.stack([0.3 * np.sin(t), 0.15 * np.sin(0.37 * t)], axis=1) * largest * [1.0, springs.length]
    model.solve("load", loads[:10])
    reached: list[int] = []
    steps = _seconds(lambda: reached.append(len(model.solve("load", loads)[0])))
    n = len(model.elements.rows)
    return [
        f"{n}",
        f"{STATES * int((model.elements.rows[:, 0] != REVERSIBLE).sum())}",
        f"{model.elements.residual:.4f}",
        f"{seconds:.1f}",
        f"{steps:.2f}",
        f"{reached[0]}",
    ]


def _seconds(call: Callable[[], Any]) -> float:
    start = time.process_time()
    call()
    return time.process_time() - start


HEADS = [
    "path", "role", "states", "answers", "fan [%]", "Masing [%]", "memory [%]",
    "work, fan [%]", "work, Masing [%]", "work, memory [%]", "w at the end [mm], full / memory",
]  # fmt: skip
COSTS = ["caisson", "elements", "numbers", "residual", "calibration [s]", "100,000 loads [s]", "loads answered"]


def main() -> None:
    """Read the options, run, print the tables, store them as evidence."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="folder of the springs")
    parser.add_argument("--case", choices=list(cases()), action="append", help="only this caisson")
    parser.add_argument("--store", action="store_true", help="store the tables as evidence")
    given = parser.parse_args()
    tables, costs, found = {}, [COSTS], dict[str, list[Aim]]()
    for name in given.case or cases():
        case = cases()[name]
        springs = springs_of(case, given.folder)
        tables[f"memory-{name}"] = to_csv([HEADS, *compared(springs)])
        found[name] = aims(springs, MacroModel.from_springs(springs, "memory"), is_clay(case))
        costs.append([case.title, *cost(springs)])
        print(tables[f"memory-{name}"], costs[-1], flush=True)
    tables |= {"memory-aims": to_csv(aims_table(found)), "memory-cost": to_csv(costs)}
    print(tables["memory-aims"])
    if given.store:
        for path in store("memory", tables, COMMAND, "Mesh `coarse`, 5 harmonics."):
            print(path)


if __name__ == "__main__":
    main()
