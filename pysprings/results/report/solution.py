# SPDX-License-Identifier: MIT
"""Tables of the solution: convergence by path, given-up attempts, contact, states at the end."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
import xarray as xr

from pysprings.core.columns import Column, Table
from pysprings.core.path_kinds import PATH_KINDS
from pysprings.core.text import number
from pysprings.core.words import TILTS
from pysprings.full_model.run_record import PathFigures
from pysprings.results.parts import openings
from pysprings.results.report.inputs import ReportTable

_PATH = Column("path", "path", words=True)
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
        status = str(path.attrs.get("status", ""))
        rows.append((name, str(path.attrs.get("kind", "")), status, *values))
    heads = ("path", "kind", "status", "u [mm]", "w [mm]", "rotation [mrad]", "H [kN]", "V [kN]", "M [kN m]",
             "H tip [kN]", "H lid [kN]")  # fmt: skip
    note = "w and V are positive down; M is about the lid centre. Every step is in load_displacement.csv."
    return Table("At the last converged step", heads, rows, note, wide=True) if rows else None


_END = (
    ("u", 1e3), ("w", 1e3), ("rotation", 1e3), ("H", 1e-3), ("V", 1e-3), ("M", 1e-3), ("H_tip", 1e-3), ("H_lid", 1e-3),
)  # fmt: skip


def _clean(path: Any, key: str, step: int, factor: float) -> str:
    """Write a value of a step; a rounding error beside the largest load or motion of the path is 0."""
    if key not in path:
        return "-"
    alike = [name for name in ("H", "V", "M") if name in path] if key[0] in "HVM" else ["u", "w", "rotation"]
    largest = max(float(np.abs(path[name].values).max(initial=0.0)) for name in alike if name in path)
    value = float(path[key][step])
    return number(0.0 if abs(value) < 1e-9 * largest else value * factor, 4)


def tilt_table(paths: Mapping[str, xr.Dataset]) -> Table | None:
    """List H and M at limits of tilt on each path with a free head; None without such a path."""
    rows = []
    for name, path in paths.items():
        kind = PATH_KINDS.get(str(path.attrs.get("kind")))
        if kind is None or not kind.free_head or "arm_from_m" in path.attrs:
            continue
        good = path["converged"].values.astype(bool)
        turn = np.degrees(np.abs(path["rotation"].values[good]))
        cells = [text for limit in TILTS for text in _at_tilt(limit, turn, path, good)]
        most = f"{turn.max(initial=0.0):.3g}"
        rows.append((name, number(float(path.attrs.get("arm_m", 0.0))), most, *cells))
    units = {"H": "kN", "M": "kN m"}
    loads = [f"{load} at {limit:g} deg [{unit}]" for limit in TILTS for load, unit in units.items()]
    heads = ("path", "height of the load [m]", "largest tilt [deg]", *loads)
    note = "Full model, between its steps linear. '-': the path does not reach this tilt, or does not tilt steadily."
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
            rows.append((name, widest.surface, _opening(widest)) if widest.width > 0 else (name, "-", "closed"))
    return Table("Widest gap at the last converged step", ("path", "surface", "gap"), rows) if rows else None


def _opening(opening: Any) -> str:
    return f"{opening.width * 1e3:.3g} mm at {opening.place}"


CONVERGENCE = ReportTable("convergence", "checks", lambda data: [convergence_table(data.figures)])
CUT_BACKS = ReportTable("cut-backs", "checks", lambda data: [cut_back_table(data.figures)])
RINGS = ReportTable("rings", "checks", lambda data: [ring_table(data.figures)])
END = ReportTable("end", "capacity", lambda data: [end_table(data.paths)])
TILT = ReportTable("tilt", "tilt", lambda data: [tilt_table(data.paths)])
GAPS = ReportTable("gaps", "checks", lambda data: [opening_table(data.paths)])
