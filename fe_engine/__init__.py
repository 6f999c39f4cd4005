# SPDX-License-Identifier: MIT
"""Finite elements for soil-structure interaction; knows nothing of caissons or files."""
