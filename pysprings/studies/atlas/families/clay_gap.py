# SPDX-License-Identifier: MIT
"""Caissons in one layer of undrained clay whose skirt comes off the soil outside, where the tension would be.

As `clay`, with one more input: the gap opens where the total stress falls to the water pressure, so that
gamma' D/su, su at half the skirt length, decides. Inside, under the lid and at the tip the contact holds (suction).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pysprings.core.errors import Problem
from pysprings.studies.atlas.families import clay
from pysprings.studies.atlas.families.base import diameter, first_layer

if TYPE_CHECKING:
    from pysprings.scene.model import Scene

Array = NDArray[np.float64]
_WEIGHT = "effective_unit_weight"


def _read(scene: Scene) -> Array:
    weight = float(getattr(first_layer(scene), _WEIGHT)) * diameter(scene) / clay.strength_at_half(scene)
    return np.append(clay.read(scene), weight)


def _even(values: Array) -> Array:
    return np.concatenate([clay.even(values[..., :-1]), np.log(values[..., -1:])], axis=-1)


def _odd(scene: Scene, base: Scene) -> Iterator[Problem]:
    yield from clay.FAMILY.odd(scene, base)
    if not isinstance(getattr(first_layer(scene), _WEIGHT), float | int):
        yield Problem(key=f"soil.layer.{_WEIGHT}", message="the atlas needs one unit weight at all depths")


FAMILY = replace(
    clay.FAMILY,
    name="clay-gap",
    labels=(*clay.FAMILY.labels, "gamma' D/su"),
    read=_read,
    even=_even,
    short={**clay.FAMILY.short, "gamma": f"soil.layer.clay.{_WEIGHT}"},
    odd=_odd,
)
