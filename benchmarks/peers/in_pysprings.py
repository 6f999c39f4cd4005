# SPDX-License-Identifier: MIT
"""The caisson in pysprings: `python -m benchmarks.peers.in_pysprings elastic|smooth|rough`."""

import json
import sys
import warnings

from benchmarks.peers.problem import scene
from pysprings.full_model.compute import run


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
