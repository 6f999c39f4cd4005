# SPDX-License-Identifier: MIT
"""What an omission saves, in words; takes any record, also one that somebody else has written."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

_BYTES = (("GB", 1e9), ("MB", 1e6), ("kB", 1e3))
_BYTES_OF = {"memory_bytes": "of memory", "disk_bytes": "on disk"}


def saved_text(saved: Any) -> str:
    """Return one line, "1,234 unknowns, 0.30 GB of memory, 62 % of the time (fitted laws)"; "" for nothing."""
    if not isinstance(saved, Mapping):
        return ""
    parts = []
    if unknowns := _positive(saved.get("unknowns")):
        parts.append(f"{unknowns:,.0f} unknowns")
    parts += [f"{_size(value)} {where}" for key, where in _BYTES_OF.items() if (value := _positive(saved.get(key)))]
    if share := _positive(saved.get("time_share")):
        parts.append(f"{100.0 * share:.2g} % of the time")
    return f"{', '.join(parts)} ({saved.get('basis', '')})" if parts else ""


def _positive(value: Any) -> float:
    """Return a finite number above 0, else 0."""
    plain = isinstance(value, int | float) and not isinstance(value, bool)
    return float(value) if plain and abs(value) < 1e300 and math.isfinite(value) and value > 0 else 0.0


def _size(value: float) -> str:
    for unit, size in _BYTES:
        if value >= size:
            return f"{value / size:.2g} {unit}" if value < 10 * size else f"{value / size:,.0f} {unit}"
    return f"{value:.0f} bytes"
