# SPDX-License-Identifier: MIT
"""A caisson on Winkler springs that remember, solved on its own: p by the y of each depth, m by the rotation.

Each spring is a Masing model (Iwan 1967): perfectly plastic elements in parallel, here with forces f_k = K_k clipped
to +-K_k d_k, so that unloading follows twice the backbone. It has nothing to do with the elements of the springs.
"""

from dataclasses import replace

import numpy as np
import xarray as xr

from pysprings.core.path_kinds import PARTS
from pysprings.macro.fan import FanTable, build_fan
from pysprings.memory.build import memory_dataset
from pysprings.memory.calibration import ElementSet
from pysprings.memory.elements import FRICTIONAL, GAP, PLASTIC, REVERSIBLE
from pysprings.memory.model import MemorySprings
from pysprings.memory.shares import Shares
from pysprings.springs.springs import Springs
from tests.support.fans import LENGTH, RHO, RINGS, fan_springs, set_path
from tests.support.synthetic import Caisson, Path, make_springs

SIZES = np.array([2e-4, 8e-4, 3e-3, 1.2e-2])  # motions at yield [m]
SHARES = np.array([0.4, 0.3, 0.2, 0.1])
P_STIFFNESS, M_STIFFNESS = 3e8, 2e9
REACH = 0.02


def masing(x: np.ndarray) -> np.ndarray:
    """Return the force (..., n) of a spring of stiffness 1 along motions x (..., n) from rest."""
    out, elastic = np.zeros_like(x), np.zeros((SIZES.size, *x.shape[:-1]))
    before = np.zeros(x.shape[:-1])
    limits = SIZES.reshape(-1, *[1] * before.ndim)
    for k in range(x.shape[-1]):
        elastic = np.clip(elastic + x[..., k] - before, -limits, limits)
        before = x[..., k]
        out[..., k] = np.tensordot(SHARES, elastic, axes=1)
    return out


def law(z, y, rotation):
    """Return p [N/m] and m [N m/m] along motions (the last axis, or a single small state)."""
    if np.ndim(rotation) == 0:
        return P_STIFFNESS * y, M_STIFFNESS * rotation + 0.0 * y
    return P_STIFFNESS * masing(y), M_STIFFNESS * masing(LENGTH * rotation) / LENGTH


def springs(turning=(0.0, 50.0), loops=()) -> xr.DataTree:
    """Return a fan with rays that turn back at these angles [deg], and held-back loops of (angle, rho [m])."""
    tree = fan_springs(law)
    paths = [(f"turning_{angle:g}", angle, 0.4 * RHO[-1], "memory") for angle in turning]
    paths += [(f"loop_{angle:g}", angle, rho, "held-back") for angle, rho in loops]
    steps = np.concatenate([np.linspace(a, b, 30)[1:] for a, b in ((0, 1), (1, -1), (-1, 1))])
    for name, angle, rho, role in paths:
        name = name.replace("-", "minus_").replace(".", "_")
        states = rho * np.concatenate([[0.0], steps])
        other = make_springs((Path(name, "translation", role=role, steps=steps.size),), Caisson(rings=RINGS, sectors=4))
        tree[f"paths/{name}"] = xr.DataTree(other[f"paths/{name}"].to_dataset(inherit=False))
        turn = np.radians(angle)
        set_path(tree, name, law, states * np.cos(turn), states * np.sin(turn) / LENGTH)
        tree[f"paths/{name}"].attrs |= {PARTS: 2, "role": role}
    return tree


def element(kind=PLASTIC, gauge=(1.0, 0.0, 1.0), B=(1e8, 0.0, 1e8), d=1e-3, gain=0.0, over=1.0):
    return [kind, *gauge, *B, d, gain, over]


def mixed(n=24, seed=1):
    """Elements of all kinds: slender gauges, forces that are not along them, hardening, gaps, friction, one elastic."""
    random = np.random.default_rng(seed)
    rows = [element(d=1e3, B=(2e7, 0.5e7, 3e7))]
    for _ in range(n):
        c, s = np.cos(random.uniform(0, np.pi)), np.sin(random.uniform(0, np.pi))
        a, m = random.uniform(0.1, 0.5) ** 2, random.normal(size=2)
        d, gain = REACH * 10 ** random.uniform(-3, -0.5), random.choice([0.0, 2.0, 10.0])
        norm, pressed = c * c + s * s, random.choice([0.0, 0.5, 1.0])
        gauge = (c * c + a * s * s) / norm, (1 - a) * c * s / norm, (s * s + a * c * c) / norm
        rows.append(
            element(PLASTIC, gauge, (1e7 * m[0] ** 2, 1e7 * m[0] * m[1], 1e7 * m[1] ** 2), d, gain, 0.2 * REACH)
        )
        rows.append(element(GAP, (pressed * d, 0.0, 0.0), (np.cos(d * 1e4), np.sin(d * 1e4), 1e7), d))
        rows.append(element(REVERSIBLE, gauge, 5e6 * np.array(gauge), d))
        rows.append(element(FRICTIONAL, (*m / np.hypot(*m), 0.6), (np.cos(d * 1e4), np.sin(d * 1e4), 5e6), d))
    return np.array(rows)


def elements_of(rows: np.ndarray, table: FanTable) -> ElementSet:
    """Return a set of elements that share out nothing but their loads."""
    odd = ~table.even
    none = Shares(
        odd, np.where(odd, 0.0, table.r[:, 0, 0]), np.zeros((odd.sum(), 2)), np.zeros((odd.sum(), 2 * len(rows))),
        np.zeros(((~odd).sum(), 2 * len(rows))), np.inf,
    )  # fmt: skip
    return ElementSet(rows, REACH, none, 0.0, {"0 degrees": (0.0, 0.0)}, 5 * REACH)


def remembering(elements: ElementSet, table: FanTable, rate: float | None = None) -> MemorySprings:
    """Return the response of elements on a fan of the caisson."""
    return MemorySprings(table, Springs.of(springs()).path(), elements=elements, rate=rate)


def with_invented_memory(rows: np.ndarray | None = None, settling: bool = False) -> xr.DataTree:
    """Return springs that hold elements which were not calibrated: quick to make. Settling ones change w and V."""
    tree = springs()
    given = Springs.of(tree)
    table = build_fan(given)
    elements = elements_of(mixed() if rows is None else rows, table)
    if settling:
        shares = elements.shares
        even = np.random.default_rng(7).uniform(-1.0, 1.0, shares.even.shape)
        elements = replace(elements, shares=replace(shares, even=even, growth=10.0))
    stored = memory_dataset(given, elements)
    groups = {node.path: node.to_dataset(inherit=False) for node in tree.subtree}
    return xr.DataTree.from_dict(groups | {"/memory": stored}, name=tree.name)


def at_two_rates(turning: tuple[float, ...]) -> Springs:
    """Springs of coupled rays at 1e-5 and 1e-3 m/s, with rays that turn back at these rates."""
    tree, groups = springs(), {}
    for node in tree["paths"].children.values():
        for number, speed in enumerate((1e-5, 1e-3) if node.attrs["role"] == "calibration" else turning):
            path = node.to_dataset(inherit=False).copy(deep=True)
            steps = np.hypot(np.diff(path["u"]), np.diff(path["rotation"]) * LENGTH)
            path["time"] = ("step", np.append(0.0, np.cumsum(steps)) / speed, {"long_name": "time", "units": "s"})
            groups[f"/paths/{node.name}_{number}"] = path
    root = tree.to_dataset(inherit=False)
    return Springs.of(xr.DataTree.from_dict({"/": root.assign_attrs(drainage="coupled")} | groups))
