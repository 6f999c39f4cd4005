# SPDX-License-Identifier: MIT
"""Palette and units for people of all pictures, without what draws them."""

KN, MN, KPA, MM, MRAD = 1e-3, 1e-6, 1e-3, 1e3, 1e3  # from N, N, Pa, m, rad

# Okabe & Ito (2008), safe for colour-blind readers. One colour has one meaning in all figures.
INK, GREY, PALE = "#1a1a1a", "#7a7a7a", "#e6e6e6"
BLUE, VERMILLION, GREEN = "#0072B2", "#D55E00", "#009E73"
PURPLE, ORANGE, SKY = "#CC79A7", "#E69F00", "#56B4E9"

# of load cases by verdict: symbol of Matplotlib, colour; the others are overloaded or tilted too far
CASE_MARKS = {"ok": ("s", GREEN), "supported in part": ("D", ORANGE), "no answer": ("P", PURPLE)}
OTHER_CASE = ("X", VERMILLION)
