# SPDX-License-Identifier: MIT
"""How many small changes of the code the quick tests notice: ``python -m tools.mutation [--sample 40] [--seed 1]``.

A sample of mutants (an operator, a comparison, a condition, a number, a statement left out) is drawn with a fixed seed,
a third of it from the engine. Each is made in a copy of the tree, and the test files nearest to its module run there
until one fails. Compiled loops are kept by a digest of all sources (`fe_engine.compiled`), so that a mutant of the
engine compiles its own: general tools, which change modules in place, run the unchanged loops. Verdicts are kept in
``--out``; a second call runs the survivors again.
"""

import argparse
import ast
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
PARTS = (("fe_engine", 1), ("pysprings", 2))  # folder, share of the sample
SWAPS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Lt: ast.GtE, ast.Gt: ast.LtE,
    ast.LtE: ast.Lt, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.And: ast.Or, ast.Or: ast.And,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
KILLED, SURVIVED = "killed", "survived"
SECONDS = 900.0


class Mutant(NamedTuple):
    """One change: the ``number``-th place of a file, in the order of its syntax tree, and what it became."""

    file: str
    number: int
    line: int
    words: str


class _Places(ast.NodeTransformer):
    """Counts the places of a tree, and changes the one of a number; annotations, decorators and texts stay."""

    def __init__(self, wanted: int = -1) -> None:
        self.wanted, self.found, self.last = wanted, list[tuple[int, str]](), 0

    def visit(self, node: ast.AST) -> ast.AST:
        if isinstance(node, ast.arguments | ast.Raise):
            return node
        self.last = getattr(node, "lineno", self.last)
        made = self._changed(node)
        if made is not None:
            words = f"{_text(node)} -> {_text(made)}"
            self.found.append((self.last, words))
            if len(self.found) - 1 == self.wanted:
                return made
        return self.generic_visit(node)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.AST:
        if node.value is not None:
            node.value = self.visit(node.value)
        return node

    def _changed(self, node: ast.AST) -> ast.AST | None:
        if type(node) in SWAPS:
            return SWAPS[type(node)]()
        if isinstance(node, ast.Constant) and type(node.value) in (int, float):
            return ast.copy_location(ast.Constant(node.value * 2 if node.value else 1), node)
        if isinstance(node, ast.If):
            changed = ast.If(ast.UnaryOp(ast.Not(), node.test), node.body, node.orelse)
            return ast.fix_missing_locations(ast.copy_location(changed, node))
        calls = isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)
        if calls or isinstance(node, ast.AugAssign):
            return ast.copy_location(ast.Pass(), node)
        return None


def _text(node: ast.AST) -> str:
    try:
        return ast.unparse(node).splitlines()[0][:60] or type(node).__name__
    except (AttributeError, ValueError, IndexError):
        return type(node).__name__


def mutants_of(file: Path) -> Iterator[Mutant]:
    """Yield the mutants of a source file."""
    places = _Places()
    places.visit(ast.parse(file.read_text(encoding="utf-8")))
    name = file.relative_to(ROOT).as_posix()
    yield from (Mutant(name, k, line, words) for k, (line, words) in enumerate(places.found))


def mutated(text: str, number: int) -> str:
    """Return a source with the change of a number."""
    return ast.unparse(ast.fix_missing_locations(_Places(number).visit(ast.parse(text))))


def sample(size: int, seed: int) -> list[Mutant]:
    """Return mutants drawn with a seed: places of files that are drawn first, so that long files do not rule."""
    draw, chosen, whole = random.Random(seed), list[Mutant](), sum(share for _, share in PARTS)
    for folder, share in PARTS:
        files = sorted((ROOT / folder).rglob("*.py"))
        wanted = round(size * share / whole)
        while wanted:
            found = [*mutants_of(draw.choice(files))]
            if found:
                chosen.append(draw.choice(found))
                wanted -= 1
    return chosen


def tests_of(mutant: Mutant) -> list[str]:
    """Return the test files of a mutant, nearest first: those that name its module, then those of its room."""
    module = Path(mutant.file).with_suffix("")
    dotted, room = ".".join(module.parts), ROOT / "tests" / Path(*module.parts[:2])
    files = sorted((ROOT / "tests").rglob("test_*.py"))
    named = [file for file in files if dotted in file.read_text(encoding="utf-8")]
    beside = [file for file in files if file.is_relative_to(room) and file not in named]
    return [file.relative_to(ROOT).as_posix() for file in [*named, *beside]][:24]


def verdict(mutant: Mutant, copy: Path) -> str:
    """Run the tests of a mutant in a copy of the tree; return "killed" or "survived"."""
    place = copy / mutant.file
    own = place.read_text(encoding="utf-8")
    place.write_text(mutated(own, mutant.number), encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *tests_of(mutant)]
    try:
        ended = subprocess.run(
            command, cwd=copy, env=os.environ | {"PYTHONPATH": str(copy)}, capture_output=True, timeout=SECONDS
        )
        return KILLED if ended.returncode == 1 else SURVIVED
    except subprocess.TimeoutExpired:
        return KILLED
    finally:
        place.write_text(own, encoding="utf-8")


def main() -> None:
    """Draw, run, print a line a mutant and the score; keep the verdicts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sample", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=ROOT / "out" / "mutation.json")
    given = parser.parse_args()
    known = json.loads(given.out.read_text(encoding="utf-8")) if given.out.exists() else {}
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(
            shutil.copytree(ROOT, Path(folder) / "tree", ignore=shutil.ignore_patterns(".git", ".venv*", "out"))
        )
        for mutant in sample(given.sample, given.seed):
            key = json.dumps(mutant._asdict())
            if known.get(key) != KILLED:
                known[key] = verdict(mutant, copy)
                given.out.parent.mkdir(parents=True, exist_ok=True)
                given.out.write_text(json.dumps(known, indent=1), encoding="utf-8")
            print(f"{known[key]:8} {mutant.file}:{mutant.line}: {mutant.words}", flush=True)
    killed = sum(outcome == KILLED for outcome in known.values())
    print(f"{killed} of {len(known)} noticed: {100.0 * killed / len(known):.0f} %")


if __name__ == "__main__":
    main()
