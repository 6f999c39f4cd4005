# SPDX-License-Identifier: MIT
"""Savings in words; what is no saving says nothing."""

from __future__ import annotations

from typing import Any

import pytest

from pysprings.model.forecast.omissions import saved_text


@pytest.mark.parametrize(
    ("saved", "text"),
    [
        ({"basis": "laws", "unknowns": 1234, "time_share": 0.616}, "1,234 unknowns, 62 % of the time (laws)"),
        ({"basis": "b", "memory_bytes": 1.1e9, "disk_bytes": 32.4e6}, "1.1 GB of memory, 32 MB on disk (b)"),
        ({"basis": "b", "memory_bytes": 5e3, "disk_bytes": 12}, "5 kB of memory, 12 bytes on disk (b)"),
        ({"basis": "b", "unknowns": 0, "memory_bytes": 0, "time_share": None}, ""),
        (None, ""),
        ("much", ""),
        ({"unknowns": "many", "memory_bytes": float("nan"), "disk_bytes": True, "time_share": -1.0}, ""),
        ({"basis": "b", "unknowns": 10**400, "memory_bytes": float("inf")}, ""),
    ],
)
def test_savings_in_words(saved: Any, text: str) -> None:
    assert saved_text(saved) == text
