# SPDX-License-Identifier: MIT
"""Caissons and sequences of the benchmark of springs with memory: what they are calibrated on, what is held back."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pysprings.scene.load import Scene, load_scene, parse_scene
from pysprings.scene.template import template_text

ROOT = Path(__file__).parents[1]
# Factors on the load of a case: (H, M/D about the lid centre), ends of the parts of a sequence
_ONE_WAY = [(0.5, -0.5), *[(0.1, -0.1), (0.5, -0.5)] * 5]
_MOMENTS = [(0.4, 0.0), *[(0.4, -0.5), (0.4, -0.1)] * 4]
_MOORING = [(0.6, 0.2), (0.3, 0.15), (0.8, 0.16), (0.2, 0.06), (0.9, 0.3), (0.4, 0.1)]
_STORM = [(0.25, -0.45), (0.05, -0.2), (0.4, -0.5), (-0.1, -0.1), (0.5, -0.6), (0.1, -0.35), (0.3, -0.3), (-0.2, 0.1)]
# Case -> vertical loads [N] of sequences: about that at rest, one between, a second one with rays that turn back
LOADED = {
    "sand": {"rest": 0.7e6, "between": 1.8e6, "heavy": 3e6}, "clay": {"rest": 2e6, "between": 3e6, "heavy": 4e6},
}  # fmt: skip
# Parts of sequences under a vertical load that changes: "heavy", "between", "rest" are loads, pairs factors as above
_STORM_V = [
    "heavy", (0.5, -0.5), (0.1, -0.1), "between", (0.4, -0.4), (-0.1, 0.1), "rest", (0.3, -0.3), (0.0, 0.0), "heavy",
    (0.5, -0.5), (0.0, 0.0),
]  # fmt: skip
_MOMENTS_V = [(0.3, -0.3), (0.3, -0.1), *[
    part for V, M in (("between", -0.4), ("rest", -0.3), ("heavy", -0.4)) for part in (V, (0.3, M), (0.3, -0.1))
]]  # fmt: skip
_REST = 60.0  # s, in coupled sequences
_PULL_V = ["heavy", -0.1, "between", 0.1, "rest", -0.1, 0.1]  # u over the reach


@dataclass(frozen=True)
class Case:
    """A caisson with its ground.

    scene : sections of the scene without paths. reach : of the fan [m]. force : size of the sequences of loads [N].
    """

    name: str
    title: str
    scene: Scene
    reach: float
    force: float


def cases() -> dict[str, Case]:
    """Return the caissons of the benchmark by name."""
    cohesive = load_scene(ROOT / "data/scenes/fan-cohesive-long-caisson.toml")
    clay = parse_scene(template_text("soft-clay"))
    paper = Scene(caisson={"outer_diameter": 7.8, "skirt_length": 4.0}, domain={"radius": 24.0, "depth": 12.0})
    return {
        "sand": Case("sand", "the paper's caisson, drained sand", paper, 20e-3, 1.0e6),
        "cohesive": Case("cohesive", "L/D 1, soil with cohesion, drained", cohesive, 30e-3, 1.0e6),
        "clay": Case("clay", "L/D 0.75, soft clay, undrained", clay, 100e-3, 1.0e6),
        "sand-iwan": Case("sand-iwan", "the paper's caisson, sand with kinematic hardening", iwan_sand(), 20e-3, 1.0e6),
        "clay-iwan": Case("clay-iwan", "L/D 0.75, clay with kinematic hardening", iwan_clay(), 100e-3, 1.0e6),
    }


def iwan_sand(law: str = "iwan-sand") -> Scene:
    """Return the paper's caisson in sand of this law."""
    paper = {"outer_diameter": 7.8, "skirt_length": 4.0}
    return Scene(caisson=paper, domain={"radius": 24.0, "depth": 12.0}, soil={"yield_surface": law})


def iwan_clay(law: str = "iwan-clay") -> Scene:
    """Return the caisson of the template for soft clay, in clay of this law that is stiff at small strains."""
    data = parse_scene(template_text("soft-clay")).model_dump()
    soft = {"yield_surface": law, "rigidity_ratio": 600.0, "strain_at_half_strength": 0.005}
    data["soil"] = {name: value for name, value in data["soil"].items() if value is not None} | soft
    return Scene.model_validate(data)


def scene_of(case: Case) -> Scene:
    """Return the scene of a case: a fan with reversed rays, and all sequences held back."""
    output = {"interface_fields": False, "section": False, "figures": False}
    mesh = {"preset": "coarse", "harmonics": 5}
    data = case.scene.model_dump() | {"paths": _sequences(case), "springs": {"reach": case.reach, "memory": True}}
    data["mesh"] = data["mesh"] | mesh
    data["output"] = data["output"] | output
    return Scene.model_validate(data)


def loaded_scene(case: Case) -> Scene:
    """Return the scene of a case with a fan and reversed rays under two vertical loads, and sequences held back."""
    loads = LOADED[case.name]
    data = scene_of(case).model_dump()
    data["paths"] = _loaded_sequences(case, loads)
    data["springs"] = data["springs"] | {"vertical_loads": (loads["heavy"],), "held_back": False}
    return Scene.model_validate(data)


def _loaded_sequences(case: Case, loads: dict[str, float]) -> list[dict[str, Any]]:
    """Return sequences under one vertical load, then those under one that changes from part to part."""
    D, r, F = case.scene.caisson.outer_diameter, case.reach, case.force
    one = [_loop(1, D, 0.2 * r), _loads("one_way", _ONE_WAY, F, D), _loads("moment_cycles", _MOMENTS, F, D),
           _loads("wind_and_waves", _STORM, F, D)]  # fmt: skip

    def part(each: Any) -> tuple[Any, ...]:
        if isinstance(each, str):
            return (None, None, None, None, loads[each])
        return (each * r, None, None) if isinstance(each, float) else (each[0] * F, None, None, each[1] * D * F)

    pull = {"name": "pull_V", "kind": "pull", "arm": D, "lateral_displacement": 0.1 * r, "role": "held-back"}
    storm = {"name": "storm_V", "kind": "load", "lateral_force": 0.3 * F, "arm": D, "role": "held-back"}
    moments = storm | {"name": "moments_V", "arm": 0.0, "vertical_load": loads["heavy"]}
    return [
        *(path | {"name": f"{path['name']}_{V}", "vertical_load": loads[V]}
          for V in ("between", "heavy") for path in one),
        *(path | {"then": [part(each) for each in parts]}
          for path, parts in ((storm, _STORM_V), (moments, _MOMENTS_V), (pull, _PULL_V))),
    ]  # fmt: skip


def wet_scene(mode: str) -> Scene:
    """Return the paper's caisson, coupled at two rates or undrained: a fan, reversed rays, and held-back paths."""
    data = scene_of(cases()["sand"]).model_dump()
    reach, rates = 10e-3, (0.05e-3, 0.5e-3) if mode == "coupled" else ()
    data["drainage"] = data["drainage"] | {"mode": mode}
    data["springs"] = data["springs"] | {"reach": reach, "rates": rates, "held_back": False, "vertical": False}
    timed = ("loop_1_D_between", "rests_0_D")
    paths = _wet_sequences(data["caisson"], reach)
    data["paths"] = [path for path in paths if rates or path["name"] not in timed]
    return Scene.model_validate(data)


def _wet_sequences(caisson: dict[str, Any], reach: float) -> list[dict[str, Any]]:
    """Return held-back paths of which the motion, u and rotation*L, has about the faster rate, or lies between both."""
    u, D, there = 0.2 * reach, caisson["outer_diameter"], 0.4 * reach
    along, turn = there * math.cos(math.radians(-40)), there * math.sin(math.radians(-40)) / caisson["skirt_length"]

    def pull(name: str, arm: float, rate: float, *ends: float | None) -> dict[str, Any]:
        then = [(None, None, _REST) if end is None else (end * u, rate, None) for end in ends]
        return {"name": name, "kind": "pull", "arm": arm, "lateral_displacement": u, "rate": rate, "then": then}

    paths = [
        pull("pull_0_D", 0.0, 0.4e-3), pull("loop_1_D", D, 0.33e-3, 0.0, 1.0, -1.0, 1.0),
        pull("loop_1_D_between", D, 0.1e-3, 0.0, 1.0, -1.0, 1.0), pull("rests_0_D", 0.0, 0.4e-3, None, -1.0, None, 0.0),
        {"name": "ray_minus_40_reversed", "kind": "translation", "lateral_displacement": along, "rotation": turn,
         "rate": 0.38e-3, "then": [(-along, 0.38e-3, None), (along, 0.38e-3, None)]},
    ]  # fmt: skip
    return [path | {"role": "held-back"} for path in paths]


def _sequences(case: Case) -> list[dict[str, Any]]:
    """Return the paths of a case on which its springs are only checked."""
    D, L, r = case.scene.caisson.outer_diameter, case.scene.caisson.skirt_length, case.reach
    loads = {"one_way": _ONE_WAY, "moment_cycles": _MOMENTS, "mooring_line": _MOORING, "wind_and_waves": _STORM}
    there = 0.4 * r
    along, turn = there * math.cos(math.radians(-40)), there * math.sin(math.radians(-40)) / L
    pull = {"kind": "pull", "role": "held-back"}
    small = 0.15 * r
    return [
        {"name": "ray_minus_40_reversed", "kind": "translation", "lateral_displacement": along, "rotation": turn,
         "role": "held-back", "then": [(-along, None, None), (along, None, None)]},
        *(_loop(arm, D, 0.25 * r) for arm in (0, 1)),
        {**pull, "name": "ten_cycles_1_D", "arm": D, "lateral_displacement": small,
         "then": [(sign * small, None, None) for _ in range(10) for sign in (-1.0, 1.0)]},
        {"name": "climb", "kind": "load", "lateral_force": case.force, "arm_from": 0.0, "arm": D, "role": "held-back"},
        {"name": "swipe", "kind": "swipe", "lateral_displacement": 0.25 * r, "rotation": -0.4 * r / L,
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
        "name": name, "kind": "load", "lateral_force": H * force, "arm": -M / H * D, "role": "held-back",
        "then": [(H * force, None, None, M * D * force) for H, M in rest],
    }  # fmt: skip
