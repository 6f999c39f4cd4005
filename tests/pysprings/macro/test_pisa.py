# SPDX-License-Identifier: MIT
"""Uncoupled families after PISA: lateral ones of a translation, moments of a rotation."""

import numpy as np
import pytest

from pysprings.core.errors import BeyondSprings, UserInputError
from pysprings.macro.model import MacroModel, spring_sets
from pysprings.macro.predict import MacroWarning, predict
from pysprings.macro.solver import ROWS, SpringArrays, reactions
from pysprings.springs.path import paths_of
from tests.support import synthetic

SLIDE = synthetic.Path("slide", "translation", size=1e-2, steps=16)
TURN = synthetic.Path("turn", "rotation", size=2e-3, steps=16)


def test_each_family_comes_from_its_path() -> None:
    springs = synthetic.make_springs([SLIDE, TURN])
    model = MacroModel.from_springs(springs, "pisa")
    assert set(model.table.name) == {"p", "H_tip", "H_lid", "m", "M_tip", "M_lid"}
    assert set(model.table.carrier) <= {"y", "u", "rotation"}
    slide, turn = paths_of(springs)["slide"].dataset, paths_of(springs)["turn"].dataset
    # under the pure translation: its own lateral load, and the moment of its lateral reactions alone
    force, _ = model.reactions(float(slide["u"][-1]), 0.0)
    assert force[0] == pytest.approx(float(slide["H"][-1]), rel=1e-9)
    # what a rotation adds to the moment beside the lateral families is that of its own path
    dz = np.diff(turn["depth_bounds"].values, axis=1)[:, 0]
    turned = dz @ turn["m"].sum("side").transpose("depth", "step").values + turn["M_tip"].values + turn["M_lid"].values
    rotation = float(turn["rotation"][-1])
    lateral = [row for row, name in enumerate(model.table.name) if name in ("p", "H_tip", "H_lid")]
    moment = sum(model.table.b[row, 1] * curve(model, row, rotation) for row in lateral)
    assert model.reactions(0.0, rotation)[0][1] == pytest.approx(moment + turned[-1] - turned[0], rel=1e-9)


def test_an_answer_stands_on_both_paths() -> None:
    """Its mesh error is the larger one, and the end of the springs names both."""
    springs = synthetic.make_springs([SLIDE, TURN])
    for name, error in (("slide", 1.0), ("turn", 3.0)):
        springs[f"paths/{name}"].attrs["mesh_error_pct"] = error
    with pytest.warns(MacroWarning, match="off the path 'slide'"):
        answer = predict(springs, H=1e5, arm=2.0, springs_kind="pisa")
    assert float(answer["mesh_error_pct"]) == 3.0
    assert "paths 'slide' and 'turn'" in answer.attrs["capacity_from"]
    with pytest.raises(BeyondSprings, match="beyond the range of paths 'slide' and 'turn'"):
        predict(springs, H=1e7, arm=2.0, springs_kind="pisa")


def curve(model: MacroModel, row: int, rotation: float) -> float:
    """Reaction of one row at a pure rotation."""
    a, _, q, r, slope, count = model.table.solver_arrays
    force, tangent = np.zeros(2), np.zeros((2, 2))
    one = slice(row, row + 1)
    unit = np.array([[1.0, 0.0]])
    springs = SpringArrays(ROWS, a[one], unit, q[one], r[one], slope[one], count[one])
    reactions(springs, 0.0, rotation, force, tangent)
    return float(force[0])


@pytest.mark.parametrize(
    ("paths", "path", "words"),
    [([SLIDE], None, "pure translation and a pure rotation"), ([SLIDE, TURN], "slide", "several calibration paths")],
)
def test_it_comes_from_a_pure_translation_and_a_pure_rotation_together(paths, path, words) -> None:
    springs = synthetic.make_springs(paths)
    assert ("pisa" in spring_sets(springs)) is (len(paths) == 2)
    with pytest.raises(UserInputError, match=words):
        MacroModel.from_springs(springs, "pisa", path)
