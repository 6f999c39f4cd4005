# SPDX-License-Identifier: MIT
"""Picture of laboratory tests: stress and volume (or pore pressure) over strain, and the stress path, beside data."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pysprings.core.words import ElementTest
from pysprings.results.plots.style import BLUE, GREEN, KPA, ORANGE, PURPLE, VERMILLION, new_figure, plain, styled
from pysprings.studies.element.data import MEASURED, LabTest

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pysprings.model.element import Curve

# column -> its axis, and the factor to the unit there
_AXES = {
    "axial_strain": ("axial strain [%]", 100.0), "shear_strain": ("shear strain [%]", 100.0),
    "volumetric_strain": ("volumetric strain [%], compression positive", 100.0),
    "q_Pa": ("deviator stress q [kPa]", KPA), "p_Pa": ("mean effective stress p' [kPa]", KPA),
    "shear_stress_Pa": ("shear stress [kPa]", KPA), "axial_stress_Pa": ("axial effective stress [kPa]", KPA),
    "pore_pressure_Pa": ("excess pore pressure [kPa]", KPA),
}  # fmt: skip
_COLOURS = (BLUE, VERMILLION, GREEN, ORANGE, PURPLE)


@styled
def element_picture(
    curves: Sequence[Curve], names: Sequence[str], tests: Sequence[LabTest], kind: ElementTest, title: str
) -> Figure:
    """Draw curves (lines) beside the tests of the same place in the list (dots)."""
    strain, measured = MEASURED[kind]
    wet = any(curve.drainage == "undrained" for curve in curves)
    path = ("axial_stress_Pa", measured[0]) if kind == "dss" else ("p_Pa", "q_Pa")
    panels = ((strain, measured[0]), (strain, "pore_pressure_Pa" if wet else "volumetric_strain"), path)
    figure = new_figure(13.0, 4.6)
    for axes, (x, y) in zip(figure.subplots(1, 3), panels, strict=True):
        for k, (curve, name) in enumerate(zip(curves, names, strict=True)):
            columns, colour = curve.columns(), _COLOURS[k % len(_COLOURS)]
            axes.plot(_AXES[x][1] * columns[x], _AXES[y][1] * columns[y], color=colour, label=plain(name))
            if tests and {x, y} <= set(tests[k].columns):
                data = tests[k].columns
                every = slice(None, None, max(len(data[x]) // 60, 1))
                points = _AXES[x][1] * data[x][every], _AXES[y][1] * data[y][every]
                axes.plot(*points, linestyle="", marker="o", markersize=3.0, color=colour, alpha=0.6)
        axes.set_xlabel(_AXES[x][0])
        axes.set_ylabel(_AXES[y][0])
        axes.margins(x=0.02)
        if np.ptp(axes.get_ylim()) == 0.0:
            axes.set_ylim(-1.0, 1.0)
    figure.axes[0].legend(fontsize=8)
    figure.suptitle(plain(title + ("; dots: data" if tests else "")))
    return figure
