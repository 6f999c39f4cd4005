# SPDX-License-Identifier: MIT
"""The engine's laws of a scene's layers, and their parameters at the points of a mesh; see `pysprings.scene.soils`."""

from types import SimpleNamespace

import numpy as np

from fe_engine.material import Material
from fe_engine.soil.law import SoilLaw
from pysprings.scene.ground import Stratum
from pysprings.scene.model import Scene
from pysprings.scene.soils import SOIL_LAWS


def engine_laws(scene: Scene) -> list[SoilLaw]:
    """Return the engine's laws of a scene's layers."""
    return [SOIL_LAWS[each.law].engine(each) for each in scene.ground.strata]


def soil_materials(scene: Scene, depth: np.ndarray) -> tuple[list[Material], np.ndarray]:
    """Return the materials of the layers, and the number of each element's, for depths (ne, np) in m of its points.

    Values are constant in a layer, or those of each point where one of them varies with depth.
    """
    number = scene.ground.number(depth.mean(axis=1))
    materials = [material_at(stratum, depth[number == k]) for k, stratum in enumerate(scene.ground.strata)]
    return materials, np.asarray(number, dtype=np.int64)


def material_at(stratum: Stratum, depth: np.ndarray) -> Material:
    """Return the material of a layer for depths (k, np) in m of its points."""
    law = SOIL_LAWS[stratum.law]
    # what is mobilised follows the stress
    varies = stratum.varies or law.by_stress or "strain_at_half_strength" in stratum.values
    at = depth if varies else np.array(0.5 * (stratum.top + stratum.bottom))
    values = {name: stratum.value(name, at) for name in (*stratum.values, "young_modulus")}
    values |= {
        "vertical_effective_stress": stratum.vertical_stress(at),
        "mean_effective_stress": stratum.mean_stress(at),
    }
    rows = law.pack(stratum, SimpleNamespace(**values))
    return Material(law.engine(stratum), rows)
