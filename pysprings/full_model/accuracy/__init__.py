# SPDX-License-Identifier: MIT
"""Error of a run: common curves, order of convergence, measures, settings by target, two-mesh estimate."""
