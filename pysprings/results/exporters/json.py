# SPDX-License-Identifier: MIT
"""The spring set as one JSON document: attributes, units, nested lists by path; missing numbers null."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pysprings.results.exporters.base import Exporter, Options, Source, write_text_file

if TYPE_CHECKING:
    import xarray as xr


def springs_text(source: Source, _options: Options) -> str:
    """Return the spring set as strict JSON text (SI)."""
    from pysprings.core.text import json_text
    from pysprings.springs.path import paths_of

    springs = source.springs
    document = {
        "attributes": {str(name): value for name, value in springs.attrs.items()},
        "stiffness_initial": _variable(springs.dataset["stiffness_initial"]),
        "paths": {name: _path(path.recorded) for name, path in paths_of(springs).items()},
    }
    return json_text(document) + "\n"


JSON = Exporter(
    name="json",
    description="all springs as one JSON document",
    write=write_text_file(springs_text),
    suffixes=(".json",),
    file="springs.json",
    text=springs_text,
)


def _path(path: xr.Dataset) -> dict[str, Any]:
    return {
        "attributes": {str(name): value for name, value in path.attrs.items()},
        "coordinates": {str(name): _variable(data) for name, data in path.coords.items()},
        "variables": {str(name): _variable(data) for name, data in path.data_vars.items()},
    }


def _variable(data: xr.DataArray) -> dict[str, Any]:
    return {
        "dims": [str(name) for name in data.dims],
        "units": data.attrs.get("units", "1"),
        "values": data.values,
    }
