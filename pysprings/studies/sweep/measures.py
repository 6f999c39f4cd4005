# SPDX-License-Identifier: MIT
"""What a study keeps of a case: loads and springs of its paths on a grid that all cases share.

The grid has shares of the aim of a path (`SHARES`) and of the skirt length (`DEPTHS` slices). Reactions by depth are
remapped such that their sum stays; what their moment about mudline loses is put into m, so that it stays, too.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path as FilePath

import numpy as np
from numpy.typing import NDArray

from pysprings.core.errors import PyspringsError
from pysprings.core.path_kinds import PATH_KINDS
from pysprings.full_model.run_record import RunRecord
from pysprings.macro.fan import secant_slopes
from pysprings.scene.model import Scene
from pysprings.scene.sections import Path
from pysprings.springs.checks import open_springs
from pysprings.springs.path import SpringPath
from pysprings.springs.springs import Springs

Array = NDArray[np.float64]

SHARES: Array = np.concatenate([[0.0], np.geomspace(1e-3, 1.0, 24)])
DEPTHS = 8
STATES = ("u", "w", "rotation", "H", "V", "M")
ENDS = ("H_tip", "M_tip", "V_tip", "H_lid", "M_lid", "V_lid")
BY_DEPTH = ("p", "m", "t")
_DRIVEN = {"lateral_displacement": "u", "rotation": "rotation", "vertical_displacement": "w", "lateral_force": "H"}


@dataclass(frozen=True)
class Measured:
    """One case on the common grid.

    Attributes
    ----------
    stiffness : initial stiffness (3, 3) for (u, w, rotation).
    along : (path, share) of STATES and ENDS, by name; NaN where the path ended before.
    by_depth : (path, depth, share) of BY_DEPTH, by name.
    reached : share of the aim, by path; limit : 1 where the path ended at a limit load.
    numbers : one number each: cost, size, error.
    """

    stiffness: Array
    along: Mapping[str, Array]
    by_depth: Mapping[str, Array]
    reached: Array
    limit: Array
    numbers: Mapping[str, float]


def measure(folder: FilePath, scene: Scene, paths: tuple[str, ...]) -> Measured | None:
    """Return a case by its folder; None where it has no springs."""
    try:
        springs = Springs.of(open_springs(folder / "springs.nc"))
    except PyspringsError:
        return None
    n, k, known = len(paths), len(SHARES), {path.name: path for path in scene.load_paths}
    along = {name: np.full((n, k), np.nan) for name in (*STATES, *ENDS)}
    by_depth = {name: np.full((n, DEPTHS, k), np.nan) for name in BY_DEPTH}
    reached, limit = np.zeros(n), np.zeros(n)
    for row, name in enumerate(paths):
        path = springs.paths.get(name)
        if path is None or name not in known or path.n < 2:
            continue
        share = shares_of(path, known[name])
        reached[row], limit[row] = min(share[-1], 1.0), float(path.end.how == "limit load")
        for each in (*STATES, *ENDS):
            along[each][row] = _resampled(share, path[each])
        _put_depths(path, share, by_depth, row)
    stiffness = springs.stiffness
    matrix = np.full((3, 3), np.nan) if stiffness is None else stiffness
    return Measured(matrix, along, by_depth, reached, limit, _numbers(folder))


def shares_of(path: SpringPath, asked: Path) -> Array:
    """Return how far a path has come towards its aim, by state, as far as that grows."""
    kind = PATH_KINDS[asked.kind]
    aim = getattr(asked, kind.imposed)
    values = path[_DRIVEN[kind.imposed]]
    if kind.conjugate or aim is None or aim == 0.0:
        return np.linspace(0.0, 1.0, path.n)
    share = values / aim
    falls = np.flatnonzero(np.diff(share) <= 0.0)
    grown: Array = share[: falls[0] + 1] if falls.size else share
    return grown


def _resampled(share: Array, values: Array) -> Array:
    """Return values (..., step) at SHARES; NaN beyond the last one.

    Cubic in the share as a fan is (`pysprings.macro.fan.secant_slopes`), and linear in the values: sums stay sums.
    """
    from scipy.interpolate import CubicHermiteSpline

    n = len(share)
    if n < 2 or share[1] <= 0.0:
        return np.full((*values.shape[:-1], len(SHARES)), np.nan)
    rows = np.atleast_2d(values[..., :n])
    slopes = secant_slopes(share, rows, (rows[:, 1] - rows[:, 0]) / share[1])
    answer: Array = CubicHermiteSpline(share, rows, slopes, axis=-1)(SHARES)
    answer[:, share[-1] * (1.0 + 1e-9) < SHARES] = np.nan
    return answer.reshape((*values.shape[:-1], len(SHARES)))


def _put_depths(path: SpringPath, share: Array, by_depth: Mapping[str, Array], row: int) -> None:
    """Remap the reactions by depth of a path."""
    weights = remap(path.recorded["depth_bounds"].values, path.length)
    slices = path.length / DEPTHS
    middle = (np.arange(DEPTHS) + 0.5) * slices
    recorded = {name: path.by_depth(name) for name in BY_DEPTH}
    mapped = {name: weights @ values / slices for name, values in recorded.items()}
    lost = (path.depth * path.heights) @ recorded["p"] - (middle * slices) @ mapped["p"]
    mapped["m"] = mapped["m"] - lost / path.length
    for name, values in mapped.items():
        by_depth[name][row] = _resampled(share, values)


def remap(bounds: Array, length: float) -> Array:
    """Return the height that each slice (columns) shares with each slice of the grid (rows) [m]."""
    edges = np.linspace(0.0, length, DEPTHS + 1)
    low = np.maximum(edges[:-1, None], bounds[None, :, 0])
    high = np.minimum(edges[1:, None], bounds[None, :, 1])
    return np.maximum(high - low, 0.0)


def _numbers(folder: FilePath) -> dict[str, float]:
    """Return cost, size and error of a case by its record."""
    record = RunRecord.read(folder)
    if record is None:
        return {}
    how = (record.error_estimate or {}).get("extrapolated", {})
    lost = [value for path in (record.balance or {}).values() for value in path.values()]
    return {
        "wall_s": record.wall_s, "cpu_s": record.cpu_s, "peak_memory_bytes": float(record.peak_memory_bytes),
        "unknowns": float(record.mesh.unknowns or 0), "balance_error": max(lost, default=float("nan")),
        "iterations": float(sum(path.iterations for path in record.paths.values())),
        "extrapolated": len(how.get("paths", ())) / max(len(record.paths), 1),
    }  # fmt: skip
