# SPDX-License-Identifier: MIT
"""Tables of the solution, and for what its numbers hold: balances, calibrated ranges, measured and estimated errors."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pysprings.core.columns import Column, Table, filled
from pysprings.core.loads import same_loads
from pysprings.core.path_kinds import height_of_load
from pysprings.core.text import number, with_prefix
from pysprings.core.words import SOLVED, TILTS
from pysprings.full_model.accuracy.two_mesh import HALVED, LEAST_HALVED, LEFT, head
from pysprings.full_model.run_record import PathFigures, RunRecord
from pysprings.macro.comparison_text import COLUMNS, SPACE_NOTE
from pysprings.results.parts import openings
from pysprings.springs.path import RecordedPath, paths_of
from pysprings.springs.path_ends import before_cavitation, end_of
from pysprings.springs.sums import balance


def equilibrium_table(tree: xr.DataTree) -> Table:
    """Return the table of the equilibrium check over the converged steps of a result or of springs.

    Missing: the sum of the soil reactions less the applied load (`pysprings.springs.sums.balance`).
    """
    rows = []
    for name, recorded in paths_of(tree).items():
        path = recorded.dataset
        for load, missing in balance(path).items() if path.sizes["step"] else ():
            largest = with_prefix(float(np.abs(path[load]).max()), "N m" if load == "M" else "N")
            rows.append((name, load, largest, f"{missing:.1e}"))
    note = (
        "H = sum p dz + H_tip + H_lid; V = sum t dz + V_tip + V_lid; "
        "M = -(sum p z dz + L H_tip) + sum m dz + M_tip + M_lid. Missing: reactions less load, over the largest part."
    )
    return Table("Equilibrium check", ("path", "load", "largest load", "missing (relative)"), rows, note)


def water_table(figures: Mapping[str, PathFigures]) -> Table | None:
    """Return the table of the balance of the water at the end of each path; None for a drained run."""
    rows = [{"path": name, **path.water} for name, path in figures.items() if path.water]
    note = (
        "Since the initial state, whole caisson: expelled = compressed + in gaps + outflow. Expelled is the pore "
        "volume that the soil has lost, from the displacements of its boundary; the outflow is Darcy flow over the "
        "drained boundary. The largest imbalance of all steps is shown. Pressure: the range of the excess on the path."
    )
    return Table.of(_WATER, rows, "Balance of the water", note, wide=True) if rows else None


def energy_table(figures: Mapping[str, PathFigures]) -> Table | None:
    """Return the table of the balance of energy at the end of each path; None where it was not computed."""
    rows = [{"path": name, **path.energy} for name, path in figures.items() if path.energy]
    note = (
        "Since the initial state, whole caisson: work + initial = elastic + plastic + penalty + friction + water. "
        "Initial is the work of weight, surcharge and initial contact pressure, penalty what contact springs store, "
        "water what is done against pore pressures. The imbalance is the residual of Newton, over the largest term."
    )
    return Table.of(_ENERGY, rows, "Balance of energy", note, wide=True) if rows else None


_PATH = Column("path", "path", words=True)
_WATER = (
    _PATH,
    Column("expelled [m\u00b3]", "expelled_m3"),
    Column("compressed [m\u00b3]", "compressed_m3"),
    Column("in gaps [m\u00b3]", "film_m3"),
    Column("outflow [m\u00b3]", "outflow_m3"),
    Column("imbalance / exchanged", "worst_imbalance_over_exchanged", ".1e"),
    Column("pressure [kPa]", lambda row: f"{row['pressure_min_Pa'] / 1e3:.3g} to {row['pressure_max_Pa'] / 1e3:.3g}"),
)
_TERMS = ("work", "initial", "elastic", "plastic", "penalty", "friction", "water")
_ENERGY = (
    _PATH,
    *(Column(f"{term} [kJ]", f"{term}_J", factor=1e-3) for term in _TERMS),
    Column("imbalance / largest", "imbalance_over_largest_term", ".1e"),
)


def cost_tables(run: RunRecord | None) -> list[Table]:
    """Return the tables of the cost of a run: seconds by phase, then totals; none without a record."""
    if run is None:
        return []
    tables, solver = [phase_table(run)] if run.phases else [], run.solver
    figures: dict[str, float | None] = {
        "wall time [s]": run.wall_s,
        "processor time [s]": run.cpu_s,
        "peak memory [MB]": run.peak_memory_bytes * 1e-6,
        "factorisations": solver.factorisations,
        "solves": solver.solves,
        "worst residual of a linear solve": solver.worst_linear_residual,
        "Newton tolerance (relative residual)": solver.tolerance,
    }
    totals = [(words, number(value)) for words, value in figures.items() if value is not None]
    totals += [("python", run.python), ("platform", run.platform), *run.environment.items()]
    tables.append(Table("Totals", ("", ""), totals, head=False))
    return tables


_PHASES = (
    Column("phase", "phase", words=True), Column("wall [s]", "wall_s", ".2f"),
    Column("processor [s]", "cpu_s", ".2f"), Column("calls", "calls"),
)  # fmt: skip


def phase_table(run: RunRecord) -> Table:
    """Return the table of wall and processor seconds by phase, and in all."""
    rows: list[dict[str, Any]] = [{"phase": name, **spent} for name, spent in run.phases.items()]
    rows.append({"phase": "total", "wall_s": run.wall_s or None, "cpu_s": run.cpu_s or None})  # 0: not recorded
    return Table.of(filled(_PHASES, rows), rows, "Cost by phase")


def validity(result: xr.DataTree) -> list[str]:
    """Return sentences on the range of the numbers: calibrated paths, displacements, effects that are not included."""
    behaviour = result.attrs.get("caisson_behaviour", "rigid")
    return [
        *(
            _range_sentence(path, str(result.attrs.get("drainage", ""))) + _end_sentence(path.name, path.known)
            for path in paths_of(result).values()
        ),
        "Springs from one path hold on paths with nearly the same ratio of rotation to displacement. "
        "p(z)/y(z) is not a property of the soil: check other load heights against the full model.",
        "Monotonic loading, but for springs with memory; small displacements; the caisson is "
        f"{behaviour} and wished in place, without installation effects.",
        "The soil domain is finite and stiffens the answer; the summary and `pysprings check` bound its effect on the "
        "elastic stiffness.",
        "Beyond the displacements of the calibration paths `predict` refuses an answer unless `--extrapolate` asks for "
        "one.",
    ]


def _end_sentence(name: str, path: xr.Dataset) -> str:
    """Return a sentence on a path that did not come to its aim; empty for others."""
    end = end_of(name, path)
    return f" It {end.words}." if end.failed else ""


def _range_sentence(path: RecordedPath, drainage: str) -> str:
    own, length = path.known, float(path.recorded["depth_bounds"].values[-1, 1])
    good = own["converged"].values.astype(bool)
    text = f"Path {path.name} ({path.attrs.get('kind', '')}, {path.attrs.get('role', '')}): "
    if not good.any():
        return text + "no converged step."
    if path.is_vertical:
        w, V = own["w"].values[good] * 1e3, own["V"].values[good]
        ends = " to ".join(with_prefix(float(each), "N") for each in V[[0, -1]])
        return f"{text}w from {w[0]:.3g} to {w[-1]:.3g} mm, V from {ends}."
    moved = np.stack([own["u"].values, length * own["rotation"].values])[:, good]
    u, turn = np.where(
        np.abs(moved) > 1e-9 * np.abs(moved).max(), moved, 0.0
    )  # what is imposed as 0 is met to rounding
    text += f"{path.under(drainage)}, u from {u.min() * 1e3:.3g} to {u.max() * 1e3:.3g} mm, "
    text += f"rotation from {turn.min() / length * 1e3:.3g} to {turn.max() / length * 1e3:.3g} mrad"
    if u[-1]:
        text += f", rotation·L/u = {turn[-1] / u[-1]:.2f} at its end"
    return text + "."


_COMPARED = (
    "path", "role", "springs", "springs_from", "eta_small", "eta_large", "H_error_max_pct", "rotation_error_max_pct",
    "M_error_max_pct", "V_error_max_pct", "u_error_max_pct", "u_error_half_pct", "p_error_max_pct", "T_error_max_pct",
    "rotation_point_error_max_m", "H_error_between_pct",
    "rotation_error_between_pct", "M_error_between_pct", "extrapolated_states", "off_path_states", "off_load_states",
)  # fmt: skip


def compare_table(compare: pd.DataFrame | None) -> Table | None:
    """Return the table macro-model against full model, without the columns that hold no number; None without rows."""
    if compare is None or compare.empty:
        return None
    best = "fan" if (compare["springs"] == "fan").any() else None
    kept = compare if best is None else compare[compare["springs"].isin([best, "vertical", "memory"])]
    rows = kept.to_dict("records")
    columns = filled((COLUMNS[name] for name in _COMPARED), rows)
    note = (
        "max: largest error, macro-model over full model minus 1, at equal displacement; u: displacement "
        "at equal load, half: up to half of the largest load of the path; z_rot: depth of the point of rotation. "
        "between: the same when every second recorded state is left out of the springs. eta = 1 - area between the "
        "load-displacement curves over the area under the full model's, to a small displacement and to the "
        "end. extrapolated, off path, other V: states that the springs do not cover. py: lateral p-y springs alone; "
        "full: with distributed moment, tip and lid terms; fan: all of them by displacement and rotation, from all "
        "calibration paths of constant ratio. Of a fan its rows alone are shown; compare.csv has those of every set."
    )
    note += f" {SPACE_NOTE}." if "T_error_max_pct" in compare else ""
    ended = [
        f" {row['path']}, {row['springs']}: {row['status']}."
        for row in compare.to_dict("records")
        if row.get("status", "complete") != "complete"
    ]
    return Table.of(columns, rows, note=note + "".join(ended), wide=True)


def estimate_table(run: RunRecord | None) -> Table | None:
    """Return the table of the estimated discretisation error; None where no estimate was requested."""
    estimate = None if run is None else run.error_estimate
    if not estimate:
        return None
    if not estimate["estimate_pct"]:
        return Table("Discretisation error", ("",), [(f"no estimate: {estimate['why_not']}",)])
    words = {
        "load_max": "load, largest difference / largest load",
        "py_rms": "p(y), root mean square / largest p",
        "rotation_max": "rotation, largest difference / largest rotation",
        "vertical_max": "V of vertical paths, largest difference / largest change",
        "stiffness": "initial stiffness",
    }
    rows = [
        (words[name], number(estimate["difference_pct"][name], 3), number(estimate["order"][name], 3), number(value, 2))
        for name, value in estimate["estimate_pct"].items()
    ]
    note = (
        f"From the same scene on a coarser mesh ({estimate['unknowns'][1]} beside {estimate['unknowns'][0]} unknowns, "
        f"ratio of cell sizes r = {estimate['cell_ratio']:.3g}): "
    )
    factor = f"safety factor {estimate['safety']:g} times difference / (r^order - 1)"
    if (how := estimate.get("extrapolated") or {}).get("paths"):
        left = ", ".join(f"{share:g} ({head(name)})" for name, share in how["left"].items())
        note += "extrapolated by difference / (r^order - 1), which leaves these shares of the difference: "
        note += f"{left}; else {factor}."
        if names := ", ".join(how.get("halved", ())):
            note += (
                f" V of {names} is {HALVED:g} of what halved elements at the tip change, {LEAST_HALVED:g} % at least."
            )
        other = " Other" * bool(names)
        note += "".join(f"{other} {head(name)} is {size:g} % at least." for name, size in how.get("least", {}).items())
    else:
        note += f"{factor}."
    if series := estimate.get("harmonics"):
        shares = ", ".join(f"{words[name]} {number(value, 2)} %" for name, value in estimate["harmonics_pct"].items())
        part = f", of paths that have it in their reactions {LEFT:g} of it" if how.get("harmonics_added") else ""
        note += f" The difference of {series[0]} and {series[1]} harmonics there is added{part}: {shares}."
    return Table("Discretisation error", ("", "difference [%]", "order", "estimate [%]"), rows, note)


_CONVERGENCE = (
    _PATH,
    Column("status", "status", words=True),
    Column("increments", "increments"),
    Column("iterations", "iterations"),
    Column("median", "median_iterations"),
    Column("most", "max_iterations"),
    Column("cut-backs", "cut_backs"),
    Column("worst residual", "worst_residual"),
    Column("last ratio", "last_residual_ratio"),
    Column("order", "order_of_last_iterations"),
)


def convergence_table(figures: Mapping[str, PathFigures]) -> Table | None:
    """Return the table of increments, iterations and cut-backs by path; None without a record."""
    rows = [{"path": name, **asdict(path)} for name, path in figures.items()]
    note = (
        "Residual: out-of-balance forces over contact forces, by norm; the worst that was accepted. Iterations: of "
        "accepted increments; median, most: per increment; last ratio: residual of the last iteration over the one "
        "before; order: of the last three residuals (2 is quadratic); both are medians over increments."
    )
    return Table.of(_CONVERGENCE, rows, "Convergence", note, wide=True) if rows else None


_CUT_BACKS = (
    _PATH,
    Column("at", lambda row: f"{100 * row['load_fraction']:.4g} % of the {row['stage']}", words=True),
    Column("iterations", "iterations"),
    Column("reason", "reason", words=True),
    Column("largest residual at", lambda row: row["place"] or "-", words=True),
    Column("last residuals", lambda row: row["last_residuals"] or None, 2),
)


def cut_back_table(figures: Mapping[str, PathFigures]) -> Table | None:
    """List the attempts that were given up: path, place in the load and in the model, reason; None without any."""
    rows = [{"path": name, **asdict(each)} for name, path in figures.items() for each in path.cut_backs_at]
    note = "The load step was halved after each of these attempts and taken again."
    return Table.of(_CUT_BACKS, rows, "Attempts given up (cut-backs)", note, wide=True) if rows else None


def _with_place(rings: Mapping[str, Any], name: str) -> str:
    if name not in rings:
        return "not measured: interface fields were not kept"
    place = rings[f"{name}_at"]
    return number(rings[name], 3) + (f" ({place})" if place else "")


_RINGS = (
    _PATH,
    Column("alternation", lambda row: _with_place(row, "alternation"), words=True),
    Column("largest second difference", lambda row: _with_place(row, "second_difference"), words=True),
    Column("open stations between two loaded ones", "isolated_open"),
    Column("of stations", "stations"),
)


def ring_table(figures: Mapping[str, PathFigures]) -> Table | None:
    """State, path by path, whether contact pressure and opening alternate around the rings of the skirt.

    Paths off a plane are left out; None without others.
    """
    rows = [{"path": name} | (path.contact_rings or {}) for name, path in figures.items() if "u_x" not in path.end]
    note = (
        "Normal effective stress at neighbouring stations of a ring (one side, one depth), over the ring's mean "
        "(now or at the start, the larger); largest over all steps. Second difference: p(i-1) - 2 p(i) + p(i+1); "
        "it also sees real curvature and the edge of an open zone. Alternation: the smallest of three that "
        "follow each other with signs in turn; a swing of s from point to point gives 4 s."
    )
    return Table.of(_RINGS, rows, "Contact from station to station", note) if rows else None


def end_table(paths: Mapping[str, xr.Dataset]) -> Table | None:
    """List loads and motion at the last converged step of every path, and how it ended; None without paths."""
    rows = []
    for name, path in paths.items():
        good = np.flatnonzero(path["converged"].values.astype(bool))
        last = int(good[-1]) if good.size else 0
        values = [_clean(path, key, last, factor) for key, factor in _END]
        cavitates = before_cavitation(path).sizes["step"] < path.sizes["step"]
        status = str(path.attrs.get("status", "")) + ", beyond cavitation" * cavitates
        rows.append((name, str(path.attrs.get("kind", "")), status, *values))
    heads = ("path", "kind", "status", "u [mm]", "w [mm]", "rotation [mrad]", "H [kN]", "V [kN]", "M [kN m]",
             "H tip [kN]", "H lid [kN]")  # fmt: skip
    note = "w and V are positive down; M is about the lid centre. Every step is in load_displacement.csv."
    return Table("At the last converged step", heads, rows, note, wide=True) if rows else None


_END = (
    ("u", 1e3), ("w", 1e3), ("rotation", 1e3), ("H", 1e-3), ("V", 1e-3), ("M", 1e-3), ("H_tip", 1e-3), ("H_lid", 1e-3),
)  # fmt: skip


def _clean(path: Any, key: str, step: int, factor: float) -> str:
    """Write a value of a step; what the solver leaves of 0 beside the largest load or motion of the path is 0."""
    if key not in path:
        return "-"
    alike = [name for name in ("H", "V", "M") if name in path] if key[0] in "HVM" else ["u", "w", "rotation"]
    largest = max(float(np.abs(path[name].values).max(initial=0.0)) for name in alike if name in path)
    value = float(path[key][step])
    least = (SOLVED if key[0] in "HVM" else 1e-9) * largest
    return number(0.0 if abs(value) < least else value * factor, 4)


def tilt_table(paths: Mapping[str, xr.Dataset]) -> Table | None:
    """List H and M at limits of tilt on each path with a free head; None without such a path."""
    rows = []
    for name, path in ((name, before_cavitation(path)) for name, path in paths.items()):
        if (height := height_of_load(path.attrs)) is None:
            continue
        good = path["converged"].values.astype(bool)
        turn = np.degrees(np.abs(path["rotation"].values[good]))
        cells = [text for limit in TILTS for text in _at_tilt(limit, turn, path, good)]
        most = f"{turn.max(initial=0.0):.3g}"
        V = path["V"].values[good]
        words = name if same_loads(V, V[:1].sum()).all() else f"{name} (V changes)"
        rows.append((words, number(height), most, *cells))
    units = {"H": "kN", "M": "kN m"}
    loads = [f"{load} at {limit:g} deg [{unit}]" for limit in TILTS for load, unit in units.items()]
    heads = ("path", "height of the load [m]", "largest tilt [deg]", *loads)
    note = (
        "Full model before cavitation, between its steps linear. '-': not reached, or the path does not tilt steadily."
    )
    return Table("Loads at limits of tilt", heads, rows, note, wide=True) if rows else None


def _at_tilt(limit: float, turn: np.ndarray, path: Any, good: np.ndarray) -> tuple[str, str]:
    if turn.size < 2 or turn.max() < limit or not (np.diff(turn) > 0.0).all():
        return "-", "-"
    loads = (np.interp(limit, turn, np.abs(path[name].values[good])) for name in ("H", "M"))
    H, M = (number(1e-3 * float(load), 4) for load in loads)
    return H, M


def opening_table(paths: Mapping[str, xr.Dataset]) -> Table | None:
    """List the widest gap at the last converged step of each path; None where interface fields were not kept."""
    rows = []
    for name, path in paths.items():
        good = np.flatnonzero(path["converged"].values.astype(bool))
        if "gap" in path and good.size:
            widest = max(openings(path, int(good[-1])), key=lambda each: each.width)
            gap = f"{widest.width * 1e3:.3g} mm at {widest.place}"
            rows.append((name, widest.surface, gap) if widest.width > 0 else (name, "-", "closed"))
    return Table("Widest gap at the last converged step", ("path", "surface", "gap"), rows) if rows else None
