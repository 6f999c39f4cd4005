# SPDX-License-Identifier: MIT
"""Reactions extrapolated from two meshes: what they keep, what they tend to, and where there are none."""

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from scipy.interpolate import PchipInterpolator

from pysprings import Scene, predict, predict_batch
from pysprings.core.errors import TargetMissed
from pysprings.core.storage import read_tree
from pysprings.core.text import number
from pysprings.full_model.accuracy import extrapolation, own_estimate, target, two_mesh
from pysprings.full_model.accuracy.extrapolation import Beside, extrapolated, share_of
from pysprings.full_model.compute import RunOptions, Sink, compute, run_into
from pysprings.full_model.run_record import Computed, RunRecord
from pysprings.results.folder import run_to_folder, run_to_target
from pysprings.results.report import validity
from pysprings.results.report.inputs import ReportData
from pysprings.results.summary import summary
from pysprings.scene.template import template_text
from pysprings.springs.checks import extract_springs
from pysprings.springs.path import paths_of
from pysprings.springs.sums import balance, slice_heights
from pysprings.springs.tip_zone import on_slices
from tests.support import tiny
from tests.support.commands import command

PULL = {"name": "pull", "kind": "pull", "lateral_displacement": 4e-3, "arm": 4.0}
BACK = {"name": "back", "kind": "pull", "lateral_displacement": 2e-3, "then": ["-1 mm"], "role": "held-back"}
LOAD = {"name": "load", "kind": "load", "lateral_force": 2e5, "arm": 4.0, "role": "held-back"}
CLIMB = LOAD | {"name": "climb", "arm_from": 0.0}
DOWN = {"name": "down", "kind": "vertical", "vertical_displacement": 2e-3}
SERIES: dict[str, Any] = {"mesh": {"discretisation": "fourier", "refinement": 0.5, "harmonics": 2}}


def scene(**changes: Any) -> Scene:
    return tiny.sand(**SERIES | {"paths": (PULL, BACK, LOAD, CLIMB, DOWN)} | changes)


@pytest.fixture(autouse=True, scope="module")
def _small_meshes() -> Iterator[None]:
    """Extrapolate from meshes that are far too coarse for it: what is done is the same, in a tenth of the time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(own_estimate, "FINE_ENOUGH", 0.0)
        yield


@cache
def found() -> Computed:
    return run_into(None, scene(), RunOptions(), Sink())


def test_a_mesh_below_those_of_the_presets_keeps_its_reactions(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(own_estimate, "FINE_ENOUGH", 1.0)
    ran = run_into(None, scene(paths=(PULL,)), RunOptions(), Sink())
    own, kept = (paths_of(ran.tree, of_mesh=each)["pull"] for each in (True, False))
    assert own["H"].tolist() == kept["H"].tolist() and own_estimate.TOO_COARSE in ran.record.remarks


def test_what_is_linear_in_the_reactions_is_kept() -> None:
    tree, springs = found().tree, extract_springs(found().tree)
    own, better = paths_of(tree, of_mesh=True), paths_of(tree)
    for name in ("pull", "back", "down"):
        a, b = own[name].dataset, better[name].dataset
        assert float(np.abs(b["H"] - a["H"]).max() + np.abs(b["V"] - a["V"]).max()) > 0.0
        assert max(map(abs, balance(springs[f"paths/{name}"].to_dataset(inherit=False)).values())) < 1e-12
        y = b["u"] - b["rotation"] * b["depth"]
        np.testing.assert_allclose(b["y"].transpose("step", "depth"), y, atol=1e-15)
    pull = better["pull"].dataset
    np.testing.assert_allclose(pull["M"][1:], 4.0 * pull["H"][1:], rtol=1e-5)  # height of the load
    np.testing.assert_array_equal(pull["u"], own["pull"]["u"])  # what drives it
    assert pull.attrs["end_H_N"] == float(pull["H"][-1])
    np.testing.assert_array_equal(pull["normal_effective_stress"], own["pull"].dataset["normal_effective_stress"])


def test_the_record_has_the_end_of_the_extrapolated_path() -> None:
    for name, path in paths_of(found().tree).items():
        assert found().record.paths[name].end["H"] == float(path["H"][-1])


def test_summary_and_report_have_the_extrapolated_loads() -> None:
    tree, record = found().tree, found().record
    better, of_mesh = (paths_of(tree, of_mesh=each)["pull"]["M"][-1].item() for each in (False, True))
    assert f"{1e-6 * better:.4g}" != f"{1e-6 * of_mesh:.4g}"
    assert f"M {1e-6 * better:.4g} MN m (path pull" in summary(tree, record)["loads"]
    ends = validity.end_table(ReportData(tree).paths)
    assert ends is not None and ends.rows[0][8] == number(1e-3 * better, 4)


def test_meshes_that_are_close_are_not_extrapolated() -> None:
    """The coarser mesh of 0.3 is 0.25: the difference would be multiplied by more than two."""
    close = run_into(None, scene(paths=(PULL,), mesh=SERIES["mesh"] | {"refinement": 0.3}), RunOptions(), Sink())
    xr.testing.assert_identical(
        paths_of(close.tree)["pull"].dataset, paths_of(close.tree, of_mesh=True)["pull"].dataset
    )
    assert "extrapolated" not in (close.record.error_estimate or {})
    assert "what extrapolation by order 2 leaves" in two_mesh.words(found().record.error_estimate or {})


def test_a_path_under_a_load_has_the_reactions_of_one_mesh_and_a_remark() -> None:
    record, tree = found().record, found().tree
    assert record.error_estimate is not None
    assert record.error_estimate["extrapolated"]["paths"] == ["pull", "back", "down"]
    assert record.error_estimate["extrapolated"]["halved"] == ["down"]
    assert [text for text in record.remarks if "reactions of down extrapolated from elements halved at the tip" in text]
    for name in ("load", "climb"):
        assert f"path {name} has the reactions of one mesh: a load drives it" in " ".join(record.remarks)
        xr.testing.assert_identical(paths_of(tree)[name].dataset, paths_of(tree, of_mesh=True)[name].dataset)
    assert "reactions extrapolated from meshes of" in extract_springs(tree).attrs["remarks"]


def test_a_ray_on_which_v_changes_is_extrapolated() -> None:
    """V changes while nothing moves, on both meshes; springs that remember are fitted to such rays, and to others."""
    ray = {"name": "loads", "kind": "translation", "lateral_displacement": 1e-3, "role": "held-back",
           "then": ("V 1.4 MN", "-1 mm", "V 1.2 MN", "1 mm")}  # fmt: skip
    tree = compute(scene(paths=(ray,))).tree
    coarse = tree.copy(deep=True)
    coarse["paths/loads"]["H"] = 1.02 * tree["paths/loads"]["H"]
    both = extrapolated(tree, Beside(coarse), 0.5)
    assert not both.not_alike and paths_of(both.tree)["loads"].load_changes
    own, better = (paths_of(each)["loads"]["H"] for each in (tree, both.tree))
    np.testing.assert_allclose(better, 0.99 * own, rtol=1e-9)


def test_what_a_solver_leaves_of_no_vertical_load_is_no_change_of_it() -> None:
    """V of 0 N within 1 N: a couple in clay had three times its moment where that counted as way."""
    tree = found().tree.copy(deep=True)
    pull, coarse, random = tree["paths/pull"], tree.copy(deep=True), np.random.default_rng(1)
    coarse["paths/pull"]["H"] = 1.02 * pull["H"]
    for each in (pull, coarse["paths/pull"]):
        each["V"] = pull["V"].copy(data=random.normal(size=pull.sizes["step"]))
    better = paths_of(extrapolated(tree, Beside(coarse), 0.5).tree)["pull"]["H"]
    np.testing.assert_allclose(better, 0.99 * pull["H"], rtol=1e-9)


@pytest.mark.parametrize("angle", [-1.0, 0.5 * np.pi])
def test_a_probe_is_extrapolated_at_equal_conjugate_displacement(angle: float) -> None:
    """Its motions and loads change, the displacement conjugate to its load and the direction of this one do not."""
    probe = {"name": "probe", "kind": "probe", "lateral_displacement": 2e-3, "load_angle": angle, "role": "held-back"}
    done = run_into(None, scene(paths=(probe,)), RunOptions(), Sink())
    own, better = (paths_of(done.tree, of_mesh=each)["probe"].dataset for each in (True, False))
    diameter = float(done.tree.attrs["outer_diameter_m"])
    conjugate = [np.cos(angle) * each["u"] + diameter * np.sin(angle) * each["rotation"] for each in (own, better)]
    np.testing.assert_allclose(*conjugate, atol=1e-15)
    assert float(np.abs(better["u"] - own["u"]).max()) > 1e-8
    np.testing.assert_allclose(better["M"] * np.cos(angle), diameter * np.sin(angle) * better["H"], atol=100.0)
    assert float(own["M"][-1]) / float(better["M"][-1]) > 1.0  # the finer of two meshes is still too stiff
    assert done.record.error_estimate is not None
    assert 0.1 < done.record.error_estimate["by_path"]["probe"]["load_pct"] < 20.0


def test_all_extrapolated_paths_begin_at_one_settlement() -> None:
    """That of the dead load, which both meshes have before a vertical path moves on."""
    caisson = tiny.scene().caisson.model_dump() | {"vertical_load": 1.2e6}
    fine, coarse, halved = (
        compute(scene(paths=(PULL, DOWN), caisson=caisson, mesh=SERIES["mesh"] | mesh)).tree
        for mesh in ({"refinement": 0.6}, {"refinement": 0.4}, {"refinement": 0.6, "halvings": 1})
    )
    near = extrapolated(fine, Beside(coarse, halved=halved), 0.5)
    assert near.halved == ["pull", "down"]
    for tree in (near.tree, extrapolated(fine, Beside(coarse), 0.5).tree):
        starts_at_one_rest(fine, tree)
    rest = [paths_of(each)["down"].dataset[["t", "V_tip", "V_lid", "w"]].isel(step=0) for each in (near.tree, tree)]
    xr.testing.assert_allclose(*rest, rtol=1e-9, atol=1e-6)


def starts_at_one_rest(fine: xr.DataTree, both: xr.DataTree) -> None:
    own, down, pull = paths_of(fine)["down"]["w"], paths_of(both)["down"]["w"], paths_of(both)["pull"]["w"]
    assert float(down[0]) == pytest.approx(float(pull[0]), rel=1e-9) and float(down[0]) != float(own[0])
    np.testing.assert_allclose(down - down[0], own - own[0], rtol=1e-6, atol=1e-12)


def test_three_meshes_of_one_family_show_that_two_are_better_than_the_finer_one() -> None:
    """The error of 0.6 and 1 of a section beside 2.2 of it is more than halved at the end of a pull."""
    path = {**PULL, "lateral_displacement": 8e-3}
    coarse, fine, truth = (
        compute(scene(paths=(path,), mesh=SERIES["mesh"] | {"refinement": size})).tree for size in (0.6, 1.0, 2.2)
    )
    share = share_of(1.0 / 0.6, 2.0)
    found = extrapolated(fine, Beside(coarse), share)
    assert not found.not_alike
    both = found.tree
    u, H = (paths_of(truth)["pull"][name] for name in ("u", "H"))
    errors = [
        np.abs(PchipInterpolator(each["u"], each["H"])(u) - H)[-1]
        for each in (paths_of(fine)["pull"], paths_of(both)["pull"])
    ]
    assert errors[1] < 0.5 * errors[0]


def test_smaller_elements_at_the_tip_are_what_a_push_into_sand_needs() -> None:
    """Error of V with them halved once, beside a finer section where they are halved twice.

    One harmonic is all that an axisymmetric path has.
    """
    path = DOWN | {"vertical_displacement": 4e-3}

    def tree(size: float, halvings: int, harmonics: int = 1) -> xr.DataTree:
        mesh = {"refinement": size, "halvings": halvings, "harmonics": harmonics}
        return compute(scene(paths=(path,), mesh=SERIES["mesh"] | mesh)).tree

    truth = paths_of(tree(1.5, 2))["down"]["V"]
    fine, coarse, halved = tree(1.0, 0, 3), tree(0.6, 0), tree(1.0, 1)
    share = share_of(1.0 / 0.6, 2.0)
    found = extrapolated(fine, Beside(coarse, halved=halved), share)
    assert found.halved == ["down"]
    other = extrapolated(fine, Beside(coarse), share).tree
    change = float(truth[-1] - truth[0])
    errors = [abs(float(paths_of(each)["down"]["V"][-1] - truth[-1]) / change) for each in (fine, other, found.tree)]
    assert errors[2] < 0.5 * min(errors[:2])


def test_harmonics_that_are_left_out_are_added_from_the_coarser_mesh() -> None:
    """Clay with a gap: N 3, and what N 5 changes on the coarser mesh, beside N 5 on both (1.7 % lower)."""
    path = {"name": "slide", "kind": "translation", "lateral_displacement": 0.3}

    def tree(size: float, n: int) -> xr.DataTree:
        mesh = {"preset": "medium", "discretisation": "fourier", "refinement": size, "harmonics": n}
        return compute(
            tiny.parsed(template_text("soft-clay")).replace(mesh=mesh, springs={"reach": None}, paths=(path,))
        ).tree

    fine, coarse, richest, richer = tree(0.6, 3), tree(0.36, 3), tree(0.6, 5), tree(0.36, 5)
    share = share_of(1.0 / 0.6, 1.7)
    truth, poorer, added = (
        extrapolated(*trees)
        for trees in (
            (richest, Beside(richer), share),
            (fine, Beside(coarse), share),
            (fine, Beside(coarse, richer), share),
        )
    )
    assert truth.without == poorer.without == added.without == {}
    ends = [float(paths_of(each.tree)["slide"]["H"][-1]) for each in (truth, poorer, added)]
    assert ends[1] / ends[0] - 1.0 > 0.015
    assert abs(ends[2] / ends[0] - 1.0) < 0.003
    springs = extract_springs(added.tree)
    assert max(map(abs, balance(springs["paths/slide"].to_dataset(inherit=False)).values())) < 1e-12


def test_a_coarser_path_that_stopped_early_gives_nothing() -> None:
    tree, shorter = found().tree, found().tree.copy(deep=True)
    for name in ("pull", "back"):
        shorter[f"paths/{name}"] = shorter[f"paths/{name}"].to_dataset(inherit=False).isel(step=slice(3))
    without = extrapolated(tree, Beside(shorter), 0.5).not_alike
    assert "it stopped on the coarser mesh at" in without["pull"] and "load" in without
    del shorter["paths"]["down"]
    assert "did not start" in extrapolated(tree, Beside(shorter), 0.5).not_alike["down"]


@pytest.mark.parametrize("steps", [0, 1])
def test_a_path_without_a_converged_step_gives_nothing(steps: int) -> None:
    """As of a probe whose vertical load is not carried: it has no state, or that at rest alone."""
    probe = {"name": "probe", "kind": "probe", "lateral_displacement": 2e-3, "load_angle": 0.0, "role": "held-back"}
    tree = compute(scene(paths=(probe,))).tree
    converged = tree["paths/probe"]["converged"]
    tree["paths/probe/converged"] = converged.where(converged["step"] < steps, 0)
    assert extrapolated(tree, Beside(tree), 0.5).not_alike == {"probe": "no step of it converged"}


@pytest.mark.parametrize(("sign", "added"), [(1.0, 2.0), (-1.0, 4.0 / 3.0)])
def test_a_push_is_of_first_and_a_pull_of_second_order_in_the_elements_at_the_tip(sign: float, added: float) -> None:
    """Halved elements change V by 2 % of its way from rest: 1 + 1/(2^o - 1) times that is added."""
    tree = found().tree.copy(deep=True)
    down = tree["paths/down"]
    down["w"] = down["w"][0] + sign * (down["w"] - down["w"][0])
    halved = tree.copy(deep=True)
    change = 0.02 * (down["V"] - down["V"][0])
    halved["paths/down"]["V"] = down["V"] + change
    better = paths_of(extrapolated(tree, Beside(tree, halved=halved), 0.5).tree)["down"]["V"]
    np.testing.assert_allclose(better - down["V"], added * change, rtol=1e-6, atol=1e-3)


def test_beyond_a_limit_load_the_difference_of_both_meshes_stays() -> None:
    """The coarser path ends half way, 2 % above the finer one, which goes on and rises."""
    tree = found().tree
    own = paths_of(tree, of_mesh=True)["down"].recorded
    half = own.sizes["step"] // 2
    other = own.isel(step=slice(half + 1)).copy(deep=True)
    for name in ("V", "t"):
        other[name] = other[name] + 0.02 * (other[name] - other[name].isel(step=0))
    other.attrs["status"] = "limit load"
    ended = tree.copy(deep=True)
    ended["paths/down"] = xr.DataTree(other)
    better = paths_of(extrapolated(tree, Beside(ended), 0.5).tree)["down"]
    np.testing.assert_allclose(better["w"], own["w"], rtol=1e-12)
    added = own["V"] - better["V"]
    np.testing.assert_allclose(added[: half + 1], 0.01 * (own["V"] - own["V"][0])[: half + 1], rtol=1e-9, atol=1e-3)
    np.testing.assert_allclose(added[half:], float(added[half]), rtol=1e-9)


def test_other_slices_keep_force_and_moment() -> None:
    path = paths_of(found().tree)["pull"].dataset
    fine = on_slices(path, np.linspace(0.0, float(path["depth_bounds"][-1, 1]), 12))
    fine["p_component"] = fine["p_component"] * (1.0 + 0.1 * fine["depth"])
    new = {name: path[name].transpose("depth", "side", ..., "step").values for name in ("p_component", "m", "t")}
    was = sums(new, path)
    extrapolation._resliced(new, path, fine)
    for before, after in zip(was, sums(new, fine), strict=True):
        np.testing.assert_allclose(after, before, rtol=1e-9, atol=1e-9 * np.abs(before).max())


def sums(found: dict[str, np.ndarray], path: xr.Dataset) -> list[np.ndarray]:
    """Return H, V and M of reactions per metre."""
    height, p = slice_heights(path), found["p_component"].sum(axis=2)
    turning = found["m"] - path["depth"].values[:, None, None] * p
    return [np.tensordot(height, each, axes=1).sum(axis=0) for each in (p, found["t"], turning)]


def sliced(edges: list[float], p: list[float]) -> xr.Dataset:
    """Return p (N/m) at one side and state in slices between these depths (m), without m."""
    bounds, values = np.stack([edges[:-1], edges[1:]], axis=1), np.array(p, dtype=float)[:, None, None]
    return xr.Dataset({
        "depth_bounds": (("depth", "edge"), bounds), "depth": ("depth", bounds.mean(axis=1)),
        "p_component": (("depth", "side", "component", "step"), values[..., None]),
        "m": (("depth", "side", "step"), 0.0 * values),
    })  # fmt: skip


@pytest.mark.parametrize(("edges", "p", "new", "finer", "wanted"), [
    # sand over clay: the jump at 3.2 m does not ring through the slices above it
    ([0.0, 1.5, 3.2, 4.7, 5.8, 7.5], [10, 10, 100, 100, 100], [0.0, 0.9, 2.0, 3.2, 4.2, 5.4, 7.5],
     [11, 11, 11, 120, 120, 120], [10, 10, 10, 100, 100, 100]),
    # the peak at the tip is not drawn into the slice above it
    ([0.0, 2.0, 4.0], [10, 30], [0.0, 1.0, 2.0, 3.0, 4.0], [10, 10, 10, 50], [10, 10, 10, 50]),
])  # fmt: skip
def test_what_both_meshes_have_stays_where_it_is(edges, p, new, finer, wanted) -> None:
    path = sliced(edges, p)
    found = {name: path[name].values for name in ("p_component", "m")}
    extrapolation._resliced(found, path, sliced(new, finer))
    np.testing.assert_allclose(found["p_component"][:, 0, 0, 0], wanted, rtol=1e-9)


def test_answers_have_the_estimate_of_the_paths_that_they_stand_on() -> None:
    springs, estimate = extract_springs(found().tree), found().record.error_estimate
    assert estimate is not None
    known = estimate["by_path"]["pull"]["load_pct"]
    answer = predict(springs, H=5e4, arm=4.0)
    np.testing.assert_allclose(answer["mesh_error_pct"], known)
    assert predict_batch(springs, H=[5e4], arm=4.0)["mesh_error_pct"].values[0] == pytest.approx(known)


def test_files_have_the_extrapolated_values_and_the_full_model_both(tmp_path: Path) -> None:
    run_to_folder(scene(paths=(PULL,)), tmp_path / "out")
    tree = read_tree(tmp_path / "out" / "full_model.nc")
    own, better = paths_of(tree, of_mesh=True)["pull"], paths_of(tree)["pull"]
    assert float(own["H"][-1]) != float(better["H"][-1])
    table = pd.read_csv(tmp_path / "out" / "load_displacement.csv")
    assert float(table["H_N"].iloc[-1]) == pytest.approx(float(better["H"][-1]), rel=1e-9)
    springs = paths_of(read_tree(tmp_path / "out" / "springs.nc"))["pull"]
    np.testing.assert_array_equal(springs["p"], better["p"])
    meshes = [each.attrs["meshes"] for each in (own.recorded, better.recorded, springs.recorded)]
    assert meshes == ["one; 'extrapolated' has what mesh_error_pct is of", "two", "two"]


def small() -> Scene:
    return scene(paths=({**PULL, "lateral_displacement": 1e-3},))


def runs_to(out: Path, word: str, **given: Any) -> dict[str, Any]:
    """Return what run.json has on a target; a target that is missed is raised."""
    run_to_target(target.start(small(), word).replace(mesh={"refinement": 0.5}), out, word, **given)
    record = RunRecord.read(out)
    assert record is not None and record.target_error is not None
    return record.target_error


def test_runs_to_a_target_refine_until_their_estimate_is_within_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first run of half the cells misses 2 % of p-y; the folder has the last one."""
    monkeypatch.setitem(target.START, "2%", "coarse")
    noted = runs_to(tmp_path / "out", "2%")
    sizes, errors = ([each[key] for each in noted["runs"]] for key in ("refinement", "py_rms"))
    assert noted["missed"] is None and len(sizes) > 1 and sizes[0] == 0.5
    assert sizes == sorted(set(sizes)) and errors[0] > 2.0 >= errors[-1]
    record = RunRecord.read(tmp_path / "out")
    assert record is not None and f"refinement = {sizes[-1]:g}" in record.scene_toml


def test_a_target_is_missed_where_the_budget_is_spent_or_runs_are_used_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(target.START, "0.5%", "coarse")
    with pytest.raises(TargetMissed, match=r"--target-error 0.5%: .* of the budget 0 s are left"):
        runs_to(tmp_path / "out", "0.5%", budget=1e-9)
    record = RunRecord.read(tmp_path / "out")
    assert record is not None and record.complete and record.target_error is not None
    assert len(record.target_error["runs"]) == 1 and "the budget" in record.target_error["missed"]
    monkeypatch.setattr(target, "ATTEMPTS", 2)
    (tmp_path / "small.toml").write_text(small().to_toml(), encoding="utf-8")
    more = ("run", tmp_path / "small.toml", "--out", tmp_path / "out", "--target-error", "0.5%", "--resume", "--quiet")
    done = command(*more)  # goes on where a budget was spent
    assert done.code == 3 and "nothing is left to do" not in done.err
    assert done.err.startswith("fatal: target missed: ") and "2 meshes were tried" in done.err
    record = RunRecord.read(tmp_path / "out")
    assert record is not None and len((record.target_error or {})["runs"]) == 2
    again = command(*more).err
    assert "nothing is left to do" in again and "fatal: target missed: " in again
