# SPDX-License-Identifier: MIT
"""The output of `pysprings run`: where results are, how the paths went, cost, comparison."""

import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

from pysprings.cli.inputs import read_springs
from pysprings.cli.support import print_table, refuse
from pysprings.core.columns import Table
from pysprings.core.errors import printable
from pysprings.core.text import number, percent
from pysprings.core.written import WRITING, listed
from pysprings.full_model.run_record import FILE, RunRecord
from pysprings.results.layout import FIGURES, run_files

STATUS_WORDS = {WRITING: "stopped while its files were written"}  # a status that needs more words


def results(folder: Path) -> dict[str, Any]:
    """Return the document that `pysprings run --json` prints: run.json, the files and the comparison."""
    from pysprings.macro.comparison_text import to_dict

    record = read_record(folder)
    files = sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())
    comparison = to_dict(_comparison(folder, record)) if _has_springs(folder, record) else None
    return {"folder": str(folder), "files": files, "run": record.as_dict(), "compare": comparison}


def read_record(folder: Path) -> RunRecord:
    """Return the record of a folder; end the program where it has none."""
    record = RunRecord.read(folder)
    return refuse(None, f"{FILE} is missing or broken", folder) if record is None else record


def _has_springs(folder: Path, record: RunRecord) -> bool:
    """Return whether this run, not an earlier one in the same folder, has written springs."""
    return record.balance is not None and (folder / "springs.nc").exists()


def print_results(folder: Path, verbose: bool = False) -> None:
    """Print where the results of a run are, limit loads, warnings, the comparison and the cost in a line.

    Without verbose the comparison has the springs that predict, on the paths held back. verbose: every picture, spring
    set and path, iterations, attempts given up, contact, balances of water and energy, and the cost by phase. The paths
    of a run that stopped are shown always.
    """
    from pysprings.macro.comparison_text import to_brief_text, to_text

    record = read_record(folder)
    print(f"results in {folder} ({STATUS_WORDS.get(record.status, record.status)})")
    rows = [(str(folder / name), text) for name, text in run_files().items() if (folder / name).exists()]
    pictures = _pictures(folder)
    rows += pictures if verbose or not pictures else [(str(folder / FIGURES), f"pictures: {len(pictures)}")]
    width = max((len(name) for name, _ in rows), default=0)
    for name, text in rows:
        print(f"  {name.ljust(width)}  {text}")
    for name, limit in record.limit_loads.items():
        print(f"limit load of path {name}: {limit}")
    for text in record.warnings:
        print(printable(f"warning: {text}"))
    if record.not_made:
        print(printable(record.left_to_make))
    if verbose or not record.complete:
        print_paths(record)
    if verbose:
        print_balances(record)
    print_cost(record)
    print_estimate(record)
    if _has_springs(folder, record):
        print("\nprediction with the springs against the full model:")
        table = _comparison(folder, record)
        print(to_text(table) if verbose else to_brief_text(table), end="")
        if not verbose:
            print(f"`pysprings compare {shlex.quote(str(folder))}`: all spring sets and paths")
    print_summary(record)


def print_summary(record: RunRecord) -> None:
    """Print the run in ten lines."""
    if record.summary:
        width = max(map(len, record.summary))
        print("\nsummary")
        for name, text in record.summary.items():
            print(printable(f"  {name.ljust(width)}  {text}"))


def _comparison(folder: Path, record: RunRecord) -> pd.DataFrame:
    """Return the comparison that a run has written; compute it where the file was removed."""
    if not (folder / "compare.csv").exists():
        from pysprings.macro.comparison import compare

        return compare(read_springs(folder))
    import tomllib

    from pysprings.results.exporters.csv import read_comparison

    frame = read_comparison(folder / "compare.csv")
    title = tomllib.loads(record.scene_toml).get("title", "")
    frame.attrs = {"title": title, "pysprings_version": record.version, "scene_sha256": record.scene_sha256}
    return frame


def _pictures(folder: Path) -> list[tuple[str, str]]:
    """Return the pictures that the run of a folder has listed, one line for the formats of each."""
    by_stem: dict[Path, list[str]] = {}
    for path in listed(folder, (FIGURES,)):
        if path.suffix in (".png", ".svg") and path.exists():
            by_stem.setdefault(path.with_suffix(""), []).append(path.suffix.lstrip("."))
    return [(str(stem), f"picture ({', '.join(formats)})") for stem, formats in by_stem.items()]


MOST_LINES = 12  # attempts that were given up


def print_paths(record: RunRecord) -> None:
    """Print iterations, attempts given up and the contact around the rings by path, as the report has them."""
    from pysprings.results.report.validity import convergence_table, cut_back_table, ring_table

    lost = cut_back_table(record.paths)
    if lost is not None and len(lost.rows) > MOST_LINES:
        lost = replace(
            lost, rows=lost.rows[:MOST_LINES], note=f"... and {len(lost.rows) - MOST_LINES} more in run.json"
        )
    _print_tables(convergence_table(record.paths), lost, ring_table(record.paths))


def print_balances(record: RunRecord) -> None:
    """Print the balances of water and energy at the end of each path, and the cost by phase, as the report has them."""
    from pysprings.results.report.validity import energy_table, phase_table, water_table

    phases = phase_table(record) if record.phases else None
    _print_tables(water_table(record.paths), energy_table(record.paths), phases)


def _print_tables(*tables: Table | None) -> None:
    for table in filter(None, tables):
        print(f"\n{table.title}:")
        print_table(table)
        if table.note:
            print(table.note)


def print_cost(record: RunRecord) -> None:
    """Print time, unknowns, factorisations, iterations and peak memory."""
    if not record.phases:
        return
    times = {"wall": record.wall_s, "CPU": record.cpu_s}  # 0: not recorded
    print("\n" + "".join(f"{value:.2f} s {name}, " for name, value in times.items() if value), end="")
    solver, mesh = record.solver, record.mesh
    spent = sum(path.iterations + path.iterations_in_cut_backs for path in record.paths.values())
    print(f"{number(mesh.nodes)} nodes, {number(mesh.unknowns)} unknowns; ", end="")
    print(f"{number(spent)} Newton iterations, those in cut-backs included; ", end="")
    print(f"{number(solver.factorisations)} factorisations ({solver.linear}); ", end="")
    print(f"peak memory {number(record.peak_memory_bytes / 1e6)} MB")
    if saved := record.checkpoints:
        share = 100.0 * saved.share_of_wall
        print(f"checkpoints: {saved.written} of paths, {saved.wall_s:.2f} s, {share:.1f} % of the time of the paths")
    for part in record.resumed:
        print(f"resumed {part['at_utc']} from {part['from']}")


def print_estimate(record: RunRecord) -> None:
    """Print the runs to a target error, and the error estimate of the run."""
    if noted := record.target_error:
        from pysprings.full_model.accuracy.target import JUDGED

        for run in noted["runs"]:
            found = ", ".join(f"{words} {percent(run[name])}" for name, words in JUDGED.items() if name in run)
            print(f"target error {noted['target']}: {run['preset']}, refinement {run['refinement']:g}: {found or '-'}")
        if missed := noted.get("missed"):
            print(printable(missed))
    if estimate := record.error_estimate:
        from pysprings.full_model.accuracy.two_mesh import words

        print(words(estimate))
