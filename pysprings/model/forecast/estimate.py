# SPDX-License-Identifier: MIT
"""What a scene costs before it is run: counts from its own mesh, memory, disk and time from fitted laws."""

import math
from typing import Any

import numpy as np

from fe_engine.assembly.fourier_pattern import make_pattern
from fe_engine.memory import left as memory_available
from pysprings.core.loads import close_loads, nearest
from pysprings.core.tables.load_cases import read_load_cases
from pysprings.model.build import Built
from pysprings.model.contact import defaults_of, penalty_of
from pysprings.model.forecast.domain_effect import DomainEffect, domain_effect
from pysprings.model.forecast.omissions import left_out, symmetric_factors
from pysprings.model.forecast.resources import gigabytes, model_bytes, refuse_what_cannot_fit, size_of, steps_bytes
from pysprings.model.forecast.run_time import path_seconds, seconds, superlu_bytes, uses_superlu
from pysprings.model.fourier import BuiltFourier, build
from pysprings.model.stages import fast_paths, scene_warnings
from pysprings.scene.defaults import remarks
from pysprings.scene.interface import adhesion_factor, uses_adhesion
from pysprings.scene.model import Scene
from pysprings.scene.soils.cyclic import CYCLIC

MOST_NAMED = 5  # load cases of a warning


def profile(scene: Scene) -> list[dict[str, Any]]:
    """Return a row for top and bottom of each layer, in SI; adhesion factors where they act."""
    rows, ground = [], scene.ground
    for stratum in ground.strata:
        for depth in (stratum.top, stratum.bottom):
            row = stratum.row(depth)
            adheres = stratum.top <= scene.caisson.skirt_length and float(stratum.strength(np.array(depth))) > 0.0
            if uses_adhesion(scene) and adheres:
                for side in ("outside", "inside"):
                    factor = adhesion_factor(scene.interface, stratum, side, np.array(depth))
                    row[f"adhesion_factor_{side}"] = float(factor)
            rows.append(row)
    return rows


def describe(scene: Scene) -> dict[str, Any]:
    """Return counts and quality of the mesh, unknowns, memory and disk (GB), time (s), what is left out, warnings.

    Raises ResourceError, before anything is built, where the run cannot fit in the memory of this machine.
    """
    refuse_what_cannot_fit(scene)
    built = build(scene)
    mesh, quality = built.model.mesh, built.quality
    unknowns = _unknowns(built)
    steps = steps_bytes(scene, size_of(scene))[1]
    symmetric = symmetric_factors(scene)
    memory = model_bytes(scene, symmetric) + steps
    effect = domain_effect(scene)
    free = memory_available()  # other programs may leave too little
    warnings = [f"the run needs about {gigabytes(memory)} of memory; {gigabytes(free)} are free now"] * (memory > free)
    warnings += [*effect.remarks, *scene_warnings(scene), *penalty_of(scene).remarks]
    warnings += [*fast_paths(scene, mesh), *remarks(scene)]
    V = 2.0 * (built.balanced_load + built.extra_load)
    time = seconds(scene, unknowns, symmetric=symmetric)
    by_load, far = _by_load(scene, V, time, unknowns)
    return {
        "mesh": {
            "nodes": mesh.n_nodes,
            "elements": mesh.n_elements,
            "steel_elements": 0 if built.steel is None else built.steel.n_elements,
            "interface_stations": len(built.model.initial_pressure),
            "smallest_scaled_Jacobian": quality.min_jacobian,
            "largest_aspect_ratio": quality.max_aspect,
        },
        "unknowns": unknowns,
        "domain": _domain(effect),
        "contact": _contact(scene),
        "ground": profile(scene),
        **_cyclic(scene),
        "vertical_load_N": V,
        "defaulted": defaults_of(scene, V),
        "memory_GB": memory / 1e9,
        "disk_GB": steps / 1e9,
        "time_s": time,
        **_with_pardiso(scene, unknowns, memory),
        "vertical_loads": by_load,
        "left_out": [omission.record() for omission in left_out(scene)],
        "warnings": [*warnings, *far],
    }


def _by_load(scene: Scene, rest: float, time: float, unknowns: int) -> tuple[list[dict[str, Any]], list[str]]:
    """Return a row for each vertical load of the springs, and a sentence on load cases that no row is close to.

    A row has V [N], its paths and their part of the time of the run [s], and how many cases of [design] it is nearest
    to. None where there is one load and no table of cases. rest [N] is V of the caisson.
    """
    loads = np.array([rest, *scene.springs.vertical_loads])
    if loads.size == 1 and scene.design.cases is None:
        return [], []
    cases = None if scene.design.cases is None else read_load_cases(scene.design.cases)
    V = np.zeros(0) if cases is None else np.where(np.isnan(cases.V), rest, cases.V)
    place = nearest(V, loads)
    of_path = np.array([rest if each.vertical_load is None else each.vertical_load for each in scene.all_paths])
    cost = np.array(path_seconds(scene, unknowns))
    rows = [
        {"V_N": float(load), "paths": int((of_path == load).sum()),
         "time_s": time * float(cost[of_path == load].sum() / cost.sum()),
         **({} if cases is None else {"cases": int((place == k).sum())})}
        for k, load in enumerate(loads)
    ]  # fmt: skip
    far = np.flatnonzero(~close_loads(V, loads[place]) & (cases is not None and cases.lateral))
    if cases is None or not far.size:
        return rows, []
    names = ", ".join(cases.name[k] for k in far[:MOST_NAMED]) + " ..." * (far.size > MOST_NAMED)
    of = f"{far.size} load case{'s' * (far.size > 1)}"
    return rows, [f"V of {of} is more than 10 % from that of all springs: {names}"]


def _cyclic(scene: Scene) -> dict[str, list[dict[str, Any]]]:
    """Return the points of backbones from contours of cyclic tests, one a row; nothing without any."""
    found = ((stratum.name, stratum.tables.get(CYCLIC)) for stratum in scene.ground.strata)
    rows = [
        {"layer": name, "contours": each.name, "cycles": each.number, "average": each.average, "strain": strain,
         "stress_over_su": stress}
        for name, each in found if each for strain, stress in each.curve
    ]  # fmt: skip
    return {"cyclic": rows} if rows else {}


def _with_pardiso(scene: Scene, unknowns: int, memory: float) -> dict[str, float]:
    """Return memory (GB) and time (s) with the extra `mkl` where SuperLU factorises bricks; else nothing."""
    if not uses_superlu(scene):
        return {}
    less = superlu_bytes(unknowns)
    return {
        "memory_with_pardiso_GB": (memory - less) / 1e9,
        "time_with_pardiso_s": seconds(scene, unknowns, superlu=False),
    }


def _domain(effect: DomainEffect) -> dict[str, float]:
    """Return how far the domain reaches around the caisson, and bounds of its stiffening where there are some."""
    bounds = {"stiffening_by_the_domain_percent": effect.most}
    bounds |= {f"stiffening_of_K_{name}_percent": value for name, value in effect.percent.items()}
    return {
        "domain_radius_over_diameter": effect.radius,
        "soil_below_tip_over_diameter": effect.below_tip,
        **{name: value for name, value in bounds.items() if math.isfinite(value)},
    }


def _unknowns(built: Built | BuiltFourier) -> int:
    if isinstance(built, BuiltFourier):
        return make_pattern(built.model).n_unknowns + built.model.n_border
    model = built.model
    pressures = 0 if model.water is None else int((~model.water.fixed).sum())
    return int(3 * model.mesh.n_nodes - model.fixed.sum()) + model.n_border + pressures


def _contact(scene: Scene) -> dict[str, Any]:
    """Return the penalty stiffness that the model uses, and what it costs."""
    penalty = penalty_of(scene)
    return {
        "normal_stiffness_N_per_m3": penalty.normal,
        "shear_stiffness_N_per_m3": penalty.shear,
        "largest_initial_penetration_m": penalty.penetration,
        "loss_of_elastic_stiffness_percent": 100.0 * penalty.stiffness_loss,
    }
