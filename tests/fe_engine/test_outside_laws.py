# SPDX-License-Identifier: MIT
"""Laws from outside the package: more history than any of ours, contact that cannot open, a register that is closed."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from fe_engine.errors import ModelError
from fe_engine.soil.elastic import elastic_matrix
from fe_engine.soil.laws import SOIL_LAWS
from tests.support.models import SAND
from tests.support.outside_laws import HISTORY, RECORDED
from tests.support.place import ROOT


def lifted(**environment: str) -> dict:
    """Lift a footing in a process of its own, where the laws are added before loops are compiled."""
    command = [sys.executable, "-m", "tests.support.outside_laws"]
    given = {**os.environ, "NUMBA_NUM_THREADS": "1", **environment}
    done = subprocess.run(command, cwd=ROOT, env=given, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return dict(json.loads(done.stdout))


@pytest.fixture(scope="module")
def run() -> dict:
    """Lift the footing with interpreted loops, which takes a tenth of their compilation."""
    return lifted(NUMBA_DISABLE_JIT="1")


@pytest.mark.slow
def test_compiled_loops_with_laws_from_outside_give_the_same(run, tmp_path):
    compiled = lifted(NUMBA_CACHE_DIR=str(tmp_path))
    assert set(compiled) == set(run)
    for name, values in run.items():
        found, expected = np.array(compiled[name]), np.array(values)
        np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-8 * np.abs(expected).max(), err_msg=name)


def test_a_soil_law_from_outside_keeps_its_own_history(run):
    history, change = np.array(run["history"]), np.array(run["change"])
    assert history.shape[-1] == len(HISTORY) > max(len(law.history) for law in SOIL_LAWS)
    strain = history[..., :6]
    assert np.abs(strain).max() > 1e-4
    elastic = elastic_matrix(*SAND[:2])
    np.testing.assert_allclose(change, strain @ elastic, rtol=1e-9, atol=1e-6 * np.abs(change).max())
    assert np.all(history[..., 7] == run["steps"])
    assert np.all(history[..., 6] >= np.linalg.norm(strain, axis=-1) * (1.0 - 1e-12))


def test_a_contact_law_from_outside_holds_in_tension(run):
    assert run["open"] == 0
    assert run["force"][1] < 0.0  # it pulls the soil up


def test_laws_are_added_before_loops_are_compiled():
    import fe_engine.assembly.system  # noqa: F401

    with pytest.raises(ModelError, match="comes too late"):
        SOIL_LAWS.add(RECORDED)
