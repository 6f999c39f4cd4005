# SPDX-License-Identifier: MIT
"""Springs at the rate and vertical load of an export, and the header of files for other programs.

The header has origin, frame, units, conditions, range of validity, measured error.
"""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from pysprings.core.errors import refused
from pysprings.core.loads import close_loads, same_load
from pysprings.core.path_kinds import HELD_BACK, MEMORY, TWIST, VERTICAL
from pysprings.core.text import percent
from pysprings.core.version import __version__
from pysprings.results.exporters.base import Options, Source
from pysprings.springs.path import SpringPath
from pysprings.springs.springs import Springs
from pysprings.springs.sums import balance


def springs_at(source: Source, options: Options) -> tuple[Springs, float | None]:
    """Return the springs at the rate and vertical load of the options, and that load [N] (None: that at rest).

    Raises UserInputError: a vertical load beyond those of the lateral paths, whose springs would be those of another
    load.
    """
    springs = Springs.of(source.springs)
    springs = springs if options["rate"] is None else springs.at_rate(float(options["rate"]))
    if options["V"] is None:
        return springs.at(), None
    V = float(options["V"])
    known = [each.V for each in springs.load_sets]
    if known and not (known[0] < V < known[-1] or any(same_load(V, each) for each in known)):
        there = " to ".join(f"{1e-3 * each:.6g}" for each in sorted({known[0], known[-1]}))
        raise refused("--option V", f"{1e-3 * V:.6g} kN: lateral springs are known at V = {there} kN")
    return springs.at(V=V), V


_ROTATION = "rotation_error_max_pct"
_ERRORS = {
    "H_error_max_pct": "load", _ROTATION: "rotation", "M_error_max_pct": "moment",
    "u_error_max_pct": "displacement at equal load", "u_error_half_pct": "that up to half of the largest load",
    "V_error_max_pct": "vertical load", "T_error_max_pct": "T/R over the largest load",
}  # fmt: skip


_ALONE = (("H", "kN", "u", "mm"), ("M", "kN m", "rotation", "mrad"))  # of a pure translation, of a pure rotation
_PREDICT = ("fan", "full", "py")  # spring sets in the order in which `predict` takes them
# attributes of springs on their scene, and the words before them
_OF_SCENE = {"defaulted": "by default, not given in the scene", "remarks": "remarks on the scene"}
_STEEL = (
    "elastic caisson: these springs have the bending of its steel in them, for motions of the lid centre; a skirt that "
    "bends, too, would count it twice"
)
BACKBONE = "monotonic backbone of a nonlinear response, not cyclic"


def torsion_words(stiffness: float | None, springs: Springs) -> str:
    """Return a sentence on torsion, for the stiffness of the full model at rest; None: not known."""
    if stiffness is None:
        return "torsion is not known, no full model has computed it: rotation about z is free"
    words = "torsion is linear, with the stiffness of the full model at rest: friction is not in it"
    for path in springs.space.values():
        if path.kind == TWIST:
            turn, T = (each[:, -1] for each in (path.turns(), path.pushes()))
            k = int(np.abs(turn).argmax())
            sizes = f"{1e-6 * stiffness * turn[k]:.4g} MN m, {1e-6 * T[k]:.4g} in the full model"
            words += f"; at {1e3 * turn[k]:.3g} mrad (path {path.name}) T is {sizes}"
    return words


def header(
    source: Source, target: str, frame: str, units: str, use: str = BACKBONE, at: Springs | None = None, kind: str = ""
) -> list[str]:
    """Return the lines of a header, without comment signs.

    source : Springs of the export.
    target : Program and kind of file.
    frame, units : Axes with their signs, and units, of the numbers in the file.
    use : A sentence on the kind of loading that the numbers stand for.
    at : Springs of the numbers, at one rate and vertical load; None: all.
    kind : Spring set whose errors it has; that which predicts without one.
    """
    attrs, given = source.springs.attrs, Springs.of(source.springs)
    V, rates = None if at is None else at.path().load, [each.rate for each in given.rate_sets]
    if at is not None and rates and (own := at.attrs.get("rate_m_per_s", at.path().rate)):
        rates = [float(own)]
    rate = ", ".join(f"{1e3 * each:.4g} mm/s" for each in rates)
    return [
        f"{target}, written by pysprings {__version__}",
        f"scene: {attrs.get('title', 'not recorded')}; sha256 {attrs.get('scene_sha256', 'not recorded')}",
        f"springs by pysprings {attrs.get('pysprings_version', 'not recorded')}; "
        f"status {attrs.get('status', 'not recorded')}",
        *of_atlas(given),
        f"frame: {frame}",
        f"units: {units}",
        f"drainage: {given.drainage}; rate: {rate or 'none: the springs do not depend on it'}; "
        f"vertical load at rest: {given.rest_load / 1e3:.6g} kN",
        *([] if at is None else _by_load(at)),
        *(f"{words}: {attrs[name]}" for name, words in _OF_SCENE.items() if attrs.get(name)),
        use,
        *([_STEEL] if attrs.get("caisson_behaviour") == "elastic" else []),
        *_ranges(at or given),
        *_errors(source.comparison, given, V, kind),
        source.mesh_error or _mesh_error(at or given),
    ]


def of_atlas(springs: Springs) -> Iterator[str]:
    """Yield where springs of an atlas are from, what is outside, deviations of their stiffness, errors held back."""
    yield from springs.atlas_words
    if outside := str(springs.attrs.get("atlas_outside", "")):
        yield outside
    if springs.of_atlas:
        known = {name: springs.attrs.get(f"{name}_relative_deviation", np.nan) for name in ("K_H", "K_V", "K_M")}
        parts = ", ".join(f"{name} {percent(100.0 * float(value))}" for name, value in known.items())
        yield f"standard deviation of the initial stiffness: {parts}; of loads and motions: see `pysprings predict`"
        yield f"atlas: {springs.attrs.get('atlas', 'not recorded')}"


def _by_load(at: Springs) -> Iterator[str]:
    """Yield V of springs at one of several vertical loads, and what those at the others carry at equal motion."""
    V, every = at.path().load, at.whole or at
    others = [each.V for each in every.load_sets if not same_load(each.V, V)]
    yield f"lateral springs at V = {1e-3 * V:.6g} kN" + ": at another V they are not known" * (not others)
    for other in others:
        there, parts = every.at_load(other), []
        pure = zip(at.pure_paths or (), there.pure_paths or (), _ALONE, strict=False)
        for one, two, (load, unit, motion, small) in pure:
            paths = at.paths[one], there.paths[two]
            reach = min(float(np.abs(path[motion]).max()) for path in paths)
            own, their = (1e-3 * np.interp(reach, np.abs(path[motion]), np.abs(path[load])) for path in paths)
            at_reach = f"{1e3 * reach:.4g} {small} of {motion} alone"
            parts.append(
                f"{load} {their:.4g} {unit} in place of {own:.4g} ({100 * (their / own - 1):+.1f} %) at {at_reach}"
            )
        yield "; ".join([f"springs at V = {1e-3 * other:.6g} kN", *parts])


def _mesh_error(springs: Springs) -> str:
    """Return a sentence on the largest error that the mesh makes in the load of a path, by the run's own estimate."""
    known = {name: end.mesh_error for name, end in springs.ends.items() if np.isfinite(end.mesh_error)}
    if not known:
        return "discretisation error: not recorded beside these springs"
    worst = max(known, key=known.__getitem__)
    return f"estimated discretisation error of the load: {percent(known[worst])} at most (path {worst})"


def _ranges(springs: Springs) -> Iterator[str]:
    """Yield the largest motions and loads of the paths that springs are made from, and what failed."""
    paths = list(springs.paths.values())
    lateral = [path for path in paths if path.calibrates and not path.is_vertical]
    if lateral:
        most = {key: max(float(np.abs(path[key]).max()) for path in lateral) for key in ("u", "rotation", "H")}
        yield (
            f"range of the springs, {len(lateral)} lateral paths: |u| to {1e3 * most['u']:.4g} mm, |rotation| to "
            f"{1e3 * most['rotation']:.4g} mrad, |H| to {1e-3 * most['H']:.5g} kN; beyond it every use is an "
            "extrapolation"
        )
    down = [path for path in paths if path.calibrates and path.is_vertical]
    if down:
        w, V = (np.concatenate([path[key] for path in down]) for key in ("w", "V"))
        paces = dict.fromkeys(f"{1e3 * path.rate:.4g}" for path in down if path.rate and springs.rate_sets)
        yield (
            f"range of the springs, {len(down)} vertical paths: w from {1e3 * w.min():.4g} to {1e3 * w.max():.4g} mm, "
            f"V from {1e-3 * V.min():.5g} to {1e-3 * V.max():.5g} kN"
            + f", at {', '.join(paces)} mm/s of w"
            * bool(paces)
        )
    yield from (f"path {path.name} {path.end.words}" for path in paths if path.end.failed)


def _errors(comparison: pd.DataFrame, given: Springs, V: float | None, kind: str) -> Iterator[str]:
    """Yield the largest errors of a spring set, on held-back paths where there are any, and their paths.

    Blank is the set that predicts. Lateral paths are those at V [N], all without it.
    """
    here = (comparison["kind"] == VERTICAL) | (V is None or close_loads(comparison["V_N"].to_numpy(float), V))
    held_back = (comparison["role"] == HELD_BACK) & (comparison["kind"] != VERTICAL)
    if V is not None and not given.of_atlas and not (here & held_back).any():
        yield f"no path is held back at V = {1e-3 * V:.6g} kN: errors of lateral springs are not known there"
    sets = comparison[here].groupby("springs", sort=False)
    predict = kind or next((each for each in _PREDICT if each in sets.groups), None)
    for name, rows in sets:
        springs = str(name)
        if springs not in (predict, VERTICAL):
            continue
        held = rows[rows["role"] == HELD_BACK]
        used = held if len(held) else rows[(rows["role"] != MEMORY) | (springs == MEMORY)]
        parts = []
        for key in _ERRORS:
            sizes = used.get(key, pd.Series(np.nan, used.index)).abs()
            if np.isfinite(sizes).any():
                worst = used.iloc[int(np.nanargmax(sizes))]
                parts.append(f"{_error_words(key, worst)} {sizes.max():.2f} % ({worst['path']})")
        role = "held-back" if len(held) else "calibration"
        if parts:
            of = f"{len(used)} {role} paths{given.paces(used['path'])}"
            head = f"largest errors of springs {springs!s} against {given.reference}, {of}"
            yield f"{head}: {', '.join(parts)}"


def _error_words(key: str, row: pd.Series | dict) -> str:
    """Return the words of an error in a row of the comparison; off a plane (eta is NaN) rotation is at equal load."""
    return _ERRORS[key] + " at equal displacement" * (key == _ROTATION and bool(np.isfinite(row["eta_large"])))


def range_of_path(drainage: str, path: SpringPath) -> str:
    """Return a sentence on the calibrated range of a path, its load, and its balance."""
    missing = balance(path.dataset)
    ended = f" The path {path.end.words}." if path.end.failed else ""
    u, rotation, load = (float(np.abs(path[key]).max()) for key in ("u", "rotation", "H"))
    if path.is_vertical:
        w, V = path.w, path["V"]
        return (
            f"{drainage} vertical, {path.attrs['role']}, {path.attrs['status']}: "
            f"w from {1e3 * w[0]:.4g} to {1e3 * w[-1]:.4g} mm, "
            f"V from {1e-3 * V[0]:.5g} to {1e-3 * V[-1]:.5g} kN; out of balance by "
            f"{missing['V']:.1e} (V). Beyond this range every use is an extrapolation.{ended}"
        )
    height = f"load {path.arm:g} m above mudline, " if np.isfinite(path.arm) else ""
    if direction := float(path.attrs.get("direction_rad", 0.0)):
        height += f"in its own plane, {np.degrees(direction):.4g} deg from x towards y, "
    return (
        f"{drainage} {path.kind}, {height}"
        f"{path.attrs['role']}, {path.attrs['status']}: |u| to {round(1e3 * u, 9):.4g} mm, "
        f"|rotation| to {round(1e3 * rotation, 9):.4g} mrad, |H| to {1e-3 * load:.5g} kN, "
        f"{path.under(drainage)}; out of balance by {missing['H']:.1e} (H), {missing['M']:.1e} (M). "
        f"Beyond this range every use is an extrapolation.{ended}"
    )


def error_of_row(row: pd.Series | dict, reference: str) -> str:
    """Return a sentence on the errors of one row of the comparison with what the paths are recorded from."""
    parts = [
        f"{_error_words(key, row)} {round(row[key], 2) + 0.0:+.2f} %"
        for key in _ERRORS
        if np.isfinite(row.get(key, np.nan))
    ]
    source = f"springs from {row['springs_from']}, {row['role']} path"
    eta = f"; eta {row['eta_large']:.4f}" if np.isfinite(row["eta_large"]) else ""  # out of one plane there is none
    errors = f"largest error against {reference}: {', '.join(parts)}{eta}"
    return f"{errors} ({source}; {row['status']})"
