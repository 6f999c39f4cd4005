# SPDX-License-Identifier: MIT
"""Errors of the engine: what went wrong, where, and with which history."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any


class FEError(Exception):
    """Base of all errors raised by the engine."""


class MeshError(FEError):
    """A mesh that cannot be computed on (inverted element, dangling node, bad set)."""


class ModelError(FEError):
    """A model whose parts contradict each other."""


class LawError(FEError):
    """A constitutive update failed; the message names element, point and coordinates."""


class SettingError(FEError):
    """An environment variable that a library would not take."""


class LinearSolverError(FEError):
    """A factorisation failed or its solution does not satisfy the equations."""


@dataclass
class NotConverged(FEError):
    """An increment that Newton could not close.

    Attributes
    ----------
    reason : str
        One line for people.
    place : str
        Where the largest residual or correction stands.
    history : list of dict
        One entry per Newton iteration of the last attempt.
    refused : bool
        The increment converged, and the caller of the driver did not accept it (`Driver.refusal`).
    """

    reason: str
    place: str = ""
    history: list[dict[str, Any]] = field(default_factory=list)
    refused: bool = False

    def __str__(self) -> str:
        where = f" ({self.place})" if self.place else ""
        tail = ", ".join(f"{row['residual']:.1e}" for row in self.history[-6:])
        return f"{self.reason}{where}; last residuals: {tail}" if tail else f"{self.reason}{where}"
