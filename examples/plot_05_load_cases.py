# SPDX-License-Identifier: MIT
r"""
Ten load cases of a monobucket in clay
======================================

A bucket in soft clay, a fan of load paths, and ten load cases with a tolerance on the tilt. A case is answered,
answered with a mark, or refused with the reason.

Each case is an equilibrium of the springs; its utilisation is beside the largest load in its direction:

.. math:: Q = \sqrt{H^2 + (M/L)^2}, \qquad \text{utilisation} = Q / Q_\max(H : M/L)
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import pandas as pd

work = Path(tempfile.mkdtemp())
scene = """
title = "Bucket in soft clay"
caisson = { outer_diameter = "8 m", skirt_length = "6 m", skirt_thickness = "0.03 m", vertical_load = "2 MN" }
domain = { radius = "48 m", depth = "36 m" }
drainage = { water_depth = "20 m" }
mesh = { preset = "coarse", harmonics = 3, refinement = 0.7 }
solver = { tolerance = 1e-3 }
output = { figures = false }
springs = { reach = "150 mm", held_back = false }

[soil]
yield_surface = "tresca"
undrained_shear_strength = { top = "5 kPa", gradient = "2 kPa/m" }
rigidity_ratio = 200
poisson_ratio = 0.495
effective_unit_weight = "6 kN/m^3"
surcharge = "0 kPa"
K0 = 1.0

[interface]
adhesion_factor = 0.65
opening = { outside = "vented", inside = "sealed", lid = "sealed", tip = "sealed" }
"""
(work / "clay.toml").write_text(scene, encoding="utf-8")

# %%
# The cases: H grows, at 20 m above mudline. Each has a tolerance of 0.25 degrees.
rows = [f"case {k},ULS,{H},20,0.25" for k, H in enumerate((20, 40, 80, 120, 160, 200, 250, 300, 350, 400), 1)]
cases = "case,limit state,H [kN],arm [m],tilt [deg]\n" + "\n".join(rows)
(work / "cases.csv").write_text(cases, encoding="utf-8")


def pysprings(*words):
    """Run the command; return what it prints."""
    done = subprocess.run([sys.executable, "-m", "pysprings", *words], cwd=work, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


pysprings("run", "clay.toml", "--out", "clay", "--no-estimate-error")
print(pysprings("design", "clay", "cases.csv", "--out", "answers.csv"))

# %%
answers = pd.read_csv(work / "answers.csv")
figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
left.plot(answers["tilt_deg"], answers["H_N"] / 1e3, "o-")
left.axvline(0.25, color="tab:red", linestyle="--", label="tolerance 0.25 deg")
left.set(xlabel="tilt [deg]", ylabel="H at 20 m [kN]")
left.legend()
right.barh(answers["name"], answers["utilisation"])
right.set(xlabel="load over the largest known one", xlim=(0.0, 1.0))
right.invert_yaxis()
for axes in (left, right):
    axes.grid(alpha=0.4)
