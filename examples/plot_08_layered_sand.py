# SPDX-License-Identifier: MIT
r"""
Loose sand over dense sand
==========================

Two layers whose stiffness follows the initial stress. Slices of the springs end at the boundary, where the
reaction jumps.

Young's modulus follows the initial mean effective stress:

.. math:: E = E_\mathrm{ref}\,(p' / \sigma_\mathrm{ref})^{n}, \qquad p' = (1 + 2 K_0)\,\sigma'_v / 3
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import pysprings
from pysprings import plots

text = """
title = "Push in two layers of sand"
caisson = { outer_diameter = "10 m", skirt_length = "8 m", skirt_thickness = "0.04 m" }
domain = { radius = "50 m", depth = "40 m" }
mesh = { preset = "coarse", harmonics = 3 }
solver = { tolerance = 1e-3 }

[soil]
K0 = 0.5
poisson_ratio = 0.25
friction_angle_initial = "auto"
surcharge = "5 kPa"

[[soil.layer]]
top = "0 m"
name = "loose sand"
friction_angle_final = "31 deg"
effective_unit_weight = "9 kN/m^3"
young_modulus = { reference = "60 MPa", reference_stress = "100 kPa", exponent = 0.5 }

[[soil.layer]]
top = "3 m"
name = "dense sand"
friction_angle_final = "38 deg"
dilation_angle = "8 deg"
effective_unit_weight = "10.5 kN/m^3"
young_modulus = { reference = "150 MPa", reference_stress = "100 kPa", exponent = 0.5 }

[[path]]
name = "push"
kind = "translation"
lateral_displacement = "20 mm"
"""
file = Path(tempfile.mkdtemp()) / "sand.toml"
file.write_text(text, encoding="utf-8")
scene = pysprings.load_scene(file)
loose, depth = scene.ground.strata[0], np.array([0.0, 2.0])
mean = (1.0 + 2.0 * 0.5) * (5e3 + 9e3 * depth) / 3.0  # p' from the surcharge and the weight above
assert np.allclose(loose.value("young_modulus", depth), 60e6 * (mean / 100e3) ** 0.5)
springs = pysprings.extract_springs(pysprings.run(scene, estimate_error=False))
push = plots.path_data(springs, "push")

# %%
p = push["p"]
top, bottom = push["depth_bounds"].values.T
assert np.any(np.isclose(bottom, 3.0))  # a slice ends at the boundary
figure, axes = plt.subplots(figsize=(5.0, 4.5), layout="constrained")
for u_mm in (2.0, 20.0):
    k = int(np.argmin(abs(1e3 * push["u"].values - u_mm)))
    steps = np.repeat(p.values[:-1, k] / 1e3, 2)  # without the slice at the tip, an edge effect of the mesh
    axes.plot(steps, np.column_stack([top, bottom])[:-1].ravel(), label=f"u = {1e3 * float(push['u'][k]):.0f} mm")
axes.axhline(3.0, color="0.5", linestyle="--")
axes.annotate("loose above, dense below", (0.98, 3.0), xycoords=("axes fraction", "data"), ha="right", va="bottom")
axes.set(xlabel="p [kN/m]", ylabel="depth [m]", ylim=(8.0, 0.0))
axes.grid(alpha=0.4)
axes.legend(loc="lower right")
