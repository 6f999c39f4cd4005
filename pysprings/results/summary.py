# SPDX-License-Identifier: MIT
"""A run in ten lines: end of `pysprings run`, first page of the report, first sheet of the workbook."""

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import xarray as xr

from pysprings.core.errors import BeyondSprings, PyspringsError, UserInputError
from pysprings.core.loads import same_load
from pysprings.core.path_kinds import HELD_BACK, PATH_KINDS, height_of_load
from pysprings.core.text import number, percent
from pysprings.core.words import sudden
from pysprings.full_model.run_record import RunRecord, significant
from pysprings.results.parts import load_sizes
from pysprings.scene.defaults import defaulted_text
from pysprings.scene.design_load import USUAL_TILT
from pysprings.scene.model import Scene, caisson_text, ground_text
from pysprings.springs.card import stiffness_words
from pysprings.springs.path import paths_of, space_paths_of
from pysprings.springs.path_ends import STOPPED, before_cavitation, end_of, steps_before_cavitation

if TYPE_CHECKING:
    from pysprings.macro.model import MacroModel

_GOOD = 5.0  # percent: springs with larger errors on held-back paths are for comparison only
_GOOD_MESH = 5.0  # percent of load
_NONE_CALIBRATED = "no lateral path was calibrated"
_U, _HALF = "u", "u, half"
_AT_LOAD = {_U: "u_error_max_pct", _HALF: "u_error_half_pct"}  # at equal load; the second up to half of the largest one


@dataclass(frozen=True)
class Run:
    """What the lines are made from; ``comparison`` is None without springs, the others are always there."""

    scene: Scene
    result: xr.DataTree
    record: RunRecord
    comparison: pd.DataFrame | None
    springs: xr.DataTree | None


def summary(
    result: xr.DataTree, record: RunRecord, comparison: pd.DataFrame | None = None, springs: xr.DataTree | None = None
) -> dict[str, str]:
    """Return the text of each line by its heading; empty where the scene of the record cannot be read.

    ``comparison`` and ``springs`` are left out where too little converged for springs.
    """
    from pysprings.scene.load import parse_scene

    try:
        run = Run(parse_scene(record.scene_toml), result, record, comparison, springs)
    except PyspringsError:  # of another version
        return {}
    lines = [
        ("caisson", caisson_text(run.scene, run.result.attrs.get("vertical_load_N"))),
        ("ground", ground_text(run.scene)),
        ("defaults", defaulted_text(record.defaulted, numerical=False)), ("remarks", "; ".join(record.remarks)),
        ("initial stiffness", _stiffness(run)),
        ("loads", _loads(run)), ("off a plane", _off_plane(run)), ("vertical", _vertical(run)),
        ("tilt", _tilt(run)), ("range", _range(run)), ("mesh error", _mesh(run)),
        ("springs", _springs(run)), ("warnings", _warnings(run)), ("use", _use(run)),
        ("not made", record.left_to_make),
    ]  # fmt: skip
    return {name: text for name, text in lines if text}


def _stiffness(run: Run) -> str:
    if "stiffness_initial" not in run.result.dataset:
        return ""
    known = stiffness_words(run.result.dataset["stiffness_initial"].values)
    return known + sudden(run.result.attrs.get("drainage"))


def _loads(run: Run) -> str:
    """Give the limit loads, else the largest H and M that the paths reached; `_vertical` has V."""
    found = run.record.limit_loads.items()
    before = {name for name, path in _lateral(run) if end_of(name, path).how == STOPPED}
    limits = [f"limit load of {name}: {at}" for name, at in found if not at.is_vertical and name not in before]
    if limits:
        return "; ".join(limits)
    parts = []
    length = run.scene.caisson.skirt_length
    sizes = load_sizes((path for _, path in _lateral(run)), length)
    for load, unit in (("H", "MN"), ("M", "MN m")):
        if not sizes[load]:
            continue
        best, path = max(_lateral(run), key=lambda item: float(np.abs(item[1][load]).max()))
        at = int(np.abs(path[load].values).argmax())
        u, turn, value = (float(path[name][at]) for name in ("u", "rotation", load))
        (u,), (turn,) = significant((u,), (turn,), length)
        parts.append(
            f"{load} {1e-6 * value:.4g} {unit} (path {best}: u {1e3 * u:.3g} mm, "
            f"{math.degrees(turn):.3g} deg{_under(path, float(path['V'][at]))})"
        )
    return f"largest reached, no limit load: {', '.join(parts)}" if parts else ""


def _off_plane(run: Run) -> str:
    """Give loads and motions at the end of each path off a plane; what is none to rounding is left out.

    Of a path whose water would cavitate those of the step before.
    """
    length, texts, space = run.scene.caisson.skirt_length, [], space_paths_of(run.result)
    for name, path in run.record.paths.items():
        parts: list[str] = []
        end, where = path.end, ""
        if name in space and (count := steps_before_cavitation(states := space[name].recorded)) < states.sizes["step"]:
            end = {each: float(states[each][max(count - 1, 0)]) for each in path.end}
            where = " before cavitation"
        for first, second, scale in _SIX if "u_x" in end else ():
            kept = significant([end[each] for each in first[0]], [end[each] for each in second[0]], length**scale)
            for (names, unit, factor), values in zip((first, second), kept, strict=True):
                shown = [f"{each} {factor * value:.3g}" for each, value in zip(names, values, strict=True) if value]
                parts += [f"{', '.join(shown)} {unit}"] if shown else []
        texts += [f"{name}{where}: {'; '.join(parts)}"] if parts else []
    return " | ".join(texts)


# loads and motions of paths off a plane, their units, and SI to these; power of L between forces and moments, ...
_SIX = (
    ((("H_x", "H_y", "V"), "MN", 1e-6), (("M_x", "M_y", "T"), "MN m", 1e-6), -1),
    ((("u_x", "u_y", "w"), "mm", 1e3), (("rot_x", "rot_y", "rot_z"), "mrad", 1e3), 1),
)


def _vertical(run: Run) -> str:
    """Give V at rest with the share that is used, the largest V of each rate that the springs carry, and V of sets.

    Empty without vertical springs. The share is of the largest V at the slowest rate.
    """
    from pysprings.macro.model import MacroModel
    from pysprings.macro.vertical_answer import vertical_use
    from pysprings.springs.springs import Springs

    if run.springs is None:
        return ""
    springs = Springs.of(run.springs)
    rates = [each.rate for each in springs.rate_sets]
    try:
        several = [springs.at_rate(each) for each in rates] if len(rates) > 1 else [springs]
        models = [MacroModel.from_springs(each) for each in several]
    except PyspringsError:  # no lateral springs
        return ""
    known = dict.fromkeys(filter(None, map(_largest_vertical, models)))  # once where all have one vertical path
    rest = models[0].rest_load
    used = float(vertical_use(models[0], np.array([rest]))["utilisation_V"][0])
    share = f", {100.0 * used:.3g} % used" if math.isfinite(used) else ""
    sets = [f"{1e-6 * each.V:.4g}" for each in springs.load_sets]
    at = f"; lateral springs at V {', '.join(sets)} MN" if len(sets) > 1 else ""
    return f"V {1e-6 * rest:.4g} MN at rest{share}; largest known{';'.join(known)}{at}" if known else ""


def _largest_vertical(model: "MacroModel") -> str:
    """Return the rate of vertical springs, where they have one, and the largest V in both directions; else nothing."""
    from pysprings.macro.vertical_answer import largest_vertical

    branches = model.vertical.branches if model.vertical else ()
    known = [(word, *largest_vertical(model, sign)) for word, sign in (("push", 1.0), ("pull", -1.0))]
    ways = [(word, V, "; ".join([kind, *of.split("; ")[1:]])) for word, V, kind, of in known if kind]  # why it stopped
    parts = [f"{word} {1e-6 * V:.4g} MN ({end})" for word, V, end in ways]
    least = min((each.largest for each in branches), default=0.0)
    parts += [f"nothing below {1e-6 * least:.4g} MN"] if least > 0.0 else []
    paces = dict.fromkeys(number(1e3 * each.rate) for each in branches if each.rate and model.rate)
    pace = f" at {', '.join(paces)} mm/s of w" if paces else ""
    return f"{pace}: {', '.join(parts)}" if parts else ""


def _tilt(run: Run) -> str:
    """Give the tilt at the design load of the scene; without one, the load of the tolerance on a path."""
    design = run.scene.design
    tolerated = math.degrees(USUAL_TILT if design.tilt is None else design.tilt)
    if design.lateral_force is None:
        return _tilt_on_path(run, tolerated)
    arm = design.arm or 0.0
    where = f"at the design load, H {1e-6 * design.lateral_force:.4g} MN at {arm:g} m"
    if run.springs is None:
        return f"not known {where}: no springs were made"
    answer = _answer(run.springs, design.lateral_force, arm)
    if isinstance(answer, str):
        return f"not known {where}: {answer}"
    carried = f"{1e-6 * answer.attrs['capacity_H_N']:.4g} MN at this height ({answer.attrs['capacity_kind']})"
    if answer.attrs["beyond_range"] or answer.attrs["refusals"]:
        return f"not known {where}: beyond the springs, which carry H {carried}"
    turn = math.degrees(abs(float(answer["rotation"])))
    kept = "within" if turn <= tolerated else "beyond"
    marks = "".join(f"; {text}" for text in answer.attrs["warnings"])
    used = 100.0 * float(answer["utilisation"])
    return f"{turn:.3g} deg {where}: {kept} the tolerated {tolerated:.3g} deg; {used:.3g} % of H {carried}{marks}"


def _answer(springs: xr.DataTree, force: float, arm: float) -> xr.Dataset | str:
    """Return the answer of the springs to a load, extrapolated where they do not reach; else why there is none."""
    from pysprings.macro.predict import MacroWarning, predict

    try:
        with warnings.catch_warnings(action="ignore", category=MacroWarning):  # the attributes of the answer have them
            return predict(springs, H=force, arm=arm, extrapolate=True)
    except PyspringsError as error:
        if isinstance(error, UserInputError) and not isinstance(error, BeyondSprings):  # as of several rates
            return "; ".join(each.message for each in error.problems)
        return "the springs do not carry it"


def _tilt_on_path(run: Run, tolerated: float) -> str:
    """Give the load of a tilt [deg] on the highest pull with a free head, or its largest tilt."""
    pulls = [(name, path) for name, path in _lateral(run) if PATH_KINDS[str(path.attrs["kind"])].free_head]
    pulls = [each for each in pulls if height_of_load(each[1].attrs) is not None]
    if not pulls:
        return ""
    name, path = max(pulls, key=lambda item: float(item[1].attrs.get("arm_m", 0.0)))
    turn, load = np.degrees(np.abs(path["rotation"].values)), np.abs(path["H"].values)
    where, V = f"under a load at {float(path.attrs['arm_m']):g} m", path["V"].values
    reached = np.flatnonzero(turn >= tolerated)
    if not reached.size:
        at = int(turn.argmax())
        found = f"{turn[at]:.3g} deg at H {1e-6 * float(load[at]):.4g} MN {where} (path {name}{_under(path, V[at])})"
        return f"{found}; {tolerated:.3g} deg is not reached; no [design] load"
    k = int(reached[0])
    between = slice(max(k - 1, 0), k + 1)  # a path may turn back
    there, down = (float(np.interp(tolerated, turn[between], values[between])) for values in (load, V))
    under = f"(path {name}{_under(path, down)})"
    return f"{tolerated:.3g} deg at H {1e-6 * there:.4g} MN {where} {under}; no [design] load"


def _under(path: xr.Dataset, V: float) -> str:
    """Return words for a vertical load that is not that of the start of a path: w is held, or V changes on the way."""
    return "" if same_load(V, float(path["V"][0])) else f", V {1e-6 * V:.4g} MN"


def _range(run: Run) -> str:
    from pysprings.springs.springs import Springs

    calibrated = _calibrated(run)
    if not calibrated:
        return _NONE_CALIBRATED
    first, *others = calibrated
    fan = _is_fan(run)
    used = [calibrated[name] for name in (first, *(others if fan else ()))]
    u, turn = (max(float(np.abs(each[name]).max()) for each in used) for name in ("u", "rotation"))
    (u,), (turn,) = significant((u,), (turn,), run.scene.caisson.skirt_length)
    kind = "load heights of its rays" if fan else f"the load height of path {first} only"
    loading = "monotonic loading" + ", but for springs with memory" * any(
        path.remembers for path in paths_of(run.result).values()
    )
    text = f"u up to {1e3 * u:.3g} mm, rotation up to {math.degrees(turn):.3g} deg, {kind}; {loading}; in proportion"
    sets = () if run.springs is None else Springs.of(run.springs).rate_sets
    rates = ", ".join(f"{1e3 * each.rate:.3g}" for each in sets)
    return f"{text}; at {rates} mm/s (of rho)" if rates else text


def _mesh(run: Run) -> str:
    from pysprings.full_model.accuracy.two_mesh import short
    from pysprings.model.forecast.domain_effect import domain_effect

    estimate = run.record.error_estimate or {}
    most = domain_effect(run.scene).percent
    bounds = f"at most {percent(most['H'])} (K_H), {percent(most['M'])} (K_M)" if math.isfinite(most["H"]) else "far"
    domain = f"domain: stiffness {bounds} above unbounded soil"
    return f"{'estimated ' + short(estimate) if estimate.get('estimate_pct') else 'not estimated'}; {domain}"


def _springs(run: Run) -> str:
    from pysprings.springs.springs import Springs

    worst, checked = _held_back(run), _on_held_back(run)
    if worst is None or checked is None:
        if run.comparison is not None:
            return "not checked: no path of one direction with a free head is held back"
        return "none: too little converged" if run.scene.load_paths else "none: there is no path in one plane"
    errors = ", ".join(f"{name} {percent(value)}" for name, value in worst.items() if name not in _AT_LOAD)
    moved = f"; of u at equal load: {_of_u(worst)}" if _U in worst else ""
    paces = "" if run.springs is None else Springs.of(run.springs).paces(checked["path"])
    arms = dict.fromkeys(f"{arm:.4g}" for arm in sorted(checked["arm_m"]))
    heights = " to ".join([*arms][:: max(len(arms) - 1, 1)])
    return (
        f"against the full model on the paths held back{paces} (loads at {heights} m), "
        f"largest error at equal displacement: {errors}{moved}"
    )


def _of_u(worst: Mapping[str, float]) -> str:
    size, half = (number(worst.get(key, math.nan), 2) for key in (_U, _HALF))
    if _HALF not in worst or half == size:
        return f"{size} %"
    return f"{half} % up to half of the largest load, {size} % beyond"


def _warnings(run: Run) -> str:
    texts = [*run.record.failures, *run.record.warnings]
    return "none" if not texts else f"{len(texts)}: {texts[0]}" + (" ..." if len(texts) > 1 else "")


def _use(run: Run) -> str:
    """Say for what the springs may be used."""
    if run.comparison is None:
        return "no springs were made"
    if run.record.failures:
        return "not for design: the run did not come to its end"
    if not _calibrated(run):
        return _NONE_CALIBRATED
    if not _is_fan(run):
        return "only on the path that they were made from: other load heights need a fan ([springs] reach)"
    worst, limits = _held_back(run) or {}, []
    if not worst:
        limits.append("they were not checked on a path of their own")
    elif max(value for name, value in worst.items() if name not in _AT_LOAD) > _GOOD:
        limits.append(f"their error is above {_GOOD:g} % on a path held back")
    limits += _mesh_limits(run.record.error_estimate or {})
    moved = f", u under a load off by {_of_u(worst)}" if worst.get(_U, 0.0) > _GOOD else ""
    return f"predictions within the range{moved}" + (f"; preliminary: {'; '.join(limits)}" if limits else "")


def _mesh_limits(estimate: Mapping[str, Any]) -> list[str]:
    """Say where the error of the mesh is too large for design, and the remedy."""
    size = (estimate.get("estimate_pct") or {}).get("load_max")
    if size is None:
        return [f"the mesh error of load is unknown ({estimate.get('why_not', 'run it with --estimate-error')})"]
    if size <= _GOOD_MESH:
        return []
    by_path = {name: each.get("load_pct", 0.0) for name, each in (estimate.get("by_path") or {}).items()}
    path = max((name for name in by_path if by_path[name] <= size), key=by_path.__getitem__, default="")  # not of V
    on = f" on path {path}" if path else ""
    return [f"the mesh error of load is {percent(size)}{on}: run it with --target-error {_GOOD_MESH:g}%"]


def _lateral(run: Run) -> list[tuple[str, xr.Dataset]]:
    """Return the converged states before cavitation of the paths that move the caisson sideways, by name.

    They are extrapolated where they are in the result.
    """
    paths = [path for path in paths_of(run.result).values() if path.rules.drives != "w"]
    return [(path.name, before_cavitation(path.dataset)) for path in paths if path.dataset.sizes["step"] > 1]


def _calibrated(run: Run) -> dict[str, xr.Dataset]:
    """Return the paths of `_lateral` that springs are made from."""
    return {name: each for name, each in _lateral(run) if each.attrs.get("role") == "calibration"}


def _is_fan(run: Run) -> bool:
    return run.comparison is not None and bool((run.comparison["springs"] == "fan").any())


def _held_back(run: Run) -> dict[str, float] | None:
    """Return the largest errors of the fan (else of all families) on proportional paths held back.

    Those of H and rotation are at equal displacement; that of u, at equal load, grows without end near collapse.
    """
    own = _on_held_back(run)
    if own is None or own.empty:
        return None
    columns = {"H": "H_error_max_pct", "rotation": "rotation_error_max_pct"} | _AT_LOAD
    worst = {name: float(own[column].abs().max()) for name, column in columns.items()}
    return {name: value for name, value in worst.items() if math.isfinite(value)}


def _on_held_back(run: Run) -> pd.DataFrame | None:
    """Return the rows of the comparison that show what the springs of a run are worth in proportional loading."""
    frame = run.comparison
    if frame is None or frame.empty:
        return None
    own = frame[(frame["role"] == HELD_BACK) & (frame["springs"] == ("fan" if _is_fan(run) else "full"))]
    turning = {name for name, path in paths_of(run.result).items() if path.turns_back}  # or rest
    free = {name for name, kind in PATH_KINDS.items() if kind.free_head}
    return own[own["kind"].isin(free) & ~own["path"].isin(turning)]
