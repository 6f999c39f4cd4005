# SPDX-License-Identifier: MIT
"""Excess pore pressure and lateral shear around the caisson, drawn radially (the paper's figures 9 and 15)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from pysprings.results.plots.picture import Picture
from pysprings.results.plots.signed_rose import Quantity, draw_signed_rose
from pysprings.results.plots.style import styled

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

PRESSURE = Quantity("pore_pressure", "Excess pore pressure around the skirt", "pressure", False)
PRESSURE_RATIO = Quantity(
    "pore_pressure", "Excess pore pressure around the skirt / initial $p'_N$", "pressure", normalised=True
)
SHEAR = Quantity(
    "shear_lateral", "Shear stress in the loading direction / initial $p'_N$, on the soil, along +x positive", "shear",
    normalised=True, marks=(0.0, np.pi / 2.0, np.pi), places=("front", "side", "back"),
)  # fmt: skip


@styled
def pressure_rose(
    path: xr.Dataset,
    step: int | None = None,
    displacement: float | None = None,
    depths: Iterable[float] | None = None,
    normalised: bool = False,
) -> Figure:
    """Draw the excess pore pressure in the interface at four depths, on both sides of the skirt.

    The trace of the caisson is zero; pressure goes outward from it, suction inward, on one scale for all panels. The
    half model is mirrored to the full ring; the front is on the right.

    Parameters
    ----------
    path
        One path with pore_pressure (step, side, azimuth, depth) [Pa], compression positive, over hydrostatic.
    step, displacement
        A step, or the lateral displacement [m] it should be nearest to; default the last converged step.
    depths
        Depths [m], nearest rings; default 1/16, 5/16, 9/16 and 13/16 of the skirt.
    normalised
        Over the initial normal effective stress of each ring, as the paper does, instead of kPa; zones without contact
        stress are then marked.
    """
    return draw_signed_rose(path, PRESSURE_RATIO if normalised else PRESSURE, step, displacement, depths)


@styled
def shear_rose(
    path: xr.Dataset,
    step: int | None = None,
    displacement: float | None = None,
    depths: Iterable[float] | None = None,
) -> Figure:
    """Draw the shear stress in the loading direction over the initial p'_N at four depths, on both sides of the skirt.

    Parameters as those of `pressure_rose`; path with shear_lateral (step, side, azimuth, depth) [Pa], the traction of
    the caisson on the soil, positive along +x.
    """
    return draw_signed_rose(path, SHEAR, step, displacement, depths)


PICTURE = Picture(
    name="pressure",
    caption="Excess pore pressure around the skirt",
    function=pressure_rose,
    data=lambda view: (view.path, view.step),
    scope="state",
    applies=lambda view: "pressure_min" in view.path and "pore_pressure" in view.path,
    section="",
)
