# SPDX-License-Identifier: MIT
"""An atlas beside full models that it was not made from: stiffness, load and rotation of pulls, its band of 95 %."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pysprings.core.errors import PyspringsError, UserInputError, refused
from pysprings.macro.fan_springs import BAND
from pysprings.scene.load import SceneText
from pysprings.springs.springs import Springs
from pysprings.studies.atlas.samples import scenes

if TYPE_CHECKING:
    import xarray as xr

    from pysprings.scene.model import Scene
    from pysprings.scene.sections import Path
    from pysprings.studies.atlas.model import Atlas

Array = NDArray[np.float64]
Source = TypeVar("Source", bound="Atlas")
AT = (0.001, 0.01)  # u/D
STIFFNESSES = {"K_V": (1, 1, "K_V_relative_deviation"), "K_H": (0, 0, "K_H_relative_deviation"),
               "K_M": (2, 2, "K_M_relative_deviation")}  # fmt: skip


def held_back(atlas: Atlas, data: xr.Dataset, at: tuple[float, ...] = AT) -> pd.DataFrame:
    """Return an atlas beside a study of pulls, a row a quantity.

    Columns: case, path, arm_over_D, u_over_D, quantity (K_V, K_H, K_M, H, rotation), full, atlas, error_pct,
    deviation_pct (one standard deviation), inside (1 within 1.96 of them), why_not (no answer).

    Raises
    ------
    UserInputError
        The study has no pulls, or scenes that are none of the family.
    """
    if "case" not in data.dims:
        raise refused("--held-back", "a check needs samples, not a grid of axes")
    text = SceneText(str(data.attrs["scene_toml"]), "the base scene of the held-back study")
    rows: list[dict[str, Any]] = []
    for number, scene in enumerate(scenes(data, text)):
        case = data.isel(case=number)
        if not np.isfinite(float(case["K_H"])):
            continue
        rows += [{"case": number + 1, **row} for row in _case(atlas, case, scene, at)]
    if not rows:
        raise refused("--held-back", "no case of the study has springs")
    return pd.DataFrame(rows)


def _case(atlas: Atlas, case: xr.Dataset, scene: Scene, at: tuple[float, ...]) -> Iterator[dict[str, Any]]:
    try:
        springs = Springs.of(atlas.springs(_plain(atlas, scene)))
    except UserInputError as error:
        yield {"quantity": "all", "why_not": error.problems[0].message}
        return
    matrix = springs.stiffness
    assert matrix is not None
    for name, (row, column, key) in STIFFNESSES.items():
        full, own = float(case["stiffness_initial"][row, column]), float(matrix[row, column])
        yield _row(name, full, own, float(springs.attrs[key]) * own)
    for path in scene.load_paths:
        if path.kind == "pull":
            yield from _pull(springs, case.sel(path=path.name), scene, path, at)


def _plain(atlas: Atlas, scene: Scene) -> Scene:
    """Return the scene with the rays of the atlas in place of its pulls."""
    return scene.replace(paths=(), springs=atlas.base.springs.model_dump()) if scene.paths else scene


def _pull(
    springs: Springs, case: xr.Dataset, scene: Scene, path: Path, at: tuple[float, ...]
) -> Iterator[dict[str, Any]]:
    from pysprings.macro import predict

    D, aim, arm = scene.caisson.outer_diameter, float(path.lateral_displacement or 0.0), float(path.arm or 0.0)
    for share in at:
        place = {"path": path.name, "arm_over_D": arm / D, "u_over_D": share}
        u = share * D
        if u > aim * (1.0 + 1e-9):
            continue
        full = {name: _read(case, name, u / aim) for name in ("H", "rotation")}
        if not all(map(np.isfinite, full.values())):
            yield {**place, "quantity": "all", "why_not": "the full model stopped before"}
            continue
        try:
            with warnings.catch_warnings():  # of the edge of the atlas: the table has every case
                warnings.simplefilter("ignore")
                answer = predict.impose(springs, u=u, arm=arm)
        except PyspringsError as error:
            yield {**place, "quantity": "all", "why_not": str(error).split("\n")[0]}
            continue
        for name, value in full.items():
            yield place | _row(name, value, float(answer[name]), float(answer[f"{name}_deviation"]))


def _read(case: xr.Dataset, name: str, share: float) -> float:
    """Return a quantity at a share of the aim, by cubic interpolation of its secant over log share."""
    from scipy.interpolate import PchipInterpolator

    shares, values = case["share"].values[1:], case[name].values[1:].astype(float)
    known = np.isfinite(values)
    if not known.any() or share > shares[known][-1] * (1.0 + 1e-6):
        return float("nan")
    return float(PchipInterpolator(np.log(shares[known]), values[known] / shares[known])(np.log(share))) * share


def _row(quantity: str, full: float, own: float, deviation: float) -> dict[str, Any]:
    return {
        "quantity": quantity, "full": full, "atlas": own, "error_pct": 100.0 * (own / full - 1.0),
        "deviation_pct": 100.0 * abs(deviation / full), "inside": int(abs(own - full) <= BAND * deviation),
        "why_not": "",
    }  # fmt: skip


def calibrated(atlas: Source, data: xr.Dataset, at: tuple[float, ...] = AT) -> tuple[Source, pd.DataFrame]:
    """Return the atlas with the deviations of its fan from held-back pulls, and the table of `held_back`.

    The deviations of the atlas are those of all cases. Each case of the table is judged by those of the other half of
    the cases, so that no case decides on its own band.
    """
    parts = [held_back(replace(atlas, fan=fan), data, at) for fan in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))]
    table = parts[0]
    answered = (table["quantity"] != "all").to_numpy()
    base, *more = (part["deviation_pct"].to_numpy(dtype=float) ** 2 for part in parts)
    shares = [np.maximum(each - base, 0.0) for each in more]
    error = table["error_pct"].abs().to_numpy(dtype=float)
    of_pull = answered & table["quantity"].isin(("H", "rotation")).to_numpy()
    half = table["case"].to_numpy() % 2
    deviation = np.sqrt(base)
    for side in (0, 1):
        fan = _fan(error, base, shares, of_pull & (half != side), table["quantity"].to_numpy())
        own = of_pull & (half == side)
        deviation[own] = np.sqrt(base + fan[0] ** 2 * shares[0] + fan[1] ** 2 * shares[1])[own]
    table["deviation_pct"] = deviation
    table["inside"] = np.where(answered, (error <= BAND * deviation).astype(float), np.nan)
    return replace(atlas, fan=_fan(error, base, shares, of_pull, table["quantity"].to_numpy())), table


def _fan(error: Array, base: Array, shares: list[Array], rows: NDArray[np.bool_], names: Any) -> tuple[float, float]:
    """Return the least deviations of a fan for which 95 % of the loads and of the rotations lie in their bands."""
    if not rows.any():
        return 0.0, 0.0

    def inside(fan: tuple[float, float], name: str) -> float:
        own = rows & (names == name)
        deviation = np.sqrt(base + fan[0] ** 2 * shares[0] + fan[1] ** 2 * shares[1])
        return float((error <= BAND * deviation)[own].mean())

    steps = np.arange(0.0, 0.1001, 0.0005)
    second = next((b for b in steps if inside((0.0, b), "rotation") >= 0.95), steps[-1])
    first = next((a for a in steps if inside((a, second), "H") >= 0.95), steps[-1])
    return float(first), float(second)


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """Return errors by quantity and displacement: count, root mean square, 95 %, largest, share inside the band."""
    rows = []
    answered = table[table["quantity"] != "all"]
    for (quantity, u), part in answered.groupby(["quantity", answered["u_over_D"].fillna(0.0)], sort=False):
        size = part["error_pct"].abs()
        rows.append({
            "quantity": quantity, "u_over_D": u, "count": len(part), "caissons": part["case"].nunique(),
            "mean_pct": part["error_pct"].mean(), "rms_pct": float(np.sqrt((size**2).mean())),
            "p95_pct": size.quantile(0.95), "largest_pct": size.max(), "inside_pct": 100.0 * part["inside"].mean(),
        })  # fmt: skip
    return pd.DataFrame(rows)
