# SPDX-License-Identifier: MIT
"""What a family of an atlas declares: the dimensionless numbers that decide, and the sizes of loads and motions.

The reactions of a caisson to a motion rho along a ray are F h(X) times a function of the inputs and of X, with a force
F and X = ratio rho/D. h = X/(1 + X) takes the way from elasticity to failure out of what is interpolated.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pysprings.core.errors import Problem, UserInputError

if TYPE_CHECKING:
    from pysprings.scene.model import Scene

Array = NDArray[np.float64]
_TOLERANCE = 0.01  # share by which a value that scales may differ


@dataclass(frozen=True)
class Sizes:
    """Sizes of a scene: force F [N], X over rho/D."""

    force: float
    ratio: float


@dataclass(frozen=True)
class Scaled:
    """A value of a scene that an atlas has in proportion to a size of the scene.

    Attributes
    ----------
    section, key : of the scene.
    unit : of the value in a scene file, and its SI value.
    words : the size, for messages.
    size : scene -> the size in SI.
    """

    section: str
    key: str
    unit: tuple[str, float]
    words: str
    size: Callable[[Scene], float]

    def value(self, scene: Scene) -> float:
        """Return the value over its size."""
        return float(getattr(getattr(scene, self.section), self.key)) / self.size(scene)


@dataclass(frozen=True)
class Family:
    """A family of caissons and ground: one module beside this one, and one entry in `FAMILIES`.

    Attributes
    ----------
    name : word of atlas files.
    labels : names of the inputs, for tables.
    read : scene -> inputs (d,).
    even : inputs (..., d) -> the same in a form in which the reactions vary evenly.
    sizes : scene -> `Sizes`.
    free : keys of a scene by section that may differ from the base scene of an atlas.
    scaled : values that an atlas has in proportion.
    short : short names of keys for the command line.
    odd : scene, base -> further reasons why an atlas does not cover the scene.
    """

    name: str
    labels: tuple[str, ...]
    read: Callable[[Scene], Array]
    even: Callable[[Array], Array]
    sizes: Callable[[Scene], Sizes]
    free: Mapping[str, tuple[str, ...]]
    scaled: tuple[Scaled, ...] = ()
    short: Mapping[str, str] = field(default_factory=dict)
    odd: Callable[[Scene, Scene], Iterator[Problem]] = lambda _scene, _base: iter(())

    def check(self, scene: Scene, base: Scene) -> None:
        """Raise UserInputError for every value of a scene that an atlas with this base scene does not follow."""
        problems = [*self._scaled_faults(scene, base), *_differing(scene, base, self), *self.odd(scene, base)]
        if problems:
            raise UserInputError(problems)

    def _scaled_faults(self, scene: Scene, base: Scene) -> Iterator[Problem]:
        for each in self.scaled:
            there, own = each.value(base), each.value(scene)
            if abs(own - there) > _TOLERANCE * abs(there):
                text = f"the atlas has {there:.4g} {each.words}, the scene {own:.4g}"
                yield Problem(key=f"{each.section}.{each.key}", message=text)


def _differing(scene: Scene, base: Scene, family: Family) -> Iterator[Problem]:
    """Yield a problem for every value that differs from the base scene and is not free."""
    mine, theirs = scene.model_dump(), base.model_dump()
    if len(mine["soil"]["layers"]) != len(theirs["soil"]["layers"]):
        yield Problem(key="soil.layer", message=f"the atlas has {len(theirs['soil']['layers']) or 'no'} layer tables")
        return
    tables = [(name, mine[name], theirs[name]) for name in ("caisson", "domain", "soil", "interface", "drainage")]
    tables += [("soil.layer", *pair) for pair in zip(mine["soil"]["layers"], theirs["soil"]["layers"], strict=True)]
    scaled = {(each.section, each.key) for each in family.scaled}
    for name, own, known in tables:
        for key, value in own.items():
            if key == "layers" or key in family.free.get(name, ()) or (name, key) in scaled:
                continue
            if value != known[key]:
                message = f"the atlas holds for {_shown(known[key])} alone, the scene has {_shown(value)}"
                yield Problem(key=f"{name}.{key}", message=message)


def _shown(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def diameter(scene: Scene) -> float:
    """Return the outer diameter [m]."""
    return scene.caisson.outer_diameter
