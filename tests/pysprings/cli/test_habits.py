# SPDX-License-Identifier: MIT
"""Options that people expect: --set, --quiet, --log, --no-figures, --tilt, --out."""

import json
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from pysprings.cli.run import RunOptions
from pysprings.scene.load import load_scene
from pysprings.springs.checks import save_springs
from tests.support import tiny
from tests.support.commands import command
from tests.support.fans import fan_springs, potential
from tests.support.files import read_record

SET = {
    'soil.young_modulus="80 MPa"': lambda scene: scene.soil.young_modulus == 80e6,
    "soil.young_modulus=80 MPa": lambda scene: scene.soil.young_modulus == 80e6,
    "soil.poisson_ratio=0.25": lambda scene: scene.soil.poisson_ratio == 0.25,
    'limit.rotation="2 deg"': lambda scene: scene.limit.rotation == pytest.approx(np.radians(2.0)),
    'path.pull.arm="5 m"': lambda scene: scene.paths[0].arm == 5.0,
    "title=Another": lambda scene: scene.title == "Another",
    "output.figures=true": lambda scene: scene.output.pictures == "report",
    'output.figures="report"': lambda scene: scene.output.pictures == "report",
    'output.figures="all"': lambda scene: scene.output.pictures == "all",
}


@pytest.mark.parametrize("change", SET, ids=SET.keys())
def test_a_value_is_set(scene_file: Path, change: str) -> None:
    """The scene is that of a file with the value in it; its own text has it, too."""
    scene = load_scene(scene_file, [change])
    assert SET[change](scene)
    assert scene.sha256 != load_scene(scene_file).sha256
    assert json.loads(command("check", scene_file, "--set", change, "--json").out)["scene_sha256"] == scene.sha256
    again = scene_file.with_name("again.toml")
    again.write_text(scene.source_text, encoding="utf-8")
    assert load_scene(again) == scene


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ("soil.young_modulus", '--set: "soil.young_modulus" is not KEY=VALUE'),
        ("soil.young_modulus=80", '--set: soil.young_modulus: expected a quantity with unit such as "200 MPa"'),
        ("soil.young_modolus=80 MPa", "--set: soil.young_modolus: unknown key (did you mean 'young_modulus'?)"),
        ("soil.poisson_ratio=0.7", "--set: soil.poisson_ratio: 0.7 is not in [0, 0.5)"),
        ("path.storm.arm=5 m", "--set path.storm.arm: no 'storm'; there are: pull"),
        ("title.x=1", "--set title.x: 'title' is a value, not a table"),
        ("path.arm=5 m", "--set path.arm: is a list: name one of its tables, and a key of it"),
    ],
)
def test_a_wrong_value_is_refused_in_one_line(scene_file: Path, change: str, says: str) -> None:
    done = command("check", scene_file, "--set", change)
    assert (done.code, done.out) == (2, "")
    assert done.err.startswith(f"fatal: user input: {says}")
    assert len(done.err.splitlines()) == 1


def test_a_value_of_one_of_two_layers_of_a_name_is_refused(tmp_path: Path) -> None:
    """The first of them alone would change."""
    layer = """[[soil.layer]]
name = "clay"
law = "tresca"
undrained_shear_strength = "40 kPa"
rigidity_ratio = 200
effective_unit_weight = "8 kN/m^3"
"""
    text = f'{layer}top = "0 m"\n{layer}top = "3 m"\n[interface]\nadhesion_factor = 0.6\n'
    (tmp_path / "a.toml").write_text(text)
    assert command("check", tmp_path / "a.toml").code == 0
    done = command("check", tmp_path / "a.toml", "--set", "soil.layer.clay.rigidity_ratio=300")
    assert done.code == 2 and "2 have the name 'clay': give each a name of its own" in done.err


def test_a_quiet_run_without_pictures_and_its_log(tmp_path: Path) -> None:
    """Nothing on the terminal; progress, with times, in the log; the scene is the same, so that a run can go on."""
    scene = tiny.scene(output={"figures": True})
    file, out, log = tiny.write(scene, tmp_path / "caisson.toml"), tmp_path / "out", tmp_path / "run.log"
    done = command("run", file, "--out", out, "--quiet", "--no-figures", "--log", log, "--set", "soil.K0=0.9")
    assert (done.code, done.out, done.err) == (0, "", "")
    assert not (out / "figures").exists()
    assert read_record(out)["scene_sha256"] == scene.replace(soil={"K0": 0.9}).sha256
    lines = log.read_text(encoding="utf-8").splitlines()
    assert all(re.match(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\+00:00 ", line) for line in lines)
    assert any(re.search(r"\d %", line) for line in lines)
    refused = command("run", file, "--out", out, "--log", log)
    assert refused.code == 2
    assert "holds results already" in log.read_text(encoding="utf-8").splitlines()[-1]
    assert command("run", file, "--out", out, "--log", tmp_path).code == 2


@pytest.fixture
def fan_file(tmp_path: Path) -> Path:
    return save_springs(fan_springs(potential), tmp_path / "fan.nc")


@pytest.mark.parametrize("arm", ["2 m", "-1 m"])
def test_the_load_of_a_tilt(fan_file: Path, arm: str) -> None:
    """H > 0 whatever way the caisson turns; under that load it has the tilt."""
    (state,) = json.loads(command("predict", fan_file, "--tilt", "0.02 deg", "--arm", arm, "--json").out)["states"]
    assert abs(np.degrees(state["rotation"])) == pytest.approx(0.02, rel=1e-9)
    assert state["H"] > 0.0
    back = command("predict", fan_file, "--H", f"{state['H']!r} N", "--arm", arm, "--json")
    assert abs(np.degrees(json.loads(back.out)["states"][0]["rotation"])) == pytest.approx(0.02, rel=1e-6)
    far = command("predict", fan_file, "--tilt", "5 deg", "--arm", arm)
    assert (far.code, far.out) == (2, "")
    assert "beyond the range" in far.err
    assert command("predict", fan_file, "--tilt", "1 deg", "--H", "1 MN").code == 2


@pytest.mark.parametrize("ending", ["csv", "json", "nc"])
def test_answers_go_into_a_file(fan_file: Path, tmp_path: Path, ending: str) -> None:
    out = tmp_path / f"answer.{ending}"
    asked = ("predict", fan_file, "--u-max", "2 mm", "--arm", "2 m", "--points", "5")
    done = command(*asked, "--out", out)
    assert (done.code, done.out) == (0, f"{out}\n")
    states = json.loads(command(*asked, "--json").out)["states"]
    if ending == "csv":
        made = pd.read_csv(out, comment="#")["H_N"].to_list()
    elif ending == "json":
        made = [state["H"] for state in json.loads(out.read_text())["states"]]
    else:
        with xr.open_dataset(out) as data:
            made = data["H"].values.tolist()
    assert made == pytest.approx([state["H"] for state in states], rel=1e-12)
    refused = command(*asked, "--out", tmp_path / "answer.docx")
    assert (refused.code, "csv, json or nc" in refused.err) == (2, True)


def test_pictures_by_word_flag_and_format(tmp_path: Path) -> None:
    """The flag counts, not the scene; the other words are refused together, and a resumed run has the same flags."""
    file = tiny.write(tiny.scene(output={"figures": False}), tmp_path / "caisson.toml")
    out = tmp_path / "out"
    assert command("run", file, "--out", out, "--figures", "report", "--figure-format", "svg", "--quiet").code == 0
    drawn = {path.name for path in (out / "figures").iterdir()}
    assert {"pull_py.svg", "pull_profiles.svg"} < drawn and "pull_newton.png" not in drawn
    assert all(name.endswith(".svg") or f"{name[:-4]}.svg" not in drawn for name in drawn)
    page = (out / "report.html").read_text(encoding="utf-8")
    assert page.count("<figure") == len(drawn) + 1  # the sketch of the axes
    both = command("run", file, "--out", out, "--figures", "all", "--no-figures", "--force")
    assert (both.code, both.out) == (2, "")
    assert both.err == "fatal: user input: --no-figures: give either this or --figures all\n"
    assert RunOptions(figures="all", format="png,svg").command(file, out) == (
        f"pysprings run {file} --out {out} --figures all --figure-format png,svg --resume"
    )


MISSPELT = {  # command (of the files below) -> the name that is meant
    "run scene.toml --mesh corse": "coarse",
    "init x.toml --template sofclay": "soft-clay",
    "run scene.toml --set mesh.prest=coarse": "preset",
    "check scene.toml --set mesh.preset=corse": "coarse",
    "run scene.toml --set path.pul.arm=5m": "pull",
    "element scene.toml --test triaxal": "triaxial",
    "stability --case papr": "paper",
    "springs fan.nc --format xslx": "xlsx",
    "export fan.nc --to openfst": "openfast",
    "export fan.nc --to openfast --option matrx=tangent": "matrix",
    "export fan.nc --to openfast --option matrix=tangnt": "tangent",
    "predict fan.nc --springs fann --H 1kN": "fan",
    "predict fan.nc --H 1kNN": "kN",
    "compare fan.nc --springs fna": "fan",
    "predict --atlas clya --H 1MN": "clay",
}


@pytest.mark.parametrize("line", MISSPELT, ids=MISSPELT.keys())
def test_a_misspelt_name_is_refused_with_the_one_that_is_near(line: str, scene_file: Path, tmp_path: Path) -> None:
    save_springs(fan_springs(potential), tmp_path / "fan.nc")
    places = {"scene.toml": scene_file, "fan.nc": tmp_path / "fan.nc", "x.toml": tmp_path / "x.toml"}
    done = command(*(places.get(word, word) for word in line.split()))
    said = " ".join(done.err.split())
    assert (done.code, re.findall(r"did you mean ['\"](.*?)['\"]\?", said)) == (2, [MISSPELT[line]]), said
