# SPDX-License-Identifier: MIT
"""Every variable of full_model.nc that is derived, against plain loops over stations, nodes and cells."""

import itertools

import numpy as np
import pytest
import xarray as xr

from pysprings.core import variables
from pysprings.core.storage import read_tree, write_tree
from pysprings.model.contact import SURFACE
from tests.support import raw_caisson as rc
from tests.support.raw_caisson import STEPS, Raw, raw

STEP = 4
GAUSS = 1.0 / np.sqrt(3.0)
CORNERS = [(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)]
GAUSS_POINTS = [tuple(GAUSS * s for s in signs) for signs in itertools.product((-1.0, 1.0), repeat=3)]


@pytest.fixture(scope="module", params=["swept", "down"])
def name(request: pytest.FixtureRequest) -> str:
    found: str = request.param
    return found


@pytest.fixture(scope="module")
def path(name: str, tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    """A path as it is read back from the file."""
    tree = read_tree(write_tree(rc.result(), tmp_path_factory.mktemp("full") / "full_model.nc"))
    return tree[f"paths/{name}"].to_dataset(inherit=False)


def shapes(point: tuple[float, ...]) -> list[float]:
    """Trilinear shape functions at a point of the unit cell."""
    return [0.125 * np.prod([1.0 + c * x for c, x in zip(corner, point, strict=True)]) for corner in CORNERS]


def volume_at(corners: np.ndarray, point: tuple[float, ...]) -> float:
    """Volume (m3) that a Gauss point of a cell with these corners (8, 3) stands for."""
    slope = np.zeros((8, 3))
    for a, corner in enumerate(CORNERS):
        for i in range(3):
            factors = [1.0 + c * x for j, (c, x) in enumerate(zip(corner, point, strict=True)) if j != i]
            slope[a, i] = 0.125 * corner[i] * factors[0] * factors[1]
    return float(np.linalg.det(corners.T @ slope))


def moved(one: Raw) -> np.ndarray:
    """Displacement (n, 3) of the nodes in the axes of the model."""
    frames = rc.built().model.frames
    rows = enumerate(one.state.displacement)
    return np.array([frames[k].T @ u if k in frames else u for k, u in rows])


@pytest.mark.slow
def test_faces_of_the_caisson(path: xr.Dataset, name: str) -> None:
    for step in range(STEPS):
        now, here = raw(name, step), path.isel(step=step)
        for face in SURFACE:
            for load in "HVM":
                found = float(here[f"{load}_{face}"])
                assert found == pytest.approx(now["on"][face][load], rel=1e-9, abs=1e-3), (face, load)
        for change, face in (("F_in", "inner"), ("F_out", "outer")):
            expected = now["on"][face]["V"] - raw(name, 0)["on"][face]["V"]
            assert float(here[change]) == pytest.approx(expected, rel=1e-9, abs=1e-3)
        assert float(here["F_pw"]) == pytest.approx(now["motion"]["F_pw"], rel=1e-9)
        for load in "HVM":
            assert float(here[load]) == pytest.approx(now["total"][load], rel=1e-9, abs=1e-3)
        for k, z in enumerate(rc.depths()):
            assert float(here["p"][k]) == pytest.approx(now["net"][z]["p"], rel=1e-9, abs=1e-3)
            for side in variables.SIDES:
                ring, at = now["ring"][side, z], here.isel(depth=k).sel(side=side)
                for part in variables.COMPONENTS:
                    found = float(at["p_component"].sel(component=part))
                    assert found == pytest.approx(ring[part], rel=1e-9, abs=1e-3)
                assert [float(at["m"]), float(at["t"])] == pytest.approx([ring["m"], ring["t"]], rel=1e-9, abs=1e-3)


def test_fields_on_the_walls(path: xr.Dataset, name: str) -> None:
    one, built = Raw(name, STEP), rc.built()
    stations = built.model.stations
    assert stations is not None
    count = 0
    for k, (face, (x, y, z), parts) in enumerate(one.stations()):
        if face not in ("outer", "inner"):
            continue
        side, twice = {"outer": "outside", "inner": "inside"}[face], 2.0 * stations.area[k]
        i = int(np.argmin(np.abs(built.caisson.azimuth - np.arctan2(y, x))))
        here = path.isel(step=STEP, azimuth=i, depth=int(np.argmin(np.abs(built.caisson.depth - z)))).sel(side=side)
        normal = float(parts["normal"] @ stations.frame[k, 0]) / twice
        expected = {
            "normal_effective_stress": normal, "shear_lateral": parts["shear"][0] / twice,
            "shear_vertical": parts["shear"][2] / twice, "pore_pressure": one.water(k), "gap": one.gap(k)
        }  # fmt: skip
        for variable, value in expected.items():
            assert float(here[variable]) == pytest.approx(value, rel=1e-9, abs=1e-9), variable
        count += 1
    assert count == 2 * len(built.caisson.azimuth) * len(built.caisson.depth)
    assert float(path["gap"].max()) > 1e-6


def test_lid_and_tip(path: xr.Dataset, name: str) -> None:
    one, seen = Raw(name, STEP), {"lid": 0, "tip": 0}
    for k, (face, (x, y, _), _) in enumerate(one.stations()):
        if face in seen:
            here = path.isel({"step": STEP, f"{face}_point": seen[face]})
            assert [float(here[f"{face}_x"]), float(here[f"{face}_y"])] == [x, y]
            expected = {
                "normal_effective_stress": -one.state.traction[k, 0],
                "gap": one.gap(k),
                "pore_pressure": one.water(k),
            }
            for variable, value in expected.items():
                assert float(here[f"{face}_{variable}"]) == pytest.approx(value, rel=1e-9, abs=1e-12), variable
            seen[face] += 1
    assert seen == {face: path.sizes[f"{face}_point"] for face in seen} and min(seen.values()) > 0


def test_volumes_of_water(path: xr.Dataset, name: str) -> None:
    """Of the whole caisson: pores by the volume of the deformed cells, compression and film by sums over points."""
    model, one, start = rc.built().model, Raw(name, STEP), Raw(name, 0)
    stations, water = model.stations, model.water
    assert stations is not None and water is not None
    u, h = moved(one) - moved(start), 1e-3
    expelled = compressed = 0.0
    for cell in model.mesh.hexes:
        corners = model.mesh.nodes[cell]
        change = one.state.pressure[cell] - start.state.pressure[cell]
        for point in GAUSS_POINTS:
            ahead, behind = (volume_at(corners + sign * h * u[cell], point) for sign in (1.0, -1.0))
            expelled -= (ahead - behind) / (2.0 * h)
            pressure = sum(n * p for n, p in zip(shapes(point), change, strict=True))
            compressed += water.storage * pressure * volume_at(corners, point)
    film = sum(float(stations.area[k]) * (one.gap(k) - start.gap(k)) for k in range(len(stations.area)))
    here = path.isel(step=STEP)
    found = {key: float(here[f"water_{key}"]) for key in ("expelled", "compressed", "film", "outflow", "moved")}
    assert found["expelled"] == pytest.approx(2.0 * expelled, rel=1e-8)
    assert found["compressed"] == pytest.approx(2.0 * compressed, rel=1e-8)
    assert found["film"] == pytest.approx(2.0 * film, rel=1e-9) and film > 1e-9
    assert found["moved"] == pytest.approx(2.0 * 7e-3)
    left = found["expelled"] - found["compressed"] - found["film"] - found["outflow"]
    assert float(here["water_imbalance"]) == pytest.approx(left, rel=1e-9)


def test_pressures(path: xr.Dataset, name: str) -> None:
    model, one = rc.built().model, Raw(name, STEP)
    soil = [float(p) for p in one.state.pressure[: model.mesh.n_nodes]]
    film = [float(p) for p in one.state.pressure[model.mesh.n_nodes :]]
    here = path.isel(step=STEP)
    assert float(here["pressure_min"]) == min(soil + film)
    assert float(here["pressure_max"]) == max(soil)
    z = [*model.mesh.nodes[:, 2], *model.mesh.nodes[rc.built().film_mesh_node, 2]]
    over = [101_325.0 - 2_339.0 + rc.WEIGHT * (rc.SEA + depth) + p for depth, p in zip(z, soil + film, strict=True)]
    assert float(here["cavitation_margin"]) == pytest.approx(min(over), rel=1e-12)
    assert np.argmin(over) != np.argmin(soil + film)  # depth counts


def test_the_symmetry_plane(path: xr.Dataset, name: str) -> None:
    """Nodes of the plane, in the order of section_node; none of them has axes of its own in x and z."""
    built, one = rc.built(), Raw(name, STEP)
    nodes = sorted({int(node) for quad in built.caisson.section for node in quad})
    assert all(abs(built.model.mesh.nodes[node, 1]) < 1e-9 for node in nodes)
    section = rc.result()["section"]
    for k, node in enumerate(nodes):
        x, _, z = built.model.mesh.nodes[node]
        assert (float(section["section_x"][k]), float(section["section_depth"][k])) == (x, z)
        here = path.isel(step=STEP, section_node=k)
        assert [float(here["section_ux"]), float(here["section_uz"])] == list(one.state.displacement[node][[0, 2]])
        assert float(here["section_pore_pressure"]) == one.state.pressure[node]


def test_the_whole_model(path: xr.Dataset, name: str) -> None:
    built, one = rc.built(), Raw(name, STEP)
    mesh, stations, here = built.model.mesh, built.model.stations, path.isel(step=STEP)
    assert stations is not None
    u, gap = moved(one), np.zeros(mesh.n_nodes)
    for k in range(len(stations.area)):
        for node, weight in zip(stations.nodes[k], stations.weight[k], strict=True):
            if weight > 0.0:
                gap[node] = max(gap[node], one.gap(k))
    single = {"rtol": 1e-6, "atol": 1e-12}  # single precision
    for i, axis in enumerate("xyz"):
        np.testing.assert_allclose(here[f"volume_u{axis}"], u[:, i], err_msg=axis, **single)
    np.testing.assert_allclose(here["volume_gap"], gap, **single)
    np.testing.assert_allclose(here["volume_pore_pressure"], one.state.pressure[: mesh.n_nodes], **single)
    for cell in range(mesh.n_elements):
        for i, part in enumerate(("xx", "yy", "zz", "xy", "yz", "zx")):
            mean = sum(float(one.state.stress[cell, point, i]) for point in range(8)) / 8.0
            assert float(here[f"volume_s{part}"][cell]) == pytest.approx(mean, rel=1e-5, abs=1e-2)
        assert float(here["volume_plastic_strain"][cell]) == pytest.approx(rc.strain_of(one.state, cell), rel=1e-6)
    whole = rc.result()["volume"]
    for i, axis in enumerate("xyz"):
        np.testing.assert_array_equal(whole[f"volume_{axis}"], mesh.nodes[:, i])
    np.testing.assert_array_equal(whole["volume_hex"], mesh.hexes)
    assert not whole["volume_steel"].values.any()


def test_no_variable_is_left_out(path: xr.Dataset) -> None:
    """Those above are all that a rigid caisson's result has."""
    seen = {f"{load}{face}" for load in "HVM" for face in ("", "_outer", "_inner", "_lid", "_tip")}
    seen |= {"F_in", "F_out", "F_pw", "p", "p_component", "m", "t", "time", "converged", "depth", "azimuth", "side"}
    seen |= {"component", "step", "depth_bounds", "u", "w", "rotation", "y", "pressure_min", "pressure_max"}
    seen |= {"normal_effective_stress", "shear_lateral", "shear_vertical", "pore_pressure", "gap", "cavitation_margin"}
    seen |= {
        f"{face}_{name}"
        for face in ("lid", "tip")
        for name in ("x", "y", "normal_effective_stress", "gap", "pore_pressure")
    }
    seen |= {f"water_{name}" for name in ("expelled", "compressed", "film", "outflow", "moved", "imbalance")}
    seen |= {"section_ux", "section_uz", "section_pore_pressure", "volume_gap", "volume_pore_pressure"}
    seen |= {f"volume_u{axis}" for axis in "xyz"} | {f"volume_s{part}" for part in variables.STRESSES}
    assert set(path.variables) == seen | {"volume_plastic_strain"}
