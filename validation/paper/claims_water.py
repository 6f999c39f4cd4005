# SPDX-License-Identifier: MIT
"""The paper's claims about partial drainage, rate and friction, measured (8 to 13)."""

import numpy as np
import xarray as xr

from validation.paper import measures as m
from validation.paper.cases import DEPTHS, END, SHOWN
from validation.paper.findings import Finding, Paths, at_depths, every, joined, rises, which, within

_SLOPE = 2e-3  # m, where the paper sees the change of slope
_OPEN = 1e-9  # of the initial stress


def drainage_gain(paths: Paths) -> Finding:
    """Load at 0.05 mm/s over the drained one."""
    slow, drained = paths["slow"], paths["drained"]
    early = [m.load_ratio(slow, drained, u) for u in (0.5e-3, 1e-3, _SLOPE)]
    late = [m.load_ratio(slow, drained, u) for u in (5e-3, 10e-3, END)]
    figure = f"0.05 mm/s over drained: {joined(early, '.3f')} at 0.5, 1, 2 mm; {joined(late, '.3f')} at 5, 10, 20 mm"
    holds = (*(within(value, 0.95, 1.05) for value in early), within(late[-1], 1.02, np.inf))
    reason = "" if all(holds) else "no dilation (psi 0): little suction; see the sensitivity to psi"
    return Finding(figure, (every(holds[:3]), holds[3]), reason)


def suction(paths: Paths) -> Finding:
    """Judge pore pressures at 0.05 mm/s, and their force under the lid."""
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
    return Finding(figure, holds, which(holds, ("no suction inside in front", "none under the lid",
                                                 "none behind near the tip", "F_pw does not grow")))  # fmt: skip


def rear_contact(paths: Paths) -> Finding:
    """Judge contact behind and stress in front, drained and at 0.05 mm/s."""
    slow, drained = paths["slow"], paths["drained"]
    back = [float(m.stress_ratio(path, SHOWN, m.BACK, (3.25,))[0]) for path in (drained, slow)]
    front = [float(m.stress_ratio(path, SHOWN, m.FRONT, DEPTHS).max()) for path in (drained, slow)]
    ends = [float(m.stress_ratio(path, END, m.BACK, (3.25,))[0]) for path in (drained, slow)]
    figure = (
        f"back at 3.25 m: {joined(back)} times initial drained and at 0.05 mm/s at 2.5 mm, {joined(ends)} at 20 mm; "
        f"front maximum {joined(front)}"
    )
    holds = (
        within(back[1], 1e-6, np.inf), within(back[1] - back[0], 0.02, np.inf), within(front[1] / front[0], 0.9, 1.1),
    )  # fmt: skip
    return Finding(figure, holds, "the back keeps its contact when drained, too" if back[0] > _OPEN else "")


def py(paths: Paths) -> Finding:
    """Judge order, gain and bends of the p-y curves."""
    slow, drained = paths["slow"], paths["drained"]
    rising = [m.p_at(drained, depth, END) for depth in DEPTHS]
    over = [m.p_at(slow, depth, END) / p for depth, p in zip(DEPTHS, rising, strict=True)]
    bends = [py_bend(drained, depth) for depth in DEPTHS]
    y = [float(np.interp(END, drained["u"].values, m.py_curve(drained, depth)[0])) for depth in DEPTHS]
    figure = (
        f"at 20 mm, {at_depths()}: p {joined(1e-3 * np.array(rising), '.0f')} kN/m drained, 0.05 mm/s over drained "
        f"{joined(over)}; y {joined(1e3 * np.array(y), '.1f')} mm; sharpest bend at y "
        f"{joined(1e3 * np.array(bends), '.1f')} mm"
    )
    holds = (
        rises(rising), within(over[0], 0.95, 1.05), every([within(value, 1.01, np.inf) for value in over[1:]]),
        rises(bends), rises(y[::-1]),
    )  # fmt: skip
    words = ("p does not grow with depth", "differs at 0.25 m", "not higher deeper down",
             "the bend does not move to larger y", "y not larger at the top")  # fmt: skip
    return Finding(figure, holds, "" if None in holds else which(holds, words))


def py_bend(path: xr.Dataset, depth: float) -> float:
    """Return the displacement y [m] at the sharpest bend of the p-y curve at a depth [m]."""
    y, p = m.py_curve(path, depth)
    rising = np.maximum.accumulate(y)
    if (np.diff(rising) <= 0.0).any():
        return float("nan")
    return m.sharpest_bend(y, p, high=float(min(m.BEND_TO, y[-1])))[0]


def rate(paths: Paths) -> Finding:
    """Load at 0.5 over that at 0.05 mm/s."""
    ratio = [m.load_ratio(paths["fast"], paths["slow"], u) for u in (SHOWN, 10e-3, END)]
    figure = f"0.5 over 0.05 mm/s: {joined(ratio, '.3f')} at 2.5, 10, 20 mm"
    return Finding(figure, (within(ratio[-1], 1.0, 1.25),))


def friction(paths: Paths) -> Finding:
    """Load without friction over that with it."""
    drained = [m.load_ratio(paths["drained-smooth"], paths["drained"], u) for u in (SHOWN, 5e-3, END)]
    slow = [m.load_ratio(paths["slow-smooth"], paths["slow"], u) for u in (SHOWN, 5e-3, END)]
    figure = f"mu 0 over mu 0.5 at 2.5, 5, 20 mm: {joined(drained)} drained, {joined(slow)} at 0.05 mm/s"
    return Finding(figure, (within(drained[0], 0.4, 0.6), within(slow[0], 0.0, 0.85)))
