# SPDX-License-Identifier: MIT
"""One self-contained report.html of a run: inputs, checks, figures, comparison, limits, cost.

The page needs nothing beside it (pictures are inside) and prints. Curves can be read under the pointer where the
browser runs the page's scripts (`pysprings.results.report.live`); in print and without them pictures stand in their
places. Every text that comes from a scene or a file is escaped by the template engine.
"""

from __future__ import annotations

import base64
import os
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from pysprings.core import version
from pysprings.core.columns import Table
from pysprings.core.registry import Registry
from pysprings.full_model.run_record import RunRecord
from pysprings.results.axes import axes_svg
from pysprings.results.exporters.csv import read_comparison
from pysprings.results.layout import Drawn, picture_kind, pictures_in, stands_for
from pysprings.results.opened import open_result
from pysprings.results.report import inputs, load_cases, solution, validity
from pysprings.results.report.inputs import ReportData, ReportTable, Section
from pysprings.results.report.live import Live, live_parts
from pysprings.results.report.load_cases import read_answers

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

# parts of the page that hold tables, and pictures that have an interactive twin there
SECTIONS: tuple[Section, ...] = (
    "cases", "springs", "capacity", "tilt", "comparison", "inputs", "limits", "mesh", "checks", "cost",
)  # fmt: skip
TWINS = ("py", "profiles", "overview", "tilt", "stress_outside")
Paths = Mapping[str, Mapping[Any, Any]]
MEDIA = {".png": "image/png", ".svg": "image/svg+xml"}


@dataclass(frozen=True)
class Picture:
    """A figure of the report: caption, bytes as a data URI, page's height or not, interactive twin or not."""

    caption: str
    source: str
    tall: bool = False
    twin: bool = False


@dataclass(frozen=True)
class PathPart:
    """The tables of the report about one path."""

    name: str
    status: str
    tables: Sequence[Table]


def write_report(
    folder: str | os.PathLike[str],
    result: xr.DataTree | None = None,
    springs: xr.DataTree | None = None,
    compare: pd.DataFrame | None = None,
    run: RunRecord | None = None,
    figures: Sequence[str | os.PathLike[str]] | None = None,
) -> Path:
    """Write ``report.html`` into the folder of a run, whole or not at all; return its path.

    Whatever is not given is read from the folder: full_model.nc, springs.nc, compare.csv, run.json, design.csv
    (answers to load cases) and the pictures in its subfolder ``figures``. Only the result is needed.
    """
    from pysprings.core.files.storage import read_tree, write_text

    place = Path(folder)
    result = open_result(place) if result is None else result
    if springs is None and (place / "springs.nc").exists():
        springs = read_tree(place / "springs.nc")
    if compare is None and (place / "compare.csv").exists():
        compare = read_comparison(place / "compare.csv")
    run = RunRecord.read(place) if run is None else run
    files = [Path(file) for file in figures] if figures is not None else pictures_in(place)
    cases, live = read_answers(place), live_parts(result)
    return write_text(render(result, springs, compare, run, files, cases, live), place / "report.html")


def render(
    result: xr.DataTree,
    springs: xr.DataTree | None = None,
    compare: pd.DataFrame | None = None,
    run: RunRecord | None = None,
    figures: Sequence[Path] = (),
    cases: pd.DataFrame | None = None,
    live: Live | None = None,
) -> str:
    """Return the report as HTML text.

    Parameters
    ----------
    result
        Full model.
    springs
        Spring set; the equilibrium check is made on it, else on the result.
    compare
        Table of `pysprings.macro.comparison.compare`, one row per path and spring set.
    run
        Record of the run: cost by phase, what was left out.
    figures
        Picture files, named as `pysprings.results.plots.save_all` names them.
    cases
        Answers to load cases (`pysprings design`), in SI.
    live
        Interactive parts; None for a page without scripts.
    """
    data = ReportData(result, springs, compare, run, cases)
    kinds = {name: path.attrs for name, path in data.paths.items()}
    return page_html(
        "report.html.j2",
        attrs={key: result.attrs.get(key, "") for key in ("title", "pysprings_version", "scene_sha256")},
        summary=(run.summary or {}) if run else {},
        status=str(run.status if run else result.attrs.get("status", "")),
        started=run.started_utc if run else "",
        failures=run.failures if run else [],
        limits=[f"{name}: {at}" for name, at in run.limit_loads.items()] if run else [],
        warnings=run.warnings if run else [],
        validity=validity.validity(result, springs),
        tables={section: tables_of(section, data) for section in SECTIONS},
        pictures_of=pictures_by_part(figures, kinds, live is not None),
        live=live,
        paths=[
            PathPart(name, str(path.attrs.get("status", "")), tables_of("path", data, name))
            for name, path in data.paths.items()
        ],
    )


def page_html(template: str, folder: Path | None = None, **values: Any) -> str:
    """Return a page from a template of this folder, or of another one; all have the version and a sketch of the axes.

    All text from outside is escaped, and undefined names are errors.
    """
    from jinja2 import ChoiceLoader, Environment, FileSystemLoader, PackageLoader, StrictUndefined

    places = [PackageLoader("pysprings.results.report", "templates"), *([FileSystemLoader(folder)] if folder else [])]
    engine = Environment(
        loader=ChoiceLoader(places), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    sketch = picture_uri(axes_svg().encode(), ".svg")
    return engine.get_template(template).render(version=version.__version__, sketch=sketch, **values)


def pictures_by_part(files: Iterable[Path], paths: Paths, live: bool = False) -> dict[str, list[Picture]]:
    """Embed the pictures of each part of the report: those of the run, and of one path that stands for the others.

    `paths` has the attributes of each path by its name. Of several states of a path the last is shown. SVG is taken
    where there is one. Pictures without a part stay in their folder.
    """
    best: dict[str, Path] = {}
    for file in files:
        if file.stem not in best or file.suffix == ".svg":
            best[file.stem] = file
    if not best:  # matplotlib, 0.5 s, is left out
        return defaultdict(list)
    from pysprings.results.plots.draw import PICTURES
    from pysprings.results.plots.picture import Part

    known = [
        Drawn(found[0], path, found[1]) for path in ("", *paths) for stem in best if (found := picture_kind(stem, path))
    ]
    parts: dict[str, list[Picture]] = {name: [] for name in get_args(Part) if name}
    for kind in PICTURES:
        drawn = stands_for(kind.name, known, paths)
        if not kind.section or drawn is None:
            continue
        of = f", path {drawn.path}" if drawn.path else ""
        file = best[drawn.stem]
        shown = Picture(
            _caption(kind.caption, drawn.state) + of,
            picture_uri(file.read_bytes(), file.suffix), kind.tall, live and kind.name in TWINS,
        )  # fmt: skip
        parts.setdefault(kind.section, []).append(shown)
    return parts


def _caption(caption: str, state: str) -> str:
    if not state:
        return caption
    at = "at the last converged step" if state == "last" else f"at u = {state.replace('mm', ' mm')}"
    return f"{caption}, {at}"


def picture_uri(content: bytes, suffix: str) -> str:
    """Return a picture's bytes as a data URI."""
    return f"data:{MEDIA[suffix]};base64,{base64.b64encode(content).decode('ascii')}"


REPORT_TABLES: Registry[ReportTable] = Registry(
    "report table",
    (
        load_cases.CASES,
        load_cases.STIFFNESS,
        load_cases.SPRINGS,
        solution.END,
        solution.TILT,
        validity.COMPARISON,
        inputs.INPUTS,
        inputs.DEFAULTS,
        inputs.OMISSIONS,
        inputs.SETTINGS,
        inputs.MESH,
        solution.CONVERGENCE,
        solution.CUT_BACKS,
        validity.EQUILIBRIUM,
        solution.RINGS,
        validity.WATER,
        validity.ENERGY,
        validity.ESTIMATE,
        solution.GAPS,
        validity.COST,
    ),
    group="pysprings.report_tables",
)


def tables_of(section: Section, data: ReportData, path: str = "") -> list[Table]:
    """Return the tables of one section of the report, for the section "path" those of a path."""
    own = replace(data, path=path)
    return [
        table for each in REPORT_TABLES if each.section == section for table in each.build(own) if table is not None
    ]
