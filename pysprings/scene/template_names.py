# SPDX-License-Identifier: MIT
"""Names of the scene templates (light: `--help` lists them)."""

from __future__ import annotations

from pathlib import Path

FOLDER = Path(__file__).parent / "templates"


def template_names() -> list[str]:
    """Return the names of the templates, sorted."""
    return sorted(file.stem for file in FOLDER.glob("*.toml"))
