# SPDX-License-Identifier: MIT
r"""
Capacity in horizontal load and moment
======================================

The full model is pushed to failure in eight directions of H and M under the dead load: an envelope with nothing
fitted. The mesh of this example is far too coarse for the number; the way is that of a finer one.

A probe imposes the motion s, conjugate to a load Q of constant direction; the envelope has the largest Q:

.. math:: s = u\cos\alpha + D\theta\sin\alpha, \qquad H = Q\cos\alpha, \quad M = Q D\sin\alpha
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import pandas as pd

work = Path(tempfile.mkdtemp())
scene = """
title = "Bucket bonded to stiff clay"
caisson = { outer_diameter = "8 m", skirt_length = "4 m", skirt_thickness = "0.05 m", vertical_load = "2 MN" }
domain = { radius = "40 m", depth = "30 m" }
interface = { adhesion_factor = 1.0, opening = "bonded" }
mesh = { preset = "coarse", harmonics = 2, refinement = 0.6 }
solver = { tolerance = 1e-3 }

[soil]
yield_surface = "von-mises"
undrained_shear_strength = "50 kPa"
rigidity_ratio = 200
poisson_ratio = 0.49
effective_unit_weight = "8 kN/m^3"
surcharge = "0 kPa"
K0 = 1.0
"""
(work / "clay.toml").write_text(scene, encoding="utf-8")

# %%
command = ["capacity", "clay.toml", "--no-macro", "--directions", "8", "--out", "envelope"]
done = subprocess.run([sys.executable, "-m", "pysprings", *command], cwd=work, capture_output=True, text=True)
assert done.returncode == 0, done.stderr
print(done.stdout[: done.stdout.index("\n\n")])

# %%
# The picture that the command writes beside its tables:
table = pd.read_csv(next((work / "envelope").glob("*.csv")))
picture = next((work / "envelope").rglob("*.png"))
figure, axes = plt.subplots(figsize=(6.5, 5.5), layout="constrained")
axes.imshow(plt.imread(picture))
axes.axis("off")
