# SPDX-License-Identifier: MIT
"""The macro-model of a run in all programs, as `pysprings export` writes it, beside `predict`."""

import json
import resource
import sys
import time
import warnings
from pathlib import Path

from benchmarks.peers.timed import timed
from pysprings import predict
from pysprings.core.version import __version__
from pysprings.results.exporters import Source, export
from pysprings.results.exporters.uniaxial_sets import uniaxial
from pysprings.springs.springs import Springs

HEADS = ["program", "version", "u [mm]", "rotation [mrad]", "wall [s]", "peak [MB]", "what it lacks here"]
H, ARM, POINTS = 1.0e6, 5.0, 1001  # N, m
KRATOS = "not set up: its SpringDamperElement is linear"
OPENSEES = """
import importlib.util, json, sys
import openseespy.opensees as ops
spec = importlib.util.spec_from_file_location("caisson", sys.argv[1])
caisson = importlib.util.module_from_spec(spec)
spec.loader.exec_module(caisson)
ops.model("basic", "-ndm", 3, "-ndf", 6)
ops.node(1, 0.0, 0.0, 0.0)
caisson.attach(ops, 1)
ops.timeSeries("Linear", 1)
ops.pattern("Plain", 1, 1)
ops.load(1, float(sys.argv[2]), 0.0, 0.0, 0.0, float(sys.argv[2]) * float(sys.argv[3]), 0.0)
ops.constraints("Transformation"); ops.numberer("Plain"); ops.system("FullGeneral")
ops.test("NormDispIncr", 1e-12, 100); ops.algorithm("Newton")
ops.integrator("LoadControl", 0.1); ops.analysis("Static")
assert ops.analyze(10) == 0
print(json.dumps([ops.nodeDisp(1, 1), ops.nodeDisp(1, 5)]))
"""


def table(source: Source, there: dict[str, str | None], folder: Path) -> list[list[str]]:
    """Return the rows of the macro-model under H at ARM."""
    rows = list(_own(source))
    for name, run in (("OpenSees", _opensees), ("CalculiX", _calculix)):
        version = there[name]
        if version is None:
            rows.append([name, "missing", *[""] * 5])
        else:
            (u, rotation), seconds, memory = run(source, folder)
            lacks = "a spring that couples u and rotation" + ("; tables above 200 points" if name == "CalculiX" else "")
            rows.append(_row(name, version, u, rotation, seconds, memory, lacks))
    version = there["Kratos"]
    return [*rows, ["Kratos", version or "missing", *[""] * 4, KRATOS if version else ""]]


def _row(name: str, version: str, u: float, rotation: float, seconds: float, memory: float, lacks: str) -> list[str]:
    return [name, version, f"{1e3 * u:.5f}", f"{1e3 * rotation:.5f}", f"{seconds:.2g}", f"{memory:.0f}", lacks]


def _own(source: Source):
    """Yield the answers of the fan, and of its virtual springs, by `predict`."""
    springs = uniaxial(Springs.of(source.springs)).model
    for name, model in (("pysprings, fan", source.springs), ("pysprings, virtual springs", springs)):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            predict(model, H=H, arm=ARM)  # compiled loops are loaded
            start = time.perf_counter()
            answer = predict(model, H=H, arm=ARM)
        seconds, memory = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
        yield _row(name, __version__, float(answer["u"]), float(answer["rotation"]), seconds, memory, "hysteresis")


def _opensees(source: Source, folder: Path) -> tuple[list[float], float, float]:
    export(source, "opensees", folder, points=POINTS)
    script = ["caisson_opensees.py", str(H), str(ARM)]
    text, *cost = timed([sys.executable, "-c", OPENSEES, *script], folder)
    return json.loads(text.strip().splitlines()[0]), cost[0], cost[1]


def _calculix(source: Source, folder: Path) -> tuple[list[float], float, float]:
    export(source, "calculix", folder, points=POINTS)
    _, *cost = timed(["ccx", "example_calculix"], folder)
    lines = (folder / "example_calculix.dat").read_text().splitlines()[-2:]
    rows = [[float(x) for x in line.split()] for line in lines]
    return [rows[0][1], rows[1][2]], cost[0], cost[1]
