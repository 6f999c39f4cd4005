# SPDX-License-Identifier: MIT
"""The caisson in weightless elastic soil that all programs compute: half a mesh of bricks, as arrays in one file.

elastic: every soil node on the caisson moves with it (bonded) in x; H/u is the stiffness. smooth, rough: the caisson
moves by `PUSH` in x, held in all else; penalty contact that opens, with Coulomb friction in the last. No initial
stress: pressure comes from the push alone. `python -m benchmarks.peers.problem CASE` computes one in pysprings.
"""

import json
import sys
import warnings
from pathlib import Path

import numpy as np

from pysprings import Scene
from pysprings.full_model.compute import run
from pysprings.model.build import build_model
from pysprings.model.contact import SURFACE

PENALTY, PUSH, STEPS = 1e9, 2e-3, 10  # N/m3, m
FRICTION = {"elastic": 0.0, "smooth": 0.0, "rough": 0.3}  # by case
YOUNG, POISSON = 200e6, 0.3
BONDED = {"normal_stiffness": 1e13, "shear_stiffness": 1e13, "friction_coefficient": 5.0}
SMALL = 1e-8  # m: a bonded caisson in elastic soil answers in proportion


def scene(case: str) -> Scene:
    """Return a case as a scene."""
    contact = case != "elastic"
    soil = {"yield_surface": "elastic", "young_modulus": YOUNG, "poisson_ratio": POISSON, "effective_unit_weight": 0.0}
    rough = {"normal_stiffness": PENALTY, "shear_stiffness": PENALTY, "friction_coefficient": FRICTION[case]}
    path = {"name": "push", "kind": "translation", "lateral_displacement": PUSH if contact else SMALL, "heave": "fixed"}
    return Scene(
        soil=soil | {"surcharge": 0.0 if contact else 1e6},
        interface=rough if contact else BONDED,
        domain={"radius": 24.0, "depth": 12.0, "side": "fixed"},
        mesh={"preset": "coarse", "discretisation": "hex8"},
        paths=(path,),
        solver={"first_step_fraction": 1.0 / STEPS, "max_step_fraction": 1.0 / STEPS} if contact else {},
        output={"figures": False, "interface_fields": False, "section": False},
    )


def write(case: str, file: Path) -> Path:
    """Write nodes, hexes, fixed dofs and nodal stations (node, normal into the soil, area) of the half model.

    Stations of the tip, one element wide, are left out: its nodes are those of the walls.
    """
    model = build_model(scene(case)).model
    stations = model.stations
    assert stations is not None
    nodal = stations.surface != SURFACE["tip"]
    faces = {name: model.mesh.face_sets[name] for name in ("outer", "inner", "lid")}
    np.savez(
        file, nodes=model.mesh.nodes, hexes=model.mesh.hexes, fixed=model.fixed, node=stations.nodes[nodal, 0],
        normal=stations.frame[nodal, 0], area=stations.area[nodal], young=YOUNG, poisson=POISSON, penalty=PENALTY,
        friction=np.where(model.contact[nodal, 2] > 0.0, FRICTION[case], 0.0), push=PUSH, steps=STEPS, **faces,
    )  # fmt: skip
    return file


def main() -> None:
    """Print H/u [N/m] and M/u [N], or H [N] and M [N m], of the whole caisson."""
    warnings.simplefilter("ignore")  # a penalty of 1e13 N/m3 is reduced, which costs 0.05 %
    path = run(scene(sys.argv[1]))["paths/push"]
    assert path.attrs["status"] == "complete"
    last = path.to_dataset().isel(step=-1)
    share = 1.0 / float(last["u"]) if sys.argv[1] == "elastic" else 1.0
    print(json.dumps({"H": share * float(last["H"]), "M": share * float(last["M"])}))


if __name__ == "__main__":
    main()
