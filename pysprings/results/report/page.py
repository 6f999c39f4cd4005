# SPDX-License-Identifier: MIT
"""One self-contained report.html of a run: inputs, checks, figures, comparison, limits, cost.

The page needs nothing beside it (pictures are inside), runs no script, and prints. Every text that comes from
a scene or a file is escaped by the template engine.
"""

from __future__ import annotations

import base64
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from pysprings.full_model.run_record import RunRecord
from pysprings.results.axes import axes_svg
from pysprings.results.exporters.csv import read_comparison
from pysprings.results.layout import picture_kind, pictures_in
from pysprings.results.report.load_cases import read_answers
from pysprings.results.report.table import ReportData, Section, Table
from pysprings.results.report.tables import tables_of
from pysprings.results.report.validity import validity

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from jinja2 import Environment

MEDIA = {".png": "image/png", ".svg": "image/svg+xml"}


@dataclass(frozen=True)
class Picture:
    """A figure of the report: caption, the file's bytes as a data URI, whether it needs a page's height."""

    caption: str
    source: str
    tall: bool = False


@dataclass(frozen=True)
class PathPart:
    """The part of the report about one path."""

    name: str
    status: str
    tables: Sequence[Table]
    pictures: Sequence[Picture] = field(default_factory=tuple)


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
    result = read_tree(place / "full_model.nc") if result is None else result
    if springs is None and (place / "springs.nc").exists():
        springs = read_tree(place / "springs.nc")
    if compare is None and (place / "compare.csv").exists():
        compare = read_comparison(place / "compare.csv")
    run = RunRecord.read(place) if run is None else run
    files = [Path(file) for file in figures] if figures is not None else pictures_in(place)
    return write_text(render(result, springs, compare, run, files, read_answers(place)), place / "report.html")


def render(
    result: xr.DataTree,
    springs: xr.DataTree | None = None,
    compare: pd.DataFrame | None = None,
    run: RunRecord | None = None,
    figures: Sequence[Path] = (),
    cases: pd.DataFrame | None = None,
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
    """
    data = ReportData(result, springs, compare, run, cases)
    sections: tuple[Section, ...] = ("cases", "inputs", "limits", "mesh", "checks", "springs", "comparison", "cost")
    return (
        environment()
        .get_template("report.html.j2")
        .render(
            attrs={key: result.attrs.get(key, "") for key in ("title", "pysprings_version", "scene_sha256")},
            summary=(run.summary or {}) if run else {},
            status=str(run.status if run else result.attrs.get("status", "")),
            started=run.started_utc if run else "",
            failures=run.failures if run else [],
            limits=[f"{name}: {at}" for name, at in run.limit_loads.items()] if run else [],
            warnings=run.warnings if run else [],
            sketch=picture_uri(axes_svg().encode(), ".svg"),
            validity=validity(result, springs),
            tables={section: tables_of(section, data) for section in sections},
            mesh_pictures=_pictures(figures, ""),
            paths=[
                PathPart(
                    name, str(path.attrs.get("status", "")), tables_of("path", data, name), _pictures(figures, name)
                )
                for name, path in data.paths.items()
            ],
        )
    )


def environment() -> Environment:
    """Return the template engine of all reports: it escapes all text from outside, and undefined names are errors."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    return Environment(
        loader=PackageLoader("pysprings.results.report", "templates"), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip


def _pictures(files: Iterable[Path], path: str) -> list[Picture]:
    """Embed the pictures of a path (of the whole run: ``""``), once each; SVG if present."""
    best: dict[str, Path] = {}
    for file in files:
        if file.stem not in best or file.suffix == ".svg":
            best[file.stem] = file
    from pysprings.results.plots.pictures import PICTURES

    kinds = {stem: kind for stem in best if (kind := picture_kind(stem, path))}
    names = PICTURES.names()
    order = sorted(kinds, key=lambda stem: (names.index(kinds[stem][0]), kinds[stem][1] == "last"))
    return [
        Picture(
            _caption(PICTURES[kinds[stem][0]].caption, kinds[stem][1]),
            picture_uri(best[stem].read_bytes(), best[stem].suffix),
            PICTURES[kinds[stem][0]].tall,
        )
        for stem in order
    ]


def _caption(caption: str, state: str) -> str:
    if not state:
        return caption
    at = "at the last converged step" if state == "last" else f"at u = {state.replace('mm', ' mm')}"
    return f"{caption}, {at}"


def picture_uri(content: bytes, suffix: str) -> str:
    """Return a picture's bytes as a data URI."""
    return f"data:{MEDIA[suffix]};base64,{base64.b64encode(content).decode('ascii')}"
