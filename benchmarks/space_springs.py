# SPDX-License-Identifier: MIT
"""Errors of springs with memory out of one plane: ``python -m benchmarks.space_springs DIR [--case NAME] [--store]``.

A caisson in sand and one in clay with a gap run a fan with `memory` and `directions`, and further paths out of one
plane that are held back; springs are kept as DIR/NAME.nc. Errors are those of `macro.space.compare_in_space`; then how
far a pull that is turned differs from one along x, and the least work of 1,000 closed loops at random.
"""

import argparse
import itertools
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from fe_engine.clock import Clock
from fe_engine.model import Stage
from fe_engine.solve.stepping import Driver
from fe_engine.state import State
from pysprings import Scene
from pysprings.core import variables
from pysprings.full_model.compute import run
from pysprings.full_model.fourier_collect import SpaceCollector
from pysprings.full_model.work import make_engine
from pysprings.macro.space import compare_in_space
from pysprings.memory.build import with_memory
from pysprings.memory.offered import numbers_in_space
from pysprings.memory.space_model import SpaceSprings
from pysprings.model.fourier import build_fourier
from pysprings.scene.load import load_scene
from pysprings.scene.sections import PAPER, PAPER_SOIL
from pysprings.springs.checks import extract_springs, open_springs, save_springs
from tools.evidence_store import store, to_csv

COMMAND = "python -m benchmarks.space_springs DIR --store"
ROOT = Path(__file__).parents[1]
# reach [m]; H of the cross with M across of 2 L H; of H with T; of wind at 8 m and waves at 4 m [N]
CASES = {
    "sand": (20e-3, 0.6e6, (1.2e6, 4.5e6), (0.4e6, 0.5e6)),
    "clay-gap": (80e-3, 0.5e6, (1.2e6, 2.5e6), (0.35e6, 0.4e6)),
}
HEADS = ("case", "path", "role", *(f"{name}_error_pct" for name in ("H", "M", "p", "T", "u", "rotation")))
LOOPS, ANGLES = 1000, (7.5, 15.0, 22.5, 37.0, 45.0, 90.0)


def scene_of(name: str, preset: str = "medium") -> Scene:
    """Return the scene of a case with its fan and the paths that are held back."""
    reach, cross, (H, T), _ = CASES[name]
    held: dict[str, Any] = {"role": "held-back"}
    paths: list[dict[str, Any]] = [
        {"name": "elbow_upright", "kind": "translation", "lateral_displacement": 0.25 * reach,
         "then": [f"{500.0 * reach:g} mm towards 90 deg"]} | held,
        {"name": "small_circle", "kind": "circle", "radius": 0.15 * reach, "direction": np.radians(60.0)} | held,
        {"name": "cross", "kind": "load", "H_x": cross, "M_x": 8.0 * cross} | held,
        {"name": "H_with_T", "kind": "load", "H_x": H, "T": T} | held,
    ]  # fmt: skip
    sections: dict[str, Any] = {
        "caisson": {"outer_diameter": 7.8, "skirt_length": 4.0},
        "domain": PAPER,
        "soil": PAPER_SOIL,
    }
    if name != "sand":
        clay = load_scene(ROOT / "data/studies/clay-gap-scene.toml")
        sections = {key: getattr(clay, key).model_dump() for key in ("caisson", "domain", "soil", "interface")}
    return Scene(
        **sections, mesh={"preset": preset, "harmonics": 3}, solver={"tolerance": 1e-4}, paths=tuple(paths),
        output={"figures": False, "section": False, "interface_fields": False},
        springs={"reach": reach, "memory": True, "directions": True},
    )  # fmt: skip


def wind_and_waves(scene: Scene, loads: tuple[float, float]) -> xr.Dataset:
    """Return a path of the full model: H_x at 8 m that stays, then H_y at 4 m to and fro."""
    built = build_fourier(scene, whole=True)
    newton, dry = make_engine(scene, built, Clock()).newton, lambda _: np.zeros(len(built.model.stations))
    driver, collector = Driver(newton, State(built.model)), SpaceCollector(built, newton.system.gaps, dry, False)
    wind, wave = loads[0] * np.eye(6)[0] + 8.0 * loads[0] * np.eye(6)[4], np.zeros(6)
    wave[1], wave[3] = loads[1], -4.0 * loads[1]
    collector.add(driver.state.committed, 0.0)
    for number, force in enumerate((wind, wind + wave, wind - wave, wind + wave)):
        stage = Stage(f"{number}", np.zeros((0, 6)), np.zeros(0), np.zeros((6, 0)), force, max_fraction=0.05)
        driver.run(stage, lambda _: collector.add(driver.state.committed, float(len(collector.rows))))
    attrs = {"kind": "load", "role": "held-back", "arm_m": 0.0, "status": "complete", "heave": "free"}
    return collector.dataset().assign_attrs(attrs)


def springs_of(name: str, folder: Path, preset: str) -> xr.DataTree:
    """Return the springs of a case, from DIR/NAME.nc, or from a run of the full model that is kept there."""
    file = folder / f"{name}.nc"
    if not file.exists():
        folder.mkdir(parents=True, exist_ok=True)
        tree = extract_springs(run(scene_of(name, preset), estimate_error=False))
        waves = variables.attach(wind_and_waves(scene_of(name, preset), CASES[name][3]), "space_path")
        groups = {node.path: node.to_dataset(inherit=False) for node in tree.subtree} | {"/space/wind_and_waves": waves}
        save_springs(with_memory(xr.DataTree.from_dict(groups, name="springs")), file)
    return open_springs(file)


def turned_pulls(model: SpaceSprings) -> float:
    """Return the largest difference of a way that is turned from one along x, over its largest load."""
    worst = 0.0
    for ratio in np.radians([-45.0, 0.0, 30.0, 60.0, 90.0]):
        size = 0.5 * model.reach * np.concatenate([np.linspace(0.02, 1.0, 25), np.linspace(0.96, -1.0, 50)])
        u, lean = size * np.cos(ratio), size * np.sin(ratio) / model.length
        straight = model.solve("state", np.stack([u, 0 * u, 0 * u, lean, 0 * u], axis=1))[1]
        for angle in np.radians(ANGLES):
            c, s = np.cos(angle), np.sin(angle)
            H, V, M, N, _ = model.solve("state", np.stack([c * u, s * u, -s * lean, c * lean, 0 * u], axis=1))[1].T
            back = np.stack([c * H + s * V, c * V - s * H, c * M + s * N, c * N - s * M, 0 * u], axis=1)
            scale = np.array([1.0, 1.0, 1.0 / model.length, 1.0 / model.length, 0.0])
            worst = max(worst, np.abs((back - straight) * scale).max() / np.linalg.norm(straight * scale, axis=1).max())
    return 100.0 * worst


def least_work(model: SpaceSprings) -> float:
    """Return the least work of closed loops in five motions, over the work that goes to and fro in each."""
    random, worst = np.random.default_rng(44), np.inf
    for _ in range(LOOPS):
        corners = random.normal(size=(random.integers(2, 6), 5)) * model.reach * 10.0 ** random.uniform(-3.0, -0.3)
        corners /= [1.0, 1.0, -model.length, model.length, model.elements.radius]
        ends = np.concatenate([np.zeros((1, 5)), corners, np.zeros((1, 5))])
        way = np.concatenate([a + np.linspace(0, 1, 21)[1:, None] * (b - a) for a, b in itertools.pairwise(ends)])
        loads = np.concatenate([np.zeros((1, 5)), model.solve("state", way)[1]])
        works = 0.5 * (loads[1:] + loads[:-1]) * np.diff(way, axis=0, prepend=0.0)
        worst = min(worst, works.sum() / np.abs(works).sum())
    return float(worst)


def _shown(value: Any) -> str:
    """Return a text as it is, an error to a tenth, and "-" where there is none."""
    return value if isinstance(value, str) else "-" if np.isnan(value) else f"{value:.1f}"


def main() -> None:
    """Read the options, measure, print or store."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="where springs are kept")
    parser.add_argument("--case", choices=CASES, help="one caisson instead of all")
    parser.add_argument("--preset", default="medium", help="mesh of the full model")
    parser.add_argument("--store", action="store_true", help="write the tables of the documentation")
    given, errors, sets = parser.parse_args(), [HEADS], [("case", "elements", "numbers", "turned_pct", "least_work")]
    for name in [given.case] if given.case else CASES:
        tree = springs_of(name, given.folder, given.preset)
        for row in compare_in_space(tree).to_dict("records"):
            errors.append((name, *(_shown(row[key.replace("_error_", "_error_max_")]) for key in HEADS[1:])))
        model = SpaceSprings.of(tree)
        rows = model.elements.rows
        sets.append(
            (
                name,
                str(len(rows)),
                str(numbers_in_space(rows)),
                f"{turned_pulls(model):.1f}",
                f"{least_work(model):.2g}",
            )
        )
    print(to_csv(errors + sets))
    if given.store:
        store("space-springs", {"space-springs": to_csv(errors), "space-springs-sets": to_csv(sets)}, COMMAND)


if __name__ == "__main__":
    main()
