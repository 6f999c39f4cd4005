# SPDX-License-Identifier: MIT
"""Scenes that are right: defaults, units, round trips, hashes, the scene files that come with the project."""

import copy
import json
import math
import pickle
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from pydantic import ValidationError

from pysprings.scene.by_depth import BySurface, Profile
from pysprings.scene.defaults import defaulted
from pysprings.scene.fields import Choice, Count, Field, Flag, Interval, Number, Quantity, field_of
from pysprings.scene.load import SECTIONS, load_scene, parse_scene
from pysprings.scene.model import Scene
from pysprings.scene.sections import PAPER_SOIL, Domain, Layer
from pysprings.scene.template import scene_schema, template_names, template_text
from tests.support import tiny
from tests.support.place import SCENES


def test_defaults_are_the_paper_s_drained_caisson() -> None:
    """Numbers from Cerfontaine, Charlier & Collin (2018), as the project's physics notes list them."""
    scene = tiny.sand()
    assert (scene.caisson.outer_diameter, scene.caisson.skirt_length) == (7.8, 4.0)
    assert (scene.caisson.skirt_thickness, scene.caisson.lid_thickness) == (0.1, 0.4)
    assert (scene.domain.radius, scene.domain.depth) == ("auto", "auto")
    soil = scene.soil
    assert (soil.young_modulus, soil.poisson_ratio, soil.K0) == (200e6, 0.3, 1.0)
    assert np.rad2deg(soil.friction_angle_initial) == pytest.approx(5, rel=1e-15)
    assert np.rad2deg(soil.friction_angle_final) == pytest.approx(30, rel=1e-15)
    assert (soil.hardening_parameter, soil.dilation_angle, soil.cohesion) == (0.005, None, None)
    assert (soil.effective_unit_weight, soil.surcharge) == (10.56e3, 10.56e3)
    assert soil.hydraulic_conductivity == 1e-4
    contact = scene.interface
    assert (contact.normal_stiffness, contact.shear_stiffness) == ("auto", "auto")  # 1e10 N/m3, see penalty
    assert (contact.friction_coefficient, contact.transversal_conductivity) == (0.5, 1e-8)
    assert contact.residual_aperture == 1e-5
    (path,) = scene.load_paths
    assert (path.kind, path.lateral_displacement, path.rate, path.report_at) == ("pull", 0.02, 5e-5, (2.5e-3,))
    assert (path.arm, path.heave, path.role) == (0.0, "free", "calibration")
    assert scene.drainage.mode == "drained"


def test_template_holds_every_default() -> None:
    """The commented template has every key, and the ground and the values by default of the paper's scene."""
    text = template_text("caisson")
    scene, paper = parse_scene(text), tiny.sand(springs={"reach": 0.02}, solver={"tolerance": 1e-4})
    own = {"soil", "title"}
    assert scene.model_dump(exclude=own) == paper.model_dump(exclude=own)
    assert scene.ground == paper.ground
    assert defaulted(scene) == []
    for name, model in SECTIONS.items():
        if name == "path":
            continue
        optional = {key for key, info in model.model_fields.items() if info.default in (None, ())} - {"report_at"}
        for key in set(model.model_fields) - optional:
            assert f"\n{key} = " in text, f"{name}.{key}"


@pytest.mark.parametrize("name", template_names())
def test_templates_load(name: str) -> None:
    text = template_text(name)
    assert text.startswith("#:schema ./pysprings.schema.json\n")
    assert parse_scene(text).source_text == text


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_example_scenes_load(path: Path) -> None:
    scene = load_scene(path)
    assert scene.source_text == path.read_text(encoding="utf-8")
    assert parse_scene(scene.to_toml()) == scene


def test_there_are_example_scenes() -> None:
    assert len(SCENES) >= 2


def test_units_are_converted() -> None:
    scene = tiny.parsed(
        '[soil]\nyoung_modulus = "0.15 GPa"\nfriction_angle_final = "0.6 rad"\n[[path]]\nname = "turn"\n'
        'kind = "rotation"\nrotation = "-1 deg"\nreport_at = ["-0.1 deg", "-5 mrad"]\n'
    )
    assert (scene.soil.young_modulus, scene.soil.friction_angle_final) == (150e6, 0.6)
    assert scene.paths[0].report_at == pytest.approx((-math.radians(0.1), -5e-3), rel=1e-15)


def test_hash_depends_on_values_only() -> None:
    one = tiny.parsed('[soil]\nyoung_modulus = "150 MPa"\n[caisson]\nskirt_length = "4 m"\n')
    same = tiny.parsed('# other\n[caisson]\nskirt_length = "4000 mm"\n[soil]\nyoung_modulus = "0.15 GPa"\n')
    assert one.sha256 == same.sha256
    assert one == same
    assert hash(one) == hash(same)
    assert tiny.sand().sha256 != one.sha256


def test_python_takes_units_and_si_numbers() -> None:
    scene = tiny.sand(
        soil={"young_modulus": "150 MPa", "cohesion": 5e3, "K0": np.float64(1)}, mesh={"azimuth": np.int64(16)}
    )
    assert (scene.soil.young_modulus, scene.soil.cohesion, scene.mesh.azimuth) == (150e6, 5e3, 16)
    assert type(scene.soil.K0) is float
    assert type(scene.mesh.azimuth) is int
    paths = [{"name": "a", "kind": "load", "lateral_force": "2 MN", "arm": 8, "report_at": [1e6, "1.5 MN"]}]
    assert tiny.sand(paths=paths).paths[0].report_at == (1e6, 1.5e6)
    assert tiny.sand(path=paths) == tiny.sand(paths=paths)


def test_python_gets_messages_with_units() -> None:
    with pytest.raises(ValidationError, match=r"0\.2 Pa is not in \[0\.001, 1e6\] MPa"):
        tiny.sand(soil={"young_modulus": 0.2})
    with pytest.raises(ValidationError, match=r"nan Pa is not in"):
        tiny.sand(soil={"young_modulus": math.nan})
    with pytest.raises(ValidationError, match=r"domain\.radius: 3\.9 m must be more than 1\.02 times"):
        tiny.sand(domain={"radius": 3.9})


def test_scene_is_frozen() -> None:
    scene = tiny.sand()
    with pytest.raises(ValidationError, match="frozen"):
        scene.soil.young_modulus = 1.0  # type: ignore[misc]
    with pytest.raises(ValidationError, match="frozen"):
        scene.title = "x"  # type: ignore[misc]


def test_replace_merges_validates_and_forgets_the_file() -> None:
    scene = tiny.parsed('title = "mine"\n[soil]\nK0 = 0.9\n')
    finer = scene.replace(mesh={"preset": "paper"}, soil={"young_modulus": "150 MPa"})
    assert (finer.title, finer.soil.K0, finer.soil.young_modulus) == ("mine", 0.9, 150e6)
    assert finer.mesh.preset == "paper"
    assert scene.mesh.preset == "coarse"
    assert 'preset = "paper"' in finer.source_text
    assert scene.source_text.startswith('title = "mine"\n[soil]')
    with pytest.raises(ValidationError, match='"papers" is not one of'):
        scene.replace(mesh={"preset": "papers"})


def test_copies_keep_everything() -> None:
    scene = tiny.parsed('title = "mine"\n')
    for twin in (pickle.loads(pickle.dumps(scene)), copy.deepcopy(scene), scene.model_copy()):
        assert twin == scene
        assert twin.source_text == 'title = "mine"\n'
    # a copy that pydantic changes without validation does not pass off the old text as its own
    assert scene.model_copy(update={"title": "other"}).source_text.startswith('title = "other"')


def test_ground_and_paths_are_found_once_and_anew_in_copies() -> None:
    scene = Scene(soil=PAPER_SOIL)
    assert scene.ground is scene.ground and "ground" not in scene.model_dump()
    softer = scene.model_copy(update={"soil": scene.soil.model_copy(update={"young_modulus": 1e6})})
    assert softer.ground.value("young_modulus", np.array(1.0)) == 1e6
    assert scene.model_copy(update={"domain": Domain(depth=20.0)}).ground.strata[-1].bottom == 20.0


def test_byte_order_mark_and_windows_line_ends(tmp_path: Path) -> None:
    file = tmp_path / "scene.toml"
    file.write_bytes(b"\xef\xbb\xbf" + tiny.grounded("[soil]\nK0 = 0.9\n").replace("\n", "\r\n").encode())
    assert load_scene(file).soil.K0 == 0.9
    assert load_scene(str(file)).soil.K0 == 0.9


@pytest.mark.parametrize(
    ("text", "inside", "outside"),
    [("[0, 0.5)", [0, 0.4999], [-1e-9, 0.5, math.nan]), ("(0, 1e3]", [1e-9, 1e3], [0, 1001, math.inf])],
)
def test_intervals(text: str, inside: list[float], outside: list[float]) -> None:
    interval = Interval(text)
    assert all(interval.holds(value) for value in inside)
    assert not any(interval.holds(value) for value in outside)


def test_interval_bounds_have_the_unit() -> None:
    degrees = Interval("[0, 30]")
    assert degrees.holds(math.radians(30), "deg")
    assert not degrees.holds(math.radians(30.001), "deg")


def test_parts_of_a_path_that_change_the_vertical_load() -> None:
    """Newtons and seconds, in TOML and in Python; other entries beside them stay what they are."""
    path = {"name": "a", "kind": "pull", "lateral_displacement": 5e-3, "role": "held-back"}
    texts = ["V 3 MN", "V -500 kN in 10 min", "rest 1 hour", "-1 mm"]
    scene = tiny.sand(paths=[path | {"then": texts}])
    assert [(then.value, then.time, then.load) for then in scene.paths[0].then] == [
        (None, None, 3e6), (None, 600.0, -5e5), (None, 3600.0, None), (-1e-3, None, None),
    ]  # fmt: skip
    assert parse_scene(scene.to_toml()) == scene
    assert '"V 3 MN"' in scene.to_toml() and '"V -0.5 MN in 600 s"' in scene.to_toml()
    assert (
        Scene.model_validate(scene.model_dump()) == Scene.model_validate(json.loads(scene.model_dump_json())) == scene
    )
    assert scene.sha256 != tiny.sand(paths=[path | {"then": texts[1:]}]).sha256


# --- round trip of random scenes ---


def values_of(field: Field) -> st.SearchStrategy[object]:
    """Draw values that a field accepts."""
    if isinstance(field, Flag):
        return st.booleans()
    if isinstance(field, Choice):
        return st.sampled_from(field.words)
    if isinstance(field, Count):
        return st.integers(field.low // field.multiple_of, field.high // field.multiple_of).map(
            lambda n: n * field.multiple_of
        )
    if isinstance(field, Quantity):
        return _numbers_in(field.interval).map(lambda x: f"{x!r} {field.unit}")
    if isinstance(field, Number):
        return _numbers_in(field.interval)
    if isinstance(field, BySurface):  # adhesion needs a soil that has some
        return st.sampled_from(field.words) if field.number is None else st.none()
    return st.text(alphabet='abc "\\é#', min_size=1).filter(str.strip)


def _numbers_in(interval: str) -> st.SearchStrategy[float]:
    """Draw numbers strictly inside an interval."""
    return st.floats(*map(float, Interval(interval).bounds), exclude_min=True, exclude_max=True)


@st.composite
def sections(draw: st.DrawFn) -> dict[str, object]:
    data: dict[str, object] = {"title": draw(values_of(field_of(Scene.model_fields["title"]))), "soil": PAPER_SOIL}
    for name in ("interface", "mesh", "output"):
        fields = {key: field_of(info) for key, info in SECTIONS[name].model_fields.items()}
        data[name] = draw(st.fixed_dictionaries({}, optional={key: values_of(field) for key, field in fields.items()}))
    mesh: dict[str, object] = data["mesh"]  # type: ignore[assignment]
    for key in ("azimuth",) if mesh.get("discretisation") == "fourier" else ("harmonics", "halvings"):
        mesh.pop(key, None)
    turn = draw(st.floats(1e-6, 0.5)) * draw(st.sampled_from([1, -1]))
    data["paths"] = [{"name": "p", "kind": "rotation", "rotation": turn, "report_at": [turn / 3, turn]}]
    return data


@settings(deadline=None, max_examples=60)
@given(sections())
def test_to_toml_is_read_back_exactly(data: dict[str, object]) -> None:
    scene = Scene.model_validate(data)
    again = parse_scene(scene.to_toml())
    assert again == scene
    assert again.sha256 == scene.sha256


# --- JSON schema ---


def test_schema_knows_every_key_and_no_other() -> None:
    schema = scene_schema()
    assert set(schema["properties"]) == {"title", *SECTIONS}
    for name, model in SECTIONS.items():
        table = schema["properties"][name]
        table = table["items"] if name == "path" else table
        assert set(table["properties"]) - {"profile", "estimate"} == {
            str(info.validation_alias or key) for key, info in model.model_fields.items()
        }
        assert table["additionalProperties"] is False
    assert schema["properties"]["path"]["items"]["required"] == ["name", "kind"]


def test_schema_speaks_of_toml_values() -> None:
    """Defaults and examples are what TOML holds; texts match their pattern; units and ranges are told."""
    soil = scene_schema()["properties"]["soil"]["properties"]
    modulus = soil["young_modulus"]
    assert soil["surcharge"]["default"] == "0 kPa"
    assert modulus["description"] == "Young modulus (in [0.001, 1e6] MPa)"
    assert re.match(modulus["pattern"], "200 MPa")
    assert not re.match(modulus["pattern"], "200")
    laws = ["drucker-prager", "van-eekelen", "elastic", "tresca", "von-mises", "iwan-clay", "iwan-sand", "sand"]
    assert soil["yield_surface"]["enum"] == laws
    assert soil["poisson_ratio"] == {
        "description": "Poisson ratio; 0.3 where not given, 0.495 of undrained clay (in [0, 0.5))",
        "type": "number",
        "minimum": 0.0,
        "exclusiveMaximum": 0.5,
    }


def test_examples_of_fields_are_valid() -> None:
    """An example that a message shows must itself be accepted."""
    for name, model in {**SECTIONS, "soil.layer": Layer}.items():
        for key, info in model.model_fields.items():
            if key == "layers":
                continue
            field = field_of(info)
            field = field.quantity if isinstance(field, Profile) else field
            if isinstance(field, Quantity):
                assert math.isfinite(field.number(field.example, bare=False)), f"{name}.{key}"
            if isinstance(field, Number):
                assert Interval(field.interval).holds(field.example), f"{name}.{key}"


def test_defaults_are_valid() -> None:
    """pydantic does not check defaults; validate each section's own dump."""
    for name, model in SECTIONS.items():
        if name != "path":
            assert model.model_validate(model().model_dump()) == model()
    assert Scene.model_validate(tiny.sand().model_dump()) == tiny.sand()
