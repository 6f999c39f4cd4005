# SPDX-License-Identifier: MIT
"""What GMRES asks of a Fourier model, and the factors of its interface."""

import numpy as np
import pytest

from fe_engine.conventions import REGIME_ELASTIC
from fe_engine.linear.preconditioner import Control
from fe_engine.solve.fourier_near import NearProduct
from fe_engine.solve.fourier_stage import Preconditioner, Room
from tests.support.fourier_models import disc, moved, on_plate, wet
from tests.support.models import replace

SOFT = (1.0e8, 5.0e7, 0.02)


def preconditioner(system, tangent, precise):
    nb = system.model.n_border
    free = np.eye(nb)[:, 1:]
    return Preconditioner(system, tangent, Control(np.zeros(nb), free, free), Room({}), precise)


@pytest.mark.parametrize("calm", [slice(0), slice(1, None)])
@pytest.mark.parametrize(("harmonics", "whole", "body"), [
    (2, False, lambda model: model), (5, False, lambda model: model), (2, True, lambda model: model),
    (4, True, lambda model: model), (2, False, on_plate), (2, True, on_plate), (2, False, wet), (5, True, wet),
    (2, False, lambda model: wet(on_plate(model))), (2, False, lambda model: wet(model, film=False)),
])  # fmt: skip
def test_products_near_what_yields_are_those_of_the_whole(harmonics, whole, body, calm):
    system, state, rng = moved(body(disc(harmonics, contact=SOFT, skew=True, whole=whole)), time=0.5)
    _, _, tangent = system.linearise(state, True)
    tangent.regime[system.yielding(tangent)[0][calm]] = REGIME_ELASTIC  # where one element yields others lie on the way
    p, yielding = preconditioner(system, tangent, True), system.yielding(tangent)
    nodes = yielding[1]
    rows = system.pattern.equation[nodes].ravel()
    force = np.where(system.pattern.held[nodes].ravel(), 0.0, rng.normal(size=len(rows)))
    padded = np.zeros(p.size)
    padded[rows] = force
    whole_product = system.plastic_product(tangent, p.solve(padded)[: system.pattern.n_moving])
    near = NearProduct(system, tangent, yielding, p.rest, p.interface)
    for _ in range(2):  # the second time with what the first one left in its arrays
        found = near(force)
    np.testing.assert_allclose(found, whole_product[rows], rtol=0, atol=1e-4 * np.abs(whole_product).max())
    assert np.abs(np.delete(whole_product, rows)).max(initial=0.0) == 0.0


@pytest.mark.parametrize(
    ("stiffer", "size", "single"), [(1.0, 1.0, True), (1e3, 1.0, True), (1e8, 1.0, False), (1.0, 1e60, False)]
)
def test_single_precision_is_refined_and_left_where_it_does_not_do(stiffer, size, single):
    system, state, rng = moved(disc(2, contact=SOFT, skew=True))
    _, _, tangent = system.linearise(state, True)
    scale = np.where(np.arange(len(tangent.contact)) % 2, 1.0, stiffer)  # of every other station
    tangent = replace(tangent, contact=tangent.contact * scale[:, None, None])
    exact, p = (preconditioner(system, tangent, precise) for precise in (True, False))
    rhs = size * rng.normal(size=exact.size)  # the largest is that of an iterate that diverges
    rhs[: system.pattern.n_free][system.pattern.held.ravel()] = 0.0
    wanted, found = exact.solve(rhs), p.solve(rhs)
    assert p.single is single
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-5 * np.abs(wanted).max())
