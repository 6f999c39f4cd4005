# SPDX-License-Identifier: MIT
"""The tables and sentences of the report: inputs, checks, ends of paths, comparison, limits, cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from pysprings.core.text import number
from pysprings.full_model.ring_measure import contact_alternation

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


@dataclass(frozen=True)
class Table:
    """A table of the report: heading, columns with units, rows of text, a remark."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""


def input_tables(scene_toml: str) -> list[Table]:
    """Make one table per section of the scene: key, value with its unit, defaults included."""
    import tomllib

    try:
        scene = tomllib.loads(_with_defaults(scene_toml))
    except tomllib.TOMLDecodeError:
        return []
    plain = {key: value for key, value in scene.items() if not isinstance(value, (dict, list))}
    tables = [_key_table("scene", plain)] if plain else []
    for key, value in scene.items():
        if isinstance(value, dict):
            tables.append(_key_table(key, value))
        elif isinstance(value, list):
            tables += [_key_table(f"{key} {k}", item) for k, item in enumerate(value, 1) if isinstance(item, dict)]
    return tables


def _with_defaults(scene_toml: str) -> str:
    """Return the scene with every default written out; as it is where this version does not take it."""
    from pysprings.core.errors import UserInputError
    from pysprings.scene.load import parse_scene

    try:
        return parse_scene(scene_toml).to_toml() if scene_toml else ""
    except UserInputError:
        return scene_toml


def _key_table(title: str, values: Mapping[str, Any]) -> Table:
    return Table(title, ("key", "value"), [(key, number(value, 6)) for key, value in values.items()])


def mesh_table(attrs: Mapping[Any, Any], run: Mapping[str, Any] | None = None) -> Table:
    """Make the table of mesh counts, quality and solver from the attrs of a result and its run.json."""
    names = {
        "mesh_preset": "preset",
        "n_nodes": "nodes",
        "n_elements": "eight-node elements",
        "n_unknowns": "unknowns",
        "interface_stations": "interface stations",
        "min_scaled_jacobian": "smallest scaled Jacobian",
        "max_aspect": "largest aspect ratio",
        "solver": "linear solver",
    }
    known = {**dict((run or {}).get("mesh") or {}), **attrs}
    return Table("", ("", ""), [(text, number(known[key])) for key, text in names.items() if key in known])


def convergence_table(paths: Mapping[str, Any], run: Mapping[str, Any] | None = None) -> Table:
    """Count increments, iterations and cut-backs by path, with the worst residual that was accepted."""
    summaries = (run or {}).get("paths") or {}
    rows = [(name, *_convergence_row(path, summaries.get(name) or {})) for name, path in paths.items()]
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
    return Table("Convergence", columns, rows, note)


def _convergence_row(path: Any, summary: Mapping[str, Any]) -> list[str]:
    if "convergence" not in path.children or not path["convergence"].sizes.get("iteration", 0):
        return ["not recorded"] * 8
    from pysprings.results.analysis.newton import attempts, failed_steps

    record = path["convergence"].to_dataset(inherit=False)
    tries = attempts(record, failed_steps(path.to_dataset(), record))
    kept = [each for each in tries if each.accepted]
    lost = [each for each in tries if not each.accepted]
    counts = [each.iterations for each in kept] or [0]
    residual, fraction = record["residual"].values, record["load_fraction"].values
    worst = max((float(residual[each.rows[-1]]) for each in kept), default=float("nan"))
    return [
        number(len(kept)),
        number(float(np.median(counts))),
        number(max(counts)),
        number(sum(each.iterations for each in tries)),
        number(len(lost)),
        ", ".join(f"{100 * float(fraction[each.rows[-1]]):.3g}" for each in lost) or "-",
        number(worst, 2),
        number(summary.get("order_of_last_iterations") or "-", 3),
    ]


def _at(place: str) -> str:
    return f" ({place})" if place else ""


def cut_back_table(run: Mapping[str, Any]) -> Table | None:
    """List the attempts that were given up: path, place in the load and in the model, reason; None without any."""
    rows = [
        (
            str(name), f"{100 * each['load_fraction']:.4g} % of the {each['stage']}", number(each["iterations"]),
            str(each["reason"]), str(each["place"]) or "-",
            ", ".join(number(value, 2) for value in each["last_residuals"]) or "-",
        )
        for name, path in dict(run.get("paths") or {}).items()
        for each in path.get("cut_backs_at", ())
    ]  # fmt: skip
    columns = ("path", "at", "iterations", "reason", "largest residual at", "last residuals")
    note = "The load step was halved after each of these attempts and taken again."
    return Table("Attempts given up (cut-backs)", columns, rows, note) if rows else None


def ring_table(paths: Mapping[str, Any]) -> Table:
    """State, path by path, whether contact pressure and opening alternate around the rings of the skirt."""
    rows = []
    for name, path in paths.items():
        found = contact_alternation(path.to_dataset())
        if found is None:
            rows.append((name, *["not measured: interface fields were not kept"] * 3))
            continue
        rows.append(
            (
                name,
                number(found["alternation"], 3) + _at(found["alternation_at"]),
                number(found["second_difference"], 3) + _at(found["second_difference_at"]),
                f"{found['isolated_open']} of {found['stations']} stations",
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


def equilibrium_table(tree: xr.DataTree) -> Table:
    """Make the table of the equilibrium check over the converged steps of a result or of springs.

    Missing: the sum of the soil reactions less the applied load (`pysprings.springs.sums.balance`).
    """
    from pysprings.springs.dataset import get_path, path_names
    from pysprings.springs.sums import balance

    rows = []
    for name in path_names(tree):
        path = get_path(tree, name)
        path = path.assign(p=path["p_component"]) if "p_component" in path else path
        for load, missing in balance(path).items() if path.sizes["step"] else ():
            unit = "kN m" if load == "M" else "kN"
            largest = f"{float(np.abs(path[load]).max()) / 1e3 + 0.0:.4g} {unit}"
            rows.append((name, load, largest, f"{missing:.1e}"))
    note = (
        "H = sum p dz + H_tip + H_lid; V = sum t dz + V_tip + V_lid; "
        "M = sum (p z + m) dz + L H_tip + M_tip + M_lid. Missing: reactions less load, over the largest part."
    )
    return Table("Equilibrium check", ("path", "load", "largest load", "missing (relative)"), rows, note)


def water_table(run: Mapping[str, Any]) -> Table | None:
    """Make the table of the balance of the water at the end of each path; None for a drained run."""
    paths = {name: path["water"] for name, path in run.get("paths", {}).items() if "water" in path}
    if not paths:
        return None
    columns = ("path", "expelled [m\u00b3]", "compressed [m\u00b3]", "in gaps [m\u00b3]", "outflow [m\u00b3]",
               "imbalance / exchanged", "pressure [kPa]")  # fmt: skip
    rows = [
        (
            name,
            *(number(water[f"{key}_m3"]) for key in ("expelled", "compressed", "film", "outflow")),
            f"{water['worst_imbalance_over_exchanged']:.1e}",
            f"{water['pressure_min_Pa'] / 1e3:.3g} to {water['pressure_max_Pa'] / 1e3:.3g}",
        )
        for name, water in paths.items()
    ]
    note = (
        "Since the initial state, whole caisson: expelled = compressed + in gaps + outflow. Expelled is the pore "
        "volume that the soil has lost, from the displacements of its boundary; the outflow is Darcy flow over the "
        "drained boundary. The largest imbalance of all steps is shown. Pressure: the range of the excess on the path."
    )
    return Table("Balance of the water", columns, rows, note)


def energy_table(run: Mapping[str, Any]) -> Table | None:
    """Make the table of the balance of energy at the end of each path; None where there is none."""
    paths = {name: path["energy"] for name, path in run.get("paths", {}).items() if "energy" in path}
    if not paths:
        return None
    terms = ("work", "initial", "elastic", "plastic", "penalty", "friction", "water")
    rows = [
        (
            name,
            *(number(1e-3 * energy[f"{term}_J"]) for term in terms),
            f"{energy['imbalance_over_largest_term']:.1e}",
        )
        for name, energy in paths.items()
    ]
    note = (
        "Since the initial state, whole caisson: work + initial = elastic + plastic + penalty + friction + water. "
        "Initial is the work of weight, surcharge and initial contact pressure, penalty what contact springs store, "
        "water what is done against pore pressures. The imbalance is what Newton has left, over the largest term."
    )
    columns = ("path", *(f"{term} [kJ]" for term in terms), "imbalance / largest")
    return Table("Balance of energy", columns, rows, note)


def estimate_table(run: Mapping[str, Any]) -> Table | None:
    """Make the table of the estimated discretisation error; None where none was asked for."""
    found = run.get("error_estimate")
    if not found:
        return None
    if not found["estimate_pct"]:
        return Table("Discretisation error", ("",), [(f"no estimate: {found['why_not']}",)])
    words = {"load_max": "load, largest difference / largest load", "py_rms": "p(y), root mean square / largest p"}
    rows = [
        (words[name], number(found["difference_pct"][name], 3), number(found["order"][name], 3), number(value, 2))
        for name, value in found["estimate_pct"].items()
    ]
    note = (
        f"From the same scene on a coarser mesh ({found['unknowns'][1]} beside {found['unknowns'][0]} unknowns, "
        f"ratio of cell sizes r = {found['cell_ratio']:.3g}): safety factor {found['safety']:g} times "
        "difference / (r^order - 1)."
    )
    return Table("Discretisation error", ("", "difference [%]", "order", "estimate [%]"), rows, note)


def end_table(path: Any) -> Table:
    """List loads and motion at the last converged step of a path, in units for people."""
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
    return Table("At the last converged step", ("", ""), rows)


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


def validity(result: xr.DataTree, springs: xr.DataTree | None) -> list[str]:
    """Say in sentences for what the numbers hold: what was calibrated, how far, what no run sees."""
    found = []
    behaviour = result.attrs.get("caisson_behaviour", "rigid")
    length = float((springs.attrs if springs is not None else {}).get("skirt_length_m", np.nan))
    for name, path in result["paths"].children.items() if "paths" in result.children else ():
        found.append(_range_sentence(name, path, length))
    return [
        *found,
        "Springs from one path hold on paths with nearly the same ratio of rotation to displacement. "
        "p(z)/y(z) is not a property of the soil: check other load heights against the full model.",
        f"Monotonic loading; small displacements; the caisson is {behaviour} and wished in place, without "
        "installation effects.",
        "The soil domain is finite: its size stiffens the answer (a domain of 24 m by 12 m around a caisson "
        "of 7.8 m by about a third in elasticity, compared with a half-space).",
        "Beyond the displacements above the springs are extrapolated.",
    ]


def _range_sentence(name: str, path: Any, length: float) -> str:
    good = path["converged"].values.astype(bool)
    u, rotation = path["u"].values[good], path["rotation"].values[good]
    text = f"Path {name} ({path.attrs.get('kind', '')}, {path.attrs.get('role', '')}): "
    if not good.any():
        return text + "no converged step."
    if path.attrs.get("kind") == "vertical":
        w, V = path["w"].values[good] * 1e3, path["V"].values[good] / 1e3
        return f"{text}w from {w[0]:.3g} to {w[-1]:.3g} mm, V from {V[0]:.4g} to {V[-1]:.4g} kN."
    text += f"u from {u.min() * 1e3:.3g} to {u.max() * 1e3:.3g} mm, "
    text += f"rotation from {rotation.min() * 1e3:.3g} to {rotation.max() * 1e3:.3g} mrad"
    if np.isfinite(length) and abs(u[-1]) > 0:
        text += f", rotation·L/u = {rotation[-1] * length / u[-1]:.2f} at its end"
    return text + "."


# column of the comparison -> (heading, decimals of a number)
COMPARED: dict[str, tuple[str, int]] = {
    "path": ("path", 0),
    "role": ("role", 0),
    "springs": ("springs", 0),
    "springs_from": ("springs from", 0),
    "eta_small": ("eta small", 4),
    "eta_large": ("eta large", 4),
    "H_error_max_pct": ("H max [%]", 2),
    "rotation_error_max_pct": ("rotation max [%]", 2),
    "M_error_max_pct": ("M max [%]", 2),
    "V_error_max_pct": ("V max [%]", 2),
    "u_error_max_pct": ("u max [%]", 2),
    "rotation_point_error_max_m": ("z_rot max [m]", 3),
    "H_error_between_pct": ("H between [%]", 2),
    "rotation_error_between_pct": ("rotation between [%]", 2),
    "M_error_between_pct": ("M between [%]", 2),
    "extrapolated_states": ("extra\u00adpolated", 0),
    "off_path_states": ("off path", 0),
    "off_load_states": ("other V", 0),
}


def compare_table(compare: pd.DataFrame | None) -> Table | None:
    """Make the table macro-model against full model; columns without a number are left out."""
    if compare is None or compare.empty:
        return None
    shown = compare[[name for name in COMPARED if name in compare.columns]].dropna(axis=1, how="all")
    decimals = [COMPARED[str(name)][1] for name in shown.columns]
    rows = [[_fixed(v, n) for v, n in zip(row, decimals, strict=True)] for row in shown.itertuples(index=False)]
    note = (
        "max: largest error, macro-model over full model minus 1, at equal displacement; u: displacement "
        "at equal load; z_rot: depth of the point of rotation. between: the same "
        "when every second recorded state is left out of the springs. eta = 1 - area between the "
        "load-displacement curves over the area under the full model's, to a small displacement and to the "
        "end. extrapolated, off path, other V: states that the springs do not cover. py: lateral p-y springs alone; "
        "full: with distributed moment, tip and lid terms; fan: all of them by displacement and rotation, from all "
        "calibration paths of constant ratio."
    )
    ended = [
        f" {row['path']}, {row['springs']}: {row['status']}."
        for row in compare.to_dict("records")
        if row.get("status", "complete") != "complete"
    ]
    return Table("", [COMPARED[str(name)][0] for name in shown.columns], rows, note + "".join(ended))


def _fixed(value: Any, decimals: int) -> str:
    """Write a number with fixed decimals (never -0.00); anything else as it is."""
    if isinstance(value, float) and np.isfinite(value):
        return f"{round(value, decimals) + 0.0:.{decimals}f}"
    return number(value)


def cost_tables(run: Mapping[str, Any]) -> list[Table]:
    """Make the tables of cost from run.json: seconds by phase, then totals."""
    tables = []
    phases = {str(name): dict(value) for name, value in dict(run.get("phases") or {}).items()}
    if phases:
        keys = list(dict.fromkeys(key for value in phases.values() for key in value))
        rows = [[name, *(number(value.get(key, "-"), 3) for key in keys)] for name, value in phases.items()]
        tables.append(Table("Cost by phase", ["phase", *(_words(key) for key in keys)], rows))
    flat = {**run, **dict(run.get("solver") or {})}
    totals = [(words, number(flat[key] * factor)) for key, (words, factor) in _TOTALS.items() if key in flat]
    totals += [(key, str(run[key])) for key in ("python", "platform") if key in run]
    totals += [(str(name), str(value)) for name, value in dict(run.get("environment") or {}).items()]
    if totals:
        tables.append(Table("Totals", ("", ""), totals))
    return tables


_TOTALS: dict[str, tuple[str, float | int]] = {
    "wall_s": ("wall time [s]", 1.0),
    "cpu_s": ("processor time [s]", 1.0),
    "peak_memory_bytes": ("peak memory [MB]", 1e-6),
    "factorisations": ("factorisations", 1),
    "solves": ("solves", 1),
    "worst_linear_residual": ("worst residual of a linear solve", 1.0),
    "tolerance": ("Newton tolerance (relative residual)", 1.0),
}


def _words(key: str) -> str:
    return {"wall_s": "wall [s]", "cpu_s": "processor [s]"}.get(key, key.replace("_", " "))
