# SPDX-License-Identifier: MIT
"""Error against CPU time of the sections of Fourier series, in sand and in clay (`python -m benchmarks.sections`).

The paths of the estimate of the template `caisson`, three paths of `soft-clay`, and a pull of 3 % of D in clay of
su = 5 kPa + 2 kPa/m z, on the presets and on those of commit b53de92: each section alone and extrapolated from it and
its coarser one, beside the extrapolated `fine`. Prints a line a run and writes data/evidence/sections.csv; half an
hour.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pandas as pd
import xarray as xr

from pysprings.full_model.accuracy import measures, own_estimate, two_mesh
from pysprings.full_model.accuracy.measures import curves_of, samples
from pysprings.full_model.compute import compute
from pysprings.model import fourier_mesh
from pysprings.model.fourier_mesh import SectionCounts, ground_of_sections
from pysprings.scene.load import parse_scene
from pysprings.scene.model import Scene
from pysprings.scene.template import template_text

FILE = Path(__file__).parents[1] / "data" / "evidence" / "sections.csv"
EARLIER = {
    "coarse": SectionCounts(plug=3, outer=5, tip=1, skirt=4, below=3, wall=0.08, mudline=0.25, toe=0.08, harmonics=3),
    "medium": SectionCounts(plug=4, outer=7, tip=1, skirt=5, below=5, wall=0.04, mudline=0.15, toe=0.04, harmonics=3),
    "paper": SectionCounts(plug=5, outer=10, tip=1, skirt=7, below=7, wall=0.04, mudline=0.15, toe=0.01, harmonics=3),
}
CLAY = """
[caisson]\nouter_diameter = "9 m"\nskirt_length = "6 m"\nskirt_thickness = "30 mm"
[soil]\nyield_surface = "tresca"\nundrained_shear_strength = { top = "5 kPa", gradient = "2 kPa/m" }
rigidity_ratio = 200\npoisson_ratio = 0.495\neffective_unit_weight = "6 kN/m^3"\nK0 = 1.0
[interface]\nadhesion_factor = 0.65\nopening = "bonded"\n[solver]\ntolerance = 1e-4
[[path]]\nname = "pull"\nkind = "pull"\nlateral_displacement = "0.27 m"\narm = "10 m"
"""


def scenes() -> dict[str, Scene]:
    """Return the scenes by name, without fields."""
    sand, clay = (parse_scene(template_text(name)) for name in ("caisson", "soft-clay"))
    some = tuple(path for path in clay.paths if path.name in ("ray_0", "ray_60", "check_10"))
    found = {"sand": two_mesh.few(sand), "soft-clay": clay.replace(paths=some), "clay D 9, L 6": parse_scene(CLAY)}
    output = {"interface_fields": False, "section": False, "figures": False}
    return {name: scene.replace(output=output) for name, scene in found.items()}


def run(scene: Scene) -> tuple[xr.DataTree, float]:
    """Return the result of a scene and its CPU seconds."""
    before = time.process_time()
    return compute(scene).tree, time.process_time() - before


def rows(name: str, scene: Scene) -> Iterator[dict[str, Any]]:
    """Yield a row a preset and path: unknowns, CPU seconds of both meshes, errors [%] alone and extrapolated."""
    ground, known = ground_of_sections(scene), {}
    for label, counts in [*fourier_mesh.PRESETS[ground].items(), *((f"{n}, b53de92", c) for n, c in EARLIER.items())]:
        fourier_mesh.PRESETS[ground]["coarse"], own = counts, fourier_mesh.PRESETS[ground]["coarse"]
        fine = scene.replace(mesh={"preset": "coarse"})
        try:
            (a, first), (b, second) = run(fine), run(two_mesh.coarser(fine))
        finally:
            fourier_mesh.PRESETS[ground]["coarse"] = own
        share = own_estimate.share_of(1.0 / two_mesh.FACTOR["fourier"], own_estimate.ORDERS[ground])
        known[label] = (a, own_estimate.extrapolated(a, b, share)[0], first, second)
        print(f"{name}, {label}: {a.attrs['n_unknowns']} unknowns, {first:.1f} + {second:.1f} s", flush=True)
    truth = curves_of(known["fine"][1])
    for label, (a, better, first, second) in known.items():
        alone = samples({"truth": truth, "alone": curves_of(a), "both": curves_of(better)})
        for path, each in alone.items():
            errors = [measures.errors(each[kind], each["truth"]) for kind in ("alone", "both")]
            columns = {
                f"{word}_{kind}_pct": found[key]
                for kind, found in zip(("alone", "extrapolated"), errors, strict=True)
                for word, key in (("load", "load_max"), ("py", "py_rms"), ("rotation", "rotation_max"))
            }
            head = {"scene": name, "section": label, "unknowns": int(a.attrs["n_unknowns"])}
            cost = {"cpu_s": round(first, 1), "cpu_coarser_s": round(second, 1), "path": path}
            yield head | cost | {key: round(value, 2) for key, value in columns.items()}


def main() -> None:
    """Run everything and write the table."""
    table = [row for name, scene in scenes().items() for row in rows(name, scene)]
    pd.DataFrame(table).to_csv(FILE, index=False)


if __name__ == "__main__":
    main()
