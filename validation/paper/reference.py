# SPDX-License-Identifier: MIT
"""Small results of the paper's caisson, kept in data/reference with their origin, and how far a run is from them.

``python -m validation.paper.reference DIR`` writes them from a folder of the study (`make reference`).
"""

from __future__ import annotations

import argparse
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from pysprings.core import variables
from pysprings.core.storage import read_tree, write_tree
from validation.paper.cases import CASES, STEPS_MM, Case
from validation.paper.measures import at

if TYPE_CHECKING:
    from validation.paper.runs import Run

MESH = "coarse"
KEPT = ("drained", "slow")  # cases
STATES_MM = tuple(u for u in STEPS_MM if u >= 0.2) + (20.0,)
FIELDS_MM = (2.5, 20.0)  # contact fields at these alone
BY_STEP = ("time", "w", "rotation", "H", "V", "H_outer", "H_inner", "H_lid", "H_tip", "F_in", "F_out", "F_pw", "p", "y")
FIELDS = ("normal_effective_stress", "shear_lateral", "shear_vertical", "pore_pressure", "gap")
COMMAND = f"make paper MESH={MESH}"
# Largest deviation that is taken for the same result, over the largest value of each variable: rounding, another
# linear solver and the Newton tolerance (1e-5) come to less; a change of the model to more.
TOLERANCE = 2e-3


def reduced(path: xr.Dataset) -> xr.Dataset:
    """Return what is kept of a path: curves at STATES_MM, contact fields at FIELDS_MM, by displacement u [m]."""
    table = variables.GROUPS["result_path"]
    data: dict[str, Any] = {}
    for names, states, dim in ((BY_STEP, STATES_MM, "u"), (FIELDS, FIELDS_MM, "u_field")):
        for name in names:
            if name not in path:
                continue
            dims = [d for d in path[name].dims if d != "step"]
            values = np.stack([at(path[[name, "u"]].transpose("step", ...), name, 1e-3 * u) for u in states])
            data[name] = ((dim, *dims), values.astype(np.float32), table[name].attributes())
    attrs = {"units": "m", "long_name": "lateral displacement of the lid centre"}
    coords: dict[str, Any] = {
        "u": ("u", 1e-3 * np.array(STATES_MM), attrs), "u_field": ("u_field", 1e-3 * np.array(FIELDS_MM), attrs),
        **{name: path[name] for name in ("depth", "azimuth", "side") if name in path},
    }  # fmt: skip
    small = xr.Dataset(data, coords=coords)
    small["depth"].attrs.pop("bounds", None)  # they are not kept
    return small


def write(run: Run, folder: Path, origin: Mapping[str, str]) -> Path:
    """Write the reference file of a run; origin: attributes such as the command and the date of the commit."""
    small = reduced(run.path)
    attrs = {key: run.result.attrs[key] for key in ("pysprings_version", "scene_sha256", "mesh_preset", "solver",
                                                    "n_nodes", "n_elements", "scene_toml")}  # fmt: skip
    small.attrs = {"title": run.case.words, "case": run.case.name, "tolerance": TOLERANCE, **attrs, **origin}
    return write_tree(xr.DataTree(small), file_of(run.case, folder))


def file_of(case: Case, folder: Path) -> Path:
    """Return where the reference of a case is."""
    return folder / f"paper-{case.name}-{MESH}.nc"


def read(case: Case, folder: Path) -> xr.Dataset:
    """Read the reference of a case."""
    return read_tree(file_of(case, folder)).to_dataset()


def reference_cases() -> list[Case]:
    """Return the cases that have a reference."""
    return [case for case in CASES if case.name in KEPT]


def deviations(path: xr.Dataset, reference: xr.Dataset) -> dict[str, float]:
    """Return the largest deviation of a path from a reference, by variable, over the largest value of the variable."""
    data = reduced(path)
    out = {}
    for name in reference.data_vars:
        largest = float(np.abs(reference[name].values).max())
        apart = float(np.abs(data[name].values - reference[name].values).max())
        out[str(name)] = apart / largest if largest else apart
    return out


def _commit_date() -> str:
    """Return the date of the commit that the results come from; "unknown" outside a repository."""
    command = ["git", "log", "-1", "--format=%cI"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.stdout.strip() or "unknown"


def main() -> None:
    """Read the options, write data/reference from the folder of a study."""
    from validation.paper.runs import load_runs

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help=f"folder of `{COMMAND}`")
    parser.add_argument("--to", type=Path, default=Path("data/reference"), help="where the references are")
    given = parser.parse_args()
    ended = load_runs(given.folder, MESH, reference_cases())
    origin = {"command": f"{COMMAND}; python -m validation.paper.reference", "commit_date": _commit_date()}
    for case in reference_cases():
        if case.name not in ended or not ended[case.name].complete:
            raise SystemExit(f"{given.folder}: the run {case.name} is not there, or not complete")
        print(write(ended[case.name], given.to, origin))


if __name__ == "__main__":
    main()
