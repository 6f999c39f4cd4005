# SPDX-License-Identifier: MIT
"""OpenBLAS on one thread for as long as a run lasts, and as before afterwards."""

from __future__ import annotations

from threadpoolctl import ThreadpoolController

from pysprings import full_model
from pysprings.threads import blas_on_one_thread
from tests.pysprings import tiny


def threads() -> list[int]:
    """Threads of each OpenBLAS that is loaded."""
    return [library["num_threads"] for library in ThreadpoolController().select(internal_api="openblas").info()]


def test_blas_has_one_thread_inside_and_its_own_outside() -> None:
    with ThreadpoolController().select(internal_api="openblas").limit(limits=2):
        before = threads()
        with blas_on_one_thread():
            assert set(threads()) <= {1}
        assert threads() == before


def test_a_run_has_it_on_one_thread() -> None:
    seen: set[int] = set()
    with ThreadpoolController().select(internal_api="openblas").limit(limits=2):
        full_model.compute(tiny.scene(), progress=lambda *_: seen.update(threads()))
    assert seen <= {1}
