# SPDX-License-Identifier: MIT
"""Soil laws as a scene names them, one class each. A new law is a file here and a line in `SOIL_LAWS`."""

from collections.abc import Mapping

from pysprings.scene.fields import Field
from pysprings.scene.soils.clay import IwanClay, Tresca, VonMises
from pysprings.scene.soils.friction import DruckerPrager, Elastic, IwanSand, VanEekelen
from pysprings.scene.soils.law import SoilLaw
from pysprings.scene.soils.sand import Sand

SOIL_LAWS: dict[str, SoilLaw] = {
    law.name: law
    for law in (DruckerPrager(), VanEekelen(), Elastic(), Tresca(), VonMises(), IwanClay(), IwanSand(), Sand())
}  # fmt: skip
LAW_KEYS: Mapping[str, Field] = {name: key for law in SOIL_LAWS.values() for name, key in law.keys.items()}
STIFFNESSES = tuple(dict.fromkeys(name for law in SOIL_LAWS.values() for name in law.stiffnesses))


def owners(key: str) -> str:
    """Return the laws that use a key, as a scene names them."""
    return ", ".join(f'"{law.name}"' for law in SOIL_LAWS.values() if key in law.keys)
