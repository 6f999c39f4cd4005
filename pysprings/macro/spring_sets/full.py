# SPDX-License-Identifier: MIT
"""The set "full": all reactions of one path, p(y), m(rotation), tip and lid terms."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pysprings.macro.spring_sets.base import Built, SpringSet

if TYPE_CHECKING:
    import xarray as xr


def _build(springs: xr.DataTree, path: str | None) -> Built:
    from pysprings.macro.curve_table import build_table
    from pysprings.springs.dataset import get_path

    origin = get_path(springs, path)
    return Built(build_table(origin, companions=True), origin, (str(origin.attrs["path"]),))


SPRING_SET = SpringSet(
    name="full",
    label="full spring set of one path",
    description="all reactions of one path",
    build=_build,
    curves=True,
)
