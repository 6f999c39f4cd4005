# SPDX-License-Identifier: MIT
"""Write figures to files: all that a run can show, each file whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib as mpl

from pysprings.core.files.storage import replacing
from pysprings.results.plots import (
    comparison,
    gap,
    load,
    newton,
    pressure_rose,
    reactions,
    rose,
    section,
    steel,
    vertical,
)
from pysprings.results.plots.data import (
    convergence_data,
    path_data,
    pick_step,
    section_data,
    settings,
)
from pysprings.results.plots.style import STYLE
from pysprings.springs.dataset import path_names

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

PAPER_DISPLACEMENT = 2.5e-3  # m: the state that the paper's figures show
DPI = 150
LARGEST_SVG = 400_000  # bytes; a larger drawing is kept as PNG alone


def save_all(
    result: xr.DataTree,
    springs: xr.DataTree | None,
    folder: str | os.PathLike[str],
    curves: Mapping[str, Mapping[str, xr.Dataset]] | None = None,
    note: Callable[[Path], object] | None = None,
) -> list[Path]:
    """Write every figure that the result allows, as PNG and, where small, SVG; return the files in order.

    Parameters
    ----------
    result
        Full model (DataTree of a run).
    springs
        Spring set; when None the p-y curves are drawn from the result.
    folder
        Where to write; made when missing. Files of the same name are replaced one by one, each atomically.
    curves
        Predictions of the rigid body on springs: path name -> spring set (``"full"``, ``"py"``) -> Dataset.
    note
        Called with each file when it is written.
    """
    target = Path(folder)
    target.mkdir(parents=True, exist_ok=True)
    written: list[Path] = []
    for name, figure in figures(result, springs, curves or {}):
        for file in save(figure, target / name):
            written.append(file)
            if note is not None:
                note(file)
    return written


def figures(
    result: xr.DataTree,
    springs: xr.DataTree | None,
    curves: Mapping[str, Mapping[str, xr.Dataset]],
) -> Iterator[tuple[str, Figure]]:
    """Yield (file name without suffix, figure) for every figure that the result allows, in reading order."""
    plane = section_data(result)
    if plane is not None:
        plane = plane.assign_attrs({**(settings(springs) if springs is not None else {}), **plane.attrs})
        yield "mesh", section.mesh(plane)
    for name in path_names(result):
        yield from path_figures(result, springs, name, plane, curves.get(name, {}))


def path_figures(
    result: xr.DataTree,
    springs: xr.DataTree | None,
    name: str,
    plane: xr.Dataset | None,
    curves: Mapping[str, xr.Dataset],
) -> Iterator[tuple[str, Figure]]:
    """Yield (file name without suffix, figure) for one path."""
    path = path_data(result, name)
    if springs is not None:
        path = path.assign_attrs({**settings(springs), **path.attrs})
    if path.attrs.get("kind") == "vertical":
        yield f"{name}_vertical", vertical.vertical_springs(path)
    else:
        yield f"{name}_load_displacement", load.load_displacement(path)
        if curves:
            yield f"{name}_macro_against_full", comparison.macro_against_full(path, curves)
        source = path_data(springs, name) if springs is not None and name in path_names(springs) else path
        yield f"{name}_py", reactions.py_curves(source)
    yield from _state_figures(path, plane)
    record = convergence_data(result, name)
    if record is not None and record.sizes.get("iteration", 0):
        failed = newton.failed_steps(path, record)
        yield (
            f"{name}_newton",
            newton.newton_record(record.assign_attrs({**path.attrs, **record.attrs}), failed),
        )


def _state_figures(path: xr.Dataset, plane: xr.Dataset | None) -> Iterator[tuple[str, Figure]]:
    """Yield the figures of single steps: the paper's displacement where it is reached, and the last step."""
    name = path.attrs["path"]
    for tag, step in shown_steps(path).items():
        if "normal_effective_stress" in path:
            for side in ("outside", "inside"):
                yield f"{name}_stress_{side}_{tag}", rose.stress_rose(path, step, side=side)
        if "gap" in path:
            yield f"{name}_gap_{tag}", gap.gap_map(path, step)
        if "diameter_change_x" in path:
            yield f"{name}_ovalisation_{tag}", steel.ovalisation(path, step)
        if plane is not None and "section_ux" in path:
            yield f"{name}_section_{tag}", section.section_displacement(plane, path, step)
        if "pressure_min" in path and "pore_pressure" in path:
            yield f"{name}_pressure_{tag}", pressure_rose.pressure_rose(path, step)
        if plane is not None and "section_pore_pressure" in path:
            yield f"{name}_section_pressure_{tag}", section.section_pressure(plane, path, step)


def shown_steps(path: xr.Dataset) -> dict[str, int]:
    """Choose the steps drawn as states: ``{"2.5mm": step, "last": step}``, the first only where reached."""
    last = pick_step(path)
    steps = {}
    near = pick_step(path, displacement=PAPER_DISPLACEMENT)
    if near != last and abs(float(path["u"][near]) - PAPER_DISPLACEMENT) <= 0.1 * PAPER_DISPLACEMENT:
        steps["2.5mm"] = near
    return {**steps, "last": last}


def save(figure: Figure, stem: Path, dpi: int = DPI) -> list[Path]:
    """Write a figure as ``stem.png`` and, when small, ``stem.svg``, each by a rename; return the files."""
    with mpl.rc_context(STYLE):
        png = _write(figure, stem.with_name(stem.name + ".png"), dpi)
        figure.set_layout_engine("none")  # the layout is settled: do not spend a second on it again
        svg = _write(figure, stem.with_name(stem.name + ".svg"), dpi, most=LARGEST_SVG)
    return [file for file in (png, svg) if file is not None]


def _write(figure: Figure, file: Path, dpi: int, most: int | None = None) -> Path | None:
    """Write one file by a rename; a file above `most` bytes is not kept, nor is an older one of its name."""
    # Dates would make two equal runs differ.
    metadata = {"Date": None} if file.suffix == ".svg" else None
    with replacing(file) as temporary:
        figure.savefig(temporary, dpi=dpi, metadata=metadata)
        small = most is None or temporary.stat().st_size <= most
    if small:
        return file
    file.unlink()
    return None
