# SPDX-License-Identifier: MIT
"""The SoilDyn library called as OpenFAST calls it: arrays of the caller, everything by reference."""

import ctypes
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

INITIALISE, FORCE, STIFFNESS = 1, 2, 3
LETTERS = 45
needs_compiler = pytest.mark.skipif(
    not any(shutil.which(name) for name in ("cc", "gcc", "clang")), reason="there is no C compiler"
)


class Point:
    """A point of SoilDyn with the arrays that SoilDyn keeps for it."""

    def __init__(self, library: Path, springs: Path | str) -> None:
        self.call = ctypes.CDLL(str(library)).INTERFACEFOUNDATION
        self.call.restype = None
        self.names = ctypes.create_string_buffer(str(springs).encode().ljust(LETTERS), LETTERS)
        self.props, self.state = np.full((200, 100), np.nan), np.full((100, 12), np.nan)
        self.printed = np.zeros((100, 12), dtype=np.int32)
        self.force, self.D = np.zeros(6), np.zeros((6, 6))
        self.code = self.ask(INITIALISE, np.zeros(6))

    def ask(self, task: int, motion: np.ndarray) -> int:
        """Call the library; return its error code, 0 for none."""
        d = np.ascontiguousarray(motion, dtype=float)
        number, codes = ctypes.c_int(-1), np.full(100, -1, dtype=np.int32)
        arrays = (self.props, self.state, self.printed, d, self.force, self.D)
        self.call(
            self.names,
            self.names,
            ctypes.byref(ctypes.c_int(task)),
            ctypes.byref(number),
            codes.ctypes,
            *(a.ctypes for a in arrays),
        )
        assert number.value == (codes[0] != 0)
        return int(codes[0])

    def forces(self, motion: np.ndarray) -> np.ndarray:
        """Return the forces (6,) at a motion (6,) in the frame of OpenFAST."""
        assert self.ask(FORCE, motion) == 0
        return self.force.copy()

    def stiffness(self, motion: np.ndarray) -> np.ndarray:
        """Return the stiffness (6, 6) at a motion."""
        assert self.ask(STIFFNESS, motion) == 0
        return self.D.T.copy()  # column-major


PointOn = Callable[..., Point]  # the fixture of tests/pysprings/results/conftest.py
