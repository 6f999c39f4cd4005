# SPDX-License-Identifier: MIT
"""The spring dataset: schema, file, sums, dead loads, rates."""
