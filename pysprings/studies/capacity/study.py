# SPDX-License-Identifier: MIT
"""The whole study in a folder: runs, envelope of both models, tables, picture, page."""

import math
import os
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pysprings.core import version
from pysprings.core.columns import records
from pysprings.core.errors import PyspringsError, RunIncomplete, following, refused
from pysprings.core.progress import Progress
from pysprings.core.storage import read_tree, remove_leftovers, write_text
from pysprings.core.tables.load_cases import LoadCases
from pysprings.core.text import json_text, with_prefix
from pysprings.core.words import RANGE_END
from pysprings.core.written import exclusive, new_folder, own_folder
from pysprings.full_model.accuracy.presets import carries_series
from pysprings.full_model.diagnosis import DisplacementLimit
from pysprings.macro.capacity import capacities
from pysprings.macro.model import AnySprings, MacroModel, typed
from pysprings.macro.vertical import covered
from pysprings.results.exporters.csv import write_frame
from pysprings.scene.checks import off_plane_refusals
from pysprings.scene.model import Scene
from pysprings.springs.path import SpringPath
from pysprings.springs.path_ends import MESH_ERROR
from pysprings.springs.springs import Springs
from pysprings.studies.capacity import plan, points
from pysprings.studies.capacity.envelope import utilisation
from pysprings.studies.stored_runs import RUNS, forget, run_folder

_ENOUGH = 0.75  # share of the limit of motion to which a ray must lead
SCHEMA = "pysprings-capacity-3"
FILES = {
    "report.html": "page with envelope and tables: open it in a browser",
    "capacity.csv": "capacity by direction, vertical load and strength; the macro-model's beside it",
    "cases.csv": "utilisation of the load cases",
    "capacity.json": "everything as JSON",
    "capacity.png": "envelopes of both models, with the load cases",
    "capacity.svg": "the same as SVG",
    RUNS: "the runs, each with its own report",
}


def scene_of(scene: Scene, mesh: str | None = None, discretisation: str | None = None) -> Scene:
    """Return the scene of a study: another mesh or discretisation; Fourier series where the scene allows them."""
    if discretisation is None and carries_series(scene):
        discretisation = "fourier"
    changed: dict[str, Any] = {"preset": mesh or scene.mesh.preset}
    if discretisation not in (None, scene.mesh.discretisation):
        changed |= {"discretisation": discretisation, "azimuth": None, "harmonics": None}
    return scene.replace(mesh=changed)


def with_torsion(scene: Scene, request: plan.Request, cases: LoadCases) -> plan.Request:
    """Return what is asked for with T alone, too, where load cases have a torsion and the scene's model carries it."""
    needed = not request.torsion and bool(cases.torsion.any())
    carried = needed and next(off_plane_refusals(scene, whole=True), None) is None
    return replace(request, torsion=(0.5 * math.pi,)) if carried else request


def study(
    scene: Scene, out: Path, request: plan.Request, report: Progress, springs: AnySprings | None = None,
    cases: LoadCases | None = None, force: bool = False, formats: Sequence[str] = ("png",), jobs: int | None = 1,
) -> points.Capacity:  # fmt: skip
    """Run what has not ended yet, assess it and write everything; return the capacities.

    springs : those whose envelope stands beside that of the full model, instead of rays. force : have every
    run made again. formats : those of the picture, "png" and "svg"; none: no picture. jobs : worker processes (None:
    the cores of the machine).

    Raises RunIncomplete: no direction has a load; nothing but the runs is written. UserInputError: the model of the
    scene carries no torsion, or water flows in it; springs of another caisson.
    """
    if scene.drainage.mode == "coupled":
        raise refused("drainage.mode", 'a capacity has no time for water to flow: it needs "drained" or "undrained"')
    if request.torsion and (why := [text for _, text in off_plane_refusals(scene, whole=True)]):
        raise refused("--torsion", f"the load leaves the plane of H and M: {'; '.join(why)}")
    if springs is not None:
        _refuse_other_springs(springs, scene)
    groups = list(plan.groups(scene, request))
    every = points.planned(groups, request)
    with new_folder(out), exclusive(out):
        remove_leftovers(out, own_folder(out, RUNS))
        if force:
            for run in (*every, *(each.with_small_steps() for each in every)):
                forget(run_folder(out, run.name))
        outcome = assess(scene, request, points.run_all(every, out, report, jobs), springs, cases)
        if outcome.table.empty:
            raise RunIncomplete(f"no capacity was found: {'; '.join(outcome.remarks)}", out)
        write(out, outcome, formats)
    return outcome


def assess(
    scene: Scene, request: plan.Request, ended: Sequence[points.Ended], springs: AnySprings | None = None,
    cases: LoadCases | None = None,
) -> points.Capacity:  # fmt: skip
    """Return the capacities of ended runs."""
    rows, remarks = [], [] if springs is None else _other_drainage(springs, scene)
    if scene.drainage.mode == "undrained" and scene.drainage.water_depth is None:
        remarks.append("suction of the water is not checked against cavitation: drainage.water_depth is not given")
    for group in dict.fromkeys(each.planned.group.name for each in ended):
        own = [each for each in ended if each.planned.group.name == group]
        if own[0].overloaded:
            remarks.append(f"{group}: the caisson does not carry this vertical load: {own[0].why}")
            continue
        load = _load_of(own)
        model, why = model_at(springs, load) if springs is not None else _model_of(own)
        remarks += [f"{group}: {why}"] if why else []
        for each in own:
            if each.planned.direction is None:
                continue
            point = each.point
            if point is None:
                remarks.append(f"{each.planned.name}: {each.why or 'no step converged'}")
                continue
            remarks += [f"{each.planned.name}: {point.why}"] if point.why else []
            rows.append(_row(each.planned, point, model) | {"V_N": load})
    table = pd.DataFrame(rows)
    used = None if cases is None or table.empty else utilisation(table, cases)
    return points.Capacity(scene, request, table, used, tuple(remarks))


def _load_of(ended: Iterable[points.Ended]) -> float:
    """Return the vertical load [N] of a group: the given one, or that of the first probe at its start."""
    for each in ended:
        if not isinstance(each.planned.group.load, str):
            return each.planned.group.load
        if each.point is not None:
            return each.point.rest_load
    return math.nan


def model_at(springs: AnySprings, load: float) -> tuple[MacroModel | None, str]:
    """Return the macro-model of springs at a vertical load [N]; None, with the reason, where they are of another."""
    model = MacroModel.from_springs(springs, V=load)
    if not isinstance(typed(springs), Springs):  # a table has none
        return model, ""
    own = model.origin.load
    if covered(model.vertical, np.array([load]), np.array([own]))[0]:
        return model, ""
    return None, f"the springs are those at V = {with_prefix(own, 'N')}: no macro-model beside this load"


def _refuse_other_springs(springs: AnySprings, scene: Scene) -> None:
    """Refuse springs of a caisson that is not that of a scene, and springs at several rates, of which it has none."""
    given, caisson = typed(springs), scene.caisson
    known = given.attrs if isinstance(given, Springs) else {}
    for name, own in (("outer_diameter", caisson.outer_diameter), ("skirt_length", caisson.skirt_length)):
        there = float(known.get(f"{name}_m", own))
        if not math.isclose(there, own, rel_tol=1e-3):
            raise refused("--springs", f"{name.replace('_', ' ')} {there:g} m; that of the scene is {own:g} m")
    if isinstance(given, Springs) and len(given.rate_sets) > 1:
        raise refused("--springs", "are at several rates, and a capacity has none: leave them out, for rays of its own")


def _other_drainage(springs: AnySprings, scene: Scene) -> list[str]:
    """Return a remark where water takes part otherwise in springs than in the probes of a scene."""
    given = typed(springs)
    if not isinstance(given, Springs) or given.drainage == scene.layer_drainage:
        return []
    return [f"the springs beside the full model are {given.drainage}, its probes {scene.layer_drainage}"]


def _model_of(ended: Iterable[points.Ended]) -> tuple[MacroModel | None, str]:
    """Return the macro-model on the rays of a group; None, with the reason, where there is none."""
    rays = next((each for each in ended if each.planned.direction is None), None)
    if rays is None:
        return None, ""
    try:
        springs = Springs.of(read_tree(rays.folder / "springs.nc"))
        short = [name for name, path in springs.paths.items() if _is_short(path, rays.planned.scene)]
        left = [path for name, path in springs.paths.items() if name not in short]
        model = MacroModel.from_springs(springs.with_paths(left), "fan")
    except (PyspringsError, OSError) as error:
        return None, f"no springs from the rays ({error})"
    omitted = f"; left out, because they stopped early: {', '.join(short)}" if short else ""
    return model, f"rays for the springs: {rays.why}{omitted}" if rays.why else ""


def _is_short(path: SpringPath, scene: Scene) -> bool:
    """Return whether a ray stopped so early that it would bend the interpolation beside it where the others go on."""
    limit = DisplacementLimit.of(scene, float(path.w[0]))
    moved = limit.share(np.array([path.u[-1], path.w[0], path.rotation[-1]]))
    return path.end.failed and moved < _ENOUGH


def _row(planned: points.Planned, point: points.Point, model: MacroModel | None) -> dict[str, Any]:
    """Return one row of the table."""
    a, b = point.direction
    row: dict[str, Any] = {
        "strength": planned.group.strength,
        "vertical_load": planned.group.load if isinstance(planned.group.load, str) else "given",
        "V_N": point.V,
        "direction_deg": math.degrees(a),
        "torsion_deg": math.degrees(b),
        "H_N": point.H,
        "M_Nm": point.M,
        "T_Nm": point.T,
        "size_N": point.size,
        "criterion": str(point.criterion),
        "is_capacity": int(point.is_capacity),
        "u_m": point.u,
        "w_m": point.w,
        "rotation_rad": point.rotation,
        "twist_rad": point.twist,
        "growth": point.growth,
        "moved": point.moved,
        MESH_ERROR: point.mesh_error,
    }
    return row | _beside(point, model, planned.scene.caisson.outer_diameter) | {"run": planned.name}


def _beside(point: points.Point, model: MacroModel | None, diameter: float) -> dict[str, Any]:
    """Return the capacity of the macro-model in the direction of a point, and its difference where both are known.

    Springs have no capacity under torsion.
    """
    if model is None or point.direction[1]:
        return {"H_macro_N": np.nan, "M_macro_Nm": np.nan, "criterion_macro": "", "difference_pct": np.nan}
    along = points.along_load(point.direction, diameter)[None, :2]
    found = capacities(model, along * point.size)
    kind, difference = str(found.kind[0]), 100.0 * (1.0 / float(found.utilisation[0]) - 1.0)
    return {
        "H_macro_N": float(found.H[0]),
        "M_macro_Nm": float(found.M[0]),
        "criterion_macro": kind,
        "difference_pct": difference if point.is_capacity and kind != RANGE_END else np.nan,
    }


def to_json(outcome: points.Capacity) -> dict[str, Any]:
    """Return everything that was found, in SI; numbers that are not there are null."""
    return {
        "schema": SCHEMA,
        "version": version.__version__,
        "scene": outcome.scene.title,
        "scene_sha256": outcome.scene.sha256,
        "factors": str(outcome.request.factors),
        "rows": records(outcome.table),
        "cases": None if outcome.cases is None else records(outcome.cases),
        "remarks": list(outcome.remarks),
    }


def write(out: str | os.PathLike[str], outcome: points.Capacity, formats: Sequence[str] = ("png",)) -> None:
    """Write tables, picture and page of a study."""
    from pysprings.results.plots.files import redraw
    from pysprings.studies.capacity import picture

    folder = Path(out)
    write_frame(outcome.table, folder / "capacity.csv")
    if outcome.cases is not None:
        write_frame(outcome.cases, folder / "cases.csv")
    else:
        (folder / "cases.csv").unlink(missing_ok=True)
    write_text(json_text(to_json(outcome), indent=1) + "\n", folder / "capacity.json")
    with following("the picture was"), warnings.catch_warnings(action="ignore"):
        if len(outcome.table):
            redraw(lambda: picture.envelopes(outcome.table, outcome.scene, outcome.cases), folder / "capacity", formats)
    with following("the page was"):
        picture.write_page(folder, outcome)
