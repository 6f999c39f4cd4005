# SPDX-License-Identifier: MIT
"""A row of the verification table, and the small arithmetic that the cases share."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np


@dataclass(frozen=True)
class Row:
    """One figure of ours beside a reference.

    Attributes
    ----------
    case, quantity, unit : what is compared; a ratio or a count has no unit ("").
    ours, reference : the two figures, in ``unit``.
    source : where the reference comes from.
    tolerance : largest difference allowed, relative to the reference (absolute where the reference is 0); None
        where the row is only shown beside the others.
    limit : "" where the reference is a value to meet; "at most" or "at least" where it is a limit, which no tolerance
        softens.
    """

    case: str
    quantity: str
    unit: str
    ours: float
    reference: float
    source: str
    tolerance: float | None
    limit: Literal["", "at most", "at least"] = ""

    @property
    def difference(self) -> float:
        """Ours minus reference over the size of the reference, or the plain difference from a reference of 0."""
        plain = self.ours - self.reference
        return plain / abs(self.reference) if self.reference else plain

    @property
    def holds(self) -> bool:
        """Whether the difference is within the tolerance or the limit is kept; what is not a number never holds."""
        if self.limit:
            return self.ours <= self.reference if self.limit == "at most" else self.ours >= self.reference
        return self.tolerance is None or bool(abs(self.difference) <= self.tolerance)

    @classmethod
    def at_most(cls, case: str, quantity: str, ours: float, limit: float, source: str) -> Row:
        """A figure without a unit that may not exceed a limit."""
        return cls(case, quantity, "", ours, limit, source, None, "at most")

    @classmethod
    def at_least(cls, case: str, quantity: str, ours: float, limit: float, source: str) -> Row:
        """A figure without a unit that may not be below a limit."""
        return cls(case, quantity, "", ours, limit, source, None, "at least")

    @classmethod
    def error(cls, case: str, quantity: str, error: float, source: str, tolerance: float) -> Row:
        """A figure that should be nothing: an error, a count of faults."""
        return cls(case, quantity, "", error, 0.0, source, tolerance)

    def __str__(self) -> str:
        allowed = self.limit or ("not judged" if self.tolerance is None else f"allowed {self.tolerance:.1e}")
        return (
            f"{self.case} | {self.quantity} [{self.unit}]: {self.ours:.10g}, reference {self.reference:.10g}, "
            f"difference {self.difference:.2e}, {allowed}"
        )


def failures(rows: Iterable[Row]) -> list[str]:
    """Rows out of tolerance, as text for an assertion message."""
    return [str(row) for row in rows if not row.holds]


HEADINGS = ("case", "quantity", "ours", "reference", "difference", "source")


def cells(row: Row) -> tuple[str, ...]:
    """The row as text, in the order of HEADINGS."""
    unit = f", {row.unit}" if row.unit else ""
    shown_only = row.tolerance is None and not row.limit
    note = " (shown only)" if shown_only else "" if row.holds else " OUT OF TOLERANCE"
    reference = f"{row.limit} {_number(row.reference)}".lstrip()
    numbers = (_number(row.ours), reference, ("-" if row.limit else _difference(row)) + note)
    return (row.case, row.quantity + unit, *numbers, row.source)


def _number(value: float) -> str:
    if not np.isfinite(value) or (value == round(value) and abs(value) < 1000.0):
        return f"{value:.0f}"
    size = abs(value)
    return f"{value:,.0f}" if 1000.0 <= size < 1e7 else f"{value:.5g}" if size >= 1e-4 else f"{value:.3e}"


def _difference(row: Row) -> str:
    """Difference in percent; nothing beside a reference of 0, where ours is the difference."""
    if row.reference == 0.0 or not np.isfinite(row.difference):
        return "-"
    if row.difference > 9.0:
        return f"{row.ours / row.reference:.0f}-fold"
    percent = 100.0 * row.difference
    return f"{percent:+.2f} %" if abs(percent) >= 0.005 else f"{percent:+.0e} %" if percent else "0 %"


def fitted_rate(size: Iterable[float], error: Iterable[float]) -> float:
    """Slope of log(error) over log(size): the order of convergence."""
    x, y = np.log(np.array([*size], dtype=float)), np.log(np.abs(np.array([*error], dtype=float)))
    return float(np.polyfit(x, y, 1)[0])


def worst(ours: np.ndarray, reference: np.ndarray | float) -> float:
    """Largest difference between two arrays, relative to the largest reference."""
    return float(np.max(np.abs(ours - np.asarray(reference))) / np.max(np.abs(reference)))
