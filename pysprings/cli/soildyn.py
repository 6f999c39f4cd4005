# SPDX-License-Identifier: MIT
"""`pysprings soildyn`: the foundation library for OpenFAST, built with the compiler of the system."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pysprings.cli.folders import refuse_no_folder


def soildyn(
    out: Annotated[Path, typer.Argument(metavar="DIR", help="folder for the library")],
    compiler: Annotated[
        str | None, typer.Option("--compiler", metavar="COMMAND", help="C compiler \\[default: CC, cc, gcc or clang]")
    ] = None,
) -> None:
    """Build the library that SoilDyn (OpenFAST) loads for springs of `export --to openfast`."""
    from pysprings.results.exporters.soildyn.library import build

    refuse_no_folder(out)
    print(build(out, compiler))
