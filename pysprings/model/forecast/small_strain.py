# SPDX-License-Identifier: MIT
"""How far small strains and rotations reach: motions beyond it are computed, and named."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from pysprings.core.path_kinds import PATH_KINDS

if TYPE_CHECKING:
    from pysprings.scene.load import Path, Scene

# Geometry and contact faces stay where they were: a motion of this share of the skirt length, or a rotation of as many
# radians (which moves the tip as far), is beyond what that describes.
LARGEST_SHARE = 0.1
LARGEST_ROTATION = 0.1


def large_motion(path: str, displacement: float, rotation: float, length: float) -> str:
    """Return a sentence where a displacement (m) or rotation (rad) of a path is large beside the skirt; else ""."""
    parts = []
    if abs(displacement) > LARGEST_SHARE * length:
        share = abs(displacement) / length
        parts.append(f"a displacement of {abs(displacement):.3g} m, {share:.0%} of the skirt length")
    if abs(rotation) > LARGEST_ROTATION:
        parts.append(f"a rotation of {abs(rotation):.3g} rad")
    if not parts:
        return ""
    limit = f"limit {LARGEST_SHARE:.0%} of the skirt length, {LARGEST_ROTATION:g} rad"
    return f"path '{path}': {' and '.join(parts)} is beyond small strains ({limit}): the answer is a guess there"


def scene_warnings(scene: Scene) -> list[str]:
    """Return a sentence for each path of a scene that imposes a large motion."""
    texts = (large_motion(path.name, *imposed_motion(path), scene.caisson.skirt_length) for path in scene.load_paths)
    return [text for text in texts if text]


def imposed_motion(path: Path) -> tuple[float, float]:
    """Return the largest displacement (m) and rotation (rad) that a path imposes; 0 where it imposes a force."""
    kind = PATH_KINDS[path.kind]
    if kind.force:
        return 0.0, 0.0
    first = abs(getattr(path, kind.imposed) or 0.0)
    largest = max([first, *(abs(value) for value in _ends(path))])
    if kind.drives == "rotation":
        return 0.0, largest
    turn = max([abs(path.rotation or 0.0), *(abs(then.second) for then in path.then if then.second is not None)])
    return largest, turn * (largest / first if kind.straight and first else 1.0)


def _ends(path: Path) -> Iterator[float]:
    return (then.value for then in path.then if then.value is not None)
