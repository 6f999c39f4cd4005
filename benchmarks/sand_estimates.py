# SPDX-License-Identifier: MIT
"""Do error estimates cover the truth in sand by relative density, and that of V on vertical paths?

    python -m benchmarks.sand_estimates [--out out/sand-estimates] [--scene dense-1 ...] [--vertical later-5 ...]

``--scene``: pulls of a Latin hypercube that was drawn after the method was fixed (law `sand`, 20 scenes), as
`benchmarks.error_estimates` judges them. ``--vertical``: pushes and pulls by 0.002 D (clay 0.01 D) of scenes of both
lists with two harmonics, on `coarse` and `medium`, extrapolated as in a run; the truth is extrapolated by order 1.35
from sections of 2 and 2.8 times the elements of `medium`, and uncertain by half of what that adds. Rows are CSV.
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
from pysprings.full_model.accuracy.own_estimate import share_of
from pysprings.full_model.accuracy.presets import read_mesh
from pysprings.full_model.compute import scene_to_run
from pysprings.springs.path import paths_of

# diameter m, L/D, relative density, critical angle deg, K0, friction at the wall, arm/D, V/(gamma' D^3), displacement/D
RANGE = ((4.0, 0.25, 0.3, 29.0, 0.4, 0.3, 0.0, 0.02, 0.001), (14.0, 1.2, 0.9, 34.0, 1.0, 0.6, 5.0, 0.4, 0.01))
TRUTH = ("fourier-medium", "fourier-medium:1.4", "fourier-medium:2", "fourier-medium:2.8")
ORDER, WEIGHT = 1.35, 10e3


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


def vertical(name: str, folder: Path) -> None:
    """Print the rows of a scene: what extrapolation leaves on `coarse` and `medium` at the end of both paths [%]."""
    values = dict(pulls.SCENES[name])
    d, clay = values["caisson"]["outer_diameter"], name.startswith("clay")
    end = (0.01 if clay else 0.002) * d
    ways = [{"name": n, "kind": "vertical", "vertical_displacement": s * end} for n, s in (("down", 1), ("up", -1))]
    changed: dict[str, Any] = {"path": ways, "title": name, "output": pulls.OUTPUT}
    changed |= {"soil": (pulls.PAPER_SOIL if name.startswith("later") else {}) | values["soil"]}
    changed |= {} if clay else {"solver": {"viscous_displacement": 1e-8 * d}}
    if name.startswith("later"):
        changed["caisson"] = values["caisson"] | {"vertical_load": 0.1 * WEIGHT * d**3}
    scene = Scene.model_validate({"domain": pulls.PAPER} | values | changed)

    def loads(mesh: Scene, path: str, at: Array) -> Array:
        data = paths_of(pulls.result_of(scene_to_run(mesh, harmonics=2), folder), of_mesh=True)[path].dataset
        way = data["w"].values - data["w"].values[0]
        return np.interp(at, np.sign(way[-1]) * way, data["V"].values)

    for path in ("down", "up"):
        at = np.linspace(0.0, end, 11)
        rows = [loads(read_mesh(text).scene(scene), path, at) for text in TRUTH]
        added = (rows[-2] - rows[-1]) * share_of(1.4, ORDER)
        truth = rows[-1] - added
        size = np.abs(truth - truth[0]).max()
        for mesh in ("coarse", "medium"):
            fine = scene_to_run(read_mesh(f"fourier-{mesh}").scene(scene), harmonics=2)
            coarse = two_mesh.coarser(fine)
            ratio = two_mesh.cell_ratio(fine, coarse)
            assert ratio is not None
            own, other = loads(fine, path, at), loads(coarse, path, at)
            left = own + share_of(ratio, 1.7 if clay else 2.0) * (own - other) - truth
            difference = np.abs(own - other).max()
            share = two_mesh.left_in(scene)["vertical_max"] * difference
            sizes = (100.0 * np.abs(each).max() / size for each in (own - truth, difference, share, left, 0.5 * added))
            print(",".join([name, path, mesh, *(f"{each:.2g}" for each in sizes)]), flush=True)


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
