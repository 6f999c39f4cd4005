# SPDX-License-Identifier: MIT
"""The stiffening by the domain: the estimate beside the engine itself, and who is warned."""

import numpy as np
import pytest

from benchmarks.domain_table import DIAMETER, stiffness
from pysprings.full_model.compute import compute, run
from pysprings.model.forecast.domain_effect import MOST_SHOWN, DomainEffect, domain_effect
from pysprings.model.forecast.estimate import describe
from pysprings.studies.stability import CASES, run_case
from tests.support import tiny

DOMAINS = [
    (0.5, 2.577, 1.026, 0.3, "roller"),  # the paper's
    (0.5, 0.5, 2.0, 0.3, "roller"),
    (0.37, 2.5, 0.25, 0.35, "fixed"),
    (0.5, 5.5, 4.0, 0.2, "roller"),
    (0.7, 20.0, 9.0, 0.47, "roller"),
    (1.4, 1.5, 0.5, 0.3, "fixed"),
    (2.0, 30.0, 30.0, 0.495, "roller"),
]


def effect_of(length: float, beside: float, below: float, poisson: float, side: str = "roller") -> DomainEffect:
    """The bounds of a domain; lengths over the diameter, of the skirt, the soil beside it and below its tip."""
    domain = {"radius": (0.5 + beside) * DIAMETER, "depth": (length + below) * DIAMETER, "side": side}
    caisson = {"outer_diameter": DIAMETER, "skirt_length": length * DIAMETER}
    return domain_effect(tiny.sand(caisson=caisson, domain=domain, soil={"poisson_ratio": poisson}))


@pytest.mark.slow
@pytest.mark.parametrize(("length", "beside", "below", "poisson", "side"), DOMAINS)
def test_the_bounds_are_above_what_the_engine_finds_and_not_far(
    length: float, beside: float, below: float, poisson: float, side: str
) -> None:
    near, far = (stiffness(length, size, size, poisson) for size in (40.0, 80.0))
    true = 100.0 * (stiffness(length, beside, below, poisson, side) / (2.0 * far - near) - 1.0)
    bound = np.array([*effect_of(length, beside, below, poisson, side).percent.values()])
    assert (true <= bound).all()
    assert bound[0] <= 1.6 * true[0] + 1.0


@pytest.mark.parametrize("length", [0.25, 0.5, 1.0])
@pytest.mark.parametrize("mode", ["drained", "undrained"])
def test_the_domain_by_default_is_as_good_as_unbounded_soil(length: float, mode: str) -> None:
    caisson = {"outer_diameter": DIAMETER, "skirt_length": length * DIAMETER}
    assert domain_effect(tiny.sand(caisson=caisson, drainage={"mode": mode})).most < 4.0


@pytest.mark.slow
@pytest.mark.parametrize("length", [0.25, 0.5, 0.75, 1.0])
def test_the_domain_by_default_is_within_five_per_cent_of_the_half_space(length: float) -> None:
    """The half-space: domains of 80 and of 160 diameters, extrapolated. The bound that `check` prints is above it."""
    scene = tiny.sand(caisson={"outer_diameter": DIAMETER, "skirt_length": length * DIAMETER})
    extent = scene.extent
    near, far = (stiffness(length, size, size, scene.soil.poisson_ratio) for size in (80.0, 160.0))
    own = stiffness(length, extent.radius / DIAMETER - 0.5, extent.depth / DIAMETER - length, scene.soil.poisson_ratio)
    true = 100.0 * (own / (2.0 * far - near) - 1.0)
    assert (true > 0.0).all()
    assert (true < 5.0).all()
    assert (true <= [*domain_effect(scene).percent.values()]).all()


@pytest.mark.slow
def test_the_papers_caisson_by_default_beside_an_independent_half_space() -> None:
    """K_H 2,892 MN/m and K_M 80,933 MN m by an independent axisymmetric solution; mesh `coarse`, domain and penalty."""
    scene = tiny.sand(soil={"yield_surface": "elastic"})
    matrix = run(scene.replace(springs={"reach": None}, paths=(tiny.PULL,)))["stiffness_initial"].values
    over = [1e-6 * matrix[0, 0] / 2892.0 - 1.0, 1e-6 * matrix[2, 2] / 80933.0 - 1.0]
    assert min(over) > 0.0 and max(over) < 0.05
    assert 100.0 * over[0] < domain_effect(scene).percent["H"] + 2.0  # of mesh and penalty


def test_the_papers_domain_is_shown_and_not_warned_of() -> None:
    """4,072 over 2,892 MN/m: K_H of an independent axisymmetric solution, in 24 m x 12 m and on the half-space."""
    effect, about = domain_effect(tiny.paper()), describe(tiny.scene())
    assert 100.0 * (4072 / 2892 - 1.0) < effect.percent["H"] < 1.3 * 100.0 * (4072 / 2892 - 1.0)
    assert effect.remarks == ()
    assert about["domain"]["stiffening_by_the_domain_percent"] == effect.most == effect.percent["V"]
    assert about["domain"]["stiffening_of_K_H_percent"] == effect.percent["H"]
    assert about["domain"]["domain_radius_over_diameter"] == pytest.approx(24 / 7.8)
    assert about["domain"]["soil_below_tip_over_diameter"] == pytest.approx(8 / 7.8)
    assert about["warnings"] == []


def test_a_caisson_that_is_large_for_its_domain_is_warned_of_by_check_and_run() -> None:
    """20 m x 11 m in 24 m x 12 m: the engine finds K_H 3.1 times that of 100 m x 60 m, 1.2 times the half-space's."""
    asked = tiny.scene(caisson={"outer_diameter": "20 m", "skirt_length": "11 m"})
    effect = domain_effect(asked)
    assert effect.percent["H"] > 100 * (3.1 * 1.2 - 1.0)
    (warning,) = effect.remarks
    assert warning.startswith("tight domain: domain.radius 24 m (1.2 diameters) and domain.depth 12 m (1 m, 0.05 diam")
    assert describe(asked)["warnings"] == [warning]
    assert warning in compute(asked).record.warnings


def test_a_needle_of_soil_has_no_figure() -> None:
    (warning,) = effect_of(0.5, 0.02, 1.0, 0.3).remarks
    assert f"K_H more than {MOST_SHOWN:g} %" in warning


def test_water_that_cannot_flow_holds_the_volume() -> None:
    drained, undrained = (
        domain_effect(tiny.paper(drainage={"mode": mode})).percent for mode in ("drained", "undrained")
    )
    assert all(undrained[name] > drained[name] for name in ("H", "V"))


@pytest.mark.parametrize("name", ["tight-domain", "pancakes"])
def test_stability_names_a_tight_domain(name: str) -> None:
    (case,) = (case for case in CASES if case.name == name)
    outcome = run_case(case, refinement=0.5, reach=1e-4)
    assert outcome.outcome == "warned"
    assert outcome.detail.startswith("tight domain: ")


def test_other_shapes_of_the_catalogue_are_not_tight() -> None:
    roomy = [case for case in CASES if case.group == "shape" and case.name not in ("tight-domain", "pancakes")]
    assert len(roomy) >= 5
    for case in roomy:
        assert not domain_effect(case.scene("coarse")).remarks, case.name
