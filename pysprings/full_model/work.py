# SPDX-License-Identifier: MIT
"""What the paths of one run share: mesh, engine, stiffness at rest, checkpoints; and what has been computed so far."""

import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import nullcontext, suppress
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property, partial
from typing import Any, Self

import numba
import numpy as np
import scipy
import xarray as xr

from fe_engine.assembly.bordered import Residual
from fe_engine.assembly.fourier_system import FourierSystem
from fe_engine.assembly.system import System
from fe_engine.balance.water import WaterBalance
from fe_engine.clock import Clock
from fe_engine.compiled import engine_digest
from fe_engine.errors import FEError, LinearSolverError
from fe_engine.linear.backends import Backend
from fe_engine.linear.solver import LinearSolver
from fe_engine.settings import Settings
from fe_engine.solve.fourier_stage import FourierStage
from fe_engine.solve.globalisation import EXACT
from fe_engine.solve.newton import Newton
from fe_engine.solve.stage import Balance, FactorStage
from fe_engine.state import State
from pysprings.core import version
from pysprings.core.errors import ResourceError, RunIncomplete, UserInputError, refused
from pysprings.core.progress import Progress
from pysprings.core.words import StopReason
from pysprings.full_model.checkpoint import Checkpoints, Cost, Loaded, Saved, scene_identity
from pysprings.full_model.collect import Collector, section_dataset
from pysprings.full_model.fourier_collect import FourierCollector, SpaceCollector, fourier_section_dataset
from pysprings.full_model.run_record import PathFigures
from pysprings.full_model.volume import FourierVolume, Volume
from pysprings.model.build import Built
from pysprings.model.contact import penalty_of
from pysprings.model.forecast.domain_effect import domain_effect
from pysprings.model.fourier import BuiltFourier, build, build_fourier, build_torsion
from pysprings.model.stages import fast_paths
from pysprings.model.water import undrained_time
from pysprings.scene.model import Scene
from pysprings.scene.sections import Path

_ROUNDING = 1e-5  # share of the stiffness by which a linear solver may leave it unsymmetric


@dataclass
class Whole:
    """The whole caisson in six degrees of freedom; stiffness (6, 6) at the initial state."""

    scene: Scene
    clock: Clock
    built: BuiltFourier
    stiffness: np.ndarray

    @cached_property
    def newton(self) -> Newton:
        """What solves it, made where a path runs."""
        with self.clock.phase("set-up"):
            return newton_of(self.scene, self.built, self.clock)

    @property
    def system(self) -> FourierSystem:
        """The system that Newton solves."""
        assert isinstance(self.newton.system, FourierSystem)
        return self.newton.system


@dataclass
class Work:
    """A run on its way.

    paths, figures : datasets by group of the result, and figures by path, of the paths that have ended.
    failures, warnings : sentences for the record.
    stopped : why the run ended before its paths did.
    condition : estimate of the condition of the last matrix.
    stiffness : (3, 3) of half the caisson at the initial state; torsion : of the whole one [N m/rad], NaN where it
        cannot be computed.
    state : of the path that ran last.
    under_dead_load : where paths stand under it, by whether they leave the plane and by its load beyond what the stress
        at rest carries (N).
    cpu_elsewhere : CPU seconds of earlier parts of the run, and of other processes; ``cpu_began`` those of this process
        before the run.
    """

    scene: Scene
    built: Built | BuiltFourier
    newton: Newton
    clock: Clock
    progress: Progress
    checkpoints: Checkpoints | None = None
    paths: dict[str, xr.Dataset] = field(default_factory=dict)
    figures: dict[str, PathFigures] = field(default_factory=dict)
    failures: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    stopped: StopReason | None = None
    condition: float | None = None
    stiffness: np.ndarray = field(default_factory=lambda: np.zeros((3, 3)))
    torsion: float = float("nan")
    state: State | None = None
    under_dead_load: dict[tuple[bool, float], Saved] = field(default_factory=dict)
    cpu_elsewhere: float = 0.0
    cpu_began: float = field(default_factory=time.process_time)
    _whole: Whole | None = None

    def model_of(self, path: Path) -> Self | Whole:
        """Return the model on which a path runs: half a caisson, or the whole one, made for the first that needs it."""
        if not path.in_space:
            return self
        if self._whole is None:
            from pysprings.macro.stiffness import axisymmetric

            with self.clock.phase("set-up"):
                built = build_fourier(self.scene, whole=True)
            self._whole = Whole(self.scene, self.clock, built, axisymmetric(2.0 * self.stiffness, torsion=self.torsion))
        return self._whole

    @property
    def system(self) -> System | FourierSystem:
        """The system that Newton solves."""
        return self.newton.system

    @property
    def vertical_load(self) -> float:
        """Vertical load of the whole caisson in N, positive down; the number behind "balanced"."""
        return 2.0 * (self.built.balanced_load + self.built.extra_load)

    def cost(self) -> Cost:
        """Return the cost of all that this run has counted so far."""
        whole = [] if self._whole is None or "newton" not in vars(self._whole) else [self._whole.newton]
        solvers = [each.solver for each in (self.newton, *whole)]
        saved = self.checkpoints
        written, spent = (0, 0.0) if saved is None else (saved.written, saved.spent)
        return Cost(
            dict(self.clock.wall), dict(self.clock.cpu), self.cpu_elsewhere + time.process_time() - self.cpu_began,
            sum(each.n_factorisations for each in solvers), sum(each.n_solves for each in solvers),
            max(each.worst_residual for each in solvers), written, spent, self.condition,
        )  # fmt: skip

    def add(self, cost: Cost) -> None:
        """Count what was computed before this part of the run, or in another process."""
        for total, part in ((self.clock.wall, cost.wall), (self.clock.cpu, cost.cpu)):
            for phase, seconds in part.items():
                total[phase] = total.get(phase, 0.0) + seconds
        solver = self.newton.solver
        solver.n_factorisations += cost.factorisations
        solver.n_solves += cost.solves
        solver.worst_residual = max(solver.worst_residual, cost.worst)
        self.cpu_elsewhere += cost.cpu_s
        if self.checkpoints is not None:
            self.checkpoints.written += cost.checkpoints
            self.checkpoints.spent += cost.spent

    def take_up(self, resume: bool | None, started: str) -> Loaded:
        """Return what is known before the first path: the initial stiffness, and what checkpoints hold."""
        checkpoints, loaded = self.checkpoints, Loaded()
        if checkpoints is not None:
            checkpoints.identity, checkpoints.environment = self._identity(), environment_of(self.newton.solver.backend)
            with nullcontext() if resume else suppress(UserInputError):
                loaded = checkpoints.load() if resume is not False else loaded
            self.warnings += differences(loaded.environments, checkpoints.environment)
            self.warnings += [f"checkpoint {text}; what it held is computed again" for text in loaded.damaged]
            if loaded.any:
                checkpoints.resumed.append({"at_utc": started, "from": loaded.place})
        if loaded.shared is None:
            stiffness, (torsion, lacking) = self._initial_stiffness(), self._initial_torsion()
            about = {"started_utc": started, "harmonics": self.scene.mesh.harmonics, "cost": asdict(self.cost())}
            arrays = {"stiffness": stiffness, "torsion": np.array(torsion)}
            loaded.shared = Saved(about | {"torsion_lacks": lacking}, arrays)
            if checkpoints is not None:
                with self.clock.phase("checkpoint"):
                    checkpoints.begin(loaded.shared, anew=not loaded.paths)
        else:
            self.add(Cost(**loaded.shared.meta["cost"]))
        self.stiffness = loaded.shared.arrays["stiffness"]
        self.torsion = float(loaded.shared.arrays["torsion"])
        self.warnings += loaded.shared.meta["torsion_lacks"]
        return loaded

    def _identity(self) -> dict[str, str]:
        """Return the properties, by name, that must be the same for an interrupted run to go on."""
        return {
            "mesh": self.scene.mesh.preset,
            "linear solver": self.newton.solver.backend.name,
            "version of pysprings": version.__version__,
            "engine": f"sha256 {engine_digest()}",
            "scene": scene_identity(self.scene.sha256),
        }

    def _initial_stiffness(self) -> np.ndarray:
        """Return the tangent stiffness (3, 3) of half the caisson at rest; undrained where there is water."""
        self.system.time_step, self.system.sealed = undrained_time(self.scene, self.built.model.mesh), True
        try:
            return symmetric_but_for_rounding(self.newton.border_stiffness(State(self.built.model)))
        except FEError as error:
            raise RunIncomplete(f"the stiffness of the initial state cannot be computed: {error}") from error
        finally:
            self.system.sealed = False

    def _initial_torsion(self) -> tuple[float, list[str]]:
        """Return the torsional stiffness of the whole caisson at rest [N m/rad], without water: no volume changes.

        Where it cannot be computed (bricks in a geometry that has no section), NaN and a sentence on it.
        """
        try:
            with self.clock.phase("set-up"):
                system = FourierSystem(build_torsion(self.scene).model, self.clock)
            stage, twist = FourierStage(system, self.clock), np.eye(6)[-1]
            return float(twist @ stage.border_forces(system.tangent_at_rest(), twist)), []
        except FEError as error:
            return float("nan"), [f"the torsional stiffness cannot be computed, and stands nowhere: {error}"]


def prepare(scene: Scene, clock: Clock, progress: Progress) -> Work:
    """Return the work of a scene before its first path: mesh and engine."""
    progress("model", 0.0, "mesh")
    with clock.phase("mesh"):
        try:
            built = build(scene)
        except FEError as error:
            raise refused("mesh", str(error)) from error
    with clock.phase("set-up"):
        try:
            newton = newton_of(scene, built, clock)
        except LinearSolverError as error:
            raise ResourceError(str(error)) from error
    unknowns = newton.system.pattern.n_unknowns + built.model.n_border
    progress("model", 1.0, f"{built.model.mesh.n_nodes} nodes, {unknowns} unknowns")
    remarks = [*domain_effect(scene).remarks, *penalty_of(scene).remarks, *fast_paths(scene, built.model.mesh)]
    return Work(scene, built, newton, clock, progress, warnings=remarks)


def symmetric_but_for_rounding(stiffness: np.ndarray) -> np.ndarray:
    """Return the symmetric part of a stiffness (nb, nb) that differs from it by rounding alone; others as they are.

    At rest contact sticks and the soil is elastic: what is not symmetric is what the linear solver leaves.
    """
    mean: np.ndarray = 0.5 * (stiffness + stiffness.T)
    size = np.sqrt(np.abs(np.diag(mean)))
    rounding = bool((np.abs(stiffness - mean) <= _ROUNDING * np.outer(size, size)).all())
    return mean if rounding else stiffness


# --- what computes ---

Environment = dict[str, str]


def environment_of(backend: Backend) -> Environment:
    """Return versions and numbers of threads by name, as run.json and checkpoints hold them."""
    return {
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "numba": numba.__version__,
        "threads of numba": str(numba.get_num_threads()),
        **backend.versions(),
    }


def differences(before: Iterable[Mapping[str, str]], now: Mapping[str, str]) -> list[str]:
    """Return a sentence on each environment, of parts of a run, that was another than that of ``now``."""
    texts = []
    for other in before:
        names = [name for name in {**other, **now} if other.get(name) != now.get(name)]
        if names:
            changes = ", ".join(f"{name} {other.get(name, 'unknown')} (here {now.get(name, 'none')})" for name in names)
            texts.append(f"a part of this run was computed with {changes}: last digits may differ from a run in one go")
    return list(dict.fromkeys(texts))


# --- one factorisation and solve, timed ---

REPEATS = 3
_LOOSE = 1.0e9  # share of a residual that no iteration is needed for


def factorise_and_solve_seconds(newton: Newton, state: State) -> float:
    """Return the wall time [s] of factorising the tangent at a committed state and solving as an iteration does.

    The median of three, without assembly and symbolic analysis. Time step as in the last increment.
    """
    state.reset_trial()
    _, linear, tangent = newton.system.linearise(state, True)
    if isinstance(newton.stage, FactorStage):
        newton.close()
        once: Callable[[], object] = partial(_factorise_and_solve, newton.stage, linear, tangent)
    else:
        still = Balance(np.eye(len(newton.scale)), np.eye(len(newton.scale)), *3 * [newton.scale])
        once = partial(newton.stage.step, linear, tangent, still, _LOOSE, True)
    once()  # analyses the pattern
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        once()
        times.append(time.perf_counter() - start)
    return float(np.median(times))


def _factorise_and_solve(stage: FactorStage, linear: Residual, tangent: Any) -> None:
    stage.solver.factorise(tangent.matrix)
    stage.solver.solve(np.column_stack([-linear.free, tangent.columns]))


def newton_of(scene: Scene, built: Built | BuiltFourier, clock: Clock) -> Newton:
    """Return what solves the system of a built model. Raises LinearSolverError."""
    settings = Settings(scene.solver.tolerance, scene.solver.max_iterations)
    if isinstance(built, BuiltFourier):
        series = FourierSystem(built.model, clock)
        return Newton(series, FourierStage(series, clock), settings)
    bricks = System(built.model, clock)
    wet, symmetric = built.model.water is not None, built.model.symmetric
    solver = LinearSolver(scene.solver.linear, bricks.pattern.n_free, clock, wet, symmetric)
    if scene.drainage.mode == "undrained":  # volumes hardly change: a small residual does not bound the pressures
        settings = replace(settings, shares=(EXACT, EXACT))
    return Newton(bricks, solver, settings)


def make_collector(
    scene: Scene, on: Work | Whole, balance: WaterBalance | None = None, sea: tuple[float, float] | None = None
) -> Collector | SpaceCollector:
    """Make what gathers the rows of a path on its model."""
    output, built = scene.output, on.built
    requested = output.interface_fields, output.section
    wet = partial(scene.ground.holds_water, mode=scene.drainage.mode)
    if isinstance(built, BuiltFourier):
        if built.model.whole:
            return SpaceCollector(built, lambda: on.system, output.interface_fields, sea)
        assert isinstance(on.system, FourierSystem)
        return FourierCollector(built, on.system, *requested, balance, sea, output.paraview, wet)
    assert isinstance(on.system, System)
    return Collector(built, on.system, *requested, balance, sea, output.paraview, wet)


def section_of(built: Built | BuiltFourier) -> xr.Dataset:
    """Return the symmetry plane of the mesh."""
    return fourier_section_dataset(built) if isinstance(built, BuiltFourier) else section_dataset(built)


def volume_of(built: Built | BuiltFourier) -> xr.Dataset:
    """Return nodes and cells of the whole half model."""
    return (FourierVolume if isinstance(built, BuiltFourier) else Volume)(built).dataset()
