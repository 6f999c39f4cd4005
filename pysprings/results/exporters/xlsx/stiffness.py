# SPDX-License-Identifier: MIT
"""The workbook's stiffness sheet: 6 x 6 for programs that read a foundation as one matrix, then 3 x 3 by spring set."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pysprings.macro.model import MacroModel
from pysprings.macro.sets import spring_sets
from pysprings.macro.spring_sets import SPRING_SETS
from pysprings.macro.stiffness import FULL_MODEL, TORSION, stiffness_six
from pysprings.results.exporters.xlsx.sheet import Book
from pysprings.springs.path import paths_of

KN = 1e-3
ON_A_PAGE = 31  # rows of a printed page
_SIX = (("Fx [kN]", "Fy [kN]", "Fz [kN]", "Mx [kN m]", "My [kN m]", "Mz [kN m]"),
        ("per x [m]", "per y [m]", "per z [m]", "per rx [rad]", "per ry [rad]", "per rz [rad]"))  # fmt: skip
_THREE = (("H [kN]", "V [kN]", "M [kN m]"), ("per u [m]", "per w [m]", "per rotation [rad]"))

_NOTES = (
    "Axes: x along the load, y to its left seen from above, z up; rotations right-hand. The caisson at rest is "
    "axisymmetric: what holds for (x, ry) holds for (y, -rx).",
    TORSION[0].upper() + TORSION[1:] + ".",
    "About another point: `pysprings predict ... --stiffness --reference-depth LENGTH`.",
    "Springs of one path at rest: slope of the first recorded step, below the full model's initial one; w is the full "
    "model's elastic stiffness.",
)


def write_stiffness(book: Book, sheet: Any, springs: xr.DataTree) -> None:
    """Write the full model's initial stiffness as 6 x 6, then the 3 x 3 of the full model and of each spring set."""
    names = book.names
    sheet.set_column(0, 0, 30)
    sheet.set_column(1, 6, 16)
    full = springs.dataset["stiffness_initial"].values
    row = _block(book, sheet, 0, f"{FULL_MODEL} at the lid centre, 6 x 6", stiffness_six(springs).values, _SIX)
    names.define("K_6x6", sheet.name, (2, 1), (7, 6))
    for note in _NOTES:
        sheet.write_string(row, 0, note)
        row += 1
    row += 1
    names.define("K_3x3", sheet.name, (row + 2, 1), (row + 4, 3))
    row = _block(book, sheet, row, f"{FULL_MODEL} at the lid centre, 3 x 3", full, _THREE)
    breaks = [0]
    for words, matrix in _sets(springs):
        if row + 3 + len(matrix) > breaks[-1] + ON_A_PAGE:
            breaks.append(row)
        row = _block(book, sheet, row, f"stiffness of the springs at rest: {words}", matrix, _THREE)
    sheet.set_h_pagebreaks(breaks[1:])


def _sets(springs: xr.DataTree) -> list[tuple[str, NDArray[np.float64]]]:
    sets = [SPRING_SETS[name] for name in spring_sets(springs)]
    blocks = [
        (each.label, MacroModel.from_springs(springs, each.name).tangent_stiffness().values)
        for each in reversed(sets)
        if each.several
    ]
    for name in (name for name, path in paths_of(springs).items() if not path.is_vertical):
        for each in (each for each in sets if not each.several):
            matrix = MacroModel.from_springs(springs, each.name, name).tangent_stiffness().values
            blocks.append((f"{each.name} springs of path {name}", matrix))
    return blocks


def _block(
    book: Book, sheet: Any, row: int, words: str, matrix: NDArray[np.float64], labels: tuple[tuple[str, ...], ...]
) -> int:  # fmt: skip
    """Write one matrix in kN, m, rad with its labels; return the row behind it."""
    sheet.write_string(row, 0, words, book.title)
    for column, label in enumerate(labels[1], start=1):
        sheet.write_string(row + 1, column, label, book.head)
    for line, label in enumerate(labels[0]):
        sheet.write_string(row + 2 + line, 0, label, book.head)
        sheet.write_row(row + 2 + line, 1, (matrix[line] * KN + 0.0).tolist(), book.tenth)
    return row + 3 + len(labels[0])
