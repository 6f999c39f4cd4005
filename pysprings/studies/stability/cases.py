# SPDX-License-Identifier: MIT
"""The catalogue of stiff and extreme cases: the paper's caisson with a few values far from usual."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pysprings.scene.model import Scene

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
        from pysprings.scene.soils import SOIL_LAWS

        soil = self.changes.get("soil", {})
        usual = soil.get("yield_surface", "drucker-prager")
        layers = soil.get("layers") or soil.get("layer") or [{}]
        return all(SOIL_LAWS[layer.get("law") or usual].total_stress for layer in layers)

    def scene(self, mesh: str, reach: float = REACH, discretisation: str = "hex8") -> Scene:
        """Return the scene of the case, pulled as far as ``reach`` (m) where the case sets no displacement of its own.

        Raises UserInputError or ValueError where the input is refused.
        """
        from pysprings.scene.model import Scene
        from pysprings.scene.sections import PAPER, PAPER_SOIL

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


_SOFT = {"top": 5e3, "gradient": 2e3}
_CLAY = {
    "yield_surface": "tresca", "undrained_shear_strength": _SOFT, "rigidity_ratio": 200.0,
    "effective_unit_weight": 6e3, "surcharge": 0.0,
}  # fmt: skip
_SIDES = ("outside", "inside", "lid", "tip")
_BUCKET = {
    "adhesion_factor": 0.65,
    "opening": {"outside": "vented", "inside": "sealed", "lid": "sealed", "tip": "sealed"},
}


def _clay(interface: Mapping[str, Any] | None = None, **soil: Any) -> dict[str, Any]:
    """Return soft clay with some values changed, and its interface."""
    return {"soil": {**_CLAY, **soil}, "interface": {**_BUCKET, **(interface or {})}}


def _layers(*layers: Mapping[str, Any], interface: Mapping[str, Any] | None = None, **soil: Any) -> dict[str, Any]:
    """Return layers, sand where they say nothing else."""
    changes = {"soil": {"layers": tuple(dict(each) for each in layers), **soil}}
    return changes | ({"interface": dict(interface)} if interface else {})


def _steps(depths: Sequence[float], moduli: Sequence[float]) -> tuple[dict[str, Any], ...]:
    return tuple({"top": z, "young_modulus": young} for z, young in zip(depths, moduli, strict=True))


_STIFF = {"law": "tresca", "undrained_shear_strength": 50e3, "rigidity_ratio": 200.0}
_WEAK = {"law": "tresca", "undrained_shear_strength": 1e3, "rigidity_ratio": 200.0}
_TWENTY = _steps([0.5 * n for n in range(20)], [20e6 * (1.0 + 9.0 * (n % 2)) for n in range(20)])

GROUND_CASES = (
    Case("ground", "layer-5cm", "5 cm of E 5 MPa at 2 m", _layers(
        *_steps([0.0, 2.0, 2.05], [200e6, 5e6, 200e6])), hard=True),
    Case("ground", "boundary-at-tip", "E 20 over 400 MPa at the tip", _layers(*_steps([0.0, 4.0], [20e6, 400e6]))),
    Case("ground", "boundary-1mm-below-tip", "E 20 over 400 MPa 1 mm below the tip", _layers(
        *_steps([0.0, 4.001], [20e6, 400e6])), hard=True),
    Case("ground", "twenty-layers", "twenty layers of 0.5 m, E 20 and 200 MPa", _layers(*_TWENTY)),
    Case("ground", "stiffness-1e4", "E 1 MPa over 10 GPa at 2 m", _layers(*_steps([0.0, 2.0], [1e6, 10e9])), hard=True),
    Case("ground", "stiff-crust", "E 1 GPa over 1 MPa at 1 m", _layers(*_steps([0.0, 1.0], [1e9, 1e6]))),
    Case("clay", "soft-clay", "su = 5 + 2 z kPa", _clay(), hard=True),
    Case("clay", "su-0-at-mudline", "su = 2 z kPa", _clay(undrained_shear_strength={"top": 0.0, "gradient": 2e3}),
         hard=True),
    Case("clay", "su-1kPa-over-1MPa", "su 1 kPa over 1 MPa at 2 m", _layers(
        {"top": 0.0, **_WEAK}, {"top": 2.0, **_WEAK, "undrained_shear_strength": 1e6}, interface=_BUCKET), hard=True),
    Case("clay", "alpha-0", "alpha = 0", _clay({"adhesion_factor": 0.0})),
    Case("clay", "alpha-1-bonded", "alpha = 1, bonded", _clay({"adhesion_factor": 1.0, "opening": "bonded"})),
    Case("clay", "vented", "vented everywhere", _clay({"opening": "vented"})),
    Case("clay", "nu-0.4999", "nu = 0.4999", _clay(poisson_ratio=0.4999), hard=True),
    Case("clay", "von-mises", "von Mises", _clay(yield_surface="von-mises")),
    Case("clay", "half-strength-at-5-percent", "half of su at a shear strain of 5 %", _clay(
        strain_at_half_strength=0.05)),
    Case("clay", "rigidity-1e4", "G/su = 10,000", _clay(rigidity_ratio=1e4)),
    Case("clay", "clay-K0-0.5", "K0 = 0.5", _clay(K0=0.5)),
    Case("clay", "api", "alpha of API RP 2GEO", _clay({"adhesion_factor": "api"})),
    Case("clay", "clay-push-0.8m", "pull to a tenth of D", _clay(), {"lateral_displacement": 0.8}, hard=True),
    Case("clay", "clay-beyond-capacity", "load 20 MN at mudline", _clay(), {
        "kind": "load", "lateral_displacement": None, "lateral_force": 20e6}),
    Case("clay", "clay-pull-out", "pulled out by 0.2 m", _clay(), {
        "kind": "vertical", "lateral_displacement": None, "vertical_displacement": -0.2}),
    Case("clay", "sand-over-clay", "2 m of sand over clay of su 50 kPa", _layers(
        {"top": 0.0}, {"top": 2.0, **_STIFF}, interface=_BUCKET), hard=True),
    Case("clay", "sand-over-clay-undrained", "2 m of undrained sand over clay", _layers(
        {"top": 0.0}, {"top": 2.0, **_STIFF}, interface=_BUCKET) | {"drainage": {"mode": "undrained"}}, hard=True),
    Case("clay", "sand-over-clay-coupled", "2 m of coupled sand over clay", _layers(
        {"top": 0.0}, {"top": 2.0, **_STIFF}, interface=_BUCKET) | {"drainage": {"mode": "coupled"}}),
    Case("clay", "clay-over-coupled-sand", "clay of su 5 kPa over confined coupled sand", _layers(
        {"top": 0.0, **_WEAK, "undrained_shear_strength": 5e3}, {"top": 2.0}, interface=_BUCKET) | {
        "drainage": {"mode": "coupled"}}),
    Case("ground", "drained-seam", "10 cm that drain, in undrained sand at 2 m", _layers(
        {"top": 0.0}, {"top": 2.0, "drainage": "drained"}, {"top": 2.1}) | {"drainage": {"mode": "undrained"}}),
    Case("clay", "clay-over-sand", "2 m of clay of su 1 kPa over sand", _layers(
        {"top": 0.0, **_WEAK}, {"top": 2.0}, interface=_BUCKET)),
    Case("clay", "clay-with-friction", "su beside a friction angle", _clay(friction_angle_final=0.6)),
    Case("clay", "weightless-api", "alpha of API RP 2GEO without weight", _clay(
        {"adhesion_factor": "api"}, effective_unit_weight=0.0)),
)  # fmt: skip


_DEG = math.pi / 180.0


def _penalty(normal: float, shear: float) -> dict[str, Any]:
    return {"interface": {"normal_stiffness": normal, "shear_stiffness": shear}}


def _water(**changes: Any) -> dict[str, Any]:
    return {"drainage": {"mode": "coupled"}, **changes}


def _caisson(length: float, radius: float, depth: float) -> dict[str, Any]:
    return {"caisson": {"skirt_length": length}, "domain": {"radius": radius, "depth": depth}}


def _turns(n: int, amplitude: float) -> tuple[str, ...]:
    """Return cycles of +- amplitude (mm) and back to zero, for a path that starts at +amplitude."""
    there_and_back = (f"{-amplitude:g} mm", f"{amplitude:g} mm")
    return (*there_and_back * n, "0 mm")


CASES = (
    Case("as it is", "paper", "the paper's caisson, drained", hard=True),
    Case("as it is", "paper-coupled", "the paper's caisson, 0.05 mm/s", _water(), hard=True),
    Case("penalty", "penalty-1e7", "K_N = K_T = 1e7 N/m3", _penalty(1e7, 1e7)),
    Case("penalty", "penalty-1e8", "K_N = K_T = 1e8 N/m3", _penalty(1e8, 1e8)),
    Case("penalty", "penalty-1e11", "K_N = K_T = 1e11 N/m3", _penalty(1e11, 1e11)),
    Case("penalty", "penalty-3e11", "K_N = K_T = 3e11 N/m3", _penalty(3e11, 3e11)),
    Case("penalty", "penalty-1e12", "K_N = K_T = 1e12 N/m3", _penalty(1e12, 1e12), hard=True),
    Case("penalty", "penalty-1e14", "K_N = K_T = 1e14 N/m3", _penalty(1e14, 1e14), hard=True),
    Case("penalty", "normal-over-shear", "K_N = 1e12, K_T = 1e8 N/m3", _penalty(1e12, 1e8)),
    Case("penalty", "shear-over-normal", "K_N = 1e8, K_T = 1e12 N/m3", _penalty(1e8, 1e12)),
    Case("penalty", "penalty-1e12-coupled", "K_N = K_T = 1e12 N/m3, coupled", _water(**_penalty(1e12, 1e12))),
    Case("friction", "smooth", "mu = 0", {"interface": {"friction_coefficient": 0.0}}, hard=True),
    Case("friction", "almost-smooth", "mu = 1e-4", {"interface": {"friction_coefficient": 1e-4}}),
    Case("friction", "rough", "mu = 2", {"interface": {"friction_coefficient": 2.0}}, hard=True),
    Case("soil", "phi-45", "phi_f = 45 deg", {"soil": {"friction_angle_final": 45 * _DEG}}),
    Case("soil", "no-hardening", "phi_i = phi_f = 30 deg", {"soil": {"friction_angle_initial": 30 * _DEG}}),
    Case("soil", "hardening-1e-6", "B_phi = 1e-6", {"soil": {"hardening_parameter": 1e-6}}),
    Case("soil", "hardening-1", "B_phi = 1", {"soil": {"hardening_parameter": 1.0}}),
    Case("soil", "associated", "psi = phi_f = 30 deg", {"soil": {"dilation_angle": 30 * _DEG}}, hard=True),
    Case("soil", "contractant", "psi = -5 deg", {"soil": {"dilation_angle": -5 * _DEG}}),
    Case("soil", "no-stress-at-mudline", "c = 0, surcharge = 0", {"soil": {"surcharge": 0.0}}, hard=True),
    Case("soil", "cohesion-1MPa", "c = 1 MPa", {"soil": {"cohesion": 1e6}}),
    Case("soil", "soft", "E = 1 MPa", {"soil": {"young_modulus": 1e6}}),
    Case("soil", "rock", "E = 100 GPa", {"soil": {"young_modulus": 100e9}}),
    Case("soil", "nu-0", "nu = 0", {"soil": {"poisson_ratio": 0.0}}),
    Case("soil", "nu-0.499", "nu = 0.499", {"soil": {"poisson_ratio": 0.499}}, hard=True),
    Case("soil", "K0-0.3", "K0 = 0.3 at phi_i = 5 deg", {"soil": {"K0": 0.3}}),
    Case("soil", "K0-0.3-strong", "K0 = 0.3 at phi_i = phi_f = 40 deg", {
        "soil": {"K0": 0.3, "friction_angle_initial": 40 * _DEG, "friction_angle_final": 40 * _DEG}}),
    Case("soil", "K0-3", "K0 = 3 at phi_i = 5 deg", {"soil": {"K0": 3.0}}),
    Case("soil", "K0-3-strong", "K0 = 3 at phi_i = phi_f = 30 deg", {
        "soil": {"K0": 3.0, "friction_angle_initial": 30 * _DEG}}),
    Case("soil", "van-eekelen", "Van Eekelen's surface", {"soil": {"yield_surface": "van-eekelen"}}, hard=True),
    Case("soil", "van-eekelen-dilates", "Van Eekelen's surface, psi = 10 deg", {
        "soil": {"yield_surface": "van-eekelen", "dilation_angle": 10 * _DEG}}),
    Case("water", "k-1e-14", "k = 1e-14 m/s", _water(soil={"hydraulic_conductivity": 1e-14}), hard=True),
    Case("water", "k-1", "k = 1 m/s", _water(soil={"hydraulic_conductivity": 1.0})),
    Case("water", "rate-1e-10", "1e-10 m/s", _water(), {"rate": 1e-10}),
    Case("water", "rate-1", "1 m/s", _water(), {"rate": 1.0}),
    Case("water", "aperture-1e-9", "D_0 = 1e-9 m", _water(interface={"residual_aperture": 1e-9})),
    Case("water", "aperture-1e-3", "D_0 = 1e-3 m", _water(interface={"residual_aperture": 1e-3})),
    Case("water", "transfer-1e-18", "T_w = 1e-18 m/(Pa s)", _water(interface={"transversal_conductivity": 1e-18}),
         hard=True),
    Case("water", "transfer-1e-10", "T_w = 1e-10 m/(Pa s)", _water(interface={"transversal_conductivity": 1e-10})),
    Case("water", "transfer-1e-3", "T_w = 1e-3 m/(Pa s)", _water(interface={"transversal_conductivity": 1e-3})),
    Case("water", "incompressible", "incompressible water, nu = 0.499",
         {"drainage": {"mode": "coupled", "water_bulk_modulus": "incompressible"}, "soil": {"poisson_ratio": 0.499}}),
    Case("water", "undrained", "undrained", {"drainage": {"mode": "undrained"}}),
    Case("water", "first-step-1e-9s", "first step 1e-9 s", _water(solver={"first_step_fraction": 2.5e-12})),
    Case("water", "first-step-1000s", "first step 1,000 s", _water(solver={"first_step_fraction": 0.05}),
         {"rate": 1e-6}),
    Case("water", "shallow-sea", "1 m/s in 1 m of water", {"drainage": {"mode": "coupled", "water_depth": 1.0}},
         {"rate": 1.0}),
    Case("shape", "L/D-0.1", "L/D 0.1", _caisson(0.78, 24.0, 12.0)),
    Case("shape", "L/D-1", "L/D 1", _caisson(7.8, 24.0, 20.0)),
    Case("shape", "L/D-3", "L/D 3", _caisson(23.4, 40.0, 50.0)),
    Case("shape", "skirt-5mm", "skirt 5 mm thick", {"caisson": {"skirt_thickness": 5e-3}}, hard=True),
    Case("shape", "skirt-0.5m", "skirt 0.5 m thick", {"caisson": {"skirt_thickness": 0.5}}),
    Case("shape", "tight-domain", "domain 4.8 m x 4.5 m", {"domain": {"radius": 4.8, "depth": 4.5}}),
    Case("shape", "needles", "8 cells around, domain of 200 m", {
        "domain": {"radius": 200.0, "depth": 12.0}, "mesh": {"azimuth": 8}}),
    Case("shape", "pancakes", "domain 5 m x 200 m", {"domain": {"radius": 5.0, "depth": 200.0}}),
    Case("path", "push-0.5m", "pull to 0.5 m", {}, {"lateral_displacement": 0.5}, hard=True),
    Case("path", "reversal", "20 mm, back to -20 mm", {}, {"then": ("-20 mm",), "role": "held-back"}),
    Case("path", "ten-cycles", "ten cycles of 5 mm", {},
         {"lateral_displacement": 5e-3, "then": _turns(10, 5.0), "role": "held-back"}, hard=True),
    Case("path", "ten-cycles-coupled", "ten cycles of 5 mm, 0.5 mm/s", _water(), {
        "lateral_displacement": 5e-3, "rate": 0.5e-3, "role": "held-back",
        "then": tuple(f"{part} at 0.5 mm/s" for part in _turns(10, 5.0))}),
    Case("path", "beyond-capacity", "load 20 MN at mudline", {}, {
        "kind": "load", "lateral_displacement": None, "lateral_force": 20e6}, hard=True),
    Case("path", "pull-out", "vertical load of -20 MN, upwards", {"caisson": {"vertical_load": -20e6}}),
    Case("path", "push-down", "vertical load of 200 MN", {"caisson": {"vertical_load": 200e6}}),
    Case("path", "high-arm", "load 1,000 m above mudline", {}, {"arm": 1000.0}),
    Case("path", "rotation", "rotation of 1 deg", {}, {
        "kind": "rotation", "lateral_displacement": None, "rotation": _DEG}),
    *GROUND_CASES,
)  # fmt: skip
