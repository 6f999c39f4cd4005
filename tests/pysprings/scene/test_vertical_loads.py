# SPDX-License-Identifier: MIT
"""`[springs] vertical_loads = "from cases"`: its loads, what `check` shows of them, refusals, and the run."""

import json
from pathlib import Path

import pytest

from pysprings.core.errors import UserInputError
from pysprings.core.storage import read_tree
from pysprings.macro.predict import predict
from pysprings.model.forecast.estimate import describe
from pysprings.scene.load import load_scene, parse_scene
from pysprings.springs.springs import Springs
from tests.support.commands import command

SCENE = """title = "clay"
[caisson]
vertical_load = "1 MN"
[domain]
radius = "24 m"
depth = "12 m"
[soil]
yield_surface = "tresca"
undrained_shear_strength = "30 kPa"
rigidity_ratio = 200
effective_unit_weight = "7 kN/m^3"
[interface]
adhesion_factor = 0.65
[springs]
reach = "20 mm"
rays = ["0 deg", "90 deg"]
vertical = false
held_back = false
vertical_loads = "from cases"
[mesh]
preset = "coarse"
[design]
cases = "tables/loads.csv"
[output]
figures = "none"
"""
CASES = """name,H [kN],arm [m],V [MN]
still,0,,4
calm,300,2,
near,300,2,1.05
storm,500,2,2
heavy,300,2,2.1
light,300,2,0.5
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    (tmp_path / "tables").mkdir()
    (tmp_path / "tables" / "loads.csv").write_text(CASES, encoding="utf-8")
    file = tmp_path / "clay.toml"
    file.write_text(SCENE, encoding="utf-8")
    return file


def test_loads_are_those_of_the_cases_and_are_written_into_the_scene(scene: Path) -> None:
    loaded = load_scene(scene)
    assert loaded.springs.vertical_loads == pytest.approx((0.5e6, 2e6))
    again = parse_scene(loaded.source_text)  # what a run keeps needs no table
    assert again.springs == loaded.springs and "from cases" not in loaded.source_text
    assert load_scene(scene, ['caisson.vertical_load="2 MN"']).springs.vertical_loads == pytest.approx((0.5e6, 1.05e6))
    moved = scene.parent / "moved.csv"
    (scene.parent / "tables" / "loads.csv").rename(moved)
    assert load_scene(scene, ["design.cases=moved.csv"]).sha256 == loaded.sha256  # nothing depends on its name


def test_check_shows_loads_paths_time_and_cases(scene: Path) -> None:
    about = describe(load_scene(scene))
    rows = about["vertical_loads"]
    assert [(row["V_N"], row["paths"], row["cases"]) for row in rows] == [(1e6, 2, 2), (0.5e6, 2, 1), (2e6, 2, 3)]
    assert sum(row["time_s"] for row in rows) == pytest.approx(about["time_s"])
    far = describe(load_scene(scene, ['springs.vertical_loads=["0.5 MN"]']))["warnings"]
    assert "V of 2 load cases is more than 10 % from that of all springs: storm, heavy" in far
    (one,) = (text for text in describe(load_scene(scene, ['springs.vertical_loads=["0.5 MN", "2.3 MN"]']))["warnings"]
              if "load case" in text)  # fmt: skip
    assert one == "V of 1 load case is more than 10 % from that of all springs: storm"
    assert "springs by vertical load" in command("check", scene).out


@pytest.mark.parametrize(
    ("change", "table", "message"),
    [
        ("", None, "{folder}/tables/loads.csv: no such file"),
        ("", "name,H [kN],V [MN]\na,5,x\n", "{folder}/tables/loads.csv:2: V [MN]: \"x\" is not a number"),
        ("", "name,H [kN]\na,5\n", "{folder}/tables/loads.csv: V: no case has one: springs.vertical_loads takes its"),
        ("", "name,H [kN],V [MN]\na,5,\nb,0,2\n",
         "{folder}/tables/loads.csv: V: no case that has one has a lateral load: springs.vertical_loads takes its"),
        ("", "H [kN],V [MN]\n" + "".join(f"1,{1.3**k:.3f}\n" for k in range(2, 12)),
         "{folder}/tables/loads.csv: V: from 1.69 MN to 17.922 MN: 10 further sets of springs, at most 8; list"),
        ('cases = "tables/loads.csv"', CASES, '{scene}:19:18: springs.vertical_loads: "from cases" needs [design]'),
        ('reach = "20 mm"', CASES, '{scene}:18:18: springs.vertical_loads: "from cases" needs [design] cases = '
         '"loads.csv" and [springs] reach'),
        ('vertical_load = "1 MN"', CASES, '{scene}:2:1: caisson.vertical_load: springs.vertical_loads = "from cases" '
         "needs a number here"),
    ],
)  # fmt: skip
def test_refusals(scene: Path, change: str, table: str | None, message: str) -> None:
    file = scene.parent / "tables" / "loads.csv"
    file.unlink() if table is None else file.write_text(table, encoding="utf-8")
    scene.write_text(SCENE.replace(f"{change}\n", "") if change else SCENE, encoding="utf-8")
    with pytest.raises(UserInputError) as error:
        load_scene(scene)
    (line,) = str(error.value).split("\n")
    assert line.startswith("fatal: user input: " + message.format(folder=scene.parent, scene=scene))


def test_a_table_that_is_not_there_is_refused_before_anything_is_computed(scene: Path) -> None:
    """Also where no vertical load is taken from it."""
    scene.write_text(SCENE.replace('"from cases"', '["2 MN"]').replace("loads.csv", "none.csv"), encoding="utf-8")
    for name in ("check", "run", "capacity"):
        done = command(name, scene)
        assert done.code == 2 and done.err.strip() == f"fatal: user input: {scene.parent}/tables/none.csv: no such file"


def test_the_word_is_of_scene_files() -> None:
    from pysprings import Scene

    with pytest.raises(ValueError, match='or, in a scene file, "from cases"'):
        Scene(springs={"vertical_loads": "from cases"})


@pytest.mark.slow
def test_each_case_of_a_run_is_answered_by_the_springs_at_its_load(
    scene: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without a table `design` takes that of the scene; a case at a set's V has the H of the full model at that V."""
    monkeypatch.chdir(scene.parent)
    assert command("run", "clay.toml", "--out", "out", "--jobs", "1").code == 0
    done = command("design", "out", "--out", "a.png", "--out", "a.csv", "--json")
    assert done.code == 0, done.err
    assert command("design", "out").out.startswith(
        "load cases: tables/loads.csv as it is now ([design] cases of the run)"
    )
    rows = {row["name"]: row for row in json.loads(done.out)["cases"]}
    at = {name: round(1e-6 * row["V_springs_N"], 3) for name, row in rows.items()}
    assert at == {"calm": 1.0, "near": 1.0, "storm": 2.0, "heavy": 2.0, "light": 0.5, "still": 2.0}
    assert "at V" not in rows.pop("still")["marks"]  # which has w of the elastic stiffness
    assert {row["marks"] for row in rows.values()} == {"off the calibrated paths"}  # rays 90 degrees apart; none of V
    springs = Springs.of(read_tree(Path("out/springs.nc")))
    for name, suffix in (("calm", ""), ("storm", "_load_2"), ("light", "_load_1")):  # those springs alone
        alone = springs.with_paths([springs.paths[f"ray_{angle}{suffix}"] for angle in (0, 90)])
        assert alone.main_paths == tuple(alone.paths) and len(alone.load_sets) == 1
        with pytest.warns(UserWarning):  # two rays are 90 degrees apart
            own = predict(alone, H=rows[name]["H_N"], M=rows[name]["M_Nm"])
        assert rows[name]["u_m"] == pytest.approx(float(own["u"]), rel=1e-6)
    assert abs(rows["light"]["u_m"] / rows["calm"]["u_m"] - 1.0) > 1e-4  # other springs than those at rest
    assert (scene.parent / "a.png").read_bytes()[:4] == b"\x89PNG"
    Path("tables/loads.csv").unlink()
    assert (
        "tables/loads.csv, [design] cases of the run as seen from where it ran, is not there"
        in command("design", "out").err
    )
