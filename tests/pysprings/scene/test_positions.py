# SPDX-License-Identifier: MIT
"""Places of keys and values in TOML: by hand, and against tomllib on generated documents."""

import json
import re
import tomllib
from collections.abc import Iterator
from typing import Any

from hypothesis import HealthCheck, given, reject, settings, strategies as st

from pysprings.scene.positions import KeyPath, Place, locate, nearest

BY_HAND = '''# comment = 1
title = "x # y = 3" # z
a.b."c d" = 1
"quo\\u0074ed" = [ 1, [2, "]"], # ] comment
   {k = 'v', d.e = 2}, """m ""
""", ]
[soil]
E = """
a "" b\\"""
c"""""
d = 1979-05-27 07:32:00
lit = \'\'\'it's
two\'\'\'
[[path]]
name = ""
r = []
[path.sub]
q=1
[[path]]
name="b"
[[path.sub]]
z = +inf
[ "x y" . b ]
k = {}
'''

PLACES: dict[KeyPath, tuple[tuple[int, int], tuple[int, int]]] = {
    ("title",): ((2, 1), (2, 9)),
    ("a", "b", "c d"): ((3, 5), (3, 13)),
    ("quoted",): ((4, 1), (4, 17)),
    ("quoted", 1, 1): ((4, 26), (4, 26)),
    ("quoted", 2, "k"): ((5, 5), (5, 9)),
    ("quoted", 2, "d", "e"): ((5, 16), (5, 20)),
    ("quoted", 3): ((5, 24), (5, 24)),
    ("soil",): ((7, 1), (7, 1)),
    ("soil", "E"): ((8, 1), (8, 5)),
    ("soil", "d"): ((11, 1), (11, 5)),
    ("soil", "lit"): ((12, 1), (12, 7)),
    ("path",): ((14, 1), (14, 1)),
    ("path", 0): ((14, 1), (14, 1)),
    ("path", 0, "r"): ((16, 1), (16, 5)),
    ("path", 0, "sub", "q"): ((18, 1), (18, 3)),
    ("path", 1): ((19, 1), (19, 1)),
    ("path", 1, "sub", 0, "z"): ((22, 1), (22, 5)),
    ("x y", "b", "k"): ((24, 1), (24, 5)),
}


def paths_of(data: Any, path: KeyPath = ()) -> Iterator[tuple[KeyPath, Any]]:
    """Give every key path of parsed TOML and its value."""
    entries = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in entries:
        yield (*path, key), value
        yield from paths_of(value, (*path, key))


def test_by_hand() -> None:
    found = locate(BY_HAND)
    assert {path: (found[path].key, found[path].value) for path in PLACES} == PLACES
    assert set(found) == {path for path, _ in paths_of(tomllib.loads(BY_HAND))}


def test_windows_line_ends_count_the_same() -> None:
    found = locate(BY_HAND.replace("\n", "\r\n"))
    assert {path: (found[path].key, found[path].value) for path in PLACES} == PLACES


def test_nearest_falls_back_to_the_table_around() -> None:
    found = locate(BY_HAND)
    assert nearest(found, ("path", 0, "kind")) == found[("path", 0)]
    assert nearest(found, ("mesh", "preset")) == Place((1, 1), (1, 1))


# --- generated documents: scalars and keys are drawn between marks, so their places are known ---

BARE = st.text(alphabet="abcXYZ019_-", min_size=1, max_size=4)
WILD = st.text(alphabet='ab"\\ .#=[]{}é\t', max_size=4)
CALM = WILD.filter(lambda text: "'" not in text)

SCALARS = st.one_of(
    st.integers(-999, 999).map(str),
    st.sampled_from(["1.5e3", "-inf", "0x1F", "true", "1979-05-27", "1979-05-27 07:32:00Z", "07:32:00"]),
    WILD.map(lambda text: json.dumps(text, ensure_ascii=False)),
    CALM.map(lambda text: f"'{text}'"),
    WILD.map(lambda text: '"""\n' + text.replace("\\", "\\\\").replace('"', '\\"') + '\n"" """'),
    CALM.map(lambda text: f"'''{text}\n''it''''"),
).map(lambda literal: f"<v{literal}v>")
GAPS = st.sampled_from(["", " ", "\n", " # ] } , \" '\n  ", "\r\n\t"])


@st.composite
def keys(draw: st.DrawFn) -> str:
    """Draw a key, marked."""
    style = draw(st.sampled_from(["bare", "literal", "basic"]))
    if style == "bare":
        return f"<k{draw(BARE)}k>"
    written = f"'{draw(CALM)}'" if style == "literal" else json.dumps(draw(WILD), ensure_ascii=False)
    return f"<k{written}k>"


@st.composite
def arrays(draw: st.DrawFn, inner: st.SearchStrategy[str]) -> str:
    """Draw a list over several lines, with comments."""
    parts = [draw(GAPS) + item + draw(GAPS) for item in draw(st.lists(inner, max_size=3))]
    comma = "," if parts and draw(st.booleans()) else ""
    return "[" + ",".join(parts) + comma + draw(GAPS) + "]"


@st.composite
def inline_tables(draw: st.DrawFn, inner: st.SearchStrategy[str]) -> str:
    """Draw an inline table."""
    pairs = draw(st.lists(st.tuples(keys(), inner), max_size=3))
    return "{ " + ", ".join(f"{key} = {value}" for key, value in pairs) + "}"


VALUES = st.recursive(SCALARS, lambda inner: st.one_of(arrays(inner), inline_tables(inner)), max_leaves=6)


@st.composite
def documents(draw: st.DrawFn) -> str:
    """Draw a marked document; where its keys clash, tomllib refuses it."""
    lines = []
    for _ in range(draw(st.integers(0, 6))):
        kind = draw(st.sampled_from(["pair", "pair", "dotted", "table", "array", "comment"]))
        first, second = draw(keys()), draw(keys())
        name = first if kind == "pair" or draw(st.booleans()) else f"{first} . {second}"
        if kind == "comment":
            lines.append("  # a = 1 [b]")
        elif kind in ("pair", "dotted"):
            lines.append(f"{draw(st.sampled_from(['', '  ']))}{name} = {draw(VALUES)} # c")
        else:
            name = name.replace("<k", "").replace("k>", "")  # a table stands at its bracket
            lines.append(f"[[ {name} ]]" if kind == "array" else f"[{name}] # d")
    return "\n".join(lines) + draw(st.sampled_from(["", "\n"]))


def unmarked(document: str) -> tuple[str, dict[int, str], dict[int, str]]:
    """Take the marks out; return the text, and the literals of scalars and of keys by offset."""
    text, found = "", {"v": {}, "k": {}}
    for piece in re.split(r"(<[kv][\s\S]*?[kv]>)", document):
        if piece[:2] in ("<k", "<v"):
            found[piece[1]][len(text)] = piece[2:-2]
        text += piece[2:-2] if piece[:2] in ("<k", "<v") else piece
    return text, found["v"], found["k"]


def offset(text: str, place: tuple[int, int]) -> int:
    lines = text.split("\n")
    return sum(len(line) + 1 for line in lines[: place[0] - 1]) + place[1] - 1


@settings(deadline=None, max_examples=120, suppress_health_check=[HealthCheck.filter_too_much])
@given(documents())
def test_generated_documents(document: str) -> None:
    """Every path is found; scalars and keys stand exactly where they were written."""
    text, scalars, written_keys = unmarked(document)
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        reject()
    found = locate(text)
    values = dict(paths_of(data))
    assert set(found) == set(values)
    leaves = {path: value for path, value in values.items() if not isinstance(value, dict | list)}
    assert {offset(text, found[path].value) for path in leaves} == set(scalars)
    for path, value in leaves.items():
        literal = scalars[offset(text, found[path].value)]
        assert tomllib.loads(f"k = {literal}")["k"] == value
        if isinstance(path[-1], str):
            key = written_keys[offset(text, found[path].key)]
            assert next(iter(tomllib.loads(f"{key} = 1"))) == path[-1]
