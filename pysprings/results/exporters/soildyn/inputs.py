# SPDX-License-Identifier: MIT
"""Input files of SoilDyn, as OpenFAST 5.0.0 reads them (commit 2895884): one matrix, or points of a library."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pysprings.core.text import commented, one_line

Array = NDArray[np.float64]
Place = tuple[float, float, float]

MATRIX, LIBRARY = 1, 3  # CalcOption
# reactions of the soil (kN, kN m) and motions (m, rad), by point
_FORCES, _MOTIONS = ("Fx", "Fy", "Fz", "Mx", "My", "Mz"), ("TDx", "TDy", "TDz", "RDx", "RDy", "RDz")


def matrix_input(head: Sequence[str], stiffness: Array, place: Place) -> str:
    """Return an input file with one matrix (6, 6) at a place [m]; the header stands at its end, too."""
    return _input(head, MATRIX, stiffness, place, [])


def library_input(head: Sequence[str], library: str, springs: str, places: Sequence[Place]) -> str:
    """Return an input file with points on the springs of a library.

    Parameters
    ----------
    library
        Shared library, relative to the working folder of OpenFAST.
    springs
        Spring file, relative to the input file; at most 45 letters with the folder of the input file.
    places
        Points (x, y, z) [m].
    """
    points = [f'{x:.10g} {y:.10g} {z:.10g} "{springs}" "{springs}"' for x, y, z in places]
    return _input(head, LIBRARY, np.zeros((6, 6)), places[0], points, library)


def _input(
    head: Sequence[str], option: int, stiffness: Array, place: Place, points: Sequence[str], library: str = "unused"
) -> str:
    lines = [
        f"---------- SoilDyn Input File: {one_line(head[0])} ----------",
        "scene, frame, units, range and error: below END",
        "---------- Options ----------",
        "False        Echo         - Echo the input data",
        '"default"    DT           - Time step (s)',
        f"{option}            CalcOption   - 1: stiffness matrix, 3: library",
        "---------- Stiffness and damping at one point (CalcOption 1) ----------",
        f"{place[0]:.10g} {place[1]:.10g} {place[2]:.10g}    Location (x, y, z) (m)",
        "---------- Stiffness (N/m, N/rad, N m/rad) ----------",
        *(" ".join(f"{value:.15E}" for value in row) for row in stiffness),
        "---------- Damping (not supported by SoilDyn) ----------",
        *["0 0 0 0 0 0"] * 6,
        "---------- P-Y curves (not available in SoilDyn) ----------",
        "0            PY_NumPoints",
        "---------- Location (x, y, z) (m) and file ----------",
        "---------- Library (CalcOption 3) ----------",
        "2            DLL_Model",
        f'"{library}"     DLL_FileName',
        f"{len(points)}            DLL_NumPoints",
        "---------- Location (x, y, z) (m) and files ----------",
        *points,
        "---------- Output ----------",
        "False        SumPrint",
        "---------- OutList ----------",
        *_outputs(max(1, len(points))),
        "END of input",
        *commented("!", head),
    ]
    return "\n".join(lines) + "\n"


def _outputs(points: int) -> list[str]:
    """Return the output channels of up to nine points, as many as SoilDyn has."""
    names = [[f"Sld{k + 1}{name}g" for name in each] for k in range(min(points, 9)) for each in (_FORCES, _MOTIONS)]
    return [f'"{", ".join(row)}"' for row in names]
