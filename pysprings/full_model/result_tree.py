# SPDX-License-Identifier: MIT
"""What a run leaves in memory: its record, and its datasets as one tree with provenance."""

import math
import os
import platform
from typing import Any

import xarray as xr

from pysprings.core import variables, version
from pysprings.core.errors import ResourceError, RunIncomplete, TargetMissed
from pysprings.core.words import StopReason
from pysprings.full_model.checkpoint import Loaded
from pysprings.full_model.run_record import CheckpointCost, Computed, MeshFigures, RunRecord, SolverFigures, Status
from pysprings.full_model.work import Work, environment_of, section_of, volume_of
from pysprings.model.contact import defaults_of
from pysprings.model.forecast.omissions import left_out
from pysprings.model.fourier import BuiltFourier
from pysprings.scene.defaults import defaulted_text, remarks
from pysprings.springs.checks import RESULT


def record_of(work: Work, loaded: Loaded) -> RunRecord:
    """Return everything that goes into run.json but the cost of this part of the run."""
    assert loaded.shared is not None
    return RunRecord(
        status=Status.INTERRUPTED if work.stopped else Status.PARTIAL if work.failures else Status.COMPLETE,
        stopped_by=work.stopped,
        failures=work.failures,
        warnings=work.warnings,
        version=version.__version__,
        schema=RESULT,
        started_utc=loaded.shared.meta["started_utc"],
        resumed=[] if work.checkpoints is None else work.checkpoints.resumed,
        python=platform.python_version(),
        platform=platform.platform(),
        environment=environment_of(work.newton.solver.backend),
        scene_sha256=work.scene.sha256,
        ranges_sha256=work.scene.ranges_sha256,
        scene_toml=work.scene.to_toml(),
        mesh=_mesh(work),
        solver=_solver(work),
        paths=work.figures,
        left_out=[omission.record() for omission in left_out(work.scene)],
        defaulted=defaults_of(work.scene, work.vertical_load),
        remarks=remarks(work.scene),
        checkpoints=_checkpoints(work),
        stiffness_initial=_stiffness(work),
        wall_s=loaded.elapsed,
        cpu_s=work.cpu_elsewhere,
    )


def _stiffness(work: Work) -> dict[str, Any]:
    """Return the stiffness of the whole caisson at rest."""
    torsion = work.torsion if math.isfinite(work.torsion) else None
    matrix = (2.0 * work.stiffness).tolist()
    return {"dofs": list(variables.DOFS), "matrix": matrix, variables.TORSION: torsion}


def _mesh(work: Work) -> MeshFigures:
    built, mesh = work.built, work.built.model.mesh
    series = {}
    if isinstance(built, BuiltFourier):
        model = built.model
        series = {"harmonics": model.harmonics, "azimuths": model.azimuths, "contact_azimuths": len(built.azimuth)}
    return MeshFigures(
        preset=work.scene.mesh.preset,
        discretisation=work.scene.discretisation,
        nodes=mesh.n_nodes,
        elements=mesh.n_elements,
        unknowns=work.system.pattern.n_unknowns + 3,
        steel_elements=0 if built.steel is None else built.steel.n_elements,
        interface_stations=len(work.system.stations.area),
        min_scaled_jacobian=built.quality.min_jacobian,
        max_aspect=built.quality.max_aspect,
        **series,
    )


def _solver(work: Work) -> SolverFigures:
    solver, settings, cost = work.newton.solver, work.newton.settings, work.cost()
    return SolverFigures(
        linear=solver.backend.name,
        tolerance=settings.tolerance,
        max_iterations=settings.max_iterations,
        factorisations=cost.factorisations,
        solves=cost.solves,
        worst_linear_residual=cost.worst,
        condition_estimate=work.condition,
    )


def _checkpoints(work: Work) -> CheckpointCost | None:
    """Return the cost of the checkpoints of all parts of the run; None where there are none."""
    if work.checkpoints is None:
        return None
    spent, wall = work.checkpoints.spent, work.checkpoints.elapsed
    return CheckpointCost(work.checkpoints.written, round(spent, 3), round(spent / wall, 4))


def tree_of(work: Work, record: RunRecord) -> xr.DataTree:
    """Return the result with its provenance, without the record itself."""
    axes = "dof", "dof_conjugate"
    data = {"stiffness_initial": (axes, 2.0 * work.stiffness)}
    root = variables.attach(xr.Dataset(data, {axis: list(variables.DOFS) for axis in axes}), "springs_root")
    scene, mesh = work.scene, work.built.model.mesh
    root.attrs = {
        "Conventions": "CF-1.11",
        "schema": RESULT,
        "title": scene.title,
        "source": f"pysprings {version.__version__}",
        "history": f"{record.started_utc} pysprings run",
        "references": "Cerfontaine, Charlier & Collin (2018), NUMGE 2018, 1519-1528",
        "pysprings_version": version.__version__,
        "scene_sha256": scene.sha256,
        "scene_toml": scene.source_text,
        "solver": record.solver.linear,
        "mesh_preset": scene.mesh.preset,
        "discretisation": scene.discretisation,
        **({} if record.mesh.harmonics is None else {"harmonics": record.mesh.harmonics}),
        "n_nodes": mesh.n_nodes,
        "n_elements": mesh.n_elements,
        "n_unknowns": record.mesh.unknowns,
        "status": str(record.status),
        "drainage": scene.layer_drainage,
        "outer_diameter_m": scene.caisson.outer_diameter,
        "skirt_length_m": scene.caisson.skirt_length,
        "skirt_thickness_m": scene.caisson.skirt_thickness,
        "lid_thickness_m": scene.caisson.lid_thickness,
        "caisson_behaviour": scene.caisson.behaviour,
        "limit_displacement_over_diameter": scene.limit.displacement_over_diameter,
        "limit_rotation_rad": scene.limit.rotation,
        "vertical_load_N": work.vertical_load,
        **({variables.TORSION: work.torsion} if math.isfinite(work.torsion) else {}),
        "defaulted": defaulted_text(record.defaulted, numerical=False),
        "remarks": "; ".join(record.remarks),
    }
    groups: dict[str, Any] = {"/": root, "/section": section_of(work.built)} | work.paths
    if scene.output.paraview:
        groups["/volume"] = volume_of(work.built)
    return xr.DataTree.from_dict(groups, name="result")


def raise_if_incomplete(result: Computed, folder: str | os.PathLike[str] | None = None) -> None:
    """Raise what the command line turns into exit codes 3, 4 and 130.

    Raises RunIncomplete, ResourceError, KeyboardInterrupt: a path stopped, or the estimate is above the target error;
    memory was used up; the run, or what follows its results, was interrupted.
    """
    record = result.record
    if record.stopped_by is StopReason.OUT_OF_MEMORY:
        where = "" if folder is None else f"; what converged is kept in {folder}, --resume goes on from there"
        raise ResourceError(f"{record.failures[-1]}; try a smaller mesh (`pysprings check` estimates){where}")
    if result.interrupted or StopReason.INTERRUPTED in record.not_made.values():
        raise KeyboardInterrupt
    if record.status is not Status.COMPLETE:
        raise RunIncomplete("; ".join(record.failures), folder, record.reasons)
    if missed := (record.target_error or {}).get("missed"):
        raise TargetMissed(missed, folder)
