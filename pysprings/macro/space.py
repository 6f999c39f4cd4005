# SPDX-License-Identifier: MIT
"""Answers out of one plane: sequences of loads or motions in six degrees of freedom, and their errors.

Springs with memory that were calibrated on a circle and a twist, beside planar paths, answer them
(`[springs] memory = true, directions = true`); the other spring sets hold for one plane.
"""

from typing import Any, Literal, Protocol, Unpack

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from pysprings.core.arguments import check_arrays, check_rows
from pysprings.core.columns import Column, Table
from pysprings.core.errors import refused
from pysprings.macro.answer import Care, raise_or_warn
from pysprings.macro.spring_sets import SPRING_SETS
from pysprings.springs.path import SpacePath
from pysprings.springs.springs import Springs
from pysprings.springs.tip_zone import ZONE

Array = NDArray[np.float64]
SpaceControl = Literal["load", "state"]
MEMORY = "memory"  # the spring set that answers
ALONE = 0.01  # lateral loads below this share of the torsion are none
PLANE_ALONE = "the set '{}' answers loads in one plane only: ask for the springs 'memory'"


class SpaceResponse(Protocol):
    """Springs that answer loads from all sides; motions (n, 5), loads (n, 5) as in `sequence_in_space`."""

    @property
    def has_torsion(self) -> bool:
        """Whether they carry torsion."""
        ...

    def solve(self, control: SpaceControl, targets: Array) -> tuple[Array, Array, str]:
        """Follow targets from rest; return motions, loads, and a message on where it ended."""
        ...

    def answer(self, control: SpaceControl, targets: Array, V: Array | None, time: Array | None) -> xr.Dataset:
        """Return the states along targets as a dataset by step, marked."""
        ...

    def reactions(self, turns: Array) -> Array:
        """Return p in the planes of x and y by depth, (2, depth, n) [N/m], along motions from rest on."""
        ...


def sequence_in_space(
    springs: Springs | xr.DataTree,
    targets: Array,
    *,
    control: SpaceControl = "load",
    V: float | Array | None = None,
    time: Array | None = None,
    springs_kind: str | None = None,
    **care: Unpack[Care],
) -> xr.Dataset:
    """Return the states along a sequence of loads or motions in six degrees of freedom, from rest.

    Parameters
    ----------
    targets
        (n, 5): loads H_x, H_y [N], M_x, M_y about the lid centre, T [N m], or, with the control "state", motions u_x,
        u_y [m], rot_x, rot_y, rot_z [rad]; axes with z up.
    V
        Vertical load [N]: states under another one than that of the springs are marked `off_load`.
    time
        (n,) [s] of the rows; handed on.
    springs_kind
        "memory", or None: no other set answers.

    Raises
    ------
    UserInputError
        The springs have no path that leaves the plane and calibrates them.
    BeyondSprings
        The answer is beyond their range (not with `extrapolate`).
    """
    check_arrays(targets=targets, V=V, time=time)
    rows = np.asarray(targets, dtype=float)
    check_rows(len(rows), V, time)
    down = None if V is None else np.broadcast_to(np.asarray(V, dtype=float), len(rows)).copy()
    answer = response_in_space(springs, springs_kind).answer(control, rows, down, time)
    return raise_or_warn(answer, **care)


def response_in_space(springs: Springs | xr.DataTree, springs_kind: str | None = None) -> SpaceResponse:
    """Return the springs that answer loads from all sides. Raises UserInputError where there are none."""
    chosen = SPRING_SETS.find(springs_kind or MEMORY, "springs_kind")
    if chosen.in_space is None:
        raise refused("springs_kind", PLANE_ALONE.format(chosen.name))
    return chosen.in_space(Springs.of(springs))


def compare_in_space(springs: Springs | xr.DataTree) -> pd.DataFrame:
    """Return the errors of springs on the paths out of one plane, one row a path; empty where none answers.

    At the motions of the full model: largest error of H and M/L, as vectors, over the largest (H, M/L) of the path [%],
    of T/R over the largest load, and of p by depth, as vectors, over the largest p (the last fifth of the skirt is one
    slice). Under its loads: largest error of (u_x, u_y) and of the rotation L over the
    largest motion, NaN where the springs do not carry the loads. T is NaN without springs of torsion.
    """
    given = Springs.of(springs)
    if not given.turning or not SPRING_SETS[MEMORY].ready(given.at()):
        return pd.DataFrame()
    response = response_in_space(given)
    return pd.DataFrame([_row(given, response, path) for path in given.space.values() if path.n > 1])


def _row(springs: Springs, response: SpaceResponse, path: SpacePath) -> dict[str, Any]:
    length, radius = springs.length, 0.5 * springs.diameter
    motions, loads = path.turns(), path.pushes()
    if not response.has_torsion:
        motions[:, 4], loads[:, 4] = 0.0, 0.0
    _, carried, held = response.solve("state", motions[1:])
    moved, _, stopped = response.solve("load", loads[1:])
    given, own = path.loads(radius)[1:], path.scaled(carried, 1.0 / length, 1.0 / radius)
    size, whole = (float(np.linalg.norm(given[:, :n], axis=1).max()) for n in (4, 5))
    missing = np.abs(own - given[: len(own)])
    twists = not size > ALONE * whole
    row: dict[str, Any] = {"path": path.name, "role": path.role, "kind": path.kind, "springs": MEMORY}
    row |= {"states": path.n - 1, "status": held or "complete"}
    for name, first in (("H", 0), ("M", 1)):
        worst = float(np.hypot(missing[:, first], missing[:, first + 2]).max())
        row[f"{name}_error_pct"] = np.nan if twists else 100.0 * worst / size
    row["p_error_pct"] = np.nan if twists else _p_error(path, response.reactions(motions)[:, :, : len(own) + 1])
    row["T_error_pct"] = 100.0 * float(missing[:, 4].max()) / whole if response.has_torsion else np.nan
    known, found = path.motions(radius)[1:], path.scaled(moved, length, radius)
    far, wrong = float(np.linalg.norm(known[:, :4], axis=1).max()), np.abs(found - known[: len(found)])
    for name, first in (("u", 0), ("rotation", 1)):
        worst = float(np.hypot(wrong[:, first], wrong[:, first + 2]).max(initial=0.0))
        row[f"{name}_error_pct"] = np.nan if twists or stopped else 100.0 * worst / far
    return row | {"message": stopped}


def _p_error(path: SpacePath, found: Array) -> float:
    """Return the largest error [%] of p in two planes, (2, depth, n), over the largest p; one slice at the tip."""
    heights = np.diff(path["depth_bounds"], axis=1)[:, 0]
    tip = path.depth > (1.0 - ZONE) * path.length
    share = heights[tip] / heights[tip].sum()
    both = path.reactions()[:, :, : found.shape[2]], found
    known, own = (np.concatenate([p[:, ~tip], (share @ p[:, tip])[:, None]], axis=1) for p in both)
    size = float(np.linalg.norm(known, axis=0).max())
    return 100.0 * float(np.linalg.norm(own - known, axis=0).max()) / size


COLUMNS = (
    Column("path", "path", words=True),
    Column("role", "role", words=True),
    Column("H [%]", "H_error_pct", ".1f"),
    Column("M [%]", "M_error_pct", ".1f"),
    Column("p [%]", "p_error_pct", ".1f"),
    Column("T [%]", "T_error_pct", ".1f"),
    Column("u [%]", "u_error_pct", ".1f"),
    Column("rot [%]", "rotation_error_pct", ".1f"),
)
_NOTES = (
    "H, M (M/L): largest error of the vector at the motions of the full model, over the largest (H, M/L) of the path; "
    "T (T/R): over the largest load; p: vectors by depth, over the largest p",
    "u, rot (rotation L): at its loads, over the largest motion of the path; '-': not carried, or undefined",
)


def in_space_text(frame: pd.DataFrame) -> str:
    """Return the errors on paths out of one plane as a table for a terminal, with definitions; empty without rows."""
    if frame.empty:
        return ""
    head = "paths out of one plane, answered by springs with memory"
    return "\n".join(["", head, Table.of(COLUMNS, frame.to_dict("records")).text(), "", *_NOTES]) + "\n"
