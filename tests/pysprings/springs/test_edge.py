# SPDX-License-Identifier: MIT
"""Edge rings of the tip: which they are; lumped springs carry the same load in every state."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from pysprings.springs.checks import validate_springs
from pysprings.springs.dataset import get_path
from pysprings.springs.edge import edge_rings, lump_edge
from pysprings.springs.sums import net_p, resultants
from tests.support import synthetic

PATHS = (synthetic.Path("pull", size=8e-3, steps=8), synthetic.Path("turn", "rotation", size=2e-3, steps=5))


@pytest.mark.parametrize(
    ("bounds", "expected"),
    [
        ([0.0, 1.0, 2.0, 4.0], [False, False, True]),
        ([0.0, 2.0, 3.6, 3.9, 4.0], [False, False, True, True]),
        ([0.0, 4.0], [False]),
    ],
)
def test_edge_rings_lie_in_the_last_tenth_and_the_last_is_one(bounds: list[float], expected: list[bool]) -> None:
    path = xr.Dataset({"depth_bounds": (("depth", "bound"), np.column_stack([bounds[:-1], bounds[1:]]))})
    assert edge_rings(path).tolist() == expected


def test_lumped_springs_keep_the_loads_of_every_state_and_lose_the_peak() -> None:
    springs = synthetic.make_springs(PATHS)
    for name in ("pull", "turn"):
        springs[f"paths/{name}"]["p"][-1] *= 7.0
        springs[f"paths/{name}"]["t"][-1] += 3e3
        path = springs[f"paths/{name}"]
        for load, values in resultants(path.to_dataset(inherit=False)).items():
            path[load][:] = values
    before = springs.copy(deep=True)
    lumped = lump_edge(springs)
    validate_springs(lumped)
    assert springs.identical(before)
    for name in ("pull", "turn"):
        old, new = get_path(before, name), get_path(lumped, name)
        edge, p = edge_rings(old), net_p(new).values
        assert edge.any() and not edge.all()
        for load, values in resultants(old).items():
            assert np.allclose(resultants(new)[load], values, rtol=1e-12, atol=1e-9 * np.abs(values).max())
        assert np.array_equal(p[edge], np.broadcast_to(p[~edge][-1], p[edge].shape))
        assert np.array_equal(p[~edge], net_p(old).values[~edge])
        assert np.abs(new["H_tip"] - old["H_tip"]).max() > 0.1 * np.abs(old["H"]).max()
        assert new["H_tip"].attrs == old["H_tip"].attrs
