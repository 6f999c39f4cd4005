# SPDX-License-Identifier: MIT
"""Options that several commands share (light)."""

from pathlib import Path
from typing import Annotated, Any

import typer

from pysprings.cli.support import WRONG, quantities, refuse
from pysprings.core.errors import UserInputError
from pysprings.core.registry import Item, Registry
from pysprings.core.words import Discretisation, FigureFormat, Figures, MeshPreset, TargetError
from pysprings.macro.spring_sets import SPRING_SETS


def option(flag: str, words: str, metavar: str | None = None) -> Any:
    """Return an option with its help, and its value in words where its type does not say it."""
    return typer.Option(flag, metavar=metavar, help=words)


def argument(metavar: str, words: str) -> Any:
    """Return an argument with its help."""
    return typer.Argument(metavar=metavar, help=words)


SceneFile = Annotated[Path, argument("SCENE", "scene file (TOML)")]
Result = Annotated[Path, argument("RESULT", "folder of a run, or its springs.nc")]
Mesh = Annotated[MeshPreset | None, option("--mesh", "mesh preset instead of the scene's")]
Series = Annotated[Discretisation | None, option("--discretisation", "bricks or Fourier series instead of the scene's")]
Target = Annotated[
    TargetError | None, option("--target-error", "run on finer meshes until the run's own estimate is within it")
]
EstimateError = Annotated[
    bool | None,
    option(
        "--estimate-error/--no-estimate-error",
        "also run a coarser mesh, and estimate the error from both [default: with Fourier series]",
    ),
]
Changes = Annotated[
    list[str] | None,
    option("--set", 'value instead of the scene\'s, e.g. soil.young_modulus="80 MPa"; repeated', "KEY=VALUE"),
]
Estimates = Annotated[
    list[str] | None,
    option(
        "--estimate", "values of ranges that count; repeated: a folder each, and all side by side", "[low|best|high]"
    ),
]
DrawnFigures = Annotated[Figures | None, option("--figures", "none: no picture")]
NoFigures = Annotated[bool, option("--no-figures", "draw no pictures: --figures none")]
Format = Annotated[FigureFormat, option("--figure-format", "format of the pictures")]
Jobs = Annotated[
    int | None,
    typer.Option("--jobs", metavar="N", min=1, help="worker processes; 1: none [default: the cores of the machine]"),
]
Json = Annotated[bool, option("--json", "one JSON document on stdout")]


def formats_of(figures: Figures | None, none: bool, wanted: FigureFormat) -> tuple[str, ...]:
    """Return the formats of the only picture that a command draws; none where no picture is asked for."""
    return () if drawn(figures, none) == "none" else tuple(wanted.split(","))


def drawn(figures: Figures | None, none: bool) -> Figures | None:
    """Return which pictures are asked for; refuse `--no-figures` beside another `--figures`."""
    if none and figures not in (None, "none"):
        refuse("--no-figures", f"give either this or --figures {figures}")
    return "none" if none else figures


_METAVARS = {"N": "FORCE", "N m": "MOMENT", "m": "LENGTH", "rad": "ANGLE", "m/s": "VELOCITY", "s": "TIME"}


def quantity(flag: str, unit: str, example: str, words: str) -> Any:
    """Return an option whose value is a quantity in SI; what is wrong is refused with that of all such options."""

    def read(text: str) -> float | None:
        try:
            return quantities({flag: (text, unit, example)})[flag]
        except UserInputError as error:
            WRONG.extend(error.problems)
            return None

    return typer.Option(flag, metavar=_METAVARS[unit], help=words, parser=read)


def named(flag: str, registry: Registry[Item], words: str, cases: list[Item] | None = None) -> Any:
    """Return an option whose value is a name of a registry; help lists `cases` (default: all).

    The command validates the value with `Registry.find`, so that names of other packages are accepted.
    """
    shown = "|".join(case.name for case in (registry if cases is None else cases))
    return typer.Option(flag, metavar=f"[{shown}]", help=words, autocompletion=lambda: registry.names())


_SETS = [*SPRING_SETS][::-1]
SpringSet = Annotated[
    str | None,
    named(
        "--springs",
        SPRING_SETS,
        f"springs to use: {', '.join(f'{each.name} ({each.description})' for each in _SETS)} "
        "[default: fan if present, else full]",
        _SETS,
    ),
]
Rate = Annotated[
    float | None, quantity("--rate", "m/s", "0.1 mm/s", "of rho = |(u, rotation*L)|, for springs from several rates")
]
OneSpringSet = Annotated[str | None, named("--springs", SPRING_SETS, "only these springs [default: all]", _SETS)]
