# SPDX-License-Identifier: MIT
"""Soil laws: one law a file, each with packed parameters, history and an update."""
