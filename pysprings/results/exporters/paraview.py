# SPDX-License-Identifier: MIT
"""ParaView files of a run that kept the whole model: a `.pvd` for each path, a `.vtu` for each step."""

from pysprings.results.exporters.base import Exported, Exporter, Options, Source, Target


def _write(source: Source, target: Target, _options: Options) -> Exported:
    from pysprings.results.exporters.vtu import write_paraview

    return Exported(write_paraview(source.result, target.path, target.note))


PARAVIEW = Exporter(
    name="paraview",
    description="ParaView files of a run with [output] paraview = true: displacements, stresses, pressures by step",
    write=_write,
    needs="full model",
    suffixes=(".pvd", ".vtu"),
)
