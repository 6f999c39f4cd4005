# SPDX-License-Identifier: MIT
"""What the commands share: errors and exit codes, quantities, results from folders, tables, JSON."""

from __future__ import annotations

import functools
import json
import math
import os
import signal
import sys
import threading
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, ParamSpec

import typer

from pysprings.errors import (
    EXIT_BUG,
    EXIT_INTERRUPTED,
    EXIT_NOT_CONVERGED,
    EXIT_RESOURCES,
    EXIT_USER_INPUT,
    Problem,
    ResourceError,
    RunIncomplete,
    UserInputError,
    printable,
)
from pysprings.result_files import is_unfinished, results_in
from pysprings.run_lock import exclusive, new_folder

if TYPE_CHECKING:
    import xarray as xr

    from pysprings.macro_sets import Springs
    from pysprings.scene import Scene

P = ParamSpec("P")

DEBUG = {"on": False}  # set by `pysprings --debug`


def guarded(command: Callable[P, None]) -> Callable[P, None]:
    """Run a command so that every error ends in one clear line and the right exit code."""

    @functools.wraps(command)
    def run(*args: P.args, **kwargs: P.kwargs) -> None:
        try:
            with warnings.catch_warnings():
                warnings.showwarning = _show_warning
                command(*args, **kwargs)
            sys.stdout.flush()
        except typer.Exit:
            raise
        except BrokenPipeError:  # the reader, say `head`, has seen enough
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise typer.Exit(0) from None
        except (Exception, KeyboardInterrupt) as error:
            if DEBUG["on"]:
                traceback.print_exc()
            text, code = _explained(error)
            say(text)
            raise typer.Exit(code) from None

    return run


def _explained(error: BaseException) -> tuple[str, int]:
    """Return message and exit code of an error."""
    if isinstance(error, UserInputError):
        return str(error), error.exit_code
    if isinstance(error, RunIncomplete):
        kept = f"\nwhat converged is kept in {error.folder}" if error.folder else ""
        return f"fatal: not converged: {error}{kept}", error.exit_code
    if isinstance(error, KeyboardInterrupt):
        return "interrupted", EXIT_INTERRUPTED
    if isinstance(error, MemoryError):
        return (
            "fatal: resources: out of memory; try a smaller mesh (`pysprings check` estimates)",
            EXIT_RESOURCES,
        )
    if isinstance(error, ResourceError):
        return f"fatal: resources: {error}", EXIT_RESOURCES
    if isinstance(error, OSError):
        what = f"{error.filename}: {error.strerror}" if error.filename and error.strerror else str(error)
        return f"fatal: resources: {printable(what)}", EXIT_RESOURCES
    engine = sys.modules.get("fe_engine.errors")  # its errors, when nothing around it made more of them
    if engine and isinstance(error, engine.NotConverged):
        return f"fatal: not converged: {printable(error)}", EXIT_NOT_CONVERGED
    if engine and isinstance(error, engine.MeshError):
        return f"fatal: user input: mesh: {printable(error)}", EXIT_USER_INPUT
    trace = "" if DEBUG["on"] else "; `pysprings --debug ...` shows where"
    return f"fatal: bug: {type(error).__name__}: {printable(error)}\nplease report it{trace}", EXIT_BUG


def _show_warning(message: Warning | str, *_args: Any, **_kwargs: Any) -> None:
    say(f"warning: {message}")


def say(text: str) -> None:
    """Talk to the user (stderr); what could steer a terminal is written out."""
    print("\n".join(map(printable, text.split("\n"))), file=sys.stderr, flush=True)


def refuse(key: str | None, message: str, file: str | os.PathLike[str] | None = None) -> NoReturn:
    """Raise the error for one problem with an option or a file."""
    raise UserInputError([Problem(None if file is None else str(file), key=key, message=message)])


def quantities(given: Mapping[str, tuple[str | None, str, str]]) -> dict[str, float | None]:
    """Return SI values (None for options not given) of {option: (text or None, SI unit, example)}."""
    from pysprings.magnitudes import fault
    from pysprings.units import QuantityError, quoted, read

    values: dict[str, float | None] = {}
    problems = []
    for option, (text, si_unit, example) in given.items():
        try:
            values[option] = value = None if text is None else read(text, si_unit, example)
        except QuantityError as error:
            problems.append(Problem(key=option, message=str(error)))
            continue
        if value is not None and (wrong := fault(value, si_unit)):
            problems.append(Problem(key=option, message=f"{quoted(text)} {wrong}"))
    if problems:
        raise UserInputError(problems)
    return values


def springs_of(result: Path) -> xr.DataTree:
    """Open the springs of a result folder or spring file; extract them from a full-model file."""
    from pysprings.springs import validate_springs
    from pysprings.storage import read_tree

    path = result / "springs.nc" if result.is_dir() else result
    if result.is_dir() and not path.exists():
        refuse(None, "no springs.nc in this folder; is it a result of `pysprings run`?", result)
    tree = read_tree(path)
    if "schema" not in tree.attrs and "scene_toml" in tree.attrs:
        from pysprings.extract import extract_springs

        return extract_springs(tree)
    validate_springs(tree, file=path)
    return tree


def springs_or_table(source: Path, skirt_length: float | None) -> Springs:
    """Open what a prediction is made with: springs as `springs_of` does, or somebody's CSV or Excel table."""
    from pysprings.tables import is_table, open_table

    if is_table(source):
        return open_table(source, skirt_length)
    if skirt_length is not None:
        refuse("--skirt-length", "is for tables; a spring file has it", source)
    return springs_of(source)


@contextmanager
def result_folder(out: Path, force: bool, resume: bool = False) -> Iterator[None]:
    """Create a result folder and hold its lock; refuse one that holds what the options do not speak of.

    It is removed again if it stays empty.
    """
    if force and resume:
        refuse("--resume", "goes on with a run, --force begins anew: give one of them")
    if out.exists() and not out.is_dir():
        refuse("--out", "is a file, not a folder", out)
    with ExitStack() as stack:
        try:
            stack.enter_context(new_folder(out))
        except OSError as error:
            refuse("--out", f"cannot be created ({error.strerror})", out)
        if not os.access(out, os.W_OK | os.X_OK):
            refuse("--out", "is not writable", out)
        stack.enter_context(exclusive(out))
        if not force:
            _refuse_what_is_there(out, resume)
        yield


def _refuse_what_is_there(out: Path, resume: bool) -> None:
    """Refuse a folder with an interrupted run or with results, or with neither where a run is to go on."""
    found, unfinished = results_in(out), is_unfinished(out)
    if resume and not unfinished and "run.json" not in found:
        refuse("--resume", "nothing to resume: no interrupted run in this folder", out)
    if unfinished and not resume:
        refuse("--out", "holds an interrupted run; --resume goes on with it, --force begins anew", out)
    if found and not resume:
        refuse(
            "--out",
            f"holds results already ({', '.join(found)}); choose another folder, or --force to replace",
            out,
        )


def refuse_other_run(folder: Path, record: Mapping[str, Any], scene_sha256: str) -> None:
    """Refuse to take the results of a folder for those of a scene, unless they are its own and whole."""
    if record.get("scene_sha256") != scene_sha256:
        refuse("--resume", "the results here are those of another scene or mesh; --force begins anew", folder)
    if record.get("status") == "interrupted":
        refuse("--resume", "nothing to resume: the run here was interrupted, and its checkpoints are gone", folder)


@contextmanager
def interruptible() -> Iterator[None]:
    """Have a request to end (SIGTERM), or a terminal that closes, interrupt the block as Ctrl-C does."""

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    names = [name for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    kinds = [kind for name in names if signal.getsignal(kind := getattr(signal, name)) == signal.SIG_DFL]
    if threading.current_thread() is not threading.main_thread():  # signals are the main thread's affair
        kinds = []
    for kind in kinds:
        signal.signal(kind, interrupt)
    try:
        yield
    finally:
        for kind in kinds:
            signal.signal(kind, signal.SIG_DFL)


def with_target(scene: Scene, target: str, has_mesh: bool) -> tuple[Scene, dict[str, Any]]:
    """Return the scene with the cheapest setting for a target error, and what `run_to_folder` is told beside it."""
    from pysprings.accuracy import presets

    if has_mesh:
        refuse("--target-error", "chooses the mesh itself: give it or --mesh")
    setting = presets.cheapest(target)
    extra = {"estimate_error": True, "notes": {"target_error": presets.note(target, setting)}}
    return presets.applied(setting, scene), extra


def record_stamp(folder: Path) -> tuple[int, int] | None:
    """Return what changes when a run writes its record, to tell it from the record of a run before it."""
    record = folder / "run.json"
    return (record.stat().st_ino, record.stat().st_mtime_ns) if record.exists() else None


def print_json(data: Any) -> None:
    """Print one JSON document on stdout; numbers that are not finite become null."""
    print(json.dumps(_plain(data), indent=2, allow_nan=False))


def _plain(data: Any) -> Any:
    """Return data as JSON can hold it."""
    if isinstance(data, Mapping):
        return {str(key): _plain(value) for key, value in data.items()}
    if hasattr(data, "tolist"):  # numpy scalars and arrays
        return _plain(data.tolist())
    if isinstance(data, float):
        return data if math.isfinite(data) else None
    if data is None or isinstance(data, bool | int | str):
        return data
    if isinstance(data, Sequence | set | frozenset):
        return [_plain(value) for value in data]
    return str(data)


def print_table(headers: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table in plain text: first column left, the others right."""
    lines = [list(headers), *(list(row) for row in rows)]
    widths = [max(len(line[column]) for line in lines) for column in range(len(headers))]
    lines.insert(1, ["-" * width for width in widths])
    for line in lines:
        cells = [
            printable(cell).rjust(width) if column else printable(cell).ljust(width)
            for column, (cell, width) in enumerate(zip(line, widths, strict=True))
        ]
        print("  ".join(cells).rstrip())


def number(value: Any) -> str:
    """Return a number for people: thousands apart, four figures."""
    if value is None:
        return "-"
    value = value.item() if hasattr(value, "item") else value
    if isinstance(value, bool) or not isinstance(value, int | float):
        return str(value)
    if isinstance(value, int) or (abs(value) >= 1e4 and math.isfinite(value) and abs(value) < 1e15):
        return f"{value:,.0f}"
    return f"{value:.4g}"
