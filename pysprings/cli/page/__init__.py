# SPDX-License-Identifier: MIT
"""The page of `pysprings explore`: what it explores, what it answers, how it looks."""
