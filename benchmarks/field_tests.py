# SPDX-License-Identifier: MIT
"""Two tests that others measured, beside the model at both ends of plausible ranges of the ground.

    python -m benchmarks.field_tests [--mesh medium] [--out FILE]

Bothkennar (Houlsby et al. 2005): D 3 m, L 1.5 m, clay of su = 15 + 1.9 z kPa. The rotational stiffness is the initial
one under a couple with free translation; the capacity is V at a settlement of a tenth of the diameter.

A monopod in silty sand at 70 g (Kim et al. 2014), at the scale of the prototype: D 15.5 m, L 8 m, load 33 m above
mudline. The yield moment is where the initial tangent of M over rotation meets the tangent at 3 degrees. Prints CSV.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pysprings import Scene
from pysprings.full_model.compute import compute

HEAD = ("test", "quantity", "measured", "low", "high", "bracketed")
DEGREE = np.pi / 180.0
# (factor on su, G/su, adhesion factor): su of direct shear over that of compression; E_u/su 200 to 1000
CLAY_ENDS = (0.75, 67.0, 0.3), (1.0, 333.0, 0.65)
# (final friction and dilation angle in degrees, E at 100 kPa, friction of the wall, vertical load). Bolton (1986):
# phi = 31 + 3 (I_D (10 - ln p') - 1), at relative densities of 0.4 and 0.8 and p' = 75 kPa; psi = phi - 30
SAND_ENDS = (35.0, 5.0, 25e6, 0.35, 5e6), (42.0, 12.0, 60e6, 0.5, 12e6)
ROTATION, ARM = 3.0 * DEGREE, 33.0


def _run(mesh: str, path: dict[str, Any], harmonics: int, **sections: Any) -> Any:
    scene = Scene(
        **sections, paths=[path], mesh={"preset": mesh, "discretisation": "fourier", "harmonics": harmonics},
        output={"figures": False, "interface_fields": False, "section": False},
    )  # fmt: skip
    return compute(scene)


def bothkennar(factor: float, rigidity: float, adhesion: float, mesh: str) -> tuple[float, float]:
    """Return the rotational stiffness in MN m/rad and the vertical capacity in kN."""
    result = _run(
        mesh, {"name": "down", "kind": "vertical", "vertical_displacement": 0.3}, 1,
        caisson={"outer_diameter": 3.0, "skirt_length": 1.5, "skirt_thickness": 0.008, "vertical_load": 50e3},
        domain={"radius": 18.0, "depth": 12.0},
        soil={
            "yield_surface": "tresca", "rigidity_ratio": rigidity, "effective_unit_weight": 6e3, "surcharge": 0.0,
            "undrained_shear_strength": {"top": factor * 15e3, "gradient": factor * 1.9e3},
        },
        interface={"adhesion_factor": adhesion, "opening": {
            "outside": "vented", "inside": "sealed", "lid": "sealed", "tip": "sealed"}},
        solver={"tolerance": 1e-4},
    )  # fmt: skip
    compliance = np.linalg.inv(result.recorded()["stiffness_initial"].values)
    return 1e-6 / float(compliance[2, 2]), 1e-3 * float(result.tree["paths/down"]["V"].values[-1])


def monopod(friction: float, dilation: float, young: float, wall: float, load: float, mesh: str) -> float:
    """Return the yield moment in MN m."""
    result = _run(
        mesh, {"name": "pull", "kind": "pull", "arm": ARM, "lateral_displacement": 0.45}, 3,
        caisson={"outer_diameter": 15.5, "skirt_length": 8.0, "skirt_thickness": 0.04, "vertical_load": load},
        domain={"radius": 93.0, "depth": 60.0},
        soil={"surcharge": 5e3, "layers": [{
            "top": 0.0, "K0": round(1.0 - np.sin(friction * DEGREE), 2), "friction_angle_initial": "auto",
            "friction_angle_final": friction * DEGREE, "dilation_angle": dilation * DEGREE, "poisson_ratio": 0.25,
            "effective_unit_weight": 9e3,
            "young_modulus": {"reference": young, "reference_stress": 100e3, "exponent": 0.5}}]},
        interface={"friction_coefficient": wall}, solver={"tolerance": 1e-4, "viscous_displacement": 15.5e-8},
    )  # fmt: skip
    path = result.tree["paths/pull"]
    moment, turned = np.abs(path["M"].values), np.abs(path["rotation"].values)
    return yield_moment(turned, moment)


def yield_moment(turned: np.ndarray, moment: np.ndarray) -> float:
    """Return where the first tangent meets that of the last half degree before ROTATION, in MN m.

    Raises
    ------
    ValueError
        The path ends before ROTATION.
    """
    if turned[-1] < ROTATION:
        raise ValueError(f"the path ends at {turned[-1] / DEGREE:.2f} deg")
    first = int(np.argmax(turned > 0.0))
    start = moment[first] / turned[first]
    back = ROTATION - 0.5 * DEGREE
    low, high = np.interp([back, ROTATION], turned, moment)
    slope = (high - low) / (ROTATION - back)
    return 1e-6 * float(start * (high - slope * ROTATION) / (start - slope))


def rows(mesh: str) -> list[tuple[str, ...]]:
    """Return a row a quantity."""
    clay = [bothkennar(*end, mesh) for end in CLAY_ENDS]
    sand = [(monopod(*end, mesh),) for end in SAND_ENDS]
    found = (
        ("Bothkennar", "rotational stiffness [MN m/rad]", 225.0, [each[0] for each in clay]),
        ("Bothkennar", "vertical capacity [kN]", 746.0, [each[1] for each in clay]),
        ("monopod at 70 g", "yield moment [MN m]", 198.0, [each[0] for each in sand]),
    )
    return [
        (
            test,
            what,
            f"{measured:g}",
            *(f"{each:.4g}" for each in ends),
            "yes" if ends[0] <= measured <= ends[1] else "no",
        )
        for test, what, measured, ends in found
    ]


def main(arguments: Sequence[str] | None = None) -> None:
    """Read the options, print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--mesh", default="medium")
    parser.add_argument("--out", type=Path)
    given = parser.parse_args(arguments)
    table = [HEAD, *rows(given.mesh)]
    csv.writer(sys.stdout, lineterminator="\n").writerows(table)
    if given.out:
        with given.out.open("w", newline="", encoding="utf-8") as stream:
            csv.writer(stream, lineterminator="\n").writerows(table)


if __name__ == "__main__":
    main()
