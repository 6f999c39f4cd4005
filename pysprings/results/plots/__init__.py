# SPDX-License-Identifier: MIT
"""Figures of a run: Dataset in, matplotlib Figure out (drawn by Agg, never through pyplot).

>>> from pysprings import plots                                            # doctest: +SKIP
>>> plots.py_curves(plots.path_data(springs, "pull")).savefig("py.png")    # doctest: +SKIP
"""

from pysprings.plots.comparison import macro_against_full
from pysprings.plots.data import convergence_data, path_data, section_data
from pysprings.plots.files import save, save_all
from pysprings.plots.gap import gap_map
from pysprings.plots.load import load_displacement
from pysprings.plots.newton import newton_record
from pysprings.plots.pressure_rose import pressure_rose, shear_rose
from pysprings.plots.reactions import py_curves
from pysprings.plots.rose import stress_rose
from pysprings.plots.section import mesh, section_displacement, section_pressure
from pysprings.plots.steel import ovalisation
from pysprings.plots.vertical import vertical_springs
from pysprings.springs import path_names

__all__ = [
    "convergence_data",
    "gap_map",
    "load_displacement",
    "macro_against_full",
    "mesh",
    "newton_record",
    "ovalisation",
    "path_data",
    "path_names",
    "pressure_rose",
    "py_curves",
    "save",
    "save_all",
    "section_data",
    "section_displacement",
    "section_pressure",
    "shear_rose",
    "stress_rose",
    "vertical_springs",
]
