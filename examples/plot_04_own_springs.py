# SPDX-License-Identifier: MIT
r"""
Springs of your own
===================

p-y curves of another source, in a table with units in its headings, answer a load without any finite-element
run.

Equilibrium of the rigid body on p-y springs alone, for a load H at height h:

.. math:: H = \sum p(u - \theta z)\,\Delta z, \qquad H h = -\sum p(u - \theta z)\,z\,\Delta z
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt

import pysprings

table = """depth_m,y [mm],p [kN/m]
0.5,1,200
0.5,10,400
2.0,1,300
2.0,10,700
3.5,1,350
3.5,10,900
"""
file = Path(tempfile.mkdtemp()) / "curves.csv"
file.write_text(table, encoding="utf-8")

# %%
# Such a table has no base shear and no moments: the answer is that of p-y springs alone.
springs = pysprings.open_table(file, skirt_length=4.0)
curve = pysprings.curve(springs, u_max=8e-3, arm=2.0)
print(f"{float(curve['H'][-1]) / 1e3:.0f} kN at u = 8 mm")

# %%
figure, axes = plt.subplots(layout="constrained")
axes.plot(1e3 * curve["u"], curve["H"] / 1e3)
axes.set(xlabel="u of the lid centre [mm]", ylabel="lateral load H at 2 m [kN]", title="p-y springs of a table")
axes.grid(alpha=0.4)
