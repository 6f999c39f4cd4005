# SPDX-License-Identifier: MIT
"""What a soil law of a scene declares: keys, checks, defaults, and the engine's law with its parameters."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from pysprings.scene.fields import Field
from pysprings.scene.positions import Clash

if TYPE_CHECKING:
    from fe_engine.soil.law import SoilLaw as EngineLaw
    from pysprings.scene.ground import Stratum

Soil = Any
"""Values of a soil in SI by the keys of a scene: numbers, or arrays of equal shape (..., ) where a law packs them."""


class SoilLaw(ABC):
    """A soil law of the scene; the engine is imported where it is asked for, since checks of a scene do without.

    name : its word in `law` and `soil.yield_surface`.
    keys : its own keys of [soil] and of layers, with unit and range; laws that share a key share its field.
    unused : keys that it accepts without using them.
    defaults : values of keys that are not given.
    needs : keys of the initial state and the strength that have no default.
    stiffnesses : keys of which one gives the stiffness, the usual one first.
    friction : key of the friction angle of K0 = "auto"; "" without one.
    cap : key of the strength to which an adhesion factor refers.
    yields : whether the soil can yield.
    total_stress : whether it is undrained clay in total stress, which has no pore pressure as unknown.
    changes_stiffness : whether its stiffness may follow the stress and degrade with strain.
    gives_stiffness : whether it has a stiffness where the scene gives none.
    by_stress : whether its parameters follow the initial stress, so that they differ from point to point.
    """

    name: ClassVar[str]
    keys: ClassVar[Mapping[str, Field]] = {}
    unused: ClassVar[Mapping[str, Field]] = {}
    defaults: ClassVar[Mapping[str, Any]] = {}
    needs: ClassVar[tuple[str, ...]] = ("effective_unit_weight",)
    stiffnesses: ClassVar[tuple[str, ...]] = ("young_modulus", "shear_modulus")
    friction: ClassVar[str] = ""
    cap: ClassVar[str] = "cohesion"
    yields: ClassVar[bool] = True
    total_stress: ClassVar[bool] = False
    changes_stiffness: ClassVar[bool] = False
    by_stress: ClassVar[bool] = False
    gives_stiffness: ClassVar[bool] = False

    def faults(self, soil: Soil, stresses: tuple[float, float]) -> Iterator[Clash]:
        """Give what does not go together in a soil that stands between two vertical effective stresses (Pa)."""
        return iter(())

    def least_friction(self, k0: float) -> float:
        """Return the least initial friction angle (rad) that holds the geostatic stress of K0 without cohesion."""
        return 0.0

    def shear_modulus(self, stratum: Stratum, depth: np.ndarray) -> np.ndarray:
        """Return G (...,) in Pa at depths (...,) of a layer that gives neither modulus."""
        raise KeyError("shear_modulus")

    def exponent(self, stratum: Stratum) -> float:
        """Return the exponent of the stress that the stiffness follows in a layer that gives neither modulus."""
        return 0.0

    def derived(self, stratum: Stratum, depth: np.ndarray) -> dict[str, float]:
        """Return values at a depth (m) of keys that follow from others in a layer that does not give them."""
        return {}

    def shown(self, stratum: Stratum, depth: np.ndarray) -> dict[str, float]:
        """Return what `pysprings check` shows of a layer at a depth (m) beside its values, by column."""
        return {}

    def word(self, stratum: Stratum) -> str:
        """Return the name of the engine's law of a layer."""
        return self.name

    def engine(self, stratum: Stratum) -> EngineLaw:
        """Return the engine's law of a layer."""
        return engine_law(self.word(stratum))

    @abstractmethod
    def pack(self, stratum: Stratum, soil: Soil) -> np.ndarray:
        """Return the packed parameters (n,) of the engine's law, or (..., n) where the values of the layer vary."""


def engine_law(name: str) -> EngineLaw:
    """Return the engine's law of a name."""
    from fe_engine.soil.laws import SOIL_LAWS

    return SOIL_LAWS[name]
