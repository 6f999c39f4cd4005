# SPDX-License-Identifier: MIT
"""Settings of the study, the choice by target error, and the two-mesh estimate on results with a known order."""

import math
import re
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import xarray as xr

from pysprings import Scene
from pysprings.core.errors import ResourceError, UserInputError
from pysprings.core.words import StopReason
from pysprings.full_model.accuracy import target, two_mesh
from pysprings.full_model.accuracy.measures import SLICES, cell_size
from pysprings.full_model.accuracy.own_estimate import (
    SHARE,
    companions_of,
    estimates_by_default,
    vertical_paths,
    with_estimate,
)
from pysprings.full_model.accuracy.presets import BETWEEN, LINEAR, PRESETS, VARIED, read_mesh, settings
from pysprings.full_model.compute import scene_to_run
from pysprings.full_model.run_record import Computed, MeshFigures, PathFigures, RunRecord, Status
from pysprings.model.build import counts_of, geometry_of
from pysprings.model.fourier import section_counts_of
from pysprings.model.fourier_mesh import COHESIVE, PRESETS as SECTIONS
from pysprings.model.mesh import PRESETS as MESHES, depths, skirt_cells
from pysprings.scene.template import template_text
from pysprings.springs.path import paths_of
from pysprings.springs.tip_zone import reslice
from tests.support import tiny
from tests.support.measured import LENGTH, measured_result, with_error
from tests.support.synthetic import Caisson, Path


def test_the_default_study() -> None:
    found = settings(linear=["pardiso", "superlu"], base_linear="pardiso")
    names = [each.name for each in found]
    assert len(set(names)) == len(names) == len(BETWEEN) + 3 + len(VARIED) + 1
    assert [each.name for each in found if each.series] == ["medium-0.7", "medium", "medium-1.4"]
    assert "medium-superlu" in names and "medium-pardiso" not in names
    for each in found:
        scene = each.scene(tiny.paper(mesh={"azimuth": 12, "refinement": 0.5}))
        assert (scene.mesh.preset, scene.mesh.refinement, scene.mesh.azimuth) == (
            each.mesh,
            0.5 * each.refinement,
            None,
        )
        for key, value in each.solver.items():
            assert getattr(scene.solver, key) == value
    assert set(PRESETS) == set(MESHES)


def test_one_factor_at_a_time_on_the_second_finest_mesh() -> None:
    found = settings(["coarse", "medium:0.7", "medium"])
    assert any(each.solver for each in found)
    for each in found:
        assert len(each.solver) <= 1
        if each.solver:
            assert each.name.startswith("medium-0.7-")
            assert (each.mesh, each.refinement) == ("medium", 0.7)


def test_no_linear_solver_is_tried_where_the_series_has_its_own() -> None:
    for meshes, tried in ((["coarse", "medium"], True), (["fourier-coarse@3", "fourier-coarse:2@3"], False)):
        found = settings(meshes, linear=["rslab", "superlu"], base_linear="rslab")
        assert any(each.group == LINEAR for each in found) == tried


def test_the_series_is_ordered_by_size_and_names_a_mesh_once() -> None:
    found = settings(["medium:1.4", "coarse:1.3", "medium:0.70", "medium:0.7", "coarse", "coarse:1"])
    assert [each.name for each in found if each.series] == ["coarse", "medium-0.7", "coarse-1.3", "medium-1.4"]
    assert {each.mesh for each in found if each.solver} == {"coarse"}
    assert len({each.name for each in found}) == len(found)


def test_meshes_of_series_stand_beside_the_bricks() -> None:
    found = settings(fourier=True)
    series = [each for each in found if each.discretisation == "fourier"]
    assert {each.name for each in series if each.series} == {
        f"fourier-coarse{end}-N8" for end in ("", "-2", "-3", "-4")
    }
    rings = [section_counts_of(each.scene(tiny.paper())).skirt for each in series if each.series]
    assert len(rings) == 4 and min(rings[1:]) >= SLICES  # of the three finest, beside the slices of p(y)
    assert all(each.solver == {"tolerance": 1e-3} for each in series)
    assert {each.mesh for each in found if each.group != "mesh"} == {"medium"}  # bricks alone are varied
    scene = read_mesh("fourier-paper:1.5@5").scene(tiny.paper(mesh={"azimuth": 12}))
    assert (scene.mesh.discretisation, scene.mesh.preset, scene.mesh.refinement) == ("fourier", "paper", 1.5)
    assert (scene.mesh.harmonics, scene.mesh.azimuth, scene.solver.tolerance) == (5, None, 1e-3)
    assert not [each for each in settings(quick=True, fourier=True) if each.discretisation == "fourier"]


def test_a_factor_beyond_the_range_with_that_of_the_scene_is_refused() -> None:
    with pytest.raises(UserInputError, match=r"--mesh: 'medium-4' .* mesh.refinement 4 is 16 times medium, not in"):
        read_mesh("medium:4").scene(tiny.paper(mesh={"refinement": 4.0}))


def test_a_mesh_that_the_scene_cannot_have_is_refused() -> None:
    """It ended as a bug of the program."""
    twist = {"name": "turn", "kind": "twist", "twist": 1e-3, "role": "held-back"}
    with pytest.raises(UserInputError, match=r"--mesh: 'coarse': .*path 'turn' leaves the plane"):
        read_mesh("coarse").scene(tiny.paper(paths=(twist,), mesh={"discretisation": "fourier", "azimuth": None}))
    for count in (0, 99):
        with pytest.raises(UserInputError, match=f"--mesh: 'fourier-coarse-N{count}': {count} is not in"):
            read_mesh(f"fourier-coarse@{count}").scene(tiny.paper(mesh={"azimuth": None}))


def test_quick_is_a_family_with_ever_more_sectors() -> None:
    series = [each for each in settings(quick=True) if each.series]
    assert [counts_of(each.scene(tiny.paper())).azimuth for each in series] == [4, 8, 12]


@pytest.mark.parametrize(
    "text",
    ["huge", "coarse:", "coarse:0.1", "coarse:9", "coarse:x", "Coarse", "coarse@5", "fourier-coarse@", "fourier-huge"],
)
def test_meshes_that_are_refused(text: str) -> None:
    with pytest.raises(UserInputError, match="--mesh: "):
        read_mesh(text)


@pytest.mark.parametrize("preset", PRESETS)
def test_the_coarser_mesh_is_coarser_in_every_direction(preset: str) -> None:
    scene = tiny.paper(mesh={"preset": preset})
    own, other = counts_of(scene), counts_of(two_mesh.coarser(scene))
    for name in ("azimuth", "plug", "outer", "skirt", "below"):
        assert getattr(other, name) < getattr(own, name), name
    assert two_mesh.coarser(tiny.paper(mesh={"azimuth": 16})).mesh.azimuth == 12
    smallest = tiny.paper(mesh={"refinement": 0.25})
    assert two_mesh.coarser(smallest) is smallest


@pytest.mark.parametrize("preset", PRESETS)
def test_the_coarser_section_keeps_small_elements_at_both_ends_of_the_skirt(preset: str) -> None:
    """With two equal elements along the skirt the difference of p(y) would be that of another kind of mesh."""
    scene = tiny.sand(mesh={"preset": preset, "discretisation": "fourier"})
    coarse = two_mesh.coarser(scene)
    own, other = section_counts_of(scene), section_counts_of(coarse)
    ratio = two_mesh.cell_ratio(scene, coarse)
    assert ratio == pytest.approx(1.0 / two_mesh.FACTOR["fourier"])
    assert (other.wall, other.toe) == pytest.approx((ratio * own.wall, ratio * own.toe))
    assert 3 <= other.skirt < own.skirt
    assert two_mesh.cell_ratio(tiny.paper(), two_mesh.coarser(tiny.paper())) is None


def test_the_estimate_is_the_safety_factor_times_the_error_where_the_order_is_true() -> None:
    order = two_mesh.ORDERS["hex8"]["load"]
    fine, coarse = with_error(9000, order), with_error(3000, order)
    found = two_mesh.estimate(fine, coarse)
    true = 100.0 * (1.0 - 1.0 / (1.0 + 100.0 * cell_size(9000) ** order))
    assert found["estimate_pct"]["load_max"] == pytest.approx(two_mesh.SAFETY["hex8"] * true, rel=1e-6)
    assert found["cell_ratio"] == pytest.approx(3.0 ** (1 / 3), abs=1e-4)
    assert "two meshes, 3,000 and 9,000 unknowns" in two_mesh.words(found)
    how = {"paths": ["pull"], "order": order, "left": {"load_max": 0.35, "rotation_max": 0.4}}
    left = two_mesh.estimate(fine, coarse, extrapolated=how)
    ratio = left["by_path"]["pull"]["load_pct"] / found["by_path"]["pull"]["load_pct"]
    assert ratio == pytest.approx(0.35 * (found["cell_ratio"] ** order - 1.0) / 3.0, rel=1e-3)
    assert left["by_path"]["shift"] == found["by_path"]["shift"]
    of_pull = left["by_path"]["pull"]  # both meshes have one rotation
    assert of_pull["rotation_pct"] == of_pull["load_pct"] and found["by_path"]["pull"]["rotation_pct"] == 0.0


@pytest.mark.parametrize(("length", "load", "py"), [(3.9, 0.875, 1.4), (4.0, 0.35, 0.9), (6.0, 0.35, 0.9)])
def test_clay_and_its_short_skirts_leave_more_of_the_difference(length: float, load: float, py: float) -> None:
    """The shares that the scenes of data/evidence/error-estimates-clay.csv ask for."""
    clay = tiny.parsed(template_text("soft-clay")).replace(caisson={"outer_diameter": 8.0, "skirt_length": length})
    assert two_mesh.left_in(clay) == {"load_max": load, "vertical_max": load, "rotation_max": 0.4, "py_rms": py}


def test_sand_leaves_the_shares_that_its_scenes_ask_for() -> None:
    """data/evidence/error-estimates-sand.csv, -dense.csv."""
    frictional = {"load_max": 0.6, "vertical_max": 0.35, "rotation_max": 0.4, "py_rms": 0.9}
    half = {"skirt_length": 0.5 * tiny.sand().caisson.outer_diameter}
    assert two_mesh.left_in(tiny.sand(caisson=half)) == frictional
    short = {"skirt_length": 0.49 * tiny.sand().caisson.outer_diameter}
    assert two_mesh.left_in(tiny.sand(caisson=short)) == frictional | {"load_max": 0.85, "py_rms": 1.4}
    dense = tiny.sand(caisson=half, soil={"yield_surface": "sand", "relative_density": 0.7})
    assert two_mesh.left_in(dense) == frictional | {"load_max": 1.0}


@pytest.mark.parametrize("length", [2.5, 6.0, 9.0])
def test_rings_of_clay_are_no_wider_on_medium_than_on_coarse(length: float) -> None:
    """With wider ones in mid-skirt p-y of `medium` was worse than that of `coarse` (data/evidence/sections.csv)."""
    clay = tiny.parsed(template_text("soft-clay")).replace(caisson={"skirt_length": length})
    geometry, widest = geometry_of(clay), list[float]()
    for preset in ("coarse", "medium"):
        levels = depths(geometry, SECTIONS[COHESIVE][preset])
        widest.append(float(np.diff(levels[: skirt_cells(geometry, levels) + 1]).max()))
    assert widest[1] <= widest[0]


def test_layers_that_one_slice_of_the_coarser_mesh_covers_are_no_error_of_p_y() -> None:
    """Both meshes have the same force in each quarter of a skirt whose p jumps threefold at a layer."""
    fine = measured_result(Caisson(rings=16)).copy(deep=True)
    for path in fine["paths"].children.values():
        path["p"] = path["p"] * xr.where(path["depth"] < 0.25 * LENGTH, 1.0, 3.0)
        path["p_component"] = path["p_component"] * xr.where(path["depth"] < 0.25 * LENGTH, 1.0, 3.0)
    coarse = reslice(fine, np.linspace(0.0, LENGTH, 5))
    assert all(each["py_rms"] < 1e-6 for each in two_mesh.differences(fine, coarse).values())
    weaker = {name: path.to_dataset().assign(p=0.9 * path["p"]) for name, path in coarse["paths"].children.items()}
    for name, path in weaker.items():
        coarse[f"paths/{name}"].dataset = path
    assert all(1.0 < each["py_rms"] < 10.0 for each in two_mesh.differences(fine, coarse).values())


def pushed(unknowns: int, factor: float) -> xr.DataTree:
    """A push on a mesh of so many unknowns, whose V changes by so many times the limit."""
    tree = measured_result(paths=(Path("down", kind="vertical"),)).copy(deep=True)
    path = tree["paths/down"]
    path["w"] = 1e-3 * path["step"]
    path["V"] = 5e6 + factor * 1e8 * path["w"]
    tree.attrs |= {"n_unknowns": unknowns, "status": "complete"}
    return tree


def test_the_load_of_a_vertical_path_is_stated_apart_and_is_no_less_than_meshes_leave_in_common() -> None:
    """V of a push differs by 2 % of its change: 0.35 of that, or what sand has at least."""
    fine, coarse = pushed(9000, 1.0), pushed(3000, 1.02)
    assert two_mesh.differences(fine, coarse)["down"]["vertical_max"] == pytest.approx(2.0)
    assert math.isnan(two_mesh.differences(fine, coarse)["down"]["load_max"])
    how: dict[str, Any] = {"paths": ["down"], "order": 2.0, "left": {"vertical_max": 0.35}}
    for least, stated in ((0.0, 0.7), (4.0, 4.0)):
        found = two_mesh.estimate(fine, coarse, extrapolated=how | {"least": {"vertical_max": least}})
        assert found["estimate_pct"]["vertical_max"] == found["by_path"]["down"]["load_pct"] == pytest.approx(stated)
        assert "load_max" not in found["estimate_pct"] and f"V {stated:g} %" in two_mesh.short(found)


def test_of_halved_elements_at_the_tip_half_of_what_they_change_is_left() -> None:
    """V of a push changes by 4 and by 1 %: 2 %, and the least that is stated; not the 20 % of the coarser mesh."""
    fine, coarse = pushed(9000, 1.0), pushed(3000, 1.2)
    how: dict[str, Any] = {"paths": ["down"], "order": 2.0, "left": {"vertical_max": 0.35}}
    for factor, stated in ((0.96, 2.0), (0.99, 1.0)):
        given = how | {"least": two_mesh.LEAST_IN_SAND}
        near = two_mesh.differences(fine, pushed(9500, factor))
        found = two_mesh.estimate(fine, coarse, extrapolated=given, near=near)
        assert found["estimate_pct"]["vertical_max"] == pytest.approx(stated)


def test_the_estimate_of_a_series_adds_what_more_harmonics_change() -> None:
    """Limit 1; N 3 is 0.2 % above N 5 on the coarser mesh; the errors of the section are 1 % and 2^order %."""
    order = two_mesh.ORDERS["fourier"]["load"]
    slope = 0.01 / cell_size(3000, 3) ** order
    fine = with_error(3000, order, slope, harmonics=3, beside=2e-3)
    coarse, richer = with_error(750, order, slope, 3, 2e-3), with_error(1125, order, slope, 5)
    assert cell_size(750, 3) == pytest.approx(cell_size(1125, 5)) == pytest.approx(2.0 * cell_size(3000, 3))
    found = two_mesh.estimate(fine, coarse, richer)
    whole = 2.0**order
    section = 100.0 * 0.01 / (1.0 + 0.01 + 2e-3)
    series = 100.0 * 2e-3 / (1.0 + 0.01 * whole)
    assert found["cell_ratio"] == pytest.approx(2.0)
    assert found["harmonics"] == [3, 5]
    assert found["harmonics_pct"]["load_max"] == pytest.approx(series, rel=1e-6)
    expected = two_mesh.SAFETY["fourier"] * section + series
    assert found["estimate_pct"]["load_max"] == pytest.approx(expected, rel=1e-6)
    assert "3 and 5 harmonics" in two_mesh.words(found)
    added = {"paths": [], "order": order, "left": {}, "harmonics_added": ["pull"]}
    half = two_mesh.estimate(fine, coarse, richer, extrapolated=added)["by_path"]
    saved = found["by_path"]["pull"]["load_pct"] - half["pull"]["load_pct"]
    assert saved == pytest.approx((1.0 - two_mesh.LEFT) * series, rel=1e-6)
    assert half["shift"] == found["by_path"]["shift"]
    wider = two_mesh.estimate(fine, coarse, richer, ratio=3.0)
    section *= (whole - 1.0) / (3.0**order - 1.0)
    assert wider["estimate_pct"]["load_max"] == pytest.approx(two_mesh.SAFETY["fourier"] * section + series, rel=1e-6)


@pytest.mark.parametrize(
    ("change", "chosen", "asked"),
    [
        ({3: 0.008}, 3, [3, "few 5"]),
        ({3: 0.015}, 3, [3, "few 5", "rest 5"]),  # adding it leaves half
        ({3: 0.08, 5: 0.0}, 5, [3, "few 5", "rest 5", "few 7"]),
        ({3: 0.08, 5: 0.08, 7: 0.03}, 7, [3, "few 5", "rest 5", "few 7", "rest 7", "few 9", "rest 9"]),
    ],
)
def test_harmonics_grow_until_two_more_change_little(
    change: dict[int, float], chosen: int, asked: list[int | str]
) -> None:
    """On the coarser mesh, by more than 2 % (`coarse`); the number of a scene stays, whatever it changes."""
    ran: list[int | str] = []
    spans: list[float] = [SHARE]

    def compute(scene: Scene, span: tuple[float, float], **_: Any) -> Computed:
        n = scene.mesh.harmonics
        assert n is not None and span[0] == spans[-1] < span[1] < 1.0  # one total, of the run and all beside it
        spans.append(span[1])
        names = [path.name for path in scene.all_paths]
        if scene.mesh.halvings:
            assert names == ["down", "up"] and scene.mesh.refinement == 1.0
        part = "few" if "ray_0" in names else "halved" if scene.mesh.halvings else "rest"
        ran.append(n if len(names) == len(fan) else f"{part} {n}")
        above = sum(size for least, size in change.items() if least >= n)
        tree = with_error(300 * (n + 1), harmonics=n, beside=above)
        pull = tree["paths/pull"]
        tree["paths"] = xr.DataTree(children={name: pull.copy() for name in names})
        return Computed(tree, RunRecord(Status.COMPLETE))

    scene = tiny.sand(mesh={"discretisation": "fourier"}, paths=(), springs={"reach": 8e-3})
    fan = scene.all_paths
    found = companions_of(scene, compute)
    assert found.harmonics == chosen and ran == [*asked, "halved 1"]
    assert scene_to_run(scene, harmonics=found.harmonics).mesh.harmonics == chosen
    ran.clear()
    spans[:] = [SHARE]
    assert companions_of(scene, compute, chosen=chosen).harmonics == chosen  # a run that goes on
    assert ran[:2] == [chosen, f"few {chosen + 2}"]
    given = scene.replace(mesh={"harmonics": 3})
    spans[:] = [SHARE]
    assert companions_of(given, compute).harmonics == 3
    assert scene_to_run(given, harmonics=9) is given
    assert [path.name for path in vertical_paths(scene)] == ["down", "up"]
    assert not vertical_paths(scene.replace(mesh={"halvings": 4}))  # no more are allowed
    assert estimates_by_default(scene) and not estimates_by_default(tiny.paper())


def test_rays_of_the_memory_on_which_V_changes_run_with_more_harmonics() -> None:
    """The scene with some of its paths alone has no further vertical loads beside them."""
    ran: list[str] = []

    def compute(scene: Scene, **_: Any) -> Computed:
        n = scene.mesh.harmonics
        assert n is not None
        names = [path.name for path in scene.all_paths]
        ran.extend(names if n == 5 else ())
        tree = with_error(300 * (n + 1), harmonics=n, beside=0.015 if n == 3 else 0.0)
        tree["paths"] = xr.DataTree(children={name: tree["paths/pull"].copy() for name in names})
        return Computed(tree, RunRecord(Status.COMPLETE))

    springs = {"reach": 8e-3, "memory": True, "vertical_loads": [3e6]}
    scene = tiny.sand(mesh={"discretisation": "fourier"}, paths=(), springs=springs)
    assert companions_of(scene, compute).why_not == ""
    assert {path.name for path in scene.all_paths} == {*ran} | {"down", "up"} and "ray_0_loads" in ran


def test_a_path_that_a_load_drives_is_not_helped_by_what_harmonics_change() -> None:
    """3 and 5 differ by 3 % on a path of kind load: N grows, since no difference can be added at equal motion."""

    def compute(scene: Scene, **_: Any) -> Computed:
        n = scene.mesh.harmonics
        tree = with_error(300 * (n + 1), harmonics=n, beside=0.03 if n == 3 else 0.0)
        for path in tree["paths"].children.values():
            path.attrs["kind"] = kind
        return finished(tree)

    scene = tiny.sand(mesh={"discretisation": "fourier"})
    for kind, chosen in (("load", 5), ("pull", 3)):  # noqa: B007 (compute has the kind)
        assert companions_of(scene, compute).harmonics == chosen


def finished(tree: Any, status: Status = Status.COMPLETE, stopped: StopReason | None = None) -> Computed:
    """Return a result whose record has the tree's number of harmonics."""
    paths = {name: PathFigures(Status.COMPLETE) for name in paths_of(tree)}
    return Computed(
        tree, RunRecord(status, stopped, mesh=MeshFigures(harmonics=tree.attrs.get("harmonics")), paths=paths)
    )


def fails(*_: Any, **__: Any) -> Computed:
    raise ResourceError("no memory")


def breaks(*_: Any, **__: Any) -> Computed:
    raise IndexError("a bug")


def ends(why: StopReason) -> Callable[..., Computed]:
    return lambda *_, **__: finished(with_error(3000, harmonics=3), Status.INTERRUPTED, why)


@pytest.mark.parametrize("discretisation", ["fourier", "hex8"])
@pytest.mark.parametrize(
    ("compute", "words"),
    [
        (fails, "no memory"),
        (breaks, "IndexError: a bug"),
        (ends(StopReason.INTERRUPTED), "interrupted"),
        (ends(StopReason.OUT_OF_MEMORY), "out of memory"),
    ],
)
def test_whatever_becomes_of_the_coarser_run_the_result_stays(
    discretisation: str, compute: Callable[..., Computed], words: str
) -> None:
    scene = tiny.sand(mesh={"discretisation": discretisation}) if discretisation == "fourier" else tiny.paper()
    done = finished(with_error(9000, harmonics=3 if discretisation == "fourier" else None))
    load = done.tree["paths/pull/H"].values.copy()
    companions = companions_of(scene, compute)
    assert companions.harmonics is None
    assert with_estimate(scene, done, companions, breaks) is done
    assert words in done.record.error_estimate["why_not"] and words in done.record.not_made["error estimate"]
    assert words in done.record.left_to_make and "--resume" in done.record.left_to_make
    assert words in done.recorded().attrs["run_json"]
    np.testing.assert_array_equal(done.tree["paths/pull/H"], load)


def test_a_coarser_run_beyond_its_time_is_given_up_and_named() -> None:
    """Its progress stops it, as Ctrl-C would; the run's own results are there, and nothing else is left out."""

    def compute(scene: Scene, progress: Any, **_: Any) -> Computed:
        progress("pull", 0.5, "")
        return finished(with_error(3000, harmonics=scene.mesh.harmonics))

    scene, done = tiny.sand(mesh={"discretisation": "fourier"}), finished(with_error(9000, harmonics=3))
    assert companions_of(scene, compute, until=time.monotonic() + 60.0).why_not == ""
    late = companions_of(scene, compute, until=time.monotonic() - 1.0)
    with_estimate(scene, done, late, breaks)
    assert done.record.not_made == {"error estimate": "it took more than 5 times the run itself, and 5 minutes"}
    assert "--resume" in done.record.left_to_make


def test_an_estimate_waits_for_its_share_of_the_harmonics() -> None:
    """Time is over in the run with two more: an estimate without it would be too small, and a target met wrongly."""
    ends: list[float] = []

    def compute(scene: Scene, progress: Any, **_: Any) -> Computed:
        if ends:
            time.sleep(max(ends[0] - time.monotonic(), 0.0) + 0.01)
        ends.append(time.monotonic() + 0.2)
        progress("pull", 0.5, "")
        return finished(with_error(300 * (scene.mesh.harmonics + 1), harmonics=scene.mesh.harmonics))

    scene, done = tiny.sand(mesh={"discretisation": "fourier"}), finished(with_error(9000, harmonics=3))
    companions = companions_of(scene, compute, until=time.monotonic() + 0.1)
    assert companions.trees and not companions.richer
    with_estimate(scene, done, companions, breaks)
    assert done.record.error_estimate["estimate_pct"] == {} and "5 times" in done.record.error_estimate["why_not"]


@pytest.mark.parametrize(
    ("again", "kept", "words"),
    [
        (lambda n, _: finished(with_error(9000, harmonics=n)), 5, ""),
        (
            lambda n, _: finished(with_error(9000, harmonics=n), Status.PARTIAL),
            3,
            "the run with 5 harmonics, which the",
        ),
        (lambda n, _: finished(with_error(9000, harmonics=n), Status.INTERRUPTED, StopReason.INTERRUPTED), 3, "(inter"),
        (breaks, 3, "IndexError: a bug"),
    ],
)
def test_more_harmonics_replace_a_result_only_where_they_come_as_far(again: Any, kept: int, words: str) -> None:
    """The coarser mesh asks for five: 3 and 5 differ by 8 %, 5 and 7 do not."""

    def compute(scene: Scene, **_: Any) -> Computed:
        n = scene.mesh.harmonics
        return finished(with_error(300 * (n + 1), harmonics=n, beside=0.08 if n == 3 else 0.0))

    scene = tiny.sand(mesh={"discretisation": "fourier"})
    result = with_estimate(scene, finished(with_error(9000, harmonics=3)), companions_of(scene, compute), again)
    assert result.record.mesh.harmonics == kept
    assert words in " ".join([*result.record.warnings, result.record.left_to_make])
    assert result.record.error_estimate["harmonics"] == [kept, kept + 2]


def test_an_estimate_names_its_worst_path_and_where_the_companion_stopped() -> None:
    far, near = (with_error(3000, harmonics=3, slope=slope) for slope in (200.0, 50.0))
    fine = with_error(9000, harmonics=3)
    for tree, other in ((far, near), (fine, with_error(9000, harmonics=3))):
        tree["paths/second"] = other["paths/pull"].copy()
    far["paths/second"] = far["paths/second"].to_dataset().isel(step=slice(0, -1))
    far["paths/shift"]["p"] = 1.1 * far["paths/shift"]["p"]
    stopped = PathFigures(Status.PARTIAL, StopReason.APEX)
    done, coarse = finished(fine), finished(far, Status.PARTIAL)
    coarse.record.paths["second"] = stopped
    scene = tiny.sand(mesh={"discretisation": "fourier", "harmonics": 3})
    with_estimate(scene, done, companions_of(scene, lambda *_, **__: coarse), breaks)
    found = done.record.error_estimate
    assert found["worst_path"] == "shift"  # p-y of both meshes differs more there
    assert found["by_path"]["pull"]["load_pct"] == found["estimate_pct"]["load_max"]
    assert found["by_path"]["pull"]["load_pct"] > found["by_path"]["second"]["load_pct"]
    words = two_mesh.words(found)
    assert "companion stopped on 1 of 4 paths: second (apex)" in words and "p-y of path shift" in words


def test_a_path_without_a_converged_state_is_left_out_of_an_estimate() -> None:
    """It stopped during its dead load, on both meshes or on either: the state that it reached is marked."""
    trees = [with_error(n) for n in (9000, 3000)]
    for tree, name in zip(trees * 2, ("stuck", "stuck", "shift", "turn"), strict=True):
        tree[f"paths/{name}"] = tree["paths/pull"].to_dataset().isel(step=[0]).assign(converged=("step", [0]))
    assert sorted(two_mesh.differences(*trees)) == ["pull"]


def test_meshes_that_are_alike_give_no_estimate() -> None:
    found = two_mesh.estimate(with_error(9000), with_error(8900))
    assert found["estimate_pct"] == {}
    assert "no mesh with fewer cells" in two_mesh.words(found)


def test_differences_without_a_finite_value_give_no_estimate(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(two_mesh.measures, "errors", lambda *_: dict.fromkeys(two_mesh.ESTIMATED, np.nan))
    found = two_mesh.estimate(with_error(9000), with_error(3000))
    assert found["estimate_pct"] == {}
    assert "no finite value" in two_mesh.words(found)


@pytest.mark.parametrize(
    ("load", "py", "stopped", "words"),
    [
        (4.0, 3.0, {}, None),
        (28.0, 3.0, {}, r"--target-error 5%: the run's own estimate is load 28 % \(path p\)"),
        (4.0, 5.04, {}, "p-y 5.04 %"),
        (4.0, 3.0, {"p": "apex"}, "the estimate ends where the coarser mesh stopped, on p"),
    ],
)
def test_a_target_is_met_by_the_estimate_of_the_run_alone(
    load: float, py: float, stopped: dict[str, str], words: str | None
) -> None:
    estimate = {"estimate_pct": {"load_max": load, "py_rms": py}, "worst_path": "p", "companion_stopped": stopped}
    scene = target.start(tiny.paper(), "5%")
    missed = target.judged("5%", scene, estimate, [])["missed"]
    assert missed is None if words is None else re.search(words, missed)
    assert "no estimate" in target.judged("5%", scene, {}, [])["missed"]


def test_the_next_mesh_of_a_target_has_the_cells_that_the_estimate_asks_for() -> None:
    scene = target.start(tiny.paper(mesh={"refinement": 0.5, "azimuth": 16}), "2%")
    assert (scene.mesh.preset, scene.mesh.refinement, scene.mesh.azimuth) == ("medium", 1.0, None)
    noted = target.judged("2%", scene, {"estimate_pct": {"load_max": 4.0, "py_rms": 0.9}}, [])
    after, why = target.finer(scene, noted)
    assert after is not None and not why
    assert after.mesh.refinement == pytest.approx(2.0 ** (1.0 / target.ORDER), abs=0.01)
    assert target.cost(10.0, scene, after) == pytest.approx(10.0 * after.mesh.refinement**3)
    assert target.as_ran(tiny.paper(), noted).mesh.preset == "medium"
    many = target.judged("2%", after, {"estimate_pct": {"load_max": 4.0, "py_rms": 0.9}}, noted["runs"] * 3)
    assert target.finer(after, many) == (None, "4 meshes were tried")
    blind = target.judged("2%", scene, {"why_not": "a path stopped"}, [])
    assert target.finer(scene, blind)[0] is None and "a path stopped" in blind["missed"]
