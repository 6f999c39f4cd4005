# SPDX-License-Identifier: MIT
"""Axes, signs and component orders that every file of the engine obeys.

Units are SI: m, N, Pa, s, rad.

Axes are right-handed with z DOWN: x is the loading direction, z the depth below
mudline, y the direction out of the symmetry plane.

Stress is positive in tension; Voigt order is ``xx yy zz xy yz zx`` and shear
strains are engineering strains (gamma = 2 eps).

The jump of an interface is the displacement of side 1 (soil) minus that of side 2
(body), resolved in the local frame ``(normal, tangent 1, tangent 2)`` whose normal
points from side 2 to side 1; a positive normal jump is a gap. The traction is
work-conjugate to the jump, so its normal component is minus the contact pressure.

A rigid body moves with a displacement (u_x, u_y, u_z) of its reference point and
right-hand rotations about x, y and z; one that moves in the plane of x and z with
(u, w, rotation): u_x = u + rotation (z - z0), u_z = w - rotation (x - x0).
"""

import numpy as np

# Voigt positions
XX, YY, ZZ, XY, YZ, ZX = range(6)
# Local corners (xi, eta, zeta) of a hexahedron: bottom quad counter-clockwise, then top quad.
CORNERS = np.array(
    [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], dtype=float
)
# Components of a jump or a traction: 0 normal, 1 and 2 tangential (see interface.local_frames)
# Degrees of freedom of a rigid body in the plane of x and z
U, W, ROTATION = range(3)

# What happened at a Gauss point or a station in the last evaluation
REGIME_ELASTIC, REGIME_CONE, REGIME_APEX = 0, 1, 2
REGIME_STIFFNESS = 3  # inside the surface, but not with the initial stiffness
CONTACT_STICK, CONTACT_SLIP, CONTACT_OPEN = 0, 1, 2

# Status of a kernel: zero is success, anything else becomes a Python error
OK = 0
LAW_NOT_CONVERGED = 1
