# SPDX-License-Identifier: MIT
"""What the benchmarks of cost and of error estimates make of their runs: ratios, exponents, coverage."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import pysprings
from benchmarks import bench, error_estimates, kept_runs, limit_causes, mesh_changes, two_limits
from pysprings import Scene
from pysprings.core.errors import PyspringsError
from pysprings.full_model.accuracy.curves import LOAD, OTHER, PY, Sample
from pysprings.full_model.accuracy.quantities import initial_stiffness
from pysprings.full_model.accuracy.richardson import cell_size
from pysprings.full_model.accuracy.settings import read_mesh
from pysprings.full_model.run_record import Computed, RunRecord, Status
from pysprings.model.build import counts_of, geometry_of
from pysprings.model.fourier import section_counts_of
from pysprings.model.mesh import depths
from pysprings.springs.dataset import get_path
from tests.support import tiny
from tests.support.measured import with_error
from tests.support.synthetic import Path as Pull
from tests.support.synthetic import make_result


def run(unknowns: int, wall: float, unit: float) -> RunRecord:
    return RunRecord.from_dict({
        "mesh": {"unknowns": unknowns}, "wall_s": wall, "paths": {"pull": {"increments": 23}},
        "solver": {"factorisations": 15, "solves": 820, "unit_s": unit, "peak_before_unit_bytes": 0.94e9},
        "phases": {"assembly": {"wall_s": 0.25 * wall}, "solve": {"wall_s": 0.75 * wall}},
    })  # fmt: skip


def test_exponents_of_a_power_law_and_of_its_end() -> None:
    n = [1e3, 4e3, 2e4]
    assert bench.exponents(n, [7.0 * x**1.5 for x in n]) == pytest.approx((1.5, 1.5))
    fitted, last = bench.exponents([1.0, 10.0, 100.0], [1.0, 10.0, 1000.0])
    assert last == pytest.approx(2.0)
    assert fitted == pytest.approx(1.5)  # of 0, 1, 3 over 0, 1, 2 by hand


def test_a_run_in_units_and_shares() -> None:
    first, second = bench.text_of("paper", run(52_099, 37.0, 0.5)).splitlines()
    assert "52,099 unknowns" in first and "37.0 s" in first and "74.0 units" in first and "0.94 GB" in first
    assert second.strip() == "solve 75 %, assembly 25 %"


def test_cost_per_unknown_is_that_of_the_first_over_the_second() -> None:
    assert bench.cost_per_unknown(run(3_000, 12.0, 1.0), run(1_000, 2.0, 1.0)) == pytest.approx(2.0)


def test_meshes_of_the_benchmark_are_scenes() -> None:
    assert set(bench.GROWTH) >= {"drained", "coupled"}
    for mode, meshes in bench.GROWTH.items():
        assert len(meshes) > 1
        for mesh in meshes:
            found = bench.scene(mesh, 1e-3, mode)
            assert found.drainage.mode == mode
            assert found.paths[0].lateral_displacement == 1e-3


def test_results_are_kept_by_scene_and_version(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    attrs = {"status": "complete", "pysprings_version": pysprings.__version__}

    def compute(scene: Scene) -> Computed:
        asked.append(scene.title)
        found = make_result((Pull(steps=3),))
        found.attrs |= attrs
        return Computed(found, RunRecord(Status(attrs["status"]), failures=["stuck"]))

    monkeypatch.setattr(kept_runs, "compute", compute)
    for _ in range(2):
        error_estimates.result_of(tiny.paper(title="a"), tmp_path)
    assert asked == ["a"]
    monkeypatch.setattr("pysprings.core.version.__version__", "99")
    attrs |= {"pysprings_version": "99", "status": "partial"}
    for _ in range(2):
        with pytest.raises(PyspringsError, match="stuck"):
            error_estimates.result_of(tiny.paper(title="a"), tmp_path)
    assert asked == ["a", "a"]
    attrs |= {"status": "interrupted"}
    with pytest.raises(KeyboardInterrupt):
        error_estimates.result_of(tiny.paper(title="b"), tmp_path)
    assert len(list(tmp_path.iterdir())) == 1


def line(true: float, estimate: float) -> dict[str, Any]:
    return {
        "scene": "a", "mesh": "coarse", "safety": 3.0, "estimate_pct": {"load_max": estimate},
        "true_pct": {"load_max": true, "py_rms": math.nan},
    }  # fmt: skip


def test_coverage_counts_and_says_which_factor_nine_in_ten_need() -> None:
    lines = [line(true=float(k), estimate=8.5) for k in range(1, 11)]  # 1 to 8 of 10 are covered
    found = error_estimates.coverage([*lines, {"scene": "b", "mesh": "coarse", "why": "stopped"}])
    assert found["estimates"] == 10
    load = found["load_max"]
    assert (load["covered"], load["of"]) == (8, 10)
    assert load["safety_needed"] == pytest.approx(3.0 * 9.0 / 8.5)
    assert load["largest_needed"] == pytest.approx(3.0 * 10.0 / 8.5)
    assert load["median_excess"] == pytest.approx(0.5 * (8.5 / 5.0 + 8.5 / 6.0))
    assert "py_rms" not in found  # no estimate of it


def test_the_table_counts_scenes_drawn_afterwards_apart() -> None:
    lines = [line(true=3.0, estimate=2.0), line(true=1.0, estimate=2.0) | {"scene": "later-1"}]
    head, both, later = error_estimates.table(lines)
    assert head[:3] == ["quantity", "estimates", "true error covered"]
    assert both == ["load, coarse", "2", "1", "1.3", "2", "3"]
    assert later == ["load, coarse, drawn afterwards", "1", "1", "2", "1", "1"]


def test_a_truth_that_is_not_known_does_not_count() -> None:
    found = error_estimates.coverage([line(true=math.nan, estimate=1.0), line(true=1.0, estimate=1.0)])
    assert (found["load_max"]["covered"], found["load_max"]["of"]) == (1, 1)


def test_safety_that_is_needed() -> None:
    assert error_estimates.needed_safety(2.0, 4.0, 3.0) == 6.0
    assert error_estimates.needed_safety(0.0, 0.0, 3.0) == 0.0
    assert error_estimates.needed_safety(0.0, 1.0, 3.0) == math.inf


def test_held_out_scenes_are_scenes_and_are_pushed_as_far_as_asked() -> None:
    assert error_estimates.SCENES
    for name in error_estimates.SCENES:
        whole, half = error_estimates.scene_of(name, 1.0), error_estimates.scene_of(name, 0.5)
        for key in ("lateral_displacement", "rotation"):
            far = getattr(whole.paths[0], key)
            assert (far is None) == (getattr(half.paths[0], key) is None)
            if far is not None:
                assert getattr(half.paths[0], key) == pytest.approx(0.5 * far)


@pytest.mark.parametrize("case", two_limits.CASES)
def test_cases_of_two_limits_can_be_run_in_both_discretisations(case: str) -> None:
    scene = two_limits.scene_of(case)
    kinds = {
        kind: {read_mesh(family.mesh).scene(scene).replace(mesh=dict(c.mesh)).discretisation for c in family.changes}
        for kind, family in mesh_changes.families().items()
    }
    assert kinds == {"bricks": {"hex8"}, "series": {"fourier"}}
    own = two_limits.CASES[case]
    stops = [*scene.paths[0].report_at, scene.paths[0].lateral_displacement]
    assert [1e3 * u for u in stops] == pytest.approx(own.ends)
    assert scene.drainage.mode == ("drained" if own.rate is None else "coupled")


FAMILIES = mesh_changes.families((1.0, 1.5, 2.0), (1.0, 1.5, 2.0))
ENDS = (1.7677669529663687, 5.0)  # mm, states of the invented runs
_AROUND, _N5 = 0.02, 0.003  # errors of 12 cells around, and of N = 5


def made(scene: Scene) -> xr.DataTree:
    """A run with errors of second order in sections and cells around; the limit of bricks is 1 % above the other."""
    factor, n = scene.mesh.refinement, scene.mesh.harmonics
    if scene.discretisation == "fourier":
        return with_error(round(2000 * (n + 1) * factor**2), harmonics=n, beside=_N5 if n == 5 else 0.0)
    return with_error(round(90000 * factor**3), beside=0.01 + _AROUND * (12.0 / scene.mesh.azimuth) ** 2)


def test_cells_across_the_tip_are_refined_with_the_section() -> None:
    """Else p(y) at the tip, and the rotation, keep an error that no section takes away."""
    for kind, family in mesh_changes.families().items():
        counts = []
        for change in family.sections:
            with mesh_changes.counted(kind, family.mesh.removeprefix("fourier-").split("@")[0], change.counts):
                scene = read_mesh(family.mesh).scene(tiny.paper())
                mesh = {"preset": scene.mesh.preset, "discretisation": scene.discretisation, **change.mesh}
                scene = scene.replace(mesh=mesh)
                counts.append(section_counts_of(scene) if kind == "series" else counts_of(scene))
        scale = [each.tip * change.size for each, change in zip(counts, family.sections, strict=True)]
        assert scale == pytest.approx([scale[0]] * len(scale))
        assert [each.skirt / each.tip for each in counts] == pytest.approx(
            [counts[0].skirt / counts[0].tip] * len(scale)
        )
        assert len({getattr(each, "azimuth", 0) for each in counts}) == 1


def test_limits_that_are_apart_by_more_than_they_are_uncertain_by_are_marked(monkeypatch: pytest.MonkeyPatch) -> None:
    """The errors of 12 cells around (2 %) and of N = 5 are gone from the limits."""
    monkeypatch.setattr(kept_runs, "compute", lambda scene: Computed(made(scene), RunRecord(Status.COMPLETE)))
    rows = [dict(zip(two_limits.HEAD, line, strict=True)) for line in two_limits.rows("the paper's", FAMILIES, ENDS)]
    assert [(row["to"], row["measure"]) for row in rows] == [
        (to, two_limits.WORDS[name]) for to in ("1.76777 mm", "5 mm") for name in two_limits.MEASURED
    ]
    for row in rows:
        if row["measure"] == "load, %":
            assert float(row["limits differ up to there by"]) == pytest.approx(1.0, abs=0.02)
            assert float(row["at it by"]) == pytest.approx(1.0, abs=0.02)
            assert (row["aim"], row["met"]) == ("0.5", "no")
        assert "section 2, 12 around; series, section 2, N 5" in row["finest meshes"]


def test_a_limit_is_uncertain_by_the_distances_of_all_its_groups() -> None:
    """Sections 1, 1.5 and 2 are off by 10 %/f2, cells around by 2 % (12/n)2."""

    def sample(section: float = 1.0, around: int = 12) -> Sample:
        load = 1.0 + 0.1 / section**2 + _AROUND * (12.0 / around) ** 2
        return {LOAD: np.array([load]), OTHER: np.array([load]), PY: np.array([[load, np.nan]])}

    family = FAMILIES["bricks"]
    each = {c.words: sample(1.0 / c.size) for c in family.sections}
    each |= {c.words: sample(around=round(12.0 / c.size)) for c in family.around}
    limit = mesh_changes.together(family, each)
    assert limit.values[LOAD] == pytest.approx(1.0)
    assert two_limits.doubt_of("load_max", limit) == pytest.approx(100.0 * (0.1 / 4.0 + _AROUND / 4.0))
    del each[family.around[-1].words]  # not all are there: the group adds nothing
    assert mesh_changes.together(family, each).values[LOAD] == pytest.approx(1.0 + _AROUND)
    del each[family.sections[0].words]
    assert mesh_changes.together(family, each).values[LOAD] == pytest.approx(sample(2.0)[LOAD])


def test_cells_below_the_lid_are_a_group_of_their_own() -> None:
    """All sections have a first cell of one size; the group halves it, and its error is gone from the limit."""
    for kind, family in mesh_changes.families((0.5, 0.75, 1.0), (1.0, 2.0, 3.0), lid=True).items():
        first = {}
        for change in family.changes:
            with mesh_changes.counted(kind, family.mesh.removeprefix("fourier-").split("@")[0], change.counts):
                setting = read_mesh(family.mesh)
                mesh = {"preset": setting.mesh, "discretisation": setting.discretisation, **change.mesh}
                scene = tiny.paper().replace(mesh=mesh)
                levels = depths(geometry_of(scene), section_counts_of(scene) if kind == "series" else counts_of(scene))
                first[change.words] = (levels[1] - levels[0]) / 4.0
        own = first[family.sections[0].words]
        assert [first[c.words] for c in family.sections] == pytest.approx(3 * [own], rel=0.02)
        cells = [first[c.words] for c in family.lid]
        assert cells == pytest.approx([c.size for c in family.lid], rel=0.02)
        assert own in cells and cells[0] > 1.8 * own > 3.5 * cells[2]

        def sample(section: float, cell: float) -> Sample:
            load = 1.0 + 0.1 / section**2 + 30.0 * cell**2
            return {LOAD: np.array([load]), OTHER: np.array([load]), PY: np.array([[load]])}

        each = {c.words: sample(1.0 / c.size, own) for c in family.sections}
        each |= {c.words: sample(1.0 / family.sections[0].size, first[c.words]) for c in family.lid}
        assert mesh_changes.together(family, each).values[LOAD] == pytest.approx(1.0, abs=1e-3)


def test_harmonics_have_no_order() -> None:
    """The highest N stands for the limit, the one before it for its doubt."""
    family = FAMILIES["series"]
    value = {5: 1.04, 8: 1.02, 11: 1.01}

    def sample(load: float) -> Sample:
        return {LOAD: np.array([load]), OTHER: np.array([load]), PY: np.array([[load]])}

    each = {c.words: sample(value[5] + 0.1 * c.size**2 - 0.1) for c in family.sections}
    each |= {c.words: sample(value[int(c.mesh["harmonics"])]) for c in family.around}
    limit = mesh_changes.together(family, each)
    assert limit.values[LOAD] == pytest.approx(1.01 - 0.1)
    assert limit.beside[1][LOAD] - limit.values[LOAD] == pytest.approx(0.01)


def test_a_run_that_stops_short_is_left_out_beyond_its_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """The finest bricks stop at the first end: the second rests on the next section."""

    def computed(scene: Scene) -> Computed:
        tree = made(scene)
        if scene.discretisation == "hex8" and scene.mesh.refinement == 2.0:
            tree["paths/pull"] = xr.DataTree(two_limits.until(tree["paths/pull"].to_dataset(), ENDS[0]))
        return Computed(tree, RunRecord(Status.PARTIAL))

    monkeypatch.setattr(kept_runs, "compute", computed)
    lines = two_limits.rows("the paper's", FAMILIES, ENDS)
    assert [line[-1].split(", ")[1] for line in lines] == 3 * ["section 2"] + 3 * ["section 1.5"]
    trees = {c.words: with_error(9000) for family in FAMILIES.values() for c in family.changes}
    assert two_limits.limits(trees, FAMILIES, 6.0) is None


def test_a_load_with_water_is_the_drained_limit_times_the_ratio_of_both(monkeypatch: pytest.MonkeyPatch) -> None:
    """Drained runs have three sections and more cells around, those with water two: the product errs less."""
    seen = []

    def computed(scene: Scene) -> Computed:
        mesh = scene.mesh
        seen.append((scene.drainage.mode, scene.discretisation, mesh.refinement, mesh.azimuth or mesh.harmonics))
        tree = made(scene)
        path = tree["paths/pull"].to_dataset()
        tree["paths/pull"] = xr.DataTree(path.assign(F_pw=path["F_pw"] - 5e3))
        return Computed(tree, RunRecord(Status.COMPLETE))

    monkeypatch.setattr(kept_runs, "compute", computed)
    lines = two_limits.rows("the paper's, 0.5 mm/s", FAMILIES, ENDS[1:], with_water=2)
    rows = {line[2]: dict(zip(two_limits.HEAD, line, strict=True)) for line in lines}
    names = ("load_max", two_limits.BY_DRAINED, two_limits.OVER_DRAINED)
    load, product, ratio = (rows[two_limits.WORDS[name]] for name in names)
    assert float(product["at it by"]) == pytest.approx(1.0, abs=0.02)
    assert float(load["at it by"]) > 1.3
    assert float(ratio["at it by"]) == pytest.approx(0.0, abs=1e-9)
    assert float(product["bricks uncertain by"]) > 1.0
    assert "section 1.5, 12 around; series, section 1.5" in load["finest meshes"]
    wet = {each[1:] for each in seen if each[0] == "coupled"}
    assert wet == {("hex8", 1.0, 12), ("hex8", 1.5, 12), ("fourier", 1.0, 5), ("fourier", 1.5, 5)}


def test_water_is_compared_at_five_points_and_by_its_force() -> None:
    path = with_error(9000)["paths/pull"].to_dataset()
    depth = path["depth"]
    path["pore_pressure"] = path["pore_pressure"] + 1e3 * depth + 200.0 * path["azimuth"] + 10.0 * path["step"]
    path["F_pw"] = path["F_pw"] - 5e3
    sample, last = two_limits.water_sample(path), 10.0 * float(path["step"][-1])
    expected = [
        1e3 * np.clip(z, depth[0], depth[-1]) + 200.0 * azimuth + last for _, azimuth, z in two_limits.POINTS
    ]  # fmt: skip
    np.testing.assert_allclose(sample[two_limits.PRESSURES], expected)
    moved = {two_limits.WATER_FORCE: np.array([-4.5e3]), two_limits.PRESSURES: np.array(expected) + [0, 0, 250, 0, 0]}
    assert two_limits.difference(two_limits.WATER_FORCE, sample, moved) == pytest.approx(10.0)
    assert two_limits.difference(two_limits.PRESSURES, sample, moved) == pytest.approx(0.25)


def test_causes_change_one_thing_of_a_mesh_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Counts of a preset are changed while its run lasts; every change has its own run."""
    seen = []
    found = mesh_changes.families()
    plain = {section.words for family in found.values() for section in family.sections[:2]}
    plain_run, changed_run = with_error(9000), with_error(9000, beside=0.01)

    def computed(scene: Scene) -> Computed:
        series = scene.discretisation == "fourier"
        counts = section_counts_of(scene) if series else counts_of(scene)
        seen.append((counts, scene.solver))
        return Computed(plain_run if scene.title in plain else changed_run, RunRecord(Status.COMPLETE))

    monkeypatch.setattr(kept_runs, "compute", computed)
    lines = limit_causes.study(found, two_limits.scene_of("the paper's", (5.0,)), 5.0, None)
    words = {c.words for family in found.values() for c in (*family.changes, *limit_causes.changes_of(family))}
    assert len(set(map(repr, seen))) == len(seen) == len(words)
    bases = {limit_causes.changed_section(family).words for family in found.values()}
    assert {line[1] for line in lines} > words - bases
    load = 100.0 * 0.01 / (1.0 + 100.0 * cell_size(9000) ** 2)
    assert {line[0] for line in lines} - {"both"} <= plain
    assert [line[6] for line in lines if line[1] == "as it is"] == 2 * [
        f"{1e-6 * initial_stiffness(plain_run['stiffness_initial'].values, get_path(plain_run, 'pull')):.1f} MN/m"
    ]
    assert all(float(line[3]) == pytest.approx(load, abs=0.006) for line in lines if line[1] in words - plain)


def test_cells_across_the_tip_are_changed_on_any_section() -> None:
    base = limit_causes.changed_section(mesh_changes.families()["bricks"])
    for change in limit_causes.changes_of(mesh_changes.families()["bricks"]):
        if "across" in change.words:
            with mesh_changes.counted("bricks", "medium", change.counts):
                tip = counts_of(Scene(mesh={"preset": "medium", **change.mesh})).tip
            assert f", {tip} across" in change.words
            assert change.mesh == base.mesh
