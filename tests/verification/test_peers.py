# SPDX-License-Identifier: MIT
"""An elastic caisson and a push with contact beside OpenSees and CalculiX, on the same mesh (`benchmarks.peers`)."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.peers import problem
from benchmarks.peers.timed import timed, versions

PEERS = Path(problem.__file__).parent


def loads(case: str, folder: Path, name: str = "") -> tuple[float, float]:
    """H and M of a program; without a name ours. Skips the test where the program is missing or does not load."""
    command = [str(PEERS / f"in_{name.lower()}.py"), case, str(problem.write(case, folder / "problem.npz"))]
    if name and versions()[name] is None:
        pytest.skip(f"{name} is not installed")
    try:
        text, *_ = timed([sys.executable, *(command if name else ["-m", "benchmarks.peers.problem", case])], folder)
    except subprocess.CalledProcessError as error:
        if "ImportError" in error.stderr or "RuntimeError: Failed to import" in error.stderr:
            pytest.skip(f"{name} does not load")
        raise
    answer = next(json.loads(line) for line in text.splitlines() if line.startswith("{"))
    return answer["H"], answer["M"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "case", "error"),
    [
        ("OpenSees", "elastic", (1e-3, 1e-3)),  # our largest penalty costs 0.05 %
        ("CalculiX", "elastic", (0.01, 0.015)),  # no mean dilatation
        ("OpenSees", "smooth", (5e-3, 0.03)),  # no contact under the tip
        ("CalculiX", "rough", (0.07, 0.04)),  # contact on flat faces
    ],
)
def test_other_programs_on_the_same_mesh(name: str, case: str, error: tuple[float, float], tmp_path: Path) -> None:
    for own, other, allowed in zip(loads(case, tmp_path), loads(case, tmp_path, name), error, strict=True):
        assert own == pytest.approx(other, rel=allowed)
