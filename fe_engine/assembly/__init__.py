# SPDX-License-Identifier: MIT
"""Residual and tangent on a fixed sparsity pattern."""
