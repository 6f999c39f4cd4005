# SPDX-License-Identifier: MIT
"""What a claim of the paper comes to: our figure, whether each item of its criterion holds, and the words for it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from validation.paper.cases import DEPTHS

AGREES, PARTLY, DIFFERS, UNKNOWN = "agrees", "partly", "differs", "not reached"
Paths = Mapping[str, xr.Dataset]  # by name of the case; cases that have not run are absent


@dataclass(frozen=True)
class Finding:
    """What came out: figures in words, whether each item of the criterion holds (None: not known), why."""

    figure: str
    holds: Sequence[bool | None]
    reason: str = ""

    @property
    def verdict(self) -> str:
        """Judgement of a claim: agrees where all items hold, differs where none does."""
        known = [item for item in self.holds if item is not None]
        if len(known) < len(self.holds) or not known:
            return UNKNOWN
        return AGREES if all(known) else PARTLY if any(known) else DIFFERS


def within(value: float, low: float, high: float) -> bool | None:
    """Return whether a value lies in a range; None where it is unknown."""
    return bool(low <= value <= high) if np.isfinite(value) else None


def joined(values: Sequence[float] | np.ndarray, form: str = ".2f") -> str:
    """Write numbers in a row."""
    return ", ".join(format(float(value), form) for value in values)


def mm(length: float) -> str:
    """Write a length [m] in mm."""
    if not np.isfinite(length):
        return "never"
    return f"{1e3 * length:.2g} mm" if abs(length) >= 5e-8 else "0 mm"


def at_depths() -> str:
    """Write the paper's depths."""
    return f"at {', '.join(f'{d:g}' for d in DEPTHS)} m"


def every(items: Sequence[bool | None]) -> bool | None:
    """Return whether all items hold; None where one is unknown."""
    return None if any(item is None for item in items) else all(items)


def which(holds: Sequence[bool | None], words: Sequence[str]) -> str:
    """Return the words of the items that do not hold."""
    return "; ".join(word for item, word in zip(holds, words, strict=True) if not item)


def rises(values: Sequence[float]) -> bool | None:
    """Return whether values rise from one to the next; None where one is unknown."""
    return bool((np.diff(values) > 0.0).all()) if np.isfinite(values).all() else None
