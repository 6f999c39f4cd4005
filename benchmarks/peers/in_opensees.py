# SPDX-License-Identifier: MIT
"""The caisson in OpenSees: `python in_opensees.py elastic|smooth|rough FILE`; bbarBrick, zeroLengthContactASDimplex."""

import json
import sys

import numpy as np
import openseespy.opensees as ops


def soil(data) -> None:
    """Build bricks of elastic soil with fixed dofs; tags are 1-based."""
    ops.model("basic", "-ndm", 3, "-ndf", 3)
    for k, x in enumerate(data["nodes"], 1):
        ops.node(k, *map(float, x))
    ops.nDMaterial("ElasticIsotropic", 1, float(data["young"]), float(data["poisson"]))
    for k, corners in enumerate(data["hexes"], 1):
        ops.element("bbarBrick", k, *(int(c) + 1 for c in corners), 1)
    for k in np.flatnonzero(data["fixed"].any(axis=1)):
        ops.fix(int(k) + 1, *(int(x) for x in data["fixed"][k]))


def moved(data, size: float) -> list[int]:
    """Hold the nodes of the caisson and move them in x; return their tags."""
    ops.timeSeries("Linear", 1)
    ops.pattern("Plain", 1, 1)
    tags, first = [], len(data["nodes"]) + 1
    if size == 1.0:
        tags = [int(k) + 1 for k in np.unique(data["node"])]
    else:
        for j, (k, normal) in enumerate(zip(data["node"], data["normal"], strict=True)):
            tag, area = first + j, float(data["area"][j])
            ops.node(tag, *map(float, data["nodes"][k]))
            stiffness = float(data["penalty"]) * area
            law = [stiffness, stiffness, float(data["friction"][j])]
            # gap: motion of the second node less that of the first, along the axis
            element = len(data["hexes"]) + 1 + j
            ops.element("zeroLengthContactASDimplex", element, tag, int(k) + 1, *law, "-orient", *map(float, normal))
            tags.append(tag)
    for tag in tags:
        for dof in (1, 2, 3):
            held = tag <= len(data["nodes"]) and data["fixed"][tag - 1, dof - 1]
            if not held:
                ops.sp(tag, dof, size if dof == 1 else 0.0)
    return tags


def main() -> None:
    """Print H and M of the whole caisson, at 1 m of an elastic one."""
    data = np.load(sys.argv[2])
    contact = sys.argv[1] != "elastic"
    soil(data)
    tags = moved(data, float(data["push"]) if contact else 1.0)
    ops.constraints("Transformation")
    ops.numberer("RCM")
    ops.system("UmfPack")
    ops.test("NormDispIncr", 1e-8, 200)
    ops.algorithm("Newton")
    steps = int(data["steps"]) if contact else 1
    ops.integrator("LoadControl", 1.0 / steps)
    ops.analysis("Static")
    assert ops.analyze(steps) == 0
    ops.reactions()
    force = np.array([ops.nodeReaction(tag) for tag in tags])
    x, depth = (np.array([ops.nodeCoord(tag, axis) for tag in tags]) for axis in (1, 3))
    print(json.dumps({"H": 2.0 * force[:, 0].sum(), "M": 2.0 * (force[:, 2] @ x - force[:, 0] @ depth)}))


if __name__ == "__main__":
    main()
