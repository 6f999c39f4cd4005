# SPDX-License-Identifier: MIT
"""Fans of rays whose p and m follow a law in closed form, coupled or linear."""

import numpy as np
import xarray as xr
from scipy.optimize import brentq

from pysprings.core import variables
from tests.support.synthetic import Caisson, Path, make_springs

LENGTH, RINGS = 4.0, 9
DEPTH = np.linspace(0.0, LENGTH, RINGS)
HEIGHT = np.diff(np.concatenate([[0.0], 0.5 * (DEPTH[1:] + DEPTH[:-1]), [LENGTH]]))
ANGLES = (0.0, 20.0, 30.0, 40.0, 50.0, 60.0, -45.0, 90.0)  # degrees of (u, rotation*L)
RHO = 8e-3 * np.linspace(0.0, 1.0, 25) ** 1.5
# Symmetric stiffness (p to y and m to rotation coupled) at each depth: p = A y + C rotation, m = C y + B rotation.
A, B, C = 3e8, 2e9, -1.5e8
STIFFNESS_V = 3.5e9


def linear(z, y, rotation):
    return A * y + C * rotation, C * y + B * rotation


def potential(z, y, rotation):
    """Return p, m of potential W = k e^2 (1 + z/L) sqrt(1 + q/e^2), q = quadratic form of (y, rotation): coupled."""
    e = 2e-3
    stress = np.array(linear(z, y, rotation))
    q = (stress[0] * y + stress[1] * rotation) / A
    return stress / np.sqrt(1.0 + q / e**2) * (1.0 + z / LENGTH)


def loads(law, u, rotation):
    p, m = law(DEPTH, u - rotation * DEPTH, rotation)
    return np.array([HEIGHT @ p, HEIGHT @ (m - p * DEPTH)])


def fan_springs(law, angles=ANGLES, rho=RHO, held_back=()) -> xr.DataTree:
    """Return the springs of rays (and held-back pulls at the arms given) of a caisson whose p and m follow a law."""
    names = {f"ray_{k}": a for k, a in enumerate(angles)}
    paths = [Path(name, "translation", steps=rho.size - 1) for name in names]
    paths += [Path(f"pull_{arm:g}", arm=arm, role="held-back", steps=rho.size - 1) for arm in held_back]
    tree = make_springs(tuple(paths), Caisson(rings=RINGS, sectors=4))
    for path in paths:
        if path.kind == "translation":
            angle = np.radians(names[path.name])
            states = np.stack([rho * np.cos(angle), rho * np.sin(angle) / LENGTH])
        else:
            states = pull_states(law, path.arm, 0.5 * rho)
        set_path(tree, path.name, law, *states)
    h = 1e-9
    k = np.zeros((3, 3))
    k[np.ix_([0, 2], [0, 2])] = np.stack([loads(law, h, 0.0), loads(law, 0.0, h)], axis=1) / h
    k[1, 1] = STIFFNESS_V
    tree["stiffness_initial"].values = k
    return tree


def pull_states(law, arm, u):
    def unbalance(rotation, x):
        force, moment = loads(law, x, rotation)
        return moment - arm * force

    return u, np.array([brentq(unbalance, -x, 2.0 * x, args=(x,), xtol=1e-18) if x else 0.0 for x in u])


def set_path(tree, name, law, u, rotation):
    """Give a path of a tree the states (n,) = (u, rotation) and the reactions of a law."""
    data = tree[f"paths/{name}"].to_dataset(inherit=False).copy(deep=True)
    y = u - rotation * DEPTH[:, None]
    p, m = law(DEPTH[:, None], y, rotation + 0.0 * y)
    edges = np.concatenate([[0.0], np.cumsum(HEIGHT)])
    zero = np.zeros_like(u)
    parts, moment, shear = (np.zeros(data[key].shape) for key in ("p_component", "m", "t"))
    parts[:, 0, 0, :], moment[:, 0, :], shear[:, 0, :] = p, m, 1e5
    force, couple = HEIGHT @ p, HEIGHT @ m - (HEIGHT * DEPTH) @ p
    new = {key: ("step", zero) for key in ("H_tip", "M_tip", "H_lid", "M_lid", "V_lid")}
    new |= {"p": (("depth", "step"), p), "p_component": (data["p_component"].dims, parts)}
    new |= {"m": (data["m"].dims, moment), "t": (data["t"].dims, shear)}
    new |= {"u": ("step", u), "rotation": ("step", rotation), "y": (("depth", "step"), y)}
    new |= {"H": ("step", force), "M": ("step", couple), "V_tip": ("step", data["V"].values - 1e5 * LENGTH)}
    new |= {"w": ("step", -0.2 * np.hypot(u, LENGTH * rotation))}
    data = data.drop_vars("depth_bounds").assign_coords(depth=DEPTH).assign(new)
    data["depth_bounds"] = (("depth", "bound"), np.stack([edges[:-1], edges[1:]], axis=1))
    tree[f"paths/{name}"].dataset = variables.attach(data, "springs_path")


def scattered(n=200, size=7e-3, seed=3):
    """Return the states (n, 2) = (u, rotation) all over the plane."""
    random = np.random.default_rng(seed)
    rho, phi = size * random.random(n), 2 * np.pi * random.random(n)
    return np.stack([rho * np.cos(phi), rho * np.sin(phi) / LENGTH], axis=1)
