# SPDX-License-Identifier: MIT
"""A case of the catalogue: what is stretched, and the scene that it gives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pysprings.scene.load import Scene

REACH = 20e-3  # m
_NOTHING: Mapping[str, Any] = MappingProxyType({})


@dataclass(frozen=True)
class Case:
    """One case: its group and name, what is stretched, and the changes to the paper's scene (SI, as in the scene).

    ``changes`` maps sections to values; ``path`` replaces values of the path, a pull at the lid centre to REACH.
    ``hard`` cases are also run on the ``paper`` mesh where one asks for them.
    """

    group: str
    name: str
    what: str
    changes: Mapping[str, Any] = field(default_factory=lambda: _NOTHING)
    path: Mapping[str, Any] = field(default_factory=lambda: _NOTHING)
    hard: bool = False

    @property
    def _clay(self) -> bool:
        """Whether all its ground is undrained clay, which shares weight and surcharge alone with the paper's sand."""
        from pysprings.scene.soil_laws import SOIL_LAWS

        soil = self.changes.get("soil", {})
        usual = soil.get("yield_surface", "drucker-prager")
        layers = soil.get("layers") or soil.get("layer") or [{}]
        return all(SOIL_LAWS[layer.get("law") or usual].total_stress for layer in layers)

    def scene(self, mesh: str, reach: float = REACH, discretisation: str = "hex8") -> Scene:
        """Return the scene of the case, pulled as far as ``reach`` (m) where the case sets no displacement of its own.

        Raises UserInputError or ValueError where the input is refused.
        """
        from pysprings.scene.extent import PAPER
        from pysprings.scene.load import Scene
        from pysprings.scene.sections import PAPER_SOIL

        coupled = self.changes.get("drainage", {}).get("mode", "drained") == "coupled"
        path = {"name": "path", "kind": "pull", "lateral_displacement": reach} | ({"rate": 0.05e-3} if coupled else {})
        path = {key: value for key, value in (path | dict(self.path)).items() if value is not None}
        output = {"interface_fields": False, "section": False, "figures": False}
        given: dict[str, Any] = {"title": self.what, "domain": PAPER, "output": output, "path": [path]}
        given |= {"soil": PAPER_SOIL, "mesh": {"preset": mesh, "discretisation": discretisation}}
        changed = {name: given.get(name, {}) | dict(values) for name, values in self.changes.items()}
        if self._clay:
            own = {key: PAPER_SOIL[key] for key in ("effective_unit_weight", "surcharge")}
            changed["soil"] = own | self.changes["soil"]
        return Scene.model_validate(given | changed)
