# SPDX-License-Identifier: MIT
"""The documentation: its commands and Python blocks run, its links resolve, its generated pages are up to date.

Tiny scenes replace those that would take minutes. The commands of a document run in a scratch folder.
"""

import importlib.util
import json
import re
import shlex
import shutil
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pysprings import Scene
from pysprings.cli.app import application
from pysprings.macro.predict import MacroWarning
from pysprings.scene.load import parse_scene
from pysprings.springs.checks import save_springs
from tests.support import tiny
from tests.support.commands import command
from tests.support.place import ROOT
from tests.support.winkler import with_invented_memory
from tools import evidence_store, reference_pages

README = ROOT / "README.md"
RUN_HERE = [
    README,
    *(page for part in ("start", "tutorials", "guide") for page in sorted((ROOT / "docs" / part).glob("*.md"))),
]
SCENES_OF_TUTORIALS = ("sand", "clay", "layered", "slow")
PAGES = [README, ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md"))]

# commands that compute a full model or more: in the slow tests
LONG = ("run",)
# commands that no test of this file runs, with the test that does, or the reason
ELSEWHERE = {
    "make": "a fresh clone is needed; .ci/run calls it",
    "pip": "a fresh environment is needed",
    "pysprings run caisson.toml --out out --resume": "an interrupted run is needed: full_model/test_resume.py",
    "pysprings run caisson.toml --target-error 5% --out within5": "no tiny mesh: full_model/test_accuracy_settings.py",
    "pysprings accuracy caisson.toml --quick --out study": "a study of many runs: studies/test_accuracy_study.py",
    "pysprings check mono.toml": "the files are blocks of docs/guide/load-cases.md, which other tests read",
    "pysprings capacity mono.toml --cases loads.csv --out mono": "many runs: studies/test_capacity.py",
    "pysprings design mono/runs/characteristic-V3000kN-rays loads.csv --out design.html": "needs the runs before it",
    'pysprings capacity sand.toml --V "1 MN" --V "3 MN" --directions 8 --out envelope': "many runs: as above",
    'pysprings capacity sand.toml --V "1 MN" --cases cases.csv --factor 1.25 --out envelope': "many runs: as above",
    'pysprings capacity sand.toml --directions 4 --torsion "30 deg" --torsion "60 deg" --torsion "90 deg"': "as above",
    'pysprings ground site-cpt.gef site-lab.csv --depth "24 m" --out site.csv': "data/tutorials: tools.tutorials",
    "pysprings run caisson.toml --estimate low --estimate best --estimate high --out out --no-figures "
    "--no-estimate-error": "a scene with ranges is needed: tools.tutorials",
    "pysprings run caisson.toml --estimate low --estimate best --estimate high --out out": "as above",
    'pysprings design out site-cases.csv --tilt "0.25 deg"': "as above",
    "pysprings ground cpt.gef": "the CPT of a reader: site/test_files.py",
    "pysprings ground cpt.gef --out site.csv": "as above",
    'pysprings ground cpt.ags lab.csv log.xlsx --depth "30 m" --nkt 12,14,16 --out site.csv': "as above",
    "pysprings explore out": "it serves until Ctrl-C: cli/test_explore.py",
    "pysprings explore --atlas clay": "as above",
    'pysprings predict rates --u-max "20 mm" --rate "0.5 mm/s"': "springs at two rates: springs/test_rates.py",
}
MM = 1.0e-3
RAYS = {"ray_0": (4.0, 0.0), "ray_40": (3.0, 0.63), "ray_60": (2.0, 0.87)}  # u [mm], rotation [mrad]


# --- what the documents hold ---


def blocks(page: Path, language: str) -> list[str]:
    """Return the code blocks of a language."""
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S)


def commands(page: Path) -> list[str]:
    """Return the command lines of the shell blocks, without comments."""
    lines = [line for block in blocks(page, "bash") for line in block.splitlines()]
    return [
        " ".join(shlex.split(line, comments=True)) and line.split("  #")[0].strip() for line in lines if line.strip()
    ]


def name(page: Path) -> str:
    return str(page.relative_to(ROOT))


ALL_COMMANDS = [(page, line) for page in RUN_HERE for line in commands(page)]


def is_elsewhere(line: str) -> bool:
    return line in ELSEWHERE or line.split()[0] in ELSEWHERE


def is_long(line: str) -> bool:
    return not is_elsewhere(line) and line.split()[1] in LONG


def here(page: Path) -> list[str]:
    """Return the commands of a page that the quick tests run."""
    return [line for line in commands(page) if not is_elsewhere(line) and not is_long(line)]


def test_readme_is_short() -> None:
    assert len(README.read_text(encoding="utf-8").splitlines()) <= 150


def test_documents_hold_commands_and_python() -> None:
    assert len(ALL_COMMANDS) > 30
    assert {name(page) for page, _ in ALL_COMMANDS} >= {"README.md", "docs/start/first-run.md", "docs/guide/predict.md"}
    assert blocks(README, "python")


def test_reasons_name_lines_that_exist() -> None:
    lines = {line for _, line in ALL_COMMANDS}
    words = {line.split()[0] for line in lines}
    assert not [key for key in ELSEWHERE if key not in lines | words]


def test_every_command_of_the_program_is_in_the_readme() -> None:
    registered = [command.name or command.callback.__name__ for command in application().registered_commands]
    assert registered
    text = README.read_text(encoding="utf-8")
    assert not [each for each in registered if f"| `pysprings {each} " not in text]


# --- they run ---


def fan_scene() -> Scene:
    """A small fan: three rays, a rotation, a vertical path, and a held-back pull."""
    paths: list[dict[str, Any]] = [
        {"name": key, "kind": "translation", "lateral_displacement": u * MM, "rotation": turn * MM}
        for key, (u, turn) in RAYS.items()
    ]
    paths += [
        {"name": "turn", "kind": "rotation", "rotation": MM},
        {"name": "down", "kind": "vertical", "vertical_displacement": 4.0 * MM},
        {"name": "pull", "kind": "pull", "lateral_displacement": 2.0 * MM, "arm": 2.0, "role": "held-back"},
    ]
    return tiny.scene(paths=tuple(paths))


def call(line: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Run a command line of a document in a folder; replace what is there."""
    monkeypatch.chdir(folder)
    given = shlex.split(line, comments=True)[1:]
    if given and given[0] in ("init", "run"):
        given.append("--force")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MacroWarning)
        return command(*given)


@pytest.fixture(scope="session")
def prepared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with tiny scenes and the result of one, under the names that the documents use."""
    folder = tmp_path_factory.mktemp("docs")
    tiny.write(fan_scene(), folder / "fan.toml")
    tiny.write(tiny.scene(), folder / "caisson.toml")
    done = command("run", str(folder / "fan.toml"), "--out", str(folder / "out"))
    assert done.code == 0, done.err
    for name in ("fan", *SCENES_OF_TUTORIALS):
        shutil.copytree(folder / "out", folder / name)
    for name in SCENES_OF_TUTORIALS:
        tiny.write(fan_scene(), folder / f"{name}.toml")
    tables = blocks(ROOT / "docs/guide/predict.md", "text")
    (folder / "curves.csv").write_text(next(each for each in tables if each.startswith("depth_m")))
    cases = blocks(ROOT / "docs/guide/load-cases.md", "text")
    for file, head in (("cases.csv", "case,"), ("legs.csv", "bucket,")):
        (folder / file).write_text(next(each for each in cases if each.startswith(head)))
    rows = blocks(ROOT / "docs/guide/cycles.md", "text")
    (folder / "sequence.csv").write_text(next(each for each in rows if each.startswith("H_kN")))
    save_springs(with_invented_memory(), folder / "springs.nc")
    (folder / "loads.csv").write_text(next(each for each in tables if each.startswith("H_N")))
    return folder


@pytest.fixture
def scratch(prepared: Path, tmp_path: Path) -> Path:
    """A copy of the prepared folder for one test."""
    return Path(shutil.copytree(prepared, tmp_path / "scratch"))


@pytest.mark.slow
@pytest.mark.parametrize("page", [page for page in RUN_HERE if here(page)], ids=name)
def test_commands_of_a_document_run(page: Path, scratch: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for line in here(page):
        done = call(line, scratch, monkeypatch)
        assert done.code == 0, f"{line}\n{done.out}\n{done.err}"
        assert done.out


LONG_LINES = [(page, line) for page, line in ALL_COMMANDS if is_long(line)]


@pytest.mark.slow
@pytest.mark.parametrize(("page", "line"), LONG_LINES, ids=[f"{name(page)}-{line}" for page, line in LONG_LINES])
def test_runs_of_a_document_run(page: Path, line: str, scratch: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    done = call(line, scratch, monkeypatch)
    assert done.code == 0, f"{line}\n{done.out}\n{done.err}"
    assert (scratch / shlex.split(line)[-1] / "report.html").exists()


PYTHON = [(page, block) for page in RUN_HERE for block in blocks(page, "python")]


@pytest.mark.slow
@pytest.mark.parametrize(("page", "block"), PYTHON, ids=[f"{name(page)}-{k}" for k, (page, _) in enumerate(PYTHON)])
def test_python_of_a_document_runs(
    page: Path, block: str, scratch: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(scratch)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MacroWarning)
        exec(compile(block, name(page), "exec"), {"__name__": "__main__"})
    if "print(" in block:
        assert capsys.readouterr().out


@pytest.mark.slow
def test_the_table_of_pandas_has_the_curves_between_their_points(
    scratch: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (block,) = (block for page, block in PYTHON if "pivot_table" in block)
    monkeypatch.chdir(scratch)
    names: dict[str, Any] = {}
    exec(compile(block.replace("print(", "shown = ("), "hand-over", "exec"), names)
    lateral, shown = names["lateral"], names["shown"]
    assert len(shown.columns) > 2 and not capsys.readouterr().out
    for depth, own in lateral.groupby("depth_m"):
        p = np.interp(shown.index, own["y_m"], own["p_N_per_m"], right=np.nan)
        np.testing.assert_allclose(shown[depth], p, rtol=1e-9, atol=1e-9)


def test_scenes_of_the_documents_are_valid() -> None:
    """Many are fragments, which stand for scenes with a ground of their own."""
    texts = [block for page in RUN_HERE for block in blocks(page, "toml")]
    apart = (
        "[[axis]]",
        "[sampling]",
        "profile =",
        "contours =",
        "cases =",
    )  # those of studies, and of tables that are not there
    scenes = [text for text in texts if not any(each in text for each in apart)]
    assert scenes
    assert all((parse_scene if "K0" in text else tiny.parsed)(text).all_paths for text in scenes)


# --- their links resolve ---


def links(page: Path) -> Iterator[str]:
    """Yield the relative links and pictures of a page, outside code blocks."""
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"`[^`\n]*`", "", text)):
        if "://" not in target:
            yield target


def anchors(page: Path) -> set[str]:
    """Return the anchors that the headings of a page make."""
    heads = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.M)
    return {re.sub(r"[^\w\- ]", "", head.lower()).strip().replace(" ", "-") for head in heads}


def test_links_resolve() -> None:
    found = [(page, target) for page in PAGES for target in links(page)]
    assert len(found) > 80
    lost = []
    for page, target in found:
        file, _, anchor = target.partition("#")
        place = (page.parent / file).resolve() if file else page
        if not place.exists() or (anchor and anchor not in anchors(place)):
            lost.append(f"{name(page)}: {target}")
    assert not lost


def test_every_page_is_reached_over_the_index_pages() -> None:
    docs = ROOT / "docs"
    reached, waiting = set(), [docs / "index.md"]
    while waiting:
        page = waiting.pop()
        reached.add(page)
        linked = {(page.parent / target).resolve() for target in links(page) if target.endswith(".md")}
        waiting += [each for each in linked - reached if page.name == "index.md"]
    pages = set(docs.rglob("*.md"))
    assert len(pages) > 60
    assert not sorted(name(page) for page in pages - reached)


def test_every_source_file_that_a_page_names_exists() -> None:
    pattern = re.compile(r"`((?:fe_engine|pysprings|tests|benchmarks|tools|validation|data)/[\w/.-]+)`")
    pages = [page for page in PAGES if page.name != "CHANGELOG.md"]
    named = [(page, path) for page in pages for path in pattern.findall(page.read_text(encoding="utf-8"))]
    assert len(named) > 30
    assert not [f"{name(page)}: {path}" for page, path in named if not (ROOT / path).exists()]


# files of the engine that hold no law or element of their own
HELPERS = {"__init__.py", "dispatch.py", "formulas.py", "frictional.py", "law.py", "laws.py", "lode.py"}


def test_the_page_of_laws_names_every_file_of_a_law_or_element() -> None:
    text = (ROOT / "docs/theory/laws-and-files.md").read_text(encoding="utf-8")
    files = [file for room in ("soil", "contact", "elements") for file in (ROOT / "fe_engine" / room).glob("*.py")]
    named = [file.relative_to(ROOT).as_posix() for file in files if file.name not in HELPERS]
    assert len(named) > 12
    assert not [name for name in named if f"`{name}`" not in text]


# --- the generated pages ---


@pytest.mark.parametrize("file", sorted(reference_pages.pages()))
def test_reference_is_what_the_program_makes(file: str) -> None:
    assert (reference_pages.PAGES / file).read_text(encoding="utf-8") == reference_pages.pages()[file], (
        "run: make pages"
    )


EVIDENCE = sorted((ROOT / "docs/evidence").glob("*.md"))


@pytest.fixture(scope="module")
def site() -> Any:
    """The settings of the site, which show stored tables."""
    spec = importlib.util.spec_from_file_location("site_settings", ROOT / "docs/conf.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_stored_table_is_shown_with_its_origin(site: Any) -> None:
    stored = {file.stem for file in evidence_store.DATA.glob("*.csv")}
    shown = {name for page in EVIDENCE for name in site.STORED.findall(page.read_text(encoding="utf-8"))}
    assert stored and stored == shown
    for page in EVIDENCE:
        text = site.with_tables(page.read_text(encoding="utf-8"))
        if page.name != "index.md":
            head = text.split("Data on this page:\n\n")[1].split("\n\n")[0]
            assert re.search(r"^- `[\w-]+`: `.+`, version \d+\.\d+\.\d+, \d{4}-\d\d-\d\d\.", head, re.M)
        assert "data/evidence/" not in site.STORED.sub("", text).replace("data/evidence/origins.json", "")


def test_commands_of_origins_are_there_or_name_their_commit() -> None:
    origins = json.loads((evidence_store.DATA / evidence_store.ORIGINS).read_text(encoding="utf-8"))
    found = {name: re.findall(r"-m (benchmarks\.\w+)", each["command"]) for name, each in origins.items()}
    gone = {
        name for name, modules in found.items()
        if not all((ROOT / module.replace(".", "/")).with_suffix(".py").exists() for module in modules)
    }  # fmt: skip
    assert len(gone) > 10 and any(modules for name, modules in found.items() if name not in gone)
    assert {name for name in gone if not re.search(r" of commit [0-9a-f]{7}\b", origins[name]["note"])} == set()


def test_a_stored_figure_stands_on_its_page(site: Any) -> None:
    assert "6.8 %" in site.table("slices")
    page = site.with_tables((ROOT / "docs/evidence/springs.md").read_text(encoding="utf-8"))
    assert site.table("slices") in page


def test_a_document_is_stored_by_section(tmp_path: Path) -> None:
    file = tmp_path / "study.md"
    file.write_text("# T\n\n- a: 1\n\n## Full model\n\n| x | y |\n| --- | --: |\n| a \\| b | 2 |\n", encoding="utf-8")
    tables = evidence_store.read_tables("study", file)
    assert tables == {"study": "line\na: 1\n", "study-full-model": "x,y\na | b,2\n"}
    paths = evidence_store.store("study", tables, "make study", data=tmp_path / "data")
    assert [path.name for path in paths] == ["study.csv", "study-full-model.csv"]
    assert "make study" in (tmp_path / "data/origins.json").read_text(encoding="utf-8")
