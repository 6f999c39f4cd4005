# SPDX-License-Identifier: MIT
"""The same springs in OpenSees: multilinear elastic springs on rigid links, solved by its own Newton.

Licence of openseespy: free for research and internal use, so that it is a dependency of tests only.
"""

from pathlib import Path as File
from typing import Any

import numpy as np
import pytest

from pysprings.macro.curve_table import SpringTable
from pysprings.macro.predict import MacroModel, predict
from pysprings.macro.solver import row_values
from tests.support.in_opensees import answer_of
from tests.support.synthetic import Caisson, Path, make_springs

POINTS = 1500  # a side of each curve: our curves are cubic between points, those of OpenSees straight


def odd_curve(table: SpringTable, j: int) -> tuple[list[float], list[float]]:
    """Points of one spring for both signs, dense near the origin, with a far point on the last slope."""
    q = table.range[j] * np.linspace(0.0, 1.0, POINTS) ** 1.5
    q = np.append(q, 10.0 * table.range[j])
    r = row_values(table.q[j : j + 1], table.r[j : j + 1], table.slope[j : j + 1], table.count[j : j + 1], q[None])[0]
    return [*-q[:0:-1], *q], [*-r[:0:-1], *r]


def springs_of(table: SpringTable) -> list[dict[str, Any]]:
    """Springs for OpenSees: place, direction (1 lateral, 3 moment), points of force (reaction times slice height)."""
    springs = []
    for j in range(table.count.size):
        lateral = table.a[j, 0] == 1.0
        q, r = odd_curve(table, j)
        height = float(table.b[j, 0] if lateral else table.b[j, 1])
        depth = float(table.a[j, 1]) if lateral else 0.0
        force = [height * value for value in r]
        springs.append({"depth": depth, "direction": 1 if lateral else 3, "q": q, "r": force})
    return springs


def solve_in_opensees(table: SpringTable, H: float, M: float) -> tuple[float, float]:
    """Return u and rotation of the lid under H and M; skip the test where OpenSees does not run."""
    task = {"springs": springs_of(table), "H": H, "M": M, "steps": 20}
    answer = answer_of(File(__file__).parents[2] / "support" / "opensees_child.py", task, 0)
    assert answer["status"] == 0
    return answer["u"], answer["rotation"]


@pytest.mark.parametrize(("spring_set", "H", "arm"), [("full", 2.0e6, 0.0), ("full", 1.0e6, 1.5), ("py", 1.2e6, -1.0)])
@pytest.mark.filterwarnings("ignore::pysprings.macro.predict.MacroWarning")
def test_predict_is_what_opensees_finds(spring_set: str, H: float, arm: float) -> None:
    """u and rotation to 1e-5 at loads where the springs yield."""
    springs = make_springs((Path("ray", "pull", size=8e-3, arm=-1.5, steps=30),), Caisson(rings=9))
    model = MacroModel.from_springs(springs, spring_set)
    assert isinstance(model.table, SpringTable)
    assert model.table.natural.all()  # each spring reads its own displacement: OpenSees can hold it
    answer = predict(model, H=H, arm=arm)
    assert float(answer["range_used"]) < 1.0
    start = np.linalg.solve(model.reactions(0.0, 0.0)[1], [H, arm * H])
    assert abs(float(answer["u"])) > 1.2 * abs(start[0])  # beyond the elastic range
    found = solve_in_opensees(model.table, H, arm * H)
    np.testing.assert_allclose(found, [answer["u"], answer["rotation"]], rtol=1e-5)
