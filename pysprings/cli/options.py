# SPDX-License-Identifier: MIT
"""Options that several commands share (light)."""

from __future__ import annotations

from typing import Any

import typer

from pysprings.core.registry import Item, Registry


def named(flag: str, registry: Registry[Item], words: str, cases: list[Item] | None = None) -> Any:
    """Return an option whose value is a name of a registry; help lists `cases` (default: those of this package).

    The command validates the value with `Registry.find`, so that names of other packages are accepted.
    """
    shown = "|".join(case.name for case in (registry.built_in if cases is None else cases))
    return typer.Option(flag, metavar=f"[{shown}]", help=words, autocompletion=lambda: registry.names())
