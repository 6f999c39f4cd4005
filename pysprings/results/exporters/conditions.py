# SPDX-License-Identifier: MIT
"""The rate and the vertical load of an export (`--option rate=... --option V=...`)."""

from __future__ import annotations

from pysprings.core.errors import refused
from pysprings.results.exporters.base import Options, Source
from pysprings.springs.path import same_load
from pysprings.springs.springs import Springs


def springs_at(source: Source, options: Options) -> tuple[Springs, float | None]:
    """Return the springs at the rate of the options, and the vertical load [N] (None: that at rest).

    Raises
    ------
    UserInputError
        A vertical load beyond those of the lateral paths, whose springs would be those of another load.
    """
    springs = Springs.of(source.springs)
    springs = springs if options["rate"] is None else springs.at_rate(float(options["rate"]))
    if options["V"] is None:
        return springs, None
    V = float(options["V"])
    known = [each.V for each in springs.load_sets]
    if known and not (known[0] < V < known[-1] or any(same_load(V, each) for each in known)):
        there = " to ".join(f"{1e-3 * each:.6g}" for each in sorted({known[0], known[-1]}))
        raise refused("--option V", f"{1e-3 * V:.6g} kN: lateral springs are known at V = {there} kN")
    return springs, V
