# SPDX-License-Identifier: MIT
"""A wide table (`pysprings.results.exporters.wide_table`) -> the long format by cell; every row keeps its line."""

from __future__ import annotations

from typing import Any

from pysprings.results.exporters.wide_table import ENDS, PAIRS, parse

Lines = list[tuple[int, list[Any]]]

Place = tuple[str, str, str]  # depth, top and bottom of the slice, as they stand in the heading

_FAMILIES = ("py", "mtheta")  # of PAIRS
_OF_LATERAL = ("y_m", "p_N_per_m", "m_Nm_per_m")  # blank on a vertical path


def is_wide(head: list[str]) -> bool:
    """Return whether a heading is that of a wide table."""
    return any((heading := parse(name)) is not None and heading[0] in PAIRS[0] for name in head)


def unfold(head: list[str], lines: Lines) -> tuple[list[str], Lines]:
    """Return heading and lines of the long format, other tables as they are; other columns stay for the checks."""
    if not is_wide(head):
        return head, lines
    by_depth: dict[Place, dict[str, int]] = {}  # depth and slice -> quantity -> column
    for column, text in enumerate(head):
        if (heading := parse(text)) is not None and any(heading[0] in pair for pair in PAIRS):
            by_depth.setdefault(heading[1], {})[heading[0]] = column
    ends = {wide: head.index(wide) for columns in ENDS.values() for wide in columns.values() if wide in head}
    used = {column for own in by_depth.values() for column in own.values()} | set(ends.values())
    others = [column for column in range(len(head)) if column not in used]
    quantities = [name for pair in PAIRS for name in pair]
    long = ["family", "depth_m", "depth_top_m", "depth_bottom_m", *quantities, *ENDS["base"]]
    return [*long, *(head[column] for column in others)], [
        (line, family + [row[column] if column < len(row) else None for column in others] + row[len(head) :])
        for line, row in lines
        for family in [*_depth_rows(row, by_depth, quantities), *_end_rows(row, by_depth, ends, quantities)]
    ]


def _depth_rows(row: list[Any], by_depth: dict[Place, dict[str, int]], quantities: list[str]) -> list[list[Any]]:
    """Return rows of the families by depth of one wide row: y and p, then m and t; t alone on a vertical path."""
    filled = []
    lateral = [column for own in by_depth.values() for name, column in own.items() if name in _OF_LATERAL]
    if all(_cell(row, column) in (None, "") for column in lateral):
        ends: list[Any] = [None] * len(ENDS["base"])
        t = [[None] * 3 + [_cell(row, own.get("t_N_per_m"))] for own in by_depth.values()]
        return [["tz", *place, *cells, *ends] for place, cells in zip(by_depth, t, strict=True)]
    for family, pair in zip(_FAMILIES, PAIRS, strict=True):
        for place, columns in by_depth.items():
            if not any(name in columns for name in pair):
                continue
            cells = [_cell(row, columns.get(name)) if name in pair else None for name in quantities]
            filled.append([family, *place, *cells, *[None] * len(ENDS["base"])])
    return filled


def _end_rows(
    row: list[Any], by_depth: dict[Place, dict[str, int]], ends: dict[str, int], quantities: list[str]
) -> list[list[Any]]:
    """Return rows of tip (at the bottom of the deepest slice) and lid (depth 0) of one wide row."""
    bottom = max((place[2] for place in by_depth), key=_size)
    filled: list[list[Any]] = []
    for family, columns in ENDS.items():
        if any(wide in ends for wide in columns.values()):
            at = bottom if family == "base" else "0"
            forces = [_cell(row, ends.get(wide)) for wide in columns.values()]
            filled.append([family, at, at, at, *[None] * len(quantities), *forces])
    return filled


def _cell(row: list[Any], column: int | None) -> Any:
    return row[column] if column is not None and column < len(row) else None


def _size(text: str) -> float:
    try:
        return float(text)
    except ValueError:  # the checks of the cells note it
        return float("-inf")
