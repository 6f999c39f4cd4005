# SPDX-License-Identifier: MIT
"""Runs on common displacements: where they are compared, and that nothing is lost or made up between the meshes."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from pysprings.full_model.accuracy import measures
from pysprings.full_model.accuracy.measures import (
    LOAD,
    OTHER,
    POINTS,
    PRESSURE,
    PY,
    STIFFNESS,
    Sample,
    cell_size,
    common_grid,
    curves_of,
    driver_of,
    errors,
    extrapolate,
    first_secant,
    initial_stiffness,
    leading,
    load_of,
    order_from,
    other_of,
    pressure_of,
    sampled,
    samples,
    slice_curves,
)
from pysprings.springs.path import paths_of
from pysprings.studies.accuracy.rows import front
from tests.support.measured import LENGTH, PATHS, measured_result
from tests.support.synthetic import Caisson


def test_only_the_way_out_counts() -> None:
    assert leading(np.array([0.0, 1.0, 1.0, 2.0, 1.5, 3.0])).tolist() == [0, 1, 3]
    assert leading(np.array([0.0, -1.0])).tolist() == [0]


def test_the_same_soil_at_other_steps_gives_the_same_curves() -> None:
    """Between recorded steps curves are smooth: other steps of one model matter little, another model much."""
    some, more = measured_result(), measured_result(paths=tuple(replace(path, steps=31) for path in PATHS))
    other = measured_result(Caisson(modulus=6e7))
    sampled_paths = samples({"a": curves_of(some), "b": curves_of(more), "c": curves_of(other)})
    assert set(sampled_paths) == {path.name for path in PATHS}
    for path, found in sampled_paths.items():
        same, different = errors(found["b"], found["a"]), errors(found["c"], found["a"])
        for name in ("load_max", "py_max", "rotation_max", "pressure_max"):
            assert same[name] < 0.1, (path, name)
            if name != "rotation_max":  # at equal displacement it hardly depends on the soil's modulus
                assert different[name] > 1.0, (path, name)


def test_other_depths_of_the_same_soil_hand_the_same_force_to_the_slices() -> None:
    curves = {n: curves_of(measured_result(Caisson(rings=n)))["shift"] for n in (13, 41)}
    by_ring = paths_of(measured_result())["shift"].dataset
    heights = np.diff(by_ring["depth_bounds"].values, axis=1)[:, 0]
    np.testing.assert_allclose(curves[13].p.mean(axis=0) * LENGTH, heights @ by_ring["p"].values, rtol=1e-12, atol=1e-6)
    grid = common_grid(list(curves.values()))
    found = {n: sampled(curve, grid)[PY] for n, curve in curves.items()}
    assert np.abs(found[13] - found[41]).max() < 0.05 * np.abs(found[41]).max()


def test_slices_that_end_inside_rings_carry_the_force_of_a_smooth_reaction() -> None:
    """p = 3 + 2 z - z^2/2 on five unequal rings: the force above a depth is a cubic, which the spline follows."""
    bounds = np.array([0.0, 0.3, 1.1, 2.0, 3.7, 4.0])

    def above(z: np.ndarray) -> np.ndarray:
        return 3.0 * z + z**2 - z**3 / 6.0

    middle = 0.5 * (bounds[1:] + bounds[:-1])
    p = np.diff(above(bounds)) / np.diff(bounds)
    path = xr.Dataset(
        {
            "p": (("depth", "step"), np.stack([0.0 * p, p], axis=1)),
            "y": (("depth", "step"), np.zeros((5, 2))),
            "depth_bounds": (("depth", "side"), np.stack([bounds[:-1], bounds[1:]], axis=1)),
        },
        {"depth": middle},
    )
    edges = np.linspace(0.0, 4.0, 9)
    forces = slice_curves(path, 4.0, 8)[1] * np.diff(edges)[:, None]
    np.testing.assert_allclose(forces[:, 1], np.diff(above(edges)), rtol=1e-12)
    np.testing.assert_array_equal(forces[:, 0], 0.0)


def test_y_of_slices_above_and_below_all_ring_centres_is_that_of_the_rigid_skirt() -> None:
    """y = 5 - z, of which two rings have 4 and 2; of a first state that counts as 0."""
    bounds = np.array([[0.0, 2.0], [2.0, 4.0]])
    y = np.array([[0.0, 4.0], [0.0, 2.0]])
    values = {"p": (("depth", "step"), y), "y": (("depth", "step"), y), "depth_bounds": (("depth", "side"), bounds)}
    path = xr.Dataset(values, {"depth": bounds.mean(axis=1)})
    np.testing.assert_allclose(slice_curves(path, 4.0, 4)[0][:, 1], [4.5, 3.5, 2.5, 1.5], rtol=1e-12)


def test_motion_counts_from_the_first_state() -> None:
    """The dead load may have moved the caisson before the path begins."""
    path = paths_of(measured_result())["shift"].dataset
    moved = path.assign(y=path["y"] + 1e-3)
    np.testing.assert_allclose(slice_curves(moved, LENGTH, 4)[0], slice_curves(path, LENGTH, 4)[0], atol=1e-15)


def test_grid_ends_where_the_shorter_run_does() -> None:
    long, short = (
        curves_of(measured_result())["pull"],
        curves_of(measured_result(paths=(replace(PATHS[0], size=3e-3),)))["pull"],
    )
    grid = common_grid([long, short])
    assert grid.x.size == POINTS
    assert grid.x[-1] == pytest.approx(3e-3)
    assert grid.x[0] == pytest.approx(3e-3 / POINTS)
    found = sampled(long, grid)
    path = paths_of(measured_result())["pull"].dataset
    assert found[LOAD][-1] == pytest.approx(np.interp(3e-3, path["u"], path["H"]), rel=1e-3)


def test_slices_near_the_point_of_rotation_are_left_out() -> None:
    """A pull at 8 m turns about a point on the skirt: there y is next to nothing."""
    curve = curves_of(measured_result())["pull"]
    grid = common_grid([curve, curve])
    left_out = np.isnan(grid.y).all(axis=1)
    end = np.abs(curve.y[:, -1])
    assert left_out.sum() < 3
    assert (end[left_out] < 0.1 * end.max()).all()
    assert np.isnan(sampled(curve, grid)[PY][left_out]).all()


def test_quantities_by_kind_of_path() -> None:
    curves = curves_of(measured_result())
    pull, turn = paths_of(measured_result())["pull"].dataset, paths_of(measured_result())["turn"].dataset
    np.testing.assert_array_equal(curves["pull"].by_x[OTHER], pull["rotation"])
    np.testing.assert_array_equal(curves["turn"].x, np.abs(turn["rotation"]))
    np.testing.assert_array_equal(curves["turn"].by_x[LOAD], turn["M"])
    np.testing.assert_array_equal(curves["turn"].by_x[OTHER], turn["H"])
    bare = paths_of(measured_result())["pull"].dataset.drop_vars("normal_effective_stress")
    assert pressure_of(bare, LENGTH) is None


def test_pressure_is_the_largest_down_to_nine_tenths() -> None:
    path = paths_of(measured_result())["shift"].dataset
    stress = path["normal_effective_stress"]
    at = stress.interp(depth=np.linspace(0.0, 0.9 * LENGTH, 19))
    np.testing.assert_allclose(pressure_of(path, LENGTH), at.max(("side", "azimuth", "depth")).values, rtol=1e-12)
    assert curves_of(measured_result())["shift"].by_x[PRESSURE].max() < stress.max()


def test_initial_stiffness_is_the_slope_at_rest() -> None:
    """Beside a first step that is small: the load over what is driven."""
    tiny = tuple(replace(path, size=path.size * 1e-6, steps=3) for path in PATHS)
    tree = measured_result(paths=tiny)
    curves = curves_of(tree)
    assert set(curves) == {path.name for path in PATHS}
    for name, curve in curves.items():
        path = paths_of(tree)[name].dataset
        driven = path["rotation"] if name == "turn" else path["u"]
        load = path["M"] if name == "turn" else path["H"]
        assert sampled(curve, common_grid([curve]))[STIFFNESS][0] == pytest.approx(float(load[1] / driven[1]), rel=1e-5)


def test_the_first_secant_is_less_than_the_stiffness_where_the_ground_yields_at_once() -> None:
    K = np.diag([4.0, 2.0, 3.0])
    states = {"u": ("step", [0.0, 0.5, 1.0]), "rotation": ("step", [0.0, 0.0, 0.0]), "M": ("step", [0.0, 0.0, 0.0])}
    attrs = {"kind": "translation", "arm_m": 0.0, "heave": "fixed"}
    for load, share in ((2.0, 1.0), (1.5, 0.75)):
        path = xr.Dataset(states | {"H": ("step", [0.0, load, 3.0])}, attrs=attrs)
        assert first_secant(K, path) == pytest.approx(share)
    assert first_secant(K, path.assign(u=0.0 * path["u"])) is None


def test_w_follows_in_the_stiffness_where_it_is_free() -> None:
    coupled = np.array([[4.0, 1.0, 0.5], [1.0, 2.0, 0.2], [0.5, 0.2, 3.0]])
    path = xr.Dataset(attrs={"kind": "pull", "arm_m": 2.0, "heave": "free"})
    u = np.linalg.solve(coupled, np.array([1.0, 0.0, 2.0]))[0]
    assert initial_stiffness(coupled, path) == pytest.approx(1.0 / u)
    held = np.linalg.solve(coupled[np.ix_([0, 2], [0, 2])], np.array([1.0, 2.0]))[0]
    assert initial_stiffness(coupled, path.assign_attrs(heave="fixed")) == pytest.approx(1.0 / held)
    vertical = path.assign_attrs(kind="vertical")
    assert initial_stiffness(coupled, vertical) == 2.0


def test_stiffness_of_a_path_that_turns_as_it_goes() -> None:
    """A swipe sets out with a ratio of rotation and u; a load that climbs at its first arm."""
    K = np.array([[4.0, 0.0, 0.5], [0.0, 2.0, 0.0], [0.5, 0.0, 3.0]])
    motion = {"u": ("step", [0.0, 1e-3]), "rotation": ("step", [0.0, -2e-4])}
    swipe = xr.Dataset(motion, attrs={"kind": "swipe", "arm_m": 0.0, "heave": "fixed"})
    assert initial_stiffness(K, swipe) == pytest.approx(4.0 - 0.2 * 0.5)
    climbing = xr.Dataset(attrs={"kind": "load", "arm_m": 9.0, "arm_from_m": 2.0, "heave": "fixed"})
    still = climbing.drop_attrs().assign_attrs(kind="load", arm_m=2.0, heave="fixed")
    assert initial_stiffness(K, climbing) == initial_stiffness(K, still)


def test_paths_that_bend_are_followed_by_both_motions_and_vertical_ones_by_w() -> None:
    names = ("u", "w", "rotation", "H", "V", "M")
    values = {name: ("step", np.array([0.0, 1.0, 2.0]) * 10.0**k + (k == 4)) for k, name in enumerate(names)}
    climbing = xr.Dataset(values, attrs={"kind": "load", "arm_m": 9.0, "arm_from_m": 2.0})
    for path in (climbing, xr.Dataset(values, attrs={"kind": "swipe", "arm_m": 0.0})):
        np.testing.assert_allclose(driver_of(path, 4.0), [0.0, 401.0, 802.0])  # |u| + 4 |rotation|
        np.testing.assert_array_equal(load_of(path), path["H"])
        np.testing.assert_array_equal(other_of(path), path["M"])
    vertical = xr.Dataset(values, attrs={"kind": "vertical", "arm_m": 0.0})
    np.testing.assert_allclose(driver_of(vertical, 4.0), [0.0, 10.0, 20.0])
    np.testing.assert_allclose(load_of(vertical), [0.0, 1e4, 2e4])  # the change of V
    assert other_of(vertical) is None


def test_a_slice_that_goes_the_other_way_in_a_run_is_left_out() -> None:
    curve = curves_of(measured_result())["pull"]
    turned = replace(curve, y=np.where(np.arange(len(curve.y))[:, None] == 0, -curve.y, curve.y))
    assert np.isfinite(common_grid([curve, curve]).y[0]).all()
    assert np.isnan(common_grid([curve, turned]).y[0]).all()


# --- order and extrapolation on manufactured values, errors with known answers, the Pareto front ---

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
    vertical = [each | {PY: np.full((3, 40), np.nan)} for each in series]  # has no p(y)
    assert PY not in measures.reference_of(vertical, H)
    to_and_fro = measures.reference_of([sample(1.0), sample(1.2), sample(1.1)], H)
    assert measures.uncertainty(to_and_fro)["load_max"] == pytest.approx(100.0 * 0.1 / 1.1)


def test_pareto_front() -> None:
    assert front([1.0, 2.0, 3.0, 4.0], [9.0, 4.0, 5.0, 1.0]) == [0, 1, 3]
    assert front([4.0, 1.0, 2.0], [1.0, 9.0, 9.0]) == [1, 0]
    assert front([1.0, 1.0], [2.0, 1.0]) == [1]
    assert front([1.0, np.nan, 2.0], [np.nan, 1.0, 3.0]) == [2]
    assert front([], []) == []
