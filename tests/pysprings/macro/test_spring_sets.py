# SPDX-License-Identifier: MIT
"""Spring sets as plug-ins: what each declares, and one from outside the package."""

from dataclasses import replace

import pytest

from pysprings.core.errors import UserInputError
from pysprings.macro.comparison import compare
from pysprings.macro.model import MacroModel, spring_sets
from pysprings.macro.predict import predict
from pysprings.macro.spring_sets import SPRING_SETS, SpringSet
from tests.support import synthetic

ARM = 0.0  # of the path of the springs


def halved(springs, path):
    """All reactions of one path at half their size."""
    whole = SPRING_SETS["full"].build(springs, path)
    table = replace(whole.table, r=0.5 * whole.table.r, slope=0.5 * whole.table.slope)
    return replace(whole, table=table, remarks=("half of the soil",))


HALF = SpringSet("half", "half of the springs", "reactions at half their size", halved)


def test_a_set_from_outside_predicts_and_is_compared() -> None:
    springs = synthetic.make_springs()
    with SPRING_SETS.added(HALF):
        assert spring_sets(springs) == ["py", "full", "half"]
        whole = predict(springs, H=4e5, arm=ARM, springs_kind="full")
        half = predict(springs, H=2e5, arm=ARM, springs_kind="half")
        table = compare(springs).set_index("springs")
    assert float(half["u"]) == pytest.approx(float(whole["u"]), rel=1e-9)
    assert half.attrs["springs"] == "half" and "half of the soil" in " ".join(half.attrs["remarks"])
    assert table.loc["half", "H_error_max_pct"] == pytest.approx(-50.0, abs=1e-6)
    assert abs(table.loc["full", "H_error_max_pct"]) < 1e-6
    with pytest.raises(UserInputError, match="springs_kind: 'half' is not one of py, pisa, full, fan, memory"):
        MacroModel.from_springs(springs, "half")


def test_every_set_has_words_for_people() -> None:
    assert len(SPRING_SETS) >= 4
    assert all(each.label and each.description for each in SPRING_SETS)
