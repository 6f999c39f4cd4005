# SPDX-License-Identifier: MIT
"""Caissons and sequences of the benchmark of springs with memory: what they are calibrated on, what is held back."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pysprings.scene.load import load_scene, parse_scene
from pysprings.scene.model import Scene
from pysprings.scene.sections import PAPER, PAPER_SOIL
from pysprings.scene.template import template_text

ROOT = Path(__file__).parents[1]
# Factors on the load of a case: (H, M/D about the lid centre), ends of the parts of a sequence
_ONE_WAY = [(0.5, 0.5), *[(0.1, 0.1), (0.5, 0.5)] * 5]
_MOMENTS = [(0.4, 0.0), *[(0.4, 0.5), (0.4, 0.1)] * 4]
_MOORING = [(0.6, 0.2), (0.3, 0.15), (0.8, 0.16), (0.2, 0.06), (0.9, 0.3), (0.4, 0.1)]
_STORM = [(0.25, 0.45), (0.05, 0.2), (0.4, 0.5), (-0.1, 0.1), (0.5, 0.6), (0.1, 0.35), (0.3, 0.3), (-0.2, -0.1)]


@dataclass(frozen=True)
class Case:
    """A caisson with its ground.

    scene : sections of the scene without paths. reach : of the fan [m]. force : size of the sequences of loads [N].
    """

    name: str
    scene: Scene
    reach: float
    force: float


def cases() -> dict[str, Case]:
    """Return the paper's caisson in sand, L/D 1 in soil with cohesion, L/D 0.75 in soft clay; -iwan: kinematic."""
    cohesive = load_scene(ROOT / "data/scenes/fan-cohesive-long-caisson.toml")
    clay = parse_scene(template_text("soft-clay"))
    known = {name: value for name, value in clay.model_dump()["soil"].items() if value is not None}
    stiff = {"yield_surface": "iwan-clay", "rigidity_ratio": 600.0, "strain_at_half_strength": 0.005}
    kinematic = Scene.model_validate(clay.model_dump() | {"soil": known | stiff})
    paper = Scene(domain=PAPER, soil=PAPER_SOIL)
    return {
        "sand": Case("sand", paper, 20e-3, 1.0e6),
        "cohesive": Case("cohesive", cohesive, 30e-3, 1.0e6),
        "clay": Case("clay", clay, 100e-3, 1.0e6),
        "sand-iwan": Case("sand-iwan", paper.replace(soil={"yield_surface": "iwan-sand"}), 20e-3, 1.0e6),
        "clay-iwan": Case("clay-iwan", kinematic, 100e-3, 1.0e6),
    }


def scene_of(case: Case) -> Scene:
    """Return the scene of a case: a fan with reversed rays, and all sequences held back."""
    data = case.scene.model_dump() | {"paths": _sequences(case), "springs": {"reach": case.reach, "memory": True}}
    data["mesh"] |= {"preset": "coarse", "harmonics": 5}
    data["output"] |= {"interface_fields": False, "section": False, "figures": False}
    return Scene.model_validate(data)


def _sequences(case: Case) -> list[dict[str, Any]]:
    """Return the paths of a case on which its springs are only checked."""
    D, L, r = case.scene.caisson.outer_diameter, case.scene.caisson.skirt_length, case.reach
    loads = {"one_way": _ONE_WAY, "moment_cycles": _MOMENTS, "mooring_line": _MOORING, "wind_and_waves": _STORM}
    there = 0.4 * r
    along, turn = there * math.cos(math.radians(40)), there * math.sin(math.radians(40)) / L
    pull = {"kind": "pull", "role": "held-back"}
    small = 0.15 * r
    return [
        {"name": "ray_40_reversed", "kind": "translation", "lateral_displacement": along, "rotation": turn,
         "role": "held-back", "then": [(-along, None, None), (along, None, None)]},
        *(_loop(arm, D, 0.25 * r) for arm in (0, 1)),
        {**pull, "name": "ten_cycles_1_D", "arm": D, "lateral_displacement": small,
         "then": [(sign * small, None, None) for _ in range(10) for sign in (-1.0, 1.0)]},
        {"name": "climb", "kind": "load", "lateral_force": case.force, "arm_from": 0.0, "arm": D, "role": "held-back"},
        {"name": "swipe", "kind": "swipe", "lateral_displacement": 0.25 * r, "rotation": 0.4 * r / L,
         "role": "held-back"},
        *(_loads(name, parts, case.force, D) for name, parts in loads.items()),
    ]  # fmt: skip


def _loop(arm: int, D: float, there: float) -> dict[str, Any]:
    """Return a pull at a height (over D) to u [m] and back, to the other side and back."""
    return {
        "name": f"loop_{arm}_D", "kind": "pull", "arm": arm * D, "lateral_displacement": there, "role": "held-back",
        "then": [(x * there, None, None) for x in (0.0, 1.0, -1.0, 1.0, 0.0)],
    }  # fmt: skip


def _loads(name: str, parts: list[tuple[float, float]], force: float, D: float) -> dict[str, Any]:
    """Return a sequence of loads whose first part grows in proportion."""
    (H, M), *rest = parts
    return {
        "name": name, "kind": "load", "lateral_force": H * force, "arm": M / H * D, "role": "held-back",
        "then": [(H * force, None, None, M * D * force) for H, M in rest],
    }  # fmt: skip
