# SPDX-License-Identifier: MIT
"""Figures of a run: Dataset in, matplotlib Figure out (drawn by Agg, never through pyplot).

>>> from pysprings import plots                                            # doctest: +SKIP
>>> plots.py_curves(plots.path_data(springs, "pull")).savefig("py.png")    # doctest: +SKIP
"""

from pysprings.results.analysis.parts import convergence_data, path_data, section_data
from pysprings.results.plots.comparison import macro_against_full
from pysprings.results.plots.files import save, save_all
from pysprings.results.plots.gap import gap_map
from pysprings.results.plots.load import load_displacement
from pysprings.results.plots.newton import newton_record
from pysprings.results.plots.overview import overview
from pysprings.results.plots.picture import Picture, View
from pysprings.results.plots.pictures import PICTURES
from pysprings.results.plots.pressure_rose import pressure_rose, shear_rose
from pysprings.results.plots.profiles import profiles
from pysprings.results.plots.reactions import py_curves
from pysprings.results.plots.rose import stress_rose
from pysprings.results.plots.secant import secant_stiffness
from pysprings.results.plots.section import mesh, section_displacement, section_pressure
from pysprings.results.plots.steel import ovalisation
from pysprings.results.plots.tilt import tilt
from pysprings.results.plots.vertical import vertical_springs
from pysprings.springs.dataset import path_names

__all__ = [
    "PICTURES",
    "Picture",
    "View",
    "convergence_data",
    "gap_map",
    "load_displacement",
    "macro_against_full",
    "mesh",
    "newton_record",
    "ovalisation",
    "overview",
    "path_data",
    "path_names",
    "pressure_rose",
    "profiles",
    "py_curves",
    "save",
    "save_all",
    "secant_stiffness",
    "section_data",
    "section_displacement",
    "section_pressure",
    "shear_rose",
    "stress_rose",
    "tilt",
    "vertical_springs",
]
