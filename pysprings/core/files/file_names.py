# SPDX-License-Identifier: MIT
"""Names that become names of files, and that a system refuses or takes for something else (light)."""

from __future__ import annotations

_DEVICES = {"CON", "PRN", "AUX", "NUL", "CONIN$", "CONOUT$"}
_DEVICES |= {f"{kind}{number}" for kind in ("COM", "LPT") for number in "0123456789\u00b9\u00b2\u00b3"}


def is_device(name: str) -> bool:
    """Return True if Windows takes a file of this name, with any ending, for a device."""
    return name.split(".")[0].rstrip(" ").upper() in _DEVICES
