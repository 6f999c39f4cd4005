# SPDX-License-Identifier: MIT
"""The whole command: help, version, usage."""

from typing import get_args

import pytest
from typer.main import get_command

from pysprings import __version__
from pysprings.cli import app
from pysprings.core.words import Discretisation, MeshPreset, TargetError
from pysprings.full_model.accuracy.target import TARGETS
from pysprings.macro.spring_sets import SPRING_SETS
from pysprings.results.exporters import EXPORTERS
from pysprings.scene.fields import field_of
from pysprings.scene.load import SECTIONS
from pysprings.scene.template import template_names
from pysprings.studies.atlas.families import FAMILIES
from pysprings.studies.atlas.model import shipped
from tests.support.commands import command, run_python


@pytest.mark.parametrize("args", [["--help"], ["--version"], ["run", "--help"], ["predict", "--help"]])
def test_help_loads_nothing_heavy(args: list[str]) -> None:
    """typer itself may bring pydantic; everything else heavy, and our own models, must stay out."""
    heavy = {"dash", "numpy", "scipy", "pandas", "xarray", "numba", "matplotlib", "pint", "netCDF4", "fe_engine"}
    code = (
        f"import sys; sys.argv = ['pysprings', *{args!r}]\n"
        "from pysprings.cli.app import main\n"
        "try: main()\n"
        "except SystemExit as end: assert not end.code, end.code\n"
        f"print(sorted(name for name in {heavy!r} if sys.modules.get(name)), file=sys.stderr)\n"
        "print([name for name in sys.modules if name.startswith('pysprings.scene.load')], file=sys.stderr)\n"
    )
    done = run_python("-c", code)
    assert done.returncode == 0, done.stderr
    assert done.stderr == "[]\n[]\n"


def test_python_dash_m_and_version() -> None:
    done = run_python("-m", "pysprings", "--version")
    assert (done.returncode, done.stdout.splitlines()[0], done.stderr) == (0, f"pysprings {__version__}", "")


def test_the_list_of_commands_is_that_of_the_whole_program() -> None:
    """Without a command it is on stderr, as wrong usage; no description is cut short."""
    done, none = run_python("-m", "pysprings", "--help"), run_python("-m", "pysprings")
    assert done.stdout.split() == none.stderr.split() == command("--help").out.split()
    assert all(f" {name} " in done.stdout for name in app.COMMANDS)
    assert "...\n" not in done.stdout.partition("Commands:")[2]
    assert (done.returncode, none.returncode, none.stdout) == (0, 2, "")


def test_help_tells_the_exit_codes() -> None:
    text = " ".join(command("--help").out.split())
    assert "2 user input" in text
    assert "130" in text


@pytest.mark.parametrize("name", sorted(get_command(app.application()).commands))
def test_help_shows_every_bracket_of_its_texts(name: str) -> None:
    """Texts with `[word]` arrive whole."""
    known = get_command(app.application()).commands[name]
    texts = [known.help, *(text for param in known.params if (text := getattr(param, "help", None)))]
    assert len(texts) > 1
    assert not [text for text in texts if "".join(text.split()) not in shown(name)]


def shown(name: str) -> str:
    """Text of a help page without the spaces, by which its lines are broken."""
    return "".join(command(name, "--help").out.split())


def test_help_lists_the_names_that_options_accept() -> None:
    for page, names in (
        ("init", template_names()),
        ("predict", [f"{each.name} (" for each in SPRING_SETS]),
        ("compare", SPRING_SETS.names()),
        ("export", EXPORTERS.names()),
        ("springs", [each.name for each in EXPORTERS if each.is_spring_file]),
        ("run", [*get_args(MeshPreset), *get_args(Discretisation), *get_args(TargetError)]),
        ("atlas", FAMILIES.names()),
        ("predict", shipped()),
        ("size", shipped()),
    ):
        text = shown(page)
        assert len(names) > 1
        assert not [name for name in names if name.replace(" ", "") not in text]


def test_words_of_options_are_those_of_the_scene_and_the_presets() -> None:
    mesh = SECTIONS["mesh"].model_fields
    assert get_args(MeshPreset) == field_of(mesh["preset"]).words
    assert ("auto", *get_args(Discretisation)) == field_of(mesh["discretisation"]).words
    assert TARGETS == {"5%": 5.0, "2%": 2.0, "1%": 1.0, "0.5%": 0.5}


def test_wrong_usage_is_exit_2() -> None:
    assert command("check").code == 2
    assert command("nonsense").code == 2
    assert command("run", "x.toml", "--mesh", "huge").code == 2
