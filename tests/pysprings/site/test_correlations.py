# SPDX-License-Identifier: MIT
"""Correlations, I_c, stresses and the split into layers, beside numbers of groundhog 0.16.0 and plain arithmetic.

The numbers of groundhog (B. Stuyts, GPL 3) are results of its functions for the rows below; none of its code is here.
"""

import numpy as np
import pytest

from pysprings.site.correlations import SAND, Rows, clay, dilation
from pysprings.site.layering import boundaries
from pysprings.site.sounding import behaviour_index, sounding, stresses, unit_weight

# q_t, f_s [MPa], s_v0, s'_v0 [kPa]
ROWS = ((10.0, 0.08, 200.0, 100.0), (1.0, 0.03, 120.0, 60.0), (25.0, 0.2, 60.0, 30.0), (5.0, 0.15, 350.0, 180.0))


def rows(density: float = 0.6) -> Rows:
    cone, sleeve, total, effective = np.array(ROWS).T * [[1e6], [1e6], [1e3], [1e3]]
    same = np.ones(len(cone))
    return Rows(cone, sleeve, total, effective, 19e3 * same, 2.0 * same, density * same)


def of(name: str, gives: str, density: float = 0.6) -> np.ndarray:
    return next(each for each in (*SAND, *clay()) if each.name.startswith(name) and each.gives == gives).of(
        rows(density)
    )


def test_behaviour_index_is_that_of_groundhog() -> None:
    cone, sleeve, total, effective = np.array(ROWS).T
    index = behaviour_index(1e6 * cone - 1e3 * total, 1e6 * sleeve, 1e3 * effective)
    assert index == pytest.approx([1.862227, 2.897426, 1.416308, 2.679924], abs=2e-4)


@pytest.mark.parametrize(
    ("name", "gives", "values", "unit"),
    [
        ("Rix", "shear_modulus", [91886.57, 42663.72, 73562.68, 96321.17], 1e3),
        ("Mayne and Rix", "shear_modulus", [608197.7, 28121.91, 2066782.0, 241084.8], 1e3),
        ("Robertson and Cabal 2015", "shear_modulus", [114369.6, 10269.92, 291059.0, 54267.22], 1e3),
        ("Kulhawy", "friction_angle_final", [39.6, 29.82017, 46.85317, 34.88467], np.pi / 180.0),
        ("Baldi et al. 1986, NC", "relative_density", [0.672718, 0.05, 1.0, 0.250963], 1.0),
        ("Baldi et al. 1986, OC", "relative_density", [0.566667, 0.05, 1.0, 0.177230], 1.0),
        ("Mayne et al. 2010", "effective_unit_weight", [9.065089, 7.449173, 8.742084, 10.494180], 1e3),
    ],
)
def test_correlations_have_the_values_of_groundhog(name, gives, values, unit) -> None:
    """Densities are held between 0.05 and 1 here; unit weights are those of groundhog less 9.81 kN/m3."""
    assert of(name, gives) == pytest.approx(np.array(values) * unit, rel=2e-5)


def test_density_of_jamiolkowski_is_that_of_dry_sand_times_the_correction_of_saturated_sand() -> None:
    """groundhog 0.16.0: 0.532166 dry; ln(q_c/(p_a s'_v0)^0.5) = ln 100."""
    wet = 0.5321659 * (1.0 + (2.32 * np.log(100.0) - 1.87) / 100.0)
    assert of("Jamiolkowski", "relative_density")[0] == pytest.approx(wet, rel=1e-6)


def test_sand_by_density() -> None:
    """Brinkgreve et al. (2010) at D_r 0.6, Bolton (1986) at D_r 0.8 and p' 150 kPa: numbers of groundhog 0.16.0."""
    brinkgreve = {each.gives: each.of(rows())[0] for each in SAND if each.name == "Brinkgreve et al. 2010"}
    assert np.degrees(brinkgreve["friction_angle_final"]) == pytest.approx(35.5)
    assert brinkgreve["degradation_strain"] == pytest.approx(1.4e-4)
    assert brinkgreve["effective_unit_weight"] == pytest.approx(19.96e3 - 9.81e3)
    assert brinkgreve["shear_modulus"] == pytest.approx(100.8e6 * 0.5**0.5125)  # s'_3 50 kPa
    bolton = of("Bolton", "friction_angle_final", 0.8)[0]
    assert np.degrees(bolton) == pytest.approx(33.0 + 8.974475, rel=1e-6)
    # -d eps_v/d eps_1 = 0.8974475 at the peak, and sin psi = 0.3 I_R/(2 + 0.3 I_R)
    assert np.sin(dilation(bolton)) == pytest.approx(0.8974475 / 2.8974475, rel=1e-6)


def test_what_is_outside_the_range_of_a_correlation_is_marked() -> None:
    (jamiolkowski,) = (each for each in SAND if each.name.startswith("Jamiolkowski"))
    assert jamiolkowski.inside(rows()).tolist() == [True, True, False, True]
    (bolton,) = (each for each in SAND if each.name.startswith("Bolton"))
    assert not bolton.inside(rows(0.15)).any()


def test_strength_of_clay_is_the_net_resistance_over_the_cone_factor() -> None:
    su = [each.of(rows())[1] for each in clay((10.0, 14.0, 18.0)) if each.gives == "undrained_shear_strength"]
    assert su == pytest.approx([88e3, 880e3 / 14.0, 880e3 / 18.0])


def test_unit_weight_of_robertson_and_cabal() -> None:
    """R_f 1 %, q_t 1 MPa: gamma/gamma_w = 0.36 + 1.236."""
    weight = unit_weight(np.array([1e6]), np.array([1e4]))
    assert weight == pytest.approx([9810.0 * 1.596])


def test_stresses_are_sums_of_weights_below_mudline() -> None:
    total, effective = stresses(np.array([1.0, 3.0]), np.array([18e3, 20e3]))
    assert total == pytest.approx([18e3, 56e3])
    assert effective == pytest.approx([18e3 - 9810.0, 56e3 - 3 * 9810.0])


def test_total_cone_resistance_counts_the_pore_pressure_behind_the_cone() -> None:
    one = np.ones(3)
    given = {"depth": np.arange(3.0), "qc": 1e6 * one, "fs": 1e4 * one, "u2": 2e5 * one}
    assert sounding("a", "a", given, 0.75).total_cone == pytest.approx(1.05e6 * one)
    assert sounding("a", "a", given | {"qt": 1.2e6 * one}, 0.75).total_cone == pytest.approx(1.2e6 * one)
    without = sounding("a", "a", given)
    assert without.total_cone == pytest.approx(1.04e6 * one) and "0.8 is assumed" in without.notes[0]


def test_boundaries_are_found_where_soils_change() -> None:
    depth = np.arange(0.02, 20.0, 0.02)
    noise = np.random.default_rng(1).normal(0.0, 1.0, depth.shape)
    soil = np.select([depth < 4.0, depth < 11.0], [0, 1], 2)
    index = np.array([1.8, 3.1, 2.2])[soil] + 0.1 * noise
    net = np.array([10e6, 0.4e6, 5e6])[soil] * (1.0 + 0.05 * depth) * np.exp(0.2 * noise)
    assert boundaries(depth, index, net, 9e3 * depth, 10) == pytest.approx([4.0, 11.0], abs=0.15)


def test_no_more_layers_than_asked_for() -> None:
    depth = np.arange(0.02, 20.0, 0.02)
    index = np.where((depth % 2.0) < 1.0, 1.8, 3.2)
    net = np.where((depth % 2.0) < 1.0, 8e6, 0.5e6)
    assert len(boundaries(depth, index, net, 9e3 * depth, 50)) == 19
    assert len(boundaries(depth, index, net, 9e3 * depth, 6)) <= 5
