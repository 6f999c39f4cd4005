# SPDX-License-Identifier: MIT
"""Nothing in the packages turns input into code, starts a shell or another program, or reads pickles."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FILES = sorted(file for package in ("pysprings", "fe_engine") for file in (ROOT / package).rglob("*.py"))
MODULES = {
    "pickle", "cPickle", "dill", "cloudpickle", "shelve", "marshal", "joblib", "subprocess", "pty", "socket", "ctypes",
    "yaml", "code", "codeop", "runpy", "xmlrpc", "urllib", "http", "ftplib", "telnetlib", "multiprocessing",
}  # fmt: skip
# worker processes run this program itself, and exchange what they have made through pipes;
# a register of laws makes the chain of calls that loops compile, from the numbers of its laws alone
# and Pardiso is called by its address, as the wrapper that loads it does, with less copying
# `pysprings soildyn` builds its own C sources with the compiler of the system, or that of the command line; no shell
ALLOWED = {
    "pysprings/cli/explore.py": {"socket"},
    "pysprings/results/exporters/soildyn/library.py": {"subprocess"},
    "fe_engine/linear/backends.py": {"ctypes"},
    "fe_engine/register.py": {"exec", "compile"},
    "pysprings/core/workers.py": {"multiprocessing", "multiprocessing.connection", "multiprocessing.util", "pickle"},
}
CALLS = {"eval", "exec", "compile", "__import__", "os.system", "os.popen", "os.execv", "os.spawnl", "os.startfile"}
METHODS = {"read_pickle", "to_pickle", "eval", "sympify", "literal_eval", "system", "popen"}
KEYWORDS = {"shell", "allow_pickle"}


def test_all_files_are_looked_at() -> None:
    assert len(FILES) > 100


def test_no_way_from_input_to_code() -> None:
    found = {
        file.relative_to(ROOT).as_posix(): list(faults(ast.parse(file.read_text(encoding="utf-8")))) for file in FILES
    }
    for file, modules in ALLOWED.items():
        found[file] = [each for each in found[file] if each.split(": ")[1] not in modules]
    assert {file: each for file, each in found.items() if each} == {}


def faults(tree: ast.Module) -> Iterator[str]:
    """Yield what could run input as code, or another program."""
    for node in ast.walk(tree):
        line = getattr(node, "lineno", 0)
        if isinstance(node, ast.Import):
            yield from (f"{line}: {name.name}" for name in node.names if name.name.split(".")[0] in MODULES)
        elif isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] in MODULES:
            yield f"{line}: {node.module}"
        elif isinstance(node, ast.Call):
            name = ast.unparse(node.func)
            if name in CALLS or name.split(".")[-1] in METHODS:
                yield f"{line}: {name}"
            yield from (
                f"{line}: {word.arg}" for word in node.keywords
                if word.arg in KEYWORDS and not (isinstance(word.value, ast.Constant) and word.value.value is False)
            )  # fmt: skip


@pytest.mark.parametrize(
    "text",
    [
        "import pickle", "from subprocess import run", "import yaml.loader", "x = eval(text)", "exec(text)",
        "os.system('x')", "np.load(file, allow_pickle=True)", "run(x, shell=flag)", "frame.eval(text)",
        "pd.read_pickle(file)", "__import__(name)",
    ],
)  # fmt: skip
def test_each_way_is_found(text: str) -> None:
    assert list(faults(ast.parse(text)))


def test_harmless_words_are_not() -> None:
    assert not list(faults(ast.parse("np.load(file, allow_pickle=False)\nre.compile(text)\nimport json")))
