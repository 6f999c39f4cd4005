# SPDX-License-Identifier: MIT
"""The paper's drained pull by bricks and by Fourier series: the limit of one beside that of the other.

Each limit is extrapolated from three meshes as in `pysprings accuracy`: bricks with 4, 8 and 12 cells around, series
with N = 5 on three sections. Curves are compared up to 2.5 mm. The same from finer meshes, for other caissons, to
20 mm and with water: `docs/evidence/accuracy.md`.
"""

from functools import cache

import numpy as np

from pysprings.full_model.accuracy import measures
from pysprings.full_model.accuracy.measures import LOAD, OTHER, Reference, cell_size, curves_of, samples
from pysprings.full_model.accuracy.presets import QUICK_SERIES, read_mesh
from pysprings.full_model.compute import compute
from pysprings.scene.sections import PAPER
from tests.support import tiny
from tests.verification.rows import Row

END = 2.5  # mm
SECTIONS = ("fourier-coarse@5", "fourier-coarse:1.4@5", "fourier-coarse:2@5")
_SOURCE = "bricks, extrapolated"
# The limit of bricks from meshes this coarse, with one cell across the tip, is 4 % (load) and 2 % (p-y) from the
# finest; sections refined together with the tip have limits that are nearer (docs/evidence/accuracy.md)
_LOAD, _ROTATION, _PY = 0.02, 0.025, 0.02


def limits() -> tuple[dict[str, Reference], dict[str, Reference]]:
    """Return the limits of bricks and of series, by quantity, on displacements that all meshes share."""
    path = {"name": "pull", "kind": "pull", "lateral_displacement": 1e-3 * END}
    scene = tiny.sand(domain=PAPER, paths=[path], output={"figures": False, "section": False})
    names = (*QUICK_SERIES, *SECTIONS)
    trees = {name: compute(read_mesh(name).scene(scene)).recorded() for name in names}
    each = samples({name: curves_of(tree) for name, tree in trees.items()})["pull"]
    size = {name: cell_size(tree.attrs["n_unknowns"], tree.attrs.get("harmonics")) for name, tree in trees.items()}
    bricks, series = (
        measures.reference_of([each[name] for name in family], [size[name] for name in family])
        for family in (QUICK_SERIES, SECTIONS)
    )
    return bricks, series


@cache
def rows() -> tuple[Row, ...]:
    """Load and rotation at 1 and 2.5 mm, and p(y) over the path."""
    bricks, series = limits()
    case, found = "the paper's drained pull, limits of both discretisations", []
    for u in (1.0, END):
        at = round(u / END * len(series[LOAD].values)) - 1
        for key, name, unit, scale, slack in (
            (LOAD, "H", "kN", 1e-3, _LOAD), (OTHER, "rotation", "mrad", 1e3, _ROTATION),
        ):  # fmt: skip
            ours, reference = (scale * float(each[key].values[at]) for each in (series, bricks))
            found.append(Row(case, f"{name} at {u:g} mm, series", unit, ours, reference, _SOURCE, slack))
    apart = measures.errors(*({key: each.values for key, each in limit.items()} for limit in (series, bricks)))
    assert np.isfinite(apart["py_rms"])
    found.append(
        Row.error(case, "p(y): root mean square difference over the largest p", 0.01 * apart["py_rms"], _SOURCE, _PY)
    )
    return tuple(found)
