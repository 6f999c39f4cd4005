# SPDX-License-Identifier: MIT
"""Springs from a user's own table: a CSV file or an Excel workbook with p-y curves, and their companions if any.

`curves` declares columns, checks names and builds springs from independent curves, `recorded` from tables of a path (as
`pysprings springs` writes them); `open_table` chooses.
"""

import os

import xarray as xr

from pysprings.macro.curve_table import CurveSprings


def open_table(path: str | os.PathLike[str], skirt_length: float | None = None) -> xr.DataTree | CurveSprings:
    """Read springs from a CSV or Excel table in the long format of `py.csv` (SI, the unit in each column's name).

    Parameters
    ----------
    path
        Columns `depth_m, y_m, p_N_per_m` at least. Families of companions: `mtheta` (m_Nm_per_m over rotation_rad),
        `base` and `lid` (H_N over y_m, M_Nm over rotation_rad), by the column `family` or by the name of the sheet.
    skirt_length
        Bottom of the lowest slice [m], where the table has no `depth_bottom_m`.

    Returns
    -------
    DataTree or CurveSprings
        Rows of p with step and rotation are the record of a path of a rigid body (what we write ourselves): a spring
        tree, from which a fan can be made. Others are independent curves.

    Raises
    ------
    UserInputError
        Every fault of the table, each with file and line.
    """
    from pysprings.core.tables import Faults
    from pysprings.results.tables.curves import build_curves, read_rows
    from pysprings.results.tables.recorded import build_tree, is_record

    faults = Faults()
    rows = read_rows(path, faults)
    return build_tree(rows, faults) if is_record(rows) else build_curves(rows, skirt_length, faults)
