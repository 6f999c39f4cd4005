# SPDX-License-Identifier: MIT
"""The command `pysprings`: registration of its commands, which import heavy libraries when they run.

Data go to stdout, messages to stderr.
"""

import functools
import importlib
import os
import sys
from collections.abc import Callable
from typing import Annotated

import typer

from pysprings.cli.guard import DEBUG, guarded
from pysprings.cli.options import option
from pysprings.cli.support import Once
from pysprings.core.jit import choose_for_command
from pysprings.core.process import open_missing_streams
from pysprings.core.version import __version__

EPILOG = (
    "Exit codes: 0 ok; 1 a bug; 2 user input; 3 not converged (partial results saved); 4 resources; 130 interrupted."
)

# command: its module in this package; the function has the name of the command
COMMANDS = {
    "init": "scene",
    "check": "scene",
    "ground": "ground",
    "run": "run",
    "compile": "compiling",
    "springs": "springs",
    "export": "springs",
    "soildyn": "springs",
    "predict": "predict",
    "compare": "compare",
    "diff": "compare",
    "design": "design",
    "capacity": "capacity",
    "element": "element",
    "sweep": "sweep",
    "atlas": "atlas",
    "size": "size",
    "explore": "explore",
    "accuracy": "studies",
    "stability": "studies",
}

WITH_DASK = ("sweep", "atlas", "size")  # commands that Dask runs, or that read studies lazily
HELP: tuple[list[str], ...] = ([], ["-h"], ["--help"])  # arguments that ask for the list of commands


def _listed(command: Callable[..., None]) -> Callable[[], None]:
    """Return a command with the description of another, for the list of commands: it has no options to prepare."""

    def listed() -> None: ...

    listed.__name__, listed.__doc__ = command.__name__, command.__doc__
    return listed


@functools.cache
def application(command: str | None = None, listed: bool = False) -> typer.Typer:
    """Return the command line with all commands, or with one of `COMMANDS`, whose module alone is then imported.

    With ``listed`` it only lists them: no command has options.
    """
    app = typer.Typer(
        help="p-y springs of suction caissons from a 3D finite-element model, and the prediction made with them.",
        epilog=EPILOG,
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,  # texts as they are, in half the time
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback()(_options)
    for name in COMMANDS if command is None else (command,):
        function = getattr(importlib.import_module(f"pysprings.cli.{COMMANDS[name]}"), name)
        app.command(cls=Once)(_listed(function) if listed else guarded(function))
    return app


def _print_version(requested: bool) -> None:
    if requested:
        from pysprings.core.licences import installed, text

        print(f"pysprings {__version__}")
        print(text(installed()))
        raise typer.Exit


def _options(
    _version: Annotated[
        bool,
        typer.Option(
            "--version", help="Print the version and the licences, and exit.", is_eager=True, callback=_print_version
        ),
    ] = False,
    debug: Annotated[bool, option("--debug", "Show the traceback of an error.")] = False,
) -> None:
    DEBUG.set(debug)


def main() -> None:
    """Run the command line."""
    open_missing_streams()
    arguments = sys.argv[1:]
    choose_for_command(arguments)
    first = arguments[0] if arguments else ""
    if first in COMMANDS and "xarray" not in sys.modules:  # it would load them with the first text or index
        for name in ("pint", *(() if first in WITH_DASK else ("dask",))):  # 0.1 s, 0.3 s
            sys.modules.setdefault(name, None)  # type: ignore[arg-type]  # "not installed", for importlib and xarray
    only_listed = arguments in HELP and "_PYSPRINGS_COMPLETE" not in os.environ
    application(first if first in COMMANDS else None, only_listed)(prog_name="pysprings")


if __name__ == "__main__":
    main()
