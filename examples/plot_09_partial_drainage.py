# SPDX-License-Identifier: MIT
r"""
How fast the load comes
=======================

Partially drained sand: the same pull at two rates, between the drained and the undrained caisson. Suction under
the lid carries part of the load that is applied fast.

Water flows by Darcy's law, and the soil gives what it loses in volume (Biot 1941):

.. math:: \dot\varepsilon_v + \frac{n}{K_w}\dot p_w = \nabla\cdot\left(\frac{k}{\gamma_w}\nabla p_w\right)
"""

import matplotlib.pyplot as plt

import pysprings
from pysprings import plots

scene = pysprings.Scene(
    title="A pull in sand with water",
    soil={  # sand, in SI
        "young_modulus": 200e6,
        "friction_angle_initial": 0.0873,
        "friction_angle_final": 0.5236,
        "effective_unit_weight": 10.56e3,
        "surcharge": 10.56e3,
        "K0": 1.0,
        "hydraulic_conductivity": 1e-4,
    },
    drainage={"mode": "drained"},
    paths=({"name": "pull", "kind": "pull", "lateral_displacement": 2.5e-3, "arm": 5.0},),
    mesh={"preset": "coarse", "harmonics": 3},
    solver={"tolerance": 1e-3},
)

# %%
# Only the mode and the rate [m/s] differ. Undrained is a limit: no water flows in the soil, whatever the rate.
cases = {
    "drained": ("drained", None),
    "0.05 mm/s": ("coupled", 5e-5),
    "0.5 mm/s": ("coupled", 5e-4),
    "undrained": ("undrained", None),
}
figure, axes = plt.subplots(figsize=(6.0, 4.0), layout="constrained")
for label, (mode, rate) in cases.items():
    path = {"name": "pull", "kind": "pull", "lateral_displacement": 2.5e-3, "arm": 5.0, "rate": rate}
    wet = scene.replace(drainage={"mode": mode}, paths=(path,))
    pull = plots.path_data(pysprings.run(wet, estimate_error=False), "pull")
    axes.plot(1e3 * pull["u"], pull["H"] / 1e3, label=label)
    print(f"{label:10} H = {float(pull['H'][-1]) / 1e3:.0f} kN")
axes.set(xlabel="u of the lid centre [mm]", ylabel="lateral load H [kN]")
axes.grid(alpha=0.4)
axes.legend()
