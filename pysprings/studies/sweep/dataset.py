# SPDX-License-Identifier: MIT
"""`study.nc`: one dataset of a study, a dimension an axis (or `case`), written case by case; pictures of it.

`open_study` opens it lazily: what is not asked for is not read. Of a case it keeps loads and springs of its paths on a
grid that all cases share: shares of the aim of a path (`SHARES`) and of the skirt length (`DEPTHS` slices). Reactions
by depth are remapped such that their sum stays; what their moment about mudline loses is put into m, so that it stays,
too.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import xarray as xr

from pysprings.core.arrays import Array
from pysprings.core.errors import PyspringsError, refused
from pysprings.core.path_kinds import PATH_KINDS, direction_of_load
from pysprings.core.storage import replacing
from pysprings.core.text import suggestion
from pysprings.core.units import unit_of
from pysprings.core.variables import DOFS
from pysprings.core.version import __version__
from pysprings.core.words import ESTIMATES
from pysprings.full_model.run_record import RunRecord
from pysprings.results.exporters.csv import write_frame
from pysprings.results.sheets import write_sheet
from pysprings.scene.model import Scene
from pysprings.scene.sections import Path as ScenePath
from pysprings.springs.checks import open_springs
from pysprings.springs.path import SpringPath
from pysprings.springs.path_ends import LIMIT_LOAD, MESH_ERROR
from pysprings.springs.springs import Springs
from pysprings.springs.sums import secant_slopes
from pysprings.studies.sweep.plan import DONE, SCHEMA, SHORT, Axis, Case, Plan, split

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pysprings.studies.sweep.study import Study


SHARES: Array = np.concatenate([[0.0], np.geomspace(1e-3, 1.0, 24)])
DEPTHS = 8
STATES = ("u", "w", "rotation", "H", "V", "M")
ENDS = ("H_tip", "M_tip", "V_tip", "H_lid", "M_lid", "V_lid")
BY_DEPTH = ("p", "m", "t")
BY_PATH = {  # unit, value where nothing is known, meaning; of all states of a path
    "H_largest": ("N", np.nan, "largest |H| of the path; of a vertical path none"),
    "M_largest": ("N m", np.nan, "largest |M| of the path; of a vertical path none"),
    "V_largest": ("N", np.nan, "of a vertical path: largest V in its direction, positive down"),
    "reached": ("1", 0.0, "share of its aim that the path reached"),
    "limit_load": ("1", 0.0, "1 where the path ended at a limit load, so that the largest load is a capacity"),
    MESH_ERROR: ("%", np.nan, "estimate of the error of the load that the mesh makes"),
}
_DRIVEN = {"lateral_displacement": "u", "rotation": "rotation", "vertical_displacement": "w", "lateral_force": "H"}


@dataclass(frozen=True)
class Measured:
    """One case on the common grid.

    stiffness : initial stiffness (3, 3) for (u, w, rotation).
    along : (path, share) of STATES and ENDS, by name; NaN where the path ended before.
    by_depth : (path, depth, share) of BY_DEPTH, by name.
    by_path : (path,) of BY_PATH, by name.
    numbers : one number each: cost, size, error.
    """

    stiffness: Array
    along: Mapping[str, Array]
    by_depth: Mapping[str, Array]
    by_path: Mapping[str, Array]
    numbers: Mapping[str, float]


def measure(folder: Path, scene: Scene, paths: tuple[str, ...]) -> Measured | None:
    """Return a case by its folder; None where it has no springs."""
    try:
        springs = Springs.of(open_springs(folder / "springs.nc"))
    except PyspringsError:
        return None
    n, k, known = len(paths), len(SHARES), {path.name: path for path in scene.load_paths}
    along = {name: np.full((n, k), np.nan) for name in (*STATES, *ENDS)}
    by_depth = {name: np.full((n, DEPTHS, k), np.nan) for name in BY_DEPTH}
    by_path = {name: np.full(n, nothing) for name, (_, nothing, _) in BY_PATH.items()}
    for row, name in enumerate(paths):
        path = springs.paths.get(name)
        if path is None or name not in known or path.n < 2:
            continue
        share = shares_of(path, known[name])
        found = (*_largest(path), min(share[-1], 1.0), path.end.how == LIMIT_LOAD)
        for each, value in zip(BY_PATH, (*found, path.end.mesh_error), strict=True):
            by_path[each][row] = value
        for each in (*STATES, *ENDS):
            along[each][row] = _resampled(share, path[each])
        _put_depths(path, share, by_depth, row)
    stiffness = springs.stiffness
    matrix = np.full((3, 3), np.nan) if stiffness is None else stiffness
    return Measured(matrix, along, by_depth, by_path, _numbers(folder))


def _largest(path: SpringPath) -> tuple[float, float, float]:
    """Return the largest |H| and |M| of a path, and V of a vertical one, in whose H and M is what the solver leaves."""
    if not path.is_vertical:
        return np.abs(path["H"]).max(), np.abs(path["M"]).max(), np.nan
    way = np.sign(path.w[-1] - path.w[0])
    return np.nan, np.nan, way * (way * path["V"]).max()


def shares_of(path: SpringPath, asked: ScenePath) -> Array:
    """Return how far a path has come towards its aim, by state, as far as that grows."""
    kind = PATH_KINDS[asked.kind]
    aim = getattr(asked, kind.imposed)
    values = path[_DRIVEN[kind.imposed]]
    if (along := direction_of_load(path.attrs)) is not None:  # the displacement conjugate to it is imposed
        values = along[0] * path.u + along[1] * path.rotation
    if aim is None or aim == 0.0:
        return np.linspace(0.0, 1.0, path.n)
    share = (values - values[0]) / aim  # w starts at the settlement under the dead load
    falls = np.flatnonzero(np.diff(share) <= 0.0)
    return share[: falls[0] + 1] if falls.size else share


def _resampled(share: Array, values: Array) -> Array:
    """Return values (..., step) at SHARES; NaN beyond the last one.

    Cubic in the share as a fan is (`secant_slopes`), and linear in the values: sums stay sums.
    """
    from scipy.interpolate import CubicHermiteSpline

    n = len(share)
    if n < 2 or share[1] <= 0.0:
        return np.full((*values.shape[:-1], len(SHARES)), np.nan)
    rows = np.atleast_2d(values[..., :n])
    slopes = secant_slopes(share, rows, (rows[:, 1] - rows[:, 0]) / share[1])
    answer: Array = CubicHermiteSpline(share, rows, slopes, axis=-1)(SHARES)
    answer[:, share[-1] * (1.0 + 1e-9) < SHARES] = np.nan
    return answer.reshape((*values.shape[:-1], len(SHARES)))


def _put_depths(path: SpringPath, share: Array, by_depth: Mapping[str, Array], row: int) -> None:
    """Remap the reactions by depth of a path."""
    weights = remap(path.recorded["depth_bounds"].values, path.length)
    slices = path.length / DEPTHS
    middle = (np.arange(DEPTHS) + 0.5) * slices
    recorded = {name: path.by_depth(name) for name in BY_DEPTH}
    mapped = {name: weights @ values / slices for name, values in recorded.items()}
    lost = (path.depth * path.heights) @ recorded["p"] - (middle * slices) @ mapped["p"]
    mapped["m"] = mapped["m"] - lost / path.length
    for name, values in mapped.items():
        by_depth[name][row] = _resampled(share, values)


def remap(bounds: Array, length: float) -> Array:
    """Return the height that each slice (columns) shares with each slice of the grid (rows) [m]."""
    edges = np.linspace(0.0, length, DEPTHS + 1)
    low = np.maximum(edges[:-1, None], bounds[None, :, 0])
    high = np.minimum(edges[1:, None], bounds[None, :, 1])
    return np.maximum(high - low, 0.0)


def _numbers(folder: Path) -> dict[str, float]:
    """Return cost, size and error of a case by its record."""
    record = RunRecord.read(folder)
    if record is None:
        return {}
    how = (record.error_estimate or {}).get("extrapolated", {})
    lost = [value for path in (record.balance or {}).values() for value in path.values()]
    return {
        "wall_s": record.wall_s, "cpu_s": record.cpu_s, "peak_memory_bytes": float(record.peak_memory_bytes),
        "unknowns": float(record.mesh.unknowns or 0), "balance_error": max(lost, default=float("nan")),
        "iterations": float(sum(path.iterations for path in record.paths.values())),
        "extrapolated": len(how.get("paths", ())) / max(len(record.paths), 1),
    }  # fmt: skip


def axis_names(data: xr.Dataset) -> list[str]:
    """Return the axes of a study whose values are numbers."""
    return [name for name in str(data.attrs["axes"]).split(", ") if data[name].dtype.kind == "f"]


def draw(data: xr.Dataset, quantity: str, over: Sequence[str] = ()) -> Figure:
    """Return a picture of a quantity (`K_H`, `H_largest:ray_0`) over one axis or two; by default the first ones.

    Cases of a sample are points, whatever their other values are. Of a grid the other axes stand at the middle value,
    which the title names.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    from pysprings.results.plots.style import STYLE

    axes = axis_names(data)
    data = data.sortby([name for name in axes if name in data.dims])
    known = scalars(data)
    _refuse_unknown(quantity, list(known))
    if not over and not axes and (bars := _bars(data, known[quantity])):
        if np.isnan(bars[0]):
            raise refused("--picture", f"'{quantity}' has no answer with all ranges at best, which bars begin at")
        return _tornado(data, _named(quantity, known), *bars)
    chosen = list(over) or axes[:2]
    _refuse_axes(chosen, axes)
    values, others = _on(known[quantity], chosen, data)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(6.4, 4.6), layout="constrained")
        plot = figure.add_subplot()
        label = _named(quantity, known)
        x = data[chosen[0]]
        if len(chosen) == 1:
            plot.plot(x.values, values.values, "o" if "case" in values.dims else "o-", ms=4)
            plot.set_ylabel(label)
            plot.set_ylim(*_ends_if_alike(values))
        else:
            _map(figure, plot, (x, data[chosen[1]]), values, label)
        _mark_short(plot, _on(data["status"] == SHORT, chosen, data)[0], [data[name] for name in chosen], values)
        plot.set(xlabel=_label(x), xscale="log" if _by_ratio(x) else "linear")
        plot.set_title("\n".join(filter(None, (str(data.attrs["title"]), others))), fontsize=9)
    return figure


def _named(quantity: str, known: Mapping[str, xr.DataArray]) -> str:
    """Return a quantity with its unit; of a largest load, in how many cases it is that at the end of the path."""
    name, _, path = quantity.partition(":")
    label = f"{quantity} [{known[quantity].attrs.get('units', '1')}]"
    if not name.endswith("_largest"):
        return label
    ends = known[f"limit_load:{path}"].values[np.isfinite(known[quantity].values)]
    count = int((ends == 0.0).sum())
    return label + f"\nno limit load in {count} of {ends.size} cases: the end of the path" * (count > 0)


def check_pictures(plan: Plan, quantities: Sequence[str], over: Sequence[str] = ()) -> None:
    """Refuse quantities and axes of pictures that study.nc of a plan will not have, before its cases run."""
    if over:
        values = zip(*(case.values for case in plan.cases), strict=True)
        texts = [any(isinstance(split(each)[0], str) for each in own) for own in values]
        _refuse_axes(over, [axis.name for axis, words in zip(plan.axes, texts, strict=True) if not words])
    if quantities:
        of_paths = [f"{name}:{path}" for name in BY_PATH for path in _path_names(plan, plan.cases)]
        for each in quantities:
            _refuse_unknown(each, [*of_paths, *STIFFNESSES, *NUMBERS])


def _refuse_unknown(quantity: str, known: Sequence[str]) -> None:
    if quantity not in known:
        text = f"no quantity '{quantity}'{suggestion(quantity, known)}; there are: {', '.join(known)}"
        raise refused("--picture", text)


def _refuse_axes(chosen: Sequence[str], axes: Sequence[str]) -> None:
    if not chosen or len(chosen) > 2 or not set(chosen) <= set(axes):
        raise refused("--over", f"expected one axis or two of: {', '.join(axes) or 'none with numbers'}")


def _bars(data: xr.Dataset, values: xr.DataArray) -> tuple[float, list[tuple[str, float, float]]] | None:
    """Return the answer with all ranges at best, and name, low and high of each; None where no case has all at best."""
    names = str(data.attrs["axes"]).split(", ")
    if "case" not in values.dims:
        return None
    words, answers = np.array([data[name].values for name in names], dtype=str), values.values.reshape(-1)
    answers = np.where(data["status"].values == "complete", answers, np.nan)
    others = words != "best"
    if not set(words.flat) <= {*ESTIMATES} or not (~others).all(axis=0).any():
        return None

    def at(k: int, word: str) -> float:
        own = (words[k] == word) & (others.sum(axis=0) == 1)
        return float(answers[own][0]) if own.any() else np.nan

    rows = [(name, at(k, "low"), at(k, "high")) for k, name in enumerate(names)]
    return float(answers[(~others).all(axis=0)][0]), rows


def _tornado(data: xr.Dataset, label: str, best: float, rows: list[tuple[str, float, float]]) -> Figure:
    """Draw a bar from the answer at low to that at high for each range, the longest on top."""
    from pysprings.results.plots.style import BLUE, GREEN, INK, new_figure, plain

    rows = [
        (f"{name}{' (an end has no answer)' if np.isnan(low + high) else ''}", low, high) for name, low, high in rows
    ]
    rows = sorted(rows, key=lambda row: np.nan_to_num(abs(row[2] - row[1]), nan=np.inf))
    figure = new_figure(7.2, 1.4 + 0.32 * len(rows))
    plot = figure.add_subplot()
    for colour, end in ((BLUE, 1), (GREEN, 2)):
        widths = [row[end] - best for row in rows]  # type: ignore[operator]
        plot.barh([plain(row[0]) for row in rows], widths, left=best, color=colour, label=("low", "high")[end - 1])
    plot.axvline(best, color=INK, linewidth=1.0, label="best")
    plot.set_xlabel(label)
    plot.set_title(str(data.attrs["title"]), fontsize=9)
    figure.legend(loc="outside lower center", ncols=3, fontsize=8)
    return figure


def _on(values: xr.DataArray, chosen: Sequence[str], data: xr.Dataset) -> tuple[xr.DataArray, str]:
    """Return a quantity over the chosen axes, and what the other ones were held at."""
    if "case" in values.dims:
        return values, f"{values.sizes['case']} cases; their other values differ" if len(axis_names(data)) > 2 else ""
    fixed = {str(dim): data.sizes[dim] // 2 for dim in values.dims if dim not in chosen}
    words = [
        f"{dim} = {_text(data[dim].values[k])} {data[dim].attrs.get('units', '')}".rstrip() for dim, k in fixed.items()
    ]
    return values.isel(fixed), ", ".join(words)


def _text(value: Any) -> str:
    return value if isinstance(value, str) else f"{float(value):.4g}"


def _label(axis: xr.DataArray) -> str:
    unit = axis.attrs.get("units", "1")
    return str(axis.name) if unit == "1" else f"{axis.name} [{unit}]"


def _mark_short(plot: Any, short: xr.DataArray, axes: list[xr.DataArray], values: xr.DataArray) -> None:
    """Cross the cases that stopped early: what they show may be less than what is asked for."""
    if short.any():
        *places, marks = (each.values for each in xr.broadcast(*[*axes, values][:2], short))
        plot.plot(*(place[marks] for place in places), "kx", ms=8, label="stopped early")
        plot.legend(fontsize=8)


def _map(figure: Figure, plot: Any, axes: tuple[xr.DataArray, xr.DataArray], values: xr.DataArray, label: str) -> None:
    """Draw a quantity as colour: points of a sample, or fields of a grid with the points that it is known at."""
    x, y = axes
    if "case" in values.dims:
        good = np.isfinite(values.values)
        plot.plot(x.values[~good], y.values[~good], "x", color="0.6", ms=5, label="no result")
        drawn = plot.scatter(x.values[good], y.values[good], c=values.values[good], s=40)
        if not good.all():
            plot.legend(fontsize=8)
    else:
        table = values.transpose(str(y.name), str(x.name)).values
        drawn = plot.pcolormesh(_edges(x), _edges(y), np.ma.masked_invalid(table))
    drawn.set_clim(*_ends_if_alike(values))
    figure.colorbar(drawn, ax=plot, label=label)
    plot.set(ylabel=_label(y), yscale="log" if _by_ratio(y) else "linear")


def _by_ratio(axis: xr.DataArray) -> bool:
    """Return whether an axis is drawn by ratio: its values are positive, over two decades or more."""
    return bool(0.0 < axis.values.min() <= 0.01 * axis.values.max())


def _edges(axis: xr.DataArray) -> Array:
    """Return the ends of cells around the values of an axis, half way to the next."""
    middles = np.log(axis.values) if _by_ratio(axis) else axis.values
    steps = np.diff(middles) if middles.size > 1 else np.ones(1)
    edges = np.append(middles[0] - 0.5 * steps[0], middles + 0.5 * np.append(steps, steps[-1])[: middles.size])
    return np.exp(edges) if _by_ratio(axis) else edges


def _ends_if_alike(values: xr.DataArray) -> tuple[float | None, float | None]:
    """Return ends of a scale for values that differ by rounding alone, which it must not show; else none."""
    low, high = float(values.min()), float(values.max())
    small = 1e-6 * max(abs(low), abs(high))
    return (low - 1e3 * small, high + 1e3 * small) if 0.0 < small >= high - low else (None, None)


FILE = "study.nc"
_STATE_UNITS = {
    "u": "m", "w": "m", "rotation": "rad", "H": "N", "V": "N", "M": "N m", "H_tip": "N", "M_tip": "N m", "V_tip": "N",
    "H_lid": "N", "M_lid": "N m", "V_lid": "N", "p": "N/m", "m": "N m/m", "t": "N/m",
}  # fmt: skip
NUMBERS = {
    "wall_s": ("s", "wall time of the case"),
    "cpu_s": ("s", "CPU time of the case"),
    "peak_memory_bytes": ("byte", "largest memory of the process that ran the case, cases before it included"),
    "unknowns": ("1", "unknowns of its model"),
    "iterations": ("1", "Newton iterations of all paths"),
    "balance_error": ("1", "largest share of the load that the sums of the reactions miss"),
    "extrapolated": ("1", "share of the paths whose reactions are extrapolated from two meshes"),
}
STIFFNESSES = {"K_H": ("u", "u", "N/m"), "K_V": ("w", "w", "N/m"), "K_M": ("rotation", "rotation", "N m/rad"),
               "K_HM": ("u", "rotation", "N/rad")}  # fmt: skip


_SIZES = {"path": 0, "share": len(SHARES), "depth_share": DEPTHS, "dof": len(DOFS), "dof_conjugate": len(DOFS)}
# of dimensions and variables, which no axis may have
NAMES = (
    "case", "case_number", "status", "stiffness_initial", *_SIZES, *STATES, *ENDS, *BY_DEPTH, *BY_PATH, *STIFFNESSES,
    *NUMBERS,
)  # fmt: skip


def write_study(study: Study) -> Path | None:
    """Write study.nc from the folders of the cases, one at a time; None, and no earlier one, where none has springs."""
    usable = [case for case in study.plan.cases if study.states[case.number].status in (DONE, SHORT)]
    paths, target = _path_names(study.plan, usable), study.out / FILE
    if not paths:
        for each in (target, study.out / CSV):
            each.unlink(missing_ok=True)
        return None
    with replacing(target) as temporary:
        _write(study, temporary, paths)
    return target


def _path_names(plan: Plan, cases: Iterable[Case]) -> tuple[str, ...]:
    """Return the names of the paths of cases."""
    scenes = (plan.scene_of(case) for case in cases)
    return tuple(dict.fromkeys(path.name for scene in scenes for path in scene.load_paths))


def _write(study: Study, file: Path, paths: tuple[str, ...]) -> None:
    import netCDF4

    with netCDF4.Dataset(file, "w", format="NETCDF4") as data:
        data.setncatts({
            "Conventions": "CF-1.11", "schema": SCHEMA, "title": study.plan.title, "source": f"pysprings {__version__}",
            "scene_toml": study.plan.scene.text, "axes": ", ".join(axis.name for axis in study.plan.axes),
            "axis_keys": "; ".join(" ".join(axis.keys) for axis in study.plan.axes),
        })  # fmt: skip
        dims = _put_axes(data, study)
        _make_variables(data, dims, paths)
        place = _places(study)
        for case in study.plan.cases:
            at = place(case)
            state = study.states[case.number]
            data["status"][at] = state.status
            data["case_number"][at] = case.number
            if state.status in (DONE, SHORT):
                found = measure(study.folder(case.number), study.plan.scene_of(case), paths)
                if found is not None:
                    _put(data, at, found)


def _put_axes(data: Any, study: Study) -> tuple[str, ...]:
    """Write dimensions and coordinates; return the dimensions of a case."""
    plan = study.plan
    if plan.is_grid:
        for axis in plan.axes:
            data.createDimension(axis.name, len(axis.values))
            _put_values(data, axis, axis.name, axis.values)
        return tuple(axis.name for axis in plan.axes)
    data.createDimension("case", len(plan.cases))
    for k, axis in enumerate(plan.axes):
        _put_values(data, axis, "case", [case.values[k] for case in plan.cases])
    return ("case",)


def _put_values(data: Any, axis: Axis, dim: str, values: Iterable[Any]) -> None:
    """Write the values of an axis: numbers in the unit that they have in common, or texts."""
    pairs = [split(value) for value in values]
    if any(isinstance(number, str) for number, _ in pairs):
        variable = data.createVariable(axis.name, str, (dim,))
        variable[:] = np.array([f"{number} {unit}".strip() for number, unit in pairs], dtype=object)
    else:
        units = {unit for _, unit in pairs}
        own = len(units) == 1  # a column with several units is in SI
        variable = data.createVariable(axis.name, "f8", (dim,))
        variable[:] = [float(number) * (1.0 if own or not unit else unit_of(unit)[0]) for number, unit in pairs]
        variable.units = (units.pop() or "1") if own else _si(pairs[0][1])
    variable.long_name = " ".join(axis.keys)


def _si(unit: str) -> str:
    """Return the SI base units of a unit."""
    names = {"kilogram": "kg", "meter": "m", "second": "s", "radian": "rad"}
    if not unit:
        return "1"
    return " ".join(f"{names.get(name, name)}{'' if power == 1 else f'{power:g}'}" for name, power in unit_of(unit)[1])


def _make_variables(data: Any, dims: tuple[str, ...], paths: tuple[str, ...]) -> None:
    sizes = _SIZES | {"path": len(paths)}
    for name, size in sizes.items():
        data.createDimension(name, size)
    for name, texts in (("path", paths), ("dof", DOFS), ("dof_conjugate", DOFS)):
        data.createVariable(name, str, (name,))[:] = np.array(texts, dtype=object)
    data.createVariable("share", "f8", ("share",))[:] = SHARES
    data.createVariable("depth_share", "f8", ("depth_share",))[:] = (np.arange(DEPTHS) + 0.5) / DEPTHS
    data["share"].setncatts({"units": "1", "long_name": "share of the aim of the path"})
    data["depth_share"].setncatts({"units": "1", "long_name": "depth over skirt length, middle of the slice"})
    data.createVariable("status", str, dims)
    data.createVariable("case_number", "i4", dims, fill_value=0)

    def number(name: str, more: tuple[str, ...], unit: str, text: str = "") -> None:
        whole = (*dims, *more)
        chunks = [1] * len(dims) + [sizes[each] for each in more] if more else None
        variable = data.createVariable(name, "f8" if not more else "f4", whole, zlib=bool(more), chunksizes=chunks,
                                       fill_value=np.nan)  # fmt: skip
        variable.setncatts({"units": unit} | ({"long_name": text} if text else {}))

    for name in (*STATES, *ENDS):
        number(name, ("path", "share"), _STATE_UNITS[name])
    for name in BY_DEPTH:
        number(name, ("path", "depth_share", "share"), _STATE_UNITS[name], "both sides and all components together")
    for name, (unit, _, text) in BY_PATH.items():
        number(name, ("path",), unit, text)
    for name, (_, _, unit) in STIFFNESSES.items():
        number(name, (), unit, "initial stiffness at the lid centre, where water flows that of a sudden load")
    number("stiffness_initial", ("dof", "dof_conjugate"), "1", "mixed units: N/m, N/rad, N m/rad")
    for name, (unit, text) in NUMBERS.items():
        number(name, (), unit, text)


def _places(study: Study) -> Any:
    """Return the function from a case to its index in the arrays."""
    if study.plan.is_grid:
        shape = tuple(len(axis.values) for axis in study.plan.axes)
        return lambda case: tuple(int(k) for k in np.unravel_index(case.number - 1, shape))
    order = {case.number: k for k, case in enumerate(study.plan.cases)}
    return lambda case: (order[case.number],)


def _put(data: Any, at: tuple[int, ...], found: Measured) -> None:
    for name, values in (*found.along.items(), *found.by_depth.items(), *found.by_path.items()):
        data[name][at] = values
    data["stiffness_initial"][at] = found.stiffness
    for name, (row, column, _) in STIFFNESSES.items():
        data[name][at] = found.stiffness[DOFS.index(row), DOFS.index(column)]
    for name, value in found.numbers.items():
        data[name][at] = value


def open_study(path: str | os.PathLike[str]) -> xr.Dataset:
    """Open study.nc, or that of a folder, without reading its arrays; close it after use."""
    file = Path(path) / FILE if Path(path).is_dir() else Path(path)
    if not file.exists():
        raise refused(None, "no such file; `pysprings sweep` writes it", file)
    data = xr.open_dataset(file, engine="netcdf4", decode_times=False, decode_timedelta=False)
    if data.attrs.get("schema") != SCHEMA:
        data.close()
        raise refused(None, f"is no {FILE} of a study ({SCHEMA})", file)
    return data.set_coords(str(data.attrs["axes"]).split(", "))


def scalars(data: xr.Dataset) -> Mapping[str, xr.DataArray]:
    """Return the quantities of a study with one number a case: by name, or name:path."""
    dims = set(data["case_number"].dims)
    found: dict[str, xr.DataArray] = {}
    for name, variable in data.data_vars.items():
        if variable.dtype.kind != "f" or name == "case_number":
            continue
        if set(variable.dims) == dims:
            found[str(name)] = variable
        elif set(variable.dims) == dims | {"path"}:
            found |= {f"{name}:{path}": variable.sel(path=path) for path in data["path"].values}
    return found


CSV, SUFFIXES = "study.csv", (".csv", ".xlsx")


def table_of(data: xr.Dataset) -> pd.DataFrame:
    """Return a row a case: number, axes, status and quantities of one number, with units in the headings."""
    number = data["case_number"]
    columns = {name: data[name] for name in (*str(data.attrs["axes"]).split(", "), "status")} | dict(scalars(data))
    table: dict[str, Any] = {"id": number.values.reshape(-1).astype(int)}
    for name, each in columns.items():
        unit = str(each.attrs.get("units", ""))
        values = each.broadcast_like(number).transpose(*number.dims).values.reshape(-1)
        table[name if unit in ("", "1") else f"{name} [{unit}]"] = values
    return pd.DataFrame(table).replace([np.inf, -np.inf], np.nan)


def suffix_of(file: Path) -> str:
    """Return the suffix of a table. Raises UserInputError for one that `write_table` does not write."""
    if file.suffix not in SUFFIXES:
        raise refused("--table", f"ends in {' or '.join(SUFFIXES)}", file)
    return file.suffix


def write_table(data: xr.Dataset, file: Path) -> Path:
    """Write the table of a study as .csv or .xlsx, whole or not at all."""
    suffix, table = suffix_of(file), table_of(data)
    if suffix == ".csv":
        return write_frame(table, file)
    return write_sheet(
        file, [str(name) for name in table], ((row, False) for row in table.itertuples(index=False, name=None)), {}
    )
