# SPDX-License-Identifier: MIT
"""Errors of springs in space on walks that a scene cannot state: ``python -m benchmarks.space_walks SCENE DIR``.

A run of the scene (a fan with `memory` and `directions`) gives springs in DIR. The full model then follows figures of
eight, one with rotations in proportion, a random walk in four motions, and a wind that stays with waves across; each is
kept in DIR. Prints the errors of `macro.space.compare_in_space` on all paths out of one plane.
"""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from fe_engine.clock import Clock
from fe_engine.model import Stage
from fe_engine.solve.stepping import Driver
from fe_engine.state import State
from pysprings import Scene
from pysprings.core.path_kinds import MOTIONS
from pysprings.full_model.compute import run
from pysprings.full_model.fourier_collect import SpaceCollector
from pysprings.full_model.work import make_engine
from pysprings.macro.space import compare_in_space
from pysprings.memory.build import with_memory
from pysprings.model.fourier import build_fourier
from pysprings.model.stages import dead_load_stage, lengths_of
from pysprings.scene.load import load_scene
from pysprings.springs.checks import extract_springs, open_springs, save_springs

FREE, HELD = np.eye(6)[:2], np.eye(6)[[0, 1, 3, 4]]  # motions that are imposed
# H [N] and height [m] of wind along x, and of waves along y
LOADS = {"space-sand": (0.4e6, 8.0, 0.5e6, 4.0), "space-clay-gap": (0.35e6, 8.0, 0.4e6, 4.0)}


def walks(name: str, scene: Scene, springs: xr.DataTree) -> dict[str, tuple[np.ndarray, np.ndarray, list[np.ndarray]]]:
    """Return what each walk imposes: combinations of motions, their values (n, nc) by part, and loads by part."""
    reach, length, diameter = (
        float(scene.springs.reach or 0.0),
        scene.caisson.skirt_length,
        scene.caisson.outer_diameter,
    )
    s = np.linspace(0.0, 2.0 * np.pi, 33)[1:]
    eight = 0.4 * reach * np.stack([np.sin(s), 0.5 * np.sin(2.0 * s)], axis=1)
    lean = 1.2 / length * eight
    turning = 0.7 * np.stack([eight[:, 0], eight[:, 1], -lean[:, 1], lean[:, 0]], axis=1)
    corners = np.random.default_rng(2811).uniform(-1.0, 1.0, size=(8, 4))
    corners /= np.maximum(1.0, np.linalg.norm(corners, axis=1))[:, None]
    circle = springs["space/circle"].to_dataset()
    top = float(np.hypot(circle["H_x"], circle["H_y"]).max())
    H, high, across, low = LOADS.get(name, (0.22 * top, diameter, 0.25 * top, 0.5 * diameter))
    wind, wave = np.zeros(6), np.zeros(6)
    wind[0], wind[4], wave[1], wave[3] = H, high * H, across, -low * across
    return {
        "figure_eight": (FREE, eight, []), "figure_eight_turning": (HELD, turning, []),
        "random_walk": (HELD, 0.35 * reach * corners / [1.0, 1.0, length, length], []),
        "wind_and_waves": (np.zeros((0, 6)), np.zeros((4, 0)), [wind, wind + wave, wind - wave, wind + wave]),
    }  # fmt: skip


def followed(scene: Scene, control: np.ndarray, points: np.ndarray, forces: list[np.ndarray]) -> xr.Dataset:
    """Return the path of the full model along a walk, from rest under the dead load."""
    built = build_fourier(scene, whole=True)
    newton, dry = make_engine(scene, built, Clock()).newton, lambda _: np.zeros(len(built.model.stations))
    driver, collector = Driver(newton, State(built.model)), SpaceCollector(built, newton.system.gaps, dry, False, None)
    if built.extra_load:
        driver.run(dead_load_stage(built.extra_load, MOTIONS), lambda _: None)
    collector.add(driver.state.committed, 0.0)
    before, diameter, reach = np.zeros(len(control)), scene.caisson.outer_diameter, float(scene.springs.reach or 0.0)
    for number, point in enumerate(points):
        force = forces[number].copy() if forces else np.zeros(6)
        force[2] += built.extra_load
        stage = Stage(f"{number}", control, point, control.T.copy(), force, max_fraction=0.05)
        if len(control):
            travel = float(np.linalg.norm((point - before) * lengths_of(scene, control)))
            first = min(1.0, 2.5e-6 * diameter * (20.0 if number else 1.0) / travel)
            stage = replace(stage, first_fraction=first, max_fraction=max(0.05, min(0.5, 0.04 * reach / travel)))
            stage = replace(stage, lag=(scene.solver.viscous_displacement or 0.0) / travel)
            before = point
        driver.run(stage, lambda _: collector.add(driver.state.committed, float(len(collector.rows))))
    return collector.dataset()


def main() -> None:
    """Run what has not run yet, calibrate, print errors."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", type=Path)
    parser.add_argument("folder", type=Path, help="where springs and walks are kept")
    given = parser.parse_args()
    scene, file = load_scene(given.scene), given.folder / "springs.nc"
    given.folder.mkdir(parents=True, exist_ok=True)
    if not file.exists():
        save_springs(with_memory(extract_springs(run(scene))), file)
    springs = open_springs(file)
    groups: dict[str, Any] = {node.path: node.to_dataset(inherit=False) for node in springs.subtree}
    for name, walk in walks(given.scene.stem, scene, springs).items():
        kept = given.folder / f"{name}.nc"
        if not kept.exists():
            followed(scene, *walk).to_netcdf(kept)
        attrs = springs["space/circle"].attrs | {"kind": "motion", "role": "held-back"}
        groups[f"/space/{name}"] = xr.load_dataset(kept).assign_attrs(attrs)
    print(compare_in_space(xr.DataTree.from_dict(groups, name="springs")).to_csv(index=False))


if __name__ == "__main__":
    main()
