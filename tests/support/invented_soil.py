# SPDX-License-Identifier: MIT
"""A rigid caisson on invented, physical-looking soil reactions.

Not a soil model: contact stress, friction and base terms follow hyperbolas of the local displacement, chosen
so that stiffness (about 4 GN/m) and shapes resemble those of a caisson in sand. The reactions are the
integrals of the contact fields over the stations, with the sign rules of the result schema, and the states
are equilibria under the loads, so sums, balances and extraction can be tested against them. The reactions
depend on displacement *and* rotation, as real ones do: p-y curves of one path do not hold on another.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.optimize import brentq


@dataclass(frozen=True)
class Path:
    """One load path: kind pull | translation | rotation, size (m or rad), arm (m above mudline)."""

    name: str = "pull"
    kind: str = "pull"
    size: float = 5e-3
    arm: float = 0.0
    role: str = "calibration"
    steps: int = 20


@dataclass(frozen=True)
class Caisson:
    """Geometry (m), strength and stiffness of the invented soil; rings include the mudline and the tip."""

    radius: float = 3.9
    thickness: float = 0.1
    length: float = 4.0
    rings: int = 13
    sectors: int = 16
    modulus: float = 4.5e7  # N/m^3, contact stress per lateral displacement at the front
    unit_weight: float = 10.56e3
    surcharge: float = 10.56e3
    coupling: float = 0.25  # share of rotation*length felt by the contact stress besides y

    @property
    def depth(self) -> np.ndarray:
        s = np.linspace(0.0, 1.0, self.rings)
        return self.length * (s + 0.12 * np.sin(2 * np.pi * s) / np.pi)  # a little denser at both ends

    @property
    def bounds(self) -> np.ndarray:
        middle = 0.5 * (self.depth[1:] + self.depth[:-1])
        edges = np.concatenate([[0.0], middle, [self.length]])
        return np.stack([edges[:-1], edges[1:]], axis=1)

    @property
    def azimuth(self) -> np.ndarray:
        return np.linspace(0.0, np.pi, self.sectors + 1)

    @property
    def arc(self) -> np.ndarray:
        """Arc weights (rad) of the stations; both halves of the caisson counted."""
        weights = np.full(self.sectors + 1, np.pi / self.sectors)
        weights[[0, -1]] *= 0.5
        return 2.0 * weights

    @property
    def radii(self) -> np.ndarray:
        return np.array([self.radius, self.radius - self.thickness])


def hyperbola(x, stiffness, limit):
    """Return the odd curve of initial slope `stiffness` that tends to +-limit."""
    return stiffness * x / (1.0 + np.abs(stiffness * x / limit))


def fields(c: Caisson, u: float, rotation: float) -> dict[str, np.ndarray]:
    """Return the contact fields (side, azimuth, depth) at a state (m, rad): stresses in Pa, gap in m."""
    z, theta = c.depth, c.azimuth[:, None]
    confinement = c.unit_weight * z + c.surcharge
    felt = u - rotation * z - c.coupling * rotation * c.length
    names = ("normal_effective_stress", "shear_lateral", "shear_vertical", "gap")
    out: dict[str, list[np.ndarray]] = {name: [] for name in names}
    for sign, radius, share in ((1.0, c.radii[0], 1.0), (-1.0, c.radii[1], 0.25)):
        swing = hyperbola(felt, share * c.modulus, 4.0 * confinement)
        normal = confinement + sign * swing * np.cos(theta)
        lateral = hyperbola(felt, 0.5 * share * c.modulus, 0.4 * confinement) * np.sin(theta) ** 2
        down = rotation * radius * np.cos(theta)
        vertical = hyperbola(down, 0.35 * share * c.modulus, 0.4 * confinement * np.ones_like(theta))
        out["normal_effective_stress"].append(np.maximum(normal, 0.0))
        touching = np.clip(normal / (0.2 * confinement), 0.0, 1.0)  # friction fades out before the gap opens
        out["shear_lateral"].append(lateral * touching)
        out["shear_vertical"].append(vertical * touching)
        out["gap"].append(np.maximum(-normal, 0.0) / c.modulus)
    return {name: np.stack(parts) for name, parts in out.items()}


def rings(c: Caisson, field: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the integrals of the fields ring by ring: p (depth, side, component), m and t (depth, side)."""
    outward = np.array([1.0, -1.0])[:, None, None]  # normal of the contact, caisson towards soil
    cos = np.cos(c.azimuth)[None, :, None]
    arc = (c.radii[:, None] * c.arc[None, :])[:, :, None]
    x = c.radii[:, None, None] * cos
    normal = (field["normal_effective_stress"] * outward * cos * arc).sum(axis=1)
    shear = (field["shear_lateral"] * arc).sum(axis=1)
    p = np.stack([normal, shear, np.zeros_like(normal)], axis=-1)
    m = (field["shear_vertical"] * x * arc).sum(axis=1)
    t = (field["shear_vertical"] * arc).sum(axis=1)
    return {"p": np.moveaxis(p, 0, 1), "m": m.T, "t": t.T}


def base(c: Caisson, u: float, rotation: float) -> dict[str, float]:
    """Return the tip and lid terms (N, N m) at a state."""
    tip = u - rotation * c.length
    return {
        "H_tip": float(hyperbola(tip, 1.2e8, 1.5e5)),
        "M_tip": float(hyperbola(rotation, 4e9, 3e6)),
        "H_lid": float(hyperbola(u, 8e7, 2e5)),
        "M_lid": float(hyperbola(rotation, 2e9, 2e6)),
    }


def loads(c: Caisson, u: float, rotation: float) -> tuple[float, float]:
    """Return the total H (N) and M (N m) that hold the caisson at a state."""
    ring, b = rings(c, fields(c, u, rotation)), base(c, u, rotation)
    dz = np.diff(c.bounds)[:, 0]
    p, m = ring["p"].sum(axis=(1, 2)), ring["m"].sum(axis=1)
    lateral = float(p @ dz + b["H_tip"] + b["H_lid"])
    moment = float((m - p * c.depth) @ dz - c.length * b["H_tip"] + b["M_tip"] + b["M_lid"])
    return lateral, moment


@cache
def states(c: Caisson, path: Path) -> list[tuple[float, float]]:
    """Return the equilibrium states (u, rotation) of a path; denser at its start, as a solver's steps are."""
    ramp = path.size * np.linspace(0.0, 1.0, path.steps + 1) ** 1.5
    if path.kind == "rotation":
        return [(0.0, float(a)) for a in ramp]
    if path.kind == "translation":
        return [(float(u), 0.0) for u in ramp]

    def unbalance(rotation: float, u: float) -> float:
        lateral, moment = loads(c, u, rotation)
        return moment - lateral * path.arm

    solved = [(0.0, 0.0)]
    for u in ramp[1:]:
        ends = -2.0 * u / c.length, 4.0 * u / c.length
        solved.append((float(u), float(brentq(unbalance, *ends, args=(u,), xtol=1e-16, rtol=1e-14))))
    return solved


def stiffness(c: Caisson) -> np.ndarray:
    """Return the initial tangent (u, w, rotation) by differences."""
    h = 1e-9
    k = np.zeros((3, 3))
    k[np.ix_([0, 2], [0])] = (np.array(loads(c, h, 0.0)) / h)[:, None]
    k[np.ix_([0, 2], [2])] = (np.array(loads(c, 0.0, h)) / h)[:, None]
    k[1, 1] = 3.5e9
    return k
