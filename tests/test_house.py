# SPDX-License-Identifier: MIT
"""The figures of the structure, on small packages whose structure is known."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.house import EXAMPLES, circles, files_to_edit, floors, import_graph, measure, room_graph, sources

ROOT = Path(__file__).parents[1]


def small(root: Path) -> Path:
    files = {
        "pysprings/__init__.py": "",
        "pysprings/low.py": "def f(a, b):\n    return a\n",
        "pysprings/room/__init__.py": "",
        "pysprings/room/high.py": "from pysprings import low\n\n\ndef g():\n    from pysprings.room import other\n",
        "pysprings/room/other.py": "import pysprings.room.high\n",
        "fe_engine/__init__.py": "",
        "fe_engine/one.py": "from pysprings.low import f\n",
    }
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, encoding="utf-8")
    return root


def test_graph_circles_and_floors(tmp_path: Path) -> None:
    graph = import_graph(sources(small(tmp_path)))
    assert graph["pysprings.room.high"] == {"pysprings.low", "pysprings.room.other"}
    assert circles(graph) == [["pysprings.room.high", "pysprings.room.other"]]
    assert floors(graph) == 2
    assert room_graph(graph)["pysprings.room"] == {"pysprings.low"}


def test_figures(tmp_path: Path) -> None:
    figures = measure(small(tmp_path))
    assert figures["entries on the top level of pysprings, fe_engine"] == "2, 1"
    assert figures["most arguments"] == "2 (pysprings.low.f)"
    assert figures["circles of modules"] == "1"


def test_files_to_edit_count_code_and_branches_but_no_texts(tmp_path: Path) -> None:
    root = small(tmp_path)
    (root / "pysprings/room/high.py").write_text('"""On a swipe."""\n\n# swipe\nTEXT = "a swipe or two"\n', "utf-8")
    (root / "pysprings/room/other.py").write_text('def f(path):\n    return path.kind == "load"\n', "utf-8")
    (root / "pysprings/low.py").write_text('KINDS = ("swipe",)\n', "utf-8")
    assert files_to_edit(root, sources(root), EXAMPLES["kind of path (swipe, translation)"]) == [
        "pysprings/low", "pysprings/room/other",
    ]  # fmt: skip


@pytest.mark.slow
def test_a_new_part_is_few_files(house: dict[str, str]) -> None:
    most = {"soil law": 3, "exporter": 1, "picture": 2, "kind of path": 2}
    for kind in EXAMPLES:
        count = int(house[f"files to edit for a new {kind}, beside its own"].split()[0])
        assert 1 <= count <= most[kind.split(" (")[0]]


@pytest.fixture(scope="module")
def house() -> dict[str, str]:
    return measure(ROOT)


@pytest.mark.slow
def test_the_house_has_few_rooms_and_no_circle_between_them(house: dict[str, str]) -> None:
    figures = house
    inside, engine = map(int, figures["entries on the top level of pysprings, fe_engine"].split(", "))
    assert inside <= 10 and engine <= 19
    assert figures["circles of entries"] == "0"
    tool, engine = map(int, figures["layers of the import contracts of pysprings, fe_engine"].split(", "))
    assert 0 < tool <= 9 and 0 < engine <= 9


@pytest.mark.slow
def test_modules_make_no_circle_and_functions_take_eight_arguments_at_most(house: dict[str, str]) -> None:
    """Imports inside functions and for types count, too; kernels and commands may have more arguments."""
    figures = house
    assert figures["circles of modules"] == "0"
    assert int(figures["most arguments outside kernels and commands"].split()[0]) <= 8
