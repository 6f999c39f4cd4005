# SPDX-License-Identifier: MIT
"""Rigid body on nonlinear springs, and its error against the full model."""
