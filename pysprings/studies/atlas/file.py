# SPDX-License-Identifier: MIT
"""Atlas files: NetCDF with the inputs of the full models, the components and their processes."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pysprings.core.errors import refused
from pysprings.core.files.storage import read_tree, write_tree
from pysprings.core.units import quoted
from pysprings.core.version import __version__
from pysprings.scene.load import SceneText
from pysprings.studies.atlas.families import FAMILIES
from pysprings.studies.atlas.model import Atlas
from pysprings.studies.atlas.process import Process
from pysprings.studies.atlas.samples import ROWS

SUFFIX = ".nc"
SHIPPED = Path(__file__).parent / "shipped"

Array = NDArray[np.float64]
SCHEMA = "pysprings-atlas-2"


def write_atlas(atlas: Atlas, file: str | os.PathLike[str]) -> Path:
    """Write an atlas; return its path. Components have single precision."""
    processes = [*atlas.processes, *atlas.stiffness, atlas.settlement]
    data: dict[str, Any] = {
        "inputs": (("case", "input"), atlas.inputs), "points": (("case", "input"), processes[0].points),
        "angle": ("ray", atlas.angles), "X": ("X", atlas.X),
        "mean": (("ray", "row", "X"), atlas.mean.astype(np.float32)),
        "modes": (("component", "ray", "row", "X"), atlas.modes.astype(np.float32)),
        "rest": (("load", "ray", "X"), atlas.rest.astype(np.float32)),
        "values": (("process", "case"), np.stack([each.values for each in processes])),
        "lengths": (("process", "input"), np.stack([each.lengths for each in processes])),
    }  # fmt: skip
    for name in ("mean", "size", "variance", "noise"):
        data[f"process_{name}"] = ("process", np.array([getattr(each, name) for each in processes]))
    coords = {"ray": list(atlas.rays), "row": list(ROWS), "input": list(atlas.family.labels), "load": ["H", "M"]}
    attrs = {
        "schema": SCHEMA, "family": atlas.family.name, "scene_toml": atlas.text.text, "factor": atlas.factor,
        "reach_over_diameter": atlas.reach, "fan": list(atlas.fan), "about": json.dumps(dict(atlas.about)),
        "source": f"pysprings {__version__}",
    }  # fmt: skip
    return write_tree(xr.DataTree(xr.Dataset(data, coords, attrs)), file)


def read_atlas(file: Path) -> Atlas:
    """Read an atlas. Raises UserInputError for another or a broken file."""
    tree = read_tree(file)
    if tree.attrs.get("schema") != SCHEMA:
        raise refused(None, f"is no atlas ({SCHEMA}); `pysprings atlas` makes one of a study", file)
    data = tree.to_dataset()
    if tuple(data["row"].values) != ROWS:
        raise refused(None, "an atlas of another version: its rows differ", file)
    values = {str(name): np.asarray(each.values) for name, each in data.variables.items()}
    count = data.sizes["component"]
    processes = [
        Process(
            values["points"], values["values"][k], float(values["process_mean"][k]), float(values["process_size"][k]),
            float(values["process_variance"][k]), values["lengths"][k], float(values["process_noise"][k]),
        )
        for k in range(data.sizes["process"])
    ]  # fmt: skip
    attrs = data.attrs
    text = SceneText(str(attrs["scene_toml"]), f"base scene of {file.name}")
    return Atlas(
        family=FAMILIES.find(str(attrs["family"]), "family"), text=text, inputs=values["inputs"],
        rays=tuple(str(name) for name in data["ray"].values), angles=values["angle"], X=values["X"],
        reach=float(attrs["reach_over_diameter"]), rest=values["rest"].astype(float), factor=float(attrs["factor"]),
        fan=(float(attrs["fan"][0]), float(attrs["fan"][1])), about=json.loads(str(attrs["about"])),
        mean=values["mean"].astype(float), modes=values["modes"].astype(float), processes=tuple(processes[:count]),
        stiffness=tuple(processes[count:-1]), settlement=processes[-1],
    )  # fmt: skip


def shipped() -> list[str]:
    """Return the names of the atlases of this package."""
    return sorted(file.stem for file in SHIPPED.glob(f"*{SUFFIX}"))


def open_atlas(source: str | os.PathLike[str]) -> Atlas:
    """Open an atlas: a file, or the name of one that comes with the package ("clay").

    Raises UserInputError for another file, or a broken one.
    """
    names = shipped()
    if str(source) in names:
        return read_atlas(SHIPPED / f"{source}{SUFFIX}")
    if not Path(source).exists() and Path(source).suffix != SUFFIX:
        raise refused("--atlas", f"no atlas {quoted(str(source))}; there are: {', '.join(names) or 'none'}, or a file")
    return read_atlas(Path(source))
