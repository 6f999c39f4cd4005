# SPDX-License-Identifier: MIT
"""What an atlas expects -> a spring set like that of a full model, with the group `atlas` for its standard deviation.

Reactions by depth are net ones: they stand at the side "outside" and the component "normal", and the vertical load at
rest stands at the tip. Loads are the sums of the reactions.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from pysprings.core import variables
from pysprings.core.arrays import Array
from pysprings.core.version import __version__
from pysprings.scene.defaults import implausible
from pysprings.scene.fan import ray_name
from pysprings.scene.model import Scene
from pysprings.springs.checks import SCHEMA
from pysprings.springs.springs import SPREAD
from pysprings.studies.atlas.between import between
from pysprings.studies.atlas.model import Atlas, Estimate
from pysprings.studies.atlas.samples import FORCES, MOMENTS, ROWS, share

_NOTHING = 1e-9  # of rho: w that is rounding
_CLOSE = 0.05  # share by which knots differ at the least
# what the extrapolation of full models of clay on the mesh `coarse` leaves of their loads (docs/evidence, "Sections");
# sand takes it, too: 97 % of its held-back loads are inside
MESH_LEFT = 0.033
STIFFNESS_LEFT = 0.006  # of the initial stiffness, which is that of one mesh: `coarse` beside `fine`, both grounds
OF_MESH = "made on one mesh, '{}', whose error the deviations do not have: confirm by a run on a finer mesh"
_BAND = 1.96
_N = sum(name.startswith("p") for name in FORCES)
_TOGETHER = "both sides and all components together, which an atlas does not divide"


def spring_tree(atlas: Atlas, scene: Scene, estimate: Estimate) -> xr.DataTree:
    """Return the springs of a scene; they hold what `pysprings.springs.checks` asks for by the way they are made."""
    D, L = scene.caisson.outer_diameter, scene.caisson.skirt_length
    sizes = atlas.family.sizes(scene)
    last = min(sizes.ratio * atlas.reach, float(atlas.X[-1]))
    knots = np.append(atlas.X[(1.0 - _CLOSE) * last > atlas.X], last)
    rho = np.concatenate([[0.0], knots * D / sizes.ratio])
    values = _at_rest(_physical(_between(atlas.X, estimate.values, knots), knots, sizes.force, L, D / sizes.ratio))
    modes = _at_rest(_physical(_between(atlas.X, estimate.modes, knots), knots, sizes.force, L, D / sizes.ratio))
    given = scene.caisson.vertical_load
    V = 0.0 if isinstance(given, str) else float(given)  # balanced: 0 in a bonded or unloaded ground
    rest = _between(atlas.X, atlas.factor * atlas.rest, knots) * share(knots) * sizes.force
    modes = np.concatenate([modes, _left(rest, L)])
    values, modes, angles = between(values, modes, _action(L), atlas.angles, rho)
    part = np.append(0.0, share(knots))
    own_modes = [atlas.fan[0] * part * values, np.append(0.0, np.full(knots.shape, MESH_LEFT / _BAND)) * values]
    modes = np.concatenate([modes, own_modes])
    names = [ray_name(round(float(np.degrees(angle)), 1)) for angle in angles]
    coords = _coordinates(L, rho.size)
    paths = {
        f"/paths/{name}": _path(values[k], rho, float(angle), coords, V, estimate.settled)
        for k, (name, angle) in enumerate(zip(names, angles, strict=True))
    }
    root = _root(atlas, scene, estimate, V)
    spread = _spread(names, modes, rho, atlas.fan[1] * part, L)
    return xr.DataTree.from_dict({"/": root, **paths, f"/{SPREAD}": spread}, name="springs")


def mesh_words(atlas: Atlas) -> str:
    """Return words on the mesh of the full models of an atlas; empty where they are extrapolated from two."""
    extrapolated = atlas.about.get("mesh", "").endswith(variables.EXTRAPOLATED)
    return "" if extrapolated else OF_MESH.format(atlas.base.mesh.preset)


def _between(X: Array, values: Array, knots: Array) -> Array:
    """Return values (..., X) at knots, linear in log X."""
    place = np.clip(np.searchsorted(X, knots, side="right") - 1, 0, X.size - 2)
    part = np.log(knots / X[place]) / np.log(X[place + 1] / X[place])
    return np.asarray(values[..., place] * (1.0 - part) + values[..., place + 1] * part)


def _physical(values: Array, knots: Array, force: float, L: float, stretch: float) -> Array:
    """Return rows (..., row, knot) in SI: N, N m, m."""
    n = len(FORCES)
    unit = np.concatenate([np.full(n, force), np.full(len(MOMENTS), force * L), [stretch]])
    along = np.where(np.arange(len(ROWS))[:, None] < len(ROWS) - 1, share(knots), knots)
    return np.asarray(values * unit[:, None] * along)


def _at_rest(rows: Array) -> Array:
    """Return rows with a state at rest in front."""
    return np.concatenate([np.zeros((*rows.shape[:-1], 1)), rows], axis=-1)


def _coordinates(L: float, steps: int) -> xr.Coordinates:
    """Return the coordinates that all paths share."""
    edges = np.linspace(0.0, L, _N + 1)
    coords: dict[str, Any] = {
        "depth": ("depth", 0.5 * (edges[1:] + edges[:-1])), "side": ("side", list(variables.SIDES)),
        "component": ("component", list(variables.COMPONENTS)), "step": ("step", np.arange(steps)),
    }  # fmt: skip
    return xr.Dataset(coords=_described(coords)).coords


def _path(rows: Array, rho: Array, angle: float, coords: xr.Coordinates, V: float, settled: float) -> xr.Dataset:
    depth, steps = coords["depth"].values, rho.size
    dz = 2.0 * float(depth[0])
    L = dz * _N
    row = dict(zip(ROWS, rows, strict=True))
    edges = dz * np.arange(_N + 1)
    straight = abs(np.cos(angle)) < 1e-9
    u = np.zeros(steps) if straight else rho * np.cos(angle)
    rotation = rho * np.sin(angle) / L if angle else np.zeros(steps)

    def slices(name: str) -> Array:
        return np.stack([row[f"{name}{k}"] for k in range(_N)]) / dz

    p = np.zeros((_N, 2, len(variables.COMPONENTS), steps))
    p[:, 0, 0] = slices("p")
    two = {name: np.stack([slices(name), np.zeros((_N, steps))], axis=1) for name in ("m", "t")}
    along = {name: row[name] for name in ("H_tip", "H_lid", "M_tip", "M_lid", "V_lid")}
    along |= {"V_tip": row["V_tip"] + V, "u": u, "rotation": rotation}
    along["w"] = settled + np.where(np.abs(row["w"]) < _NOTHING * rho, 0.0, row["w"])
    H, M = _action(L).T @ rows
    along |= {"H": H, "M": L * M, "V": dz * slices("t").sum(axis=0) + along["V_tip"] + row["V_lid"]}
    data: dict[str, Any] = {name: ("step", values) for name, values in along.items()}
    data |= {
        "depth_bounds": (("depth", "bound"), np.stack([edges[:-1], edges[1:]], axis=1)),
        "p": (("depth", "step"), p[:, 0, 0]), "p_component": (("depth", "side", "component", "step"), p),
        "m": (("depth", "side", "step"), two["m"]), "t": (("depth", "side", "step"), two["t"]),
        "y": (("depth", "step"), u - rotation * depth[:, None]),
        "converged": ("step", np.ones(steps, dtype=np.int8)),
    }  # fmt: skip
    path = xr.Dataset(_described(data), coords, _path_attributes(along, straight))
    for name in ("p_component", "m", "t"):
        path[name].attrs["comment"] = f"{path[name].attrs['comment']}; {_TOGETHER}"
    return path


def _described(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return variables with the attributes that the files of springs have."""
    known = variables.GROUPS["springs_path"]
    return {name: (*pair, known[name].attributes() if name in known else {}) for name, pair in values.items()}


def _path_attributes(along: Mapping[str, Array], is_rotation: bool) -> dict[str, Any]:
    last = {name: float(along[name][-1]) for name in ("H", "M", "u", "rotation")}
    return {
        "kind": "rotation" if is_rotation else "translation", "arm_m": 0.0, "role": "calibration", "status": "complete",
        "heave": "free", "end": "reached", "end_reason": "", "end_H_N": last["H"], "end_M_Nm": last["M"],
        "end_u_m": last["u"], "end_rotation_rad": last["rotation"],
    }  # fmt: skip


def _root(atlas: Atlas, scene: Scene, estimate: Estimate, V: float) -> xr.Dataset:
    dofs = list(variables.DOFS)
    root = xr.Dataset(
        {"stiffness_initial": (("dof", "dof_conjugate"), estimate.stiffness)}, {"dof": dofs, "dof_conjugate": dofs}
    )
    root = variables.attach(root, "springs_root")
    caisson = scene.caisson
    errors = np.hypot(estimate.stiffness_error, STIFFNESS_LEFT / _BAND)
    root.attrs = {
        "Conventions": "CF-1.11", "title": scene.title, "source": atlas.source,
        "pysprings_version": __version__, "scene_sha256": scene.sha256, "scene_toml": scene.to_toml(),
        "mesh_preset": atlas.base.mesh.preset, "status": "complete", "schema": SCHEMA,
        "drainage": scene.layer_drainage, "outer_diameter_m": caisson.outer_diameter,
        "skirt_length_m": caisson.skirt_length, "skirt_thickness_m": caisson.skirt_thickness, "vertical_load_N": V,
        "caisson_behaviour": "rigid", "limit_displacement_over_diameter": scene.limit.displacement_over_diameter,
        "limit_rotation_rad": scene.limit.rotation, "atlas": "; ".join(f"{k}: {v}" for k, v in atlas.about.items()),
        "atlas_outside": "; ".join(estimate.outside), "atlas_mesh": mesh_words(atlas),
        "remarks": "; ".join([*implausible(scene), *(atlas.family.under_load if V > 0.0 else ())]),
        "atlas_cases": len(atlas.inputs), "K_V_relative_deviation": float(errors[0]),
        "K_H_relative_deviation": float(errors[1]), "K_M_relative_deviation": float(errors[2]),
    }  # fmt: skip
    return root


def _left(rest: Array, L: float) -> Array:
    """Return two modes (2, ray, row, knot) of what the components leave: of H, at the lid, and of M."""
    out = np.zeros((2, rest.shape[1], len(ROWS), rest.shape[-1] + 1))
    out[0, :, ROWS.index("H_lid"), 1:] = rest[0]
    out[1, :, ROWS.index("M_lid"), 1:] = L * rest[1]
    return out


def _action(L: float) -> Array:
    """Return the share (row, 2) of every row in (H, M/L)."""
    middle = (np.arange(_N) + 0.5) / _N
    pairs = {f"p{k}": (1.0, -float(middle[k])) for k in range(_N)}
    pairs |= {"H_tip": (1.0, -1.0), "H_lid": (1.0, 0.0)} | {name: (0.0, 1.0 / L) for name in MOMENTS}
    return np.array([pairs.get(name, (0.0, 0.0)) for name in ROWS])


def _spread(names: list[str], modes: Array, rho: Array, turn: Array, L: float) -> xr.Dataset:
    """Return modes of one standard deviation of H and M along the rays."""
    loads = np.einsum("mrkn,kl->lmrn", modes, _action(L)) * np.array([1.0, L])[:, None, None, None]
    data: dict[str, Any] = {
        f"{name}_mode": (("mode", "ray", "knot"), values, {"units": unit, "long_name": f"mode of {name}"})
        for name, unit, values in zip(("H", "M"), ("N", "N m"), loads, strict=True)
    }
    data["rho"] = ("knot", rho, {"units": "m", "long_name": "size of the motion"})
    data["turn"] = ("knot", turn, {"units": "1", "long_name": "deviation of the rotation of a pull over the rotation"})
    return xr.Dataset(data, {"ray": names})
