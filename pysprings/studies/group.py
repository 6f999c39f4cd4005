# SPDX-License-Identifier: MIT
"""Caissons under one frame: load cases of the group shared among them, each answered as a load case of its own.

The frame is rigid. With its motion q = (u, w, rotation, roll) at the origin of the positions, in the vertical plane of
H, a caisson at x along that plane and y to its left moves by

    u_i = u,   w_i = w + x rotation - y roll,   rotation_i = rotation - M_i/k,

k the rotational stiffness of its joint with the frame, and equilibrium asks for

    H = sum H_i,   V = sum V_i,   M = sum (M_i + x V_i),   M_across = -sum y V_i.

The springs answer motions d to loads f (`macro.batch`), with the tangent K. Newton's iteration for loads that give
motions of one frame is

    f_i <- f_i + K_i (B_i q - d_i),   (sum B_i^T K_i B_i) q = F - sum B_i^T (f_i - K_i d_i),

d_i = B_i q the motions above; loads are in equilibrium after each whole step. A torsion, and that of H beside the
middle of its shares, is shared as forces across the arm of each, T r_i/sum r^2. Left out: bending of the caissons
across the plane, the twist of the frame, and interaction through the soil, whose size in an elastic half-space is
stated (`Group.interaction`).
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pysprings.core.arrays import Array
from pysprings.core.errors import refused
from pysprings.core.loads import in_plane
from pysprings.core.tables import Column, one_table
from pysprings.core.tables.headings import TEXT
from pysprings.core.tables.load_cases import OPPOSED, LoadCases
from pysprings.core.text import number
from pysprings.core.units import quoted
from pysprings.macro.batch import answer_loads
from pysprings.macro.model import AnySprings
from pysprings.studies.design import answer_cases, not_tolerated, verdicts, with_larger, with_tilt

COLUMNS = (
    Column("bucket", TEXT, ("name", "caisson", "leg")), Column.named("x_m", ("east",)), Column.named("y_m", ("north",)),
)  # fmt: skip
LEAST, NARROW = 3, 0.2  # caissons of a group, and its width over its length
MOST = 30  # Newton iterations of one share of a case
CLOSE = 1e-6  # of the largest motion: differences of the caissons' motions from those of the frame
LEAST_STEP = 1.0 / 64.0  # share of a case
LEAST_TORSION = 0.01  # of forces times their arms: less is left
OF_PLACES = 1e-4  # share of M up to which its part across the plane of H comes from places in cm
_HALVINGS = 6
_MOTIONS = ("u", "w", "rotation")


@dataclass(frozen=True)
class Group:
    """Caissons under one frame.

    name : by caisson.
    at : (n, 2) positions x, y [m] in plan of the axes of load cases; their origin is the point of M and across.
    joint : rotational stiffness [N m/rad] of each joint with the frame; inf: rigid.
    """

    name: tuple[str, ...]
    at: Array
    joint: float = np.inf

    @property
    def spacing(self) -> float:
        """Smallest distance [m] between two axes."""
        apart = np.linalg.norm(self.at[:, None] - self.at, axis=-1)
        return float(apart[apart > 0.0].min())

    def interaction(self, diameter: float) -> tuple[float, float]:
        """Return by how much neighbours add to the settlement and to u of a caisson, at most, in elasticity.

        Rough rigid discs on a half-space, displacements by others those of point forces: w of one disc is
        Q (1 - nu)/(4 G R), of a force at distance s Q (1 - nu)/(2 pi G s) (Boussinesq 1885), so that each adds
        D/(pi s); u along the force is Q (2 - nu)/(8 G R) and Q/(2 pi G s) (Cerruti 1882): 2 D/(pi s (2 - nu)),
        with nu 0.5, which adds most.
        """
        apart = np.linalg.norm(self.at[:, None] - self.at, axis=-1)
        near = (diameter / (np.pi * apart[apart > 0.0].reshape(len(self.name), -1))).sum(axis=1).max()
        return float(near), float(2.0 * near / (2.0 - 0.5))


def read_group(path: Path, joint: float = np.inf) -> Group:
    """Read the positions of caissons from a table with the columns bucket, x and y, units in the headings."""
    table = one_table(path, COLUMNS, "positions of caissons")
    for name in ("x_m", "y_m"):
        if table.head and name not in table:
            table.fault(None, None, f"no column {name[0]} [m]")
    table.stop_at_head()
    names, at = table.texts("bucket"), np.stack([table.numbers("x_m"), table.numbers("y_m")], axis=1)
    for k, position in enumerate(at):
        if not np.isfinite(position).all():
            table.fault(k, "x_m", "blank: a position has x and y")
        if any(np.array_equal(position, other) for other in at[:k]):
            table.fault(k, "x_m", "two caissons at one place")
        if names[k] and names[k] in names[:k]:
            table.fault(k, "bucket", f"{quoted(names[k])} is the name of another caisson")
    if len(at) < LEAST:
        table.fault(None, None, f"a group has {LEAST} caissons or more")
    table.faults.stop()
    wide, narrow = np.linalg.svd(at - at.mean(axis=0), compute_uv=False)
    if narrow < NARROW * wide:
        table.fault(None, None, "the caissons stand on a line: push and pull carry no moment across it")
    table.faults.stop()
    return Group(tuple(name or str(k + 1) for k, name in enumerate(names)), at, joint)


def answer_group(
    springs: AnySprings, cases: LoadCases, group: Group, tilt: float | None = None, extrapolate: bool = False,
    **choice: Any,
) -> pd.DataFrame:  # fmt: skip
    """Return the answers to load cases of a group, a row a case and caisson; see `design.answer_cases`.

    The tilt is that of the frame; attrs["group"] is a sentence on the group. Cases whose V is not given have that of
    the springs at each caisson. A case whose whole load finds no equilibrium has no answer.
    """
    rest = answer_loads(springs, np.zeros((1, 2)), np.array([np.nan]), **choice)
    if "w" not in rest:
        raise refused("--group", "these springs have no vertical path: nothing shares V and M among caissons")
    D = float(rest.attrs.get("outer_diameter_m", np.nan))
    if group.spacing <= D:
        raise refused("--group", f"axes {group.spacing:g} m apart: caissons of {D:g} m overlap")
    at_rest = float(rest["V"].values[0])
    found = [_shared(springs, cases, k, group, at_rest, extrapolate, choice) for k in range(len(cases))]
    failed = np.array([why for *_, why in found])
    rows = np.repeat(np.arange(len(cases)), len(group.name))
    every = _of_buckets(cases, group, [loads for loads, *_ in found])
    own = replace(every, tilt=np.full(len(every), np.nan))  # the tilt that counts is that of the frame
    frame = answer_cases(springs, own, np.nan, extrapolate, **choice)
    motions, lost = np.stack([q for _, q, _ in found])[rows], (failed != "")[rows]
    motions[lost] = np.nan
    frame = frame.assign(group_u_m=motions[:, 0], group_w_m=motions[:, 1], group_rotation_rad=motions[:, 2])
    turn = np.hypot(motions[:, 2], motions[:, 3])
    frame = frame.assign(group_roll_rad=motions[:, 3], group_tilt_deg=np.degrees(turn))
    frame = with_tilt(frame, turn, springs, every, tilt)
    frame["marks"] = _with_mesh_error(
        frame, cases, lambda larger, k: _shared(springs, larger, k, group, at_rest, extrapolate, choice)
    )
    kept = ("direction_deg", "tilt_limit_deg")
    frame.loc[lost, [name for name in frame if frame[name].dtype.kind == "f" and name not in kept]] = np.nan
    frame.loc[lost, ["answered", "capacity_kind"]] = 0, ""
    frame.loc[lost, "marks"] = failed[rows][lost]
    remarks = (text.split("; ") for text in frame["remarks"])  # a caisson under a frame has an M against H as a rule
    frame["remarks"] = ["; ".join(text for text in own if not text.startswith(OPPOSED)) for own in remarks]
    frame = frame.assign(verdict=verdicts(frame))
    frame.attrs["group"] = _words(group, D)
    return frame


def _with_mesh_error(frame: pd.DataFrame, cases: LoadCases, shared: Any) -> list[str]:
    """Return the marks of rows, and of tilts of the frame not tolerated at H and M larger by the error of the mesh."""
    marks = []
    for k, (_, rows) in enumerate(frame.groupby(np.arange(len(frame)) // (len(frame) // len(cases)))):
        error, limit = float(rows["mesh_error_pct"].max()), float(rows["tilt_limit_deg"].iloc[0])
        texts = []
        if error > 0.0 and (rows["tilt_used"] <= 1.0).all():
            more = {name: (1.0 + 0.01 * error) * getattr(cases, name) for name in ("H", "M", "across")}
            _, q, lost = shared(replace(cases, **more), k)
            turn = float(np.degrees(np.hypot(q[2], q[3])))
            texts = [lost] if lost else [not_tolerated(turn)] * (turn > limit)
        marks += [with_larger(own, error, texts) for own in rows["marks"]]
    return marks


def _words(group: Group, diameter: float) -> str:
    """Return a sentence on the group and what is left out."""
    down, along = (number(100.0 * each, 2) for each in group.interaction(diameter))
    joints = "rigid" if np.isinf(group.joint) else f"of {number(1e-6 * group.joint)} MN m/rad"
    return (
        f"{len(group.name)} caissons under a rigid frame, joints {joints}; loads act at the origin of the positions. "
        f"Left out are the twist of the frame, bending of caissons across the plane of H, and interaction through the "
        f"soil: in an elastic half-space neighbours add at most {down} % to the settlement and {along} % to u "
        "(Boussinesq, Cerruti)"
    )


def _of_buckets(cases: LoadCases, group: Group, loads: list[Array]) -> LoadCases:
    """Return the load cases of all caissons: loads (n, 3) = (H, V, M) in the plane of each case, and the torsion."""
    n, m = len(cases), len(group.name)
    H, V, M = np.concatenate(loads).T
    way = np.repeat(cases.direction, m)
    along = np.stack([np.cos(way), np.sin(way)], axis=1)
    arm = group.at - group.at.mean(axis=0)
    around = np.tile(np.stack([-arm[:, 1], arm[:, 0]], axis=1) / (arm**2).sum(), (n, 1))
    turning = (group.at[:, 0] * (H * along[:, 1]).reshape(n, m) - group.at[:, 1] * (H * along[:, 0]).reshape(n, m)).sum(
        axis=1
    )
    force = H[:, None] * along + np.repeat(cases.torsion - turning, m)[:, None] * around
    planes = in_plane(force, M[:, None] * along, OF_PLACES * np.outer(np.abs(M), [0.01, 1.0]))
    least = LEAST_TORSION * np.abs(H * np.tile(np.hypot(*group.at.T), n)).reshape(n, m).sum(axis=1)
    turned = np.repeat((cases.torsion != 0.0) | (np.abs(turning) > least), m)
    H, M, across = (np.where(turned, a, b) for a, b in ((planes.H, H), (planes.M, M), (planes.across, 0.0 * H)))
    return replace(
        cases,
        name=tuple(f"{case}, {bucket}" for case in cases.name for bucket in group.name),
        limit_state=tuple(np.repeat(cases.limit_state, m)),
        remarks=tuple(np.repeat(cases.remarks, m)),
        line=np.repeat(cases.line, m), tilt=np.repeat(cases.tilt, m),
        H=H, V=V, M=M, across=across, torsion=np.zeros(n * m), direction=np.where(turned, planes.direction, way),
    )  # fmt: skip


def _shared(
    springs: AnySprings, cases: LoadCases, k: int, group: Group, at_rest: float, extrapolate: bool,
    choice: dict[str, Any],
) -> tuple[Array, Array, str]:  # fmt: skip
    """Return loads (n, 3) = (H, V, M) of the caissons, the motion q (4,) of the frame, and why a case has no answer.

    A V that is not given is that of the springs, `at_rest`, at each caisson; a given one acts at the origin.
    """
    n, why = len(group.name), [""]

    def answer(loads: Array) -> tuple[Array, Array] | None:
        """Return motions (n, 3) at the frame and tangents (n, 3, 3) there; None where a caisson has no answer."""
        found = answer_loads(springs, loads[:, [0, 2]], loads[:, 1], extrapolate, **choice)
        if not found["answered"].values.all():
            k = int(np.argmin(found["answered"].values))
            why[0] = f", then {group.name[k]}: {found['why_not'].values[k]}"
            return None
        motions = np.stack([found[name].values for name in _MOTIONS], axis=1)
        motions[:, 2] += loads[:, 2] / group.joint
        softer = np.linalg.inv(found["stiffness"].values)
        softer[:, 2, 2] += 1.0 / group.joint
        return motions, np.linalg.inv(softer)

    given = bool(np.isfinite(cases.V[k]))
    V = np.full(n, cases.V[k] / n if given else at_rest)
    c, s = np.cos(cases.direction[k]), np.sin(cases.direction[k])
    frame = _frame(group.at @ np.array([[c, -s], [s, c]]))
    loads = np.stack([0.0 * V, V, 0.0 * V], axis=1)
    own = np.array([0.0, V.sum(), 0.0, 0.0]) if given else np.einsum("nij,ni->j", frame, loads)
    target = own + [cases.H[k], 0.0, cases.M[k], cases.across[k]]
    loads, q, share = _followed(answer, frame, loads, target)
    lost = f"the group is in equilibrium up to {100.0 * share:.0f} % of the case{why[0]}"
    return loads, q, lost if share < 1.0 else ""


def _frame(at: Array) -> Array:
    """Return B (n, 3, 4): motions of caissons at (x, y) (n, 2) under those of the frame."""
    B = np.zeros((len(at), 3, 4))
    B[:, 0, 0] = B[:, 1, 1] = B[:, 2, 2] = 1.0
    B[:, 1, 2], B[:, 1, 3] = at[:, 0], -at[:, 1]
    return B


def _followed(answer: Any, frame: Array, loads: Array, target: Array) -> tuple[Array, Array, float]:
    """Follow the loads from those at rest to a target (4,), in steps that are halved where one fails."""
    rest, q, share, step = np.einsum("nij,ni->j", frame, loads), np.zeros(4), 0.0, 1.0
    while share < 1.0 and step >= LEAST_STEP:
        goal = min(1.0, share + step)
        found = _balanced(answer, frame, loads, rest + goal * (target - rest))
        if found is None:
            step *= 0.5
            continue
        (loads, q), share = found, goal
    return loads, q, share


def _balanced(answer: Any, frame: Array, loads: Array, target: Array) -> tuple[Array, Array] | None:
    """Return loads (n, 3) under a target (4,) at which all caissons move as the frame does, and its motion (4,)."""
    state, arm = answer(loads), np.array([1.0, 1.0, np.abs(frame[:, 1, 2:]).max()])
    for _ in range(MOST):
        if state is None:
            return None
        motions, K = state
        left = target - np.einsum("nij,ni->j", frame, loads - np.einsum("nij,nj->ni", K, motions))
        q = np.linalg.lstsq(np.einsum("nik,nij,njl->kl", frame, K, frame), left, rcond=None)[0]
        missed = frame @ q - motions
        change = np.einsum("nij,nj->ni", K, missed)
        if np.abs(arm * missed).max() <= CLOSE * max(np.abs(arm * motions).max(), 1e-9):
            return (loads, q) if _in_equilibrium(frame, loads, target) else None
        for _ in range(_HALVINGS):
            if (state := answer(loads + change)) is not None:
                break
            change = 0.5 * change
        loads = loads + change
    return None


def _in_equilibrium(frame: Array, loads: Array, target: Array) -> bool:
    """Return whether loads (n, 3) of caissons sum to those of the frame (4,)."""
    sums, sizes = (np.einsum("nij,ni->j", *each) for each in ((frame, loads), (np.abs(frame), np.abs(loads))))
    return bool((np.abs(sums - target) <= CLOSE * (sizes + np.abs(target).max())).all())
