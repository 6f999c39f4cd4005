# SPDX-License-Identifier: MIT
"""Stiffness (6, 6) of the caisson at mudline, for programs that read a foundation as one matrix."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pysprings.core.errors import refused
from pysprings.macro.model import MacroModel
from pysprings.macro.sets import AnySprings
from pysprings.macro.user_curves import CurveSprings
from pysprings.springs.springs import Springs

Array = NDArray[np.float64]

DOFS = ("x", "y", "z", "rx", "ry", "rz")
TORSION = "torsion (rz) is not known from lateral loading: its row and column are 0; put in a value of your own"


FULL_MODEL = "initial stiffness of the full model"
FIRST_STEPS = "stiffness of the first recorded steps of the table"  # no full model stands behind a table


def stiffness_six(springs: AnySprings | MacroModel) -> xr.DataArray:
    """Return the initial stiffness (6, 6) at the lid centre for (x, y, z, rx, ry, rz), symmetric.

    It is the full model's, `stiffness_initial` of the spring file, whatever spring set predicts; a table with a
    vertical path has that of its first recorded steps instead, and `long_name` names the source. Axes are those of the
    springs: x along the load, z down, y completing a right-handed set; rotations right-hand. Units: N/m for
    displacements, N/rad = N m/m between x and ry (y and rx), N m/rad for rotations. The caisson at rest is
    axisymmetric: what holds for (x, ry) holds for (y, -rx). A state under load is not, and has no such matrix: see
    `stiffness` for the springs' tangent at a state. The block is the mean of the (3, 3) matrix and its transpose
    (they agree but for rounding). Torsion is unknown and stated so: zeros.

    Raises
    ------
    UserInputError
        Springs from a table without a vertical path, which have no vertical stiffness.
    """
    initial, source = _initial(springs)
    if initial is None:
        raise refused("springs", "springs from a table have no vertical stiffness: a 6x6 matrix needs springs.nc")
    coords = {"dof": list(DOFS), "dof_conjugate": list(DOFS)}
    attrs = {
        "long_name": f"{source} at the lid centre",
        "units": "1",
        "comment": "mixed units: N m-1; N radian-1 between x and ry, y and rx; N m radian-1 for rotations",
        "torsion": TORSION,
    }
    return xr.DataArray(axisymmetric(initial), coords, ("dof", "dof_conjugate"), attrs=attrs, name="stiffness_6x6")


def has_six(springs: AnySprings | MacroModel) -> bool:
    """Return whether `stiffness_six` has an answer for springs."""
    return _initial(springs)[0] is not None


def _initial(springs: AnySprings | MacroModel) -> tuple[Array | None, str]:
    """Return the initial stiffness (3, 3) that springs hold, None where they have no vertical one; and whose it is."""
    if isinstance(springs, MacroModel):
        return springs.stiffness_initial, FIRST_STEPS if "first_steps" in springs.attrs else FULL_MODEL
    if isinstance(springs, CurveSprings):
        return None, ""
    given = Springs.of(springs)
    return given.stiffness, FIRST_STEPS if given.first_steps else FULL_MODEL


def axisymmetric(tangent: Array) -> Array:
    """Return the symmetric (6, 6) matrix of an axisymmetric body from its (3, 3) one for (u, w, rotation)."""
    k = 0.5 * (tangent + tangent.T)
    lateral, coupling, rocking, vertical = k[0, 0], k[0, 2], k[2, 2], k[1, 1]
    matrix = np.diag([lateral, lateral, vertical, rocking, rocking, 0.0])
    matrix[0, 4] = matrix[4, 0] = coupling
    matrix[1, 3] = matrix[3, 1] = -coupling
    return matrix
