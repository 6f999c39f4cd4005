# SPDX-License-Identifier: MIT
"""Do error estimates cover the truth in sand by relative density, and that of V on vertical paths?

    python -m benchmarks.sand_estimates [--out out/sand-estimates] [--scene dense-1 ...] [--vertical later-5 ...]

``--scene``: pulls of a Latin hypercube that was drawn after the method was fixed (law `sand`, 20 scenes), as
`benchmarks.error_estimates` judges them. ``--vertical``: pushes and pulls by 0.002 D (clay 0.01 D) of scenes of both
lists and of the default one, with one harmonic, on `coarse` and `medium`, extrapolated from halved elements beside the
tip as in a run; the truth is that of 1.5 times the elements of `medium`, uncertain by its difference from 1.2 times.
Rows are CSV.
"""

import argparse
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import error_estimates as pulls
from pysprings import Scene
from pysprings.core.arrays import Array
from pysprings.full_model.accuracy import two_mesh
from pysprings.full_model.accuracy.own_estimate import PULLED, PUSHED, share_of
from pysprings.full_model.accuracy.presets import read_mesh
from pysprings.scene.load import parse_scene
from pysprings.scene.template import template_text
from pysprings.springs.path import paths_of

# diameter m, L/D, relative density, critical angle deg, K0, friction at the wall, arm/D, V/(gamma' D^3), displacement/D
RANGE = ((4.0, 0.25, 0.3, 29.0, 0.4, 0.3, 0.0, 0.02, 0.001), (14.0, 1.2, 0.9, 34.0, 1.0, 0.6, 5.0, 0.4, 0.01))
TRUTH = ("medium:1.2", "medium:1.5")
WEIGHT = 10e3


def dense(number: int = 20, seed: int = 711) -> dict[str, dict[str, Any]]:
    """Return scenes of sand by relative density under a dead load."""
    scenes = {}
    for _, name, (d, ratio, density, phi, k0, mu, arm, load, reach) in pulls.hypercube("dense", number, seed, RANGE):
        scene = pulls.caisson(d, ratio)
        scene["caisson"]["vertical_load"] = load * WEIGHT * d**3
        soil = {"yield_surface": "sand", "relative_density": density, "critical_friction_angle": phi * pulls.DEG}
        scenes[name] = scene | {
            "soil": soil | {"K0": k0, "effective_unit_weight": WEIGHT, "surcharge": 2e3},
            "interface": {"friction_coefficient": mu}, "path": pulls.pull(1e3 * reach * d, arm * d),
            "solver": {"viscous_displacement": 1e-8 * d},
        }  # fmt: skip
    return scenes


def scene_of(name: str) -> tuple[Scene, float]:
    """Return a scene with a push and a pull, and their length [m]."""
    clay = name.startswith("clay")
    if name == "default":
        scene, end = parse_scene(template_text("caisson")), 0.01
        return scene.replace(paths=tuple(path for path in scene.all_paths if path.name in ("down", "up"))), end
    values = dict(pulls.SCENES[name])
    d = values["caisson"]["outer_diameter"]
    end = (0.01 if clay else 0.002) * d
    ways = [{"name": n, "kind": "vertical", "vertical_displacement": s * end} for n, s in (("down", 1), ("up", -1))]
    changed: dict[str, Any] = {"path": ways, "title": name, "output": pulls.OUTPUT}
    changed |= {"soil": (pulls.PAPER_SOIL if name.startswith("later") else {}) | values["soil"]}
    changed |= {} if clay else {"solver": {"viscous_displacement": 1e-8 * d}}
    if name.startswith("later"):
        changed["caisson"] = values["caisson"] | {"vertical_load": 0.1 * WEIGHT * d**3}
    return Scene.model_validate({"domain": pulls.PAPER} | values | changed), end


def vertical(name: str, folder: Path) -> None:
    """Print the rows of a scene: what extrapolation leaves on `coarse` and `medium`, largest along a path [%]."""
    scene, end = scene_of(name)

    def loads(mesh: str, halvings: int, path: str) -> tuple[Array, Array]:
        one = read_mesh(f"fourier-{mesh}").scene(scene).replace(mesh={"halvings": halvings, "harmonics": 1})
        data = paths_of(pulls.result_of(one, folder), of_mesh=True)[path].dataset
        return np.abs(data["w"].values - data["w"].values[0]), data["V"].values

    def both(mesh: str, path: str, at: Array) -> tuple[Array, Array]:
        """Return V of a mesh and with halved elements; beyond the end of that path their difference stays."""
        own, half = (loads(mesh, halvings, path) for halvings in (0, 1))
        end = np.minimum(at, half[0][-1])
        return np.interp(at, *own), np.interp(at, *own) + np.interp(end, *half) - np.interp(end, *own)

    for path in ("down", "up"):
        at = np.linspace(0.0, end, 11)
        share = share_of(2.0, PUSHED if path == "down" else PULLED)
        rough, truth = (half + share * (half - own) for own, half in (both(mesh, path, at) for mesh in TRUTH))
        size = np.abs(truth - truth[0]).max()
        for mesh in ("coarse", "medium"):
            own, half = both(mesh, path, at)
            left, changed = half + share * (half - own) - truth, np.abs(own - half).max()
            stated = max(two_mesh.HALVED * 100.0 * changed / size, two_mesh.LEAST_HALVED)
            parts = (100.0 * np.abs(each).max() / size for each in (own - truth, changed))
            rest = (100.0 * np.abs(each).max() / size for each in (left, rough - truth))
            print(",".join([name, path, mesh, *(f"{each:.2g}" for each in (*parts, stated, *rest))]), flush=True)


def main() -> None:
    """Run what has not run yet, and print everything."""
    parser = argparse.ArgumentParser("python -m benchmarks.sand_estimates")
    parser.add_argument("--out", type=Path, default=Path("out/sand-estimates"))
    parser.add_argument("--scene", nargs="+", default=[], choices=tuple(dense()))
    parser.add_argument("--vertical", nargs="+", default=[])
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    pulls.SCENES.update(dense())
    for name in options.vertical:
        vertical(name, options.out)
    if options.scene:
        pulls.PAPER_SOIL.clear()  # law `sand` has no friction angles
        truth = ["fourier-medium@5", "fourier-medium:1.4@5", "fourier-medium:2@5"]
        given = ["--fourier", "--out", str(options.out), "--at", "fourier-coarse", "--truth", *truth]
        pulls.main([*given, "--scene", *options.scene])


if __name__ == "__main__":
    main()
