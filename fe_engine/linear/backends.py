# SPDX-License-Identifier: MIT
"""Sparse direct solvers behind one interface.

A backend analyses the fixed pattern once, factorises values on it, and solves for several right-hand sides.
"""

from __future__ import annotations

import ctypes
import importlib.util
import os
import re
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numba import get_num_threads
from scipy.sparse import csr_matrix

from fe_engine.errors import LinearSolverError
from fe_engine.memory import require

SUPERLU_COMFORT = 30_000


class Backend(Protocol):
    """What a sparse direct solver offers."""

    name: str

    def factorise(self, matrix: csr_matrix) -> None:
        """Factorise; the pattern is the same at every call."""

    def solve(self, rhs: np.ndarray) -> np.ndarray:
        """Solve for rhs (n,) or (n, k)."""

    def close(self) -> None:
        """Release the memory of the factors."""

    def versions(self) -> dict[str, str]:
        """Return what last digits depend on beside SciPy, by name: versions, numbers of threads."""


class SuperLU:
    """SciPy's SuperLU: everywhere available, one thread."""

    name = "superlu"

    def factorise(self, matrix: csr_matrix) -> None:
        """Factorise with the ordering of A^T + A, which suits a symmetric pattern."""
        from scipy.sparse.linalg import splu

        try:
            self._factors = splu(
                matrix.astype(float, copy=False).tocsc(),
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.1,
                options={"SymmetricMode": True},
            )
        except RuntimeError as error:
            raise LinearSolverError(f"SuperLU: {error}") from error

    def solve(self, rhs: np.ndarray) -> np.ndarray:
        """Solve for rhs (n,) or (n, k)."""
        return self._factors.solve(np.asarray(rhs, dtype=float))

    def close(self) -> None:
        """Drop the factors."""
        self._factors = None

    def versions(self) -> dict[str, str]:
        """Return nothing: SciPy's version is that of SuperLU."""
        return {}


class Pardiso:
    """MKL Pardiso through pypardiso; symbolic analysis once, values many times.

    Matching and scaling permutations depend on the values of the first matrix; they are switched off, so that
    the analysis stays valid for every later tangent (the diagonal of a soil tangent is strong).
    """

    name = "pardiso"
    _MATRIX_TYPE = 11  # real, not symmetric

    def __init__(self, single: bool = False) -> None:
        _point_at_mkl()
        import pypardiso

        self._solver = pypardiso.PyPardisoSolver(mtype=self._MATRIX_TYPE)
        self.pardiso = self._solver._mkl_pardiso  # the C function
        self._type = np.float32 if single else np.float64
        self._analysed = False
        self._remaining = np.zeros(0, dtype=np.int64)
        for index, value in (_IPARM | {_SINGLE: int(single)}).items():
            self._solver.set_iparm(index, value)

    def keep(self, equations: np.ndarray) -> None:
        """Eliminate all but these equations (m,) from now on: ``schur`` is what is left of the matrix then (m, m)."""
        self._remaining = np.asarray(equations, dtype=np.int64)
        self._solver.set_iparm(_SCHUR, 2)  # 2: with the factors of the others, for `solve_with`

    def factorise(self, matrix: csr_matrix) -> None:
        """Factorise numerically; the first call also analyses the pattern."""
        # shared with the matrix, whose entries the next tangent overwrites: solves come before that
        self._values = np.ascontiguousarray(matrix.data, dtype=self._type)
        self._starts = np.ascontiguousarray(matrix.indptr, dtype=np.int32)
        self._columns = np.ascontiguousarray(matrix.indices, dtype=np.int32)
        n, m = matrix.shape[0], len(self._remaining)
        if m:
            self._solver.perm = np.zeros(n, dtype=np.int32)
            self._solver.perm[self._remaining] = 1
            require(float(m * m * np.dtype(self._type).itemsize), f"what is left of the matrix ({m:,} equations)")
        into, nothing = np.zeros((m, m), dtype=self._type) if m else None, np.zeros((n, 1))
        if not self._analysed:
            self.call(11, nothing, into)
            self._analysed = True  # `close` has something to release
            require(self._needed(), f"the factorisation of {n:,} unknowns")
        schur = self.call(22, nothing, into)
        if m:
            self.schur = schur

    def solve(self, rhs: np.ndarray) -> np.ndarray:
        """Solve for rhs (n,) or (n, k)."""
        return self.call(33, rhs)

    def solve_with(self, middle: Callable[[np.ndarray], np.ndarray], rhs: np.ndarray) -> np.ndarray:
        """Solve for rhs (n,) or (n, k); ``middle`` solves for what is left of it (m,), (m, k) of the kept equations."""
        reduced = self.call(331, rhs)
        reduced[self._remaining] = middle(reduced[self._remaining])
        return self.call(333, reduced)

    def call(self, phase: int, rhs: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
        """Call a phase of Pardiso itself: the wrapper copies the pattern each time, half the cost of a solve."""
        rhs = np.asfortranarray(rhs, dtype=self._type)
        x, error, solver = np.zeros_like(rhs) if out is None else out, ctypes.c_int32(0), self._solver
        one, kind, what, n, n_rhs, silent = (
            ctypes.c_int32(v) for v in (1, self._MATRIX_TYPE, phase, len(rhs), rhs.size // len(rhs), 0)
        )
        starts, columns, order, settings = (
            a.ctypes.data_as(ctypes.POINTER(ctypes.c_int32))
            for a in (self._starts, self._columns, solver.perm, solver.iparm)
        )
        values, given, into = (a.ctypes.data_as(ctypes.c_void_p) for a in (self._values, rhs, x))
        handle = solver.pt.ctypes.data_as(ctypes.POINTER(solver._pt_type[0]))
        self.pardiso(
            handle, one, one, kind, what, n, values, starts, columns, order, n_rhs, settings, silent, given, into,
            error,
        )  # fmt: skip
        if error.value == _NO_MEMORY:  # a smaller step would not help
            raise MemoryError("Pardiso: not enough memory")
        if error.value != 0:
            raise LinearSolverError(f"Pardiso: error {error.value}")
        return np.ascontiguousarray(x)

    def versions(self) -> dict[str, str]:
        """Return the version of MKL, as it names itself ("2026.2"), and the largest number of threads that it takes."""
        text = ctypes.create_string_buffer(_TEXT)
        self._solver.libmkl.MKL_Get_Version_String(text, ctypes.c_int(_TEXT))
        match = re.search(rb"[Vv]ersion\s+([0-9][0-9.]*)", text.value)
        threads = int(self._solver.libmkl.MKL_Get_Max_Threads())
        return {"MKL": match[1].decode("ascii") if match else "unknown", "threads of MKL": str(threads)}

    def _needed(self) -> float:
        """Return bytes of the factors and of the work on them, by Pardiso's own account after the analysis (in kB)."""
        return 1024.0 * float(self._solver.get_iparm(_FACTORS_KB))

    def close(self) -> None:
        """Release MKL's internal memory; the next factorisation analyses anew."""
        if self._analysed:
            self._solver.free_memory(everything=True)
            self._solver.pt[:] = 0
        self._analysed = False


class SymmetricPardiso(Pardiso):
    """Pardiso for symmetric positive definite matrices (LL^T): it reads and factorises the upper triangle alone."""

    _MATRIX_TYPE = 2

    def factorise(self, matrix: csr_matrix) -> None:
        """Factorise the upper triangle; what is below the diagonal is taken to be its mirror."""
        if not self._analysed:
            row = np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr))
            self._upper = matrix.indices >= row
            counts = np.bincount(row[self._upper], minlength=matrix.shape[0])
            self._start = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
            self._column = matrix.indices[self._upper]
        half = matrix.data[self._upper], self._column, self._start
        super().factorise(csr_matrix(half, shape=matrix.shape))


class Rslab:
    """The supernodal LU of rslab: symbolic analysis once, values many times, the same bits on any number of threads.

    Rows are not matched to columns by value: the analysis is that of the pattern, whichever tangent comes first.
    """

    name = "rslab"

    def __init__(self, single: bool = False) -> None:
        import rslab

        rslab.set_log_level("off")  # what is wrong is raised
        self._version: str = rslab.__version__
        self._analyse, self._settings = rslab.analyze, {"ordering": "metis", "matching": False}
        self._type = np.float32 if single else np.float64
        self._analysis: Any = None

    def factorise(self, matrix: csr_matrix) -> None:
        """Factorise numerically; the first call also analyses the pattern."""
        columns, threads = matrix.astype(self._type, copy=False).tocsc(), get_num_threads()
        if self._analysis is None:
            self._analysis = self._analyse(columns, path="lu", threads=threads, **self._settings)
        needed = self._analysis.memory_plan(columns.dtype.name, threads=threads)["peak_bytes"]
        require(float(needed), f"the factorisation of {matrix.shape[0]:,} unknowns")
        try:
            self._factors = self._analysis.factor(columns)
        except RuntimeError as error:
            raise LinearSolverError(f"rslab: {error}") from error

    def solve(self, rhs: np.ndarray) -> np.ndarray:
        """Solve for rhs (n,) or (n, k)."""
        rhs = np.asarray(rhs, dtype=self._type)
        x: np.ndarray = self._factors.solve(rhs) if rhs.ndim == 1 else self._factors.solve_many(rhs)
        return x

    def close(self) -> None:
        """Drop the factors; the analysis stays."""
        self._factors = None

    def versions(self) -> dict[str, str]:
        """Return the version of rslab; its threads change no bit."""
        return {"rslab": self._version}


_TEXT = 200  # letters of MKL's version, at most
_NO_MEMORY = -2  # Pardiso's error code
_SINGLE = 28  # iparm: 1: the numbers handed over have 4 bytes
_FACTORS_KB = 17  # iparm: memory of the numerical factorisation and of solving
_SCHUR = 36  # iparm: equations marked in perm are not eliminated

# 1-based iparm: defaults off (1), METIS (2), refinement only where pivots were perturbed (8; a step of it costs ten
# solves, and LinearSolver refines where the residual asks for it), pivot perturbation 1e-13 (10), no scaling (11) and
# no matching (13), parallel factorisation (24), indices from 0 (35).
_IPARM = {1: 1, 2: 2, 8: 0, 10: 13, 11: 0, 13: 0, 24: 1, 25: 0, 35: 1}


def _point_at_mkl() -> None:
    """Set the place of MKL for the wrapper, which would search the whole environment for a second."""
    libraries = sorted(Path(sys.prefix, "lib").glob("libmkl_rt.so*"), key=lambda file: len(file.name))
    if libraries:
        os.environ.setdefault("PYPARDISO_MKL_RT", str(libraries[0]))


def available_backends() -> list[str]:
    """Return the names of the backends that can be used here, best first."""
    found = {"pardiso": "pypardiso", "rslab": "rslab", "superlu": "scipy"}
    return [name for name, package in found.items() if importlib.util.find_spec(package) is not None]


def make_backend(name: str, n_unknowns: int, symmetric: bool = False, single: bool = False) -> Backend:
    """Return the backend of the given name; ``auto`` takes the best one that works.

    ``symmetric`` promises symmetric positive definite matrices: Pardiso then does half the work; the others have no
    such factorisation. ``single`` asks for factors in single precision, which SuperLU is not used for either.
    """
    for each in available_backends() if name == "auto" else [name]:
        try:
            if each == "pardiso":
                return SymmetricPardiso(single) if symmetric else Pardiso(single)
            if each == "rslab":
                return Rslab(single)
        except (ImportError, OSError) as error:
            if name != "auto":
                raise LinearSolverError(f"{name} does not load here: {error}") from error
    if name not in ("auto", "superlu"):
        raise LinearSolverError(f"unknown linear solver {name!r}; available: {', '.join(available_backends())}")
    if n_unknowns > SUPERLU_COMFORT:
        warnings.warn(
            f"SuperLU on {n_unknowns} unknowns is slow and needs much memory (comfortable up to {SUPERLU_COMFORT}); "
            "the extras rslab (open) and mkl (x86-64 Linux and Windows) bring faster ones",
            stacklevel=2,
        )
    return SuperLU()
