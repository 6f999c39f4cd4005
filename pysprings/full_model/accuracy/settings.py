# SPDX-License-Identifier: MIT
"""What `pysprings accuracy` varies, as data: meshes, and beside them one setting at a time."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from pysprings.core.errors import refused

if TYPE_CHECKING:
    from pysprings.scene.load import Scene

PRESETS = ("coarse", "medium", "paper", "fine")
FINEST_FACTOR, COARSEST_FACTOR = 8.0, 0.25
_NOTHING: Mapping[str, Any] = MappingProxyType({})

MESH, STEPS, TOLERANCE, LINEAR = "mesh", "steps", "tolerance", "linear solver"

# The meshes of the extrapolation, and those that are run beside them
SERIES = ("medium:0.7", "medium", "medium:1.4")
BETWEEN = ("coarse:0.7", "coarse:0.8", "coarse", "medium:0.85", "paper")
QUICK_SERIES = ("coarse:0.7", "coarse", "coarse:1.3")  # 4, 8 and 12 cells around

# group, end of the name, values of [solver] (steps: shares of a path); on the second finest mesh of the series
VARIED: tuple[tuple[str, str, Mapping[str, Any]], ...] = (
    (STEPS, "steps-0.3", {"max_step_fraction": 0.3}),
    (STEPS, "steps-0.1", {"max_step_fraction": 0.1}),
    (STEPS, "steps-0.02", {"max_step_fraction": 0.02}),
    (STEPS, "first-0.02", {"first_step_fraction": 0.02}),
    (TOLERANCE, "tolerance-1e-2", {"tolerance": 1e-2}),
    (TOLERANCE, "tolerance-1e-3", {"tolerance": 1e-3}),
    (TOLERANCE, "tolerance-1e-4", {"tolerance": 1e-4}),
    (TOLERANCE, "tolerance-1e-8", {"tolerance": 1e-8}),
)
QUICK_VARIED = ("steps-0.3", "tolerance-1e-3")


@dataclass(frozen=True)
class Setting:
    """One way to run a scene: mesh preset with a factor on its counts, and values of [solver] that change.

    ``series`` marks the meshes from which the reference is extrapolated.
    """

    name: str
    group: str
    mesh: str
    refinement: float = 1.0
    solver: Mapping[str, Any] = field(default_factory=lambda: _NOTHING)
    series: bool = False

    def scene(self, scene: Scene) -> Scene:
        """Return the scene with this setting: factors on the mesh multiply, sectors are those of the preset."""
        refinement = scene.mesh.refinement * self.refinement
        if not COARSEST_FACTOR <= refinement <= FINEST_FACTOR:
            own = (
                f"'{self.name}' with the scene's own mesh.refinement {scene.mesh.refinement:g} is {refinement:g} times"
            )
            raise refused("--mesh", f"{own} {self.mesh}, not in [{COARSEST_FACTOR:g}, {FINEST_FACTOR:g}]")
        mesh = {"preset": self.mesh, "refinement": refinement, "azimuth": None}
        return scene.replace(mesh=mesh, solver=dict(self.solver))


def settings(
    meshes: Sequence[str] = (), quick: bool = False, linear: Sequence[str] = (), base_linear: str = ""
) -> list[Setting]:
    """Return the settings of a study.

    Parameters
    ----------
    meshes : presets, with an optional factor ("medium:0.7"), in any order; the series of the extrapolation.
        Empty: SERIES, and BETWEEN.
    quick : a smaller series (where no meshes are given) and fewer variations.
    linear : linear solvers to try beside ``base_linear``, the one that the other runs use.
    """
    chosen = [read_mesh(text, series=True) for text in meshes or (QUICK_SERIES if quick else SERIES)]
    series = sorted({each.name: each for each in chosen}.values(), key=_unknowns)
    between = [] if meshes or quick else [read_mesh(text) for text in BETWEEN]
    base = series[max(len(series) - 2, 0)]
    varied = [each for each in VARIED if not quick or each[1] in QUICK_VARIED]
    others = [] if quick else [(LINEAR, name, {"linear": name}) for name in linear if name != base_linear]
    return [
        *between,
        *series,
        *(Setting(f"{base.name}-{end}", group, base.mesh, base.refinement, values)
          for group, end, values in [*varied, *others]),
    ]  # fmt: skip


def _unknowns(setting: Setting) -> int:
    """Return the unknowns of a mesh, by which presets and factors are ordered; of the default scene."""
    from pysprings.model.forecast.resources import size_of
    from pysprings.scene.load import Scene

    return size_of(setting.scene(Scene())).unknowns


def read_mesh(text: str, series: bool = False) -> Setting:
    """Return the setting of a mesh as the command line names it: "medium", or "medium:0.7"."""
    match = re.fullmatch(r"([a-z]+)(?::([0-9]*\.?[0-9]+))?", text)
    if not match or match[1] not in PRESETS:
        known = ", ".join(PRESETS)
        raise refused("--mesh", f"'{text[:40]}' is no mesh; give {known}, or one with a factor: coarse:0.7")
    factor = float(match[2] or 1.0)
    if not COARSEST_FACTOR <= factor <= FINEST_FACTOR:
        raise refused("--mesh", f"the factor {factor:g} is not in [{COARSEST_FACTOR:g}, {FINEST_FACTOR:g}]")
    name = match[1] if factor == 1.0 else f"{match[1]}-{factor:g}"
    return Setting(name, MESH, match[1], factor, series=series)
