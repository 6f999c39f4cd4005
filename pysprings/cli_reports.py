# SPDX-License-Identifier: MIT
"""What the commands print: descriptions of scenes, results of runs, predictions."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pysprings.cli_support import RESULT_FILES, number, print_table, springs_of

if TYPE_CHECKING:
    import xarray as xr

    from pysprings.scene import Scene

PICTURES = (".png", ".svg", ".pdf")

# columns of a prediction: name, unit for people, factor from SI
COLUMNS = (
    ("u", "mm", 1e3),
    ("w", "mm", 1e3),
    ("rotation", "deg", 180.0 / math.pi),
    ("H", "kN", 1e-3),
    ("V", "kN", 1e-3),
    ("M", "kN m", 1e-3),
)


def describe_json(file: Path, scene: Scene, about: Mapping[str, Any]) -> dict[str, Any]:
    """Return what `pysprings check --json` prints."""
    left_out = [{"what": what, "why": why} for what, why in about.get("left_out", ())]
    paths = [{"name": path.name, "kind": path.kind, "role": path.role} for path in scene.paths]
    head = {"scene": str(file), "title": scene.title, "scene_sha256": scene.sha256, "paths": paths}
    return {**head, **about, "left_out": left_out}


def print_description(file: Path, scene: Scene, about: Mapping[str, Any]) -> None:
    """Print what `pysprings check` found."""
    print(f"{file}: {scene.title}")
    print(f"sha256 {scene.sha256}")
    paths = ", ".join(f"{path.name} ({path.kind}, {path.role})" for path in scene.paths)
    print(f"mesh {scene.mesh.preset}; paths: {paths}\n")
    rows = [row for key, value in about.items() if key != "left_out" for row in _rows(key, value)]
    print_table(("quantity", "value"), rows)
    print("\nleft out by this scene:")
    for what, why in about.get("left_out", ()):
        print(f"- {what}: {why}")


def _rows(key: str, value: Any) -> list[tuple[str, str]]:
    """Return the lines of one entry of a description; a table of counts has one line each."""
    if isinstance(value, Mapping):
        return [(str(name).replace("_", " "), number(count)) for name, count in value.items()]
    units = {"memory_GB": "memory, estimated [GB]", "time_s": "time, estimated [s]"}
    return [(units.get(key, key.replace("_", " ")), number(value))]


def results_json(folder: Path) -> dict[str, Any]:
    """Return what `pysprings run --json` prints: run.json, the files and the comparison."""
    from pysprings.compare import compare, to_dict

    record = json.loads((folder / "run.json").read_text(encoding="utf-8"))
    files = sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())
    return {
        "folder": str(folder),
        "files": files,
        "run": record,
        "compare": to_dict(compare(springs_of(folder))),
    }


def print_results(folder: Path) -> None:
    """Print where the results of a run are, and the prediction beside the full model."""
    from pysprings.compare import compare, to_text

    print(f"results in {folder}")
    rows = [(str(folder / name), text) for name, text in RESULT_FILES.items() if (folder / name).exists()]
    pictures = sorted(path for path in folder.rglob("*") if path.suffix in PICTURES)
    rows += [(str(path), "picture") for path in pictures]
    width = max((len(name) for name, _ in rows), default=0)
    for name, text in rows:
        print(f"  {name.ljust(width)}  {text}")
    print("\nprediction with the springs against the full model:")
    print(to_text(compare(springs_of(folder))), end="")


def prediction_json(states: xr.Dataset) -> dict[str, Any]:
    """Return what `pysprings predict --json` prints, in SI."""
    names = [name for name in states.data_vars if states[name].dims == ("step",)]
    units = {name: states[name].attrs.get("units", "1") for name in names}
    rows = [{name: states[name].values[step] for name in names} for step in range(states.sizes["step"])]
    return {"attributes": states.attrs, "units": units, "states": rows}


def print_prediction(states: xr.Dataset) -> None:
    """Print states (dimension step) as a table, in the units people use."""
    columns = [column for column in COLUMNS if column[0] in states]
    headers = [f"{name} [{unit}]" for name, unit, _ in columns]
    values = [[f"{value:.5g}" for value in states[name].values * factor + 0.0] for name, _, factor in columns]
    print_table(headers, [list(row) for row in zip(*values, strict=True)])
