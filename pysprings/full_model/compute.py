# SPDX-License-Identifier: MIT
"""Scene -> full model -> raw result with provenance, convergence record and cost."""

from __future__ import annotations

import json
import os
import platform
import warnings
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from fe_engine.clock import Clock
from fe_engine.compiled import engine_digest
from fe_engine.errors import FEError, LinearSolverError
from fe_engine.state import State
from pysprings.core import variables, version
from pysprings.core.errors import Problem, ResourceError, RunIncomplete, UserInputError, out_of_memory
from pysprings.core.files.layout import is_unfinished, refuse_links
from pysprings.core.files.lock import exclusive, new_folder
from pysprings.core.progress import Progress
from pysprings.core.stop_reasons import StopReason
from pysprings.core.threads import blas_on_one_thread
from pysprings.full_model.accuracy.own_estimate import add_estimate, was_interrupted
from pysprings.full_model.cavitation import warning as cavitation_warning
from pysprings.full_model.checkpoint import Checkpoints, Loaded, Saved, scene_identity
from pysprings.full_model.discretise import make_engine, section_of, volume_of
from pysprings.full_model.environment import differences, environment_of
from pysprings.full_model.path_run import PathRun, Work
from pysprings.full_model.record import (
    Meter,
    convergence_dataset,
    cut_back,
    energy_summary,
    summarise,
)
from pysprings.full_model.unit_time import factorise_and_solve_seconds
from pysprings.model.discretise import build
from pysprings.model.forecast.domain_effect import domain_effect
from pysprings.model.forecast.omissions import left_out
from pysprings.model.forecast.resources import refuse_what_cannot_fit
from pysprings.model.forecast.small_strain import large_motion
from pysprings.model.fourier import BuiltFourier
from pysprings.model.penalty import penalty_of
from pysprings.model.water import undrained_time
from pysprings.springs.path_ends import end_attrs

if TYPE_CHECKING:
    from pysprings.scene.load import Scene

# why a run has ended before its paths did (`stopped_by` in run.json)
INTERRUPTED, OUT_OF_MEMORY = StopReason.INTERRUPTED, StopReason.OUT_OF_MEMORY


def run(
    scene: Scene, mesh: str | None = None, progress: Progress | None = None, linear: str | None = None,
    checkpoint: str | os.PathLike[str] | None = None, estimate_error: bool = False,
) -> xr.DataTree:  # fmt: skip
    """Run the full model along all paths of a scene.

    Parameters
    ----------
    scene : what to run.
    mesh, linear : preset and linear solver instead of the scene's; the result records the scene that ran.
    progress : called as ``progress(path, fraction, message)``.
    checkpoint : folder for checkpoints. Where one holds those of this very run, stopped, it goes on from them; they are
        removed when it has ended.
    estimate_error : run the scene on a coarser mesh, too, and put an estimate of the discretisation error into the
        record (`pysprings.full_model.accuracy.two_mesh`).

    Returns
    -------
    DataTree with one group per path (see `pysprings.core.variables`). ``attrs["status"]`` is "complete", or "partial"
    when a path did not converge to its end (with a warning), or "interrupted"; what converged is kept. Water that
    would cavitate at the scene's water depth is warned of.
    """
    if estimate_error and scene.mesh.discretisation != "hex8":
        raise UserInputError([Problem(key="mesh.discretisation", message='errors are estimated for "hex8" alone')])
    if checkpoint is None:
        result = compute(scene, mesh, progress, linear)
    else:
        result = _compute_in(FilePath(checkpoint), scene, mesh, progress, linear)
    if estimate_error and result.attrs["status"] != INTERRUPTED:
        add_estimate(scene_to_run(scene, mesh, linear), result, compute, progress)
        if was_interrupted(result):
            raise KeyboardInterrupt
    record = json.loads(result.attrs["run_json"])
    for text in [*record["failures"], *record["warnings"]]:
        warnings.warn(text, stacklevel=2)
    return result


def _compute_in(
    folder: FilePath, scene: Scene, mesh: str | None, progress: Progress | None, linear: str | None
) -> xr.DataTree:
    """Compute with checkpoints in a folder, from those that it holds."""
    with new_folder(folder), exclusive(folder):
        refuse_links(folder)
        checkpoints = Checkpoints(folder)
        result = compute(scene, mesh, progress, linear, checkpoints, resume=is_unfinished(folder))
        if result.attrs["status"] != "interrupted":
            checkpoints.remove()
    return result


def compute(
    scene: Scene, mesh: str | None = None, progress: Progress | None = None, linear: str | None = None,
    checkpoints: Checkpoints | None = None, resume: bool = False, time_unit: bool = False,
) -> xr.DataTree:  # fmt: skip
    """Do the work of `run`, without warnings; leave checkpoints where they are given, and go on from them.

    The checkpoints stay when the paths have ended: whoever has saved the result removes them. ``time_unit`` also
    measures one factorisation and solve of the last tangent (solver.unit_s of the record); the peak of the memory
    before that is solver.peak_before_unit_bytes.
    """
    with blas_on_one_thread():
        return _compute(scene, mesh, progress, linear, checkpoints, resume, time_unit)


def _compute(
    scene: Scene, mesh: str | None, progress: Progress | None, linear: str | None,
    checkpoints: Checkpoints | None, resume: bool, time_unit: bool,
) -> xr.DataTree:  # fmt: skip
    started, meter = datetime.now(UTC).isoformat(timespec="seconds"), Meter()
    ran = scene_to_run(scene, mesh, linear)
    refuse_what_cannot_fit(ran)
    work = _prepare(ran, meter.clock, progress or (lambda *_: None))
    work.checkpoints = checkpoints
    loaded = _take_up(work, started, resume)
    try:
        _run_paths(work, loaded)
    except KeyboardInterrupt:
        work.stopped = INTERRUPTED
    except MemoryError as error:
        work.stopped = OUT_OF_MEMORY
        work.failures.append(out_of_memory(error))
    if work.condition is None:
        work.condition = work.newton.condition_estimate()
    record = _record(work, loaded)
    meter.charge(record)
    if time_unit and not work.stopped:
        record["solver"]["peak_before_unit_bytes"] = record["peak_memory_bytes"]
        with suppress(FEError, MemoryError):  # the run is worth more than its unit
            record["solver"]["unit_s"] = factorise_and_solve_seconds(work.newton, work.state or State(work.built.model))
    work.newton.close()
    result = _tree(work, record)
    if ran is not scene:
        result.attrs["scene_toml_given"] = scene.source_text
    return result


def _take_up(work: Work, started: str, resume: bool) -> Loaded:
    """Return what is known before the first path: the initial stiffness, and what checkpoints hold."""
    checkpoints, loaded = work.checkpoints, Loaded()
    if checkpoints is not None:
        checkpoints.identity, checkpoints.environment = _identity(work), environment_of(work.newton.solver.backend)
        loaded = checkpoints.load() if resume else loaded
        work.warnings += differences(loaded.environments, checkpoints.environment)
    if loaded.newest is not None:
        work.go_on_from(loaded.newest.meta["cost"])
        work.resumed.append({"at_utc": started, "from": loaded.place})
        work.warnings += [f"checkpoint {text}; what it held is computed again" for text in loaded.damaged]
    if loaded.shared is None:
        loaded.shared = Saved({"started_utc": started}, {"stiffness": _initial_stiffness(work)})
        if checkpoints is not None:
            with work.clock.phase("checkpoint"):
                checkpoints.begin(loaded.shared, anew=not resume)
    work.stiffness = loaded.shared.arrays["stiffness"]
    return loaded


def _identity(work: Work) -> dict[str, str]:
    """What has to be the same for an interrupted run to go on."""
    return {
        "mesh": work.scene.mesh.preset,
        "linear solver": work.newton.solver.backend.name,
        "version of pysprings": version.__version__,
        "engine": f"sha256 {engine_digest()}",
        "scene": scene_identity(work.scene.sha256),
    }


def scene_to_run(scene: Scene, mesh: str | None = None, linear: str | None = None) -> Scene:
    """Return the scene with another mesh preset or linear solver; the scene itself where nothing changes."""
    changed = scene
    if mesh is not None and mesh != scene.mesh.preset:
        changed = changed.replace(mesh={"preset": mesh})
    if linear is not None and linear != scene.solver.linear:
        changed = changed.replace(solver={"linear": linear})
    return changed


def _prepare(scene: Scene, clock: Clock, progress: Progress) -> Work:
    progress("model", 0.0, "mesh")
    with clock.phase("mesh"):
        try:
            built = build(scene)
        except FEError as error:
            raise UserInputError([Problem(key="mesh", message=str(error))]) from error
    with clock.phase("set-up"):
        try:
            engine = make_engine(scene, built, clock)
        except LinearSolverError as error:
            raise ResourceError(str(error)) from error
    progress("model", 1.0, f"{built.model.mesh.n_nodes} nodes, {engine.system.pattern.n_unknowns} unknowns")
    remarks = [*domain_effect(scene).remarks, *penalty_of(scene).remarks]
    return Work(scene, built, engine.system, engine.newton, clock, progress, warnings=remarks)


def _initial_stiffness(work: Work) -> np.ndarray:
    """Tangent stiffness (3, 3) of half the caisson at the initial state; undrained where there is water."""
    work.system.time_step = undrained_time(work.scene, work.built.model.mesh)
    try:
        return work.newton.border_stiffness(State(work.built.model))
    except FEError as error:
        raise RunIncomplete(f"the stiffness of the initial state cannot be computed: {error}") from error


def _run_paths(work: Work, loaded: Loaded) -> None:
    """Run every path that has not ended; the one on its way goes on from where it stood."""
    for number, path in enumerate(work.scene.paths):
        run = PathRun(work, path)
        ended, state = loaded.paths.get(path.name), loaded.state
        if ended is not None:
            run.restore(ended)
            _keep(work, run)
            continue
        if state is not None and state.meta["path"] == path.name:
            run.restore(state)
        work.state = run.state
        try:
            run.run()
        finally:
            if run.collector.rows:
                _keep(work, run)
        work.condition = work.newton.condition_estimate() if path is work.scene.paths[-1] else None
        run.save_end(number)


def _keep(work: Work, run: PathRun) -> None:
    """Add a path, whole or as far as it went, to the result."""
    path, driver, name = run.path, run.driver, run.path.name
    with work.clock.phase("output"):
        dataset = run.collector.dataset()
        dataset.attrs = {
            "kind": path.kind, "arm_m": path.arm, "role": path.role, "status": run.status, "heave": path.heave,
        } | end_attrs(run.reason, run.why, dataset)  # fmt: skip
        if path.rate is not None:
            dataset.attrs["rate_m_per_s"] = path.rate
        if path.arm_from is not None:
            dataset.attrs["arm_from_m"] = path.arm_from
        work.paths[f"/paths/{name}"] = dataset
        work.paths[f"/paths/{name}/convergence"] = convergence_dataset(driver.record)
        work.summaries[name] = (
            {"status": run.status, **({} if run.reason is None else {"reason": run.reason})}
            | summarise(driver.record, [cut_back(*attempt) for attempt in driver.given_up], dataset, run.limits)
            | {"energy": energy_summary(run.energy.now())}
        )
        work.failures += [run.failure] if run.failure else []
        u, w, turn = (float(np.abs(dataset[key].values).max()) for key in ("u", "w", "rotation"))
        if large := large_motion(name, max(u, w), turn, work.scene.caisson.skirt_length):
            work.warnings.append(large)
        if run.collector.cavitation is not None:
            work.warnings.append(cavitation_warning(name, *run.collector.cavitation))


def _record(work: Work, loaded: Loaded) -> dict[str, Any]:
    """Everything that goes into run.json but the cost of this part of the run."""
    assert loaded.shared is not None
    solver, mesh = work.newton.solver, work.built.model.mesh
    return {
        "status": "interrupted" if work.stopped else "partial" if work.failures else "complete",
        "stopped_by": work.stopped or None,
        "failures": work.failures,
        "warnings": work.warnings,
        "version": version.__version__,
        "started_utc": loaded.shared.meta["started_utc"],
        "resumed": work.resumed,
        "python": platform.python_version(),
        "platform": platform.platform(),
        "environment": environment_of(solver.backend),
        "scene_sha256": work.scene.sha256,
        "scene_toml": work.scene.to_toml(),
        "mesh": {
            "preset": work.scene.mesh.preset, "discretisation": work.scene.mesh.discretisation, **_series(work),
            "nodes": mesh.n_nodes, "elements": mesh.n_elements, "unknowns": work.system.pattern.n_unknowns + 3,
            "steel_elements": 0 if work.built.steel is None else len(work.built.steel.hexes),
            "interface_stations": len(work.system.stations.area),
            "min_scaled_jacobian": work.built.quality.min_jacobian, "max_aspect": work.built.quality.max_aspect,
        },
        "solver": {
            "linear": solver.backend.name, "tolerance": work.newton.settings.tolerance,
            "max_iterations": work.newton.settings.max_iterations,
            "factorisations": solver.n_factorisations, "solves": solver.n_solves,
            "worst_linear_residual": solver.worst_residual,
            "condition_estimate": work.condition,
        },
        "paths": work.summaries,
        "left_out": [omission.record() for omission in left_out(work.scene)],
        **_cost_before(work, loaded),
    }  # fmt: skip


def _series(work: Work) -> dict[str, int]:
    """Highest harmonic and numbers of azimuths of a Fourier model; nothing of bricks."""
    if not isinstance(work.built, BuiltFourier):
        return {}
    model = work.built.model
    return {"harmonics": model.harmonics, "azimuths": model.azimuths, "contact_azimuths": len(work.built.azimuth)}


def _cost_before(work: Work, loaded: Loaded) -> dict[str, Any]:
    """What the parts of the run before this one took, and the checkpoints of all parts."""
    if work.checkpoints is None:
        return {}
    before = {} if loaded.newest is None else {key: loaded.newest.meta["cost"][key] for key in ("wall_s", "cpu_s")}
    spent, wall = work.checkpoints.spent, work.checkpoints.elapsed()["wall_s"]
    cost = {"written": work.checkpoints.written, "wall_s": round(spent, 3), "share_of_wall": round(spent / wall, 4)}
    return before | {"checkpoints": cost}


def _tree(work: Work, record: dict[str, Any]) -> xr.DataTree:
    dofs, stiffness = list(variables.DOFS), 2.0 * work.stiffness
    root = xr.Dataset(
        {"stiffness_initial": (("dof", "dof_conjugate"), stiffness)}, coords={"dof": dofs, "dof_conjugate": dofs}
    )
    root = variables.attach(root, "springs_root")
    scene, mesh = work.scene, work.built.model.mesh
    root.attrs = {
        "Conventions": "CF-1.11",
        "title": scene.title,
        "source": f"pysprings {version.__version__}",
        "history": f"{record['started_utc']} pysprings run",
        "references": "Cerfontaine, Charlier & Collin (2018), NUMGE 2018, 1519-1528",
        "pysprings_version": version.__version__,
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
        "caisson_behaviour": scene.caisson.behaviour,
        "vertical_load_N": 2.0 * (work.built.balanced_load + work.built.extra_load),
        "run_json": json.dumps(record),
    }
    groups: dict[str, Any] = {"/": root, "/section": section_of(work.built)} | work.paths
    if scene.output.paraview:
        groups["/volume"] = volume_of(work.built)
    return xr.DataTree.from_dict(groups, name="result")


def raise_if_incomplete(result: xr.DataTree, folder: str | os.PathLike[str] | None = None) -> None:
    """Raise what the command line turns into exit codes 3, 4 and 130."""
    record = json.loads(result.attrs["run_json"])
    if record["stopped_by"] == OUT_OF_MEMORY:
        kept = "" if folder is None else f"; what converged is kept in {folder}, --resume goes on from there"
        raise ResourceError(f"{record['failures'][-1]}; try a smaller mesh (`pysprings check` estimates){kept}")
    if result.attrs["status"] == "interrupted":
        raise KeyboardInterrupt
    if result.attrs["status"] != "complete":
        reasons = [StopReason(path["reason"]) for path in record["paths"].values() if "reason" in path]
        raise RunIncomplete("; ".join(record["failures"]), folder, reasons)
