# SPDX-License-Identifier: MIT
"""Samples of a study -> an atlas: principal components, a Gaussian process each, and the check by leaving cases out."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pysprings.core.variables import EXTRAPOLATED
from pysprings.core.version import __version__
from pysprings.macro.fan_springs import BAND
from pysprings.studies.atlas import check
from pysprings.studies.atlas.between import Process, filled, fit
from pysprings.studies.atlas.families import Family
from pysprings.studies.atlas.model import Atlas, sums
from pysprings.studies.atlas.samples import Samples, read_samples
from pysprings.studies.sweep.dataset import open_study

Array = NDArray[np.float64]
COMPONENTS = 12
_TOTALS = 3.0  # weight of H and M beside a row of their parts


@dataclass(frozen=True)
class LeftOut:
    """Loads along the rays of cases left out one by one.

    Attributes
    ----------
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
    points = (even - even.min(axis=0)) / (even.max(axis=0) - even.min(axis=0))
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
    study: Path, family: Family, held_back: Path | None, at: tuple[float, ...] = check.AT
) -> tuple[Atlas, LeftOut, pd.DataFrame | None]:
    """Return the atlas of a study, the errors of cases left out, and the comparison with held-back pulls.

    Raises UserInputError for studies that an atlas cannot be made of.
    """
    with open_study(study) as data:
        title, samples = str(data.attrs["title"]), read_samples(data.load(), family)
    atlas, left = build(samples, family)
    about, compared = _about(title, samples, _left_words(left)), None
    if held_back is not None:
        with open_study(held_back) as data:  # judged with the share of the mesh, which `about` names
            atlas, compared = check.calibrated(replace(atlas, about=about), data.load(), at)
    return replace(atlas, about=about | {"held back": _held_back_words(compared)}), left, compared


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


def _about(title: str, samples: Samples, fitted: dict[str, str]) -> dict[str, str]:
    base = samples.scene.scene()
    better = f", {EXTRAPOLATED}" if samples.extrapolated else ""
    return {
        "title": title, "full models": str(len(samples.inputs)), "pysprings": __version__,
        "mesh": f"{base.mesh.preset} ({base.mesh.discretisation}){better}",
        "drainage": _drainage(base.soil.layers), **fitted,
    }  # fmt: skip


def _held_back_words(compared: pd.DataFrame | None) -> str:
    if compared is None:
        return "not checked: the deviations lack what rays do not say of pulls"
    words = []
    for row in check.summary(compared).to_dict("records"):
        place = f" at u/D {row['u_over_D']:g}" if row["u_over_D"] else ""
        words.append(f"{row['quantity']}{place} {row['largest_pct']:.2g} %")
    cases = compared.loc[compared["quantity"] != "all", "case"].nunique()
    return f"largest errors on {cases} caissons: {', '.join(words)}"


def _left_words(left: LeftOut) -> dict[str, str]:
    error = np.abs(left.error[np.isfinite(left.error)])
    text = (
        f"load along the rays {100 * np.sqrt((error**2).mean()):.2g} % (rms), {100 * np.quantile(error, 0.95):.2g} % "
        f"(95 %), {100 * left.inside:.3g} % inside the band of 95 %"
    )
    return {"left out": text}


def _drainage(layers: tuple[object, ...]) -> str:
    """Return the drainage as springs have it: of clay layers in total stress, or drained."""
    clay = any(getattr(layer, "law", None) in ("tresca", "von-mises") for layer in layers)
    return "total-stress" if clay else "drained"
