# SPDX-License-Identifier: MIT
"""Files that are whole or absent: atomic writing of any file, NetCDF-4 writing and reading of DataTrees, their heads.

A NetCDF file ends with a checksum, behind the end of the HDF5 data: the SHA-256 of the bytes before it, which is
compared before HDF5 opens the file. Checksums of HDF5 (Fletcher-32) cannot replace it: they protect the chunks of the
variables, not internal tables, attributes and texts. Of 800 files with one wrong bit at random, opened without this
line, four ended the process by a segmentation fault in HDF5. Readers of HDF5 skip bytes behind the end, and a program
that changes the file drops the line.
Content that is too large by the file's header is rejected before a number is loaded: arrays that were never written
take no room on a disk, whatever their size, and a file of 100 kB can ask for any memory.
"""

import hashlib
import math
import mmap
import os
import re
import shutil
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from pysprings.core.errors import ResourceError, UserInputError, refused
from pysprings.core.process import uninterrupted

_TEMPORARY = re.compile(r"\..+\.\d+\.tmp(\.\w+)?")
_AMPLE = 1e9  # bytes free on a disk: it is not full
_HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a temporary path beside the target; move it onto the target when the block ends well and it is on the disk.

    An exception inside the block leaves an existing target untouched and removes the temporary file.
    """
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    temporary = target.with_name(f".{target.stem}.{os.getpid()}.tmp{target.suffix}")
    try:
        temporary.unlink(missing_ok=True)  # of a process of this number that was killed
        yield temporary
        with temporary.open("rb+") as stream:
            os.fsync(stream.fileno())
        os.replace(temporary, target)
        _sync_folder(target.parent)
    except Exception as error:
        wrapped = error.args and isinstance(error.args[0], OSError)  # by a writer of workbooks
        cause = error.args[0] if wrapped else error
        if isinstance(cause, OSError) and cause.errno and temporary.name in str(cause.filename or temporary):
            cause.filename = os.fspath(target)
        if wrapped:
            raise cause from None
        raise
    finally:
        temporary.unlink(missing_ok=True)


def _sync_folder(folder: Path) -> None:
    """Have the disk keep a new name in a folder, where the system can be asked to."""
    if os.name == "nt":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def leftovers(folder: Path) -> list[Path]:
    """Return the temporary files in a folder of processes that were killed while they wrote."""
    return [path for path in folder.glob(".*.tmp*") if _TEMPORARY.fullmatch(path.name)]


def remove_leftovers(*folders: Path) -> None:
    """Remove the temporary files that killed processes have left in folders."""
    for file in (file for folder in folders for file in leftovers(folder)):
        file.unlink(missing_ok=True)


def write_text(text: str, path: str | os.PathLike[str]) -> Path:
    """Write a UTF-8 text file atomically; return its path."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="")
    return Path(path)


def write_tree(tree: xr.DataTree, path: str | os.PathLike[str]) -> Path:
    """Write a DataTree as compressed NetCDF-4 with a checksum, atomically; return its path.

    Raises ResourceError: the file cannot be written; the disk may be full.
    """
    groups = {node.path: _storable(node.to_dataset(inherit=False)) for node in tree.subtree}
    with uninterrupted(), replacing(path) as temporary:
        try:
            _write_groups(groups, temporary)
            seal(temporary)
        except (RuntimeError, OSError) as error:  # what the C libraries make of a full disk
            raise _unwritable(Path(path), error) from error
    return Path(path)


class _Later:
    """Writer of a store that keeps arrays until all of a file is defined."""

    def __init__(self) -> None:
        self.parts: list[tuple[Any, Any]] = []

    def add(self, source: Any, target: Any, region: Any = None) -> None:
        """Keep what goes to a variable."""
        self.parts.append((source, target))


def _write_groups(groups: dict[str, xr.Dataset], path: Path) -> None:
    """Define all variables, then write their values: the C library goes through a whole file at each change between."""
    import netCDF4
    from xarray.backends import NetCDF4DataStore
    from xarray.conventions import encode_dataset_coordinates

    later = _Later()
    with netCDF4.Dataset(os.fspath(path), "w", format="NETCDF4") as file:
        for name, dataset in groups.items():
            variables, attributes = encode_dataset_coordinates(dataset)
            for variable, options in _encoding(dataset).items():
                variables[variable].encoding = options
            store = NetCDF4DataStore(file if name == "/" else file.createGroup(name))
            store.store(variables, attributes, writer=later)
        for source, target in later.parts:
            target[...] = source


def write_attribute(name: str, text: str, path: str | os.PathLike[str]) -> None:
    """Write an attribute of the root of a NetCDF file that `write_tree` has written, atomically; the arrays stay.

    Raises ResourceError: the file cannot be written; the disk may be full.
    """
    import netCDF4

    with uninterrupted(), replacing(path) as temporary:
        try:
            shutil.copyfile(path, temporary)
            with netCDF4.Dataset(os.fspath(temporary), "a") as file:
                file.setncattr(name, text)
            seal(temporary)
        except (RuntimeError, OSError) as error:
            raise _unwritable(Path(path), error) from error


def _unwritable(path: Path, error: Exception) -> ResourceError:
    free = shutil.disk_usage(path.parent).free
    reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    why = f"{free / 1e6:,.0f} MB are free on the disk"
    if free > _AMPLE:
        why += ", so a quota or a limit on the size of files may be what is used up"
    return ResourceError(f"{path}: cannot be written ({reason}; {why})")


def _storable(dataset: xr.Dataset) -> xr.Dataset:
    """Return a copy without leftovers of an earlier file, with attributes that NetCDF can hold."""
    clean = dataset.drop_encoding()
    clean.attrs = {str(name): _attribute(value) for name, value in dataset.attrs.items()}
    return clean


def _attribute(value: Any) -> Any:
    if value is None:
        return ""
    return int(value) if isinstance(value, bool | np.bool_) else value


_LARGE = 16_384  # bytes: chunks and tables of smaller compressed arrays need more room than they save


def _encoding(dataset: xr.Dataset) -> dict[str, dict[str, Any]]:
    """Compress large numeric arrays; no fill value on coordinates and their bounds, as CF asks."""
    exact = set(dataset.coords) | {name for name in dataset.variables if str(name).endswith("_bounds")}
    encoding: dict[str, dict[str, Any]] = {}
    for name, variable in dataset.variables.items():
        options: dict[str, Any] = {"_FillValue": None} if name in exact else {}
        if variable.dtype.kind in "iufb" and variable.ndim and variable.nbytes >= _LARGE:
            options |= {"zlib": True, "complevel": 4, "shuffle": True}
        if options and variable.dtype.kind in "iufb":
            encoding[str(name)] = options
    return encoding


CHANGED_ELSEWHERE = "no checksum at its end: written or changed by another program"


def read_tree(path: str | os.PathLike[str]) -> xr.DataTree:
    """Read a NetCDF-4 file into memory and close it; refuse what is not one with a clear message.

    A file without a checksum (written or changed by another program) is read with a warning.

    Raises UserInputError: no such file, a folder, another format, a broken or damaged file.
    Raises ResourceError: the content needs more memory than is free.
    """
    import netCDF4

    _refuse_foreign(Path(path))
    try:
        whole = bytes_hold(path)
        if whole is False:
            raise refused(None, "the file is damaged: its bytes have changed since it was written", path)
        small = Path(path).stat().st_size <= MOST_SPRINGS
        content = Path(path).read_bytes() if small else None  # the C library crashes where a file is open twice
        with uninterrupted(), _ONE_READER, netCDF4.Dataset(os.fspath(path), memory=content) as root:
            _judge(path, root)
            result = _with_bounds_units(_contents(root))
    except (UserInputError, ResourceError, ModuleNotFoundError):
        raise
    except Exception as error:  # the C libraries below raise many types on a damaged file
        raise refused(None, f"broken or incomplete NetCDF file ({error})", path) from error
    if whole is None:
        warnings.warn(f"{path}: {CHANGED_ELSEWHERE}, taken as it is", stacklevel=3)
    return result


def _with_bounds_units(tree: xr.DataTree) -> xr.DataTree:
    """Give bounds the units of their coordinate again, which CF (and so the file) leaves out."""
    for node in tree.subtree:
        for coordinate in node.coords.values():
            bounds = coordinate.attrs.get("bounds")
            if bounds in node.data_vars:
                node.data_vars[bounds].attrs.setdefault("units", coordinate.attrs.get("units", "1"))
    return tree


def _refuse_foreign(path: Path) -> None:
    if not path.exists():
        raise refused(None, "no such file", path)
    if path.is_dir():
        raise refused(None, "is a folder, not a NetCDF file", path)
    with path.open("rb") as stream:
        start = stream.read(len(_HDF5_SIGNATURE))
    if start != _HDF5_SIGNATURE:
        raise refused(None, "not a NetCDF-4 file (of a run: springs.nc or full_model.nc, or its folder)", path)


_ONE_READER = threading.Lock()  # the C library is not safe in threads
MOST_SPRINGS = 100e6  # bytes of a spring set, unpacked: hundreds of paths
MOST_GROUPS = 20_000
MOST_VARIABLES = 200  # in a group
MOST_ATTRIBUTES = 500  # of a group or variable
MOST_SHOWN = 40  # letters of a name
_DENSEST = 1032.0  # bytes that one byte of deflate can stand for at best
_SPARE = 10e6  # bytes that a small file may have beyond that: fill values of short arrays


def _judge(path: str | os.PathLike[str], root: Any) -> None:
    """Refuse an open file whose groups, variables or attributes are too many, or whose arrays are too large.

    Raises UserInputError: the numbers, or sizes beyond what a file of this size can hold, or beyond a spring set's.
    Raises ResourceError: the content needs more memory than is free.
    """
    name, packed = str(path), Path(path).stat().st_size
    total = _sizes(name, root)
    if total > _DENSEST * packed + _SPARE:
        _refuse(name, f"{total / 1e9:,.3g} GB when unpacked from {packed / 1e6:.3g} MB: most of it was never written")
    if max(total, packed) <= MOST_SPRINGS:
        return
    if "schema" in root.ncattrs():
        size = max(total, packed) / 1e6
        _refuse(name, f"{size:,.0f} MB when unpacked; a set of springs has at most {MOST_SPRINGS / 1e6:.0f} MB")
    import psutil

    free = psutil.virtual_memory().available
    if total > free:
        raise ResourceError(f"{path}: {total / 1e9:,.3g} GB when unpacked; {free / 1e9:.3g} GB of memory are free")


def _contents(root: Any) -> xr.DataTree:
    """Return all groups of an open file in memory, by the CF conventions; seconds stay numbers, no dates.

    xarray's own reader takes a lock and a lazy array for each variable, which is twice the time.
    """
    root.set_auto_maskandscale(False)
    root.set_auto_chartostring(False)
    groups = {}
    for group in _groups(root):
        own = group.variables.items()
        variables = {name: (each.dimensions, _values(each), _attributes(each)) for name, each in own}
        raw = xr.Dataset(variables, attrs=_attributes(group))
        groups[group.path] = xr.decode_cf(raw, decode_times=False, decode_timedelta=False).load()
    return xr.DataTree.from_dict(groups)


def _values(variable: Any) -> Any:
    """Return the values of a variable; those of an index of texts with their length, as xarray reads them."""
    is_index = variable.dtype is str and variable.dimensions == (variable.name,)
    return variable[...].astype(str) if is_index else variable[...]


def _attributes(of: Any) -> dict[str, Any]:
    return {name: of.getncattr(name) for name in of.ncattrs()}


def _sizes(name: str, root: Any) -> float:
    """Return the bytes of all variables; refuse what is too many. Texts count as pointers."""
    total = 0.0
    for number, group in enumerate(_groups(root), start=1):
        if number > MOST_GROUPS:
            _refuse(name, f"holds more than {MOST_GROUPS:,} groups")
        _refuse_many(name, group.path, len(group.variables), MOST_VARIABLES, "variables")
        _refuse_many(name, group.path, len(group.ncattrs()), MOST_ATTRIBUTES, "attributes")
        for key, variable in group.variables.items():
            _refuse_many(name, f"{group.path}/{key}", len(variable.ncattrs()), MOST_ATTRIBUTES, "attributes")
            total += float(math.prod(variable.shape)) * getattr(variable.dtype, "itemsize", 8)
    return total


def _groups(group: Any) -> Iterator[Any]:
    yield group
    for each in group.groups.values():
        yield from _groups(each)


def _refuse_many(name: str, place: str, count: int, most: int, what: str) -> None:
    if count > most:
        _refuse(name, f"holds {count:,} {what} in '{place[-MOST_SHOWN:]}', at most {most:,}")


def _refuse(name: str, message: str) -> None:
    raise refused(None, message, name)


_LAST_LINE = b"\npysprings sha256 "
_LENGTH = len(_LAST_LINE) + 64 + 1  # with the digest and the end of the line


def seal(path: str | os.PathLike[str]) -> None:
    """Write the last line of a NetCDF file without one."""
    digest = hashlib.sha256(Path(path).read_bytes()).hexdigest()
    with Path(path).open("ab") as stream:
        stream.write(_LAST_LINE + digest.encode() + b"\n")


def bytes_hold(path: str | os.PathLike[str]) -> bool | None:
    """Compare the last line with the bytes before it; None where there is no such line."""
    with Path(path).open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
        line = data[-_LENGTH:]
        if len(data) <= _LENGTH or not line.startswith(_LAST_LINE):
            return None
        with memoryview(data) as view, view[:-_LENGTH] as content:
            return hashlib.sha256(content).hexdigest().encode() == line[len(_LAST_LINE) : -1]
