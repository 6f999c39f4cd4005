# SPDX-License-Identifier: MIT
"""OpenBLAS on one thread for as long as a run lasts, and as before afterwards."""

import numpy as np
from threadpoolctl import ThreadpoolController

from pysprings.core.process import blas_on_one_thread
from pysprings.full_model import compute
from tests.support import tiny


def threads() -> list[int]:
    """Threads of each OpenBLAS that is loaded; at least NumPy's is."""
    np.ones((2, 2)) @ np.ones((2, 2))
    found = [library["num_threads"] for library in ThreadpoolController().select(internal_api="openblas").info()]
    assert found, "NumPy is not built with OpenBLAS: nothing is tested here"
    return found


def test_blas_has_one_thread_inside_and_its_own_outside() -> None:
    with ThreadpoolController().select(internal_api="openblas").limit(limits=2):
        before = threads()
        assert set(before) == {2}
        with blas_on_one_thread():
            assert set(threads()) == {1}
        assert threads() == before


def test_a_run_has_it_on_one_thread() -> None:
    seen: set[int] = set()
    with ThreadpoolController().select(internal_api="openblas").limit(limits=2):
        compute.compute(tiny.scene(), progress=lambda *_: seen.update(threads()))
    assert seen == {1}  # and progress was called
