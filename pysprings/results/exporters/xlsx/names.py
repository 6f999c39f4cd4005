# SPDX-License-Identifier: MIT
"""Defined names of the workbook: a curve, a length or a matrix by its name instead of a cell address."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

from xlsxwriter.utility import xl_range_abs

# Line of the About sheet -> defined name of its number.
LENGTHS = {
    "outer diameter [m]": "outer_diameter",
    "skirt length [m]": "skirt_length",
    "skirt thickness [m]": "skirt_thickness",
}

# Pattern -> what it holds; PATH is the name of a load path, K the number of a depth from the top.
MEANING = {
    "y_K.PATH, p_K.PATH": "p-y curve of the K-th depth from the top (mm, kN/m)",
    "theta.PATH, m_K.PATH, t_K.PATH": "rotation (mrad), distributed moment and vertical reaction of the K-th depth",
    "y_base.PATH, H_base.PATH, V_base.PATH, M_base.PATH": "tip (mm, kN, kN m)",
    "y_lid.PATH, H_lid.PATH, V_lid.PATH, M_lid.PATH": "lid (mm, kN, kN m)",
    "u.PATH, w.PATH, rotation.PATH, H.PATH, V.PATH, M.PATH": "motion and load of the full model (mm, mrad, kN, kN m)",
    "w_tz.PATH, V_tz.PATH, tz_K.PATH": "vertical paths: w (mm), V (kN), vertical reaction of the K-th depth (kN/m)",
    "K_3x3, K_6x6": "initial stiffness of the full model at mudline (kN, m, rad)",
    "outer_diameter, skirt_length, skirt_thickness": "lengths (m)",
    "all curves": "one row a step, the rows of unconverged steps included",
}


class Names:
    """Names of one workbook, unique for any names of paths."""

    def __init__(self, file: Any, paths: Iterable[str]) -> None:
        self._file = file
        self.path: dict[str, str] = {}
        for name in paths:
            plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
            taken = {used.lower() for used in self.path.values()}
            while plain.lower() in taken:
                plain += "_"
            self.path[name] = plain

    def define(
        self, name: str, sheet: str, first: tuple[int, int], last: tuple[int, int], path: str | None = None
    ) -> None:
        """Define a name for the cells from first to last (row, column); of one path when it is given."""
        full = name if path is None else f"{name}.{self.path[path]}"
        self._file.define_name(full, f"='{sheet}'!{xl_range_abs(*first, *last)}")
