# SPDX-License-Identifier: MIT
"""Print the verification table: ``python -m tests.verification.table [--quick] [--markdown] [--out FILE]``.

``--only NAME`` computes a case alone. Rows go to stdout as each case ends, progress to stderr; ``--out`` also
writes them to a CSV file, which the page of the documentation shows; with ``--only`` they replace
those of the same case in the file and follow those of other cases. Exit 1 when a row is out of tolerance or a case
fails.
"""

import argparse
import csv
import math
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path

from tests.verification.cases import (
    alternation,
    caisson_by_depth,
    caisson_stiffness,
    caisson_water,
    cavity,
    clay,
    clay_anisotropy,
    cryer,
    drained_push,
    film_flow,
    film_transfer,
    layered_water,
    mandel,
    patch,
    porous_interface,
    pressure_patch,
    sand_stiffness,
    series_water,
    sliding_block,
    steel_rings,
    steel_shell,
    stefan_film,
    tangents,
    terzaghi,
    triaxial,
    two_discretisations,
    undrained_column,
)
from tests.verification.rows import HEADINGS, Row, cells

Rows = Callable[[], Iterable[Row]]
# In a few seconds each
QUICK: dict[str, Rows] = {
    "triaxial tests": triaxial.rows,
    "spherical cavity": cavity.rows,
    "patch tests": patch.rows,
    "sliding block": sliding_block.rows,
    "tangents": tangents.rows,
    "elastic caisson": steel_shell.rows,
    "elastic caisson in series": steel_rings.rows,
    "pore pressure patch": pressure_patch.rows,
    "Terzaghi": terzaghi.rows,
    "Mandel": mandel.rows,
    "undrained column": undrained_column.rows,
    "flow across a film": film_transfer.rows,
    "opening film": stefan_film.rows,
    "interface between soils": porous_interface.rows,
    "stiffness, coarse mesh": caisson_stiffness.rows,
    "water in series": series_water.rows,
    "cavities in clay": clay.cavity_rows,
    "clay with su by direction": clay_anisotropy.rows,
    "sand, stiffness in a run": sand_stiffness.rows,
}
# Up to a minute each
SLOW: dict[str, Rows] = {
    "contact around the ring": alternation.rows,
    "caisson with water": caisson_water.rows,
    "Cryer": cryer.rows,
    "water in series, the paper's pull": series_water.slow_rows,
    "flow along a film": film_flow.rows,
    "drained push": drained_push.rows,
    "limits of both discretisations": two_discretisations.rows,
    "drained push, variants": drained_push.slow_rows,
    "contact around the ring, variants": alternation.slow_rows,
    "elastic caisson, stiffness by depth": caisson_by_depth.rows,
    "circle on clay": clay.circle_rows,
    "flow around a pile": clay.pile_rows,
    "pull-out from clay": clay.pull_out_rows,
    "sand with water over clay": layered_water.rows,
    "sand with water over clay, yielding": layered_water.push_rows,
}
# Several factorisations of the paper mesh
LONG: dict[str, Rows] = {
    "stiffness, paper mesh": caisson_stiffness.slow_rows,
    "caisson with water, paper mesh": caisson_water.slow_rows,
}
# Many increments in clay: up to a few minutes each
LONGEST: dict[str, Rows] = (
    {"circle on clay, three meshes": clay.circle_order_rows, "disc turns on clay under V": clay.disc_moment_rows}
    | {"caisson with water, what takes stiffness away": caisson_water.share_rows}
    | {
        f"{clay.caisson_name(*caisson)}, {load}": partial(clay.caisson_case, *caisson, load)
        for caisson, loads in clay.CAISSONS.items()
        for load in loads
    }
    | {
        f"{clay.caisson_name(*caisson)}, preset {preset}": partial(clay.preset_case, *caisson, preset)
        for caisson in clay.CAISSONS
        for preset in ("coarse", "medium", "paper", "fine", "coarse:2")
    }
    | {
        f"{clay.caisson_name(*clay.ENVELOPE)}, V/V_ult {share:g}": partial(clay.envelope_case, share)
        for share in (0.0, 0.5)
    }
    | {f"{clay.caisson_name(*clay.ENVELOPE)}, rotation about the tip": clay.about_tip_case}
)


def _all() -> dict[str, Rows]:
    return QUICK | SLOW | LONG | LONGEST


def compute(name: str, case: Rows) -> tuple[Row, ...]:
    """Rows of a case; one row out of tolerance, with the reason, where the case fails."""
    try:
        return tuple(case())
    except Exception as error:
        reason = f"fails: {type(error).__name__}: {error}".replace("|", "/")
        return (Row.error(name, reason, math.nan, "", 0.0),)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the cases, print the table, return the exit code."""
    parser = argparse.ArgumentParser("python -m tests.verification.table", description="Print the verification table.")
    parser.add_argument("--quick", action="store_true", help="leave out the paper mesh, and collapse loads in clay")
    parser.add_argument("--only", action="append", metavar="NAME", choices=[*_all()], help="a case; may be repeated")
    parser.add_argument("--markdown", action="store_true", help="print a markdown table")
    parser.add_argument("--out", type=Path, help="CSV file to write the rows to as well")
    options = parser.parse_args(arguments)
    print_line = _markdown_line if options.markdown else _plain_line
    print_line(HEADINGS)
    if options.markdown:
        print_line(("---", "---", "--:", "--:", "--:", "---"))
    done: list[Row] = []
    for name, case in _chosen(options).items():
        print(f"{name} ...", end=" ", file=sys.stderr, flush=True)
        start = time.perf_counter()
        rows = compute(name, case)
        print(f"{time.perf_counter() - start:.1f} s", file=sys.stderr, flush=True)
        for row in rows:
            print_line(cells(row))
        done.extend(rows)
    if options.out:
        write_rows(done, options.out, keep_others=bool(options.only))
    bad = sum(not row.holds for row in done)
    print(f"{len(done)} rows, {bad} out of tolerance", file=sys.stderr)
    return 1 if bad else 0


def _chosen(options: argparse.Namespace) -> dict[str, Rows]:
    """Return the cases that the options ask for."""
    if options.only:
        return {name: case for name, case in _all().items() if name in options.only}
    return QUICK | SLOW if options.quick else _all()


def write_rows(rows: Iterable[Row], file: Path, keep_others: bool = False) -> None:
    """Write rows to a CSV file: the texts of the printed table, then the figures they were rounded from.

    With ``keep_others`` the rows that the file has of other cases stay, before these.
    """
    heads = [*HEADINGS, "ours_exact", "reference_exact", "tolerance"]
    lines = []
    for row in rows:
        tolerance = "" if row.tolerance is None else str(row.tolerance)
        lines.append([*cells(row), repr(float(row.ours)), repr(float(row.reference)), tolerance])
    if keep_others and file.exists():
        with file.open(newline="", encoding="utf-8") as stream:
            lines = [old for old in [*csv.reader(stream)][1:] if old[0] not in {line[0] for line in lines}] + lines
    with file.open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream, lineterminator="\n").writerows([heads, *lines])


def _markdown_line(texts: Iterable[str]) -> None:
    print("| " + " | ".join(texts) + " |", flush=True)


def _plain_line(texts: Iterable[str]) -> None:
    case, quantity, ours, reference, difference, source = texts
    print(f"{case:<52}  {quantity:<60}  {ours:>11}  {reference:>9}  {difference:>20}  {source}", flush=True)


if __name__ == "__main__":
    sys.exit(main())
