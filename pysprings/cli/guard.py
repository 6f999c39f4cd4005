# SPDX-License-Identifier: MIT
"""Errors of commands: each ends in one line on stderr and its exit code."""

import errno
import functools
import os
import sys
import traceback
import warnings
from collections.abc import Callable
from contextvars import ContextVar
from dataclasses import replace
from typing import ParamSpec

import typer

from pysprings.cli.support import LOG, OPTIONS, to_stderr
from pysprings.core import errors

P = ParamSpec("P")

OTHER_NAMES = {"springs_kind": "--springs", "n": "--points"}  # arguments of Python and their options
OURS = ("", "pysprings", "fe_engine")
DEBUG: ContextVar[bool] = ContextVar("debug", default=False)  # `pysprings --debug`


def guarded(command: Callable[P, None]) -> Callable[P, None]:
    """Return the command with every error turned into one line on stderr and an exit code."""

    @functools.wraps(command)
    def run(*args: P.args, **kwargs: P.kwargs) -> None:
        LOG.set(None)  # that of a command before it in this process
        try:
            with warnings.catch_warnings():
                warnings.showwarning = lambda message, *_args, **_kwargs: to_stderr(f"warning: {message}")
                command(*args, **kwargs)
            sys.stdout.flush()
        except typer.Exit:
            raise
        except BrokenPipeError:  # the reader, such as `head`, has closed the pipe
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise typer.Exit(0) from None
        except (Exception, KeyboardInterrupt) as error:
            if DEBUG.get():
                traceback.print_exc()
            text, code = explained(as_typed(error))
            to_stderr(text)
            raise typer.Exit(code) from None

    return run


def as_typed(error: BaseException) -> BaseException:
    """Return an error of user input whose keys, where they are arguments of Python, are the options of this command."""
    options = OPTIONS.get()
    if not isinstance(error, errors.UserInputError):
        return error
    typed = {name[2:].replace("-", "_"): name for name in options if name != "--springs"}  # springs: the argument
    typed |= {key: name for key, name in OTHER_NAMES.items() if name in options}
    problems = [
        replace(each, key=typed.get(each.key, each.key)) if each.key and each.file is None else each
        for each in error.problems
    ]
    return type(error)(problems)


def explained(error: BaseException) -> tuple[str, int]:
    """Return message and exit code of an error."""
    if isinstance(error, errors.UserInputError):
        return str(error), error.exit_code
    if isinstance(error, errors.RunIncomplete):
        what, kept = error.words
        where = f"\n{kept} kept in {error.folder}" if error.folder else ""
        return f"fatal: {what}: {error}{where}", error.exit_code
    if isinstance(error, KeyboardInterrupt):
        return "interrupted", errors.EXIT_INTERRUPTED
    if isinstance(error, MemoryError):
        return (
            f"fatal: resources: {errors.out_of_memory(error)}; try a smaller mesh (`pysprings check` estimates)",
            errors.EXIT_RESOURCES,
        )
    if isinstance(error, errors.ResourceError):
        return f"fatal: resources: {error}", errors.EXIT_RESOURCES
    if isinstance(error, OSError) and error.errno == errno.ENAMETOOLONG:
        name = errors.printable(error.filename or "a path")
        return (
            f"fatal: user input: {name[: errors.MOST_LETTERS]}: is longer than the system allows",
            errors.EXIT_USER_INPUT,
        )
    if isinstance(error, OSError):
        what = f"{error.filename}: {error.strerror}" if error.filename and error.strerror else str(error)
        return f"fatal: resources: {errors.printable(what)}", errors.EXIT_RESOURCES
    if isinstance(error, ModuleNotFoundError) and (error.name or "").partition(".")[0] not in OURS:
        return f"fatal: resources: this needs the package {error.name}, which is not installed", errors.EXIT_RESOURCES
    engine = sys.modules.get("fe_engine.errors")  # errors of the engine that no caller has converted
    if engine and isinstance(error, engine.NotConverged):
        return f"fatal: not converged: {errors.printable(error)}", errors.EXIT_NOT_CONVERGED
    if engine and isinstance(error, engine.MeshError):
        return f"fatal: user input: mesh: {errors.printable(error)}", errors.EXIT_USER_INPUT
    if engine and isinstance(error, engine.SettingError):
        return f"fatal: user input: {errors.printable(error)}", errors.EXIT_USER_INPUT
    trace = "" if DEBUG.get() else "; `pysprings --debug ...` shows where"
    return f"fatal: bug: {type(error).__name__}: {errors.printable(error)}\nplease report it{trace}", errors.EXIT_BUG
