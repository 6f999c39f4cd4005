# SPDX-License-Identifier: MIT
"""Springs with a memory: elements in parallel, their calibration, and sequences of loads and motions on them."""
