# SPDX-License-Identifier: MIT
r"""
A fan of load paths, and a prediction
=====================================

Springs of one path hold on that path. A fan of paths holds between them. A pull that was held back measures how
well.

Reactions are functions of the motion (u, rotation), in polar coordinates with the skirt length L:

.. math:: \rho = \sqrt{u^2 + (\theta L)^2}, \quad \varphi = \operatorname{atan2}(\theta L, u), \qquad
          p(z) = p(\rho, \varphi; z)
"""

import matplotlib.pyplot as plt

import pysprings
from pysprings import plots

scene = pysprings.Scene(
    title="A fan to 10 mm",
    soil={  # sand, in SI
        "young_modulus": 200e6,
        "friction_angle_initial": 0.0873,
        "friction_angle_final": 0.5236,
        "effective_unit_weight": 10.56e3,
        "surcharge": 10.56e3,
        "K0": 1.0,
    },
    springs={"reach": 10e-3, "held_back": False},
    paths=({"name": "pull", "kind": "pull", "lateral_displacement": 5e-3, "arm": 7.8, "role": "held-back"},),
    mesh={"preset": "coarse", "harmonics": 3},
    solver={"tolerance": 1e-3},
)
springs = pysprings.extract_springs(pysprings.run(scene, estimate_error=False))

# %%
# Held-back paths measure a prediction; calibration paths only how well the springs give back their own data.
table = pysprings.compare(springs)
held_back = table[(table["path"] == "pull") & (table["springs"] == "fan")].iloc[0]
print(f"largest error in load {held_back['H_error_max_pct']:.2f} %")

# %%
# One load, one answer, with the share of the largest known load in its direction. Beyond the range there is no
# answer.
answer = pysprings.predict(springs, H=4.0e5, arm=7.8)
print(f"u = {1e3 * float(answer['u']):.2f} mm, rotation = {1e3 * float(answer['rotation']):.3f} mrad")
print(f"utilisation {float(answer['utilisation']):.2f} ({answer.attrs['capacity_kind']})")
try:
    pysprings.predict(springs, H=2.0e6, arm=7.8)
except pysprings.errors.BeyondSprings as refusal:
    print(f"refused: {str(refusal)[:120]} ...")

# %%
full = plots.path_data(springs, "pull")
fan = pysprings.curve(springs, u_max=float(full["u"][-1]), arm=7.8)
figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
for axes, name, scale, label in ((left, "H", 1e-3, "load H [kN]"), (right, "rotation", 1e3, "rotation [mrad]")):
    axes.plot(1e3 * full["u"], scale * full[name], "k.-", label="full model, held back")
    axes.plot(1e3 * fan["u"], scale * fan[name], "--", label="springs of the fan")
    axes.set(xlabel="u of the lid centre [mm]", ylabel=label)
    axes.grid(alpha=0.4)
left.legend()
