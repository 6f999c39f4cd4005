# SPDX-License-Identifier: MIT
"""A scene with design values of strength: partial factors on tan phi, c and su.

The friction angle becomes atan(tan(phi)/factor), cohesion and su are divided by their factors, and the friction
coefficient of the interface by that of tan phi. Stiffness stays: a `rigidity_ratio` G/su is multiplied by the factor of
su. The adhesion factor stays, so that the adhesion falls with su; `"api"` is evaluated with the design value of su. The
angle at first yield and the dilation angle are reduced where they would exceed the new friction angle. The initial
stress stays: K0 = "auto" is that of the friction angle before.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Self

from pysprings.core.errors import Problem, UserInputError
from pysprings.core.units import quoted
from pysprings.scene.ground import at_rest
from pysprings.scene.layers import laws_of
from pysprings.scene.model import Scene
from pysprings.scene.soils import SOIL_LAWS

NAMES = {"tan_phi": "tan phi", "c": "c", "su": "su"}
LARGEST = 5.0
_EXPECTED = f"expected a number from 1 to {LARGEST:g} such as 1.25, or one of {', '.join(NAMES)} with it such as su=1.4"


@dataclass(frozen=True, slots=True)
class StrengthFactors:
    """Partial factors on tan phi, cohesion and undrained strength."""

    tan_phi: float = 1.0
    c: float = 1.0
    su: float = 1.0

    @classmethod
    def read(cls, texts: Iterable[str]) -> Self:
        """Read factors: "1.25" for all but those that have one of their own, "su=1.4", in any order.

        Raises UserInputError for every text that is none, and for a second factor of the same.
        """
        found, problems = dict[str, float](), []
        for text in texts:
            name, _, number = text.rpartition("=")
            name = name.strip()
            try:
                value = float(number)
            except ValueError:
                value = math.nan
            if not 1.0 <= value <= LARGEST or name not in ("", *NAMES):
                problems.append(Problem(key="--factor", message=f"{quoted(text)}: {_EXPECTED}"))
            elif name in found:
                problems.append(Problem(key="--factor", message=f"{quoted(text)}: a second factor of {name or 'all'}"))
            else:
                found[name] = value
        if problems:
            raise UserInputError(problems)
        return cls(**{name: found.get(name, found.get("", 1.0)) for name in NAMES})

    def __str__(self) -> str:
        return ", ".join(f"{words}/{getattr(self, name):g}" for name, words in NAMES.items())


def with_design_strength(scene: Scene, factors: StrengthFactors) -> Scene:
    """Return a scene with its strength divided by partial factors; refuse friction that has no key of its own."""
    for law in laws_of(scene.soil) if factors.tan_phi != 1.0 else ():
        if SOIL_LAWS[law].yields and SOIL_LAWS[law].friction not in ("", "friction_angle_final"):
            text = f'law "{law}" has no friction angle to divide: give c= and su=, or a law with friction_angle_final'
            raise UserInputError([Problem(key="--factor", message=text)])
    soil = scene.model_dump()["soil"]
    ground = scene.extent.ground
    tops = [layer["top"] for layer in soil["layers"]]
    _keep_initial_stress(soil)
    _reduce(soil, factors, 0.0, ground)
    for layer, bottom in zip(soil["layers"], [*tops[1:], ground], strict=False):  # no layers: one soil
        _reduce(layer, factors, layer["top"], bottom)
    interface = {"friction_coefficient": scene.interface.friction_coefficient / factors.tan_phi}
    title = f"{scene.title} (design strength: {factors})"
    return scene.replace(title=title[:200], soil=soil, interface=interface)


def _keep_initial_stress(soil: dict[str, Any]) -> None:
    """Put numbers in place of K0 = "auto", in place."""
    for table in soil["layers"] or [soil]:
        law = SOIL_LAWS[table.get("law") or soil["yield_surface"]]
        own = {name: soil[name] if table[name] is None else table[name] for name in ("K0", law.friction) if name}
        if own["K0"] == "auto":
            angle = own[law.friction]
            table["K0"] = at_rest(law.defaults[law.friction] if angle is None else angle)


def _reduce(table: dict[str, Any], factors: StrengthFactors, top: float, bottom: float) -> None:
    """Reduce the strength of a soil or layer between two depths [m], in place."""

    def reduced(angle: float) -> float:
        return math.atan(math.tan(angle) / factors.tan_phi)

    before = table.get("friction_angle_final")
    if before is not None and factors.tan_phi != 1.0:
        after = table["friction_angle_final"] = _each(before, reduced, top, bottom)
        least = min(after["top"], after["bottom"]) if isinstance(after, dict) else after
        for name in ("friction_angle_initial", "dilation_angle"):
            if table.get(name) is not None and table[name] != "auto":
                table[name] = _each(table[name], lambda angle: min(angle, least), top, bottom)
    for name, factor in (("cohesion", factors.c), ("undrained_shear_strength", factors.su)):
        if table.get(name) is not None:
            table[name] = _divided(table[name], factor)
    if table.get("rigidity_ratio") is not None:
        table["rigidity_ratio"] = _divided(table["rigidity_ratio"], 1.0 / factors.su)


def _each(value: Any, change: Callable[[float], float], top: float, bottom: float) -> Any:
    """Return a constant, or a value that is linear in a layer between two depths [m], changed at both ends."""
    if not isinstance(value, dict):
        return change(value)
    if value.get("bottom") is not None:
        to = {} if value.get("to") is None else {"to": value["to"]}
        return {"top": change(value["top"]), "bottom": change(value["bottom"])} | to
    end = value["top"] + value["gradient"] * (bottom - top)
    return {"top": change(value["top"]), "bottom": change(end), "to": bottom}


def _divided(value: Any, factor: float) -> Any:
    """Return a value over a factor; of a value by depth all that is a strength."""
    if not isinstance(value, dict):
        return value / factor
    sizes = ("top", "bottom", "gradient")
    return {key: each / factor if key in sizes else each for key, each in value.items() if each is not None}
