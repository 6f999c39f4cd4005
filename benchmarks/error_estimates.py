# SPDX-License-Identifier: MIT
"""Do the own error estimates of runs cover the truth? Held-out scenes, at small meshes and on finer ones.

    python -m benchmarks.error_estimates [--fourier] [--out out/error-estimates] [--truth medium:0.7 medium medium:1.4]
        [--at coarse:0.6 coarse] [--scene NAME ... | --clay] [--reach 1.0] [--table FILE]

The truth of a scene is extrapolated from the meshes of `--truth` as in `pysprings accuracy` (the finest as it is where
no order can be fitted), the estimate is that of `pysprings run --estimate-error` at each mesh of `--at`. Prints a line
a scene, mesh and quantity, then how often the estimate covers the error (asked: nine times in ten), the median of
estimate over true error, and the safety factors with which nine of ten estimates, and all, would just cover. What has
run is kept in the folder; the same command goes on. ``--table`` writes the table of the evidence. For bricks nothing
was fitted to these scenes; for Fourier series (`--fourier`) the settings were chosen with all scenes at hand but those
of LATER and CLAY (`--clay`: these alone), which were drawn afterwards.
"""

import argparse
import json
import math
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import qmc

from pysprings import Scene
from pysprings.core import version
from pysprings.core.errors import PyspringsError
from pysprings.core.storage import read_tree, write_tree
from pysprings.full_model.accuracy import measures
from pysprings.full_model.accuracy.measures import cell_size, curves_of, samples
from pysprings.full_model.accuracy.own_estimate import add_estimate, companions_of
from pysprings.full_model.accuracy.presets import read_mesh
from pysprings.full_model.compute import compute, scene_to_run
from pysprings.full_model.run_record import Computed, MeshFigures, PathFigures, RunRecord, Status
from pysprings.scene.sections import PAPER, PAPER_SOIL
from pysprings.springs.path import paths_of

ASKED = 0.9
COLUMNS = ["scene", "mesh", "quantity", "estimate", "true", "uncertain", "needed", "why"]
WORDS = {"load_max": "load", "py_rms": "p-y", "rotation_max": "rotation", "stiffness": "initial stiffness"}
# Fourier series -> meshes of the truth, meshes whose estimates are judged
MESHES = {
    False: (("medium:0.7", "medium", "medium:1.4"), ("coarse:0.6", "coarse")),
    True: (("fourier-medium@5", "fourier-medium:1.4@5", "fourier-medium:2@5"), ("fourier-coarse",)),
}
CLAY_TRUTH = ("fourier-medium:0.8@7", "fourier-medium:1.1@7", "fourier-medium:1.5@7")
DEG = math.pi / 180.0
OUTPUT = {"interface_fields": False, "section": False, "figures": False}


def pull(mm: float, arm: float = 0.0, **more: Any) -> list[dict[str, Any]]:
    """Return a pull to a displacement, at a height of load (m)."""
    return [{"name": "pull", "kind": "pull", "lateral_displacement": 1e-3 * mm, "arm": arm, **more}]


def caisson(diameter: float, ratio: float, wide: float = 3.1, deep: float = 3.0) -> dict[str, Any]:
    """Return the caisson of a diameter and L/D, in a domain of so many diameters across (radius) and skirts deep."""
    length = ratio * diameter
    return {
        "caisson": {"outer_diameter": diameter, "skirt_length": length, "skirt_thickness": diameter / 78.0},
        "domain": {"radius": wide * diameter, "depth": max(deep * length, length + 0.75 * diameter)},
    }


def soil(phi: float, young: float, k0: float, cohesion: float = 0.0, **more: Any) -> dict[str, Any]:
    """Return the soil of final friction angle (deg), Young modulus (MPa), K0 and cohesion (kPa)."""
    values = {"friction_angle_final": phi * DEG, "young_modulus": 1e6 * young, "K0": k0, "cohesion": 1e3 * cohesion}
    return {"soil": values | more}


# Scenes of Latin hypercubes, beside those by hand: name, number, seed
DRAWN, LATER, CLAY = ("drawn", 18, 20), ("later", 12, 2026), ("clay", 20, 2611)
# diameter m, L/D, friction angle deg, Young's modulus MPa, K0, friction at the wall, arm over D, displacement over D
SAND_RANGE = ((3.0, 0.3, 29.0, 20.0, 0.8, 0.2, 0.0, 0.0003), (16.0, 1.2, 41.0, 200.0, 1.1, 0.6, 5.0, 0.0012))
# diameter m, L/D, su at mudline kPa, k D/su, G/su, adhesion, arm over D, displacement over D
CLAY_RANGE = ((4, 0.25, 2, 0, 100, 0.3, 0, 0.005), (14, 1.5, 30, 6, 800, 1, 5, 0.05))
Ends = tuple[tuple[float, ...], tuple[float, ...]]


def hypercube(name: str, number: int, seed: int, ends: Ends) -> Iterator[tuple[int, str, list[float]]]:
    """Yield index, name and values of the scenes of a Latin hypercube between two ends."""
    points = qmc.scale(qmc.LatinHypercube(len(ends[0]), seed=seed).random(number), *ends)
    yield from ((k, f"{name}-{k + 1}", point) for k, point in enumerate(points.round(4).tolist()))


def drawn(name: str, number: int, seed: int) -> dict[str, dict[str, Any]]:
    """Return scenes of sand, each third of them with stiffness that grows with depth."""
    scenes = {}
    for k, title, (d, ratio, phi, young, k0, mu, arm, reach) in hypercube(name, number, seed, SAND_RANGE):
        ground = soil(phi, young, k0, friction_angle_initial="auto")
        if k % 3 == 0:
            stiffness = {"reference": 1e6 * young, "reference_stress": 100e3, "exponent": 0.5}
            ground["soil"]["layer"] = [{"top": 0.0, "name": "sand", "young_modulus": stiffness}]
        scenes[title] = caisson(d, ratio) | ground | {
            "path": pull(1e3 * reach * d, arm * d), "interface": {"friction_coefficient": mu}
        }  # fmt: skip
    return scenes


def clays(name: str, number: int, seed: int) -> dict[str, dict[str, Any]]:
    """Return scenes of clay in total stress, every second with a gap."""
    scenes = {}
    for k, title, (d, ratio, su, growth, stiffness, alpha, arm, reach) in hypercube(name, number, seed, CLAY_RANGE):
        layer = {
            "top": 0.0, "name": "clay", "law": "tresca", "poisson_ratio": 0.49, "effective_unit_weight": 7e3,
            "undrained_shear_strength": {"top": 1e3 * su, "gradient": 1e3 * su * growth / d},
            "rigidity_ratio": stiffness,
        }  # fmt: skip
        scenes[title] = caisson(d, ratio) | {
            "soil": {"surcharge": 0.0, "layer": [layer]}, "path": pull(1e3 * reach * d, arm * d),
            "interface": {"adhesion_factor": alpha, "opening": ("vented", "bonded")[k % 2]},
        }  # fmt: skip
    return scenes


WATER = {"drainage": {"mode": "coupled"}}

# Drawn by hand over the ranges that designers use; none is the scene of the study.
SCENES: dict[str, dict[str, Any]] = drawn(*DRAWN) | drawn(*LATER) | clays(*CLAY) | {
    "small-stiff": caisson(3.0, 0.5) | soil(32, 120, 1.0) | {"path": pull(2.0)},
    "large-flat": caisson(15.0, 0.3) | soil(35, 80, 1.0) | {"path": pull(10.0, arm=10.0)},
    "long": caisson(6.0, 1.0) | soil(30, 60, 0.8, friction_angle_initial=10 * DEG) | {"path": pull(6.0)},
    "longer": caisson(4.0, 1.5) | soil(33, 50, 1.0) | {"path": pull(4.0, arm=8.0)},
    "loose": caisson(8.0, 0.5) | soil(28, 30, 0.9) | {"path": pull(8.0)},
    "dense": caisson(8.0, 0.6) | soil(40, 250, 1.2, dilation_angle=5 * DEG) | {"path": pull(5.0, arm=4.0)},
    "cohesive": caisson(10.0, 0.8) | soil(30, 40, 1.0, cohesion=15.0) | {"path": pull(10.0)},
    "high-arm": caisson(9.0, 0.7) | soil(36, 100, 1.0) | {"path": pull(8.0, arm=40.0)},
    "wide-domain": caisson(7.0, 0.5, wide=8.0, deep=6.0) | soil(34, 90, 1.0) | {"path": pull(5.0)},
    "tight-domain": caisson(7.0, 0.5, wide=1.5, deep=2.0) | soil(34, 90, 1.0) | {"path": pull(5.0)},
    "smooth": caisson(8.0, 0.4) | soil(33, 150, 1.0) | {
        "path": pull(6.0, arm=2.0), "interface": {"friction_coefficient": 0.2}},
    "translation": caisson(8.0, 0.6) | soil(31, 70, 1.0) | {
        "path": [{"name": "shift", "kind": "translation", "lateral_displacement": 5e-3}]},
    "rotation": caisson(8.0, 0.6) | soil(33, 70, 1.0) | {
        "path": [{"name": "turn", "kind": "rotation", "rotation": 0.1 * DEG}]},
    "coupled": caisson(8.0, 0.5) | soil(33, 100, 1.0) | WATER | {"path": pull(5.0, rate=0.1e-3)},
    "coupled-fast": caisson(6.0, 0.8) | soil(30, 60, 1.0) | WATER | {"path": pull(5.0, arm=5.0, rate=2e-3)},
}  # fmt: skip


def scene_of(name: str, reach: float) -> Scene:
    """Return the scene of a name, pushed to ``reach`` times its end value."""
    values = SCENES[name]
    paths = [dict(path) for path in values["path"]]
    for path in paths:
        for key in ("lateral_displacement", "rotation"):
            if key in path:
                path[key] = reach * path[key]
    soil = ({} if name.startswith(CLAY[0]) else PAPER_SOIL) | values.get("soil", {})
    given = {"title": name, "domain": PAPER, "output": OUTPUT} | values | {"path": paths, "soil": soil}
    return Scene.model_validate(given)


def result_of(scene: Scene, folder: Path) -> Any:
    """Return the result of a scene, stored by this version or run now. Raises PyspringsError if the run stops."""
    file = folder / f"{scene.sha256[:16]}.nc"
    tree = read_tree(file) if file.exists() else None
    if tree is None or tree.attrs["pysprings_version"] != version.__version__:
        done = compute(scene)
        if done.interrupted:
            raise KeyboardInterrupt
        tree = done.recorded()
        folder.mkdir(parents=True, exist_ok=True)
        write_tree(tree, file)
    if tree.attrs["status"] != "complete":
        raise PyspringsError("; ".join(json.loads(tree.attrs["run_json"])["failures"]))
    return tree


def lines_of(name: str, at: Sequence[str], truth: Sequence[str], reach: float, folder: Path) -> list[dict[str, Any]]:
    """Return a line a mesh and quantity: estimate and true error [%], or one a mesh with why there is none."""
    scene, lines = scene_of(name, reach), list[dict[str, Any]]()
    for mesh in at:
        head = {"scene": name, "mesh": mesh}
        try:
            results = [result_of(read_mesh(text).scene(scene), folder) for text in truth]
            run, estimate = estimated(read_mesh(mesh).scene(scene), folder)
        except PyspringsError as error:
            lines.append(head | {"why": str(error)})
            continue
        if not estimate["estimate_pct"]:
            lines.append(head | {"why": estimate["why_not"]})
        true, doubt = true_errors(run, results)
        for key, stated in estimate["estimate_pct"].items():
            lines.append(head | line_of(key, stated, true[key], doubt[key], estimate["safety"]))
    return lines


def line_of(key: str, stated: float, true: float, doubt: float, safety: float) -> dict[str, Any]:
    """Return the figures of a quantity; errors in %, the safety factor with which the estimate would just be true."""
    needed = 0.0 if true == 0.0 else safety * true / stated if stated else math.inf
    return {"quantity": WORDS[key], "estimate": stated, "true": true, "uncertain": doubt, "needed": needed}


def estimated(scene: Scene, folder: Path) -> tuple[Any, dict[str, Any]]:
    """Return the result of a scene and its own estimate, as `pysprings run --estimate-error` makes them."""

    def stored(scene: Scene, **_: Any) -> Computed:
        tree = result_of(scene, folder)
        paths = {name: PathFigures(Status.COMPLETE) for name in paths_of(tree)}
        return Computed(tree, RunRecord(Status.COMPLETE, paths=paths))

    beside = companions_of(scene, stored)
    done = stored(scene_to_run(scene, harmonics=beside.harmonics))
    done.record.mesh = MeshFigures(harmonics=done.tree.attrs.get("harmonics"))
    done = add_estimate(scene, done, beside)
    assert done.record.error_estimate is not None
    return done.tree, done.record.error_estimate


def true_errors(run: Any, series: Sequence[Any]) -> tuple[dict[str, float], dict[str, float]]:
    """Return errors [%] of a run, worst path, and the uncertainty of the truth from a series of ever finer meshes."""
    names = [f"truth {k}" for k in range(len(series))]
    by_path = samples({"run": curves_of(run)} | {n: curves_of(tree) for n, tree in zip(names, series, strict=True)})
    h = [cell_size(tree.attrs["n_unknowns"], tree.attrs.get("harmonics")) for tree in series]
    errors, doubts = [], []
    for each in by_path.values():
        reference = measures.reference_of([each[name] for name in names], h)
        errors.append(measures.errors(each["run"], {name: one.values for name, one in reference.items()}))
        doubts.append(measures.uncertainty(reference))
    worst = (measures.worst(errors), measures.worst(doubts))
    true, doubt = ({name: each[name] for name in WORDS} for each in worst)
    return true, doubt


def coverage(lines: pd.DataFrame) -> pd.DataFrame:
    """Return how often estimates cover, by mesh and quantity, of all scenes and of those of LATER.

    The truth is taken as it is: what it is uncertain by stands in the lines.
    """
    known = lines[np.isfinite(lines["true"])]
    later = known[known["scene"].str.startswith(f"{LATER[0]}-")]
    rows = []
    for mesh in known["mesh"].unique():
        for words, part in (("", known), (", drawn afterwards", later)):
            for quantity, each in part[part["mesh"] == mesh].groupby("quantity", sort=False):
                needed = np.sort(each["needed"])
                rows.append({
                    "quantity": f"{quantity}, {mesh.removeprefix('fourier-')}{words}",
                    "estimates": len(each),
                    "true error covered": int((each["estimate"] >= each["true"]).sum()),
                    "median of estimate over true error": (each["estimate"] / each["true"]).median(),
                    "median of true error [%]": each["true"].median(),
                    "largest true error [%]": each["true"].max(),
                    "safety that nine of ten need": needed[math.ceil(ASKED * len(needed)) - 1],
                    "safety that all need": needed[-1],
                })  # fmt: skip
    return pd.DataFrame(rows)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run what has not run yet, and print everything."""
    parser = argparse.ArgumentParser("python -m benchmarks.error_estimates", description="Do error estimates hold?")
    parser.add_argument("--out", type=Path, default=Path("out/error-estimates"))
    parser.add_argument("--fourier", action="store_true", help="meshes of Fourier series")
    parser.add_argument("--truth", nargs="+", help="meshes of the extrapolation")
    parser.add_argument("--at", nargs="+", help="meshes whose estimates are judged")
    sand = [name for name in SCENES if not name.startswith(CLAY[0])]
    parser.add_argument("--scene", nargs="+", choices=tuple(SCENES), default=sand)
    parser.add_argument("--clay", action="store_true", help="the scenes of clay alone, by series")
    parser.add_argument("--reach", type=float, default=1.0, help="share of each push")
    parser.add_argument("--table", type=Path, help="CSV file of the evidence")
    options = parser.parse_args(arguments)
    warnings.simplefilter("ignore")  # a run's own warnings are in its record
    truth, at = MESHES[options.fourier or options.clay]
    if options.clay:
        options.scene, truth = list(clays(*CLAY)), CLAY_TRUTH
    lines = []
    for name in options.scene:
        lines += lines_of(name, options.at or at, options.truth or truth, options.reach, options.out)
        print(f"{name} done", flush=True)
    frame = pd.DataFrame(lines, columns=COLUMNS)
    total = coverage(frame)
    print(frame.to_csv(index=False, float_format="%.3g"), total.to_csv(index=False, float_format="%.2g"), sep="\n")
    if options.table is not None:
        total.to_csv(options.table, index=False, float_format="%.2g", lineterminator="\n")


if __name__ == "__main__":
    main()
