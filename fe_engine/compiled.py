# SPDX-License-Identifier: MIT
"""Compiled loops, kept between processes in a folder for each state of all sources that they are compiled from.

Numba renews a kept loop when the file of its function changes. A function of another file may be compiled into the
loop, too, and Numba does not check that file. So the folder's name is a digest of the contents of all sources: loops
of other laws stand in another folder, wherever the folder lies, and dates of files do not matter.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import FunctionType
from typing import Any

import numba

# Loops that are written for it become vector instructions; what they compute is the same to the last digit
if "NUMBA_SLP_VECTORIZE" not in os.environ:
    vars(numba.config)["SLP_VECTORIZE"] = 1
if "NUMBA_OPT" not in os.environ:  # a fifth less to compile than level 3; loops are as fast, and the same
    vars(numba.config)["OPT"] = type(vars(numba.config)["OPT"])(2)

HOME = Path(__file__).parent
UNUSED_DAYS = 30.0  # after so many days without a start, the loops of other sources are removed
_DIGITS = 16  # of the digest, in a folder's name (paths are short on Windows)
_PROBE = bytes(4096)  # a full disk takes an empty file still


def digest(home: Path, sources: Iterable[Path]) -> str:
    """Return the SHA-256 (64 hexadecimal digits) of files below ``home``: their names, and every byte of them."""
    total = hashlib.sha256()
    for source in sorted(sources):
        content = source.read_bytes()
        total.update(f"{source.relative_to(home).as_posix()}\0{len(content)}\0".encode())
        total.update(content)
    return total.hexdigest()


_outside: list[Path] = []  # sources of registered laws that lie outside the engine


def include(sources: Iterable[Path]) -> None:
    """Count files outside the engine among its sources: loops made from now on depend on their contents."""
    _outside.extend(sorted(sources))


def engine_digest() -> str:
    """Return the digest of all sources of the engine, and of those of laws from outside (see `include`)."""
    return _digest_with(tuple(_outside))


@cache
def _digest_with(outside: tuple[Path, ...]) -> str:
    own = digest(HOME, HOME.rglob("*.py"))
    if not outside:
        return own
    return hashlib.sha256(b"\0".join([own.encode(), *(source.read_bytes() for source in outside)])).hexdigest()


def njit(function: Callable[..., Any] | None = None, **options: Any) -> Any:
    """Compile a function of the engine at its first call, see `cached`; a decorator, options of Numba are optional."""
    if function is None:
        return lambda decorated: njit(decorated, **options)
    # given for each function: without the option a function takes that of its caller
    return cached(function, HOME, engine_digest(), **({"_nrt": True} | options))


def lean(function: Callable[..., Any]) -> Any:
    """Compile a function like `njit` that makes no arrays, without counting references to those that it gets.

    Numba counts them at calls, at accesses to fields and at slices, by atomic operations: these cost more than the
    work on a point of the soil.
    """
    return njit(function, _nrt=False)


def with_globals(function: Any, suffix: str, known: Mapping[str, Any]) -> Any:
    """Return a jitted copy of a jitted function, under a name of its own, to which ``known`` are global names.

    Numba keeps loops by name: one name with another callee would read a loop that was kept for the first.
    """
    plain, name = getattr(function, "py_func", function), f"{function.__name__}_{suffix}"  # NUMBA_DISABLE_JIT: itself
    code = plain.__code__.replace(co_name=name, co_qualname=name)
    copy = FunctionType(code, {**plain.__globals__, **known}, name, plain.__defaults__)
    given = getattr(function, "targetoptions", {})
    return njit(copy, **{key: given[key] for key in ("_nrt", "parallel") if key in given})


def cached(function: Callable[..., Any], home: Path, sources: str, **options: Any) -> Any:
    """Compile a function at its first call, and keep the code for later processes where there is a place for it.

    Parameters
    ----------
    function : the function, of a package that lies in the folder ``home``.
    sources : digest of all files that the function is compiled from.
    options : of `numba.njit`.
    """
    folder = folder_of(home, sources)
    if folder is None:
        return numba.njit(**options)(function)
    with _numba_keeps_in(folder):
        return numba.njit(cache=True, **options)(function)


@contextmanager
def _numba_keeps_in(folder: Path) -> Iterator[None]:
    """Have functions that are decorated in the block keep their code in a folder; Numba chooses it there and then."""
    settings = {"CACHE_DIR": str(folder), "CACHE_LOCATOR_CLASSES": "UserProvidedCacheLocator"}
    before = {name: getattr(numba.config, name, "") for name in settings}
    try:
        for name, value in settings.items():
            setattr(numba.config, name, value)
        yield
    finally:
        for name, value in before.items():
            setattr(numba.config, name, value)


@cache
def folder_of(home: Path, sources: str) -> Path | None:
    """Return the folder of what is compiled from these sources, ready to be written to; None where there is none.

    A warning names the place where it is not one of the usual ones: NUMBA_CACHE_DIR alone where that is set, else
    ``home / "__pycache__"`` or the user's cache.
    """
    given = getattr(numba.config, "CACHE_DIR", "")
    usual = [Path(given)] if given else [home / "__pycache__", user_cache()]
    name = f"{home.name}-{sources[:_DIGITS]}"
    chosen, refused = choose(name, usual, private_temporary())
    if refused:
        where = "are not kept: each start compiles them anew" if chosen is None else f"are kept in {chosen.parent}"
        what = f"NUMBA_CACHE_DIR, {given}," if given else "neither the package nor the user's cache"
        warn_once(f"compiled loops {where}; {what} {'cannot' if given else 'can'} be written to (see NUMBA_CACHE_DIR)")
    return chosen


def choose(name: str, usual: Iterable[Path], last: Path | None) -> tuple[Path | None, list[Path]]:
    """Return the first place that can be written to with ``name`` added; and the usual ones if it is none of them."""
    refused = []
    for place in usual:
        if prepare(place / name):
            return place / name, []
        refused.append(place)
    return (last / name if last is not None and prepare(last / name) else None), refused


def prepare(folder: Path) -> bool:
    """Make a folder for kept loops, mark it as used, and clear away its old neighbours; False where that fails."""
    try:
        new = not folder.exists()
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as probe:
            probe.write(_PROBE)
            probe.flush()
        os.utime(folder)
    except OSError:
        return False
    if new:
        _clear_away(folder)
    return True


def _clear_away(folder: Path) -> None:
    """Remove folders beside this one that hold loops of other sources, and that no process has used for long."""
    package = folder.name.rpartition("-")[0]
    name, oldest = re.compile(rf"{re.escape(package)}-[0-9a-f]{{{_DIGITS}}}"), time.time() - 86_400.0 * UNUSED_DAYS
    for other in folder.parent.glob(f"{package}-*"):
        try:
            if name.fullmatch(other.name) and not other.is_symlink() and other.stat().st_mtime < oldest:
                shutil.rmtree(other, ignore_errors=True)
        except OSError:  # another process was faster
            continue


def user_cache() -> Path:
    """Return the folder in which this system keeps a user's caches."""
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local") / "pysprings"
    if sys.platform == "darwin":
        return Path("~/Library/Caches/pysprings").expanduser()
    return Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser()) / "pysprings"


def private_temporary() -> Path | None:
    """Return a folder for temporary files that nobody else can write to (what is kept is run); None without one."""
    try:
        place = Path(tempfile.gettempdir(), f"pysprings-{os.getuid() if hasattr(os, 'getuid') else 'loops'}")
        place.mkdir(mode=0o700, exist_ok=True)
        about = place.lstat()
    except OSError:
        return None
    if hasattr(os, "getuid") and (about.st_uid != os.getuid() or about.st_mode & 0o077 or place.is_symlink()):
        return None
    return place


@cache
def warn_once(text: str) -> None:
    """Warn, the first time in a process."""
    warnings.warn(text, RuntimeWarning, stacklevel=2)
