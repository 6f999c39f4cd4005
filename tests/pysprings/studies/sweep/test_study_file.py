# SPDX-License-Identifier: MIT
"""Study files: axes, samples and tables of cases; what is wrong with them, all at once."""

import numpy as np
import pytest

from pysprings.core.errors import UserInputError
from pysprings.studies.sweep.study_file import read_study
from tests.support import tiny

GRID = """
scene = "base.toml"
[[axis]]
key = "soil.young_modulus"
values = ["100 MPa", "200 MPa"]
[[axis]]
key = "interface.friction_coefficient"
name = "mu"
from = 0.3
to = 0.6
count = 3
"""
SAMPLE = """
scene = "base.toml"
[sampling]
method = "latin-hypercube"
cases = 16
seed = 3
[[axis]]
key = "soil.young_modulus"
from = "50 MPa"
to = "0.2 GPa"
spacing = "log"
[[axis]]
key = "interface.friction_coefficient"
from = 0.3
to = 0.6
"""


@pytest.fixture
def study(tmp_path):
    tiny.write(tiny.scene(), tmp_path / "base.toml")

    def read(text, **files):
        for name, content in files.items():
            (tmp_path / f"{name}.csv").write_text(content, encoding="utf-8")
        (tmp_path / "study.toml").write_text(text, encoding="utf-8")
        return read_study(tmp_path / "study.toml")

    return read


def refusals(study, text, **files):
    with pytest.raises(UserInputError) as error:
        study(text, **files).checked()
    return [(problem.line, problem.key, problem.message) for problem in error.value.problems]


def test_a_grid_has_all_combinations_and_each_changes_the_scene(study):
    plan = study(GRID)
    assert [case.values for case in plan.cases[:4]] == [
        ("100 MPa", 0.3), ("100 MPa", 0.45), ("100 MPa", 0.6), ("200 MPa", 0.3),
    ]  # fmt: skip
    assert plan.is_grid and len(plan.cases) == 6
    scene = plan.scene_of(plan.cases[4])
    assert scene.soil.young_modulus == 200e6 and scene.interface.friction_coefficient == 0.45
    assert len(set(plan.checked()[0])) == 6


def test_a_sample_fills_every_row_of_the_hypercube_once_and_repeats_with_its_seed(study):
    plan, same = study(SAMPLE), study(SAMPLE)
    assert [case.values for case in plan.cases] == [case.values for case in same.cases]
    other = study(SAMPLE.replace("seed = 3", "seed = 4"))
    assert [case.values for case in plan.cases] != [case.values for case in other.cases]
    stiffness = np.array([float(case.values[0].split()[0]) for case in plan.cases])
    shares = np.log(stiffness / 50.0) / np.log(4.0)
    assert sorted(np.floor(16 * shares).astype(int)) == list(range(16))
    assert {case.values[0].split()[1] for case in plan.cases} == {"MPa"}


ONE = 'scene = "ranged.toml"\n[sampling]\nmethod = "one-at-a-time"\n'
RANGED = """
[soil]
yield_surface = "tresca"
rigidity_ratio = { low = 100, best = 200, high = 300 }
effective_unit_weight = "8 kN/m^3"
[[soil.layer]]
top = "0 m"
name = "soft clay"
undrained_shear_strength = { low = "8 kPa", best = "10 kPa", high = "13 kPa" }
[[soil.layer]]
top = "4 m"
undrained_shear_strength = { low = { top = "20 kPa", bottom = "30 kPa" }, best = "30 kPa", high = "40 kPa" }
[domain]
depth = "20 m"
radius = "30 m"
[interface]
adhesion_factor = 0.65
[[path]]
name = "a"
kind = "pull"
lateral_displacement = "1 mm"
"""


@pytest.mark.parametrize("estimate", ["", 'estimate = "best"\n'])
def test_one_at_a_time_goes_through_the_ranges_of_a_scene(study, tmp_path, estimate):
    text = RANGED.replace("[soil]\n", f"[soil]\n{estimate}", 1)
    (tmp_path / "ranged.toml").write_text(text, encoding="utf-8")
    plan = study(ONE)
    names = ["rigidity_ratio", "soft_clay_undrained_shear_strength", "layer_2_undrained_shear_strength"]
    assert [axis.name for axis in plan.axes] == names and not plan.is_grid
    assert [case.values for case in plan.cases] == [
        ("best", "best", "best"), ("low", "best", "best"), ("high", "best", "best"), ("best", "low", "best"),
        ("best", "high", "best"), ("best", "best", "low"), ("best", "best", "high")]  # fmt: skip
    strata = [plan.scene_of(case).ground.strata for case in plan.cases]
    assert [each[0].values["rigidity_ratio"] for each in strata[:4]] == [200.0, 100.0, 300.0, 200.0]
    assert [each[0].values["undrained_shear_strength"] for each in strata[3:6]] == [8e3, 13e3, 10e3]
    assert strata[5][1].values["undrained_shear_strength"].top == 20e3 and len(set(plan.checked()[0])) == 7


@pytest.mark.parametrize(
    ("change", "text", "message"),
    [
        (("", ""), ONE + "[[axis]]\n", "one-at-a-time varies the ranges of the scene: no [[axis]]"),
        (("soft clay", "2"), ONE, "the name \"2\" is the number of another one"),
        (("", ""), ONE.replace("ranged", "base"), "no value of the scene has a range { low, best, high }"),
    ],
)  # fmt: skip
def test_ranges_that_cannot_be_taken_one_at_a_time(study, tmp_path, change, text, message):
    (tmp_path / "ranged.toml").write_text(RANGED.replace(*change), encoding="utf-8")
    assert any(message in each for _, _, each in refusals(study, text))


def test_layers_whose_names_begin_alike_are_taken_one_at_a_time_by_their_numbers(study, tmp_path):
    """The second was `silty_clay_o_undrained_shear_strength_3`: no reader of a tornado could name its layer."""
    text = RANGED.replace('top = "4 m"\n', 'top = "4 m"\nname = "silty clay of the lower formation"\n')
    text = text.replace("soft clay", "silty clay of the upper formation")
    (tmp_path / "ranged.toml").write_text(text, encoding="utf-8")
    own = [axis.name for axis in study(ONE).axes[1:]]
    assert own == ["layer_1_undrained_shear_strength", "layer_2_undrained_shear_strength"]


def test_layers_of_one_name_are_taken_one_at_a_time_by_their_numbers(study, tmp_path):
    """A sounding through sand, clay and sand names two layers alike."""
    text = RANGED.replace('top = "4 m"\n', 'top = "4 m"\nname = "soft clay"\n')
    (tmp_path / "ranged.toml").write_text(text, encoding="utf-8")
    plan = study(ONE)
    own = [axis.name for axis in plan.axes[1:]]
    assert own == ["layer_1_undrained_shear_strength", "layer_2_undrained_shear_strength"]
    low = plan.scene_of(plan.cases[3]).ground.strata
    assert low[0].values["undrained_shear_strength"] == 8e3
    assert low[1].values["undrained_shear_strength"] == 30e3


def test_a_table_has_a_scene_key_a_column(study):
    text = 'scene = "base.toml"\ncases = "mine.csv"\n'
    plan = study(text, mine="id,soil.young_modulus [MPa],interface.friction_coefficient\n1,80,0.4\n2,90,0.5\n")
    assert [case.values for case in plan.cases] == [("80 MPa", 0.4), ("90 MPa", 0.5)]
    assert plan.scene_of(plan.cases[1]).soil.young_modulus == 90e6
    decimal = study(text, mine="soil.young_modulus [MPa];interface.friction_coefficient\n80,5;0,4\n")
    assert decimal.cases[0].values == ("80.5 MPa", 0.4)


def test_all_faults_of_a_study_come_at_once_with_their_lines(study):
    text = 'scene = "base.toml"\nkeeep = 1\n[[axis]]\nkey = "soil.K0"\nfrom = 2\nto = 1\ncount = 1\n'
    text += "[[axis]]\nvalues = []\n"
    assert refusals(study, text) == [
        (2, "keeep", "unknown key (did you mean 'keep'?)"),
        (6, "axis.1.to", "must be above from (2)"),
        (7, "axis.1.count", "1 is not in [2, 1000000]"),
        (8, "axis.2.key", 'expected a key of the scene such as "caisson.skirt_length"'),
    ]


def test_values_that_the_scene_refuses_stand_at_their_axis(study):
    text = GRID.replace('"200 MPa"]', '"200 m"]').replace("to = 0.6", "to = 9")
    found = refusals(study, text)
    assert [line for line, _, _ in found] == [5, 9]
    assert "expected a pressure or stress" in found[0][2] and "9 is not in [0, 5]" in found[1][2]


def test_values_of_a_table_that_the_scene_refuses_stand_at_their_row(study):
    found = refusals(study, 'scene = "base.toml"\ncases = "mine.csv"\n', mine="soil.poisson_ratio\n0.3\n0.7\n")
    assert found == [(3, "soil.poisson_ratio", "case 00002: 0.7 is not in [0, 0.5)")]
    titled = "Site A,\n\nid,soil.poisson_ratio\n1,0.3\n\n2,0.7\n"
    (below,) = refusals(study, 'scene = "base.toml"\ncases = "mine.csv"\n', mine=titled)
    assert below[0] == 6


def test_an_axis_has_no_name_of_the_files_of_a_study(study):
    """Of a vertical load "V", of a rotation "rotation" by default: no dataset could be written after the last case."""
    for text in (GRID.replace('name = "mu"', 'name = "V"'), GRID.replace('name = "mu"', 'name = "reason"')):
        ((_, key, message),) = refusals(study, text)
        assert key == "axis.2.name" and "is taken by the files of a study" in message


@pytest.mark.parametrize("other", ["soil.young_modulus", "soil"])
def test_a_value_has_one_axis(study, other):
    """Of two the last would count, under the values of both."""
    found = refusals(study, f'{GRID}\n[[axis]]\nkey = "{other}"\nname = "other"\nvalues = ["50 MPa"]\n')
    assert found and all("has a value already: each key takes one" in message for _, _, message in found)
    mine = "soil.young_modulus [MPa],soil.young_modulus [kPa]\n80,90\n"
    with pytest.raises(UserInputError, match=r"soil\.young_modulus"):
        study('scene = "base.toml"\ncases = "mine.csv"\n', mine=mine).checked()


def test_unknown_keys_of_the_scene_are_refused(study):
    (line, _, message), *_ = refusals(study, GRID.replace("soil.young_modulus", "soil.young_modulu"))
    assert line == 5 and "did you mean 'young_modulus'" in message


@pytest.mark.parametrize(
    "change, words",
    [
        (('method = "latin-hypercube"', 'method = "sobol"'), '"sobol" is not one of "latin-hypercube"'),
        (("seed = 3\n", ""), "missing"),
        (('to = "0.2 GPa"', 'to = "2 m"'), "units of different quantities"),
        (('from = "50 MPa"', 'from = "-1 MPa"'), "must be positive"),
    ],
)
def test_samples_that_are_none(study, change, words):
    found = refusals(study, SAMPLE.replace(*change))
    assert len(found) == 1 and words in found[0][2]
