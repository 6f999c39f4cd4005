# SPDX-License-Identifier: MIT
"""The benchmark of omissions on a model that a test can afford: it measures what it says."""

from __future__ import annotations

from benchmarks import carried
from benchmarks.omissions import Case, cases, measure, models, table
from fe_engine.assembly.system import System
from fe_engine.linear.backends import available_backends
from pysprings.model.build import Built


def test_a_case_is_measured_without_and_with_what_it_leaves_out() -> None:
    scene = carried.scene()
    without, with_it = measure(Case("half", scene, lambda: carried.whole_model(scene)), 1)
    assert without.unknowns == 443 < with_it.unknowns
    assert with_it.field_bytes > 1.8 * without.field_bytes
    assert with_it.push > 0.0 and without.factorisations > 3
    if "pardiso" in available_backends():
        assert with_it.factor_bytes > 1.5 * without.factor_bytes > 0
    (_, row) = table({"half": (without, with_it)}).splitlines()
    assert row.startswith("half ") and "443 818" in row


def test_every_case_has_a_model_that_carries_more() -> None:
    """More unknowns, or else what has none: history, shear, the other half of the factors, output."""
    found = {case.what: [unknowns(built) for built in models(case)] for case in cases("coarse", 1e-3)}
    assert all(with_it >= without for without, with_it in found.values())
    assert [what for what, (without, with_it) in found.items() if without == with_it] == [
        "plastic history", "shear of the interface", "lower triangle of the factors", "fields, section, ParaView",
    ]  # fmt: skip


def unknowns(built: Built) -> int:
    return System(built.model).pattern.n_free + built.model.n_border
