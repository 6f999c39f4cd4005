# SPDX-License-Identifier: MIT
"""Fewer depth slices: what is kept, what is lost, and how fast the loss falls."""

import json

import numpy as np
import pytest

from pysprings.core.errors import UserInputError
from pysprings.macro.comparison import convergence_text, merge_slices, slice_convergence, slice_counts
from pysprings.springs.checks import save_springs, validate_springs
from pysprings.springs.path import paths_of
from pysprings.springs.springs import Springs
from pysprings.springs.sums import balance, by_depth, slice_heights
from tests.support import winkler
from tests.support.commands import command
from tests.support.synthetic import Caisson, Path, make_springs

PATHS = (
    Path("pull", steps=6),
    Path("push", kind="translation", steps=6),
    Path("high", arm=8.0, role="held-back", steps=6),
)


@pytest.fixture(scope="module")
def springs():
    return make_springs(PATHS, Caisson(rings=33, sectors=8))


def test_merged_springs_are_springs_with_the_same_forces(springs):
    merged = merge_slices(springs, 4)
    validate_springs(merged.tree, balanced=False)
    fine, coarse = paths_of(springs)["pull"].dataset, merged.path("pull").dataset
    assert coarse.sizes["depth"] == 4
    for path in (fine, coarse):
        assert (
            float(np.abs(slice_heights(path) @ by_depth(path, "p") - (path["H"] - path["H_tip"] - path["H_lid"])).max())
            < 1.0
        )
    missing = balance(coarse)
    assert missing["H"] < 1e-9
    assert missing["V"] < 1e-9
    assert missing["M"] > 1e-4  # the moment of p inside a slice
    np.testing.assert_allclose(coarse["depth_bounds"].values[1:, 0], coarse["depth_bounds"].values[:-1, 1])


def test_all_slices_are_the_springs_themselves(springs):
    same = merge_slices(springs, 33).path("high").dataset
    np.testing.assert_allclose(same["p"], paths_of(springs)["high"].dataset["p"])
    np.testing.assert_allclose(same["depth"], paths_of(springs)["high"].dataset["depth"], atol=1e-12)
    assert slice_counts(Springs.of(springs)) == [1, 2, 4, 8, 16, 32, 33]
    for n in (0, 34):
        with pytest.raises(UserInputError, match=r"slices: .* the springs have 1 to 33"):
            merge_slices(springs, n)


def test_springs_with_stored_elements_have_their_slices_merged_without_them():
    table = slice_convergence(winkler.with_invented_memory(), [2])
    assert set(table["slices"]) == {2} and "fan" in set(table["springs"]) and "memory" not in set(table["springs"])


def test_error_falls_with_the_square_of_the_slice_height(springs):
    """Full set on the path it comes from: only the slices are wrong."""
    frame = slice_convergence(springs, [2, 4, 8], "full")
    own = frame[frame["role"] == "calibration"]
    error = own["M_error_max_pct"].to_numpy()
    rates = np.log2(error[:-1] / error[1:])
    assert rates.min() > 1.7
    assert (own["curve_ms"] > 0.0).all()
    assert set(frame["role"]) == {"calibration", "held-back"}
    assert "held-back paths, largest errors by number of depth slices" in convergence_text(frame)


@pytest.mark.slow
def test_command(springs, tmp_path):
    file = save_springs(springs, tmp_path / "springs.nc")
    done = command("compare", str(file), "--slices", "--springs", "full", "--json")
    rows = json.loads(done.out)["rows"]
    assert [row["slices"] for row in rows if row["role"] == "held-back"] == [1, 2, 4, 8, 16, 32, 33]
    assert "50 points [ms]" in command("compare", str(file), "--slices", "--springs", "py").out
