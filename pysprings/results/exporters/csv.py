# SPDX-License-Identifier: MIT
"""Springs as files of data, in SI: CSV tables (one header line, no comment lines), one JSON document, NetCDF."""

import os
import re
from pathlib import Path
from typing import Any

import pandas as pd
import xarray as xr

from pysprings.core.storage import write_text
from pysprings.core.text import json_text
from pysprings.macro.spring_sets import with_stored
from pysprings.results.exporters.base import Exported, Options, Source, Target
from pysprings.results.exporters.tables import py_long, py_wide
from pysprings.springs.checks import save_springs
from pysprings.springs.path import paths_of

# Ten digits: below the accuracy of the model, and short enough to read.
_NUMBER = "%.10g"
_COUNT = re.compile(r"^states|^depths|_states$")  # columns of a comparison that hold counts


def py_text(source: Source, _options: Options) -> str:
    """Return the long p-y table as CSV text."""
    return csv_text(py_long(source.tables))


def wide_text(source: Source, _options: Options) -> str:
    """Return the wide p-y table (rows are steps, a pair of columns y, p for each slice) as CSV text."""
    return csv_text(py_wide(source.tables))


def write_frame(frame: pd.DataFrame, path: str | os.PathLike[str]) -> Path:
    """Write any table, such as the comparison with the full model; return the path."""
    return write_text(csv_text(frame), path)


def read_comparison(path: str | os.PathLike[str]) -> pd.DataFrame:
    """Return a comparison as `compare.csv` holds it, with ten digits; types are those of `compare`."""
    texts = dict.fromkeys(("path", "role", "kind", "springs", "springs_from", "status"), str)
    frame = pd.read_csv(path, dtype=texts, keep_default_na=False, na_values=[""])
    whole = [name for name in frame.select_dtypes("integer") if not _COUNT.search(str(name))]  # 2.0 is written as 2
    return frame.astype(dict.fromkeys(whole, float))


def csv_text(frame: pd.DataFrame) -> str:
    """Return a table as CSV text, -0 as 0."""
    numbers = frame.select_dtypes("float").columns
    frame = frame.assign(**{str(name): frame[name] + 0.0 for name in numbers})
    return frame.to_csv(index=False, float_format=_NUMBER, lineterminator="\n")


def springs_text(source: Source, _options: Options) -> str:
    """Return the spring set as strict JSON text (SI)."""
    springs = with_stored(source.springs)
    stiffness = springs.dataset["stiffness_initial"]
    rows = {"dofs": stiffness["dof"].values, "comment": stiffness.attrs.get("comment", "")}  # its unit is none
    document = {
        "attributes": {str(name): value for name, value in springs.attrs.items()},
        "stiffness_initial": _variable(stiffness) | rows,
        "paths": {name: _group(path.recorded) for name, path in paths_of(springs).items()},
    }
    for name, node in springs.children.items():  # paths out of one plane, elements that remember, spread of an atlas
        within = {each: _group(child.to_dataset(inherit=False)) for each, child in node.children.items()}
        document.setdefault(name, within or _group(node.to_dataset(inherit=False)))
    return json_text(document) + "\n"


def _group(path: xr.Dataset) -> dict[str, Any]:
    return {
        "attributes": {str(name): value for name, value in path.attrs.items()},
        "coordinates": {str(name): _variable(data) for name, data in path.coords.items()},
        "variables": {str(name): _variable(data) for name, data in path.data_vars.items()},
    }


def _variable(data: xr.DataArray) -> dict[str, Any]:
    return {"dims": [str(name) for name in data.dims], "units": data.attrs.get("units", "1"), "values": data.values}


def write_netcdf(source: Source, target: Target, _options: Options) -> Exported:
    """Write the springs as `springs.nc`."""
    return Exported([save_springs(with_stored(source.springs), target.path)])
