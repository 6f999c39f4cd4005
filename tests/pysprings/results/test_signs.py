# SPDX-License-Identifier: MIT
"""Signs of the field wherever M or a rotation is stored, printed or drawn: a pull above mudline has both positive."""

import json
import math
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import openpyxl
import pandas as pd
import pytest
import xarray as xr

import pysprings
from pysprings.core.tables.load_cases import read_load_cases
from pysprings.full_model.run_record import RunRecord, Status
from pysprings.macro.capacity import capacities
from pysprings.macro.model import MacroModel
from pysprings.macro.predict import impose, predict, sequence
from pysprings.macro.stiffness import stiffness, stiffness_six
from pysprings.memory.build import build_memory
from pysprings.memory.stepper import MemoryStepper
from pysprings.results.exporters import export
from pysprings.results.exporters.tables import load_displacement, py_long, py_wide
from pysprings.results.plots.files import figures
from pysprings.results.plots.overview import overview
from pysprings.results.summary import summary
from pysprings.results.tables import open_table
from pysprings.springs.checks import open_springs, save_springs
from pysprings.springs.springs import Springs
from pysprings.studies.atlas.model import open_atlas, shipped
from pysprings.studies.design import answer_cases
from pysprings.studies.sizing import Search, Wanted
from tests.support import synthetic, tiny, winkler
from tests.support.commands import command
from tests.support.files import Outline

PULL = synthetic.Path("pull", arm=8.0)
TURN = synthetic.Path("turn", "rotation", size=2e-3)
H, ARM = 1e5, 8.0
TURNING = re.compile(  # headings of moments and rotations
    r"(.*(model|springs:) )?(end_)?(rotation|M|m|m net)(_(end|full|macro|tip|lid|outer|inner|rad|Nm|Nm_per_m))*"
    r"( z=.*| \[.*| of the caisson \[.*| about the lid centre \[.*)?"
)


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


# --- files and pictures of a run whose paths lean towards +x ---

PATHS = (
    {"name": "pull", "kind": "pull", "lateral_displacement": 1e-3, "arm": ARM},
    {"name": "turn", "kind": "rotation", "rotation": 2e-4},
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("run")
    file = tiny.write(tiny.scene(paths=PATHS, design={"lateral_force": H, "arm": ARM}), place / "caisson.toml")
    assert command("run", file, "--out", place / "out", "--quiet", "--no-estimate-error").code == 0
    return place / "out"


def turning(name: object) -> bool:
    """Return whether a heading is that of a moment or a rotation."""
    return TURNING.fullmatch(str(name)) is not None


def in_netcdf(folder: Path) -> Iterator[tuple[str, float]]:
    """M, its parts, m summed over the skirt, and the rotation, at the ends of all paths."""
    for file in ("full_model.nc", "springs.nc"):
        with xr.open_datatree(folder / file) as tree:
            for path in PATHS:
                last = tree[f"paths/{path['name']}"].to_dataset().isel(step=-1)
                for name in filter(turning, map(str, last)):
                    yield f"{file} {path['name']} {name}", float(last[name].sum())


def in_tables(folder: Path) -> Iterator[tuple[str, float]]:
    for file in ("load_displacement.csv", "py.csv", "py_wide.csv", "compare.csv"):
        table = pd.read_csv(folder / file)
        last = table[table["step"] == table.groupby("path")["step"].transform("max")] if "step" in table else table
        for path, rows in last.groupby("path"):
            for name in filter(turning, table):
                yield f"{file} {path} {name}", float(rows[name].sum())


def in_cells(folder: Path) -> Iterator[tuple[str, float]]:
    """The last row of each path on each sheet of the workbook."""
    for sheet in openpyxl.load_workbook(folder / "springs.xlsx", read_only=True):
        rows = [list(row) for row in sheet.iter_rows(values_only=True)]
        heads = next((row for row in rows if "path" in row), [])
        last = {row[heads.index("path")]: row for row in rows if heads and row[heads.index("path")] in ("pull", "turn")}
        for path, row in last.items():
            for column in (k for k, name in enumerate(heads) if turning(name)):
                yield f"{sheet.title} {path} {heads[column]}, column {column}", float(row[column])


def in_report(folder: Path) -> Iterator[tuple[str, float]]:
    """The table of loads of all paths, and the range of each path in words."""
    lines = Outline((folder / "report.html").read_text(encoding="utf-8")).lines
    cells = [
        [
            cell.rpartition("]")[2].strip() if "rotation [" not in line else cell.split("] ", 1)[-1].strip()
            for cell in line.split(" |")
        ]
        for line in lines
    ]
    heads = next(row for row in cells if "rotation [mrad]" in row)
    for row in (row for row in cells if len(row) == len(heads) and row[1] in ("pull", "turn")):
        for name in filter(turning, heads):
            yield f"report {row[1]} {name}", float(row[heads.index(name)].replace(",", ""))
    for line in (line for line in lines if "rotation from" in line):
        yield line, float(re.search(r"rotation from \S+ to (\S+) mrad", line)[1])


def in_heads(folder: Path) -> Iterator[tuple[str, float]]:
    """Ends of the paths in the head of a matrix, and its entries, that couple M to the u that it holds back."""
    export(pysprings.open_springs(folder / "springs.nc"), "subdyn", folder / "subdyn")
    (head,) = (each.read_text() for each in (folder / "subdyn").glob("*ssi.dat"))
    rows = re.findall(r"! (pull|turn) +calibration +\S+ +(\S+) ", head)
    assert len(rows) == 2
    yield from ((f"head {name}", float(value)) for name, value in rows)
    yield "Kxty", -float(re.search(r"(\S+) +Kxty\n", head)[1])


def drawn(folder: Path) -> Iterator[tuple[str, float]]:
    """Ends of the curves on axes of a moment or a rotation; how much deeper the front of the dashed caisson is."""
    result = pysprings.open_result(folder)
    for name, figure in figures(result, pysprings.open_springs(folder / "springs.nc"), {}):
        for axes in figure.axes:
            lines = [(line, *map(np.asarray, line.get_data())) for line in axes.lines]
            curves = [each for each in lines if each[1].size > 2]
            for label, of in ((axes.get_xlabel(), 1), (axes.get_ylabel(), 2)):
                for curve in curves if turning(label) else ():
                    yield f"{name}: {label}, {curve[0].get_label()}", float(curve[of][-1])
            if "_section_" in name and curves:
                ((_, x, depth),) = curves
                yield f"{name}, {axes.get_ylabel()}", float(depth[x > 0.0].mean() - depth[x < 0.0].mean())


WALKS = {in_netcdf: 24, in_tables: 30, in_cells: 30, in_report: 6, in_heads: 3, drawn: 20}


@pytest.mark.parametrize("walk", WALKS, ids=lambda each: each.__name__)
def test_every_moment_and_rotation_of_a_run_is_positive(walk, folder: Path) -> None:
    found = dict(walk(folder))
    assert len(found) >= WALKS[walk], found
    assert {place: value for place, value in found.items() if not value > 0.0} == {}


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_summary_has_the_sign_of_m(sign: float) -> None:
    result = synthetic.make_result((replace(TURN, size=sign * TURN.size),))
    loads = summary(result, RunRecord(Status.COMPLETE, scene_toml=tiny.scene().to_toml()))["loads"]
    (M,), (turn,) = re.findall(r"M (\S+) MN m", loads), {*re.findall(r", (\S+) deg", loads)}
    assert sign * float(M) > 0.0 and sign * float(turn) > 0.0


# --- answers that go on step by step, and sizes ---


def test_a_stepper_leans_in_the_direction_of_its_load() -> None:
    model = build_memory(Springs.of(winkler.with_invented_memory()))
    stepper = MemoryStepper(model)
    u, rotation = stepper.advance(load=(H, ARM * H))
    assert u > 0.0 and rotation > 0.0
    assert stepper.tangent[0, 1] < 0.0 and stepper.tangent[1, 0] < 0.0
    assert MemoryStepper(model).advance(motion=(0.0, rotation))[1] > 0.0


def test_a_size_for_m_is_that_for_its_height_and_larger_than_for_m_against_h(tmp_path: Path) -> None:
    atlas = open_atlas("clay")
    use = []
    for load in ("arm [m]\na,800,10", "M [MN m]\na,800,8", "M [MN m]\na,800,-8"):
        (tmp_path / "cases.csv").write_text(f"name,H [kN],{load}\n", encoding="utf-8")
        wanted = Wanted(read_load_cases(tmp_path / "cases.csv"), math.radians(0.5), 0.8)
        use.append(Search(atlas, wanted).at(10.0, 8.0).use)
    assert use[0] == pytest.approx(use[1]) and use[0] > 1.1 * use[2]
