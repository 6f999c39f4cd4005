# SPDX-License-Identifier: MIT
"""Scene -> model in the scene's discretisation."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pysprings.model.build import Built, build_model
from pysprings.model.fourier import BuiltFourier, build_fourier

if TYPE_CHECKING:
    from pysprings.scene.load import Scene


def build(scene: Scene) -> Built | BuiltFourier:
    """Build the model of a scene in its discretisation. Raises FEError."""
    return build_fourier(scene) if scene.discretisation == "fourier" else build_model(scene)
