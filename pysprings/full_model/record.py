# SPDX-License-Identifier: MIT
"""The convergence record of a path, its figures, and the cost of a run."""

import sys
from collections import Counter
from collections.abc import Callable, Sequence
from itertools import groupby
from typing import Any

import numpy as np
import xarray as xr

from fe_engine.balance.energy import TERMS, Energy
from fe_engine.clock import Clock, seconds
from fe_engine.errors import NotConverged
from pysprings.core import variables
from pysprings.core.arrays import Array, Marks
from pysprings.core.path_kinds import LOADS, MOTIONS
from pysprings.full_model.run_record import CutBack, PathFigures, RunRecord, Status

DEAD_LOAD = "dead load"  # the stage before a path whose caisson carries more or less than the balance

_COLUMNS = (
    "increment", "attempt", "iteration", "load_fraction", "residual", "correction", "damping",
    "n_open", "n_slip", "n_plastic", "n_apex",
)  # fmt: skip
_INTEGERS = {"increment", "attempt", "iteration", "n_open", "n_slip", "n_plastic", "n_apex"}


def with_attempts(record: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Count the increments of the path from 1, and the attempts at each: 1, and one more after each cut-back.

    The increments of the dead load, which come first, get the numbers up to 0.
    """
    before = max((row["step"] for row in record if row["stage"] == DEAD_LOAD), default=0)
    rows, attempt, last_step = [], 0, 0
    for row in record:
        if row["iteration"] == 0:
            attempt = attempt + 1 if row["step"] == last_step else 1
            last_step = row["step"]
        rows.append({**row, "attempt": attempt, "increment": row["step"] - before})
    return rows


def convergence_dataset(record: list[dict[str, Any]]) -> xr.Dataset:
    """Return the record of every iteration, failed attempts included, as a Dataset along ``iteration``."""
    rows = with_attempts(record)
    data = {
        name: (("iteration",), np.array([row[name] for row in rows], dtype=np.int32 if name in _INTEGERS else float))
        for name in _COLUMNS
    }
    return variables.attach(xr.Dataset(data), "convergence")


def summarise(
    record: list[dict[str, Any]], cut_backs: list[CutBack], path: xr.Dataset, limits: Sequence[str] = ()
) -> PathFigures:
    """Return the figures of a path but for how it ended and its energy.

    record : one row per iteration (`fe_engine.solve.stepping.Driver`).
    cut_backs : attempts that were given up, see `cut_back`.
    path : what was collected along the path.
    limits : what limited the size of each step (`fe_engine.solve.step_size.LIMITS`).
    """
    names = (*MOTIONS, *LOADS) if "u_x" in path else ("u", "w", "rotation", "H", "V", "M")
    attempts = [list(rows) for _, rows in groupby(with_attempts(record), lambda r: (r["increment"], r["attempt"]))]
    good = [rows for rows in attempts if rows[-1]["converged"]]
    iterations = [len(rows) - 1 for rows in good]
    dead_load = sum(rows[0]["stage"] == DEAD_LOAD for rows in good)
    return PathFigures(
        status=Status.COMPLETE,
        increments=len(good),
        increments_of_dead_load=dead_load or None,
        iterations=int(sum(iterations)),
        median_iterations=float(np.median(iterations)) if good else 0.0,
        max_iterations=max(iterations, default=0),
        cut_backs=len(cut_backs),
        iterations_in_cut_backs=sum(each.iterations for each in cut_backs),
        cut_backs_at=cut_backs,
        steps_limited_by=dict(Counter(limits)),
        worst_residual=max((rows[-1]["residual"] for rows in good), default=0.0),
        order_of_last_iterations=_order(good),
        last_residual_ratio=_last_ratio(good),
        end={name: float(path[name][-1]) for name in names},
        contact_rings=None if "u_x" in path else contact_alternation(path),
        water=_water(path),
    )


def _water(path: xr.Dataset) -> dict[str, float] | None:
    """Balance of the water at the end and the range of its pressures; None when drained."""
    if "water_moved" not in path:
        return None
    volumes = {name: float(path[f"water_{name}"][-1]) for name in VOLUMES}
    exchanged = max(volumes["moved"], abs(volumes["expelled"]), volumes["film"])
    worst = float(np.abs(path["water_imbalance"]).max())
    return {
        **{f"{name}_m3": value for name, value in volumes.items()},
        "worst_imbalance_over_exchanged": worst / exchanged if exchanged else 0.0,
        "pressure_min_Pa": float(path["pressure_min"].min()),
        "pressure_max_Pa": float(path["pressure_max"].max()),
    }


def energy_summary(energy: Energy, part: float = 0.5) -> dict[str, float]:
    """Return the terms of the energy balance of the whole caisson at the end of a path, J, and what they leave.

    ``part`` is that of the caisson whose energy is given.
    """
    terms = {f"{name}_J": getattr(energy, name) / part for name in (*TERMS, "imbalance")}
    return terms | {"imbalance_over_largest_term": abs(energy.imbalance) / energy.moved if energy.moved else 0.0}


VOLUMES = ("expelled", "compressed", "film", "outflow", "moved", "imbalance")


def cut_back(stage: str, fraction: float, error: NotConverged) -> CutBack:
    """Return the record of an attempt that was given up on its way to a fraction of a stage."""
    residuals = [float(row["residual"]) for row in error.history]
    return CutBack(
        stage=stage if stage == DEAD_LOAD else "path",
        load_fraction=round(fraction, 9),
        reason=error.reason,
        place=error.place,
        iterations=max(len(residuals) - 1, 0),
        last_residuals=[float(f"{value:.3g}") for value in residuals[-6:]],
    )


class Meter:
    """Measures what a piece of work costs: its phases by a clock, and wall and CPU seconds in all."""

    def __init__(self, now: Callable[[], tuple[float, float]] = seconds) -> None:
        self.clock = Clock(now)
        self._since = now()

    def include(self, clock: Clock) -> None:
        """Add what another clock has measured before this meter started."""
        for name, wall in clock.wall.items():
            cpu = clock.cpu[name]
            self.clock.wall[name] = self.clock.wall.get(name, 0.0) + wall
            self.clock.cpu[name] = self.clock.cpu.get(name, 0.0) + cpu
            self._since = self._since[0] - wall, self._since[1] - cpu

    def charge(self, record: RunRecord) -> None:
        """Add the cost since the last charge to a record, and start anew.

        The phase "other" takes what no phase has counted, so that the phases add up to the totals.
        """
        phases = record.phases
        phases.pop("other", None)
        for name, wall in self.clock.wall.items():
            phases[name] = {"wall_s": round(wall, 3), "cpu_s": round(self.clock.cpu[name], 3)}
        wall, cpu = self.clock.now()
        record.wall_s = round(record.wall_s + wall - self._since[0], 3)
        record.cpu_s = round(record.cpu_s + cpu - self._since[1], 3)
        counted = {key: sum(phase[key] for phase in phases.values()) for key in ("wall_s", "cpu_s")}
        phases["other"] = {
            "wall_s": round(max(record.wall_s - counted["wall_s"], 0.0), 3),
            "cpu_s": round(max(record.cpu_s - counted["cpu_s"], 0.0), 3),
        }
        record.peak_memory_bytes = peak_memory_bytes()
        self.clock, self._since = Clock(self.clock.now), (wall, cpu)


def _order(good: list[list[dict[str, Any]]]) -> float | None:
    """Return the median order log(e2/e1)/log(e1/e0) of the last three residuals of increments (2 is quadratic)."""
    orders = []
    for rows in good:
        e = [row["residual"] for row in rows[-3:]]
        if len(e) == 3 and 0.0 < e[2] < e[1] < e[0] < 0.1:
            orders.append(np.log(e[2] / e[1]) / np.log(e[1] / e[0]))
    return float(np.median(orders)) if orders else None


def _last_ratio(good: list[list[dict[str, Any]]]) -> float | None:
    """Return the median of the last residual over the one before it."""
    pairs = [(rows[-2]["residual"], rows[-1]["residual"]) for rows in good if len(rows) > 2]
    return float(np.median([b / a for a, b in pairs if a > 0.0])) if pairs else None


def peak_memory_bytes() -> int:
    """Return the largest resident memory of this process so far, in bytes."""
    try:
        import resource
    except ImportError:  # Windows
        import psutil

        return int(psutil.Process().memory_info().peak_wset)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return int(peak) if sys.platform == "darwin" else int(peak) * 1024


_DIMS = ("step", "side", "depth", "azimuth")


def contact_alternation(path: xr.Dataset) -> dict[str, Any] | None:
    """Measure alternation of the contact pressure along a path; None where interface fields were not kept.

    Interfaces with a stiff penalty and coupled integration points show pressures that swing about the true ones
    (Schellekens & de Borst 1993): stations open beside loaded ones. The measures are taken ring by ring (one side, one
    depth, one step), on p'_N at the stations 0..pi of the half model and their mirror images:

        d_i = (p_{i-1} - 2 p_i + p_{i+1}) / mean        second difference

    over the mean of the ring's p now, or in the first step where that is larger (a ring that is all but open has no
    significant mean).

    - ``second_difference``: the largest |d_i|. It also sees real curvature: a pressure that follows 1 + a cos(theta)
      gives a (azimuth step)^2, and the edge of an open zone gives the pressure beside it.
    - ``alternation``: the largest min(|d_{i-1}|, |d_i|, |d_{i+1}|) where the three change sign from one to the next. A
      smooth curve, a kink and a step give next to nothing, a swing from point to point of +-s about the mean 4 s.
    - ``isolated_open``: stations without pressure between two neighbours that carry some; an open zone that begins,
      narrower than the spacing of the stations, counts as one. A ring of bricks on a boundary of layers has two slices,
      and counts in each.

    path : normal_effective_stress (step, side, azimuth, depth) Pa, compression positive; azimuth from 0 to pi.

    The first two are dimensionless, the largest over all steps and rings, with their places (``..._at``); the third is
    the largest number at one step, both sides, with ``isolated_open_at_step``. ``stations``: evaluated in each step.
    """
    if "normal_effective_stress" not in path or path.sizes["azimuth"] < 3:
        return None
    pressure = path["normal_effective_stress"].transpose(*_DIMS).values.astype(float)
    difference = _second_difference(pressure)
    swing = _swing(difference)
    isolated = _isolated_open(pressure).sum(axis=(1, 2, 3))
    return {
        "second_difference": float(np.abs(difference).max(initial=0.0)),
        "second_difference_at": _place(path, np.abs(difference)),
        "alternation": float(swing.max(initial=0.0)),
        "alternation_at": _place(path, swing),
        "isolated_open": int(isolated.max(initial=0)),
        "isolated_open_at_step": int(path["step"].values[int(np.argmax(isolated))]) if isolated.any() else None,
        "stations": int(np.prod(pressure.shape[1:])),
    }


def _mirrored(values: Array) -> Array:
    """Return values (..., azimuth) with a mirror image beyond each end: the loading plane is a symmetry plane."""
    return np.concatenate([values[..., 1:2], values, values[..., -2:-1]], axis=-1)


def _second_difference(pressure: Array) -> Array:
    """Return second difference around each ring over the ring's mean pressure, see above; 0 without any pressure."""
    ring = _mirrored(pressure)
    share = np.ones(pressure.shape[-1])
    share[[0, -1]] = 0.5  # the stations in the symmetry plane count once on the whole ring, the others twice
    mean = (pressure * share).sum(axis=-1, keepdims=True) / share.sum()
    mean = np.maximum(mean, mean[:1])
    return (ring[..., :-2] - 2.0 * pressure + ring[..., 2:]) / np.where(mean > 0.0, mean, np.inf)


def _swing(difference: Array) -> Array:
    """Return smallest size of three second differences that follow each other, where their signs alternate, else 0."""
    ring = _mirrored(difference)
    before, here, after = ring[..., :-2], difference, ring[..., 2:]
    size = np.minimum(np.minimum(np.abs(before), np.abs(here)), np.abs(after))
    return np.where((before * here < 0.0) & (here * after < 0.0), size, 0.0)


def _isolated_open(pressure: Array) -> Marks:
    """Return True where a station carries nothing and both neighbours in its ring do."""
    loaded = _mirrored(pressure) > 0.0
    return ~loaded[..., 1:-1] & loaded[..., :-2] & loaded[..., 2:]


def _place(path: xr.Dataset, measure: Array) -> str:
    """Return words for the place of the largest value; empty where all are 0."""
    if not measure.any():
        return ""
    step, side, depth, azimuth = np.unravel_index(int(np.argmax(measure)), measure.shape)
    degrees = np.degrees(float(path["azimuth"].values[azimuth]))
    where = f"azimuth {degrees:.0f}°, depth {float(path['depth'].values[depth]):.2f} m"
    return f"{path['side'].values[side]}, {where}, step {int(path['step'].values[step])}"
