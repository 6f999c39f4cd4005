# SPDX-License-Identifier: MIT
"""Rigid body on springs in OpenSees, as a program of its own: JSON in, JSON out (test_opensees.py runs it).

Lateral x, upwards y: its rotation then has the sign of ours. A lateral spring sits where its displacement is read; a
moment acts on the rigid body wherever it sits.
"""

import json
import sys

NOT_THERE = 77


def main() -> int:
    try:
        import openseespy.opensees as ops
    except Exception as error:  # its loader raises what it likes where it has no binary
        print(error, file=sys.stderr)
        return NOT_THERE
    task = json.load(sys.stdin)
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    ops.node(1, 0.0, 0.0)
    # held by a spring, not fixed: loads on a fixed node that links retain add up from step to step
    ops.node(2, 0.0, 0.0)
    ops.fix(2, 1, 1, 1)
    ops.uniaxialMaterial("Elastic", 9999, 1e9)
    ops.element("zeroLength", 9999, 2, 1, "-mat", 9999, "-dir", 2)
    for j, spring in enumerate(task["springs"]):
        ground, on = 1000 + j, 100 + j
        ops.node(ground, 0.0, -spring["depth"])
        ops.fix(ground, 1, 1, 1)
        ops.node(on, 0.0, -spring["depth"])
        ops.rigidLink("beam", 1, on)
        curve = "-strain", *spring["q"], "-stress", *spring["r"]
        ops.uniaxialMaterial("ElasticMultiLinear", j + 1, *curve)
        ops.element("zeroLength", j + 1, ground, on, "-mat", j + 1, "-dir", spring["direction"])
    ops.timeSeries("Linear", 1)
    ops.pattern("Plain", 1, 1)
    ops.load(1, task["H"], 0.0, task["M"])
    ops.constraints("Transformation")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    ops.test("NormDispIncr", 1e-13, 50)
    ops.algorithm("Newton")
    ops.integrator("LoadControl", 1.0 / task["steps"])
    ops.analysis("Static")
    status = ops.analyze(task["steps"])
    print(json.dumps({"status": status, "u": ops.nodeDisp(1, 1), "rotation": ops.nodeDisp(1, 3)}), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
