# SPDX-License-Identifier: MIT
"""The standard deviation that springs of an atlas have: a group of the file beside the paths.

`H_mode` [N] and `M_mode` [N m] (mode, ray, knot): loads along each ray of independent modes of one standard deviation;
`rho` [m] (knot): the motions, which are those of the paths. `turn` (knot): standard deviation over the rotation of what
straight rays do not say of the rotation under a load.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from pysprings.core.errors import refused

GROUP = "atlas"
_DIMS = ("mode", "ray", "knot")


def check_spread(data: xr.Dataset) -> xr.Dataset:
    """Return the group as it is. Raises UserInputError where something is missing or not finite."""
    for name in ("H_mode", "M_mode"):
        if name not in data or data[name].dims != _DIMS:
            raise refused(f"{GROUP}/{name}", f"missing, or not by {', '.join(_DIMS)}")
    for name in ("rho", "turn"):
        if name not in data or data[name].dims != ("knot",) or "ray" not in data.coords:
            raise refused(f"{GROUP}/{name}", "missing, or not by knot")
    for name in ("H_mode", "M_mode", "rho", "turn"):
        if not np.isfinite(data[name].values).all():
            raise refused(f"{GROUP}/{name}", "not finite")
    return data
