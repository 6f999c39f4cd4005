# SPDX-License-Identifier: MIT
r"""
A caisson in one minute
=======================

The caisson of the paper in drained sand is pulled at 5 m above mudline. The picture shows which part of the
caisson carries the load.

The load is the sum of the reactions of skirt, tip and lid:

.. math:: H = \sum p\,\Delta z + H_\mathrm{tip} + H_\mathrm{lid}
"""

import pysprings
from pysprings import plots

# %%
# A scene needs a path; everything else has a default. Numbers in Python are in SI units.
scene = pysprings.Scene(
    title="A pull at 5 m above mudline",
    soil={  # sand, in SI
        "young_modulus": 200e6,
        "friction_angle_initial": 0.0873,
        "friction_angle_final": 0.5236,
        "effective_unit_weight": 10.56e3,
        "surcharge": 10.56e3,
        "K0": 1.0,
    },
    paths=({"name": "pull", "kind": "pull", "lateral_displacement": 2.5e-3, "arm": 5.0},),
    mesh={"preset": "coarse", "harmonics": 3},
    solver={"tolerance": 1e-3},
)

# %%
# ``run`` computes the full model. Here it leaves out the estimate of its own error, which takes two further
# runs.
result = pysprings.run(scene, estimate_error=False)
pull = plots.path_data(result, "pull")
print(f"H = {float(pull['H'][-1]) / 1e6:.3f} MN at u = {1e3 * float(pull['u'][-1]):.2f} mm")

# %%
# The parts sum to the load: outer and inner face of the skirt, lid and tip.
figure = plots.load_displacement(pull)
