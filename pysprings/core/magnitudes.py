# SPDX-License-Identifier: MIT
"""Largest numbers that a caisson can mean, by unit: beyond them arithmetic overflows; pressures of cavitation."""

import math

# Generous by some orders of magnitude; products of a few of them stay far from overflow.
LARGEST = {
    "m": 1e5, "rad": 1e2, "s": 1e15, "m/s": 1e5,
    "N": 1e15, "N m": 1e18, "N/m": 1e15, "N m/m": 1e18, "N m/rad": 1e21, "Pa": 1e15,
    "1": 1e9,
}  # fmt: skip
# A length or rotation that is not zero is at least this: what rounding leaves of zero passes, quotients stay finite.
SMALLEST = {"m": 1e-60, "rad": 1e-60}
SMALLEST_AT_ALL = 1e-150  # of any number that is not zero: quotients of two stay finite

# Motion under a load that counts as failure: displacement over diameter, and rotation [rad] (default of `[limit]`)
MOST_MOVED, MOST_TURNED = 0.1, math.radians(5.0)

SMALLEST_LOAD = 1.0  # N, N m: below it, millinewtons were meant to be meganewtons

_ENDINGS = {
    "_N_per_m": "N/m", "_Nm_per_m": "N m/m", "_Nm": "N m", "_N": "N", "_rad": "rad", "_m": "m", "_s": "s",
}  # fmt: skip


def unit_of_column(name: str) -> str:
    """Return the unit of a column of a table by the end of its name; "1" for a pure number."""
    return next((unit for ending, unit in _ENDINGS.items() if name.endswith(ending)), "1")


def fault(value: float, unit: str) -> str:
    """Return the fault in the size of a number in a unit of `LARGEST`; empty if there is none."""
    if not math.isfinite(value):
        return "is not a finite number"
    if abs(value) > LARGEST[unit]:
        return f"is not in [{-LARGEST[unit]:.0e}, {LARGEST[unit]:.0e}]{_with(unit)}"
    if 0.0 < abs(value) < SMALLEST.get(unit, 0.0):
        return f"is too small: at least {SMALLEST[unit]:.0e}{_with(unit)}, or 0"
    return ""


def slip(text: str, value: float, unit: str) -> str:
    """Return a message on a load written in millinewtons, which is next to nothing; empty for others."""
    if "mN" in text and 0.0 < abs(value) < SMALLEST_LOAD:
        return f"is {value:.3g} {unit}: m is milli, M is mega"
    return ""


def _with(unit: str) -> str:
    return "" if unit == "1" else f" {unit}"


ATMOSPHERE = 101_325.0  # Pa, standard atmosphere (ISO 2533)
VAPOUR = 2_339.0  # Pa, saturated vapour of water at 20 deg C (IAPWS)
