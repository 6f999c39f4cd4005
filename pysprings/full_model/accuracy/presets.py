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
from pysprings.core.words import TargetError
from pysprings.full_model.accuracy.curves import LOAD, PY
from pysprings.full_model.accuracy.settings import BRICKS, FOURIER, MESH, Setting, read_mesh

if TYPE_CHECKING:
    from pysprings.scene.load import Scene

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
