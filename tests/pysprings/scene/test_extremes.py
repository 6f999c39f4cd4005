# SPDX-License-Identifier: MIT
"""The extremes a scene may hold are accepted and give a sound model; one step further is refused with the range."""

import json
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from fe_engine.conventions import OK
from fe_engine.soil import formulas, lode, plasol, van_eekelen
from fe_engine.soil.law import Point
from pysprings.core.errors import UserInputError
from pysprings.model.build import build_model
from pysprings.model.stages import path_stages, scene_warnings
from pysprings.scene.soils.friction import MOST_CONTRACTION, VAN_EEKELEN
from tests.support import tiny

PULL = {"name": "a", "kind": "pull", "lateral_displacement": "20 mm"}
WATER = {"drainage": {"mode": "coupled"}}
TURNS = [f"{sign}20 mm" for _ in range(10) for sign in ("-", "")]

EXTREMES: dict[str, dict[str, Any]] = {
    "soft contact": {"interface": {"normal_stiffness": "1e7 N/m^3", "shear_stiffness": "1e7 N/m^3"}},
    "hard contact": {"interface": {"normal_stiffness": "1e14 N/m^3", "shear_stiffness": "1e14 N/m^3"}},
    "unequal contact": {"interface": {"normal_stiffness": "1e12 N/m^3", "shear_stiffness": "1e8 N/m^3"}},
    "unequal contact, the other way": {"interface": {"normal_stiffness": "1e8 N/m^3", "shear_stiffness": "1e12 N/m^3"}},
    "smooth": {"interface": {"friction_coefficient": 0}},
    "almost smooth": {"interface": {"friction_coefficient": 1e-4}},
    "rough": {"interface": {"friction_coefficient": 2}},
    "phi 45": {"soil": {"friction_angle_final": "45 deg"}},
    "no hardening": {"soil": {"friction_angle_initial": "30 deg"}},
    "hardens at once": {"soil": {"hardening_parameter": 1e-6}},
    "hardly hardens": {"soil": {"hardening_parameter": 1}},
    "van eekelen": {"soil": {"yield_surface": "van-eekelen", "dilation_angle": "10 deg"}},
    "associated": {"soil": {"dilation_angle": "30 deg"}},
    "contracts": {"soil": {"dilation_angle": "-10 deg"}},
    "no weight above": {"soil": {"cohesion": "0 kPa", "surcharge": "0 kPa"}},
    "rock": {"soil": {"cohesion": "1 MPa"}},
    "mud": {"soil": {"young_modulus": "1 MPa"}},
    "stone": {"soil": {"young_modulus": "100 GPa"}},
    "nu 0": {"soil": {"poisson_ratio": 0}},
    "nu 0.499": {"soil": {"poisson_ratio": 0.499}},
    "K0 0.3": {"soil": {"K0": 0.3, "friction_angle_initial": "35 deg", "friction_angle_final": "40 deg"}},
    "K0 3": {"soil": {"K0": 3, "friction_angle_initial": "30 deg"}},
    "clay": {"soil": {"hydraulic_conductivity": "1e-14 m/s"}, **WATER, "path": [PULL | {"rate": "1e-10 m/s"}]},
    "gravel": {"soil": {"hydraulic_conductivity": "1 m/s"}, **WATER, "path": [PULL | {"rate": "1 m/s"}]},
    "tight film": {
        "interface": {"residual_aperture": "1e-9 m", "transversal_conductivity": "1e-18 m/(Pa s)"},
        **WATER,
        "path": [PULL | {"rate": "0.05 mm/s"}],
    },
    "wide film": {
        "interface": {"residual_aperture": "1e-3 m", "transversal_conductivity": "1e-3 m/(Pa s)"},
        **WATER,
        "path": [PULL | {"rate": "0.05 mm/s"}],
    },
    "short first step": {**WATER, "path": [PULL | {"duration": "1e3 s"}], "solver": {"first_step_fraction": 1e-12}},
    "long first step": {
        **WATER,
        "path": [PULL | {"duration": "1e3 s"}],
        "solver": {"first_step_fraction": 1, "max_step_fraction": 1},
    },
    "L/D 0.1": {"caisson": {"skirt_length": "0.78 m"}},
    "L/D 1": {"caisson": {"skirt_length": "7.8 m"}},
    "L/D 3": {"caisson": {"skirt_length": "23.4 m"}, "domain": {"depth": "50 m"}},
    "thin skirt": {"caisson": {"skirt_thickness": "5 mm"}},
    "thick skirt": {"caisson": {"skirt_thickness": "0.5 m"}},
    "long push": {"path": [PULL | {"lateral_displacement": "0.5 m"}]},
    "ten cycles": {"path": [PULL | {"role": "held-back", "then": TURNS}]},
    "pull-out": {"caisson": {"vertical_load": "-5 MN"}},
    "narrow domain": {"domain": {"radius": "4.0 m"}},
    "shallow domain": {"domain": {"depth": "4.1 m"}},
    "wide domain": {"domain": {"radius": "10 km", "depth": "10 km"}},
    "pancake": {"caisson": {"outer_diameter": "100 m", "skirt_length": "0.1 m"}, "domain": {"radius": "150 m"}},
    "needle": {"caisson": {"outer_diameter": "1 m", "skirt_length": "100 m"}, "domain": {"depth": "200 m"}},
}


def as_toml(sections: dict[str, Any]) -> str:
    """Write sections as TOML."""
    lines = []
    for name, section in sections.items():
        for table in section if name == "path" else [section]:
            lines.append(f"[[{name}]]" if name == "path" else f"[{name}]")
            lines += [f"{key} = {json.dumps(value)}" for key, value in table.items()]
    return "\n".join(lines) + "\n"


GEOMETRY = [name for name, sections in EXTREMES.items() if {"caisson", "domain"} & set(sections)]


@pytest.mark.parametrize(
    ("name", "preset"), [*((name, "coarse") for name in EXTREMES), *((name, "medium") for name in GEOMETRY)]
)
def test_extremes_are_accepted_and_give_a_sound_model(name: str, preset: str) -> None:
    scene = tiny.parsed(as_toml(EXTREMES[name])).replace(mesh={"preset": preset})
    assert tiny.parsed(scene.to_toml()) == scene
    built = build_model(scene)
    assert built.quality.min_jacobian > 0.0
    model = built.model
    for array in (model.mesh.nodes, model.initial_stress, model.initial_pressure, model.contact):
        assert np.isfinite(array).all()
    for path in scene.paths:
        stages = path_stages(scene, path, built.extra_load, 1.0)
        assert all(np.isfinite(stage.target).all() and np.isfinite(stage.duration) for stage in stages)
        assert all(0.0 < stage.first_fraction <= 1.0 and 0.0 < stage.max_fraction <= 1.0 for stage in stages)


@pytest.mark.parametrize(
    ("section", "key", "value", "words"),
    [
        ("interface", "normal_stiffness", '"1e-300 N/m^3"', '"1e-300 N/m^3" is not in [1e3, 1e16] N/m^3'),
        ("interface", "residual_aperture", '"1e-300 m"', '"1e-300 m" is not in [1e-9, 100] mm'),
        ("interface", "transversal_conductivity", '"1e-30 m/(Pa s)"', "is not in [1e-24, 1] m/(Pa s)"),
        ("soil", "hydraulic_conductivity", '"1e-300 m/s"', "is not in [1e-20, 10] m/s"),
        ("soil", "hardening_parameter", "1e-300", "1e-300 is not in [1e-9, 10]"),
        ("soil", "K0", "1e-300", "1e-300 is not in [0.01, 10]"),
        ("soil", "dilation_angle", '"-31 deg"', '"-31 deg" is not in [-30, 60] deg'),
        ("caisson", "skirt_length", '"1e-300 m"', "is not in [0.01, 200] m"),
        ("caisson", "outer_diameter", '"1e-300 m"', "is not in [0.01, 200] m"),
        ("caisson", "skirt_thickness", '"1e-300 m"', "is not in [1e-4, 10] m"),
        ("domain", "radius", '"20 km"', "is not in [0.01, 1e4] m"),
        ("solver", "first_step_fraction", "1e-300", "is not in [1e-12, 1]"),
        ("solver", "max_step_fraction", "1e-300", "is not in [1e-9, 1]"),
    ],
)
def test_beyond_them_is_refused_with_the_range(section: str, key: str, value: str, words: str) -> None:
    with pytest.raises(UserInputError) as caught:
        tiny.parsed(f"[{section}]\n{key} = {value}\n")
    (line,) = str(caught.value).split("\n")
    assert line.startswith(f"fatal: user input: 2:{len(key) + 4}: {section}.{key}: ")
    assert words in line


# --- contraction ---


@pytest.mark.parametrize("nu", [0.3, 0.45, 0.49])
def test_a_soil_that_contracts_is_accepted_down_to_where_it_becomes_unstable(nu: float) -> None:
    """The limit is 9 K m(phi_f) m_psi = -0.95 G; the message names the angle, and that angle is accepted."""
    with pytest.raises(UserInputError, match="is unstable: with Poisson ratio") as caught:
        tiny.parsed(f'[soil]\npoisson_ratio = {nu}\nfriction_angle_final = "60 deg"\ndilation_angle = "-30 deg"\n')
    least = float(str(caught.value).split("at least ")[1].split(" deg")[0])
    soil = {"poisson_ratio": nu, "friction_angle_final": "60 deg", "dilation_angle": f"{least + 0.005} deg"}
    bulk_over_shear = 2.0 * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu))
    psi = tiny.sand(soil=soil).soil.dilation_angle
    share = 9.0 * bulk_over_shear * formulas.cone_slope(np.sin(np.radians(60.0))) * formulas.cone_slope(np.sin(psi))
    assert share == pytest.approx(-MOST_CONTRACTION, abs=0.03)
    with pytest.raises(ValueError, match="unstable"):
        tiny.sand(soil=soil | {"dilation_angle": f"{least - 0.015} deg"})


def test_van_eekelen_is_refused_where_it_is_not_convex() -> None:
    with pytest.raises(UserInputError) as caught:
        tiny.parsed('[soil]\nyield_surface = "van-eekelen"\nfriction_angle_final = "47 deg"\n')
    place = "3:24: soil.friction_angle_final: 47 deg is too much: "
    assert str(caught.value) == f"fatal: user input: {place}Van Eekelen's surface is convex up to 46.5 deg"
    assert tiny.parsed('[soil]\nyield_surface = "van-eekelen"\nfriction_angle_final = "46.5 deg"\n')


@pytest.mark.parametrize("angle", [5.0, 30.0, 45.0])
@pytest.mark.parametrize("lode_angle", [0.0, 0.4, 1.0])
def test_the_section_is_the_engines(angle: float, lode_angle: float) -> None:
    b = lode.shape(np.radians(angle))
    cosine, sine = np.cos(3.0 * lode_angle), np.sin(3.0 * lode_angle)
    found = lode.section(b, cosine), lode.turn_of(b, cosine, sine)[0]
    assert VAN_EEKELEN.section(np.radians(angle), lode_angle) == pytest.approx(found)


def returns_to_the_surface(module: ModuleType, law: np.ndarray, rng: np.random.Generator) -> None:
    """Status OK, finite, and next to no excess, after random steps."""
    for _ in range(300):
        old, strain = np.zeros(6), 1e-3 * rng.standard_normal(6)
        old[:3] = -rng.uniform(1e4, 1e5)
        stress, history, tangent = np.zeros(6), np.zeros(1), np.zeros((6, 6))
        status, _ = module.update(law, strain, Point(old, np.zeros(1)), Point(stress, history), tangent, True)
        assert status == OK and np.isfinite(stress).all() and np.isfinite(tangent).all()
        trial = np.abs(200e6 * strain).max() + np.abs(old).max()
        assert module.yield_function(law, stress, history[0]) < 2.0 * plasol.APEX_STIFFNESS * trial


@pytest.mark.slow
@pytest.mark.parametrize("phi", [30.0, 46.5])
def test_van_eekelen_returns_to_its_surface_down_to_the_least_dilation(phi: float) -> None:
    """Status OK, no excess; and the yield function along the return changes its sign once, for any trial stress."""
    given = {"yield_surface": "van-eekelen", "friction_angle_final": f"{phi} deg", "poisson_ratio": 0.4}
    given |= {"dilation_angle": "-30 deg"}
    with pytest.raises(ValueError, match="is unstable") as caught:
        tiny.sand(soil=given)
    least = float(str(caught.value).split("at least ")[1].split(" deg")[0]) + 0.005
    assert tiny.sand(soil=given | {"dilation_angle": f"{least} deg"})
    law = plasol.pack(200e6, 0.4, np.radians(5.0), np.radians(phi), 0.005, np.radians(least), 0.0)
    rng = np.random.default_rng(1)
    returns_to_the_surface(van_eekelen, law, rng)
    start = np.array([-5e4, -5e4, -5e4, 0.0, 0.0, 0.0])
    b_psi = lode.shape_of_slope(law[plasol.M_PSI])
    for _ in range(200):
        trial_stress = start + 5e4 * rng.standard_normal(6)
        first = trial_stress[:3].sum()
        trial = lode.lode(trial_stress, first, plasol.second_invariant(trial_stress, first / 3.0))
        excess = [van_eekelen._evaluate(law, b_psi, 0.02, trial, w, 0.0).f for w in np.linspace(0.0, 1.0, 101)]
        assert np.count_nonzero(np.diff(np.sign(excess))) <= 1


def test_an_elastic_soil_has_no_use_for_its_dilation() -> None:
    assert tiny.sand(soil={"yield_surface": "elastic", "poisson_ratio": 0.49, "dilation_angle": "-30 deg"})


@pytest.mark.parametrize("psi", [-30.0, -10.0, -1.0])
def test_the_law_returns_to_its_surface_when_it_contracts(psi: float) -> None:
    """Why the range of the dilation angle goes below zero: status OK, no excess, no stress that is not finite."""
    law = plasol.pack(200e6, 0.2, np.radians(5.0), np.radians(30.0), 0.005, np.radians(psi), 0.0)
    returns_to_the_surface(plasol, law, np.random.default_rng(1))


# --- small strains ---


@pytest.mark.parametrize(
    ("path", "words"),
    [
        (PULL | {"lateral_displacement": "0.5 m"}, "a displacement of 0.5 m, 12% of the skirt length is beyond"),
        ({"name": "a", "kind": "rotation", "rotation": "0.11 rad"}, "a rotation of 0.11 rad is beyond small strains"),
        (PULL | {"role": "held-back", "then": ["-0.5 m"]}, "a displacement of 0.5 m"),
        (PULL | {"kind": "translation", "lateral_displacement": "0.5 m", "rotation": "0.2 rad"},
         "a displacement of 0.5 m, 12% of the skirt length and a rotation of 0.2 rad"),
        ({"name": "a", "kind": "vertical", "vertical_displacement": "-0.5 m"}, "a displacement of 0.5 m, 12% of the"),
    ],
)  # fmt: skip
def test_large_motions_are_named(path: dict[str, Any], words: str) -> None:
    (text,) = scene_warnings(tiny.sand(paths=[path]))
    assert text.startswith("path 'a': ")
    assert words in text
    assert "(limit 10% of the skirt length, 0.1 rad)" in text


def test_small_motions_are_not() -> None:
    turn = {"name": "b", "kind": "rotation", "rotation": "0.1 rad"}
    assert scene_warnings(tiny.sand(paths=[PULL | {"lateral_displacement": "0.4 m"}, turn])) == []


def test_a_run_records_the_motion_that_it_reached(monkeypatch: pytest.MonkeyPatch) -> None:
    from pysprings.full_model import compute
    from pysprings.model import stages

    monkeypatch.setattr(stages, "LARGEST_SHARE", 1e-5)
    result = compute.compute(tiny.scene()).recorded()
    (text,) = json.loads(result.attrs["run_json"])["warnings"]
    assert "path 'pull': a displacement of 0.0005 m" in text
