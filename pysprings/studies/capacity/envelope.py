# SPDX-License-Identifier: MIT
"""Between the computed directions: chords of the envelope, and the utilisation of load cases.

A chord lies inside of a convex envelope, so that what it gives is on the safe side. Where one of its ends is no
capacity (the run stopped before failure), neither is the chord: the utilisation is then an upper bound.
"""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pysprings.results.tables.load_cases import LoadCases
from pysprings.springs.path import same_load

Array = NDArray[np.float64]


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
