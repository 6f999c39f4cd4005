# SPDX-License-Identifier: MIT
"""Loads in six components on springs that answer in one vertical plane, and their motions in components.

Axes are right-handed with z up: x, y to its left seen from above; H at height h has M_y = H_x h and M_x = -H_y h. The
caisson is the same in all directions: a load whose H and M lie in one vertical plane is answered there, and turned.
"""

import numpy as np
import xarray as xr

from pysprings.core import variables
from pysprings.core.arrays import Array
from pysprings.core.loads import InPlane
from pysprings.core.text import number

_OFF_PLANE = "springs answer in one vertical plane"
_LEAST = "rot_z is T over the torsional stiffness at rest, the least twist: H and T share friction, which is left out"
_LINEAR = {"long_name": "1 where rot_z is T over the torsional stiffness at rest", "units": "1"}
_UNKNOWN = "T is left out: torsion is not known, as no full model has computed it"


def off_plane(across: float) -> str:
    """Return why a load has no answer: its moment [N m] across its plane."""
    return f"a moment of {number(1e-3 * abs(across))} kN m across the plane of H: {_OFF_PLANE}"


def twist_words(stiffness: float | None) -> str:
    """Return what a twist by the torsional stiffness at rest [N m/rad] is; None: it is not known."""
    return _UNKNOWN if stiffness is None else _LEAST


def twist_of(T: Array, stiffness: float | None) -> Array:
    """Return the linear twist [rad] under T [N m], for the torsional stiffness [N m/rad]; NaN where that is not known.

    Without T it is 0.
    """
    return np.where(T == 0.0, 0.0, np.nan if stiffness is None else T / (stiffness or 1.0))


def with_components(
    answer: xr.Dataset, loads: InPlane, T: Array, stiffness: float | None, linear: Array | bool = True
) -> xr.Dataset:
    """Return answers (dimension step or case) in the planes of loads with their components.

    T (n,) [N m] and the torsional stiffness [N m/rad] give the twist (`twist_of`) where it is linear (n,);
    `linear_twist` marks it.
    """
    by_rest = np.where(linear, T, 0.0)
    dim, c, s = answer["u"].dims[0], np.cos(loads.direction), np.sin(loads.direction)
    u, turn = answer["u"].values, answer["rotation"].values
    values = {
        "u_x": c * u, "u_y": s * u, "rot_x": -s * turn, "rot_y": c * turn, "rot_z": twist_of(by_rest, stiffness),
        "H_x": c * loads.H, "H_y": s * loads.H, "M_x": c * loads.across - s * loads.M,
        "M_y": s * loads.across + c * loads.M, "T": T,
    }  # fmt: skip
    made = {name: (dim, value, variables.GROUPS["space_path"][name].attributes()) for name, value in values.items()}
    turned = answer.assign(made).assign(
        direction=(dim, loads.direction, {"units": "radian", "long_name": "plane of H and M, from x towards y"}),
        linear_twist=(dim, ((by_rest != 0.0) & (stiffness is not None)).astype(np.int8), _LINEAR),
    )
    remark = [twist_words(stiffness)] if by_rest.any() else []
    return turned.assign_attrs(remarks=[*answer.attrs.get("remarks", ()), *remark])
