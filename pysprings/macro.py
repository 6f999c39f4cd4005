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
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pysprings import variables
from pysprings.errors import RunIncomplete
from pysprings.macro_answer import answer_dataset, check_finite, refused
from pysprings.macro_control import Control, ending, equations
from pysprings.macro_curves import CurveSprings
from pysprings.macro_fan import FanTable, build_fan
from pysprings.macro_sets import ALONE, Springs, choose_set
from pysprings.macro_solver import FAN, ROWS, follow, reactions
from pysprings.macro_tables import SpringSet, SpringTable, build_table
from pysprings.springs import get_path

Array = NDArray[np.float64]


NO_VERTICAL = "a table has no vertical springs: w and V are left out"


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
        (3, 3) initial tangent of the full model for (u, w, rotation); None where the springs come from a table:
        then nothing is known of w and V.
    attrs
        Attributes of the spring set (geometry, provenance).
    remarks
        Sentences that go with every answer.
    """

    table: SpringTable | FanTable
    spring_set: SpringSet
    origin: xr.Dataset
    stiffness_initial: Array | None
    attrs: dict[str, Any]
    remarks: tuple[str, ...] = ()

    @classmethod
    def from_springs(cls, springs: Springs, springs_kind: str | None = None, path: str | None = None) -> MacroModel:
        """Build the model from springs: their fan where they have one, else all springs of the first calibration path.

        springs_kind chooses "fan", "full" or "py"; path the path whose springs serve (for "full" and "py").
        p-y curves without companions give "py" and say so.
        """
        kind = choose_set(springs, springs_kind, path)
        remarks: tuple[str, ...] = (ALONE,) if kind == "py" else ()
        if isinstance(springs, CurveSprings):
            name, curves = springs.pick(path)
            attrs = {"title": f"table {springs.source}", "skirt_length_m": curves.length}
            remarks += tuple(filter(None, (curves.note, NO_VERTICAL)))
            return cls(curves.table(kind), kind, springs.origin(name), None, attrs, remarks)
        table: SpringTable | FanTable
        if kind == "fan":
            table = build_fan(springs)
            origin = get_path(springs, table.path[0])
        else:
            origin = get_path(springs, path)
            table = build_table(origin, kind)
        stiffness = springs.dataset["stiffness_initial"].values
        known = stiffness if stiffness.shape == (3, 3) else None
        remarks += () if known is not None else (NO_VERTICAL,)
        return cls(table, kind, origin, known, {str(name): value for name, value in springs.attrs.items()}, remarks)

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

    def _knows(self, dof: str) -> bool:
        return dof != "w" or self.stiffness_initial is not None

    def tangent_stiffness(self, u: float = 0.0, rotation: float = 0.0) -> xr.DataArray:
        """Return the tangent stiffness (3, 3) at mudline for (u, w, rotation) at a state.

        u and rotation come from the springs; w is the elastic stiffness of the full model, uncoupled; springs from
        a table do not know it, and the matrix is (2, 2) for (u, rotation).
        Units: N/m for displacements, N m/rad for rotation, N/rad = N m/m between them.
        """
        lateral, dofs = self.reactions(u, rotation)[1], [name for name in variables.DOFS if self._knows(name)]
        matrix = np.zeros((len(dofs), len(dofs)))
        matrix[np.ix_([0, -1], [0, -1])] = lateral
        if self.stiffness_initial is not None:
            matrix[1, 1] = self.stiffness_initial[1, 1]
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
        G, C, scale, aims = equations(control, np.asarray(targets, dtype=float), arm, self.table.load_scale)
        steps = np.concatenate([np.zeros((1, 2)), aims])
        out = np.zeros((2, *steps.shape))
        n, at0, at1 = follow(*self._springs, G, C, scale, np.zeros(2), steps, out[0], out[1])
        states, loads = out[0, 1:n], out[1, 1:n]
        return (
            states,
            loads,
            "" if n == len(steps) else ending(control, (at0, at1), aims[n - 1], states, loads),
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
    springs: Springs | MacroModel,
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
    springs: Springs | MacroModel,
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
    springs: Springs,
    u: float = 0.0,
    rotation: float = 0.0,
    springs_kind: str | None = None,
    path: str | None = None,
) -> xr.DataArray:
    """Return the tangent stiffness (3, 3) at mudline for (u, w, rotation) at a state (m, rad)."""
    return MacroModel.from_springs(springs, springs_kind, path).tangent_stiffness(u, rotation)


def _model(springs: Springs | MacroModel, springs_kind: str | None, path: str | None) -> MacroModel:
    return springs if isinstance(springs, MacroModel) else MacroModel.from_springs(springs, springs_kind, path)


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
