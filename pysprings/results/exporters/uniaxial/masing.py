# SPDX-License-Identifier: MIT
"""Springs that unload and reload by Masing's rule, beside paths of the full model that turn back."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pysprings.results.exporters.uniaxial.curve import Table
from pysprings.results.exporters.uniaxial.planes import cosines
from pysprings.results.exporters.uniaxial.sets import Uniaxial
from pysprings.springs.springs import Springs

Array = NDArray[np.float64]


def masing(q: Array, f: Array, x: Array) -> Array:
    """Return the reactions (n,) along displacements x (n,) that start at rest (Masing 1926; Iwan 1967).

    The curve through the points q >= 0, f is a sum of sliders in parallel, each elastic up to one of its points.
    """
    slope = np.diff(f) / np.diff(q)
    stiffness, limit = slope - np.append(slope[1:], 0.0), q[1:]
    spring, out = np.zeros(limit.size), np.empty(x.size)
    for i, move in enumerate(np.diff(x, prepend=0.0)):
        spring = np.clip(spring + move, -limit, limit)
        out[i] = stiffness @ spring
    return out


def errors_on_reversals(springs: Springs, made: Uniaxial, tables: list[Table]) -> list[str]:
    """Return a sentence for each lateral path that turns back: H and M of Masing's rule beside the full model."""
    lines = []
    for path in springs.paths.values():
        if path.is_vertical or not path.turns_back:
            continue
        u, rotation = path.u - path.u[0], path.rotation - path.rotation[0]
        found = loads(made, tables, u, rotation)
        parts = []
        for key, own in zip("HM", found, strict=True):
            exact = path[key] - path[key][0]
            parts.append(f"{key} by {100.0 * np.abs(own - exact).max() / max(np.abs(exact).max(), 1e-300):.0f} %")
        lines.append(
            f"Masing's rule on path {path.name} ({path.role}): off by {' and '.join(parts)} of the largest load"
        )
    return lines or ["the springs hold no path that turns back: the error of Masing's rule is not known for them"]


def loads(made: Uniaxial, tables: list[Table], u: Array, rotation: Array) -> tuple[Array, Array]:
    """Return H [N] and M [N m] (n,) along a motion in one of the planes, from rest, by Masing's rule."""
    H, M = np.zeros_like(u), np.zeros_like(u)
    for each in tables:
        if not each.spring.odd:
            continue
        q, f = each.q[each.q >= 0.0], each.f[each.q >= 0.0]
        lateral = each.spring.direction == "lateral"
        read = u - each.spring.depth * rotation if lateral else rotation
        force = sum(n * c * masing(q, f, c * read) for c, n in zip(*cosines(made.planes), strict=True))
        H += force if lateral else 0.0
        M += -force * each.spring.depth if lateral else force
    return H, M
