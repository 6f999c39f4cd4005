# SPDX-License-Identifier: MIT
"""The catalogue of stiff and extreme cases: the paper's caisson with a few values far from usual."""

from __future__ import annotations

import math
from typing import Any

from pysprings.studies.stability.case import Case
from pysprings.studies.stability.cases_ground import GROUND_CASES

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
        "kind": "rotation", "lateral_displacement": None, "rotation": -1 * _DEG}),
    *GROUND_CASES,
)  # fmt: skip
