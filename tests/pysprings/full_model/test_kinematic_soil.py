# SPDX-License-Identifier: MIT
"""Runs in soils with kinematic hardening: first loading as with the isotropic law, loops that close, springs."""

import itertools
from typing import Any

import numpy as np
import pytest

from pysprings.full_model.compute import compute
from pysprings.springs.checks import extract_springs
from pysprings.springs.sums import balance
from tests.support import tiny

CLAY: dict[str, Any] = {
    "undrained_shear_strength": {"top": 5e3, "gradient": 2e3}, "rigidity_ratio": 200.0,
    "effective_unit_weight": 6e3, "surcharge": 0.0, "strain_at_half_strength": 0.01,
}  # fmt: skip
BONDED = {"adhesion_factor": 1.0, "opening": "bonded"}


def cycle(law: str, soil: dict[str, Any], size: float, **sections: Any):
    """Pull, go back by half and pull again, then all the way back; return the path's dataset and the result."""
    back = [(x * size, None, None) for x in (0.5, 1.0, -1.0, 1.0)]
    pull = {"name": "loop", "kind": "pull", "lateral_displacement": size, "role": "held-back", "then": back}
    pulls = ({**tiny.PULL, "lateral_displacement": size}, pull)
    mesh = {"discretisation": "fourier", "refinement": 1.0}
    scene = tiny.sand(
        **{**tiny.SECTIONS, "mesh": mesh, "soil": {"yield_surface": law, **soil}, "paths": pulls, **sections}
    )
    result = compute(scene).recorded()
    assert result.attrs["status"] == "complete"
    return result["paths/loop"].to_dataset(), result


def parts(path) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return u and H of each part of the path, the end of the part before included."""
    u, H = path["u"].values, path["H"].values
    turns = [0, *(np.flatnonzero(np.diff(np.sign(np.diff(u)))) + 1), len(u) - 1]
    return [(u[a : b + 1], H[a : b + 1]) for a, b in itertools.pairwise(turns)]


def small_loop(path) -> float:
    """Return the work of the small cycle over that of the first pull."""
    (first, there, back, *_) = parts(path)
    return sum(float(np.trapezoid(H, u)) for u, H in (there, back)) / float(np.trapezoid(first[1], first[0]))


def test_clay_has_the_first_loading_of_von_mises_and_the_loops_of_masing():
    """Below its largest load the isotropic law is elastic; the kinematic one yields again on the way back."""
    own, result = cycle("iwan-clay", CLAY, 10e-3, interface=BONDED)
    other, _ = cycle("von-mises", CLAY, 10e-3, interface=BONDED)
    peaks = [[float(H[-1]) for _, H in parts(path)] for path in (own, other)]
    assert peaks[0][0] == pytest.approx(peaks[1][0], rel=0.03)
    assert max(balance(extract_springs(result)["paths/pull"].to_dataset()).values()) < 1e-8
    assert peaks[0][3] == pytest.approx(-peaks[0][0], rel=0.02)  # loops close
    assert [peaks[0][2], peaks[0][4]] == pytest.approx([peaks[0][0]] * 2, rel=0.02)
    assert -peaks[1][3] > 1.15 * peaks[1][0]  # each reversal carries more
    assert small_loop(own) > 0.02 > 10.0 * abs(small_loop(other))


@pytest.mark.slow
def test_sand_has_the_first_loading_of_drucker_prager_and_carries_no_more_on_reversal():
    sand = {"friction_angle_initial": 0.05}
    frictionless = {"friction_coefficient": 0.0}
    own, _ = cycle("iwan-sand", sand, 4e-3, interface=frictionless)
    other, _ = cycle("drucker-prager", sand, 4e-3, interface=frictionless)
    peaks = [[float(H[-1]) for _, H in parts(path)] for path in (own, other)]
    assert peaks[0][0] == pytest.approx(peaks[1][0], rel=0.02)
    assert [peaks[0][2], -peaks[0][3], peaks[0][4]] == pytest.approx([peaks[0][0]] * 3, rel=0.03)
    assert -peaks[1][3] > 1.3 * peaks[1][0]
    assert small_loop(own) > 0.1


@pytest.mark.slow
def test_strengths_by_direction_give_the_collapse_load_of_the_elastic_plastic_law():
    """The same ellipsoids bound both laws, which differ on the way to collapse alone."""
    soil = {name: value for name, value in CLAY.items() if name != "strain_at_half_strength"}
    ends = []
    for law, factor in ("iwan-clay", 0.6), ("von-mises", 0.6), ("von-mises", 1.0):
        own = {**soil, "yield_surface": law, "rigidity_ratio": 1000.0, "extension_factor": factor}
        pull = {**tiny.PULL, "lateral_displacement": 0.4}
        mesh = {"discretisation": "fourier", "refinement": 0.6, "harmonics": 3}
        result = compute(tiny.sand(**{**tiny.SECTIONS, "mesh": mesh, "soil": own, "paths": (pull,)}, interface=BONDED))
        assert result.record.status == "complete"
        ends.append(float(result.recorded()["paths/pull"]["H"][-1]))
    assert ends[0] == pytest.approx(ends[1], rel=0.02)
    assert ends[1] < 0.96 * ends[2]
