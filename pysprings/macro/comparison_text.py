# SPDX-License-Identifier: MIT
"""The comparison of both models as a table for a terminal, and for JSON, with its definitions."""

from collections.abc import Hashable, Mapping
from typing import Any

import pandas as pd

from pysprings.core.columns import Column, Table, filled, records
from pysprings.core.loads import same_load
from pysprings.core.path_kinds import ROLES, VERTICAL
from pysprings.macro.measures import SKIP_BELOW, SMALL_OVER_DIAMETER

# every column of the comparison for people; terminal and report choose theirs
COLUMNS = {
    str(column.source): column
    for column in (
        Column("path", "path", words=True),
        Column("role", "role", words=True),
        Column("arm [m]", "arm_m", ".2f"),
        Column("V [MN]", "V_N", ".2f", 1e-6),
        Column("springs", "springs", words=True),
        Column("from", "springs_from", words=True),
        Column("eta small", "eta_small", ".4f"),
        Column("eta large", "eta_large", ".4f"),
        Column("H max [%]", "H_error_max_pct", ".2f"),
        Column("H end [%]", "H_error_end_pct", ".2f"),
        Column("H between [%]", "H_error_between_pct", ".2f"),
        Column("rot max [%]", "rotation_error_max_pct", ".2f"),
        Column("rot end [%]", "rotation_error_end_pct", ".2f"),
        Column("rot between [%]", "rotation_error_between_pct", ".2f"),
        Column("M max [%]", "M_error_max_pct", ".2f"),
        Column("M between [%]", "M_error_between_pct", ".2f"),
        Column("u max [%]", "u_error_max_pct", ".2f"),
        Column("u half [%]", "u_error_half_pct", ".2f"),
        Column("p max [%]", "p_error_max_pct", ".2f"),
        Column("T max [%]", "T_error_max_pct", ".2f"),
        Column("z_rot full [m]", "rotation_point_full_m", ".3f"),
        Column("z_rot macro [m]", "rotation_point_macro_m", ".3f"),
        Column("z_rot max [m]", "rotation_point_error_max_m", ".3f"),
        Column("w max [mm]", "w_error_max_m", ".2f", 1e3),
        Column("V max [%]", "V_error_max_pct", ".2f"),
        Column("V between [%]", "V_error_between_pct", ".2f"),
        Column("extra\u00adpolated", "extrapolated_states"),
        Column("off path", "off_path_states"),
        Column("other V", "off_load_states"),
    )
}
_OF_THE_REPORT = ("role", "rotation_error_between_pct", "M_error_between_pct", "extrapolated_states", "off_path_states",
                  "off_load_states")  # fmt: skip
# of runs that have vertical paths, or paths at several vertical loads
_VERTICAL = ("V_N", "w_error_max_m", "V_error_max_pct", "V_error_between_pct")
_BRIEF = ("path", "arm_m", "V_N", "springs", "eta_large", "H_error_max_pct", "rotation_error_max_pct",
          "M_error_max_pct", "w_error_max_m")  # fmt: skip
_ROLE_TITLES = {
    "calibration": "calibration paths: springs are made from them",
    "memory": "memory paths: springs with memory are made from them, too",
    "held-back": "held-back paths: springs are checked on them",
}

# spring sets that predict
_PREDICTING = ("fan", "vertical")


def to_brief_text(frame: pd.DataFrame) -> str:
    """Return the rows that show what the springs are worth: the fan on the paths held back; else all, as `to_text`."""
    own = frame[(frame["role"] == "held-back") & frame["springs"].isin(_PREDICTING)]
    return to_text(frame) if own.empty else to_text(own, brief=True)


def to_text(frame: pd.DataFrame, brief: bool = False) -> str:
    """Return the comparison as tables for a terminal, one a role, with definitions; '-' is imposed or undefined.

    brief: the columns of `_BRIEF` and one definition.
    """
    if frame.empty:
        return (
            "nothing to compare: no springs of this run answer on its paths (none was calibrated in their direction)\n"
        )
    first = frame["V_N"].iloc[0]
    vertical = (frame["kind"] == VERTICAL).any() or not all(same_load(V, first) for V in frame["V_N"])
    left_out = {*_OF_THE_REPORT, *(() if vertical else _VERTICAL)}
    left_out -= {"w_error_max_m"} if "T_error_max_pct" in frame else set()
    rows = frame.to_dict("records")
    columns = [each for name, each in COLUMNS.items() if name not in left_out and (not brief or name in _BRIEF)]
    columns = filled(columns, rows)
    lines: list[str] = []
    for role in ROLES:
        if own := [row for row in rows if row["role"] == role]:
            lines += [_ROLE_TITLES[role], Table.of(columns, own).text(), ""]
    ended = [f"{r.path}, {r.springs}: {r.status}" for r in frame.itertuples() if r.status != "complete"]
    ends = frame.attrs.get("ends", {})
    ended += [f"path {name} {ends[name]}" for name in frame["path"].unique() if name in ends]
    ended += [f"path {name}: not compared, no springs here answer it" for name in frame.attrs.get("unanswered", ())]
    further = (_VERTICAL_NOTES if vertical else []) + ([SPACE_NOTE] if "T_error_max_pct" in frame else [])
    notes = _NOTES[:1] if brief else _NOTES + further
    reference = str(frame.attrs.get("reference", FULL_MODEL))
    notes = [f"full model: {reference}, none of this caisson"] * (reference != FULL_MODEL) + notes
    return "\n".join(lines + notes + ended + _marked(frame)) + "\n"


def _marked(frame: pd.DataFrame) -> list[str]:
    """Return one line for each answer of the fan that it supports only in part."""
    off_load = [
        f"{r['path']}, fan: {_uncovered(r)}"
        for r in frame.to_dict("records")
        if r["springs"] == "fan" and r["off_load_states"]
    ]
    return off_load + [
        f"{r['path']}, fan: of {r['states']} states {r['extrapolated_states']} are extrapolated and "
        f"{r['off_path_states']} between paths too far apart"
        for r in frame.to_dict("records")
        if r["springs"] == "fan" and (r["extrapolated_states"] or r["off_path_states"])
    ]


def _uncovered(row: Mapping[Hashable, Any]) -> str:
    """Return words for states under a vertical load that is not that of the lateral springs."""
    if row["off_load_states"] < row["states"]:
        return (
            f"lateral springs of its first vertical load answer {row['off_load_states']} of its {row['states']} states"
        )
    return f"no calibration paths cover its vertical load ({row['V_N'] * 1e-6:.4g} MN)"


_NOTES = [
    f"errors: macro-model over full model minus 1, at equal displacement; states below {SKIP_BELOW:.0%} of "
    "the largest are left out; '-': imposed or undefined",
    "on a swipe, under a load that climbs, where a path turns back, and of a load that changes its sign errors are "
    "relative to the largest of the path",
    "u: error of the displacement at equal load, half: up to half of the largest load of the path; "
    "z_rot: depth of the point of rotation, at the end and largest error",
    "between: the largest error when every second recorded state is left out of the springs",
    "eta = 1 - area between the load-displacement curves / area of the full model's; "
    f"small: to outer diameter / {1 / SMALL_OVER_DIAMETER:.0f}",
    "springs: py = lateral p-y alone; full = p-y, distributed moment, tip and lid terms of one path;",
    "pisa = the same families, lateral ones of the pure translation, moments of the pure rotation; "
    "fan = all of them by (u, rotation), from all calibration paths of constant rotation/u",
]

_VERTICAL_NOTES = [
    "V: vertical load at the start of the path, under which the springs answer; where it changes on the way, w "
    "follows, and springs with memory between their loads; w max: largest distance of w; "
    "V max: error of V at equal w, over its change from rest",
    "vertical = vertical springs t(w), V_tip(w), V_lid(w) of the vertical calibration paths",
]

FULL_MODEL = "the full model"
SPACE_NOTE = (
    "paths out of one plane, answered by springs with memory in space: H, M/L as vectors at the motions of the full "
    "model, over the largest (H, M/L) of the path; T/R over the largest load; p as vectors by depth; u and rotation L "
    "as vectors under its loads, over its largest motion; w: largest distance at its motions and under its loads"
)


def to_dict(frame: pd.DataFrame) -> dict[str, Any]:
    """Return the comparison for JSON: definitions and rows; what is undefined is None."""
    definitions = {
        "eta": "1 - area between load-displacement curves / area under the full model's",
        "eta_small_to": f"outer diameter * {SMALL_OVER_DIAMETER:g}; over the skirt length on a rotation path",
        "errors": "(macro - full) / full in percent, at equal displacement",
        "u_error": "displacement at equal load (H and M of each state), macro / full - 1 in percent; half: up to half "
        "of the largest load of the path",
        "states_at_load": "states whose load the springs carry",
        "rotation_point": "depth of the point of the axis at rest, u/rotation, at the end; error_max: over all states",
        "skip_below": SKIP_BELOW,
        "V_error": "V at equal w, (macro - full) over the change of V from rest, in percent",
        "w_error_max": "largest distance of the vertical displacements, macro - full",
        "off_load_states": "states under a vertical load that is not that of the lateral springs",
    }
    about = {str(name): value for name, value in frame.attrs.items()}
    return about | {"definitions": definitions, "rows": records(frame)}
