# SPDX-License-Identifier: MIT
"""Stiffness of a caisson as a matrix: the full model's at rest, tangent and secant of the springs at a state.

Without a load or motion the matrix is the initial stiffness of the full model, `stiffness_initial` of the spring file,
whatever spring set predicts. At a state it is that of the springs. The secant is the mean of the tangents on the
straight way from rest to the state, so that it times the motion is the load.
"""

from collections.abc import Mapping
from typing import Any, TypedDict, Unpack

import numpy as np
import xarray as xr

from pysprings.core import variables
from pysprings.core.arguments import check_numbers
from pysprings.core.arrays import Array
from pysprings.core.errors import refused
from pysprings.core.loads import same_load, same_loads
from pysprings.core.path_kinds import MOTIONS
from pysprings.core.words import sudden
from pysprings.macro.answer import trace
from pysprings.macro.curve_table import CurveSprings
from pysprings.macro.model import AnySprings, MacroModel, typed
from pysprings.macro.predict import Asking, impose, model_of, parts_of, predict

NO_TORSION = "torsion (rot_z) is not known, as no full model has computed it: its row and column are 0"
AT_REST = "torsion (rot_z) is that of the full model at rest: less where torsion or lateral loads mobilise friction"
# data/evidence/stiffness-w.csv: by full models at equal H and M
W_APART = (
    "w is not coupled with u and rotation, and its stiffness is that under V alone: a lateral load softens it "
    "(in sand to 0.8, 0.5, 0.3 of it at 20, 40, 70 % of the range)"
)
W_COUPLED = "w is coupled with u and rotation as the springs at several vertical loads have it"
FULL_MODEL = "initial stiffness of the full model"
FIRST_STEPS = "stiffness of the first recorded steps of the table"  # no full model stands behind a table
_TANGENT = "tangent stiffness of the springs at the state"
GAUSS = 64  # points of the mean along the way
_SMALL = 0.05, 1e-4  # steps of differences: of V over the range of its sets, of a motion over its size


class Form(TypedDict, total=False):
    """Keywords on the form of a stiffness.

    secant : that from rest to the state, instead of the tangent there.
    symmetric : the symmetric part alone.
    reference_depth : depth [m] below mudline of the point on the axis that the matrix belongs to; 0 is the lid centre.
    """

    secant: bool
    symmetric: bool
    reference_depth: float


class Load(TypedDict, total=False):
    """Keywords of a load (`predict`) or of a motion (`impose`); none of them: at rest."""

    H: float | None
    arm: float | None
    M: float | None
    V: float | None
    u: float | None
    rotation: float | None


class Question(Load, Form, Asking, total=False):
    """Keywords of `stiffness` and `stiffness_six`."""


def stiffness(springs: AnySprings | MacroModel, **question: Unpack[Question]) -> xr.DataArray:
    """Return a stiffness (3, 3) for (u, w, rotation).

    Without a load or motion it is the full model's initial stiffness, else that of the springs under a load H [N] at
    height arm [m] or with moment M [N m], and V [N] (`predict`), or at u [m] and rotation [rad] (`impose`): `Load`.
    `Form` chooses tangent or secant, symmetric part, reference point and axes; `long_name` names what it is. Units: N/m
    for displacements, N m/rad for rotation, N/rad = N m/m between them. (2, 2) for (u, rotation) of springs from a
    table without a vertical path. Raises as `predict` does.
    """
    load, form, asking = _parts(question)
    matrix, name = _at_state(*_asked(springs, load, asking), form) if load else initial(springs, asking)
    return _array(in_form(matrix, form), name, form)


def stiffness_six(springs: AnySprings | MacroModel, **question: Unpack[Question]) -> xr.DataArray:
    """Return a stiffness (6, 6) for (u_x, u_y, w, rot_x, rot_y, rot_z): initial, or at a state in a plane of load.

    Questions are those of `stiffness`. Axes: x along the load, y to its left seen from above, z up; rotations
    right-hand; w is down. Units: N/m for displacements, N/rad = N m/m between u_x and rot_y (u_y and rot_x), N
    m/rad for rotations. The caisson at rest is axisymmetric: what holds for (u_x, rot_y) holds for (u_y, -rot_x).
    At a state the block out of the plane of the load is the secant, as the response does not depend on the
    direction of the plane; attribute `vertical` has whether w is coupled. Torsion is that of the full model at rest, at
    a state, too; where none has computed it (a table, an atlas) it is 0, and stated so.

    Raises
    ------
    UserInputError
        Springs from a table without a vertical path, which have no vertical stiffness; and as `predict` does.
    """
    load, form, asking = _parts(question)
    if not has_six(springs):
        raise refused("springs", "springs from a table have no vertical stiffness: a 6x6 matrix needs springs.nc")
    if load:
        return six_at_state(*_asked(springs, load, asking), form)
    matrix, name = initial(springs, asking)
    return _six(in_form(matrix, form), in_form(matrix, form), torsion_of(springs), (name, form))


def torsion_of(springs: AnySprings | MacroModel) -> float | None:
    """Return the torsional stiffness of the full model at rest [N m/rad]; None where springs have none."""
    if isinstance(springs, MacroModel):
        return variables.known_torsion(springs.attrs)
    given = typed(springs)
    return None if isinstance(given, CurveSprings) else variables.known_torsion(given.attrs)


def has_six(springs: AnySprings | MacroModel) -> bool:
    """Return whether `stiffness_six` has an answer for springs."""
    return _known(springs)[0] is not None


def initial(springs: AnySprings | MacroModel, asking: Asking | None = None) -> tuple[Array, str]:
    """Return the stiffness at rest, (3, 3) or (2, 2), and what it is."""
    known, name = _known(springs)
    if known is None:
        model = model_of(springs, **parts_of(asking or Asking())[1])
        return model.tangent_stiffness().values, "stiffness of the springs at rest"
    return known, name


def _known(springs: AnySprings | MacroModel) -> tuple[Array | None, str]:
    """Return the initial stiffness (3, 3) that springs hold, None where they have no vertical one; and whose it is."""
    if isinstance(springs, MacroModel):
        return springs.stiffness_initial, _name_of(springs.attrs)
    given = typed(springs)
    if isinstance(given, CurveSprings):
        return None, ""
    return given.stiffness, _name_of(given.attrs)


def _name_of(attrs: Mapping[Any, Any]) -> str:
    """Return words for the initial stiffness that springs with these attributes hold."""
    of_atlas = f"initial stiffness of the {attrs.get('source')}" if "atlas_cases" in attrs else FULL_MODEL
    return FIRST_STEPS if "first_steps" in attrs else of_atlas + sudden(attrs.get("drainage"))


def at_states(model: MacroModel, states: xr.Dataset, form: Form) -> xr.DataArray:
    """Return the stiffness (step, 3, 3) of the springs at the states of an answer (dimension step)."""
    if form.get("secant"):
        rows = [_at_state(model, states.isel(step=step), form) for step in range(states.sizes["step"])]
        name, matrices = rows[0][1], [matrix for matrix, _ in rows]
    else:
        name, matrices = _TANGENT, list(_coupled(model, states))
    one = _array(matrices[-1], name, form)
    return xr.concat([one.copy(data=in_form(matrix, form)) for matrix in matrices], "step")


def six_at_state(model: MacroModel, state: xr.Dataset, form: Form) -> xr.DataArray:
    """Return the stiffness (6, 6) of the springs at one state; see `stiffness_six`."""
    plane, name = _at_state(model, state, form)
    across, _ = _at_state(model, state, Form(secant=True, symmetric=form.get("symmetric", False)))
    plane = in_form(plane, form)
    six = _six(plane, in_form(across, form), torsion_of(model), (name, form))
    six.values[2, [0, 4]], six.values[[0, 4], 2] = plane[1, [0, 2]], plane[[0, 2], 1]
    return six.assign_attrs(vertical=W_COUPLED if plane[1, ::2].any() else W_APART)


def secant(model: MacroModel, u: float, rotation: float, V: float | None = None, symmetric: bool = False) -> Array:
    """Return the secant stiffness of the springs at a state: (3, 3), or (2, 2) where w is not known.

    What the mean of the tangents has left of the load is added by the least change that keeps no symmetry (Broyden
    1965), or with ``symmetric`` that of a symmetric matrix (Powell 1970).
    """
    place, weight = np.polynomial.legendre.leggauss(GAUSS)
    state = np.array([u, rotation])
    ways = 0.5 * (place + 1.0)[:, None] * state
    matrix: Array = np.tensordot(0.5 * weight, model.tangents(ways).values, axes=1)
    lateral = np.ix_([0, matrix.shape[0] - 1], [0, matrix.shape[0] - 1])
    size = np.array([1.0, model.length])
    block = 0.5 * (matrix[lateral] + matrix[lateral].T) if symmetric else matrix[lateral]
    x = state * size
    if way := float(x @ x):
        left = (model.reactions(*state)[0] - model.reactions(0.0, 0.0)[0] - block @ state) / size
        change = np.outer(left, x) / way
        change += np.outer(x, left - (left @ x) / way * x) / way if symmetric else 0.0
        matrix[lateral] = block + size[:, None] * change * size
    if matrix.shape == (3, 3) and V is not None and model.vertical is not None:
        w0, V0 = model.vertical.rest
        if not same_load(V, V0):  # of one load both differences are rounding
            matrix[1, 1] = (V - V0) / (model.vertical.displacement(V) - w0)
    return matrix


def in_form(matrix: Array, form: Form) -> Array:
    """Return stiffnesses (..., 3, 3) or (..., 2, 2) about another point, or their symmetric part."""
    n, depth = matrix.shape[-1], form.get("reference_depth", 0.0)
    check_numbers(reference_depth=depth)
    motion = np.eye(n)
    motion[0, -1] = depth  # u at mudline from u and rotation at the point
    out: Array = motion.T @ matrix @ motion
    return 0.5 * (out + np.swapaxes(out, -1, -2)) if form.get("symmetric") else out


def axisymmetric(plane: Array, across: Array | None = None, torsion: float = 0.0) -> Array:
    """Return the (6, 6) matrix of (3, 3) ones for (u, w, rotation): in the plane of x and z, and across it."""
    other = plane if across is None else across
    matrix = np.diag([plane[0, 0], other[0, 0], plane[1, 1], other[2, 2], plane[2, 2], torsion])
    matrix[0, 4], matrix[4, 0] = plane[0, 2], plane[2, 0]
    matrix[1, 3], matrix[3, 1] = -other[0, 2], -other[2, 0]
    return matrix


def turned(matrix: xr.DataArray, direction: float) -> xr.DataArray:
    """Return a (6, 6) matrix with x along a load in axes from which that load stands at a direction [rad]."""
    turn, c, s = np.eye(6), np.cos(direction), np.sin(direction)
    for i, j in ((0, 1), (3, 4)):
        turn[np.ix_([i, j], [i, j])] = [[c, -s], [s, c]]
    return matrix.copy(data=turn @ matrix.values @ turn.T)


def form_words(form: Form) -> str:
    """Return words for the reference point of a form."""
    depth = form.get("reference_depth", 0.0)
    point = "at the lid centre" if depth == 0.0 else f"about the axis point {depth:g} m below mudline"
    return f"{point}{', symmetric part' if form.get('symmetric') else ''}"


def _asked(springs: AnySprings | MacroModel, load: Load, asking: Asking) -> tuple[MacroModel, xr.Dataset]:
    """Return the model that a question is for, and its state under the load, or at the motion."""
    (care, choice), given = parts_of(asking), dict[str, Any](load)
    model = model_of(springs, V=load.get("V"), **choice)
    return model, (impose if {"u", "rotation"} & set(load) else predict)(model, **given, **care)


def _at_state(model: MacroModel, state: xr.Dataset, form: Form) -> tuple[Array, str]:
    if not form.get("secant"):
        return _coupled(model, state.expand_dims("step"))[0], _TANGENT
    model.response.check_state("secant")
    V = float(state["V"]) if "V" in state else None
    found = secant(model, float(state["u"]), float(state["rotation"]), V, form.get("symmetric", False))
    return found, "secant stiffness of the springs at the state"


def _coupled(model: MacroModel, states: xr.Dataset) -> Array:
    """Return the tangents (n, 3, 3) at states (step), with w coupled where V is between vertical loads of a fan.

    At rest w is apart, by symmetry.
    """
    matrices: Array = states["stiffness"].values.copy()
    loads = [each.V for each in model.whole.load_sets] if model.whole is not None else []
    if model.spring_set != "fan" or len(loads) < 2:
        return matrices
    motions, V = np.stack([states["u"].values, states["rotation"].values], axis=1), states["V"].values
    within = np.clip(V, loads[0], loads[-1])
    inside = same_loads(V, within) & motions.any(axis=1)
    for one in np.unique(within[inside]):
        here, d = inside & (within == one), _SMALL[0] * (loads[-1] - loads[0])
        span = max(one - d, loads[0]), min(one + d, loads[-1])
        matrices[here] = _with_w(model, motions[here], float(one), span, matrices[here])
    return matrices


def _with_w(model: MacroModel, motions: Array, V: float, span: tuple[float, float], matrices: Array) -> Array:
    """Return tangents (n, 3, 3) with w coupled, from those without, at motions (n, 2) under V [N] in a span of V.

    A fan at several vertical loads has H, M and w as functions of q = (u, rotation) and V, that is

        d(H, M) = A dq + h dV,   dw = g dq + b dV,

    which is solved for dV. Where w does not grow with V the tangent stays without.
    """

    def at(motions: Array, V: float) -> Array:
        found = trace(model.under(V), "state", motions, 0.0, V)
        return np.stack([found[name].values[-len(motions) :] for name in ("H", "M", "w")], axis=1)

    low, high = span
    change = (at(motions, high) - at(motions, low)) / (high - low)
    h, b = change[:, :2], np.where(change[:, 2] > 0.0, change[:, 2], np.nan)
    size, sides = np.array([1.0, model.length]), np.eye(2)
    steps = _SMALL[1] * np.linalg.norm(motions * size, axis=1)[:, None] / size
    g = np.stack([
        (at(motions + side * steps, V) - at(motions - side * steps, V))[:, 2] / (2.0 * steps @ side) for side in sides
    ], axis=1)  # fmt: skip
    found = np.zeros_like(matrices)
    found[:, ::2, ::2] = matrices[:, ::2, ::2] - h[:, :, None] * (g / b[:, None])[:, None, :]
    found[:, ::2, 1], found[:, 1, 1], found[:, 1, ::2] = h / b[:, None], 1.0 / b, -g / b[:, None]
    return np.where((b > 0.0)[:, None, None], found, matrices)


def _parts(question: Question) -> tuple[Load, Form, Asking]:
    for name in question:
        if name not in Question.__annotations__:
            raise TypeError(f"a stiffness got an unexpected keyword argument '{name}'")
    given: dict[str, Any] = {name: value for name, value in question.items() if value is not None}
    load: Any = {name: given.pop(name) for name in Load.__annotations__ if name in given}
    form: Any = {name: given.pop(name) for name in Form.__annotations__ if name in given}
    check_numbers(**load)
    if {"u", "rotation"} & set(load) and {"H", "M"} & set(load):
        raise refused("u", "give a load or a motion, not both")
    asking: Any = given
    return load, form, asking


def _array(matrix: Array, name: str, form: Form) -> xr.DataArray:
    dofs = list(variables.DOFS) if matrix.shape == (3, 3) else ["u", "rotation"]
    words = variables.GROUPS["prediction"]["stiffness"].comment
    if name == _TANGENT and matrix.shape == (3, 3) and matrix[1, ::2].any():  # at rest what stands there is rounding
        words = f"{variables.GROUPS['springs_root']['stiffness_initial'].comment}; {W_COUPLED}"
    attrs = {"long_name": f"{name} {form_words(form)}", "units": "1", "comment": words}
    return xr.DataArray(matrix, {"dof": dofs, "dof_conjugate": dofs}, ("dof", "dof_conjugate"), "stiffness", attrs)


def _six(plane: Array, across: Array, torsion: float | None, named: tuple[str, Form]) -> xr.DataArray:
    name, form = named
    attrs = {
        "long_name": f"{name} {form_words(form)}",
        "units": "1",
        "comment": "mixed units: N m-1; N radian-1 between u_x and rot_y, u_y and rot_x; N m radian-1 for rotations",
        "torsion": NO_TORSION if torsion is None else AT_REST,
    }
    coords = {"dof": list(MOTIONS), "dof_conjugate": list(MOTIONS)}
    matrix = axisymmetric(plane, across, torsion or 0.0)
    return xr.DataArray(matrix, coords, ("dof", "dof_conjugate"), "stiffness_6x6", attrs)
