# SPDX-License-Identifier: MIT
"""How much bounded domains stiffen a caisson: the table behind `pysprings check` (`python -m benchmarks.domain_table`).

Initial stiffness of elastic, homogeneous soil in domains of the grid below over that of unbounded soil, which is
extrapolated from domains of 80 and 160 diameters (what a domain adds falls as one over its size). One harmonic of a
Fourier series on a section whose elements are the same in all domains. Ten minutes.
"""

import itertools
import json
from pathlib import Path

import numpy as np

from fe_engine.clock import Clock
from fe_engine.state import State
from pysprings.full_model.work import newton_of
from pysprings.model.forecast import domain_effect
from pysprings.model.fourier import build_on_section
from pysprings.model.fourier_mesh import FRICTIONAL, PRESETS
from pysprings.scene.model import Scene
from pysprings.scene.sections import PAPER_SOIL

DIAMETER = 8.0  # m
SLENDERNESS = (0.1, 0.25, 0.5, 1.0, 2.0, 4.0)
POISSON = (0.3, 0.45, 0.49, 0.499)
ROOM = (0.1, 0.3, 0.8, 2.0, 5.0, 12.0, 40.0)  # diameters beside the skirt, and below the tip
_GROWTH = 1.7


def stiffness(slenderness: float, beside: float, below: float, poisson: float, side: str = "roller") -> np.ndarray:
    """Return K_H, K_V, K_M (3,) of an elastic caisson, N/m and N m; lengths over the diameter."""
    scene = Scene.model_validate({
        "caisson": {"outer_diameter": DIAMETER, "skirt_length": slenderness * DIAMETER},
        "domain": {"radius": (0.5 + beside) * DIAMETER, "depth": (slenderness + below) * DIAMETER, "side": side},
        "soil": PAPER_SOIL | {"yield_surface": "elastic", "poisson_ratio": poisson},
        "mesh": {"preset": "medium", "discretisation": "fourier", "harmonics": 1},
        "path": [{"name": "pull", "kind": "pull", "lateral_displacement": 1e-3}],
    })  # fmt: skip
    built = build_on_section(scene, PRESETS[FRICTIONAL]["medium"])
    newton = newton_of(scene, built, Clock())
    matrix = 2.0 * newton.border_stiffness(State(built.model))
    newton.close()
    return np.diag(matrix)


def main() -> None:
    """Compute the table and write it beside the code that reads it."""
    table = []
    for slenderness, poisson in itertools.product(SLENDERNESS, POISSON):
        near, far = (stiffness(slenderness, size, size, poisson) for size in (80.0, 160.0))
        unbounded = 2.0 * far - near
        for side, beside, below in itertools.product(domain_effect.SIDES, ROOM, ROOM):
            over = stiffness(slenderness, beside, below, poisson, side) / unbounded - 1.0
            table += [float(f"{100.0 * each:.3g}") for each in over]
        print(f"L/D {slenderness:g}, nu {poisson:g}: {len(table)} values", flush=True)
    axes = {"slenderness": SLENDERNESS, "poisson": POISSON, "room": ROOM}
    Path(domain_effect.TABLE).write_text(json.dumps({**axes, "percent": table}, separators=(",", ":")) + "\n")


if __name__ == "__main__":
    main()
