# SPDX-License-Identifier: MIT
"""study.nc -> what an atlas learns from: inputs, reactions over F h(X) on a grid of ray and X, stiffness.

Rows of a state, in this order: forces p dz of the slices, H_tip, H_lid, t dz of the slices, V_tip, V_lid; moments m dz
of the slices, M_tip, M_lid; w. Forces are over F h, moments over F L h, w over rho; all are changes from the state at
rest.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from pysprings.core.arrays import Array
from pysprings.core.errors import refused
from pysprings.scene.changes import Change
from pysprings.scene.load import SceneText
from pysprings.scene.model import Scene
from pysprings.springs.sums import secant_slopes
from pysprings.studies.atlas.families import Family
from pysprings.studies.sweep.dataset import DEPTHS
from pysprings.studies.sweep.plan import quantity

FORCES = (*(f"p{k}" for k in range(DEPTHS)), "H_tip", "H_lid", *(f"t{k}" for k in range(DEPTHS)), "V_tip", "V_lid")
MOMENTS = (*(f"m{k}" for k in range(DEPTHS)), "M_tip", "M_lid")
ROWS = (*FORCES, *MOMENTS, "w")
POINTS = 26  # of X
FEWEST = 10  # cases that reach the end of X at the least


@dataclass(frozen=True)
class Samples:
    """The full models of a study.

    scene : text of the base scene.
    inputs : (n, d) inputs of the family.
    rays, angles : names and directions [rad] of the rays.
    X : (k,) grid.
    values : (n, ray, row, k); NaN beyond what a case reached.
    stiffness : (n, 4) logarithmic Cholesky factors of the initial stiffness: `factors`.
    settled : (n,) settlement at rest over D/ratio.
    reach : largest rho over D of the rays.
    failed : number of cases of the study that are left out.
    extrapolated : whether all paths of all cases have the reactions of two meshes.
    """

    scene: SceneText
    inputs: Array
    rays: tuple[str, ...]
    angles: Array
    X: Array
    values: Array
    stiffness: Array
    settled: Array
    reach: float
    failed: int = 0
    extrapolated: bool = False


def share(X: Array) -> Array:
    """Return h(X) = X/(1 + X)."""
    return X / (1.0 + X)


def scenes(data: xr.Dataset, text: SceneText) -> list[Scene]:
    """Return the scene of every case of a study."""
    axes = str(data.attrs["axes"]).split(", ")
    keys = [each.split(" ") for each in str(data.attrs["axis_keys"]).split("; ")]
    columns = [(data[axis].values, str(data[axis].attrs.get("units", "1"))) for axis in axes]
    answer = []
    for k in range(data.sizes["case"]):
        changes = [
            Change(tuple(key.split(".")), _value(values[k], "" if unit == "1" else unit))
            for (values, unit), names in zip(columns, keys, strict=True)
            for key in names
        ]
        answer.append(text.scene(changes))
    return answer


def _value(value: Any, unit: str) -> str | float:
    """Return a value of an axis as TOML has it: a text stays as it is."""
    return value if isinstance(value, str) else quantity(float(value), unit)


def read_samples(data: xr.Dataset, family: Family) -> Samples:
    """Return what an atlas learns from a study of samples.

    Raises UserInputError: a grid or too few cases; scenes that are none of the family.
    """
    if "case" not in data.dims:
        raise refused("study", "an atlas needs samples (a Latin hypercube or a table), not a grid of axes")
    text = SceneText(str(data.attrs["scene_toml"]), "the base scene of the study")
    base = text.scene()
    known = scenes(data, text)
    whole = np.isfinite(data["H"].values[:, :, 1]).all(axis=1) & np.isfinite(data["K_H"].values)
    good = np.flatnonzero(whole)
    if good.size < 2 * FEWEST:
        raise refused("study", f"{good.size} cases with springs: an atlas needs {2 * FEWEST} at the least")
    chosen = [known[k] for k in good]
    for scene in chosen:
        family.check(scene, base)
    data = data.isel(case=good)
    sizes = [family.sizes(scene) for scene in chosen]
    force, ratio = np.array([each.force for each in sizes]), np.array([each.ratio for each in sizes])
    D, L = (np.array([getattr(scene.caisson, name) for scene in chosen]) for name in ("outer_diameter", "skirt_length"))
    u, turn = data["u"].values.astype(float), data["rotation"].values.astype(float) * L[:, None, None]
    rho = np.hypot(u, turn)
    reach = ratio[:, None] * np.nanmax(rho, axis=2) / D[:, None]  # X
    ends = np.sort(reach.min(axis=1))
    X = np.geomspace(np.median(ratio[:, None] * rho[:, :, 1] / D[:, None]), ends[-min(FEWEST, ends.size)], POINTS)
    rows = _rows(data, force, ratio / D, L)
    values = np.stack([_on_grid(X, ratio[k] * rho[k] / D[k], rows[k]) for k in range(good.size)])
    scale = np.where(np.array(ROWS) == "w", 1.0, share(X)[:, None] / X[:, None]).T  # w is over rho, not over h
    return Samples(
        text, np.stack([family.read(scene) for scene in chosen]), tuple(str(name) for name in data["path"].values),
        _angles(u, turn), X, values / scale, factors(data["stiffness_initial"].values, force, ratio, D, L),
        data["w"].values[:, 0, 0].astype(float) * ratio / D, float(np.nanmax(rho / D[:, None, None])),
        int((~whole).sum()), bool((data["extrapolated"].values == 1.0).all()),
    )  # fmt: skip


def _angles(u: Array, turn: Array) -> Array:
    """Return the directions of the rays of the first case, which all cases share."""
    angles = np.arctan2(turn[:, :, 1], u[:, :, 1])
    if np.abs(angles - angles[0]).max() > 1e-3:
        raise refused("study", "the paths of the cases are no rays of the same directions")
    return angles[0]


def _rows(data: xr.Dataset, force: Array, stretch: Array, L: Array) -> Array:
    """Return the rows over F, F L, D/ratio (n, ray, row, share); stretch is ratio/D [1/m]."""
    dz = (L / DEPTHS)[:, None, None, None]

    def changes(name: str) -> Array:
        values = data[name].values.astype(float)
        return values - values[..., :1]

    def by_depth(name: str) -> Array:
        return changes(name) * dz

    def ends(*names: str) -> Array:
        return np.stack([changes(name) for name in names], axis=2)

    over = force[:, None, None, None]
    forces = np.concatenate([by_depth("p"), ends("H_tip", "H_lid"), by_depth("t"), ends("V_tip", "V_lid")], axis=2)
    moments = np.concatenate([by_depth("m"), ends("M_tip", "M_lid")], axis=2)
    return np.concatenate([forces / over, moments / (over * L[:, None, None, None]),
                           ends("w") * stretch[:, None, None, None]], axis=2)  # fmt: skip


def _on_grid(X: Array, own: Array, rows: Array) -> Array:
    """Return rows (ray, row, share) at own X (ray, share) on the grid, over X: NaN beyond, linear below the first."""
    from scipy.interpolate import CubicHermiteSpline

    out = np.full((*rows.shape[:2], X.size), np.nan)
    for ray, (x, r) in enumerate(zip(own, rows, strict=True)):
        known = np.isfinite(x) & np.isfinite(r).all(axis=0)
        x, r = x[known], r[:, known]
        slopes = secant_slopes(x, r, r[:, 1] / x[1])
        values: Any = CubicHermiteSpline(x, r, slopes, axis=-1)(np.maximum(X, x[1])) / np.maximum(X, x[1])
        values[:, x[-1] * (1.0 + 1e-6) < X] = np.nan
        out[ray] = values
    return out


def factors(stiffness: Array, force: Array, ratio: Array, D: Array, L: Array) -> Array:
    """Return (n, 4) numbers of stiffnesses (n, 3, 3) that any real numbers make positive definite.

    log of K_V, log of the Cholesky factor's diagonal and its other entry over the first one, of the lateral part for
    (u, rotation*L); all over F ratio/D.
    """
    over = force * ratio / D
    lateral = stiffness[:, ::2, ::2] / over[:, None, None]
    lateral = lateral / np.stack([np.stack([np.ones_like(L), L]), np.stack([L, L**2])]).transpose(2, 0, 1)
    lower = np.linalg.cholesky(0.5 * (lateral + lateral.transpose(0, 2, 1)))
    return np.stack([
        np.log(stiffness[:, 1, 1] / over), np.log(lower[:, 0, 0]), lower[:, 1, 0] / lower[:, 0, 0],
        np.log(lower[:, 1, 1]),
    ], axis=1)  # fmt: skip


def stiffness_of(factor: Array, force: float, ratio: float, D: float, L: float) -> Array:
    """Return the stiffness (3, 3) of numbers (4,) of `factors`."""
    a = np.exp(factor[1])
    lower = np.array([[a, 0.0], [factor[2] * a, np.exp(factor[3])]])
    lateral = lower @ lower.T * np.array([[1.0, L], [L, L * L]])
    matrix = np.zeros((3, 3))
    matrix[::2, ::2], matrix[1, 1] = lateral, np.exp(factor[0])
    return np.asarray(matrix * force * ratio / D)
