# SPDX-License-Identifier: MIT
"""The measure of alternation sees a swing from station to station, and not a smooth pressure or a kink."""

import numpy as np
import pytest
import xarray as xr

from pysprings.full_model.record import contact_alternation
from tests.support import tiny

N = 17
THETA = np.linspace(0.0, np.pi, N)
STEP = np.pi / (N - 1)


def path(pressure: np.ndarray) -> xr.Dataset:
    """Two steps, two sides, three depths: even pressure everywhere, the given one (azimuth,) at one place."""
    field = np.full((2, 2, N, 3), 100.0)
    field[1, 1, :, 2] = pressure
    coords = {"step": [0, 1], "side": ["outside", "inside"], "azimuth": THETA, "depth": [0.0, 1.0, 2.5]}
    return xr.Dataset({"normal_effective_stress": (("step", "side", "azimuth", "depth"), field)}, coords=coords)


def measure(pressure: np.ndarray) -> dict:
    found = contact_alternation(path(pressure))
    assert found is not None
    return found


def test_an_even_pressure_measures_nothing() -> None:
    found = measure(np.full(N, 100.0))
    assert (found["second_difference"], found["alternation"], found["isolated_open"]) == (0.0, 0.0, 0)
    assert (found["second_difference_at"], found["alternation_at"], found["isolated_open_at_step"]) == ("", "", None)
    assert found["stations"] == 2 * N * 3


def test_a_smooth_pressure_gives_its_curvature_and_no_alternation() -> None:
    found = measure(100.0 * (1.0 + 0.8 * np.cos(THETA)))
    assert found["second_difference"] == pytest.approx(0.8 * 2.0 * (1.0 - np.cos(STEP)), rel=1e-9)
    assert found["alternation"] < 0.02
    assert found["second_difference_at"] in (
        "inside, azimuth 0°, depth 2.50 m, step 1",
        "inside, azimuth 180°, depth 2.50 m, step 1",
    )


@pytest.mark.parametrize("size", [0.01, 0.5])
def test_a_swing_of_s_gives_4_s(size: float) -> None:
    found = measure(100.0 * (1.0 + size * (-1.0) ** np.arange(N)))
    assert found["alternation"] == pytest.approx(4.0 * size)
    assert found["second_difference"] == pytest.approx(4.0 * size)
    assert found["alternation_at"].startswith("inside, azimuth ")


@pytest.mark.parametrize("edge", [0.0, 60.0])
def test_the_edge_of_an_open_zone_is_no_alternation(edge: float) -> None:
    """Not even where the pressure steps up and falls again slowly, as beside a caisson that leans back."""
    pressure = np.where(THETA < 1.5, edge + 40.0 * np.maximum(1.5 - THETA, 0.0), 0.0)
    found = measure(pressure)
    assert found["alternation"] < 1e-12
    assert found["isolated_open"] == 0
    assert found["second_difference"] > max(0.99 * edge, 5.0) / 100.0


def test_a_ring_that_is_all_but_open_is_measured_against_its_first_state() -> None:
    found = measure(np.where(np.arange(N) == 8, 1.0, 0.0))
    assert found["second_difference"] == pytest.approx(0.02)
    assert found["alternation"] == pytest.approx(0.01)  # one loaded station among open ones does alternate


def test_a_ring_whose_pressure_grows_is_measured_against_its_mean_now() -> None:
    found = measure(400.0 * (1.0 + 0.1 * (-1.0) ** np.arange(N)))
    assert found["alternation"] == pytest.approx(0.4)


@pytest.mark.parametrize("station", [0, 1, 8, N - 1])
def test_an_open_station_between_loaded_ones_is_counted_once(station: int) -> None:
    """At the ends the neighbour on the other side is the mirror image of the one on this side."""
    pressure = np.full(N, 100.0)
    pressure[station] = 0.0
    found = measure(pressure)
    assert (found["isolated_open"], found["isolated_open_at_step"]) == (1, 1)


def test_two_open_stations_side_by_side_are_a_zone() -> None:
    pressure = np.full(N, 100.0)
    pressure[[4, 5]] = 0.0
    assert measure(pressure)["isolated_open"] == 0


def test_a_ring_that_is_open_all_around_divides_by_nothing() -> None:
    assert measure(np.zeros(N))["second_difference"] == 0.0


def test_the_order_of_the_dimensions_does_not_matter() -> None:
    data = path(100.0 * (1.0 + 0.1 * (-1.0) ** np.arange(N)))
    assert contact_alternation(data.transpose("depth", "azimuth", "side", "step")) == contact_alternation(data)


def test_nothing_is_measured_without_fields() -> None:
    assert contact_alternation(path(np.ones(N)).drop_vars("normal_effective_stress")) is None


def test_it_measures_a_run() -> None:
    found = contact_alternation(tiny.result()["paths/pull"].to_dataset())
    assert found is not None
    assert 0.0 < found["second_difference"] < 1.0
    assert found["isolated_open"] == 0
