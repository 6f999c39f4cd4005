# SPDX-License-Identifier: MIT
"""Signs of the field wherever M or a rotation is stored, printed or drawn: a pull above mudline has both positive."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pysprings.macro.capacity import capacities
from pysprings.macro.model import MacroModel
from pysprings.macro.predict import impose, predict, sequence
from pysprings.macro.stiffness import stiffness, stiffness_six
from pysprings.results.exporters.tables import load_displacement, py_long
from pysprings.results.exporters.wide_table import py_wide
from pysprings.results.plots.overview import overview
from pysprings.results.tables import open_table
from pysprings.results.tables.load_cases import read_load_cases
from pysprings.springs.checks import open_springs, save_springs
from pysprings.studies.atlas.file import open_atlas, shipped
from pysprings.studies.design.answers import answer_cases
from tests.support import synthetic, winkler
from tests.support.commands import command

PULL = synthetic.Path("pull", arm=8.0)
H, ARM = 1e5, 8.0


def stored(folder: Path) -> Iterator[tuple[str, float, float]]:
    """Yield M and rotation at the end of the pull, by place."""
    result = synthetic.make_result((PULL,))
    file = save_springs(synthetic.make_springs((PULL,)), folder / "springs.nc")
    path = open_springs(file)["paths/pull"].isel(step=-1)
    yield "springs.nc", float(path["M"]), float(path["rotation"])
    yield "tip and lid", float(path["M_tip"] + path["M_lid"]), float(path["m"].sum())
    last = load_displacement(result).iloc[-1]
    yield "load_displacement.csv", last["M_Nm"], last["rotation_rad"]
    for table in (py_long(open_springs(file)), py_wide(open_springs(file))):
        table.to_csv(folder / "table.csv", index=False)
        again = open_table(folder / "table.csv")["paths/pull"].isel(step=-1)
        yield "a table read back", float(again["m"].sum() * 0.5 + again["M_tip"]), float(again["rotation"])
    for load in overview(result).axes[1].lines[:1]:
        yield "picture", float(load.get_ydata()[-1]), float(load.get_xdata()[-1])


def answered(folder: Path) -> Iterator[tuple[str, float, float]]:
    """Yield M and rotation under H at 8 m, by place."""
    tree = winkler.with_invented_memory()
    file = save_springs(tree, folder / "fan.nc")
    for kind in ("fan", "memory"):
        model = MacroModel.from_springs(tree, kind)
        for name, answer in (("load", predict(model, H=H, arm=ARM)), ("motion", impose(model, u=1e-5, arm=ARM))):
            yield f"{kind}, {name}", float(answer["M"]), float(answer["rotation"])
        way = sequence(model, np.array([[H, H * ARM]])).isel(step=-1)
        yield f"{kind}, sequence", float(way["M"]), float(way["rotation"])
    asked = ("predict", file, "--H", "100 kN", "--arm", "8 m")
    (state,) = json.loads(command(*asked, "--json").out)["states"]
    yield "JSON", state["M"], state["rotation"]
    cells = command(*asked).out.splitlines()[2].split()
    yield "text", float(cells[5]), float(cells[2])
    command(*asked, "--out", folder / "answer.csv")
    row = pd.read_csv(folder / "answer.csv", comment="#").iloc[-1]
    yield "CSV", *(row[next(name for name in row.index if name.startswith(each))] for each in ("M", "rotation"))
    (folder / "cases.csv").write_text("name,H [kN],arm [m]\na,100,8\n", encoding="utf-8")
    case = answer_cases(tree, read_load_cases(folder / "cases.csv")).iloc[0]
    yield "design", case["M_Nm"], case["rotation_rad"]
    yield "capacity", float(capacities(MacroModel.from_springs(tree), np.array([[H, H * ARM]])).M[0]), 1.0
    for name in shipped():
        atlas = open_atlas(name)
        answer = impose(atlas.springs(atlas.scene(8.0, 4.0)), u=0.01, arm=ARM)
        yield f"atlas {name}", float(answer["M"]), float(answer["rotation"])


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("places", [stored, answered])
def test_m_and_rotation_are_positive_under_a_pull_above_mudline(places, tmp_path: Path) -> None:
    found = {name: (M, rotation) for name, M, rotation in places(tmp_path)}
    assert len(found) > 4
    assert {name: pair for name, pair in found.items() if not min(pair) > 0.0} == {}


def test_h_and_m_of_a_motion_are_coupled_by_a_negative_stiffness() -> None:
    springs = synthetic.make_springs((PULL,))
    three, six = stiffness(springs).values, stiffness_six(springs).values
    assert three[0, 2] < 0.0 and three[2, 0] < 0.0
    assert six[0, 4] < 0.0 < six[1, 3]  # y to the left of x, z up
