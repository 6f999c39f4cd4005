# SPDX-License-Identifier: MIT
"""Frictional surfaces of sand, one line each: laws on their own, and those whose stiffness may change (`following`).

The first two packed parameters of each are the bulk and the shear modulus, to which its answer is homogeneous; its
history is that of `plasol`.
"""

from __future__ import annotations

from fe_engine.register import Register
from fe_engine.soil import plasol, sand, van_eekelen
from fe_engine.soil.law import SoilLaw

SURFACES: Register[SoilLaw] = Register("frictional surface", plasol.LAW, van_eekelen.LAW, sand.LAW)
