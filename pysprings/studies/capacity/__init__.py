# SPDX-License-Identifier: MIT
"""Capacity under H and M at given V: the full model pushed to failure, and the macro-model's envelope beside it."""
