# SPDX-License-Identifier: MIT
"""Springs -> model with a memory: calibrated from their rays, or read where a file holds the elements."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pysprings.core.errors import refused
from pysprings.core.path_kinds import MEMORY
from pysprings.macro.fan import FanTable, build_fan, has_fan
from pysprings.macro.memory.calibration import ElementSet, calibrate
from pysprings.macro.memory.model import MemoryModel
from pysprings.macro.memory.samples import samples
from pysprings.macro.memory.shares import Shares
from pysprings.springs.springs import Springs

Array = NDArray[np.float64]

MISSING = (
    "no ray that turns back at this vertical load and rate: monotonic paths do not show how the soil reacts on "
    "reversal. Run the scene with `[springs] memory = true`, or add a translation or rotation with `then` and "
    'role = "memory"'
)
VERSION = 8
_HEAD = ("rows", "odd", "rest", "loads", "elastic", "even")


def has_memory(springs: Springs) -> bool:
    """Return whether springs have a fan, and a ray that turns back at its vertical load."""
    return has_fan(springs) and bool(springs.remembering)


def build_memory(springs: Springs) -> MemoryModel:
    """Return the model with a memory of springs at one rate and vertical load; the stored one where it is theirs.

    Raises
    ------
    UserInputError
        The springs have no fan, or no ray that turns back.
    """
    table = build_fan(springs)
    if not springs.remembering:
        raise refused("springs", MISSING)
    first, own = springs.remembering[0], digest(springs)
    known = [stored for stored in springs.memory.values() if stored.attrs.get("paths_sha256") == own]
    elements = from_dataset(known[0]) if known else _calibrated(springs, table)
    return MemoryModel(elements, table, first.load, first.rate if springs.rate_sets else None)


def _calibrated(springs: Springs, table: FanTable) -> ElementSet:
    scale = np.array([1.0, springs.length])
    return calibrate(samples(springs, table), table, springs.lateral_stiffness / scale / scale[:, None])


def with_memory(tree: xr.DataTree) -> xr.DataTree:
    """Return springs with the calibrated elements in the group "memory"; as they are where they have no memory.

    Of several rates each has its own elements: "memory" those of the slowest, "memory_rate_1" those of the next.
    """
    springs = Springs.of(tree)
    sets = springs.rate_sets
    each = [springs.at(rate=one.rate) for one in sets] if len(sets) > 1 else [springs.at()]
    found = [memory_dataset(at, _calibrated(at, build_fan(at))) for at in each if has_memory(at)]
    if not found:
        return tree
    groups = {node.path: node.to_dataset(inherit=False) for node in tree.subtree}
    names = (f"/{MEMORY}" + (f"_rate_{k}" if k else "") for k in range(len(found)))
    return xr.DataTree.from_dict(groups | dict(zip(names, found, strict=True)), name=tree.name)


def memory_dataset(springs: Springs, elements: ElementSet) -> xr.Dataset:
    """Return the elements of springs as the group "memory" of a spring file."""
    dims = {
        "rows": ("element", "parameter"), "odd": ("row",), "rest": ("row",), "loads": ("odd_row", "load"),
        "elastic": ("odd_row", "motion"), "even": ("even_row", "way"),
    }  # fmt: skip
    shares = elements.shares
    values = {"rows": elements.rows, "odd": shares.odd.astype(np.int8)}
    values |= {name: getattr(shares, name) for name in _HEAD[2:]}
    data = {name: (dims[name], value, {"units": "1"}) for name, value in values.items()}
    attrs: dict[str, Any] = {"version": VERSION, "reach_m": elements.reach, "residual": elements.residual}
    attrs |= {"heave_growth": shares.growth, "way_m": elements.way}
    attrs |= {"paths_sha256": digest(springs), "ways": list(elements.errors)}
    attrs |= {
        "H_errors": [e[0] for e in elements.errors.values()],
        "M_errors": [e[1] for e in elements.errors.values()],
    }
    return xr.Dataset(data, attrs=attrs)


def from_dataset(stored: xr.Dataset) -> ElementSet:
    """Return the elements of the group "memory" of a spring file."""
    rows, odd, rest, loads, elastic, even = (stored[name].values for name in _HEAD)
    attrs = stored.attrs
    ways, pairs = np.atleast_1d(attrs["ways"]), zip(
        np.atleast_1d(attrs["H_errors"]), np.atleast_1d(attrs["M_errors"]), strict=True)  # fmt: skip
    errors = {str(way): (float(H), float(M)) for way, (H, M) in zip(ways, pairs, strict=True)}
    shares = Shares(odd.astype(bool), rest, loads, elastic, even, float(attrs["heave_growth"]))
    reach, residual, way = (float(attrs[name]) for name in ("reach_m", "residual", "way_m"))
    return ElementSet(np.ascontiguousarray(rows), reach, shares, residual, errors, way)


def digest(springs: Springs) -> str:
    """Return the SHA-256 (hex) of the loads, motions and rates of the paths that elements are calibrated on."""
    found = hashlib.sha256(f"{VERSION} {springs.length!r}".encode())
    for path in (*(springs.paths[name] for name in springs.rays), *springs.remembering):
        found.update(f" {path.rate or 0.0:.6g}".encode())
        for values in (path.u, path.rotation, path["H"], path["M"]):
            found.update(np.ascontiguousarray(values, dtype="<f8").tobytes())
    return found.hexdigest()
