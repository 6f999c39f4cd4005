# SPDX-License-Identifier: MIT
"""The runs as data: the paper's six runs, two for our idealisations, readings of what it leaves open."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pysprings.scene.model import Scene

_DEG = math.pi / 180.0
_NOTHING: Mapping[str, Any] = MappingProxyType({})

PATH = "pull"  # name of the one path of every run
END = 20e-3  # m, displacement of the lid centre at the end
SHOWN = 2.5e-3  # m, where the paper shows states
DEPTHS = (0.25, 1.25, 2.25, 3.25)  # m, the paper's four depths
# mm, converged steps for slopes, for the figures' states, and (the later ones) for time steps that follow the flow
STEPS_MM = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0, 2.25, 2.5, 2.75, 3.0, 3.5, 4.0, 5.0, 6.0,
            7.0, 8.0, 9.0, 10.0, 12.0, 14.0, 16.0, 18.0)  # fmt: skip
VARIANT_STEPS_MM = (0.1, 0.2, 0.3, 0.4, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 7.0, 10.0)
SLOW, FAST = 0.05e-3, 0.5e-3  # m/s, the paper's rates


@dataclass(frozen=True)
class Case:
    """One run of the paper's caisson, a pull at the lid centre.

    rate : velocity of the lid centre (m/s); None is drained.
    end, stops_mm : last displacement of the lid centre (m), and where steps end on the way to it (mm).
    changes : section -> values (SI, as in the scene) that differ from the paper's.
    """

    name: str
    words: str
    rate: float | None = None
    friction: float = 0.5
    changes: Mapping[str, Mapping[str, Any]] = field(default_factory=lambda: _NOTHING)
    end: float = END
    stops_mm: tuple[float, ...] = STEPS_MM

    @property
    def drained(self) -> bool:
        """Whether the run is drained."""
        return self.rate is None

    def scene(self, mesh: str, fields_only: bool = False) -> Scene:
        """Return the scene on a mesh preset; UserInputError or ValueError where its values are refused.

        fields_only : keep contact fields but neither the symmetry plane nor pictures.
        """
        from pysprings.scene.model import Scene
        from pysprings.scene.sections import PAPER, PAPER_SOIL

        stops = tuple(u / 1e3 for u in self.stops_mm if u / 1e3 < self.end)
        path = {"name": PATH, "kind": "pull", "lateral_displacement": self.end, "report_at": stops}
        drainage: dict[str, Any] = {}
        if self.rate is not None:
            path["rate"] = self.rate
            drainage = {"mode": "coupled", "water_depth": 30.0}
        given: dict[str, Any] = {
            "title": f"Caisson of Cerfontaine et al. (2018), {self.words}", "path": [path],
            "domain": PAPER, "soil": PAPER_SOIL, "mesh": {"preset": mesh, "discretisation": "hex8"},
            "interface": {"friction_coefficient": self.friction}, "drainage": drainage,
            "output": {"section": not fields_only, "figures": not fields_only},
        }  # fmt: skip
        for section, values in self.changes.items():
            given[section] = {**given.get(section, {}), **values}
        return Scene.model_validate(given)


CASES = (
    Case("drained", "drained, friction 0.5"),
    Case("drained-smooth", "drained, no friction", friction=0.0),
    Case("slow", "0.05 mm/s, friction 0.5", SLOW),
    Case("slow-smooth", "0.05 mm/s, no friction", SLOW, friction=0.0),
    Case("fast", "0.5 mm/s, friction 0.5", FAST),
    Case("fast-smooth", "0.5 mm/s, no friction", FAST, friction=0.0),
    # what our defaults idealise
    Case("elastic-steel", "drained, elastic steel", changes={"caisson": {"behaviour": "elastic"}}),
    Case("van-eekelen", "drained, Van Eekelen's surface", changes={"soil": {"yield_surface": "van-eekelen"}}),
)

# Whether a reading fills in what the paper leaves open, or differs from what it states.
OPEN, STATED = "open", "stated"


@dataclass(frozen=True)
class Variant:
    """One reading of the paper: what is changed, and whether the paper leaves it open or states otherwise.

    smooth : the same without friction is run, too (to 2.5 mm), for the ratio of their loads.
    water : run at 0.05 mm/s; ``beside`` is the variant whose drained run it is set against.
    """

    group: str
    name: str
    words: str
    changes: Mapping[str, Mapping[str, Any]] = field(default_factory=lambda: _NOTHING)
    standing: str = OPEN
    smooth: bool = True
    water: bool = False
    beside: str = "as-stated"

    def case(self) -> Case:
        """Return its run."""
        rate = SLOW if self.water else None
        return Case(self.name, self.words, rate, changes=self.changes, stops_mm=VARIANT_STEPS_MM)

    def smooth_case(self) -> Case | None:
        """Return the same run without friction, to 2.5 mm; None where it is not requested."""
        if not self.smooth:
            return None
        words = f"{self.words}, no friction"
        return Case(f"{self.name}-smooth", words, changes=_smooth(self.changes), end=SHOWN, stops_mm=VARIANT_STEPS_MM)


def _smooth(changes: Mapping[str, Mapping[str, Any]]) -> dict[str, Mapping[str, Any]]:
    return {**changes, "interface": {**changes.get("interface", {}), "friction_coefficient": 0.0}}


def _soil(**values: Any) -> dict[str, Any]:
    return {"soil": values}


def _angle(degrees: float) -> float:
    return degrees * _DEG


def _penalty(stiffness: float) -> dict[str, Any]:
    return {"interface": {"normal_stiffness": stiffness, "shear_stiffness": stiffness}}


_STRONG = {"friction_angle_initial": _angle(30.0)}

VARIANTS = (
    Variant("as stated", "as-stated", "the paper's values; where it is silent, the defaults of this tool"),
    # what the paper leaves open, one at a time
    Variant("yield surface", "surface-van-eekelen", "Van Eekelen's surface", _soil(yield_surface="van-eekelen")),
    Variant("steel", "steel-elastic", "elastic steel, as the paper states it", {"caisson": {"behaviour": "elastic"}}),
    Variant("dilation", "dilation-5", "psi 5 deg", _soil(dilation_angle=_angle(5.0))),
    Variant("dilation", "dilation-10", "psi 10 deg", _soil(dilation_angle=_angle(10.0))),
    Variant("dilation", "dilation-30", "psi 30 deg (associated at the end)", _soil(dilation_angle=_angle(30.0))),
    Variant("cohesion", "cohesion-1", "c 1 kPa", _soil(cohesion=1e3)),
    Variant("cohesion", "cohesion-5", "c 5 kPa", _soil(cohesion=5e3)),
    Variant("domain", "side-fixed", "side of the domain fixed", {"domain": {"side": "fixed"}}),
    Variant("domain", "deeper", "soil 24 m deep", {"domain": {"depth": 24.0}}),
    Variant("domain", "larger", "soil of 48 m x 24 m", {"domain": {"radius": 48.0, "depth": 24.0}}),
    Variant("dead load", "steel-weight", "dead load 1.94 MN: the submerged weight of the steel",
            {"caisson": {"vertical_load": 1.94e6}}),
    # values that the paper states, read otherwise
    Variant("friction angle", "no-hardening", "phi 30 deg from the start", _soil(**_STRONG), STATED),
    Variant("friction angle", "hardening-percent", "B_phi 5e-5: 0.005 read as per cent",
            _soil(hardening_parameter=5e-5), STATED),
    Variant("friction angle", "phi-initial-15", "phi_i 15 deg", _soil(friction_angle_initial=_angle(15.0)), STATED),
    Variant("stiffness", "E-20", "E 20 MPa", _soil(young_modulus=20e6), STATED),
    Variant("combined", "E-20-no-hardening", "E 20 MPa, phi 30 deg from the start",
            _soil(young_modulus=20e6, **_STRONG), STATED),
    Variant("combined", "E-50-hardening-percent", "E 50 MPa, B_phi 5e-5",
            _soil(young_modulus=50e6, hardening_parameter=5e-5), STATED),
    Variant("penalty", "penalty-1e9", "K_N = K_T = 1e9 N/m3", _penalty(1e9), STATED),
    Variant("penalty", "penalty-1e8", "K_N = K_T = 1e8 N/m3", _penalty(1e8), STATED),
    Variant("penalty", "penalty-1e7", "K_N = K_T = 1e7 N/m3", _penalty(1e7), STATED),
    Variant("combined", "penalty-1e7-no-hardening", "K_N = K_T = 1e7 N/m3, phi 30 deg from the start",
            _penalty(1e7) | _soil(**_STRONG), STATED),
    Variant("combined", "cohesion-5-E-50", "c 5 kPa, E 50 MPa", _soil(cohesion=5e3, young_modulus=50e6), STATED),
    Variant("combined", "cohesion-5-E-50-steel-weight", "c 5 kPa, E 50 MPa, dead load 1.94 MN", {
        **_soil(cohesion=5e3, young_modulus=50e6), "caisson": {"vertical_load": 1.94e6}}, STATED),
    Variant("combined", "cohesion-3-E-50", "c 3 kPa, E 50 MPa", _soil(cohesion=3e3, young_modulus=50e6), STATED),
    Variant("combined", "cohesion-5-E-20", "c 5 kPa, E 20 MPa", _soil(cohesion=5e3, young_modulus=20e6), STATED),
    Variant("combined", "cohesion-5-mu-0.25", "c 5 kPa, mu 0.25", {
        **_soil(cohesion=5e3), "interface": {"friction_coefficient": 0.25}}, STATED, smooth=False),
    Variant("combined", "cohesion-3-steel-weight", "c 3 kPa, dead load 1.94 MN", {
        **_soil(cohesion=3e3), "caisson": {"vertical_load": 1.94e6}}),
    Variant("combined", "cohesion-4-steel-weight", "c 4 kPa, dead load 1.94 MN", {
        **_soil(cohesion=4e3), "caisson": {"vertical_load": 1.94e6}}),
    Variant("combined", "cohesion-4-4MN", "c 4 kPa, dead load 4 MN", {
        **_soil(cohesion=4e3), "caisson": {"vertical_load": 4e6}}),
    Variant("combined", "cohesion-3-4MN", "c 3 kPa, dead load 4 MN", {
        **_soil(cohesion=3e3), "caisson": {"vertical_load": 4e6}}),
    Variant("combined", "cohesion-4-E-100-steel-weight", "c 4 kPa, E 100 MPa, dead load 1.94 MN", {
        **_soil(cohesion=4e3, young_modulus=100e6), "caisson": {"vertical_load": 1.94e6}}, STATED),
    Variant("combined", "cohesion-5-steel-weight", "c 5 kPa, dead load 1.94 MN", {
        **_soil(cohesion=5e3), "caisson": {"vertical_load": 1.94e6}}),
    Variant("combined", "cohesion-5-no-hardening", "c 5 kPa, phi 30 deg from the start",
            _soil(cohesion=5e3, **_STRONG), STATED),
    Variant("friction angle", "low-strength", "phi 15 deg, no hardening", _soil(
        friction_angle_initial=_angle(15.0), friction_angle_final=_angle(15.0)), STATED),
    Variant("initial stress", "surcharge-0", "no confinement at the surface", _soil(surcharge=0.0), STATED),
    Variant("initial stress", "surcharge-21", "confinement by 2 m of soil", _soil(surcharge=21.12e3), STATED),
    Variant("initial stress", "K0-0.5", "K0 0.5", _soil(K0=0.5), STATED),
    Variant("combined", "K0-0.5-no-hardening", "K0 0.5, phi 30 deg from the start",
            _soil(K0=0.5, **_STRONG), STATED),
    Variant("friction", "mu-0.25", "mu 0.25", {"interface": {"friction_coefficient": 0.25}}, STATED, smooth=False),
    Variant("friction", "mu-1", "mu 1", {"interface": {"friction_coefficient": 1.0}}, STATED, smooth=False),
    Variant("stiffness", "elastic", "elastic soil, contact that opens and slides", {
        "soil": {"yield_surface": "elastic"}}, STATED),
    # with water, 0.05 mm/s
    Variant("water", "slow", "as stated, 0.05 mm/s", smooth=False, water=True),
    Variant("water", "aperture-1e-6", "D_0 1e-6 m", {"interface": {"residual_aperture": 1e-6}}, smooth=False,
            water=True),
    Variant("water", "aperture-1e-4", "D_0 1e-4 m", {"interface": {"residual_aperture": 1e-4}}, smooth=False,
            water=True),
    Variant("water", "incompressible", "incompressible water", {"drainage": {"water_bulk_modulus": "incompressible"}},
            smooth=False, water=True),
    Variant("water", "side-drained", "side of the domain drained", {"domain": {"side_drainage": "drained"}},
            smooth=False, water=True),
    Variant("water", "slow-dilation-5", "psi 5 deg, 0.05 mm/s", _soil(dilation_angle=_angle(5.0)), smooth=False,
            water=True, beside="dilation-5"),
    Variant("water", "slow-dilation-30", "psi 30 deg, 0.05 mm/s", _soil(dilation_angle=_angle(30.0)), smooth=False,
            water=True, beside="dilation-30"),
    Variant("water", "slow-no-hardening", "phi 30 deg from the start, 0.05 mm/s", _soil(**_STRONG), STATED,
            smooth=False, water=True, beside="no-hardening"),
)  # fmt: skip
