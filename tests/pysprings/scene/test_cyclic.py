# SPDX-License-Identifier: MIT
"""Backbones of clay from contours of cyclic tests: interpolation by hand, G and contours in a DSS test, refusals."""

from pathlib import Path

import numpy as np
import pytest

from pysprings.core.errors import UserInputError
from pysprings.model.element import KINDS, element_test, specimen
from pysprings.model.soil_laws import soil_materials
from pysprings.scene.load import load_scene, parse_scene
from pysprings.scene.model import Scene, ground_text
from pysprings.springs.path import paths_of
from tests.support import tiny
from tests.support.commands import command

SCENE = """
title = "Storm"
[soil]
yield_surface = "iwan-clay"
undrained_shear_strength = { top = "10 kPa", gradient = "2 kPa/m" }
rigidity_ratio = 600
effective_unit_weight = "8 kN/m^3"
cyclic = { contours = "drammen.csv", cycles = 10 }
[domain]
radius = "40 m"
depth = "20 m"
[interface]
adhesion_factor = 0.65
[[path]]
name = "a"
kind = "pull"
lateral_displacement = "1 mm"
"""
# Andersen's diagram of Drammen clay in DSS, OCR 1, tau_a = 0, as read off in groundhog 0.15 (soildynamics)
DRAMMEN = {1: (0.628, 0.783, 0.928, 1.211), 10: (0.603, 0.727, 0.820, 0.924), 100: (0.545, 0.613, 0.668, 0.710),
           1000: (0.460, 0.490, 0.511, 0.530)}  # fmt: skip
STRAINS = (0.005, 0.01, 0.03, 0.15)
# two averages; strains of the averages in %
AVERAGES = """\
N;tau_a/su;tau_cy/su;gamma_a [%];gamma_cy [%]
10;0;0.4;0;0.5
10;0;0.8;0;4
10;0.4;0.2;0.3;0.2
10;0.4;0.5;1;3
"""


def rows() -> str:
    lines = [f"{N},{t},{100 * g}" for N, own in DRAMMEN.items() for t, g in zip(own, STRAINS, strict=True)]
    return "N,tau_cy/su,gamma_cy [%]\n" + "\n".join(lines) + "\n"


def scene(tmp_path: Path, change: tuple[str, str] = ("", ""), table: str | None = None, text: str = SCENE) -> Scene:
    (tmp_path / "drammen.csv").write_text(rows() if table is None else table)
    (tmp_path / "c.toml").write_text(text.replace(*change))
    return load_scene(tmp_path / "c.toml")


def curve(given: Scene) -> tuple[tuple[float, float], ...]:
    return given.ground.strata[0].tables["cyclic"].curve


@pytest.mark.parametrize("cycles", [1, 10, 1000])
def test_a_backbone_at_a_number_of_the_contours_is_theirs(tmp_path, cycles) -> None:
    given = scene(tmp_path, ("cycles = 10", f"cycles = {cycles}"))
    assert curve(given) == tuple(zip(STRAINS, DRAMMEN[cycles], strict=True))


def test_between_contours_stress_is_linear_in_log_of_the_number_of_cycles(tmp_path) -> None:
    share = np.log(3.0) / np.log(10.0)
    found = np.array(curve(scene(tmp_path, ("cycles = 10", "cycles = 30"))))
    assert found[:, 1] == pytest.approx(
        (1.0 - share) * np.array(DRAMMEN[10]) + share * np.array(DRAMMEN[100]), rel=1e-5
    )


def test_strains_of_both_curves_count_where_they_differ_in_log_of_strain(tmp_path) -> None:
    """tau/su 0.4 at 1 % and 0.6 at 4 % at N 1: 0.5 at 2 %; 0.2 at 0.5 %, 0.4 at 2 % and 0.5 at 8 % at N 100."""
    table = "N,tau_cy/su,gamma_cy [%]\n1,0.4,1\n1,0.6,4\n100,0.2,0.5\n100,0.4,2\n100,0.5,8\n"
    found = curve(scene(tmp_path, ("cycles = 10", "cycles = 10"), table))
    assert np.array(found) == pytest.approx(np.array([(0.01, 0.35), (0.02, 0.45), (0.04, 0.525)]), rel=1e-5)


def test_average_and_cyclic_parts_are_added(tmp_path) -> None:
    """At tau_a/su 0.4: 0.6 at 0.5 %, 0.9 at 4 %; at 0.2 the mean of these and of 0.4, 0.8."""
    own = scene(tmp_path, ("cycles = 10", "cycles = 10, average = 0.4"), AVERAGES)
    assert curve(own) == ((0.005, 0.6), (0.04, 0.9)) and "tau_a/su 0.4" in own.title
    half = scene(tmp_path, ("cycles = 10", "cycles = 10, average = 0.2"), AVERAGES)
    assert curve(half) == ((0.005, 0.5), (0.04, 0.85))


def sheared(given: Scene, strain: float, kind: str = "dss", column: str = "shear_stress_Pa") -> np.ndarray:
    """Return stress over su of a test at 5 m, where su is 20 kPa, up to a strain; of DSS tau."""
    point = specimen(given.ground.strata[0], KINDS[kind], 50e3, 5.0)
    return element_test(point, KINDS[kind], 5.0, False, strain).columns()[column] / 20e3


@pytest.mark.parametrize("rigidity", [150.0, 600.0, 2000.0])
def test_a_simple_shear_test_begins_with_the_stiffness_and_meets_every_contour(tmp_path, rigidity) -> None:
    given = scene(tmp_path, ("ratio = 600", f"ratio = {rigidity}"))
    assert sheared(given, 2e-6)[-1] == pytest.approx(2e-6 * rigidity, rel=0.01)
    assert [sheared(given, each)[-1] for each in STRAINS] == pytest.approx(DRAMMEN[10], rel=1e-6)
    assert sheared(given, 0.3)[-1] == pytest.approx(0.924, rel=1e-6)


def test_strengths_by_direction_have_the_contours_in_their_own(tmp_path) -> None:
    """Factors 1.3, 1, 0.7: DSS has the contours, with K0 1 up to 3 % less on the way; triaxial 1.17, 0.57."""
    given = scene(tmp_path, ("[domain]", "compression_factor = 1.3\nextension_factor = 0.7\n[domain]"))
    assert parse_scene(given.source_text) == given
    assert sheared(given, 2e-6)[-1] == pytest.approx(2e-6 * 600.0, rel=0.01)
    assert [sheared(given, each)[-1] for each in STRAINS] == pytest.approx(DRAMMEN[10], rel=0.03)
    assert sheared(given, 0.8)[-1] == pytest.approx(0.924, rel=1e-3)
    up, down = (sheared(given, 0.8, kind, "q_Pa")[-1] for kind in ("triaxial", "triaxial-extension"))
    assert (0.5 * up, 0.5 * down) == pytest.approx((1.166 * 0.924, -0.566 * 0.924), rel=2e-3)


def test_a_factor_of_simple_shear_raises_the_backbone_at_every_depth(tmp_path) -> None:
    """A factor of 1.2 on 10 + 2 z kPa is a strength of 12 + 2.4 z kPa with the other factors over 1.2."""
    depth = np.array([[1.0, 2.0], [4.0, 6.0]])
    rows = [
        soil_materials(scene(tmp_path, ("[domain]", keys + "[domain]"), text=text), depth)[0][0].parameters
        for keys, text in (
            ("direct_shear_factor = 1.2\nextension_factor = 0.96\n", SCENE),
            ("compression_factor = 0.8333333333333\nextension_factor = 0.8\nrigidity_ratio = 500\n",
             SCENE.replace("10 kPa", "12 kPa").replace("2 kPa/m", "2.4 kPa/m").replace("rigidity_ratio = 600\n", "")),
        )
    ]  # fmt: skip
    assert rows[0] == pytest.approx(rows[1], rel=1e-9)


def test_a_contour_on_the_elastic_line_joins_by_a_hyperbola_through_it_alone(tmp_path) -> None:
    """tau/su 0.1 at 0.02 % is 500 su, near G/su of 600; the second contour is far below it."""
    table = "N,tau_cy/su,gamma_cy [%]\n10,0.10,0.02\n10,0.3,0.1\n10,0.8,5\n"
    found = [sheared(scene(tmp_path, table=table), each)[-1] for each in (2e-6, 2e-4, 1e-3, 0.05)]
    assert found == pytest.approx([2e-6 * 600.0, 0.1, 0.3, 0.8], rel=1e-3)


def test_a_scene_holds_its_contours_and_names_them(tmp_path) -> None:
    """Its text needs no file, and another number of cycles changes backbone and title."""
    given = scene(tmp_path)
    assert given.title == "Storm (cyclic: drammen.csv, N 10, tau_a/su 0)"
    assert "(iwan-clay, cyclic: drammen.csv, N 10, tau_a/su 0) from 0 m" in ground_text(given)
    (tmp_path / "drammen.csv").unlink()
    assert parse_scene(given.source_text) == given
    other = parse_scene(given.source_text, changes=["soil.cyclic.cycles=100"])
    assert other.title == "Storm (cyclic: drammen.csv, N 100, tau_a/su 0)" and curve(other)[0] == (0.005, 0.545)
    assert given.sha256 != other.sha256


# tau/su = 0.8 + 0.1 log10(gamma/1 %) - 0.1 log10(N): the strain grows with N, as Miner's rule has it
MINER = "N,tau_cy/su,gamma_cy [%]\n" + "".join(
    f"{N},{0.8 + 0.1 * np.log10(g) - 0.1 * np.log10(N)},{g}\n" for N in (1, 1000) for g in (0.1, 1.0, 10.0)
)
STORM = 'parcels = "storm.csv", utilisation = 0.8'


@pytest.mark.parametrize(
    ("parcels", "number"),
    [
        ("3,1", 3.0), ("10,0.875\n3,1", 4.0), ("3,1\n10,0.875\n50,0.5", 4.0), ("40,0.875\n20,0.75\n2,1", 6.2),
        ("1,0.875\n1,1", 1.1), ("1,1\n1,1", 2.0), ("\n".join(["1,1"] * 5), 5.0),
    ],
)  # fmt: skip
def test_the_number_of_cycles_of_a_storm_accumulates_strain(tmp_path, parcels, number) -> None:
    """tau/su 0.8 at most: a cycle of 0.7 counts a tenth, one of 0.6 a hundredth, together at least one.

    One of 0.4 stays below 0.1 % and does not count.
    """
    (tmp_path / "storm.csv").write_text("N,load/largest\n" + parcels + "\n")
    given = scene(tmp_path, ("cycles = 10", STORM), MINER, SCENE.replace("600", "900"))
    assert given.ground.strata[0].tables["cyclic"].number == pytest.approx(number, rel=1e-6)
    assert parse_scene(given.source_text) == given and f"N {number:.4g}" in given.title


def test_cycles_that_do_not_count_are_stated_and_what_is_no_storm_is_refused(tmp_path) -> None:
    (tmp_path / "storm.csv").write_text("N,load/largest\n500,0.5\n3,1\n")
    given = scene(tmp_path, ("cycles = 10", STORM), MINER, SCENE.replace("600", "900"))
    assert given.ground.strata[0].tables["cyclic"].left_out == 500.0
    assert "N 3, tau_a/su 0, 500 cycles below the contours left out)" in given.title
    for table, other, words in (
        ("500,0.5\n3,0.6", STORM, "the largest load/largest 1"),
        ("3,1", STORM.replace("0.8", "0.1") + ", average = 0.1", "utilisation must be above average"),
        ("3,1", STORM.replace("0.8", "0.3"), "none reaches the first strain"),
    ):
        (tmp_path / "storm.csv").write_text(f"N,load/largest\n{table}\n")
        with pytest.raises(UserInputError, match=words):
            scene(tmp_path, ("cycles = 10", other), MINER, SCENE.replace("600", "900"))


@pytest.mark.parametrize(
    "parcels", ["80,0.857142857\n12,1", "\n".join(["8,0.857142857\n1.2,1"] * 10), "4,0.999999999\n16,1"]
)
def test_a_storm_from_contours_that_begin_late_is_that_from_all(tmp_path, parcels) -> None:
    """Strain grows in proportion to N here: contours from N = 10 give what those from N = 1 do, in parts, too."""
    (tmp_path / "storm.csv").write_text(f"N,load/largest\n{parcels}\n")
    rows = [line for line in MINER.splitlines() if not line.startswith("1,")]
    rows += [f"10,{0.7 + 0.1 * np.log10(g)},{g}" for g in (0.1, 1.0, 10.0)]
    for table in (MINER, "\n".join(rows)):
        given = scene(tmp_path, ("cycles = 10", STORM.replace("0.8", "0.7")), table, SCENE.replace("600", "900"))
        assert given.ground.strata[0].tables["cyclic"].number == pytest.approx(20.0, rel=1e-6)


@pytest.mark.parametrize(
    ("points", "words"),
    [
        ([(1, 0.2, 0.2), (1, 0.4, 0.4), (1, 0.6, 2.0)], "does not bend downwards at its first strain"),
        ([(1, 0.2, 0.2), (1, 0.45, 0.4), (1, 0.6, 2.0)], "does not bend downwards at its first strain"),
        ([(1, 0.4, 0.2), (1, 0.6, 1.0), (100, 0.6, 0.2), (100, 0.8, 1.0)], "contours of N 100 are above those of N 1"),
    ],
)
def test_contours_that_are_no_backbone_are_refused(tmp_path, points, words) -> None:
    table = "N,tau_cy/su,gamma_cy [%]\n" + "".join(f"{n},{t},{g}\n" for n, t, g in points)
    with pytest.raises(UserInputError, match=words):
        scene(tmp_path, ("cycles = 10", "cycles = 1"), table)


def test_parcels_that_leave_the_contours_are_refused(tmp_path) -> None:
    (tmp_path / "storm.csv").write_text("N,load/largest [%]\n5000,40\n30,100\n")
    with pytest.raises(
        UserInputError, match=r"cyclic: parcels: the row of load/largest 1, tau/su 0\.8 after 30 cycles: str"
    ):
        scene(tmp_path, ("cycles = 10", STORM), MINER)
    (tmp_path / "storm.csv").write_text("N,load/largest [%]\n5000,80\n3,100\n")
    words = r"row of load/largest 0\.8, .* after 5000 cycles: N is outside the contours of drammen.csv, 1 to 1000"
    with pytest.raises(UserInputError, match=words):
        scene(tmp_path, ("cycles = 10", STORM), MINER)
    (tmp_path / "storm.csv").write_text("N,load/largest [%]\n0.5,100\n")
    with pytest.raises(UserInputError, match=r"row of load/largest 1, .* after 0\.5 cycles: N is outside the contours"):
        scene(tmp_path, ("cycles = 10", STORM.replace("0.8", "0.7")), MINER)
    (tmp_path / "storm.csv").write_text("N,load/largest\n5,1.5\n")
    with pytest.raises(UserInputError, match=r"storm.csv:2: load/largest: 1.5 is not in \(0, 1\]"):
        scene(tmp_path, ("cycles = 10", STORM), MINER)
    (tmp_path / "storm.csv").write_text("N\n5\n")
    with pytest.raises(UserInputError, match=r"storm.csv:1: no column 'load/largest': parcels have N, load/largest"):
        scene(tmp_path, ("cycles = 10", STORM), MINER)
    with pytest.raises(UserInputError, match="or parcels and utilisation for cycles"):
        scene(tmp_path, ("cycles = 10", "cycles = 10, utilisation = 0.5"), MINER)


def test_the_number_of_cycles_may_have_a_range(tmp_path) -> None:
    scene(tmp_path, ("cycles = 10", "cycles = { low = 1000, best = 100, high = 10 }"))
    text = (tmp_path / "c.toml").read_text()
    found = [parse_scene(text, str(tmp_path / "c.toml"), [f"soil.estimate={each}"]) for each in ("low", "best", "high")]
    assert [curve(each)[-1][1] for each in found] == [0.53, 0.71, 0.924]
    assert found[0].title == "Storm (low estimate) (cyclic: drammen.csv, N 1000, tau_a/su 0)"


def test_check_prints_the_backbone(tmp_path) -> None:
    scene(tmp_path)
    text = command("check", tmp_path / "c.toml").out
    assert "su after cycles [kPa]" in text and "9.24" in text
    assert [line.split()[-2:] for line in text.splitlines() if "drammen.csv" in line][1:] == [
        [f"{100 * g:g}", f"{t:g}"] for g, t in zip(STRAINS, DRAMMEN[10], strict=True)]  # fmt: skip


@pytest.mark.parametrize(
    ("change", "table", "message"),
    [
        (("cycles = 10", "cycles = 5000"), None,
         "c.toml:8:10: soil.cyclic: cycles: 5000 is outside the contours, 1 to 1000"),
        (("cycles = 10", "cycles = 10, average = 0.3"), None, "average: 0.3 is outside the contours at N 10, 0 to 0"),
        (("cycles = 10", "cycles = 0.5"), None, "cycles: 0.5 is not in [1, 1e9]"),
        (("cycles = 10", "average = 0.3"), None, "for cycles, got one with contours, average"),
        (("drammen.csv", "none.csv"), None, "none.csv: no such file"),
        (("", ""), "N,tau_cy/su,gamma_cy\n1,0.5,0.5\n1,0.6,1\n", "drammen.csv:1: gamma_cy: has no unit: write"),
        (("", ""), "N,tau_cy/su\n1,0.5\n", "drammen.csv:1: no column 'gamma_cy'"),
        (("", ""), "N,tau_cy/su,gamma_cy [%]\n10,0.5,1\n10,,2\n", "drammen.csv:3: tau_cy/su: is blank"),
        (("", ""), "N,tau_cy/su,gamma_cy [%]\n10,0.5,1\n0,0.6,2\n", "drammen.csv:3: N: 0 is not in [1, 1e9]"),
        (("", ""), "N,tau_cy/su,gamma_cy [%]\n10,1.9,1\n10,2.2,2\n", "drammen.csv:3: tau_cy/su: 2.2 is not in [0, 2]"),
        (("", ""), "N,tau_cy/su,gamma_cy [%]\n10,0.5,1\n", "the curve of N 10, tau_a/su 0 needs two rows at least"),
        (("", ""), "N,tau_cy/su,gamma_cy [%]\n10,0.5,1\n10,0.4,3\n", "falls, or two of one strain, at 3 %"),
        (("", ""), "N,tau_cy/su,gamma_cy [%]\n10,0.5,1\n10,0.52,2\n10,0.9,3\n", "bends upwards at a strain of 2 %"),
        (("ratio = 600", "ratio = 100"), None, "is stiffer than G: G/su must be more than 120.6, not 100"),
        (('"iwan-clay"', '"tresca"'), None, 'soil.cyclic: is not used by law "tresca"'),
        (("cycles = 10 }", "cycles = 10 }\nstrain_at_half_strength = 0.01"), None,
         "cannot be used with strain_at_half_strength"),
        (("contours = \"drammen.csv\"", "contours = [[1, 2]]"), None, "rows of 5 numbers"),
    ],
)  # fmt: skip
def test_contours_that_give_no_backbone_are_refused_in_one_line(tmp_path, change, table, message) -> None:
    with pytest.raises(UserInputError) as error:
        scene(tmp_path, change, table)
    assert message in str(error.value) and "\n" not in str(error.value)


@pytest.mark.slow
def test_a_bucket_keeps_its_stiffness_and_has_the_load_of_its_contours(tmp_path) -> None:
    """D 8 m, L 6 m, load 8 m up, bonded: the table of docs/guide/ground.md at N 10.

    A polygon from 1e-5 through the same contours, with su set by hand, gave 1.392 MN at 3 % of D and 0.341 MN at 0.1 %,
    too soft below the first contour. Elastic soil of the same G has the initial stiffness.
    """
    path = '[[path]]\nname = "pull"\nkind = "pull"\narm = "8 m"\nlateral_displacement = "240 mm"\n'
    text = SCENE[: SCENE.index("[domain]")] + '[interface]\nadhesion_factor = 1.0\nopening = "bonded"\n' + path
    text += '[caisson]\nouter_diameter = "8 m"\nskirt_length = "6 m"\n[mesh]\npreset = "coarse"\n'
    given = scene(tmp_path, text=text)
    pull = paths_of(tiny.run(given), of_mesh=True)["pull"]
    u, H = np.asarray(pull["u"]), np.asarray(pull["H"])
    assert np.interp([0.008, 0.024, 0.08, 0.24], u, H) == pytest.approx([0.810e6, 1.112e6, 1.309e6, 1.400e6], rel=0.01)
    assert np.interp(0.24, u, H) == pytest.approx(1.392e6, rel=0.01)
    elastic = scene(tmp_path, ('cyclic = { contours = "drammen.csv", cycles = 10 }\n', ""), text=text)
    short = elastic.replace(paths=({**elastic.paths[0].model_dump(), "lateral_displacement": 2e-5},))
    first = paths_of(tiny.run(short), of_mesh=True)["pull"]
    assert H[1] / u[1] == pytest.approx(np.asarray(first["H"])[-1] / 2e-5, rel=0.01)
