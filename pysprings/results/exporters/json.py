# SPDX-License-Identifier: MIT
"""The spring set as one JSON document: attributes, units, nested lists by path; missing numbers null."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import xarray as xr

from pysprings.springs import path_dataset, path_names


def springs_text(springs: xr.DataTree) -> str:
    """Return the spring set as strict JSON text (SI)."""
    document = {
        "attributes": {str(name): _plain(value) for name, value in springs.attrs.items()},
        "stiffness_initial": _variable(springs.dataset["stiffness_initial"]),
        "paths": {name: _path(path_dataset(springs, name)) for name in path_names(springs)},
    }
    return json.dumps(document, allow_nan=False) + "\n"


def _path(path: xr.Dataset) -> dict[str, Any]:
    return {
        "attributes": {str(name): _plain(value) for name, value in path.attrs.items()},
        "coordinates": {str(name): _variable(data) for name, data in path.coords.items()},
        "variables": {str(name): _variable(data) for name, data in path.data_vars.items()},
    }


def _variable(data: xr.DataArray) -> dict[str, Any]:
    return {
        "dims": [str(name) for name in data.dims],
        "units": data.attrs.get("units", "1"),
        "values": _plain(data.values),
    }


def _plain(value: Any) -> Any:
    """Return numbers, texts and nested lists that JSON knows; None for what is not finite."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
