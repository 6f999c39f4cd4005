# SPDX-License-Identifier: MIT
"""Scene -> full model -> raw result with provenance, convergence record and cost."""

from __future__ import annotations

import json
import platform
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

import pysprings
from fe_engine.assembly import System
from fe_engine.clock import Clock
from fe_engine.errors import FEError, NotConverged
from fe_engine.linear import LinearSolver
from fe_engine.newton import Newton, Settings
from fe_engine.state import State
from fe_engine.stepping import Driver, Step
from pysprings import variables
from pysprings.build import Built, build_model, left_out
from pysprings.collect import Collector, section_dataset
from pysprings.errors import Problem, RunIncomplete, UserInputError
from pysprings.run_record import convergence_dataset, peak_memory_bytes, summarise
from pysprings.stages import dead_load_stage, path_stage

if TYPE_CHECKING:
    from pysprings.scene import Path, Scene

Progress = Callable[[str, float, str], None]


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
    interrupted: bool = False


def run(
    scene: Scene, mesh: str | None = None, progress: Progress | None = None, linear: str | None = None
) -> xr.DataTree:
    """Run the full model along all paths of a scene.

    Parameters
    ----------
    scene : what to run.
    mesh, linear : preset and linear solver instead of the scene's.
    progress : called as ``progress(path, fraction, message)``.

    Returns
    -------
    DataTree with one group per path (see `pysprings.variables`). ``attrs["status"]`` is "complete", or "partial"
    when a path did not converge to its end (with a warning), or "interrupted"; what converged is kept.
    """
    started, wall = datetime.now(UTC), time.perf_counter()
    work = _prepare(scene, mesh, progress or (lambda *_: None), linear)
    stiffness = _initial_stiffness(work)
    try:
        for path in scene.paths:
            _run_path(work, path)
    except KeyboardInterrupt:
        work.interrupted = True
    work.newton.solver.close()
    for failure in work.failures:
        warnings.warn(failure, stacklevel=2)
    record = _record(work, started, time.perf_counter() - wall)
    return _tree(work, stiffness, record)


def _prepare(scene: Scene, mesh: str | None, progress: Progress, linear: str | None) -> _Run:
    clock = Clock()
    with clock.phase("mesh"):
        progress("model", 0.0, "mesh")
        try:
            built = build_model(scene, mesh)
        except FEError as error:
            raise UserInputError([Problem(key="mesh", message=str(error))]) from error
    with clock.phase("set-up"):
        system = System(built.model, clock)
        solver = LinearSolver(linear or scene.solver.linear, system.pattern.n_free, clock)
        newton = Newton(system, solver, Settings(scene.solver.tolerance, scene.solver.max_iterations))
    progress("model", 1.0, f"{built.model.mesh.n_nodes} nodes, {system.pattern.n_free} unknowns")
    return _Run(scene, built, system, newton, clock, progress)


def _initial_stiffness(work: _Run) -> np.ndarray:
    """Tangent stiffness (3, 3) of the whole caisson at the initial state."""
    return 2.0 * work.newton.border_stiffness(State(work.built.model))


def _run_path(work: _Run, path: Path) -> None:
    """Run one path from the initial state; a path that stops early is kept up to where it converged."""
    state = State(work.built.model)
    driver = Driver(work.newton, state)
    output = work.scene.output
    collector = Collector(work.built, work.system, output.interface_fields, output.section)
    status = "complete"

    def on_step(step: Step) -> None:
        with work.clock.phase("output"):
            collector.add(state.committed, _time_of(path, step.fraction))
        message = f"step {driver.n_steps}, {step.increment.iterations} iterations"
        work.progress(path.name, step.fraction, message)

    try:
        if work.built.extra_load:
            driver.run(dead_load_stage(work.built.extra_load), lambda _: None)
        collector.add(state.committed, 0.0)
        driver.run(path_stage(work.scene, path, work.built.extra_load), on_step)
    except NotConverged as error:
        status = "partial"
        reached = driver.record[-1]["load_fraction"] if driver.record else 0.0
        work.failures.append(f"path '{path.name}' stopped on its way to {100 * reached:.1f} %: {error}")
    except KeyboardInterrupt:
        status = "interrupted"
        raise
    finally:
        if collector.rows:
            _keep(work, path, collector, driver, status)


def _keep(work: _Run, path: Path, collector: Collector, driver: Driver, status: str) -> None:
    dataset = collector.dataset()
    dataset.attrs = {"kind": path.kind, "arm_m": path.arm, "role": path.role, "status": status, "heave": path.heave}
    if path.rate is not None:
        dataset.attrs["rate_m_per_s"] = path.rate
    work.paths[f"/paths/{path.name}"] = dataset
    work.paths[f"/paths/{path.name}/convergence"] = convergence_dataset(driver.record)
    work.summaries[path.name] = {"status": status} | summarise(driver.record, dataset)


def _time_of(path: Path, fraction: float) -> float:
    """Time in s at a fraction of the path; 0 without a rate (a drained path has no time of its own)."""
    if path.rate is None or path.lateral_displacement is None:
        return 0.0
    return fraction * abs(path.lateral_displacement) / path.rate


def _record(work: _Run, started: datetime, wall: float) -> dict[str, Any]:
    """Everything that goes into run.json."""
    solver, mesh = work.newton.solver, work.built.model.mesh
    status = "interrupted" if work.interrupted else "partial" if work.failures else "complete"
    phases = {
        name: {"wall_s": round(work.clock.wall[name], 3), "cpu_s": round(work.clock.cpu[name], 3)}
        for name in work.clock.wall
    }
    return {
        "status": status,
        "failures": work.failures,
        "version": pysprings.__version__,
        "started_utc": started.isoformat(timespec="seconds"),
        "python": platform.python_version(),
        "platform": platform.platform(),
        "scene_sha256": work.scene.sha256,
        "scene_toml": work.scene.to_toml(),
        "mesh": {
            "nodes": mesh.n_nodes, "elements": mesh.n_elements, "unknowns": work.system.pattern.n_free + 3,
            "interface_stations": len(work.system.stations.area),
            "min_scaled_jacobian": work.built.quality.min_jacobian, "max_aspect": work.built.quality.max_aspect,
        },
        "solver": {
            "linear": solver.backend.name, "tolerance": work.newton.settings.tolerance,
            "factorisations": solver.n_factorisations, "solves": solver.n_solves,
            "worst_linear_residual": solver.worst_residual,
        },
        "paths": work.summaries,
        "phases": phases,
        "wall_s": round(wall, 3),
        "cpu_s": round(time.process_time(), 3),
        "peak_memory_bytes": peak_memory_bytes(),
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
        "vertical_load_N": 2.0 * (work.built.balanced_load + work.built.extra_load),
        "run_json": json.dumps(record),
    }
    groups: dict[str, Any] = {"/": root, "/section": section_dataset(work.built)} | work.paths
    return xr.DataTree.from_dict(groups, name="result")


def raise_if_incomplete(result: xr.DataTree, folder: Any = None) -> None:
    """Raise what the command line turns into exit codes 3 and 130."""
    if result.attrs["status"] == "interrupted":
        raise KeyboardInterrupt
    if result.attrs["status"] != "complete":
        failures = json.loads(result.attrs["run_json"])["failures"]
        raise RunIncomplete("; ".join(failures), folder)
