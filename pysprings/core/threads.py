# SPDX-License-Identifier: MIT
"""Threads of libraries that would wait for work on the cores that others need."""

from __future__ import annotations

from contextlib import AbstractContextManager


def blas_on_one_thread() -> AbstractContextManager[object]:
    """Return the context in which NumPy's OpenBLAS has one thread.

    Its threads wait by spinning after every product of vectors; beside those of Pardiso and Numba on two cores they
    took half the time of a linear solve. Pardiso's own BLAS keeps its threads.
    """
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController().select(internal_api="openblas").limit(limits=1)
