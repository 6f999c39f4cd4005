# SPDX-License-Identifier: MIT
"""Curves for beam programs: sums on any depths, the safe side, the stated error beside an own solution, refusals."""

import io
import json
import re
from pathlib import Path as File

import numpy as np
import openpyxl
import pandas as pd
import pytest
from scipy.optimize import brentq

import pysprings
from pysprings.core.errors import UserInputError
from pysprings.full_model.compute import run
from pysprings.results import exporters
from pysprings.results.exporters import beam
from pysprings.results.exporters.base import Source
from pysprings.springs.checks import extract_springs, save_springs
from pysprings.springs.springs import Springs
from tests.support import tiny
from tests.support.commands import command
from tests.support.fans import fan_springs, potential
from tests.support.synthetic import Path, make_springs
from tests.support.vertical import vertical_springs

PATHS = (Path("across", "translation"), Path("over", "rotation"), Path("pull", arm=6.0, role="held-back", steps=30))
DEPTHS = "0.4, 1.3, 2.2, 3.6 m"


def text(**options: str) -> str:
    return exporters.text(make_springs(PATHS), "beam", **options)


def table(**options: str) -> pd.DataFrame:
    return pd.read_csv(io.StringIO(text(**options)), comment="#")


PAIRS = (("y_m", "p_N_per_m"), ("y_m", "H_N"), ("rotation_rad", "m_Nm_per_m"), ("rotation_rad", "M_Nm"))
Lines = list[tuple[float, float, list[tuple[np.ndarray, np.ndarray]]]]


def lines_of(curves: pd.DataFrame) -> Lines:
    """Return depth, height and the four curves of each row of springs in a table."""
    found = []
    for (_, z), own in curves.groupby(["family", "depth_m"]):
        height = own["depth_bottom_m"].iloc[0] - own["depth_top_m"].iloc[0]
        found.append((z, height, [tuple(own[[*pair]].dropna().to_numpy().T) for pair in PAIRS]))
    return found


def loads(springs: Lines, u: float, rotation: float) -> np.ndarray:
    """Return H, M of a rigid beam on the straight lines of the curves of a table, as a beam program sums them."""
    out = np.zeros(2)
    for z, height, curves in springs:
        y = u - z * rotation
        p, H, m, M = (np.sign(x) * np.interp(abs(x), *curve) if curve[0].size else 0.0
                      for x, curve in zip((y, y, rotation, rotation), curves, strict=True))  # fmt: skip
        force = height * p + H
        out += force, height * m + M - z * force
    return out


def test_the_stated_error_is_that_of_a_rigid_beam_on_the_straight_lines_of_the_table() -> None:
    """At the recorded u of the held-back pull, the load at its height: rotation and H by an own solution."""
    written = text(depths=DEPTHS)
    alone, whole = (line for line in written.splitlines()[:2])
    assert alone.startswith("# p(y) alone") and whole.startswith("# all curves of this table")
    curves, path = pd.read_csv(io.StringIO(written), comment="#"), Springs.of(make_springs(PATHS)).paths["pull"]
    for line, own in ((alone, lines_of(curves[curves["family"] == "py"])), (whole, lines_of(curves))):
        errors = []
        for u, H in zip(path.u, path["H"], strict=True):
            if u < 0.01 * path.u[-1]:
                continue

            def missing(rotation: float, u: float = u, own: Lines = own) -> float:
                force, couple = loads(own, u, rotation)
                return float(couple - path.arm * force)

            rotation = brentq(missing, -1.0 * u, 2.0 * u, xtol=1e-15)
            errors.append(100.0 * (loads(own, u, rotation)[0] / H - 1.0))
        stated = float(re.findall(r"H ([-+.\d]+) % \(pull\)", line)[0])
        assert stated == pytest.approx(errors[int(np.argmax(np.abs(errors)))], abs=0.1)


def test_a_pile_that_stands_for_the_foundation_follows_the_fan(tmp_path: File) -> None:
    """Loads of a rigid beam at the states of held-back pulls, and the error that is stated, far below the other's."""
    tree = fan_springs(potential, held_back=(2.0, 8.0))
    first = {}
    for pile in ("no", "yes"):
        lines = exporters.text(tree, "beam", pile=pile).splitlines()
        line = next(line for line in lines if line.startswith("# all curves of this table"))
        first[pile] = max(
            abs(float(value)) for value in re.findall(r"H ([-+.\d]+) %|u at equal load ([-+.\d]+) %", line)[0] if value
        )
        assert any(line.startswith("# --pile: p(y) of a rigid pile") for line in lines) == (pile == "no")
    assert first["yes"] < min(5.0, 0.5 * first["no"])
    assert any("not for loads near the depth of the tip" in line for line in lines)
    curves = pd.read_csv(io.StringIO("\n".join(lines)), comment="#")
    assert curves["depth_bottom_m"].max() <= 8.0 + 1e-9
    rows = lines_of(curves)
    for path in (Springs.of(tree).paths[name] for name in ("pull_2", "pull_8")):
        exact = np.stack([path["H"], path["M"]], axis=1)[5:]
        found = np.array([loads(rows, *state) for state in zip(path.u[5:], path.rotation[5:], strict=True)])
        assert (
            np.linalg.norm((found - exact) / [1.0, 4.0], axis=1) < 0.05 * np.linalg.norm(exact / [1.0, 4.0], axis=1)
        ).all()
    arrays = pysprings.beam(tree, pile="yes")
    np.testing.assert_allclose(arrays["M_lid"].max(), curves["M_Nm"].max())
    np.testing.assert_allclose(arrays["depth"], (np.arange(24) + 0.5) / 3.0)  # no stratum is missing
    save_springs(tree, tmp_path / "fan.nc")
    done = command("springs", tmp_path / "fan.nc", "--for", "beam", "--pile", "--depths", "1, 2 m")
    assert done.code == 2 and "--depths: the strata of a pile" in done.err
    for place in (tmp_path / "pile.csv", tmp_path / "pile.xlsx"):
        assert command("springs", tmp_path / "fan.nc", "--for", "beam", "--pile", "--out", place).code == 0
        state = json.loads(command("predict", place, "--H", "0.5 MN", "--arm", "2 m", "--json").out)["states"][-1]
        np.testing.assert_allclose(loads(lines_of(curves), state["u"], state["rotation"]), [0.5e6, 1.0e6], rtol=1e-3)


@pytest.mark.parametrize("depths", ["", DEPTHS])
def test_force_and_moment_of_p_and_the_sum_of_m_are_those_recorded(depths: str) -> None:
    springs = Springs.of(make_springs((PATHS[0], Path("over", "rotation", size=2e-4))))  # m grows on all of it
    asked = beam.depths_of(depths, springs.length) if depths else None
    rows, bounds, corrected = beam.rows_of(springs, asked)
    assert not corrected
    slid, turned = springs.paths["across"], springs.paths["over"]
    height = {z: low - high for z, (high, low) in bounds.items()}
    p = np.array([height[row.depth] * row.r for row in rows if row.name == "p"])
    m = np.array([height[row.depth] * row.r for row in rows if row.name == "m"])
    z = np.array([row.depth for row in rows if row.name == "p"])
    assert len(z) == 4 or not depths
    change = slid.p - slid.p[:, :1]
    np.testing.assert_allclose(p.sum(axis=0), slid.heights @ change, rtol=1e-12)
    np.testing.assert_allclose(z @ p, (slid.depth * slid.heights) @ change, rtol=1e-12)
    np.testing.assert_allclose(m.sum(axis=0), turned.heights @ (turned.m - turned.m[:, :1]), rtol=1e-12)


def test_curves_that_fall_or_pull_along_are_cut_and_their_sum_is_never_above() -> None:
    given = np.array([[0.0, 3.0, 5.0, 4.0], [0.0, -1.0, 1.0, 2.0], [0.0, 2.0, 3.0, 5.0]])
    weight = np.array([1.0, 2.0, 0.5])
    found = beam.on_safe_side(given, weight)
    assert (np.diff(found, axis=1) >= 0.0).all() and (found >= 0.0).all()
    assert (weight @ found <= weight @ given + 1e-12).all()
    np.testing.assert_allclose(beam.monotone(given)[0], [0.0, 3.0, 4.0, 4.0])
    np.testing.assert_allclose(beam.on_safe_side(given[2:], weight[2:]), given[2:])


def test_what_is_corrected_and_the_vertical_load_stand_in_the_head() -> None:
    """m of the rotation falls: the sum of its family is lower by what the line states, and never above."""
    rows, _, corrected = beam.rows_of(Springs.of(make_springs(PATHS)), None)
    (line,) = corrected
    assert re.match(
        r"corrected on the safe side, sum of the moments of the rotation lower by [\d.]+ % of the largest at most: m",
        line,
    )
    assert all((np.diff(row.r) >= 0.0).all() for row in rows) and f"# {line}" in text()
    heavy = exporters.text(vertical_springs(heavier=(6e6,)), "beam", V=6e6)
    light = exporters.text(vertical_springs(heavier=(6e6,)), "beam")
    assert "# lateral springs at V = 6000 kN" in heavy and "# lateral springs at V = 2000 kN" in light
    p = [pd.read_csv(io.StringIO(each), comment="#")["p_N_per_m"].max() for each in (light, heavy)]
    assert p[1] == pytest.approx(3.0 * p[0], rel=0.02)


def test_the_error_of_the_mesh_is_that_of_the_worst_path_where_the_springs_have_it() -> None:
    assert "discretisation error: not recorded" in text()
    springs = make_springs(PATHS)
    for name, error in (("across", 2.0), ("over", 3.4)):
        springs[f"paths/{name}"].attrs["mesh_error_pct"] = error
    own = exporters.text(springs, "beam")
    assert "estimated discretisation error of the load: 3.4 % at most (path over)" in own


def test_what_the_safe_side_changes_of_force_and_moment_stands_in_the_head() -> None:
    """The lid pulls along: it is cut, p is less by as much, and the moment with it."""
    tree = make_springs(PATHS)
    path = tree["paths/across"].to_dataset(inherit=False)
    path["H_lid"][:] = -0.02 * path["H"]
    tree["paths/across"] = path
    springs = Springs.of(tree)
    rows, bounds, corrected = beam.rows_of(springs, None)
    own = [row for row in rows if row.carrier == "y"]
    weight = np.array([np.diff(bounds[row.depth])[0] if row.name == "p" else 1.0 for row in own])
    r, slid = np.array([row.r for row in own]), springs.paths["across"]
    tip = slid["H_tip"] - slid["H_tip"][0]
    change = slid.p - slid.p[:, :1]
    force = slid.heights @ change + tip + slid["H_lid"] - slid["H_lid"][0]
    moment = (slid.depth * slid.heights) @ change + springs.length * tip
    found = (weight * [row.depth for row in own]) @ r
    (text,) = (each for each in corrected if "translation" in each)
    lost, moved = (float(each) for each in re.findall(r"by ([-+.\de]+) %", text))
    assert lost == pytest.approx(100.0 * np.max(force - weight @ r) / np.abs(force).max(), rel=0.1, abs=1e-9)
    assert moved == pytest.approx(100.0 * np.min(found - moment) / np.abs(moment).max(), rel=0.05) and moved < -1.0


@pytest.mark.parametrize("depths", ["0.1, 0.2 m", "3.8, 3.9, 4 m"])
def test_depths_on_one_side_of_where_p_acts_are_refused(depths: str) -> None:
    """No curves there that grow have its force and its moment."""
    slid = Springs.of(make_springs(PATHS)).paths["across"]
    with pytest.raises(UserInputError, match=r"p of the translation acts at .* which is not between") as error:
        text(depths=depths)
    at = float(re.findall(r"acts at ([\d.]+) m", str(error.value))[0])
    centre = ((slid.depth * slid.heights) @ slid.p)[1:] / (slid.heights @ slid.p)[1:]
    assert centre.min() - 0.01 < at < centre.max() + 0.01


def test_the_table_answers_as_springs_of_a_user(tmp_path: File) -> None:
    """`predict` on the table: its equilibrium is that of a rigid beam on the straight lines."""
    file = tmp_path / "beam.csv"
    file.write_text(text(depths=DEPTHS))
    for H, arm in ((1e5, 0.0), (3e5, 0.0), (1e5, 6.0), (2e5, 6.0), (5e4, 20.0)):
        found = command("predict", file, "--springs", "full", "--H", f"{H} N", "--arm", f"{arm} m", "--json")
        assert found.code == 0, found.err
        state = json.loads(found.out)["states"][-1]
        balance = loads(lines_of(table(depths=DEPTHS)), state["u"], state["rotation"])
        np.testing.assert_allclose(balance, [H, H * arm], rtol=1e-6, atol=1e-6 * H)


def test_comments_of_any_length_stand_above_a_table(tmp_path: File) -> None:
    """A table that the program wrote, with remarks of its reader above it, is read again."""
    depths = ", ".join(f"{0.1 + 0.1 * k:.1f} m" for k in range(35))
    written = text(depths=depths)
    assert re.search(r"largest at most: m at \d\d depths from 0\.\d+ to 3\.5 m", written)
    file = tmp_path / "beam.csv"
    file.write_text("# a remark, one of many\n" * 50 + written)
    found = command("predict", file, "--springs", "full", "--H", "1 kN", "--arm", "6 m", "--json")
    assert found.code == 0, found.err


def test_workbook_and_text_have_the_same_rows(tmp_path: File) -> None:
    exporters.export(make_springs(PATHS), "beam", tmp_path / "beam.xlsx", depths=DEPTHS)
    rows = list(openpyxl.load_workbook(tmp_path / "beam.xlsx").active.values)
    head = next(k for k, row in enumerate(rows) if row[0] == "family")
    assert str(rows[0][0]).startswith("# p(y) alone") and rows[head] == beam.COLUMNS
    frame = pd.DataFrame(rows[head + 1 :], columns=beam.COLUMNS)
    pd.testing.assert_frame_equal(frame, table(depths=DEPTHS)[list(beam.COLUMNS)], check_dtype=False, rtol=1e-9)


@pytest.mark.parametrize(
    ("depths", "words"),
    [
        ("0.5, 9 m", "9 m is not on the skirt, 0 to 4 m"),
        ("0.5, 1.5", "expected a quantity with unit"),
        ("0.5 m", "two depths or more"),
        ("1.5, 0.5 m", "each below the one before"),
        ("0.5 m, deep", 'got "deep"'),
    ],
)
def test_depths_that_are_refused(depths: str, words: str) -> None:
    with pytest.raises(UserInputError, match=re.escape(words)):
        text(depths=depths)


def test_too_few_points_are_refused() -> None:
    with pytest.raises(UserInputError, match="--option points: 1 is not from"):
        text(points="1")


def test_depths_with_units_of_their_own() -> None:
    np.testing.assert_allclose(beam.depths_of("50 cm, 1.5, 2 m", 4.0), [0.5, 1.5, 2.0])
    np.testing.assert_allclose(beam.depths_of("0.5, 1.0 m, 150 cm", 4.0), [0.5, 1.0, 1.5])


def test_springs_without_pure_paths_are_refused() -> None:
    springs = Source(springs=make_springs((Path("pull", arm=6.0),)))
    with pytest.raises(UserInputError, match="a pure translation and a pure rotation"):
        exporters.text(springs, "beam")


def test_options_of_the_command(tmp_path: File) -> None:
    from pysprings.springs.checks import save_springs

    file = save_springs(make_springs(PATHS), tmp_path / "springs.nc")
    assert command("springs", file, "--for", "beam", "--depths", DEPTHS).out == text(depths=DEPTHS)
    for extra, words in ((("--format", "json"), "writes csv or xlsx"), (("--wide",), "writes csv or xlsx, not --wide")):
        done = command("springs", file, "--for", "beam", *extra)
        assert done.code == 2 and words in done.err
    assert "is an option of --for beam" in command("springs", file, "--depths", DEPTHS).err


def test_the_curves_as_arrays_are_those_of_the_table() -> None:
    """Every point of the table stands in the dataset, of the typed springs and of the accessor alike."""
    tree, depths = make_springs(PATHS), [0.4, 1.3, 2.2, 3.6]
    found, frame = pysprings.beam(tree, depths), table(depths=DEPTHS)
    assert found.identical(pysprings.beam(Springs.of(tree), depths)) and found.identical(tree.pysprings.beam(depths))
    assert found["p"].shape == (4, beam.POINTS) and found.attrs["remarks"][0].startswith("p(y) alone")
    for name, (family, moves, reacts) in beam.PLACES.items():
        own = frame[frame["family"] == family].dropna(subset=[moves, reacts])
        place = name[1:]
        arrays = found[("rotation" if moves == "rotation_rad" else "y") + (place if len(name) > 1 else "")], found[name]
        for column, values in zip((moves, reacts), arrays, strict=True):
            np.testing.assert_allclose(values.values[np.isfinite(values.values)], own[column], rtol=1e-6)
    np.testing.assert_allclose(found["depth_bottom"] - found["depth_top"], [0.85, 0.9, 1.15, 1.1])
    units = {"y": "m", "p": "N m-1", "rotation": "radian", "m": "N m m-1", "H": "N", "M": "N m", "depth": "m"}
    assert {str(name): each.attrs["units"] for name, each in found.variables.items()} == {
        str(name): units[str(name).partition("_")[0]] for name in found.variables
    }
    assert "bounds" not in found["depth"].attrs  # names no variable that is not there
    assert len(pysprings.beam(tree, points=7)["point"]) == 7
    with pytest.raises(UserInputError, match="not on the skirt"):
        pysprings.beam(tree, [0.5, 9.0])
    for depths in ([], 2.0, "0.5, 1.5 m"):
        with pytest.raises(UserInputError, match=r"depths: (give two depths or more|.*is a text)"):
            pysprings.beam(tree, depths)


def test_the_stated_error_is_that_of_paths_at_the_v_of_the_table() -> None:
    """Curves at 6 MN are not judged by a path that is held back at 2 MN; the calibration paths at 6 MN are left."""
    tree = vertical_springs(heavier=(6e6,))
    tree["paths/check"] = tree["paths/slide"].to_dataset(inherit=False).assign_attrs(role="held-back")
    here, there = (pysprings.beam(tree, [0.5, 3.0], V=V).attrs["remarks"][:4] for V in (2e6, 6e6))
    assert "held-back paths, largest: H" in here[0] and "(check)" in here[0] and "held-back" in here[1]
    assert not any("check" in line or "held-back" in line for line in there)
    assert "calibration paths, largest: H" in there[0] and "slide_6" in there[0] + there[2]
    assert there[1].endswith("no path is held back at V = 6000 kN") and there[3].endswith("at V = 6000 kN")


def test_curves_at_mudline_and_tip_keep_force_and_moment() -> None:
    """Depths that are no ring of the mesh, the ends of the skirt among them."""
    springs = Springs.of(make_springs(PATHS))
    slid = springs.paths["across"]
    curves = table(depths=f"0, 0.5, {springs.length} m")
    for share in (0.4, 1.0):
        k = round(share * (slid.n - 1))
        force, couple = loads(lines_of(curves), float(slid.u[k]), 0.0)
        assert force == pytest.approx(float(slid["H"][k] - slid["H"][0]), rel=1e-2)
        p = slid.p[:, k] - slid.p[:, 0]
        moment = -float(p @ (slid.depth * slid.heights)) - springs.length * float(slid["H_tip"][k] - slid["H_tip"][0])
        assert couple == pytest.approx(moment, rel=1e-2)


def test_a_prediction_on_these_curves_is_no_plain_answer(tmp_path: File) -> None:
    """The table has errors of many per cent in its first lines, which a reader of tables leaves out."""
    file = tmp_path / "beam.csv"
    file.write_text(text(depths=DEPTHS), encoding="utf-8")
    done = command("predict", file, "--H", "100 kN", "--arm", "2 m")
    assert done.code == 0 and "note: curves of a table act apart from each other" in done.err
    cases, answers = tmp_path / "cases.csv", tmp_path / "answers.html"
    cases.write_text("name,H [kN],arm [m]\na,100,2\n", encoding="utf-8")
    done = command("design", file, cases, "--out", answers)
    assert done.code == 0 and "note: curves of a table act apart from each other" in done.out
    assert "curves of a table act apart from each other" in answers.read_text(encoding="utf-8")


def test_depths_beyond_the_outer_rings_of_a_mesh() -> None:
    """Rings of a series end inside the skirt: springs asked for at its ends stand at no ring of the held-back path."""
    slide = {"name": "slide", "kind": "translation", "lateral_displacement": 0.5e-3}
    turn = {"name": "turn", "kind": "rotation", "rotation": 1e-4}
    paths, mesh = (slide, turn, tiny.PULL | {"role": "held-back"}), {"discretisation": "fourier", "harmonics": 2}
    springs = extract_springs(run(tiny.scene(paths=paths, mesh=mesh)))
    typed = Springs.of(springs)
    assert 0.0 < typed.path().depth[0] < typed.path().depth[-1] < typed.length
    written = exporters.text(springs, "beam", depths=f"0, {typed.length} m")
    assert written.startswith("# p(y) alone") and "pull" in written.partition("\n")[0]
    depths = pd.read_csv(io.StringIO(written), comment="#")["depth_m"]
    assert {0.0, typed.length} <= set(depths)
