# SPDX-License-Identifier: MIT
"""Parts of a result with the settings of the run: a path, the symmetry-plane section, the Newton record, a step.

Beside them the zones without contact around the skirt, and the attempts of a Newton record.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import xarray as xr

from pysprings.core.arrays import Array, Integers, Marks
from pysprings.core.path_kinds import driven
from pysprings.full_model.run_record import ATTRIBUTE, RunRecord
from pysprings.springs.path import paths_of
from pysprings.springs.path_ends import before_cavitation


def node(tree: xr.DataTree, path: str) -> xr.DataTree:
    """Return a group of a tree; the path of a variable is an error."""
    part = tree[path]
    if not isinstance(part, xr.DataTree):
        raise KeyError(f"{path} is not a group")
    return part


def path_names(tree: xr.DataTree, role: str | None = None) -> list[str]:
    """Return the load paths of a tree, in order; only those of a role when it is given."""
    return [name for name, path in paths_of(tree).items() if role in (None, path.attrs.get("role"))]


def path_data(tree: xr.DataTree, name: str) -> xr.Dataset:
    """Return one path as a Dataset whose attrs also hold the settings of the whole run.

    Parameters
    ----------
    tree : Result (``full_model.nc``) or spring set (``springs.nc``).
    name : Name of the path.

    Returns
    -------
    xarray.Dataset
        The path's variables (SI); attrs ``path``, ``drainage``, ``outer_diameter_m``, ``skirt_length_m`` are
        added when the tree holds them, so that a figure needs nothing else; ``cavitates`` has the motion beyond which
        its water would.
    """
    path = paths_of(tree)[name].recorded
    attrs, known = {**settings(tree), **path.attrs, "path": name}, before_cavitation(path)
    if known.sizes["step"] < path.sizes["step"]:
        motion = driven(path.attrs)
        unit = "mrad" if motion == "rotation" else "mm"
        attrs["cavitates"] = f"{motion} = {MM * float(known[motion][-1]):.3g} {unit}"
    return path.assign_attrs(attrs)


def section_data(tree: xr.DataTree) -> xr.Dataset | None:
    """Return the symmetry-plane section with the run's settings as attrs, None when there is none."""
    if "section" not in tree.children:
        return None
    section = node(tree, "section").to_dataset(inherit=False)
    return section.assign_attrs({**settings(tree), **section.attrs}) if "section_quad" in section else None


def convergence_data(tree: xr.DataTree, name: str) -> xr.Dataset | None:
    """Return the Newton record of a path with the run's settings as attrs, None when there is none."""
    if "convergence" not in node(tree, f"paths/{name}").children:
        return None
    record = node(tree, f"paths/{name}/convergence").to_dataset(inherit=False)
    return record.assign_attrs({**settings(tree), **record.attrs, "path": name})


ROUNDING = 1e-6  # share of the larger one of |H| arm and |M| below which the other one is zero
SETTINGS = (
    "drainage", "outer_diameter_m", "skirt_length_m", "skirt_thickness_m", "lid_thickness_m", "caisson_behaviour",
    "status", "mesh_preset", "n_nodes", "n_elements", "n_unknowns",
)  # fmt: skip


def settings(tree: xr.DataTree) -> dict[str, Any]:
    """Collect drainage, caisson size [m], mesh counts and solver tolerance of a run from its attrs."""
    attrs = tree.root.attrs
    values: dict[str, Any] = {key: attrs[key] for key in SETTINGS if key in attrs}
    tolerance = _tolerance(str(attrs.get(ATTRIBUTE, "")))
    return values if tolerance is None else {**values, "tolerance": tolerance}


@lru_cache(maxsize=8)
def _tolerance(run_json: str) -> float | None:
    """Return the tolerance of the solver in the record of a run; None without one. The text is parsed once."""
    record = RunRecord.from_text(run_json) if run_json else None
    return None if record is None or record.solver.tolerance is None else float(record.solver.tolerance)


def converged(path: xr.Dataset) -> Marks:
    """Return which steps of a path (or of a prediction) converged, shape (step,)."""
    if "converged" not in path:
        return np.ones(path.sizes["step"], dtype=bool)
    return path["converged"].values.astype(bool)


def load_sizes(paths: Iterable[xr.Dataset], arm: float) -> dict[str, float]:
    """Return the largest |H| `arm` and |M| of paths [N m]; 0 for one that is rounding beside the other."""
    sizes = {"H": 0.0, "M": 0.0}
    for path in paths:
        for load, by in (("H", arm), ("M", 1.0)):
            sizes[load] = max(sizes[load], by * float(np.abs(path[load].values).max(initial=0.0)))
    return {load: size if size > ROUNDING * max(sizes.values()) else 0.0 for load, size in sizes.items()}


def pick_step(path: xr.Dataset, step: int | None = None, displacement: float | None = None) -> int:
    """Choose a step: the given one, else the converged one nearest to a displacement [m], else the last.

    path : One path of a result.
    step : Index of a step; taken as it is.
    displacement : Lateral displacement u of the lid centre [m].
    """
    if step is not None:
        if not -path.sizes["step"] <= step < path.sizes["step"]:
            raise IndexError(f"step {step} is not among the {path.sizes['step']} steps of the path")
        return int(step) % path.sizes["step"]
    good = np.flatnonzero(converged(path))
    if good.size == 0:
        return 0
    if displacement is None:
        return int(good[-1])
    return int(good[np.argmin(np.abs(path["u"].values[good] - displacement))])


MM, DEG = 1e3, 180.0 / np.pi  # from SI to the units of the texts


@dataclass(frozen=True)
class Opening:
    """The widest opening of one surface: width [m] and a description of its place."""

    surface: str
    width: float
    place: str

    def text(self) -> str:
        """Return a label of two lines: ``outside: max 0.043 mm``, ``at azimuth 180 deg, depth 0.25 m``."""
        if not self.width > 0:
            return f"{self.surface}: closed everywhere"
        return f"{self.surface}: max {self.width * MM:.3g} mm\nat {self.place}"


def openings(path: xr.Dataset, step: int) -> list[Opening]:
    """Return the widest opening [m] of each surface of the caisson at a step, with its place."""
    widest = [_skirt_opening(path, step, str(side)) for side in path["side"].values]
    for surface, name in (("lid", "under the lid"), ("tip", "under the tip")):
        if f"{surface}_gap" in path:
            widest.append(_plan_opening(path, step, surface, name))
    return widest


def skirt_gap(path: xr.Dataset, step: int, side: str) -> Array:
    """Return the opening [m] of one side, shape (depth, azimuth); penetration counts as closed."""
    values = path["gap"].sel(side=side).transpose("step", "depth", "azimuth").values[step]
    return np.maximum(values, 0.0)


def _skirt_opening(path: xr.Dataset, step: int, side: str) -> Opening:
    gap = skirt_gap(path, step, side)
    if not np.isfinite(gap).any():
        return Opening(side, 0.0, "")
    k, i = np.unravel_index(np.nanargmax(gap), gap.shape)
    place = f"azimuth {path['azimuth'].values[i] * DEG:.0f}°, depth {path['depth'].values[k]:.2f} m"
    return Opening(side, float(gap[k, i]), place)


def _plan_opening(path: xr.Dataset, step: int, surface: str, name: str) -> Opening:
    x, y, gap = plan_gap(path, step, surface)
    if not np.isfinite(gap).any():
        return Opening(name, 0.0, "")
    k = int(np.nanargmax(gap))
    place = f"azimuth {np.arctan2(abs(y[k]), x[k]) * DEG:.0f}°, radius {np.hypot(x[k], y[k]):.2f} m"
    return Opening(name, float(gap[k]), place)


def plan_gap(path: xr.Dataset, step: int, surface: str) -> tuple[Array, ...]:
    """Return x, y and opening [m] of the stations under the lid or the tip, each (point,)."""
    gap = path[f"{surface}_gap"].transpose("step", f"{surface}_point").values[step]
    return path[f"{surface}_x"].values, path[f"{surface}_y"].values, np.maximum(gap, 0.0)


_STOPPED = ("partial", "limit load")


@dataclass(frozen=True)
class Attempt:
    """One try at an increment: step, number, rows in the record, iterations taken, whether the step kept it.

    The first row (iteration 0) is the residual before the first iteration.
    """

    step: int
    number: int
    rows: Integers
    iterations: int
    accepted: bool


def failed_steps(path: xr.Dataset, record: xr.Dataset) -> tuple[int, ...]:
    """Return the steps of a record that were never accepted: marked so, or the one behind the last step of a path."""
    failed = {int(k) for k in np.flatnonzero(~converged(path))}
    last = int(record["increment"].values[-1]) if record.sizes["iteration"] else 0
    if path.attrs.get("status") in _STOPPED and last >= path.sizes["step"]:
        failed.add(last)
    return tuple(sorted(failed))


def attempts(record: xr.Dataset, failed_steps: tuple[int, ...] = ()) -> list[Attempt]:
    """Split a Newton record in attempts, in their order.

    The last attempt at a step is the accepted one, the earlier ones were cut back; a step in `failed_steps`
    has no accepted attempt.
    """
    step, number = record["increment"].values, record["attempt"].values
    changes = np.flatnonzero((np.diff(step) != 0) | (np.diff(number) != 0)) + 1
    blocks = [rows for rows in np.split(np.arange(step.size), changes) if rows.size]
    tries = []
    for k, rows in enumerate(blocks):
        this = int(step[rows[0]])
        last = k + 1 == len(blocks) or int(step[blocks[k + 1][0]]) != this
        taken = int(record["iteration"].values[rows].max())
        tries.append(Attempt(this, int(number[rows[0]]), rows, taken, last and this not in failed_steps))
    return tries
