# SPDX-License-Identifier: MIT
"""What bricks cost with SuperLU beside Pardiso: fitted laws of time and memory."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fe_engine.linear.backends import available_backends

if TYPE_CHECKING:
    from pysprings.scene.load import Scene

# Drained, to 2.5 mm, CPU seconds with SuperLU and with Pardiso: `coarse` (4,631 unknowns) 11.9 and 4.1, `medium`
# (13,863) 81.6 and 13.8; peak memory 0.45 and 0.38 GB, 1.08 and 0.59 GB. Power laws through both.
_UNKNOWNS, _TIME, _TIME_EXPONENT = 4631.0, 2.9, 0.65
_BYTES, _BYTES_EXPONENT = 0.07e9, 1.77


def uses_superlu(scene: Scene) -> bool:
    """Return whether SuperLU factorises the matrices of a scene of bricks; a series has small ones of its own."""
    if scene.discretisation == "fourier":
        return False
    return scene.solver.linear == "superlu" or available_backends()[0] == "superlu"


def superlu_time(unknowns: int) -> float:
    """Return the time of an increment with SuperLU over that with Pardiso, at least 1."""
    return max(1.0, _TIME * (unknowns / _UNKNOWNS) ** _TIME_EXPONENT)


def superlu_bytes(unknowns: int) -> float:
    """Return the memory that SuperLU needs beyond Pardiso's, in bytes."""
    return _BYTES * (unknowns / _UNKNOWNS) ** _BYTES_EXPONENT
