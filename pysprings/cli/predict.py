# SPDX-License-Identifier: MIT
"""`pysprings predict`: motions under loads, loads at motions, curves and sequences, on springs or tables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pysprings.cli.atlas import SHIPPED_ATLASES, Asked, refuse_without_atlas, springs_of_atlas
from pysprings.cli.folders import refuse_read
from pysprings.cli.inputs import springs_or_table
from pysprings.cli.options import Changes, Json, Rate, SpringSet, argument, option, quantity
from pysprings.cli.support import print_json, refuse, to_stderr

if TYPE_CHECKING:
    import xarray as xr

    from pysprings.cli import predictions
    from pysprings.core.loads import InPlane
    from pysprings.macro.model import AnySprings, MacroModel
    from pysprings.macro.predict import Asking
    from pysprings.macro.space import SpaceControl
    from pysprings.macro.stiffness import Form
    from pysprings.results.tables.sequence import Sequence

POINTS = 50  # of a curve
BY_COMPONENTS = {"--Hx", "--Hy", "--Mx", "--My", "--T"}
MISSING = 'missing: give a load such as --H "2 MN", or --u-max "5 mm" for a curve'


@dataclass(frozen=True)
class Question:
    """Loads and motions of a prediction in SI; None for options that are absent."""

    H: float | None = None
    arm: float | None = None
    M: float | None = None
    V: float | None = None
    u_max: float | None = None
    u: float | None = None
    rotation: float | None = None
    tilt: float | None = None
    skirt_length: float | None = None
    rate: float | None = None
    reference_depth: float | None = None
    Hx: float | None = None
    Hy: float | None = None
    Mx: float | None = None
    My: float | None = None
    T: float | None = None
    sequence: Path | None = None
    points: int | None = None

    @property
    def given(self) -> set[str]:
        """Options of quantities that are given."""
        names = (each.name for each in fields(self) if each.name not in ("sequence", "points"))
        return {f"--{name.replace('_', '-')}" for name in names if getattr(self, name) is not None}

    def __post_init__(self) -> None:
        """Raise UserInputError for loads and motions that are missing or given twice."""
        there = self.given
        motions, parts = there & {"--u", "--rotation", "--tilt"}, sorted(there & BY_COMPONENTS)
        if self.points is not None and self.u_max is None:
            refuse("--points", "are those of a curve: give --u-max")
        if self.sequence is not None:
            for option in sorted(there - {"--V", "--skirt-length", "--rate", "--reference-depth"}):
                refuse(option, "give either this or --sequence: the file holds loads, motions and their height")
            return
        if parts and (other := sorted(there & {"--H", "--arm", "--M", "--u-max", *motions})):
            refuse(other[0], f"give either this or {parts[0]}: loads by components are Hx, Hy, V, Mx, My, T")
        if not there & {"--H", "--M", "--V", "--u-max", *motions, *parts}:
            refuse("--H", MISSING)
        if {"--H", "--u-max"} <= there:
            refuse("--u-max", "give either --H or --u-max: the load is an answer of the curve")
        if {"--u-max", "--M"} <= there:
            refuse("--M", "a curve needs the height of the load: give --arm instead")
        if motions and (other := sorted(there & {"--H", "--M", "--u-max"})):
            refuse(min(motions), f"give either this or {other[0]}: a load is the answer to a motion")
        if {"--arm", "--M"} <= there:
            refuse("--M", "give either --arm or --M, not both (M = H*arm)")
        if "--tilt" in there and len(motions) > 1:
            refuse("--tilt", f"give either this or {min(motions - {'--tilt'})}")
        if len(motions) == 2 and "--arm" in there:
            refuse("--arm", "with --u and --rotation both loads are answers: leave --arm out")
        if "--arm" in there and not there & {"--H", "--u-max", *motions}:
            refuse("--H", MISSING)


def predict(
    result: Annotated[
        Path | None,
        argument("[SPRINGS]", "springs.nc, the folder of a run, or a p-y table; with --atlas a scene file, or none"),
    ] = None,
    load: Annotated[float | None, quantity("--H", "N", "2 MN", 'lateral load, e.g. "2 MN"')] = None,
    arm: Annotated[float | None, quantity("--arm", "m", "8 m", 'its height above mudline, e.g. "8 m"')] = None,
    moment: Annotated[
        float | None, quantity("--M", "N m", "3 MN m", 'moment about the lid centre, H*arm, e.g. "3 MN m"')
    ] = None,
    vertical: Annotated[float | None, quantity("--V", "N", "4 MN", "vertical load, positive down")] = None,
    force_x: Annotated[float | None, quantity("--Hx", "N", "1 MN", "loads by components, z up: lateral load")] = None,
    force_y: Annotated[float | None, quantity("--Hy", "N", "1 MN", "to the left of x, seen from above")] = None,
    moment_x: Annotated[float | None, quantity("--Mx", "N m", "-3 MN m", "right-handed: -Hy at its height")] = None,
    moment_y: Annotated[float | None, quantity("--My", "N m", "3 MN m", "right-handed: Hx at its height")] = None,
    torsion: Annotated[
        float | None, quantity("--T", "N m", "0.5 MN m", "torsion; without springs in space the twist is linear")
    ] = None,
    u_max: Annotated[
        float | None, quantity("--u-max", "m", "5 mm", 'a whole curve up to this displacement, e.g. "5 mm"')
    ] = None,
    points: Annotated[
        int | None, typer.Option("--points", help="points of the curve [default: 50]", min=2, max=10_000)
    ] = None,
    u: Annotated[float | None, quantity("--u", "m", "3 mm", "the load at this displacement")] = None,
    rotation: Annotated[
        float | None, quantity("--rotation", "rad", "0.5 mrad", "the load at this rotation; with --u: both imposed")
    ] = None,
    tilt: Annotated[
        float | None, quantity("--tilt", "rad", "0.25 deg", "the lateral load that turns it by this angle")
    ] = None,
    sequence: Annotated[
        Path | None, option("--sequence", "table with a load (H_N, M_Nm) or motion (u_m ...) a line", "FILE")
    ] = None,
    spring_set: SpringSet = None,
    path: Annotated[str | None, option("--path", "load path whose springs answer (full, py)", "NAME")] = None,
    strict: Annotated[bool, option("--strict", "refuse an answer that the springs support only in part")] = False,
    extrapolate: Annotated[
        bool, option("--extrapolate", "answer beyond the calibrated range of the springs, marked")
    ] = False,
    rate: Rate = None,
    stiffness: Annotated[
        bool,
        option("--stiffness", "also the stiffness of the springs at each state, and the full model's initial one, 6x6"),
    ] = False,
    secant: Annotated[bool, option("--secant", "stiffness from rest to each state, not tangent")] = False,
    symmetric: Annotated[bool, option("--symmetric", "symmetric part of stiffnesses")] = False,
    reference_depth: Annotated[
        float | None, quantity("--reference-depth", "m", "4 m", "point of stiffnesses on the axis, below mudline")
    ] = None,
    atlas: Annotated[
        str | None, option("--atlas", f"answer without a full model, by {SHIPPED_ATLASES}", "NAME|FILE")
    ] = None,
    diameter: Annotated[float | None, quantity("--D", "m", "9 m", "outer diameter, with --atlas")] = None,
    length: Annotated[float | None, quantity("--L", "m", "6 m", "skirt length, with --atlas")] = None,
    changes: Changes = None,
    save_springs: Annotated[
        Path | None, option("--save-springs", "write the springs of the atlas: .nc", "FILE")
    ] = None,
    skirt_length: Annotated[
        float | None, quantity("--skirt-length", "m", "4 m", "of a table without depth_bottom_m")
    ] = None,
    out: Annotated[Path | None, option("--out", "write the answer to a file: csv, json or nc", "FILE")] = None,
    as_json: Json = False,
) -> None:
    """Predict the motion of the rigid caisson on its springs. One state, or a load-displacement curve.

    SPRINGS may be a table of p-y curves (CSV, Excel) with columns depth_m, y_m, p_N_per_m, and companions if any.
    """
    from pysprings.cli import predictions

    question = Question(
        load, arm, moment, vertical, u_max, u, rotation, tilt, skirt_length, rate, reference_depth,
        force_x, force_y, moment_x, moment_y, torsion, sequence, points,
    )  # fmt: skip
    refuse_read("--out", out, result, sequence)
    springs: AnySprings
    if atlas is not None:
        for name in sorted(question.given & {"--rate", "--skirt-length"}):
            refuse(name, "is not one of springs of an atlas: leave it out")
        asked = Asked(atlas, result, diameter, length, tuple(changes or ()), save_springs, question.V)
        springs = springs_of_atlas(asked, strict, extrapolate)
    else:
        refuse_without_atlas({"--D": diameter, "--L": length, "--set": changes, "--save-springs": save_springs})
        if result is None:
            refuse("SPRINGS", "missing: springs.nc, the folder of a run, a p-y table, or --atlas")
        springs = springs_or_table(result, question.skirt_length, strict, question.rate)
    asking: Asking = {"springs_kind": spring_set, "path": path, "strict": strict, "extrapolate": extrapolate}
    states = answer(springs, question, asking)
    form: Form = {"secant": secant, "symmetric": symmetric}
    form["reference_depth"] = question.reference_depth or 0.0
    wanted = stiffness or any(form.values())
    if wanted and "u" not in states:
        refuse("--stiffness", "is that of one plane: leave it out with loads or motions in six degrees of freedom")
    matrices = _matrices(springs, states, question, asking, form) if wanted else None
    stiffnesses = predictions.stiffness(matrices) if matrices else {}
    if out is not None:
        predictions.write(states, stiffnesses, out)
    if as_json:
        return print_json(predictions.prediction(states) | stiffnesses)
    if out is not None:
        return print(out)
    predictions.print_prediction(states)
    if matrices:
        predictions.print_stiffness(matrices)
    for remark in states.attrs.get("remarks", ()):
        to_stderr(f"note: {remark}")


def answer(springs: AnySprings, question: Question, asking: Asking) -> xr.Dataset:
    """Return the states of a question: the last one of a load or motion, all of a curve or sequence."""
    from pysprings.macro import predict

    common: dict[str, Any] = {**asking}
    if question.sequence is not None:
        from pysprings.results.tables.sequence import read_sequence

        read = read_sequence(question.sequence)
        if read.V is not None and question.V is not None:
            refuse("--V", "the file has a column of V: give one of them", question.sequence)
        common |= {"V": read.V if read.V is not None else question.V, "time": read.time}
        if read.in_space:
            return _in_space(springs, read, common)
        states = predict.sequence(springs, read.targets, control=read.control, arm=read.arm, **common)
        return states.assign_attrs(question="sequence")
    if question.u_max is not None:
        return predict.curve(
            springs, u_max=question.u_max, arm=question.arm or 0.0, n=question.points or POINTS, V=question.V, **common
        )
    if question.tilt is not None:
        return _tilted(springs, question, common)
    if question.given & BY_COMPONENTS:
        return _by_components(springs, question, common)
    if question.u is not None or question.rotation is not None:
        common |= {"u": question.u, "rotation": question.rotation}
        states = predict.way_to_motion(springs, arm=question.arm or 0.0, V=question.V, **common)
    else:
        states = way_to_load(springs, question, common)
    return states.isel(step=[-1])


def way_to_load(springs: AnySprings | MacroModel, question: Question, asking: Mapping[str, Any]) -> xr.Dataset:
    """Return the states on the way to the load of a question; a moment that turns against H is a remark."""
    from pysprings.macro import predict

    states = predict.way_to_load(springs, H=question.H, arm=question.arm, M=question.M, V=question.V, **asking)
    if question.H and question.M and question.H * question.M < 0.0:
        from pysprings.core.tables.load_cases import below_mudline

        states.attrs["remarks"] = [*states.attrs["remarks"], below_mudline(question.H, question.M)]
    return states


def _by_components(springs: AnySprings, question: Question, common: Mapping[str, Any]) -> xr.Dataset:
    """Return the state under loads by components: in their plane, or out of one by springs in space."""
    import numpy as np

    from pysprings.core.loads import in_plane
    from pysprings.macro import predict, stiffness
    from pysprings.macro.directions import off_plane, twist_words, with_components

    x, y, about_x, about_y, T = (getattr(question, name) or 0.0 for name in ("Hx", "Hy", "Mx", "My", "T"))
    loads = in_plane(np.array([[x, y]]), np.array([[about_y, -about_x]]))
    across = float(loads.across[0])
    if (across or T) and (found := _from_all_sides(springs, loads, T, question, common)) is not None:
        return found
    if across:
        refuse("--Mx", f"{off_plane(across)} (`design` answers a bound)")
    if T and common["strict"]:
        refuse("--T", twist_words(stiffness.torsion_of(springs)))
    H, M = float(loads.H[0]), float(loads.M[0])
    state = predict.way_to_load(springs, H=H, M=M, V=question.V, **common).isel(step=[-1])
    return with_components(state, loads, np.array([T]), stiffness.torsion_of(springs))


def _from_all_sides(
    springs: AnySprings, loads: InPlane, T: float, question: Question, common: Mapping[str, Any]
) -> xr.Dataset | None:
    """Return the state under loads out of one plane, or with T [N m]; None without springs in space."""
    import numpy as np

    from pysprings.core.errors import BeyondSprings, Problem
    from pysprings.macro.answer import raise_or_warn
    from pysprings.macro.batch import APART, MOST_APART, answer_from_all_sides
    from pysprings.macro.model import typed
    from pysprings.macro.predict import STEPS
    from pysprings.macro.space import MEMORY, answers_in_space
    from pysprings.springs.path import SPACE_LOADS

    kind, V = common["springs_kind"], np.array([np.nan if question.V is None else question.V])
    choice = {"springs_kind": None if kind == MEMORY else kind, "path": common["path"]}
    source = typed(springs)
    if (space := answers_in_space(source, **choice)) is None:
        return None
    case = answer_from_all_sides(source, loads, np.array([T]), V, common["extrapolate"], space, **choice).isel(case=0)
    if not int(case["in_space"]):
        return None
    way = np.linspace(0.0, 1.0, STEPS + 1)[1:, None] * [float(case[name]) for name in SPACE_LOADS]
    care = {name: common[name] for name in ("strict", "extrapolate")}
    down = None if question.V is None else np.full(STEPS, question.V)
    states = raise_or_warn(space.answer("load", way, down), **care)
    if why := str(case["why_not"].values):
        raise BeyondSprings([Problem(key="springs", message=why)])
    apart = float(case["plane_difference_pct"])
    remarks = [*states.attrs["remarks"], *[APART.format(apart)] * (apart > MOST_APART)]
    return states.isel(step=[-1]).assign_attrs(question="load", remarks=remarks)


def _in_space(springs: AnySprings, read: Sequence, common: dict[str, Any]) -> xr.Dataset:
    """Return the states of a sequence in six degrees of freedom."""
    from pysprings.macro.curve_table import CurveSprings
    from pysprings.macro.space import sequence_in_space

    if isinstance(springs, CurveSprings):
        refuse("--sequence", "springs of a table answer one plane: columns H_N, M_Nm or u_m, rotation_rad")
    if common.pop("path") is not None:
        refuse("--path", "a sequence in six degrees of freedom is answered by springs of several paths")
    control: SpaceControl = "load" if read.control == "load" else "state"
    return sequence_in_space(springs, read.targets, control=control, **common)


def _tilted(springs: AnySprings, question: Question, common: Mapping[str, Any]) -> xr.Dataset:
    """Return the state under the load H > 0 that turns the caisson by an angle, one way or the other."""
    import numpy as np

    from pysprings.macro import predict

    assert question.tilt is not None
    model = predict.model_of(springs, common["springs_kind"], common["path"], question.V)
    care = {name: common[name] for name in ("strict", "extrapolate")}
    arm = question.arm or 0.0
    turn = np.linalg.solve(model.reactions(0.0, 0.0)[1], [1.0, arm])[1]  # by a small load
    way = -1.0 if turn < 0.0 else 1.0
    states = predict.way_to_motion(model, rotation=way * abs(question.tilt), arm=arm, V=question.V, **care)
    return states.isel(step=[-1])


def _matrices(
    springs: AnySprings, states: xr.Dataset, question: Question, asking: Asking, form: Form
) -> predictions.Matrices:
    """Return the stiffness of the springs at each state, and the initial one; 6x6 where w is known."""
    from pysprings.cli import predictions
    from pysprings.macro import predict, stiffness
    from pysprings.macro.spring_sets import MEMORY

    model = predict.model_of(springs, asking["springs_kind"], asking["path"], question.V)
    initial = stiffness.Form(**{**form, "secant": False})
    known = stiffness.has_six(springs)
    across = known and states.sizes["step"] == 1 and model.spring_set != MEMORY.name  # it needs the secant of a state
    six = stiffness.six_at_state(model, states.isel(step=0), form) if across else None
    if six is not None and "direction" in states:
        six = stiffness.turned(six, float(states["direction"].values.flat[0]))
    return predictions.Matrices(
        at_states=stiffness.at_states(model, states, form),
        six_at_state=six,
        six=stiffness.stiffness_six(springs, **initial) if known else None,
    )
