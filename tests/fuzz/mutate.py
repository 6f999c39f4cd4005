# SPDX-License-Identifier: MIT
"""Damage to texts and bytes, drawn as small lists of (what, where, how), which hypothesis can shrink."""

import os
from collections.abc import Sequence

from hypothesis import HealthCheck, Phase, settings, strategies as st

Op = tuple[str, int, int]

QUICK = 20  # inputs of a quick test
_HEALTH = [HealthCheck.too_slow, HealthCheck.function_scoped_fixture, HealthCheck.data_too_large]


def budget(examples: int) -> settings:
    """So many inputs, the same ones every time; others each time where PYSPRINGS_FUZZ=random."""
    same = os.environ.get("PYSPRINGS_FUZZ") != "random"
    phases = (Phase.generate, Phase.shrink) if examples <= QUICK else (Phase.generate,)  # shrinking takes minutes
    return settings(
        max_examples=examples, deadline=None, derandomize=same, database=None, phases=phases,
        suppress_health_check=_HEALTH,
    )  # fmt: skip


def ops(names: Sequence[str], most: int = 5) -> st.SearchStrategy[list[Op]]:
    """Draw what to do: names, each with two numbers that say where and how."""
    number = st.integers(0, 2**32 - 1)
    return st.lists(st.tuples(st.sampled_from(names), number, number), min_size=1, max_size=most)


class Data(bytes):
    """The content of a file; the last one that failed is still in the folder of its test."""

    def __repr__(self) -> str:
        return f"<{len(self)} bytes, beginning {bytes(self[:60])!r}>"


NUMBERS = [
    "nan", "inf", "-inf", "0", "-0.0", "-1", "1e-320", "1e308", "-1e308", "1e-12", "1e12", "1e999", "9" * 400, "0x10",
    "1_000", "1,5", "1 000", "٣", "1e", "--1", "+1", ".5", "5.", "1e+3", "½", "∞",
]  # fmt: skip
TEXTS = [
    "", " ", "\x00", "../../x", "/etc/passwd", "C:\\x", "<script>alert(1)</script>", "&amp;", "\x1b[31m", "\u202e",
    "\ufeff",
    "=cmd|' /C calc'!A0", "+1+1", "-1", "@SUM(A1)", "${HOME}", "`id`", "$(id)", "'; DROP TABLE x; --", "%s%n", "{0}",
    "{{7*7}}", "x" * 5000, "é" * 100, "\U0001f4a9", "\ud7ff", "True", "None", "null", "\r\n", "\t",
]  # fmt: skip
BYTES = [b"\x00", b"\xff", b"\xfe\xff", b"\xc3", b"\xed\xa0\x80", b"\n", b"\r", b'"', b"'", b"\\", b"[", b"]", b"="]

RAW = ("flip", "drop", "insert", "double", "truncate", "swap")


def damage(data: bytes, todo: Sequence[Op]) -> Data:
    """Return bytes with bits flipped, pieces dropped, doubled, swapped, and others put in."""
    out = bytearray(data)
    for what, where, how in todo:
        at = where % (len(out) + 1)
        size = 1 + how % 64
        if what == "flip" and out:
            out[at % len(out)] ^= 1 << (how % 8)
        elif what == "drop":
            del out[at : at + size]
        elif what == "insert":
            out[at:at] = BYTES[how % len(BYTES)]
        elif what == "double":
            out[at:at] = out[at : at + size]
        elif what == "truncate":
            del out[at:]
        elif what == "swap":
            out[at : at + size], out[:size] = out[:size], out[at : at + size]
    return Data(out)
