# SPDX-License-Identifier: MIT
"""Scene -> full model -> raw result with provenance, convergence record and cost."""

from __future__ import annotations

import json
import os
import platform
import warnings
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

import pysprings
from fe_engine.assembly import System
from fe_engine.clock import Clock
from fe_engine.errors import FEError, LinearSolverError, NotConverged
from fe_engine.linear import LinearSolver
from fe_engine.newton import Newton, Settings
from fe_engine.state import State, initial_fields
from fe_engine.stepping import Driver, Step
from fe_engine.water_balance import WaterBalance
from pysprings import variables
from pysprings.build import Built, build_model, left_out
from pysprings.build_water import undrained_time
from pysprings.cavitation import warning as cavitation_warning
from pysprings.collect import Collector, section_dataset
from pysprings.errors import Problem, ResourceError, RunIncomplete, UserInputError
from pysprings.progress import Progress
from pysprings.resources import refuse_what_cannot_fit
from pysprings.run_record import DEAD_LOAD, Meter, convergence_dataset, cut_back, summarise
from pysprings.small_strain import large_motion
from pysprings.stages import dead_load_stage, path_stages

if TYPE_CHECKING:
    from pysprings.scene import Path, Scene

# Largest motion of the caisson under a given load, over its diameter
_LARGEST_MOTION = 0.5


@dataclass
class _Run:
    """What the paths of one run share, and what has been computed so far."""

    scene: Scene
    built: Built
    system: System
    newton: Newton
    clock: Clock
    progress: Progress
    paths: dict[str, xr.Dataset] = field(default_factory=dict)
    summaries: dict[str, dict[str, Any]] = field(default_factory=dict)
    failures: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    interrupted: bool = False


def run(
    scene: Scene, mesh: str | None = None, progress: Progress | None = None, linear: str | None = None
) -> xr.DataTree:
    """Run the full model along all paths of a scene.

    Parameters
    ----------
    scene : what to run.
    mesh, linear : preset and linear solver instead of the scene's; the result records the scene that ran.
    progress : called as ``progress(path, fraction, message)``.

    Returns
    -------
    DataTree with one group per path (see `pysprings.variables`). ``attrs["status"]`` is "complete", or "partial"
    when a path did not converge to its end (with a warning), or "interrupted"; what converged is kept. Water that
    would cavitate at the scene's water depth is warned of.
    """
    result = compute(scene, mesh, progress, linear)
    record = json.loads(result.attrs["run_json"])
    for text in [*record["failures"], *record["warnings"]]:
        warnings.warn(text, stacklevel=2)
    return result


def compute(
    scene: Scene, mesh: str | None = None, progress: Progress | None = None, linear: str | None = None
) -> xr.DataTree:
    """Do the work of `run`, without warnings."""
    started, meter = datetime.now(UTC), Meter()
    ran = scene_to_run(scene, mesh, linear)
    refuse_what_cannot_fit(ran)
    work = _prepare(ran, meter.clock, progress or (lambda *_: None))
    stiffness = _initial_stiffness(work)
    try:
        for path in ran.paths:
            _run_path(work, path)
    except KeyboardInterrupt:
        work.interrupted = True
    work.newton.solver.close()
    record = _record(work, started)
    meter.charge(record)
    result = _tree(work, stiffness, record)
    if ran is not scene:
        result.attrs["scene_toml_given"] = scene.source_text
    return result


def scene_to_run(scene: Scene, mesh: str | None = None, linear: str | None = None) -> Scene:
    """Return the scene with another mesh preset or linear solver; the scene itself where nothing changes."""
    changed = scene
    if mesh is not None and mesh != scene.mesh.preset:
        changed = changed.replace(mesh={"preset": mesh})
    if linear is not None and linear != scene.solver.linear:
        changed = changed.replace(solver={"linear": linear})
    return changed


def _prepare(scene: Scene, clock: Clock, progress: Progress) -> _Run:
    progress("model", 0.0, "mesh")
    with clock.phase("mesh"):
        try:
            built = build_model(scene)
        except FEError as error:
            raise UserInputError([Problem(key="mesh", message=str(error))]) from error
    with clock.phase("set-up"):
        system = System(built.model, clock)
        try:
            water = built.model.water is not None
            solver = LinearSolver(scene.solver.linear, system.pattern.n_free, clock, equilibrate=water)
        except LinearSolverError as error:
            raise ResourceError(str(error)) from error
        newton = Newton(system, solver, Settings(scene.solver.tolerance, scene.solver.max_iterations))
    progress("model", 1.0, f"{built.model.mesh.n_nodes} nodes, {system.pattern.n_free} unknowns")
    return _Run(scene, built, system, newton, clock, progress)


def _initial_stiffness(work: _Run) -> np.ndarray:
    """Tangent stiffness (3, 3) of the whole caisson at the initial state; undrained where there is water."""
    work.system.time_step = undrained_time(work.scene, work.built.model.mesh)
    try:
        return 2.0 * work.newton.border_stiffness(State(work.built.model))
    except FEError as error:
        raise RunIncomplete(f"the stiffness of the initial state cannot be computed: {error}") from error


def _run_path(work: _Run, path: Path) -> None:
    """Run one path from the initial state; a path that stops early is kept up to where it converged."""
    state = State(work.built.model)
    driver = Driver(work.newton, state)
    output, extra = work.scene.output, work.built.extra_load
    water = None if work.built.model.water is None else WaterBalance(work.system, initial_fields(work.built.model))
    collector = Collector(work.built, work.system, output.interface_fields, output.section, water, _sea(work.scene))
    stages = path_stages(work.scene, path, extra, undrained_time(work.scene, work.built.model.mesh))
    status, time, done = "complete", 0.0, 0
    limits: list[str] = []

    def on_step(step: Step) -> None:
        if water is not None:
            water.advance(state.committed, step.time_step)
        limits.append(step.limit)
        if step.stage == DEAD_LOAD:
            work.progress(path.name, 0.0, DEAD_LOAD)
            return
        nonlocal time
        time += step.time_step
        _collect(work, collector, state, time)
        message = f"step {len(collector.rows) - 1}, {step.increment.iterations} iterations"
        work.progress(path.name, (done + step.fraction) / len(stages), message)
        if path.kind == "load":
            _refuse_flight(work.scene, state)

    try:
        if extra:
            driver.run(dead_load_stage(extra), on_step)
        _collect(work, collector, state, 0.0)
        for stage in stages:
            driver.run(stage, on_step)
            done += 1
    except NotConverged as error:
        status = "partial"
        work.failures.append(_failure(path, driver, error))
        if not collector.rows:  # the dead load itself: the state that it reached is kept, marked
            _collect(work, collector, state, 0.0, converged=False)
    except KeyboardInterrupt:
        status = "interrupted"
        raise
    finally:
        if collector.rows:
            _keep(work, path, collector, driver, status, limits)


def _collect(work: _Run, collector: Collector, state: State, time: float, converged: bool = True) -> None:
    with work.clock.phase("output"):
        collector.add(state.committed, time, converged)


def _refuse_flight(scene: Scene, state: State) -> None:
    """Stop a path under a given load where the caisson leaves: small displacements then make no sense."""
    u, _, rotation = state.committed.border
    reach = max(abs(u), abs(u + rotation * scene.caisson.skirt_length))
    if reach > _LARGEST_MOTION * scene.caisson.outer_diameter:
        raise NotConverged(f"the caisson has moved by {reach:.3g} m: the soil does not carry the load")


def _failure(path: Path, driver: Driver, error: NotConverged) -> str:
    """One line: which path stopped, on its way to which part of the load, where in the model and why."""
    stage, target = driver.aim
    of = " of its dead load" if stage == DEAD_LOAD else ""
    return f"path '{path.name}' stopped on its way to {100 * target:.4g} %{of}: {error}"


def _sea(scene: Scene) -> tuple[float, float] | None:
    """Unit weight (N/m3) and depth (m) of the sea, where suction is checked against cavitation."""
    drainage = scene.drainage
    return None if drainage.water_depth is None else (drainage.water_unit_weight, drainage.water_depth)


def _keep(work: _Run, path: Path, collector: Collector, driver: Driver, status: str, limits: list[str]) -> None:
    with work.clock.phase("output"):
        dataset = collector.dataset()
        dataset.attrs = {"kind": path.kind, "arm_m": path.arm, "role": path.role, "status": status, "heave": path.heave}
        if path.rate is not None:
            dataset.attrs["rate_m_per_s"] = path.rate
        if path.arm_from is not None:
            dataset.attrs["arm_from_m"] = path.arm_from
        work.paths[f"/paths/{path.name}"] = dataset
        work.paths[f"/paths/{path.name}/convergence"] = convergence_dataset(driver.record)
        work.summaries[path.name] = {"status": status} | summarise(
            driver.record, [cut_back(*attempt) for attempt in driver.given_up], dataset, limits
        )
        u, turn = (float(np.abs(dataset[name].values).max()) for name in ("u", "rotation"))
        if large := large_motion(path.name, u, turn, work.scene.caisson.skirt_length):
            work.warnings.append(large)
        if collector.cavitation is not None:
            work.warnings.append(cavitation_warning(path.name, *collector.cavitation))


def _record(work: _Run, started: datetime) -> dict[str, Any]:
    """Everything that goes into run.json but the cost."""
    solver, mesh = work.newton.solver, work.built.model.mesh
    return {
        "status": "interrupted" if work.interrupted else "partial" if work.failures else "complete",
        "failures": work.failures,
        "warnings": work.warnings,
        "version": pysprings.__version__,
        "started_utc": started.isoformat(timespec="seconds"),
        "python": platform.python_version(),
        "platform": platform.platform(),
        "scene_sha256": work.scene.sha256,
        "scene_toml": work.scene.to_toml(),
        "mesh": {
            "preset": work.scene.mesh.preset,
            "nodes": mesh.n_nodes, "elements": mesh.n_elements, "unknowns": work.system.pattern.n_free + 3,
            "interface_stations": len(work.system.stations.area),
            "min_scaled_jacobian": work.built.quality.min_jacobian, "max_aspect": work.built.quality.max_aspect,
        },
        "solver": {
            "linear": solver.backend.name, "tolerance": work.newton.settings.tolerance,
            "max_iterations": work.newton.settings.max_iterations,
            "factorisations": solver.n_factorisations, "solves": solver.n_solves,
            "worst_linear_residual": solver.worst_residual,
        },
        "paths": work.summaries,
        "left_out": [{"what": what, "why": why} for what, why in left_out(work.scene)],
    }  # fmt: skip


def _tree(work: _Run, stiffness: np.ndarray, record: dict[str, Any]) -> xr.DataTree:
    dofs = list(variables.DOFS)
    root = xr.Dataset(
        {"stiffness_initial": (("dof", "dof_conjugate"), stiffness)}, coords={"dof": dofs, "dof_conjugate": dofs}
    )
    root = variables.attach(root, "springs_root")
    scene, mesh = work.scene, work.built.model.mesh
    root.attrs = {
        "Conventions": "CF-1.11",
        "title": scene.title,
        "source": f"pysprings {pysprings.__version__}",
        "history": f"{record['started_utc']} pysprings run",
        "references": "Cerfontaine, Charlier & Collin (2018), NUMGE 2018, 1519-1528",
        "pysprings_version": pysprings.__version__,
        "scene_sha256": scene.sha256,
        "scene_toml": scene.source_text,
        "solver": record["solver"]["linear"],
        "mesh_preset": scene.mesh.preset,
        "n_nodes": mesh.n_nodes,
        "n_elements": mesh.n_elements,
        "n_unknowns": record["mesh"]["unknowns"],
        "status": record["status"],
        "drainage": scene.drainage.mode,
        "outer_diameter_m": scene.caisson.outer_diameter,
        "skirt_length_m": scene.caisson.skirt_length,
        "skirt_thickness_m": scene.caisson.skirt_thickness,
        "lid_thickness_m": scene.caisson.lid_thickness,
        "vertical_load_N": 2.0 * (work.built.balanced_load + work.built.extra_load),
        "run_json": json.dumps(record),
    }
    groups: dict[str, Any] = {"/": root, "/section": section_dataset(work.built)} | work.paths
    return xr.DataTree.from_dict(groups, name="result")


def raise_if_incomplete(result: xr.DataTree, folder: str | os.PathLike[str] | None = None) -> None:
    """Raise what the command line turns into exit codes 3 and 130."""
    if result.attrs["status"] == "interrupted":
        raise KeyboardInterrupt
    if result.attrs["status"] != "complete":
        failures = json.loads(result.attrs["run_json"])["failures"]
        raise RunIncomplete("; ".join(failures), folder)
