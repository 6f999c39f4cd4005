# SPDX-License-Identifier: MIT
"""What the page answers: the way to a load as `predict` has it, the largest loads around it, load cases as `design`."""

import base64
import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, cast

import numpy as np
import pandas as pd
import xarray as xr

from pysprings.cli.guard import explained
from pysprings.cli.page.sources import ARM, Field, H, M, Source, Values, command_line
from pysprings.cli.predict import Question, way_to_load
from pysprings.cli.support import quantities
from pysprings.core.arrays import Array
from pysprings.core.errors import PyspringsError
from pysprings.core.units import si_of
from pysprings.macro.capacity import Capacities, capacities
from pysprings.macro.fan import FanTable
from pysprings.macro.model import MacroModel

DIRECTIONS = 24  # of the half plane of H and M/L; the other half mirrors them
SHORT = 0.999  # of the largest load, up to which the curve goes on
SET = {"springs_kind": None, "path": None, "strict": False, "extrapolate": False}


@dataclass(frozen=True)
class Answer:
    """What is known of a load.

    question : the load in SI; None where the inputs are no load.
    refusal : why there is no answer, as `predict` prints it; blank with one.
    way : states up to the load. onward : states up to the largest known load of its direction.
    model : springs, at the V of the question.
    largest : largest known load along the load. around : along `DIRECTIONS` of the half plane.
    cases : answers to load cases, or why there are none.
    """

    question: Question | None
    refusal: str = ""
    way: xr.Dataset | None = None
    onward: xr.Dataset | None = None
    model: MacroModel | None = None
    largest: Capacities | None = None
    around: Capacities | None = None
    cases: pd.DataFrame | str | None = None


@dataclass
class Asker:
    """Answers the inputs of the page; keeps what it has made until what that depends on changes."""

    source: Source
    _kept: dict[str, tuple[Any, Any]] = field(default_factory=dict)

    def answer(self, values: Values, table: tuple[str, str] | None = None) -> Answer:
        """Return the answer to inputs, and to a table of load cases (name, content as a data URI).

        Errors are answers, those of the program too, so that no earlier answer stays beside other inputs.
        """
        try:
            with warnings.catch_warnings(action="ignore"):  # they are attributes of an answer, too
                return self._answer(values, table)
        except Exception as error:
            return Answer(None, explained(error)[0])

    def _answer(self, values: Values, table: tuple[str, str] | None) -> Answer:
        model, question = self.model(values), question_of(values, self.source)
        key, direction = (self.source.key(values), question.V), _direction(question)
        largest, onward = self._once("onward", (key, direction), lambda: _onward(model, direction, question.V))
        around = self._once("around", key, lambda: _around(model, question.V))
        try:
            way, refusal = way_to_load(model, question, SET), ""
        except PyspringsError as error:
            way, refusal = None, explained(error)[0]
        cases = None if table is None else self.cases(values, table)
        return Answer(question, refusal, way, onward, model, largest, around, cases)

    def _once(self, name: str, key: Any, make: Callable[[], Any]) -> Any:
        """Return what was made last under a name, made anew where its key has changed."""
        if name not in self._kept or self._kept[name][0] != key:
            self._kept[name] = (key, make())
        return self._kept[name][1]

    def half_of_largest(self, values: Values) -> float | None:
        """Return half of the largest known H [MN] at the height of inputs; None where it is not known."""
        known = self.answer({**values, H.name: 0.0}).largest
        if known is None or not np.isfinite(known.H[0]):
            return None
        return float(f"{0.5e-6 * float(known.H[0]):.2g}")

    def model(self, values: Values) -> MacroModel:
        """Return the springs for inputs, built. Raises UserInputError."""
        from pysprings.macro.predict import model_of

        V_ = question_of({**values, H.name: 0.0}, self.source).V
        made = self._once(
            "model", (self.source.key(values), V_), lambda: model_of(self.source.springs(values), V=V_)
        )  # fmt: skip
        return cast("MacroModel", made)

    def cases(self, values: Values, table: tuple[str, str]) -> pd.DataFrame | str:
        """Return the answers of `pysprings design` to an uploaded table, or why it refuses them."""
        from pysprings.core.tables.load_cases import read_load_cases
        from pysprings.studies.design import answer_cases

        def make() -> pd.DataFrame | str:
            with TemporaryDirectory() as place:
                file = Path(place) / Path(table[0]).name
                file.write_bytes(base64.b64decode(table[1].partition(",")[2]))
                try:
                    return answer_cases(self.source.springs(values), read_load_cases(file))
                except Exception as error:
                    return explained(error)[0].replace(str(file), file.name)

        return cast("pd.DataFrame | str", self._once("cases", (self.source.key(values), table), make))


def given_loads(values: Values, source: Source) -> list[tuple[Field, float]]:
    """Return the inputs of the load that count: the moment in place of the height."""
    left_out = ARM.name if values[M.name] is not None or values[H.name] is None else ""
    given = [(each, values[each.name]) for each in source.load_fields if each.name != left_out]
    return [(each, value) for each, value in given if value is not None]


def question_of(values: Values, source: Source) -> Question:
    """Return the question of `predict` that inputs are, read from the texts of its options. Raises UserInputError."""
    given = {f"--{each.name}": (each.text(value), si_of(each.unit), "") for each, value in given_loads(values, source)}
    loads = quantities(given)
    return Question(H=loads.get("--H"), arm=loads.get("--arm"), M=loads.get("--M"), V=loads.get("--V"))


def command_of(values: Values, source: Source) -> str:
    """Return the command that gives the same answer."""
    loads = [text for each, value in given_loads(values, source) for text in (f"--{each.name}", each.text(value))]
    return command_line(["predict", *source.options(values), *loads])


def load_of(question: Question) -> tuple[float, float]:
    """Return H [N] and M [N m] of a question."""
    force = question.H or 0.0
    return force, question.M if question.M is not None else force * (question.arm or 0.0)


def _direction(question: Question) -> tuple[float, float]:
    """Return H and M of a load in proportion: a force at its height where there is none; the same for all sizes."""
    force, moment = load_of(question)
    if force and question.M is None:
        return math.copysign(1.0, force), math.copysign(1.0, force) * (question.arm or 0.0)
    return (force, moment) if force or moment else (1.0, question.arm or 0.0)


def _around(model: MacroModel, V: float | None) -> Capacities:
    """Return the largest known loads all around the half plane of H and M/L."""
    angles = np.pi * np.arange(DIRECTIONS) / DIRECTIONS - 0.5 * np.pi
    return capacities(model, np.stack([np.cos(angles), np.sin(angles) * model.length], axis=1), V)


def _onward(model: MacroModel, direction: tuple[float, float], V: float | None) -> tuple[Capacities, xr.Dataset | None]:
    """Return the largest known load in a direction, and the states up to just below it; None where it is not known."""
    from pysprings.macro.predict import way_to_load as way

    largest = capacities(model, np.array([direction]), V)
    if not np.isfinite(largest.utilisation[0]):
        return largest, None
    try:
        states = way(model, H=SHORT * float(largest.H[0]), M=SHORT * float(largest.M[0]), V=V, n=40)
    except PyspringsError:
        states = None
    return largest, states


def profiles(answer: Answer) -> dict[str, tuple[Array, Array]]:
    """Return p, m and t [N/m, N m/m, N/m] at the last state over depth [m], as far as the springs have them."""
    if answer.way is None or answer.model is None:
        return {}
    last = answer.way.isel(step=-1)
    found = {"p": (last["depth"].values, last["p"].values)}
    table = answer.model.table
    if isinstance(table, FanTable):
        rows = table.rows(np.array([[float(last["u"]), float(last["rotation"])]]))[:, 0]
        found |= {name: (table.depth[table.name == name], rows[table.name == name]) for name in ("m", "t")}
    return found


def numbers(answer: Answer, source: Source, values: Values) -> list[tuple[str, str]]:
    """Return the numbers of an answer: names and texts; "-" where there is none."""
    from pysprings.studies.sizing import steel_of

    facts = dict.fromkeys(("u", "tilt", "utilisation", "V used", "steel"), "-")
    if answer.way is not None:
        last = answer.way.isel(step=-1)
        facts["u"] = f"{1e3 * float(last['u']):.5g} mm"
        facts["tilt"] = f"{math.degrees(float(last['rotation'])):.5g} deg"
        if np.isfinite(float(last["utilisation"])):
            facts["utilisation"] = f"{100.0 * float(last['utilisation']):.4g} %"
        if "utilisation_V" in last and np.isfinite(float(last["utilisation_V"])):
            facts["V used"] = f"{100.0 * float(last['utilisation_V']):.4g} %"
    elif answer.question is not None and answer.onward is not None and answer.largest is not None:
        used = np.hypot(*load_of(answer.question)) / np.hypot(answer.largest.H[0], answer.largest.M[0])
        facts["utilisation"] = f"{100.0 * float(used):.4g} %"
    try:
        scene = source.scene(values)
    except PyspringsError:
        scene = None
    if scene is not None:
        size = scene.caisson
        steel = 1e-3 * steel_of(size.outer_diameter, size.skirt_length, size.skirt_thickness)
        facts["steel"] = f"{steel:.4g} t"
    return [(name, text) for name, text in facts.items() if text != "-" or name != "V used"]


def remarks(answer: Answer) -> list[tuple[str, str]]:
    """Return the notes and marks of an answer, as `predict` prints them: kinds ("refused", "mark", "note"), texts."""
    from pysprings.cli import predictions

    if answer.refusal:
        return [("refused", f"no answer: {answer.refusal.removeprefix('fatal: ').removeprefix('user input: ')}")]
    assert answer.way is not None
    last = answer.way.isel(step=[-1])
    marks = [name for name in predictions.MARKS if name in last and last[name].values[-1]]
    said = [("mark", f"marks: {', '.join(marks)}")] if marks else []
    said += [("mark", f"warning: {text}") for text in last.attrs["warnings"]]
    said += [("note", text) for text in predictions.sentences(last)]
    mesh = last.attrs.get("atlas_mesh")  # one of the remarks
    notes = last.attrs.get("remarks", ())
    said += [("mark" if text == mesh else "note", f"note: {text}") for text in notes]
    return sorted(said, key=lambda each: each[0])
