# SPDX-License-Identifier: MIT
"""Samples of a study -> an atlas: principal components, a Gaussian process each, and the check by leaving cases out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pysprings.core.progress import Progress
from pysprings.studies.atlas.families import Family
from pysprings.studies.atlas.model import Atlas, sums
from pysprings.studies.atlas.process import Process, filled, fit
from pysprings.studies.atlas.samples import Samples

Array = NDArray[np.float64]
COMPONENTS = 12
_TOTALS = 3.0  # weight of H and M beside a row of their parts
_BAND = 1.96  # standard deviations: 95 %


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
        return float((np.abs(self.error[known]) <= _BAND * self.deviation[known]).mean())


def build(
    samples: Samples, family: Family, components: int = COMPONENTS, about: Mapping[str, str] | None = None,
    progress: Progress = lambda *_: None,
) -> tuple[Atlas, LeftOut]:  # fmt: skip
    """Return an atlas of samples, and its loads with each case left out."""
    even = family.even(samples.inputs)
    points = (even - even.min(axis=0)) / (even.max(axis=0) - even.min(axis=0))
    n, shape = len(points), samples.values.shape[1:]
    H, M = sums(samples.values)
    known = [samples.values.reshape(n, -1), _TOTALS * H.reshape(n, -1), _TOTALS * M.reshape(n, -1)]
    whole = filled(points, np.concatenate(known, axis=1))
    mean = whole.mean(axis=0)
    left, size, right = np.linalg.svd(whole - mean, full_matrices=False)
    m = min(components, n - 1)
    scores = left[:, :m] * size[:m]
    processes = []
    for k in range(m):
        processes.append(fit(points, scores[:, k]))
        progress("components", (k + 1) / m, "")
    width = int(np.prod(shape))
    atlas = Atlas(
        family=family, text=samples.scene, inputs=samples.inputs, rays=samples.rays, angles=samples.angles, X=samples.X,
        reach=samples.reach, rest=_rest(samples, mean, scores, right[:m], shape), about=dict(about or {}),
        mean=mean[:width].reshape(shape), modes=right[:m, :width].reshape(m, *shape), processes=tuple(processes),
        stiffness=tuple(fit(points, values) for values in samples.stiffness.T), settlement=fit(points, samples.settled),
    )  # fmt: skip
    out = left_out(atlas, samples)
    known_ = np.isfinite(out.error)
    factor = max(1.0, float(np.quantile(np.abs(out.error[known_]) / out.deviation[known_], 0.95)) / _BAND)
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
