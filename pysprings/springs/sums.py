# SPDX-License-Identifier: MIT
"""Sums of the reactions of a path: over sides, components and depth, and beside its loads; curves that keep them."""

from collections.abc import Iterator

import numpy as np
import xarray as xr

from pysprings.core.arrays import Array

# Reactions sum to the load within this share of the largest of them. Files of a run: 1e-15; single precision: 1e-7.
BALANCED = 1e-6


def action(name: str, depth: float, height: float, length: float) -> tuple[float, float]:
    """Return the share of H and M [m] that a unit of a lateral reaction adds, as in `resultants`.

    p [N/m] and m [N m/m] act over a slice of a height [m] at a depth [m]; tip and lid as a whole, the tip at the skirt
    length [m].
    """
    return {
        "p": (height, -depth * height),
        "m": (0.0, height),
        "H_tip": (1.0, -length),
        "M_tip": (0.0, 1.0),
        "H_lid": (1.0, 0.0),
        "M_lid": (0.0, 1.0),
    }[name]


def displacement_at(path: xr.Dataset, depth: float) -> np.ndarray:
    """Return y [m] (step,) of lid (depth 0) or tip: u - rotation*depth, and at the tip what the steel has bent.

    That of the last two slices goes on to the tip.
    """
    u, rotation, z = (path[name].values for name in ("u", "rotation", "depth"))
    rigid = u - rotation * depth
    if depth == 0.0 or z.size < 2:
        return rigid
    y = path["y"].transpose("depth", "step").values[-2:]
    bent = y - (u - rotation * z[-2:, None])
    if np.abs(bent).max(initial=0.0) <= BALANCED * np.abs(y).max(initial=0.0):
        return rigid
    return rigid + bent[1] + (bent[1] - bent[0]) * (depth - z[-1]) / (z[-1] - z[-2])


def with_moment(p: np.ndarray, moment: np.ndarray, depth: np.ndarray, heights: np.ndarray) -> np.ndarray:
    """Return p (depth, ..., step) [N/m] whose moment about the lid is ``moment`` (..., step) [N m]; its force stays.

    What is added is a share of p that is linear in depth [m], over slices of these heights [m]: a soft layer keeps its
    p beside a stiff one.
    """
    shape = (-1, *[1] * (p.ndim - 1))
    z, weight = depth.reshape(shape), np.abs(p) * heights.reshape(shape)
    middle = (weight * z).sum(axis=0) / _not_zero(weight.sum(axis=0))
    missing = moment - np.tensordot(depth * heights, p, axes=1)
    spread = (weight * z * (z - middle)).sum(axis=0)
    return p + np.abs(p) * (z - middle) * (missing / _not_zero(spread))


def _not_zero(values: np.ndarray) -> np.ndarray:
    return np.where(values == 0.0, 1.0, values)


def slice_heights(dataset: xr.Dataset) -> np.ndarray:
    """Return the height of the slice of each depth [m], the weights of an integral over depth."""
    bounds = dataset.variables["depth_bounds"].values
    return bounds[:, 1] - bounds[:, 0]


def by_depth(dataset: xr.Dataset, name: str) -> np.ndarray:
    """Return a reaction per depth, both sides together, (depth, step): "p", "t" [N/m], "m" [N m/m]."""
    variable = dataset.variables[name]
    others = tuple(k for k, dim in enumerate(variable.dims) if dim not in ("depth", "step"))
    left = [dim for dim in variable.dims if dim in ("depth", "step")]
    values: np.ndarray = np.nansum(variable.values, axis=others) if others else variable.values
    return values if left == ["depth", "step"] else values.T


def resultants(dataset: xr.Dataset) -> dict[str, np.ndarray]:
    """Return H, V [N] and M [N m] by step that the reactions sum to.

    H = sum p dz + H_tip + H_lid;  V = sum t dz + V_tip + V_lid;
    M = -(sum p z dz + L H_tip) + sum m dz + M_tip + M_lid.
    """
    return {name: np.sum(terms, axis=0) for name, terms in _terms(dataset).items()}


def balance(dataset: xr.Dataset) -> dict[str, float]:
    """Return what is missing between summed reactions and loads H, V, M, relative to their largest part.

    A load that symmetry makes zero (H and M on a vertical path) counts beside a thousandth of the largest force.
    Zero where the springs hold all reactions of the caisson (`resultants`).
    """
    sums = _sums(dataset)
    return {
        name: float(np.abs(total - dataset.variables[name].values).max()) / size if size else 0.0
        for name, (total, size) in sums.items()
    }


def _terms(dataset: xr.Dataset) -> dict[str, tuple[np.ndarray, ...]]:
    """Return the terms by step of H, V [N] and M [N m]."""
    dz, z = slice_heights(dataset), dataset.variables["depth"].values
    p, m, t = by_depth(dataset, "p"), by_depth(dataset, "m"), by_depth(dataset, "t")
    value = {name: dataset.variables[name].values for name in ("H_tip", "H_lid", "V_tip", "V_lid", "M_tip", "M_lid")}
    length = float(dataset.variables["depth_bounds"].values[-1, 1])
    return {
        "H": (dz @ p, value["H_tip"], value["H_lid"]),
        "V": (dz @ t, value["V_tip"], value["V_lid"]),
        "M": (-(dz * z) @ p, dz @ m, -length * value["H_tip"], value["M_tip"], value["M_lid"]),
    }


def _sums(dataset: xr.Dataset) -> dict[str, tuple[np.ndarray, float]]:
    """Return sums of the reactions by step for H, V [N] and M [N m], each with the reference size of its error."""
    terms, length = _terms(dataset), float(dataset.variables["depth_bounds"].values[-1, 1])
    least = 1.0e-3 * max(_largest(terms["H"]), _largest(terms["V"]))
    least_of = {"H": least, "V": least, "M": least * length}
    return {name: (np.sum(each, axis=0), max(_largest(each), least_of[name])) for name, each in terms.items()}


def balance_faults(dataset: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Yield (load, message) for loads that the reactions do not sum to, with the worst step."""
    good = np.flatnonzero(dataset.variables["converged"].values == 1)
    path = dataset.isel(step=good)
    for name, (total, size) in _sums(path).items():
        load = path.variables[name].values
        worst = int(np.argmax(np.abs(total - load)))
        if abs(total[worst] - load[worst]) > BALANCED * size:
            units = "N m" if name == "M" else "N"
            yield (
                name,
                f"step {good[worst]}: the reactions sum to {total[worst]:.6g} {units}, the load is {load[worst]:.6g} "
                f"{units} (they may differ by {BALANCED:g} of the largest reaction of the path)",
            )


def _largest(terms: tuple[np.ndarray, ...]) -> float:
    return max(float(np.abs(term).max()) for term in terms)


def secant_slopes(rho: Array, r: Array, initial: Array) -> Array:
    """Return slopes dr/drho (rows, k) at the knots rho (k,), 0 first, from the secants S = (r - r(0))/rho.

    S(0) = initial (rows,). dS/ds is that of a parabola through three neighbours in s = ln(1 + rho/rho_1), as steps
    grow from the first one on. Exact for a linear response; linear in r and initial, unlike
    `pysprings.macro.curve_table.pchip_slopes`: slopes of a sum are the sum of the slopes.
    """
    secant = np.concatenate([initial[:, None], (r[:, 1:] - r[:, :1]) / rho[1:]], axis=1)
    h = np.diff(np.log1p(rho / rho[1]))
    rise = np.diff(secant, axis=1) / h
    bend = np.empty_like(r)
    if h.size == 1:
        bend[:] = rise
    else:
        share = h[1:] / (h[1:] + h[:-1])
        bend[:, 1:-1] = share * rise[:, :-1] + (1.0 - share) * rise[:, 1:]
        bend[:, 0], bend[:, -1] = 2.0 * rise[:, 0] - bend[:, 1], 2.0 * rise[:, -1] - bend[:, -2]
    return secant + bend * rho / (rho + rho[1])
