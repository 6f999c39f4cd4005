# SPDX-License-Identifier: MIT
"""The stiffening by the domain: the estimate beside the engine itself, and who is warned."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import pytest

from fe_engine.assembly.system import System
from fe_engine.linear.solver import LinearSolver
from fe_engine.settings import Settings
from fe_engine.solve.newton import Newton
from fe_engine.state import State
from pysprings.full_model.compute import compute
from pysprings.model.build import build_model
from pysprings.model.forecast.domain_effect import MOST_TOLD, TIGHT, domain_effect
from pysprings.model.forecast.estimate import describe
from pysprings.model.mesh import PRESETS
from pysprings.scene.load import Scene
from pysprings.studies.stability.cases import CASES
from pysprings.studies.stability.catalogue import run_case
from tests.support import tiny

DIAMETER = 8.0  # m


def scene(length: float, radius: float, below: float, poisson: float = 0.3) -> Scene:
    """An elastic scene; lengths over the diameter, of the skirt, the domain's radius and the soil below the tip."""
    return Scene.model_validate({
        "caisson": {"outer_diameter": DIAMETER, "skirt_length": length * DIAMETER},
        "domain": {"radius": radius * DIAMETER, "depth": (length + below) * DIAMETER},
        "soil": {"yield_surface": "elastic", "poisson_ratio": poisson},
        "path": [tiny.PULL],
    })  # fmt: skip


def cells(length: float, first: float) -> int:
    """Number of cells that grow by 1.4 from the first one to a length: the same mesh, cut off nearer or farther."""
    return max(1, math.ceil(math.log(1.0 + 0.4 * length / first) / math.log(1.4)))


def translation(asked: Scene) -> float:
    """K_H of half the caisson at the initial state, by the engine, on a coarse mesh that reaches as far as asked."""
    caisson, domain = asked.caisson, asked.domain
    outwards, down = domain.radius - 0.5 * DIAMETER, domain.depth - caisson.skirt_length
    layer = 0.08 * min(caisson.skirt_length, DIAMETER)
    counts = replace(
        PRESETS["coarse"],
        outer=cells(outwards, 0.05 * DIAMETER),
        below=cells(down, layer),
        toe=layer / caisson.skirt_length,
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(PRESETS, "coarse", counts)
        system = System(build_model(asked).model)
    solver = LinearSolver("auto", system.pattern.n_free)
    stiffness = Newton(system, solver, Settings()).border_stiffness(State(system.model))
    solver.close()
    return float(stiffness[0, 0])


@cache
def unbounded(length: float, poisson: float) -> float:
    """The limit of domains of 15 and 30 diameters: what they add falls as one over their size."""
    return 2.0 * translation(scene(length, 30.0, 30.0, poisson)) - translation(scene(length, 15.0, 15.0, poisson))


DOMAINS = [
    (0.5, 3.0, 1.0, 0.3, 0.06),  # the paper's, nearly
    (0.5, 1.0, 2.0, 0.3, 0.12),
    (0.5, 3.0, 0.25, 0.3, 0.12),
    (0.5, 6.0, 4.0, 0.3, 0.06),
    (0.5, 3.0, 1.0, 0.45, 0.08),
    (0.25, 2.0, 1.0, 0.3, 0.08),
    (1.0, 2.0, 0.5, 0.3, 0.12),
    (2.0, 3.0, 1.0, 0.3, 0.12),
]


@pytest.mark.parametrize(("length", "radius", "below", "poisson", "within"), DOMAINS)
def test_the_estimate_is_what_the_engine_finds(
    length: float, radius: float, below: float, poisson: float, within: float
) -> None:
    asked = scene(length, radius, below, poisson)
    assert domain_effect(asked).stiffening == pytest.approx(translation(asked) / unbounded(length, poisson), rel=within)


def test_the_papers_domain_is_told_and_not_warned_of() -> None:
    """4,072 over 2,892 MN/m: K_H of an independent axisymmetric solution, in 24 m x 12 m and on the half-space."""
    effect, about = domain_effect(Scene()), describe(tiny.scene())
    assert effect.stiffening == pytest.approx(4072 / 2892, rel=0.02)
    assert effect.remarks == ()
    assert about["domain"]["stiffening_by_the_domain_percent"] == pytest.approx(100 * (effect.stiffening - 1))
    assert about["domain"]["domain_radius_over_diameter"] == pytest.approx(24 / 7.8)
    assert about["domain"]["soil_below_tip_over_diameter"] == pytest.approx(8 / 7.8)
    assert about["warnings"] == []


def test_a_caisson_that_is_large_for_the_default_domain_is_warned_of_by_check_and_run() -> None:
    """20 m x 11 m: the engine finds K_H 3.1 times that of 100 m x 60 m, which is 1.2 times the half-space's."""
    asked = tiny.scene(caisson={"outer_diameter": "20 m", "skirt_length": "11 m"})
    effect = domain_effect(asked)
    assert effect.stiffening == pytest.approx(3.1 * 1.2, rel=0.1)
    (warning,) = effect.remarks
    assert warning.startswith("tight domain: domain.radius 24 m (1.2 diameters) and domain.depth 12 m (1 m, 0.05 diam")
    assert "about 3.8 times as stiff as unbounded soil (warned of beyond 1.5)" in warning
    assert describe(asked)["warnings"] == [warning]
    assert warning in compute(asked).record.warnings


def test_a_needle_of_soil_has_no_figure() -> None:
    (warning,) = domain_effect(scene(0.5, 0.52, 1.0)).remarks
    assert f"more than {MOST_TOLD:g} times" in warning


def test_incompressible_soil_and_undrained_scenes_have_a_finite_estimate() -> None:
    asked = scene(0.5, 3.0, 1.0, 0.49)
    assert domain_effect(asked).stiffening == pytest.approx(1.45, rel=0.05)  # the engine's
    undrained = scene(0.5, 3.0, 1.0).replace(drainage={"mode": "undrained"})
    assert domain_effect(undrained).stiffening == domain_effect(asked).stiffening


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
        assert domain_effect(case.scene("coarse")).stiffening < TIGHT, case.name
