# SPDX-License-Identifier: MIT
"""Why a path stopped: measures with known answers, and whole paths that end for a known reason."""

import re
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fe_engine.soil.elastic import elastic_tangent, moduli
from pysprings.core.words import Diagnosis, StopReason
from pysprings.full_model import diagnosis, paths
from pysprings.full_model.compute import compute
from pysprings.full_model.diagnosis import during_dead_load
from tests.support import tiny


def test_the_elastic_acoustic_tensor_has_the_textbook_determinant() -> None:
    tangent, (bulk, shear) = np.zeros((6, 6)), moduli(2e8, 0.3)
    elastic_tangent(bulk, shear, 1.0, tangent)
    found = diagnosis._acoustic(tangent, diagnosis._directions())
    np.testing.assert_allclose(found, diagnosis._elastic(bulk, shear), rtol=1e-10)


def test_perfect_plasticity_of_mises_loses_its_ellipticity_in_pure_shear() -> None:
    """C - 2G n x n with a unit pure shear n in xy: det(n.C.n) is 0 for n = x, as the shear stiffness on it is."""
    bulk, shear = 1e8, 5e7
    tangent = np.zeros((6, 6))
    elastic_tangent(bulk, shear, 1.0, tangent)
    tangent[3, 3] = 0.0
    one = diagnosis._acoustic(tangent, np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
    assert one[0] == pytest.approx(0.0, abs=1e-9 * shear**3)
    assert one[1] == pytest.approx((bulk + 4 / 3 * shear) * shear * shear)


def test_directions_are_unit_vectors_of_half_a_sphere() -> None:
    directions = diagnosis._directions()
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0)
    assert directions[:, 2].min() > 0.0
    np.testing.assert_allclose(directions[:, :2].mean(axis=0), 0.0, atol=0.01)


def test_the_stiffness_left_is_beside_the_softest_motion_at_rest() -> None:
    """In displacements: a rotation of stiffness 36 N m counts with a length of 2 m, as 9 N/m; the heave has 4."""
    newton = SimpleNamespace(scale=np.array([1.0, 1.0, 2.0]))
    initial = np.diag([25.0, 4.0, 36.0])
    left = [
        diagnosis._stiffness_left(SimpleNamespace(newton=newton, stiffness=k), initial)  # type: ignore[arg-type]
        for k in (0.2, -0.2, None)
    ]
    assert left == pytest.approx([0.05, -0.05, np.nan], nan_ok=True)  # the last: no force was given


STUCK: dict[str, Any] = {"solver": {"tolerance": 1e-12, "max_iterations": 2, "first_step_fraction": 1e-5}}


def test_a_load_beyond_capacity_ends_at_its_limit() -> None:
    record = compute(tiny.scene(paths=({"name": "storm", "kind": "load", "lateral_force": 2e7},))).record
    assert record.failures == []
    assert record.limit_loads["storm"].criterion.startswith("limit load: ")


SINKS = {"caisson": {"vertical_load": -20e6}}
PUSHED = {"paths": ({"name": "pull", "kind": "load", "lateral_force": 1e5},)}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (SINKS, r"path 'pull' stopped during its dead load: 13\.\d % of it converged; no mo"),
        (STUCK | PUSHED, r"unexplained: no increment of the path converged"),
    ],
)
def test_a_path_that_did_not_begin_is_at_no_limit_load(
    changes: dict[str, Any], words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No capacity may be taken from it: neither from a load of no size nor from that of a dead load on its way."""
    limit = Diagnosis(StopReason.LIMIT_LOAD, "no motion balances any more")
    monkeypatch.setattr(paths, "diagnose", lambda *_: limit)
    result = compute(tiny.scene(**changes))
    (line,) = result.record.failures
    assert re.search(words, line), line
    assert result.record.limit_loads == {} and not result.record.reasons[0].is_limit
    assert result.tree["paths/pull"].attrs["end"] == "stopped"
    assert "no increment of it converged, however small; this is no limit load" in str(during_dead_load(limit, None))
