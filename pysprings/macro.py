# SPDX-License-Identifier: MIT
"""Rigid caisson on nonlinear springs: load and rotation in milliseconds, from the spring file alone.

Degrees of freedom: u (lateral, lid centre at mudline, +x), rotation (right-hand about +y); w follows.
Loads: H (N) at height arm (m) above mudline, that is M = -H*arm about the lid centre.

Three spring sets. From the reactions along one path of the full model:

- "full": p(y) by depth, m(rotation) by depth, tip H(y_tip) and M(rotation), lid H(u) and M(rotation);
- "py": p(y) alone, as in a plain Winkler model; the moment is resisted by p*z only.

From all its calibration paths of constant ratio rotation/u, two at least:

- "fan": all reactions by (u, rotation*L) in magnitude and angle (`macro_fan`); it predicts on other paths.

What the springs do not know, an answer says: `extrapolated` (beyond the calibrated displacements, where
curves go on with their last slope), `off_path` (springs of one path: far from it, their p and m hold on that
path only; a fan: between rays more than 60 degrees apart) and a vertical load other than that of the path
(answered by the elastic vertical stiffness of the full model). With `strict` such an answer is refused.
Springs are odd: a load towards -x is the mirror image of one towards +x.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pysprings import variables
from pysprings.errors import RunIncomplete
from pysprings.macro_answer import answer_dataset, check_finite, refused
from pysprings.macro_fan import FanTable, build_fan, has_fan
from pysprings.macro_solver import FAN, ROWS, follow, reactions
from pysprings.macro_tables import SPRING_SETS, SpringSet, SpringTable, build_table
from pysprings.springs import get_path

Array = NDArray[np.float64]
Control = Literal["displacement", "rotation", "load", "state"]


class MacroWarning(UserWarning):
    """An answer of the macro-model that the springs support only in part."""


class PredictionNotConverged(RunIncomplete):
    """No equilibrium was found beyond a load; the message names it and the part that was reached."""


@dataclass(frozen=True, slots=True)
class MacroModel:
    """A rigid caisson on the springs of one path, or of a fan of paths; built once, asked often.

    Attributes
    ----------
    table
        The springs as interpolation tables.
    spring_set
        "fan", "full" or "py".
    origin
        Converged steps of the path the springs come from; of the first ray of a fan.
    stiffness_initial
        (3, 3) initial tangent of the full model for (u, w, rotation).
    attrs
        Attributes of the spring set (geometry, provenance).
    """

    table: SpringTable | FanTable
    spring_set: SpringSet
    origin: xr.Dataset
    stiffness_initial: Array
    attrs: dict[str, Any]

    @classmethod
    def from_springs(cls, springs: xr.DataTree, springs_kind: str | None = None, path: str | None = None) -> MacroModel:
        """Build the model from a spring set: its fan where it has one, else all springs of its first calibration path.

        springs_kind chooses "fan", "full" or "py"; path the path whose springs serve (for "full" and "py").
        """
        kind = _spring_set(springs, springs_kind, path)
        table: SpringTable | FanTable
        if kind == "fan":
            table = build_fan(springs)
            origin = get_path(springs, table.path[0])
        else:
            origin = get_path(springs, path)
            table = build_table(origin, kind)
        stiffness = springs.dataset["stiffness_initial"].values
        return cls(table, kind, origin, stiffness, {str(name): value for name, value in springs.attrs.items()})

    @property
    def length(self) -> float:
        """Skirt length [m]."""
        return float(self.attrs["skirt_length_m"])

    @property
    def _springs(self) -> tuple[int, Array, Array, Array, Array, Array, NDArray[np.int64]]:
        return FAN if isinstance(self.table, FanTable) else ROWS, *self.table.solver_arrays

    def reactions(self, u: float, rotation: float) -> tuple[Array, Array]:
        """Return the loads (H [N], M [N m]) that hold a state, and their tangent (2, 2) to (u, rotation)."""
        force, tangent = np.zeros(2), np.zeros((2, 2))
        reactions(*self._springs, float(u), float(rotation), force, tangent)
        return force, tangent

    def tangent_stiffness(self, u: float = 0.0, rotation: float = 0.0) -> xr.DataArray:
        """Return the tangent stiffness (3, 3) at mudline for (u, w, rotation) at a state.

        u and rotation come from the springs; w is the elastic stiffness of the full model, uncoupled.
        Units: N/m for displacements, N m/rad for rotation, N/rad = N m/m between them.
        """
        matrix = np.zeros((3, 3))
        matrix[np.ix_([0, 2], [0, 2])] = self.reactions(u, rotation)[1]
        matrix[1, 1] = self.stiffness_initial[1, 1]
        dofs = list(variables.DOFS)
        attrs = {
            "long_name": "tangent stiffness at the lid centre",
            "units": "1",
            "springs": self.spring_set,
            "comment": variables.GROUPS["springs_root"]["stiffness_initial"].comment,
        }
        return xr.DataArray(matrix, {"dof": dofs, "dof_conjugate": dofs}, ("dof", "dof_conjugate"), attrs=attrs)

    def solve(self, control: Control, targets: Array, arm: float = 0.0) -> tuple[Array, Array, str]:
        """Follow the equilibrium from the origin through targets.

        Parameters
        ----------
        control
            "displacement" (u with the load at height arm), "rotation" (rotation with the load at height arm),
            "load" (H, M) or "state" (u and rotation imposed).
        targets
            (n, 2): (u, -), (rotation, -), (H, M) or (u, rotation); the - columns are not read.
        arm
            Height of the load above mudline [m].

        Returns
        -------
        tuple
            States (k, 2) = (u, rotation), loads (k, 2) = (H, M), and a message that says where it ended
            when k < n.
        """
        G, C, scale, aims = _equations(control, np.asarray(targets, dtype=float), arm, self.table.load_scale)
        steps = np.concatenate([np.zeros((1, 2)), aims])
        out = np.zeros((2, *steps.shape))
        n, at0, at1 = follow(*self._springs, G, C, scale, np.zeros(2), steps, out[0], out[1])
        states, loads = out[0, 1:n], out[1, 1:n]
        return (
            states,
            loads,
            "" if n == len(steps) else _ending(control, (at0, at1), aims[n - 1], states, loads),
        )

    def trace(self, control: Control, targets: Array, arm: float = 0.0, V: float | None = None) -> xr.Dataset:
        """Return the answer to `solve` as a dataset by step, with marks for what the springs do not support.

        A path that ends early holds the steps reached; `status` is then "partial" and `message` says where.
        """
        states, loads, message = self.solve(control, targets, arm)
        return answer_dataset(self, states, loads, V, {"control": control, "arm_m": float(arm)}, message)

    def curve(
        self, u_max: float, arm: float = 0.0, n: int = 50, V: float | None = None, strict: bool = False
    ) -> xr.Dataset:
        """Return n states from the origin to a lateral displacement u_max [m], load at height arm [m]."""
        check_finite(u_max=u_max, arm=arm)
        targets = np.zeros((_points(n), 2))
        targets[:, 0] = np.linspace(0.0, u_max, n)
        return _spoken(self.trace("displacement", targets, arm, V), strict)

    def predict(
        self,
        H: float,
        arm: float | None = None,
        M: float | None = None,
        V: float | None = None,
        n: int = 26,
        strict: bool = False,
    ) -> xr.Dataset:
        """Return n states from the origin to the load H [N] at height arm [m], or with moment M [N m].

        H and M grow in proportion; the last step is the answer.
        """
        if arm is not None and M is not None:
            raise refused("arm", "give the height of the load or its moment, not both")
        check_finite(H=H, **{name: value for name, value in (("arm", arm), ("M", M)) if value is not None})
        moment = M if M is not None else -H * (arm or 0.0)
        height = arm if arm is not None else (-moment / H if H else 0.0)
        targets = np.linspace(0.0, 1.0, _points(n))[:, None] * np.array([H, moment], dtype=float)
        return _spoken(self.trace("load", targets, height, V), strict)


def predict(
    springs: xr.DataTree | MacroModel,
    *,
    H: float,
    arm: float | None = None,
    M: float | None = None,
    V: float | None = None,
    springs_kind: str | None = None,
    path: str | None = None,
    n: int = 26,
    strict: bool = False,
) -> xr.Dataset:
    """Predict the motion under a lateral load H [N] at height arm [m] above mudline, or with moment M [N m].

    Returns n states (dimension step) from the origin to the load; the last one is the answer. With neither
    arm nor M the load acts at the mudline. `springs` may be a model built before, when many cases are asked.

    Raises
    ------
    PredictionNotConverged
        No equilibrium beyond the load named in the message.
    UserInputError
        With strict: the springs support the answer only in part. Without, that is a MacroWarning.
    """
    return _model(springs, springs_kind, path).predict(H, arm=arm, M=M, V=V, n=n, strict=strict)


def curve(
    springs: xr.DataTree | MacroModel,
    *,
    u_max: float,
    arm: float = 0.0,
    n: int = 50,
    V: float | None = None,
    springs_kind: str | None = None,
    path: str | None = None,
    strict: bool = False,
) -> xr.Dataset:
    """Return the load-displacement curve, n points to u_max [m] at the lid centre, load at height arm [m]."""
    return _model(springs, springs_kind, path).curve(u_max, arm=arm, n=n, V=V, strict=strict)


def tangent_stiffness(
    springs: xr.DataTree,
    u: float = 0.0,
    rotation: float = 0.0,
    springs_kind: str | None = None,
    path: str | None = None,
) -> xr.DataArray:
    """Return the tangent stiffness (3, 3) at mudline for (u, w, rotation) at a state (m, rad)."""
    return MacroModel.from_springs(springs, springs_kind, path).tangent_stiffness(u, rotation)


def _model(springs: xr.DataTree | MacroModel, springs_kind: str | None, path: str | None) -> MacroModel:
    return springs if isinstance(springs, MacroModel) else MacroModel.from_springs(springs, springs_kind, path)


def spring_sets(springs: xr.DataTree) -> list[SpringSet]:
    """Return the spring sets that a spring file can give: a fan needs two rays at least."""
    return [name for name in SPRING_SETS if name != "fan" or has_fan(springs)]


def _spring_set(springs: xr.DataTree, name: str | None, path: str | None) -> SpringSet:
    if name is None:
        return "fan" if path is None and has_fan(springs) else "full"
    for known in SPRING_SETS:
        if name == known:
            if known == "fan" and path is not None:
                raise refused("path", "a fan comes from all calibration paths: ask for the springs 'full' or 'py'")
            return known
    raise refused("springs_kind", f"'{name}' is not one of {', '.join(SPRING_SETS)}")


def _equations(control: Control, targets: Array, arm: float, size: Array) -> tuple[Array, Array, Array, Array]:
    """G, C (2, 2), the sizes of both equations, and the right sides c (n, 2): see `macro_solver`."""
    zero, one = np.zeros((2, 2)), np.eye(2)
    if control == "load":
        return zero, one, size, targets
    motion = np.maximum(np.abs(targets).max(axis=0), 1e-12)
    if control == "state":
        return one, zero, motion, targets
    row = 0 if control == "displacement" else 1
    G, C = zero.copy(), np.array([[0.0, 0.0], [arm, 1.0]])
    G[0, row] = 1.0
    aims = np.stack([targets[:, 0], np.zeros(len(targets))], axis=1)
    return G, C, np.array([motion[0], size[1] + abs(arm) * size[0]]), aims


def _ending(control: Control, reached: tuple[float, float], wanted: Array, states: Array, loads: Array) -> str:
    """Say where a path ended: what was held, what was wanted next, the last state."""
    words = {
        "displacement": ("u = {:.6g} m",),
        "rotation": ("rotation = {:.6g} rad",),
        "load": ("H = {:.6g} N", "M = {:.6g} N m"),
        "state": ("u = {:.6g} m", "rotation = {:.6g} rad"),
    }[control]
    got, aim = (", ".join(w.format(x) for w, x in zip(words, values, strict=False)) for values in (reached, wanted))
    last = "no step was reached"
    if len(states):
        (u, rotation), (H, M) = states[-1], loads[-1]
        last = f"last step: u = {u:.6g} m, rotation = {rotation:.6g} rad, H = {H:.6g} N, M = {M:.6g} N m"
    return f"macro-model: no equilibrium beyond {got} on the way to {aim}; {last}"


def _spoken(answer: xr.Dataset, strict: bool) -> xr.Dataset:
    """Raise when an answer is partial, warn (refuse, when strict) where it says so; else hand it on."""
    if answer.attrs["status"] != "complete":
        raise PredictionNotConverged(answer.attrs["message"])
    notes = [note for note in answer.attrs["warnings"].split(" | ") if note]
    if strict and notes:
        raise refused("strict", "; ".join(notes))
    for note in notes:
        warnings.warn(note, MacroWarning, stacklevel=4)
    return answer


def _points(n: int) -> int:
    if n < 2:
        raise refused("n", f"{n} points: at least 2 are needed")
    return n
