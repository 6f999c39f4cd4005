# SPDX-License-Identifier: MIT
"""What each value of the ground changes: pulls of one caisson in sand and in clay, one value changed at a time.

    python -m benchmarks.ground_values [--mesh coarse]

Prints a table: initial stiffness, load at 0.1 and 1 % of the diameter, each over that of the base. Series of three
harmonics, load one diameter above mudline.
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from pysprings import Scene
from pysprings.core.text import markdown_table
from pysprings.full_model.compute import compute

DIAMETER, LENGTH = 8.0, 6.0
YOUNG = {"reference": 120e6, "reference_stress": 100e3, "exponent": 0.5}
DEGREE = np.pi / 180.0
SAND: dict[str, Any] = {
    "K0": 0.5, "friction_angle_initial": "auto", "friction_angle_final": 36 * DEGREE, "dilation_angle": 6 * DEGREE,
    "poisson_ratio": 0.25, "effective_unit_weight": 10e3, "surcharge": 5e3, "young_modulus": YOUNG,
}  # fmt: skip
CLAY: dict[str, Any] = {
    "law": "von-mises", "undrained_shear_strength": {"top": 10e3, "gradient": 2e3}, "rigidity_ratio": 300.0,
    "effective_unit_weight": 7e3, "K0": 0.8,
}  # fmt: skip
CONTACT: dict[str, Any] = {
    "adhesion_factor": 0.65, "opening": {"outside": "vented", "inside": "sealed", "lid": "sealed", "tip": "sealed"},
}  # fmt: skip
SAND_CHANGES: dict[str, dict[str, Any]] = {
    "E 30 % higher": {"young_modulus": YOUNG | {"reference": 156e6}},
    'follows = "stress"': {"young_modulus": YOUNG | {"follows": "stress"}},
    "degradation_strain 4e-4": {"degradation_strain": 4e-4},
    "degradation_strain 2e-4": {"degradation_strain": 2e-4},
    "final friction angle 33 deg": {"friction_angle_final": 33 * DEGREE},
    "dilation angle 0": {"dilation_angle": 0.0},
    "hardening parameter twice": {"hardening_parameter": 0.01},
    "K0 0.8": {"K0": 0.8},
    "unit weight 9 kN/m3": {"effective_unit_weight": 9e3},
    "friction of the wall 0.35": {"interface": {"friction_coefficient": 0.35}},
}
CLAY_CHANGES: dict[str, dict[str, Any]] = {
    "su 20 % lower (G with it)": {"undrained_shear_strength": {"top": 8e3, "gradient": 1.6e3}},
    "G/su 600": {"rigidity_ratio": 600.0},
    "half of su at 1 %": {"strain_at_half_strength": 0.01},
    "plasticity index 30, OCR 1.5, half of su at 1 %": {
        "rigidity_ratio": None, "plasticity_index": 30.0, "overconsolidation_ratio": 1.5,
        "strain_at_half_strength": 0.01,
    },
    "Tresca": {"law": "tresca"},
    "su by direction 1.3, 1, 0.7": {"compression_factor": 1.3, "extension_factor": 0.7},
    "su by direction 1, 1, 0.6": {"compression_factor": 1.0, "extension_factor": 0.6},
    "adhesion 0.4": {"interface": CONTACT | {"adhesion_factor": 0.4}},
    "wall outside sealed": {"interface": CONTACT | {"opening": "sealed"}},
    "unit weight 6 kN/m3": {"effective_unit_weight": 6e3},
}  # fmt: skip


def pull(layer: dict[str, Any], interface: dict[str, Any], mesh: str) -> tuple[float, float, float]:
    """Return the initial stiffness (N/m) and the loads (N) at 0.1 and 1 % of the diameter."""
    layer = {key: value for key, value in layer.items() if value is not None}
    surcharge = layer.pop("surcharge", 0.0)
    soil = {"surcharge": surcharge, "layers": [{"top": 0.0, **layer}]}
    path = {
        "name": "pull", "kind": "pull", "lateral_displacement": 0.01 * DIAMETER, "arm": DIAMETER,
        "report_at": [0.001 * DIAMETER],
    }  # fmt: skip
    scene = Scene(
        caisson={"outer_diameter": DIAMETER, "skirt_length": LENGTH, "skirt_thickness": 0.03, "vertical_load": 3e6},
        domain={"radius": 48.0, "depth": 36.0}, soil=soil, interface=interface, paths=[path],
        mesh={"preset": mesh, "discretisation": "fourier", "harmonics": 3}, solver={"tolerance": 1e-4},
        output={"figures": False, "interface_fields": False, "section": False},
    )  # fmt: skip
    result = compute(scene)
    path_rows = result.tree["paths/pull"]
    u, load = path_rows["u"].values, path_rows["H"].values
    k = np.linalg.inv(result.recorded()["stiffness_initial"].values)
    compliance = k[0, 0] - k[0, 2] * DIAMETER  # u of H at a height of one diameter: M = -H arm
    ends = np.interp([0.001 * DIAMETER, 0.01 * DIAMETER], u, load, right=np.nan)
    return 1.0 / float(compliance), float(ends[0]), float(ends[1])


def table(base: dict[str, Any], contact: dict[str, Any], changes: dict[str, dict[str, Any]], mesh: str) -> str:
    """Return the table of one soil."""
    rows, first = [], None
    for name, change in {"base": {}, **changes}.items():
        change = dict(change)
        interface = change.pop("interface", contact)
        values = pull(base | change, interface, mesh)
        first = first or values
        units = (f"{values[0] / 1e6:.0f} MN/m", f"{values[1] / 1e6:.3f} MN", f"{values[2] / 1e6:.2f} MN")
        shares = tuple(f"{100 * (each / own - 1):+.1f} %" for each, own in zip(values, first, strict=True))
        rows.append((name, *(units if name == "base" else shares)))
        print(rows[-1], flush=True)
    return markdown_table(("change", "initial stiffness H/u", "H at 0.1 % D", "H at 1 % D"), rows)


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser("python -m benchmarks.ground_values", description=__doc__.splitlines()[0])
    parser.add_argument("--mesh", default="coarse")
    mesh = parser.parse_args().mesh
    print(table(CLAY, CONTACT, CLAY_CHANGES, mesh))
    print(table(SAND, {"friction_coefficient": 0.5}, SAND_CHANGES, mesh))


if __name__ == "__main__":
    main()
