# SPDX-License-Identifier: MIT
"""The ten lines of a run: the tilt at the design load of the scene."""

import dataclasses
import math
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import pysprings
from pysprings.core.storage import read_tree
from pysprings.full_model.run_record import LimitLoad, RunRecord, significant
from pysprings.results.exporters.header import range_of_path
from pysprings.results.folder import run_to_folder
from pysprings.results.summary import _on_held_back, _range, _stiffness, _vertical, summary
from pysprings.springs.path import SpringPath
from tests.support import tiny, winkler
from tests.support.fans import fan_springs, potential
from tests.support.rates import with_vertical
from tests.support.vertical import fan_with_vertical


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run_to_folder(tiny.scene(), tmp_path_factory.mktemp("summary") / "out")


def tilt(folder: Path, **design: object) -> str:
    """Return the line on the tilt of the run for a design load (SI)."""
    record = RunRecord.read(folder)
    assert record is not None
    record.scene_toml = tiny.scene(design=design).to_toml()
    springs = pysprings.open_springs(folder / "springs.nc")
    return summary(read_tree(folder / "full_model.nc"), record, pysprings.compare(springs), springs)["tilt"]


def test_the_tilt_is_that_of_predict_and_the_tolerance_decides(folder: Path) -> None:
    answer = pysprings.predict(pysprings.open_springs(folder / "springs.nc"), H=2e5)
    degrees = math.degrees(abs(float(answer["rotation"])))
    line = tilt(folder, lateral_force=2e5)
    assert line.startswith(f"{degrees:.3g} deg at the design load, H 0.2 MN at 0 m: within the tolerated 0.25 deg")
    assert f"{100 * float(answer['utilisation']):.3g} % of H {1e-6 * answer.attrs['capacity_H_N']:.4g} MN" in line
    line = tilt(folder, lateral_force=2e5, tilt=math.radians(0.5 * degrees))
    assert f"beyond the tolerated {0.5 * degrees:.3g} deg" in line


def test_what_rounding_leaves_of_a_rotation_is_none(folder: Path) -> None:
    """As on a translation, whose rotation is imposed."""
    tree, record = read_tree(folder / "full_model.nc"), RunRecord.read(folder)
    assert record is not None and "rotation up to 0 deg" not in summary(tree, record)["range"]
    for node in tree["paths/pull"].subtree:
        if "rotation" in node.data_vars:
            node.dataset = node.to_dataset(inherit=False).assign(rotation=1e-16 * node["rotation"])
    assert ", rotation up to 0 deg, " in summary(tree, record)["range"]


def test_loads_under_another_vertical_load_are_stated_with_it(folder: Path) -> None:
    """Where w is held V changes along a path (2 to 3.9 MN on a pull of 40 mm in sand)."""
    tree, record = read_tree(folder / "full_model.nc"), RunRecord.read(folder)
    assert record is not None and ", V " not in summary(tree, record)["loads"] + summary(tree, record)["tilt"]
    paths = [node for node in tree["paths/pull"].subtree if "V" in node.data_vars]
    for node in paths:
        node["V"][1:] = 2.0 * float(node["V"][0])
    words = f"(path pull, V {2e-6 * float(paths[0]['V'][0]):.4g} MN)"
    assert words in summary(tree, record)["tilt"] and f"{words[10:-1]})" in summary(tree, record)["loads"]
    for node in paths:
        node.attrs["then_pairs"] = 1  # of H and M: no load at one height
    assert "tilt" not in summary(tree, record)


def test_the_error_of_u_at_equal_load_stands_beside_those_at_equal_displacement(folder: Path) -> None:
    """Near collapse it is far larger; it stands beside the use of the springs, and does not make them preliminary."""
    record, springs = RunRecord.read(folder), pysprings.open_springs(folder / "springs.nc")
    assert record is not None
    own = pysprings.compare(springs)
    found = {"H_error_max_pct": 1.0, "rotation_error_max_pct": -2.0, "u_error_max_pct": -69.25, "u_error_half_pct": 0.5}
    held = own[own["springs"] == "full"].assign(role="held-back", springs="fan", **found)
    lines = summary(read_tree(folder / "full_model.nc"), record, held, springs)
    assert lines["springs"].endswith(
        "displacement: H 1 %, rotation 2 %; of u at equal load: 0.5 % up to half of the largest load, 69 % beyond"
    )
    within = "predictions within the range, u under a load off by 0.5 % up to half of the largest load, 69 % beyond"
    assert lines["use"].startswith(within)
    assert "their error is above" not in lines["use"]
    by_path = {"ray": {"load_pct": 6.0}, "down": {"load_pct": 9.0}}  # that of V is no load of lateral paths
    record.error_estimate = {"estimate_pct": {"load_max": 6.0, "vertical_max": 9.0}, "by_path": by_path}
    lines = summary(read_tree(folder / "full_model.nc"), record, held, springs)
    assert "the mesh error of load is 6 % on path ray: run it" in lines["use"] and "V 9 %" in lines["mesh error"]
    lines = summary(read_tree(folder / "full_model.nc"), record, held.assign(u_error_max_pct=np.nan), springs)
    assert lines["springs"].endswith("rotation 2 %") and "off" not in lines["use"]
    arms = pd.concat([held.assign(arm_m=arm, H_error_max_pct=123.4) for arm in (7.8, -4.0, 39.0)])
    checked = summary(read_tree(folder / "full_model.nc"), record, arms, springs)["springs"]
    assert "on the paths held back (loads at -4 to 39 m), largest" in checked and "H 123 %, rotation" in checked


def test_beyond_the_springs_there_is_no_tilt(folder: Path) -> None:
    line = tilt(folder, lateral_force=1e8)
    assert line.startswith("not known at the design load, H 100 MN at 0 m: beyond the springs, which carry H ")
    assert " deg" not in line


def test_springs_at_several_rates_have_no_tilt_for_that_reason_and_each_path_names_its_own(folder: Path) -> None:
    """The load is small: that the springs do not carry it would be false."""
    record, springs = RunRecord.read(folder), winkler.at_two_rates((1e-5, 1e-3))
    assert record is not None
    record.scene_toml = tiny.scene(design={"lateral_force": 1e5}).to_toml()
    line = summary(read_tree(folder / "full_model.nc"), record, None, springs.tree)["tilt"]
    assert line.startswith("not known at the design load, H 0.1 MN at 0 m: the calibration paths have several rates")
    for name, rate in (("ray_1_0", "0.01"), ("ray_1_1", "1")):
        assert f"kN, {rate} mm/s of rho; out of balance" in range_of_path(springs.drainage, springs.paths[name])
    path = springs.paths["ray_1_0"]
    noise = SpringPath("a", path.dataset.assign(rotation=0.0 * path.dataset["rotation"] + 4e-18), path.length)
    assert "|rotation| to 0 mrad" in range_of_path(springs.drainage, noise)


def test_what_is_carried_beyond_cavitation_is_no_load_of_the_summary(folder: Path) -> None:
    record, result = RunRecord.read(folder), read_tree(folder / "full_model.nc")
    assert record is not None
    path = result["paths/pull"].to_dataset(inherit=False)
    margin = np.where(np.arange(path.sizes["step"]) < 3, 1e5, -1e3)
    result["paths/pull"] = path.assign(cavitation_margin=("step", margin, {"units": "Pa"}))
    record.paths["pull"] = dataclasses.replace(
        record.paths["pull"], limit_load=LimitLoad(1e6, 1e6, 0.0, 0.1, 0.0, 0.0, "x")
    )
    lines, last = summary(result, record), path.isel(step=2)
    assert lines["loads"].startswith(f"largest reached, no limit load: H {1e-6 * float(last['H']):.4g} MN")
    assert lines["range"].startswith(f"u up to {1e3 * float(last['u']):.3g} mm")
    assert "; monotonic loading; " in lines["range"]
    result["paths/back"] = path.assign_attrs(role="memory")
    assert "; monotonic loading, but for springs with memory; " in summary(result, record)["range"]


def test_a_moment_that_is_rounding_is_no_load(folder: Path) -> None:
    """The pull at mudline has no moment about the lid centre."""
    record = RunRecord.read(folder)
    assert record is not None and record.summary is not None
    assert record.summary["loads"].startswith("largest reached, no limit load: H ")
    assert ", M " not in record.summary["loads"]


def test_a_rotation_that_is_none_to_rounding_is_0(tmp_path: Path) -> None:
    shift = {"name": "shift", "kind": "translation", "lateral_displacement": 5e-4}
    record = RunRecord.read(run_to_folder(tiny.scene(paths=[shift]), tmp_path / "out", estimate_error=False))
    assert record is not None and record.summary is not None
    assert record.summary["loads"].count("u 0.5 mm, 0 deg)") == 2


def test_marks_stand_beside_the_tilt(folder: Path) -> None:
    """Springs of one pull, under a load at another height."""
    assert "off the path 'pull'" in tilt(folder, lateral_force=5e4, arm=6.0)


def test_without_a_design_load_a_path_gives_the_tilt(folder: Path) -> None:
    turned = read_tree(folder / "full_model.nc")["paths/pull"]["rotation"].values
    end = math.degrees(float(abs(turned[-1])))
    assert tilt(folder).startswith(f"{end:.3g} deg at H ")
    assert tilt(folder).endswith("0.25 deg is not reached; no [design] load")
    assert tilt(folder, tilt=math.radians(0.5 * end)).startswith(f"{0.5 * end:.3g} deg at H ")


def test_a_height_without_a_load_is_refused() -> None:
    with pytest.raises(ValueError, match=r"design\.arm: is the height of a load"):
        tiny.scene(design={"arm": 5.0})
    with pytest.raises(ValueError, match=r"design\.lateral_force: a load of zero"):
        tiny.scene(design={"lateral_force": 0.0})


def test_a_design_load_changes_no_number_of_other_scenes() -> None:
    """The text and the number of a scene without [design] stay those of versions before it."""
    assert "[design]" not in tiny.scene().to_toml()
    assert tiny.scene(design={"lateral_force": 1e6}).sha256 != tiny.scene().sha256
    assert tiny.scene(design={"lateral_force": 1e6, "arm": 2.0}).to_toml().count("[design]") == 1


def test_vertical_loads_stand_in_the_summary() -> None:
    """V at rest is a number, and each direction has the largest load known; without vertical paths there is none."""
    text = _vertical(SimpleNamespace(springs=fan_with_vertical()))
    assert text.startswith("V 2 MN at rest, ") and " % used; largest known: push " in text and ", pull -" in text
    share, push = (float(found) for found in re.findall(r", ([\d.]+) % used; largest known: push ([\d.]+) MN", text)[0])
    assert share == pytest.approx(200.0 / push, rel=1e-2)
    assert _vertical(SimpleNamespace(springs=fan_springs(potential))) == ""
    pushed = fan_with_vertical()  # its path upwards ends under pressure: what is below has no answer
    up = next(path for path in pushed["paths"].children.values() if float(path["V"][-1]) < 0.0)
    lifted = up.to_dataset(inherit=False)
    margin = np.where(np.arange(lifted.sizes["step"]) < 12, 1e5, -1e3)
    up.dataset = lifted.assign(cavitation_margin=("step", margin, {"units": "Pa"}))
    words = "MN (end of the range; it stopped: the water would cavitate beyond, at w"
    assert words in _vertical(SimpleNamespace(springs=pushed)).split(", pull ")[1]
    up.dataset = lifted.isel(step=slice(int((lifted["V"].values > 0.0).sum())))
    assert f"MN (end of the range), nothing below {1e-6 * float(up['V'][-1]):.4g} MN" in _vertical(
        SimpleNamespace(springs=pushed)
    )
    sudden = "at the lid centre (of a load so sudden that no water moves)"  # not the stiffness of a slow one
    wet, dry = (_stiffness(SimpleNamespace(result=tree)) for tree in (with_vertical(1e-5), fan_with_vertical()))
    assert wet.endswith(sudden) and dry.endswith("at the lid centre")
    for rates in ((0.01,), (0.01, 1.0)):  # mm/s; no rate is asked for
        springs = with_vertical(*(1e-3 * rate for rate in rates))
        first, known = _vertical(SimpleNamespace(springs=springs)).split("largest ")
        assert first.startswith("V 2 MN at rest, ")
        pushes = re.findall(r"(?:known|;) at ([\d.]+) mm/s of w: push ([\d.]+) MN", known)
        assert [float(rate) for rate, _ in pushes] == list(rates)
        slow, fast = (float(pushes[k][1]) - 2.0 for k in (0, -1))
        assert fast == pytest.approx(1.5 * slow if len(rates) > 1 else slow, rel=1e-3)


def test_the_range_is_that_of_the_path_that_springs_are_made_from(folder: Path) -> None:
    """Of two pulls without a fan the first that calibrates: not one held back before it, nor one that goes farther."""
    tree = read_tree(folder / "full_model.nc")
    pull = tree["paths/pull"].to_dataset(inherit=False)
    groups = {"/": tree.to_dataset(inherit=False), "/paths/before": pull.assign_attrs(role="held-back")}
    groups |= {"/paths/pull": pull, "/paths/farther": pull.assign(u=3.0 * pull["u"])}
    run = SimpleNamespace(result=xr.DataTree.from_dict(groups), comparison=None, springs=None, scene=tiny.scene())
    end = 1e3 * float(pull["u"].max())
    assert _range(run).startswith(f"u up to {end:.3g} mm, ") and "the load height of path pull only" in _range(run)


def test_springs_of_no_path_have_neither_range_nor_use(folder: Path) -> None:
    record, tree = RunRecord.read(folder), read_tree(folder / "full_model.nc")
    tree["paths/pull"].attrs["role"] = "held-back"
    assert record is not None
    found = summary(tree, record, pd.DataFrame({"springs": []}))
    assert found["range"] == found["use"] == "no lateral path was calibrated"


def test_what_springs_are_worth_is_not_judged_on_a_path_that_turns_back(folder: Path) -> None:
    """A fan goes back on its curve; `pysprings compare` has its error there."""
    tree = read_tree(folder / "full_model.nc")
    table = pd.DataFrame([["pull", "held-back", "full", "pull"]], columns=["path", "role", "springs", "kind"])
    assert len(_on_held_back(SimpleNamespace(comparison=table, result=tree))) == 1
    tree["paths/pull"].attrs["then_parts"] = 1  # a rest
    assert _on_held_back(SimpleNamespace(comparison=table, result=tree)).empty


def test_a_path_that_turns_back_gives_the_load_at_which_it_first_has_the_tilt(folder: Path) -> None:
    """By its own states, the last of which has come back."""
    tree = read_tree(folder / "full_model.nc")
    path = tree["paths/pull"].to_dataset(inherit=False)
    H, turn = (path[name].values for name in ("H", "rotation"))
    there = [*range(path.sizes["step"]), *range(path.sizes["step"] - 2, 0, -1)]
    tree["paths/pull"].dataset = path.isel(step=there).assign_coords(step=range(len(there)))
    springs = pysprings.open_springs(folder / "springs.nc")
    for share, words in ((0.6, "deg at H {:.4g} MN under a load"), (1.5, "deg at H {:.4g} MN under .* is not reached")):
        record = RunRecord.read(folder)
        assert record is not None
        tolerated = share * float(abs(turn[-1]))
        record.scene_toml = tiny.scene(design={"tilt": tolerated}).to_toml()
        line = summary(tree, record, pysprings.compare(springs), springs)["tilt"]
        load = np.interp(min(share, 1.0), np.abs(turn / turn[-1]), np.abs(H))
        assert re.search(words.format(1e-6 * load), line), line


def test_the_range_of_coupled_springs_names_their_rate(folder: Path, tmp_path: Path) -> None:
    for of, words in ((run_to_folder(tiny.wet(kind="translation"), tmp_path), "; at 0.1 mm/s (of rho)"), (folder, "")):
        record = RunRecord.read(of)
        assert record is not None and record.summary is not None
        assert record.summary["range"].endswith(f"monotonic loading; in proportion{words}")


def test_values_are_judged_beside_the_largest_times_their_length() -> None:
    """4 urad are 40 um on 10 m, which count beside 1 m; on 1 m they do not."""
    assert significant((1.0,), (4e-6,), 10.0) == ([1.0], [4e-6])
    assert significant((1.0, 4e-6), (4e-6,), 1.0) == ([1.0, 0.0], [0.0])
