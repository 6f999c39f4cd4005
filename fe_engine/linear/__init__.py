# SPDX-License-Identifier: MIT
"""Linear solvers behind one interface."""
