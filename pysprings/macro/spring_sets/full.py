# SPDX-License-Identifier: MIT
"""The set "full": all reactions of one path, p(y), m(rotation), tip and lid terms."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pysprings.macro.spring_sets.base import Built, SpringSet

if TYPE_CHECKING:
    from pysprings.springs.springs import Springs


def _build(springs: Springs, path: str | None) -> Built:
    from pysprings.macro.curve_table import build_table

    origin = springs.path(path)
    return Built(build_table(origin, companions=True), origin, (origin.name,))


SPRING_SET = SpringSet(
    name="full",
    label="full spring set of one path",
    description="all reactions of one path",
    build=_build,
    curves=True,
)
