# SPDX-License-Identifier: MIT
"""Runs of scenes beside tests of others: PISA's reaction curves, a bucket in Bothkennar clay, a monopod at 70 g.

    pip install openpile
    pysprings run data/scenes/SCENE.toml --estimate low --estimate best --estimate high --no-estimate-error --out OUT
    python -m benchmarks.pisa OUT/low OUT/best OUT/high

SCENE is dunkirk-pile, cowden-pile or bothkennar-pile: prints H of the run over H of a rigid pile on PISA's curves
(Burd et al. 2020, Byrne et al. 2020), at equal motion at mudline; or bothkennar-bucket (Houlsby et al. 2005): the
rotational stiffness of the first increment; or monopod-centrifuge (Kim et al. 2014): the moment at 3.1 degrees.
Coefficients are those of openpile, and so is the conic: openpile samples it at points of which the first is at 2 % of
its end, a chord where small motions count; here it has points by ratio.
"""

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from openpile.utils import Hb_curves, Mb_curves, mt_curves, py_curves
from scipy.optimize import brentq

D, L, ARM, DENSITY, WEIGHT, K0 = 10.0, 20.0, 50.0, 75.0, 10.09, 0.4  # m, %, kN/m3
SHARES = (1e-4, 5e-4, 1e-3, 2e-3, 5e-3, 0.01, 0.02, 0.05, 0.1)  # u/D
SLICES = 80


class Ground(NamedTuple):
    """Name of the curves in openpile; strength (sigma'_v of sand, su) and G_0 in kPa at a depth in m."""

    curves: str
    strength: Callable[[float], float]
    stiffness: Callable[[float], float]


def dense_sand(z: float) -> float:
    """Return G_0 in kPa: B 875, e 0.629, p_r 101.3 kPa (Taborda et al. 2020)."""
    return float(875.0 * 101.3 / (0.3 + 0.7 * 0.629**2) * np.sqrt(WEIGHT * z * (1.0 + 2.0 * K0) / 3.0 / 101.3))


GROUNDS = {
    "Dunkirk sand": Ground("dunkirk_sand", lambda z: WEIGHT * z, dense_sand),
    "Cowden till": Ground("cowden_clay", lambda z: 60.0 + 4.0 * z, lambda z: 1e4 + 1.1e4 * z),
    "Bothkennar clay": Ground("bothkennar_clay", lambda z: 11.4 + 1.9 * z, lambda z: 7.4e3 + 1.24e3 * z),
}


def conic(end: float, n: float, k: float, most: float, _: int) -> tuple[np.ndarray, np.ndarray]:
    """Return normalised motions and reactions of the conic of Burd et al. (2020), as openpile writes it."""
    k, x, a = max(most / end, k), np.concatenate([[0.0], np.geomspace(1e-7, 1.0, 400)]) * end, 1.0 - 2.0 * n
    b = 2.0 * n * x / end - (1.0 - n) * (1.0 + x * k / most)
    c = x * k / most * (1.0 - n) - n * (x / end) ** 2
    return x, most * 2.0 * c / (-b + np.sqrt(np.maximum(b * b - 4.0 * a * c, 0.0)))


def reaction(module: object, curves: str, motion: float, *arguments: float) -> float:
    """Return the reaction of openpile's curve of a module at a motion."""
    module.conic = conic  # type: ignore[attr-defined]
    function = getattr(module, curves)
    curve = getattr(function, "py_func", function)(*arguments)
    return float(np.sign(motion) * np.interp(abs(motion), *curve))


def loads(ground: Ground, u: float, turn: float) -> tuple[float, float]:
    """Return H [kN] and M at mudline [kN m] of a rigid pile at a motion [m] and rotation there."""
    name, sand = ground.curves, ground.curves == "dunkirk_sand"
    force = moment = 0.0
    for z in (np.arange(SLICES) + 0.5) * L / SLICES:
        strength, shear = ground.strength(z), ground.stiffness(z)
        here = (strength, z, DENSITY, shear) if sand else (z, strength, shear)
        p = reaction(py_curves, name, u - turn * z, *here, D, *([L] if sand else []))
        m = reaction(mt_curves, name, turn, *here, *([p, D, L] if sand else [D]))
        force, moment = force + p * L / SLICES, moment + (m - p * z) * L / SLICES
    strength, shear = ground.strength(L), ground.stiffness(L)
    tip = (strength, L, DENSITY, shear) if sand else (L, strength, shear)
    base = reaction(Hb_curves, name, u - turn * L, *tip, D, L)
    return force + base, moment - base * L + reaction(Mb_curves, name, turn, *tip, D, L)


def load(ground: Ground, u: float) -> float:
    """Return H in N of the pile that is loaded at its arm, at a motion at mudline [m]."""

    def away(turn: float) -> float:
        force, moment = loads(ground, u, turn)
        return moment - ARM * force

    return 1e3 * loads(ground, u, brentq(away, 0.0, u / 5.0))[0]


def row(scene: str, table: pd.DataFrame) -> list[str]:
    """Return what a run of a scene has beside the test of its title."""
    if "Bucket" in scene:
        first = table[table["step"] > 0].iloc[0]
        return [f"{first['M_Nm'] / first['rotation_rad'] / 1e6:.0f} MN m/rad (225 measured)"]
    if "Monopod" in scene:
        turned = np.degrees(table["rotation_rad"])
        if turned.max() < 3.1:
            return [f"ends at {turned.max():.2f} degrees with {table['M_Nm'].iloc[-1] / 1e6:.0f} MN m"]
        return [f"{np.interp(3.1, turned, table['M_Nm']) / 1e6:.0f} MN m (198 measured)"]
    ground = next(each for name, each in GROUNDS.items() if name in scene)
    reached = [share * D for share in SHARES if share * D <= 1.0001 * table["u_m"].max()]
    ours = np.interp(reached, table["u_m"], table["H_N"])
    return [f"{h / load(ground, u):.2f}" for h, u in zip(ours, reached, strict=True)]


def main() -> None:
    for folder in map(Path, sys.argv[1:]):
        title = json.loads((folder / "run.json").read_text())["scene_toml"].splitlines()[0]
        print(title.removeprefix("title = "), *row(title, pd.read_csv(folder / "load_displacement.csv")))


if __name__ == "__main__":
    main()
