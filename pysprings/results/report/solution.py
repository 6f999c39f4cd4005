# SPDX-License-Identifier: MIT
"""Tables of the solution: convergence by path, given-up attempts, contact, states at the end."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from pysprings.core.text import number
from pysprings.full_model.ring_measure import contact_alternation
from pysprings.results.analysis.newton import attempts, failed_steps
from pysprings.results.report.table import ReportTable, Table

if TYPE_CHECKING:
    from pysprings.full_model.run_record import PathFigures


def convergence_table(paths: Mapping[str, Any], figures: Mapping[str, PathFigures] = MappingProxyType({})) -> Table:
    """Count increments, iterations and cut-backs by path, with the worst residual that was accepted."""
    rows = [(name, *_convergence_row(path, figures.get(name))) for name, path in paths.items()]
    columns = (
        "path",
        "increments",
        "iterations, median",
        "most",
        "total",
        "attempts given up (cut-backs)",
        "at [% of the path]",
        "worst accepted residual",
        "order of the last iterations",
    )
    note = (
        "Residual: out-of-balance forces over contact forces, by norm. Total: given-up attempts too. "
        "Order 2 is quadratic convergence."
    )
    return Table("Convergence", columns, rows, note, wide=True)


def _convergence_row(path: Any, summary: PathFigures | None) -> list[str]:
    if "convergence" not in path.children or not path["convergence"].sizes.get("iteration", 0):
        return ["not recorded"] * 8

    record = path["convergence"].to_dataset(inherit=False)
    tries = attempts(record, failed_steps(path.to_dataset(), record))
    accepted = [each for each in tries if each.accepted]
    lost = [each for each in tries if not each.accepted]
    counts = [each.iterations for each in accepted] or [0]
    residual, fraction = record["residual"].values, record["load_fraction"].values
    worst = max((float(residual[each.rows[-1]]) for each in accepted), default=float("nan"))
    return [
        number(len(accepted)),
        number(float(np.median(counts))),
        number(max(counts)),
        number(sum(each.iterations for each in tries)),
        number(len(lost)),
        ", ".join(f"{100 * float(fraction[each.rows[-1]]):.3g}" for each in lost) or "-",
        number(worst, 2),
        number((summary and summary.order_of_last_iterations) or "-", 3),
    ]


def _at(place: str) -> str:
    return f" ({place})" if place else ""


def cut_back_table(figures: Mapping[str, PathFigures]) -> Table | None:
    """List the attempts that were given up: path, place in the load and in the model, reason; None without any."""
    rows = [
        (
            name, f"{100 * each.load_fraction:.4g} % of the {each.stage}", number(each.iterations),
            each.reason, each.place or "-",
            ", ".join(number(value, 2) for value in each.last_residuals) or "-",
        )
        for name, path in figures.items()
        for each in path.cut_backs_at
    ]  # fmt: skip
    columns = ("path", "at", "iterations", "reason", "largest residual at", "last residuals")
    note = "The load step was halved after each of these attempts and taken again."
    return Table("Attempts given up (cut-backs)", columns, rows, note, wide=True) if rows else None


def ring_table(paths: Mapping[str, Any]) -> Table:
    """State, path by path, whether contact pressure and opening alternate around the rings of the skirt."""
    rows = []
    for name, path in paths.items():
        alternation = contact_alternation(path.to_dataset())
        if alternation is None:
            rows.append((name, *["not measured: interface fields were not kept"] * 3))
            continue
        rows.append(
            (
                name,
                number(alternation["alternation"], 3) + _at(alternation["alternation_at"]),
                number(alternation["second_difference"], 3) + _at(alternation["second_difference_at"]),
                f"{alternation['isolated_open']} of {alternation['stations']} stations",
            )
        )
    columns = ("path", "alternation", "largest second difference", "open stations between two loaded ones")
    note = (
        "Normal effective stress at neighbouring stations of a ring (one side, one depth), over the ring's mean "
        "(now or at the start, the larger); largest over all steps. Second difference: p(i-1) - 2 p(i) + p(i+1); "
        "it also sees real curvature and the edge of an open zone. Alternation: the smallest of three that "
        "follow each other with signs in turn; a swing of s from point to point gives 4 s."
    )
    return Table("Contact from station to station", columns, rows, note)


def end_table(path: Any) -> Table:
    """List loads and motion at the last converged step of a path, in mm, mrad, kN and kN m."""
    good = np.flatnonzero(path["converged"].values.astype(bool))
    last = int(good[-1]) if good.size else 0
    rows = [
        ("step", number(last)),
        *(
            (text, f"{float(path[name][last]) * factor + 0.0:.4g} {unit}")
            for name, text, factor, unit in _END
            if name in path
        ),
    ]
    if "gap" in path:
        from pysprings.results.analysis.gap import openings

        rows += [("widest gap, " + each.surface, _opening(each)) for each in openings(path.to_dataset(), last)]
    return Table("At the last converged step", ("", ""), rows, head=False)


_END = (
    ("u", "lateral displacement of the lid centre, u", 1e3, "mm"),
    ("w", "vertical displacement of the lid centre, w (down +)", 1e3, "mm"),
    ("rotation", "rotation", 1e3, "mrad"),
    ("H", "horizontal load, H", 1e-3, "kN"),
    ("V", "vertical load, V (down +)", 1e-3, "kN"),
    ("M", "moment about the lid centre, M", 1e-3, "kN m"),
    ("H_outer", "H carried by the outside of the skirt", 1e-3, "kN"),
    ("H_inner", "H carried by the inside of the skirt", 1e-3, "kN"),
    ("H_lid", "H carried by the lid", 1e-3, "kN"),
    ("H_tip", "H carried by the tip", 1e-3, "kN"),
    ("F_in", "change of vertical shear force inside, F_in (on the soil, down +)", 1e-3, "kN"),
    ("F_out", "change of vertical shear force outside, F_out (on the soil, down +)", 1e-3, "kN"),
    ("F_pw", "change of water force under the lid, F_pw", 1e-3, "kN"),
)


def _opening(opening: Any) -> str:
    return f"{opening.width * 1e3:.3g} mm at {opening.place}" if opening.width > 0 else "closed"


CONVERGENCE = ReportTable("convergence", "checks", lambda data: [convergence_table(data.paths, data.figures)])
CUT_BACKS = ReportTable("cut-backs", "checks", lambda data: [cut_back_table(data.figures)])
RINGS = ReportTable("rings", "checks", lambda data: [ring_table(data.paths)])
END = ReportTable("end", "path", lambda data: [end_table(data.paths[data.path])])
