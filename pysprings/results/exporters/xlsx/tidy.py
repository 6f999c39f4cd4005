# SPDX-License-Identifier: MIT
"""The tidy sheet: a row for each path, step and depth, one heading row, for filters and pivots."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from pysprings.results.exporters.xlsx.sheet import KN, MM, MRAD, Book, datasets, print_a_look
from pysprings.springs.sums import by_depth

HEADINGS = (
    "path", "role", "step", "converged (1 = yes)", "depth [m]", "slice top [m]", "slice bottom [m]",
    "u [mm]", "w [mm]", "rotation [mrad]", "y [mm]",
    "p net [kN/m]", "m net [kN m/m]", "t net [kN/m]",
)  # fmt: skip


def write_tidy(book: Book, sheet: Any, springs: xr.DataTree) -> None:
    """Write the net reactions of all paths below each other, with a filter over the headings."""
    sheet.write_row(0, 0, HEADINGS, book.head)
    row = 0
    for name, path in zip(book.rows, datasets(springs, book.rows), strict=True):
        steps, depths = path.sizes["step"], path.sizes["depth"]
        step, depth = (index.ravel() for index in np.indices((steps, depths)))
        bounds = path["depth_bounds"].values
        sheet.write_column(row + 1, 0, [name] * step.size)
        sheet.write_column(row + 1, 1, [str(path.attrs.get("role", ""))] * step.size)
        columns = [
            step, path["converged"].values[step], path["depth"].values[depth], *bounds[depth].T,
            *(path[key].values[step] * scale for key, scale in _MOTION.items()),
            path["y"].transpose("step", "depth").values.ravel() * MM,
            *(by_depth(path, key).T.ravel() * KN for key in ("p", "m", "t")),
        ]  # fmt: skip
        for col, values in enumerate(columns, start=2):
            cells = [None if np.isnan(value) else value for value in np.asarray(values, dtype=float).tolist()]
            sheet.write_column(row + 1, col, cells, book.number if col >= 4 else None)
        row += step.size
    sheet.set_row(0, 45)
    sheet.set_column(0, 1, 14)
    sheet.set_column(2, len(HEADINGS) - 1, 11)
    sheet.freeze_panes(1, 1)
    sheet.repeat_rows(0)
    sheet.autofilter(0, 0, row, len(HEADINGS) - 1)
    print_a_look(sheet, 1, row, len(HEADINGS))


_MOTION = {"u": MM, "w": MM, "rotation": MRAD}
