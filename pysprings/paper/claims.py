# SPDX-License-Identifier: MIT
"""The thirteen things that the paper says, each beside our figure: agrees, partly or differs, and why.

A claim's verdict comes from a criterion that is stated with it; the criteria turn the paper's words into numbers, since
its text gives few. "partly" is what holds in part of the criterion's items.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
import xarray as xr

from pysprings.paper import measures as m
from pysprings.paper.cases import DEPTHS, END, SHOWN

AGREES, PARTLY, DIFFERS, UNKNOWN = "agrees", "partly", "differs", "not reached"
Paths = Mapping[str, xr.Dataset]  # by name of the case; what has not run is absent
_SLOPE = 2e-3  # m, where the paper sees the change of slope
_WALL_BACK = 1e-9  # of the initial stress: open


@dataclass(frozen=True)
class Finding:
    """What came out: figures in words, whether each item of the criterion holds (None: not known), why."""

    figure: str
    holds: Sequence[bool | None]
    reason: str = ""

    @property
    def verdict(self) -> str:
        """Agrees where all items hold, differs where none does."""
        known = [item for item in self.holds if item is not None]
        if len(known) < len(self.holds) or not known:
            return UNKNOWN
        return AGREES if all(known) else PARTLY if any(known) else DIFFERS


@dataclass(frozen=True)
class Claim:
    """A statement of the paper, the criterion that stands for it, the runs it needs, and its measurement."""

    number: int
    words: str
    criterion: str
    needs: tuple[str, ...]
    measure: Callable[[Paths], Finding]


def assess(paths: Paths) -> pd.DataFrame:
    """Return the table of the claims: number, claim, figure, verdict, reason, criterion; one row a claim."""
    rows = []
    for claim in CLAIMS:
        missing = [name for name in claim.needs if name not in paths]
        found = Finding(f"needs the run {', '.join(missing)}", (None,)) if missing else claim.measure(paths)
        if found.verdict == UNKNOWN and not missing:
            found = Finding(f"{found.figure} (a run stopped before it)", (None,), found.reason)
        rows.append({
            "number": claim.number, "claim": claim.words, "figure": found.figure, "verdict": found.verdict,
            "reason": found.reason, "criterion": claim.criterion,
        })  # fmt: skip
    return pd.DataFrame(rows)


def _is(value: float, low: float, high: float) -> bool | None:
    return bool(low <= value <= high) if np.isfinite(value) else None


def _list(values: Sequence[float] | np.ndarray, form: str = ".2f") -> str:
    return ", ".join(format(float(value), form) for value in values)


def _mm(length: float) -> str:
    if not np.isfinite(length):
        return "never"
    return f"{1e3 * length:.2g} mm" if abs(length) >= 5e-8 else "0 mm"


def _at_depths() -> str:
    return f"at {', '.join(f'{d:g}' for d in DEPTHS)} m"


def _slope_change(paths: Paths) -> Finding:
    path = paths["drained"]
    place, sharpness = m.load_bend(path)
    share = m.secant_share(path, 1e-3)
    ratio = m.slope_ratio(path)
    figure = (
        f"tangent at 0.3 mm {ratio:.1f} times that at 3 mm; secant at 1 mm {100 * share:.0f} % of that at 0.1 mm; "
        f"sharpest bend at {1e3 * place:.1f} mm, where the tangent falls by {sharpness:.1f} % a per cent of u"
    )
    bends = _all((_is(1e3 * place, 1.0, 3.0), _is(sharpness, 1.0, np.inf)))
    holds = (bends, _is(share, 0.8, 1.2))
    reason = "" if all(holds) else "the sand yields from the start (phi_i 5 deg): the curve bends smoothly"
    return Finding(figure, holds, reason)


def _front_stress(paths: Paths) -> Finding:
    ratio = m.stress_ratio(paths["drained"], SHOWN, m.FRONT, DEPTHS)
    holds = [_is(value, 1.25, 1.75) for value in ratio]
    reason = "" if all(holds) else "larger near the mudline, where the initial stress is small"
    return Finding(f"{_list(ratio)} times initial {_at_depths()}", holds, reason)


def _rear_gap(paths: Paths) -> Finding:
    path = paths["drained"]
    back = m.stress_ratio(path, SHOWN, m.BACK, DEPTHS)
    gap = m.rear_gap(path, END)
    top, bottom = gap[path["depth"].values <= 2.0].max(), gap[path["depth"].values > 2.0].max()
    share = m.open_share(path, SHOWN)
    figure = (
        f"back p'_N {_list(back)} times initial {_at_depths()}, {100 * share:.0f} % of the back line open at 2.5 mm; "
        f"at 20 mm widest opening {_mm(top)} above and {_mm(bottom)} below half the skirt"
    )
    lateral, down = (np.abs(m.field(path, name, SHOWN, m.BACK)) for name in ("shear_lateral", "shear_vertical"))
    shear = float(np.interp(DEPTHS[0], path["depth"].values, np.hypot(lateral, down)))
    holds = (
        _is(back[0], -1.0, _WALL_BACK), bool(top > bottom) if np.isfinite(top) else None, _is(1e-3 * shear, 0.0, 0.01),
    )  # fmt: skip
    reason = ""
    if not all(item is True for item in holds):
        reason = (
            "the yielding sand follows the caisson: contact is kept, at less stress; see the sensitivities for the "
            "readings with a gap"
        )
    return Finding(f"{figure}; shear behind at {DEPTHS[0]:g} m {1e-3 * shear:.2g} kPa", holds, reason)


def _lateral_shear(paths: Paths) -> Finding:
    path = paths["drained"]
    shear = m.at(path[["shear_lateral", "u"]].sel(side="outside").transpose("step", "azimuth", "depth"),
                 "shear_lateral", SHOWN)  # fmt: skip
    azimuth, depth = path["azimuth"].values, path["depth"].values
    rings = np.array([m.by_depth(depth, shear[k], DEPTHS) for k in range(len(azimuth))])
    front = np.abs(rings[0]) / np.abs(rings).max(axis=0)
    sixty = np.array([np.interp(np.pi / 3.0, azimuth, ring) for ring in rings.T])
    thirty = np.array([np.interp(np.pi / 6.0, azimuth, ring) for ring in rings.T])
    grows = bool((np.abs(sixty) > np.abs(thirty)).all() and (np.abs(thirty) > np.abs(rings[0])).all())
    figure = (
        f"outside, at 2.5 mm: front {_list(100 * front, '.0f')} % of the ring's largest {_at_depths()}; 30 deg "
        f"{_list(1e-3 * thirty, '.1f')} kPa, 60 deg {_list(1e-3 * sixty, '.1f')} kPa"
    )
    if not np.isfinite(front).all():
        return Finding(figure, (None,))
    return Finding(figure, (bool((front < 0.05).all()), grows))


def _vertical_shear(paths: Paths) -> Finding:
    path = paths["drained"]
    front = m.by_depth(path["depth"].values, m.field(path, "shear_vertical", SHOWN, m.FRONT), DEPTHS).mean()
    back = m.by_depth(path["depth"].values, m.field(path, "shear_vertical", SHOWN, m.BACK), DEPTHS).mean()
    inside, outside = (float(m.at(path, name, END)) for name in ("F_in", "F_out"))
    change = [_late_change(path, name) for name in ("F_in", "F_out")]
    figure = (
        f"on the soil at 2.5 mm, outside: {1e-3 * front:.1f} kPa in front, {1e-3 * back:.1f} kPa behind (down +); at "
        f"20 mm F_in {1e-3 * inside:.0f} kN, F_out {1e-3 * outside:.0f} kN; change from 15 to 20 mm "
        f"{_list(100 * np.array(change), '.0f')} % of the largest"
    )
    if not np.isfinite([front, back, inside, outside, *change]).all():
        return Finding(figure, (None,))
    # on the caisson up in front and down behind: on the soil the other way round
    holds = (front > 0.0 > back, abs(inside - outside) > 0.2 * max(abs(inside), abs(outside)), max(change) < 0.1)
    reason = "" if all(holds) else _which(holds, ("not opposite in front and behind", "not different", "no plateau"))
    return Finding(figure, tuple(bool(item) for item in holds), reason)


def _late_change(path: xr.Dataset, name: str) -> float:
    """Change of a force from 15 mm to 20 mm over its largest value on the path."""
    largest = float(np.abs(path[name].values).max())
    return abs(float(m.at(path, name, END) - m.at(path, name, 15e-3))) / largest if largest else 0.0


def _which(holds: Sequence[bool | None], words: Sequence[str]) -> str:
    return "; ".join(word for item, word in zip(holds, words, strict=True) if not item)


def _base(paths: Paths) -> Finding:
    path = paths["drained"]
    if "section_ux" not in path:
        return Finding("needs the symmetry plane", (None,))
    lid, tip, load = (float(m.at(path, name, END)) for name in ("H_lid", "H_tip", "H"))
    growing = m.tangent(path, 16e-3) * END / load
    rotation, sink = float(m.at(path, "rotation", SHOWN)), float(m.at(path, "w", SHOWN))
    length = float(path["depth_bounds"].values.max())
    follows = plug_motion(path)
    figure = (
        f"tip and lid carry {100 * (tip + lid) / load:.0f} % of H at 20 mm, where the load still grows by "
        f"{100 * growing:.0f} % a doubling of u; plug moves {_list([follows])} times the caisson; at 2.5 mm "
        f"rotation*L/u {rotation * length / SHOWN:.2f}, vertical {-1e3 * sink:.2f} mm (up +)"
    )
    if not np.isfinite([growing, rotation, sink, follows]).all():
        return Finding(figure, (None,))
    moves = rotation < 0.0 and abs(sink) < 0.5 * SHOWN
    return Finding(figure, (growing > 0.02, 0.8 <= follows <= 1.2, bool(moves)))


def plug_motion(path: xr.Dataset, u: float = SHOWN) -> float:
    """Lateral motion of the plug on the axis of the caisson over that of the caisson, fitted over the skirt."""
    x, depth = path["section_x"].values, path["section_depth"].values
    length = float(path["depth_bounds"].values.max())
    axis = np.flatnonzero((np.abs(x) < 1e-6 * np.abs(x).max()) & (depth <= length + 1e-6))
    order = axis[np.argsort(depth[axis])]
    soil = m.at(path, "section_ux", u)[order]
    caisson = float(m.at(path, "u", u)) + float(m.at(path, "rotation", u)) * depth[order]
    weight = np.gradient(depth[order])
    return float((soil * caisson * weight).sum() / (caisson**2 * weight).sum())


def _wedge(paths: Paths) -> Finding:
    path = paths["drained"]
    if "section_ux" not in path:
        return Finding("needs the symmetry plane", (None,))
    radius = _outer_radius(path)
    shift = [front_motion(path, radius, depth) for depth in (0.25, 2.0, 4.0)]
    lift = front_heave(path, radius)
    figure = (
        f"soil 1 m in front of the skirt at 2.5 mm moves {_list(1e3 * np.array(shift))} mm at 0.25, 2 and 4 m depth; "
        f"the surface there rises by up to {1e3 * lift:.2f} mm within 4 m"
    )
    if not np.isfinite([*shift, lift]).all():
        return Finding(figure, (None,))
    ratio = m.stress_ratio(path, SHOWN, m.FRONT, DEPTHS)
    return Finding(f"{figure}; front stress over initial {ratio[0]:.1f} at 0.25 m, {ratio[-1]:.1f} at 3.25 m",
                   (shift[0] > shift[1] > shift[2], lift > 0.0, bool(ratio[0] > ratio[-1])))  # fmt: skip


def _outer_radius(path: xr.Dataset) -> float:
    return 0.5 * float(path.attrs["outer_diameter_m"])


def front_motion(path: xr.Dataset, radius: float, depth: float, u: float = SHOWN, ahead: float = 1.0) -> float:
    """Lateral motion [m] of the soil so far ahead of the skirt [m] at a depth [m] of the symmetry plane.

    In front of the skirt the nodes stand in layers of equal depth: linear in each, and between them.
    """
    x, layer = path["section_x"].values, np.round(path["section_depth"].values, 9)
    front = x >= radius - 1e-6
    x, layer, values = x[front], layer[front], m.at(path, "section_ux", u)[front]
    depths, motion = np.unique(layer), []
    for each in depths:
        order = np.flatnonzero(layer == each)[np.argsort(x[layer == each])]
        motion.append(np.interp(radius + ahead, x[order], values[order]))
    return float(np.interp(depth, depths, motion))


def front_heave(path: xr.Dataset, radius: float, u: float = SHOWN, reach: float = 4.0) -> float:
    """Largest rise [m] of the mudline in front of the skirt within a reach [m]."""
    x, depth = path["section_x"].values, path["section_depth"].values
    near = (depth <= 1e-9) & (x >= radius - 1e-6) & (x <= radius + reach)
    return float((-m.at(path, "section_uz", u)[near]).max())


def _drainage_gain(paths: Paths) -> Finding:
    slow, drained = paths["slow"], paths["drained"]
    early = [m.load_ratio(slow, drained, u) for u in (0.5e-3, 1e-3, _SLOPE)]
    late = [m.load_ratio(slow, drained, u) for u in (5e-3, 10e-3, END)]
    figure = f"0.05 mm/s over drained: {_list(early, '.3f')} at 0.5, 1, 2 mm; {_list(late, '.3f')} at 5, 10, 20 mm"
    holds = (*(_is(value, 0.95, 1.05) for value in early), _is(late[-1], 1.02, np.inf))
    reason = "" if all(holds) else "no dilation (psi 0): little suction; see the sensitivity to psi"
    return Finding(figure, (_all(holds[:3]), holds[3]), reason)


def _all(items: Sequence[bool | None]) -> bool | None:
    return None if any(item is None for item in items) else all(items)


def _suction(paths: Paths) -> Finding:
    path = paths["slow"]
    inside = m.field(path, "pore_pressure", END, m.FRONT, "inside")
    depth = path["depth"].values
    front_top = float(inside[depth <= 1.0].min())
    outside = m.field(path, "pore_pressure", END, m.BACK)
    back_tip = float(outside[(depth >= 3.0) & (depth < depth[-1] + 1e-9)].min())
    lid = float(m.at(path, "F_pw", END))
    halfway = float(m.at(path, "F_pw", 0.5 * END))
    figure = (
        f"at 20 mm: {1e-3 * front_top:.2f} kPa inside in front in the upper metre, {1e-3 * back_tip:.2f} kPa outside "
        f"behind in the lowest metre; F_pw {1e-3 * halfway:.1f} kN at 10 mm, {1e-3 * lid:.1f} kN at 20 mm (suction -)"
    )
    if not np.isfinite([front_top, back_tip, lid, halfway]).all():
        return Finding(figure, (None,))
    holds = (front_top < 0.0, lid < 0.0, back_tip < 0.0, abs(lid) > abs(halfway))
    return Finding(figure, holds, _which(holds, ("no suction inside in front", "none under the lid",
                                                 "none behind near the tip", "F_pw does not grow")))  # fmt: skip


def _rear_contact(paths: Paths) -> Finding:
    slow, drained = paths["slow"], paths["drained"]
    back = [float(m.stress_ratio(path, SHOWN, m.BACK, (3.25,))[0]) for path in (drained, slow)]
    front = [float(m.stress_ratio(path, SHOWN, m.FRONT, DEPTHS).max()) for path in (drained, slow)]
    ends = [float(m.stress_ratio(path, END, m.BACK, (3.25,))[0]) for path in (drained, slow)]
    figure = (
        f"back at 3.25 m: {_list(back)} times initial drained and at 0.05 mm/s at 2.5 mm, {_list(ends)} at 20 mm; "
        f"front maximum {_list(front)}"
    )
    holds = (
        _is(back[1], 1e-6, np.inf), _is(back[1] - back[0], 0.02, np.inf), _is(front[1] / front[0], 0.9, 1.1),
    )  # fmt: skip
    return Finding(figure, holds, "the back keeps its contact when drained, too" if back[0] > _WALL_BACK else "")


def _py(paths: Paths) -> Finding:
    slow, drained = paths["slow"], paths["drained"]
    rising = [m.p_at(drained, depth, END) for depth in DEPTHS]
    over = [m.p_at(slow, depth, END) / p for depth, p in zip(DEPTHS, rising, strict=True)]
    bends = [py_bend(drained, depth) for depth in DEPTHS]
    y = [float(np.interp(END, drained["u"].values, m.py_curve(drained, depth)[0])) for depth in DEPTHS]
    figure = (
        f"at 20 mm, {_at_depths()}: p {_list(1e-3 * np.array(rising), '.0f')} kN/m drained, 0.05 mm/s over drained "
        f"{_list(over)}; y {_list(1e3 * np.array(y), '.1f')} mm; sharpest bend at y "
        f"{_list(1e3 * np.array(bends), '.1f')} mm"
    )
    holds = (
        _rises(rising), _is(over[0], 0.95, 1.05), _all([_is(value, 1.01, np.inf) for value in over[1:]]),
        _rises(bends), _rises(y[::-1]),
    )  # fmt: skip
    words = ("p does not grow with depth", "differs at 0.25 m", "not higher deeper down",
             "the bend does not move to larger y", "y not larger at the top")  # fmt: skip
    return Finding(figure, holds, "" if None in holds else _which(holds, words))


def py_bend(path: xr.Dataset, depth: float) -> float:
    """Displacement y [m] at the sharpest bend of the p-y curve at a depth [m]."""
    y, p = m.py_curve(path, depth)
    rising = np.maximum.accumulate(y)
    if (np.diff(rising) <= 0.0).any():
        return float("nan")
    return m.sharpest_bend(y, p, high=float(min(m.BEND_TO, y[-1])))[0]


def _rises(values: Sequence[float]) -> bool | None:
    return bool((np.diff(values) > 0.0).all()) if np.isfinite(values).all() else None


def _rate(paths: Paths) -> Finding:
    ratio = [m.load_ratio(paths["fast"], paths["slow"], u) for u in (SHOWN, 10e-3, END)]
    figure = f"0.5 over 0.05 mm/s: {_list(ratio, '.3f')} at 2.5, 10, 20 mm"
    return Finding(figure, (_is(ratio[-1], 1.0, 1.25),))


def _friction(paths: Paths) -> Finding:
    drained = [m.load_ratio(paths["drained-smooth"], paths["drained"], u) for u in (SHOWN, 5e-3, END)]
    slow = [m.load_ratio(paths["slow-smooth"], paths["slow"], u) for u in (SHOWN, 5e-3, END)]
    figure = f"mu 0 over mu 0.5 at 2.5, 5, 20 mm: {_list(drained)} drained, {_list(slow)} at 0.05 mm/s"
    return Finding(figure, (_is(drained[0], 0.4, 0.6), _is(slow[0], 0.0, 0.85)))


CLAIMS = (
    Claim(1, "a clear change of slope of the drained load-displacement curve near 2 mm; nearly elastic before it",
          "sharpest bend between 1 and 3 mm, where the tangent falls faster than 1/u; secant at 1 mm within 20 % of "
          "that at 0.1 mm", ("drained",), _slope_change),
    Claim(2, "front normal effective stress about 50 % above initial at 2.5 mm",
          "1.25 to 1.75 times initial at each of the four depths", ("drained",), _front_stress),
    Claim(3, "a gap at the back outside, larger at the top than at the bottom; no shear there",
          "behind, at 0.25 m and 2.5 mm, no contact stress and no shear; the opening is wider above than below half "
          "the skirt at 20 mm", ("drained",), _rear_gap),
    Claim(4, "lateral shear zero at the front and growing with azimuth away from it",
          "front below 5 % of the ring's largest; larger at 60 than at 30 deg, four depths", ("drained",),
          _lateral_shear),
    Claim(5, "vertical shear on the caisson up in front, down behind; different inside and outside; a plateau",
          "opposite signs in front and behind; F_in and F_out differ by more than 20 %; both change by less than 10 % "
          "from 15 to 20 mm", ("drained",), _vertical_shear),
    Claim(6, "base shear mobilised but not to failure; the plug moves with the caisson; rotation and slight vertical "
          "motion",
          "the load still grows at 20 mm; plug within 20 % of the caisson; rotation with heave or settlement below "
          "half of u at 2.5 mm", ("drained",), _base),
    Claim(7, "a wedge of soil in front yields first near the surface",
          "the soil in front moves more near the surface, which rises; the stress over initial is largest at the top",
          ("drained",), _wedge),
    Claim(8, "partially drained as drained before the slope break, stronger after it",
          "within 5 % up to 2 mm; at least 2 % above drained at 20 mm", ("drained", "slow"), _drainage_gain),
    Claim(9, "suction inside at the front near the top, under the lid, and outside behind near the tip; F_pw grows",
          "each below zero at 20 mm; F_pw larger at 20 than at 10 mm", ("slow",), _suction),
    Claim(10, "partial drainage keeps p'_N above zero behind (3.25 m) and hardly raises the maximum in front",
          "back at 3.25 m and 2.5 mm above zero, and above drained by 2 % of initial; front maximum within 10 %",
          ("drained", "slow"), _rear_contact),
    Claim(11, "p-y: load grows with depth; the same at 0.25 m, higher deeper when partially drained; the drained break "
          "moves to larger y with depth; y larger at the top",
          "each at 20 mm: p rises with depth; within 5 % at 0.25 m; 1 % higher at the others; bend and y in order",
          ("drained", "slow"), _py),
    Claim(12, "0.5 instead of 0.05 mm/s raises the load only slightly", "1.00 to 1.25 times at 20 mm",
          ("slow", "fast"), _rate),
    Claim(13, "mu = 0 halves the drained load; friction matters when partially drained, too",
          "0.4 to 0.6 times at 2.5 mm drained; below 0.85 at 0.05 mm/s",
          ("drained", "drained-smooth", "slow", "slow-smooth"), _friction),
)  # fmt: skip
