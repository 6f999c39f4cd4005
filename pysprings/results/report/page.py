# SPDX-License-Identifier: MIT
"""One self-contained report.html of a run: inputs, checks, figures, comparison, limits, cost.

The page needs nothing beside it (pictures are inside) and prints. Curves can be read under the pointer where the
browser runs the page's scripts: the page holds one copy of plotly.js, compressed, which the browser unpacks. Where
plotly is not installed, scripts are off, or the page is printed, the pictures of matplotlib stand in the same places.
Every text that comes from a scene or a file is escaped by the template engine.
"""

import base64
import gzip
import hashlib
import json
import os
import re
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pandas as pd
import xarray as xr

from pysprings.core import version
from pysprings.core.arrays import Array
from pysprings.core.columns import Table
from pysprings.core.path_kinds import driven, height_of_load
from pysprings.core.registry import Registry
from pysprings.core.storage import read_tree, write_text
from pysprings.core.words import TILTS
from pysprings.full_model.run_record import RunRecord
from pysprings.macro.model import AnySprings
from pysprings.results.exporters.csv import read_comparison
from pysprings.results.layout import Drawn, open_result, picture_kind, pictures_in, stands_for
from pysprings.results.parts import converged
from pysprings.results.report import inputs, load_cases, validity
from pysprings.results.report.inputs import ReportData, ReportTable, Section
from pysprings.springs.path import paths_of
from pysprings.springs.path_ends import before_cavitation
from pysprings.springs.sums import by_depth
from pysprings.springs.tip_zone import edge_rings

TEMPLATES = files("pysprings.results.report").joinpath("templates")
MOST_STEPS = 25  # of a path that the sliders show
MOST_PATHS = 24
MOST_DEPTHS = 4  # of the contact stresses
_DIGITS = 4
_SCALES = {"u": 1e3, "w": 1e3, "rotation": 180.0 / np.pi, "H": 1e-6, "V": 1e-6, "M": 1e-6}


@dataclass(frozen=True)
class Live:
    """Texts of the interactive parts: data and script of the page, plotly.js (gzip, base64), the sources allowed."""

    data: str
    script: str
    library: str
    sources: str


def live_parts(result: xr.DataTree) -> Live | None:
    """Return the interactive parts of the report of a result; None without plotly or without a path to draw."""
    library = _library()
    first = [*paths_of(result).items()][:MOST_PATHS]
    paths = [_path(name, before_cavitation(path.recorded)) for name, path in first]
    drawn = [path for path in paths if len(path["u"]) > 1]
    if library is None or not drawn:
        return None
    size = {key: float(result.attrs.get(f"{key}_m", np.nan)) for key in ("outer_diameter", "skirt_length")}
    known = {key: value for key, value in size.items() if np.isfinite(value)}
    data = json.dumps({"size": known, "limits": TILTS, "paths": drawn}, separators=(",", ":"), allow_nan=False)
    script = TEMPLATES.joinpath("report.js").read_text(encoding="utf-8")
    packed, digest = library
    own = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    return Live(data.replace("<", "\\u003c"), script, packed, f"'sha256-{own}' 'sha256-{digest}'")


@lru_cache(maxsize=1)
def _library() -> tuple[str, str] | None:
    """Return plotly.js as text of the page, and its SHA-256 in base64; None where plotly is not installed."""
    found = find_spec("plotly")
    if found is None or not found.submodule_search_locations:
        return None
    file = Path(found.submodule_search_locations[0]) / "package_data" / "plotly.min.js"
    if not file.exists():
        return None
    content = file.read_text(encoding="utf-8").encode()
    digest = base64.b64encode(hashlib.sha256(content).digest()).decode()
    return base64.b64encode(gzip.compress(content, 6, mtime=0)).decode("ascii"), digest


def _path(name: str, path: xr.Dataset) -> dict[str, Any]:
    """Return the converged states of one path for the page, at most `MOST_STEPS` of them."""
    good = np.flatnonzero(converged(path))
    steps = np.unique(np.linspace(0, good.size - 1, min(good.size, MOST_STEPS)).astype(int)) if good.size else good
    chosen = path.isel(step=good[steps])
    height = height_of_load(path.attrs)
    data: dict[str, Any] = {
        "name": name,
        "role": str(path.attrs.get("role", "")),
        "vertical": driven(path.attrs) == "w",
    }
    data |= {} if height is None else {"arm": height}
    data |= {key: _round(factor * chosen[key].values) for key, factor in _SCALES.items()}
    if chosen.sizes["step"]:
        data |= {"depth": _round(path["depth"].values), "edge": edge_rings(path).tolist()}
        data |= {"y": _round(1e3 * chosen["y"].transpose("step", "depth").values)}
        data |= {key: _round(1e-3 * by_depth(chosen, key).T) for key in ("p", "m", "t")}
        data |= _stress(chosen)
    return data


def _stress(path: xr.Dataset) -> Mapping[str, Any]:
    """Return p'_N [kPa] by side, step, depth and azimuth [deg], at some depths; empty where it was not kept."""
    if "normal_effective_stress" not in path or driven(path.attrs) == "w":
        return {}
    n = path.sizes["depth"]
    rings = np.unique(np.linspace(0, n - 1, min(n, MOST_DEPTHS)).astype(int))
    order = np.argsort(path["azimuth"].values)
    field = path["normal_effective_stress"].isel(depth=rings, azimuth=order)
    field = field.transpose("side", "step", "depth", "azimuth")
    stress = {str(side): _round(1e-3 * field.values[k], 3) for k, side in enumerate(field["side"].values)}
    azimuth = np.degrees(path["azimuth"].values[order])
    return {"stress": stress, "azimuth": _round(azimuth), "rings": _round(path["depth"].values[rings])}


def _round(values: Array, digits: int = _DIGITS) -> Any:
    """Return numbers as nested lists with this many digits; rounding errors beside the largest become 0."""
    values = np.nan_to_num(np.asarray(values, dtype=float))
    least = 1e-9 * float(np.abs(values).max(initial=0.0))
    short = np.vectorize(lambda value: float(f"{value:.{digits}g}"), otypes=[float])
    return short(np.where(np.abs(values) > least, values, 0.0)).tolist()


# parts of the page that hold tables, and pictures that have an interactive twin there
SECTIONS: tuple[Section, ...] = (
    "cases", "springs", "capacity", "tilt", "comparison", "inputs", "limits", "mesh", "checks", "cost",
)  # fmt: skip
TWINS = ("py", "profiles", "overview", "tilt", "stress_outside")
Paths = Mapping[str, Mapping[Any, Any]]
MEDIA = {".png": "image/png", ".svg": "image/svg+xml"}


@dataclass(frozen=True)
class Picture:
    """A figure of the report: caption, bytes as a data URI, interactive twin or not."""

    caption: str
    source: str
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
    place = Path(folder)
    result = open_result(place) if result is None else result
    if springs is None and (place / "springs.nc").exists():
        springs = read_tree(place / "springs.nc")
    if compare is None and (place / "compare.csv").exists():
        compare = read_comparison(place / "compare.csv")
    run = RunRecord.read(place) if run is None else run
    files = [Path(file) for file in figures] if figures is not None else pictures_in(place)
    data = ReportData(result, springs, compare, run, load_cases.read_answers(place))
    return write_text(render(data, files, live_parts(result)), place / "report.html")


def render(data: ReportData, figures: Sequence[Path] = (), live: Live | None = None) -> str:
    """Return the report as HTML text.

    figures : Picture files, named as `pysprings.results.plots.save_all` names them.
    live : Interactive parts; None for a page without scripts.
    """
    result, run = data.result, data.run
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
        validity=validity.validity(result),
        tables={section: tables_of(section, data) for section in SECTIONS},
        pictures_of=pictures_by_part(figures, kinds, live is not None),
        cases_drawn=[] if data.cases is None or data.springs is None else picture_of_cases(data.cases, data.springs),
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
    engine.filters["marked"] = marked
    sketch = picture_uri(TEMPLATES.joinpath("axes.svg").read_bytes(), ".svg")
    return engine.get_template(template).render(version=version.__version__, sketch=sketch, **values)


def marked(text: object) -> str:
    """Return a text as markup, escaped, whose words between backticks are code."""
    from markupsafe import Markup, escape

    return Markup(re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(text))))


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
            picture_uri(file.read_bytes(), file.suffix), live and kind.name in TWINS,
        )  # fmt: skip
        parts.setdefault(kind.section, []).append(shown)
    return parts


def picture_of_cases(cases: pd.DataFrame, springs: AnySprings | None) -> list[Picture]:
    """Return the picture of answers to load cases over V; none of springs without V."""
    if cases["V_N"].isna().all():
        return []
    from pysprings.results.plots.files import content_of
    from pysprings.results.plots.load_cases import load_cases

    caption = "Load cases over V, and the largest load known in the direction of each"
    return [Picture(caption, picture_uri(content_of(load_cases(cases, springs)), ".png"))]


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
        ReportTable(
            "load_cases", "cases", lambda data: [] if data.cases is None else [load_cases.table_of(data.cases)]
        ),
        ReportTable("stiffness", "springs", lambda data: [load_cases.stiffness_table(data.result)]),
        ReportTable("springs", "springs", lambda data: load_cases.spring_tables(data.springs, data.comparison)),
        ReportTable("end", "capacity", lambda data: [validity.end_table(data.paths)]),
        ReportTable("tilt", "tilt", lambda data: [validity.tilt_table(data.paths)]),
        ReportTable("comparison", "comparison", lambda data: [validity.compare_table(data.comparison)]),
        ReportTable(
            "inputs", "inputs", lambda data: inputs.used_tables(str(data.result.attrs.get("scene_toml", "")), False)
        ),
        ReportTable("defaults", "inputs", lambda data: [inputs.defaults_table(data.run)]),
        ReportTable("omissions", "limits", lambda data: [inputs.omission_table(data.run.left_out if data.run else [])]),
        ReportTable(
            "settings", "mesh", lambda data: inputs.used_tables(str(data.result.attrs.get("scene_toml", "")), True)
        ),
        ReportTable(
            "mesh", "mesh", lambda data: [inputs.mesh_table(data.result.attrs, data.run.mesh if data.run else None)]
        ),
        ReportTable("convergence", "checks", lambda data: [validity.convergence_table(data.figures)]),
        ReportTable("cut-backs", "checks", lambda data: [validity.cut_back_table(data.figures)]),
        ReportTable(
            "equilibrium",
            "checks",
            lambda data: [validity.equilibrium_table(data.result if data.springs is None else data.springs)],
        ),
        ReportTable("rings", "checks", lambda data: [validity.ring_table(data.figures)]),
        ReportTable("water", "checks", lambda data: [validity.water_table(data.figures)]),
        ReportTable("energy", "checks", lambda data: [validity.energy_table(data.figures)]),
        ReportTable("estimate", "checks", lambda data: [validity.estimate_table(data.run)]),
        ReportTable("gaps", "checks", lambda data: [validity.opening_table(data.paths)]),
        ReportTable("cost", "cost", lambda data: validity.cost_tables(data.run)),
    ),
)


def tables_of(section: Section, data: ReportData, path: str = "") -> list[Table]:
    """Return the tables of one section of the report, for the section "path" those of a path."""
    own = replace(data, path=path)
    return [
        table for each in REPORT_TABLES if each.section == section for table in each.build(own) if table is not None
    ]
