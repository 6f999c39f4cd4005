# SPDX-License-Identifier: MIT
"""The set "py": net p(y) of one path alone, as in a plain Winkler model; p*z alone resists the moment."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pysprings.macro.spring_sets.base import Built, SpringSet

if TYPE_CHECKING:
    import xarray as xr

ALONE = (
    "p-y springs alone: no distributed moment, tip and lid springs; on a caisson they carry a fraction of the load "
    "(`pysprings compare` measures it)"
)


def _build(springs: xr.DataTree, path: str | None) -> Built:
    from pysprings.macro.curve_table import build_table
    from pysprings.springs.dataset import get_path

    origin = get_path(springs, path)
    return Built(build_table(origin, companions=False), origin, (str(origin.attrs["path"]),))


SPRING_SET = SpringSet(
    name="py",
    label="p-y springs only",
    description="p-y alone",
    build=_build,
    companions=False,
    curves=True,
    remark=ALONE,
)
