# SPDX-License-Identifier: MIT
"""Laboratory tests on one point of a layer, beside closed forms."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fe_engine.material import Material
from pysprings.model.element import KINDS, Curve, drive, element_test, schedule, specimen
from pysprings.scene.ground import Stratum
from tests.support import tiny

PHI, STRESS, SU, E, NU = np.radians(35.0), 100e3, 20e3, 50e6, 0.3
SAND = {"friction_angle_initial": PHI, "friction_angle_final": PHI, "young_modulus": E, "poisson_ratio": NU, "K0": 0.6}
CLAY = {"undrained_shear_strength": SU, "rigidity_ratio": 200.0}


def layer(law: str, **soil: Any) -> Stratum:
    interface = {"adhesion_factor": 1.0} if "undrained_shear_strength" in soil else {}
    return tiny.sand(soil={"yield_surface": law, **soil}, interface=interface).ground.strata[0]


def run(stratum: Stratum, test: Any, undrained: bool = False, end: float | None = None) -> Curve:
    point = specimen(stratum, KINDS[test], STRESS, 1.0)
    curve = element_test(point, KINDS[test], 1.0, undrained, end)
    assert curve.stopped == ""
    return curve


M_COMPRESSION = 6.0 * np.sin(PHI) / (3.0 - np.sin(PHI))
M_EXTENSION = 6.0 * np.sin(PHI) / (3.0 + np.sin(PHI))


@pytest.mark.parametrize("undrained", [False, True])
@pytest.mark.parametrize(
    ("law", "test", "ratio"),
    [
        ("drucker-prager", "triaxial", M_COMPRESSION),
        ("drucker-prager", "triaxial-extension", -M_COMPRESSION),
        ("van-eekelen", "triaxial", M_COMPRESSION),
        ("van-eekelen", "triaxial-extension", -M_EXTENSION),
    ],
)
def test_the_stress_ratio_at_failure_is_that_of_the_surface(law: str, test: Any, ratio: float, undrained: bool) -> None:
    """6 sin(phi)/(3 -+ sin(phi)): Mohr and Coulomb in compression, and in extension on Van Eekelen's surface."""
    columns = run(layer(law, **SAND), test, undrained).columns()
    assert columns["q_Pa"][-1] / columns["p_Pa"][-1] == pytest.approx(ratio, rel=1e-6)
    if law == "van-eekelen" or test == "triaxial":
        assert columns["mobilised_angle_rad"][-1] == pytest.approx(PHI, rel=1e-6)
    if undrained:
        assert np.abs(columns["volumetric_strain"]).max() < 1e-15
        # the total radial stress stays: u = s_3 - s_3'
        assert columns["pore_pressure_Pa"] == pytest.approx(STRESS - columns["radial_stress_Pa"], abs=1e-6)
    else:
        assert columns["radial_stress_Pa"] == pytest.approx(STRESS, rel=1e-8)
        assert not columns["pore_pressure_Pa"].any()


def test_a_drained_cone_without_dilation_keeps_its_plastic_volume() -> None:
    """Beyond yield the stresses are constant, and so is the volume; with psi the ratio is that of the potential."""
    columns = run(layer("drucker-prager", **SAND), "triaxial").columns()
    assert columns["volumetric_strain"][-1] == pytest.approx((1.0 - 2.0 * NU) * columns["q_Pa"][-1] / E, rel=1e-6)
    psi = np.radians(10.0)
    columns = run(layer("drucker-prager", **SAND, dilation_angle=psi), "triaxial").columns()
    slope = np.diff(columns["volumetric_strain"])[-1] / np.diff(columns["axial_strain"])[-1]
    assert slope == pytest.approx(-2.0 * np.sin(psi) / (1.0 - np.sin(psi)), rel=1e-6)


@pytest.mark.parametrize(
    ("law", "test", "column", "strength"),
    [
        ("tresca", "triaxial", "q_Pa", 2.0),
        ("tresca", "triaxial-extension", "q_Pa", -2.0),
        ("tresca", "dss", "shear_stress_Pa", 1.0),
        ("von-mises", "triaxial", "q_Pa", np.sqrt(3.0)),
        ("von-mises", "dss", "shear_stress_Pa", 1.0),
        ("iwan-clay", "dss", "shear_stress_Pa", 40.0 / 41.0),  # the hyperbola at gamma G/su = 40
    ],
)
def test_clay_fails_at_its_undrained_strength(law: str, test: Any, column: str, strength: float) -> None:
    curve = run(layer(law, **CLAY), test)
    assert curve.drainage == "total stress"
    assert curve.columns()[column][-1] == pytest.approx(strength * SU, rel=2.5e-2 if law == "iwan-clay" else 1e-6)


def test_elastic_soil_has_the_moduli_of_each_test() -> None:
    stratum = layer("elastic", young_modulus=E, poisson_ratio=NU, K0=0.6)
    columns = run(stratum, "oedometer").columns()
    modulus = E * (1.0 - NU) / ((1.0 + NU) * (1.0 - 2.0 * NU))
    assert columns["axial_stress_Pa"] - STRESS == pytest.approx(modulus * columns["axial_strain"], rel=1e-9)
    assert columns["radial_stress_Pa"][0] == pytest.approx(0.6 * STRESS)
    columns = run(stratum, "triaxial").columns()
    assert columns["q_Pa"] == pytest.approx(E * columns["axial_strain"], rel=1e-8)
    assert columns["volumetric_strain"] == pytest.approx((1.0 - 2.0 * NU) * columns["axial_strain"], abs=1e-12)
    columns = run(stratum, "triaxial", undrained=True).columns()
    assert columns["p_Pa"] == pytest.approx(STRESS, rel=1e-12)
    assert columns["pore_pressure_Pa"] == pytest.approx(columns["q_Pa"] / 3.0, rel=1e-9)  # Skempton's A = 1/3
    columns = run(stratum, "dss").columns()
    assert columns["shear_stress_Pa"] == pytest.approx(E / (2.0 + 2.0 * NU) * columns["shear_strain"], rel=1e-9)


def test_stiffness_by_stress_is_that_of_the_specimen() -> None:
    young = {"reference": 40e6, "reference_stress": 100e3, "exponent": 0.5}
    weightless = {"layers": ({"top": 0.0, "law": "elastic", "young_modulus": young},)}
    stratum = tiny.sand(soil=weightless).ground.strata[0]
    point = specimen(stratum, KINDS["triaxial"], 400e3, 1.0)
    columns = element_test(point, KINDS["triaxial"], 1.0, False, 1e-3).columns()
    assert columns["q_Pa"][-1] == pytest.approx(80e6 * 1e-3, rel=1e-6)


def test_without_a_stress_it_is_that_of_the_layer() -> None:
    stratum = layer("van-eekelen", **SAND)
    point = specimen(stratum, KINDS["dss"], None, 2.0)
    assert point.above == pytest.approx(float(stratum.vertical_stress(np.array(2.0))))
    assert specimen(stratum, KINDS["triaxial"], None, 2.0).above == pytest.approx(point.above * 2.2 / 3.0)


def test_a_schedule_begins_small_and_ends_at_its_end() -> None:
    strains = schedule(0.1)
    assert strains[0] == pytest.approx(1e-6) and strains[-1] == 0.1 and (np.diff(strains) > 0.0).all()


def test_a_test_without_equilibrium_says_where_it_ends() -> None:
    """A law whose update fails beyond a stress ends the test at the strain of that stress."""

    def update(p: Any, strain: Any, old: Any, new: Any, tangent: Any, with_tangent: bool) -> tuple[int, int]:
        new.stress[:] = old.stress + p[0] * strain
        tangent[:] = p[0] * np.eye(6)
        return (0 if new.stress[2] > -1.5e5 else 1), 0

    law: Any = SimpleNamespace(update=update, parameters=("stiffness",), history=())
    material = Material(law, np.array([1e6]))
    start, down, held = np.array([-1e5, -1e5, -1e5, 0.0, 0.0, 0.0]), np.array([0.0, 0.0, -1.0, 0.0, 0.0, 0.0]), [0, 1]
    strain, stress, why = drive(material, start, down, np.array(held), np.linspace(0.0, 0.1, 11)[1:])
    assert why == "no equilibrium beyond a strain of 0.04999"
    assert len(strain) == 5 and strain[-1][2] == pytest.approx(-0.04) and stress[-1][2] == pytest.approx(-1.4e5)
