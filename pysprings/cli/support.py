# SPDX-License-Identifier: MIT
"""What the commands share: errors and exit codes, quantities, results from folders, tables, JSON."""

from __future__ import annotations

import errno
import functools
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

from pysprings.core.errors import (
    EXIT_BUG,
    EXIT_INTERRUPTED,
    EXIT_NOT_CONVERGED,
    EXIT_RESOURCES,
    EXIT_USER_INPUT,
    MOST_LETTERS,
    Problem,
    ResourceError,
    RunIncomplete,
    UserInputError,
    out_of_memory,
    printable,
)
from pysprings.core.files.layout import WRITING, is_unfinished
from pysprings.core.files.lock import exclusive, new_folder
from pysprings.core.text import json_text, plain_table
from pysprings.results.layout import refuse_linked_folders, results_in

if TYPE_CHECKING:
    import xarray as xr

    from pysprings.macro.sets import AnySprings
    from pysprings.scene.load import Scene

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
            f"fatal: resources: {out_of_memory(error)}; try a smaller mesh (`pysprings check` estimates)",
            EXIT_RESOURCES,
        )
    if isinstance(error, ResourceError):
        return f"fatal: resources: {error}", EXIT_RESOURCES
    if isinstance(error, OSError) and error.errno == errno.ENAMETOOLONG:
        name = printable(error.filename or "a path")
        return f"fatal: user input: {name[:MOST_LETTERS]}: is longer than the system allows", EXIT_USER_INPUT
    if isinstance(error, OSError):
        what = f"{error.filename}: {error.strerror}" if error.filename and error.strerror else str(error)
        return f"fatal: resources: {printable(what)}", EXIT_RESOURCES
    engine = sys.modules.get("fe_engine.errors")  # its errors, when nothing around it made more of them
    if engine and isinstance(error, engine.NotConverged):
        return f"fatal: not converged: {printable(error)}", EXIT_NOT_CONVERGED
    if engine and isinstance(error, engine.MeshError):
        return f"fatal: user input: mesh: {printable(error)}", EXIT_USER_INPUT
    if engine and isinstance(error, engine.SettingError):
        return f"fatal: user input: {printable(error)}", EXIT_USER_INPUT
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
    from pysprings.core.magnitudes import fault
    from pysprings.core.units import QuantityError, quoted, read

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


def springs_of(result: Path, strict: bool = False) -> xr.DataTree:
    """Open the springs of a result folder or spring file, as `read_springs`; refuse a run that has not ended."""
    refuse_unfinished(result, strict)
    return read_springs(result)


def refuse_unfinished(result: Path, strict: bool = False) -> None:
    """Refuse a folder whose run was killed or still writes; say of what was interrupted that it is a part.

    strict : refuse that, too. A file that is named itself is whole: its folder is spoken of, not refused.
    """
    from pysprings.full_model.checkpoint import Checkpoints
    from pysprings.studies.kept_runs import read_record

    folder = result if result.is_dir() else result.parent
    unfinished, record = is_unfinished(folder), read_record(folder)
    saved = not unfinished or Checkpoints(folder).are_of(str(record.get("scene_sha256")))
    onward = "`pysprings run SCENE --out DIR --resume` goes on with it"
    if record.get("status") == "interrupted" and saved:
        message = f"the run was interrupted: what is here is what had converged until then; {onward}"
        if strict:
            refuse("--strict", message, folder)
        say(f"warning: {folder}: {message}")
    elif unfinished or record.get("status") == WRITING:
        message = "holds a run that has not ended (killed, or still running)"
        if result.is_dir():
            refuse(None, f"{message}: files here may be of a run before it, or not all there; {onward}", folder)
        say(f"warning: {folder}: {message}; this file may be of a run before it")


def read_springs(result: Path) -> xr.DataTree:
    """Open the springs of a result folder or spring file; extract them from a full-model file."""
    from pysprings.core.files.storage import read_tree
    from pysprings.springs.checks import validate_springs

    path = result / "springs.nc" if result.is_dir() else result
    if result.is_dir() and not path.exists():
        refuse(None, "no springs.nc in this folder; is it a result of `pysprings run`?", result)
    tree = read_tree(path)
    if "schema" not in tree.attrs and "scene_toml" in tree.attrs:
        from pysprings.springs.extract import extract_springs

        return extract_springs(tree)
    validate_springs(tree, file=path)
    return tree


def springs_or_table(source: Path, skirt_length: float | None, strict: bool = False) -> AnySprings:
    """Open what a prediction is made with: springs as `springs_of` does, or somebody's CSV or Excel table."""
    from pysprings.results.tables import FOREIGN, endings, is_table, open_table

    if is_table(source):
        return open_table(source, skirt_length)
    if source.suffix.lower() in FOREIGN and not source.is_dir():
        known = " or ".join(endings())
        refuse(None, f"tables in the format {source.suffix.lower()} cannot be read; save it as {known}", source)
    if skirt_length is not None:
        refuse("--skirt-length", f"is for tables ({', '.join(endings())}); a spring file has it", source)
    return springs_of(source, strict)


@contextmanager
def result_folder(out: Path, force: bool, resume: bool = False) -> Iterator[None]:
    """Create a result folder and hold its lock; refuse one that holds what the options do not speak of.

    It is removed again if it stays empty.
    """
    if force and resume:
        refuse("--resume", "goes on with a run, --force begins anew: give one of them")
    refuse_no_folder(out)
    with ExitStack() as stack:
        try:
            stack.enter_context(new_folder(out))
        except OSError as error:
            refuse("--out", f"cannot be created ({error.strerror})", out)
        if not os.access(out, os.W_OK | os.X_OK):
            refuse("--out", "is not writable", out)
        stack.enter_context(exclusive(out))
        refuse_linked_folders(out)
        if not force:
            _refuse_what_is_there(out, resume)
        yield


def refuse_no_folder(out: Path) -> None:
    """Refuse a result folder that is a file, or a link to nothing."""
    if out.is_symlink() and not out.exists():
        refuse("--out", f"is a link to {os.readlink(out)}, which is not there", out)
    if out.exists() and not out.is_dir():
        refuse("--out", "is a file, not a folder", out)


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
    if record.get("status") in ("interrupted", WRITING):
        message = "nothing to resume: the run here was interrupted, and its checkpoints are gone; --force begins anew"
        refuse("--resume", message, folder)


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


def in_discretisation(scene: Scene, wanted: str | None) -> Scene:
    """Return the scene in another discretisation; refuse what that cannot carry."""
    from pysprings.scene.checks import clashes, dotted

    if wanted is None or wanted == scene.mesh.discretisation:
        return scene
    changed = scene.model_copy(update={"mesh": scene.mesh.model_copy(update={"discretisation": wanted})})
    for clash in clashes(changed):
        refuse("--discretisation", f"{dotted(clash.keys[0])}: {clash.message}")
    return scene.replace(mesh={"discretisation": wanted})


def with_target(scene: Scene, target: str, has_mesh: bool) -> tuple[Scene, dict[str, Any]]:
    """Return the scene with the cheapest setting for a target error, and what `run_to_folder` is told beside it."""
    from pysprings.full_model.accuracy import presets

    if has_mesh:
        refuse("--target-error", "chooses the mesh itself: give it or --mesh")
    if scene.mesh.discretisation != "hex8":
        refuse("--target-error", 'rests on a study of bricks: choose a mesh, or discretisation = "hex8"')
    setting = presets.cheapest(target)
    extra = {"estimate_error": True, "target_error": presets.note(target, setting)}
    return presets.applied(setting, scene), extra


def record_stamp(folder: Path) -> tuple[int, int] | None:
    """Return what changes when a run writes its record, to tell it from the record of a run before it."""
    record = folder / "run.json"
    return (record.stat().st_ino, record.stat().st_mtime_ns) if record.exists() else None


def print_json(data: Any) -> None:
    """Print one JSON document on stdout; numbers that are not finite become null."""
    print(json_text(data, indent=2))


def print_table(headers: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table in plain text: first column left, the others right."""
    print(plain_table([printable(head) for head in headers], [[printable(cell) for cell in row] for row in rows]))
