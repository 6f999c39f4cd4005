# SPDX-License-Identifier: MIT
"""Which test files see a module: found from the imports of all files, wherever they lie.

The distance of a test file from a module is the number of imports between them, imports within functions included. The
files of a module are the nearest ones; those that name the changed function come first, then those named after the
module, then those that reach few modules, which are the quick ones.
"""

from __future__ import annotations

import ast
import re
from collections import deque
from functools import cached_property
from pathlib import Path

JITTED = re.compile(r"@(njit|jit|jitted|guvectorize|vectorize)\b|\b(njit|jitted)\(")
CHAINED = re.compile(r"\bexec\(compile\(")  # a loop whose text is made


class TestMap:
    """Modules below some folders of a root, what each imports, and the test files that reach it."""

    __test__ = False  # pytest would collect it

    def __init__(self, root: Path, packages: tuple[str, ...], tests: str = "tests") -> None:
        self.root, self.tests = root, tests
        files = [file for folder in (*packages, tests, "benchmarks") for file in sorted((root / folder).rglob("*.py"))]
        self.text = {_module(file.relative_to(root)): file.read_text(encoding="utf-8") for file in files}
        self.path = {_module(file.relative_to(root)): file.relative_to(root).as_posix() for file in files}
        self._imports = {name: _imported(ast.parse(text)) for name, text in self.text.items()}

    @cached_property
    def graph(self) -> dict[str, set[str]]:
        """Module -> modules it imports to run, within functions too."""
        return {
            name: {self._home(base, item) for base, item, typing in found if not typing} & set(self.path) - {name}
            for name, found in self._imports.items()
        }

    def _home(self, base: str, item: str, depth: int = 0) -> str:
        """Return the module that an imported name comes from: through what packages hand on, for type checkers too."""
        if f"{base}.{item}" in self.path:
            return f"{base}.{item}"
        for other, name, _ in self._imports.get(base, []):
            if name == item and other != base and depth < 5:
                return self._home(other, name, depth + 1)
        return base

    def reached(self, start: str) -> dict[str, int]:
        """Return every module that a module imports, and how many imports lie between."""
        distance, queue = {start: 0}, deque([start])
        while queue:
            here = queue.popleft()
            for there in self.graph[here]:
                if there not in distance:
                    distance[there] = distance[here] + 1
                    queue.append(there)
        return distance

    @cached_property
    def _tests(self) -> dict[str, dict[str, int]]:
        names = [name for name, path in self.path.items() if re.search(r"(^|/)test_[^/]*\.py$", path)]
        return {name: self.reached(name) for name in names if self.path[name].startswith(f"{self.tests}/")}

    def test_files(self, file: str, function: str = "", most: int = 6) -> list[str]:
        """Return the test files to run for a change of a function in a file, at most so many, best first."""
        module = _module(Path(file))
        stem, word = module.rpartition(".")[2], function.strip("_")
        mentions = re.compile(rf"\b_?{re.escape(word)}\b") if len(word) > 3 else None
        found = []
        for name, distance in self._tests.items():
            if module in distance:
                text, own = self.text[name], stem.startswith(name.rpartition(".")[2].removeprefix("test_"))
                named = bool(mentions and mentions.search(text)) and distance[module] <= 2
                found.append((not (own or named), not own, distance[module], len(distance), self.path[name]))
        return [path for *_, path in sorted(found)[:most]]

    @cached_property
    def loops(self) -> dict[str, set[str]]:
        """File that compiles loops -> files whose code may be part of them: all that it imports.

        The chains of a register call what is registered: they count with every other file that compiles loops.
        """
        jitted = [name for name, text in self.text.items() if JITTED.search(text) and not name.startswith(self.tests)]
        found = {self.path[name]: {self.path[other] for other in self.reached(name)} for name in jitted}
        for name in jitted:
            if CHAINED.search(self.text[name]):
                found[self.path[name]] = set().union(*found.values())
        return found

    @cached_property
    def compiled(self) -> set[str]:
        """Files whose code is part of what Numba compiles: where it is used, and all that these modules import."""
        return set().union(*self.loops.values())


def _module(path: Path) -> str:
    parts = list(path.with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _imported(tree: ast.Module) -> list[tuple[str, str, bool]]:
    """Return the module, name ("" of a whole module) and whether for type checkers alone, of every import."""
    found: list[tuple[str, str, bool]] = []
    typing = {id(n) for block in ast.walk(tree) if _is_typing(block) for n in ast.walk(block)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found += [(alias.name, "", id(node) in typing) for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            found += [(node.module, alias.name, id(node) in typing) for alias in node.names]
    return found


def _is_typing(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test)
