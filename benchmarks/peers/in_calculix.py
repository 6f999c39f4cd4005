# SPDX-License-Identifier: MIT
"""The caisson in CalculiX, C3D8 and face-to-face penalty contact: `python in_calculix.py elastic|smooth|rough FILE`."""

import json
import subprocess
import sys
from collections.abc import Iterator
from itertools import count
from pathlib import Path

import numpy as np

FACES = ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0))  # S1 to S6
BACK = 0.05  # m: thickness of the bricks behind the faces of the caisson


def soil(data) -> Iterator[str]:
    """Yield nodes, bricks, material and fixed dofs."""
    yield "*NODE, NSET=SOILNODES"
    yield from (f"{k}, {x:.12g}, {y:.12g}, {z:.12g}" for k, (x, y, z) in enumerate(data["nodes"], 1))
    yield "*ELEMENT, TYPE=C3D8, ELSET=SOIL"
    yield from (f"{k}, {', '.join(str(c + 1) for c in corners)}" for k, corners in enumerate(data["hexes"], 1))
    yield f"*MATERIAL, NAME=SOIL\n*ELASTIC\n{float(data['young'])}, {float(data['poisson'])}"
    yield "*SOLID SECTION, ELSET=SOIL, MATERIAL=SOIL"
    rows = [f"{k + 1}, {d + 1}" for k, d in zip(*np.nonzero(data["fixed"]), strict=True)]
    yield "*BOUNDARY\n" + "\n".join(rows)


def walls(data, own: dict[int, np.ndarray]) -> Iterator[str]:
    """Yield rigid bricks behind the contact faces, whose nodes go to `own`, and a contact pair for each surface."""
    node, element = count(len(data["nodes"]) + 1), count(len(data["hexes"]) + 1)
    faces_of = {}
    for number, corners in enumerate(data["hexes"], 1):
        for side, local in enumerate(FACES, 1):
            faces_of[frozenset(int(corners[i]) for i in local)] = number, side
    for name in ("outer", "inner", "lid"):
        direction = {int(k): normal_of(data["nodes"][k], name) for k in data[name].ravel()}
        near, far = {k: next(node) for k in direction}, {k: next(node) for k in direction}
        yield "*NODE, NSET=CAISSON"
        for k, n in direction.items():
            for tag, x in ((near[k], data["nodes"][k]), (far[k], data["nodes"][k] - BACK * n)):
                own[tag] = x
                yield f"{tag}, {x[0]:.12g}, {x[1]:.12g}, {x[2]:.12g}"
        slaves, masters, bricks = [], [], []
        for face in data[name]:
            number, side = faces_of[frozenset(map(int, face))]
            slaves.append(f"{number}, S{side}")
            corners = [int(k) for k in face]
            a, b, c = (data["nodes"][corners[i]] for i in (0, 1, 3))
            turned = np.cross(b - a, c - a) @ direction[corners[0]] < 0.0
            corners = corners[::-1] if turned else corners
            tag = next(element)
            bricks.append(f"{tag}, {', '.join(str(t[k]) for t in (far, near) for k in corners)}")
            masters.append(f"{tag}, S2")
        yield f"*ELEMENT, TYPE=C3D8, ELSET=BODY{name}\n" + "\n".join(bricks)
        yield f"*SOLID SECTION, ELSET=BODY{name}, MATERIAL=SOIL"
        yield f"*SURFACE, NAME=SLAVE{name}\n" + "\n".join(slaves)
        yield f"*SURFACE, NAME=MASTER{name}\n" + "\n".join(masters)
        yield f"*SURFACE INTERACTION, NAME=LAW{name}\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR"
        yield f"{float(data['penalty'])}, 1., 0."
        if float(data["friction"].max()) > 0.0:
            yield f"*FRICTION\n{float(data['friction'].max())}, {float(data['penalty'])}"
        yield f"*CONTACT PAIR, INTERACTION=LAW{name}, TYPE=SURFACE TO SURFACE\nSLAVE{name}, MASTER{name}"


def normal_of(x: np.ndarray, name: str) -> np.ndarray:
    """Return the unit normal from a wall, or up from the lid."""
    if name == "lid":
        return np.array([0.0, 0.0, 1.0])
    out = np.array([x[0], x[1], 0.0]) / np.hypot(x[0], x[1])
    return out if name == "outer" else -out


def step(data, contact: bool) -> Iterator[str]:
    """Yield the motion of the caisson and the output of its reactions."""
    if not contact:
        yield "*NSET, NSET=CAISSON\n" + ",\n".join(str(k + 1) for k in np.unique(data["node"]))
    yield f"*STEP, INC=1000\n*STATIC\n{1.0 / float(data['steps'])}, 1." if contact else "*STEP\n*STATIC"
    yield f"*BOUNDARY\nCAISSON, 1, 1, {float(data['push']) if contact else 1.0}\nCAISSON, 2, 3"
    yield "*NODE PRINT, NSET=CAISSON, FREQUENCY=1000\nRF\n*END STEP"


def main() -> None:
    """Print H and M of the whole caisson, at 1 m of an elastic one."""
    data = np.load(sys.argv[2])
    contact = sys.argv[1] != "elastic"
    own: dict[int, np.ndarray] = {}
    lines = [*soil(data), *(walls(data, own) if contact else ()), *step(data, contact)]
    Path("caisson.inp").write_text("\n".join(lines) + "\n")
    done = subprocess.run(["ccx", "caisson"], capture_output=True, text=True, check=False)
    assert "Job finished" in done.stdout, done.stdout[-1500:]
    text = Path("caisson.dat").read_text().split("forces (fx,fy,fz)")[-1].splitlines()[1:]
    rows = np.array([[float(x) for x in line.split()] for line in text if len(line.split()) == 4])
    places = dict(enumerate(data["nodes"], 1)) | own
    x = np.array([places[int(k)] for k in rows[:, 0]])
    moment = rows[:, 1] @ x[:, 2] - rows[:, 3] @ x[:, 0]
    print(json.dumps({"H": 2.0 * rows[:, 1].sum(), "M": -2.0 * moment}))


if __name__ == "__main__":
    main()
