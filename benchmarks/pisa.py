# SPDX-License-Identifier: MIT
"""Runs of `data/scenes/dunkirk-pile.toml` beside PISA's reaction curves for Dunkirk sand (Burd et al. 2020).

    pip install openpile
    pysprings run data/scenes/dunkirk-pile.toml --estimate best --no-estimate-error --out OUT
    python -m benchmarks.pisa OUT...

Prints H of the run over H of a rigid pile on these curves, at equal motion at mudline. Coefficients are those of
openpile, and so is the conic: openpile samples it at points of which the first is at 2 % of its end, a chord where
small motions count; here it has points by ratio.
"""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
from openpile.utils import Hb_curves, Mb_curves, mt_curves, py_curves
from scipy.optimize import brentq

D, L, ARM, DENSITY, WEIGHT, K0 = 10.0, 20.0, 50.0, 75.0, 10.09, 0.4  # m, %, kN/m3
SHARES = (1e-4, 5e-4, 1e-3, 2e-3, 5e-3, 0.01, 0.02, 0.05, 0.1)  # u/D
SLICES = 80


def conic(end: float, n: float, k: float, most: float, _: int) -> tuple[np.ndarray, np.ndarray]:
    """Return normalised motions and reactions of the conic of Burd et al. (2020), as openpile writes it."""
    k, x, a = max(most / end, k), np.concatenate([[0.0], np.geomspace(1e-7, 1.0, 400)]) * end, 1.0 - 2.0 * n
    b = 2.0 * n * x / end - (1.0 - n) * (1.0 + x * k / most)
    c = x * k / most * (1.0 - n) - n * (x / end) ** 2
    return x, most * 2.0 * c / (-b + np.sqrt(np.maximum(b * b - 4.0 * a * c, 0.0)))


def reaction(module: object, motion: float, *arguments: float) -> float:
    """Return the reaction of openpile's curve of a module at a motion."""
    module.conic = conic  # type: ignore[attr-defined]
    curve = module.dunkirk_sand.py_func(*arguments)  # type: ignore[attr-defined]
    return float(np.sign(motion) * np.interp(abs(motion), *curve))


def loads(u: float, turn: float) -> tuple[float, float]:
    """Return H [kN] and M at mudline [kN m] of a rigid pile at a motion [m] and rotation there."""
    force = moment = 0.0
    for z in (np.arange(SLICES) + 0.5) * L / SLICES:
        sigma, shear = WEIGHT * z, stiffness(z)
        p = reaction(py_curves, u - turn * z, sigma, z, DENSITY, shear, D, L)
        m = reaction(mt_curves, turn, sigma, z, DENSITY, shear, p, D, L)
        force, moment = force + p * L / SLICES, moment + (m - p * z) * L / SLICES
    tip = WEIGHT * L, L, DENSITY, stiffness(L), D, L
    base = reaction(Hb_curves, u - turn * L, *tip)
    return force + base, moment - base * L + reaction(Mb_curves, turn, *tip)


def stiffness(z: float) -> float:
    """Return G_0 in kPa: B 875, e 0.629, p_r 101.3 kPa (Taborda et al. 2020)."""
    return float(875.0 * 101.3 / (0.3 + 0.7 * 0.629**2) * np.sqrt(WEIGHT * z * (1.0 + 2.0 * K0) / 3.0 / 101.3))


def load(u: float) -> float:
    """Return H in N of the pile that is loaded at its arm, at a motion at mudline [m]."""

    def away(turn: float) -> float:
        force, moment = loads(u, turn)
        return moment - ARM * force

    return 1e3 * loads(u, brentq(away, 0.0, u / 5.0))[0]


def main() -> None:
    reference = [load(share * D) for share in SHARES]
    for folder in sys.argv[1:]:
        table = pd.read_csv(Path(folder) / "load_displacement.csv")
        reached = [share for share in SHARES if share * D <= 1.0001 * table["u_m"].max()]
        ours = np.interp(np.multiply(reached, D), table["u_m"], table["H_N"])
        print(folder, *(f"{h / r:.2f}" for h, r in zip(ours, reference, strict=False)))


if __name__ == "__main__":
    main()
