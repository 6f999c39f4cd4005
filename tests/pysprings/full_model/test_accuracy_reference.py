# SPDX-License-Identifier: MIT
"""Order and extrapolation on manufactured values, errors with known answers, the Pareto front."""

from __future__ import annotations

import numpy as np
import pytest

from pysprings.full_model.accuracy import measures
from pysprings.full_model.accuracy.curves import LOAD, OTHER, PRESSURE, PY, STIFFNESS, Sample
from pysprings.full_model.accuracy.measures import cell_size, extrapolate, order_from
from pysprings.studies.accuracy.picture import front

H = (1.0, 0.71, 0.42)  # ratios that are not equal


def manufactured(order: float, limit: float = 5.0, slope: float = 0.3) -> list[np.ndarray]:
    return [np.array([limit + slope * h**order]) for h in H]


@pytest.mark.parametrize("order", [0.6, 1.0, 1.7, 2.0, 3.5])
def test_order_and_limit_of_a_power_law(order: float) -> None:
    found = extrapolate(manufactured(order), H)
    assert found.order == pytest.approx(order, abs=1e-9)
    assert found.values == pytest.approx(5.0, abs=1e-12)
    assert found.beside == manufactured(order)[-1]
    assert f"order {order:.2f}" in found.note


def test_a_curve_has_one_order_and_keeps_its_gaps() -> None:
    x = np.linspace(0.1, 1.0, 40)
    curves = [np.sqrt(x) + h**1.5 * np.cos(3.0 * x) for h in H]
    for curve in curves:
        curve[7] = np.nan
    found = extrapolate(curves, H)
    assert found.order == pytest.approx(1.5, abs=1e-8)
    good = np.arange(40) != 7
    np.testing.assert_allclose(found.values[good], np.sqrt(x)[good], rtol=1e-9)
    assert np.isnan(found.values[7])


def test_only_the_three_finest_count() -> None:
    values = [np.array([99.0]), *manufactured(2.0)]
    assert extrapolate(values, (2.0, *H)).order == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ([1.0, 2.0, 1.5], "change sign"),
        ([float(manufactured(0.3)[k][0]) for k in range(3)], "not in"),
        ([float(manufactured(5.0)[k][0]) for k in range(3)], "not in"),
        ([1.0, 2.0, 2.0], "agree"),
        ([2.0, 1.0], "2 meshes"),
    ],
)
def test_where_there_is_no_order_the_finest_mesh_stands_with_the_last_difference(values: list, words: str) -> None:
    found = extrapolate([np.array([value]) for value in values], H[-len(values) :])
    assert found.order is None and not found.extrapolated
    assert found.values == values[-1]
    assert found.beside == values[-2]
    assert words in found.note


def test_one_mesh_knows_nothing_of_its_error() -> None:
    found = extrapolate([np.array([1.0])], (1.0,))
    assert found.order is None
    assert np.isnan(found.beside).all()


def test_order_needs_a_ratio_between_those_of_the_bounds() -> None:
    low, high = ((H[0] ** p - H[1] ** p) / (H[1] ** p - H[2] ** p) for p in (0.5, 4.0))
    assert order_from(low * 1.0001, H) == pytest.approx(0.5, abs=1e-3)
    assert order_from(high * 0.9999, H) == pytest.approx(4.0, abs=1e-3)
    assert np.isnan(order_from(0.999 * low, H)) and np.isnan(order_from(1.001 * high, H))


def test_cells_halve_with_eight_times_the_unknowns() -> None:
    assert cell_size(8000.0) == pytest.approx(0.5 * cell_size(1000.0))


def sample(factor: float = 1.0) -> Sample:
    x = np.arange(1, 41) / 40.0
    p = np.outer(np.arange(1.0, 4.0), x)
    p[1] = np.nan  # a slice that is left out
    return {
        LOAD: factor * x,
        OTHER: -factor * x,
        PY: factor * p,
        STIFFNESS: np.array([7.0 * factor]),
        PRESSURE: factor * (1.0 + x),
    }


def test_errors_of_curves_that_are_five_percent_high() -> None:
    found = measures.errors(sample(1.05), sample())
    for name in ("load_max", "load_area", "rotation_max", "stiffness", "pressure_max", "py_max"):
        assert found[name] == pytest.approx(5.0), name
    # rms of 0.05 p over the slices 1 and 3, beside the largest p, 3
    x = np.arange(1, 41) / 40.0
    square = np.mean(np.concatenate([x, 3.0 * x]) ** 2)
    assert found["py_rms"] == pytest.approx(5.0 * np.sqrt(square) / 3.0)


def test_a_local_error_counts_beside_the_largest_load() -> None:
    wrong = sample()
    wrong[LOAD] = wrong[LOAD].copy()
    wrong[LOAD][9] += 0.02  # where the load is a quarter of the largest
    found = measures.errors(wrong, sample())
    assert found["load_max"] == pytest.approx(2.0)
    assert found["load_area"] == pytest.approx(100.0 * 0.02 / 40.0 / 0.5)  # a triangle over the area 1/2


def test_what_is_not_there_is_nan_and_the_worst_path_counts() -> None:
    bare = {name: values for name, values in sample(1.1).items() if name != PRESSURE}
    found = measures.errors(bare, sample())
    assert np.isnan(found["pressure_max"])
    both = measures.worst([found, measures.errors(sample(1.02), sample())])
    assert both["load_max"] == pytest.approx(10.0)
    assert both["pressure_max"] == pytest.approx(2.0)
    assert np.isnan(measures.worst([found])["pressure_max"])


def test_reference_and_its_uncertainty() -> None:
    series = [sample(1.0 + 0.3 * h**2) for h in H]
    reference = measures.reference_of(series, H)
    assert reference[LOAD].order == pytest.approx(2.0)
    np.testing.assert_allclose(reference[PY].values, sample()[PY])
    assert measures.uncertainty(reference)["load_max"] == pytest.approx(30.0 * H[-1] ** 2)
    to_and_fro = measures.reference_of([sample(1.0), sample(1.2), sample(1.1)], H)
    assert measures.uncertainty(to_and_fro)["load_max"] == pytest.approx(100.0 * 0.1 / 1.1)


def test_pareto_front() -> None:
    assert front([1.0, 2.0, 3.0, 4.0], [9.0, 4.0, 5.0, 1.0]) == [0, 1, 3]
    assert front([4.0, 1.0, 2.0], [1.0, 9.0, 9.0]) == [1, 0]
    assert front([1.0, 1.0], [2.0, 1.0]) == [1]
    assert front([1.0, np.nan, 2.0], [np.nan, 1.0, 3.0]) == [2]
    assert front([], []) == []
