# SPDX-License-Identifier: MIT
"""Rigid against elastic steel, and the two yield surfaces: what is read from where, and what an absent run leaves."""

import math

import numpy as np
import pytest
import xarray as xr

from validation.paper import idealisations

U = np.linspace(0.0, 20e-3, 41)
DEPTH, AZIMUTH = np.array([0.0, 1.0, 2.0, 4.0]), np.array([0.0, 0.5 * np.pi, np.pi])


def path(softer: float = 1.0, bent: bool = False) -> xr.Dataset:
    """A linear caisson, ``softer`` times as soft; bent, its diameter along x shrinks by a tenth of u at 1 m."""
    field = ("step", "side", "azimuth", "depth")
    initial = np.broadcast_to(1e4 * (1.0 + DEPTH), (U.size, 2, AZIMUTH.size, DEPTH.size))
    data = {
        "u": ("step", U),
        "rotation": ("step", -0.2 * U),
        "H": ("step", 1e9 * U / softer),
        "y": (("depth", "step"), U * (1.0 - DEPTH[:, None] / 8.0)),
        "p": (("depth", "step"), 1e8 / softer * U * (1.0 + DEPTH[:, None])),
        "normal_effective_stress": (field, initial * (1.0 + U[:, None, None, None] / 2.5e-3)),
    }
    if bent:
        shrinks = -0.1 * U[:, None] * np.array([0.5, 1.0, 0.5, 0.0])
        data |= {"diameter_change_x": (("step", "depth"), shrinks), "diameter_change_y": (("step", "depth"), -shrinks)}
    return xr.Dataset(data, coords={"depth": DEPTH, "azimuth": AZIMUTH, "side": ["outside", "inside"]})


def test_each_quantity_and_its_difference() -> None:
    table = idealisations.compare({"drained": path(), "elastic-steel": path(1.25, bent=True)}).set_index("quantity")
    assert table.loc["H/u at 0.1 mm", ["drained", "elastic-steel"]].tolist() == pytest.approx([1000.0, 800.0])
    assert table.loc["H at 2.5 mm", "elastic-steel_difference_percent"] == pytest.approx(-20.0)
    assert table.loc["rotation at 20 mm", "drained"] == pytest.approx(-4.0)
    assert table.loc["p at 2.5 mm, depth 1.25 m", "drained"] == pytest.approx(562.5)
    assert table.loc["y at 20 mm, depth 3.25 m", "elastic-steel"] == pytest.approx(20.0 * (1.0 - 3.25 / 8.0))
    assert table.loc["front p'_N over initial at 2.5 mm, depth 0.25 m", "drained"] == pytest.approx(2.0)
    assert table.loc["ovalisation along x at 20 mm", ["drained", "elastic-steel"]].tolist() == pytest.approx(
        [0.0, -2.0]
    )
    assert table.loc["ovalisation along y at 20 mm", "elastic-steel"] == pytest.approx(2.0)


def test_a_run_that_is_not_there_leaves_dashes() -> None:
    table = idealisations.compare({"drained": path()})
    assert table["van-eekelen"].isna().all()
    heads, rows = idealisations.rows_for_people(table)
    assert heads[-2:] == ["Van Eekelen", "difference"]
    assert all(row[-2:] == ["-", "-"] and row[2] != "-" for row in rows)


def test_a_run_that_stopped_early_says_nothing_beyond() -> None:
    short = path().isel(step=slice(0, 11))
    table = idealisations.compare({"drained": short, "elastic-steel": path(bent=True)}).set_index("quantity")
    assert math.isfinite(table.loc["H at 2.5 mm", "drained"])
    beyond = [name for name in table.index if "20 mm" in name and "ovalisation" not in name]
    assert beyond and table.loc[beyond, "drained"].isna().all()
    assert table.loc[beyond, "elastic-steel_difference_percent"].isna().all()
