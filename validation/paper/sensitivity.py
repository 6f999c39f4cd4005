# SPDX-License-Identifier: MIT
"""Readings of the paper, one at a time: which of its figures each gives, and whether any reading gives them all."""

from __future__ import annotations

import hashlib
import json
import re
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pysprings.core import version
from pysprings.core.errors import PyspringsError, UserInputError
from pysprings.core.progress import duration
from pysprings.core.storage import write_text
from pysprings.core.text import json_text
from pysprings.core.words import StopReason
from pysprings.core.written import own_folder
from validation.paper import measures as m
from validation.paper.cases import DEPTHS, END, SHOWN, VARIANTS, Case, Variant

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from pysprings import Scene

FOLDER = "sensitivity"
_KEPT = re.compile(r".+-[0-9a-f]{16}\.json")  # as `_figures_of` names them
# What counts as the paper's: stated with the table.
FRONT_RANGE = (1.25, 1.75)  # mean over the four depths of p'_N over initial, front, at 2.5 mm: "approximately 50 %"
BREAK_RANGE = (1.0e-3, 3.0e-3)  # m, place of the sharpest bend: "around 2 mm"
BREAK_SHARPNESS = 1.0  # a tangent that falls faster than 1/u
HALF_RANGE = (0.4, 0.6)  # H(mu 0)/H(mu 0.5) at 2.5 mm: "drops to half"
_AT = 5e-3  # m

CRITERIA = (
    f"front: mean over {', '.join(f'{d:g}' for d in DEPTHS)} m of p'_N over initial in front at 2.5 mm in "
    f"{FRONT_RANGE[0]:g} to {FRONT_RANGE[1]:g}. gap: no contact stress behind the caisson, outside, at {DEPTHS[0]:g} m "
    f"at 2.5 mm. break: the sharpest bend of the load curve between {1e3 * BREAK_RANGE[0]:g} and "
    f"{1e3 * BREAK_RANGE[1]:g} mm, where the tangent falls faster than 1/u. half: H(mu 0)/H(mu 0.5) at 2.5 mm in "
    f"{HALF_RANGE[0]:g} to {HALF_RANGE[1]:g}."
)

Report = Callable[[str, float, str], None]


def run_variants(
    folder: Path, mesh: str, progress: Report, variants: Sequence[Variant] = VARIANTS,
    run: Callable[[Scene], dict[str, Any]] | None = None,
) -> Iterator[pd.DataFrame]:  # fmt: skip
    """Run the variants that the folder has no figures of; yield the table of those that have been, after each.

    Each run leaves a small file of its own, named by scene and version, so that an interrupted study goes on. ``run``
    makes the figures of a scene (None: `run_scene`).
    """
    import pandas as pd

    figures: dict[str, dict[str, Any]] = {}
    rows: list[dict[str, Any]] = []
    began, worked = time.monotonic(), 0
    for number, variant in enumerate(variants):
        left = (
            f", about {duration((time.monotonic() - began) / worked * (len(variants) - number))} left" if worked else ""
        )
        progress("sensitivity", number / len(variants), f"{number + 1} of {len(variants)}: {variant.words}{left}")
        new = False
        for case in filter(None, (variant.case(), variant.smooth_case())):
            figures[case.name], ran = _figures_of(folder, mesh, case, run or run_scene)
            new = new or ran
        worked += new
        rows.append(row(variant, figures))
        yield pd.DataFrame(rows).assign(mesh=mesh, variants=len(variants))
    progress("sensitivity", 1.0, f"{len(variants)} variants")


def row(variant: Variant, by_case: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Return the line of a variant from the figures of all runs, by name of the case."""
    own = by_case[variant.name]
    words = {"group": variant.group, "variant": variant.name, "what": variant.words, "standing": variant.standing}
    out: dict[str, Any] = words | {"status": own["status"], "detail": own["detail"]}
    if own["status"] == "refused":
        return out
    figures = {key: value for key, value in own.items() if key not in ("status", "detail")}
    smooth = by_case.get(f"{variant.name}-smooth", {})
    figures["smooth_2.5mm"] = _over(smooth.get("H_2.5mm_kN"), own.get("H_2.5mm_kN"))
    if variant.water:
        drained = by_case.get(variant.beside, {})
        for key in ("H_1mm_kN", "H_2.5mm_kN", "H_10mm_kN", "H_20mm_kN"):
            figures[f"over_drained_{key[2:-3]}"] = _over(own.get(key), drained.get(key))
    return out | figures | verdicts(figures)


def verdicts(figures: Mapping[str, Any]) -> dict[str, Any]:
    """Return which of the paper's four figures a run gives (True, False, None: unknown), and whether all."""
    answers: dict[str, Any] = {
        "is_front": _within(figures.get("front_mean_2.5mm"), FRONT_RANGE),
        "is_gap": _within(figures.get("back_0.25m_2.5mm"), (-1.0, 1e-9)),
        "is_break": _is_break(figures.get("bend_mm"), figures.get("bend_sharpness")),
        "is_half": _within(figures.get("smooth_2.5mm"), HALF_RANGE),
    }
    judged = [value for value in answers.values() if value is not None]
    return answers | {"of_four": sum(judged)}


def _is_break(place: float | None, sharpness: float | None) -> bool | None:
    near = _within(place, (1e3 * BREAK_RANGE[0], 1e3 * BREAK_RANGE[1]))
    sharp = _within(sharpness, (BREAK_SHARPNESS, 1e9))
    return None if near is None or sharp is None else near and sharp


def _within(value: float | None, limits: tuple[float, float]) -> bool | None:
    if value is None or not np.isfinite(value):
        return None
    return bool(limits[0] <= value <= limits[1])


def _over(value: float | None, base: float | None) -> float:
    return float("nan") if value is None or not base else float(value / base)


def figures_of_path(path: xr.Dataset) -> dict[str, Any]:
    """Return the figures of one run, by column of the table."""
    front = m.stress_ratio(path, SHOWN, m.FRONT, DEPTHS)
    back = m.stress_ratio(path, SHOWN, m.BACK, DEPTHS)
    place, sharpness = m.load_bend(path)
    figures: dict[str, Any] = {
        "front_mean_2.5mm": float(np.mean(front)),
        **{f"front_{depth:g}m_2.5mm": float(v) for depth, v in zip(DEPTHS, front, strict=True)},
        **{f"back_{depth:g}m_2.5mm": float(v) for depth, v in zip(DEPTHS, back, strict=True)},
        "open_share_2.5mm": m.open_share(path, SHOWN),
        "gap_2.5mm_mm": 1e3 * float(m.rear_gap(path, SHOWN).max()),
        "gap_20mm_mm": 1e3 * float(m.rear_gap(path, END).max()),
        "slope_ratio": m.slope_ratio(path),
        "bend_mm": 1e3 * place,
        "bend_sharpness": sharpness,
        **{f"H_{1e3 * u:g}mm_kN": 1e-3 * m.load(path, u) for u in (1e-3, SHOWN, _AT, 10e-3, END)},
    }
    if "pressure_min" in path:
        figures["back_3.25m_20mm"] = float(m.stress_ratio(path, END, m.BACK, DEPTHS[-1:])[0])
        figures["F_pw_20mm_kN"] = 1e-3 * float(m.at(path, "F_pw", END))
    return {key: round(value, 6) for key, value in figures.items()}


def _figures_of(
    folder: Path, mesh: str, case: Case, run: Callable[[Scene], dict[str, Any]]
) -> tuple[dict[str, Any], bool]:
    """Return the figures of a case, kept ones of this very scene and version or those of a run, and which it was."""
    try:
        scene = case.scene(mesh, fields_only=True)
    except ValueError as error:  # pydantic's, of values that clash
        return {"status": "refused", "detail": _first_line(error)}, False
    key = hashlib.sha256(f"{scene.sha256} {version.__version__}".encode()).hexdigest()[:16]
    file = own_folder(folder, FOLDER) / f"{case.name}-{key}.json"
    if (stored := _read(file)) is not None:
        return stored, False
    figures = run(scene)
    write_text(json_text(figures, indent=1) + "\n", file)
    return figures, True


def run_scene(scene: Scene) -> dict[str, Any]:
    """Run a scene; return how it ended, with the figures of the converged steps."""
    from pysprings.full_model.compute import compute
    from pysprings.springs.path import paths_of

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a run's own warnings are in its record
            result = compute(scene)
    except PyspringsError as error:
        return {"status": "refused", "detail": _first_line(error)}
    record, tree = result.record, result.tree
    if record.stopped_by is StopReason.INTERRUPTED:
        raise KeyboardInterrupt
    path = paths_of(tree)["pull"]
    figures = figures_of_path(path.dataset) if path.recorded.sizes["step"] > 1 else {}
    detail = "; ".join(record.short).split(" (")[0]
    return {"status": str(record.status), "detail": detail} | figures


def forget(folder: Path) -> None:
    """Remove the figures of all variants, by their names, so that each is run again."""
    for file in own_folder(folder, FOLDER).glob("*.json"):
        if _KEPT.fullmatch(file.name):
            file.unlink()


def _read(file: Path) -> dict[str, Any] | None:
    """Return what a file holds; None where it is not there or broken: the run is then made again."""
    try:
        record = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return record if isinstance(record, dict) and "status" in record else None


def _first_line(error: Exception) -> str:
    from pydantic import ValidationError

    if isinstance(error, ValidationError):
        return "; ".join(each["msg"] for each in error.errors(include_url=False, include_context=False))
    return error.lines[0] if isinstance(error, UserInputError) else str(error).splitlines()[0]
