# SPDX-License-Identifier: MIT
r"""
Cycles: springs with memory
===========================

Springs of a fan go back on the curve that they came on. Three rays that turn back calibrate springs that
remember. A pull that was held back and reverses shows both beside the full model.

Springs with memory are elements with a stiffness and a limit each, whose loads sum:

.. math:: (H, M) = \sum_i f_i, \qquad \dot f_i = k_i\,\dot q \;\text{ while }\; \phi_i(f_i) < 1
"""

import subprocess
import sys
import tempfile
from pathlib import Path

from pysprings import open_springs

work = Path(tempfile.mkdtemp())
scene = """
title = "A pull that reverses"
springs = { reach = "8 mm", memory = true, held_back = false }
mesh = { preset = "coarse", harmonics = 3, refinement = 0.7 }
solver = { tolerance = 1e-3 }
domain = { radius = "40 m", depth = "30 m" }

[soil]
young_modulus = "200 MPa"
poisson_ratio = 0.3
friction_angle_initial = "5 deg"
friction_angle_final = "30 deg"
hardening_parameter = 0.005
effective_unit_weight = "10.56 kN/m^3"
surcharge = "10.56 kPa"
K0 = 1.0
cohesion = "2 kPa"

[[path]]
name = "turns"
kind = "pull"
lateral_displacement = "3 mm"
arm = "7.8 m"
role = "held-back"
then = ["-2 mm", "2 mm"]
"""
(work / "turns.toml").write_text(scene, encoding="utf-8")


def pysprings(*words):
    """Run the command; return what it prints."""
    done = subprocess.run([sys.executable, "-m", "pysprings", *words], cwd=work, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


pysprings("run", "turns.toml", "--out", "turns", "--no-estimate-error", "--figures", "none")
errors = pysprings("compare", "turns", "--cycles")
print(errors[: errors.index("\n\n")])

# %%
# Loops of the full model, of the fan and of the springs with memory.
figure = open_springs(work / "turns" / "springs.nc").pysprings.plot.loops("turns")
