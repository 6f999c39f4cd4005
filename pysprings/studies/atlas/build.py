# SPDX-License-Identifier: MIT
"""Samples of a study -> an atlas: principal components, a Gaussian process each; cases left out, held-back models."""

import warnings
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pandas as pd
import xarray as xr

from pysprings.core.arrays import Array, Marks
from pysprings.core.errors import PyspringsError, UserInputError, refused
from pysprings.core.text import percent
from pysprings.core.variables import EXTRAPOLATED
from pysprings.core.version import __version__
from pysprings.macro.fan_springs import BAND
from pysprings.scene.load import SceneText
from pysprings.scene.model import Scene
from pysprings.scene.sections import Path as ScenePath
from pysprings.springs.springs import Springs
from pysprings.studies.atlas.between import Process, filled, fit
from pysprings.studies.atlas.families import Family
from pysprings.studies.atlas.model import Atlas, scale_of, sums
from pysprings.studies.atlas.samples import Samples, read_samples, scenes
from pysprings.studies.sweep.dataset import open_study

Source = TypeVar("Source", bound="Atlas")
AT = (0.001, 0.01)  # u/D
STIFFNESSES = {"K_V": (1, 1, "K_V_relative_deviation"), "K_H": (0, 0, "K_H_relative_deviation"),
               "K_M": (2, 2, "K_M_relative_deviation")}  # fmt: skip


def held_back(atlas: Atlas, data: xr.Dataset, at: tuple[float, ...] = AT) -> pd.DataFrame:
    """Return an atlas beside a study of pulls, a row a quantity.

    Columns: case, path, arm_over_D, u_over_D, quantity (K_V, K_H, K_M, H, rotation), full, atlas, error_pct,
    deviation_pct (one standard deviation), inside (1 within 1.96 of them), why_not (no answer).

    Raises UserInputError: the study has no pulls, or scenes that are none of the family.
    """
    if "case" not in data.dims:
        raise refused("--held-back", "a check needs samples, not a grid of axes")
    text = SceneText(str(data.attrs["scene_toml"]), "the base scene of the held-back study")
    rows: list[dict[str, Any]] = []
    for number, scene in enumerate(scenes(data, text)):
        case = data.isel(case=number)
        if not np.isfinite(float(case["K_H"])):
            continue
        rows += [{"case": int(case["case_number"]), **row} for row in _case(atlas, case, scene, at)]
    if not rows:
        raise refused("--held-back", "no case of the study has springs")
    return pd.DataFrame(rows)


def _case(atlas: Atlas, case: xr.Dataset, scene: Scene, at: tuple[float, ...]) -> Iterator[dict[str, Any]]:
    try:
        rays = atlas.base.springs.model_dump()  # in place of the pulls
        springs = Springs.of(atlas.springs(scene.replace(paths=(), springs=rays) if scene.paths else scene))
    except UserInputError as error:
        yield {"quantity": "all", "why_not": "; ".join(f"{each.key}: {each.message}" for each in error.problems)}
        return
    matrix = springs.stiffness
    assert matrix is not None
    for name, (row, column, key) in STIFFNESSES.items():
        full, own = float(case["stiffness_initial"][row, column]), float(matrix[row, column])
        yield _row(name, full, own, float(springs.attrs[key]) * own)
    for path in scene.load_paths:
        if path.kind == "pull":
            yield from _pull(springs, case.sel(path=path.name), scene, path, at)


def _pull(
    springs: Springs, case: xr.Dataset, scene: Scene, path: ScenePath, at: tuple[float, ...]
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
            with warnings.catch_warnings(action="ignore"):  # of the edge of the atlas: the table has every case
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


def _fan(error: Array, base: Array, shares: list[Array], rows: Marks, names: Any) -> tuple[float, float]:
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


COMPONENTS = 12
_TOTALS = 3.0  # weight of H and M beside a row of their parts


@dataclass(frozen=True)
class LeftOut:
    """Loads along the rays of cases left out one by one.

    error : (n, 2, ray, X): of H and of M/L over the size of the load |(H, M/L)|; NaN beyond what a case reached.
    deviation : predicted standard deviation of the same.
    stiffness : (n, 3): relative errors of K_V, K_H, K_M.
    """

    error: Array
    deviation: Array
    stiffness: Array

    @property
    def inside(self) -> float:
        """Share of the errors within the band of 95 %."""
        known = np.isfinite(self.error)
        return float((np.abs(self.error[known]) <= BAND * self.deviation[known]).mean())


def build(samples: Samples, family: Family) -> tuple[Atlas, LeftOut]:
    """Return an atlas of samples, and its loads with each case left out."""
    even = family.even(samples.inputs)
    low, span = scale_of(even)
    points = (even - low) / span
    n, shape = len(points), samples.values.shape[1:]
    H, M = sums(samples.values)
    known = [samples.values.reshape(n, -1), _TOTALS * H.reshape(n, -1), _TOTALS * M.reshape(n, -1)]
    whole = filled(points, np.concatenate(known, axis=1))
    mean = whole.mean(axis=0)
    left, size, right = np.linalg.svd(whole - mean, full_matrices=False)
    m = min(COMPONENTS, n - 1)
    scores = left[:, :m] * size[:m]
    processes = tuple(fit(points, scores[:, k]) for k in range(m))
    width = int(np.prod(shape))
    atlas = Atlas(
        family=family, text=samples.scene, inputs=samples.inputs, rays=samples.rays, angles=samples.angles, X=samples.X,
        reach=samples.reach, rest=_rest(samples, mean, scores, right[:m], shape), about={},
        mean=mean[:width].reshape(shape), modes=right[:m, :width].reshape(m, *shape), processes=processes,
        stiffness=tuple(fit(points, values) for values in samples.stiffness.T), settlement=fit(points, samples.settled),
    )  # fmt: skip
    out = left_out(atlas, samples)
    known_ = np.isfinite(out.error)
    factor = max(1.0, float(np.quantile(np.abs(out.error[known_]) / out.deviation[known_], 0.95)) / BAND)
    return replace(atlas, factor=factor), replace(out, deviation=factor * out.deviation)


def _rest(samples: Samples, mean: Array, scores: Array, modes: Array, shape: tuple[int, ...]) -> Array:
    """Return the standard deviation (2, ray, X) of H and M that the components leave."""
    width = int(np.prod(shape))
    again = (mean + scores @ modes)[:, :width].reshape(-1, *shape)
    missing = [own - made for own, made in zip(sums(samples.values), sums(again), strict=True)]
    return np.stack([np.sqrt(np.nanmean(each**2, axis=0)) for each in missing])


def left_out(atlas: Atlas, samples: Samples) -> LeftOut:
    """Return the errors along the rays with each case left out: components and kernels stay those of all cases."""
    pairs = [process.left_out() for process in atlas.processes]
    means, deviations = (np.stack(each, axis=1) for each in zip(*pairs, strict=True))
    values = atlas.mean + np.tensordot(means, atlas.modes, axes=1)
    true, made = np.stack(sums(samples.values), axis=1), np.stack(sums(values), axis=1)
    modes = np.stack(sums(atlas.modes), axis=1)
    size = np.sqrt((true**2).sum(axis=1))[:, None]
    variance = np.tensordot(deviations**2, modes**2, axes=1) + atlas.rest**2
    return LeftOut((made - true) / size, atlas.factor * np.sqrt(variance) / size, _stiffness_errors(atlas.stiffness))


def _stiffness_errors(processes: tuple[Process, ...]) -> Array:
    """Return relative errors (n, 3) of K_V, K_H, K_M with each case left out."""

    def terms(factor: Array) -> Array:
        inner = np.exp(2.0 * factor[1]) * factor[2] ** 2 + np.exp(2.0 * factor[3])
        return np.stack([factor[0], 2.0 * factor[1], np.log(inner)], axis=1)

    made = terms(np.stack([process.left_out()[0] for process in processes]))
    true = terms(np.stack([process.values for process in processes]))
    return np.asarray(np.expm1(made - true))


def atlas_of(
    study: Path, family: Family, held_back: Path | None, at: tuple[float, ...] = AT
) -> tuple[Atlas, LeftOut, pd.DataFrame | None]:
    """Return the atlas of a study, the errors of cases left out, and the comparison with held-back pulls.

    Raises UserInputError for studies that an atlas cannot be made of.
    """
    with open_study(study) as data:
        title, samples = str(data.attrs["title"]), read_samples(data.load(), family)
    atlas, left = build(samples, family)
    about, compared = _about(title, samples, left), None
    if held_back is not None:
        with open_study(held_back) as data:  # judged with the share of the mesh, which `about` names
            atlas, compared = calibrated(replace(atlas, about=about), data.load(), at)
    return replace(atlas, about=about | {"held back": held_back_words(compared)}), left, compared


def left_summary(left: LeftOut) -> pd.DataFrame:
    """Return errors of cases left out one by one, a row a quantity: of stiffness, and of loads over |(H, M/L)|."""
    parts = {name: left.stiffness[:, k] for k, name in enumerate(("K_V", "K_H", "K_M"))}
    parts |= {"H along rays": left.error[:, 0].ravel(), "M/L along rays": left.error[:, 1].ravel()}
    rows = []
    for name, values in parts.items():
        size = np.abs(values[np.isfinite(values)]) * 100.0
        rows.append({
            "quantity": name, "count": size.size, "rms_pct": float(np.sqrt((size**2).mean())),
            "p95_pct": float(np.quantile(size, 0.95)), "largest_pct": float(size.max()),
        })  # fmt: skip
    return pd.DataFrame(rows)


def _about(title: str, samples: Samples, left: LeftOut) -> dict[str, str]:
    base = samples.scene.scene()
    better = f", {EXTRAPOLATED}" if samples.extrapolated else ""
    error = np.abs(left.error[np.isfinite(left.error)])
    text = (
        f"load along the rays {percent(100 * np.sqrt((error**2).mean()))} (rms), "
        f"{percent(100 * np.quantile(error, 0.95))} (95 %), {100 * left.inside:.3g} % inside the band of 95 %"
    )
    return {
        "title": title, "full models": str(len(samples.inputs)), "pysprings": __version__,
        "mesh": f"{base.mesh.preset} ({base.mesh.discretisation}){better}",
        "left out": text,
    }  # fmt: skip


def held_back_words(compared: pd.DataFrame | None) -> str:
    """Return a sentence on the table of `held_back`, or on a check that there was not."""
    if compared is None:
        return "not checked: the deviations lack what rays do not say of pulls"
    words = []
    for row in summary(compared).to_dict("records"):
        place = f" at u/D {row['u_over_D']:g}" if row["u_over_D"] else ""
        words.append(f"{row['quantity']}{place} {percent(row['largest_pct'])}")
    none = compared["quantity"] == "all"
    left = f"; {none.sum()} without an answer" if none.any() else ""
    return f"largest errors on {compared.loc[~none, 'case'].nunique()} caissons: {', '.join(words)}{left}"
