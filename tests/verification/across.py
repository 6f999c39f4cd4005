# SPDX-License-Identifier: MIT
"""A push along x and then along y: the series of all directions beside CalculiX with bricks around the whole ring.

The problem is that of `benchmarks.peers.problem` with friction: elastic soil without initial stress, contact that
opens, no rotation and no heave. `python -m tests.verification.across FILE` writes the table of docs/evidence/peers.md.
"""

import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.peers import in_calculix, problem
from pysprings import Scene
from pysprings.full_model.compute import run
from pysprings.model.build import build_model
from pysprings.springs.path import space_paths_of

ALONG, LOADS = "H after the push along x [MN]", ("H_x", "H_y", "M_x", "M_y", "T")
BRICKS, HARMONICS, ORDER = (0.6, 1.0), (3, 5, 8), 2.0


def whole(of: Scene, names: Sequence[str] = ("outer", "inner", "lid")) -> dict[str, Any]:
    """Return the half model of bricks of a scene and its mirror image beyond y = 0 as one, as `in_calculix` takes it.

    names : Faces of the caisson.
    """
    model = build_model(of).model
    nodes, held = model.mesh.nodes, model.fixed.astype(bool)
    held[~held[:, 0], 1] = False  # on the plane: it is one of symmetry no more
    aside = np.flatnonzero(np.abs(nodes[:, 1]) > 1e-9)
    twin = np.arange(len(nodes))
    twin[aside] = len(nodes) + np.arange(len(aside))
    faces = {name: model.mesh.face_sets[name] for name in names}
    return {
        "nodes": np.vstack([nodes, nodes[aside] * [1.0, -1.0, 1.0]]), "fixed": np.vstack([held, held[aside]]),
        "hexes": np.vstack([model.mesh.hexes, twin[model.mesh.hexes][:, [3, 2, 1, 0, 7, 6, 5, 4]]]),
        "young": problem.YOUNG, "poisson": problem.POISSON, "penalty": problem.PENALTY,
        "friction": np.array(problem.FRICTION["rough"]),
    } | {name: np.vstack([each, twin[each]]) for name, each in faces.items()}  # fmt: skip


def in_bricks(refinement: float, folder: Path) -> dict[str, float]:
    """Return the loads of CalculiX [MN, MN m] on the brick mesh `coarse` times a refinement."""
    of = problem.scene("rough").replace(mesh={"refinement": refinement})
    data, own = whole(of), dict[int, np.ndarray]()
    lines = [*in_calculix.soil(data), *in_calculix.walls(data, own), *legs(problem.PUSH, problem.STEPS)]
    return loads_of(lines, dict(enumerate(data["nodes"], 1)) | own, folder)


def loads_of(lines: Sequence[str], places: dict[int, np.ndarray], folder: Path) -> dict[str, float]:
    """Return the loads after the first and the second leg of a model in CalculiX, whose nodes are at places [m]."""
    (folder / "across.inp").write_text("\n".join(lines) + "\n")
    done = subprocess.run(["ccx", "across"], cwd=folder, capture_output=True, text=True, check=False)
    assert "Job finished" in done.stdout, done.stdout[-1500:]
    first, last = (
        np.array([row.split() for row in part.splitlines() if len(row.split()) == 4], dtype=float)
        for part in (folder / "across.dat").read_text().split("forces (fx,fy,fz)")[1:]
    )
    x, y, z = np.array([places[int(k)] for k in last[:, 0]]).T  # z down
    f_x, f_y, f_z = 1e-6 * last[:, 1:].T
    sums = (f_x.sum(), f_y.sum(), f_y @ z - f_z @ y, f_z @ x - f_x @ z, x @ f_y - y @ f_x)
    return {ALONG: 1e-6 * first[:, 1].sum()} | dict(zip(LOADS, map(float, sums), strict=True))


def legs(push: float, steps: int) -> Iterator[str]:
    """Yield the motion of the nodes CAISSON [m] along x and then along y, each in a number of steps."""
    for y in (0.0, push):
        yield f"*STEP, INC=1000\n*STATIC\n{1.0 / steps}, 1., 1e-6, {1.0 / steps}"
        yield f"*BOUNDARY\nCAISSON, 1, 1, {push}\nCAISSON, 2, 2, {y}\nCAISSON, 3, 3"
        yield "*NODE PRINT, NSET=CAISSON, FREQUENCY=1000\nRF\n*END STEP"


def in_series(of: Scene, harmonics: int, preset: str = "medium") -> dict[str, float]:
    """Return the loads of a series [MN, MN m]: the path of a scene, and the same along y after it."""
    path = of.paths[0].model_dump()
    along = f"{1e3 * path['lateral_displacement']} mm towards 90 deg"
    mesh = {"preset": preset, "discretisation": "fourier", "harmonics": harmonics}
    both = of.replace(mesh=mesh, paths=(path | {"then": (along,), "role": "held-back"},))
    path = space_paths_of(run(both, estimate_error=False))["push"].dataset
    turn = int(np.flatnonzero(path["u_y"].values == 0.0)[-1])
    return {ALONG: 1e-6 * float(path["H_x"][turn])} | {name: 1e-6 * float(path[name][-1]) for name in LOADS}


def write(of: Scene, bricks: Callable[[float, Path], dict[str, float]], order: float, file: str) -> None:
    """Write the table: bricks on two meshes, what they tend to by an order, series."""
    rows = {}
    for each in BRICKS:
        with tempfile.TemporaryDirectory() as folder:
            rows[f"CalculiX, bricks `coarse` x {each:g}"] = bricks(each, Path(folder))
    coarse, fine = (pd.Series(each) for each in rows.values())
    share = 1.0 / ((BRICKS[1] / BRICKS[0]) ** order - 1.0)
    rows[f"CalculiX, both extrapolated by order {order:g}"] = dict(fine + share * (fine - coarse))
    rows |= {f"series, N {each}": in_series(of, each) for each in HARMONICS}
    heads = {name: f"{name} [MN{' m' * (name[0] in 'MT')}]" for name in LOADS}
    table = pd.DataFrame(rows).T.rename(columns=heads)
    table.round(3).rename_axis("program, mesh").to_csv(file)


if __name__ == "__main__":
    write(problem.scene("rough"), in_bricks, ORDER, sys.argv[1])
