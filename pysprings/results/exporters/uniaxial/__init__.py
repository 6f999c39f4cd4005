# SPDX-License-Identifier: MIT
"""Uniaxial springs for programs without coupled ones: from the macro-model to tables, with the error of each step."""
