# SPDX-License-Identifier: MIT
"""The table of a study: a row a setting of the full model, then a row a macro-model; costs and errors; its picture."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from pysprings.core.path_kinds import driven
from pysprings.core.storage import read_tree
from pysprings.full_model.accuracy import measures
from pysprings.full_model.accuracy.measures import LOAD, OTHER, Curve, Grid, Reference, Sample
from pysprings.full_model.accuracy.presets import BRICKS, FOURIER, MESH, Setting
from pysprings.full_model.accuracy.target import JUDGED
from pysprings.full_model.run_record import RunRecord, Status
from pysprings.macro import comparison
from pysprings.macro.comparison import curves
from pysprings.macro.model import spring_sets
from pysprings.results.layout import open_result
from pysprings.results.plots.style import BLUE, GREEN, GREY, INK, ORANGE, PURPLE, VERMILLION, new_figure, plain, styled
from pysprings.springs.path import SpringPath
from pysprings.springs.springs import Springs
from pysprings.studies.accuracy.runs import Ended


def front(cost: Sequence[float], error: Sequence[float]) -> list[int]:
    """Return the numbers of the choices that none is both cheaper and better than, by cost; NaN is never among them.

    >>> front([1.0, 2.0, 3.0, 4.0], [9.0, 4.0, 5.0, 1.0])
    [0, 1, 3]
    """
    costs, errors = np.asarray(cost, dtype=float), np.asarray(error, dtype=float)
    counted = np.flatnonzero(np.isfinite(costs) & np.isfinite(errors))
    best, best_ones = np.inf, []
    for k in counted[np.lexsort((errors[counted], costs[counted]))]:
        if errors[k] < best:
            best = errors[k]
            best_ones.append(int(k))
    return best_ones


# group of settings, or discretisation of a mesh -> mark, colour
MARKS = {
    "bricks": ("o", BLUE),
    "Fourier series": ("P", INK),
    "steps": ("s", ORANGE),
    "tolerance": ("D", GREEN),
    "linear solver": ("^", PURPLE),
    "macro-model": ("x", VERMILLION),
}
# panels: model, column of the error, title, axis of the time and its factor from seconds
KINDS = {"bricks": BRICKS, "Fourier series": FOURIER}  # names of the meshes of each discretisation
PANELS = (
    ("full", "load_max_pct", "full model, load: largest", "wall time of the whole run [s]", 1.0),
    ("full", "py_rms_pct", "full model, p-y: root mean square", "wall time of the whole run [s]", 1.0),
    ("macro", "load_max_pct", "macro-model, load: largest", "time of a curve of 50 points [ms]", 1e3),
)
LEAST = 1e-3  # %: smaller errors are drawn there


@styled
def error_against_time(table: pd.DataFrame, title: str, targets: Collection[float] = ()) -> Figure:
    """Draw the table of a study (`pysprings.studies.accuracy`): error [%] over wall time [s], both logarithmic.

    Marks with a white middle show the uncertainty of the reference itself. Dotted lines: ``targets`` [%].
    """
    figure = new_figure(14.0, 5.2)
    every = figure.subplots(1, len(PANELS), sharey=True)
    for axes, (model, column, words, label, factor) in zip(every, PANELS, strict=True):
        shown = table[(table["model"] == model) & (table["status"] == "complete")]
        shown = shown[shown[column].notna()]
        _panel(axes, shown.assign(time=factor * shown["wall_s"].astype(float)), column, targets)
        axes.set(title=words, xlabel=label)
    every[0].set_ylabel("error beside the reference [% of the largest]")
    every[0].yaxis.set_major_formatter("{x:g}")
    known = {text: handle for axes in every for handle, text in zip(*axes.get_legend_handles_labels(), strict=True)}
    figure.legend(known.values(), known.keys(), loc="outside lower center", ncols=max(len(known), 1))
    figure.suptitle(plain(f"Error against time: {title}"))
    return figure


def _panel(axes: Axes, shown: pd.DataFrame, column: str, targets: Collection[float]) -> None:
    axes.set(xscale="log", yscale="log")
    for group, (mark, colour) in MARKS.items():
        part = shown[shown["group"] == group]
        if group in KINDS:
            part = shown[(shown["group"] == MESH) & (shown["discretisation"] == KINDS[group])]
        if len(part):
            _marks(axes, part, column, mark, colour, group)
    for name, kind in KINDS.items():
        _front(axes, shown[shown["discretisation"] == kind], column, name, MARKS[name][1])
    _names(axes, shown, column)
    for limit in targets:
        axes.axhline(limit, color=GREY, linewidth=0.9, linestyle=":")
        axes.annotate(
            f" {limit:g} %", (1.0, limit), xycoords=("axes fraction", "data"), fontsize=8, va="center", color=GREY
        )
    if len(shown):  # whole decades: a range of less has no room for its labels
        low, high = np.log10(shown["time"].min()), np.log10(shown["time"].max())
        axes.set_xlim(10.0 ** np.floor(low - 0.02), 10.0 ** np.ceil(high + 0.02))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())


def _names(axes: Axes, shown: pd.DataFrame, column: str) -> None:
    """Write the names of the meshes at their marks, above and below in turn."""
    part = shown[shown["group"] == MESH].sort_values("time")
    for k, row in enumerate(part.to_dict("records")):
        above = k % 2 == 0
        axes.annotate(
            str(row["name"]).removeprefix(f"{FOURIER}-"), (row["time"], max(row[column], LEAST)),
            textcoords="offset points", xytext=(0, 7 if above else -7), fontsize=7.5,
            ha="center", va="bottom" if above else "top", color=BLUE if row["discretisation"] == BRICKS else INK,
        )  # fmt: skip


def _marks(axes: Axes, part: pd.DataFrame, column: str, mark: str, colour: str, group: str) -> None:
    quantity = column.split("_")[0]
    values = part[column].clip(lower=LEAST)
    look: dict[str, Any] = {"color": colour}
    if mark != "x":  # which has no middle
        face = ["white" if quantity in own.split(", ") else colour for own in part["reference"]]
        look = {"facecolors": face, "edgecolors": colour}
    axes.scatter(part["time"], values, marker=mark, s=34, linewidths=1.3, zorder=3, label=group, **look)


def _front(axes: Axes, shown: pd.DataFrame, column: str, name: str, colour: str) -> None:
    """Draw the Pareto front of a discretisation by steps: any time between two runs gives the error of the cheaper."""
    best = shown.iloc[front(shown["time"].tolist(), shown[column].tolist())]
    if len(best) > 1:
        errors = best[column].clip(lower=LEAST)
        label = f"Pareto front, {name}"
        axes.step(best["time"], errors, where="post", linewidth=1.2, zorder=2, label=label, color=colour)


@dataclass(frozen=True)
class Answer:
    """What one spring set with so many depth slices answers along each path; seconds of a curve of 50 points.

    ``paths`` are those of the lateral paths ``lateral`` along which there is an answer.
    """

    springs: str
    slices: int
    lateral: list[str]
    paths: Mapping[str, Curve]
    seconds: float


def _answers(springs: xr.DataTree) -> Iterator[Answer]:
    """Yield the answers of the best spring set (fan if present, else full), from one slice to all of them.

    Vertical paths have springs of their own, without slices; the set answers the others.
    """
    given = Springs.of(springs)
    kind = "fan" if "fan" in spring_sets(given) else "full"
    names = [name for name, path in given.paths.items() if not path.is_vertical]
    if not names:
        return
    for n in comparison.slice_counts(given):
        merged = comparison.merge_slices(given, n)
        traces = {name: curves(merged, name, kind).get(kind) for name in names}
        traced = {name: _curve(merged.paths[name], trace) for name, trace in traces.items() if trace is not None}
        whole = {name: curve for name, curve in traced.items() if curve is not None}
        yield Answer(kind, n, names, whole, comparison.curve_seconds(merged, kind))


def _curve(path: SpringPath, trace: xr.Dataset) -> Curve | None:
    """Return the curve of a macro-model in the form of the full model's, without p(y), which belongs to the springs."""
    n, full = trace.sizes["step"], path.dataset
    states = full.isel(step=slice(0, n)).assign({name: ("step", trace[name].values) for name in ("H", "M", "rotation")})
    if driven(path.attrs) == "rotation":  # what is imposed is the full model's
        states = states.assign(rotation=("step", full["rotation"].values[:n]))
    x = measures.driver_of(states, path.length)
    rising = measures.leading(x) if n else np.zeros(0, dtype=int)
    if rising.size < 2:
        return None
    by_x = {LOAD: measures.load_of(states), OTHER: measures.other_of(states)}
    none = np.zeros((0, rising.size))
    return Curve(x[rising], {name: v[rising] for name, v in by_x.items() if v is not None}, none, none, float("nan"))


FULL, MACRO = "full", "macro"
REFERENCE = "reference"  # column: the error is that of the reference itself


@dataclass(frozen=True)
class StudyResult:
    """What a study has found: the table, and the reference by path and quantity with its uncertainty by measure [%].

    ``series`` names the meshes of the reference, the finest last; ``settings`` are those that were run. ``limits`` are
    the limits of each discretisation by path and quantity; ``kind`` is the discretisation of the reference.
    """

    table: pd.DataFrame
    references: Mapping[str, Mapping[str, Reference]]
    uncertainty: Mapping[str, Mapping[str, float]]
    series: Sequence[str]
    settings: Sequence[Setting]
    limits: Mapping[str, Mapping[str, Mapping[str, Reference]]]
    kind: str

    @property
    def apart(self) -> dict[str, dict[str, float]]:
        """Difference [%] of the limit of bricks from a reference of Fourier series, by path and measure."""
        other = self.limits.get(BRICKS)
        if self.kind != FOURIER or other is None:
            return {}
        return {
            path: measures.errors(
                {name: each.values for name, each in other[path].items()},
                {name: each.values for name, each in known.items()},
            )
            for path, known in self.references.items()
        }


@dataclass(frozen=True)
class Truth:
    """What runs are measured by, path by path: where they are compared, the reference, its uncertainty by measure [%].

    ``finest`` is the mesh that is the reference in what could not be extrapolated.
    """

    grids: Mapping[str, Grid]
    references: Mapping[str, Mapping[str, Reference]]
    uncertainty: Mapping[str, Mapping[str, float]]
    finest: str

    def columns(self, name: str, by_path: Mapping[str, Sample]) -> dict[str, Any]:
        """Return the cells of a run on the mesh of this name: its errors, worst path, and of what it is the reference.

        Without samples, nothing is known.
        """
        worst = measures.worst([self._errors(path, sample, name) for path, sample in by_path.items()])
        own = {quantity for each in self.references.values() for quantity, one in each.items() if not one.extrapolated}
        names = ", ".join(sorted(own)) if by_path and name == self.finest else ""
        return {REFERENCE: names} | {f"{measure}_pct": value for measure, value in worst.items()}

    def _errors(self, path: str, sample: Sample, name: str) -> dict[str, float]:
        """Return errors [%] by measure; for a finest mesh that is the reference, at least its uncertainty."""
        references = self.references[path]
        errors = measures.errors(sample, {quantity: one.values for quantity, one in references.items()})
        for key, measure in measures.MEASURES.items():
            if measure.quantity not in references or references[measure.quantity].extrapolated:
                continue
            doubt = self.uncertainty[path][key]
            if np.isnan(doubt):  # one mesh gives no estimate of its own error, nor of that of others
                errors[key] = doubt
            elif name == self.finest:
                errors[key] = max(errors[key], doubt)
        return errors


def assess(runs: Sequence[Ended]) -> StudyResult:
    """Return errors and costs of the runs that reached their end, and costs of the others.

    The reference is extrapolated from the complete runs of the series. The finest of them is its own reference in what
    could not be extrapolated: the uncertainty stands in the place of its error, and the column `reference` names it.
    """
    complete = [each for each in runs if each.complete]
    curves = {each.setting.name: measures.curves_of(open_result(each.folder)) for each in complete}
    series = _series(complete)
    grids = measures.common_grids(curves) if series else {}
    by_path = measures.samples(curves, grids)
    truths = {kind: _truth(each, grids, by_path) for kind, each in series.items()}
    kind = _better(series)
    truth = truths.get(kind, Truth(grids, {}, {}, ""))
    rows = []
    for each in runs:
        name = each.setting.name
        own = {path: mine[name] for path, mine in by_path.items() if name in mine}
        rows.append(_costs(each) | truth.columns(name, own))
    for each in complete:
        if each.setting.group == MESH and by_path:
            rows += _macro_rows(each, truth)
    table = pd.DataFrame(rows).astype({"harmonics": "Int64"})
    table["pareto"] = _on_front(table)
    table = table.assign(from_mesh_pct=table["name"].map(_changes_alone(curves, complete)).astype(float))
    return StudyResult(
        table, truth.references, truth.uncertainty, [each.setting.name for each in series.get(kind, [])],
        [each.setting for each in runs], {name: each.references for name, each in truths.items()}, kind,
    )  # fmt: skip


def _series(complete: Sequence[Ended]) -> dict[str, list[Ended]]:
    """Return the runs of the series by discretisation, the finest last."""
    series: dict[str, list[Ended]] = {}
    for each in sorted(complete, key=_unknowns):
        if each.setting.series:
            series.setdefault(each.setting.discretisation, []).append(each)
    return series


def _better(series: Mapping[str, Sequence[Ended]]) -> str:
    """Return the discretisation whose limit is the reference: Fourier series where there are meshes enough."""
    enough = len(series.get(FOURIER, ())) >= measures.NEEDED or BRICKS not in series
    return FOURIER if enough and FOURIER in series else BRICKS


def _truth(
    series: Sequence[Ended], grids: Mapping[str, Grid], by_path: Mapping[str, Mapping[str, Sample]]
) -> Truth:  # fmt: skip
    """Make the reference of each path from the runs of the series, the finest last."""
    h = [measures.cell_size(_unknowns(each), _record(each).mesh.harmonics) for each in series]
    references = {
        path: measures.reference_of([own[each.setting.name] for each in series], h) for path, own in by_path.items()
    }
    doubts = {path: measures.uncertainty(each) for path, each in references.items()}
    return Truth(grids, references, doubts, series[-1].setting.name if series else "")


def _on_front(table: pd.DataFrame) -> pd.Series:
    """Return the rows that no other of the same model beats in wall time and one of the errors of the targets."""
    on_front = pd.Series(False, index=table.index)
    for model in (FULL, MACRO):
        part = table[(table["model"] == model) & (table["status"] == "complete")]
        for measure in JUDGED:
            on_front[part.index[front(part["wall_s"].tolist(), part[f"{measure}_pct"].tolist())]] = True
    return on_front


def _changes_alone(curves: Mapping[str, Mapping[str, Curve]], complete: Sequence[Ended]) -> dict[str, float]:
    """Return the largest load difference [%] of a variation from the run on the same mesh with the scene's settings."""
    plain = {each.setting.mesh_key: each.setting.name for each in complete if each.setting.group == MESH}
    changes = {}
    for each in complete:
        base = plain.get(each.setting.mesh_key)
        if each.setting.group != MESH and base is not None:
            both = measures.samples({"own": curves[each.setting.name], "base": curves[base]})
            differences = [measures.errors(one["own"], one["base"]) for one in both.values()]
            changes[each.setting.name] = measures.worst(differences)["load_max"]
    return changes


def _unknowns(each: Ended) -> int:
    return _record(each).mesh.unknowns


def _record(each: Ended) -> RunRecord:
    """Return the record of a run that has one: it reached its end."""
    assert each.record is not None
    return each.record


def _costs(each: Ended) -> dict[str, Any]:
    setting = each.setting
    return {
        "model": FULL, "name": setting.name, "group": setting.group, "discretisation": setting.discretisation,
        "harmonics": setting.harmonics, "mesh": setting.mesh, "refinement": setting.refinement,
        "series": setting.series, "slices": None,
        "status": "complete" if each.complete else "stopped", "why": each.why,
    } | (_NO_FIGURES if each.record is None else _figures(each.record))  # fmt: skip


def _figures(record: RunRecord) -> dict[str, Any]:
    """Return size, work and cost of a run."""
    solver, paths = record.solver, record.paths.values()
    unit, wall, peak = solver.unit_s, record.wall_s, solver.peak_before_unit_bytes
    peak = record.peak_memory_bytes if peak is None else peak
    return {
        "unknowns": record.mesh.unknowns, "linear": solver.linear,
        "increments": sum(path.increments for path in paths),
        "iterations": sum(path.iterations + path.iterations_in_cut_backs for path in paths),
        "factorisations": solver.factorisations,
        "wall_s": wall, "cpu_s": record.cpu_s, "unit_s": unit, "units": wall / unit if unit and wall else None,
        "memory_MB": peak / 1e6 or None,
    }  # fmt: skip


_NO_FIGURES = {name: None for name in _figures(RunRecord(Status.PARTIAL))} | {"increments": 0, "iterations": 0}


def _macro_rows(each: Ended, truth: Truth) -> list[dict[str, Any]]:
    """Return rows of the macro-models whose springs come from a run, by number of depth slices."""
    springs: xr.DataTree = read_tree(each.folder / "springs.nc")
    setting, unit, rows = each.setting, _record(each).solver.unit_s, []
    for answer in _answers(springs):
        lateral, compared = [path for path in answer.lateral if path in truth.grids], {}
        for path in lateral:
            curve, x = answer.paths.get(path), truth.grids[path].x
            if curve is not None and curve.x[-1] >= x[-1] * (1.0 - 1e-9):  # else it did not get as far
                answers = measures.sampled(curve, Grid(x, np.zeros((0, x.size))))
                compared[path] = {name: answers[name] for name in (LOAD, OTHER) if name in answers}
        complete = 0 < len(compared) == len(lateral)
        rows.append({
            "model": MACRO, "name": f"{setting.name}, {answer.springs}, {answer.slices} slices",
            "group": "macro-model", "discretisation": setting.discretisation, "harmonics": setting.harmonics,
            "mesh": setting.mesh, "refinement": setting.refinement,
            "series": setting.series, "slices": answer.slices, "status": "complete" if complete else "stopped",
            "why": "" if complete else "the springs do not carry all paths to their ends",
            "unknowns": _unknowns(each), "wall_s": answer.seconds, "cpu_s": answer.seconds,
            "unit_s": unit, "units": answer.seconds / unit if unit else None,
            **truth.columns(setting.name, compared if complete else {}),
        })  # fmt: skip
    return rows
