# SPDX-License-Identifier: MIT
"""The catalogue of stiff and extreme cases, run: how each one ends, at which cost and error; its picture.

The cases are the paper's caisson with a few values far from usual.
"""

import time
import tomllib
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from importlib.resources import files
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from pydantic import ValidationError

from pysprings.core.columns import Column, Table
from pysprings.core.errors import Problem, PyspringsError, UserInputError, refused
from pysprings.core.progress import Progress
from pysprings.core.text import suggestion
from pysprings.core.words import StopReason
from pysprings.core.workers import Task, run_tasks
from pysprings.full_model.compute import compute
from pysprings.full_model.run_record import RunRecord
from pysprings.results.plots.style import BLUE, GREEN, GREY, ORANGE, VERMILLION, new_figure, styled
from pysprings.scene.model import Scene
from pysprings.scene.sections import PAPER, PAPER_SOIL
from pysprings.scene.soils import SOIL_LAWS

REACH = 20e-3  # m


@dataclass(frozen=True)
class Case:
    """One case: its group and name, what is stretched, and the changes to the paper's scene, as a scene has them.

    ``changes`` maps sections to values; ``path`` are values of the path, a pull at the lid centre where it has no kind.
    ``hard`` cases are also run on the ``paper`` mesh where one asks for them.
    """

    group: str
    name: str
    what: str
    changes: Mapping[str, Any] = field(default_factory=dict)
    path: Mapping[str, Any] = field(default_factory=dict)
    hard: bool = False

    @property
    def _clay(self) -> bool:
        """Whether all its ground is undrained clay, which shares weight and surcharge alone with the paper's sand."""
        soil = self.changes.get("soil", {})
        usual = soil.get("yield_surface", "drucker-prager")
        layers = soil.get("layers") or soil.get("layer") or [{}]
        return all(SOIL_LAWS[layer.get("law") or usual].total_stress for layer in layers)

    def scene(self, mesh: str, reach: float = REACH, discretisation: str = "hex8") -> Scene:
        """Return the scene of the case, pulled as far as ``reach`` (m) where the case sets no displacement of its own.

        Raises UserInputError or ValueError where the input is refused.
        """
        coupled = self.changes.get("drainage", {}).get("mode", "drained") == "coupled"
        pull = {} if "kind" in self.path else {"kind": "pull", "lateral_displacement": reach}
        path = {"name": "path"} | pull | ({"rate": 0.05e-3} if coupled else {}) | dict(self.path)
        output = {"interface_fields": False, "section": False, "figures": False}
        given: dict[str, Any] = {"title": self.what, "domain": PAPER, "output": output, "path": [path]}
        given |= {"soil": PAPER_SOIL, "mesh": {"preset": mesh, "discretisation": discretisation}}
        changed = {name: given.get(name, {}) | dict(values) for name, values in self.changes.items()}
        if self._clay:
            own = {key: PAPER_SOIL[key] for key in ("effective_unit_weight", "surcharge")}
            changed["soil"] = own | self.changes["soil"]
        return Scene.model_validate(given | changed)


def _catalogue() -> Iterator[Case]:
    """Yield the cases of `stability.toml`, with the sections of their `base`."""
    data = tomllib.loads(files(__package__).joinpath("stability.toml").read_text(encoding="utf-8"))
    for given in data["case"]:
        base, words = data["base"].get(given.pop("base", ""), {}), ("group", "name", "what", "hard", "path")
        own = {name: given[name] for name in words if name in given}
        changed = {name: section for name, section in given.items() if name not in words}
        yield Case(changes={name: base.get(name, {}) | changed.get(name, {}) for name in base | changed}, **own)


CASES = (*_catalogue(),)

COLOURS = {"converged": BLUE, "warned": GREEN, "stopped": ORANGE, "refused": GREY, "unexplained": VERMILLION}
MARKERS = {"converged": "o", "warned": "D", "stopped": "s", "refused": "x", "unexplained": "*"}
_ROW = 0.21  # inches


@styled
def catalogue(table: pd.DataFrame) -> Figure:
    """Draw the table of `pysprings.studies.stability.run_cases`: a row a case, from the first at the top."""
    figure = new_figure(10.0, 1.6 + _ROW * len(table))
    left, right = figure.subplots(1, 2, sharey=True, width_ratios=(1.0, 1.0))
    row = np.arange(len(table))
    _iterations(left, table, row)
    _cut_backs(right, table, row)
    left.set_yticks(row, [f"{case}" for case in table["case"]], fontsize=8)
    left.set_ylim(len(table) - 0.5, -0.5)
    group = table["group"].to_numpy()
    for axes in (left, right):
        for last in np.flatnonzero(group[1:] != group[:-1]):  # row of each group
            axes.axhline(last + 0.5, color=GREY, lw=0.6)
    used = [outcome for outcome in COLOURS if (table["outcome"] == outcome).any()]
    handles = [Line2D([], [], color=COLOURS[o], marker=MARKERS[o], ls="", label=o) for o in used]
    figure.legend(handles=handles, loc="outside upper right", ncols=len(handles))
    figure.suptitle("Stiff and extreme cases", x=0.01, ha="left")
    return figure


def _iterations(axes: Axes, table: pd.DataFrame, row: np.ndarray) -> None:
    """Draw median (mark) and largest number (end of the line) of Newton iterations of the increments."""
    columns = (table[name].tolist() for name in ("outcome", "median_iterations", "max_iterations", "increments"))
    for y, outcome, median, most, increments in zip(row, *columns, strict=True):
        if increments:
            axes.plot([median, most], [y, y], color=COLOURS[outcome], lw=1.0)
        axes.plot(median if increments else 0.0, y, MARKERS[outcome], color=COLOURS[outcome], ms=5)
    axes.set_xlim(-0.5, None)
    axes.set_xlabel("Newton iterations of an increment: median, most")


def _cut_backs(axes: Axes, table: pd.DataFrame, row: np.ndarray) -> None:
    share = 100.0 * table["cut_backs"] / table["increments"].clip(lower=1)
    axes.barh(row, share.clip(upper=100.0), color=[COLOURS[outcome] for outcome in table["outcome"]], height=0.6)
    for y, cuts, increments in zip(row, table["cut_backs"].tolist(), table["increments"].tolist(), strict=True):
        if increments:
            axes.text(min(share.iloc[y], 100.0) + 1.0, y, f"{cuts} of {increments}", va="center", fontsize=7)
    axes.set_xlim(0.0, 118.0)
    axes.set_xlabel("steps cut, % of the increments")


CONVERGED, WARNED, STOPPED, REFUSED, UNEXPLAINED = "converged", "warned", "stopped", "refused", "unexplained"
OUTCOMES = (CONVERGED, WARNED, STOPPED, REFUSED, UNEXPLAINED)


@dataclass(frozen=True)
class Outcome:
    """How a case ended.

    ``outcome`` is one of OUTCOMES, ``detail`` the warning, the named reason, or the message of the refusal. ``u_mm``,
    ``H_kN``, ``w_mm`` and ``V_kN`` (down) are the end of what converged. Imbalances are relative to the largest
    term of the energy, and to the water that has moved; ``condition`` is an estimate from below.
    """

    group: str
    case: str
    what: str
    outcome: str
    detail: str = ""
    u_mm: float | None = None
    H_kN: float | None = None
    w_mm: float | None = None
    V_kN: float | None = None
    increments: int = 0
    cut_backs: int = 0
    median_iterations: float | None = None
    max_iterations: int | None = None
    worst_residual: float | None = None
    energy_imbalance: float | None = None
    water_imbalance: float | None = None
    condition: float | None = None
    factorisations: int = 0
    wall_s: float = 0.0


def cases_named(names: Sequence[str]) -> list[Case]:
    """Return the cases of these names or groups, all where none is given; UserInputError names what there is."""
    known = {case.name for case in CASES} | {case.group for case in CASES} | {"hard"}
    unknown = [name for name in names if name not in known]
    if unknown:
        groups = ", ".join(dict.fromkeys(case.group for case in CASES))
        text = f"; there are {', '.join(case.name for case in CASES)}; and the groups {groups}, hard"
        raise UserInputError(
            [Problem(key=f"--case {name}", message=f"no such case{suggestion(name, known)}{text}") for name in unknown]
        )
    requested = set(names)
    return [c for c in CASES if not requested or {c.name, c.group} & requested or (c.hard and "hard" in requested)]


def run_case(case: Case, mesh: str = "coarse", refinement: float = 1.0, reach: float = REACH) -> Outcome:
    """Run one case; errors that a scene can cause become an outcome, any other is a bug and is raised."""
    start = time.perf_counter()
    head: dict[str, Any] = {"group": case.group, "case": case.name, "what": case.what}
    try:
        scene = case.scene(mesh, reach).replace(mesh={"refinement": refinement})
        with warnings.catch_warnings(action="ignore"):  # a run's own warnings are in its record
            result = compute(scene)
    except (UserInputError, ValidationError) as error:
        return Outcome(**head, outcome=REFUSED, detail=_refusal(error))
    except PyspringsError as error:
        return Outcome(**head, outcome=UNEXPLAINED, detail=str(error), wall_s=time.perf_counter() - start)
    if result.record.stopped_by is StopReason.INTERRUPTED:
        raise KeyboardInterrupt
    return Outcome(
        **head, **_ending(result.record), **_figures(result.record), wall_s=round(time.perf_counter() - start, 1)
    )


def run_cases(
    cases: Iterable[Case], mesh: str, refinement: float = 1.0, report: Callable[[Outcome], None] = lambda _: None,
    reach: float = REACH, jobs: int = 1,
) -> pd.DataFrame:  # fmt: skip
    """Run cases, to ``reach`` (m) where they set no displacement; return a row each (see `Outcome`).

    ``jobs`` are worker processes (1: none), in which cases share the machine: their times grow. ``report`` is given the
    rows in their order. KeyboardInterrupt passes through: it has what ended before.

    Raises UserInputError: a refinement or a reach that the plain caisson refuses, too.
    """
    try:
        CASES[0].scene(mesh, reach).replace(mesh={"refinement": refinement})
    except ValidationError as error:
        raise refused("--refinement, --reach", _refusal(error)) from None
    tasks = [Task(case.name, _in_worker, (case, mesh, refinement, reach)) for case in cases]
    ended: dict[str, Outcome] = {}
    rows: list[Outcome] = []

    def done(task: Task, answer: Outcome | Exception) -> None:
        if isinstance(answer, Exception):
            raise answer
        ended[task.name] = answer
        while len(rows) < len(tasks) and tasks[len(rows)].name in ended:
            rows.append(ended[tasks[len(rows)].name])
            report(rows[-1])

    run_tasks(tasks, jobs, done)
    return table_of(rows)


def _in_worker(case: Case, mesh: str, refinement: float, reach: float, _: Progress) -> Outcome:
    """Run a case as a task (`core.workers`)."""
    return run_case(case, mesh, refinement, reach)


def table_of(rows: Iterable[Outcome]) -> pd.DataFrame:
    """Return outcomes as a table."""
    return pd.DataFrame([asdict(row) for row in rows], columns=[each.name for each in fields(Outcome)])


def summary(table: pd.DataFrame) -> dict[str, Any]:
    """Return counts of the outcomes; median iterations and share of cut-backs over the cases that reached their end."""
    done = table[table["outcome"].isin((CONVERGED, WARNED))]
    increments = int(done["increments"].sum())
    return {
        **{outcome: int((table["outcome"] == outcome).sum()) for outcome in OUTCOMES},
        "median_iterations": float(done["median_iterations"].median()) if len(done) else None,
        "increments": increments,
        "cut_backs": int(done["cut_backs"].sum()),
        "cut_backs_over_increments": float(done["cut_backs"].sum() / increments) if increments else None,
        "worst_energy_imbalance": float(done["energy_imbalance"].max()) if len(done) else None,
    }


def _refusal(error: UserInputError | ValidationError) -> str:
    if isinstance(error, ValidationError):
        errors = error.errors(include_url=False, include_context=False, include_input=False)
        return "; ".join(
            f"{'.'.join(str(part) for part in each['loc'])}: {each['msg']}".lstrip(": ") for each in errors
        )
    return "\n".join(error.lines)


def _ending(record: RunRecord) -> dict[str, Any]:
    """Return outcome and detail of a run that wrote a record."""
    if record.reached:
        detail = "; ".join(record.warnings)
        return {"outcome": WARNED if detail else CONVERGED, "detail": detail}
    named = any(reason.explains for reason in record.reasons)
    return {"outcome": STOPPED if named else UNEXPLAINED, "detail": "; ".join(record.short)}


def _figures(record: RunRecord) -> dict[str, Any]:
    solver = record.solver
    figures: dict[str, Any] = {"condition": solver.condition_estimate, "factorisations": solver.factorisations}
    for path in record.paths.values():
        figures |= {
            **{f"{name}_mm": 1e3 * path.end[name] for name in "uw"},
            **{f"{name}_kN": 1e-3 * path.end[name] for name in "HV"},
            "increments": path.increments,
            "cut_backs": path.cut_backs,
            "median_iterations": path.median_iterations,
            "max_iterations": path.max_iterations,
            "worst_residual": path.worst_residual,
            "energy_imbalance": path.energy["imbalance_over_largest_term"],
            "water_imbalance": (path.water or {}).get("worst_imbalance_over_exchanged"),
        }
    return figures


COLUMNS = (
    Column("case", "case", words=True),
    Column("outcome", "outcome", words=True),
    Column("u [mm]", "u_mm", ".2f"),
    Column("H [kN]", "H_kN", ",.0f"),
    Column("w [mm]", "w_mm", ".2f"),
    Column("V [kN]", "V_kN", ",.0f"),
    Column("increments", "increments", "d"),
    Column("cut", "cut_backs", "d"),
    Column("median", "median_iterations", ".0f"),
    Column("most", "max_iterations", ".0f"),
    Column("residual", "worst_residual", ".0e"),
    Column("energy", "energy_imbalance", ".0e"),
    Column("water", "water_imbalance", ".0e"),
    Column("condition", "condition", ".0e"),
    Column("wall [s]", "wall_s", ".0f"),
)
_DETAIL = Column("warning or reason", "detail", words=True)
_WIDTHS = (22, 11, *(max(9, len(column.head)) for column in COLUMNS[2:]))  # lines are printed one by one


def heading() -> str:
    """Return the two head lines."""
    return _padded([column.head for column in COLUMNS]) + "\n" + "  ".join("-" * width for width in _WIDTHS)


def line(row: dict[str, Any]) -> str:
    """Return one case, with its warning or reason below, if any."""
    text = _padded([column.cell(row) for column in COLUMNS])
    return f"{text}\n    {row['detail']}" if row["detail"] else text


def closing(summary: dict[str, Any]) -> str:
    """Return the counts, and two measures of the difficulty of the cases."""
    counts = ", ".join(f"{summary[name]} {name}" for name in OUTCOMES)
    if not summary["increments"]:
        return counts
    share = 100.0 * summary["cut_backs_over_increments"]
    return (
        f"{counts}\nover the cases that reached their end: median of iterations {summary['median_iterations']:.0f}, "
        f"{summary['cut_backs']} steps cut in {summary['increments']} increments ({share:.0f} %), "
        f"energy imbalance at most {summary['worst_energy_imbalance']:.0e}"
    )


def to_markdown(table: pd.DataFrame) -> str:
    """Return the table for a document, one line a case."""
    return Table.of((*COLUMNS, _DETAIL), table.to_dict("records")).markdown()


def _padded(cells: list[str]) -> str:
    sides = [str.ljust if column.words else str.rjust for column in COLUMNS]
    return "  ".join(side(cell, width) for side, cell, width in zip(sides, cells, _WIDTHS, strict=True)).rstrip()
