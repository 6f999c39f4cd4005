# SPDX-License-Identifier: MIT
"""Correlations, I_c, stresses and the split into layers, beside numbers of groundhog 0.16.0 and plain arithmetic.

The numbers of groundhog (B. Stuyts, GPL 3) are results of its functions for the rows below; none of its code is here.
"""

import numpy as np
import pytest

from pysprings.core.errors import UserInputError
from pysprings.site.correlations import CONE_FACTORS, SAND, Correlation, Rows, clay, dilation
from pysprings.site.sounding import (
    SAND_TO,
    TRANSITION,
    behaviour_index,
    boundaries,
    sounding,
    stresses,
    unit_weight,
    zone_name,
)

# q_t, f_s [MPa], s_v0, s'_v0 [kPa]
ROWS = ((10.0, 0.08, 200.0, 100.0), (1.0, 0.03, 120.0, 60.0), (25.0, 0.2, 60.0, 30.0), (5.0, 0.15, 350.0, 180.0))


def rows(density: float = 0.6) -> Rows:
    cone, sleeve, total, effective = np.array(ROWS).T * [[1e6], [1e6], [1e3], [1e3]]
    same = np.ones(len(cone))
    return Rows(cone, sleeve, total, effective, 19e3 * same, 2.0 * same, density * same)


def named(name: str, gives: str) -> Correlation:
    (found,) = (each for each in dict.fromkeys((*SAND, *clay())) if each.name.startswith(name) and each.gives == gives)
    return found


def of(name: str, gives: str, density: float = 0.6) -> np.ndarray:
    return named(name, gives).of(rows(density))


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
    """In the order of their values, low first, whatever the order of the factors."""
    su = [each.of(rows())[1] for each in clay((10.0, 14.0, 18.0)) if each.gives == "undrained_shear_strength"]
    assert su == pytest.approx([880e3 / 18.0, 880e3 / 14.0, 88e3])


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


def every(**changed: float) -> Rows:
    """Rows of one value each, with some changed: q_t, f_s, s_v0, s'_v0 [Pa], unit weight [N/m3], I_c, D_r."""
    usual = {"cone": 10e6, "sleeve": 8e4, "total": 2e5, "effective": 1e5, "weight": 19e3, "index": 1.9, "density": 0.5}
    return Rows(**{name: np.array([value]) for name, value in (usual | changed).items()})


@pytest.mark.parametrize(
    ("gives", "name", "key", "edges"),
    [
        ("relative_density", "Jamiolkowski", "effective", (50e3, 400e3)),
        ("relative_density", "Baldi et al. 1986, NC", "effective", (50e3, 400e3)),
        ("relative_density", "Baldi et al. 1986, OC", "effective", (50e3, 400e3)),
        ("effective_unit_weight", "Robertson and Cabal 2010", "weight", (11e3, 23e3)),
        ("effective_unit_weight", "Mayne", "effective", (10e3, 500e3)),
        ("effective_unit_weight", "Brinkgreve", "density", (0.1, 1.0)),
        ("friction_angle_final", "Kulhawy", "cone", (1e6, 100e6)),  # Q 10 to 1000 at s'_v0 100 kPa
        ("friction_angle_final", "Bolton", "density", (1.0 / (10.0 - np.log(150.0)), 1.0)),  # I_R from 0
        ("shear_modulus", "Rix", "index", (0.0, 2.05)),
        ("shear_modulus", "Robertson", "index", (1.0, 4.0)),
        ("shear_modulus", "Mayne and Rix", "cone", tuple(1e3 * (G / 2.78) ** (1 / 1.335) for G in (0.7e3, 8e5))),
        ("degradation_strain", "Darendeli 2001, 10", "effective", (0.0, 300e3)),
        ("undrained_shear_strength", "N_kt 14", "index", (2.6, 9.0)),
    ],
)  # fmt: skip
def test_the_range_of_a_correlation_ends_where_its_source_ends(gives, name, key, edges) -> None:
    """Ranges of docs/guide/site.md: inside by a thousandth, and outside of it by a thousandth."""
    found, (low, high) = named(name, gives), edges
    assert found.inside(every(**{key: low * 1.001})).all() and found.inside(every(**{key: high * 0.999})).all()
    assert low == 0.0 or not found.inside(every(**{key: low * 0.999})).any()
    assert high == 9.0 or not found.inside(every(**{key: high * 1.001})).any()


def test_constants_of_the_sources() -> None:
    """Darendeli (2001), clean sand: gamma_r = 0.0474 % (p'/atm)^0.234, G/G_0 = 1/(1 + (gamma/gamma_r)^0.895) = 0.722.

    Matlock (1970): eps50 of 2, 1, 0.5 %, and gamma = 1.5 eps; Bolton's index at p' 100 kPa is that at 150 kPa.
    """
    for pressure in (10, 200):
        strain = 0.0474e-2 * (pressure / 101.325) ** 0.234 * (1.0 / 0.722 - 1.0) ** (1.0 / 0.895)
        found = of(f"Darendeli 2001, {pressure} kPa", "degradation_strain")
        assert found == pytest.approx(np.full(4, strain), rel=0.02)
    for percent, strain in (("2 ", 0.03), ("1 ", 0.015), ("0.5 ", 0.0075)):
        assert of(f"Matlock 1970, eps50 {percent}", "strain_at_half_strength") == pytest.approx(np.full(4, strain))
    assert CONE_FACTORS == (10.0, 14.0, 18.0)
    bolton = np.degrees(of("Bolton", "friction_angle_final", 0.5))  # p' is two thirds of s'_v0: 66.7, 40, 20, 120 kPa
    assert bolton == pytest.approx(np.full(4, 33.0 + 3.0 * (0.5 * (10.0 - np.log(150.0)) - 1.0)))
    deep = named("Bolton", "friction_angle_final").of(every(effective=450e3, density=0.5))
    assert np.degrees(deep) == pytest.approx([33.0 + 3.0 * (0.5 * (10.0 - np.log(300.0)) - 1.0)])
    assert dilation(np.radians([30.0, 33.0, 45.0])) == pytest.approx([0.0, 0.0, np.arcsin(1.2 / 3.2)])


def test_densities_are_held_between_a_twentieth_and_one() -> None:
    (found,) = (each for each in SAND if each.name.startswith("Jamiolkowski"))
    assert found.of(every(cone=1e5)) == pytest.approx([0.05]) and found.of(every(cone=90e6)) == pytest.approx([1.0])


def test_unit_weight_and_index_at_their_bounds() -> None:
    """Robertson and Cabal (2010) with R_f 4 %, q_t 2 MPa, and held; exponent 1 of Robertson (2009) at 800 kPa."""
    cone, sleeve = np.array([2e6, 2e6, 5e4, 99e6]), np.array([8e4, 2e2, 50.0, 3e6])
    plain = 9810.0 * (0.27 * np.log10([4.0, 0.1]) + 0.36 * np.log10(20.0) + 1.236)
    assert unit_weight(cone, sleeve) == pytest.approx([*plain, 11e3, 23e3])
    index = behaviour_index(np.array([4e6, 1e5, -1.0]), np.array([2e5, 1e3, 1.0]), np.array([8e5, 2e3, 1e5]))
    deep = np.hypot(3.47 - np.log10(40.0 / 8.0), np.log10(5.0) + 1.22)  # Q_tn = q_net/s'_v0
    shallow = np.hypot(3.47 - np.log10(1.7), np.log10(1.0) + 1.22)  # (p_a/s'_v0)^n held at 1.7
    assert index == pytest.approx([deep, shallow, np.nan], nan_ok=True)


def test_zones_of_robertson() -> None:
    """Robertson (2009), table of soil behaviour types: I_c 1.31, 2.05, 2.60, 2.95, 3.60."""
    edges = (1.31, 2.05, 2.60, 2.95, 3.60)
    names = [(zone_name(each - 0.001), zone_name(each + 0.001)) for each in edges]
    assert all(below != above for below, above in names)
    assert names[2] == ("silty sand to sandy silt", "clayey silt to silty clay")
    assert (SAND_TO, TRANSITION) == (2.6, (2.5, 2.7))


@pytest.mark.parametrize(
    ("channel", "edge", "message"),
    [("depth", 500.0, "a depth of 500.5 m"), ("qc", 200e6, "a cone resistance of 200.2 MPa"),
     ("fs", 0.3 * 1e6, "a sleeve friction of 30 %"), ("qc", -20e3, "no cone resistance above 20 kPa")],
)  # fmt: skip
def test_values_that_no_test_has_are_refused_at_their_bounds(channel, edge, message) -> None:
    """At most 500 m, 200 MPa and a friction ratio of 30 %, at least 20 kPa (negative here): a thousandth decides."""
    cone = 10e6 if channel == "depth" else 1e6
    usual = {"depth": np.linspace(0.5, 1.0, 5), "qc": np.full(5, cone), "fs": np.full(5, 0.01 * cone)}
    sizes = {"fs": np.ones(5), "depth": np.array([0.2, 0.4, 0.6, 0.8, 1.0])}
    size = sizes.get(channel, np.array([0.1, 0.1, 0.2, 0.6, 1.0] if edge > 0.0 else [0.5, 0.7, 0.9, 0.9, 1.0]))
    usual["fs"] = np.full(5, 2e-3 * abs(edge)) if channel == "qc" else usual["fs"]
    inside, outside = (usual | {channel: abs(edge) * size * (1.0 + sign * 1e-3 * np.sign(edge))} for sign in (-1, 1))
    sounding("a", "a", inside)
    with pytest.raises(UserInputError, match=message):
        sounding("a", "a", outside)


@pytest.mark.parametrize(
    ("cone", "friction", "message"),
    [(60e6, 0.01, "a cone resistance above 60.1 MPa in half of its rows"),
     (20e6, 0.05, "a sleeve friction above 1 MPa in half of its rows"),
     (-8e3, 0.01, "a cone resistance below 7.99 kPa per m of depth in half of its rows")],
)  # fmt: skip
def test_values_that_half_of_a_test_never_has_are_refused(cone, friction, message) -> None:
    """Kilopascals of soft clay called MPa, megapascals of dense sand called kPa (negative here); by a thousandth."""
    depth = np.arange(1.0, 10.0)
    for sign in (-1, 1):
        each = abs(cone) * (1.0 + sign * 1e-3 * np.sign(cone)) * (depth if cone < 0.0 else np.ones(9))
        given = {"depth": depth, "qc": each, "fs": friction * each}
        if sign < 0:
            assert len(sounding("a", "a", given).depth) == 9
            continue
        with pytest.raises(UserInputError, match=message):
            sounding("a", "a", given)
