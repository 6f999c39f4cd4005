# SPDX-License-Identifier: MIT
"""Springs as compact HTML for notebooks: caisson, stiffness, paths, range, and load over displacement."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from pysprings.core.arrays import Array
from pysprings.core.card import caisson_drawing, card, curves_drawing
from pysprings.core.text import with_prefix
from pysprings.core.words import sudden

if TYPE_CHECKING:
    from pysprings.springs.path import SpringPath
    from pysprings.springs.springs import Springs


def springs_card(springs: Springs, title: str = "Springs", more: Mapping[str, str] | None = None) -> str:
    """Return springs, or the paths of a result in this form, as HTML of a few kB; `more` are further lines."""
    paths, diameter = list(springs.paths.values()), springs.attrs.get("outer_diameter_m", math.nan)
    name = str(springs.attrs.get("title", ""))
    known = f"D {diameter:g} m, " if math.isfinite(diameter) else ""
    lines = {
        "caisson": f"{known}L {springs.length:g} m; {springs.drainage}",
        "initial stiffness": stiffness_text(springs),
        "paths": paths_text(paths),
        "range": range_text(paths),
    }
    drawings = [caisson_drawing(diameter, springs.length)] if math.isfinite(diameter) else []
    return card(f"{title}: {name}" if name else title, lines | dict(more or {}), [*drawings, loads_drawing(paths)])


def stiffness_text(springs: Springs) -> str:
    """Return the initial stiffness at the lid centre; blank where none is held."""
    if "stiffness_initial" not in springs.root:
        return ""
    k = springs.lateral_stiffness if springs.stiffness is None else springs.stiffness
    return stiffness_words(k) + sudden(springs.drainage)


def stiffness_words(k: Array) -> str:
    """Return a stiffness at the lid centre, (3, 3) of u, w, rotation or (2, 2) of u, rotation [N/m, N/rad, N m/rad]."""
    vertical = f"K_V {with_prefix(k[1, 1], 'N/m')}, " if len(k) > 2 else ""
    return (
        f"K_H {with_prefix(k[0, 0], 'N/m')}, {vertical}K_M {with_prefix(k[-1, -1], 'N m/rad')}, "
        f"K_HM {with_prefix(k[0, -1], 'N/rad')} at the lid centre"
    )


def paths_text(paths: Iterable[SpringPath]) -> str:
    """Return the number of paths by role and kind."""
    counts = Counter((path.role, path.kind) for path in paths)
    return ", ".join(f"{number} {kind} ({role})" for (role, kind), number in counts.items())


def range_text(paths: Iterable[SpringPath]) -> str:
    """Return the largest motions and loads of the lateral calibration paths."""
    used = [path for path in paths if path.calibrates and not path.is_vertical]
    if not used:
        return ""
    u, turn, H, M = (
        max((float(np.abs(path.dataset[name]).max()) for path in used if name in path.dataset), default=math.nan)
        for name in ("u", "rotation", "H", "M")
    )
    return (
        f"u up to {1e3 * u:.3g} mm, rotation up to {math.degrees(turn):.3g} deg; "
        f"H up to {1e-6 * H:.3g} MN, M up to {1e-6 * M:.3g} MN m"
    )


def loads_drawing(paths: Iterable[SpringPath]) -> str:
    """Return H over u of the lateral paths as SVG; blank where none moves sideways."""
    curves = [
        list(zip((1e3 * path.u).tolist(), (1e-6 * path["H"]).tolist(), strict=True))
        for path in paths
        if not path.is_vertical and np.ptp(path.u) > 0.0
    ]
    return curves_drawing(curves, "u [mm]", "H [MN]")
