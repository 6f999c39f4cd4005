# SPDX-License-Identifier: MIT
"""Hostile NetCDF files: spring sets damaged as datasets and as bytes."""

import shutil
from collections.abc import Callable, Iterator
from functools import cache
from itertools import count
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr
from hypothesis import strategies as st

from pysprings.core.storage import write_tree
from tests.fuzz.mutate import NUMBERS, RAW, TEXTS, Op, damage, ops
from tests.support import synthetic

SAFE = [text for text in TEXTS if "\x00" not in text and "\ud7ff" not in text]
ATTRIBUTES: list[Any] = [
    *SAFE, 0, 1, -1, 1e308, float("nan"), float("inf"), np.arange(3), np.arange(3.0), np.int8(3), "5 m", [], ["a", "b"],
    "pysprings-springs-4", "pull", "held-back", "m", "Pa",
]  # fmt: skip
LINES = [float(text) for text in ("nan", "inf", "-inf", "0", "-1", "1e-320", "1e308", "-1e308", "1e12", "1e-12")]
NAMES = ["=1+1", "a b", "..", "@x", "+1", "-x", "x" * 200, "é", "<b>", "path\u202e", "0", "section"]
MEANINGS = ["units", "scale_factor", "add_offset", "_FillValue", "missing_value", "bounds", "dtype", "coordinates"]
VALUE_OPS = ("scale", "one", "one", "all", "attribute", "attribute", "role")
TREE_OPS = (
    *VALUE_OPS, "drop variable", "drop attribute", "units", "rename", "dtype", "transpose", "shorten", "longer",
    "new variable", "drop group", "rename group", "swap groups", "group attribute", "root attribute",
    "reverse", "swap values", "text",
)  # fmt: skip


@cache
def base() -> xr.DataTree:
    """A small spring set: two rays and a pull held back."""
    caisson = synthetic.Caisson(rings=3, sectors=8)
    paths = (
        synthetic.Path("slide", "translation", steps=3),
        synthetic.Path("turn", "rotation", size=1e-3, steps=3),
        synthetic.Path("pull", steps=3, role="held-back"),
    )
    return synthetic.make_springs(paths, caisson)


@cache
def base_file(folder: Path) -> Path:
    """The spring set as a file of a folder."""
    return write_tree(base(), folder / "base.nc")


class Groups(dict[str, xr.Dataset]):
    """Datasets by group; the file of the last one that failed is still in the folder of its test."""

    def __repr__(self) -> str:
        return f"<groups {', '.join(map(repr, self))}>"


def groups() -> Groups:
    """Copies of the datasets of the spring set, by group."""
    return Groups({node.path: node.to_dataset(inherit=False).copy(deep=True) for node in base().subtree})


def _spoil(data: dict[str, xr.Dataset], what: str, where: int, how: int) -> None:
    """Damage one thing in the datasets of a tree."""
    group = list(data)[where % len(data)]
    dataset = data[group]
    names = [str(name) for name in dataset.variables]
    name = names[where // 8 % len(names)] if names else ""
    if what in ("drop group", "rename group", "swap groups", "group attribute", "root attribute", "role"):
        _spoil_groups(data, what, group, how)
    elif name:
        data[group] = _spoiled(dataset, name, what, where // 4096, how)


def _spoil_groups(data: dict[str, xr.Dataset], what: str, group: str, how: int) -> None:
    if what == "drop group":
        del data[group]
    elif what == "rename group":
        data[f"/paths/{NAMES[how % len(NAMES)]}"] = data.pop(group)
    elif what == "swap groups":
        other = list(data)[how % len(data)]
        data[group], data[other] = data[other], data[group]
    elif what == "role":
        data[group].attrs["role"] = ("calibration", "held-back")[how % 2]
    else:
        attrs = data[group if what == "group attribute" else next(iter(data))].attrs
        if attrs:
            attrs[list(attrs)[how // 64 % len(attrs)]] = ATTRIBUTES[how % len(ATTRIBUTES)]


def _spoiled(dataset: xr.Dataset, name: str, what: str, where: int, how: int) -> xr.Dataset:
    """Return a dataset with one variable damaged."""
    variable = dataset.variables[name]
    simple: dict[str, Callable[[], xr.Dataset]] = {
        "drop variable": lambda: dataset.drop_vars(name),
        "rename": lambda: dataset.rename({name: ["x", "H", "paths", "y2"][how % 4]}),
        "new variable": lambda: dataset.assign({"extra": ("step2", np.zeros(3))}),
        "transpose": lambda: dataset.transpose(*reversed(list(dataset.dims))),
    }
    dims = [str(dim) for dim in variable.dims]
    if dims:
        dim = dims[where % len(dims)]
        simple |= {
            "shorten": lambda: dataset.isel({dim: slice(how % (dataset.sizes[dim] + 1))}),
            "longer": lambda: dataset.isel({dim: np.arange(how % 400) % dataset.sizes[dim]}),
            "reverse": lambda: dataset.isel({dim: slice(None, None, -1)}),
        }
    if what in simple:
        return simple[what]()
    if what in ("attribute", "drop attribute", "units"):
        return dataset.assign({name: variable_with(variable, what, where, how)})
    values = _values(np.array(variable.values), what, where, how)
    return dataset.assign({name: (variable.dims, values, variable.attrs)}) if values is not None else dataset


def variable_with(variable: Any, what: str, where: int, how: int) -> Any:
    """Return a variable with another attribute."""
    changed = variable.copy()
    attrs = dict(variable.attrs)
    if what == "units":
        attrs["units"] = ["mm", "1", "", "N m", "seconds since 2000-01-01", "days", "kN"][how % 7]
    elif what == "attribute":
        attrs[MEANINGS[where % len(MEANINGS)]] = ATTRIBUTES[how % len(ATTRIBUTES)]
    elif attrs:
        attrs.pop(list(attrs)[how % len(attrs)])
    changed.attrs = attrs
    return changed


def _values(values: Any, what: str, where: int, how: int) -> Any:
    """Return other values for a variable; None where that makes no sense."""
    if what == "text":
        return np.full(values.shape, TEXTS[5 + how % 8], dtype=object)
    if values.dtype.kind not in "iuf":
        return None
    if what == "dtype":
        return values.astype([np.float32, np.int8, np.int64, np.uint16, np.float64][how % 5])
    out = values.astype(float)
    if not out.size:
        return out
    if what == "one":
        out.flat[where % out.size] = LINES[how % len(LINES)]
    elif what == "all":
        out[...] = LINES[how % len(LINES)]
    elif what == "scale":
        out *= (-1.0) ** (how % 5 == 0) * 10.0 ** (how % 40 - 20 if how % 3 else how % 4 - 2)
    elif what == "swap values":
        out = np.roll(out, 1 + how % 3, axis=-1) if out.ndim else -out
    return out


def save(data: dict[str, xr.Dataset], file: Path) -> bool:
    """Write datasets as they are; False where NetCDF itself cannot hold them."""
    with np.errstate(all="ignore"):
        try:
            xr.DataTree.from_dict(data).to_netcdf(file, engine="netcdf4")
        except Exception:  # what the library does not write is no input
            return False
    return True


@st.composite
def spoiled_trees(draw: st.DrawFn) -> Groups:
    """Draw the groups of a spring set that was a good one."""
    data = groups()
    todo: list[Op] = draw(ops(VALUE_OPS, 3)) if draw(st.booleans()) else draw(ops(TREE_OPS, 3))
    for what, where, how in todo:
        try:
            with np.errstate(all="ignore"):
                _spoil(data, what, where, how)
        except (ValueError, KeyError, IndexError):  # damage that xarray itself does not do
            continue
        if not data:
            break
    return data


_SIGNATURE = 8  # bytes by which the format is known: damage to them is refused at once


def spoil_bytes(file: Path, todo: list[Op]) -> None:
    """Damage a file as bytes; most damage falls on its heads, where structure is."""
    data = file.read_bytes()
    used = []
    for what, where, how in todo:
        reach = len(data) if what == "truncate" or how % 3 == 0 else 20_000
        used.append((what, _SIGNATURE + where % reach, how))
    file.write_bytes(damage(data, used))


raw_ops = ops([*RAW, "flip", "flip", "flip", "flip"], 8)


def spoil_in_place(file: Path, name: str, how: int) -> None:
    """Do with the C library what xarray would not: huge dimensions, compound types, strings, links."""
    with netCDF4.Dataset(file, "a") as root:
        if name == "huge dimension":
            root.createDimension("huge", 2**40)
            root.createVariable("huge", "f8", ("huge",), chunksizes=(1024,))
        elif name == "compound":
            kind = root.createCompoundType(np.dtype([("a", "f8"), ("b", "i4")]), "pair")
            root.createVariable("two", kind, ())
        elif name == "string":
            root.createVariable("words", str, ())[...] = SAFE[how % len(SAFE)]
        elif name == "enum":
            kind = root.createEnumType(np.int8, "kinds", {"a": 0, "b": 1})
            root.createVariable("sort", kind, ())
        elif name == "deep":
            group = root
            for _ in range(how % 60):
                group = group.createGroup("g")
        elif name == "many":
            for k in range(how % 200):
                root.createGroup(f"paths/p{k}")
        elif name == "unlimited":
            root["paths/slide"].createDimension("time", None)
            root["paths/slide"].createVariable("time2", "f8", ("time",))
        elif name == "attributes":
            root.setncatts({f"a{k}": NUMBERS[k % len(NUMBERS)] for k in range(how % 300)})


IN_PLACE = ("huge dimension", "compound", "string", "enum", "deep", "many", "unlimited", "attributes")


def new_file(folder: Path) -> Path:
    """Return the path of a file that is not there yet, and remove the one before it: the library may hold it open."""
    name = _NUMBER.setdefault(folder, count())
    last = folder / f"springs{(number := next(name)) - 1}.nc"
    last.unlink(missing_ok=True)
    return folder / f"springs{number}.nc"


_NUMBER: dict[Path, Iterator[int]] = {}


def copy_of(source: Path, file: Path) -> Path:
    """Copy a file."""
    shutil.copyfile(source, file)
    return file
