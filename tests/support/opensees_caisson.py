# SPDX-License-Identifier: MIT
"""The exported caisson in OpenSees, as a program of its own: script, loads (H, M, V) and their angle in JSON in.

Motions along the load, and across it, and the number of nodes come out.

z upwards: M at the angle 0 is a moment about +y, as the rotation.
"""

import importlib.util
import json
import math
import sys
from functools import partial

NOT_THERE = 77


def beam(ops, depths: list[float]) -> dict[float, int]:
    """Return nodes of a rigid skirt by depth."""
    for tag, depth in enumerate(depths, 2):
        ops.node(tag, 0.0, 0.0, -depth)
        ops.rigidLink("beam", 1, tag)
    return dict(zip(depths, range(2, 2 + len(depths)), strict=True))


def attach(ops, script: str, skirt: dict[float, int]) -> None:
    """Hang the caisson of a script on node 1: Python, or Tcl whose commands are those of OpenSees."""
    if script.endswith(".py"):
        spec = importlib.util.spec_from_file_location("caisson", script)
        caisson = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(caisson)
        caisson.attach(ops, 1, skirt=skirt)
        return
    import tkinter

    tcl = tkinter.Tcl()
    for name in ("node", "fix", "geomTransf", "uniaxialMaterial", "element", "nodeCoord"):
        tcl.createcommand(name, partial(called, getattr(ops, name)))
    tcl.call("source", script)
    tcl.call("attach_caisson", 1, 900001, " ".join(f"{depth} {tag}" for depth, tag in skirt.items()))


def called(run, *words: str):
    """Call a command of OpenSees with the words of Tcl."""
    return run(*map(value, words))


def value(word: str) -> int | float | str:
    """Return a word of Tcl as openseespy takes it."""
    for kind in (int, float):
        try:
            return kind(word)
        except ValueError:
            pass
    return str(word)


def main() -> int:
    try:
        import openseespy.opensees as ops
    except Exception as error:  # its loader raises what it likes where it has no binary
        print(error, file=sys.stderr)
        return NOT_THERE
    task = json.load(sys.stdin)
    if task["script"].endswith(".tcl") and importlib.util.find_spec("_tkinter") is None:
        print("this Python has no Tcl", file=sys.stderr)
        return NOT_THERE
    out = []
    c, s = math.cos(task["angle"]), math.sin(task["angle"])
    for H, M, V in task["loads"]:
        ops.wipe()
        ops.model("basic", "-ndm", 3, "-ndf", 6)
        ops.node(1, 0.0, 0.0, 0.0)
        attach(ops, task["script"], beam(ops, task["skirt"]))
        ops.timeSeries("Linear", 1)
        ops.pattern("Plain", 1, 1)
        ops.load(1, c * H, s * H, -V, -s * M, c * M, 0.0)
        if held := task["held"]:  # freedoms of the lid that a user fixes, as in a tower in a plane
            ops.fix(1, *held)
        ops.constraints(*task["constraints"])
        ops.numberer("Plain")
        ops.system(task["system"])
        ops.test(*task["test"], 100)
        ops.algorithm("Newton")
        ops.integrator("LoadControl", 1.0 / task["steps"])
        ops.analysis("Static")
        status = ops.analyze(task["steps"])
        x, y, z, about_x, about_y, _ = ops.nodeDisp(1)
        across = max(abs(c * y - s * x), abs(c * about_x + s * about_y))
        out.append([status, c * x + s * y, c * about_y - s * about_x, -z, across, len(ops.getNodeTags())])
    print(json.dumps(out), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
