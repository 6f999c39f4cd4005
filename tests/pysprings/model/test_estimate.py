# SPDX-License-Identifier: MIT
"""What `pysprings check` says before anything is solved."""

from __future__ import annotations

import pytest

from fe_engine.assembly.system import System
from pysprings.model.build import build_model
from pysprings.model.forecast.estimate import describe
from tests.support import tiny


def test_counts_are_those_of_the_model_that_would_run() -> None:
    scene = tiny.scene(caisson={"vertical_load": "3 MN"})
    about, built = describe(scene), build_model(scene)
    system = System(built.model)
    assert about["mesh"]["nodes"] == built.model.mesh.n_nodes
    assert about["mesh"]["elements"] == built.model.mesh.n_elements
    assert about["mesh"]["interface_stations"] == len(system.stations.area)
    assert about["unknowns"] == system.pattern.n_free + 3
    assert about["vertical_load_N"] == pytest.approx(3e6)
    assert about["left_out"]


def test_the_estimate_for_the_coarse_mesh_is_of_the_right_size() -> None:
    """Measured on two cores, with the slower solver of before: 25 to 40 s, and 0.43 GB, for the default scene."""
    about = describe(tiny.paper())
    assert 5.0 < about["time_s"] < 150.0
    assert 0.2 < about["memory_GB"] < 1.0
