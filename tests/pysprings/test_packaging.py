# SPDX-License-Identifier: MIT
"""What an installation needs, and names and files that Linux, macOS and Windows read alike."""

import ast
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from pysprings.springs.checks import save_springs
from tests.support import tiny
from tests.support.fans import fan_springs
from tests.support.place import ROOT

LEFT_OUT = {"numba", "matplotlib", "distributed"}  # of the light installation
BLOCKED = (*LEFT_OUT, "llvmlite", "PIL", "fontTools", "contourpy", "kiwisolver")

# --- the light installation ---


def name_of(requirement: str) -> str:
    """Return the name of the package that a requirement asks for."""
    found = re.match(r"[A-Za-z0-9_.-]+", requirement)
    assert found
    return found[0].lower()


def test_light_requirements_are_the_dependencies_of_predictions() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    lines = (ROOT / "requirements-predict.txt").read_text(encoding="utf-8").splitlines()
    listed = [line for line in lines if line and not line.startswith("#")]
    assert listed == [each for each in project["dependencies"] if name_of(each) not in LEFT_OUT]
    assert {name_of(each) for each in project["dependencies"]} >= LEFT_OUT


WITHOUT = """
import sys
class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {blocked!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
sys.meta_path.insert(0, Absent())
from pysprings.cli.app import main
sys.argv = ["pysprings", *sys.argv[1:]]
main()
"""


def without(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Run a command where the packages of the light installation alone can be imported."""
    command = [sys.executable, "-c", WITHOUT.format(blocked=BLOCKED), *words]
    environment = {"PYTHONPATH": str(ROOT), "PATH": "", "OMP_NUM_THREADS": "1", "NO_COLOR": "1"}
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, encoding="utf-8")


@pytest.fixture(scope="module")
def springs_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with springs, load cases and a scene."""
    folder = tmp_path_factory.mktemp("light")
    save_springs(fan_springs(lambda z, y, rotation: (3e8 * y, 2e9 * rotation + 0.0 * y)), folder / "springs.nc")
    (folder / "cases.csv").write_text("case,H [kN],arm [m]\nstorm,300,2\n", encoding="utf-8")
    tiny.write(tiny.scene(), folder / "scene.toml")
    return folder


@pytest.mark.slow
@pytest.mark.parametrize(
    "words",
    [
        ("predict", "springs.nc", "--H", "300 kN", "--arm", "2 m"),
        ("predict", "springs.nc", "--u-max", "1 mm", "--points", "30"),
        ("design", "springs.nc", "cases.csv", "--tilt", "0.25 deg", "--out", "a.csv", "--out", "a.xlsx"),
        ("springs", "springs.nc", "--format", "csv"),
        ("export", "springs.nc", "--to", "openfast", "--out", "model", "--option", "z=-30 m"),
    ],
    ids=lambda words: " ".join(words[:3:2]),
)
def test_commands_on_springs_work_without_numba_and_matplotlib(words: tuple[str, ...], springs_folder: Path) -> None:
    done = without(springs_folder, *words)
    assert done.returncode == 0, done.stderr
    assert done.stdout


@pytest.mark.slow
def test_a_run_without_numba_names_what_is_missing(springs_folder: Path) -> None:
    done = without(springs_folder, "run", "scene.toml", "--out", "run")
    assert done.returncode == 4
    assert done.stderr.splitlines()[-1] == "fatal: resources: this needs the package numba, which is not installed"


# --- names and files ---

REFUSED = re.compile(r"""[<>:"|?*\\]|[^ -~]|[ .](/|$)""")  # by Windows, or not ASCII
DEVICES = re.compile(r"(^|/)(con|prn|aux|nul|com\d|lpt\d)(\.[^/]*)?(/|$)", re.I)


def tracked() -> list[str]:
    """Return the files of the repository, or skip where there is none."""
    done = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    if done.returncode:
        pytest.skip("not a repository")
    return done.stdout.splitlines()


def test_every_system_takes_the_names_of_the_files() -> None:
    names = tracked()
    assert len(names) > 500
    assert not [name for name in names if REFUSED.search(name) or DEVICES.search(name) or len(name) > 120]
    assert len({name.lower() for name in names}) == len(names)


@pytest.mark.parametrize("name", ["a/b?.py", "aux.txt", "x/con", "end./a", "é.py"])
def test_names_that_a_system_refuses_are_noticed(name: str) -> None:
    assert REFUSED.search(name) or DEVICES.search(name)


def faults(text: str) -> Iterator[int]:
    """Yield the lines that read or write text with the encoding or the line ends of the system that runs them."""
    for call in ast.walk(ast.parse(text)):
        if not isinstance(call, ast.Call) or not isinstance(call.func, ast.Attribute | ast.Name):
            continue
        named = call.func.id if isinstance(call.func, ast.Name) else call.func.attr
        given = {each.arg for each in call.keywords}
        method = isinstance(call.func, ast.Attribute) and ast.unparse(call.func.value) != "os"
        strings = [each.value for each in call.args if isinstance(each, ast.Constant) and isinstance(each.value, str)]
        if named == "to_csv":
            wanted = {"lineterminator"}
        elif named == "read_text" and method:
            wanted = {"encoding"}
        elif named == "write_text" and method:
            wanted = {"encoding", "newline"}
        elif named == "open" and (method or isinstance(call.func, ast.Name)):
            mode = next((each for each in strings if re.fullmatch("[rwaxbt+]{1,3}", each)), "r")
            chosen = isinstance(call.args[0], ast.IfExp) if call.args else False
            wanted = set() if "b" in mode else {"encoding", "newline"} if chosen or mode != "r" else {"encoding"}
        else:
            continue
        if not wanted <= given:
            yield call.lineno


def test_texts_are_read_and_written_alike_on_every_system() -> None:
    files = [file for folder in ("pysprings", "fe_engine") for file in sorted((ROOT / folder).rglob("*.py"))]
    texts = {file: file.read_text(encoding="utf-8") for file in files}
    assert sum(text.count("read_text(") + text.count("write_text(") for text in texts.values()) > 10
    assert not [f"{file.relative_to(ROOT)}:{line}" for file, text in texts.items() for line in faults(text)]


@pytest.mark.parametrize(
    "line",
    [
        "open(file)", "file.open('w', encoding='utf-8')", "file.read_text()", "file.write_text(text, encoding='utf-8')",
        "table.to_csv(file)",
    ],
)  # fmt: skip
def test_texts_of_the_system_are_noticed(line: str) -> None:
    assert list(faults(line)) == [1]


# --- the recipe for conda-forge ---

CONDA_NAMES = {"matplotlib": "matplotlib-base", "lazy-loader": "lazy_loader"}


def recipe_lists() -> dict[str, list[str]]:
    """Return the items of each list of the recipe, by the word above it, and its version."""
    text = (ROOT / "recipe" / "recipe.yaml").read_text(encoding="utf-8")
    lists: dict[str, list[str]] = {}
    for line in text.splitlines():
        if head := re.fullmatch(r"\s*(\w+):", line):
            items = lists.setdefault(head[1], [])
        elif item := re.fullmatch(r"\s+- (.+)", line):
            items.append(item[1])
    return lists | {"version": re.findall(r'^  version: "(.+)"$', text, re.M)}


def test_the_recipe_has_the_dependencies_and_the_version_of_the_package() -> None:
    from pysprings import __version__

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    expected = ["python >=${{ python_min }}"]
    for each in project["dependencies"]:
        name = name_of(each)
        expected.append(f"{CONDA_NAMES.get(name, name)} {each[len(name) :]}")
    lists = recipe_lists()
    assert sorted(lists["run"]) == sorted(expected)
    assert lists["version"] == [__version__]
    assert lists["entry_points"] == [f"{name} = {target}" for name, target in project["scripts"].items()]
    assert f'python_min: "{project["requires-python"].removeprefix(">=")}"' in (ROOT / "recipe/recipe.yaml").read_text()
    host = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["build-system"]["requires"]
    assert {re.sub(r"[ >=].*", "", each) for each in host} <= {re.sub(r" .*", "", each) for each in lists["host"]}


def test_the_recipe_renders() -> None:
    """Evaluate its expressions with rattler-build (pip install py-rattler-build), where that is there."""
    rattler_build = pytest.importorskip("rattler_build", reason="no py-rattler-build")
    (variant,) = rattler_build.Stage0Recipe.from_file(str(ROOT / "recipe/recipe.yaml")).render()
    assert "python >=3.11" in [str(each) for each in variant.recipe.requirements.run]
