# SPDX-License-Identifier: MIT
"""Collapse loads of rigid bodies bonded to Tresca clay, in Fourier series: a caisson of the tool, pushed to its limit.

The strength is su = su_m (1 + kappa z/D), su_0 that at the level of the skirt tip. Factors are V/(A su_0), H/(A su_0)
and M/(A D su_0) with A = pi D^2/4. The skirt is thin (D/2000), and its tip bears nothing.
"""

from dataclasses import dataclass

import numpy as np

from fe_engine.assembly.fourier_system import FourierSystem
from fe_engine.contact import adhesion
from fe_engine.errors import NotConverged
from fe_engine.model import Stage
from fe_engine.settings import Settings
from fe_engine.solve.fourier_stage import FourierStage
from fe_engine.solve.newton import Newton
from fe_engine.solve.stepping import Driver, Step
from fe_engine.state import State
from pysprings import Scene
from pysprings.model.contact import SURFACE
from pysprings.model.fourier import build, build_on_section
from pysprings.model.fourier_mesh import SectionCounts
from tests.support import tiny

DIAMETER, RIGIDITY, POISSON, STRENGTH = 10.0, 167.0, 0.49, 10.0e3
AREA = 0.25 * np.pi * DIAMETER**2
THICKNESS = DIAMETER / 2000.0
REACH = 0.1 * DIAMETER  # (G/su)(u/D) = 17
_TOLERANCE = 1.0e-4
_NOTHING = 1.0  # N/m3, penalty of the tip
# Loads: what is imposed, over (u, w, rotation), and the pattern of the force that imposes it, by the depth L of the tip
LOADS = {
    "NcV": ((0.0, 1.0, 0.0), lambda tip: (0.0, 1.0, 0.0)),
    "NcH": ((1.0, 0.0, 0.0), lambda tip: (1.0, 0.0, -tip)),
    "NcM": ((0.0, 0.0, 1.0), lambda tip: (0.0, 0.0, 1.0)),
    "H, mudline": ((1.0, 0.0, 0.0), lambda tip: (1.0, 0.0, 0.0)),
}
HELD = "H, rotation held"


@dataclass(frozen=True)
class Clay:
    """A caisson in clay: embedment d/D, kappa, cell beside wall and toe as a part of the diameter (40: D/40).

    With a ``preset`` ("coarse", or "coarse:2" for a refinement of 2) its mesh is that of the tool, whatever the cells.
    """

    embedment: float
    kappa: float
    cells: float
    harmonics: int = 5
    preset: str = ""

    @property
    def tip(self) -> float:
        """Depth of the tip, m."""
        return self.embedment * DIAMETER

    @property
    def strength(self) -> float:
        """su_0 at the level of the tip, Pa."""
        return STRENGTH * (1.0 + self.kappa * self.embedment)

    def scene(self) -> Scene:
        """Return the caisson as a scene."""
        gradient = STRENGTH * self.kappa / DIAMETER
        preset, _, factor = (self.preset or "coarse").partition(":")
        return tiny.sand(
            caisson={"outer_diameter": DIAMETER, "skirt_length": self.tip, "skirt_thickness": THICKNESS},
            domain={"radius": 3.0 * DIAMETER, "depth": self.tip + 2.5 * DIAMETER},
            soil={
                "yield_surface": "tresca", "undrained_shear_strength": {"top": STRENGTH, "gradient": gradient},
                "rigidity_ratio": RIGIDITY, "poisson_ratio": POISSON, "effective_unit_weight": 6e3, "surcharge": 0.0,
            },
            interface={"adhesion_factor": 1.0, "opening": "bonded"},
            mesh={
                "discretisation": "fourier", "harmonics": self.harmonics, "preset": preset,
                "refinement": float(factor or 1.0),
            },
        )  # fmt: skip

    def counts(self) -> SectionCounts:
        """Return the numbers of elements: twice as many where the cells are half as large."""
        factor = self.cells / 40.0
        size = 1.0 / self.cells  # over the diameter

        def scaled(number: float) -> int:
            return max(1, round(number * factor))

        return SectionCounts(
            plug=scaled(9), outer=scaled(13), tip=1, skirt=scaled(8 + 8 * self.embedment), below=scaled(13),
            wall=2.0 * size, mudline=size / self.embedment, toe=size / self.embedment, harmonics=self.harmonics,
            own=True,
        )  # fmt: skip


def stage_of(clay: Clay, load: str) -> Stage:
    """Return the stage that pushes to the limit."""
    free = {"max_fraction": 0.2, "first_fraction": 1.0e-3}
    if load == HELD:
        control = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
        return Stage("held", control, np.array([REACH, 0.0]), control.T.copy(), np.zeros(3), **free)
    imposed, pattern = LOADS[load]
    reach = REACH / (0.5 * DIAMETER) if load == "NcM" else REACH
    force = np.array(pattern(clay.tip))[:, None]
    return Stage(load, np.array([imposed]), np.array([reach]), force, np.zeros(3), **free)


@dataclass(frozen=True)
class Push:
    """Factor at the end of a push, and what it took: increments, median of the Newton iterations, cut-backs."""

    factor: float
    increments: int
    median: float
    cut_backs: int


def push(clay: Clay, load: str) -> Push:
    """Push the caisson to its limit; return the factor of the load."""
    steps, cut_backs = _run(clay, load, stage_of(clay, load))
    unit = AREA * clay.strength * (DIAMETER if load == "NcM" else 1.0)
    iterations = [step.increment.iterations for step in steps]
    factor = 2.0 * float(steps[-1].multipliers[0]) / unit
    return Push(factor, len(steps), float(np.median(iterations)), cut_backs)


def probe(clay: Clay, direction: float, vertical: float) -> tuple[float, float]:
    """Return H/(A su_0) and M/(A D su_0) at the limit in a direction, under a constant V of ``vertical`` A su_0.

    The direction is atan(M/(H D)) in degrees, M about the lid centre.
    """
    c, s = np.cos(np.radians(direction)), np.sin(np.radians(direction))
    nothing, unit = np.zeros((0, 3)), AREA * clay.strength
    dead = np.array([0.0, 0.5 * vertical * unit, 0.0])
    stages = [
        Stage("V", nothing, np.zeros(0), nothing.T, dead, first_fraction=0.1, max_fraction=0.25),
        Stage("probe", np.array([[c, 0.0, DIAMETER * s]]), np.array([2.0 * REACH]),
              np.array([[c], [0.0], [DIAMETER * s]]), dead, max_fraction=0.2, first_fraction=5.0e-4),
    ]  # fmt: skip
    steps, _ = _run(clay, f"{direction:g} deg", *(stages if vertical else stages[1:]))
    load = 2.0 * float(steps[-1].multipliers[0]) / unit
    return load * c, load * s


def about_tip(clay: Clay) -> tuple[float, float]:
    """Return H/(A su_0) and M/(A D su_0), M about the tip, of a caisson that rotates about its tip."""
    control = np.array([[1.0, 0.0, -clay.tip], [0.0, 0.0, 1.0]])
    target = np.array([0.0, REACH / (0.5 * DIAMETER)])
    stage = Stage("tip", control, target, control.T.copy(), np.zeros(3), max_fraction=0.2, first_fraction=1.0e-3)
    steps, _ = _run(clay, "rotation about the tip", stage)
    across, turning = 2.0 * steps[-1].multipliers / (AREA * clay.strength)
    return float(across), float(turning) / DIAMETER


def _run(clay: Clay, load: str, *stages: Stage) -> tuple[list[Step], int]:
    """Return the steps of the last stage and the number of cut-backs."""
    scene = clay.scene()
    model = (build(scene) if clay.preset else build_on_section(scene, clay.counts())).model
    model.contact[model.stations.surface == SURFACE["tip"], : adhesion.MU] = _NOTHING  # a skirt without thickness
    system, state = FourierSystem(model), State(model)
    driver = Driver(Newton(system, FourierStage(system), Settings(_TOLERANCE, 25)), state)
    steps: list[Step] = []
    for stage in stages:
        steps.clear()
        try:
            driver.run(stage, steps.append)
        except NotConverged as error:
            at = steps[-1].fraction if steps else 0.0
            raise AssertionError(f"{load} of {clay} stopped at {at:.3f} of {stage.name}") from error
    return steps, len(driver.given_up)
