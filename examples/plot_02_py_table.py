# SPDX-License-Identifier: MIT
r"""
A p-y table for a colleague
===========================

p-y curves of one load path as a table: what a structural engineer asks for first. The table alone is not a
foundation: the last lines compute what share of the load it carries.

The table has :math:`p(y)` at each depth z, with

.. math:: y(z) = u - \theta z, \qquad H = \sum p\,\Delta z + H_\mathrm{tip} + H_\mathrm{lid}
"""

import tempfile
import warnings
from pathlib import Path

import pysprings
from pysprings import plots

scene = pysprings.Scene(
    title="p-y curves of a pull at one diameter",
    soil={  # sand, in SI
        "young_modulus": 200e6,
        "friction_angle_initial": 0.0873,
        "friction_angle_final": 0.5236,
        "effective_unit_weight": 10.56e3,
        "surcharge": 10.56e3,
        "K0": 1.0,
    },
    paths=({"name": "pull", "kind": "pull", "lateral_displacement": 5e-3, "arm": 7.8},),
    mesh={"preset": "coarse", "harmonics": 3},
    solver={"tolerance": 1e-3},
)
springs = pysprings.extract_springs(pysprings.run(scene, estimate_error=False))
pull = plots.path_data(springs, "pull")

# %%
# A row for each depth and recorded step. ``pysprings run`` writes the same curves, split by side and component,
# as ``py.csv``.
table = (
    pull[["y", "p"]]
    .to_dataframe()
    .reset_index()[["depth", "y", "p"]]
    .rename(columns={"depth": "depth_m", "y": "y_m", "p": "p_N_per_m"})
)
file = Path(tempfile.mkdtemp()) / "py.csv"
table.to_csv(file, index=False)
print(table.groupby("depth_m").last())

# %%
# The same motion answered by p-y springs alone, and by all springs of the path. p-y springs lack the shear on
# the skirt, the tip and the lid; the warning about this is silenced here.
with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    alone = pysprings.impose(springs, u=2e-3, arm=7.8, springs_kind="py")
whole = pysprings.impose(springs, u=2e-3, arm=7.8, springs_kind="full")
print(f"p-y springs alone carry {100 * float(alone['H'] / whole['H']):.0f} % of the load")

# %%
figure = plots.py_curves(pull)
