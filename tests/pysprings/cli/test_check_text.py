# SPDX-License-Identifier: MIT
"""All that `pysprings check` prints of scenes of many kinds, in the stored texts: counts, cost, ground, omissions."""

from pathlib import Path
from typing import Any

import pytest

from pysprings import Scene
from pysprings.scene.template import template_text
from tests.support import stored, tiny
from tests.support.commands import command

LOAD = {"name": "storm", "kind": "load", "lateral_force": 2e6, "arm": 5.0}
SINK = {"name": "sink", "kind": "vertical", "vertical_displacement": 0.3, "role": "held-back"}
CYCLE = {
    "name": "cycle",
    "kind": "pull",
    "lateral_displacement": 5e-3,
    "arm": 20.0,
    "then": ["0 mm", "-3 mm"],
    "role": "held-back",
}
TURN = {"name": "turn", "kind": "rotation", "rotation": 4e-3}
WET = tiny.PULL | {"rate": 1e-4}
SCENES: dict[str, dict[str, Any]] = {
    "loads": {
        "paths": (LOAD, SINK, CYCLE, TURN | {"role": "held-back"}),
        "caisson": {"vertical_load": 3e6},
        "output": {"figures": True, "interface_fields": False, "section": False},
    },
    "elastic and coupled": {
        "caisson": {"behaviour": "elastic"},
        "drainage": {"mode": "coupled"},
        "domain": {"side_drainage": "drained", "radius": 12.0, "depth": 6.0},
        "output": {"paraview": True, "figures": False},
        "paths": (WET,),
    },
    "undrained": {"drainage": {"mode": "undrained"}, "paths": (WET,), "interface": {"friction_coefficient": 0.0}},
    "soft contact": {
        "interface": {"normal_stiffness": 1e7, "shear_stiffness": 1e6},
        "soil": {"yield_surface": "van-eekelen", "dilation_angle": 0.1, "cohesion": 5e3, "K0": 0.8},
    },
    "elastic soil": {"soil": {"yield_surface": "elastic"}, "solver": {"linear": "superlu"}},
    "series": {"mesh": {"preset": "coarse", "refinement": 0.6, "discretisation": "fourier"}},
}


def printed(text: str, folder: Path) -> list[str]:
    """Lines of `pysprings check` on a scene, without its digest and what depends on the memory that is free."""
    (folder / "scene.toml").write_text(text, encoding="utf-8")
    done = command("check", "scene.toml")
    assert done.code == 0, done.err
    lines = [*done.out.splitlines(), *done.err.splitlines()]
    return [line for line in lines if not line.startswith(("sha256", "warning: the run needs about"))]


def test_all_that_is_printed_of_scenes(tmp_path: Path) -> None:
    pytest.importorskip("pypardiso")  # times and memory of bricks are those of Pardiso
    lines = []
    for name, sections in SCENES.items():
        scene: Scene = tiny.scene(**sections)
        lines += [f"--- {name}", *printed(scene.to_toml(), tmp_path), ""]
    for name in ("layered-sand", "paper-partially-drained"):
        lines += [f"--- {name}", *printed(template_text(name), tmp_path), ""]
    about = "what `pysprings check` prints; time and memory are fitted laws, tested in tests/pysprings/model"
    stored.compare(lines, Path(__file__).parent / "texts" / "check.txt", about)
