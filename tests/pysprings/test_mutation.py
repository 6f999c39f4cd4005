# SPDX-License-Identifier: MIT
"""The mutation run: which changes it makes, which tests it asks, and what counts as a kill."""

from __future__ import annotations

import hashlib
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

from benchmarks import mutation, mutation_cache, mutation_calls
from benchmarks.mutants import Mutant, compiles, find_mutants
from benchmarks.mutation_map import TestMap
from benchmarks.mutation_server import Server

SOURCE = '''"""A docstring with 1 + 1."""
from typing import TYPE_CHECKING
if TYPE_CHECKING:
    from elsewhere import a
TABLE = {"in": "inner", "out": "outer"}

@cache(7)
def area(a: Literal[3], b=2.0):
    """Say 3 < 4."""
    if a < 0:
        raise ValueError(f"{a + 1} is below {0}")
    check(a, b)
    total = a * b - 1e-6
    total += 5
    return -total if a and b else total
'''


def changes(source: str = SOURCE) -> list[tuple[str, str, str]]:
    return [(mutant.kind, mutant.before, mutant.after) for mutant in find_mutants(source.encode(), "pack/shape.py")]


def test_every_kind_of_change_is_made_and_nothing_else() -> None:
    assert sorted(changes()) == sorted([
        ("order", '"inner", "out": "outer"', '"outer", "out": "inner"'),
        ("constant", "2.0", "4.0"),
        ("condition", "a < 0", "not (a < 0)"),
        ("operator", "<", ">="),
        ("constant", "0", "1"),
        ("statement", "check(a, b)", "pass"),
        ("order", "a, b", "b, a"),
        ("operator", "*", "/"),
        ("operator", "-", "+"),
        ("constant", "1e-6", "9.999999999999999e-06"),
        ("statement", "total += 5", "pass"),
        ("operator", "+=", "-="),
        ("constant", "5", "6"),
        ("condition", "a and b", "not (a and b)"),
        ("operator", "and", "or"),
        ("sign", "-total", "total"),
    ])  # fmt: skip


def test_a_change_is_one_place_of_the_source() -> None:
    mutants = find_mutants(SOURCE.encode(), "pack/shape.py")
    (flip,) = [mutant for mutant in mutants if mutant.before == "<"]
    assert flip.applied(SOURCE.encode()).decode() == SOURCE.replace("if a < 0:", "if a >= 0:")
    assert (flip.key, flip.line, flip.function) == ("shape.area: < -> >= #1", 10, "area")
    assert all(compiles(mutant.applied(SOURCE.encode())) for mutant in mutants)
    with pytest.raises(AssertionError, match="not that of the mutant"):
        flip.applied(b"another file that is long enough" * 20)
    umlaut = "x = 'ä' + 'ö' * 3\n".encode()
    assert [mutant.applied(umlaut).decode() for mutant in find_mutants(umlaut, "x.py")] == [
        "x = 'ä' - 'ö' * 3\n", "x = 'ä' + 'ö' / 3\n", "x = 'ä' + 'ö' * 4\n",
    ]  # fmt: skip


def test_equal_changes_of_one_place_have_numbers() -> None:
    found = find_mutants(b"y = a + b + c\n", "pack/deep/sum.py")
    assert [mutant.key for mutant in found] == ["sum: + -> - #1", "sum: + -> - #2"]


# --- which tests ---


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """Two packages, a module that Numba compiles, and tests at several distances."""
    files = {
        "pack/__init__.py": (
            "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from pack.deep.sum import add\n"
            "def __getattr__(name):\n    import pack.deep.sum\n    return getattr(pack.deep.sum, name)\n"
        ),
        "pack/deep/__init__.py": "",
        "pack/deep/sum.py": "from pack.deep import unit\ndef add(a, b):\n    return a + b\n",
        "pack/deep/unit.py": "ONE = 1\n",
        "pack/loop.py": "from numba import njit\nfrom pack.deep.unit import ONE\n@njit\ndef run():\n    return ONE\n",
        "pack/late.py": "def far():\n    from pack.deep import sum\n    return sum.add(1, 2)\n",
        "tests/test_sum.py": "from pack.deep.sum import add\ndef test_add():\n    assert add(2, 2) == 4\n",
        "tests/test_pack.py": "from pack import add\ndef test_it():\n    assert add(0, 0) == 0\n",
        "tests/test_late.py": "from pack.late import far\ndef test_far():\n    assert far() == 3\n",
        "tests/test_other.py": "import pack.loop\n",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


def test_the_nearest_tests_come_first(project: Path) -> None:
    """By name, then by imports: through what a package hands on, and within functions."""
    found = TestMap(project, ("pack",))
    assert found.test_files("pack/deep/sum.py") == ["tests/test_sum.py", "tests/test_pack.py", "tests/test_late.py"]
    assert found.test_files("pack/late.py", "far") == ["tests/test_late.py"]
    assert found.test_files("pack/deep/sum.py", most=1) == ["tests/test_sum.py"]
    assert set(found.test_files("pack/deep/unit.py")) == {
        "tests/test_sum.py", "tests/test_pack.py", "tests/test_late.py", "tests/test_other.py",
    }  # fmt: skip


def test_what_compiled_code_imports_is_compiled_in(project: Path) -> None:
    assert TestMap(project, ("pack",)).compiled >= {"pack/loop.py", "pack/deep/unit.py"}
    assert "pack/deep/sum.py" not in TestMap(project, ("pack",)).compiled
    assert TestMap(project, ("pack",)).loops == {"pack/loop.py": {"pack/loop.py", "pack/deep/unit.py"}}


def test_loops_of_unchanged_code_are_given_and_no_others(tmp_path: Path) -> None:
    """A register's chain may call whatever another loop does: it goes with any change of compiled code."""
    texts = {
        "fe_engine/loop.py": "from fe_engine.law import f\n@njit\ndef run(): return f()\n",
        "fe_engine/law.py": "@njit\ndef f(): return 1\n",
        "fe_engine/chain.py": "exec(compile('', '', 'exec'))\n@njit\ndef g(): return 1\n",
        "fe_engine/alone.py": "@njit\ndef h(): return 1\n",
        "fe_engine/plain.py": "X = 1\n",
    }
    root, copy, kept = tmp_path / "root", tmp_path / "copy", tmp_path / "kept" / "fe_engine-0123456789abcdef"
    for name, text in texts.items():
        for place in (root, copy):
            (place / name).parent.mkdir(parents=True, exist_ok=True)
            (place / name).write_text(text)
    folder = mutation_cache.numba_folder(root / "fe_engine/law.py")
    (kept / folder).mkdir(parents=True)
    for name in ("loop.run-2.py.nbi", "law.f-1.py.nbi", "chain.g-2.py.nbi", "alone.h-1.py.nbi"):
        (kept / folder / name).touch()
    tests = TestMap(root, ("fe_engine",))

    def given(changed: str) -> set[str]:
        (cache := tmp_path / changed).mkdir(parents=True)
        count = mutation_cache.give_loops(kept, root, copy, tests, changed, cache)
        (home,) = cache.iterdir()
        assert re.fullmatch("fe_engine-[0-9a-f]{16}", home.name)
        files = list((home / mutation_cache.numba_folder(copy / "fe_engine/law.py")).iterdir())
        assert len(files) == count
        return {file.name.split(".")[0] for file in files}

    assert given("fe_engine/plain.py") == {"loop", "law", "chain", "alone"}
    assert given("fe_engine/law.py") == {"alone"}
    assert given("fe_engine/loop.py") == {"law", "alone"}
    assert given("fe_engine/alone.py") == {"loop", "law"}


@pytest.mark.slow
def test_the_map_covers_this_project() -> None:
    """Every module but the entry points has a test file, and kernels count as compiled; wherever the files are."""
    found = TestMap(mutation.ROOT, tuple(folder for folder, _ in mutation.PARTS.values()))
    modules = [path for path in found.path.values() if path.startswith(("fe_engine/", "pysprings/"))]
    bare = [path for path in modules if not found.test_files(path)]
    assert len(modules) > 100 and {Path(path).name for path in bare} <= {"__main__.py", "__init__.py"}
    assert {"kernels.py", "plasol.py"} <= {Path(path).name for path in found.compiled}


def test_functions_that_were_called_have_their_names(tmp_path: Path) -> None:
    """Methods and nested functions by the way to them; lambdas and comprehensions count for what they stand in."""
    file = tmp_path / "pack" / "a.py"
    text = (
        "class A:\n def f(self):\n  def g(): return [x for x in map(lambda y: y, [1])]\n  return g()\ndef h(): pass\n"
    )
    space: dict[str, Any] = {}
    exec(compile(text, str(file), "exec"), space)
    seen = set()

    def note(frame: FrameType, _event: str, _arg: object) -> None:
        seen.add(frame.f_code)

    before = sys.gettrace()
    sys.settrace(note)
    try:
        space["A"]().f()
    finally:
        sys.settrace(before)
    assert mutation_calls.called(seen, tmp_path) == {"pack/a.py:A.f", "pack/a.py:A.f.g"}
    assert mutation_calls.called(seen, tmp_path / "elsewhere") == set()


def test_calls_are_kept_by_the_digest_of_the_test_file(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mutation_calls, "FOLDERS", ("tests",))
    ran: list[str] = []

    def run(command: list[str], env: dict[str, str], **_: Any) -> None:
        names = [word for word in command if word.endswith(".py")]
        ran.extend(names)
        entries = {name: {"seconds": 1.0, "functions": ["pack/deep/sum.py:add"]} for name in names}
        Path(env[mutation_calls.VARIABLE]).write_text(json.dumps(entries))

    file = tmp_path / "out" / "calls.json"
    found = mutation_calls.record(project, file, run)
    assert ran == sorted(found) == [f"tests/test_{name}.py" for name in ("late", "other", "pack", "sum")]
    assert mutation_calls.record(project, file, run) == found and len(ran) == 4
    (project / "tests/test_late.py").write_text("# changed\n")
    mutation_calls.record(project, file, run)
    assert ran[4:] == ["tests/test_late.py"]
    (project / "tests/test_late.py").unlink()
    assert "tests/test_late.py" not in mutation_calls.record(project, file, run)


@pytest.mark.slow
def test_a_session_records_what_each_file_calls(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In a process of its own, with a true pytest; what is called when a module is loaded is not counted."""
    monkeypatch.setattr(mutation_calls, "FOLDERS", ("tests",))
    monkeypatch.setenv("PYTHONPATH", str(mutation.ROOT))
    (project / "tests/test_other.py").write_text("def test_nothing():\n    assert True\n")

    def run(command: list[str], env: dict[str, str], **given: Any) -> None:
        paths = os.pathsep.join([str(project), str(mutation.ROOT)])
        done = subprocess.run(command, env={**env, "PYTHONPATH": paths}, **given)
        assert done.returncode == 0, done.stdout

    found = mutation_calls.record(project, project / "calls.json", run)
    functions = {name.removeprefix("tests/"): entry["functions"] for name, entry in found.items()}
    assert {name: "pack/deep/sum.py:add" in names for name, names in functions.items()} == {
        "test_late.py": True, "test_other.py": False, "test_pack.py": True, "test_sum.py": True,
    }  # fmt: skip
    assert "pack/late.py:far" in functions["test_late.py"] and "pack/late.py:far" not in functions["test_sum.py"]
    assert all(entry["seconds"] >= 0.0 for entry in found.values())


def test_of_the_files_that_call_a_function_the_nearest_and_then_the_cheapest_come_first(project: Path) -> None:
    (mutant, *_) = find_mutants((project / "pack/deep/sum.py").read_bytes(), "pack/deep/sum.py")
    functions = ["pack/deep/sum.py:add"]
    costs = {
        "tests/test_other.py": 3.0,
        "tests/test_dear.py": 9.0,
        "tests/test_sum.py": 5.0,
        "tests/test_cheap.py": 1.0,
    }
    calls = {name: {"seconds": seconds, "functions": functions} for name, seconds in costs.items()}
    calls["tests/test_late.py"] = {"seconds": 0.1, "functions": ["pack/deep/sum.py:other"]}
    tests = TestMap(project, ("pack",))
    expected = [f"tests/test_{name}.py" for name in ("sum", "pack", "cheap", "other", "dear", "late")]
    assert mutation.choose(mutant, tests, calls, 24) == expected
    assert mutation.choose(mutant, tests, calls, 2) == expected[:2]
    assert mutation.choose(mutant, tests, {}, 24) == tests.test_files("pack/deep/sum.py", "add")


# --- what counts ---


def judged(project: Path, before: str) -> mutation.Verdict:
    (mutant,) = [each for each in find_mutants((project / "pack/deep/sum.py").read_bytes(), "pack/deep/sum.py")
                 if each.before == before]  # fmt: skip
    (copy := project / "copy").mkdir()
    for file in ("pack", "tests"):
        (copy / file).symlink_to(project / file)
    files = mutation.choose(mutant, TestMap(project, ("pack",)), {}, 6)
    found = mutation.judge("tool", mutant, copy, files, mutation.Limits(first=1, seconds=120.0))
    assert (project / "pack/deep/sum.py").read_text().endswith("return a + b\n")  # taken back
    return mutation.confirmed([found], copy, 120.0)[0]


@pytest.mark.slow
def test_more_tests_are_asked_where_the_nearest_pass(project: Path) -> None:
    (project / "tests/test_sum.py").write_text(
        "from pack.deep.sum import add\ndef test_add():\n    assert add(0, 0) == 0\n"
    )
    found = judged(project, "+")
    assert (found.outcome, found.by) == (mutation.KILLED, "tests/test_late.py::test_far")


@pytest.mark.slow
def test_a_change_that_no_test_notices_survives(project: Path) -> None:
    (project / "tests/test_sum.py").write_text(
        "from pack.deep.sum import add\ndef test_add():\n    assert add(0, 0) == 0\n"
    )
    (project / "tests/test_late.py").unlink()
    assert judged(project, "+").outcome == mutation.SURVIVED


@pytest.mark.slow
def test_a_test_that_fails_without_the_change_too_kills_nothing(project: Path) -> None:
    (project / "tests/test_sum.py").write_text(
        "from pack.deep.sum import add\ndef test_add():\n    assert add(0, 0) == 1\n"
    )
    assert judged(project, "+").outcome == mutation.VOID


# --- samples and the page ---


@pytest.mark.slow
def test_verdicts_are_kept_and_only_survivors_run_again(project: Path, tmp_path: Path) -> None:
    out, file = tmp_path / "out", project / "pack/deep/sum.py"
    mutants = [("tool", each) for each in find_mutants(file.read_bytes(), "pack/deep/sum.py")]
    assert mutants
    name = f"{mutants[0][1].key} {hashlib.sha256(file.read_bytes()).hexdigest()[:16]}"
    out.mkdir()
    (out / "results.json").write_text(json.dumps({name: ["killed", "tests/test_sum.py::test_add"]}))
    limits = mutation.Limits(seconds=1.0)
    (found,) = mutation.run(project, mutants[:1], out, 1, limits, {})  # not run: there is no copy without git
    assert (found.outcome, found.by) == ("killed", "tests/test_sum.py::test_add")
    (out / "results.json").write_text(json.dumps({name: ["survived", ""]}))
    assert [each.outcome for each in mutation.run(project, mutants, out, 1, limits)] == ["survived"]
    file.write_text(file.read_text() + "# changed\n")
    assert mutation.run(project, mutants, out, 1, limits) == []


def test_a_sample_is_fixed_by_its_seed_and_has_every_kind(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (project / "pack" / "shape.py").write_text(SOURCE)
    (project / "core").mkdir()
    (project / "core" / "one.py").write_text("x = a + b\ny = 1\n")
    monkeypatch.setattr(mutation, "PARTS", {"engine": ("core", 1), "tool": ("pack", 2)})
    drawn = mutation.draw(project, 9, 1)
    assert drawn == mutation.draw(project, 9, 1)
    assert sorted(part for part, _ in drawn) == ["engine"] * 2 + ["tool"] * 6  # core has two mutants, of three wanted
    assert {mutant.kind for part, mutant in drawn if part == "tool"} == {
        "condition", "constant", "operator", "order", "sign", "statement",
    }  # fmt: skip
    assert {mutant.key for _, mutant in mutation.draw(project, 6, 1)} < {mutant.key for _, mutant in drawn}


def verdict(part: str, outcome: str, name: str = "a") -> mutation.Verdict:
    return mutation.Verdict(part, Mutant("x.py", 1, name, "operator", 0, 1, "+", "-"), outcome)


def test_the_score_leaves_out_what_changes_nothing_and_what_is_void() -> None:
    verdicts = [verdict("engine", mutation.KILLED)] * 3 + [verdict("tool", mutation.SURVIVED, "late.far")]
    verdicts += [verdict("tool", mutation.EQUAL), verdict("tool", mutation.VOID)]
    assert mutation.score(verdicts) == 75.0
    found = mutation.tables(verdicts)
    assert found["mutation"][1:] == [
        ["engine", "3", "3", "0", "0", "0", "100 %"],
        ["tool", "3", "0", "1", "1", "1", "0 %"],
        ["both", "6", "3", "1", "1", "1", "75 %"],
    ]
    assert found["mutation-survivors"] == [["line"], ["`late.far: + -> - #1`"]]
    assert found["mutation-without-effect"] == [["line"], ["`a: + -> - #1`"]]
    assert mutation.tables([])["mutation-survivors"] == [["line"], ["none"]]
    text = mutation.report(verdicts)
    assert "| both | 6 | 3 | 1 | 1 | 1 | 75 % |" in text and "- `late.far: + -> - #1`" in text


def test_the_list_of_what_changes_nothing_has_reasons_and_is_of_this_code() -> None:
    found, keys = mutation.equivalents(), set()
    assert all(reason.strip() for reason in found.values())
    for folder, _ in mutation.PARTS.values():
        for file in sorted((mutation.ROOT / folder).rglob("*.py")):
            if any(key.startswith(file.stem) for key in found):
                keys |= {mutant.key for mutant in find_mutants(file.read_bytes(), file.name)}
    assert set(found) <= keys


# --- the process that forks ---


@pytest.mark.slow
def test_forks_run_the_sources_of_their_folder(project: Path) -> None:
    """A change is seen by the next call; a test that does not end is ended; settings are those of the call."""
    server = Server()
    options = ["-q", "-x", "-p", "no:cacheprovider"]
    (project / "tests/test_sum.py").write_text(
        "import os\nfrom pack.deep.sum import add\ndef test_add():\n    assert add(2, 2) == int(os.environ['SUM'])\n"
    )
    try:
        assert server.run(project, [*options, "tests/test_sum.py"], {"SUM": "4"}, 60.0)[0] == 0
        (project / "pack/deep/sum.py").write_text("def add(a, b):\n    return a - b\n")
        code, text = server.run(project, [*options, "tests/test_sum.py"], {"SUM": "4"}, 60.0)
        assert code == 1 and "FAILED tests/test_sum.py::test_add" in text
        (project / "tests/test_late.py").write_text("def test_far():\n    while True:\n        pass\n")
        assert server.run(project, [*options, "tests/test_late.py"], {}, 2.0) == (None, "")
        assert server.run(project, [*options, "tests/test_sum.py"], {"SUM": "0"}, 60.0)[0] == 0
    finally:
        server.close()
