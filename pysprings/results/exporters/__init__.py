# SPDX-License-Identifier: MIT
"""Files for other programs and people. A new exporter is one module here and one entry in `formats`.

Other packages call `EXPORTERS.register`. Every exporter replaces a file only when the new one is whole. Its module, and
the heavy libraries that it imports, load when it is called.
"""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pysprings.core.registry import Registry
from pysprings.results.exporters.base import Exported, Exporter, Option, Source, Target, read_options
from pysprings.results.exporters.formats import FORMATS

if TYPE_CHECKING:
    import xarray as xr

EXPORTERS: Registry[Exporter] = Registry("exporter", FORMATS)

PathLike = str | os.PathLike[str]

__all__ = ["EXPORTERS", "Exported", "Exporter", "Option", "Source", "Target", "export", "read_options", "text"]


def export(data: xr.DataTree | Source, name: str, target: PathLike | Target, **options: Any) -> Exported:
    """Write springs or a full model with an exporter.

    data : Springs or a full model, as the exporter needs; or a source of both.
    name : Name of the exporter.
    target : File for exporters of one file, else folder, which need not exist.
    options : Options of the exporter.

    Raises UserInputError: unknown exporter or options, or data that it cannot use.
    """
    from pysprings.springs.springs import Springs

    exporter = EXPORTERS.find(name, "--to")
    place = target if isinstance(target, Target) else Target(Path(target))
    values = read_options(exporter, options)
    source = _source(data, exporter)
    done = exporter.write(source, place, values)
    words = Springs.of(source.springs).atlas_words if exporter.needs == "springs" else ()
    return replace(done, remarks=[*words, *done.remarks]) if words else done


def text(data: xr.DataTree | Source, name: str, **options: Any) -> str:
    """Return what an exporter of one text file writes, for a terminal or a pipe."""
    exporter = EXPORTERS.find(name, "--format")
    if exporter.text is None:
        raise ValueError(f"exporter '{name}' writes no text")
    return exporter.text(_source(data, exporter), read_options(exporter, options))


def _source(data: xr.DataTree | Source, exporter: Exporter) -> Source:
    if isinstance(data, Source):
        return data
    return Source(result=data) if exporter.needs == "full model" else Source(springs=data)
