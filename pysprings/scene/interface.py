# SPDX-License-Identifier: MIT
"""Adhesion and opening of the interface by surface and depth, and what they need of the ground."""

from collections.abc import Iterator

import numpy as np

from pysprings.scene.by_depth import SURFACES, of_surface
from pysprings.scene.ground import Ground, Stratum
from pysprings.scene.layers import laws_of
from pysprings.scene.positions import Clash
from pysprings.scene.scene_sections import SceneSections
from pysprings.scene.sections import Interface
from pysprings.scene.soils import SOIL_LAWS

API = "api"
_EXPONENTS = (-0.5, -0.25)  # of su/s'_v0 up to 1 and beyond


def api_factor(strength: np.ndarray, vertical_stress: np.ndarray) -> np.ndarray:
    """Return alpha (...,) of API RP 2GEO (2011), section 8.1.3, from su and s'_v0 (...,), both in Pa.

    0.5 psi^-0.5 for psi = su/s'_v0 up to 1, 0.5 psi^-0.25 beyond, at most 1; without stress it is 0.
    """
    strength, vertical_stress = np.broadcast_arrays(strength, vertical_stress)
    with np.errstate(divide="ignore", invalid="ignore"):
        psi = np.where(strength > 0.0, strength / vertical_stress, 0.0)
        alpha = 0.5 * np.where(psi <= 1.0, psi ** _EXPONENTS[0], psi ** _EXPONENTS[1])
    return np.minimum(alpha, 1.0)


def adhesion_factor(interface: Interface, stratum: Stratum, surface: str, depth: np.ndarray) -> np.ndarray:
    """Return alpha (...,) on a surface at depths (...,) of a layer; API's formula is for undrained clay alone."""
    given = of_surface(interface.adhesion_factor, surface)
    if given == API:
        return api_factor(stratum.strength(depth), stratum.vertical_stress(depth)) * float(stratum.total_stress)
    return np.full(np.shape(depth), 0.0 if given is None else float(given))


def uses_adhesion(scene: SceneSections) -> bool:
    """Return whether the contact has more than friction and free opening: adhesion, tension, or clay beside it."""
    interface, ground = scene.interface, scene.ground
    opens = all(of_surface(interface.opening, each) == "vented" for each in SURFACES)
    return interface.adhesion_factor is not None or not opens or any(each.total_stress for each in ground.strata)


def holds_suction(scene: SceneSections) -> bool:
    """Return whether water below the sea holds a surface against the ground: a sealed one beside undrained clay."""
    return _sealed(scene) and any(
        each.total_stress for each in scene.ground.strata if each.top <= scene.caisson.skirt_length
    )


def without_suction(scene: SceneSections) -> list[str]:
    """Return a sentence where a sealed surface holds no suction, since all soil beside the caisson is drained."""
    beside = [each for each in scene.ground.strata if each.top <= scene.caisson.skirt_length]
    drained = all(each.drainage_in(scene.drainage.mode) == "drained" for each in beside)
    words = "interface.opening: sealed is vented here, since drained soil holds no suction"
    return [words] if _sealed(scene) and drained else []


def _sealed(scene: SceneSections) -> bool:
    return any(of_surface(scene.interface.opening, each) == "sealed" for each in SURFACES)


def interface_clashes(scene: SceneSections) -> Iterator[Clash]:
    """Check what adhesion and opening need of the ground beside the caisson."""
    interface, ground = scene.interface, scene.ground
    beside = [each for each in ground.strata if each.top <= scene.caisson.skirt_length]
    clay = any(each.total_stress for each in beside)
    key = ("interface", "adhesion_factor")
    if interface.adhesion_factor is None:
        if clay:
            text = 'missing; undrained clay beside the caisson needs it: a number such as 0.65, "api", or a table'
            yield Clash((key, ("interface", "friction_coefficient")), text)
        return
    yield from _adhesion(scene, ground, beside)


def _adhesion(scene: SceneSections, ground: Ground, beside: list[Stratum]) -> Iterator[Clash]:
    """Check that adhesion factors have something to refer to."""
    key, tip = ("interface", "adhesion_factor"), np.array(scene.caisson.skirt_length)
    given = [of_surface(scene.interface.adhesion_factor, each) for each in SURFACES]
    clay = any(each.total_stress for each in beside)
    if not clay and (API in given or not any(each.values.get("cohesion", 0.0) != 0.0 for each in beside)):
        yield Clash((key,), "refers to undrained_shear_strength or cohesion: the soil beside the caisson has neither")
    elif API in given and float(ground.vertical_stress(tip)) == 0.0:
        keys = key, ("soil", "effective_unit_weight"), ("soil", "surcharge")
        yield Clash(keys, '"api" needs a vertical effective stress: give effective_unit_weight or surcharge')


def drainage_clashes(scene: SceneSections) -> Iterator[Clash]:
    """Check that the drainage of each layer fits its law and that of the scene, and that water is somewhere."""
    mode, clay = scene.drainage.mode, [SOIL_LAWS[law].total_stress for law in laws_of(scene.soil)]
    for number, (layer, undrained) in enumerate(zip(scene.soil.layers, clay, strict=False)):
        possible = ("total-stress",) if undrained else tuple(dict.fromkeys((mode, "drained")))
        if layer.drainage is not None and layer.drainage not in possible:
            why = "undrained clay has no pore pressure as unknown" if undrained else f'drainage.mode is "{mode}"'
            allowed = " or ".join(f'"{each}"' for each in possible)
            yield Clash((("soil", "layer", number, "drainage"), ("drainage", "mode")), f"must be {allowed}: {why}")
    given = [each.drainage for each in scene.soil.layers] or [None]
    if mode != "drained" and all(dry or each == "drained" for dry, each in zip(clay, given, strict=False)):
        text = 'must be "drained": no layer has a pore pressure; clay in total stress and drained layers have none'
        yield Clash((("drainage", "mode"), ("soil", "yield_surface")), text)
