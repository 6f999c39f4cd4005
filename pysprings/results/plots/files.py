# SPDX-License-Identifier: MIT
"""Write the pictures of a run to files, each whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib as mpl

from pysprings.core.files.storage import replacing
from pysprings.core.registry import Registry
from pysprings.core.words import MOST_DRAWN
from pysprings.results.analysis.parts import path_data, pick_step, section_data
from pysprings.results.plots.picture import Picture, View
from pysprings.results.plots.pictures import PICTURES
from pysprings.results.plots.style import STYLE, CompressedLayout
from pysprings.springs.path import paths_of

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
    pictures: Registry[Picture] = PICTURES,
) -> list[Path]:
    """Write every picture that the result allows, as PNG and, where small, SVG; return the files in order.

    Parameters
    ----------
    result
        Full model (DataTree of a run).
    springs
        Spring set; when None the p-y curves are drawn from the result.
    folder
        Folder of the files, created when missing. Files of the same name are replaced one by one, each atomically.
    curves
        Predictions of the rigid body on springs: path name -> spring set (``"full"``, ``"py"``) -> Dataset.
    note
        Called with each file when it is written.
    pictures
        Pictures to draw.
    """
    target = Path(folder)
    target.mkdir(parents=True, exist_ok=True)
    written: list[Path] = []
    for name, figure in figures(result, springs, curves or {}, pictures):
        for file in save(figure, target / name):
            written.append(file)
            if note is not None:
                note(file)
    return written


def figures(
    result: xr.DataTree,
    springs: xr.DataTree | None,
    curves: Mapping[str, Mapping[str, xr.Dataset]],
    pictures: Registry[Picture] = PICTURES,
) -> Iterator[tuple[str, Figure]]:
    """Yield (file name without suffix, figure) for every picture that the result allows, in reading order."""
    view = View(result, springs)
    plane = section_data(result)
    view = replace(view, section=None if plane is None else view.with_settings(plane))
    for picture in pictures:
        if picture.scope == "run" and picture.applies(view):
            yield picture.name, picture.draw(view)
    for name in drawn_paths(result):
        path = view.with_settings(path_data(result, name))
        yield from path_figures(replace(view, path=path, predictions=curves.get(name, {})), pictures)


def drawn_paths(result: xr.DataTree) -> list[str]:
    """Return the paths that are drawn: all of a few; of many the first of each kind and role.

    A fan has fifteen paths and more: pictures of each would take longer than the run.
    """
    paths = paths_of(result)
    if len(paths) <= MOST_DRAWN:
        return list(paths)
    first: dict[tuple[object, object], str] = {}
    for name, path in paths.items():
        first.setdefault((path.attrs.get("kind"), path.attrs.get("role")), name)
    return list(first.values())


def path_figures(view: View, pictures: Registry[Picture] = PICTURES) -> Iterator[tuple[str, Figure]]:
    """Yield (file name without suffix, figure) of one path; those of its states one state after the other."""
    name, steps = view.path.attrs["path"], shown_steps(view.path)
    for scope, group in groupby(pictures, key=lambda picture: picture.scope):
        members = list(group)
        states = steps.items() if scope == "state" else [("", None)] if scope == "path" else []
        for state, step in states:
            shown = replace(view, step=step)
            for picture in members:
                if picture.applies(shown):
                    yield f"{name}_{picture.name}" + (f"_{state}" if state else ""), picture.draw(shown)


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
        _settle(figure, dpi)
        png = _write(figure, stem.with_name(stem.name + ".png"), dpi)
        figure.set_layout_engine(None)
        svg = _write(figure, stem.with_name(stem.name + ".svg"), dpi, most=LARGEST_SVG)
    return [file for file in (png, svg) if file is not None]


def _settle(figure: Figure, dpi: int) -> None:
    """Lay a figure out once, for all files: with a layout engine matplotlib draws it twice for each of them.

    A compressed layout depends on the drawing, and is settled by the first file.
    """
    engine = figure.get_layout_engine()
    if engine is None or isinstance(engine, CompressedLayout):
        return
    before, figure.dpi = figure.dpi, dpi
    engine.execute(figure)  # a second time moves no panel by more than 4e-5 of the page
    figure.dpi = before
    figure.set_layout_engine(None)


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
