# SPDX-License-Identifier: MIT
"""Answers out of one plane: sequences of loads or motions in six degrees of freedom, and their errors.

Springs with memory that were calibrated on paths out of one plane, beside planar ones, answer them
(`[springs] memory = true, directions = true`); the other spring sets hold for one plane.
"""

from dataclasses import dataclass
from typing import Any, Literal, Protocol, Unpack

import numpy as np
import pandas as pd
import xarray as xr

from pysprings.core import variables
from pysprings.core.arguments import check_arrays, check_columns, check_rows
from pysprings.core.arrays import Array
from pysprings.core.errors import refused
from pysprings.core.path_kinds import HELD_BACK, TWIST
from pysprings.macro.answer import Care, raise_or_warn, trace
from pysprings.macro.model import MacroModel
from pysprings.macro.spring_sets import SPRING_SETS
from pysprings.macro.ways import RANGE_SLACK
from pysprings.springs.path import SPACE_LOADS, SPACE_TURNS, STRAIGHT, SpacePath, in_planes
from pysprings.springs.springs import Springs
from pysprings.springs.tip_zone import ZONE

SpaceControl = Literal["load", "state"]
MEMORY = "memory"  # the spring set that answers
_PARTS = np.array([[1.0, 1.0, 1.0, 1.0, 0.0], [0.0, 0.0, 0.0, 0.0, 1.0]])  # of motions: all but the twist, and that
TWISTED = 0.01  # lateral loads below this share of the torsion are none
_FROM = "paths out of one plane"
PLANE_ALONE = "the set '{}' answers loads in one plane only: ask for the springs 'memory'"
_UNCHECKED = (
    "{} of {} states go beyond the held-back paths out of one plane (lateral motions to {:.3g} of the range, twists to "
    "{:.3g}), or come after one"
)
_MOST_APART = 2.0  # difference of springs in space from those in one plane [%] that is no remark
_APART = "all rows lie in one plane: springs of that plane (columns H_N, M_Nm or u_m, rotation_rad) differ by {:.2g} %"
_NEVER = "springs in space, checked on no held-back path"
_MARKS = ("converged", "extrapolated", "unchecked", "off_load", "off_path", "torsion_apart")


class SpaceResponse(Protocol):
    """Springs that answer loads from all sides; motions (n, 5), loads (n, 5) as in `sequence_in_space`."""

    @property
    def has_torsion(self) -> bool:
        """Whether they carry torsion."""

    def solve(self, control: SpaceControl, targets: Array) -> tuple[Array, Array, str]:
        """Follow targets from rest; return motions, loads, and a message on where it ended."""

    def range_used(self, turns: Array) -> Array:
        """Return the size (n,) of motions over that of the paths behind the springs."""

    def answer(self, control: SpaceControl, targets: Array, V: Array | None, time: Array | None) -> xr.Dataset:
        """Return the states along targets as a dataset by step, marked."""

    def heave(self, turns: Array) -> Array:
        """Return w (n,) [m] under the V of the springs along motions from rest on."""

    def reactions(self, turns: Array) -> Array:
        """Return p in the planes of x and y by depth, (2, depth, n) [N/m], along motions from rest on."""


@dataclass(frozen=True, eq=False)
class SpaceAnswers:
    """Springs that answer loads from all sides, with what they were checked on.

    response : the springs.
    length : skirt length [m].
    checked : shares of their range that lateral motions, and twists alone, of held-back paths reach; 0 without any.
    errors : the largest errors on these paths, a sentence.
    """

    response: SpaceResponse
    length: float
    checked: tuple[float, float]
    errors: str

    @classmethod
    def of(cls, springs: Springs | xr.DataTree, springs_kind: str | None = None) -> "SpaceAnswers":
        """Return the springs in space of a set, checked. Raises UserInputError where there are none."""
        given = Springs.of(springs)
        response, checked, texts = response_in_space(given, springs_kind), [0.0, 0.0], []
        for path in given.space.values():
            if path.role != HELD_BACK or path.n < 2:
                continue
            part = int(path.kind == TWIST)
            checked[part] = max(checked[part], float(response.range_used(path.turns() * _PARTS[part]).max()))
            row = _row(given, response, path)
            sizes = {name: row[f"{name}_error_max_pct"] for name in ("T",) * part or ("H", "M", "u", "rotation")}
            words = ", ".join(f"{name} {size:.1f} %" for name, size in sizes.items() if np.isfinite(size))
            w = 1e3 * row["w_error_max_m"], 1e3 * np.abs(path["w"] - path["w"][0]).max()
            texts.append(f"{path.name} {words}, w {abs(w[0]):.2g} of {w[1]:.2g} mm")
        errors = f"springs in space, errors on held-back paths: {'; '.join(texts)}" if texts else _NEVER
        return cls(response, given.length, (checked[0], checked[1]), errors)

    def answer(
        self, control: SpaceControl, targets: Array, V: Array | None = None, time: Array | None = None
    ) -> xr.Dataset:
        """Return the states along targets (n, 5) from rest as a dataset by step, marked."""
        found = self.response.answer(control, targets, V, time)
        turns = np.stack([found[name].values for name in SPACE_TURNS], axis=1)
        lateral, twist = (self.response.range_used(turns * part) for part in _PARTS)
        past = lateral > self.checked[0] * (1.0 + RANGE_SLACK)
        past |= (twist > lateral) & (twist > self.checked[1] * (1.0 + RANGE_SLACK))
        past = np.logical_or.accumulate(past) & (found["extrapolated"].values == 0)
        texts = [_UNCHECKED.format(past.sum(), len(past), *self.checked)] if past.any() else []
        attrs = {name: [*found.attrs[name], *more] for name, more in (("warnings", texts), ("remarks", [self.errors]))}
        mark = variables.described({"unchecked": past.astype(np.int8)}, "space_prediction")
        return found.assign(mark).assign_attrs(attrs)

    def cases(self, pushes: Array, V: Array) -> dict[str, Array]:
        """Return motions and marks (n,) of independent loads (n, 5), each reached in proportion from rest, by name.

        V [N] is NaN for that of the springs. Without an equilibrium motions are NaN, and `converged` is 0.
        """
        out = {name: np.full(len(pushes), np.nan) for name in (*SPACE_TURNS, "w", "range_used")}
        out |= {name: np.zeros(len(pushes), dtype=np.int8) for name in _MARKS}
        for k, push in enumerate(pushes):
            found = self.answer("load", push[None], None if np.isnan(V[k]) else V[[k]])
            for name in () if found.attrs["message"] else out:
                out[name][k] = found[name].values[0] if name in found else 0
        return out


def answers_in_space(springs: Any, springs_kind: str | None = None, path: str | None = None) -> SpaceAnswers | None:
    """Return the springs that answer loads from all sides; None where there are none, or others are asked for."""
    chosen = SPRING_SETS.find(springs_kind or MEMORY, "springs_kind")
    here = isinstance(springs, Springs) and path is None and chosen.in_space is not None and _has_space(springs)
    return SpaceAnswers.of(springs, springs_kind) if here else None


def _has_space(springs: Springs) -> bool:
    lateral = any(path.kind != TWIST for path in springs.turning)
    return lateral and SPRING_SETS[MEMORY].ready(springs.at())


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
    check_columns(targets, SPACE_LOADS if control == "load" else SPACE_TURNS)
    rows = np.asarray(targets, dtype=float)
    check_rows(rows, V, time)
    down = None if V is None else np.broadcast_to(np.asarray(V, dtype=float), len(rows)).copy()
    answer = SpaceAnswers.of(springs, springs_kind).answer(control, rows, down, time)
    apart = _plane_difference(Springs.of(springs), rows, control, answer)
    remarks = [*answer.attrs["remarks"], *[_APART.format(apart)] * (apart > _MOST_APART)]
    return raise_or_warn(answer.assign_attrs(remarks=remarks), **care)


def _plane_difference(springs: Springs, rows: Array, control: SpaceControl, answer: xr.Dataset) -> float:
    """Return how far an answer is from springs of the plane in which all rows (n, 5) lie [%]; 0 where they leave one.

    That is the largest difference of (u, rotation L), or of (H, M/L) at given motions, over the largest.
    """

    def along(table: Array) -> Array:
        return np.stack([table[:, :2], np.stack([table[:, 3], -table[:, 2]], axis=1)])

    given = along(rows)
    size = np.maximum(np.abs(given).max(axis=(1, 2), keepdims=True), 1e-300)
    _, spread, axes = np.linalg.svd((given / size).reshape(-1, 2))
    if rows[:, 4].any() or spread[1] > STRAIGHT * spread[0]:
        return 0.0
    names = SPACE_TURNS if control == "load" else SPACE_LOADS
    plane = trace(MacroModel.from_springs(springs, MEMORY), control, (given @ axes[0]).T)
    other = np.stack([plane[name].values for name in (("u", "rotation") if control == "load" else ("H", "M"))])
    own = along(np.stack([answer[name].values for name in names], axis=1)) @ axes[0]
    n, length = min(own.shape[1], other.shape[1]), springs.length ** (1.0 if control == "load" else -1.0)
    own, other = own[:, :n] * [[1.0], [length]], other[:, :n] * [[1.0], [length]]
    return 100.0 * float(np.hypot(*(own - other)).max(initial=0.0) / max(np.hypot(*other).max(initial=0.0), 1e-300))


def response_in_space(springs: Springs | xr.DataTree, springs_kind: str | None = None) -> SpaceResponse:
    """Return the springs that answer loads from all sides. Raises UserInputError where there are none."""
    chosen = SPRING_SETS.find(springs_kind or MEMORY, "springs_kind")
    if chosen.in_space is None:
        raise refused("springs_kind", PLANE_ALONE.format(chosen.name))
    return chosen.in_space(Springs.of(springs))


def compare_in_space(springs: Springs | xr.DataTree) -> pd.DataFrame:
    """Return the errors of springs on the paths out of one plane, rows of a comparison; empty where none answers.

    At the motions of the full model: largest error of H and M/L, as vectors, over the largest (H, M/L) of the path [%],
    of T/R over the largest load, and of p by depth, as vectors, over the largest p (the last fifth of the skirt is one
    slice). Under its loads: largest error of (u_x, u_y) and of the rotation L over the
    largest motion, NaN where the springs do not carry the loads. T is NaN without springs of torsion. Of w [m] the
    largest distance at the motions and under the loads.
    """
    given = Springs.of(springs)
    if not _has_space(given):
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
    given, own = path.loads(radius)[1:], in_planes(carried, 1.0 / length, 1.0 / radius)
    size, whole = (float(np.linalg.norm(given[:, :n], axis=1).max()) for n in (4, 5))
    missing = np.abs(own - given[: len(own)])
    twists = not size > TWISTED * whole
    used = response.range_used(path.turns())
    row: dict[str, Any] = {"path": path.name, "role": path.role, "kind": path.kind, "springs": MEMORY}
    row |= {"springs_from": _FROM, "V_N": path.load, "status": held or "complete", "path_end": path.end.how}
    row |= {"states": path.n - 1, "depths": path.depth.size, "depths_unusable": 0, "off_path_states": 0}
    row |= {"off_load_states": 0, "extrapolated_states": int((used > 1.0 + RANGE_SLACK).sum())}
    for name, first in (("H", 0), ("M", 1)):
        worst = float(np.hypot(missing[:, first], missing[:, first + 2]).max())
        row[f"{name}_error_max_pct"] = np.nan if twists else 100.0 * worst / size
    row["p_error_max_pct"] = np.nan if twists else _p_error(path, response.reactions(motions)[:, :, : len(own) + 1])
    row["T_error_max_pct"] = 100.0 * float(missing[:, 4].max()) / whole if response.has_torsion else np.nan
    known, found = path.motions(radius)[1:], in_planes(moved, length, radius)
    far, wrong = float(np.linalg.norm(known[:, :4], axis=1).max()), np.abs(found - known[: len(found)])
    for name, first in (("u", 0), ("rotation", 1)):
        worst = float(np.hypot(wrong[:, first], wrong[:, first + 2]).max(initial=0.0))
        row[f"{name}_error_max_pct"] = np.nan if twists or stopped else 100.0 * worst / far
    w = [response.heave(np.vstack([motions[:1], turns])) for turns in (motions[1:], moved)]
    off = np.concatenate([each - each[0] - (path["w"][: len(each)] - path["w"][0]) for each in w])
    return row | {"states_at_load": len(moved), "w_error_max_m": float(off[np.argmax(np.abs(off))])}


def _p_error(path: SpacePath, found: Array) -> float:
    """Return the largest error [%] of p in two planes, (2, depth, n), over the largest p; one slice at the tip."""
    heights = np.diff(path["depth_bounds"], axis=1)[:, 0]
    tip = path.depth > (1.0 - ZONE) * path.length
    share = heights[tip] / heights[tip].sum()
    both = path.reactions()[:, :, : found.shape[2]], found
    known, own = (np.concatenate([p[:, ~tip], (share @ p[:, tip])[:, None]], axis=1) for p in both)
    size = float(np.linalg.norm(known, axis=0).max())
    return 100.0 * float(np.linalg.norm(own - known, axis=0).max()) / size
