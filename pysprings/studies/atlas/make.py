# SPDX-License-Identifier: MIT
"""A study -> an atlas, with what was measured of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from pysprings.core.progress import Progress
from pysprings.core.version import __version__
from pysprings.studies.atlas import check
from pysprings.studies.atlas.build import LeftOut, build
from pysprings.studies.atlas.families import Family
from pysprings.studies.atlas.model import Atlas
from pysprings.studies.atlas.samples import read_samples
from pysprings.studies.sweep.dataset import open_study

if TYPE_CHECKING:
    from pysprings.studies.atlas.samples import Samples


def atlas_of(
    study: Path, family: Family, held_back: Path | None, at: tuple[float, ...] = check.AT,
    progress: Progress = lambda *_: None,
) -> tuple[Atlas, LeftOut, pd.DataFrame | None]:  # fmt: skip
    """Return the atlas of a study, the errors of cases left out, and the comparison with held-back pulls.

    Raises UserInputError for studies that an atlas cannot be made of.
    """
    with open_study(study) as data:
        title, samples = str(data.attrs["title"]), read_samples(data.load(), family)
    atlas, left = build(samples, family, progress=progress)
    compared = None
    if held_back is not None:
        with open_study(held_back) as data:
            atlas, compared = check.calibrated(atlas, data.load(), at)
    return replace(atlas, about=_about(title, samples, _left_words(left), compared)), left, compared


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


def _about(title: str, samples: Samples, fitted: dict[str, str], compared: pd.DataFrame | None) -> dict[str, str]:
    base = samples.scene.scene()
    about = {
        "title": title, "full models": str(len(samples.inputs)), "pysprings": __version__,
        "mesh": f"{base.mesh.preset} ({base.mesh.discretisation})", "drainage": _drainage(base.soil.layers), **fitted,
    }  # fmt: skip
    if compared is None:
        return about | {"held back": "not checked: the deviations lack what rays do not say of pulls"}
    words = []
    for row in check.summary(compared).to_dict("records"):
        place = f" at u/D {row['u_over_D']:g}" if row["u_over_D"] else ""
        words.append(f"{row['quantity']}{place} {row['largest_pct']:.2g} %")
    cases = compared.loc[compared["quantity"] != "all", "case"].nunique()
    return about | {"held back": f"largest errors on {cases} caissons: {', '.join(words)}"}


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
