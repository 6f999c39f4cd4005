# SPDX-License-Identifier: MIT
"""A rigid caisson on invented, physical-looking soil reactions: result and spring trees of the true schema.

Not a soil model: contact stress, friction and base terms follow hyperbolas of the local displacement, chosen
so that stiffness (about 4 GN/m) and shapes resemble those of a caisson in sand. The reactions are the
integrals of the contact fields over the stations, with the sign rules of the result schema, and the states
are equilibria under the loads, so sums, balances and extraction can be tested against them. The reactions
depend on displacement *and* rotation, as real ones do: p-y curves of one path do not hold on another.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
import xarray as xr
from scipy.optimize import brentq

from pysprings.core import variables

SIDES = list(variables.SIDES)
COMPONENTS = list(variables.COMPONENTS)


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
    """Odd curve of initial slope `stiffness` that tends to +-limit."""
    return stiffness * x / (1.0 + np.abs(stiffness * x / limit))


def fields(c: Caisson, u: float, rotation: float) -> dict[str, np.ndarray]:
    """Contact fields (side, azimuth, depth) at a state (m, rad): stresses in Pa, gap in m."""
    z, theta = c.depth, c.azimuth[:, None]
    confinement = c.unit_weight * z + c.surcharge
    felt = u + rotation * z + c.coupling * rotation * c.length
    out: dict[str, list[np.ndarray]] = {
        "normal_effective_stress": [],
        "shear_lateral": [],
        "shear_vertical": [],
        "gap": [],
    }
    for sign, radius, share in ((1.0, c.radii[0], 1.0), (-1.0, c.radii[1], 0.25)):
        swing = hyperbola(felt, share * c.modulus, 4.0 * confinement)
        normal = confinement + sign * swing * np.cos(theta)
        lateral = hyperbola(felt, 0.5 * share * c.modulus, 0.4 * confinement) * np.sin(theta) ** 2
        down = -rotation * radius * np.cos(theta)
        vertical = hyperbola(down, 0.35 * share * c.modulus, 0.4 * confinement * np.ones_like(theta))
        out["normal_effective_stress"].append(np.maximum(normal, 0.0))
        touching = np.clip(normal / (0.2 * confinement), 0.0, 1.0)  # friction fades out before the gap opens
        out["shear_lateral"].append(lateral * touching)
        out["shear_vertical"].append(vertical * touching)
        out["gap"].append(np.maximum(-normal, 0.0) / c.modulus)
    return {name: np.stack(parts) for name, parts in out.items()}


def rings(c: Caisson, field: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Integrals of the fields ring by ring: p (depth, side, component), m and t (depth, side)."""
    outward = np.array([1.0, -1.0])[:, None, None]  # normal of the contact, caisson towards soil
    cos = np.cos(c.azimuth)[None, :, None]
    arc = (c.radii[:, None] * c.arc[None, :])[:, :, None]
    x = c.radii[:, None, None] * cos
    normal = (field["normal_effective_stress"] * outward * cos * arc).sum(axis=1)
    shear = (field["shear_lateral"] * arc).sum(axis=1)
    p = np.stack([normal, shear, np.zeros_like(normal)], axis=-1)
    m = (-field["shear_vertical"] * x * arc).sum(axis=1)
    t = (field["shear_vertical"] * arc).sum(axis=1)
    return {"p": np.moveaxis(p, 0, 1), "m": m.T, "t": t.T}


def base(c: Caisson, u: float, rotation: float) -> dict[str, float]:
    """Tip and lid terms (N, N m) at a state."""
    tip = u + rotation * c.length
    return {
        "H_tip": float(hyperbola(tip, 1.2e8, 1.5e5)),
        "M_tip": float(hyperbola(rotation, 4e9, 3e6)),
        "H_lid": float(hyperbola(u, 8e7, 2e5)),
        "M_lid": float(hyperbola(rotation, 2e9, 2e6)),
    }


def loads(c: Caisson, u: float, rotation: float) -> tuple[float, float]:
    """Total H (N) and M (N m) that hold the caisson at a state."""
    ring, b = rings(c, fields(c, u, rotation)), base(c, u, rotation)
    dz = np.diff(c.bounds)[:, 0]
    p, m = ring["p"].sum(axis=(1, 2)), ring["m"].sum(axis=1)
    lateral = float(p @ dz + b["H_tip"] + b["H_lid"])
    moment = float((p * c.depth + m) @ dz + c.length * b["H_tip"] + b["M_tip"] + b["M_lid"])
    return lateral, moment


@cache
def states(c: Caisson, path: Path) -> list[tuple[float, float]]:
    """Equilibrium states (u, rotation) of a path; denser at its start, as a solver's steps are."""
    ramp = path.size * np.linspace(0.0, 1.0, path.steps + 1) ** 1.5
    if path.kind == "rotation":
        return [(0.0, float(a)) for a in ramp]
    if path.kind == "translation":
        return [(float(u), 0.0) for u in ramp]

    def unbalance(rotation: float, u: float) -> float:
        lateral, moment = loads(c, u, rotation)
        return moment + lateral * path.arm

    found = [(0.0, 0.0)]
    for u in ramp[1:]:
        found.append(
            (
                float(u),
                float(brentq(unbalance, -4.0 * u / c.length, 2.0 * u / c.length, args=(u,), xtol=1e-16, rtol=1e-14)),
            )
        )
    return found


DEAD_LOAD = 2.0e6


def path_dataset(c: Caisson, path: Path) -> xr.Dataset:
    """The `/paths/<name>` dataset of the result schema."""
    track = states(c, path)
    n = len(track)
    u, rotation = np.array(track).T
    w = -0.15 * u**2 / 5e-3
    contact = [fields(c, *state) for state in track]
    ring = [rings(c, f) for f in contact]
    b = {name: np.array([base(c, *state)[name] for state in track]) for name in base(c, 0.0, 0.0)}
    p, m, t = (np.stack([r[name] for r in ring], axis=-1) for name in ("p", "m", "t"))
    z, dz = c.depth, np.diff(c.bounds)[:, 0]
    net = p.sum(axis=(1, 2))
    side_h = np.einsum("dscn,d->sn", p, dz)
    side_m = np.einsum("dscn,d->sn", p, dz * z) + np.einsum("dsn,d->sn", m, dz)
    side_v = np.einsum("dsn,d->sn", t, dz)
    v_tip = np.full(n, 0.3 * DEAD_LOAD)
    data: dict[str, tuple] = {
        "time": ("step", u.max() / 5e-5 * np.linspace(0, 1, n)),
        "u": ("step", u),
        "w": ("step", w),
        "rotation": ("step", rotation),
        "H": ("step", side_h.sum(0) + b["H_tip"] + b["H_lid"]),
        "V": ("step", np.full(n, DEAD_LOAD)),
        "M": ("step", side_m.sum(0) + c.length * b["H_tip"] + b["M_tip"] + b["M_lid"]),
        "H_outer": ("step", side_h[0]),
        "H_inner": ("step", side_h[1]),
        "M_outer": ("step", side_m[0]),
        "M_inner": ("step", side_m[1]),
        "V_outer": ("step", side_v[0]),
        "V_inner": ("step", side_v[1]),
        "V_tip": ("step", v_tip),
        "V_lid": ("step", DEAD_LOAD - v_tip - side_v.sum(0)),
        **{name: ("step", values) for name, values in b.items()},
        "F_pw": ("step", np.zeros(n)),
        "F_in": ("step", side_v[1] - side_v[1][0]),
        "F_out": ("step", side_v[0] - side_v[0][0]),
        "converged": ("step", np.ones(n, dtype=np.int8)),
        "depth_bounds": (("depth", "bound"), c.bounds),
        "p": (("depth", "step"), net),
        "y": (("depth", "step"), u + rotation * z[:, None]),
        "p_component": (("depth", "side", "component", "step"), p),
        "m": (("depth", "side", "step"), m),
        "t": (("depth", "side", "step"), t),
    }
    for name in contact[0]:
        data[name] = (("step", "side", "azimuth", "depth"), np.stack([f[name] for f in contact]))
    data["pore_pressure"] = (("step", "side", "azimuth", "depth"), np.zeros((n, 2, c.sectors + 1, c.rings)))
    data |= _under("lid", c, u, rotation, 0.0) | _under("tip", c, u, rotation, c.length)
    x, depth, _ = section_mesh(c)
    fade = np.exp(-np.maximum(np.abs(x) - c.radius, 0.0) / 5.0) * np.exp(-np.maximum(depth - c.length, 0.0) / 3.0)
    data["section_ux"] = (("step", "section_node"), (u[:, None] + rotation[:, None] * depth) * fade)
    data["section_uz"] = (("step", "section_node"), (w[:, None] - rotation[:, None] * x) * fade)
    coords = {"depth": z, "azimuth": c.azimuth, "side": SIDES, "component": COMPONENTS, "step": np.arange(n)}
    attrs = {"kind": path.kind, "arm_m": path.arm, "role": path.role, "status": "complete", "end": "reached"}
    return variables.attach(xr.Dataset(data, coords=coords, attrs=attrs), "result_path")


def _under(part: str, c: Caisson, u: np.ndarray, rotation: np.ndarray, depth: float) -> dict[str, tuple]:
    """Stations under the lid (half disc) or the tip (half ring): places, effective normal stress, opening."""
    radius = np.array([0.95, 2.0, 3.1]) if part == "lid" else np.array([c.radius - 0.5 * c.thickness])
    r, a = (v.ravel() for v in np.meshgrid(radius, c.azimuth))
    x, point = r * np.cos(a), f"{part}_point"
    start = c.surcharge + c.unit_weight * depth
    normal = start - 0.05 * c.modulus * rotation[:, None] * x - 2e6 * u[:, None]
    return {
        f"{part}_x": (point, x),
        f"{part}_y": (point, r * np.sin(a)),
        f"{part}_normal_effective_stress": (("step", point), np.maximum(normal, 0.0)),
        f"{part}_gap": (("step", point), np.maximum(-normal, 0.0) / c.modulus),
    }


def section_mesh(c: Caisson) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes x, depth (m) and quads (cell, 4) of a plain grid over the symmetry plane, 24 m by 12 m."""
    xs = np.unique(
        np.concatenate(
            [
                np.linspace(-24, -c.radius, 9),
                np.linspace(-c.radius, c.radius, 9),
                np.linspace(c.radius, 24, 9),
            ]
        )
    )
    zs = np.unique(np.concatenate([np.linspace(0, c.length, 7), np.linspace(c.length, 12, 7)]))
    x, depth = (v.ravel() for v in np.meshgrid(xs, zs))
    first = (np.arange(len(zs) - 1)[:, None] * len(xs) + np.arange(len(xs) - 1)[None, :]).ravel()
    return x, depth, np.stack([first, first + 1, first + len(xs) + 1, first + len(xs)], axis=1)


def convergence_dataset(steps: int) -> xr.Dataset:
    """An invented record: four iterations a step, one cut-back at step 2."""
    attempts = [(s, a) for s in range(1, steps + 1) for a in ((0, 1) if s == 2 else (0,))]
    rows = [
        (s, a, i, s / steps, 10.0 ** (-1.0 - 0.7 * i * i), 10.0 ** (-2.0 - i), 1.0, 4 * s, 20 * s, 90 * s, s)
        for s, a in attempts
        for i in range(4)
    ]
    names = (
        "increment",
        "attempt",
        "iteration",
        "load_fraction",
        "residual",
        "correction",
        "damping",
        "n_open",
        "n_slip",
        "n_plastic",
        "n_apex",
    )
    columns = {
        name: ("iteration", np.array(column)) for name, column in zip(names, zip(*rows, strict=True), strict=True)
    }
    return variables.attach(xr.Dataset(columns), "convergence")


def make_result(paths: tuple[Path, ...] = (Path(),), caisson: Caisson | None = None) -> xr.DataTree:
    """A result tree of the true schema."""
    c = caisson or Caisson()
    x, depth, quads = section_mesh(c)
    section = xr.Dataset(
        {
            "section_x": ("section_node", x),
            "section_depth": ("section_node", depth),
            "section_quad": (("section_cell", "corner"), quads),
        }
    )
    attrs = {
        "Conventions": "CF-1.11",
        "title": "synthetic caisson",
        "source": "pysprings 0.0.0",
        "pysprings_version": "0.0.0",
        "scene_sha256": "0" * 64,
        "scene_toml": "title = 'synthetic'\n",
        "solver": "none",
        "mesh_preset": "coarse",
        "n_nodes": 2000,
        "n_elements": 1700,
        "n_unknowns": 5500,
        "status": "complete",
        "history": "made by a test",
    }
    groups: dict[str, xr.Dataset] = {
        "/": xr.Dataset(attrs=attrs),
        "/section": variables.attach(section, "section"),
    }
    for path in paths:
        groups[f"/paths/{path.name}"] = path_dataset(c, path)
        groups[f"/paths/{path.name}/convergence"] = convergence_dataset(path.steps)
    return xr.DataTree.from_dict(groups)


def stiffness(c: Caisson) -> np.ndarray:
    """Initial tangent (u, w, rotation) by differences."""
    h = 1e-9
    k = np.zeros((3, 3))
    k[np.ix_([0, 2], [0])] = (np.array(loads(c, h, 0.0)) / h)[:, None]
    k[np.ix_([0, 2], [2])] = (np.array(loads(c, 0.0, h)) / h)[:, None]
    k[1, 1] = 3.5e9
    return k


SPRING_VARIABLES = (
    "m",
    "t",
    "y",
    "depth_bounds",
    "u",
    "w",
    "rotation",
    "H",
    "V",
    "M",
    "H_tip",
    "V_tip",
    "M_tip",
    "H_lid",
    "V_lid",
    "M_lid",
    "converged",
)


def make_springs(paths: tuple[Path, ...] = (Path(),), caisson: Caisson | None = None) -> xr.DataTree:
    """A springs tree of the true schema, from the same reactions as `make_result`."""
    c = caisson or Caisson()
    result = make_result(paths, c)
    keep = (
        "Conventions",
        "title",
        "source",
        "pysprings_version",
        "scene_sha256",
        "scene_toml",
        "status",
        "history",
    )
    attrs = {name: result.attrs[name] for name in keep} | {
        "outer_diameter_m": 2 * c.radius,
        "skirt_length_m": c.length,
        "skirt_thickness_m": c.thickness,
        "vertical_load_N": DEAD_LOAD,
        "drainage": "drained",
        "schema": "pysprings-springs-2",
    }
    root = xr.Dataset(
        {"stiffness_initial": (("dof", "dof_conjugate"), stiffness(c))},
        coords={"dof": list(variables.DOFS), "dof_conjugate": list(variables.DOFS)},
        attrs=attrs,
    )
    groups: dict[str, xr.Dataset] = {"/": variables.attach(root, "springs_root")}
    for path in paths:
        full = result[f"/paths/{path.name}"].to_dataset(inherit=False)
        springs = full[list(SPRING_VARIABLES)].drop_vars("azimuth", errors="ignore")
        springs["p"] = full["p_component"]
        groups[f"/paths/{path.name}"] = variables.attach(springs, "springs_path")
    return xr.DataTree.from_dict(groups)
