# SPDX-License-Identifier: MIT
"""Load cases beside an envelope of capacities: chords and triangles between the computed directions."""

import math

import numpy as np
import pandas as pd

from pysprings.core.arrays import Array
from pysprings.core.loads import same_load
from pysprings.core.tables.load_cases import LoadCases
from pysprings.springs.path_ends import MESH_ERROR

_FLAT = 1e-9  # volume of unit vectors in one plane: they enclose no direction


def closed(table: pd.DataFrame) -> pd.DataFrame:
    """Return the points without torsion of one envelope by growing angle, the mirrored first one at the end."""
    points = table[table["torsion_deg"] == 0.0].sort_values("direction_deg")
    first = points.iloc[[0]].copy()
    for name in ("H_N", "M_Nm", "H_macro_N", "M_macro_Nm"):
        first[name] = -first[name]
    first["direction_deg"] += 180.0
    return pd.concat([points, first], ignore_index=True)


def utilisation(table: pd.DataFrame, cases: LoadCases) -> pd.DataFrame:
    """Return a row a case and strength: its load over the chord in its direction, at the nearest computed V.

    `utilisation` is NaN where no points enclose the direction of a case, `upper_bound` 1 where an end of its chord
    is a probe that stopped before failure, `mesh_error_pct` the larger of the mesh's errors there, NaN where one is not
    known. `off_load` is 1 where the V of a case is none of those computed, to 0.1 %, and no capacity is known: not the
    10 % of springs, as an envelope closes where V nears its own capacity, and a tenth of V is not small there. A case
    without V has the worst of all.
    """
    rows = []
    for strength, own in table.groupby("strength", sort=False):
        loads = own["V_N"].drop_duplicates().to_numpy(dtype=float)
        for k, name in enumerate(cases.name):
            near = loads if np.isnan(cases.V[k]) else loads[[int(np.argmin(np.abs(loads - cases.V[k])))]]
            load = np.array([cases.H[k], cases.M[k], cases.torsion[k]])
            found = [_along(own[own["V_N"] == V], load) for V in near]
            worst = int(np.argmax([np.inf if np.isnan(share) else share for share, _ in found]))
            (share, ends), nearest = found[worst], float(near[worst])
            V = nearest if np.isnan(cases.V[k]) else float(cases.V[k])
            off = not same_load(V, nearest)
            if off:
                share, ends = math.nan, ends.iloc[:0]
            known = bool(ends["is_capacity"].all())
            rows.append({
                "name": name, "limit_state": cases.limit_state[k], "strength": strength, "H_N": float(cases.H[k]),
                "M_Nm": float(cases.M[k]), "T_Nm": float(cases.torsion[k]), "V_N": V, "V_of_envelope_N": nearest,
                "off_load": int(off),
                "H_capacity_N": float(cases.H[k]) / share if share > 0.0 else np.nan,
                "M_capacity_Nm": float(cases.M[k]) / share if share > 0.0 else np.nan,
                "T_capacity_Nm": float(cases.torsion[k]) / share if share > 0.0 else np.nan,
                "utilisation": share, "upper_bound": int(not known and np.isfinite(share)),
                MESH_ERROR: float(ends[MESH_ERROR].max(skipna=False)),
                "remarks": cases.notes[k],
            })  # fmt: skip
    return pd.DataFrame(rows)


def _along(points: pd.DataFrame, load: Array) -> tuple[float, pd.DataFrame]:
    """Return the share that a load (H, M, T) is of an envelope in its direction, and the points that bound it there.

    Without torsion it is that of the chord between two directions, with torsion that of the triangle of three.
    """
    if not load.any():
        return 0.0, points.iloc[:0]
    if load[2] != 0.0:
        return _along_face(points, load)
    plane = points[points["torsion_deg"] == 0.0]
    return _along_chord(closed(plane), *load[:2]) if len(plane) else (math.nan, plane)


def _along_face(points: pd.DataFrame, load: Array) -> tuple[float, pd.DataFrame]:
    """Return the share of a load (H, M, T) between three neighbouring directions, and their points.

    The directions are those of the points and of their mirror images; neighbours are corners of a face of the convex
    hull of directions. NaN where the points do not enclose the origin.
    """
    from scipy.spatial import ConvexHull

    own = points[["H_N", "M_Nm", "T_Nm"]].to_numpy(dtype=float)
    scaled = np.vstack([own * [s, s, t] for s in (1.0, -1.0) for t in (1.0, -1.0)])
    scaled /= (scale := np.maximum(np.abs(scaled).max(axis=0), 1e-300))
    if np.linalg.matrix_rank(scaled, tol=1e-6) < 3:
        return math.nan, points.iloc[:0]
    corners = scaled / np.linalg.norm(scaled, axis=1)[:, None]
    faces = ConvexHull(corners).simplices
    faces = faces[np.abs(np.linalg.det(corners[faces])) > _FLAT]
    shares = np.linalg.solve(scaled[faces].swapaxes(1, 2), (load / scale)[:, None])[..., 0]
    k = int(np.argmax(shares.min(axis=1) / np.abs(shares).sum(axis=1)))
    used = faces[k][shares[k] > 1e-9 * shares[k].sum()] % len(own)
    return float(shares[k].sum()), points.iloc[used]


def _along_chord(envelope: pd.DataFrame, H: float, M: float) -> tuple[float, pd.DataFrame]:
    """Return the share that a load is of the chord in its direction, and the ends of the chord."""
    points = envelope[["H_N", "M_Nm"]].to_numpy(dtype=float)
    for k in range(len(points) - 1):
        pair = np.column_stack([points[k], points[k + 1]])
        if abs(np.linalg.det(pair)) <= _FLAT * math.prod(np.linalg.norm(pair, axis=0)):
            continue
        for sign in (1.0, -1.0):
            shares = np.linalg.solve(pair, sign * np.array([H, M]))
            if (shares >= -1e-9 * math.fsum(np.abs(shares))).all():
                return float(shares.sum()), envelope.iloc[k : k + 2]
    return math.nan, envelope.iloc[:0]
