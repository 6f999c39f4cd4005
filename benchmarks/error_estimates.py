# SPDX-License-Identifier: MIT
"""Do the own error estimates of runs cover the truth? Held-out scenes, at small meshes and on finer ones.

    python -m benchmarks.error_estimates [--fourier] [--out out/error-estimates] [--truth medium:0.7 medium medium:1.4]
        [--at coarse:0.6 coarse] [--scene NAME ... | --clay] [--reach 1.0] [--table FILE]

The truth of a scene is extrapolated from the meshes of `--truth` as in `pysprings accuracy` (the finest as it is where
no order can be fitted), the estimate is that of `pysprings run --estimate-error` at each mesh of `--at`. Prints a line
a scene and mesh, then how often the estimate covers the error (asked: nine times in ten), the safety factor with
which it just would, and the median of estimate over truth. What has run is kept in the folder; the same command goes
on. ``--table`` writes the table of the evidence. For bricks nothing was fitted to these scenes; for Fourier series
(`--fourier`) the settings were chosen with all scenes at hand but those of LATER and CLAY (`--clay`: these alone),
which were drawn afterwards.
"""

import argparse
import json
import math
import statistics
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from scipy.stats import qmc

from benchmarks import kept_runs
from pysprings import Scene
from pysprings.core.errors import PyspringsError
from pysprings.core.storage import write_text
from pysprings.full_model.accuracy import measures, two_mesh
from pysprings.full_model.accuracy.measures import cell_size, curves_of, samples
from pysprings.full_model.accuracy.own_estimate import add_estimate, companions_of
from pysprings.full_model.accuracy.presets import read_mesh
from pysprings.full_model.compute import scene_to_run
from pysprings.full_model.run_record import Computed, MeshFigures, PathFigures, RunRecord, Status
from pysprings.scene.sections import PAPER, PAPER_SOIL
from pysprings.springs.path import paths_of

ASKED = 0.9
HEAD = ("quantity", "estimates", "true error covered", "median of estimate over true error",
        "median of true error [%]", "largest true error [%]")  # fmt: skip
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
DRAWN, LATER = ("drawn", 18, 20), ("later", 12, 2026)
# diameter m, L/D, friction angle deg, Young's modulus MPa, K0, friction at the wall, arm over D, displacement over D
LOWEST = (3.0, 0.3, 29.0, 20.0, 0.8, 0.2, 0.0, 0.0003)
HIGHEST = (16.0, 1.2, 41.0, 200.0, 1.1, 0.6, 5.0, 0.0012)


def drawn(name: str, number: int, seed: int) -> dict[str, dict[str, Any]]:
    """Return the scenes of a Latin hypercube, each third of them with stiffness that grows with depth."""
    points = qmc.scale(qmc.LatinHypercube(len(LOWEST), seed=seed).random(number), LOWEST, HIGHEST)
    scenes = {}
    for k, (d, ratio, phi, young, k0, mu, arm, reach) in enumerate(points.round(4).tolist()):
        ground = soil(phi, young, k0, friction_angle_initial="auto")
        if k % 3 == 0:
            stiffness = {"reference": 1e6 * young, "reference_stress": 100e3, "exponent": 0.5}
            ground["soil"]["layer"] = [{"top": 0.0, "name": "sand", "young_modulus": stiffness}]
        scenes[f"{name}-{k + 1}"] = caisson(d, ratio) | ground | {
            "path": pull(1e3 * reach * d, arm * d), "interface": {"friction_coefficient": mu}
        }  # fmt: skip
    return scenes


# Total stress, every second with a gap. m, L/D, su at mudline kPa, k D/su, G/su, adhesion, arm over D, displacement
# over D
CLAY, SOFTEST, STIFFEST = ("clay", 20, 2611), (4, 0.25, 2, 0, 100, 0.3, 0, 0.005), (14, 1.5, 30, 6, 800, 1, 5, 0.05)


def clays(name: str, number: int, seed: int) -> dict[str, dict[str, Any]]:
    """Return scenes of clay of a Latin hypercube."""
    points = qmc.scale(qmc.LatinHypercube(len(SOFTEST), seed=seed).random(number), SOFTEST, STIFFEST)
    scenes = {}
    for k, (d, ratio, su, growth, stiffness, alpha, arm, reach) in enumerate(points.round(4).tolist()):
        layer = {
            "top": 0.0, "name": "clay", "law": "tresca", "poisson_ratio": 0.49, "effective_unit_weight": 7e3,
            "undrained_shear_strength": {"top": 1e3 * su, "gradient": 1e3 * su * growth / d},
            "rigidity_ratio": stiffness,
        }  # fmt: skip
        scenes[f"{name}-{k + 1}"] = caisson(d, ratio) | {
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
    tree = kept_runs.result_of(scene, folder)
    if tree.attrs["status"] != "complete":
        raise PyspringsError("; ".join(json.loads(tree.attrs["run_json"])["failures"]))
    return tree


def lines_of(name: str, at: Sequence[str], truth: Sequence[str], reach: float, folder: Path) -> list[dict[str, Any]]:
    """Return one line a mesh: estimate and true error of each measure that is estimated, or why there is none."""
    scene = scene_of(name, reach)
    try:
        results = [result_of(read_mesh(text).scene(scene), folder) for text in truth]
    except PyspringsError as error:
        return [{"scene": name, "mesh": text, "why": f"no truth: {error}"} for text in at]
    lines = []
    for text in at:
        line: dict[str, Any] = {"scene": name, "mesh": text}
        try:
            run, estimate = estimated(read_mesh(text).scene(scene), folder)
        except PyspringsError as error:
            lines.append(line | {"why": str(error)})
            continue
        if not estimate["estimate_pct"]:
            lines.append(line | {"why": estimate["why_not"]})
            continue
        true, doubt = true_errors(run, results)
        line |= {"harmonics": str(run.attrs.get("harmonics", "")), "safety": estimate["safety"]}
        line |= {"estimate_pct": estimate["estimate_pct"], "true_pct": true, "truth_uncertain_pct": doubt}
        lines.append(line)
    return lines


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
    return _estimated(measures.worst(errors)), _estimated(measures.worst(doubts))


def _estimated(errors: Mapping[str, float]) -> dict[str, float]:
    return {name: errors[name] for name in two_mesh.ESTIMATED}


def needed_safety(estimate: float, true: float, safety: float) -> float:
    """Return the safety factor with which an estimate made with ``safety`` would just be the true error (both in %)."""
    if true == 0.0:
        return 0.0
    return safety * true / estimate if estimate else math.inf


def coverage(lines: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return how often estimates cover by measure, the safety factor that nine of ten need, and the excess.

    The truth is taken as it is: what it is uncertain by stands in the lines. The excess is the median of estimate over
    truth.
    """
    good = [line for line in lines if "why" not in line]
    summary: dict[str, Any] = {"estimates": len(good)}
    for name in two_mesh.ESTIMATED:
        each = [
            (line["estimate_pct"][name], line["true_pct"][name], line["safety"])
            for line in good
            if name in line["estimate_pct"] and math.isfinite(line["true_pct"][name])
        ]
        if each:
            needed = sorted(needed_safety(*one) for one in each)
            summary[name] = {
                "covered": sum(estimate >= true for estimate, true, _ in each),
                "of": len(each),
                "safety_needed": needed[math.ceil(ASKED * len(needed)) - 1],
                "largest_needed": needed[-1],
                "median_true_pct": statistics.median(true for _, true, _ in each),
                "largest_true_pct": max(true for _, true, _ in each),
                "median_excess": statistics.median(estimate / true if true else math.inf for estimate, true, _ in each),
            }
    return summary


def report(lines: Sequence[dict[str, Any]]) -> None:
    """Print the lines, and the coverage."""
    print(f"estimate and true error [%] (truth uncertain by): {', '.join(two_mesh.ESTIMATED)}")
    for line in lines:
        head = f"{line['scene']:14} {line['mesh']:11}"
        if "why" in line:
            print(f"{head} none: {line['why']}")
            continue
        parts = [
            f"{line['estimate_pct'].get(name, math.nan):7.2f} {line['true_pct'][name]:7.2f} "
            f"({line['truth_uncertain_pct'][name]:.2f})"
            for name in two_mesh.ESTIMATED
        ]
        print(f"{head} {'   '.join(parts)}")
    for mesh in dict.fromkeys(line["mesh"] for line in lines):
        total = coverage([line for line in lines if line["mesh"] == mesh])
        for name in two_mesh.ESTIMATED:
            if name in total:
                each = total[name]
                print(
                    f"{mesh}, {name}: covered {each['covered']} of {each['of']}; nine of ten need a safety of "
                    f"{each['safety_needed']:.2f}, all {each['largest_needed']:.2f}; estimate over true error "
                    f"{each['median_excess']:.1f} in the median; true error {each['median_true_pct']:.2f} % in the "
                    f"median, {each['largest_true_pct']:.2f} at most"
                )


def table(lines: Sequence[dict[str, Any]]) -> list[list[str]]:
    """Return the rows of the evidence: each measure on each mesh, of all scenes and of those of LATER."""
    rows = [list(HEAD)]
    later = [line for line in lines if line["scene"].startswith(f"{LATER[0]}-")]
    for mesh in dict.fromkeys(line["mesh"] for line in lines):
        for words, part in (("", lines), (", drawn afterwards", later)):
            total = coverage([line for line in part if line["mesh"] == mesh])
            for name in two_mesh.ESTIMATED:
                if name in total:
                    one = total[name]
                    head = f"{WORDS[name]}, {mesh.removeprefix('fourier-')}{words}"
                    numbers = (one["median_excess"], one["median_true_pct"], one["largest_true_pct"])
                    rows.append([head, str(one["of"]), str(one["covered"]), *(f"{value:.2g}" for value in numbers)])
    return rows


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
    lines = []
    truth, at = MESHES[options.fourier or options.clay]
    if options.clay:
        options.scene, truth = list(clays(*CLAY)), CLAY_TRUTH
    for name in options.scene:
        lines += lines_of(name, options.at or at, options.truth or truth, options.reach, options.out)
        print(f"{name} done", flush=True)
    write_text(json.dumps({"lines": lines, "coverage": coverage(lines)}, indent=1) + "\n", options.out / "table.json")
    report(lines)
    if options.table is not None:
        write_text("".join(",".join(f'"{cell}"' for cell in row) + "\n" for row in table(lines)), options.table)


if __name__ == "__main__":
    main()
