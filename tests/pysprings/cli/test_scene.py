# SPDX-License-Identifier: MIT
"""`init` and `check`."""

import json
import shlex
from pathlib import Path

import pytest

from pysprings.cli.run import RunOptions
from pysprings.core.text import number
from pysprings.full_model.accuracy.target import start
from pysprings.model.forecast.estimate import describe
from pysprings.scene.load import load_scene, parse_scene
from pysprings.scene.template import template_names, template_text
from tests.support import tiny
from tests.support.commands import command


def test_init_writes_scene_and_schema() -> None:
    done = command("init")
    assert (done.code, done.out) == (0, "caisson.toml\npysprings.schema.json\n")
    assert done.err == "next: pysprings check caisson.toml\n"
    assert load_scene("caisson.toml") == parse_scene(template_text("caisson"))
    assert Path("caisson.toml").read_text().startswith("#:schema ./pysprings.schema.json\n")
    assert json.loads(Path("pysprings.schema.json").read_text())["title"] == "pysprings scene"


def test_init_makes_folders() -> None:
    """A name with a blank, too; the command that is named next is one that a shell takes."""
    assert command("init", "a/b c/d.toml").err == "next: pysprings check 'a/b c/d.toml'\n"
    assert Path("a/b c/d.toml").exists()
    assert Path("a/b c/pysprings.schema.json").exists()
    resumed = RunOptions().command(Path("a b.toml"), Path("c d"))
    assert shlex.split(resumed) == ["pysprings", "run", "a b.toml", "--out", "c d", "--resume"]


def test_init_never_overwrites_without_force() -> None:
    Path("caisson.toml").write_text("mine")
    Path("pysprings.schema.json").write_text("mine too")
    done = command("init")
    assert (done.code, done.out) == (2, "")
    message = "caisson.toml: exists already; choose another name, or --force to replace it"
    assert done.err == f"fatal: user input: {message}\n"
    assert Path("caisson.toml").read_text() == "mine"
    other = command("init", "other.toml")
    kept = "the schema that was there is kept; --force renews it\n"
    assert (other.out, other.err) == ("other.toml\n", f"{kept}next: pysprings check other.toml\n")
    assert Path("pysprings.schema.json").read_text() == "mine too"
    assert command("init", "--force").code == 0
    assert load_scene("caisson.toml") == parse_scene(template_text("caisson"))
    assert Path("pysprings.schema.json").read_text() != "mine too"


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["--template", "paper-draind"], "--template: no template 'paper-draind' (did you mean 'paper-drained'?)"),
        (["--template", "x"], f"--template: no template 'x' (there is: {', '.join(template_names())})"),
        (["pysprings.schema.json"], "pysprings.schema.json: is the name of the schema; choose another for the scene"),
        (["file/x.toml"], "file: cannot be written (File exists)"),
    ],
)
def test_init_refuses(args: list[str], message: str) -> None:
    Path("file").write_text("")
    done = command("init", *args)
    assert (done.code, done.out, done.err) == (2, "", f"fatal: user input: {message}\n")


# --- check ---


@pytest.fixture
def scene_file() -> Path:
    return tiny.write(tiny.scene(), Path("caisson.toml"))


def test_check_json_is_the_description_of_the_scene(scene_file: Path) -> None:
    done = command("check", scene_file, "--json")
    data, scene = json.loads(done.out), load_scene(scene_file)
    about = describe(scene)
    assert (data["scene_sha256"], data["title"]) == (scene.sha256, scene.title)
    assert data["paths"] == [{"name": "pull", "kind": "pull", "role": "calibration"}]
    assert data["mesh"]["nodes"] == about["mesh"]["nodes"] > 100
    assert data["unknowns"] == about["unknowns"]
    assert [each["what"] for each in data["left_out"]] == [each["what"] for each in about["left_out"]]
    assert len(data["left_out"]) > 3


def test_check_prints_what_its_json_holds(scene_file: Path) -> None:
    data = json.loads(command("check", scene_file, "--json").out)
    done = command("check", scene_file)
    assert done.code == 0
    lines = [" ".join(line.split()) for line in done.out.splitlines()]
    assert lines[0] == f"caisson.toml: {data['title']}"
    assert f"nodes {number(data['mesh']['nodes'])}" in lines
    assert f"memory, estimated [GB] {number(data['memory_GB'])}" in lines
    for each in data["left_out"]:
        assert f"- {each['what']}: {' '.join(each['why'].split())}" in lines


def test_check_with_another_mesh(scene_file: Path) -> None:
    coarse, fine = (json.loads(command("check", scene_file, "--mesh", m, "--json").out) for m in ("coarse", "fine"))
    assert fine["unknowns"] > 2 * coarse["unknowns"]
    assert fine["scene_sha256"] == load_scene(scene_file).replace(mesh={"preset": "fine"}).sha256


def test_check_of_a_target_error_names_the_first_run_and_what_may_follow(scene_file: Path) -> None:
    """A further mesh has 1.2 to 2 times the cells in each direction; a run grows with the third power."""
    about = json.loads(command("check", scene_file, "--target-error", "2%", "--json").out)
    target = about["target_error"]
    assert (target["target"], target["begins_with"], target["runs_at_most"]) == ("2%", "medium", 4)
    assert (target["further_run_least"], target["further_run_most"]) == pytest.approx((1.2**3, 8.0))
    assert about["scene_sha256"] == start(load_scene(scene_file), "2%").sha256


def test_check_refuses_a_scene_with_every_problem() -> None:
    bad = "[interface]\nfriction_coeficient = 0.5\n[caisson]\nposition = 1\n[domain]\nside = 3\n"
    Path("bad.toml").write_text(tiny.grounded(bad))
    done = command("check", "bad.toml")
    assert (done.code, done.out) == (2, "")
    assert done.err == (
        "fatal: user input: bad.toml:2:1: interface.friction_coeficient: unknown key "
        "(did you mean 'friction_coefficient'?)\n"
        "fatal: user input: bad.toml:4:1: caisson.position: unknown key\n"
        'fatal: user input: bad.toml:6:8: domain.side: expected one of "roller", "fixed", got 3\n'
    )
