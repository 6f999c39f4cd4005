# SPDX-License-Identifier: MIT
"""Words that scene file, command line and studies share (light)."""

from __future__ import annotations

from typing import Literal

AUTO = "auto"  # of a value that the program chooses
MOST_DRAWN = 6  # paths of a run that are all drawn

MeshPreset = Literal["coarse", "medium", "paper", "fine"]
Discretisation = Literal["hex8", "fourier"]
# largest error of a run in its load and p-y curves: see `pysprings.full_model.accuracy.presets`
TargetError = Literal["5%", "2%", "1%", "0.5%"]

RANGE_END = "end of the range"  # kind of the largest known load of an answer that is no capacity: more is not known
