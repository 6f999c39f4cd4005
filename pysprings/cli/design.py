# SPDX-License-Identifier: MIT
"""`pysprings design`: load cases answered on the springs of a run."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from pysprings.cli.folders import all_folders_of, folders_of, refuse_read
from pysprings.cli.options import Json, Rate, SpringSet, argument, option
from pysprings.cli.support import print_json, print_table, quantities, refuse
from pysprings.core.text import shared

if TYPE_CHECKING:
    import pandas as pd

    from pysprings.macro.model import AnySprings


def design(
    result: Annotated[Path, argument("RESULT", "folder of a run, springs.nc, or a p-y table")],
    cases: Annotated[
        Path | None,
        argument("CASES", "load cases (CSV, Excel), units in the headings; by default design.cases of the scene"),
    ] = None,
    tilt: Annotated[
        str | None, option("--tilt", 'tolerated rotation, e.g. "0.25 deg"; by default [design] tilt', "ANGLE")
    ] = None,
    out: Annotated[
        list[Path] | None,
        option("--out", "file for the answers: .csv, .xlsx, .html, or picture: .png, .svg; may be repeated", "FILE"),
    ] = None,
    in_report: Annotated[
        bool, option("--report", "put the answers into the report of the run (RESULT: its folder)")
    ] = False,
    extrapolate: Annotated[bool, option("--extrapolate", "answer beyond the calibrated range, marked")] = False,
    strict: Annotated[bool, option("--strict", "refuse cases that are not ok (exit code 2)")] = False,
    group: Annotated[
        Path | None,
        option(
            "--group",
            "positions of caissons under one rigid frame (bucket, x, y); CASES load the frame at their origin",
            "FILE",
        ),
    ] = None,
    joint: Annotated[
        str | None,
        option("--joint", 'rotational stiffness of each joint, e.g. "2 GN m/rad"; rigid by default', "STIFFNESS"),
    ] = None,
    rate: Rate = None,
    spring_set: SpringSet = None,
    path: Annotated[str | None, option("--path", "load path whose springs answer (full, py)", "NAME")] = None,
    as_json: Json = False,
) -> None:
    """Answer load cases: motion, tilt, stiffness, utilisation, marks.

    CASES has a row a load: name, limit state, H, M or arm, V, direction, factor, tilt, with units in the headings.
    Rows of one name act together. The summary of the run stands below the answers. Of a folder with several estimates
    each case shows the largest motion and utilisation over them; files have a row a case and estimate. With --group
    each case has a row a caisson: its share of the loads, its answer, and the tilt of the frame.
    """
    from pysprings.cli.results import print_summary
    from pysprings.core.tables.load_cases import read_load_cases
    from pysprings.full_model.run_record import RunRecord
    from pysprings.results.report import load_cases as text
    from pysprings.studies import design as files
    from pysprings.studies.group import answer_group, read_group

    tolerance, stiffness = _checked(tilt, joint, group)
    used = cases or cases_of(result)
    _check_files(out or [], in_report, result, used, group)
    read = read_load_cases(used)
    placed = None if group is None else read_group(group, stiffness or math.inf)
    more = {"springs_kind": spring_set, "path": path}

    def answer(springs: AnySprings) -> pd.DataFrame:
        if placed is None:
            return files.answer_cases(springs, read, tolerance, extrapolate, **more)
        return answer_group(springs, read, placed, tolerance, extrapolate, **more)

    answers, table, springs = _answers(result, strict, rate, answer)
    if strict and (table["verdict"] != text.OK).any():
        refuse("--strict", text.closing(table))
    record = RunRecord.read(result) if result.is_dir() else None
    about = {"answered by": str(result), "load cases": str(used), "tilt tolerated": _tolerance(table)}
    about |= {"group": table.attrs["group"]} if placed else {}
    about |= {"note": "; ".join(notes)} if (notes := table.attrs.get("notes")) else {}
    about |= (record.summary if record else None) or {}
    for file in out or ():
        files.write(file, answers, about, springs, table)
    if in_report:
        files.into_report(result, table)
    if as_json:
        every = {} if answers is table else {"estimates": answers.to_dict("records")}
        print_json({"about": about, "cases": table.to_dict("records"), **every})
        return
    if cases is None:
        print(f"load cases: {used} as it is now ([design] cases of the run)\n")
    written = [f"{file}: the answers" for file in out or ()]
    written += [f"{result / 'report.html'}: the report of the run, with the answers"] if in_report else []
    _print(table, written)
    if record:
        print_summary(record)


def _check_files(files: list[Path], in_report: bool, result: Path, *read: Path | None) -> None:
    """Refuse files of no known ending, those that the command reads, and a report of no run."""
    from pysprings.results.layout import LOAD_CASES
    from pysprings.studies.design import check_ending, check_run

    for file in files:
        check_ending(file)
        refuse_read("--out", file, result, *read)
    if in_report:
        check_run(result)
        refuse_read("--report", result / LOAD_CASES, *read)


def _checked(tilt: str | None, joint: str | None, group: Path | None) -> tuple[float | None, float | None]:
    """Return tolerated tilt [rad] and stiffness of a joint [N m/rad]; refuse what is not positive or has no group."""
    given = quantities({"--tilt": (tilt, "rad", "0.25 deg"), "--joint": (joint, "N m/rad", "2 GN m/rad")})
    for name, value in given.items():
        if value is not None and value <= 0.0:
            refuse(name, f"a {'tolerance' if name == '--tilt' else 'stiffness'} must be positive")
    if joint is not None and group is None:
        refuse("--joint", "is the stiffness between caissons and the frame of a --group, which is missing")
    return given["--tilt"], given["--joint"]


def _tolerance(table: pd.DataFrame) -> str:
    """Return the rotations that the cases tolerate, in words."""
    limits = sorted(set(table["tilt_limit_deg"].dropna()))
    return ", ".join(f"{limit:.4g} deg" for limit in limits) or "none given"


def _print(table: pd.DataFrame, written: list[str]) -> None:
    """Print the table of answers with its closing lines, and what was written."""
    from pysprings.results.report import load_cases as text

    print_table(text.table_of(table, brief=True))
    group = [table.attrs["group"]] if "group" in table.attrs else []
    notes = [f"note: {each}" for each in table.attrs.get("notes", ())]
    print("\n".join([f"\n{text.closing(table)}", *group, *notes, *written]))


def cases_of(result: Path) -> Path:
    """Return the table that the scene of a run names."""
    from pysprings.full_model.run_record import RunRecord
    from pysprings.scene.load import parse_scene

    record = RunRecord.read(next(iter(folders_of(result).values()), result))
    named = None if record is None else parse_scene(record.scene_toml).design.cases
    if named is None:
        refuse("CASES", "name a table of load cases: there is no run here whose scene has [design] cases", result)
    if not Path(named).exists():
        refuse("CASES", f"{named}, [design] cases of the run as seen from where it ran, is not there: name the table")
    return Path(named)


def _answers(
    result: Path, strict: bool, rate: float | None, answer: Callable[[AnySprings], pd.DataFrame]
) -> tuple[pd.DataFrame, pd.DataFrame, AnySprings | None]:
    """Return all answers, those that govern (of several estimates the largest over them), and the springs of one."""
    from pysprings.cli.inputs import springs_or_table
    from pysprings.full_model.run_record import RunRecord
    from pysprings.studies.design import governing

    sets = all_folders_of(result)
    opened = {name: springs_or_table(place, None, strict, rate) for name, place in (sets or {"": result}).items()}
    tables = {name: answer(springs) for name, springs in opened.items()}
    if not sets:
        return tables[""], tables[""], opened[""]
    every, largest = governing(tables)
    records = {name: RunRecord.read(place) for name, place in sets.items()}
    status = [f"{name} {record.status if record else 'without run.json'}" for name, record in records.items()]
    scenes = {name: record.remarks if record else [] for name, record in records.items()}
    own = {name: [*table.attrs.get("notes", ()), *scenes[name]] for name, table in tables.items()}
    notes = [f"estimates: {', '.join(status)}", *shared(own)]
    largest.attrs |= next(iter(tables.values())).attrs | {"notes": notes}
    return every, largest, None
