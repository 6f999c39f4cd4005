# SPDX-License-Identifier: MIT
"""The convergence record of a path, its summary, and the memory a run took."""

from __future__ import annotations

import sys
from itertools import groupby
from typing import Any

import numpy as np
import xarray as xr

from pysprings import variables

_COLUMNS = (
    "step", "attempt", "iteration", "load_fraction", "residual", "correction", "damping",
    "n_open", "n_slip", "n_plastic", "n_apex",
)  # fmt: skip
_INTEGERS = {"step", "attempt", "iteration", "n_open", "n_slip", "n_plastic", "n_apex"}


def with_attempts(record: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Number the attempts at each step: 1, and one more after each cut-back."""
    rows, attempt, last_step = [], 0, 0
    for row in record:
        if row["iteration"] == 0:
            attempt = attempt + 1 if row["step"] == last_step else 1
            last_step = row["step"]
        rows.append({**row, "attempt": attempt})
    return rows


def convergence_dataset(record: list[dict[str, Any]]) -> xr.Dataset:
    """The record of every iteration, failed attempts included, as a Dataset along ``iteration``."""
    rows = with_attempts(record)
    data = {
        name: (("iteration",), np.array([row[name] for row in rows], dtype=np.int32 if name in _INTEGERS else float))
        for name in _COLUMNS
    }
    return variables.attach(xr.Dataset(data), "convergence")


def summarise(record: list[dict[str, Any]], path: xr.Dataset) -> dict[str, Any]:
    """Figures of a path: increments, iterations, cut-backs and their places, order of convergence, balance."""
    attempts = [list(rows) for _, rows in groupby(with_attempts(record), lambda r: (r["step"], r["attempt"]))]
    good = [rows for rows in attempts if rows[-1]["converged"]]
    bad = [rows for rows in attempts if not rows[-1]["converged"]]
    iterations = [len(rows) - 1 for rows in good]
    return {
        "increments": len(good),
        "iterations": int(sum(iterations)),
        "median_iterations": float(np.median(iterations)) if good else 0.0,
        "max_iterations": max(iterations, default=0),
        "cut_backs": len(bad),
        "iterations_in_cut_backs": sum(len(rows) - 1 for rows in bad),
        "cut_back_at_fractions": [round(rows[-1]["load_fraction"], 5) for rows in bad],
        "worst_residual": max((rows[-1]["residual"] for rows in good), default=0.0),
        "order_of_last_iterations": _order(good),
        "last_residual_ratio": _last_ratio(good),
        "end": {name: float(path[name][-1]) for name in ("u", "w", "rotation", "H", "V", "M")},
    }


def _order(good: list[list[dict[str, Any]]]) -> float | None:
    """Median order log(e2/e1)/log(e1/e0) of the last three residuals of increments (2 is quadratic)."""
    orders = []
    for rows in good:
        e = [row["residual"] for row in rows[-3:]]
        if len(e) == 3 and 0.0 < e[2] < e[1] < e[0] < 0.1:
            orders.append(np.log(e[2] / e[1]) / np.log(e[1] / e[0]))
    return float(np.median(orders)) if orders else None


def _last_ratio(good: list[list[dict[str, Any]]]) -> float | None:
    """Median of the last residual over the one before it."""
    pairs = [(rows[-2]["residual"], rows[-1]["residual"]) for rows in good if len(rows) > 2]
    return float(np.median([b / a for a, b in pairs if a > 0.0])) if pairs else None


def peak_memory_bytes() -> int:
    """Largest resident memory of this process so far, in bytes."""
    try:
        import resource
    except ImportError:  # Windows
        import psutil

        return int(psutil.Process().memory_info().peak_wset)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return int(peak) if sys.platform == "darwin" else int(peak) * 1024
