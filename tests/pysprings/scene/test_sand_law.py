# SPDX-License-Identifier: MIT
"""The law "sand" in scenes: what follows from the density, what is refused, and a run through its softening."""

import numpy as np
import pytest

from fe_engine.soil import following, sand
from pysprings.core.errors import UserInputError
from pysprings.model.forecast.estimate import profile
from pysprings.model.soil_laws import engine_laws, soil_materials
from pysprings.scene.defaults import defaulted
from pysprings.scene.design_strength import StrengthFactors, with_design_strength
from pysprings.scene.load import parse_scene
from pysprings.springs.path import paths_of
from tests.support import tiny

TEXT = """
[soil]
yield_surface = "sand"
relative_density = 0.7
effective_unit_weight = "10 kN/m^3"
K0 = "auto"
surcharge = "5 kPa"
"""


def rows(text: str = TEXT, depth: float = 2.0) -> dict[str, float]:
    """The packed parameters of the engine's law at a depth."""
    materials, _ = soil_materials(parse_scene(text), np.array([[depth]]))
    packed = materials[0].parameters.reshape(-1)
    return dict(zip(sand.PARAMETERS, packed, strict=False)) | {
        name: packed[following.PARAMETERS.index(name)] for name in following.PARAMETERS[-5:]
    }


def test_density_and_stress_give_stiffness_and_mobilisation() -> None:
    """Brinkgreve et al. (2010) at p' = (1 + 2 K0)/3 25 kPa, K0 = 1 - sin 33 deg (Jaky)."""
    k0, found = 1.0 - np.sin(np.radians(33.0)), rows()
    pressure = (1.0 + 2.0 * k0) / 3.0 * 25e3
    assert engine_laws(parse_scene(TEXT))[0].name == "following"
    assert found["pressure"] == pytest.approx(pressure) and found["exponent"] == pytest.approx(0.7 - 0.7 / 3.2)
    assert found["shear"] == pytest.approx((60e6 + 68e6 * 0.7) * (pressure / 1e5) ** (0.7 - 0.7 / 3.2))
    assert found["degradation"] == pytest.approx(0.385 / 1.3e-4) and found["least"] == 0.2
    assert found["scale"] == pytest.approx(0.024 * np.exp(-0.44)) and found["phi_c"] == pytest.approx(np.radians(33.0))
    # the initial state is mobilised
    sine = sand.mobilised(parse_point(), sand.formulas.dilatancy_index(0.7, 10.0, pressure), found["kappa_0"])[0]
    assert sine == pytest.approx((1.0 - k0) / (1.0 + k0), rel=1e-6)


def parse_point() -> np.ndarray:
    materials, _ = soil_materials(parse_scene(TEXT), np.array([[2.0]]))
    return np.ascontiguousarray(materials[0].parameters.reshape(-1)[: len(sand.PARAMETERS)])


def test_what_is_given_takes_its_place() -> None:
    own = TEXT + 'shear_modulus = "50 MPa"\ndegradation_strain = 2e-4\nmobilisation_strain = 0.03\ncontraction = 0.1\n'
    found = rows(own)
    assert found["shear"] == pytest.approx(50e6) and found["exponent"] == 0.0
    assert found["degradation"] == pytest.approx(0.385 / 2e-4)
    assert found["scale"] == 0.03 and found["contraction"] == 0.1
    follows = {"reference": 100e6, "reference_stress": 100e3, "exponent": 0.4, "follows": "stress"}
    layers = ({"top": 0.0, "law": "sand", "relative_density": 0.7, "young_modulus": follows},)
    materials, _ = soil_materials(tiny.sand(soil={"layers": layers, "yield_surface": "sand"}), np.array([[2.0]]))
    assert materials[0].parameters.reshape(-1)[following.EXPONENT] == 0.4


def test_check_lists_what_follows_from_the_density() -> None:
    found = {row["key"]: row["value"] for row in defaulted(parse_scene(TEXT))}
    assert found["soil.critical_friction_angle"] == 33.0 and found["soil.softening_strain"] == 0.2
    assert found["soil.degradation_strain"] == pytest.approx(1.3e-4)
    assert found["soil.shear_modulus"] == "by density and stress"
    layers = ({"top": 0.0, "relative_density": {"top": 0.4, "bottom": 0.8, "to": 10.0}},)
    varies = tiny.sand(soil={"layers": layers, "yield_surface": "sand"})
    found = {row["key"]: row["value"] for row in defaulted(varies)}
    assert found["soil.degradation_strain"] == found["soil.mobilisation_strain"] == "by depth"
    assert profile(varies)[0]["degradation_strain"] == pytest.approx(1.6e-4)


def test_check_shows_the_peak_friction_angle_at_the_initial_stress() -> None:
    """Bolton (1986): I_R = 0.5 (10 - ln 100) - 1 = 1.697 at p' 100 kPa, phi = 33 deg + 3 I_R; I_R is 4 at most."""
    text = TEXT.replace("0.7", "0.5").replace('"auto"', "1.0").replace("5 kPa", "100 kPa")
    row = profile(parse_scene(text))[0]
    assert row["dilatancy_index"] == pytest.approx(1.697, abs=2e-3)
    assert (row["friction_angle_deg"], row["peak_friction_angle_deg"]) == pytest.approx((33.0, 38.09), abs=0.01)
    assert profile(parse_scene(TEXT))[0]["dilatancy_index"] == pytest.approx(4.0, abs=5e-3)


def test_the_density_may_vary_with_depth_and_layers_may_differ() -> None:
    text = TEXT.replace("relative_density = 0.7", "") + (
        '[[soil.layer]]\ntop = "0 m"\nrelative_density = { top = 0.4, bottom = 0.8, to = "4 m" }\n'
        '[[soil.layer]]\ntop = "4 m"\nlaw = "van-eekelen"\nfriction_angle_final = "36 deg"\nyoung_modulus = "80 MPa"\n'
    )
    scene = parse_scene(text)
    materials, number = soil_materials(scene, np.array([[1.0, 3.0], [5.0, 6.0]]))
    density = materials[0].parameters[0, :, sand.DENSITY]
    assert density == pytest.approx([0.5, 0.7]) and number.tolist() == [0, 1]
    assert [each.name for each in engine_laws(scene)[:2]] == ["following", "van-eekelen"]
    assert parse_scene(scene.to_toml()) == scene


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("relative_density = 0.7", "", 'missing; law "sand" needs it; such as relative_density = 0.7'),
        ("0.7", "70", "70 is not in [0.01, 1.2]"),
        ('"sand"', '"van-eekelen"', 'relative_density: is not used by law "van-eekelen": it is that of "sand"'),
        ('K0 = "auto"', "K0 = 0.05", "0.05 mobilises 64.79 deg of friction, of 41.3 deg at the peak: too much"),
        ('K0 = "auto"', 'K0 = "auto"\nfriction_angle_final = "35 deg"', 'is not used by law "sand"'),
        ('K0 = "auto"', 'K0 = "auto"\npoisson_ratio = 0.49', "0.4 is unstable with Poisson ratio 0.49: at most 0.0"),
        ('K0 = "auto"', 'K0 = "auto"\npoisson_ratio = 0.435', "0.4 is unstable with Poisson ratio 0.435: at most 0.3"),
        ('"5 kPa"', '"0 kPa"\neffective_unit_weight = "0 kN/m^3"', "has no strength"),
    ],
)
def test_what_cannot_be_is_refused(old: str, new: str, message: str) -> None:
    text = TEXT.replace('effective_unit_weight = "10 kN/m^3"\n', "") if "unit_weight" in new else TEXT
    with pytest.raises(UserInputError) as refused:
        parse_scene(text.replace(old, new, 1))
    assert message in str(refused.value)


def test_design_strength_is_refused_where_friction_has_no_key() -> None:
    with pytest.raises(UserInputError, match='law "sand" has no friction angle to divide'):
        with_design_strength(parse_scene(TEXT), StrengthFactors(tan_phi=1.25))
    assert pytest.approx(0.4554, abs=1e-4) == with_design_strength(parse_scene(TEXT), StrengthFactors(su=1.25)).soil.K0


@pytest.mark.slow
def test_a_small_model_softens_to_its_end() -> None:
    """A pull of a tenth of the skirt length, with viscosity beside a stiffness that follows and degrades."""
    soil = {"yield_surface": "sand", "relative_density": 0.9, "K0": 0.5, "surcharge": 5e3}
    path = {"name": "pull", "kind": "pull", "lateral_displacement": 0.3, "arm": 0.0}
    mesh = {"refinement": 0.4, "discretisation": "fourier", "harmonics": 2}
    scene = tiny.sand(soil=soil, paths=(path,), mesh=mesh, solver={"viscous_displacement": 1e-6})
    result = paths_of(tiny.run(scene))["pull"]
    assert result.attrs["status"] == "complete"
    load, motion = np.abs(np.asarray(result["H"])), np.asarray(result["u"])
    assert motion[-1] == pytest.approx(0.3) and load[-1] > 0.5 * load.max()
    late = motion > 0.05  # neighbouring steps
    assert np.abs(np.diff(load[late])).max() < 0.05 * load.max()
