# SPDX-License-Identifier: MIT
"""Hostile scenes: real ones damaged, and typed ones over the whole range of every key."""

import json
import math
import re
from pathlib import Path
from typing import Any

from hypothesis import strategies as st

from pysprings.core import units
from pysprings.core.path_kinds import PATH_KINDS
from pysprings.scene.by_depth import SURFACES, BySurface, Profile
from pysprings.scene.fields import Choice, Count, Field, Flag, Interval, Number, Quantity, QuantityList, Text, field_of
from pysprings.scene.load import SECTIONS
from pysprings.scene.soils.clay import ReductionTable
from pysprings.scene.soils.cyclic import CyclicTable
from pysprings.scene.template import template_text
from tests.fuzz.mutate import NUMBERS, RAW, TEXTS, Data, Op, damage, ops

SCENES = Path(__file__).parents[2] / "data" / "scenes"
BASES = [
    *(template_text(name) for name in ("paper-drained", "paper-partially-drained", "fan")),
    *(file.read_text(encoding="utf-8") for file in sorted(SCENES.glob("*.toml"))),
    'title = "t"\nsoil = {K0 = 0.9}\n[[path]]\nname = "p"\nkind = "pull"\nlateral_displacement = "1 mm"\n',
]
UNITS = ["m", "mm", "kN", "MPa", "deg", "degC", "s", "N/m^3", "m/(Pa s)", "m/s", "parsec", "kg m/s^2", "", "%", "m^99"]
VALUES = [
    *NUMBERS[:12], "true", '""', '"x"', "[]", "{}", "{a = 1}", '["1 mm", 2]', "1979-05-27", "1979-05-27T07:32:00Z",
    '"balanced"', '"rotation"', '"load"', '"9**9**9 m"', '"1e400 m"', '"-0 m"', '"1 mm at 1 mm/s in 3 s"',
    '["rest 1 s"]',
    '"""', "'''", "[[", "[" * 200 + "]" * 200, "{a = " * 50, '"\\u0000"', '"\\ud800"', '"\\U00110000"', '"\\x"', "0b2",
]  # fmt: skip
LINES = [
    "[soil]", "[[soil]]", "[path]", "[[path]]", "[[path.name]]", "[a.b.c]", "soil.K0 = 1", '"" = 1', "= 1", "[",
    "[]", "[[]]",
    "a = 1 b = 2", '"a\\nb" = 2', "'../../x' = 1", "soil = 1", "title = 'x'\x00", "x = " + "1" * 5000, "#" * 5000,
    "y = [" + "1," * 3000 + "]", "z = '" + "é" * 5000 + "'", "k" * 3000 + " = 1", "\u2028a = 1", "\x0c",
    "a.b.c.d.e = 1", ".".join("a" * 900) + " = 1", "z = {" + "a." * 9000 + "a = 1}", "[" + "soil." * 3000 + "x]",
    '[["b"' + ' . "b"' * 2000 + "]]", "soil." + "K" * 5000 + " = 1",
    "x = {" + "a.a.a.a.a.a.a.a={" * 100 + "b=1" + "}" * 101,
]  # fmt: skip
TEXT_OPS = (
    "value", "value", "number", "unit", "text", "key", "line", "drop", "twice", "swap", "section", "many", "dotted",
)  # fmt: skip
GENTLE_OPS = ("scale", "scale", "scale", "drop", "comment", "space", "word")
WHOLE = [*24 * [""], *4 * ["bom"], *4 * ["crlf"], "cr", "utf-16", "utf-32", "latin-1", "empty", "blank"]
WHOLE += ["deep", "tables", "paths"]


def _edit(lines: list[str], what: str, at: int, how: int) -> None:
    """Damage one line."""
    key, equals, value = lines[at].partition("=")
    if what in ("value", "number", "unit", "text") and not equals:
        what = "line"
    if what == "value":
        lines[at] = f"{key}= {VALUES[how % len(VALUES)]}"
    elif what == "number":
        number = NUMBERS[how % len(NUMBERS)]
        lines[at] = f'{key}= "{number} {UNITS[how // 64 % len(UNITS)]}"' if '"' in value else f"{key}= {number}"
    elif what == "scale" and equals:
        lines[at] = key + equals + re.sub(r"[0-9.]+", lambda m: _scaled(m[0], how), value, count=1)
    elif what == "comment":
        lines[at] += f"  # {TEXTS[how % 10]!r}"
    elif what == "space" and equals:
        lines[at] = f"\t{key}   =\t{value}"
    elif what == "word" and equals:
        words = ["coupled", "undrained", "elastic", "held-back", "fixed", "drained", "medium", "superlu"]
        lines[at] = re.sub('"[a-z-]+"', f'"{words[how % len(words)]}"', lines[at], count=1)
    elif what == "unit" and value.count('"') >= 2:
        lines[at] = f'{key}= "{value.split(chr(34))[1].split(" ")[0]} {UNITS[how % len(UNITS)]}"'
    elif what == "text":
        lines[at] = f"{key}= {json.dumps(TEXTS[how % len(TEXTS)], ensure_ascii=bool(how & 64))}"
    elif what == "key":
        lines[at] = f"{['x', 'a.b', chr(34) + 'K 0' + chr(34), 'path', 'soil.K0', 'kind', 'nam'][how % 7]} = {value}"
    elif what == "line":
        lines.insert(at, LINES[how % len(LINES)])
    elif what == "drop":
        del lines[at]
    elif what == "twice":
        lines.insert(at, lines[at])
    elif what == "swap":
        other = how % len(lines)
        lines[at], lines[other] = lines[other], lines[at]
    elif what == "section":
        lines.insert(at, f"[{list(SECTIONS)[how % len(SECTIONS)]}]")
    elif what == "dotted":
        name = ["a", "soil", '"b"', "path"][how % 4]
        many = ".".join([name] * (2 + how // 4 % 20_000))
        lines.insert(at, [f"{many} = 1", f"[{many}]", f"[[{many}]]", f"x = {{{many} = 1}}"][how // 16 % 4])
    elif what == "many":
        lines[at:at] = [lines[at]] * (how % 40)


def _scaled(number: str, how: int) -> str:
    try:
        return f"{float(number) * 10.0 ** (how % 9 - 4) * (1 + how % 7):.6g}"
    except ValueError:
        return number


def _whole(text: str, how: str) -> bytes:
    """Return the bytes of a text, spoiled as a whole."""
    if how == "deep":
        text += "\ndeep = " + "[" * 3000
    elif how == "tables":
        text += "".join(f"\n[t{'.x' * k}]" for k in range(300))
    elif how == "paths":
        path = '\n[[path]]\nname = "q{}"\nkind = "rotation"\nrotation = "1 deg"\nduration = "1 s"'
        text += "".join(path.format(number) for number in range(300))
    simple = {"empty": b"", "blank": b"\n# nothing\n", "bom": b"\xef\xbb\xbf" + text.encode()}
    if how in simple:
        return simple[how]
    if how in ("crlf", "cr"):
        return text.replace("\n", "\r\n" if how == "crlf" else "\r").encode()
    codec = how if how in ("utf-16", "utf-32", "latin-1") else "utf-8"
    return text.encode(codec, "replace")


@st.composite
def damaged(draw: st.DrawFn) -> Data:
    """Draw a scene file that was a good one."""
    lines = draw(st.sampled_from(BASES)).split("\n")
    todo: list[Op] = draw(ops(GENTLE_OPS)) if draw(st.booleans()) else draw(ops(TEXT_OPS, 4))
    for what, where, how in todo:
        if lines:
            _edit(lines, what, where % len(lines), how)
    data = _whole("\n".join(lines), draw(st.sampled_from(WHOLE)))
    return damage(data, draw(ops(RAW, 3))) if draw(st.integers(0, 7)) == 0 else Data(data)


# --- typed scenes ---


@st.composite
def _number(draw: st.DrawFn, interval: str) -> float:
    """Draw a number of an interval: an end, just beyond it, or anywhere between, also in its logarithm."""
    low, high = map(float, Interval(interval).bounds)
    how = draw(st.integers(0, 49))
    if how < 4:
        return (low, high)[how % 2]
    if how == 4:
        return draw(st.sampled_from([low - 1e-9 * abs(low) - 1e-300, high * (1 + 1e-12), -high, 0.0]))
    if low < 0.0 and how % 2:
        return draw(st.sampled_from([-1.0, 1.0])) * min(-low, high) * 10.0 ** draw(st.floats(-8.0, 0.0))
    if how < 20 or low < 0.0:
        return draw(st.floats(low, high, allow_subnormal=False))
    start = math.log10(low) if low > 0.0 else math.log10(high) - 12.0
    return min(max(10.0 ** draw(st.floats(start, math.log10(high))), low), high)


@st.composite
def _by_depth(draw: st.DrawFn, quantity: Quantity) -> Any:
    """Draw a quantity, or a table of one that is linear in depth."""
    ends = [draw(_value(quantity)) for _ in range(2)]
    return draw(st.sampled_from([ends[0], {"top": ends[0], "bottom": ends[1]}]))


@st.composite
def _value(draw: st.DrawFn, field: Field) -> Any:
    """Draw a value as TOML would hold it."""
    if isinstance(field, Flag):
        return draw(st.booleans())
    if isinstance(field, Choice):
        return draw(st.sampled_from([*8 * field.words, *field.planned]))
    if isinstance(field, Count):
        return draw(st.integers(field.low // field.multiple_of, field.high // field.multiple_of)) * field.multiple_of
    if isinstance(field, Number):
        number = _number(field.interval)
        return draw(st.one_of(number, st.just(field.word)) if field.word else number)
    if isinstance(field, Text):
        return draw(st.sampled_from([*TEXTS, "a title"]))
    if isinstance(field, BySurface):
        one = st.sampled_from(field.words)
        each = one if field.number is None else st.one_of(one, _number(field.number.interval))
        return draw(st.one_of(each, st.fixed_dictionaries(dict.fromkeys(SURFACES, each))))
    if isinstance(field, Profile):
        return draw(_by_depth(field.quantity))
    if isinstance(field, ReductionTable):
        return draw(st.lists(st.tuples(_number("[1e-6, 0.1]"), _number("[0.01, 1]")).map(list), min_size=1, max_size=3))
    if isinstance(field, CyclicTable):
        rows = st.lists(st.lists(_number("[0, 100]"), min_size=5, max_size=5), min_size=1, max_size=3)
        return draw(st.fixed_dictionaries({"contours": rows, "cycles": _number("[1, 1e4]")}))
    if isinstance(field, QuantityList):
        return [f"{draw(_number(each.interval))!r} {each.unit}" for _, each in field.quantities]
    assert isinstance(field, Quantity)
    if field.word and draw(st.booleans()):
        return field.word
    value = draw(_number(field.interval))
    if draw(st.integers(0, 7)):
        return f"{value!r} {field.unit}"
    return f"{value * units.unit_of(field.unit)[0]!r} {units.si_of(field.unit)}"


_USED = {
    "pull": ("lateral_displacement", "arm"), "translation": ("lateral_displacement", "rotation"),
    "rotation": ("rotation",), "swipe": ("lateral_displacement", "rotation"), "load": ("lateral_force", "arm"),
    "probe": ("lateral_displacement", "load_angle"),
}  # fmt: skip


@st.composite
def _path(draw: st.DrawFn, name: str) -> dict[str, Any]:
    fields = {key: field_of(info) for key, info in SECTIONS["path"].model_fields.items()}
    kind = draw(st.sampled_from(list(_USED)))
    path: dict[str, Any] = {"name": name, "kind": kind, "role": "held-back"}
    path |= {key: draw(_value(fields[key])) for key in _USED[kind]}
    pace = PATH_KINDS[kind].paces
    if draw(st.integers(0, 3)):
        key = draw(st.sampled_from(pace))
        path[key] = draw(_value(fields[key]))
    if kind not in ("swipe", "probe") and draw(st.integers(0, 3)) == 0:
        entries = fields["then"]
        assert isinstance(entries, QuantityList)
        quantity = dict(entries.quantities)[kind]
        count = draw(st.integers(1, 12))
        path["then"] = [f"{draw(_value(quantity))} in {draw(st.floats(1e-6, 1e12))!r} s" for _ in range(count)]
        if draw(st.booleans()):
            path["then"].append(f"V {draw(_value(fields['vertical_load']))}")
    if draw(st.integers(0, 9)) == 0:
        key = draw(st.sampled_from(["heave", "arm_from", "role", "rate", "rotation"]))
        path[key] = draw(_value(fields[key]))
    return path


@st.composite
def typed(draw: st.DrawFn) -> str:
    """Draw a scene whose values have the right types and lie (but for a few) in their ranges."""
    lines = [f"title = {json.dumps(draw(st.sampled_from(['t', *TEXTS])))}"] if draw(st.integers(0, 3)) == 0 else []
    wide = draw(st.booleans())  # room for a large caisson
    for name, model in SECTIONS.items():
        if name == "path":
            continue
        fields = {key: field_of(info) for key, info in model.model_fields.items() if key not in ("behaviour", "layers")}
        keys = draw(st.lists(st.sampled_from(sorted(fields)), max_size=2, unique=True))
        values = {key: draw(_value(fields[key])) for key in keys}
        if name == "domain" and wide:
            values = {"radius": "1000 m", "depth": "1000 m"}
        lines += [f"[{name}]", *(f"{key} = {_literal(value)}" for key, value in values.items())]
    for number in range(draw(st.integers(1, 3))):
        lines += ["[[path]]", *(f"{key} = {_literal(value)}" for key, value in draw(_path(f"p{number}")).items())]
    return "\n".join(lines) + "\n"


def _literal(value: Any) -> str:
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{key} = {_literal(each)}' for key, each in value.items())} }}"
    return json.dumps(value, ensure_ascii=True).replace("NaN", "nan").replace("Infinity", "inf")
