# SPDX-License-Identifier: MIT
"""Two runs beside each other: keys that differ, numbers of both, pictures of both."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from pysprings.core.variables import TORSION
from pysprings.full_model.run_record import RunRecord
from pysprings.results.folder import run_to_folder
from pysprings.results.layout import open_result
from pysprings.results.two_runs import Run, curve, differences, moved
from tests.support import space_paths, tiny
from tests.support.commands import command


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Runs of an elastic soil and of one that is a tenth stiffer: every load is a tenth larger."""
    place, made = tmp_path_factory.mktemp("two"), []
    for name, modulus in (("soft", 100e6), ("stiff", 110e6)):
        soil = {"yield_surface": "elastic", "young_modulus": modulus}
        contact = {"normal_stiffness": 100.0 * modulus, "shear_stiffness": 100.0 * modulus, "friction_coefficient": 5.0}
        pull = {**tiny.PULL, "lateral_displacement": 1e-5}
        back = {**pull, "name": "back", "then": ["0 mm"], "role": "held-back"}
        up = {"name": "up", "kind": "vertical", "vertical_displacement": -1e-5}
        paths = (pull, back, up) if name == "soft" else (pull, back, up, {**pull, "name": "alone"})
        made.append(run_to_folder(tiny.scene(soil=soil, interface=contact, paths=paths), place / name))
    return made[0], made[1]


def rows(*args: object) -> dict[str, dict[str, Any]]:
    done = command("diff", *args, "--json")
    assert done.code == 0, done.err
    return {f"{row['part']}: {row['quantity']}": row for row in json.loads(done.out)["rows"]}


def test_the_numbers_of_both(folders: tuple[Path, Path]) -> None:
    """A tenth in every stiffness and in the load at equal motion; the keys of the scenes that differ are named."""
    made = rows(*folders)
    young = made["scene: soil.young_modulus"]
    assert (young["first"], young["second"]) == ("100 MPa", "110 MPa")
    own = {name for name in made if name.startswith("scene: ") and not name.startswith("scene: path.alone")}
    assert own == {
        f"scene: {key}" for key in ("soil.young_modulus", "interface.normal_stiffness", "interface.shear_stiffness")
    }
    for name in ("H per u", "M per rotation", "V per w"):
        assert made[f"initial stiffness: {name}"]["change"] == pytest.approx(10.0, abs=0.01)
    load = made["path pull: H at u = 0.01 mm"]
    assert load["change"] == pytest.approx(10.0, abs=0.2)
    with xr.open_dataset(folders[0] / "full_model.nc", group="paths/pull") as path:
        assert load["first"] == pytest.approx(1e-3 * float(path["H"][-1]), rel=1e-4)
    largest = made["path pull: largest difference of H"]
    assert largest["second"] == pytest.approx(10.0, abs=0.2)
    assert [each["unit"] for each in (load, largest, young)] == ["kN", "% of the largest of the first", ""]


def test_what_goes_up_has_its_sign_and_what_is_not_compared_is_named(folders: tuple[Path, Path]) -> None:
    made = rows(*folders)
    assert made["path up: V at w = -0.01 mm from rest"]["change"] < 0.0
    assert [name for name in made if "not compared" in name] == ["path alone: not compared"]
    assert [made["path alone: not compared"][each] for each in ("first", "second")] == ["-", "pull"]


def test_paths_of_one_name_at_different_loads_heights_and_rates_are_marked(folders: tuple[Path, Path]) -> None:
    """`ray_0_load_1` is the first of the vertical loads, `pull_2` twice the diameter high, in each run its own."""
    trees = [open_result(folders[0]) for _ in range(2)]
    for tree, load, height, time in zip(trees, (0.0, 1e6), (2.0, 3.0), (10.0, 2.0), strict=True):
        path = tree["paths/pull"]
        path["V"].values += load
        path.attrs["arm_m"] = height
        path["time"] = path["u"].copy(data=np.linspace(0.0, time, path.sizes["step"]))
    load = 1e-3 * float(trees[0]["paths/pull"]["V"][0])
    found = differences(*(Run(name, tree, RunRecord()) for name, tree in zip("ab", trees, strict=True)))
    changes = {row.quantity: row.change for row in found if row.part == "path pull"}
    assert changes["V at its start"] == pytest.approx(100e3 / load)
    assert changes["height of its load"] == pytest.approx(50.0) and changes["rate"] == pytest.approx(400.0)


def test_paths_off_a_plane_are_compared_on_the_way_that_both_have_come(folders: tuple[Path, Path]) -> None:
    """A circle of which the second run has a half, with loads a tenth larger; it twists nothing, so T has no row."""
    trees = [open_result(folders[0]) for _ in range(2)]
    round_ = space_paths.path(space_paths.circle(1e-3), "circle", "memory")
    half = round_.isel(step=slice(48))
    for tree, path, factor in zip(trees, (round_, half), (1.0, 1.1), strict=True):
        loads = {name: factor * path[name] for name in ("H_x", "H_y", "M_x", "M_y", "T")}
        tree["space/round"], tree.attrs[TORSION] = xr.DataTree(path.assign(loads)), factor * 3e6
    found = differences(*(Run(name, tree, RunRecord()) for name, tree in zip("ab", trees, strict=True)))
    own = {row.quantity: row for row in found if row.part == "path round"}
    assert own["largest H"].change == pytest.approx(10.0, abs=1e-6)
    assert own["largest H"].first == pytest.approx(1e-3 * float(np.hypot(half["H_x"], half["H_y"]).max()), rel=1e-6)
    assert own["largest difference of H"].second == pytest.approx(10.0, abs=1e-6) and "largest T" not in own
    assert next(row for row in found if row.quantity == "T per rotation").change == pytest.approx(10.0)


def test_layers_of_one_name_are_compared_each_with_its_own(folders: tuple[Path, Path]) -> None:
    """As `pysprings ground` names them by their soil: sand, clay, sand."""
    tree, layers = open_result(folders[0]), (("sand", 0), ("clay", 3), ("sand", 6))
    runs = []
    for weight in (9, 10):
        text = "".join(
            f'[[soil.layer]]\nname = "{name}"\ntop = {top}\nweight = {weight + top}\n' for name, top in layers
        )
        text = text.replace(f"weight = {weight + 3}", "weight = 8").replace(f"weight = {weight + 6}", "weight = 7")
        runs.append(Run(str(weight), tree, RunRecord(scene_toml=text)))
    (row,) = [row for row in differences(*runs) if row.part == "scene"]
    assert (row.quantity, row.first, row.second) == ("soil.layer.sand (1).weight", "9", "10")


def test_a_difference_on_the_way_back_counts(folders: tuple[Path, Path]) -> None:
    """Of two runs that are alike but for the last load of a path that turns back: that load is the difference."""
    first, changed = (open_result(folders[0]) for _ in range(2))
    H = changed["paths/back"]["H"].values
    largest = np.abs(H).max()
    assert np.argmax(np.abs(H)) < H.size - 1
    H[-1] += 0.25 * largest
    found = differences(*(Run(name, tree, RunRecord()) for name, tree in (("a", first), ("b", changed))))
    row = next(each for each in found if each.part == "path back" and each.quantity.startswith("largest difference"))
    assert row.second == pytest.approx(25.0, abs=0.5)


def test_what_the_iteration_leaves_of_zero_is_no_load(folders: tuple[Path, Path]) -> None:
    """Of a moment alone, or of one that is: H is 0 and has no change; the difference is that of M."""
    trees = [open_result(folders[0]) for _ in range(2)]
    for share, tree in zip((1e-5, -4e-5), trees, strict=True):
        path = tree["paths/pull"]
        path["H"].values[:] = share * path["M"].values / float(tree.attrs["skirt_length_m"])
        path["M"].values[:] *= 1.0 + 1e3 * share
    found = differences(*(Run(name, tree, RunRecord()) for name, tree in zip("ab", trees, strict=True)))
    own = {each.quantity: each for each in found if each.part == "path pull"}
    row = own["H at u = 0.01 mm"]
    assert (row.first, row.second, row.change) == (0.0, 0.0, None)
    assert own["largest difference of M"].second == pytest.approx(100.0 * 0.05 / 1.01, abs=0.01)
    assert len([each for each in own if each.startswith("largest difference")]) == 1


def test_meshes_their_errors_and_cavitation_are_named(folders: tuple[Path, Path]) -> None:
    """Loads of one mesh stand beside those of two; water that would cavitate ends a path in the words of springs."""
    one, two = (open_result(folders[0]) for _ in range(2))
    two["paths/pull/extrapolated"] = xr.DataTree(one["paths/pull"].to_dataset(inherit=False)[["H"]])
    two["paths/pull"].attrs["mesh_error_pct"] = 2.0
    margin = np.where(np.arange(one["paths/up"].sizes["step"]) < 3, 1.0, -1.0)
    one["paths/up"].dataset = one["paths/up"].to_dataset(inherit=False).assign(cavitation_margin=("step", margin))
    found = differences(Run("a", one, RunRecord()), Run("b", two, RunRecord()))
    rows = {f"{each.part}: {each.quantity}": (each.first, each.second) for each in found}
    assert rows["path pull: error of the mesh on the load"] == ("not known (one mesh)", "2 % (two meshes)")
    assert "the water would cavitate beyond" in rows["path up: end"][0] and "reached" in rows["path up: end"][1]
    assert "path pull: end" not in rows


def test_the_motion_of_a_path_that_goes_to_both_sides_is_that_to_the_farther_one() -> None:
    """Forth to 2, back to -5: what stands at -1 was reached on the way back."""
    motion, load = np.array([0.0, 1.0, 2.0, 0.0, -1.0, -5.0]), np.array([0.0, 10.0, 15.0, -8.0, -12.0, -20.0])
    np.testing.assert_array_equal(moved(motion), [0.0, 0.0, 0.0, 0.0, 1.0, 5.0])
    np.testing.assert_array_equal(moved(motion, 1.0), [0.0, 1.0, 2.0, 2.0, 2.0, 2.0])
    path = xr.Dataset({"u": ("step", motion), "H": ("step", load)})
    assert np.interp(1.0, *curve(path, "u", "H")) == -12.0


def test_a_run_beside_itself_and_what_is_no_run(folders: tuple[Path, Path], tmp_path: Path) -> None:
    made = rows(folders[0], folders[0])
    assert not [name for name in made if name.startswith("scene: ")]
    assert {row["change"] for row in made.values() if row["change"] is not None} == {0.0}
    done = command("diff", folders[0], tmp_path)
    assert (done.code, done.out) == (2, "")
    assert "is not the folder of a run" in done.err


def test_the_picture_has_the_curves_of_both(folders: tuple[Path, Path], tmp_path: Path) -> None:
    from pysprings.core.storage import read_tree
    from pysprings.results.plots.comparison import overlay
    from pysprings.springs.path import paths_of

    done = command("diff", *folders, "--out", tmp_path / "both")
    assert done.out.splitlines()[-1] == str(tmp_path / "both" / "up.png")
    assert (tmp_path / "both" / "pull.png").stat().st_size > 10_000
    runs = [Run(each.name, read_tree(each / "full_model.nc"), RunRecord()) for each in folders]
    load, rotation, springs = overlay({each.name: paths_of(each.result)["pull"].dataset for each in runs}, "pull").axes
    for axes, name, scale in ((load, "H", 1e-3), (rotation, "rotation", 180.0 / np.pi)):
        curves = [line for line in axes.get_lines() if len(line.get_xdata()) > 2]
        for line, run in zip(curves, runs, strict=True):
            np.testing.assert_allclose(line.get_ydata(), scale * run.result[f"paths/pull/{name}"].values)
    assert len([line for line in springs.get_lines() if len(line.get_xdata()) > 2]) == 6
