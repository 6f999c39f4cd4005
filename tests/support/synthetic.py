# SPDX-License-Identifier: MIT
"""Result and spring trees of the true schema, made of the invented soil (`invented_soil.py`)."""

from itertools import pairwise

import numpy as np
import xarray as xr

from pysprings.core import variables
from pysprings.springs.checks import RESULT, SCHEMA
from tests.support.invented_soil import Caisson, Path, base, fields, rings, states, stiffness

SIDES = list(variables.SIDES)
COMPONENTS = list(variables.COMPONENTS)


TORSION = 2.5e9  # N m/rad
DEAD_LOAD = 2.0e6


def path_dataset(c: Caisson, path: Path) -> xr.Dataset:
    """Return the `/paths/<name>` dataset of the result schema."""
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
    side_m = -np.einsum("dscn,d->sn", p, dz * z) + np.einsum("dsn,d->sn", m, dz)
    side_v = np.einsum("dsn,d->sn", t, dz)
    v_tip = np.full(n, 0.3 * DEAD_LOAD)
    data: dict[str, tuple] = {
        "time": ("step", u.max() / 5e-5 * np.linspace(0, 1, n)),
        "u": ("step", u),
        "w": ("step", w),
        "rotation": ("step", rotation),
        "H": ("step", side_h.sum(0) + b["H_tip"] + b["H_lid"]),
        "V": ("step", np.full(n, DEAD_LOAD)),
        "M": ("step", side_m.sum(0) - c.length * b["H_tip"] + b["M_tip"] + b["M_lid"]),
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
        "y": (("depth", "step"), u - rotation * z[:, None]),
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
    data["section_ux"] = (("step", "section_node"), (u[:, None] - rotation[:, None] * depth) * fade)
    data["section_uz"] = (("step", "section_node"), (w[:, None] + rotation[:, None] * x) * fade)
    coords = {"depth": z, "azimuth": c.azimuth, "side": SIDES, "component": COMPONENTS, "step": np.arange(n)}
    attrs = {"kind": path.kind, "arm_m": path.arm, "role": path.role, "status": "complete", "end": "reached"}
    return variables.attach(xr.Dataset(data, coords=coords, attrs=attrs), "result_path")


def _under(part: str, c: Caisson, u: np.ndarray, rotation: np.ndarray, depth: float) -> dict[str, tuple]:
    """Return stations under the lid (half disc) or the tip (half ring): places, effective normal stress, opening."""
    radius = np.array([0.95, 2.0, 3.1]) if part == "lid" else np.array([c.radius - 0.5 * c.thickness])
    r, a = (v.ravel() for v in np.meshgrid(radius, c.azimuth))
    x, point = r * np.cos(a), f"{part}_point"
    start = c.surcharge + c.unit_weight * depth
    normal = start + 0.05 * c.modulus * rotation[:, None] * x - 2e6 * u[:, None]
    return {
        f"{part}_x": (point, x),
        f"{part}_y": (point, r * np.sin(a)),
        f"{part}_normal_effective_stress": (("step", point), np.maximum(normal, 0.0)),
        f"{part}_gap": (("step", point), np.maximum(-normal, 0.0) / c.modulus),
    }


def section_mesh(c: Caisson) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the nodes x, depth (m) and quads (cell, 4) of a plain grid over the symmetry plane, 24 m by 12 m."""
    lines = (-24.0, -c.radius, c.radius, 24.0)
    xs = np.unique(np.concatenate([np.linspace(a, b, 9) for a, b in pairwise(lines)]))
    zs = np.unique(np.concatenate([np.linspace(0, c.length, 7), np.linspace(c.length, 12, 7)]))
    x, depth = (v.ravel() for v in np.meshgrid(xs, zs))
    first = (np.arange(len(zs) - 1)[:, None] * len(xs) + np.arange(len(xs) - 1)[None, :]).ravel()
    return x, depth, np.stack([first, first + 1, first + len(xs) + 1, first + len(xs)], axis=1)


def convergence_dataset(steps: int) -> xr.Dataset:
    """Return an invented record: four iterations a step, one cut-back at step 2."""
    attempts = [(s, a) for s in range(1, steps + 1) for a in ((0, 1) if s == 2 else (0,))]
    rows = [
        (s, a, i, s / steps, 10.0 ** (-1.0 - 0.7 * i * i), 10.0 ** (-2.0 - i), 1.0, 4 * s, 20 * s, 90 * s, s)
        for s, a in attempts
        for i in range(4)
    ]
    names = [
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
    ]
    columns = {name: ("iteration", np.array(each)) for name, each in zip(names, zip(*rows, strict=True), strict=True)}
    return variables.attach(xr.Dataset(columns), "convergence")


def make_result(paths: tuple[Path, ...] = (Path(),), caisson: Caisson | None = None) -> xr.DataTree:
    """Return a result tree of the true schema."""
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
        "schema": RESULT,
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
    groups: dict[str, xr.Dataset] = {"/": xr.Dataset(attrs=attrs), "/section": variables.attach(section, "section")}
    for path in paths:
        groups[f"/paths/{path.name}"] = path_dataset(c, path)
        groups[f"/paths/{path.name}/convergence"] = convergence_dataset(path.steps)
    return xr.DataTree.from_dict(groups)


SPRING_VARIABLES = (
    "p", "p_component", "m", "t", "y", "depth_bounds", "u", "w", "rotation", "H", "V", "M",
    "H_tip", "V_tip", "M_tip", "H_lid", "V_lid", "M_lid", "converged",
)  # fmt: skip


def make_springs(paths: tuple[Path, ...] = (Path(),), caisson: Caisson | None = None) -> xr.DataTree:
    """Return a springs tree of the true schema, from the same reactions as `make_result`."""
    c = caisson or Caisson()
    result = make_result(paths, c)
    keep = (
        "Conventions", "title", "source", "pysprings_version", "scene_sha256", "scene_toml", "status", "history",
    )  # fmt: skip
    attrs = {name: result.attrs[name] for name in keep} | {
        "outer_diameter_m": 2 * c.radius,
        "skirt_length_m": c.length,
        "skirt_thickness_m": c.thickness,
        "vertical_load_N": DEAD_LOAD,
        "drainage": "drained",
        "schema": SCHEMA,
        variables.TORSION: TORSION,
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
        groups[f"/paths/{path.name}"] = variables.attach(springs, "springs_path")
    return xr.DataTree.from_dict(groups)
