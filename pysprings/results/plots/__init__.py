# SPDX-License-Identifier: MIT
"""Pictures of results and springs: figures of matplotlib, drawn by Agg, never through pyplot.

`draw` takes a result or springs and the name of a picture; `PICTURES` lists them. The function of each picture takes
the data of its path. Those on given axes are `draw_paths`, `draw_py`, `draw_profile`, `draw_secant` and `draw_tilt`.

>>> from pysprings import plots                                           # doctest: +SKIP
>>> plots.draw(springs, "py", "pull", depths=[1, 2]).savefig("py.png")    # doctest: +SKIP
"""

from pysprings.results.parts import convergence_data, path_data, path_names, section_data
from pysprings.results.plots.comparison import macro_against_full, memory_loops, overlay
from pysprings.results.plots.draw import PICTURES, draw
from pysprings.results.plots.files import save, save_all
from pysprings.results.plots.gap import gap_map, ovalisation
from pysprings.results.plots.ground import ground_profile
from pysprings.results.plots.load import load_displacement, newton_record, vertical_springs
from pysprings.results.plots.overview import (
    draw_paths,
    draw_secant,
    draw_tilt,
    lateral_paths,
    overview,
    secant_stiffness,
    tilt,
)
from pysprings.results.plots.picture import Picture, View
from pysprings.results.plots.profiles import draw_profile, draw_py, profiles, py_curves
from pysprings.results.plots.rose import pressure_rose, shear_rose, stress_rose
from pysprings.results.plots.section import mesh, section_displacement, section_pressure

__all__ = [
    "PICTURES", "Picture", "View", "convergence_data", "draw", "draw_paths", "draw_profile", "draw_py", "draw_secant",
    "draw_tilt", "gap_map", "ground_profile", "lateral_paths", "load_displacement", "macro_against_full",
    "memory_loops", "mesh", "newton_record", "ovalisation", "overlay", "overview", "path_data", "path_names",
    "pressure_rose", "profiles", "py_curves", "save", "save_all", "secant_stiffness", "section_data",
    "section_displacement", "section_pressure", "shear_rose", "stress_rose", "tilt", "vertical_springs",
]  # fmt: skip
