# SPDX-License-Identifier: MIT
"""Extreme cases of the ground: layers far apart, undrained clay, sand over clay."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pysprings.studies.stability.case import Case

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
