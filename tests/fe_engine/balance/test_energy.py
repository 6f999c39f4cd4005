# SPDX-License-Identifier: MIT
"""Energy: the work of the loads is found again in soil, contact and water; nothing is won."""

import numpy as np
import pytest

from fe_engine.balance.energy import EnergyBalance
from fe_engine.soil import elastic
from tests.support.models import footing, mixed, replace, soil, stage, start, wet

STEPS = {"first_fraction": 0.05, "max_fraction": 0.1}
PUSH = stage({0: 2.0e-3, 2: -1.0e-4}, **STEPS)
BACK = stage({0: -1.0e-3, 2: 0.0}, **STEPS)


def energies(model, *stages, tolerance=1.0e-11):
    """Energy after every step, from the initial state."""
    out = start(model, tolerance=tolerance)
    balance, found = EnergyBalance(out.driver.newton.system), []

    def on_step(step):
        balance.advance(out.state.committed, step.increment.residual.border)
        found.append(balance.now())

    for each in stages:
        out.driver.run(each, on_step)
    return found


def four(controls, **options):
    """A stage of the mixed model, which has four border dofs."""
    control = np.array([np.eye(4)[i] for i in controls])
    each = stage({0: 0.0}, **options)
    return each.__class__("test", control, np.array(list(controls.values())), control.T, np.zeros(4), **options)


def still(model):
    """The wet model with water that is at rest when the run begins."""
    model.water = replace(model.water, initial=np.zeros_like(model.water.initial))
    return model


@pytest.fixture(scope="module")
def pushed():
    return energies(footing(), PUSH, BACK)


@pytest.mark.parametrize(
    ("model", "stages"),
    [
        (footing(), (PUSH, BACK)),
        (footing(soil(elastic.LAW)), (PUSH,)),
        (mixed(), (four({0: 1.0e-4, 1: 5.0e-5, 3: 2.0e-5}, **STEPS),)),
        (still(wet()), (four({0: 1.0e-4, 1: 5.0e-5, 3: 2.0e-5}, duration=10.0, **STEPS),)),
        (still(wet("pairs")), (four({0: 1.0e-4, 1: 5.0e-5, 2: 0.0, 3: 2.0e-5}, duration=10.0, **STEPS),)),
    ],
    ids=["footing", "elastic footing", "everything at once", "with water", "with a porous side 2"],
)
def test_what_the_loads_do_is_found_again(model, stages):
    found = energies(model, *stages)
    assert len(found) > 1
    for energy in found:
        assert abs(energy.imbalance) < 1.0e-8 * energy.moved


def test_nothing_is_won_in_soil_and_friction(pushed):
    for name in ("plastic", "friction"):
        steps = np.diff([0.0, *(getattr(energy, name) for energy in pushed)])
        assert steps.min() > -2.0e-3 * pushed[-1].moved  # a station that opens within a step
        assert steps.sum() > 0.01 * pushed[-1].moved


def test_a_bonded_elastic_footing_stores_half_of_force_times_way():
    model = footing(soil(elastic.LAW), contact=(1.0e10, 1.0e10, 5.0), pressure=1.0e9)
    (*_, last) = energies(model, stage({0: 1.0e-4, 1: 0.0, 2: 0.0}, **STEPS), tolerance=1.0e-9)
    out = start(model)
    stiffness = out.driver.newton.border_stiffness(out.state)[0, 0]
    assert last.work == pytest.approx(0.5 * stiffness * 1.0e-8, rel=1e-7)
    assert last.plastic == pytest.approx(0.0, abs=1e-7 * last.moved)
    assert last.friction == pytest.approx(0.0, abs=1e-7 * last.moved)
    assert last.elastic + last.penalty - last.initial == pytest.approx(last.work, rel=1e-7)
