# SPDX-License-Identifier: MIT
"""What a scene saves by what it leaves out: each model beside one that carries it, by turns, in one process.

    python -m benchmarks.omissions [--mesh coarse] [--end-mm 1] [--rounds 3]

Ratios of one run are what to read: seconds depend on the machine and on what else it does. Time is processor time, and
the least of all rounds; threads that wait count, so take one (MKL_NUM_THREADS=1 NUMBA_NUM_THREADS=1). Peak memory is
not a thing of one model in a process that runs many: what is printed is the memory of the factors, counted by Pardiso
itself, and that of the fields that evolve.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks import carried
from benchmarks.carried import Pushed, push
from fe_engine.assembly.system import System
from fe_engine.linear.solver import LinearSolver
from fe_engine.state import FIELDS, State
from pysprings import Scene
from pysprings.model.build import Built, build_model
from pysprings.scene.extent import PAPER

_FACTOR_KILOBYTES = 16  # Pardiso's iparm 17, from 0: memory of factorisation and solution


@dataclass(frozen=True)
class Case:
    """One omission: a scene, and how to build the model that carries what it leaves out."""

    what: str
    scene: Scene
    built: Callable[[], Built] | None = None  # None: the scene itself with `other`
    other: Scene | None = None
    symmetric: tuple[bool | None, bool | None] = (None, None)  # factors without and with; None: as in the model


@dataclass(frozen=True)
class Cost:
    """What one model has or takes: unknowns, bytes, seconds of the processor."""

    unknowns: int
    factor_bytes: int
    field_bytes: int
    output_bytes: int
    factorisations: int
    push: float
    assembly: float
    factorisation: float
    output: float


def cases(preset: str, end: float) -> list[Case]:
    """Return the omissions, each on the scene that has it."""
    path = {"name": "pull", "kind": "pull", "lateral_displacement": end, "rate": 0.05e-3}

    def scene(**sections: Any) -> Scene:
        given = {
            "mesh": {"preset": preset, "discretisation": "hex8"},
            "output": {"figures": False},
            "solver": _STEPS,
            "paths": [path],
        }
        return Scene(domain=PAPER, **given).replace(**sections)

    drained, wet = scene(), scene(drainage={"mode": "coupled"})
    wet_steel = wet.replace(caisson={"behaviour": "elastic"})
    elastic, smooth = scene(soil=carried.SMOOTH["soil"]), scene(**carried.SMOOTH)
    bare = scene(output={"interface_fields": False, "section": False})
    return [
        Case("pore pressure and film", drained, other=wet),
        Case("half of the domain", drained, lambda: carried.whole_model(drained)),
        Case("half of the domain, coupled", wet, lambda: carried.whole_model(wet)),
        Case("steel", drained, other=drained.replace(caisson={"behaviour": "elastic", "young_modulus": 1e15})),
        Case("side 2 of the film", wet_steel, lambda: carried.with_water_in_steel(wet_steel)),
        Case("plastic history", elastic, lambda: carried.with_history(elastic)),
        Case("shear of the interface", smooth, lambda: carried.with_shear(smooth), symmetric=(False, False)),
        Case("lower triangle of the factors", smooth, other=smooth, symmetric=(None, False)),
        Case("fields, section, ParaView", bare, other=bare.replace(output=dict.fromkeys(_FIELDS, True))),
    ]


_STEPS = {"first_step_fraction": 0.1, "max_step_fraction": 0.1}
_FIELDS = ("interface_fields", "section", "paraview")


def models(case: Case) -> tuple[Built, Built]:
    """Build the models without and with what is left out."""
    return build_model(case.scene), build_model(case.other or case.scene) if case.built is None else case.built()


def measure(case: Case, rounds: int) -> tuple[Cost, Cost]:
    """Return the cost without and with what is left out; the rounds go to the one and the other by turns."""
    built = models(case)
    pair = tuple(zip((case.scene, case.other or case.scene), built, case.symmetric, strict=True))
    runs = [[push(*each) for each in pair] for _ in range(rounds)]
    without, carrying = (_cost([each[k] for each in runs], built[k], case.symmetric[k]) for k in (0, 1))
    return without, carrying


def _cost(runs: list[Pushed], built: Built, symmetric: bool | None) -> Cost:
    def least(phase: str) -> float:
        return min(run.clock.cpu.get(phase, 0.0) for run in runs)

    state = State(built.model)
    fields = 2 * sum(getattr(state.committed, name).nbytes for name in FIELDS)
    return Cost(
        runs[0].unknowns, _factor_bytes(built, symmetric), fields, sum(rows.nbytes for rows in runs[0].rows.values()),
        runs[0].factorisations,
        min(run.cpu for run in runs), least("assembly"), least("factorisation"), least("output"),
    )  # fmt: skip


def _factor_bytes(built: Built, symmetric: bool | None) -> int:
    """Return the memory of one factorisation; 0 if Pardiso reports none."""
    system, half = System(built.model), built.model.symmetric if symmetric is None else symmetric
    system.time_step = 1.0
    wet = built.model.water is not None
    solver = LinearSolver("auto", system.pattern.n_free, equilibrate=wet, symmetric=half)
    solver.factorise(system.linearise(State(built.model), True)[2].matrix)
    inside: Any = getattr(solver.backend, "_solver", None)
    size = 0 if inside is None else 1000 * int(inside.iparm[_FACTOR_KILOBYTES])
    solver.close()
    return size


def contact_seconds(preset: str) -> dict[str, float]:
    """Return processor time (s) of one residual and tangent of the smooth interface, with and without shear."""
    scene = Scene(domain=PAPER, mesh={"preset": preset, "discretisation": "hex8"}, **carried.SMOOTH)
    seconds = {}
    for name, built in (("without", build_model(scene)), ("with", carried.with_shear(scene))):
        system, state = System(built.model), State(built.model)
        free, border = np.zeros(system.pattern.n_free), np.zeros(3)
        seconds[name] = _least(lambda s=system, t=state, f=free, b=border: s._contact(t, f, b, 0.0))  # type: ignore[misc]
        seconds[f"linearise, {name}"] = _least(lambda s=system, t=state: s.linearise(t, True))  # type: ignore[misc]
    return seconds


def _least(work: Callable[[], object], repeats: int = 20) -> float:
    work()
    times = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return min(times)


_COLUMNS = {
    "unknowns": "unknowns", "factor_bytes": "factors [MB]", "field_bytes": "fields [MB]", "output_bytes": "kept [MB]",
    "factorisations": "factorised", "push": "CPU [s]",
}  # fmt: skip
_RATIOS = {"push": "all", "assembly": "assembly", "factorisation": "factorise", "output": "output"}


def table(costs: dict[str, tuple[Cost, Cost]]) -> str:
    """Return each case: what it has and takes without and with it, and ratios with/without of the processor time."""
    head = f"{'left out':30}" + "".join(f"{title:>16}" for title in _COLUMNS.values())
    lines = [head + "".join(f"{'x ' + title:>12}" for title in _RATIOS.values())]
    for what, (without, with_it) in costs.items():
        cells = [_pair(without, with_it, name) for name in _COLUMNS]
        ratios = [getattr(with_it, name) / max(getattr(without, name), 1e-9) for name in _RATIOS]
        lines.append(f"{what:30}" + "".join(f"{c:>16}" for c in cells) + "".join(f"{r:12.2f}" for r in ratios))
    return "\n".join(lines)


def _pair(without: Cost, with_it: Cost, name: str) -> str:
    unit = 1e6 if name.endswith("bytes") else 1.0
    return " ".join(f"{getattr(cost, name) / unit:.{5 if name == 'unknowns' else 3}g}" for cost in (without, with_it))


def measure_all(preset: str = "coarse", end: float = 1.0e-3, rounds: int = 3) -> dict[str, tuple[Cost, Cost]]:
    """Measure every omission on a mesh, for a pull to ``end`` (m)."""
    push(carried.scene(rate=0.05e-3, drainage={"mode": "coupled"}))  # compiles, so that no case pays for it
    return {case.what: measure(case, rounds) for case in cases(preset, end)}


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser("python -m benchmarks.omissions", description="What omissions save.")
    parser.add_argument("--mesh", default="coarse", choices=("coarse", "medium", "paper"))
    parser.add_argument("--end-mm", type=float, default=1.0)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args(arguments)
    print(f"{options.mesh}, to {options.end_mm:g} mm: without, with, ratio")
    print(table(measure_all(options.mesh, 1e-3 * options.end_mm, options.rounds)))
    print(
        "stations of a smooth interface, ms:", {k: round(1e3 * v, 3) for k, v in contact_seconds(options.mesh).items()}
    )


if __name__ == "__main__":
    main()
