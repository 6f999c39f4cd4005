# SPDX-License-Identifier: MIT
r"""
Error against mesh
==================

The same pull on sections that are refined evenly. A coarse mesh carries too much; the difference between two
meshes bounds what is left.

The error falls with a power of the size h of the elements:

.. math:: H(h) = H_0 + C h^q, \qquad H_0 \approx H_1 + \frac{H_1 - H_2}{(h_2/h_1)^q - 1}
"""

import time

import matplotlib.pyplot as plt

import pysprings
from pysprings import plots

loads, nodes, seconds = [], [], []
for refinement in (0.5, 0.7, 1.0, 1.4, 2.0):
    scene = pysprings.Scene(
        title=f"refinement {refinement}",
        soil={  # sand, in SI
            "young_modulus": 200e6,
            "friction_angle_initial": 0.0873,
            "friction_angle_final": 0.5236,
            "effective_unit_weight": 10.56e3,
            "surcharge": 10.56e3,
            "K0": 1.0,
        },
        paths=({"name": "pull", "kind": "pull", "lateral_displacement": 2.5e-3, "arm": 5.0},),
        mesh={"preset": "coarse", "harmonics": 3, "refinement": refinement},
        solver={"tolerance": 1e-3},
    )
    start = time.perf_counter()
    result = pysprings.run(scene, estimate_error=False)
    seconds.append(time.perf_counter() - start)
    pull = plots.path_data(result, "pull")
    loads.append(float(pull["H"][-1]))
    nodes.append(int(pull.attrs["n_nodes"]))

for n, load, spent in zip(nodes, loads, seconds, strict=True):
    error = 100 * (load / loads[-1] - 1)
    print(f"{n:6} nodes  H = {load / 1e3:7.1f} kN  {error:+5.2f} % beside the finest  {spent:5.1f} s")

# %%
figure, axes = plt.subplots(figsize=(5.5, 4.0), layout="constrained")
axes.semilogx(nodes, [100 * (load / loads[-1] - 1) for load in loads], "o-")
axes.set(xlabel="nodes of the section", ylabel="load over that of the finest mesh, minus 1 [%]")
axes.grid(alpha=0.4, which="both")
