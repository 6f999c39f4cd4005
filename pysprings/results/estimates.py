# SPDX-License-Identifier: MIT
"""Runs of the low, best and high estimate of a scene beside each other: tables, workbook, pictures and page."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pysprings.core.arrays import Array
from pysprings.core.columns import Table
from pysprings.core.path_kinds import kind_of
from pysprings.core.storage import replacing, write_text
from pysprings.core.text import number
from pysprings.core.words import ESTIMATES, OF_ESTIMATE
from pysprings.full_model.run_record import RunRecord
from pysprings.results.exporters.csv import write_frame
from pysprings.results.layout import FIGURES
from pysprings.results.two_runs import LOAD_UNITS, Run, common_paths, curve, farthest, growing, in_words, moved
from pysprings.scene.soils.cyclic import titled
from pysprings.springs.path import paths_of
from pysprings.springs.tip_zone import on_slices, tip_zone

Paths = Mapping[str, Mapping[str, xr.Dataset]]  # by name of the path, and by estimate
SHARES = (0.1, 0.3, 1.0)  # of the motion that all runs reach, where loads are compared
TABLES = ("load_displacement.csv", "py.csv")  # of each run, which become one with a column more
POINTS, LEAST = 12, 1.0e-6  # points of a p-y curve side by side, and its least range [m]: vertical paths have none
_STIFFNESS = (("K_H [MN/m]", 0, 0), ("K_V [MN/m]", 1, 1), ("K_M [MN m/rad]", 2, 2))


def write_together(folder: Path, runs: Mapping[str, Run]) -> tuple[list[Path], pd.DataFrame]:
    """Write what shows the runs of estimates beside each other into their common folder.

    Returns the files, and the table of stiffness and loads at equal motion.

    estimates.csv has stiffness and loads at equal motion, py_side_by_side.csv p-y curves at equal y, both in
    springs.xlsx; the tables of the runs are joined with a first column `estimate`.
    """
    common = dict(_common(runs))
    loads, py = pd.DataFrame(_loads(runs, common)), pd.DataFrame(_py(runs, common))
    files = [write_frame(loads, folder / "estimates.csv"), write_frame(py, folder / "py_side_by_side.csv")]
    files += [_joined(folder, name, runs) for name in TABLES]
    book = folder / "springs.xlsx"
    with replacing(book) as temporary, pd.ExcelWriter(temporary, engine="xlsxwriter") as writer:
        loads.to_excel(writer, sheet_name="loads", index=False)
        py.to_excel(writer, sheet_name="p-y", index=False)
    return [*files, book, *_page(folder, runs, common, loads)], loads


def table_of(loads: pd.DataFrame) -> Table:
    """Return stiffness and loads at equal motion for people."""
    names = [each for each in ESTIMATES if each in loads]
    cells = [
        [str(row["part"]), str(row["quantity"]), *(number(row[each]) for each in names)]
        for row in loads.to_dict("records")
    ]
    return Table("", ("", "quantity", *names), cells, left=(True, True))


def _loads(runs: Mapping[str, Run], common: Paths) -> Iterator[dict[str, Any]]:
    """Yield initial stiffnesses, and the load of each common path at shares of the motion that all reach."""
    for quantity, i, j in _STIFFNESS:
        values = {
            name: 1e-6 * float(run.result.dataset["stiffness_initial"].values[i, j]) for name, run in runs.items()
        }
        yield {"part": "initial stiffness", "quantity": quantity, **values}
    result = next(iter(runs.values())).result
    under = {name: path.under(str(result.attrs.get("drainage", ""))) for name, path in paths_of(result).items()}
    several = len({under[name] for name in common}) > 1
    for name, paths in common.items():
        rules = kind_of(next(iter(paths.values())).attrs)
        unit, factor = LOAD_UNITS[rules.load]
        end = min(float(moved(path[rules.drives].values)[-1]) for path in paths.values())
        sign = np.sign(farthest(next(iter(paths.values()))[rules.drives].values))
        for at in (share * end for share in SHARES):
            motion = in_words(sign * at, rules.drives)
            values = {
                each: factor * _between(at, *curve(path, rules.drives, rules.load)) for each, path in paths.items()
            }
            part = f"path {name}" + f", {under[name]}" * several
            yield {"part": part, "quantity": f"{rules.load} [{unit}] at {rules.drives} {motion}", **values}


def _py(runs: Mapping[str, Run], common: Paths) -> Iterator[dict[str, Any]]:
    """Yield p of each run at equal y, by path and slice of `tip_zone`, up to the y that all reach on one side.

    Each row has V [N] at the start of its path in each run, and where water flows the rate of the path [m/s].
    """
    own = {each: paths_of(run.result) for each, run in runs.items()}
    coupled = "coupled" in str(next(iter(runs.values())).result.attrs.get("drainage", "")).split(", ")
    for name, paths in common.items():
        under: dict[str, float | None] = {f"V_{each}_N": own[each][name].load for each in paths}
        under |= {"rate_m_per_s": next(iter(own.values()))[name].rate} if coupled else {}
        edges = tip_zone(next(iter(paths.values())))
        sliced = {each: on_slices(path, edges) for each, path in paths.items()}
        for k, depth in enumerate(next(iter(sliced.values()))["depth"].values):
            curves = {
                each: [path[key].transpose("depth", "step").values[k] for key in ("y", "p")]
                for each, path in sliced.items()
            }
            ends = {side: min(float(moved(y, side)[-1]) for y, _ in curves.values()) for side in (1.0, -1.0)}
            side = max(ends, key=lambda side: ends[side])
            for y in np.linspace(0.0, ends[side], POINTS) if ends[side] > LEAST else ():
                values = {
                    f"p_{each}_N_per_m": _between(y, *growing(moved(x, side), p)) for each, (x, p) in curves.items()
                }
                yield {"path": name, **under, "depth_m": float(depth), "y_m": side * float(y) + 0.0, **values}


def _between(at: float, x: Array, values: Array) -> float:
    """Return the monotone cubic through values at x at a place within their range (rounding beyond it is cut)."""
    from scipy.interpolate import PchipInterpolator  # 0.3 s, which `predict` has no use for

    return float(PchipInterpolator(x, values)(min(at, x[-1])))


def _common(runs: Mapping[str, Run]) -> Iterator[tuple[str, dict[str, xr.Dataset]]]:
    """Yield the paths in one plane that all runs have."""
    first, *others = runs.values()
    paths = {each: paths_of(run.result) for each, run in runs.items()}
    names = [set(common_paths(first, other)) for other in others]
    for name, path in paths_of(first.result).items():
        if not kind_of(path.dataset.attrs).space and all(name in each for each in names):
            yield name, {each: own[name].dataset for each, own in paths.items()}


def _joined(folder: Path, table: str, runs: Mapping[str, Run]) -> Path:
    """Write a table of all runs with a first column `estimate`."""
    lines: list[str] = []
    for name in runs:
        head, *rows = (folder / name / table).read_text(encoding="utf-8").splitlines()
        lines += [f"estimate,{head}"] * (not lines) + [f"{name},{row}" for row in rows]
    return write_text("\n".join(lines) + "\n", folder / table)


def _status(record: RunRecord) -> str:
    """Return how a run ended, the error of its mesh, which its loads have, and remarks on its scene."""
    words = {"mesh error": (record.summary or {}).get("mesh error"), "remarks": "; ".join(record.remarks)}
    return "; ".join([str(record.status), *(f"{key}: {text}" for key, text in words.items() if text)])


def _page(folder: Path, runs: Mapping[str, Run], common: Paths, loads: pd.DataFrame) -> list[Path]:
    """Draw each path of all runs over each other, and write the page with these pictures and the table."""
    from pysprings.results.plots.comparison import overlay
    from pysprings.results.plots.files import save
    from pysprings.results.report.page import Picture, page_html, picture_uri

    (folder / FIGURES).mkdir(exist_ok=True)
    files = [file for name, paths in common.items() for file in save(overlay(paths, name), folder / FIGURES / name)]
    pictures = [Picture(f"path {file.stem}", picture_uri(file.read_bytes(), file.suffix)) for file in files]
    titles = {str(run.result.attrs["title"]).replace(f" {OF_ESTIMATE.format(name)}", "") for name, run in runs.items()}
    title = next(iter(titles)) if len(titles) == 1 else titled(next(iter(titles)), ())  # of cycles of each
    status = {name: _status(run.record) for name, run in runs.items()}
    page = page_html("estimates.html.j2", title=title, status=status, loads=table_of(loads), pictures=pictures)
    return [write_text(page, folder / "report.html"), *files]
