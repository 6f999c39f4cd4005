# SPDX-License-Identifier: MIT
"""Random scenes through `pysprings run`: short ways on small meshes, over ground, water, loads and kinds of path.

    python -m tests.fuzz.runs [FIRST] [NUMBER]

runs so many scenes from a seed on and prints a line for each that is judged bad, and a tally.
"""

import json
import math
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from tests.support.commands import command

ENDS = {0: "complete", 2: "refused", 3: "not converged"}
CLOSED = 1e-4  # of the largest force and moment, and of the largest term of the energy
Draw = np.random.Generator


def scene(seed: int) -> str:
    """Return the text of a random scene that an engineer could have written."""
    draw = np.random.default_rng(seed)
    diameter = float(np.exp(draw.uniform(math.log(3.0), math.log(25.0))))
    length = diameter * draw.uniform(0.2, 1.5)
    clay, mode = draw.random() < 0.35, str(draw.choice(["drained", "coupled", "undrained"]))
    own = 6.0e3 * math.pi * diameter * length * draw.choice([0.3, 1.0, 3.0])
    lines = [
        f'title = "random {seed}"', "[caisson]", f"outer_diameter = {_q(diameter, 'm')}",
        f"skirt_length = {_q(length, 'm')}", f"skirt_thickness = {_q(diameter * draw.uniform(0.003, 0.01), 'm')}",
    ]  # fmt: skip
    if draw.random() < 0.6:
        lines.append(f"vertical_load = {_q(own * draw.choice([1.0, 1.0, -0.1]), 'N')}")
    lines += ["[soil]", *_soil(draw, clay)]
    lines += ['hydraulic_conductivity = "1e-4 m/s"'] if mode == "coupled" and not clay else []
    opening = draw.choice(["bonded", "vented", "sealed"])
    lines += ["[interface]", f'opening = "{opening}"']
    lines += [f"adhesion_factor = {draw.uniform(0.2, 1.0):.3g}"] if clay else []
    lines += [] if clay else [f"friction_coefficient = {draw.uniform(0.0, 0.7):.3g}"]
    if not clay and mode != "drained":
        lines += ["[drainage]", f'mode = "{mode}"', 'water_depth = "20 m"']
    lines += ["[mesh]", 'preset = "coarse"', f"refinement = {draw.choice([0.4, 0.5])}"]
    lines += ["[solver]", "tolerance = 1e-3", "max_step_fraction = 0.34", "[output]", "figures = false"]
    for number in range(draw.integers(1, 3)):
        lines += _path(draw, f"p{number}", diameter, length, own)
    return "\n".join(lines) + "\n"


def _q(value: float, unit: str) -> str:
    return f'"{value:.6g} {unit}"'


def _soil(draw: Draw, clay: bool) -> list[str]:
    unit_weight = f"effective_unit_weight = {_q(draw.uniform(5e3, 11e3), 'N/m^3')}"
    if clay:
        layers = ["[[soil.layer]]", 'top = "0 m"', *_clay(draw, unit_weight)]
        if draw.random() < 0.4:
            layers += ["[[soil.layer]]", f"top = {_q(draw.uniform(0.5, 6.0), 'm')}", *_clay(draw, unit_weight)]
        return layers
    friction = draw.uniform(25.0, 42.0)
    return [
        f"young_modulus = {_q(np.exp(draw.uniform(math.log(20e6), math.log(400e6))), 'Pa')}",
        f"poisson_ratio = {draw.uniform(0.15, 0.45):.3g}", f"friction_angle_final = {_q(friction, 'deg')}",
        f"dilation_angle = {_q(friction * draw.uniform(0.0, 0.95), 'deg')}",
        'friction_angle_initial = "auto"', f"cohesion = {_q(draw.choice([0.0, 1e3]), 'Pa')}",
        f"K0 = {draw.choice([0.4, 0.6, 1.0])}", f"surcharge = {_q(draw.choice([1e3, 10.56e3]), 'Pa')}", unit_weight,
        f'yield_surface = "{draw.choice(["drucker-prager", "van-eekelen"])}"',
    ]  # fmt: skip


def _clay(draw: Draw, unit_weight: str) -> list[str]:
    top, gradient = draw.uniform(2e3, 60e3), draw.choice([0.0, 1.5e3, 3e3])
    strength = f'{{ top = "{top:.5g} Pa", gradient = "{gradient:g} Pa/m" }}'
    return [
        f'law = "{draw.choice(["tresca", "von-mises"])}"', f"undrained_shear_strength = {strength}",
        f"rigidity_ratio = {draw.uniform(50.0, 500.0):.3g}", "poisson_ratio = 0.49", unit_weight,
    ]  # fmt: skip


def _path(draw: Draw, name: str, diameter: float, length: float, own: float) -> list[str]:
    kind = str(draw.choice(["pull", "pull", "translation", "rotation", "vertical", "load", "swipe"]))
    motion = diameter * 10.0 ** draw.uniform(-4.5, -2.5) * draw.choice([1.0, -1.0])
    turn = _q(motion / length, "rad")
    given = {
        "pull": [f"lateral_displacement = {_q(motion, 'm')}", f"arm = {_q(diameter * draw.uniform(-1.0, 4.0), 'm')}"],
        "translation": [f"lateral_displacement = {_q(motion, 'm')}"], "rotation": [f"rotation = {turn}"],
        "vertical": [f"vertical_displacement = {_q(motion, 'm')}"],
        "load": [
            f"lateral_force = {_q(own * draw.uniform(0.1, 3.0), 'N')}",
            f"arm = {_q(diameter * draw.uniform(0.0, 3.0), 'm')}",
        ],
        "swipe": [f"lateral_displacement = {_q(motion, 'm')}", f"rotation = {turn}"],
    }[kind]  # fmt: skip
    time = 10.0 ** draw.uniform(0.0, 6.0)
    turns = kind in ("pull", "translation", "vertical") and draw.random() < 0.3
    then = [f'then = ["{-motion:.6g} m in {time:.6g} s"]'] if turns else []
    pace = f"rate = {_q(abs(motion) / time, 'm/s')}" if kind == "swipe" else f"duration = {_q(time, 's')}"
    role = ['role = "held-back"'] if then or kind == "swipe" or draw.random() < 0.2 else []
    return ["[[path]]", f'name = "{name}"', f'kind = "{kind}"', *given, *then, pace, *role]


def faults(seed: int, place: Path) -> tuple[str, list[str]]:
    """Run the scene of a seed; return how it ended, and what is wrong with that."""
    text = scene(seed)
    file, out = place / f"{seed}.toml", place / f"out-{seed}"
    file.write_text(text, encoding="utf-8")
    estimate = ["--estimate-error" if seed % 4 == 0 else "--no-estimate-error"]
    done = command("run", file, "--out", out, "--quiet", *estimate)
    end = ENDS.get(done.code, f"exit {done.code}")
    wrong = [done.err] if done.code not in ENDS or any(word in done.err for word in ("bug", "error of the p")) else []
    if done.code == 2:
        return end, wrong + [f"no place: {line}" for line in done.err.splitlines() if line.count(":") < 4]
    if not (out / "run.json").exists():
        return end, [*wrong, f"no result: {done.err}"]
    record = json.loads((out / "run.json").read_text(encoding="utf-8"))
    return end, wrong + _judged(record, out) + _asked(record, out)


def _judged(record: dict[str, Any], out: Path) -> list[str]:
    """Return what is wrong with the record and the table of loads."""
    wrong = [f"not made: {record['not_made']}"] if record["not_made"] else []
    for name, missing in (record.get("balance") or {}).items():
        if not max(missing.values()) < CLOSED:
            wrong.append(f"{name}: balance {missing}")
    for name, path in record["paths"].items():
        energy = path["energy"]
        if not energy["imbalance_over_largest_term"] < 1e2 * CLOSED:
            wrong.append(f"{name}: energy {energy}")
        if path["status"] == "limit load" and path["increments"] - (path.get("increments_of_dead_load") or 0) < 1:
            wrong.append(f"{name}: a limit load without an increment")
    frame = pd.read_csv(out / "load_displacement.csv")
    numbers = frame[frame["converged"] == 1].select_dtypes("number")
    if not np.isfinite(numbers.drop(columns=[c for c in numbers if c.startswith("F_")]).to_numpy()).all():
        wrong.append("a number of a converged state is not finite")
    if not (out / "report.html").exists():
        wrong.append("no report")
    return wrong


def _asked(record: dict[str, Any], out: Path) -> list[str]:
    """Return what is wrong with the answers of the springs of a run."""
    if not (out / "springs.nc").exists():
        return []
    largest = max((abs(path["end"]["H"]) for path in record["paths"].values()), default=0.0)
    wrong = []
    for words in (("predict", out, "--H", f"{0.3 * largest:.6g} N", "--json"), ("compare", out)):
        done = command(*words)
        if done.code not in ENDS or "bug" in done.err:
            wrong.append(f"{words[0]}: {done.err}")
    return wrong


def main(first: int = 0, number: int = 200) -> None:
    """Run scenes and print what is wrong, and how many ended how."""
    ends: Counter[str] = Counter()
    for seed in range(first, first + number):
        began = time.monotonic()
        with tempfile.TemporaryDirectory() as place:
            try:
                end, wrong = faults(seed, Path(place))
            except Exception as error:  # what escapes the command line
                end, wrong = "escaped", [f"{type(error).__name__}: {error}"]
        ends[end] += 1
        print(seed, end, f"{time.monotonic() - began:.0f} s", *wrong, sep="\n    " if wrong else " ", flush=True)
    print(dict(ends))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]))
