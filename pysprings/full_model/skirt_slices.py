# SPDX-License-Identifier: MIT
"""Slices of the skirt: which part of the force of each ring of nodes a slice has, and where it stands.

    bricks    a slice for each ring, half way to its neighbours; one above and one below a ring on a boundary of layers
    series    a slice for each element of the skirt's faces

A ring on the edge of two slices shares its force between them by their heights; that of the water goes to those alone
whose layer holds water. No slice reaches over a boundary.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True)
class SkirtSlices:
    """Slices from mudline to tip.

    Attributes
    ----------
    rings : (nz,) depths of the rings of nodes, m.
    bounds : (nd, 2) top and bottom of each slice, m.
    depth : (nd,) where the forces of a slice are said to act, m.
    shares : (nd, nz) part of the force of each ring in each slice; the parts of a ring sum to 1.
    """

    rings: np.ndarray
    bounds: np.ndarray
    depth: np.ndarray
    shares: np.ndarray

    @property
    def height(self) -> np.ndarray:
        """Heights (nd,), m."""
        return np.asarray(self.bounds[:, 1] - self.bounds[:, 0])

    def forces(self, of_rings: np.ndarray) -> np.ndarray:
        """Return the forces of slices (nd,) from those of rings (nz,)."""
        return np.asarray(self.shares @ of_rings)

    def of_water(self, wet: np.ndarray) -> SkirtSlices:
        """Return the slices with the force of each ring in those alone that hold water, ``wet`` (nd,) bool."""
        shares = self.shares * wet[:, None]
        sums = shares.sum(axis=0)
        return replace(self, shares=np.where(sums > 0.0, shares / np.where(sums > 0.0, sums, 1.0), self.shares))

    def turning(self, lateral: np.ndarray) -> np.ndarray:
        """Return the moments (nd,) of the lateral forces of rings (nz,) about the depth of their slice."""
        arm = self.rings[None] - self.depth[:, None]
        return np.asarray((self.shares * arm) @ lateral)

    @property
    def main_ring(self) -> np.ndarray:
        """The ring (nd,) with the most force in each slice."""
        return np.asarray(self.shares.argmax(axis=1))

    def on_lines(self, values: np.ndarray) -> np.ndarray:
        """Return values (..., nd) at the depths of the slices, on straight lines between rings (..., nz)."""
        above = np.clip(np.searchsorted(self.rings, self.depth, side="right") - 1, 0, len(self.rings) - 2)
        low, high = self.rings[above], self.rings[above + 1]
        part = (self.depth - low) / (high - low)
        return np.asarray(values[..., above] * (1.0 - part) + values[..., above + 1] * part)


def slices_of_rings(rings: np.ndarray, boundary: np.ndarray) -> SkirtSlices:
    """Return the slices of bricks with rings at depths (nz,) m; ``boundary`` (nz,) bool marks those between layers.

    A slice acts at the depth of its ring, one of the two beside a boundary in its own middle.
    """
    middle = 0.5 * (rings[1:] + rings[:-1])
    tops, bottoms = np.concatenate([rings[:1], middle]), np.concatenate([middle, rings[-1:]])
    bounds, depth, shares = [], [], []
    for k, (z, top, bottom) in enumerate(zip(rings, tops, bottoms, strict=True)):
        cut = boundary[k] and 0 < k < len(rings) - 1
        for low, high in ((top, z), (z, bottom)) if cut else ((top, bottom),):
            bounds.append((low, high))
            depth.append(0.5 * (low + high) if cut else z)
            shares.append(np.zeros(len(rings)))
            shares[-1][k] = (high - low) / (bottom - top) if cut else 1.0
    return SkirtSlices(rings, np.array(bounds), np.array(depth), np.array(shares))


def slices_of_elements(line: np.ndarray) -> SkirtSlices:
    """Return the slices of a series with nodes at depths (nz,) m, three an element."""
    bounds = np.stack([line[:-2:2], line[2::2]], axis=1)
    shares = np.zeros((len(bounds), len(line)))
    for e, (top, bottom) in enumerate(bounds):
        shares[e, 2 * e : 2 * e + 3] = bottom - top
    return SkirtSlices(line, bounds, bounds.mean(axis=1), shares / shares.sum(axis=0))
