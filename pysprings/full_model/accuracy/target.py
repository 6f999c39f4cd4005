# SPDX-License-Identifier: MIT
"""A run to a target error: a start by preset, its own estimate, and a finer mesh until the estimate meets the target.

The estimates of load and p(y) decide. The next mesh has so many more cells as the estimate asks for, by the order of
both meshes; a run ends without its target where the budget would be spent, or where no finer mesh can help.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pysprings.scene.model import Scene

START = {"5%": "coarse", "2%": "medium", "1%": "paper", "0.5%": "fine"}
TARGETS = {word: float(word.rstrip("%")) for word in START}  # %
JUDGED = {"load_max": "load", "py_rms": "p-y"}
ORDER = 1.7  # of the estimate in the cells
LEAST, LARGEST, MOST = 1.2, 2.0, 8.0  # factors on the cells: of a next mesh, and in all
GROWTH = 3.0  # power of the factor with which the cost of a run grows
ATTEMPTS = 4


def start(scene: Scene, word: str) -> Scene:
    """Return the scene on the mesh from which the runs to a target begin; its own steps and tolerance stay."""
    return scene.replace(mesh={"preset": START[word], "refinement": 1.0, "azimuth": None, "harmonics": None})


def reached(estimate: Mapping[str, Any]) -> dict[str, float]:
    """Return the estimates of load and p(y) [%], as far as there are any."""
    own = estimate.get("estimate_pct") or {}
    return {name: float(own[name]) for name in JUDGED if name in own}


def judged(
    word: str, scene: Scene, estimate: Mapping[str, Any], earlier: Sequence[Mapping[str, Any]]
) -> dict[str, Any]:
    """Return the entry of run.json on a target: the runs that were made, what the last reached [%], how it misses.

    ``missed`` is one line for people; None where load and p-y are within the target.
    """
    most, own = TARGETS[word], reached(estimate)
    beyond = {name: value for name, value in own.items() if value > most}
    missed = None
    if len(own) < len(JUDGED):
        missed = f"no estimate of load and p-y ({estimate.get('why_not', 'not on these paths')})"
    elif beyond:
        sizes = " and ".join(f"{JUDGED[name]} {value:.3g} %" for name, value in beyond.items())
        where = f" (path {estimate['worst_path']})" if estimate.get("worst_path") else ""
        missed = f"the run's own estimate is {sizes}{where}"
    elif stopped := estimate.get("companion_stopped"):
        missed = f"the estimate ends where the coarser mesh stopped, on {', '.join(stopped)}"
    mesh = {"preset": scene.mesh.preset, "refinement": scene.mesh.refinement}
    return {"target": word, "runs": [*earlier, mesh | own], "reached_pct": own,
            "missed": None if missed is None else f"--target-error {word}: {missed}"}  # fmt: skip


def finer(scene: Scene, noted: Mapping[str, Any]) -> tuple[Scene | None, str]:
    """Return the scene on the mesh after the last that ran, and an empty text; None and why there is none."""
    scene = as_ran(scene, noted)
    word, own = str(noted["target"]), noted["reached_pct"]
    beyond = max((value / TARGETS[word] for value in own.values()), default=0.0)
    if len(own) < len(JUDGED) or beyond <= 1.0:
        return None, "a finer mesh does not help"
    if len(noted["runs"]) >= ATTEMPTS:
        return None, f"{ATTEMPTS} meshes were tried"
    factor = min(max(LEAST, beyond ** (1.0 / ORDER)), LARGEST)
    refinement = round(scene.mesh.refinement * factor, 2)
    if refinement > MOST:
        return None, f"mesh.refinement would be {refinement:g}, above {MOST:g}"
    return scene.replace(mesh={"refinement": refinement}), ""


def runs_ahead() -> dict[str, float]:
    """Return how many runs a target may take, and between what times of the one before each further one takes."""
    return {"runs_at_most": ATTEMPTS, "further_run_least": LEAST**GROWTH, "further_run_most": LARGEST**GROWTH}


def cost(seconds: float, before: Scene, after: Scene) -> float:
    """Return the seconds that a run on the next mesh may take, from those of the one before."""
    return seconds * (after.mesh.refinement / before.mesh.refinement) ** GROWTH


def as_ran(scene: Scene, noted: Mapping[str, Any] | None) -> Scene:
    """Return the scene on the mesh of the last run to a target; the scene itself where none was made."""
    runs = (noted or {}).get("runs") or []
    mesh = {key: runs[-1][key] for key in ("preset", "refinement")} if runs else {}
    return scene.replace(mesh=mesh) if mesh else scene
