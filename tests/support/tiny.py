# SPDX-License-Identifier: MIT
"""Scenes small enough to run in a test (216 nodes, five steps, less than a second), and runs that tests share."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import xarray as xr

from pysprings import Scene
from pysprings.full_model.compute import run
from pysprings.scene.extent import PAPER

PULL = {"name": "pull", "kind": "pull", "lateral_displacement": 0.5e-3}
SECTIONS: dict[str, Any] = {
    "title": "tiny",
    "domain": PAPER,
    "mesh": {"refinement": 0.4, "discretisation": "hex8"},
    "solver": {"first_step_fraction": 0.05, "max_step_fraction": 0.5},
    "output": {"figures": False},
    "paths": (PULL,),
}


def paper(**sections: Any) -> Scene:
    """Return the paper's caisson in the paper's domain, on bricks, with some values changed."""
    mesh = {"discretisation": "hex8"} | sections.pop("mesh", {})
    return Scene(**sections | {"domain": PAPER | sections.pop("domain", {}), "mesh": mesh})


def scene(**sections: Any) -> Scene:
    """Return the tiny scene with some values changed."""
    return Scene(**SECTIONS).replace(**sections)


def wet(mode: str = "coupled", rate: float = 1e-4, drainage: dict | None = None, **path: object) -> Scene:
    """Return the tiny scene with water, pulled at a rate (m/s)."""
    pull = {**PULL, "rate": rate, **path}
    return scene(drainage={"mode": mode, **(drainage or {})}, paths=(pull,))


def overloaded_scene(**sections: Any) -> Scene:
    """Return a load that the soil does not carry: its first steps converge."""
    path = {"name": "storm", "kind": "load", "lateral_force": 2e7}
    return scene(interface={"friction_coefficient": 0.0}, paths=(path,), **sections)


def stuck_scene(**sections: Any) -> Scene:
    """Return a scene that cannot converge from its first step on: rounding is above the tolerance."""
    return scene(solver={"tolerance": 1e-12, "max_iterations": 2, "first_step_fraction": 1e-5}, **sections)


def write(scene: Scene, file: Path) -> Path:
    """Write a scene file; return its path."""
    file.write_text("# the user's own words\n" + scene.to_toml(), encoding="utf-8")
    return file


@cache
def result() -> xr.DataTree:
    """Return a run of the tiny scene; not to be changed by a test."""
    return run(scene())
