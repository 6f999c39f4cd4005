# SPDX-License-Identifier: MIT
"""Scenes small enough to run in a test (216 nodes, five steps, less than a second), and runs that tests share."""

import json
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

from pysprings import Scene
from pysprings.core.errors import Problem, UserInputError
from pysprings.full_model.compute import run
from pysprings.scene.changes import read_changes
from pysprings.scene.load import SceneText
from pysprings.scene.sections import BY_LAYER, PAPER, PAPER_SOIL, Soil
from pysprings.scene.soils import LAW_KEYS, SOIL_LAWS, STIFFNESSES
from pysprings.scene.toml import _pairs

PULL = {"name": "pull", "kind": "pull", "lateral_displacement": 0.5e-3}
SECTIONS: dict[str, Any] = {
    "title": "tiny",
    "domain": PAPER,
    "soil": PAPER_SOIL,
    "mesh": {"refinement": 0.4, "discretisation": "hex8"},
    "solver": {"first_step_fraction": 0.05, "max_step_fraction": 0.5},
    "output": {"figures": False},
    "paths": (PULL,),
}


def with_soil(given: dict[str, Any]) -> dict[str, Any]:
    """Return a table of the soil with what it does not give of the paper's sand; of clay weight and surcharge alone."""
    law, rest = SOIL_LAWS[given.get("yield_surface", "drucker-prager")], dict(PAPER_SOIL)
    if law.total_stress:
        rest = {name: rest[name] for name in ("effective_unit_weight", "surcharge")}
    elif any(given.get(name) is not None for name in STIFFNESSES):
        del rest["young_modulus"]
    if given.get("K0") == "auto":
        del rest["friction_angle_initial"]  # by default that which holds the initial stress
    foreign = {*LAW_KEYS} - {*law.keys, *law.unused} | ({"young_modulus"} if law.gives_stiffness else set())
    return {name: value for name, value in rest.items() if name not in foreign} | given


def only(**given: Any) -> dict[str, Any]:
    """Return a table of the soil that `Scene.replace` puts in place of the one before, as `with_soil`."""
    return dict.fromkeys(BY_LAYER) | with_soil(given)


def sand(**sections: Any) -> Scene:
    """Return a scene whose ground is the paper's sand where it does not give its own."""
    return Scene(**sections | {"soil": with_soil(sections.get("soil", {}))})


def parsed(text: str, file: str | None = None, changes: Sequence[str] = ()) -> Scene:
    """Return the scene of a text whose ground is the paper's sand where the text does not give its own."""
    read = SceneText(text, file)
    soil = read._data.setdefault("soil", {}) if read._data else None
    if isinstance(soil, dict):
        own: dict[str, Any] = {"K0": "auto"} if soil.get("K0") == "auto" else {}
        own |= {"yield_surface": law} if (law := soil.get("yield_surface")) in [*SOIL_LAWS] else {}
        given = {*soil, "poisson_ratio", "hardening_parameter"}
        given |= {"young_modulus"} if {*STIFFNESSES} & {*soil} else set()
        soil |= {name: value for name, value in _pairs(Soil.model_validate(with_soil(own))) if name not in given}
    return read.scene(read_changes(changes))


def problems(read: Callable[..., Any], *given: Any) -> list[Problem]:
    """Return the problems with which a call refuses what the user gives."""
    with pytest.raises(UserInputError) as refused:
        read(*given)
    return [*refused.value.problems]


def messages(text: str) -> list[str]:
    """Return the problems of the text of a scene, see `parsed`, in words."""
    return [str(problem) for problem in problems(parsed, text)]


def grounded(text: str) -> str:
    """Return a text of a scene with the paper's sand where it does not give its own."""
    soil = Soil.model_validate(with_soil({}))
    lines = [f"{key} = {json.dumps(value)}" for key, value in _pairs(soil) if f"\n{key} = " not in text]
    whole = text if "[soil]\n" in text else f"{text}\n[soil]\n"
    return whole.replace("[soil]\n", "\n".join(["[soil]", *lines, ""]), 1)


def paper(**sections: Any) -> Scene:
    """Return the paper's caisson in the paper's domain, on bricks, with some values changed."""
    mesh = {"discretisation": "hex8"} | sections.pop("mesh", {})
    return sand(**sections | {"domain": PAPER | sections.pop("domain", {}), "mesh": mesh})


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
