# SPDX-License-Identifier: MIT
"""A clash of values that are valid one by one."""

from __future__ import annotations

from typing import NamedTuple

from pysprings.scene.positions import KeyPath


class Clash(NamedTuple):
    """Keys (as in TOML) whose values do not go together, the one to blame first, and why."""

    keys: tuple[KeyPath, ...]
    message: str
