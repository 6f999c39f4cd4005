# SPDX-License-Identifier: MIT
"""The mesh fills the soil around the caisson, fits together, and its interface faces look into the soil."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from fe_engine.elements import hex8
from fe_engine.elements.interface import nodal_stations
from pysprings.model.forecast.resources import size_of
from pysprings.model.fourier import build
from pysprings.model.fourier_mesh import PRESETS as SECTIONS
from pysprings.model.mesh import (
    DIAMETER,
    LENGTH,
    PRESETS,
    SURFACES,
    CaissonMesh,
    Counts,
    Geometry,
    PlaneCounts,
    counted,
    down_the_skirt,
    graded,
    graded_both,
    make_mesh,
    refine,
    through,
)
from tests.support import tiny

GEOMETRY = Geometry(inner_radius=3.8, outer_radius=3.9, skirt_length=4.0, domain_radius=24.0, domain_depth=12.0)
# local faces of a hexahedron, normals outwards
FACES = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])


def stretch(counts: Counts) -> float:
    """Rings are widened so that the polygons have the area of their circles."""
    step = np.pi / counts.azimuth
    return float(np.sqrt(step / np.sin(step)))


@pytest.fixture(scope="module", params=["coarse", "tip of two cells", "small and deep"])
def case(request: pytest.FixtureRequest) -> tuple[CaissonMesh, Geometry, Counts]:
    geometry, counts = GEOMETRY, refine(PRESETS["coarse"], 0.5)
    if request.param == "coarse":
        counts = PRESETS["coarse"]
    elif request.param == "tip of two cells":
        counts = replace(counts, tip=2, azimuth=12)
    else:
        geometry = Geometry(0.9, 1.0, 6.0, 5.0, 14.0)
    return make_mesh(geometry, counts), geometry, counted(geometry, counts)


def boundary_faces(mesh: CaissonMesh) -> np.ndarray:
    """Faces (k, 4) that belong to one element only."""
    faces = mesh.mesh.hexes[:, FACES].reshape(-1, 4)
    _, index, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    assert count.max() == 2
    return faces[index[count == 1]]


def test_the_elements_fill_the_soil_exactly(case: tuple[CaissonMesh, Geometry, Counts]) -> None:
    caisson, g, _ = case
    assert caisson.mesh.check().min_jacobian > 0.2
    _, volume, _ = hex8.geometry(caisson.mesh.nodes, caisson.mesh.hexes)
    steel = (g.outer_radius**2 - g.inner_radius**2) * g.skirt_length
    assert volume.sum() == pytest.approx(0.5 * np.pi * (g.domain_radius**2 * g.domain_depth - steel), rel=1e-12)


def test_elements_meet_face_to_face_and_end_at_known_boundaries(case: tuple[CaissonMesh, Geometry, Counts]) -> None:
    caisson, g, _ = case
    nodes, sets, faces = caisson.mesh.nodes, caisson.mesh.node_sets, caisson.mesh.face_sets
    interface = {tuple(sorted(face)) for name in SURFACES for face in faces[name]}
    inside = {name: np.isin(np.arange(len(nodes)), sets[name]) for name in ("symmetry", "side", "bottom")}
    found = set()
    for face in boundary_faces(caisson):
        if tuple(sorted(face)) in interface:
            found.add(tuple(sorted(face)))
            continue
        on_set = any(inside[name][face].all() for name in inside)
        mudline = (nodes[face, 2] == 0.0).all() and np.hypot(*nodes[face, :2].T).min() > 0.99 * g.outer_radius
        assert on_set or mudline
    assert found == interface


def test_sets_lie_where_their_names_say(case: tuple[CaissonMesh, Geometry, Counts]) -> None:
    caisson, g, counts = case
    nodes, sets = caisson.mesh.nodes, caisson.mesh.node_sets
    np.testing.assert_allclose(nodes[sets["symmetry"], 1], 0.0, atol=1e-12)
    np.testing.assert_allclose(nodes[sets["bottom"], 2], g.domain_depth)
    np.testing.assert_allclose(np.hypot(*nodes[sets["side"], :2].T), g.domain_radius * stretch(counts))
    assert len(sets["symmetry"]) == np.count_nonzero(np.abs(nodes[:, 1]) < 1e-9)
    assert len(sets["bottom"]) == np.count_nonzero(nodes[:, 2] > g.domain_depth - 1e-9)


def test_walls_are_grids_of_azimuth_and_depth(case: tuple[CaissonMesh, Geometry, Counts]) -> None:
    caisson, g, counts = case
    assert caisson.depth[0] == 0.0 and caisson.depth[-1] == pytest.approx(g.skirt_length)
    assert (np.diff(caisson.depth) > 0).all()
    for side, radius in (("outside", g.outer_radius), ("inside", g.inner_radius)):
        wall = caisson.mesh.nodes[caisson.walls[side]]
        assert wall.shape == (counts.azimuth + 1, counts.skirt + 1, 3)
        np.testing.assert_allclose(wall[:, :, 2], np.broadcast_to(caisson.depth, wall.shape[:2]))
        np.testing.assert_allclose(np.hypot(wall[..., 0], wall[..., 1]), radius * stretch(counts))
        angle = np.arctan2(wall[..., 1], wall[..., 0])
        np.testing.assert_allclose(angle, np.broadcast_to(caisson.azimuth[:, None], angle.shape), atol=1e-12)


def test_interface_faces_look_from_the_caisson_into_the_soil(case: tuple[CaissonMesh, Geometry, Counts]) -> None:
    caisson, g, counts = case
    outside, inside = g.outer_radius * stretch(counts), g.inner_radius * stretch(counts)
    facet = np.cos(0.5 * np.pi / counts.azimuth)  # a flat facet is nearer to the axis than its corners
    # chords of unit radius, projected on the normals of their ends; those of the ring's ends stand on one facet
    arc = 2.0 * np.sin(0.5 * np.pi / counts.azimuth) * ((counts.azimuth - 1) * facet + 1.0)
    expected = {
        "outer": arc * outside * g.skirt_length,
        "inner": arc * inside * g.skirt_length,
        "lid": 0.5 * np.pi * g.inner_radius**2,
        "tip": 0.5 * np.pi * (g.outer_radius**2 - g.inner_radius**2),
    }
    for name, area in expected.items():
        node, normal, share = nodal_stations(caisson.mesh.nodes, caisson.mesh.face_sets[name])
        position = caisson.mesh.nodes[node]
        if name in ("lid", "tip"):
            np.testing.assert_allclose(normal, np.broadcast_to([0, 0, 1], normal.shape), atol=1e-9)
            assert share.sum() == pytest.approx(area, rel=1e-9)
        else:
            radial = (normal[:, :2] * position[:, :2]).sum(axis=1) / np.hypot(*position[:, :2].T)
            assert (radial * (1.0 if name == "outer" else -1.0) >= facet - 1e-9).all()
            assert share.sum() == pytest.approx(area, rel=1e-9)


def test_the_section_covers_the_symmetry_plane(case: tuple[CaissonMesh, Geometry, Counts]) -> None:
    caisson, g, counts = case
    corner = caisson.mesh.nodes[caisson.section][:, :, [0, 2]]
    d1, d2 = corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]
    area = 0.5 * np.abs(d1[:, 0] * d2[:, 1] - d1[:, 1] * d2[:, 0]).sum()
    wall = (g.outer_radius - g.inner_radius) * g.skirt_length
    assert area == pytest.approx(2.0 * stretch(counts) * (g.domain_radius * g.domain_depth - wall), rel=1e-9)


def test_levels_grow_from_the_size_asked_for() -> None:
    levels = graded(1.0, 3.0, 6, 0.1)
    assert (levels[0], levels[-1], levels[1] - levels[0]) == pytest.approx((1.0, 3.0, 0.1))
    ratio = np.diff(levels)[1:] / np.diff(levels)[:-1]
    np.testing.assert_allclose(ratio, ratio[0])
    np.testing.assert_allclose(graded(0.0, 1.0, 4, 0.25), np.linspace(0, 1, 5))
    np.testing.assert_allclose(np.diff(graded(3.0, 1.0, 6, 0.1)), -np.diff(levels))
    assert np.diff(graded(0.0, 1.0, 3, 0.5))[0] == pytest.approx(0.5)


@pytest.mark.parametrize("n", [6, 7, 16])
def test_levels_can_be_small_at_both_ends(n: int) -> None:
    levels = graded_both(4.0, n, 0.2, 0.1)
    cells = np.diff(levels)
    assert (levels[0], levels[-1], len(levels)) == pytest.approx((0.0, 4.0, n + 1))
    assert cells[0] == pytest.approx(0.2, rel=0.3) and cells[-1] == pytest.approx(0.1, rel=0.3)
    assert cells.max() > 0.3


@pytest.mark.parametrize("counts", [PRESETS["coarse"], *(each for of in SECTIONS.values() for each in of.values())])
@pytest.mark.parametrize("ratio", [0.05, 0.2, 0.3, 0.4, 0.47, 0.6, 1.5, 3.0])
def test_no_caisson_has_larger_cells_at_mudline_and_tip_than_the_reference(counts: PlaneCounts, ratio: float) -> None:
    first, last = counts.mudline * LENGTH / DIAMETER, counts.toe * LENGTH / DIAMETER
    cells = np.diff(down_the_skirt(ratio, 1.0, counts.skirt, counts.mudline, counts.toe))
    assert cells.sum() == pytest.approx(ratio)
    assert cells[0] <= 1.001 * first and cells[-1] <= 1.001 * last


def test_refinement_scales_counts_and_sizes() -> None:
    fine = refine(PRESETS["coarse"], 2.0)
    assert (fine.azimuth, fine.plug, fine.skirt) == (16, 8, 14)
    assert fine.wall == pytest.approx(0.5 * PRESETS["coarse"].wall)
    assert refine(PRESETS["coarse"], 0.1).tip == 1


@pytest.mark.parametrize(
    ("preset", "nodes", "elements"), [("medium", 2500, 2000), ("paper", 16000, 14000), ("fine", 40000, 35000)]
)
def test_presets_are_at_least_as_large_as_promised_and_sound(preset: str, nodes: int, elements: int) -> None:
    mesh = make_mesh(GEOMETRY, PRESETS[preset]).mesh
    assert mesh.n_nodes >= nodes
    assert mesh.n_elements >= elements
    assert mesh.check().min_jacobian > 0.2


def test_the_coarse_preset_is_about_2000_nodes() -> None:
    assert make_mesh(GEOMETRY, PRESETS["coarse"]).mesh.n_nodes == pytest.approx(2000, rel=0.2)


# --- levels that pass through lines: ends, lines, sizes; meshes of layered ground in both discretisations ---

LEVELS = graded_both(4.0, 11, 0.24, 0.24)


@given(st.lists(st.floats(-1.0, 6.0), max_size=20))
def test_levels_stand_on_every_line_inside_and_rise(lines):
    found = through(LEVELS, lines)
    assert found[0] == LEVELS[0]
    assert found[-1] == LEVELS[-1]
    assert np.all(np.diff(found) > 0.0)
    inside = [line for line in lines if 1e-6 < line < 4.0 - 1e-6]
    assert all(np.min(np.abs(found - line)) < 1e-8 for line in inside)


def test_levels_without_lines_between_them_stay_as_they_are():
    assert through(LEVELS, [0.0, 4.0, 7.0, float(LEVELS[3])]) is LEVELS


def test_cells_keep_about_their_size():
    found = through(LEVELS, [1.9])
    assert abs(len(found) - len(LEVELS)) <= 1
    sizes, at = np.diff(found), 0.5 * (found[1:] + found[:-1])
    before = np.interp(at, 0.5 * (LEVELS[1:] + LEVELS[:-1]), np.diff(LEVELS))
    assert np.all(sizes / before == pytest.approx(1.0, abs=0.6))


@pytest.mark.parametrize("discretisation", ["hex8", "fourier"])
def test_meshes_stand_on_the_boundaries_of_layers(discretisation):
    tops = (0.0, 0.33, 0.8, 1.31, 2.0)
    layers = [{"top": top} for top in tops]
    scene = tiny.scene(mesh={"discretisation": discretisation}, soil={"layers": layers})
    model = build(scene).model
    depth = model.mesh.nodes[:, -1]
    assert all(np.min(np.abs(depth - top)) < 1e-9 for top in tops)
    assert size_of(scene).nodes == model.mesh.n_nodes
    assert size_of(scene).elements == model.mesh.n_elements
