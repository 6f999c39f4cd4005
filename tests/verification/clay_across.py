# SPDX-License-Identifier: MIT
"""A push along x and then along y of a caisson bonded to clay that yields: series beside CalculiX (C3D20R, Mises).

Weightless clay of one strength, no rotation and no heave; 40 mm each, where the load along x has passed its bend.
`python -m tests.verification.clay_across FILE` writes the table of docs/evidence/peers.md.
"""

import sys
from pathlib import Path

import numpy as np

from pysprings import Scene
from tests.verification.across import legs, loads_of, whole, write

SHEAR, STRENGTH, POISSON, PUSH, STEPS = 6e6, 30e3, 0.45, 40e-3, 6  # Pa, m
AROUND = 8  # bricks of second order around the half ring
FACES = ("outer", "inner", "lid", "tip")
EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))  # C3D20R
CLAY = {
    "yield_surface": "von-mises", "shear_modulus": SHEAR, "poisson_ratio": POISSON, "effective_unit_weight": 0.0,
    "undrained_shear_strength": STRENGTH, "surcharge": 0.0,
}  # fmt: skip


def scene() -> Scene:
    """Return the push along x, without a mesh."""
    return Scene(
        soil=CLAY,
        interface={"adhesion_factor": 1.0, "opening": "bonded"},
        domain={"radius": 24.0, "depth": 12.0, "side": "fixed"},
        paths=({"name": "push", "kind": "translation", "lateral_displacement": PUSH, "heave": "fixed"},),
        output={"figures": False, "interface_fields": False, "section": False},
    )


def in_bricks(refinement: float, folder: Path, around: int | None = AROUND) -> dict[str, float]:
    """Return the loads of CalculiX [MN, MN m] with bricks of second order on the mesh `coarse` times a refinement."""
    mesh = {"preset": "coarse", "discretisation": "hex8", "refinement": refinement, "azimuth": around}
    of = scene().replace(mesh=mesh)
    data = whole(of, FACES)
    nodes, held, faces = data["nodes"], data["fixed"], np.vstack([data[name] for name in FACES])
    edges, back = np.unique(np.sort(data["hexes"][:, EDGES].reshape(-1, 2), axis=1), axis=0, return_inverse=True)
    places = np.vstack([nodes, _middles(*nodes[edges.T], 0.5 * of.caisson.outer_diameter)])
    elements = 1 + np.hstack([data["hexes"], len(nodes) + back.reshape(-1, 12)])
    sides = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    on_caisson = (edges[:, None] == np.unique(sides, axis=0)).all(axis=2).any(axis=1)
    own = np.concatenate([np.unique(faces), len(nodes) + np.flatnonzero(on_caisson)])
    fixed = np.vstack([held, held[edges].all(axis=1)])
    fixed[own] = False
    lines = [
        "*NODE, NSET=ALL", *(f"{k}, {x:.12g}, {y:.12g}, {z:.12g}" for k, (x, y, z) in enumerate(places, 1)),
        "*ELEMENT, TYPE=C3D20R, ELSET=SOIL",
        *(f"{k}, {', '.join(map(str, c[:15]))},\n{', '.join(map(str, c[15:]))}" for k, c in enumerate(elements, 1)),
        f"*MATERIAL, NAME=SOIL\n*ELASTIC\n{2.0 * SHEAR * (1.0 + POISSON)}, {POISSON}",
        f"*PLASTIC\n{3.0**0.5 * STRENGTH}, 0.\n*SOLID SECTION, ELSET=SOIL, MATERIAL=SOIL",
        "*BOUNDARY", *(f"{k + 1}, {d + 1}" for k, d in np.argwhere(fixed)),
        "*NSET, NSET=CAISSON", *(f"{k + 1}," for k in own), *legs(PUSH, STEPS),
    ]  # fmt: skip
    return loads_of(lines, dict(enumerate(places, 1)), folder)


def _middles(first: np.ndarray, second: np.ndarray, radius: float) -> np.ndarray:
    """Return the middles of edges, of those around the caisson and outside of it on their circle."""
    found = 0.5 * (first + second)
    far, other, middle = (np.hypot(*each[:, :2].T) for each in (first, second, found))
    around = (abs(far - other) < 1e-6) & (far > 0.95 * radius) & (middle > 0.5 * far)
    found[around, :2] *= (far[around] / middle[around])[:, None]
    return found


if __name__ == "__main__":
    write(scene(), in_bricks, 1.0, sys.argv[1])
