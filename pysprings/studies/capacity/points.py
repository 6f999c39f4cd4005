# SPDX-License-Identifier: MIT
"""The capacity in one direction, from the load-displacement curve of a probe of the full model."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pysprings.full_model.diagnosis import DisplacementLimit
from pysprings.results.tables.load_cases import LoadCases
from pysprings.springs.path import same_load
from pysprings.studies.capacity import plan

if TYPE_CHECKING:
    from pysprings.full_model.run_record import RunRecord
    from pysprings.scene.model import Scene


@dataclass(frozen=True, eq=False)
class Capacity:
    """What a study has shown.

    Attributes
    ----------
    scene, request : what was asked for.
    table : a row a direction, vertical load and strength (SI).
    cases : utilisation of the load cases; None without cases.
    remarks : sentences on runs that stopped, and on springs that are missing.
    """

    scene: Scene
    request: plan.Request
    table: pd.DataFrame
    cases: pd.DataFrame | None
    remarks: tuple[str, ...]


Array = NDArray[np.float64]

PEAK = 1e-3  # share by which the largest load is above the last one
# What fails is seen over this share of the conjugate displacement at least. The last steps of a probe that localisation
# stops are smaller by orders of magnitude, and their load is flat or falls without a failure.
SEEN = 0.01
PLATEAU = 0.02  # growth of the load over that of the conjugate displacement, both relative, below which it is a plateau


class Criterion(StrEnum):
    """What makes a load the capacity."""

    PEAK = "peak"
    PLATEAU = "plateau"
    MOTION = "displacement limit"
    NONE = "stopped before failure"


@dataclass(frozen=True)
class Point:
    """The largest load of a probe of the full model and its state (SI).

    Attributes
    ----------
    angle : direction [rad] in the plane of H and M/D.
    H, V, M, u, w, rotation : at the largest load.
    rest_load : V [N] at the start; the vertical load of a probe is met to the tolerance of the solver.
    criterion : what makes it the capacity; where it is `Criterion.NONE`, the capacity is larger.
    growth : relative growth of the load over that of the conjugate displacement over the last steps, `SEEN` of
        it at least; 1 in a linear response.
    moved : share of the limit of motion at the largest load.
    why : reason of a probe that stopped.
    """

    angle: float
    rest_load: float
    H: float
    V: float
    M: float
    u: float
    w: float
    rotation: float
    criterion: Criterion
    growth: float
    moved: float
    why: str = ""

    @property
    def is_capacity(self) -> bool:
        """True where the probe came to failure."""
        return self.criterion is not Criterion.NONE


_MET = 1e-6  # the limit is met to rounding where it is imposed
COLUMNS = {"u": "u_m", "w": "w_m", "rotation": "rotation_rad", "H": "H_N", "V": "V_N", "M": "M_Nm"}


def point_of(folder: Path, record: RunRecord | None, scene: Scene, angle: float) -> Point | None:
    """Return the capacity of a probe that ended in a folder; None where no step of it converged."""
    file = folder / "load_displacement.csv"
    if record is None or not file.exists():
        return None
    frame = pd.read_csv(file)
    frame = frame[frame["converged"] == 1]
    if len(frame) < 2:
        return None
    states = frame[[*COLUMNS.values()]].to_numpy(dtype=float)
    return assess(states, scene, angle, "; ".join(record.failures))


def assess(states: Array, scene: Scene, angle: float, why: str = "") -> Point:
    """Return the capacity from states (n, 6) = (u, w, rotation, H, V, M), the initial one first."""
    diameter = scene.caisson.outer_diameter
    limit, rest = DisplacementLimit.of(scene, float(states[0, 1])), float(states[0, 4])
    moved = np.array([limit.share(state[:3]) for state in states])
    along = np.array([np.cos(angle), diameter * np.sin(angle)])
    over = np.flatnonzero(moved >= 1.0 - _MET)
    ended = bool(over.size)
    if ended:  # the state at the limit itself, between the last two
        last = int(over[0])
        share = (1.0 - moved[last - 1]) / (moved[last] - moved[last - 1])
        edge = states[last - 1] + share * (states[last] - states[last - 1])
        states = np.vstack([states[:last], edge])
        moved = np.append(moved[:last], 1.0)
    load = states[:, 3] * np.cos(angle) + states[:, 5] / diameter * np.sin(angle)
    path = states[:, [0, 2]] @ along
    before = int(np.flatnonzero(path <= (1.0 - SEEN) * path[-1])[-1])
    growth = float((load[-1] - load[before]) / (path[-1] - path[before]) * path[-1] / load[-1])
    best = int(np.argmax(load))
    if load[best] > (1.0 + PEAK) * load[-1] and path[best] <= (1.0 - SEEN) * path[-1]:
        criterion = Criterion.PEAK
    elif growth < PLATEAU:
        criterion = Criterion.PLATEAU
    else:
        criterion = Criterion.MOTION if ended else Criterion.NONE
    u, w, rotation, H, V, M = states[best].tolist()
    return Point(angle, rest, H, V, M, u, w, rotation, criterion, growth, float(moved[best]), "" if ended else why)


def closed(table: pd.DataFrame) -> pd.DataFrame:
    """Return the points of one envelope by growing angle, the mirrored first one at the end."""
    points = table.sort_values("direction_deg")
    first = points.iloc[[0]].copy()
    for name in ("H_N", "M_Nm", "H_macro_N", "M_macro_Nm"):
        first[name] = -first[name]
    first["direction_deg"] += 180.0
    return pd.concat([points, first], ignore_index=True)


def utilisation(table: pd.DataFrame, cases: LoadCases) -> pd.DataFrame:
    """Return a row a case and strength: its load over the chord in its direction, at the nearest computed V.

    `off_load` is 1 where the V of a case is none of those computed. A case without V has the worst of all.
    """
    rows = []
    for strength, own in table.groupby("strength", sort=False):
        loads = own["V_N"].drop_duplicates().to_numpy(dtype=float)
        for k, name in enumerate(cases.name):
            near = loads if np.isnan(cases.V[k]) else loads[[int(np.argmin(np.abs(loads - cases.V[k])))]]
            found = [_along(closed(own[own["V_N"] == V]), float(cases.H[k]), float(cases.M[k])) for V in near]
            worst = int(np.argmax([np.inf if np.isnan(share) else share for share, _ in found]))
            (share, known), nearest = found[worst], float(near[worst])
            V = nearest if np.isnan(cases.V[k]) else float(cases.V[k])
            off = not same_load(V, nearest)
            rows.append({
                "name": name, "limit_state": cases.limit_state[k], "strength": strength, "H_N": float(cases.H[k]),
                "M_Nm": float(cases.M[k]), "V_N": V, "V_of_envelope_N": nearest, "off_load": int(off),
                "H_capacity_N": float(cases.H[k]) / share if share > 0.0 else np.nan,
                "M_capacity_Nm": float(cases.M[k]) / share if share > 0.0 else np.nan,
                "utilisation": share if not off else np.nan, "upper_bound": int(not known),
                "remarks": cases.notes[k],
            })  # fmt: skip
    return pd.DataFrame(rows)


def _along(envelope: pd.DataFrame, H: float, M: float) -> tuple[float, bool]:
    """Return the share that a load is of the chord in its direction, and whether both of its ends are capacities."""
    if H == 0.0 and M == 0.0:
        return 0.0, True
    points = envelope[["H_N", "M_Nm"]].to_numpy(dtype=float)
    known = envelope["is_capacity"].to_numpy(dtype=bool)
    for k in range(len(points) - 1):
        pair = np.column_stack([points[k], points[k + 1]])
        for sign in (1.0, -1.0):
            shares = np.linalg.solve(pair, sign * np.array([H, M]))
            if (shares >= -1e-9 * math.fsum(np.abs(shares))).all():
                return float(shares.sum()), bool(known[k] and known[k + 1])
    return math.nan, False
