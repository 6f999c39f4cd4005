# SPDX-License-Identifier: MIT
"""Vertical springs and several vertical loads: on the path, by closed form, through the full model, in files."""

import warnings
from functools import cache

import numpy as np
import pytest
import xarray as xr

from pysprings import open_table
from pysprings.core import variables
from pysprings.core.errors import BeyondSprings, UserInputError
from pysprings.core.words import RANGE_END
from pysprings.full_model.compute import run
from pysprings.macro.batch import predict_batch
from pysprings.macro.comparison import compare, curves
from pysprings.macro.comparison_text import to_text
from pysprings.macro.predict import (
    MacroModel,
    MacroWarning,
    PredictionNotConverged,
    impose,
    model_of,
    predict,
    way_to_load,
    way_to_motion,
)
from pysprings.macro.stiffness import stiffness, stiffness_six
from pysprings.macro.vertical import build_vertical, covered, share_left
from pysprings.macro.vertical_answer import largest_vertical
from pysprings.springs.checks import extract_springs, open_springs, save_springs
from pysprings.springs.path import paths_of
from pysprings.springs.path_ends import NUMBERS
from pysprings.springs.springs import Springs
from tests.support import tiny, written
from tests.support.commands import command
from tests.support.vertical import REST, K, down_curve, fan_with_vertical, pressed, vertical_springs


@pytest.mark.parametrize("name", ["down", "up"])
def test_pure_vertical_load_is_met_on_the_path(name):
    """Under the V of every recorded state w is the recorded one, exactly, and no warning is given (an error here)."""
    tree = vertical_springs()
    path = paths_of(tree)[name].dataset
    for step in (1, 7, 24):
        answer = way_to_load(tree, V=float(path["V"][step]))
        assert float(answer["w"][-1]) == pytest.approx(float(path["w"][step]), rel=1e-12)
        assert float(answer["u"][-1]) == float(answer["H"][-1]) == 0.0
        assert answer["off_load"].values.max() == answer["extrapolated"].values.max() == 0
    assert list(variables.problems(answer, "prediction")) == []


def test_the_error_of_the_mesh_is_that_of_the_path_that_carries_the_load():
    """Of V alone that of the vertical path in its direction, of a lateral load under any V that of the rays beside.

    Of a path it is a share of the change of V, which has no dead load in it; of V it is a share of the largest one.
    """
    tree = vertical_springs()
    for name, error in (("slide", 1.0), ("turn", 2.0), ("down", 4.0), ("up", 8.0)):
        tree[f"paths/{name}"].attrs["mesh_error_pct"] = error
    H, V = np.array([0.0, 0.0, 1e4, 1e4, 0.0]), np.append(REST + np.array([1e5, -1e5, 1e5, 0.0]), -0.5e6)
    down, up = (down_curve(np.array(w)) for w in (1e-2, -1e-2))
    expected = [4.0 * down / (down + REST), 8.0 * -up / V[1], 2.0, 2.0, 8.0 * up / (up + REST)]
    np.testing.assert_allclose(predict_batch(tree, H=H, V=V)["mesh_error_pct"], expected)
    assert way_to_load(tree, V=float(V[0]))["mesh_error_pct"].values[-1] == pytest.approx(expected[0])


def test_w_under_less_than_the_load_at_rest_is_named_as_that_of_unloading():
    """Where the dead load has settled the caisson, that is; w counts from that state where the load is balanced."""
    tree = vertical_springs()
    for settled, V, named in ((0.0, 0.5, False), (8e-3, 0.5, True), (0.0, 1.5, False), (0.0, 1.0, False)):
        for path in tree["paths"].children.values():
            path.dataset = path.to_dataset().assign(w=path["w"] + settled)
        assert ("less than the V at rest, 2 MN" in str(way_to_load(tree, V=V * REST).attrs["remarks"])) == named


def test_between_the_recorded_states_it_is_the_curve():
    """The closed form between 25 states: within 0.1 % of w, both ways; V ramps from the state at rest."""
    for w in (3.3e-3, -2.1e-3):
        wanted = REST + float(down_curve(np.array(w)))
        answer = way_to_load(vertical_springs(), V=wanted, n=4)
        assert float(answer["w"][-1]) == pytest.approx(w, rel=1e-3)
        np.testing.assert_allclose(answer["V"], np.linspace(REST, wanted, 5))


def test_reactions_sum_to_the_load_everywhere():
    table = build_vertical(Springs.of(vertical_springs()))
    rows = table.reactions(np.linspace(-1e-2, 1e-2, 41))
    np.testing.assert_allclose(table.b @ rows, rows[-1], rtol=1e-12)
    assert table.name[-1] == "V"


def test_initial_stiffness_is_the_full_models_and_the_slope_follows_v():
    tree = vertical_springs()
    assert float(stiffness_six(model_of(tree))[2, 2]) == K
    table = build_vertical(Springs.of(tree))
    step = 1e-9
    for sign in (1.0, -1.0):
        slope = (table.reactions(np.array([sign * step]))[-1, 0] - REST) / (sign * step)
        assert slope == pytest.approx(K, rel=1e-5)
    w = 4e-3
    slope = K / (1.0 + w / 5e-3) ** 2  # of the hyperbola
    matrix = stiffness(tree, V=REST + float(down_curve(np.array(w))))
    assert float(matrix.sel(dof="w", dof_conjugate="w")) == pytest.approx(slope, rel=5e-3)


def test_a_lateral_load_under_another_v_adds_its_w_and_is_marked():
    """w = w_lateral(V') + w_vertical(V) - w_vertical(V'), u, rotation and H as at V'."""
    tree = vertical_springs()
    more = REST + float(down_curve(np.array(1e-3)))
    usual = way_to_motion(tree, u=2e-3, rotation=0.0)
    with pytest.warns(MacroWarning, match=r"is not that of path 'slide' \(2 MN\): lateral springs unchanged"):
        loaded = way_to_motion(tree, u=2e-3, rotation=0.0, V=more)
    w = build_vertical(Springs.of(tree)).displacement(more)
    np.testing.assert_allclose(loaded["w"], usual["w"] + w, rtol=1e-9)
    np.testing.assert_allclose(loaded["H"], usual["H"])
    assert loaded["off_load"].values.tolist() == [0] + [1] * 25  # at rest V alone counts, and is known
    with pytest.raises(UserInputError, match="lateral springs unchanged"):
        impose(tree, u=2e-3, rotation=0.0, V=more, strict=True)


def test_one_direction_only_is_elastic_in_the_other_and_says_so():
    tree = vertical_springs(ends=(1e-2,))
    match = "no vertical path leads upwards: w would be that of the elastic vertical stiffness"
    with pytest.raises(BeyondSprings, match=match):
        predict(tree, V=REST - 1e6)
    with pytest.warns(MacroWarning, match=match):
        answer = predict(tree, V=REST - 1e6, extrapolate=True)
    assert float(answer["w"]) == pytest.approx(-1e6 / K)
    assert int(answer["extrapolated"]) == 1


def test_the_load_at_rest_is_known_without_its_direction():
    """V at rest, and what the solver leaves of it, is no load in the direction that no path leads to."""
    tree = vertical_springs(ends=(-1e-2,))
    for V in (REST, REST + 100.0):
        assert int(impose(tree, u=2e-3, rotation=0.0, V=V)["extrapolated"]) == 0
    path = tree["paths/slide"].to_dataset(inherit=False)
    tree["paths/slide"].dataset = path.assign(V=path["V"] + 40.0, V_lid=path["V_lid"] + 40.0)
    assert not compare(tree)["extrapolated_states"].any()


def test_no_more_states_are_marked_than_a_path_has():
    tree = vertical_springs(ends=(1e-2,))
    light = pressed(tree["paths/slide"].to_dataset(inherit=False), 0.5 * REST)
    tree["paths/light"] = xr.DataTree(light.assign_attrs(role="held-back"))
    row = compare(tree).set_index(["path", "springs"]).loc["light", "fan"]
    assert row["extrapolated_states"] == row["states"]


def test_beyond_the_vertical_springs_is_marked_or_has_no_equilibrium():
    tree = vertical_springs(ends=(5e-3, -1e-2))
    end = REST + float(down_curve(np.array(5e-3)))
    match = "beyond the vertical springs .* V from .* to 12.* MN; path 'down' ended in a way"
    with pytest.raises(BeyondSprings, match=match):
        predict(tree, V=end + 1e6)
    with pytest.warns(MacroWarning, match=match):
        answer = predict(tree, V=end + 1e6, extrapolate=True)
    assert int(answer["extrapolated"]) == 1
    flat = vertical_springs()
    for name in ("t", "V", "V_tip", "V_lid"):  # pull-out: no more resistance over the last steps
        values = flat["paths/up"][name].values
        values[..., -6:] = values[..., -6:-5]
    match = "no vertical equilibrium under V = -2 MN, .* MN .*; the springs carry V from"
    with warnings.catch_warnings(), pytest.raises(PredictionNotConverged, match=match):
        warnings.simplefilter("ignore", MacroWarning)
        predict(flat, V=-2e6, extrapolate=True)
    with pytest.raises(BeyondSprings, match=r"beyond the vertical springs \(path up\): no w carries it; they carry V"):
        predict(flat, V=-2e6)
    found = predict_batch(flat, H=0.0, V=np.array([-2e6, REST, end + 1e6]), extrapolate=True)
    assert found["answered"].values.tolist() == [0, 1, 1]
    assert str(found["why_not"].values[0]) == "no equilibrium"
    assert np.isnan(found["w"].values).tolist() == [True, False, False]


def test_vertical_paths_take_no_part_in_the_lateral_springs():
    with_vertical = vertical_springs()
    without = vertical_springs(ends=())
    for kind in ("fan", "full", "py", "pisa"):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MacroWarning)
            asked = {"u": 2e-3, "arm": 1.0, "springs_kind": kind, "extrapolate": True}
            a, b = (impose(tree, **asked) for tree in (with_vertical, without))
        xr.testing.assert_identical(a.drop_vars("utilisation_V").drop_attrs(), b.drop_attrs())
    first = xr.DataTree.from_dict({"/": with_vertical.to_dataset(inherit=False)} | {
        f"/paths/{name}": with_vertical[f"paths/{name}"].to_dataset(inherit=False) for name in ("down", "slide", "turn")
    })  # fmt: skip
    assert Springs.of(first).path().dataset.attrs["path"] == "slide"


# --- several vertical loads ---


def test_a_vertical_load_may_be_an_array_of_no_dimension():
    tree = vertical_springs(heavier=(6e6,))
    asks = (
        lambda V: impose(tree, u=1e-3, rotation=0.0, V=V)["H"],
        lambda V: predict(tree, V=V)["w"],
        lambda V: stiffness(tree, u=1e-3, rotation=0.0, V=V)[0, 0],
    )
    for ask in asks:
        for V in (np.array(3e6), xr.DataArray(3e6, attrs={"units": "N"})):
            assert float(ask(V)) == float(ask(3e6))


def test_between_two_loads_reactions_are_interpolated_and_w_is_that_of_the_vertical_springs():
    """The invented reactions grow in proportion to V, so that interpolation is exact; no warning is given."""
    tree = vertical_springs(heavier=(6e6,))
    assert [each.V for each in Springs.of(tree).load_sets] == [2e6, 6e6]
    assert Springs.of(tree).main_paths == tuple(Springs.of(tree).rays) == ("slide", "turn")
    heavy = tree.copy()
    heavy.attrs["vertical_load_N"] = 6e6
    assert sorted(Springs.of(heavy).rays) == ["slide_6", "turn_6"]
    usual, loaded = (way_to_motion(tree, u=2e-3, rotation=0.0, V=V) for V in (None, 3e6))
    np.testing.assert_allclose(loaded["H"][10:], 1.5 * usual["H"][10:], rtol=1e-9)  # beyond the first steps
    np.testing.assert_allclose(loaded["M"][10:], 1.5 * usual["M"][10:], rtol=1e-9)
    w = build_vertical(Springs.of(tree)).displacement(3e6)
    np.testing.assert_allclose(loaded["w"] - w, usual["w"], atol=1e-12)
    assert not loaded["off_load"].any()


def test_at_and_beyond_the_loads_of_the_sets():
    tree = vertical_springs(heavier=(6e6,))
    usual, own = (way_to_motion(tree, u=2e-3, rotation=0.0, V=V) for V in (None, 6e6))
    np.testing.assert_allclose(own["H"][10:], 3.0 * usual["H"][10:], rtol=1e-9)
    with pytest.warns(MacroWarning, match=r"V = 8 MN is not that of path 'slide_6' \(6 MN\)"):
        beyond = way_to_motion(tree, u=2e-3, rotation=0.0, V=8e6)
    np.testing.assert_allclose(beyond["H"], own["H"], rtol=1e-9)
    assert beyond["off_load"].values[-1] == 1
    settles = [build_vertical(Springs.of(tree)).displacement(V) for V in (8e6, 6e6)]
    np.testing.assert_allclose(beyond["w"] - own["w"], settles[0] - settles[1], rtol=1e-9)


def test_w_does_not_jump_at_the_loads_of_the_sets():
    """Rays under 6 MN from the start have a settlement of their own; at rest that of the vertical path counts."""
    tree, V = vertical_springs(heavier=(6e6,)), 1e6 * np.array([5.9, 5.99, 6.0, 6.01, 6.2])
    for name in ("slide_6", "turn_6"):
        tree[f"paths/{name}"]["w"].values += 5e-4
    w = build_vertical(Springs.of(tree)).displacements(V)[0]
    np.testing.assert_allclose(predict_batch(tree, H=0.0, V=V)["w"], w, rtol=1e-9)


def test_a_lonely_path_at_another_load_is_no_set():
    tree = vertical_springs(heavier=(6e6,))
    kept = {f"/paths/{name}": path.dataset.copy() for name, path in paths_of(tree).items() if name != "turn_6"}
    lonely = xr.DataTree.from_dict({"/": tree.to_dataset(inherit=False)} | kept)
    assert "slide_6" not in Springs.of(lonely).at(V=6e6).paths
    frame = compare(lonely)
    assert set(frame[frame["path"] == "slide_6"]["springs"]) == {"py", "pisa", "full", "fan"}


def test_compare_answers_every_path_under_its_own_load():
    tree = vertical_springs(heavier=(6e6,))
    heavy = tree["paths/slide_6"].to_dataset(inherit=False)
    tree["paths/held"] = xr.DataTree(pressed(tree["paths/slide"].to_dataset(inherit=False), 3e6).assign_attrs(
        heavy.attrs | {"role": "held-back"}))  # fmt: skip
    frame = compare(tree).set_index(["path", "springs"])
    held = frame.loc["held", "fan"]
    assert (held["V_N"], held["off_load_states"]) == (3e6, 0)
    assert abs(held["H_error_max_pct"]) < 1e-6
    assert abs(held["w_error_max_m"]) < 1e-9
    down = frame.loc["down", "vertical"]
    assert down["V_error_max_pct"] == pytest.approx(0.0, abs=1e-9)
    assert 1e-4 < abs(down["V_error_between_pct"]) < 5.0
    assert down["eta_large"] == pytest.approx(1.0)
    text = to_text(compare(tree))
    assert "V [MN]" in text and "vertical = vertical springs" in text and "nan" not in text
    assert "V [MN]" not in to_text(compare(vertical_springs(ends=())))


def changing_load(change: np.ndarray) -> xr.DataTree:
    """Return springs with a held-back translation that stops where its vertical load changes (N, by state)."""
    tree = vertical_springs()
    slide = tree["paths/slide"].to_dataset(inherit=False)
    held = slide.isel(step=[*range(slide.sizes["step"]), *[-1] * change.size]).copy(deep=True)
    held = held.assign_coords(step=np.arange(held.sizes["step"]))
    table = build_vertical(Springs.of(tree))
    settled = table.displacements(REST + change)[0]
    held["V"][-change.size :] = REST + change
    held["w"][-change.size :] += settled
    tree["paths/held"] = xr.DataTree(held.assign_attrs(slide.attrs | {"role": "held-back", "then_parts": 1}))
    return tree


def test_compare_answers_a_path_under_the_vertical_load_of_each_state():
    """w follows the recorded V, states under another V than the first are counted, and V that turns back is marked."""
    noise = np.array([1.0 + 1e-6, 1.0 - 1e-6, 1.0])
    tree = changing_load(np.append([0.3e6, 0.6e6], 1e6 * noise))
    row = compare(tree).set_index(["path", "springs"]).loc["held", "fan"]
    assert abs(row["w_error_max_m"]) < 1e-9 and abs(row["H_error_max_pct"]) < 1e-6
    assert (row["V_N"], row["V_end_macro_N"], row["off_load_states"]) == (REST, pytest.approx(3e6), 5)
    answer = curves(tree, "held")["fan"]
    assert not answer["turned_back"].any() and answer["off_load"].values[-6:].tolist() == [0, 1, 1, 1, 1, 1]
    assert f"held, fan: lateral springs of its first vertical load answer 5 of its {row['states']} states" in to_text(
        compare(tree)
    )
    back = curves(changing_load(np.array([0.5e6, 1e6, 0.5e6, 0.0])), "held")["fan"]
    assert back["turned_back"].values[-4:].tolist() == [0, 0, 1, 1] and not back["turned_back"].values[:-4].any()


def test_vertical_springs_answer_their_own_path_only_when_asked_for_all_sets():
    tree = vertical_springs()
    assert list(curves(tree, "up")) == ["vertical"]
    assert curves(tree, "up", "fan") == {}
    assert list(variables.problems(curves(tree, "up")["vertical"].drop_vars(["t", "u_at_load"]), "prediction")) != []


# --- files ---


@pytest.mark.parametrize("form", [0, 1], ids=["long", "wide"])
@pytest.mark.slow
def test_tables_give_the_vertical_springs_back(tmp_path, form):
    tree = vertical_springs(heavier=(6e6,))
    file = written.tables(tmp_path, tree)[form]
    table = open_table(file)
    for question in ({"V": 1.2e7}, {"V": 1e6}, {"V": 3e6, "H": 2e5}):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MacroWarning)  # two rays, 90 degrees apart
            ours, theirs = (predict(source, **question) for source in (tree, table))
        for name in ("u", "w", "rotation", "V"):
            np.testing.assert_allclose(theirs[name], ours[name], rtol=2e-2, atol=1e-7)
    assert "no initial stiffness" in " ".join(theirs.attrs["remarks"])
    assert float(theirs["w"]) == pytest.approx(float(ours["w"]), rel=2e-2)


def test_a_table_without_the_vertical_direction_refuses_v(tmp_path):
    file = written.tables(tmp_path, vertical_springs(ends=()))[0]
    with pytest.raises(UserInputError, match="V: these springs come from a table without vertical paths"):
        predict(open_table(file), H=1e5, V=1e6)


def test_vertical_rows_of_a_table_are_checked(tmp_path):
    file = written.tables(tmp_path, vertical_springs())[0]
    lines = file.read_text().splitlines()
    no_lid = [line for line in lines if not line.startswith("down,lid")]
    (tmp_path / "a.csv").write_text("\n".join(no_lid) + "\n")
    with pytest.raises(UserInputError, match="a vertical path has the families tz, base and lid, and no others"):
        open_table(tmp_path / "a.csv")
    at = next(k for k, line in enumerate(lines) if line.startswith("down,lid,0,0,0,,,3"))
    cells = lines[at].split(",")
    cells[11] = "0.5"
    (tmp_path / "b.csv").write_text("\n".join([*lines[:at], ",".join(cells), *lines[at + 1 :]]) + "\n")
    with pytest.raises(UserInputError, match="w_m: the caisson is rigid: one value a step, in all families"):
        open_table(tmp_path / "b.csv")


@pytest.mark.slow
def test_workbook_has_a_sheet_of_the_vertical_springs(tmp_path):
    import openpyxl

    tree = vertical_springs()
    book = openpyxl.load_workbook(written.workbook(tmp_path / "springs.xlsx", tree))
    sheet = book["t-z"]
    head = [cell.value for cell in sheet[3]]
    assert head[:7] == ["path", "step", "w [mm]", "V [kN]", "V tip [kN]", "V lid [kN]", "t net [kN/m]"]
    rows = [[cell.value for cell in row] for row in sheet.iter_rows(min_row=4)]
    assert [row[0] for row in rows] == ["down"] * 25 + ["up"] * 25
    path = paths_of(tree)["up"].dataset
    np.testing.assert_allclose([row[2] for row in rows[25:]], path["w"] * 1e3, atol=1e-12)
    np.testing.assert_allclose([row[6] for row in rows[25:]], path["t"].sum("side")[0] * 1e-3, rtol=1e-9)
    assert {"w_tz.up", "V_tz.up", "tz_1.up"} <= set(book.defined_names)
    assert (
        "t-z"
        not in openpyxl.load_workbook(written.workbook(tmp_path / "no.xlsx", vertical_springs(ends=()))).sheetnames
    )


def test_predict_with_a_vertical_load_alone(tmp_path):
    file = save_springs(vertical_springs(), tmp_path / "springs.nc")
    wanted = REST + float(down_curve(np.array(2e-3)))
    done = command("predict", str(file), "--V", f"{wanted} N", "--strict", "--json")
    assert done.code == 0, done.err
    assert '"w": 0.0020' in done.out.replace("0.00199", "0.0020")
    assert open_springs(file).attrs["schema"] == "pysprings-springs-4"


# --- scenes ---


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ({}, 'path[0]: a path of kind "vertical" needs vertical_displacement'),
        ({"vertical_displacement": 0.0}, "path[0].vertical_displacement: must not be zero"),
        ({"vertical_displacement": 1e-3, "arm": 2.0}, 'path[0].arm: a path of kind "vertical" does not use it'),
        ({"vertical_displacement": 1e-3, "heave": "fixed"}, 'path[0].heave: a path of kind "vertical" moves'),
        ({"vertical_displacement": 1e-3, "report_at": [2e-3]}, "2 mm is not on the way from 0 to vertical_"),
        ({"kind": "pull", "lateral_displacement": 1e-3, "vertical_displacement": 1e-3},
         'path[0].vertical_displacement: a path of kind "pull" does not use it'),
        ({"vertical_displacement": 1e-3, "vertical_load": "balance"}, '"balanced" is possible too'),
    ],
)  # fmt: skip
def test_a_scene_refuses_what_a_vertical_path_cannot_be(path, message):
    with pytest.raises(ValueError) as caught:
        tiny.sand(paths=[{"name": "down", "kind": "vertical", **path}])
    assert message in str(caught.value)


def test_a_vertical_path_needs_a_time_where_there_is_water():
    path = {"name": "down", "kind": "vertical", "vertical_displacement": 1e-3}
    with pytest.raises(ValueError, match=r'drainage\.mode = "coupled" needs rate or duration here'):
        tiny.sand(drainage={"mode": "coupled"}, paths=[path])
    kept = tiny.sand(drainage={"mode": "coupled"}, paths=[{**path, "rate": 1e-4, "vertical_load": "balanced"}])
    assert kept.vertical_load_of(kept.paths[0]) == "balanced"


# --- through the full model ---


@cache
def pushed() -> xr.DataTree:
    """The tiny caisson down and up from its usual load, and pulled at a vertical load of its own."""
    pull = {"lateral_displacement": 0.5e-3, "kind": "pull"}
    return run(tiny.scene(paths=[
        {**pull, "name": "pull"},
        {"name": "down", "kind": "vertical", "vertical_displacement": 2e-3},
        {"name": "up", "kind": "vertical", "vertical_displacement": -1e-3},
        {**pull, "name": "heavy", "vertical_load": 2.5e6, "role": "held-back"},
        {"name": "light_up", "kind": "vertical", "vertical_displacement": -0.2e-3, "vertical_load": 1e6,
         "role": "held-back"},
    ], solver={"first_step_fraction": 0.02, "max_step_fraction": 0.12}))  # fmt: skip


def test_a_vertical_path_holds_u_and_rotation():
    for name, end in (("down", 2e-3), ("up", -1e-3)):
        path = pushed()[f"paths/{name}"]
        assert float(path["w"][-1]) == pytest.approx(end)
        assert np.abs(path["u"]).max() < 1e-12 and np.abs(path["rotation"]).max() < 1e-12
        assert np.abs(path["H"]).max() < 1e-4 * np.abs(path["V"]).max()
        assert np.sign(end) * float(path["V"][-1] - path["V"][0]) > 0.0


def test_a_path_has_its_own_dead_load_and_counts_from_there():
    heavy, light, pull = (pushed()[f"paths/{name}"] for name in ("heavy", "light_up", "pull"))
    np.testing.assert_allclose(heavy["V"], 2.5e6, rtol=1e-4)
    assert float(pull["V"][0]) == pytest.approx(pushed().attrs["vertical_load_N"], rel=1e-6)
    assert float(heavy["w"][0]) > 0.0 and float(pull["w"][0]) == 0.0
    assert float(light["w"][-1] - light["w"][0]) == pytest.approx(-0.2e-3)


def test_the_vertical_springs_predict_dead_loads_of_the_full_model():
    """The settlement under a load put on in steps of its own, which the springs have not seen, within 2 %."""
    tree = extract_springs(pushed())
    for name in ("heavy", "light_up"):
        path = paths_of(tree)[name].dataset
        answer = predict(tree, V=float(path["V"][0]), strict=True)
        assert float(answer["w"]) == pytest.approx(float(path["w"][0]), rel=0.02)


def test_the_initial_vertical_stiffness_stays_the_full_models():
    tree = extract_springs(pushed())
    full = float(pushed()["stiffness_initial"][1, 1])
    assert float(stiffness_six(MacroModel.from_springs(tree))[2, 2]) == full
    assert build_vertical(Springs.of(tree)).stiffness == full
    frame = compare(tree).set_index(["path", "springs"])
    assert frame.loc["heavy", "full"]["off_load_states"] > 0
    assert abs(frame.loc["down", "vertical"]["V_error_max_pct"]) < 1e-6


@pytest.mark.slow
def test_a_vertical_path_has_a_picture_of_its_own():
    from pysprings.results import plots
    from pysprings.results.plots.files import figures

    names = [name for name, _ in figures(pushed(), None, {})]
    assert "up_vertical" in names and "pull_py" in names
    assert not {"up_py", "up_load_displacement", "pull_vertical"} & set(names)
    left, right = plots.vertical_springs(plots.path_data(pushed(), "up")).axes[:2]
    assert left.get_xlabel() == right.get_xlabel() == "vertical displacement w [mm], down +"
    assert left.xaxis_inverted()  # upwards runs to the right, where the labels are
    assert (left.get_ylabel(), right.get_ylabel()) == ("V [MN], down +", "reaction t [kN/m], both sides")
    total = next(line for line in left.get_lines() if line.get_label() == "total V")
    np.testing.assert_allclose(total.get_ydata(), pushed()["paths/up/V"] / 1e6)


def test_fixed_heave_holds_the_caisson_where_its_dead_load_has_put_it():
    result = run(tiny.scene(paths=[{**tiny.PULL, "heave": "fixed", "vertical_load": 2e6}]))
    w = result["paths/pull/w"].values
    assert w[0] > 0.0
    np.testing.assert_allclose(w, w[0], rtol=1e-9)


# --- beyond the last recorded state ---


@pytest.mark.parametrize("name", ["down", "up"])
def test_the_curve_goes_on_from_its_last_point_along_its_last_step(name):
    """Continuous there for every reaction, then straight; V -> w is the inverse. Line through two recorded points."""
    tree = vertical_springs(ends=(2e-3, -1e-4))  # upwards short of the limit, which carries no more
    path, table = paths_of(tree)[name].dataset, build_vertical(Springs.of(tree))
    w, V = path["w"].values, path["V"].values
    last, beyond = w[-1], w[-1] + 0.5 * (w[-1] - w[-2])
    inside, outside = table.reactions(np.array([last * (1.0 - 1e-12), last * (1.0 + 1e-12)])).T
    np.testing.assert_allclose(outside, inside, rtol=1e-9)
    recorded = {"V": V, "V_tip": path["V_tip"].values, "V_lid": path["V_lid"].values}
    t = path["t"].values.sum(axis=1) if path["t"].dims[1] == "side" else path["t"].sum("side").values
    expected = [row[-1] + 0.5 * (row[-1] - row[-2]) for row in [*t, *(recorded[n] for n in ("V_tip", "V_lid", "V"))]]
    np.testing.assert_allclose(table.reactions(np.array([beyond]))[:, 0], expected, rtol=1e-9)
    load = V[-1] + 0.5 * (V[-1] - V[-2])
    (found, just), (slope, _), (used, _) = table.displacements(np.array([load, V[-1] + 1e-9 * (V[-1] - V[0])]))
    assert found == pytest.approx(beyond, rel=1e-9)
    assert slope == pytest.approx((V[-1] - V[-2]) / (w[-1] - w[-2]))
    assert used == pytest.approx(beyond / last)
    assert just == pytest.approx(last, rel=1e-8)


@pytest.mark.filterwarnings("ignore::pysprings.macro.answer.MacroWarning")
def test_the_share_of_the_vertical_load_that_is_used():
    """Downwards over the largest V of its path; in tension over the largest pull; NaN where there is no such path."""
    tree, end = vertical_springs(), REST + float(down_curve(np.array(1e-2)))
    up = REST + float(down_curve(np.array(-1e-2)))
    assert up < 0.0
    for V, largest in ((5e6, end), (-3e5, up)):
        answer = predict(tree, V=V)
        assert answer.attrs["capacity_V_N"] == pytest.approx(largest)
        assert float(answer["utilisation_V"]) == pytest.approx(V / largest)
    assert predict(tree, V=5e6).attrs["capacity_V_kind"] == "end of the range"
    batch = predict_batch(tree, H=np.zeros(2), M=np.zeros(2), V=np.array([5e6, -3e5]))
    np.testing.assert_allclose(batch["utilisation_V"], [5e6 / end, -3e5 / up])
    bare = vertical_springs(ends=())
    assert "utilisation_V" not in predict(bare, H=1e3, arm=1.0)
    assert (
        predict_batch(bare, H=0.0, V=3.0 * REST)["why_not"]
        .values[0]
        .startswith("V beyond what is known without vertical springs")
    )
    assert np.isnan(float(predict(vertical_springs(ends=(1e-2,)), V=-1e5, extrapolate=True)["utilisation_V"]))


def test_what_is_carried_beyond_cavitation_is_no_capacity():
    """A path whose water would cavitate is known up to the step before: V, w and capacity end there, and say so."""
    whole = fan_with_vertical()
    wet, k = whole.copy(deep=True), 12
    margin = np.where(np.arange(whole["paths/up"].sizes["step"]) < k, 1e5, -1e3)
    wet["paths/up"] = whole["paths/up"].to_dataset().assign(cavitation_margin=("step", margin, {"units": "Pa"}))
    last = float(whole["paths/up"]["V"][k - 1])
    model = MacroModel.from_springs(wet)
    largest, kind, source = largest_vertical(model, -1.0)
    assert (largest, kind) == (pytest.approx(last), RANGE_END) and "water would cavitate beyond, at w = " in source
    assert largest_vertical(MacroModel.from_springs(whole), -1.0)[0] < last
    with pytest.raises(BeyondSprings, match=r"path 'up' stopped.*the water would cavitate beyond"):
        predict(wet, V=1.01 * last)
    w = [float(predict(each, V=0.99 * last)["w"]) for each in (wet, whole)]
    assert w[0] == pytest.approx(w[1], rel=1e-3)
    ended = [line for line in to_text(compare(wet)).splitlines() if line.startswith("path up")]
    assert len(ended) == 1 and ended[0].startswith("path up stopped (the water would cavitate beyond, at w = ")
    assert "cavitation_margin" not in Springs.of(wet).path("up").dataset  # springs at two V or rates are blended


def test_a_load_within_a_tenth_is_that_of_the_springs_and_a_limit_load_holds_there_too():
    """Marks begin at 10 %; what the full model did not carry at V is refused at 1.05 V."""
    tree = vertical_springs()
    for share, marked in ((1.09, 0), (0.91, 0), (1.12, 1), (0.88, 1)):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MacroWarning)
            found = way_to_motion(tree, u=2e-3, rotation=0.0, V=share * REST, extrapolate=True)
        assert found["off_load"].values[-1] == marked, share
    path = tree["paths/slide"]
    step = path.sizes["step"] // 3
    path.attrs |= {"end": "limit load", "end_reason": "limit load", "status": "limit load"}
    path.attrs |= {key: float(path[name][step]) for name, key in NUMBERS.items()}
    H, M = (1.2 * float(path[name][step]) for name in ("H", "M"))  # the springs go on beyond
    for V in (REST, 1.05 * REST):
        with pytest.raises(BeyondSprings, match="limit load"):
            predict(tree, H=H, M=M, V=V, extrapolate=True)


@pytest.mark.parametrize("spring_set", ["full", "py"])
def test_a_vertical_path_has_no_lateral_springs(spring_set):
    with pytest.raises(
        UserInputError, match="path: 'down' moves the caisson vertically alone: it has no lateral springs"
    ):
        predict(vertical_springs(), H=1e4, springs_kind=spring_set, path="down")


def test_beyond_a_vertical_limit_load_there_is_no_answer_with_any_option():
    """The last step of the path still grows: without a limit load it goes on from there, marked."""
    tree = vertical_springs()
    last = float(tree["paths/down"]["V"][-1])
    with pytest.warns(MacroWarning, match="is beyond the vertical springs"):
        assert float(predict(tree, V=1.01 * last, extrapolate=True)["w"]) > 1e-2
    tree["paths/down"].attrs |= {"end": "limit load", "end_reason": "limit load"}
    assert float(predict(tree, V=last)["w"]) == pytest.approx(1e-2)
    for H in (0.0, 1e4):
        with pytest.raises(BeyondSprings, match=r"path 'down' met a limit load .*, at V = "):
            predict(tree, H=H, V=1.01 * last, extrapolate=True)
    found = predict_batch(tree, H=0.0, V=np.array([0.99, 1.01]) * last, extrapolate=True)
    assert found["answered"].values.tolist() == [1, 0] and found["beyond_end"].values.tolist() == [0, 1]


def test_a_v_within_a_tenth_of_the_springs_and_near_its_own_capacity_is_marked_by_every_way_to_ask(tmp_path):
    """Springs at 2 MN, a path down that ends at 2.4: at 2.15 MN the chord leaves 6 tenths of the load, at 2.02 0.95."""
    tree = vertical_springs(ends=(1e-4,))
    end = REST + float(down_curve(np.array(1e-4)))
    left = (2.15e6 - end) / (REST - end)
    assert 0.5 < left < 0.7
    note = f"lateral springs unchanged, loads at equal motion at least {100.0 * left:.0f} % of those of the springs"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # two rays, 90 degrees apart
        answers = [predict(tree, H=1e5, arm=2.0, V=V) for V in (2.02e6, 2.15e6)]
        answers += [impose(tree, u=1e-4, V=2.15e6)]
    assert [int(each["off_load"]) for each in answers] == [0, 1, 1]
    assert [note in "; ".join(each.attrs["warnings"]) for each in answers] == [False, True, True]
    assert predict_batch(tree, H=1e5, arm=2.0, V=np.array([2.02e6, 2.15e6]))["off_load"].values.tolist() == [0, 1]
    with pytest.raises(UserInputError, match=note):
        impose(tree, u=1e-4, rotation=0.0, V=2.15e6, strict=True)
    file = tmp_path / "springs.nc"
    save_springs(tree, file)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        done = command("predict", str(file), "--H", "100 kN", "--arm", "2 m", "--V", "2.15 MN")
    assert "off_load" in done.out


def test_the_tolerance_of_v_along_a_path_is_no_other_vertical_load():
    """At 10 % from the springs, whose V is held to some newtons: no step is marked (a warning fails here)."""
    tree = vertical_springs()
    path = tree["paths/slide"].to_dataset(inherit=False)
    noise = xr.DataArray(40.0 * np.sin(np.arange(path.sizes["step"])), dims="step")
    tree["paths/slide"].dataset = path.assign(V=path["V"] + noise, V_lid=path["V_lid"] + noise)
    for V in (0.9 * REST, REST / 0.9):
        assert not way_to_motion(tree, u=2e-3, rotation=0.0, V=V)["off_load"].values.any()


def test_beyond_the_range_v_of_the_springs_is_still_their_load():
    """V of the last state is 0.4 % off: ten times as far along it was 45 % off, and the V of the springs was marked."""
    tree = vertical_springs()
    path = tree["paths/slide"].to_dataset(inherit=False)
    left = xr.DataArray(
        np.where(np.arange(path.sizes["step"]) == path.sizes["step"] - 1, -4e-3 * REST, 0.0), dims="step"
    )
    tree["paths/slide"].dataset = path.assign(V=path["V"] + left, V_lid=path["V_lid"] + left)
    for V in (None, REST):
        with pytest.warns(MacroWarning, match="beyond the range"):
            state = impose(tree, u=0.1, rotation=0.0, V=V, extrapolate=True)
        assert state["V"] == REST and not state["off_load"]


def test_the_share_of_loads_that_is_left_is_that_of_the_chord_to_the_end():
    """By hand: 1 at the V of the springs and within its tolerance, however near the end; else (V - V_e)/(V_s - V_e)."""
    table = build_vertical(Springs.of(vertical_springs()))
    end = next(branch.largest for branch in table.branches if branch.sign > 0.0)
    own, V = np.array([0.5, 0.5, 0.998, 0.998]) * end, np.array([0.5, 0.54, 0.9985, 1.01]) * end
    np.testing.assert_allclose(share_left(table, V, own), [1.0, 0.46 / 0.5, 1.0, -5.0], rtol=1e-9)
    assert covered(table, V, own).tolist() == [True, True, True, False]
    assert np.isnan(share_left(None, V[1:2], own[1:2])) and covered(None, V[1:2], own[1:2]).all()
