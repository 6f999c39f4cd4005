# SPDX-License-Identifier: MIT
"""The macro-model beside the full model: errors by path and spring set, at the recorded displacements.

A path is followed as the full model was driven: lateral displacement with the load at its height (pull,
load), or displacement and rotation imposed (translation, rotation, swipe). Errors are those of the answer: load and
rotation for the first, H and M for the second. With the sets "py" and "full" a calibration path is answered by its
own springs, a held-back path by the springs of the first calibration path. The set "fan" is made from all rays
among the calibration paths and answers every path; "pisa" takes its lateral families from the pure translation among
them and its moments from the pure rotation. Where calibration paths have several rates, every path is answered at its
own, and so it is with several vertical loads (`pysprings.springs.path_sets`). A path of kind "vertical" is answered by
the vertical springs (set "vertical"): V at equal w, its errors relative to the change of V from rest.

A held-back path with a `vertical_load` of its own is answered under that load. Where the vertical load changes on the
way, w follows, and the lateral springs stay those under the first one. `off_load_states` counts the states
whose vertical load is not that of these springs, `w_error_...` is the largest distance of w.

On a swipe and under a load that climbs, whose states are imposed, and on a path that turns back errors are relative to
the largest answer of the path.

Read the other way, `u_error_...` is the displacement that the macro-model needs for the full model's load (H and M of
each recorded state), over the full model's, minus 1; `u_error_half_pct` is the largest up to half of the largest load.
`rotation_point_...`: depth of the point of the axis at rest.

Paths out of one plane are answered by springs with memory in space (`pysprings.macro.space.compare_in_space`).

On their own paths the full set and the fan meet the recorded states by construction. What they do between them is
measured too: `..._error_between_pct` is the largest error when every second recorded state is left out of the
springs.

The measures are those of `pysprings.macro.measures`. `slice_convergence`: error and cost over the number of depth
slices.
"""

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
import pandas as pd
import xarray as xr

from pysprings.core.arrays import Array
from pysprings.core.columns import Column, Table, filled
from pysprings.core.errors import refused
from pysprings.core.path_kinds import VERTICAL
from pysprings.core.text import suggestion
from pysprings.macro import measures
from pysprings.macro.answer import trace
from pysprings.macro.model import MacroModel, spring_sets
from pysprings.macro.space import MEMORY, compare_in_space
from pysprings.macro.spring_sets import SPRING_SETS
from pysprings.macro.vertical import build_vertical
from pysprings.macro.vertical_answer import along_vertical
from pysprings.macro.ways import Control
from pysprings.springs.checks import SCHEMA, extract_springs
from pysprings.springs.path import SpringPath
from pysprings.springs.springs import Springs
from pysprings.springs.sums import slice_heights

AT_LOAD = {"long_name": "lateral displacement of the lid centre under the load of the full model", "units": "m"}
# columns of a comparison without a row: no path has springs that answer
_OF_EVERY_ROW = ["path", "role", "kind", "arm_m", "springs", "springs_from", "V_N", "status", "path_end"]
FEWEST_THINNED = 4  # a path needs more states than these for every second one to be left out


@dataclass(frozen=True, eq=False)
class Comparison:
    """The macro-model beside the full model that its springs come from. Everything is computed at its first use, once.

    springs : the springs.
    springs_kind : the only spring set that is compared; None for all that the springs give.
    """

    springs: Springs
    springs_kind: str | None = None
    _models: dict[tuple[Springs, str, str | None], MacroModel] = field(default_factory=dict, repr=False)

    @classmethod
    def of(cls, model: Springs | xr.DataTree, springs_kind: str | None = None) -> Self:
        """Return the comparison of springs, or of a full-model result, whose springs are extracted first.

        Raises UserInputError for a spring set that the springs do not give.
        """
        springs = _springs_of(model)
        sets = spring_sets(springs.answering(springs.path()))
        if springs_kind is not None and springs_kind not in sets:
            raise refused(
                "springs_kind",
                f"no springs '{springs_kind}' here{suggestion(springs_kind, sets)}; there are: {', '.join(sets)}",
            )
        return cls(springs, springs_kind)

    @cached_property
    def curves(self) -> Mapping[str, Mapping[str, xr.Dataset]]:
        """Answers of the macro-model along each path of the full model, by path and spring set: see `curves`."""
        return {name: self.along(path) for name, path in self.springs.paths.items()}

    @cached_property
    def frame(self) -> pd.DataFrame:
        """One row per path and spring set: eta, errors [%], ends of both models, point of rotation."""
        rows = [
            self._row(self.springs.paths[name], spring_set, answer)
            for name, answers in self.curves.items()
            for spring_set, answer in answers.items()
        ]
        frame = pd.DataFrame(rows) if rows else pd.DataFrame(columns=_OF_EVERY_ROW)
        space = compare_in_space(self.springs) if self.springs_kind in (None, MEMORY) else frame[:0]
        frame = frame if space.empty else pd.concat([frame, space], ignore_index=True)
        frame.attrs = {key: self.springs.attrs.get(key, "") for key in ("title", "pysprings_version", "scene_sha256")}
        there = set(frame["path"])
        left = [name for name in (*self.springs.paths, *self.springs.space) if name not in there]
        frame.attrs |= {"reference": self.springs.reference, "unanswered": left if self.springs_kind is None else []}
        ways = {**self.springs.paths, **self.springs.space}
        frame.attrs["ends"] = {name: path.end.words for name, path in ways.items() if path.end.failed}
        return frame

    def along(self, path: SpringPath) -> dict[str, xr.Dataset]:
        """Return the answers along one path by spring set; a vertical path has the one set "vertical", or none."""
        springs = self.springs.answering(path)
        if path.is_vertical:
            table = build_vertical(springs) if self.springs_kind is None else None
            return {} if table is None else {VERTICAL: along_vertical(table, path)}
        kinds = spring_sets(springs) if self.springs_kind is None else [self.springs_kind]
        return {kind: _along(path, self._model(springs, kind, _source(path, kind))) for kind in kinds}

    def _model(self, springs: Springs, kind: str, source: str | None) -> MacroModel:
        """Return the model of a spring set; paths that share springs share it."""
        key = springs, kind, source
        if key not in self._models:
            self._models[key] = MacroModel.from_springs(springs, kind, source)
        return self._models[key]

    def _row(self, path: SpringPath, spring_set: str, answer: xr.Dataset) -> dict[str, Any]:
        rules, length, n = path.rules, self.springs.length, answer.sizes["step"]
        x, reference, values = measures.abscissa(path)[:n], path[rules.load][:n], answer[rules.load].values
        small = self.springs.diameter * measures.SMALL_OVER_DIAMETER
        small = small / length if rules.drives == "rotation" else small
        if rules.drives == "w":  # what is there at rest is no answer
            x, reference, values = x - x[0], reference - reference[0], values - reference[0]
        if rules.load == "H" and "H" not in measures.carried(path):
            reference = 0.0 * reference
        row: dict[str, Any] = {
            "path": path.name,
            "role": path.role,
            "kind": path.kind,
            "arm_m": path.arm,
            "springs": spring_set,
            "springs_from": answer.attrs["path"],
            "V_N": path.load,
            "status": answer.attrs["message"] or "complete",
            "path_end": path.end.how,
            **path.end.attributes(),
            "states": n - 1,
            "eta_small": measures.eta(x, reference, values, small),
            "eta_large": measures.eta(x, reference, values),
        }
        row |= measures.errors(path, answer, x, rules.answers) | self._between(path, spring_set)
        row |= measures.ends(path, answer) | measures.rotation_points(path, answer)
        row |= measures.at_equal_load(path, answer) | measures.distances(path, answer)
        return row | {
            "small_at": small,
            "skip_below": measures.SKIP_BELOW,
            "depths": answer.sizes["depth"],
            "depths_unusable": int((answer["usable"] == 0).sum()),
            **{f"{mark}_states": int(answer[mark][1:].sum()) for mark in ("extrapolated", "off_path", "off_load")},
        }

    def _between(self, path: SpringPath, spring_set: str) -> dict[str, float]:
        """Return the largest error [%] on a calibration path when every second state is left out of its own springs."""
        springs = self.springs.answering(path)
        own = path.calibrates if spring_set == VERTICAL else SPRING_SETS[spring_set].reproduces(springs, path)
        if path.n <= FEWEST_THINNED or not own:
            return measures.between({})
        thinned = _thinned(springs, path.name)
        if spring_set == VERTICAL:
            table = build_vertical(thinned)
            assert table is not None  # the path itself
            return measures.between(measures.errors(path, along_vertical(table, path), path.w - path.w[0], ("V",)))
        answer = _along(path, MacroModel.from_springs(thinned, spring_set, _source(path, spring_set)))
        x = measures.abscissa(path)[: answer.sizes["step"]]
        return measures.between(measures.errors(path, answer, x, path.rules.answers))


def compare(model: Springs | xr.DataTree, springs_kind: str | None = None) -> pd.DataFrame:
    """Return one row per path and spring set: eta, errors [%], ends of both models, point of rotation.

    Parameters
    ----------
    model
        Springs (`open_springs`), or a full-model result, whose springs are extracted first.
    springs_kind
        One spring set instead of all those that the model has.
    """
    return Comparison.of(model, springs_kind).frame


def curves(springs: Springs | xr.DataTree, path: str, springs_kind: str | None = None) -> dict[str, xr.Dataset]:
    """Return the macro-model's answer along one path of the full model, by spring set ("py", "full", "fan").

    The states are those the full model recorded, the initial state included. springs_kind: only this set. A vertical
    path has the one set "vertical", or none where there are no vertical springs.
    """
    given = Springs.of(springs)
    return Comparison(given, springs_kind).along(given.path(path))


def states(springs: Springs | xr.DataTree) -> pd.DataFrame:
    """Return both models state by state (SI): path, springs, step, and u, rotation, H, M of each."""
    comparison = Comparison(Springs.of(springs))
    return pd.concat(_states(comparison), ignore_index=True)


def _states(comparison: Comparison) -> Iterator[pd.DataFrame]:
    for name, answers in comparison.curves.items():
        path = comparison.springs.paths[name]
        for spring_set, answer in answers.items():
            n = answer.sizes["step"]
            data: dict[str, Any] = {"path": name, "springs": spring_set, "step": path["step"][:n]}
            for label, units in (("u", "m"), ("rotation", "rad"), ("H", "N"), ("M", "Nm")):
                data[f"{label}_full_{units}"] = path[label][:n]
                data[f"{label}_macro_{units}"] = answer[label].values
            yield pd.DataFrame(data)


def _springs_of(model: Springs | xr.DataTree) -> Springs:
    if isinstance(model, Springs) or model.attrs.get("schema") == SCHEMA:
        return Springs.of(model)
    return Springs.of(extract_springs(model))


def _source(path: SpringPath, spring_set: str) -> str | None:
    """Return the path whose springs answer a full-model path: its own if it calibrates; None: the usual ones."""
    return path.name if path.calibrates and not SPRING_SETS[spring_set].several else None


def _thinned(springs: Springs, name: str) -> Springs:
    """Return the springs without every second recorded state of one path; its ends stay."""
    last = springs.paths[name].n - 1
    steps = sorted({*range(0, last + 1, 2), last})
    paths = {each: path.at_steps(steps) if each == name else path for each, path in springs.paths.items()}
    return springs.with_paths(paths.values())


def _along(path: SpringPath, model: MacroModel) -> xr.Dataset:
    """Drive a macro-model as the full model was driven, with its vertical load where the caisson is free to heave."""
    loads = path.given_loads
    V = path.load if (loads == path.load).all() else loads
    return along_path(path, model, V if path.free_to_heave else None)


def along_path(path: SpringPath, model: MacroModel, V: float | Array | None = None) -> xr.Dataset:
    """Drive a macro-model as the full model was driven, through the states it recorded, and under its loads.

    V: vertical load [N], one number or one a state; None: that of the springs. `u_at_load` is NaN beyond the loads that
    the macro-model carries.
    """
    control: Control = "displacement" if path.rules.free_head else "state"
    arm = path.arm if path.rules.free_head else 0.0
    answer = trace(model, control, np.stack([path.u, path.rotation], axis=1), arm, V)
    n = answer.sizes["step"]
    solved, _, _ = model.solve("load", np.stack([path["H"][:n], path["M"][:n]], axis=1))
    u = np.append(solved[:, 0], np.full(n - len(solved), np.nan))
    return answer.assign(u_at_load=("step", u, AT_LOAD))


REPEATS = 5
POINTS = 50
_ERRORS = ("H_error_max_pct", "rotation_error_max_pct", "M_error_max_pct", "u_error_max_pct")


def merge_slices(springs: Springs | xr.DataTree, n: int) -> Springs:
    """Return springs with n depth slices, made of neighbours: p, m and t are means, y is that of the mean depth.

    Forces and distributed moments stay what they are; the moment of p within a merged slice is lost, as in a table
    with so few depths. Springs with memory, whose elements have no slices, are left out with their paths.
    """
    given = Springs.of(springs)
    depths = _depths(given)
    if not 1 <= n <= depths:
        raise refused("slices", f"{n} slices: the springs have 1 to {depths}")
    paths = [path for path in given.paths.values() if not path.remembers]
    return replace(given, memory={}).with_paths(replace(path, recorded=_merged(path.recorded, n)) for path in paths)


def _depths(springs: Springs) -> int:
    return int(next(iter(springs.paths.values())).depth.size)


def _merged(path: xr.Dataset, n: int) -> xr.Dataset:
    height, bounds = slice_heights(path), path["depth_bounds"].values
    groups = np.array_split(np.arange(height.size), n)
    share = np.zeros((n, height.size))
    for row, group in enumerate(groups):
        share[row, group] = height[group] / height[group].sum()
    depth = share @ path["depth"].values
    ends = np.array([[bounds[group[0], 0], bounds[group[-1], 1]] for group in groups])
    data: dict[str, Any] = {}
    for name, variable in path.data_vars.items():
        if "depth" not in variable.dims:
            data[str(name)] = variable.variable
        elif name not in ("depth_bounds", "y"):
            data[str(name)] = (variable.dims, np.tensordot(share, variable.values, axes=(1, 0)), variable.attrs)
    y = share @ path["y"].transpose("depth", "step").values
    data |= {"depth_bounds": (path["depth_bounds"].dims, ends, path["depth_bounds"].attrs)}
    data |= {"y": (("depth", "step"), y, path["y"].attrs)}
    coords = {name: value.variable for name, value in path.coords.items() if "depth" not in value.dims}
    return xr.Dataset(data, coords | {"depth": ("depth", depth, path["depth"].attrs)}, path.attrs)


def slice_counts(springs: Springs) -> list[int]:
    """Return 1, 2, 4 ... and the number of slices that the springs have."""
    depths = _depths(springs)
    return sorted({2**k for k in range(depths.bit_length()) if 2**k < depths} | {depths})


def slice_convergence(
    springs: Springs | xr.DataTree, counts: Sequence[int] | None = None, springs_kind: str | None = None
) -> pd.DataFrame:
    """Return one row per number of slices, spring set and role of path: largest errors [%], eta, and cost.

    Errors are those of `comparison.compare` (their sizes), largest over the paths of a role. curve_ms is the time of a
    curve of 50 points on the last path, in this process, after a first one.
    """
    given, rows = Springs.of(springs), []
    for n in counts or slice_counts(given):
        coarse = merge_slices(given, n)
        frame = compare(coarse, springs_kind)
        frame = frame[frame["springs"] != "vertical"]
        for (spring_set, role), part in frame.groupby(["springs", "role"], sort=False):
            row: dict[str, Any] = {"slices": n, "springs": spring_set, "role": role}
            row |= {name: part[name].abs().max() for name in _ERRORS if name in part}
            row |= {"eta_large": part["eta_large"].min()}
            rows.append(row | {"curve_ms": 1e3 * curve_seconds(coarse, str(spring_set))})
    return pd.DataFrame(rows)


def curve_seconds(springs: Springs | xr.DataTree, spring_set: str) -> float:
    """Return the median time [s] of a curve of 50 points on the last lateral path, after a first one."""
    given = Springs.of(springs)
    path = [path for path in given.paths.values() if not path.is_vertical][-1]
    model = MacroModel.from_springs(given, spring_set)
    targets = np.zeros((POINTS, 2))
    targets[:, 0] = np.linspace(0.0, 0.5 * float(np.abs(path.u).max()), POINTS)
    times = []
    for _ in range(REPEATS + 1):
        start = time.perf_counter()
        model.solve("displacement", targets)
        times.append(time.perf_counter() - start)
    return float(np.median(times[1:]))


_COLUMNS = (
    Column("slices", "slices"),
    Column("springs", "springs", words=True),
    Column("H max [%]", "H_error_max_pct"),
    Column("u max [%]", "u_error_max_pct"),
    Column("rot max [%]", "rotation_error_max_pct"),
    Column("M max [%]", "M_error_max_pct"),
    Column("eta large", "eta_large"),
    Column("50 points [ms]", "curve_ms"),
)


def convergence_text(frame: pd.DataFrame) -> str:
    """Return the convergence as tables for a terminal, one a role."""
    lines = []
    for role, part in frame.groupby("role", sort=False):
        rows = part.to_dict("records")
        text = Table.of(filled(_COLUMNS, rows), rows).text()
        lines += [f"{role} paths, largest errors by number of depth slices", text, ""]
    return "\n".join(lines)
