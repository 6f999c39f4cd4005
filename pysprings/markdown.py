# SPDX-License-Identifier: MIT
"""Tables in Markdown, for the documents."""

from __future__ import annotations

from collections.abc import Sequence


def markdown(heads: Sequence[str], rows: Sequence[Sequence[str]], numbers: bool = False) -> str:
    """Return a table; with ``numbers``, all columns but the first are set to the right."""
    rules = ["---", *["--:" if numbers else "---"] * (len(heads) - 1)]
    lines = [heads, rules, *([_safe(text) for text in row] for row in rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def _safe(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")
