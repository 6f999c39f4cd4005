# SPDX-License-Identifier: MIT
"""Excel workbook of a spring set for design spreadsheets: kN, m, mm, mrad, with charts."""

from pysprings.results.exporters.base import Exported, Exporter, Options, Source, Target


def _write(source: Source, target: Target, _options: Options) -> Exported:
    from pysprings.results.exporters.xlsx.workbook import write_workbook

    return Exported([write_workbook(source, target.path)])


XLSX = Exporter(
    name="xlsx",
    description="springs as a spreadsheet",
    write=_write,
    suffixes=(".xlsx",),
    file="springs.xlsx",
    of_every_run=True,
)
