# SPDX-License-Identifier: MIT
r"""
Hand-over to OpenSees and OpenFAST
==================================

The springs of a fan as files for other programs. The head of each file has the frame, the range of validity and
the measured error of what the format cannot hold.

A linear foundation of another program has the stiffness of the caisson about one point,

.. math:: (H, M)^T = K\,(u, \theta)^T, \qquad K = \partial(H, M)/\partial(u, \theta)
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt

import pysprings as springs_program

work = Path(tempfile.mkdtemp())
scene = """
title = "A fan to hand on"
springs = { reach = "10 mm", held_back = false }
mesh = { preset = "coarse", harmonics = 3, refinement = 0.7 }
solver = { tolerance = 1e-3 }
output = { figures = false }

[soil]
young_modulus = "200 MPa"
friction_angle_initial = "5 deg"
friction_angle_final = "30 deg"
effective_unit_weight = "10.56 kN/m^3"
surcharge = "10.56 kPa"
K0 = 1.0

[[path]]
name = "check"
kind = "pull"
lateral_displacement = "5 mm"
arm = "7.8 m"
role = "held-back"
"""
(work / "fan.toml").write_text(scene, encoding="utf-8")


def pysprings(*words):
    """Run the command; return what it prints."""
    done = subprocess.run([sys.executable, "-m", "pysprings", *words], cwd=work, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


pysprings("run", "fan.toml", "--out", "fan", "--no-estimate-error")
print(pysprings("export", "fan", "--to", "opensees", "--out", "opensees"))

# %%
# ``pysprings soildyn openfast`` then builds the library that OpenFAST loads, where a C compiler is there.
options = ("--option", "z=-30 m")
pysprings("export", "fan", "--to", "openfast", "--out", "openfast", *options)
print(*sorted(file.name for folder in ("opensees", "openfast") for file in (work / folder).iterdir()), sep="\n")

# %%
# What is handed on: the load over the motion at one diameter above mudline.
curve = springs_program.curve(springs_program.open_springs(work / "fan" / "springs.nc"), u_max=6e-3, arm=7.8)
figure, axes = plt.subplots(layout="constrained")
axes.plot(1e3 * curve["u"], curve["H"] / 1e3)
axes.set(xlabel="u of the lid centre [mm]", ylabel="lateral load H at 7.8 m [kN]")
axes.grid(alpha=0.4)
