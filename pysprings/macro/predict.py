# SPDX-License-Identifier: MIT
"""Rigid caisson on nonlinear springs: load and rotation in milliseconds, from the spring file alone.

Degrees of freedom: u (lateral, lid centre at mudline, +x), rotation (right-hand about +y); w follows.
Loads: H (N) at height arm (m) above mudline, that is M = -H*arm about the lid centre.

Four spring sets. From the reactions along one path of the full model:

- "full": p(y) by depth, m(rotation) by depth, tip H(y_tip) and M(rotation), lid H(u) and M(rotation);
- "py": p(y) alone, as in a plain Winkler model; the moment is resisted by p*z only.

From several calibration paths of constant ratio rotation/u:

- "pisa": the families of "full", uncoupled: lateral ones from a pure translation, moments from a pure rotation;
- "fan": all reactions by (u, rotation*L) in magnitude and angle (`pysprings.macro.fan`); it predicts on other paths.

Answers outside the calibrated range are marked:

- `extrapolated`: beyond the calibrated displacements, where curves go on with their last slope; the largest load within
  them is named;
- `off_path`: with springs of one path, far from it (their p and m hold on that path only); with a fan, between rays
  more than 60 degrees apart; from where a sequence leaves its first direction (`pysprings.macro.history`);
- `turned_back`: from where a sequence turns back;
- `off_load`: under a vertical load other than those of the lateral springs (`pysprings.springs.dead_loads`; between
  sets at several loads they are interpolated). H and M are those at the nearest load, w follows the vertical springs
  (`pysprings.macro.vertical`), or without them the elastic vertical stiffness.

With `strict` such an answer raises an error.

Beyond the loads that the full model carried there is no answer (`BeyondSprings`, `pysprings.macro.ends`): beyond the
range of springs whose path stopped or met a limit load, beyond a limit load in its direction, and under vertical loads
that neither vertical springs nor a small change from the load of the paths cover.

Springs are odd: a load towards -x is the mirror image of one towards +x. They are monotonic backbones, used as they
are in both ways: the body is nonlinear elastic, and a load path that turns back goes back on the same curve.
"""

from __future__ import annotations

import warnings
from typing import TypedDict, Unpack

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pysprings.core.arguments import check_arrays, check_numbers
from pysprings.core.errors import BeyondSprings, Problem, RunIncomplete, refused
from pysprings.macro.answer import Way, answer_dataset
from pysprings.macro.control import Control
from pysprings.macro.model import MacroModel
from pysprings.macro.sets import AnySprings
from pysprings.macro.trace import trace

__all__ = [
    "MacroModel", "MacroWarning", "PredictionNotConverged", "SpringChoice", "curve", "impose", "model_of", "predict",
    "predict_batch", "raise_or_warn", "sequence", "stiffness",
]  # fmt: skip

Array = NDArray[np.float64]

ELASTIC = "the springs are nonlinear elastic: a path that turns back goes back on the same curve, without hysteresis"


class MacroWarning(UserWarning):
    """An answer of the macro-model that the springs support only in part."""


class PredictionNotConverged(RunIncomplete):
    """No equilibrium was found beyond a load; the message names it and the part that was reached."""


class SpringChoice(TypedDict, total=False):
    """Keywords that choose among the springs of a caisson; a model built before (`model_of`) takes none of them.

    Attributes
    ----------
    springs_kind : spring set ("fan", "full", "pisa", "py"); the fan if present, else the full set.
    path : load path whose springs are used, of a set of one path; the first calibration path.
    """

    springs_kind: str | None
    path: str | None


def predict(
    springs: AnySprings | MacroModel,
    *,
    H: float | None = None,
    arm: float | None = None,
    M: float | None = None,
    V: float | None = None,
    n: int = 26,
    strict: bool = False,
    **choice: Unpack[SpringChoice],
) -> xr.Dataset:
    """Predict the motion under a lateral load H [N] at height arm [m] above mudline, or with moment M [N m].

    Returns n states (dimension step) from the origin to the load, H and M growing in proportion; the last one is
    the answer. With neither arm nor M the load acts at the mudline; with M alone H is 0; with V [N] alone the vertical
    load grows from that of the springs. `springs` may be a model built before (`model_of`), for many cases. `choice`
    selects a spring set and path (`SpringChoice`).

    Raises
    ------
    PredictionNotConverged
        No equilibrium beyond the load named in the message.
    BeyondSprings
        The full model carried no such load.
    UserInputError
        With strict: the springs support the answer only in part. Without, that is a MacroWarning.
    """
    check_numbers(H=H, arm=arm, M=M, V=V)
    model, share = model_of(springs, V=V, **choice), np.linspace(0.0, 1.0, _points(n))
    if V is not None and H is None and M is None and arm is None:
        rest = model.rest_load
        return raise_or_warn(trace(model, "load", np.zeros((n, 2)), 0.0, rest + share * (V - rest)), strict)
    force, moment = (float(value) for value in _loads(H, arm, M))
    height = arm if arm is not None else (-moment / force if force else 0.0)
    return raise_or_warn(trace(model, "load", share[:, None] * np.array([force, moment]), height, V), strict)


def curve(
    springs: AnySprings | MacroModel,
    *,
    u_max: float,
    arm: float = 0.0,
    n: int = 50,
    V: float | None = None,
    strict: bool = False,
    **choice: Unpack[SpringChoice],
) -> xr.Dataset:
    """Return the load-displacement curve, n points to u_max [m] at the lid centre, load at height arm [m]."""
    check_numbers(u_max=u_max)
    return impose(springs, u=u_max, arm=arm, V=V, n=n, strict=strict, **choice)


def impose(
    springs: AnySprings | MacroModel,
    *,
    u: float | None = None,
    rotation: float | None = None,
    arm: float = 0.0,
    V: float | None = None,
    n: int = 26,
    strict: bool = False,
    **choice: Unpack[SpringChoice],
) -> xr.Dataset:
    """Return the loads that go with a displacement u [m] or a rotation [rad] of the lid centre, or with both.

    One of them: the load acts at height arm [m], and the other motion is free. Both: they are imposed, and H and M
    are the loads that hold them. Returns n states (dimension step) from the origin on; the last one is the answer.
    Raises as `predict` does.
    """
    given = {name: value for name, value in (("u", u), ("rotation", rotation)) if value is not None}
    if not given:
        raise refused("u", "give a displacement, a rotation, or both")
    check_numbers(arm=arm, V=V, **given)
    targets = np.zeros((_points(n), 2))
    for column, value in enumerate(given.values()):
        targets[:, column] = np.linspace(0.0, value, n)
    controls: dict[tuple[str, ...], Control] = {("u",): "displacement", ("rotation",): "rotation"}
    control = controls.get(tuple(given), "state")
    return raise_or_warn(trace(model_of(springs, V=V, **choice), control, targets, arm, V), strict)


def sequence(
    springs: AnySprings | MacroModel,
    targets: Array,
    *,
    control: Control = "load",
    arm: float = 0.0,
    V: float | Array | None = None,
    strict: bool = False,
    **choice: Unpack[SpringChoice],
) -> xr.Dataset:
    """Return the states along a sequence of loads or motions, one a row of targets (n, 2), from the origin on.

    control is "load" (H [N], M [N m]), "state" (u [m], rotation [rad] imposed), "displacement" or "rotation" (first
    column, load at height arm [m]). V [N]: one number, or one a row (of springs at several vertical loads those at its
    first value are used). The springs are nonlinear elastic: where the sequence turns back, so does the answer, on the
    same curve. From there on states are marked `turned_back`; from where the targets leave the direction of the first
    one (H to M, or u to rotation) they are marked `off_path`. Raises as `predict` does.
    """
    check_numbers(arm=arm)
    check_arrays(targets=targets, V=V)
    rows = np.asarray(targets, dtype=float)
    if rows.ndim != 2 or rows.shape[1] != 2 or not len(rows):
        raise refused("targets", f"must have the shape (n, 2), not {rows.shape}")
    down = None if V is None else np.asarray(V, dtype=float)
    if down is not None and down.shape not in ((), (len(rows),)):
        raise refused("V", f"give one number, or one a row of targets ({len(rows)}), not the shape {down.shape}")
    first = None if down is None else float(down.ravel()[0])
    model = model_of(springs, V=first, **choice)
    answer = trace(model, control, rows, arm, down if down is not None and down.ndim else first)
    return raise_or_warn(answer.assign_attrs(remarks=[*answer.attrs["remarks"], ELASTIC]), strict)


def predict_batch(
    springs: AnySprings | MacroModel,
    *,
    H: float | Array,
    arm: float | Array | None = None,
    M: float | Array | None = None,
    V: float | None = None,
    **choice: Unpack[SpringChoice],
) -> xr.Dataset:
    """Predict the motion under many independent loads (dimension case): arrays of H [N], and of arm [m] or M [N m].

    V [N] is one for all. A warning of `predict` is a mark by case here: `extrapolated`, `off_path`, `off_load`, and
    `converged` 0 where the springs cannot carry the load (the case then holds the largest load that was reached on the
    straight way to it). Where `predict` raises BeyondSprings, `beyond_end` is 1, `converged` 0, and u, w and rotation
    are NaN.
    """
    check_arrays(H=H, arm=arm, M=M)
    check_numbers(V=V)
    force, moment = np.broadcast_arrays(*_loads(H, arm, M))
    targets = np.stack([force.ravel(), moment.ravel()], axis=1)
    model = model_of(springs, V=V, **choice)
    states, loads, reached = model.solve_cases("load", targets)
    answer = answer_dataset(model, Way(states, loads, "load", V))
    answer = _without_motion_beyond(answer.assign(converged=answer["converged"].copy(data=reached)))
    return answer.drop_vars(["p", "y", "usable", "stiffness", "depth", "depth_bounds", "dof", "dof_conjugate"]).rename(
        step="case"
    )


def _without_motion_beyond(answer: xr.Dataset) -> xr.Dataset:
    """Return the answers of a batch without the motions of cases beyond the loads that the full model carried."""
    past = answer["beyond_end"].values == 1
    for name in ("u", "w", "rotation"):
        if name in answer:
            answer[name] = answer[name].copy(data=np.where(past, np.nan, answer[name].values))
    converged = np.where(past, 0, answer["converged"].values).astype(np.int8)
    return answer.assign(converged=answer["converged"].copy(data=converged))


def stiffness(
    springs: AnySprings | MacroModel,
    *,
    H: float | None = None,
    arm: float | None = None,
    M: float | None = None,
    V: float | None = None,
    u: float | None = None,
    rotation: float | None = None,
    strict: bool = False,
    **choice: Unpack[SpringChoice],
) -> xr.DataArray:
    """Return the stiffness (3, 3) of the springs at a state, at mudline for (u, w, rotation): the tangent there.

    The state is that at rest, under a load, or at a motion; the full model's initial stiffness is `stiffness_six`.

    Under a load H [N] at height arm [m] or with moment M [N m] (`predict`), or at u [m] and rotation [rad], imposed
    (one of them: the load acts at height arm, as in `impose`). See `MacroModel.tangents` for units and for w.
    """
    check_numbers(H=H, arm=arm, M=M, V=V, u=u, rotation=rotation)
    model = model_of(springs, V=V, **choice)
    if u is not None or rotation is not None:
        answer = impose(model, u=u, rotation=rotation, arm=arm or 0.0, V=V, strict=strict)
    elif H is not None or M is not None or V is not None:
        answer = predict(model, H=H, arm=arm, M=M, V=V, strict=strict)
    else:
        return model.tangent_stiffness()
    return answer["stiffness"].isel(step=-1, drop=True)


def model_of(
    springs: AnySprings | MacroModel, springs_kind: str | None = None, path: str | None = None, V: float | None = None
) -> MacroModel:
    """Return the model of springs (`MacroModel.from_springs`); a model itself as it is."""
    if not isinstance(springs, MacroModel):
        return MacroModel.from_springs(springs, springs_kind, path, V)
    if springs_kind is not None or path is not None:
        raise refused("springs_kind", "a model has its springs already: choose them where it is built (`model_of`)")
    return springs


def _loads(H: float | Array | None, arm: float | Array | None, M: float | Array | None) -> tuple[Array, Array]:
    """Return lateral load [N] and moment [N m] as arrays. Raises UserInputError for contradicting arguments."""
    if arm is not None and M is not None:
        raise refused("arm", "give the height of the load or its moment, not both")
    if H is None and M is None:
        raise refused("H", "give a load or a moment")
    force = np.asarray(0.0 if H is None else H, dtype=float)
    moment = np.asarray(M, dtype=float) if M is not None else -force * np.asarray(0.0 if arm is None else arm)
    return force, moment


def raise_or_warn(answer: xr.Dataset, strict: bool) -> xr.Dataset:
    """Return an answer; raise where it is beyond the springs or partial, warn (raise, when strict) where it is marked.

    Every answer passes here but those of `predict_batch`, which are marked by case.
    """
    if answer.attrs["refusals"]:
        raise BeyondSprings([Problem(key="springs", message=text) for text in answer.attrs["refusals"]])
    if answer.attrs["status"] != "complete":
        raise PredictionNotConverged(answer.attrs["message"])
    notes = answer.attrs["warnings"]
    if strict and notes:
        raise refused("strict", "; ".join(notes))
    for note in notes:
        warnings.warn(note, MacroWarning, stacklevel=3)
    return answer


def _points(n: int) -> int:
    check_numbers(n=n)
    if n != int(n) or n < 2:
        raise refused("n", f"{n} points: at least 2 are needed")
    return n
