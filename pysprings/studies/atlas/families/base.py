# SPDX-License-Identifier: MIT
"""What a family of an atlas declares: the dimensionless numbers that decide, and the sizes of loads and motions.

The reactions of a caisson to a motion rho along a ray are F h(X) times a function of the inputs and of X, with a force
F and X = ratio rho/D. h = X/(1 + X) takes the way from elasticity to failure out of what is interpolated.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from pysprings.core.arrays import Array
from pysprings.core.errors import Problem, UserInputError
from pysprings.scene.by_depth import ByDepth
from pysprings.scene.defaults import row_of, value_text
from pysprings.scene.ground import in_layers
from pysprings.scene.model import Scene

_TOLERANCE = 0.01  # share by which a value that scales may differ
FREE = {
    "caisson": ("outer_diameter", "skirt_length", "lid_thickness", "vertical_load"),
    "drainage": (
        "porosity", "water_bulk_modulus", "water_unit_weight", "water_viscosity", "water_depth", "stabilisation",
    ),
}  # fmt: skip  # keys by section that may differ in every family


@dataclass(frozen=True)
class Sizes:
    """Sizes of a scene: force F [N], X over rho/D."""

    force: float
    ratio: float


@dataclass(frozen=True)
class Scaled:
    """A value of a scene that an atlas has in proportion to a size of the scene.

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

    name : word of atlas files.
    labels : names of the inputs, for tables.
    read : scene -> inputs (d,).
    even : inputs (..., d) -> the same in a form in which the reactions vary evenly.
    sizes : scene -> `Sizes`.
    free : keys of a scene by section that may differ from the base scene of an atlas.
    scaled : values that an atlas has in proportion.
    short : short names of keys for the command line.
    odd : scene, base -> further reasons why an atlas does not cover the scene.
    at_rest : scene -> vertical load [N] of its initial contact stresses, where no input follows the weight of the soil;
        the last input is then V.
    under_load : remarks on springs at a V above 0.
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
    at_rest: Callable[[Scene], float] | None = None
    under_load: tuple[str, ...] = ()

    def check(self, scene: Scene, base: Scene) -> None:
        """Raise UserInputError for every value of a scene that an atlas with this base scene does not follow."""
        mine, theirs = ([str(each.law) for each in in_layers(one.soil).layers] for one in (scene, base))
        if mine != theirs:
            text = f"the ground of the atlas is {', '.join(theirs)}, that of the scene {', '.join(mine)}"
            raise UserInputError([Problem(key="soil", message=text)])
        problems = [*_differing(scene, base, self), *self.odd(scene, base)]
        if not problems:
            problems = [*self._scaled_faults(scene, base)]
        if problems:
            raise UserInputError(problems)

    def _scaled_faults(self, scene: Scene, base: Scene) -> Iterator[Problem]:
        for each in self.scaled:
            there, own = each.value(base), each.value(scene)
            if abs(own - there) > _TOLERANCE * abs(there):
                text = f"the atlas has {there:.4g} {each.words}, the scene {own:.4g}"
                yield Problem(key=f"{each.section}.{each.key}", message=text)


def _differing(scene: Scene, base: Scene, family: Family) -> Iterator[Problem]:
    """Yield a problem for every value that differs from the base scene and is not free; the laws are the same."""
    mine, theirs = in_layers(scene.soil), in_layers(base.soil)
    names = ("caisson", "domain", "interface", "drainage")
    tables: list[tuple[str, Any, Any]] = [(name, getattr(scene, name), getattr(base, name)) for name in names]
    layers = zip(mine.layers, theirs.layers, strict=True)
    tables += [("soil", mine, theirs), *(("soil.layer", *pair) for pair in layers)]
    scaled = {(each.section, each.key) for each in family.scaled}
    for name, own, known in tables:
        place = "soil" if not scene.soil.layers else name
        for key in type(own).model_fields:
            if key in ("layers", "top") or key in family.free.get(name, ()) or (name, key) in scaled:
                continue
            here, there = getattr(own, key), getattr(known, key)
            if here != there:
                shown = [_shown(each, type(own), key) for each in (there, here)]
                message = f"the atlas holds for {shown[0]} alone, the scene has {shown[1]}"
                yield Problem(key=f"{place if name == 'soil.layer' else name}.{key}", message=message)


def _shown(value: Any, model: Any, key: str) -> str:
    words = "none" if value is None else "a value by depth" * isinstance(value, ByDepth)
    return words or value_text(row_of(key, value, model, key))


def first_layer(scene: Scene) -> Any:
    """Return the first layer of a scene with all its values, whether or not the scene has layers."""
    return in_layers(scene.soil).layers[0]


def diameter(scene: Scene) -> float:
    """Return the outer diameter [m]."""
    return scene.caisson.outer_diameter
