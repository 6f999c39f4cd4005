# SPDX-License-Identifier: MIT
"""Exporters as plug-ins: one from outside the package, through Python and the command line."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from pysprings.cli.app import application
from pysprings.core.errors import UserInputError
from pysprings.core.written import listed
from pysprings.results import exporters
from pysprings.results.exporters import EXPORTERS, Exported, Exporter, Option, Source, Target
from pysprings.results.layout import own_folders, remove_results, run_files
from pysprings.springs.checks import save_springs
from pysprings.springs.path import paths_of
from tests.support import synthetic


def write(source: Source, target: Target, options: exporters.base.Options) -> Exported:
    """Write the largest load of each path, and an index of the files."""
    files = [
        target.write(f"{name}.txt", f"{options['factor'] * abs(source.springs[f'paths/{name}/H']).max():.10g}\n")
        for name in paths_of(source.springs)
    ]
    index = target.write("index.json", json.dumps({key: options[key] for key in ("V", "form", "signed")}))
    return Exported([*files, index], ["the toy has no moments"])


TOY = Exporter(
    name="toy",
    description="largest load of each path",
    write=write,
    suffixes=(".txt", ".json"),
    options=(
        Option("factor", "multiplies each load", 1),
        Option("V", "vertical load", unit="N", example="4 MN"),
        Option("form", "form of the table", "long", choices=("long", "short")),
        Option("signed", "keep signs", False),
    ),
)


@pytest.fixture
def toy() -> Iterator[Exporter]:
    with EXPORTERS.added(TOY) as exporter:
        yield exporter


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    save_springs(synthetic.make_springs(), tmp_path / "out" / "springs.nc")
    return tmp_path / "out"


def command(*args: object) -> Any:
    return CliRunner().invoke(application(), [str(arg) for arg in args], prog_name="pysprings")


def test_python(toy: Exporter, tmp_path: Path) -> None:
    springs = synthetic.make_springs()
    done = exporters.export(springs, "toy", tmp_path / "new" / "place", factor=2)
    assert [file.name for file in done.files] == ["pull.txt", "index.json"]
    largest = float(abs(springs["paths/pull/H"]).max())
    assert float(done.files[0].read_text()) == pytest.approx(2.0 * largest, rel=1e-9)


def test_command_line(toy: Exporter, folder: Path, tmp_path: Path) -> None:
    options = ("--option", "factor=3", "--option", "V=4 MN", "--option", "signed=true")
    done = command("export", folder, "--to", "toy", "--out", tmp_path / "there", *options)
    assert (done.exit_code, done.stderr) == (0, "note: the toy has no moments\n")
    assert done.stdout.split() == [str(tmp_path / "there" / name) for name in ("pull.txt", "index.json")]
    assert json.loads((tmp_path / "there" / "index.json").read_text()) == {"V": 4e6, "form": "long", "signed": True}
    assert not (folder / "toy").exists()


def test_without_a_target_the_targets_are_listed(toy: Exporter, folder: Path) -> None:
    done = command("export", folder)
    assert (done.exit_code, done.stdout) == (2, "")
    assert all(f"{each.name} " in done.stderr and each.description in done.stderr for each in EXPORTERS)
    assert done.stderr.splitlines()[-1].startswith("fatal: user input: --to: is missing: give one of csv, wide")


def test_files_inside_a_result_folder_go_with_the_next_run(toy: Exporter, folder: Path) -> None:
    done = command("export", folder, "--to", "toy")
    assert done.exit_code == 0
    files = [folder / "toy" / "index.json", folder / "toy" / "pull.txt"]
    assert listed(folder, ("toy",)) == files
    assert "toy" in own_folders()
    remove_results(folder)
    assert not any(file.exists() for file in files)


def test_every_exporter_of_one_file_can_be_exported(folder: Path, tmp_path: Path) -> None:
    names = [each.name for each in EXPORTERS if each.is_spring_file]
    assert len(names) >= 5
    for name in names:
        done = command("export", folder, "--to", name, "--out", tmp_path / "files")
        assert (done.exit_code, done.stdout) == (0, f"{tmp_path / 'files' / EXPORTERS[name].file}\n")
    printed = command("springs", folder, "--format", "wide").stdout
    assert (tmp_path / "files" / "py_wide.csv").read_text() == printed


def test_a_file_of_every_run(folder: Path) -> None:
    note = Exporter("note", "a note", write, file="note.txt", of_every_run=True)
    assert "note.txt" not in run_files()
    with EXPORTERS.added(note):
        assert run_files()["note.txt"] == "a note"


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (
            ["--to", "toi"],
            "--to: 'toi' is not one of csv, wide, xlsx, nc, json, beam, paraview, openfast, subdyn, "
            "opensees, calculix, sacs, toy (did you mean 'toy'?)",
        ),
        (["--to", "toy", "--option", "factor"], "--option: 'factor' is not NAME=VALUE"),
        (
            ["--to", "toy", "--option", "size=1"],
            "--option size: no option of 'toy' (did you mean 'signed'?); its options: factor, V, form, signed",
        ),
        (["--to", "csv", "--option", "size=1"], "--option size: no option of 'csv'; it has no options"),
        (["--to", "toy", "--option", "factor=1.5"], "--option factor: '1.5' is not an integer"),
        (["--to", "toy", "--option", "form=wide"], "--option form: 'wide' is not one of long, short"),
        (["--to", "toy", "--option", "signed=1"], "--option signed: '1' is not true or false"),
        (["--to", "toy", "--option", "V=4 m"], '--option V: "4 m" is a length; expected a force such as "4 MN"'),
    ],
)
def test_what_is_refused(toy: Exporter, folder: Path, args: list[str], message: str) -> None:
    done = command("export", folder, *args)
    assert (done.exit_code, done.stdout, done.stderr) == (2, "", f"fatal: user input: {message}\n")
    assert sorted(path.name for path in folder.iterdir()) == ["springs.nc"]


def test_springs_names_the_command_for_other_exports(toy: Exporter, folder: Path) -> None:
    done = command("springs", folder, "--format", "toy")
    words = "--format: 'toy' is no spring file but an export: pysprings export --to toy"
    assert (done.exit_code, done.stderr) == (2, f"fatal: user input: {words}\n")


def test_the_example_of_the_documentation(tmp_path: Path) -> None:
    page = (Path(__file__).parents[3] / "docs" / "develop" / "extend.md").read_text(encoding="utf-8")
    (block,) = (block for block in re.findall(r"^```python\n(.*?)^```", page, re.M | re.S) if "EXPORTERS" in block)
    exec(block, {})
    try:
        (file,) = exporters.export(synthetic.make_springs(), "largest", tmp_path).files
    finally:
        EXPORTERS.remove("largest")
    assert re.fullmatch(r"[0-9.]+ N", file.read_text())


def test_an_exporter_gets_the_data_that_it_needs() -> None:
    with pytest.raises(UserInputError, match="needs the full model of a run"):
        exporters.export(Source(springs=synthetic.make_springs()), "paraview", Path("nowhere"))
    assert not Path("nowhere").exists()
