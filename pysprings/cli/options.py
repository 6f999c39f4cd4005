# SPDX-License-Identifier: MIT
"""Options that several commands share (light)."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from pysprings.core.registry import Item, Registry
from pysprings.core.words import Discretisation, MeshPreset, TargetError
from pysprings.macro.spring_sets import SPRING_SETS

SceneFile = Annotated[Path, typer.Argument(metavar="SCENE", help="scene file (TOML)")]
Result = Annotated[Path, typer.Argument(metavar="RESULT", help="folder of a run, or its springs.nc")]
Mesh = Annotated[MeshPreset | None, typer.Option("--mesh", help="mesh preset instead of the scene's")]
Series = Annotated[
    Discretisation | None, typer.Option("--discretisation", help="bricks or Fourier series instead of the scene's")
]
Target = Annotated[
    TargetError | None, typer.Option("--target-error", help="the cheapest setting with this error, instead of a mesh")
]
Changes = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="KEY=VALUE", help='value instead of the scene\'s, e.g. soil.young_modulus="80 MPa"; repeated'
    ),
]
Json = Annotated[bool, typer.Option("--json", help="one JSON document on stdout")]


def named(flag: str, registry: Registry[Item], words: str, cases: list[Item] | None = None) -> Any:
    """Return an option whose value is a name of a registry; help lists `cases` (default: those of this package).

    The command validates the value with `Registry.find`, so that names of other packages are accepted.
    """
    shown = "|".join(case.name for case in (registry.built_in if cases is None else cases))
    return typer.Option(flag, metavar=f"[{shown}]", help=words, autocompletion=lambda: registry.names())


_SETS = list(reversed(SPRING_SETS.built_in))
SpringSet = Annotated[
    str | None,
    named(
        "--springs",
        SPRING_SETS,
        f"springs to use: {', '.join(f'{each.name} ({each.description})' for each in _SETS)} "
        "\\[default: fan if present, else full]",
        _SETS,
    ),
]
OneSpringSet = Annotated[str | None, named("--springs", SPRING_SETS, "only these springs \\[default: all]", _SETS)]
