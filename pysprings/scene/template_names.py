# SPDX-License-Identifier: MIT
"""Names of the scene templates (light: `--help` lists them)."""

from __future__ import annotations

from importlib.resources import files


def template_names() -> list[str]:
    """Return the names of the templates, sorted."""
    entries = files("pysprings.scene").joinpath("templates").iterdir()
    return sorted(item.name.removesuffix(".toml") for item in entries if item.name.endswith(".toml"))
