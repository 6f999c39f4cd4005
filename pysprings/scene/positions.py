# SPDX-License-Identifier: MIT
"""Where keys and values stand in a TOML text: key path -> line and column (tomllib has no positions).

A key path is a tuple of names and list indices: `("path", 0, "report_at", 1)` is the second entry of
`report_at` in the first `[[path]]`. The text must be valid TOML (read it with tomllib first); all forms of
keys, tables, inline tables, lists and strings are followed.
"""

import re
import tomllib
from bisect import bisect_right
from contextlib import suppress
from dataclasses import dataclass
from typing import NamedTuple

KeyPath = tuple[str | int, ...]

MOST_PARTS = 16  # of a dotted key or a header
MOST_LEVELS = 64  # of lists and tables

_BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_SPACE = re.compile(r"[ \t]*")
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_SCALAR = re.compile(r"[0-9]{4}-[0-9]{2}-[0-9]{2} [0-9]{2}[^\s,\]}#]*|[^\s,\]}#]+")
_STRINGS = {
    '"""': re.compile(r'"""(?:[^"\\]|\\[\s\S]|"(?!""))*"{3,5}'),
    "'''": re.compile(r"'''(?:[^']|'(?!''))*'{3,5}"),
    '"': re.compile(r'"(?:[^"\\]|\\.)*"'),
    "'": re.compile(r"'[^']*'"),
}


@dataclass(frozen=True)
class Place:
    """Line and column of a key and of its value, from 1, in characters (a list entry is its own key)."""

    key: tuple[int, int]
    value: tuple[int, int]


def locate(text: str) -> dict[KeyPath, Place]:
    """Return the place of every table, key and list entry of a valid TOML text."""
    scanner = _Scanner(text)
    scanner.document()
    return {path: Place(scanner.place(key), scanner.place(value)) for path, (key, value) in scanner.places.items()}


def refuse_depth(text: str) -> None:
    """Raise TooDeep where a key has too many parts, or lists and tables too many levels; needs no valid text.

    tomllib takes a time that grows with the square of the parts, and tables nested as deeply break what reads them.
    Other faults of a text are left to tomllib.
    """
    with suppress(ValueError):
        _Scanner(text, bounded=True).document()


class TooDeep(Exception):
    """A text with deeper keys, lists or tables than a scene has; ``place`` is line and column."""

    def __init__(self, message: str, place: tuple[int, int]) -> None:
        super().__init__(message)
        self.place = place


def nearest(places: dict[KeyPath, Place], path: KeyPath) -> Place:
    """Return the place of a key path, else of the innermost table around it that stands in the text."""
    while path and path not in places:
        path = path[:-1]
    return places.get(path, Place((1, 1), (1, 1)))


class _Scanner:
    """Walks through a text once; `places` maps key paths to the offsets of key and value."""

    def __init__(self, text: str, bounded: bool = False) -> None:
        self.text = text
        self.bounded = bounded  # TooDeep beyond MOST_PARTS and MOST_LEVELS
        self.at = 0
        self.places: dict[KeyPath, tuple[int, int]] = {}
        self.lengths: dict[KeyPath, int] = {}  # of arrays of tables
        self.starts = [0, *(match.end() for match in re.finditer("\n", text))]

    def place(self, offset: int) -> tuple[int, int]:
        line = bisect_right(self.starts, offset)
        return line, offset - self.starts[line - 1] + 1

    def skip(self, pattern: re.Pattern[str] = _SPACE) -> None:
        self.matched(pattern)

    def take(self, mark: str) -> bool:
        """Step over a mark if it stands here."""
        matches = self.text.startswith(mark, self.at)
        self.at += len(mark) if matches else 0
        return matches

    def document(self) -> None:
        table: KeyPath = ()
        self.skip(_BLANK)
        while self.at < len(self.text):
            if self.text[self.at] == "[":
                table = self.header()
            else:
                self.pair(table)
            self.skip(_BLANK)

    def header(self) -> KeyPath:
        """Read `[a.b]` or `[[a.b]]`; return the path of the table that it opens."""
        start = self.at
        array = self.take("[[")
        if not array:
            self.take("[")
        path: KeyPath = ()
        names = self.names()
        for name, _ in names[:-1]:
            path = self.latest((*path, name))
            self.places.setdefault(path, (start, start))
        path = (*path, names[-1][0])
        if array:
            self.places.setdefault(path, (start, start))
            self.lengths[path] = self.lengths.get(path, 0) + 1
        path = self.latest(path)
        self.places[path] = (start, start)
        self.take("]]" if array else "]")
        return path

    def latest(self, path: KeyPath) -> KeyPath:
        """Add the index of the newest table when the path is an array of tables."""
        return (*path, self.lengths[path] - 1) if path in self.lengths else path

    def names(self) -> list[tuple[str, int]]:
        """Read a dotted key as (name, offset) pairs, and the space after it."""
        names = [self.name()]
        while self.take("."):
            names.append(self.name())
            if self.bounded and len(names) > MOST_PARTS:
                message = f"a key of more than {MOST_PARTS} parts; no key of a scene has more than two"
                raise TooDeep(message, self.place(names[0][1]))
        return names

    def name(self) -> tuple[str, int]:
        """Read one part of a key, with the space around it."""
        self.skip()
        start = self.at
        text = self.matched(self.string_pattern() or _BARE_KEY)
        self.skip()
        return (str(tomllib.loads(f"key = {text}")["key"]) if text[0] in "\"'" else text), start

    def string_pattern(self) -> re.Pattern[str] | None:
        """Return the pattern of the string that starts here, if one does."""
        return next((p for quote, p in _STRINGS.items() if self.text.startswith(quote, self.at)), None)

    def matched(self, pattern: re.Pattern[str]) -> str:
        """Step over what a pattern matches, and return it."""
        match = pattern.match(self.text, self.at)
        if match is None:
            raise ValueError(f"not valid TOML at offset {self.at}")
        self.at = match.end()
        return match[0]

    def pair(self, table: KeyPath) -> None:
        """Read `key = value`."""
        path = table
        start = self.at
        for name, start in self.names():
            path = (*path, name)
            self.places.setdefault(path, (start, start))
        self.take("=")
        self.skip()
        self.places[path] = (start, self.at)
        self.value(path)

    def value(self, path: KeyPath) -> None:
        if self.bounded and len(path) > MOST_LEVELS:
            message = f"lists or tables are nested too deeply (more than {MOST_LEVELS} levels)"
            raise TooDeep(message, self.place(self.at))
        if self.take("["):
            self.entries(path)
        elif self.take("{"):
            self.inline_table(path)
        else:
            self.matched(self.string_pattern() or _SCALAR)

    def entries(self, path: KeyPath) -> None:
        """Read the entries of a list, after its bracket."""
        index = 0
        self.skip(_BLANK)
        while not self.take("]"):
            self.places[(*path, index)] = (self.at, self.at)
            self.value((*path, index))
            index += 1
            self.skip(_BLANK)
            self.take(",")
            self.skip(_BLANK)

    def inline_table(self, path: KeyPath) -> None:
        """Read the pairs of an inline table, after its brace."""
        self.skip(_BLANK)
        while not self.take("}"):
            self.pair(path)
            self.skip(_BLANK)
            self.take(",")
            self.skip(_BLANK)


# --- a clash of values that are valid one by one ---


class Clash(NamedTuple):
    """Keys (as in TOML) whose values do not go together, the one to blame first, and why."""

    keys: tuple[KeyPath, ...]
    message: str
