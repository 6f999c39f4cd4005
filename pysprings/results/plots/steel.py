# SPDX-License-Identifier: MIT
"""How an elastic skirt has bent: change of its diameters by depth, and its mean fibre beside the rigid motion."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pysprings.results.analysis.parts import pick_step
from pysprings.results.plots.data import step_text
from pysprings.results.plots.picture import Picture
from pysprings.results.plots.style import BLUE, INK, MM, VERMILLION, new_figure, set_title, styled, zero_lines

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


@styled
def ovalisation(path: xr.Dataset, step: int | None = None, displacement: float | None = None) -> Figure:
    """Draw the change of the skirt's diameters [mm] and the displacement of its mean fibre [mm] by depth.

    Parameters
    ----------
    path
        One path of an elastic caisson: diameter_change_x, diameter_change_y and y (depth, step) [m], u, rotation.
    step, displacement
        A step, or the lateral displacement [m] it should be nearest to; default the last converged step.
    """
    step = pick_step(path, step, displacement)
    state = path.isel(step=step)
    depth = path["depth"].values
    figure = new_figure(8.6, 4.6)
    left, right = figure.subplots(1, 2, sharey=True)
    left.plot(state["diameter_change_x"] * MM, depth, "-o", color=VERMILLION, label="in the loading direction, x")
    left.plot(state["diameter_change_y"] * MM, depth, "--s", color=BLUE, label="across it, y")
    left.set_xlabel("change of diameter [mm], growth +")
    left.set_title("Ovalisation of the skirt")
    rigid = float(state["u"]) - float(state["rotation"]) * depth
    right.plot(state["y"] * MM, depth, "-o", color=INK, label="mean fibre of the skirt")
    right.plot(rigid * MM, depth, ":", color=INK, label="rigid motion of the lid's centre")
    right.set_xlabel("lateral displacement [mm], towards +x")
    right.set_title("Where the sections are")
    left.set_ylabel("depth below mudline [m]")
    # room for the keys above mudline
    left.set_ylim(1.04 * depth[-1], -0.25 * depth[-1])
    left.set_yticks([tick for tick in left.get_yticks() if 0.0 <= tick <= depth[-1]])
    for axes in (left, right):
        zero_lines(axes)
        axes.margins(x=0.1)
        axes.legend(loc="upper center", frameon=False)
    set_title(figure, f"Elastic caisson at {step_text(path, step)}", path.attrs)
    return figure


PICTURE = Picture(
    name="ovalisation",
    caption="Ovalisation of the skirt, and its mean fibre by depth",
    function=ovalisation,
    data=lambda view: (view.path, view.step),
    scope="state",
    applies=lambda view: "diameter_change_x" in view.path,
    section="",
)
