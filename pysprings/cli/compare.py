# SPDX-License-Identifier: MIT
"""`pysprings compare`: the prediction with the springs beside the full model."""

from __future__ import annotations

from typing import Annotated

import typer

from pysprings.cli.inputs import springs_of
from pysprings.cli.options import Json, OneSpringSet, Result
from pysprings.cli.support import print_json, refuse


def compare(
    result: Result,
    spring_set: OneSpringSet = None,
    slices: Annotated[bool, typer.Option("--slices", help="error and cost by number of depth slices instead")] = False,
    cycles: Annotated[
        bool,
        typer.Option("--cycles", help="paths that turn back instead: errors, and peaks, work and damping by cycle"),
    ] = False,
    as_json: Json = False,
) -> None:
    """Set the prediction with the springs beside the full model, by path: eta and errors."""
    tree = springs_of(result)
    if slices and cycles:
        refuse("--cycles", "give either this or --slices")
    if cycles:
        from pysprings.macro import cycles_text as by_cycle

        found = by_cycle.compare_cycles(tree, spring_set)
        if as_json:
            print_json(by_cycle.to_dict(found))
        else:
            print(by_cycle.to_text(found), end="")
        return
    if slices:
        from pysprings.macro import slices as by_slices

        table = by_slices.slice_convergence(tree, springs_kind=spring_set)
        if as_json:
            print_json({"rows": table.to_dict(orient="records")})
        else:
            print(by_slices.to_text(table), end="")
        return
    from pysprings.macro.comparison import compare as compare_models
    from pysprings.macro.comparison_text import to_dict, to_text

    frame = compare_models(tree, spring_set)
    if as_json:
        print_json(to_dict(frame))
    else:
        print(to_text(frame), end="")
