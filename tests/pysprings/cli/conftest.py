# SPDX-License-Identifier: MIT
"""Every command runs in a folder of its own."""

from pathlib import Path

import pytest

from pysprings.springs.checks import save_springs
from tests.support import synthetic


@pytest.fixture(autouse=True)
def _in_a_new_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def springs_file() -> Path:
    """Springs in the folder ``results``."""
    return save_springs(synthetic.make_springs(), Path("results/springs.nc"))
