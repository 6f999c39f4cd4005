# SPDX-License-Identifier: MIT
"""What decides the effect of partial drainage: one setting changed at a time, to 20 mm.

    python -m benchmarks.partial_drainage [--mesh coarse] [--markdown]

The paper's caisson, pulled at the lid centre; each row is a run. H over the drained run's at the same displacement, the
water force under the lid, the lowest excess pressures inside and outside the skirt, the lowest effective stress at the
back outside at 3.25 m over its initial value, and the widest gap of the skirt outside.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np
import xarray as xr

from pysprings import Scene
from pysprings.full_model.compute import compute
from pysprings.scene.extent import PAPER

END, STOPS = 20e-3, (2.5e-3, 5e-3, 10e-3)
DEGREE = np.pi / 180.0
# name -> (rate in mm/s, sections that differ from the paper's scene)
VARIANTS: dict[str, tuple[float, dict]] = {
    "0.05 mm/s": (0.05, {}),
    "0.5 mm/s": (0.5, {}),
    "5 mm/s": (5.0, {}),
    "k 1e-5 m/s": (0.05, {"soil": {"hydraulic_conductivity": 1e-5}}),
    "k 1e-3 m/s": (0.05, {"soil": {"hydraulic_conductivity": 1e-3}}),
    "T_w 1e-10 m/(Pa s)": (0.05, {"interface": {"transversal_conductivity": 1e-10}}),
    "T_w 1e-6 m/(Pa s)": (0.05, {"interface": {"transversal_conductivity": 1e-6}}),
    "D_0 0.001 mm": (0.05, {"interface": {"residual_aperture": 1e-6}}),
    "D_0 0.1 mm": (0.05, {"interface": {"residual_aperture": 1e-4}}),
    "dilation 5 deg": (0.05, {"soil": {"dilation_angle": 5.0 * DEGREE}}),
    "incompressible water": (0.05, {"drainage": {"water_bulk_modulus": "incompressible"}}),
    "side drained": (0.05, {"domain": {"side_drainage": "drained"}}),
    "mu 0": (0.05, {"interface": {"friction_coefficient": 0.0}}),
}
DRAINED_TOO = ("dilation 5 deg", "mu 0")  # what these change, it changes without water too
HEADINGS = ("variant", "H/drained 2.5 mm", "5 mm", "10 mm", "20 mm", "F_pw [kN]", "p inside [kPa]", "p outside [kPa]",
            "back p'/initial", "gap [mm]")  # fmt: skip


def run(preset: str, mode: str, rate: float, sections: dict) -> xr.DataTree:
    """Run one variant; rate in mm/s."""
    path = {"name": "pull", "kind": "pull", "lateral_displacement": END, "rate": 1e-3 * rate, "report_at": STOPS}
    drainage = {"mode": mode, **sections.get("drainage", {})}
    rest = {name: value for name, value in sections.items() if name != "drainage"}
    return compute(
        Scene(
            domain=PAPER,
            mesh={"preset": preset, "discretisation": "hex8"},
            drainage=drainage,
            paths=[path],
            output={"figures": False},
            **rest,
        )
    ).recorded()


def row(name: str, path: xr.Dataset, drained: xr.Dataset) -> tuple[str, ...]:
    """Return the figures of a run beside its drained one."""
    reached = float(path["u"][-1])
    ratios = [np.interp(u, path["u"], path["H"]) / np.interp(u, drained["u"], drained["H"]) for u in (*STOPS, END)]
    ratios = [ratio if u < 1.001 * reached else np.nan for u, ratio in zip((*STOPS, END), ratios, strict=True)]
    pressure = path["pore_pressure"].min(["azimuth", "depth", "step"]) / 1e3
    back = path["normal_effective_stress"].sel(side="outside").isel(azimuth=-1)
    back = back.isel(depth=int(np.argmin(np.abs(path["depth"].values - 3.25))))
    gap = 1e3 * float(path["gap"].sel(side="outside").max())
    cells = [f"{ratio:.4f}" for ratio in ratios] + [f"{float(path['F_pw'][-1]) / 1e3:.1f}"]
    cells += [f"{float(pressure.sel(side=side)):.3f}" for side in ("inside", "outside")]
    end = "" if reached > 0.999 * END else f" (stopped at {1e3 * reached:.1f} mm)"
    return (name + end, *cells, f"{float(back.min() / back[0]):.2f}", f"{gap:.3f}")


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the variants and print their rows as they end."""
    parser = argparse.ArgumentParser("python -m benchmarks.partial_drainage", description=__doc__.split("\n")[0])
    parser.add_argument("--mesh", default="coarse", choices=("coarse", "medium", "paper"))
    parser.add_argument("--markdown", action="store_true")
    options = parser.parse_args(arguments)
    line = "| {} |" if options.markdown else "{}"
    between = " | " if options.markdown else "  "
    print(line.format(between.join(HEADINGS)))
    drained: dict[str, xr.DataTree] = {}
    for name, (rate, sections) in VARIANTS.items():
        key = name if name in DRAINED_TOO else ""
        if key not in drained:
            drained[key] = run(options.mesh, "drained", rate, sections if key else {})
        wet = run(options.mesh, "coupled", rate, sections)
        paths = (tree["paths/pull"].to_dataset() for tree in (wet, drained[key]))
        print(line.format(between.join(row(name, *paths))), flush=True)


if __name__ == "__main__":
    main()
