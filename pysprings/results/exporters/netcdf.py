# SPDX-License-Identifier: MIT
"""The spring file itself: NetCDF4 with CF units, which all commands and `xarray.open_datatree` read."""

from __future__ import annotations

from pysprings.results.exporters.base import Exported, Exporter, Options, Source, Target


def _write(source: Source, target: Target, _options: Options) -> Exported:
    from pysprings.macro.memory.build import with_memory
    from pysprings.springs.checks import save_springs

    return Exported([save_springs(with_memory(source.springs), target.path)])


NETCDF = Exporter(
    name="nc",
    description="springs (NetCDF), for `pysprings springs, predict, compare`",
    write=_write,
    suffixes=(".nc",),
    file="springs.nc",
    of_every_run=True,
)
