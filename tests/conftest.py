# SPDX-License-Identifier: MIT
"""One thread for each worker, a time limit for each tier, and fixtures that several folders use."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

# before any library is loaded: two workers with two threads each wait for each other on two cores
for _name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

LIMITS = {"slow": 900, "long": 3600}  # s for a test; pyproject.toml has that of the others


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Give every test of a slower tier its own time limit."""
    for item in items:
        tier = next((name for name in ("long", "slow") if item.get_closest_marker(name)), None)
        if tier is not None and item.get_closest_marker("timeout") is None:
            item.add_marker(pytest.mark.timeout(LIMITS[tier]))


@pytest.fixture(scope="session", autouse=True)
def _one_thread() -> None:
    """Run compiled loops on one thread; a test of several threads sets their number itself."""
    import numba

    numba.set_num_threads(1)


@pytest.fixture
def scene_file(tmp_path: Path) -> Path:
    """The file of the tiny scene, in the folder of the test."""
    from tests.support import tiny

    return tiny.write(tiny.scene(), tmp_path / "caisson.toml")
