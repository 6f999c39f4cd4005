# SPDX-License-Identifier: MIT
"""The atlas that ships: springs like those of a full model, laws of similarity, refusals, deviations."""

import json
import shlex
from dataclasses import replace

import numpy as np
import openpyxl
import pandas as pd
import pytest
import xarray as xr

import pysprings
from pysprings.cli.atlas import next_command
from pysprings.core.errors import UserInputError
from pysprings.core.tables.load_cases import read_load_cases
from pysprings.macro.comparison import compare
from pysprings.macro.comparison_text import to_text
from pysprings.macro.stiffness import stiffness
from pysprings.results.exporters import export
from pysprings.scene.changes import read_changes
from pysprings.scene.load import SceneText, parse_scene
from pysprings.scene.template import template_text
from pysprings.springs.checks import open_springs, save_springs, validate_springs
from pysprings.studies.atlas.between import Process, between, filled
from pysprings.studies.atlas.build import build, held_back_words
from pysprings.studies.atlas.model import write_atlas
from pysprings.studies.atlas.samples import Samples, factors, scenes
from pysprings.studies.design import answer_cases
from tests.support.commands import command


@pytest.fixture(scope="module")
def atlas():
    return pysprings.open_atlas("clay")


def springs(atlas, D, L, *changes):
    return atlas.springs(atlas.scene(D, L, read_changes(changes)))


@pytest.mark.slow
def test_springs_of_an_atlas_are_a_spring_file(atlas, tmp_path):
    made = springs(atlas, 9.0, 6.0)
    validate_springs(made)
    again = open_springs(save_springs(made, tmp_path / "springs.nc"))
    one, other = (pysprings.predict(each, H=1e6, arm=9.0) for each in (made, again))
    assert float(one["u"]) == float(other["u"]) > 0.0
    assert float(one["u_deviation"]) == float(other["u_deviation"]) > 0.0
    assert made.attrs["source"] == "atlas clay"


@pytest.mark.parametrize("name", ["clay", "clay-gap", "sand"])
def test_the_command_that_follows_an_atlas_runs_as_printed(name, tmp_path):
    """Of a base scene that is not among the cases it is the page, which takes any caisson of the atlas."""
    made, file = pysprings.open_atlas(name), tmp_path / "my atlas.nc"
    write_atlas(made, file)
    program, *words = shlex.split(next_command(made, file))
    done = command(*words, "--json")
    assert program == "pysprings" and done.code == 0 and len(json.loads(done.out)["states"]) > 1, done.err
    away = replace(made, inputs=made.inputs + 10.0)
    assert next_command(away, file) == f"pysprings explore --atlas '{file}'"


@pytest.mark.parametrize("name", ["clay", "clay-gap"])
def test_no_file_of_an_atlas_calls_its_rays_a_full_model(name, tmp_path):
    """What is handed over says where its numbers come from: in the head of the file, and as `export` prints it."""
    known = pysprings.open_atlas(name)
    made = springs(known, 9.0, 6.0)
    done = export(made, "openfast", tmp_path)
    head = (tmp_path / "caisson.txt").read_text()
    words = [f"the atlas {name} ({len(known.inputs)} full models), not of a full model of this caisson", "; w has none"]
    for text in (head, "\n".join(done.remarks)):
        assert [each for each in words if each in text] == words
    assert "against the full model" not in head and f"against the rays of the atlas {name}" in head
    assert f"atlas: {made.attrs['atlas'][:60]}" in head and "held back: largest errors on" in head
    assert "errors of lateral springs are not known" not in head
    export(made, "xlsx", tmp_path / "springs.xlsx")
    book = openpyxl.load_workbook(tmp_path / "springs.xlsx")
    cells = [text for sheet in book for row in sheet.values for text in row if "full model" in str(text)]
    about = "\n".join(str(row[1]) for row in book["About"].values if row[0] == "atlas")
    assert words[0] in about and "held back: largest errors on" in about and "initial stiffness: K_H" in about
    own = [f"({len(known.inputs)} full models)", f"full models: {len(known.inputs)};", "no full model"]
    assert cells and all(any(text in each for text in own) for each in cells)
    assert book["load-displacement"]["C3"].value == f"rays of the atlas {name} u [mm]"
    edge = "L/D: 0.3333 is outside the atlas (0.5 to 1.5)"
    export(known.springs(known.scene(9.0, 3.0), extrapolate=True), "xlsx", tmp_path / "beyond.xlsx")
    assert edge in [row[1] for row in openpyxl.load_workbook(tmp_path / "beyond.xlsx")["About"].values]
    assert stiffness(made).attrs["long_name"] == f"initial stiffness of the atlas {name} at the lid centre"
    assert f"full model: the rays of the atlas {name}, none of this caisson" in to_text(compare(made, "fan"))


def test_tables_of_an_atlas_have_no_sides_and_components(atlas, tmp_path):
    """An atlas has the reactions of both sides together: no table has p inside or the shear of it as 0."""
    made = springs(atlas, 9.0, 6.0)
    export(made, "csv", tmp_path / "py.csv"), export(made, "xlsx", tmp_path / "py.xlsx")
    table = pd.read_csv(tmp_path / "py.csv", low_memory=False)
    p, m = (table[table["family"] == family] for family in ("py", "mtheta"))
    assert set(p["side"]) == set(m["side"]) == {"net"} and set(p["component"]) == {"total"}
    sheets = pd.read_excel(tmp_path / "py.xlsx", sheet_name=["p-y", "m-theta"], header=2)
    for sheet, name in (("p-y", "p"), ("m-theta", "m")):
        heads = {head.partition(".")[0] for head in sheets[sheet] if head.startswith(f"{name} ")}
        assert heads == {"p net [kN/m]" if name == "p" else "m net [kN m/m]"}
    assert all("both sides" in made["paths/ray_0"][name].attrs["comment"] for name in ("p_component", "m", "t"))


def test_springs_with_fewer_states_have_the_deviations_of_those(atlas):
    from pysprings import Springs

    made = Springs.of(springs(atlas, 9.0, 6.0))
    fewer = made.with_paths(path.at_steps([*range(0, path.n - 1, 2), path.n - 1]) for path in made.paths.values())
    whole, part = (pysprings.predict(each, H=1.5e6, arm=9.0) for each in (made, fewer))
    assert float(part["u_deviation"]) == pytest.approx(float(whole["u_deviation"]), rel=0.3)


def test_a_caisson_of_twice_the_size_in_clay_of_twice_the_strength_is_similar(atlas):
    small = springs(atlas, 8.0, 6.0, "su=10 kPa", "gradient=2 kPa/m")
    large = springs(atlas, 16.0, 12.0, "su=20 kPa", "gradient=2 kPa/m")
    one, other = pysprings.predict(small, H=8e5, arm=8.0), pysprings.predict(large, H=8 * 8e5, arm=16.0)
    assert float(other["u"]) == pytest.approx(2.0 * float(one["u"]), rel=1e-6)
    assert float(other["rotation"]) == pytest.approx(float(one["rotation"]), rel=1e-6)


def test_motions_go_with_the_inverse_of_the_stiffness(atlas):
    one, other = (pysprings.predict(springs(atlas, 8.0, 6.0, f"G/su={k}"), H=8e5, arm=8.0) for k in (200, 400))
    assert float(one["u"]) == pytest.approx(2.0 * float(other["u"]), rel=1e-4)


def test_a_vertical_load_softens_the_lateral_springs(atlas):
    """Beside full models of `clay-pulls-scene.toml` under this V: H one diameter above mudline at u/D 0.1 %."""
    for V, known in {0: 606.1e3, 2: 555.0e3, 3: 512.8e3}.items():
        made = springs(atlas, 8.0, 4.0, "alpha=0.65", f"V={V} MN")
        assert float(pysprings.impose(made, u=0.008, arm=8.0)["H"]) == pytest.approx(known, rel=0.05)


@pytest.mark.parametrize(
    ("ground", "V", "known"),
    [
        (("su=12 kPa", "gradient=1.5 kPa/m"), "0 MN", -0.229e-3),
        (("su=100 kPa", "gradient=12.5 kPa/m"), "0 MN", -0.0275e-3),
        (("su=100 kPa", "gradient=12.5 kPa/m"), "5 MN", 1.272e-3),
    ],
)
def test_w_at_rest_is_that_of_the_weight_of_the_scene(atlas, ground, V, known):
    """Beside full models on `coarse` (D 9 m, L 6 m, G/su 300, alpha 0.65): w from the initial contact stress."""
    made = springs(atlas, 9.0, 6.0, *ground, "G/su=300", "alpha=0.65", f"V={V}")
    assert float(pysprings.predict(made, H=0.0)["w"]) == pytest.approx(known, rel=0.16)


def test_a_size_that_is_a_text_is_refused(atlas) -> None:
    with pytest.raises(UserInputError, match=r"D: .* is a text: give a number in SI units"):
        atlas.scene(D="9 m", L=6.0)


def test_an_answer_has_the_values_that_are_beyond_their_common_range(atlas):
    asked = {su: pysprings.predict(springs(atlas, 9.0, 6.0, f"su={su}"), H=1e5) for su in ("12 kPa", "12 MPa")}
    assert len(asked["12 kPa"].attrs["remarks"]) == 1
    assert "outside the common range 0.5 to 300 kPa: 1000 times too large?" in asked["12 MPa"].attrs["remarks"][-1]


def test_a_gap_outside_softens_the_springs_and_weight_closes_it():
    """Full models of the pulls-scenes of the studies under 1 MN, pulled at mudline, carry what stands here [N]."""
    gap, bonded = (pysprings.open_atlas(name) for name in ("clay-gap", "clay"))
    clay = ("su=10 kPa", "gradient=2 kPa/m", "G/su=300", "alpha=0.65", "V=1 MN")
    light, heavy = (springs(gap, 8.0, 4.0, *clay, f"gamma={weight} kN/m^3") for weight in (7, 12))
    bonded = springs(bonded, 8.0, 4.0, *clay)
    one, other, third = (float(pysprings.impose(each, u=0.04, arm=0.0)["H"]) for each in (light, heavy, bonded))
    assert one == pytest.approx(2103e3, rel=0.04) and other == pytest.approx(2268e3, rel=0.04)
    assert third == pytest.approx(2882e3, rel=0.03)


def test_a_vertical_load_of_the_command_is_that_of_the_caisson(atlas):
    asked = ("--D", "8 m", "--L", "4 m", "--set", "alpha=0.65", "--H", "500 kN", "--V", "2 MN", "--json")
    given = json.loads(command("predict", "--atlas", "clay", *asked).out)
    own = pysprings.predict(springs(atlas, 8.0, 4.0, "alpha=0.65", "V=2 MN"), H=5e5, V=2e6)
    assert given["states"][-1]["u"] == pytest.approx(float(own["u"]), rel=1e-9)
    assert "below 0.1 su/G, beyond the deviations" in given["attributes"]["remarks"][-1]
    for option, value in (("--rate", "1 mm/s"), ("--skirt-length", "9 m")):  # they had no effect
        refused = command("predict", "--atlas", "clay", *asked, option, value)
        assert refused.code == 2 and f"{option}: is not one of springs of an atlas" in refused.err
    assert command("predict", "--atlas", "clay", *asked, "--strict").code == 0
    assert command("predict", "--atlas", "clay-gap", *asked, "--strict").code == 0


CLAY_SCENE = """[caisson]
outer_diameter = "16 m"
skirt_length = "12 m"
skirt_thickness = "0.16 m"
vertical_load = "12 MN"
[soil]
yield_surface = "tresca"
undrained_shear_strength = { top = "20 kPa", gradient = "2.5 kPa/m" }
rigidity_ratio = 200
poisson_ratio = 0.49
effective_unit_weight = "7 kN/m^3"
[interface]
adhesion_factor = 0.65
opening = "bonded"
"""


def test_a_scene_without_layers_is_the_same_as_one_with_a_layer(atlas):
    """It was answered by an IndexError."""
    plain = parse_scene(CLAY_SCENE)
    layered = parse_scene(
        CLAY_SCENE.replace("undrained_shear", '[[soil.layer]]\ntop = "0 m"\nname = "a"\nundrained_shear', 1)
    )
    one, other = (pysprings.predict(atlas.springs(each), H=3e6, arm=20.0) for each in (plain, layered))
    assert float(one["u"]) == float(other["u"]) > 0.0


def test_clay_is_in_total_stress_whatever_form_the_base_scene_has(atlas):
    """An atlas of one's own whose base scene had no layers was marked as drained: no wider band near collapse."""
    own = replace(atlas, about={"mesh": atlas.about["mesh"], "drainage": "drained"})
    one, other = (pysprings.predict(springs(each, 9.0, 6.0), H=1.4e6, arm=9.0) for each in (own, atlas))
    assert one.attrs["drainage"] == other.attrs["drainage"] == "total-stress"
    assert float(one["u_deviation"]) == float(other["u_deviation"])


def test_short_names_are_those_of_the_base_scene_of_an_atlas_of_ones_own(atlas):
    """Without layers, or with a layer of another name: `--set su=...` asked for sections that nobody wrote."""
    layered = CLAY_SCENE.replace("yield_surface", '[[soil.layer]]\ntop = "0 m"\nname = "soft"\nlaw')
    for text in (CLAY_SCENE, layered):
        made = replace(atlas, text=SceneText(text)).scene(9.0, 6.0, read_changes(["G/su=400"]))
        assert made.ground.strata[0].values["rigidity_ratio"] == 400.0


def test_short_names_are_those_of_the_ground_of_a_scene_file(tmp_path):
    """Of a layer of any name, and of a soil without layers, in clay and in sand."""
    clay = CLAY_SCENE.replace('"12 MN"', '"6 MN"')
    layered = clay.replace("yield_surface", '[[soil.layer]]\ntop = "0 m"\nname = "soft clay"\nlaw')
    sand = pysprings.open_atlas("sand").scene(8.0, 6.0).to_toml()
    one, ground = 'surcharge = "4 kPa"\n', sand.partition("[soil]\n")[2].partition("\n\n")[0]
    layer = sand.replace(ground, f'{one}[[soil.layer]]\ntop = "0 m"\nname = "dense"\n{ground.replace(one, "")}')
    found = []
    for name, text, change in (("clay", clay, "su=30 kPa"), ("clay", layered, "su=30 kPa"),
                               ("sand", sand, "phi=40 deg"), ("sand", layer, "phi=40 deg")):  # fmt: skip
        (tmp_path / "own.toml").write_text(text, encoding="utf-8")
        asked = ("predict", tmp_path / "own.toml", "--atlas", name, "--H", "500 kN", "--json")
        plain, other = (json.loads(command(*asked, *more).out) for more in ((), ("--set", change)))
        found.append(other["states"][-1]["u"])
        assert found[-1] < 0.99 * plain["states"][-1]["u"]
    assert found[0] == found[1] and found[2] == found[3]


@pytest.mark.parametrize("name", ["clay", "clay-gap", "sand"])
@pytest.mark.parametrize(
    ("text", "words"),
    [
        (CLAY_SCENE.replace("poisson_ratio = 0.49\n", ""), "soil.poisson_ratio: the atlas holds for 0.49 alone"),
        (CLAY_SCENE.replace("rigidity_ratio = 200", 'shear_modulus = "5 MPa"'), "soil.layer.rigidity_ratio: missing"),
        (CLAY_SCENE.replace("rigidity_ratio = 200", 'shear_modulus = { top = "4 MPa", gradient = "1 MPa/m" }'),
         "soil.shear_modulus: the atlas holds for none alone, the scene has a value by depth"),
        (template_text("sand-over-clay"), "is tresca, that of the scene drucker-prager, tresca"),
        (template_text("paper-drained"), "is tresca, that of the scene drucker-prager"),
        (template_text("paper-drained").replace("drucker-prager", "elastic"), "is tresca, that of the scene elastic"),
    ],
)  # fmt: skip
def test_every_scene_is_answered_or_refused_by_every_atlas(name, text, words):
    with pytest.raises(UserInputError) as error:
        pysprings.open_atlas(name).springs(parse_scene(text))
    if name == "clay":
        assert words in str(error.value)


def test_scenes_that_the_atlas_does_not_cover_are_refused_all_at_once(atlas):
    with pytest.raises(UserInputError) as error:
        springs(atlas, 8.0, 6.0, "interface.opening=vented", "soil.layer.clay.poisson_ratio=0.3")
    assert {problem.key for problem in error.value.problems} == {"interface.opening", "soil.layer.poisson_ratio"}
    with pytest.raises(UserInputError, match=r"L/D: 0\.25 is outside the atlas \(0\.5 to"):
        springs(atlas, 8.0, 2.0)
    far = atlas.springs(atlas.scene(8.0, 3.5), extrapolate=True)
    with pytest.warns(UserWarning, match="outside the atlas"):
        pysprings.predict(far, H=1e5)
    with pytest.raises(UserInputError, match="outside the atlas"):
        pysprings.predict(far, H=1e5, strict=True)


def test_deviations_of_motion_and_of_load_belong_together(atlas):
    made = springs(atlas, 9.0, 6.0)
    moved = pysprings.impose(made, u=2e-5, arm=0.0)
    under = pysprings.predict(made, H=float(moved["H"]), arm=0.0)
    tangent = under["stiffness"].values[np.ix_([0, 2], [0, 2])]
    free_head = tangent[0, 0] - tangent[0, 1] * tangent[1, 0] / tangent[1, 1]
    assert float(moved["u_deviation"]) == float(under["H_deviation"]) == 0.0
    assert float(under["u_deviation"]) == pytest.approx(float(moved["H_deviation"]) / free_head, rel=1e-3)


# D, L, height of the load [m]; H [MN] and rotation [deg] of full models on the mesh `medium`, extrapolated (their own
# estimates are 1.4 to 1.7 %), at u/D of 0.05 to 1 %
FINER = {
    "su=8 kPa; gradient=2 kPa/m; G/su=300; alpha=0.5; caisson.vertical_load=1.5 MN": (
        (11.0, 8.25, 22.0), (0.5885, 0.8770, 1.3303, 1.5066, 1.5344), (0.0439, 0.0878, 0.2251, 0.4750, 1.0043),
    ),
    "su=20 kPa; gradient=2.5 kPa/m; G/su=200; alpha=0.65; caisson.vertical_load=6 MN": (
        (16.0, 12.0, 32.0), (1.9303, 3.5569, 5.7083, 7.0733, 7.3709), (0.0442, 0.0888, 0.2242, 0.4706, 1.0278),
    ),
    "su=30 kPa; gradient=1 kPa/m; G/su=500; alpha=0.8; caisson.vertical_load=2 MN": (
        (7.0, 7.0, 14.0), (0.8162, 1.3423, 1.7324, 1.7697, 1.7761), (0.0354, 0.0718, 0.2022, 0.4427, 0.9293),
    ),
}  # fmt: skip
AT = np.array([5e-4, 1e-3, 2.5e-3, 5e-3, 1e-2])  # u/D


@pytest.mark.parametrize("ground", FINER)
def test_finer_full_models_lie_within_the_deviations(atlas, ground):
    """Loads at their motions, within 6 %, and rotations under their loads, which are bounded under small ones."""
    (D, L, arm), H, rotation = FINER[ground]
    made, H = springs(atlas, D, L, *ground.split("; ")), 1e6 * np.array(H)
    moved = [pysprings.impose(made, u=share * D, arm=arm) for share in AT]
    loads, deviation = (np.array([float(each[name]) for each in moved]) for name in ("H", "H_deviation"))
    assert (np.abs(loads - H) <= np.minimum(1.96 * deviation, 0.06 * H)).all()
    batch = pysprings.predict_batch(made, H=H, arm=arm)
    answered = batch["answered"].values == 1
    band = 1.96 * np.degrees(batch["rotation_deviation"].values)
    assert (np.abs(np.degrees(batch["rotation"].values) - rotation) <= band)[answered].all()
    assert answered[:4].all() and batch["unbounded"].values[[0, 1, -1]].tolist() == [0, 0, 1]
    assert np.isfinite(band[:2]).all()


def test_an_atlas_of_extrapolated_studies_alone_is_not_marked_for_its_mesh(atlas, tmp_path):
    assert atlas.about["mesh"].endswith(", extrapolated")
    worse = replace(atlas, about={**atlas.about, "mesh": atlas.about["mesh"].removesuffix(", extrapolated")})
    marked, plain = (springs(each, 9.0, 6.0) for each in (worse, atlas))
    words = "made on one mesh, 'coarse', whose error the deviations do not have"
    assert words in marked.attrs["atlas_mesh"] and plain.attrs["atlas_mesh"] == ""
    assert plain.attrs["K_H_relative_deviation"] > 0.003
    assert pysprings.predict(plain, H=4e5, arm=9.0, strict=True)["u"] > 0.0
    head = export(marked, "openfast", tmp_path).remarks
    assert any(words in each for each in head)
    (tmp_path / "cases.csv").write_text("name,H [kN],arm [m]\nstorm,400,9\n")
    answers = answer_cases(marked, read_load_cases(tmp_path / "cases.csv"))
    assert answers["verdict"].tolist() == ["supported in part"] and words in answers["marks"][0]
    with pytest.raises(UserInputError, match="strict: made on one mesh"):
        pysprings.predict(marked, H=4e5, arm=9.0, strict=True)


def test_an_input_that_is_the_same_in_all_cases_stays_as_it_is(atlas):
    """An atlas of one alpha without V, of what the one that ships expects: it is the same, and refuses other alpha."""
    D, family = 8.0, atlas.family
    lengths, gradients = (each.ravel() for each in np.meshgrid([5.0, 6.0, 7.0, 8.0], [0.0, 1.0, 2.0, 3.0, 4.0]))
    made = [atlas.scene(D, L, read_changes([f"gradient={k} kPa/m"])) for L, k in zip(lengths, gradients, strict=True)]
    found, sizes = [atlas.estimate(each) for each in made], [family.sizes(each) for each in made]
    force, ratio = (np.array([getattr(each, name) for each in sizes]) for name in ("force", "ratio"))
    stiffness = factors(np.stack([each.stiffness for each in found]), force, ratio, np.full(20, D), lengths)
    own, _ = build(Samples(
        atlas.text, np.stack([family.read(each) for each in made]), atlas.rays, atlas.angles, atlas.X,
        np.stack([each.values for each in found]), stiffness, np.zeros(20), atlas.reach,
    ), family)  # fmt: skip
    scene = atlas.scene(D, 6.5, read_changes(["gradient=1.5 kPa/m"]))
    here, there = (each.estimate(scene) for each in (own, atlas))
    np.testing.assert_allclose(here.stiffness, there.stiffness, rtol=2e-3, atol=1.0)
    np.testing.assert_allclose(here.values, there.values, atol=0.01 * np.abs(there.values).max())
    with pytest.raises(UserInputError, match=r"alpha: 0\.8 is outside the atlas"):
        own.estimate(atlas.scene(D, 6.5, read_changes(["alpha=0.8"])))


def test_a_check_says_what_it_has_no_answer_to():
    rows = [{"case": k, "quantity": "H", "u_over_D": 0.01, "error_pct": -k, "inside": 1.0} for k in (1, 2)]
    assert held_back_words(pd.DataFrame(rows)) == "largest errors on 2 caissons: H at u/D 0.01 2 %"
    beyond = [{"case": 3, "quantity": "all", "why_not": "L/D: 2 is outside the atlas"}]
    assert held_back_words(pd.DataFrame([*rows, *beyond])).endswith("H at u/D 0.01 2 %; 1 without an answer")


def test_cases_of_a_study_may_have_words():
    """A table of cases with a title a case, or a law."""
    axes = {"title": ("case", ["one", "two"]), "length": ("case", [500.0, 600.0], {"units": "cm"})}
    attrs = {"axes": "title, length", "axis_keys": "title; caisson.skirt_length"}
    found = scenes(xr.Dataset(axes, attrs=attrs), SceneText(template_text("soft-clay")))
    assert [(each.title, each.caisson.skirt_length) for each in found] == [("one", 5.0), ("two", 6.0)]


def test_a_process_without_one_value_is_what_left_out_says():
    generator = np.random.default_rng(1)
    points, values = generator.random((12, 2)), generator.random(12)
    kernel = (0.0, 1.0, 2.0, np.array([0.5, 0.8]), 1e-3)
    mean, deviation = Process(points, values, *kernel).left_out()
    for k in (0, 7):
        rest = np.arange(12) != k
        alone = Process(points[rest], values[rest], *kernel).at(points[k])
        assert (mean[k], deviation[k]) == pytest.approx(alone, rel=1e-8)


def test_what_is_missing_is_filled_from_the_neighbours():
    points = np.linspace(0.0, 1.0, 9)[:, None]
    whole = np.concatenate([1.0 + points, points**2], axis=1)
    known = whole.copy()
    known[4, 0] = np.nan
    again = filled(points, known)
    assert again[4, 0] == pytest.approx(1.5, abs=1e-3)
    assert np.array_equal(again[:, 1], whole[:, 1])


def test_rays_in_between_follow_a_potential():
    """Loads of W = sqrt(1 + q) - 1, q = u^2 + 2 v^2 + u v: elastic at first, conical at last."""
    angles = np.radians([-60.0, -40.0, -20.0, 0.0])
    rho = np.concatenate([[0.0], np.geomspace(0.01, 20.0, 40)])
    elastic = np.array([[1.0, 0.5], [0.5, 2.0]])

    def loads(angle):
        motion = rho * np.array([[np.cos(angle)], [np.sin(angle)]])
        q = (motion * (elastic @ motion)).sum(axis=0)
        return elastic @ motion / np.sqrt(1.0 + q)

    rows = np.stack([loads(angle) for angle in angles])
    made, modes, found = between(rows, np.zeros((0, *rows.shape)), np.eye(2), angles, rho)
    assert found.size == 4 + 2 * 3 and modes.shape == (2, *made.shape)
    for row, angle in zip(made, found, strict=True):
        exact = loads(angle)
        assert np.abs(row - exact).max() < 2e-3 * np.abs(exact).max()
