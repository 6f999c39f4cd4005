# SPDX-License-Identifier: MIT
"""The least steel on an atlas: for every L/D the diameter at which the load cases are just met, and the best L/D.

The full model confirms a candidate: a pull for every height of the load cases. A picture shows all candidates.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from pysprings.core.arrays import Integers
from pysprings.core.errors import RunIncomplete, refused
from pysprings.core.text import with_prefix
from pysprings.full_model.run_record import RunRecord, Status
from pysprings.macro.batch import predict_batch
from pysprings.macro.fan_springs import BAND
from pysprings.results.look import BLUE, GREY, VERMILLION
from pysprings.scene.changes import VERTICAL_LOAD, Change, vertical_load
from pysprings.scene.defaults import implausible
from pysprings.springs.path import paths_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pysprings.core.tables.load_cases import LoadCases
    from pysprings.scene.model import Scene
    from pysprings.studies.atlas.model import Atlas

STEEL = 7850.0  # kg/m3
UNKNOWN = 10.0  # use of a caisson that an atlas has no answer for
TORSION = "torsion"
NO_BOUND = "T above half of R times (H, M/D) has no bound here: design it by springs in space, or leave T out"
EDGE = "edge of the atlas"
LEAST = "--D-min"
_NEAR = 0.02  # of D, and of L/D: a caisson that near is at the edge
_CLOSE = 1e-3  # of D
# diameters in equal ratios for the range that an atlas covers, times as many where none is in it, halvings to its ends
_SIZES, _FINER, _HALVINGS = 20, 5, 6


@dataclass(frozen=True)
class Wanted:
    """What a caisson must meet.

    cases : load cases; V [N] of a case is that of its caisson, NaN: that of the scene.
    tilt : largest rotation [rad], of cases that have none of their own.
    utilisation : largest share of the largest known load.
    changes : values of the ground.
    D, ratio : bounds of the diameter [m] and of L/D.
    """

    cases: LoadCases
    tilt: float
    utilisation: float
    changes: tuple[Change, ...] = ()
    D: tuple[float, float] = (2.0, 20.0)
    ratio: tuple[float, float] = (0.5, 1.45)


@dataclass(frozen=True)
class Candidate:
    """A caisson, its steel [kg], and its use: the largest share of what is allowed (1: just met), by `governs`.

    `governs` is `EDGE` where the atlas covers no smaller caisson of the same L/D, which might do, too; `LEAST` where
    the bounds do not. Of the least steel it begins with `EDGE` where the atlas ends there.
    """

    D: float
    L: float
    mass: float
    use: float
    governs: str
    answered: bool


@dataclass
class Search:
    """A search on an atlas: every caisson that was tried. `correction` multiplies predicted rotations and loads."""

    atlas: Atlas
    wanted: Wanted
    correction: float = 1.0
    tried: list[Candidate] = field(default_factory=list)

    def at(self, D: float, L: float) -> Candidate:
        """Return a caisson with its use."""
        use, governs, answered = self._use(D, L)
        candidate = Candidate(D, L, mass_of(self.atlas, D, L), use, governs, answered)
        self.tried.append(candidate)
        return candidate

    def _use(self, D: float, L: float) -> tuple[float, str, bool]:
        wanted = self.wanted
        answers = answered(self.atlas, wanted, D, L)
        tilt = np.where(np.isnan(wanted.cases.tilt), wanted.tilt, wanted.cases.tilt)
        turned = np.abs(answers["rotation"]) + BAND * answers["rotation_deviation"]
        with np.errstate(invalid="ignore"):
            by_tilt = np.minimum(self.correction * turned / tilt, UNKNOWN)  # infinite: the atlas bounds no rotation
            by_load = self.correction * answers["utilisation"] / wanted.utilisation
        ok = (answers["answered"] == 1).to_numpy()
        by_tilt = np.where(ok, by_tilt, UNKNOWN * np.fmax(answers["utilisation"], 1.0))
        by_torsion = np.minimum(wanted.cases.torsion_share(0.5 * D), UNKNOWN)  # beyond 1 nothing bounds it
        use = np.fmax(np.fmax(by_tilt, by_load), by_torsion)  # a case without lateral load has no utilisation
        worst = max(range(use.size), key=lambda k: (use[k], wanted.cases.name[k]))
        what = "utilisation" if by_load[worst] > by_tilt[worst] else "tilt"
        twisted = by_torsion[worst] > 1.0 or by_torsion[worst] == use[worst]
        what = TORSION if twisted else what if ok[worst] else "no answer"
        return float(use[worst]), f"{wanted.cases.name[worst]}: {what}", bool((ok & (by_torsion <= 1.0)).all())

    def just_met(self, ratio: float) -> Candidate | None:
        """Return the smallest caisson of an L/D that meets all cases; None where the largest one does not."""
        from scipy.optimize import brentq

        low, high = self.covered(ratio)
        if low >= high or self.at(high, ratio * high).use > 1.0:
            return None
        smallest = self.at(low, ratio * low)
        if smallest.use <= 1.0:
            return replace(smallest, governs=LEAST if low == self.wanted.D[0] else EDGE)
        D = brentq(lambda D: math.log(self.at(D, ratio * D).use), low, high, xtol=_CLOSE * low)
        D *= 1.0 + _CLOSE
        return self.at(D, ratio * D)

    def covered(self, ratio: float) -> tuple[float, float]:
        """Return the range of diameters [m] of an L/D that the atlas covers at every V; the same twice where none."""
        for count in (_SIZES, _FINER * _SIZES):  # few diameters may be between two vertical loads
            sizes = [float(D) for D in np.geomspace(*self.wanted.D, count)]
            if known := [k for k, D in enumerate(sizes) if not self._beyond(ratio, D)]:
                break
        else:
            return (self.wanted.D[0],) * 2
        ends = []
        for k, beyond in ((known[0], known[0] - 1), (known[-1], known[-1] + 1)):
            inside, outside = sizes[k], sizes[beyond] if 0 <= beyond < len(sizes) else sizes[k]
            for _ in range(_HALVINGS if inside != outside else 0):
                middle = math.sqrt(inside * outside)
                inside, outside = (inside, middle) if self._beyond(ratio, middle) else (middle, outside)
            ends.append(inside)
        return ends[0], ends[1]

    def _beyond(self, ratio: float, D: float) -> set[str]:
        """Return which inputs of the atlas a caisson leaves at some V."""
        inside = scenes_of(self.atlas, self.wanted, D, ratio * D)
        return {label for scene, _ in inside for label, _ in self.atlas.beyond(scene)}

    def least(self) -> Candidate:
        """Return the caisson of the least steel. Raises UserInputError where none within the bounds meets the cases."""
        from scipy.optimize import minimize_scalar

        met: dict[float, Candidate] = {}

        def steel(ratio: float) -> float:
            found = self.just_met(float(ratio))
            if found is not None and found.use <= 1.0:
                met[float(ratio)] = found
            largest = self.wanted.D[1]
            return found.mass if found is not None else mass_of(self.atlas, largest, ratio * largest) * 2.0

        minimize_scalar(steel, bounds=self.wanted.ratio, method="bounded", options={"xatol": 0.02, "maxiter": 10})
        for end in self.wanted.ratio:
            steel(end)
        if not met:
            ratio = math.sqrt(math.prod(self.wanted.ratio))
            low, high = self.covered(ratio)
            if low >= high:
                D = math.sqrt(math.prod(self.wanted.D))
                answered(self.atlas, self.wanted, D, ratio * D)  # refused: what is outside the atlas
            ends = sorted(self._beyond(ratio, low * (1.0 - _NEAR)) | self._beyond(ratio, high * (1.0 + _NEAR)))
            text = f"at their V the atlas covers D {low:.3g} to {high:.3g} m at L/D {ratio:.2g}"
            text += f", where {' and '.join(ends)} leave it" * bool(ends)
            if (there := self.at(high, ratio * high)).use > 1.0:
                text += f"; at the largest {there.governs} governs"
            text += f" ({NO_BOUND})" * there.governs.endswith(TORSION)
            raise refused("--D-max", f"no caisson up to D = {self.wanted.D[1]:g} m meets the load cases; {text}")
        best = min(met.values(), key=lambda each: each.mass)
        beyond = best.governs != EDGE and self._at_edge(best)
        return replace(best, governs=f"{EDGE}; {best.governs}") if beyond else best

    def _at_edge(self, found: Candidate) -> bool:
        """Return whether a caisson is at the smallest diameter, or at an end of the L/D, that the atlas covers."""
        ratio, (low, _) = found.L / found.D, self.covered(found.L / found.D)
        ends = [end for end in self.atlas.box[:, 0] if abs(ratio - float(end)) <= _NEAR]
        return bool(ends) or (low > self.wanted.D[0] and found.D / low <= 1.0 + _NEAR)


def answered(atlas: Atlas, wanted: Wanted, D: float, L: float) -> pd.DataFrame:
    """Return the answers of an atlas to the cases for a caisson, to a bound of those aside of one plane.

    Raises UserInputError for what it does not cover.
    """
    cases = wanted.cases.bounded(0.5 * D)
    names = ("u", "rotation", "u_deviation", "rotation_deviation", "utilisation", "answered")
    table = pd.DataFrame(np.nan, index=range(len(cases)), columns=list(names))
    for scene, rows in scenes_of(atlas, wanted, D, L):
        with warnings.catch_warnings(action="ignore"):
            batch = predict_batch(atlas.springs(scene), H=cases.H[rows], M=cases.M[rows])
        table.loc[rows] = np.stack([batch[name].values for name in names], axis=1)
    return table


def scenes_of(atlas: Atlas, wanted: Wanted, D: float, L: float) -> list[tuple[Scene, Integers]]:
    """Return the scene of each vertical load of the cases for a caisson, with the rows of its cases."""
    found = []
    for V in np.unique(wanted.cases.V):  # of NaN one
        changes, rows = list(wanted.changes), np.flatnonzero(np.isnan(wanted.cases.V))
        if not np.isnan(V):
            changes = [each for each in changes if atlas.named(each).keys != VERTICAL_LOAD]
            changes, rows = [*changes, vertical_load(float(V))], np.flatnonzero(wanted.cases.V == V)
        found.append((atlas.scene(D, L, changes), rows))
    return found


def mass_of(atlas: Atlas, D: float, L: float) -> float:
    """Return the steel [kg] of a caisson with the share of thickness of an atlas."""
    base = atlas.base.caisson
    return steel_of(D, L, base.skirt_thickness / base.outer_diameter * D)


def steel_of(D: float, L: float, t: float) -> float:
    """Return the steel [kg] of skirt and lid, both of the skirt's thickness t [m]."""
    return STEEL * math.pi * ((D - t) * t * L + 0.25 * D**2 * t)


def bounds_of(atlas: Atlas, ratio: tuple[float, float]) -> tuple[float, float]:
    """Return bounds of L/D within the atlas. Raises UserInputError where there are none."""
    low, high = (float(value) for value in atlas.box[:, 0])
    inside = max(ratio[0], low * 1.0001), min(ratio[1], high * 0.9999)
    if inside[0] >= inside[1]:
        raise refused("--ratio", f"the atlas has L/D {low:.3g} to {high:.3g}")
    return inside


def remarks_on(search: Search, best: Candidate, confirmed: bool) -> list[str]:
    """Return what is to be remarked on the least caisson: what its cases leave out, where the atlas ends, its mesh."""
    from pysprings.studies.atlas.springs import mesh_words

    wanted, atlas = search.wanted, search.atlas
    cases = wanted.cases.bounded(0.5 * best.D)
    texts = [f"{name}: {remark}" for name, remark in zip(cases.name, cases.notes, strict=True) if remark]
    for scene, rows in scenes_of(atlas, wanted, best.D, best.L):
        V = scene.caisson.vertical_load
        load = V if isinstance(V, str) else with_prefix(V, "N")
        texts += [f"cases without V are at that of the scene, {load}"] * bool(np.isnan(cases.V[rows[0]]))
        texts += [f"V {load}: {edge}" for edge in atlas.estimate(scene).outside]
        texts += [text for text in implausible(scene) if text not in texts]
    alone = ", ".join(name for name, lateral in zip(cases.name, cases.lateral, strict=True) if not lateral)
    texts += [f"{alone}: no lateral load: an atlas judges no V alone"] * bool(alone)
    if best.governs.startswith(EDGE):
        texts.append("the atlas ends here, with no smaller diameter or no other L/D: a caisson beyond may do with less")
    if mesh := mesh_words(atlas):
        texts.append(f"{atlas.source}: {mesh}")
    if confirmed:
        texts.append(
            f"the full model confirms the tilt, not the utilisation, on mesh '{atlas.base.mesh.preset}', that of the "
            "atlas; rotation_mesh_error_pct is its own estimate"
        )
    return texts


def table_of(tried: Sequence[Candidate]) -> pd.DataFrame:
    """Return the path of candidates, a row each; `use` is NaN where it is not known, or `UNKNOWN` and more."""
    rows = [
        {"D_m": c.D, "L_m": c.L, "L_over_D": c.L / c.D, "steel_t": 1e-3 * c.mass,
         "use": c.use if c.answered and c.use < UNKNOWN else np.nan, "governs": c.governs}
        for c in tried
    ]  # fmt: skip
    return pd.DataFrame(rows)


def candidates(table: pd.DataFrame, best: pd.Series) -> Figure:
    """Draw every caisson that was tried, its steel in tonnes as the size of the dot, and the best one."""
    from matplotlib import rc_context

    from pysprings.results.plots.style import STYLE, new_figure

    with rc_context(STYLE):
        figure = new_figure(6.4, 4.6)
        axes = figure.subplots()
        for met, colour, label in ((True, BLUE, "meets the load cases"), (False, GREY, "does not")):
            part = table[(table["use"] <= 1.0) == met]
            size = 10.0 + 60.0 * part["steel_t"] / table["steel_t"].max()
            axes.scatter(part["D_m"], part["L_m"], s=size, c=colour, label=label, alpha=0.7)
        words = f"least steel: {best['steel_t']:.3g} t"
        axes.plot(best["D_m"], best["L_m"], "*", color=VERMILLION, markersize=16, label=words)
        axes.set(xlabel="outer diameter D [m]", ylabel="skirt length L [m]")
        axes.legend(loc="best")
    return figure


_FURTHER = 1.3  # times the displacement that the atlas expects
ROUNDS = 3


def least_confirmed(search: Search) -> tuple[Candidate, pd.DataFrame]:
    """Return the caisson of the least steel that the full model confirms, and its load cases (`confirmed`).

    Where the full model turns further than tolerated, the predictions are multiplied by what was missed, and the
    search goes on.

    Raises UserInputError before the search where a case has no lateral load, and RunIncomplete: after `ROUNDS` full
    models the tolerance is still exceeded, or a load is not reached.
    """
    cases = search.wanted.cases.bounded(1.0)  # a torsion alone is bounded by a lateral load, at any radius
    if without := ", ".join(repr(name) for name, H in zip(cases.name, cases.H, strict=True) if H == 0.0):
        raise refused("--confirm", f"full models are pulled by a lateral load, and load case {without} has none")
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
    """Return the load cases by atlas and full model, a row a case, each with H; runs the full model.

    Columns: name, H_N, arm_m, u and rotation by both [m, rad], errors of the atlas [%], their deviations [%], inside
    (both errors within 1.96 deviations), tilt_used by the full model, rotation_mesh_error_pct: the full model's own
    estimate of the error of its mesh. NaN where the full model stopped before the load, or has no estimate.
    """
    from pysprings.full_model.compute import run

    wanted = replace(wanted, cases=wanted.cases.bounded(0.5 * candidate.D))
    cases, expected = wanted.cases, answered(atlas, wanted, candidate.D, candidate.L)
    scene = atlas.scene(candidate.D, candidate.L, wanted.changes)
    paths = [
        {
            "name": f"case_{k + 1}", "kind": "pull", "arm": float(cases.M[k] / cases.H[k]),
            "lateral_displacement": float(_FURTHER * abs(expected["u"][k])),
            "vertical_load": None if np.isnan(cases.V[k]) else float(cases.V[k]),
        }
        for k in range(len(cases))
    ]  # fmt: skip
    with warnings.catch_warnings(action="ignore"):
        result = run(scene.replace(paths=tuple(paths)))
    if result.attrs["status"] == Status.INTERRUPTED:
        raise KeyboardInterrupt
    record, rows = RunRecord.of(result), []
    estimates = (record.error_estimate or {}).get("by_path", {}) if record is not None else {}
    for k in range(len(cases)):
        path = paths_of(result)[f"case_{k + 1}"].recorded
        good = path["converged"].values == 1
        H, u, turn = (np.abs(path[name].values[good]) for name in ("H", "u", "rotation"))
        load = abs(float(cases.H[k]))
        known = bool(load <= H.max(initial=0.0))  # no state where the dead load itself stopped
        full = [float(np.interp(load, H, values)) if known else np.nan for values in (u, turn)]
        mesh = estimates.get(f"case_{k + 1}", {}).get("rotation_pct")
        own = {"rotation_mesh_error_pct": np.nan if mesh is None else float(mesh)}
        rows.append(_row(k, wanted, expected, full) | own)
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
