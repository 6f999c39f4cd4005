# SPDX-License-Identifier: MIT
"""Measure the structure of a checkout: rooms, layers, circles, sizes, and how many files a new part touches.

Run as ``python -m benchmarks.house [CHECKOUT] [--markdown]``; several checkouts are printed side by side. Imports are
read as text, lazy and type-only ones too, so that any commit can be measured.
"""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple

PACKAGES = ("pysprings", "fe_engine")


class Example(NamedTuple):
    """An existing part that represents a new one of its kind: its words in code, its own files, those not counted."""

    words: str
    own: str
    others: str


_NONE = r"(?!)"  # matches nothing
_USES = r"paper|stability|accuracy_study|studies"  # studies that use a part as a case
_SHOWN = r"plots/(__init__|files|pictures)|result_files|folder|cli"  # elsewhere `gap` is a variable of results
EXAMPLES = {
    "soil law (van Eekelen)": Example(r".*van.?eekelen.*", r"van_eekelen|lode", _USES),
    "exporter (Excel)": Example(r"(springs\.)?xlsx", r"xlsx", rf"{_USES}|tables|profile_table"),  # readers of Excel
    "picture (gap)": Example(r"gap|gap_map", r"/gap", rf"^(?!.*({_SHOWN}))"),
    "kind of path (swipe, translation)": Example(
        r"swipe|translation", _NONE, rf"{_USES}|curve_table|macro_tables|directions"
    ),
}
# a comparison of a kind of path with a name is a branch that a new kind may have to join
_KIND = re.compile(r"""(\bkind|\[.kind.\]|\.get\(.kind.\))$""")
_KINDS = {"pull", "translation", "rotation", "swipe", "load", "vertical"}
Graph = dict[str, set[str]]


def sources(root: Path) -> dict[str, Path]:
    """Return the modules of both packages by dotted name."""
    modules = {}
    for package in PACKAGES:
        for file in sorted((root / package).rglob("*.py")):
            parts = file.relative_to(root).with_suffix("").parts
            modules[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file
    return modules


@cache
def _parsed(file: Path) -> ast.Module:
    return ast.parse(file.read_text(encoding="utf-8"))


def import_graph(modules: Mapping[str, Path]) -> Graph:
    """Return, for each module, the modules that it imports anywhere."""
    graph: Graph = {name: set() for name in modules}
    for name, file in modules.items():
        for node in ast.walk(_parsed(file)):
            for target in _targets(node, modules):
                if target != name:
                    graph[name].add(target)
    return graph


def _targets(node: ast.AST, modules: Mapping[str, Path]) -> Iterator[str]:
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names if alias.name in modules)
    elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
        for alias in node.names:
            inner = f"{node.module}.{alias.name}"
            if inner in modules:
                yield inner
            elif node.module in modules:
                yield node.module


def circles(graph: Graph) -> list[list[str]]:
    """Return the strongly connected components of more than one module (Tarjan 1972)."""
    order: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    groups: list[list[str]] = []

    def visit(name: str) -> None:
        order[name] = low[name] = len(order)
        stack.append(name)
        for other in sorted(graph[name]):
            if other not in order:
                visit(other)
                low[name] = min(low[name], low[other])
            elif other in stack:
                low[name] = min(low[name], order[other])
        if low[name] == order[name]:
            at = stack.index(name)
            group, stack[at:] = stack[at:], []
            if len(group) > 1:
                groups.append(sorted(group))

    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(max(limit, 10_000))
    for name in graph:
        if name not in order:
            visit(name)
    sys.setrecursionlimit(limit)
    return groups


def room_graph(graph: Graph) -> Graph:
    """Return the imports between entries of the top levels of the packages."""
    rooms: Graph = {}
    for name, targets in graph.items():
        rooms.setdefault(_room(name), set()).update(_room(target) for target in targets)
    return {room: targets - {room} for room, targets in rooms.items()}


def _room(name: str) -> str:
    return ".".join(name.split(".")[:2])


def layers(root: Path, package: str) -> int:
    """Return the number of layers that the import contract of a package has; 0 without a contract."""
    file = root / "pyproject.toml"
    settings = tomllib.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
    contracts = settings.get("tool", {}).get("importlinter", {}).get("contracts", [])
    own = [len(each["layers"]) for each in contracts if package in each.get("containers", [])]
    return max(own, default=0)


def floors(graph: Graph) -> int:
    """Return the height of a graph: the number of nodes on its longest way down, a circle counting as one node."""
    group = {name: number for number, names in enumerate(circles(graph)) for name in names}
    height: dict[str, int] = {}

    def of(name: str, above: frozenset[str]) -> int:
        if name not in height:
            below = [n for n in graph[name] if n not in above and group.get(n, n) != group.get(name, name)]
            height[name] = 1 + max((of(n, above | {name}) for n in below), default=0)
        return height[name]

    return max(of(name, frozenset()) for name in graph)


def _only(graph: Graph, package: str) -> Graph:
    """Return the part of a graph within a package."""
    own = {name for name in graph if name.startswith(package + ".")}
    return {name: graph[name] & own for name in own}


def functions(modules: Mapping[str, Path]) -> Iterator[tuple[str, ast.FunctionDef, bool]]:
    """Yield the place, the node, and whether it is a compiled kernel, of every function."""
    for name, file in modules.items():
        for node in ast.walk(_parsed(file)):
            if isinstance(node, ast.FunctionDef):
                kernel = any("njit" in ast.unparse(d) or "jitted" in ast.unparse(d) for d in node.decorator_list)
                yield f"{name}.{node.name}", node, kernel


def _body_lines(node: ast.FunctionDef) -> int:
    has_text = ast.get_docstring(node) is not None
    first = node.body[1] if has_text and len(node.body) > 1 else node.body[0]
    end = node.end_lineno
    assert end is not None
    return end - first.lineno + 1


def _arguments(node: ast.FunctionDef) -> int:
    a = node.args
    return len([x for x in [*a.posonlyargs, *a.args, *a.kwonlyargs] if x.arg not in ("self", "cls")])


def files_to_edit(root: Path, modules: Mapping[str, Path], part: Example) -> list[str]:
    """Return the files whose code names a part, without its own; comments and docstrings do not count."""
    words, own, others = (re.compile(each, re.IGNORECASE) for each in part)
    files = {file.relative_to(root).with_suffix("").as_posix(): file for file in modules.values()}
    return [
        name for name, file in files.items()
        if not own.search(name) and not others.search(name) and any(words.fullmatch(w) for w in _code_words(file))
    ]  # fmt: skip


def _code_words(file: Path) -> Iterator[str]:
    """Yield the names and the texts without blanks in the code of a file, and "swipe" for each branch on a kind."""
    for node in ast.walk(_parsed(file)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and " " not in node.value:
            yield node.value
        elif isinstance(node, ast.Name):
            yield node.id
        elif isinstance(node, ast.Attribute):
            yield node.attr
        elif isinstance(node, ast.alias):
            yield node.name.split(".")[-1]
        elif isinstance(node, ast.Compare) and _is_branch(node):
            yield "swipe"


def _is_branch(node: ast.Compare) -> bool:
    texts = {each.value for each in ast.walk(node) if isinstance(each, ast.Constant) and isinstance(each.value, str)}
    return bool(_KIND.search(ast.unparse(node.left)) and texts & _KINDS)


def _largest(parts: Iterator[tuple[int, str]]) -> str:
    size, place = max(parts)
    return f"{size} ({place})"


def _counted(names: list[str]) -> str:
    return f"{len(names)} ({', '.join(names)})" if len(names) <= 4 else str(len(names))


def measure(root: Path) -> dict[str, str]:
    """Return the figures of a checkout as texts by name."""
    modules = sources(root)
    graph = import_graph(modules)
    parts = list(functions(modules))
    lines = {name: len(file.read_text(encoding="utf-8").splitlines()) for name, file in modules.items()}
    rooms = room_graph({name: targets for name, targets in graph.items() if name not in PACKAGES})
    for targets in rooms.values():
        targets.difference_update(PACKAGES)
    inner = {n: t - set(PACKAGES) for n, t in graph.items() if n not in PACKAGES}
    entries = [str(len({_room(n) for n in modules if n.startswith(package + ".")})) for package in PACKAGES]
    plain = [(place, node) for place, node, kernel in parts if not kernel and not _is_command(node)]
    return {
        "files, lines": f"{len(modules)}, {sum(lines.values()):,}",
        "entries on the top level of pysprings, fe_engine": ", ".join(entries),
        "layers of the import contracts of pysprings, fe_engine": ", ".join(str(layers(root, p)) for p in PACKAGES),
        "floors between entries of pysprings, fe_engine": ", ".join(str(floors(_only(rooms, p))) for p in PACKAGES),
        "floors between modules": str(floors(inner)),
        "circles of modules": str(len(circles(graph))),
        "circles of entries": str(len(circles(rooms))),
        "longest file": _largest((count, name) for name, count in lines.items()),
        "longest function body": _largest((_body_lines(node), place) for place, node, _ in parts),
        "most arguments outside kernels and commands": _largest((_arguments(node), place) for place, node in plain),
        "most arguments": _largest((_arguments(node), place) for place, node, _ in parts),
        **{f"files to edit for a new {kind}, beside its own": _counted(files_to_edit(root, modules, part))
           for kind, part in EXAMPLES.items()},
    }  # fmt: skip


def _is_command(node: ast.FunctionDef) -> bool:
    """Return True for a command of typer: its annotated arguments are the options of the command line."""
    text = " ".join(ast.unparse(a.annotation) for a in [*node.args.args, *node.args.kwonlyargs] if a.annotation)
    return "typer.Option" in text or "typer.Argument" in text


def main(arguments: list[str]) -> None:
    """Print the figures of one checkout, or of several beside each other."""
    roots = [Path(each) for each in arguments] or [Path(".")]
    tables = [measure(root) for root in roots]
    print("| figure | " + " | ".join(str(root) for root in roots) + " |")
    print("| --- |" + " --- |" * len(roots))
    for name in tables[0]:
        print(f"| {name} | " + " | ".join(table[name] for table in tables) + " |")


if __name__ == "__main__":
    main(sys.argv[1:])
