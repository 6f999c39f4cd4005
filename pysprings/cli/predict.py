# SPDX-License-Identifier: MIT
"""`pysprings predict`: motions under loads, loads at motions, curves and sequences, on springs or tables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pysprings.cli.atlas_springs import SHIPPED_ATLASES, Asked, refuse_without_atlas, springs_of_atlas
from pysprings.cli.inputs import springs_or_table
from pysprings.cli.options import Changes, Json, SpringSet
from pysprings.cli.support import print_json, quantities, refuse, to_stderr

if TYPE_CHECKING:
    import xarray as xr

    from pysprings.cli import predictions
    from pysprings.macro.sets import AnySprings
    from pysprings.macro.stiffness import Form

POINTS = 50  # of a curve
MISSING = 'missing: give a load such as --H "2 MN", or --u-max "5 mm" for a curve'

# quantity -> (option, SI unit, example)
_QUANTITIES = {
    "H": ("--H", "N", "2 MN"),
    "arm": ("--arm", "m", "8 m"),
    "M": ("--M", "N m", "3 MN m"),
    "V": ("--V", "N", "4 MN"),
    "u_max": ("--u-max", "m", "5 mm"),
    "u": ("--u", "m", "3 mm"),
    "rotation": ("--rotation", "rad", "0.5 mrad"),
    "tilt": ("--tilt", "rad", "0.25 deg"),
    "skirt_length": ("--skirt-length", "m", "4 m"),
    "rate": ("--rate", "m/s", "0.1 mm/s"),
    "reference_depth": ("--reference-depth", "m", "4 m"),
}


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
    sequence: Path | None = None
    points: int | None = None

    @classmethod
    def read(cls, texts: Mapping[str, str | None], sequence: Path | None, points: int | None) -> Question:
        """Read quantities with units, by the names of the attributes.

        Raises
        ------
        UserInputError
            Texts that are no such quantities, and options that exclude each other or are missing.
        """
        values = quantities({_QUANTITIES[name][0]: (text, *_QUANTITIES[name][1:]) for name, text in texts.items()})
        question = cls(**{name: values[_QUANTITIES[name][0]] for name in texts}, sequence=sequence, points=points)
        question.refuse_contradictions()
        return question

    @property
    def given(self) -> set[str]:
        """Options of quantities that are given."""
        return {option for name, (option, *_) in _QUANTITIES.items() if getattr(self, name) is not None}

    def refuse_contradictions(self) -> None:
        """Raise UserInputError for loads and motions that are missing or given twice."""
        there = self.given
        motions = there & {"--u", "--rotation", "--tilt"}
        if self.points is not None and self.u_max is None:
            refuse("--points", "are those of a curve: give --u-max")
        if self.sequence is not None:
            for option in sorted(there - {"--V", "--skirt-length", "--rate", "--reference-depth"}):
                refuse(option, "give either this or --sequence: the file holds loads, motions and their height")
            return
        if not there & {"--H", "--M", "--V", "--u-max", *motions}:
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


@dataclass(frozen=True)
class Choice:
    """Springs that answer: name of a spring set, path for a set of one path, whether marked answers are refused."""

    spring_set: str | None = None
    path: str | None = None
    strict: bool = False
    extrapolate: bool = False


def predict(
    result: Annotated[
        Path | None,
        typer.Argument(
            metavar="[SPRINGS]",
            help="springs.nc, the folder of a run, or a p-y table; with --atlas a scene file, or none",
        ),
    ] = None,
    load: Annotated[str | None, typer.Option("--H", metavar="FORCE", help='lateral load, e.g. "2 MN"')] = None,
    arm: Annotated[
        str | None, typer.Option("--arm", metavar="LENGTH", help='its height above mudline, e.g. "8 m"')
    ] = None,
    moment: Annotated[
        str | None,
        typer.Option("--M", metavar="MOMENT", help='moment about the lid centre, H*arm, e.g. "3 MN m"'),
    ] = None,
    vertical: Annotated[str | None, typer.Option("--V", metavar="FORCE", help="vertical load, positive down")] = None,
    u_max: Annotated[
        str | None,
        typer.Option("--u-max", metavar="LENGTH", help='a whole curve up to this displacement, e.g. "5 mm"'),
    ] = None,
    points: Annotated[
        int | None, typer.Option("--points", help="points of the curve \\[default: 50]", min=2, max=10_000)
    ] = None,
    u: Annotated[str | None, typer.Option("--u", metavar="LENGTH", help="the load at this displacement")] = None,
    rotation: Annotated[
        str | None,
        typer.Option("--rotation", metavar="ANGLE", help="the load at this rotation; with --u: both imposed"),
    ] = None,
    tilt: Annotated[
        str | None,
        typer.Option("--tilt", metavar="ANGLE", help="the lateral load that turns it by this angle"),
    ] = None,
    sequence: Annotated[
        Path | None,
        typer.Option("--sequence", metavar="FILE", help="table with a load (H_N, M_Nm) or motion (u_m ...) a line"),
    ] = None,
    spring_set: SpringSet = None,
    path: Annotated[
        str | None, typer.Option("--path", metavar="NAME", help="load path whose springs answer (full, py)")
    ] = None,
    strict: Annotated[
        bool, typer.Option("--strict", help="refuse an answer that the springs support only in part")
    ] = False,
    extrapolate: Annotated[
        bool, typer.Option("--extrapolate", help="answer beyond the calibrated range of the springs, marked")
    ] = False,
    rate: Annotated[
        str | None,
        typer.Option("--rate", metavar="VELOCITY", help="of rho = |(u, rotation*L)|, for springs from several rates"),
    ] = None,
    stiffness: Annotated[
        bool,
        typer.Option(
            "--stiffness", help="also the stiffness of the springs at each state, and the full model's initial one, 6x6"
        ),
    ] = False,
    secant: Annotated[bool, typer.Option("--secant", help="stiffness from rest to each state, not tangent")] = False,
    symmetric: Annotated[bool, typer.Option("--symmetric", help="symmetric part of stiffnesses")] = False,
    reference_depth: Annotated[
        str | None,
        typer.Option("--reference-depth", metavar="LENGTH", help="point of stiffnesses on the axis, below mudline"),
    ] = None,
    atlas: Annotated[
        str | None,
        typer.Option("--atlas", metavar="NAME|FILE", help=f"answer without a full model, by {SHIPPED_ATLASES}"),
    ] = None,
    diameter: Annotated[str | None, typer.Option("--D", metavar="LENGTH", help="outer diameter, with --atlas")] = None,
    length: Annotated[str | None, typer.Option("--L", metavar="LENGTH", help="skirt length, with --atlas")] = None,
    changes: Changes = None,
    save_springs: Annotated[
        Path | None, typer.Option("--save-springs", metavar="FILE", help="write the springs of the atlas: .nc")
    ] = None,
    skirt_length: Annotated[
        str | None, typer.Option("--skirt-length", metavar="LENGTH", help="of a table without depth_bottom_m")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="write the answer to a file: csv, json or nc")
    ] = None,
    as_json: Json = False,
) -> None:
    """Predict displacement and rotation of the rigid caisson on its springs, or a load-displacement curve.

    SPRINGS may be a table of p-y curves (CSV, Excel) with columns depth_m, y_m, p_N_per_m, and companions if any.
    """
    from pysprings.cli import predictions

    texts = {"H": load, "arm": arm, "M": moment, "V": vertical, "u_max": u_max, "u": u, "rotation": rotation}
    texts |= {"tilt": tilt, "skirt_length": skirt_length, "rate": rate, "reference_depth": reference_depth}
    question = Question.read(texts, sequence, points)
    springs: AnySprings
    if atlas is not None:
        asked = Asked(atlas, result, diameter, length, tuple(changes or ()), save_springs, question.V)
        springs = springs_of_atlas(asked, strict, extrapolate)
    else:
        refuse_without_atlas({"--D": diameter, "--L": length, "--set": changes, "--save-springs": save_springs})
        if result is None:
            refuse("SPRINGS", "missing: springs.nc, the folder of a run, a p-y table, or --atlas")
        springs = _at_rate(springs_or_table(result, question.skirt_length, strict), question.rate)
    choice = Choice(spring_set, path, strict, extrapolate)
    states = answer(springs, question, choice)
    form: Form = {"secant": secant, "symmetric": symmetric}
    form["reference_depth"] = question.reference_depth or 0.0
    matrices = _matrices(springs, states, question, choice, form) if stiffness or any(form.values()) else None
    if out is not None:
        predictions.write(states, predictions.stiffness(matrices) if matrices else {}, out)
        print(out)
        return
    if as_json:
        print_json(predictions.prediction(states) | (predictions.stiffness(matrices) if matrices else {}))
        return
    predictions.print_prediction(states)
    if matrices:
        predictions.print_stiffness(matrices)
    if remarks := predictions.remarks_of(states):
        to_stderr(remarks)


def answer(springs: AnySprings, question: Question, choice: Choice) -> xr.Dataset:
    """Return the states of a question: the last one of a load or motion, all of a curve or sequence."""
    from pysprings.macro import predict

    options = question
    common: dict[str, Any] = {"springs_kind": choice.spring_set, "path": choice.path}
    common |= {"strict": choice.strict, "extrapolate": choice.extrapolate}
    if options.sequence is not None:
        from pysprings.results.tables.sequence import read_sequence

        read = read_sequence(options.sequence)
        common |= {"V": read.V if read.V is not None else options.V, "time": read.time}
        states = predict.sequence(springs, read.targets, control=read.control, arm=read.arm, **common)
        return states.assign_attrs(question="sequence")
    if options.u_max is not None:
        return predict.curve(
            springs, u_max=options.u_max, arm=options.arm or 0.0, n=options.points or POINTS, V=options.V, **common
        )
    if options.tilt is not None:
        return _tilted(springs, options, common)
    if options.u is not None or options.rotation is not None:
        common |= {"u": options.u, "rotation": options.rotation}
        states = predict.way_to_motion(springs, arm=options.arm or 0.0, V=options.V, **common)
    else:
        states = predict.way_to_load(springs, H=options.H, arm=options.arm, M=options.M, V=options.V, **common)
        if options.H and options.M and options.H * options.M < 0.0:
            from pysprings.results.tables.load_cases import below_mudline

            states.attrs["remarks"] = [*states.attrs["remarks"], below_mudline(options.H, options.M)]
    return states.isel(step=[-1])


def _tilted(springs: AnySprings, question: Question, common: Mapping[str, Any]) -> xr.Dataset:
    """Return the state under the load H > 0 that turns the caisson by an angle, one way or the other."""
    from pysprings.macro import predict

    assert question.tilt is not None
    model = predict.model_of(springs, common["springs_kind"], common["path"], question.V)
    care = {name: common[name] for name in ("strict", "extrapolate")}
    arm = question.arm or 0.0
    small = predict.way_to_motion(model, u=1e-6, arm=arm, n=1, extrapolate=True)  # which way a load turns it
    way = -1.0 if float(small["rotation"][-1]) * float(small["H"][-1]) < 0.0 else 1.0
    states = predict.way_to_motion(model, rotation=way * abs(question.tilt), arm=arm, V=question.V, **care)
    return states.isel(step=[-1])


def _at_rate(springs: AnySprings, rate: float | None) -> AnySprings:
    """Return the springs at a rate [m/s]; as they are without one."""
    if rate is None:
        return springs
    from pysprings.macro.user_curves import CurveSprings
    from pysprings.springs.springs import Springs

    if isinstance(springs, CurveSprings):
        refuse("--rate", "a table has no rates")
    if rate <= 0.0:
        refuse("--rate", f"{1e3 * rate:g} mm/s is not positive")
    return Springs.of(springs).at_rate(rate)


def _matrices(
    springs: AnySprings, states: xr.Dataset, question: Question, choice: Choice, form: Form
) -> predictions.Matrices:
    """Return the stiffness of the springs at each state, and the initial one; 6x6 where w is known."""
    from pysprings.cli import predictions
    from pysprings.macro import stiffness
    from pysprings.macro.predict import model_of

    model = model_of(springs, choice.spring_set, choice.path, question.V)
    initial = stiffness.Form(**{**form, "secant": False})
    known = stiffness.has_six(springs)
    one = known and states.sizes["step"] == 1
    return predictions.Matrices(
        at_states=stiffness.at_states(model, states, form),
        six_at_state=stiffness.six_at_state(model, states.isel(step=0), form) if one else None,
        six=stiffness.stiffness_six(springs, **initial) if known else None,
    )
