# SPDX-License-Identifier: MIT
"""Mutants of a Python source: one small change each, that a test should notice.

Changed are operators, comparisons, conditions, numbers, and the order of arguments, of elements and of the values of a
table; statements are left out. Annotations, decorators, texts, messages of errors and imports stay as they are.
"""

from __future__ import annotations

import ast
import re
from bisect import bisect_right
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

_ARITHMETIC: dict[type[ast.operator], tuple[str, str]] = {
    ast.Add: ("+", "-"), ast.Sub: ("-", "+"), ast.Mult: ("*", "/"), ast.Div: ("/", "*"), ast.FloorDiv: ("//", "*"),
    ast.Mod: ("%", "*"), ast.Pow: ("**", "*"),
}  # fmt: skip
_COMPARISON: dict[type[ast.cmpop], tuple[str, str]] = {
    ast.Lt: ("<", ">="), ast.Gt: (">", "<="), ast.LtE: ("<=", "<"), ast.GtE: (">=", ">"), ast.Eq: ("==", "!="),
    ast.NotEq: ("!=", "=="), ast.Is: ("is", "is not"), ast.IsNot: ("is not", "is"), ast.In: ("in", "not in"),
    ast.NotIn: ("not in", "in"),
}  # fmt: skip
_SMALL = 1e-3  # a number below is a tolerance: times ten; others times two


@dataclass(frozen=True)
class Mutant:
    """One change of a file: bytes ``start`` to ``end`` become ``after``.

    ``place`` is module.function (without the packages, which may change), ``kind`` the kind of change, ``number`` tells
    equal changes of one place apart, from 1 on.
    """

    file: str
    line: int
    place: str
    kind: str
    start: int
    end: int
    before: str
    after: str
    number: int = 1

    @property
    def key(self) -> str:
        """What names the mutant in lists, whatever the lines and packages are."""
        return f"{self.place}: {_short(self.before)} -> {_short(self.after)} #{self.number}"

    @property
    def function(self) -> str:
        """Name of the innermost function or class; empty at the top of a module."""
        return self.place.rpartition(".")[2] if "." in self.place else ""

    def applied(self, source: bytes) -> bytes:
        """Return the source with the change."""
        assert source[self.start : self.end] == self.before.encode(), "the file is not that of the mutant"
        return source[: self.start] + self.after.encode() + source[self.end :]


def _short(text: str) -> str:
    plain = re.sub(r"\s+", " ", text)
    return plain if len(plain) <= 100 else f"{plain[:97]}..."


def find_mutants(source: bytes, file: str) -> list[Mutant]:
    """Return the mutants of a source in order of place; a few may not compile (see `compiles`)."""
    found = _Finder(source, file).found()
    counts: Counter[str] = Counter()
    numbered = []
    for mutant in sorted(found, key=lambda each: (each.start, each.end, each.after)):
        counts[mutant.key] += 1
        numbered.append(replace(mutant, number=counts[mutant.key]))
    return numbered


def compiles(source: bytes) -> bool:
    """Tell whether a source is Python: an exchange may leave a keyword where none may stand."""
    try:
        compile(source, "mutant", "exec")
    except SyntaxError:
        return False
    return True


class _Finder:
    """Walks the syntax tree of one source."""

    def __init__(self, source: bytes, file: str) -> None:
        self.source, self.file = source, file
        self.starts = [0]
        for line in source.splitlines(keepends=True):
            self.starts.append(self.starts[-1] + len(line))
        self.names = [file.rpartition("/")[2].removesuffix(".py")]

    def found(self) -> Iterator[Mutant]:
        """Yield all mutants."""
        yield from self._body(ast.parse(self.source).body)

    def _span(self, node: ast.AST) -> tuple[int, int]:
        n: ast.expr = node  # type: ignore[assignment]
        assert n.end_lineno is not None and n.end_col_offset is not None
        return self.starts[n.lineno - 1] + n.col_offset, self.starts[n.end_lineno - 1] + n.end_col_offset

    def _text(self, start: int, end: int) -> str:
        return self.source[start:end].decode()

    def _change(self, kind: str, start: int, end: int, after: str) -> Mutant:
        line = bisect_right(self.starts, start)
        return Mutant(self.file, line, ".".join(self.names), kind, start, end, self._text(start, end), after)

    # --- statements ---

    def _body(self, statements: list[ast.stmt]) -> Iterator[Mutant]:
        for statement in statements:
            yield from self._statement(statement)

    def _statement(self, node: ast.stmt) -> Iterator[Mutant]:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            self.names.append(node.name)
            yield from self._body(node.body)
            if not isinstance(node, ast.ClassDef):
                for default in [*node.args.defaults, *node.args.kw_defaults]:
                    yield from self._expression(default)
            self.names.pop()
            return
        if isinstance(node, ast.Import | ast.ImportFrom | ast.Raise | ast.Assert | ast.Global | ast.Nonlocal):
            return
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
            return
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            return  # a docstring
        if isinstance(node, ast.AugAssign) or (isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)):
            yield self._change("statement", *self._span(node), "pass")
        if isinstance(node, ast.AugAssign):
            yield from self._augmented(node)
        if isinstance(node, ast.If | ast.While):
            yield self._negated(node.test)
        for _, value in ast.iter_fields(node):
            yield from self._field(node, value)

    def _field(self, node: ast.AST, value: object) -> Iterator[Mutant]:
        if isinstance(node, ast.AnnAssign) and value is node.annotation:
            return
        for each in value if isinstance(value, list) else [value]:
            if isinstance(each, ast.stmt):
                yield from self._statement(each)
            elif isinstance(each, ast.expr):
                yield from self._expression(each)
            elif isinstance(each, ast.AST):  # handlers, items of with, comprehensions, keywords, cases
                for _, inner in ast.iter_fields(each):
                    yield from self._field(each, inner)

    def _negated(self, test: ast.expr) -> Mutant:
        start, end = self._span(test)
        return self._change("condition", start, end, f"not ({self._text(start, end)})")

    def _augmented(self, node: ast.AugAssign) -> Iterator[Mutant]:
        if type(node.op) in _ARITHMETIC:
            word, other = _ARITHMETIC[type(node.op)]
            yield from self._operator(self._span(node.target)[1], self._span(node.value)[0], f"{word}=", f"{other}=")

    # --- expressions ---

    def _expression(self, node: ast.expr | None) -> Iterator[Mutant]:
        if node is None or isinstance(node, ast.JoinedStr):
            return
        if isinstance(node, ast.BinOp) and type(node.op) in _ARITHMETIC:
            yield from self._operator(self._span(node.left)[1], self._span(node.right)[0], *_ARITHMETIC[type(node.op)])
        elif isinstance(node, ast.Compare):
            sides = [node.left, *node.comparators]
            for left, op, right in zip(sides[:-1], node.ops, sides[1:], strict=True):
                yield from self._operator(self._span(left)[1], self._span(right)[0], *_COMPARISON[type(op)])
        elif isinstance(node, ast.BoolOp):
            words = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
            yield from self._operator(self._span(node.values[0])[1], self._span(node.values[1])[0], *words)
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not):
            yield self._change("sign", *self._span(node), self._text(*self._span(node.operand)))
        elif isinstance(node, ast.IfExp):
            yield self._negated(node.test)
        elif isinstance(node, ast.Constant):
            yield from self._constant(node)
        elif isinstance(node, ast.Call):
            yield from self._swaps([each for each in node.args if not isinstance(each, ast.Starred)])
        elif isinstance(node, ast.Tuple | ast.List):
            yield from self._swaps([each for each in node.elts if not isinstance(each, ast.Starred)])
        elif isinstance(node, ast.Dict):
            yield from self._swaps([v for k, v in zip(node.keys, node.values, strict=True) if k is not None])
        for _, value in ast.iter_fields(node):
            yield from self._field(node, value)

    def _operator(self, start: int, end: int, word: str, other: str) -> Iterator[Mutant]:
        """Exchange the operator that stands between two operands."""
        between = self._text(start, end)
        at = between.find(word)
        if at >= 0 and "#" not in between:
            first = start + len(between[:at].encode())
            yield self._change("operator", first, first + len(word), other)

    def _constant(self, node: ast.Constant) -> Iterator[Mutant]:
        value = node.value
        if isinstance(value, bool):
            yield self._change("constant", *self._span(node), str(not value))
        elif isinstance(value, int):
            yield self._change("constant", *self._span(node), str(value + 1))
        elif isinstance(value, float):
            other = value * (10.0 if abs(value) < _SMALL else 2.0) if value else 1.0
            yield self._change("constant", *self._span(node), repr(other))

    def _swaps(self, nodes: list[ast.expr]) -> Iterator[Mutant]:
        """Exchange neighbours that differ."""
        for one, other in pairwise(nodes):
            (start, stop), (go_on, end) = self._span(one), self._span(other)
            first, second, between = self._text(start, stop), self._text(go_on, end), self._text(stop, go_on)
            long = max(len(first), len(second)) > 60
            if first != second and not long and "#" not in between and start < go_on:
                yield self._change("order", start, end, f"{second}{between}{first}")
