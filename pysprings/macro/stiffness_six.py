# SPDX-License-Identifier: MIT
"""Stiffness (6, 6) of the caisson at mudline, for programs that want a foundation as one matrix."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pysprings.errors import Problem, UserInputError
from pysprings.macro_model import MacroModel

DOFS = ("x", "y", "z", "rx", "ry", "rz")
TORSION = "torsion (rz) is not known from lateral loading: its row and column are 0; put in a value of your own"


def stiffness_six(model: MacroModel) -> xr.DataArray:
    """Return the initial stiffness (6, 6) at the lid centre for (x, y, z, rx, ry, rz), symmetric.

    Axes are those of the springs: x along the load, z down, y completing a right-handed set; rotations right-hand.
    Units: N/m for displacements, N/rad = N m/m between x and ry (y and rx), N m/rad for rotations. The caisson at
    rest is axisymmetric: what holds for (x, ry) holds for (y, -rx). A state under load is not, and has no such
    matrix. The block is the mean of the springs' tangent and its transpose (a full model's and a fan's are symmetric
    but for rounding). Torsion is unknown and stated so: zeros.

    Raises
    ------
    UserInputError
        Springs from a table, which know no vertical stiffness.
    """
    if model.stiffness_initial is None:
        message = "springs from a table have no vertical stiffness: a 6x6 matrix needs springs.nc"
        raise UserInputError([Problem(key="springs", message=message)])
    matrix = axisymmetric(model.tangent_stiffness().values)
    coords = {"dof": list(DOFS), "dof_conjugate": list(DOFS)}
    attrs = {
        "long_name": "initial stiffness at the lid centre",
        "units": "1",
        "comment": "mixed units: N m-1; N radian-1 between x and ry, y and rx; N m radian-1 for rotations",
        "springs": model.spring_set,
        "torsion": TORSION,
    }
    return xr.DataArray(matrix, coords, ("dof", "dof_conjugate"), attrs=attrs, name="stiffness_6x6")


def axisymmetric(tangent: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the symmetric (6, 6) matrix of an axisymmetric body from its (3, 3) one for (u, w, rotation)."""
    k = 0.5 * (tangent + tangent.T)
    lateral, coupling, rocking, vertical = k[0, 0], k[0, 2], k[2, 2], k[1, 1]
    matrix = np.diag([lateral, lateral, vertical, rocking, rocking, 0.0])
    matrix[0, 4] = matrix[4, 0] = coupling
    matrix[1, 3] = matrix[3, 1] = -coupling
    return matrix
