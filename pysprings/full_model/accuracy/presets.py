# SPDX-License-Identifier: MIT
"""Settings of a study of errors: meshes by name, and what is varied on one of them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, get_args

from pydantic import ValidationError

from pysprings.core.errors import UserInputError, refused
from pysprings.core.words import Discretisation
from pysprings.full_model.accuracy.target import JUDGED

if TYPE_CHECKING:
    from pysprings.scene.model import Scene

PRESETS = ("coarse", "medium", "paper", "fine")
FINEST_FACTOR, COARSEST_FACTOR = 8.0, 0.25
_NOTHING: Mapping[str, Any] = MappingProxyType({})

MESH, STEPS, TOLERANCE, LINEAR = "mesh", "steps", "tolerance", "linear solver"

# The meshes of the extrapolation, and those that are run beside them
SERIES = ("medium:0.7", "medium", "medium:1.4")
BETWEEN = ("coarse:0.7", "coarse:0.8", "coarse", "medium:0.85", "paper")
QUICK_SERIES = ("coarse:0.7", "coarse", "coarse:1.3")  # 4, 8 and 12 cells around

# Fourier: factors on the elements in each direction; harmonics stand behind @. The three finest have as many rings
# along the skirt as p(y) is compared in slices, or more: with fewer, p between the rings does not converge by an order.
BRICKS, FOURIER = get_args(Discretisation)
FOURIER_SERIES = ("fourier-coarse@8", "fourier-coarse:2@8", "fourier-coarse:3@8", "fourier-coarse:4@8")
FOURIER_BETWEEN = (
    "fourier-coarse@2", "fourier-coarse", "fourier-medium@2", "fourier-medium", "fourier-medium@5", "fourier-paper@2",
    "fourier-paper",
    "fourier-paper@5", "fourier-fine",
)  # fmt: skip
# The load of a series is the same to 0.01 % at a tolerance of 1e-3 and at 1e-5, which takes up to three times as long
FOURIER_SOLVER: Mapping[str, Any] = MappingProxyType({"tolerance": 1e-3})

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
    """One way to run a scene: discretisation, mesh preset with a factor on its counts, values of [solver] that change.

    ``harmonics`` of a Fourier series; None: those of the preset. ``series`` marks the meshes from which a reference is
    extrapolated.
    """

    name: str
    group: str
    mesh: str
    refinement: float = 1.0
    solver: Mapping[str, Any] = field(default_factory=lambda: _NOTHING)
    series: bool = False
    discretisation: str = BRICKS
    harmonics: int | None = None

    @property
    def mesh_key(self) -> tuple[str, str, float, int | None]:
        """What two settings on the same mesh have in common."""
        return self.discretisation, self.mesh, self.refinement, self.harmonics

    def scene(self, scene: Scene) -> Scene:
        """Return the scene with this setting: factors on the mesh multiply, sectors are those of the preset."""
        refinement = scene.mesh.refinement * self.refinement
        if not COARSEST_FACTOR <= refinement <= FINEST_FACTOR:
            own = (
                f"'{self.name}' with the scene's own mesh.refinement {scene.mesh.refinement:g} is {refinement:g} times"
            )
            raise refused("--mesh", f"{own} {self.mesh}, not in [{COARSEST_FACTOR:g}, {FINEST_FACTOR:g}]")
        mesh = {"preset": self.mesh, "refinement": refinement, "azimuth": None,
                "discretisation": self.discretisation, "harmonics": self.harmonics}  # fmt: skip
        try:
            return scene.replace(mesh=mesh, solver=dict(self.solver))
        except ValidationError as error:
            why = "; ".join(each["msg"].strip() for each in error.errors(include_url=False))
            raise refused("--mesh", f"'{self.name}': {why}") from None


def settings(
    meshes: Sequence[str] = (), quick: bool = False, linear: Sequence[str] = (), base_linear: str = "",
    fourier: bool = False,
) -> list[Setting]:  # fmt: skip
    """Return the settings of a study.

    meshes : presets, with a factor if wanted ("medium:0.7", "fourier-coarse:2@5"), in any order; the series of the
        extrapolation. Empty: SERIES, and BETWEEN.
    quick : a smaller series (where no meshes are given) and fewer variations.
    linear : linear solvers to try beside ``base_linear``, the one that the other runs use.
    fourier : the scene can be run with Fourier series: add those meshes (where none are given).
    """
    chosen = [read_mesh(text, series=True) for text in meshes or (QUICK_SERIES if quick else SERIES)]
    series = sorted({each.name: each for each in chosen}.values(), key=_unknowns)
    bricks = [each for each in series if each.discretisation == BRICKS]
    between = [] if meshes or quick else [read_mesh(text) for text in BETWEEN]
    beside = []
    if fourier and not meshes and not quick:
        beside = [*map(read_mesh, FOURIER_BETWEEN), *(read_mesh(text, series=True) for text in FOURIER_SERIES)]
    return [*between, *series, *_variations(bricks or series, quick, linear, base_linear), *beside]


def _variations(
    series: Sequence[Setting], quick: bool, linear: Sequence[str], base_linear: str
) -> list[Setting]:  # fmt: skip
    """Return one setting at a time on the second finest mesh of a series; Fourier series have a solver of their own."""
    base = series[max(len(series) - 2, 0)]
    varied = [each for each in VARIED if not quick or each[1] in QUICK_VARIED]
    others = (
        []
        if quick or base.discretisation == FOURIER
        else [(LINEAR, name, {"linear": name}) for name in linear if name != base_linear]
    )
    return [
        replace(base, name=f"{base.name}-{end}", group=group, solver={**base.solver, **values}, series=False)
        for group, end, values in [*varied, *others]
    ]


def _unknowns(setting: Setting) -> int:
    """Return the unknowns of a mesh, by which presets and factors are ordered; of the paper's caisson."""
    from pysprings.model.forecast.resources import size_of
    from pysprings.scene.model import Scene
    from pysprings.scene.sections import PAPER_SOIL

    return size_of(setting.scene(Scene(soil=PAPER_SOIL))).unknowns


_MESH = re.compile(rf"({FOURIER}-)?([a-z]+)(?::([0-9]*\.?[0-9]+))?(?:@([0-9]+))?")


def read_mesh(text: str, series: bool = False) -> Setting:
    """Return the setting of a mesh as the command line names it: "medium", "medium:0.7", "fourier-paper@5"."""
    parts = _MESH.fullmatch(text)
    if not parts or parts[2] not in PRESETS or (parts[4] and not parts[1]):
        known = ", ".join(PRESETS)
        raise refused(
            "--mesh", f"'{text[:40]}' is no mesh; give {known}, one with a factor: coarse:0.7, or {FOURIER}-coarse:2@5"
        )
    factor = float(parts[3] or 1.0)
    if not COARSEST_FACTOR <= factor <= FINEST_FACTOR:
        raise refused("--mesh", f"the factor {factor:g} is not in [{COARSEST_FACTOR:g}, {FINEST_FACTOR:g}]")
    name = parts[2] if factor == 1.0 else f"{parts[2]}-{factor:g}"
    if not parts[1]:
        return Setting(name, MESH, parts[2], factor, series=series)
    harmonics = int(parts[4]) if parts[4] else None
    name = f"{FOURIER}-{name}" + ("" if harmonics is None else f"-N{harmonics}")
    return Setting(name, MESH, parts[2], factor, FOURIER_SOLVER, series, FOURIER, harmonics)


SCHEMA = "pysprings-accuracy-2"


def carries_series(scene: Scene) -> bool:
    """Return whether a scene can be run with Fourier series."""
    try:
        read_mesh(f"{FOURIER}-coarse").scene(scene.replace(mesh={"refinement": 1.0, "azimuth": None}))
    except (UserInputError, ValidationError):
        return False
    return True


def cheapest_within(limit: float, rows: Iterable[Mapping[str, Any]]) -> Mapping[str, Any] | None:
    """Return the row with the least processor time whose errors [%] are within a limit; None: there is none.

    Other programs on the machine of a study disturb processor time less than wall time.
    """
    errors = [(row, [row[f"{name}_pct"] for name in JUDGED]) for row in rows]
    good = [row for row, own in errors if all(value is not None and value <= limit for value in own)]
    return min(good, key=lambda row: float(row["cpu_s"]), default=None)
