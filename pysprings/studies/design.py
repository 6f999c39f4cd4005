# SPDX-License-Identifier: MIT
"""Load cases answered by the macro-model, a row a case in SI, and the files of the answers: CSV, workbook, page.

What the springs do not cover is blank, with the reason.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import replace
from math import degrees
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pysprings.core.arrays import Array, Marks
from pysprings.core.columns import filled
from pysprings.core.errors import refused
from pysprings.core.loads import InPlane, close_loads, nearest
from pysprings.core.storage import replacing, write_text
from pysprings.core.tables.load_cases import LoadCases
from pysprings.core.text import number
from pysprings.core.units import QuantityError, read
from pysprings.core.words import RANGE_END
from pysprings.macro.batch import APART, MOST_APART, answer_from_all_sides, answer_loads
from pysprings.macro.fan_springs import BAND
from pysprings.macro.model import AnySprings, Typed, typed
from pysprings.macro.vertical import build_vertical, covered, share_left
from pysprings.results.exporters.csv import write_frame
from pysprings.results.layout import LOAD_CASES
from pysprings.results.report import load_cases as text
from pysprings.results.sheets import write_sheet
from pysprings.springs.path import SPACE_TURNS
from pysprings.springs.springs import Springs

TILTED, OVERLOADED, PARTLY, UNKNOWN = "tilt exceeded", "overloaded", "supported in part", "no answer"
# marks of answers that the springs support in part, and their words
MARKS = {
    "extrapolated": "beyond the calibrated range",
    "off_path": "off the calibrated paths",
    "off_load": "V not covered by the lateral springs",
    "off_rate": "V carried by vertical springs of another rate",
    "past_peak": "beyond the peak of a spring that softens",
    "unchecked": "beyond the held-back paths out of one plane",
    "torsion_apart": "torsion beside lateral loads: springs of both apart, motions too small, the twist by a factor",
    "unbounded": "no upper bound of the rotation: the largest load, 1.96 deviations less, is below this one",
}
GOVERNS = "no bound: torsion governs, which may reach its own capacity first"
NO_RADIUS = "no bound: the radius, on which torsion acts, is not known"
STIFFNESS = {
    ("u", "u"): "tangent_u_u_N_per_m",
    ("u", "rotation"): "tangent_u_rotation_N",
    ("rotation", "u"): "tangent_rotation_u_N",
    ("rotation", "rotation"): "tangent_rotation_rotation_Nm",
    ("w", "w"): "tangent_w_w_N_per_m",
}


def tolerated_tilt(springs: AnySprings) -> float | None:
    """Return the rotation [rad] that the scene of a run tolerates, [design] tilt; None where it gives none."""
    own = typed(springs)
    text = own.tree.attrs.get("scene_toml") if isinstance(own, Springs) else None
    try:
        given = tomllib.loads(str(text or ""))["design"]["tilt"]
        return float(read(given, "rad", "0.25 deg"))
    except (tomllib.TOMLDecodeError, KeyError, TypeError, QuantityError):  # none there, or no scene of this program
        return None


def answer_cases(
    springs: AnySprings, cases: LoadCases, tilt: float | None = None, extrapolate: bool = False, **choice: Any
) -> pd.DataFrame:
    """Return the answers to load cases, a row a case.

    tilt : Largest rotation that is tolerated [rad], of cases that have none of their own; None: `tolerated_tilt`.
    extrapolate : Answer beyond the calibrated range, marked.
    choice : Spring set and path (`pysprings.macro.predict.SpringChoice`).

    attrs["notes"] of the answers are sentences on the springs, for all cases.
    """
    loads = InPlane(cases.H, cases.M, cases.across, cases.direction)
    answers = answer_from_all_sides(springs, loads, cases.torsion, cases.V, extrapolate, **choice)
    space = np.nan_to_num(_values(answers, "in_space", len(cases))) == 1.0
    frame = pd.DataFrame({
        "name": cases.name, "limit_state": cases.limit_state, "direction_deg": np.degrees(cases.direction),
        "H_N": cases.H, "M_Nm": cases.M, "V_N": np.where(np.isnan(cases.V), _values(answers, "V", len(cases)), cases.V),
    })  # fmt: skip
    for name, column in (("u", "u_m"), ("w", "w_m"), ("rotation", "rotation_rad")):
        frame[column] = _values(answers, name, len(cases))
    for name, column in (("u_deviation", "u_deviation_m"), ("rotation_deviation", "rotation_deviation_rad")):
        if name in answers:
            frame[column] = answers[name].values
    turn = frame["rotation_rad"].abs().to_numpy()
    frame = pd.concat([with_tilt(frame, turn, springs, cases, tilt), _stiffness(answers, frame)], axis=1)
    frame = _with_capacity(frame, answers)
    frame["range_used"] = answers["range_used"].values
    frame["mesh_error_pct"] = _values(answers, "mesh_error_pct", len(cases))
    if "rate_m_per_s" in answers.attrs:
        frame["rate_m_per_s"] = answers.attrs["rate_m_per_s"]
    frame["answered"] = answers["answered"].values.astype(int)
    frame["marks"] = _marks(answers, frame)
    frame["remarks"] = list(cases.notes)
    frame = _with_mesh_error(frame, springs, cases, extrapolate, choice)
    own = frame["marks"]
    frame = _with_sets(frame, typed(springs), cases, extrapolate, choice)
    frame["marks"] = frame["marks"].where(~space, own)  # springs in space are those of one V
    D = answers.attrs.get("outer_diameter_m")
    radius = None if D is None else 0.5 * float(D)
    bound, twisted, found = cases.bounded(radius), cases.twisted(radius), answers
    left, at = _left_beyond(frame, typed(springs), cases, choice)
    if cases.aside.any() or (left < 1.0).any():
        of_bound = bound.loads / np.nan_to_num(left, nan=1.0)[:, None]
        found = _farthest(answer_loads(springs, of_bound, at, extrapolate, **choice), typed(springs), left)
    frame = _with_twist(_with_bounds(frame, cases, found, (space, twisted), left), cases, answers, space)
    frame = frame.assign(verdict=verdicts(frame))
    rows = str(answers.attrs.get("space_errors", ""))  # stand in their rows
    frame.attrs["notes"] = [text for text in answers.attrs["remarks"] if text != rows]
    return frame


MOTIONS = {"u_m": "u", "w_m": "w", "rotation_rad": "rotation", "tilt_used": "tilt"}
LARGEST = MOTIONS | {"utilisation": "utilisation", "utilisation_V": "V used"}
# of the estimate that has the largest value of a column
BESIDE = {
    "u_m": ("secant_H_u_N_per_m", "u_deviation_m", "u_x_m", "u_y_m", *STIFFNESS.values()),
    "rotation_rad": ("secant_M_rotation_Nm", "rotation_deviation_rad", "rot_x_rad", "rot_y_rad"),
    "utilisation": (  # of a group each estimate has its own shares of the loads
        "direction_deg",
        "H_N",
        "M_Nm",
        "across_Nm",
        "torsion_Nm",
        "H_capacity_N",
        "M_capacity_Nm",
        "capacity_kind",
    ),
    "utilisation_V": ("V_N", "V_springs_N", "capacity_V_N", "capacity_V_kind"),
}
WORST = ("tilt_deg", "range_used", "mesh_error_pct", "twist_rad")
BOUNDS = {"u_bound_m": "u", "rotation_bound_rad": "rotation", "utilisation_bound": "utilisation"}


def governing(tables: Mapping[str, pd.DataFrame]) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the answers of several estimates, a row a case and estimate, and the rows that govern, a row a case.

    A row that governs has the largest motion and utilisation over the estimates, and the worst verdict; `estimate`
    names the estimate of each: "low (u, rotation), high (utilisation)". Secants and tangents are of the estimate of
    their motion, loads and capacities of that of their utilisation, mesh error and range used the largest, everything
    else of the estimate of that verdict. Motions are blank where one estimate has no answer, utilisations where one
    has no capacity, bounds where one has none: the largest is not known.
    """
    order = (text.OK, PARTLY, UNKNOWN, TILTED, OVERLOADED)
    all_rows, rows = [], []
    for k in range(len(next(iter(tables.values())))):
        own = {name: table.iloc[k].copy() for name, table in tables.items()}
        row = max(own.values(), key=lambda each: order.index(each["verdict"])).copy()
        found: dict[str, list[str]] = {}
        known = all(each["answered"] for each in own.values())
        for column, words in LARGEST.items():
            values = {name: each[column] for name, each in own.items()}
            lost = [name for name, value in values.items() if pd.isna(value) or (column in MOTIONS and not known)]
            name = lost[0] if lost else max(values, key=lambda each: abs(values[each]))
            row[column] = np.nan if lost else values[name]
            for beside in (each for each in BESIDE.get(column, ()) if each in row.index):
                row[beside] = np.nan if lost and column in MOTIONS else own[name].get(beside, np.nan)
            found.setdefault("" if lost else name, []).append(words)
        for column in BOUNDS:
            row[column] = np.max([each.get(column, np.nan) for each in own.values()])  # NaN where one is
        for column in (name for name in row.index if name in WORST or name.startswith("group_")):
            values = {name: each[column] for name, each in own.items()}
            found_all = known and not any(pd.isna(value) for value in values.values())
            row[column] = max(values.values(), key=abs) if found_all else np.nan
        row["marks"] = "; ".join(
            f"{name}: {words}" for name, each in own.items() if (words := _marks_of(each, known))
        )  # fmt: skip
        row["estimate"] = ", ".join(f"{name} ({', '.join(words)})" for name, words in found.items() if name)
        rows.append(row)
        all_rows += [pd.Series({"name": each["name"], "estimate": name} | dict(each)) for name, each in own.items()]
    return pd.DataFrame(all_rows).reset_index(drop=True), pd.DataFrame(rows).reset_index(drop=True)


def _marks_of(row: pd.Series, known: bool) -> str:
    """Return the marks of an estimate, with a tilt that is not tolerated where the motions of others are not known."""
    tilted = not known and row["verdict"] == TILTED
    return "; ".join(filter(None, [row["marks"], f"tilt used {number(row['tilt_used'], 3)}" * tilted]))


def _values(answers: xr.Dataset, name: str, n: int) -> Array:
    """Return a variable by case; NaN where springs from a table do not have it."""
    return answers[name].values if name in answers else np.full(n, np.nan)


def with_tilt(
    frame: pd.DataFrame, turn: Array, springs: AnySprings, cases: LoadCases, tilt: float | None
) -> pd.DataFrame:
    """Return the answers with their tilt (n,) [rad], what is tolerated, and the share that is used: `answer_cases`."""
    limit = tolerated_tilt(springs) if tilt is None else tilt
    tolerance = np.where(np.isnan(cases.tilt), np.nan if limit is None else limit, cases.tilt)
    return frame.assign(tilt_deg=np.degrees(turn), tilt_limit_deg=np.degrees(tolerance), tilt_used=turn / tolerance)


def _stiffness(answers: xr.Dataset, frame: pd.DataFrame) -> pd.DataFrame:
    """Return secants H/u and M/rotation (NaN for no load or motion), and the tangent at the state."""
    secant = {
        "secant_H_u_N_per_m": frame["H_N"] / frame["u_m"],
        "secant_M_rotation_Nm": frame["M_Nm"] / frame["rotation_rad"],
    }
    out = pd.DataFrame(secant).replace([np.inf, -np.inf, 0.0], np.nan)
    dofs = [str(name) for name in answers["dof"].values]
    for (row, column), name in STIFFNESS.items():
        if row in dofs and column in dofs:
            out[name] = answers["stiffness"].values[:, dofs.index(row), dofs.index(column)]
    return out


def _with_capacity(frame: pd.DataFrame, answers: xr.Dataset) -> pd.DataFrame:
    """Return answers with the largest known loads of each case and the shares of them that are used."""
    n = len(frame)
    kinds = answers["capacity_V_kind"].values if "capacity_V_kind" in answers else [""] * n
    return frame.assign(
        utilisation=answers["utilisation"].values, utilisation_V=_values(answers, "utilisation_V", n),
        H_capacity_N=answers["capacity_H"].values, M_capacity_Nm=answers["capacity_M"].values,
        capacity_kind=[str(text) for text in answers["capacity_kind"].values],
        capacity_V_N=_values(answers, "capacity_V", n), capacity_V_kind=kinds,
    )  # fmt: skip


def _marks(answers: xr.Dataset, frame: pd.DataFrame) -> list[str]:
    """Return why a case has no answer, or the marks of its answer in words; of springs of an atlas those of all."""
    texts, wide = [], frame["tilt_deg"] + np.degrees(BAND * frame.get("rotation_deviation_rad", 0.0))
    near = (frame["tilt_used"] <= 1.0) & (wide > frame["tilt_limit_deg"]) & np.isfinite(wide)
    of_all = [str(answers.attrs[name]) for name in ("atlas_outside", "atlas_mesh") if answers.attrs.get(name)]
    for k, why in enumerate(answers["why_not"].values):
        marked = [words for name, words in MARKS.items() if name in answers and answers[name].values[k]]
        apart = float(answers["plane_difference_pct"].values[k]) if "plane_difference_pct" in answers else 0.0
        marked += [APART.format(apart)] * (apart > MOST_APART)
        marked += [f"tilt with {BAND} deviations {number(wide[k], 3)} deg: not tolerated"] * bool(near[k])
        texts.append(str(why) or "; ".join([*marked, *of_all]))
    return texts


def _with_mesh_error(
    frame: pd.DataFrame, springs: AnySprings, cases: LoadCases, extrapolate: bool, choice: dict[str, Any]
) -> pd.DataFrame:
    """Return the answers with marks of cases that are met, but not at loads larger by the mesh's error.

    Of V alone, and of loads in one plane. Near the largest load a small error of the load is a multiple of it in the
    motion.
    """
    error = frame["mesh_error_pct"].to_numpy()
    used, kind = (
        np.where(cases.lateral, frame[lateral], frame[vertical])
        for lateral, vertical in (("utilisation", "utilisation_V"), ("capacity_kind", "capacity_V_kind"))
    )
    over = (used <= 1.0) & (used * (1.0 + 0.01 * error) > 1.0) & (kind != RANGE_END)  # loads in proportion
    plane = (error > 0.0) & (frame["answered"] == 1) & ~cases.aside
    rows = np.flatnonzero(plane & (over | (cases.lateral & (frame["tilt_used"] <= 1.0))))
    if not rows.size:
        return frame
    larger = cases.loads[rows] * (1.0 + 0.01 * error[rows, None])
    more = answer_loads(springs, larger, cases.V[rows], extrapolate, **choice)
    out = frame.copy()
    for k, row in enumerate(rows):
        turn, limit = abs(np.degrees(float(more["rotation"].values[k]))), float(out["tilt_limit_deg"][row])
        texts = [not_tolerated(turn)] * bool(out["tilt_deg"][row] <= limit < turn)
        texts += ["overloaded"] * bool(over[row])
        out.loc[row, "marks"] = with_larger(out["marks"][row], error[row], texts)
    return out


def not_tolerated(turn: float) -> str:
    """Return words on a tilt [deg] at larger loads."""
    return f"tilt {number(turn, 3)} deg, not tolerated"


def with_larger(marks: str, error: float, texts: list[str]) -> str:
    """Return marks with texts on what happens at loads that are larger by the error of the mesh [%]."""
    words = f"at loads {number(error, 2)} % larger, the error of the mesh: {', '.join(texts)}"
    return "; ".join(filter(None, [marks, words * bool(texts)]))


def _with_sets(
    frame: pd.DataFrame, springs: Typed, cases: LoadCases, extrapolate: bool, choice: dict[str, Any]
) -> pd.DataFrame:
    """Return the answers with V of the nearest springs, and marks of V between two that differs by more than 10 %.

    Such a mark has the answers of the springs on both sides, bounds where the answer is monotonic in V.
    """
    if not isinstance(springs, Springs) or choice.get("path") is not None or not springs.load_sets:
        return frame
    loads = np.array([each.V for each in springs.load_sets])
    V = np.where(np.isnan(cases.V), springs.rest_load, cases.V)
    near = loads[nearest(V, loads)]
    out = frame.assign(V_springs_N=near)
    between = (loads[0] < V) & (loads[-1] > V)
    far = np.flatnonzero(~close_loads(V, near) & cases.lateral & (frame["answered"] == 1) & between)
    if not far.size:
        return out
    above = np.searchsorted(loads, V[far])
    sides = loads[above - 1], loads[above]
    names = ["answered", *(name for name, *_ in _AT_SETS)]
    answers = (answer_loads(springs, cases.loads[far], each, extrapolate, **choice)[names] for each in sides)
    found = [each.to_dataframe().to_dict("records") for each in answers]
    for k, row in enumerate(far):
        ends = [(number(1e-6 * float(at[k])), each[k]) for at, each in zip(sides, found, strict=True)]
        known = [(at, each) for at, each in ends if each["answered"]]
        values = [f"{words} {' and '.join(number(scale * each[name], 3) for _, each in known)}{unit}"
                  for name, words, scale, unit in _AT_SETS]  # fmt: skip
        texts = [out["marks"][row], "V between the springs, interpolated"]
        texts += [f"at V {' and '.join(at for at, _ in known)} MN: {', '.join(values)}"] * bool(known)
        texts += [f"beyond the springs at {at} MN" for at, each in ends if not each["answered"]]
        out.loc[row, "marks"] = "; ".join(filter(None, texts))
    return out


_AT_SETS = (
    ("u", "u", 1e3, " mm"), ("rotation", "rotation", degrees(1.0), " deg"), ("utilisation", "utilisation", 1.0, ""),
)  # fmt: skip


def _left_beyond(frame: pd.DataFrame, springs: Typed, cases: LoadCases, choice: dict[str, Any]) -> tuple[Array, Array]:
    """Return by case the share of loads at equal motion that V leaves at least, and V of the springs that it is of [N].

    1 and V of the case, but for lateral loads, answered or aside of one plane, whose V is beyond all springs and not
    `covered` by them. NaN: V is not known to lie before the end of the vertical path on its side.
    """
    share, at = np.ones(len(cases)), cases.V.copy()
    if not isinstance(springs, Springs) or choice.get("path") is not None or not springs.load_sets:
        return share, at
    sets, vertical = springs.load_sets, build_vertical(springs)
    V = np.where(np.isnan(cases.V), springs.rest_load, cases.V)
    own = np.clip(V, sets[0].V, sets[-1].V)
    beyond = cases.lateral & ((frame["answered"] == 1) | cases.aside).to_numpy() & ~covered(vertical, V, own)
    left = share_left(vertical, V, own)
    share[beyond] = np.where((left > 0.0) & (left < 1.0), left, np.nan)[beyond]
    at[beyond] = own[beyond]
    return share, at


def _farthest(answers: xr.Dataset, springs: Typed, left: Array) -> xr.Dataset:
    """Return the bounds of cases whose share of loads (n,) is known, with the largest u and rotation that V may cause.

    The share bounds the work H u + M rotation alone: what V leaves more may turn the motion. Of all motions q whose
    work F_s(q) q is at most that of the load over its share, whose answer is q_b, the largest component is

        (|q_b| + sqrt(C q_b.K q_b))/2,   K the stiffness at rest, C the component of its inverse,

    where the springs soften from K in proportion.
    """
    if not isinstance(springs, Springs) or not (left < 1.0).any():
        return answers
    K, names = 0.5 * (springs.lateral_stiffness + springs.lateral_stiffness.T), ("u", "rotation")
    q = np.stack([answers[name].values for name in names], axis=1)
    most = np.sqrt(np.diag(np.linalg.inv(K)) * np.einsum("ni,ij,nj->n", q, K, q)[:, None])
    q = np.where((left < 1.0)[:, None], 0.5 * (np.abs(q) + most), q)
    return answers.assign({name: (answers[name].dims, own) for name, own in zip(names, q.T, strict=True)})


def _with_bounds(
    frame: pd.DataFrame, cases: LoadCases, bounds: xr.Dataset, marks: tuple[Marks, Marks], left: Array
) -> pd.DataFrame:
    """Return the answers with what cases aside of one plane leave out, and with their bounds.

    marks : cases that are answered in space, and those that are twisted, (n,). Those of cases whose V is beyond the
    springs have the share of loads (n,) of `_left_beyond`. In space a bound stands in the mark where it does not show
    that the load is carried.
    """
    space, twisted = marks
    out, aside, beyond = frame.copy(), cases.aside, left != 1.0
    bounded = np.isfinite(left) & ~twisted & (aside | beyond)
    for column, load in (("across_Nm", cases.across), ("torsion_Nm", cases.torsion)):
        out[column] = np.where(load != 0.0, load, np.nan)
    for column, name in BOUNDS.items():
        out[column] = np.where(bounded, np.abs(bounds[name].values), np.nan)
    loose = space & (out["answered"] == 1).to_numpy() & ~(out["utilisation_bound"] <= 1.0).to_numpy()
    for k in np.flatnonzero((aside & ~space) | beyond | loose):
        lost = {"no moment across the plane of H": cases.across[k], "no torsion": cases.torsion[k]}
        lost = {} if space[k] else lost
        texts = [f"{what} ({number(1e-3 * abs(load))} kN m left out)" for what, load in lost.items() if load]
        if left[k] < 1.0:
            texts.append(f"loads at equal motion at least {100.0 * left[k]:.0f} % of those of the springs")
        texts += ["no bound: no vertical path leads beyond V"] * bool(np.isnan(left[k]))
        texts += [GOVERNS if "outer_diameter_m" in bounds.attrs else NO_RADIUS] * bool(twisted[k])
        far = "extrapolated" in bounds and bool(bounds["extrapolated"].values[k] and np.isfinite(out["u_bound_m"][k]))
        texts += [_bound_words(out.iloc[k]) + f" ({MARKS['extrapolated']})" * far] * bool(bounded[k])
        out.loc[k, "marks"] = "; ".join(filter(None, [frame["marks"][k], *texts]))
    return out


def _bound_words(row: pd.Series) -> str:
    """Return words on the bound of a row; without motions where the load of the bound has no answer."""
    turn = degrees(row["rotation_bound_rad"])
    found = [f"u {number(1e3 * row['u_bound_m'])} mm", f"rotation {number(turn)} deg"]
    found += [f"tilt used {number(turn / row['tilt_limit_deg'], 3)}"] * bool(np.isfinite(row["tilt_limit_deg"]))
    found *= bool(np.isfinite([row["u_bound_m"], turn]).all())
    return "bound: " + ", ".join([*found, f"utilisation {number(row['utilisation_bound'], 3)}"])


def _with_twist(frame: pd.DataFrame, cases: LoadCases, answers: xr.Dataset, space: Marks) -> pd.DataFrame:
    """Return the answers with the twist, and, where springs in space answer cases (n,), six motions and remarks."""
    out = frame.assign(twist_rad=np.where(cases.torsion != 0.0, answers["rot_z"].values, np.nan))
    least = np.isfinite(out["twist_rad"]) & ~space
    out["marks"] = [
        f"{text}; twist {number(1e3 * twist)} mrad at least (stiffness at rest)" if linear else text
        for text, twist, linear in zip(out["marks"], out["twist_rad"], least, strict=True)
    ]
    if not space.any():
        return out
    for name in SPACE_TURNS[:4]:
        out[f"{name}_{'m' if name[0] == 'u' else 'rad'}"] = answers[name].values
    out.loc[space, ["secant_H_u_N_per_m", "secant_M_rotation_Nm"]] = np.nan
    words = answers.attrs["space_errors"]
    notes = [f"{text}; {words}" if text else words for text in out["remarks"]]
    return out.assign(remarks=np.where(space, notes, out["remarks"]))


def verdicts(frame: pd.DataFrame) -> list[str]:
    """Return the verdict on each case."""
    return [_verdict(row) for row in frame.to_dict("records")]


def _verdict(row: dict[Any, Any]) -> str:
    """Return the verdict on a case: what is wrong with it comes before what is not known."""
    loads = ((row["utilisation"], row["capacity_kind"]), (row["utilisation_V"], row["capacity_V_kind"]))
    if any(used > 1.0 and kind != RANGE_END for used, kind in loads):
        return OVERLOADED
    if not row["answered"]:
        return UNKNOWN
    if row["tilt_used"] > 1.0:
        return TILTED
    return PARTLY if row["marks"] else text.OK


ENDINGS = (".csv", ".xlsx", ".html", ".png", ".svg")


def check_ending(file: Path) -> None:
    """Refuse a name whose ending is none of `ENDINGS`, and a folder."""
    if file.suffix.lower() not in ENDINGS:
        raise refused("--out", f"ends in none of {', '.join(ENDINGS)}", file)
    if file.is_dir():
        raise refused("--out", "is a folder, not a file", file)


def write(
    file: Path, table: pd.DataFrame, about: Mapping[str, str], springs: AnySprings | None,
    govern: pd.DataFrame | None = None,
) -> Path:  # fmt: skip
    """Write answers (`answer_cases`) of springs (None: of several) to a file, with lines on what made them.

    govern : The rows of several estimates that govern (`governing`), which result and picture show; None: the table.
    """
    govern = table if govern is None else govern
    check_ending(file)
    ending = file.suffix.lower()
    if ending == ".csv":
        return write_frame(table, file)
    if ending == ".xlsx":
        return _workbook(file, table, {**about, "result": text.closing(govern)})
    if ending == ".html":
        return _page(file, (table, govern), about, springs)
    from pysprings.results.plots.files import content_of
    from pysprings.results.plots.load_cases import load_cases

    with replacing(file) as temporary:
        temporary.write_bytes(content_of(load_cases(govern, springs), ending[1:]))
    return file


def check_run(folder: Path) -> None:
    """Refuse what is no folder of a run with a full model, whose report could be written."""
    if not (folder / "full_model.nc").exists():
        raise refused("--report", "needs the folder of a run, with its full_model.nc", folder)


def into_report(folder: Path, table: pd.DataFrame) -> Path:
    """Write answers into the folder of a run (design.csv) and its report anew; return the path of the report."""
    from pysprings.results.report.page import write_report

    check_run(folder)
    write_frame(table, folder / LOAD_CASES)
    return write_report(folder)


def _workbook(file: Path, table: pd.DataFrame, about: Mapping[str, str]) -> Path:
    rows = table.to_dict("records")
    columns = filled(text.COLUMNS, rows)
    cells = (([column.value(row) for column in columns], row["verdict"] != text.OK) for row in rows)
    notes = {**about, "columns": text.NOTE}
    return write_sheet(file, [column.head for column in columns], cells, notes)


def _page(
    file: Path, tables: tuple[pd.DataFrame, pd.DataFrame], about: Mapping[str, str], springs: AnySprings | None
) -> Path:
    """Write a page of all answers, with the picture and the closing line of those that govern."""
    from pysprings.results.report.page import page_html, picture_of_cases

    table, govern = tables
    cases, drawn = replace(text.table_of(table), title=""), picture_of_cases(govern, springs)
    values: dict[str, Any] = {"about": about, "closing": text.closing(govern), "cases": cases, "drawn": drawn}
    return write_text(page_html("design.html.j2", **values), file)
