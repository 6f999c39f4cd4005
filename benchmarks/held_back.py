# SPDX-License-Identifier: MIT
"""Do the estimates of single paths hold? Scenes that no setting was made with, four paths each.

    python -m benchmarks.held_back [SCENE ...] [--out out/held-back]

Clay, sand by density, Drucker-Prager sand, layers of both, coupled sand: Latin hypercubes with seeds of this date. The
estimate is that of a run on `coarse`; the truth is extrapolated from `medium` and 1.4 times its elements with at least
five harmonics (clay seven), and uncertain by its difference from the finer of both. Writes a JSON document a scene.
"""

import argparse
import json
import time
import warnings
from pathlib import Path
from typing import Any

import xarray as xr

from benchmarks.error_estimates import CLAY_RANGE, SAND_RANGE, caisson, hypercube, soil
from pysprings import Scene
from pysprings.full_model.accuracy import extrapolation, measures, own_estimate
from pysprings.full_model.accuracy.presets import read_mesh
from pysprings.full_model.compute import RunOptions, compute, scene_to_run
from pysprings.model.fourier_mesh import ground_of_sections
from pysprings.scene.sections import PAPER_SOIL
from pysprings.springs.path import paths_of

RATIO = 1.4
KEYS = {"load_max": "load_pct", "py_rms": "py_pct", "rotation_max": "rotation_pct"}
OUTPUT = {"interface_fields": False, "section": False, "figures": False, "paraview": False}
DENSE = ((4, 0.3, 0.35, 0.2, 0.001), (12, 1.2, 0.9, 0.6, 0.004))  # D, L/D, D_r, friction at the wall, u/D
LAYERS = ((5, 0.4, 0.3, 20, 0.4, 0.0015), (12, 1.1, 0.9, 90, 0.85, 0.006))  # D, L/D, boundary/L, su kPa, D_r, u/D
WET = ((4, 0.4, 30, 40, 0.8, -4.5, 0.0005), (10, 1.0, 38, 150, 1.1, -2.5, 0.0015))  # .., phi, E, K0, log10 m/s, u/D
SAND = {"name": "sand", "law": "sand", "effective_unit_weight": 9.5e3, "K0": 0.5}


def paths(d: float, reach: float, length: float, rate: float | None = None) -> list[dict[str, Any]]:
    """Return a translation, two pulls and a rotation (with water a third pull) to one reach over D."""
    timed = {} if rate is None else {"rate": rate}
    end = {"lateral_displacement": reach * d, **timed}
    turn = {"name": "turn", "kind": "rotation", "rotation": reach * d / length}
    pulls = (("low", 0.5), ("high", 4.0), *(() if rate is None else (("higher", 12.0),)))
    return [
        {"name": "shift", "kind": "translation", **end},
        *({"name": name, "kind": "pull", "arm": arm * d, **end} for name, arm in pulls),
        *([turn] if rate is None else []),
    ]


def clay(top: float, su: float, growth: float, d: float, stiffness: float) -> dict[str, Any]:
    """Return a layer of undrained clay: su at its top [kPa], its growth over D."""
    return {
        "top": top, "name": "clay", "law": "tresca", "poisson_ratio": 0.49, "effective_unit_weight": 7e3,
        "undrained_shear_strength": {"top": 1e3 * su, "gradient": 1e3 * su * growth / d}, "rigidity_ratio": stiffness,
    }  # fmt: skip


def scenes() -> dict[str, dict[str, Any]]:
    """Return the scenes by name."""
    found: dict[str, dict[str, Any]] = {}
    for k, name, (d, ratio, su, growth, stiffness, alpha, _, reach) in hypercube("hclay", 8, 2911, CLAY_RANGE):
        contact = {"adhesion_factor": alpha, "opening": ("vented", "bonded")[k % 2]}
        layers, moved = [clay(0.0, su, growth, d, stiffness)], paths(d, reach, ratio * d)
        found[name] = caisson(d, ratio) | {"soil": {"layer": layers}, "interface": contact, "path": moved}
    for _, name, (d, ratio, density, mu, reach) in hypercube("hsand", 6, 2912, DENSE):
        layers, moved = [SAND | {"top": 0.0, "relative_density": density}], paths(d, reach, ratio * d)
        found[name] = caisson(d, ratio) | {
            "soil": {"layer": layers}, "interface": {"friction_coefficient": mu}, "path": moved,
        }  # fmt: skip
    for _, name, (d, ratio, phi, young, k0, mu, _, reach) in hypercube("hplasol", 4, 2913, SAND_RANGE):
        found[name] = caisson(d, ratio) | {
            "soil": frictional(phi, young, k0), "interface": {"friction_coefficient": mu},
            "path": paths(d, reach, ratio * d),
        }  # fmt: skip
    for k, name, (d, ratio, at, su, density, reach) in hypercube("hlayer", 6, 2914, LAYERS):
        sand, below = SAND | {"relative_density": density}, at * ratio * d
        over = [sand | {"top": 0.0}, clay(below, su, 0.0, d, 250.0)]
        under = [clay(0.0, 0.5 * su, 1.0, d, 250.0), sand | {"top": below}]
        found[name] = caisson(d, ratio) | {
            "soil": {"layer": over if k % 2 else under}, "path": paths(d, reach, ratio * d),
            "interface": {"friction_coefficient": 0.4, "adhesion_factor": 0.6},
        }  # fmt: skip
    for _, name, (d, ratio, phi, young, k0, rate, reach) in hypercube("hwater", 4, 2915, WET):
        found[name] = caisson(d, ratio) | {
            "soil": frictional(phi, young, k0), "drainage": {"mode": "coupled"},
            "interface": {"friction_coefficient": 0.4}, "path": paths(d, reach, ratio * d, 10.0**rate),
        }  # fmt: skip
    return found


def frictional(phi: float, young: float, k0: float) -> dict[str, Any]:
    """Return Drucker-Prager sand under 5 kPa of surcharge."""
    return PAPER_SOIL | soil(phi, young, k0, friction_angle_initial="auto")["soil"] | {"surcharge": 5e3}


def errors(one: xr.DataTree, truth: xr.DataTree) -> dict[str, dict[str, float]]:
    """Return the errors [%] of a result by path; p is compared in slices, as it varies in those of the truth."""
    true, found = measures.curves_of(truth), measures.curves_of(one, finer=paths_of(truth))
    common = {"one": {name: found[name] for name in found if name in true}, "truth": true}
    return {name: measures.errors(each["one"], each["truth"]) for name, each in measures.samples(common).items()}


def main() -> None:
    """Run the scenes that are named, or all."""
    parser = argparse.ArgumentParser("python -m benchmarks.held_back")
    parser.add_argument("scene", nargs="*", choices=[[], *scenes()], default=[])
    parser.add_argument("--out", type=Path, default=Path("out/held-back"))
    options = parser.parse_args()
    warnings.simplefilter("ignore")  # a run's own warnings are in its record
    options.out.mkdir(parents=True, exist_ok=True)
    for name in options.scene or scenes():
        begun = time.process_time()
        scene = Scene.model_validate({"title": name, "output": OUTPUT} | scenes()[name])
        scene = read_mesh("fourier-coarse").scene(scene)
        beside = own_estimate.companions_of(scene, lambda each, **_: compute(each, RunOptions()))
        run = compute(scene_to_run(scene, harmonics=beside.harmonics), RunOptions())
        run = own_estimate.add_estimate(scene, run, beside)
        n = max(7 if name.startswith("hclay") else 5, (beside.harmonics or 3) + 2)
        meshes = (f"fourier-medium@{n}", f"fourier-medium:{RATIO}@{n}")
        coarse, fine = (compute(read_mesh(mesh).scene(scene), RunOptions()).tree for mesh in meshes)
        share = extrapolation.share_of(RATIO, own_estimate.ORDERS[ground_of_sections(scene)])
        truth = extrapolation.extrapolated(fine, extrapolation.Beside(coarse), share)
        true, doubt = errors(run.tree, truth.tree), errors(fine, truth.tree)
        estimate = run.record.error_estimate or {}
        found: dict[str, Any] = {
            path: {
                key: [estimate.get("by_path", {}).get(path, {}).get(word), each[key], doubt[path][key]]
                for key, word in KEYS.items()
            }
            for path, each in true.items()
        }
        found |= {"not extrapolated": truth.not_alike, "cpu_s": time.process_time() - begun}
        (options.out / f"{name}.json").write_text(json.dumps(found, indent=1))
        print(f"{name} done", flush=True)


if __name__ == "__main__":
    main()
