# SPDX-License-Identifier: MIT
"""Settings by target error: what the shipped study (`presets.json`) supports, and the orders it has found.

The file is written by `pysprings accuracy SCENE --write-presets FILE`; its `origin` has the scene, and by which
version and when. It is the error on that scene: a run made with a target estimates its own beside it.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any, get_args

from pydantic import ValidationError

from pysprings.core.errors import refused
from pysprings.core.text import percent
from pysprings.core.words import TargetError
from pysprings.full_model.accuracy.curves import LOAD, PY
from pysprings.full_model.accuracy.settings import BRICKS, FOURIER, MESH, Setting, read_mesh

if TYPE_CHECKING:
    from pysprings.scene.load import Path, Scene

SCHEMA = "pysprings-accuracy-2"
TARGETS = {word: float(word.rstrip("%")) for word in get_args(TargetError)}
_VARIED = ("tolerance", "max_step_fraction", "first_step_fraction")  # of [solver]; linear solvers answer alike
JUDGED = ("load_max", "py_rms")  # a setting meets a target where both errors do


@cache
def shipped() -> dict[str, Any]:
    """Return the study that comes with the package."""
    study: dict[str, Any] = json.loads((files(__package__) / "presets.json").read_text(encoding="utf-8"))
    return study


def orders(discretisation: str = BRICKS, study: dict[str, Any] | None = None) -> dict[str, float | None]:
    """Return the fitted orders of load and p(y) of a discretisation; None where the study has found none."""
    known = (study or shipped())["orders"].get(discretisation, {})
    return {name: known.get(name) for name in (LOAD, PY)}


def cheapest(target: str, study: dict[str, Any] | None = None, scene: Scene | None = None) -> Setting:
    """Return the setting with the least processor time whose errors are within a target ("5%", ..., "0.5%").

    Of a ``scene``, only settings with which it can be run.
    """
    study = study or shipped()
    if target not in TARGETS:
        raise refused("--target-error", f"'{target[:20]}' is no target; give {', '.join(TARGETS)}")
    rows = [row for row in study["settings"] if scene is None or _carries(_setting(row), scene)]
    row = cheapest_within(TARGETS[target], rows)
    if row is None:
        best = min(max(row[f"{name}_pct"] for name in JUDGED) for row in rows)
        raise refused(
            "--target-error",
            f"no setting of the study ({study['origin']['scene']}) is within {target}; the best has {best:.2g} %",
        )
    return _setting(row)


STUDIED = {"diameter": 7.8, "slenderness": 4.0 / 7.8, "motion": 2.5e-3 / 7.8}  # of the shipped study: m, L/D, u/D
SLENDER = 1.25  # factor of L/D within which its meshes stand for another caisson
FARTHEST = 10.0  # times its motion: beyond it more soil yields, and other cells decide


def refuse_outside(target: str, scene: Scene) -> None:
    """Refuse a target for a scene that the study behind the settings does not stand for: drained uniform sand.

    Raises
    ------
    UserInputError
        One problem with everything that is outside.
    """

    ground, caisson = scene.ground, scene.caisson
    moved = (
        max((_motion(path, caisson.skirt_length) for path in scene.load_paths), default=0.0) / caisson.outer_diameter
    )
    ratio = caisson.skirt_length / caisson.outer_diameter / STUDIED["slenderness"]
    outside = {
        "clay": ground.total_stress,
        "layers, or values that change with depth": not (ground.total_stress or ground.is_uniform),
        f"{scene.layer_drainage} water": scene.layer_drainage not in ("drained", "total-stress"),
        f"L/D {ratio * STUDIED['slenderness']:.2g}": not 1.0 / SLENDER <= ratio <= SLENDER,
        f"a motion of {100.0 * moved:.2g} % of D": moved > FARTHEST * STUDIED["motion"],
    }
    words = ", ".join(name for name, is_so in outside.items() if is_so)
    if words:
        low, high = (STUDIED["slenderness"] * factor for factor in (1.0 / SLENDER, SLENDER))
        most = 100.0 * FARTHEST * STUDIED["motion"]
        raise refused(
            "--target-error",
            f"'{target[:20]}' chooses a mesh from a study of drained uniform sand (L/D {low:.2f} to {high:.2f}, "
            f"motions up to {most:.2g} % of D), which does not cover {words}: give --mesh medium, paper or fine, whose "
            "run estimates its own error, or find the mesh by `pysprings accuracy SCENE`",
        )


def _motion(path: Path, length: float) -> float:
    """Return the largest motion of a path that is given (m); a rotation moves the tip."""
    moves = (path.lateral_displacement or 0.0, path.vertical_displacement or 0.0, length * (path.rotation or 0.0))
    return max(map(abs, moves))


def smaller(setting: Setting, scene: Scene) -> str:
    """Return one line where a setting is a smaller model than the scene's own mesh; empty where it is not."""
    from pysprings.model.forecast.resources import size_of

    own, chosen = size_of(scene).unknowns, size_of(applied(setting, scene)).unknowns
    if chosen >= own:
        return ""
    return f"runs {setting.name}, a smaller model ({chosen:,} unknowns) than that of the scene ({own:,})"


def _setting(row: Mapping[str, Any]) -> Setting:
    return Setting(
        row["name"], MESH, row["mesh"], row["refinement"], row["solver"],
        discretisation=row["discretisation"], harmonics=row["harmonics"],
    )  # fmt: skip


def carries_series(scene: Scene) -> bool:
    """Return whether a scene can be run with Fourier series."""
    return _carries(read_mesh(f"{FOURIER}-coarse"), scene)


def _carries(setting: Setting, scene: Scene) -> bool:
    """Return whether a scene can be run with a setting: a series does not carry everything."""
    try:
        applied(setting, scene)
    except ValidationError:
        return False
    return True


def cheapest_within(limit: float, rows: Iterable[Mapping[str, Any]]) -> Mapping[str, Any] | None:
    """Return the row with the least processor time whose errors [%] are within a limit; None: there is none.

    Other programs on the machine of a study disturb processor time less than wall time.
    """
    errors = [(row, [row[f"{name}_pct"] for name in JUDGED]) for row in rows]
    good = [row for row, own in errors if all(value is not None and value <= limit for value in own)]
    return min(good, key=lambda row: float(row["cpu_s"]), default=None)


def applied(setting: Setting, scene: Scene) -> Scene:
    """Return a scene with a setting of the study and, in what else it varies, as the study ran: by default.

    Its own mesh, tolerance and steps go: the study does not cover them.
    """
    plain = {key: getattr(type(scene.solver)(), key) for key in _VARIED}
    mesh = {"refinement": 1.0, "azimuth": None, "discretisation": "auto", "harmonics": None}
    return setting.scene(scene.replace(mesh=mesh, solver=plain))


def note(target: str, setting: Setting, study: dict[str, Any] | None = None) -> dict[str, Any]:
    """Return the entry of run.json for a target: the setting, and the study that supports it."""
    study = study or shipped()
    row = next(each for each in study["settings"] if each["name"] == setting.name)
    return {"target": target, "setting": setting.name, "error_in_study_pct": {n: row[f"{n}_pct"] for n in JUDGED},
            "study": study["origin"]}  # fmt: skip


def judged(noted: Mapping[str, Any], estimate: Mapping[str, Any]) -> dict[str, Any]:
    """Return the note of a target with what the run's own estimate reached [%], and how it misses the target.

    ``missed`` is one line for people; None where load and p-y are within the target.
    """
    most, own = TARGETS[str(noted["target"])], estimate.get("estimate_pct") or {}
    reached = {name: float(own[name]) for name in JUDGED if name in own}
    beyond = {name: value for name, value in reached.items() if value > most}
    missed, heads = None, {"load_max": "load", "py_rms": "p-y"}
    if len(reached) < len(JUDGED):
        missed = f"no estimate of load and p-y ({estimate.get('why_not', 'not on these paths')})"
    elif beyond:
        sizes = " and ".join(f"{heads[name]} {percent(value)}" for name, value in beyond.items())
        where = f" (path {estimate['worst_path']})" if estimate.get("worst_path") else ""
        missed = f"the run's own estimate is {sizes}{where}"
    elif stopped := estimate.get("companion_stopped"):
        missed = f"the estimate ends where the coarser mesh stopped, on {', '.join(stopped)}"
    if missed:
        missed = f"--target-error {noted['target']}: {missed}; take a finer --mesh, or `pysprings accuracy SCENE`"
    return {**noted, "reached_pct": reached, "missed": missed}
