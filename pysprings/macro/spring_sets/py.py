# SPDX-License-Identifier: MIT
"""The set "py": net p(y) of one path alone, as in a plain Winkler model; p*z alone resists the moment."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pysprings.macro.spring_sets.base import Built, SpringSet

if TYPE_CHECKING:
    from pysprings.springs.springs import Springs

ALONE = (
    "p-y springs alone: no distributed moment, tip and lid springs; on a caisson they carry a fraction of the load "
    "(`pysprings compare` measures it)"
)


def _build(springs: Springs, path: str | None) -> Built:
    from pysprings.macro.curve_table import build_table

    origin = springs.path(path)
    return Built(build_table(origin, companions=False), origin, (origin.name,))


SPRING_SET = SpringSet(
    name="py",
    label="p-y springs only",
    description="p-y alone",
    build=_build,
    companions=False,
    curves=True,
    remark=ALONE,
)
