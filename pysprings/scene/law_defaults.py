# SPDX-License-Identifier: MIT
"""Keys of a soil that none of its laws uses, and defaults that belong to a law."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from pysprings.scene.soil_laws import FRICTION_KEYS, SOIL_LAWS, SoilLaw

STIFFNESSES = ("young_modulus", "shear_modulus", "rigidity_ratio", "plasticity_index")  # the last two of clay alone


def with_defaults_of_laws(data: dict[str, Any], defaults: Mapping[str, Any]) -> dict[str, Any]:
    """Return the data of a soil with the defaults of its laws, and without values of [soil] that are not in use.

    ``defaults`` are those of the keys; a key that is not in use and has its default counts as not given.
    """
    data = dict(data)
    surface = data.get("yield_surface", defaults["yield_surface"])
    name = "layer" if "layer" in data else "layers"
    layers = [dict(each) if isinstance(each, dict) else each for each in data.get(name) or ()]
    laws = [_law(each) or surface for each in layers] or [surface]
    for key in unused_keys(laws, {each for each in STIFFNESSES if data.get(each) is not None}):
        if key in data and data[key] == defaults[key]:
            del data[key]
    for table, law in [*zip(layers, laws, strict=False)] if layers else [(data, surface)]:
        if isinstance(table, dict) and isinstance(law, str) and law in SOIL_LAWS:
            for key, value in _defaults(SOIL_LAWS[law], table.get("K0") or data.get("K0")).items():
                if key not in data and table.get(key) is None:
                    table[key] = value
    if isinstance(data.get(name), list | tuple):
        data[name] = layers
    return data


def _defaults(law: SoilLaw, k0: Any) -> dict[str, Any]:
    """Return the defaults of a law for a K0 as it is given."""
    at_rest = law.defaults_at_rest if isinstance(k0, str) and k0 == "auto" else {}
    return {**law.defaults, **at_rest}


def _law(layer: Any) -> Any:
    return layer.get("law") if isinstance(layer, dict) else getattr(layer, "law", None)


def unused_keys(laws: Iterable[Any], stiffness: set[str]) -> list[str]:
    """Return the keys of [soil] that none of these laws uses; ``stiffness`` are those of its stiffness that are set."""
    kinds = {SOIL_LAWS[law].total_stress for law in laws if isinstance(law, str) and law in SOIL_LAWS}
    unused = list(FRICTION_KEYS) if kinds == {True} else []
    return [*unused, "young_modulus"] if stiffness - {"young_modulus"} else unused
