# SPDX-License-Identifier: MIT
"""The thirteen claims of the paper, each beside our figure: agrees, partly or differs, and why.

A claim's verdict comes from a criterion that is stated with it; the criteria turn the paper's words into numbers, since
its text gives few. "partly" is what holds in part of the criterion's items.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass

import pandas as pd

from validation.paper.claims_drained import (
    base,
    front_stress,
    lateral_shear,
    rear_gap,
    slope_change,
    vertical_shear,
    wedge,
)
from validation.paper.claims_water import drainage_gain, friction, py, rate, rear_contact, suction
from validation.paper.findings import UNKNOWN, Finding, Paths


@dataclass(frozen=True)
class Claim:
    """A statement of the paper, the criterion that represents it, the runs it needs, and its measurement."""

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
        finding = Finding(f"needs the run {', '.join(missing)}", (None,)) if missing else claim.measure(paths)
        reached = re.sub(r"\bnan\b", "-", finding.figure)
        if reached != finding.figure or (finding.verdict == UNKNOWN and not missing):
            finding = Finding(f"{reached} (-: a run stopped before it)", finding.holds, finding.reason)
        rows.append({
            "number": claim.number, "claim": claim.words, "figure": finding.figure, "verdict": finding.verdict,
            "reason": finding.reason, "criterion": claim.criterion,
        })  # fmt: skip
    return pd.DataFrame(rows)


CLAIMS = (
    Claim(1, "a clear change of slope of the drained load-displacement curve near 2 mm; nearly elastic before it",
          "sharpest bend between 1 and 3 mm, where the tangent falls faster than 1/u; secant at 1 mm within 20 % of "
          "that at 0.1 mm", ("drained",), slope_change),
    Claim(2, "front normal effective stress about 50 % above initial at 2.5 mm",
          "1.25 to 1.75 times initial at each of the four depths", ("drained",), front_stress),
    Claim(3, "a gap at the back outside, larger at the top than at the bottom; no shear there",
          "behind, at 0.25 m and 2.5 mm, no contact stress and no shear; the opening is wider above than below half "
          "the skirt at 20 mm", ("drained",), rear_gap),
    Claim(4, "lateral shear zero at the front and growing with azimuth away from it",
          "front below 5 % of the ring's largest; larger at 60 than at 30 deg, four depths", ("drained",),
          lateral_shear),
    Claim(5, "vertical shear on the caisson up in front, down behind; different inside and outside; a plateau",
          "opposite signs in front and behind; F_in and F_out differ by more than 20 %; both change by less than 10 % "
          "from 15 to 20 mm", ("drained",), vertical_shear),
    Claim(6, "base shear mobilised but not to failure; the plug moves with the caisson; rotation and slight vertical "
          "motion",
          "the load still grows at 20 mm; plug within 20 % of the caisson; rotation with heave or settlement below "
          "half of u at 2.5 mm", ("drained",), base),
    Claim(7, "a wedge of soil in front yields first near the surface",
          "the soil in front moves more near the surface, which rises; the stress over initial is largest at the top",
          ("drained",), wedge),
    Claim(8, "partially drained as drained before the slope break, stronger after it",
          "within 5 % up to 2 mm; at least 2 % above drained at 20 mm", ("drained", "slow"), drainage_gain),
    Claim(9, "suction inside at the front near the top, under the lid, and outside behind near the tip; F_pw grows",
          "each below zero at 20 mm; F_pw larger at 20 than at 10 mm", ("slow",), suction),
    Claim(10, "partial drainage keeps p'_N above zero behind (3.25 m) and hardly raises the maximum in front",
          "back at 3.25 m and 2.5 mm above zero, and above drained by 2 % of initial; front maximum within 10 %",
          ("drained", "slow"), rear_contact),
    Claim(11, "p-y: load grows with depth; the same at 0.25 m, higher deeper when partially drained; the drained break "
          "moves to larger y with depth; y larger at the top",
          "each at 20 mm: p rises with depth; within 5 % at 0.25 m; 1 % higher at the others; bend and y in order",
          ("drained", "slow"), py),
    Claim(12, "0.5 instead of 0.05 mm/s raises the load only slightly", "1.00 to 1.25 times at 20 mm",
          ("slow", "fast"), rate),
    Claim(13, "mu = 0 halves the drained load; friction matters when partially drained, too",
          "0.4 to 0.6 times at 2.5 mm drained; below 0.85 at 0.05 mm/s",
          ("drained", "drained-smooth", "slow", "slow-smooth"), friction),
)  # fmt: skip
