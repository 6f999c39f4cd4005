# SPDX-License-Identifier: MIT
"""A candidate by the full model: a pull for every height of the load cases, beside the atlas; a picture of all."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from pysprings.core.errors import RunIncomplete, refused
from pysprings.macro.fan_springs import BAND
from pysprings.results.plots.style import BLUE, GREY, VERMILLION, new_figure, styled
from pysprings.studies.sizing.search import Candidate, Search, Wanted, answered

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pysprings.studies.atlas.model import Atlas


@styled
def candidates(table: pd.DataFrame, best: pd.Series) -> Figure:
    """Draw every caisson that was tried, its steel in tonnes as the size of the dot, and the best one."""
    figure = new_figure(6.4, 4.6)
    axes = figure.subplots()
    for met, colour, label in ((True, BLUE, "meets the load cases"), (False, GREY, "does not")):
        part = table[(table["use"] <= 1.0) == met]
        axes.scatter(part["D_m"], part["L_m"], s=10.0 + 60.0 * part["steel_t"] / table["steel_t"].max(), c=colour,
                     label=label, alpha=0.7)  # fmt: skip
    axes.plot(
        best["D_m"], best["L_m"], "*", color=VERMILLION, markersize=16, label=f"least steel: {best['steel_t']:.3g} t"
    )
    axes.set_xlabel("outer diameter D [m]")
    axes.set_ylabel("skirt length L [m]")
    axes.legend(loc="best")
    return figure


_FURTHER = 1.3  # times the displacement that the atlas expects
ROUNDS = 3


def least_confirmed(search: Search) -> tuple[Candidate, pd.DataFrame]:
    """Return the caisson of the least steel that the full model confirms, and its load cases (`confirmed`).

    Where the full model turns further than tolerated, the predictions are multiplied by what was missed, and the
    search goes on.

    Raises
    ------
    RunIncomplete
        After `ROUNDS` full models the tolerance is still exceeded, or a load is not reached.
    """
    for _ in range(ROUNDS):
        best = search.least()
        checked = confirmed(search.atlas, search.wanted, best)
        if (checked["tilt_used"] <= 1.0).all():
            return best, checked
        search.correction *= correction_of(checked)
    worst = checked.iloc[int(np.argmax(checked["tilt_used"].fillna(np.inf)))]
    used = f"{worst['tilt_used']:.3g} of the tolerated rotation" if np.isfinite(worst["tilt_used"]) else "not reached"
    raise RunIncomplete(
        f"not confirmed: after {ROUNDS} corrections the full model of D {best.D:.3f} m, L {best.L:.3f} m has load case "
        f"{worst['name']!r} at {used}"
    )


def confirmed(atlas: Atlas, wanted: Wanted, candidate: Candidate) -> pd.DataFrame:
    """Return the load cases by atlas and full model, a row a case with H; runs the full model.

    Columns: name, H_N, arm_m, u and rotation by both [m, rad], errors of the atlas [%], their deviations [%], inside
    (both errors within 1.96 deviations), tilt_used by the full model. NaN where the full model stopped before the load.
    """
    from pysprings.full_model.compute import run
    from pysprings.full_model.run_record import Status
    from pysprings.springs.path import paths_of

    wanted = replace(wanted, cases=wanted.cases.bounded(0.5 * candidate.D))
    cases, expected = wanted.cases, answered(atlas, wanted, candidate.D, candidate.L)
    scene = atlas.scene(candidate.D, candidate.L, wanted.changes)
    chosen = [k for k in range(len(cases)) if cases.H[k] and expected["answered"][k]]
    if len(chosen) < len(cases):
        without = ", ".join(repr(cases.name[k]) for k in range(len(cases)) if k not in chosen)
        raise refused("--confirm", f"full models are pulled by a lateral load, and load case {without} has none")
    paths = [
        {
            "name": f"case_{k + 1}", "kind": "pull", "arm": float(cases.M[k] / cases.H[k]),
            "lateral_displacement": float(_FURTHER * abs(expected["u"][k])),
            "vertical_load": None if np.isnan(cases.V[k]) else float(cases.V[k]),
        }
        for k in chosen
    ]  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = run(scene.replace(paths=tuple(paths)))
    if result.attrs["status"] == Status.INTERRUPTED:
        raise KeyboardInterrupt
    rows = []
    for k in chosen:
        path = paths_of(result)[f"case_{k + 1}"].recorded
        good = path["converged"].values == 1
        H, u, turn = (np.abs(path[name].values[good]) for name in ("H", "u", "rotation"))
        load = abs(float(cases.H[k]))
        known = bool(load <= H.max(initial=0.0))  # no state where the dead load itself stopped
        full = [float(np.interp(load, H, values)) if known else np.nan for values in (u, turn)]
        rows.append(_row(k, wanted, expected, full))
    return pd.DataFrame(rows)


def _row(k: int, wanted: Wanted, expected: pd.DataFrame, full: list[float]) -> dict[str, object]:
    cases = wanted.cases
    own = [abs(float(expected[name][k])) for name in ("u", "rotation")]
    spread = [float(expected[f"{name}_deviation"][k]) for name in ("u", "rotation")]
    tilt = wanted.tilt if np.isnan(cases.tilt[k]) else float(cases.tilt[k])
    errors = [a / b - 1.0 for a, b in zip(own, full, strict=True)]
    inside = all(abs(a - b) <= BAND * s for a, b, s in zip(own, full, spread, strict=True))
    return {
        "name": cases.name[k], "H_N": cases.H[k], "arm_m": cases.M[k] / cases.H[k], "u_atlas_m": own[0],
        "u_full_m": full[0], "rotation_atlas_rad": own[1], "rotation_full_rad": full[1],
        "u_error_pct": 100.0 * errors[0], "u_deviation_pct": 100.0 * spread[0] / full[0],
        "rotation_error_pct": 100.0 * errors[1], "rotation_deviation_pct": 100.0 * spread[1] / full[1],
        "inside": int(inside), "tilt_used": full[1] / tilt,
    }  # fmt: skip


def correction_of(table: pd.DataFrame) -> float:
    """Return the factor on what an atlas predicts that the full model asks for; 1 where the atlas is safe."""
    ratios = table["rotation_full_rad"] / table["rotation_atlas_rad"]
    return max(1.0, float(ratios.max())) if ratios.notna().all() else 1.1
