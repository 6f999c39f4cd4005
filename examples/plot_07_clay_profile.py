# SPDX-License-Identifier: MIT
r"""
Clay whose strength grows with depth
====================================

Undrained clay in total stress, su = 10 kPa + 2 kPa/m z. The lateral reaction over su D by depth shows where the
skirt has reached what the clay can carry: values of 9 to 12 are those of flow around a pile, values near
mudline are lower.

The bearing factor of a depth is

.. math:: N_p(z) = p(z) / (s_u(z)\,D), \qquad s_u = 10 + 2 z \;\text{kPa}
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import pysprings
from pysprings import plots

text = """
title = "Translation in clay"
caisson = { outer_diameter = "6 m", skirt_length = "6 m", skirt_thickness = "0.04 m", vertical_load = "1 MN" }
domain = { radius = "40 m", depth = "30 m" }
drainage = { water_depth = "30 m" }
mesh = { preset = "coarse", harmonics = 3 }
solver = { tolerance = 1e-3 }

[soil]
yield_surface = "tresca"
undrained_shear_strength = { top = "10 kPa", gradient = "2 kPa/m" }
rigidity_ratio = 200
poisson_ratio = 0.495
effective_unit_weight = "6 kN/m^3"
surcharge = "0 kPa"
K0 = 1.0

[interface]
adhesion_factor = 0.65
opening = { outside = "vented", inside = "sealed", lid = "sealed", tip = "sealed" }

[[path]]
name = "push"
kind = "translation"
lateral_displacement = "300 mm"
"""
file = Path(tempfile.mkdtemp()) / "clay.toml"
file.write_text(text, encoding="utf-8")
scene = pysprings.load_scene(file)
springs = pysprings.extract_springs(pysprings.run(scene, estimate_error=False))
push = plots.path_data(springs, "push")

# %%
# Slices that end at the tip carry an edge effect of the mesh and are left out of the picture.
p = push["p"]
z = push["depth"].values
factor = p.values / (6.0 * (10e3 + 2e3 * z))[:, None]
skirt = z < 5.0
print(f"p/(su D) at the end, from mudline down: {np.round(factor[skirt, -1], 1)}")

figure, axes = plt.subplots(figsize=(5.0, 4.5), layout="constrained")
u = push["u"].values
for u_mm in (5.0, 30.0, 100.0, 300.0):
    k = int(np.argmin(abs(1e3 * u - u_mm)))
    axes.plot(factor[skirt, k], z[skirt], "o-", label=f"u = {1e3 * u[k]:.0f} mm")
axes.set(xlabel="p / (su D)", ylabel="depth [m]", ylim=(6.0, 0.0))
axes.grid(alpha=0.4)
axes.legend()
