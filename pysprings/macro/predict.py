# SPDX-License-Identifier: MIT
"""Rigid caisson on nonlinear springs: load and rotation in milliseconds, from the spring file alone.

Degrees of freedom: u (lateral, lid centre at mudline, +x), rotation (the caisson leans towards +x); w follows.
Loads: H (N) at height arm (m) above mudline, that is M = H*arm about the lid centre.

Four spring sets. From the reactions along one path of the full model:

- "full": p(y) by depth, m(rotation) by depth, tip H(y_tip) and M(rotation), lid H(u) and M(rotation);
- "py": p(y) alone, as in a plain Winkler model; the moment is resisted by p*z only.

From several calibration paths of constant ratio rotation/u:

- "pisa": the families of "full", uncoupled: lateral ones from a pure translation, moments from a pure rotation;
- "fan": all reactions by (u, rotation*L) in magnitude and angle (`pysprings.macro.fan`); it predicts on other paths.

Beyond the calibrated range there is no answer (`BeyondSprings`), unless `extrapolate` asks for one: it is marked
`extrapolated` then, and curves go on with their last slope. The message has the largest load within the range, and the
paths that it comes from. Answers that the springs support in part are marked:

- `off_path`: with springs of one path, far from it (their p and m hold on that path only); with a fan, between rays
  more than 60 degrees apart; from where a sequence leaves its first direction (`pysprings.macro.ways`);
- `turned_back`: from where a sequence turns back;
- `off_load`: under a V more than 10 % from those of the lateral springs (`pysprings.springs.path_sets`; between
  sets at several loads they are interpolated), or so near the largest vertical load that the load at equal motion may
  be less than 80 % (`pysprings.macro.vertical.share_left`). H and M are those at the nearest load, w follows the
  vertical springs (`pysprings.macro.vertical`), or without them the elastic vertical stiffness.

With `strict` such an answer raises an error.

Beyond a limit load of the full model there is no answer at all. Every answer has the largest load that is known in the
direction of its own (`pysprings.macro.capacity`) and the share of it, `utilisation`.

Springs are odd: a load towards -x is the mirror image of one towards +x. They are monotonic backbones, used as they
are in both ways: the body is nonlinear elastic, and a load path that turns back goes back on the same curve.
"""

from typing import Any, TypedDict, Unpack

import numpy as np
import xarray as xr

from pysprings.core.arguments import check_arrays, check_columns, check_numbers, check_rows
from pysprings.core.arrays import Array
from pysprings.core.errors import refused
from pysprings.macro.answer import Care, MacroWarning, PredictionNotConverged, raise_or_warn, trace
from pysprings.macro.capacity import with_capacity
from pysprings.macro.model import AnySprings, MacroModel
from pysprings.macro.vertical_answer import with_vertical_use
from pysprings.macro.ways import COLUMNS, Control

__all__ = [
    "MacroModel", "MacroWarning", "PredictionNotConverged", "SpringChoice", "curve", "impose", "model_of", "predict",
    "raise_or_warn", "sequence",
]  # fmt: skip


STEPS = 25  # on the way from the origin to one load or motion


class SpringChoice(TypedDict, total=False):
    """Keywords that choose among the springs of a caisson; a model built before (`model_of`) takes none of them.

    springs_kind : spring set ("fan", "full", "pisa", "py"); the fan if present, else the full set.
    path : load path whose springs are used, of a set of one path; the first calibration path.
    """

    springs_kind: str | None
    path: str | None


class Asking(SpringChoice, Care, total=False):
    """Keywords of every question: `SpringChoice` and `Care`."""


def predict(
    springs: AnySprings | MacroModel,
    *,
    H: float | None = None,
    arm: float | None = None,
    M: float | None = None,
    V: float | None = None,
    **asking: Unpack[Asking],
) -> xr.Dataset:
    """Predict the motion under a lateral load H [N] at height arm [m] above mudline, or with moment M [N m].

    The load grows from the origin, H and M in proportion; the answer is the state under it. With neither arm nor M the
    load acts at the mudline; with M alone H is 0; with V [N] alone the vertical load grows from that of the springs.
    `springs` may be a model built before (`model_of`), for many cases. `asking` selects a spring set and path
    (`SpringChoice`), and what becomes of answers that the springs support in part (`Care`).

    The answer has u, w [m], rotation [rad], loads, p by depth, stiffness, marks, and `utilisation`: the load over the
    largest one that is known in its direction, which is `capacity_H_N`, `capacity_M_Nm` (`capacity_kind`,
    `capacity_from`) of its attributes. `curve` gives a whole curve.

    Raises
    ------
    PredictionNotConverged
        No equilibrium beyond the load named in the message.
    BeyondSprings
        The full model carried no such load; or, without extrapolate, it is beyond the calibrated range.
    UserInputError
        With strict: the springs support the answer only in part. Without, that is a MacroWarning.
    """
    return _one(way_to_load(springs, H=H, arm=arm, M=M, V=V, **asking))


def impose(
    springs: AnySprings | MacroModel,
    *,
    u: float | None = None,
    rotation: float | None = None,
    arm: float = 0.0,
    V: float | None = None,
    **asking: Unpack[Asking],
) -> xr.Dataset:
    """Return the state with a displacement u [m] or a rotation [rad] of the lid centre, or with both, and its loads.

    One of them: the load acts at height arm [m], and the other motion is free. Both: they are imposed, and H and M
    are the loads that hold them. Raises as `predict` does.
    """
    return _one(way_to_motion(springs, u=u, rotation=rotation, arm=arm, V=V, **asking))


def way_to_load(
    springs: AnySprings | MacroModel,
    *,
    H: float | None = None,
    arm: float | None = None,
    M: float | None = None,
    V: float | None = None,
    n: int = STEPS,
    **asking: Unpack[Asking],
) -> xr.Dataset:
    """Return n + 1 states (dimension step) on the way from the origin to a load; see `predict`."""
    check_numbers(H=H, arm=arm, M=M, V=V)
    care, choice = parts_of(asking)
    model, share = model_of(springs, V=V, **choice), np.linspace(0.0, 1.0, n + 1)
    if V is not None and H is None and M is None and arm is None:
        rest = model.rest_load
        return _answered(model, trace(model, "load", np.zeros((n + 1, 2)), 0.0, rest + share * (float(V) - rest)), care)
    force, moment = (float(value) for value in loads_of(H, arm, M))
    height = arm if arm is not None else (moment / force if force else 0.0)
    return _answered(model, trace(model, "load", share[:, None] * np.array([force, moment]), height, V), care)


def way_to_motion(
    springs: AnySprings | MacroModel,
    *,
    u: float | None = None,
    rotation: float | None = None,
    arm: float = 0.0,
    V: float | None = None,
    n: int = STEPS,
    **asking: Unpack[Asking],
) -> xr.Dataset:
    """Return n + 1 states (dimension step) on the way from the origin to a motion; see `impose`."""
    given = {name: value for name, value in (("u", u), ("rotation", rotation)) if value is not None}
    if not given:
        raise refused("u", "give a displacement, a rotation, or both")
    check_numbers(arm=arm, V=V, **given)
    if len(given) == 2 and arm:
        raise refused("arm", "with u and rotation both loads are answers: leave it out")
    care, choice = parts_of(asking)
    targets = np.zeros((n + 1, 2))
    for column, value in enumerate(given.values()):
        targets[:, column] = np.linspace(0.0, float(value), n + 1)
    controls: dict[tuple[str, ...], Control] = {("u",): "displacement", ("rotation",): "rotation"}
    model = model_of(springs, V=V, **choice)
    return _answered(model, trace(model, controls.get(tuple(given), "state"), targets, arm, V), care)


def curve(
    springs: AnySprings | MacroModel,
    *,
    u_max: float,
    arm: float = 0.0,
    n: int = 50,
    V: float | None = None,
    **asking: Unpack[Asking],
) -> xr.Dataset:
    """Return the load-displacement curve, n points (dimension step) to u_max [m] at the lid centre.

    The load acts at height arm [m]. Raises as `predict` does.
    """
    check_numbers(u_max=u_max)
    return way_to_motion(springs, u=u_max, arm=arm, V=V, n=_points(n) - 1, **asking)


def sequence(
    springs: AnySprings | MacroModel,
    targets: Array,
    *,
    control: Control = "load",
    arm: float = 0.0,
    V: float | Array | None = None,
    time: Array | None = None,
    **asking: Unpack[Asking],
) -> xr.Dataset:
    """Return the states along a sequence of loads or motions, one a row of targets (n, 2), from the origin on.

    control is "load" (H [N], M [N m]), "state" (u [m], rotation [rad] imposed), "displacement" or "rotation" (first
    column, load at height arm [m]). V [N]: one number, or one a row (of springs at several vertical loads those at its
    first value are used, but for springs with memory that follow V). time (n,) [s] grows from 0: springs that come from
    one rate mark steps at another one `off_rate`, and of those with memory the water's part of p drains in it; it
    changes nothing else. Springs of the set "memory" remember reversals. All others are nonlinear elastic: where the
    sequence turns back, so does the answer, on the same curve. From there on states are marked `turned_back`; from
    where the targets leave the direction of the first one (H to M, or u to rotation) they are marked `off_path`.
    Raises as `predict` does.
    """
    check_numbers(arm=arm)
    check_arrays(targets=targets, V=V, time=time)
    check_columns(targets, COLUMNS.get(control, ()))
    rows = np.asarray(targets, dtype=float)
    if rows.ndim != 2 or rows.shape[1] != 2 or not len(rows):
        raise refused("targets", f"must have the shape (n, 2), not {rows.shape}")
    check_rows(rows, V, time)
    if arm and control in ("load", "state"):
        raise refused("arm", f"is that of a displacement or a rotation: of the control '{control}' give M or rotation")
    down = None if V is None else np.asarray(V, dtype=float)
    first = None if down is None else float(down.ravel()[0])
    care, choice = parts_of(asking)
    model = model_of(springs, V=first, **choice)
    at = None if time is None else np.asarray(time, dtype=float)
    V_of_rows = down if down is not None and down.ndim else first
    answer = trace(model, control, rows, arm, V_of_rows, at)
    remarks = [*answer.attrs["remarks"], *model.response.sequence_remarks(V_of_rows)]
    return _answered(model, answer.assign_attrs(remarks=remarks), care)


def model_of(
    springs: AnySprings | MacroModel, springs_kind: str | None = None, path: str | None = None, V: float | None = None
) -> MacroModel:
    """Return the model of springs (`MacroModel.from_springs`); a model itself as it is."""
    if not isinstance(springs, MacroModel):
        return MacroModel.from_springs(springs, springs_kind, path, V)
    if springs_kind is not None or path is not None:
        raise refused("springs_kind", "a model has its springs already: choose them where it is built (`model_of`)")
    return springs


def loads_of(H: float | Array | None, arm: float | Array | None, M: float | Array | None) -> tuple[Array, Array]:
    """Return lateral load [N] and moment [N m] as arrays. Raises UserInputError for contradicting arguments."""
    if arm is not None and M is not None:
        raise refused("arm", "give the height of the load or its moment, not both")
    if H is None and M is None:
        raise refused("H", "give a load or a moment")
    force = np.asarray(0.0 if H is None else H, dtype=float)
    moment = np.asarray(M, dtype=float) if M is not None else force * np.asarray(0.0 if arm is None else arm)
    return force, moment


def _answered(model: MacroModel, answer: xr.Dataset, care: Care) -> xr.Dataset:
    """Return an answer with the largest load in its direction; raise or warn as `raise_or_warn` does."""
    return with_vertical_use(model, with_capacity(model, raise_or_warn(answer, **care)))


def parts_of(asking: Asking) -> tuple[Care, SpringChoice]:
    """Return the keywords of a question that are `Care`, and those that choose the springs."""
    care: Any = {name: value for name, value in asking.items() if name in Care.__annotations__}
    choice: Any = {name: value for name, value in asking.items() if name not in care}
    return care, choice


def _one(way: xr.Dataset) -> xr.Dataset:
    return way.isel(step=-1, drop=True)


def _points(n: int) -> int:
    check_numbers(n=n)
    if n != int(n) or n < 2:
        raise refused("n", f"{n} points: at least 2 are needed")
    return int(n)
