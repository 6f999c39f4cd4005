# SPDX-License-Identifier: MIT
"""Write the pictures of a run to files, each whole or not at all."""

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from io import BytesIO
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib as mpl
import xarray as xr
from matplotlib.figure import Figure

from pysprings.core.registry import Registry
from pysprings.core.storage import replacing
from pysprings.core.words import MOST_DRAWN, Figures
from pysprings.results.layout import Drawn, stands_for
from pysprings.results.parts import path_data, pick_step, section_data
from pysprings.results.plots.draw import PICTURES
from pysprings.results.plots.picture import Picture, View
from pysprings.results.plots.style import STYLE, CompressedLayout
from pysprings.springs.path import paths_of

PAPER_DISPLACEMENT = 2.5e-3  # m: the state that the paper's figures show
DPI = 100  # the widest figures, 9.6 inch, fill the report, whose text is 960 pixels wide
FORMATS = ("png", "svg")
PNG_LEVEL = 1  # of compression: a tenth larger than by default, in a third of the time
LARGEST_SVG = 400_000  # bytes; a larger drawing is kept as PNG alone


class Planned(NamedTuple):
    """A picture that the data allow, by its place, and what it reads."""

    place: Drawn
    picture: Picture
    view: View


def save_all(
    result: xr.DataTree,
    springs: xr.DataTree | None,
    folder: str | os.PathLike[str],
    curves: Mapping[str, Mapping[str, xr.Dataset]] | None = None,
    note: Callable[[Path], object] | None = None,
    which: Figures = "all",
    formats: Sequence[str] = ("png",),
    pictures: Registry[Picture] = PICTURES,
) -> list[Path]:
    """Write the pictures that the result allows; return the files in order.

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
    which
        "report": those that the report shows; "none": none.
    formats
        "png" and "svg": see `save`.
    pictures
        Kinds of pictures.
    """
    target = Path(folder)
    target.mkdir(parents=True, exist_ok=True)
    written: list[Path] = []
    for name, figure in figures(result, springs, curves or {}, which, pictures):
        for file in save(figure, target / name, formats):
            written.append(file)
            if note is not None:
                note(file)
    return written


def figures(
    result: xr.DataTree,
    springs: xr.DataTree | None,
    curves: Mapping[str, Mapping[str, xr.Dataset]],
    which: Figures = "all",
    pictures: Registry[Picture] = PICTURES,
) -> Iterator[tuple[str, Figure]]:
    """Yield (file name without suffix, figure) of the pictures that the result allows, in reading order."""
    if which == "none":
        return
    view, plane = View(result, springs), section_data(result)
    view = replace(view, section=None if plane is None else view.with_settings(plane))
    whole = (picture for picture in pictures if picture.scope == "run" and picture.applies(view))
    planned = [Planned(Drawn(picture.name, "", ""), picture, view) for picture in whole]
    for name in drawn_paths(result):
        path = view.with_settings(path_data(result, name))
        planned += path_plan(replace(view, path=path, predictions=curves.get(name, {})), pictures)
    if which == "report":
        paths = {name: path.attrs for name, path in paths_of(result).items()}
        known = [each.place for each in planned]
        shown = {stands_for(picture.name, known, paths) for picture in pictures if picture.section}
        planned = [each for each in planned if each.place in shown]
    for each in planned:
        yield each.place.stem, each.picture.draw(each.view)


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


def path_plan(view: View, pictures: Registry[Picture] = PICTURES) -> Iterator[Planned]:
    """Yield the pictures of one path; those of its states one state after the other."""
    name, steps = view.path.attrs["path"], shown_steps(view.path)
    for scope, group in groupby(pictures, key=lambda picture: picture.scope):
        members = list(group)
        states = steps.items() if scope == "state" else [("", None)] if scope == "path" else []
        for state, step in states:
            shown = replace(view, step=step)
            for picture in members:
                if picture.applies(shown):
                    yield Planned(Drawn(picture.name, name, state), picture, shown)


def shown_steps(path: xr.Dataset) -> dict[str, int]:
    """Choose the steps drawn as states: ``{"2.5mm": step, "last": step}``, the first only where reached."""
    last = pick_step(path)
    steps = {}
    near = pick_step(path, displacement=PAPER_DISPLACEMENT)
    if near != last and abs(float(path["u"][near]) - PAPER_DISPLACEMENT) <= 0.1 * PAPER_DISPLACEMENT:
        steps["2.5mm"] = near
    return {**steps, "last": last}


def save(figure: Figure, stem: Path, formats: Sequence[str] = ("png",), dpi: int = DPI) -> list[Path]:
    """Write a figure as ``stem.png``, ``stem.svg`` or both, each by a rename; return the files.

    A large drawing is written as PNG in the place of SVG. Files of the same stem in other formats are removed.
    """
    with mpl.rc_context(STYLE):
        _settle(figure, dpi)
        files = {each: stem.with_name(f"{stem.name}.{each}") for each in FORMATS}
        if "svg" in formats and not _write(figure, files["svg"], dpi, most=LARGEST_SVG):
            formats = ("png",)
        if "png" in formats:
            _write(figure, files["png"], dpi)
    for each in set(FORMATS) - set(formats):
        files[each].unlink(missing_ok=True)
    return [file for each, file in files.items() if each in formats]


def redraw(draw: Callable[[], Figure], stem: Path, formats: Sequence[str] = ("png",)) -> list[Path]:
    """Save the figure that `draw` returns; with no format draw nothing, and remove the files of the stem."""
    if formats:
        return save(draw(), stem, formats)
    for each in FORMATS:
        stem.with_name(f"{stem.name}.{each}").unlink(missing_ok=True)
    return []


def _settle(figure: Figure, dpi: int) -> None:
    """Lay a figure out once, for all files: with a layout engine matplotlib draws it twice for each of them.

    A compressed layout depends on the drawing: the figure is drawn once for it.
    """
    engine = figure.get_layout_engine()
    if engine is None:
        return
    before, figure.dpi = figure.dpi, dpi
    if isinstance(engine, CompressedLayout):
        figure.draw_without_rendering()
    else:
        engine.execute(figure)  # a second time moves no panel by more than 4e-5 of the page
    figure.dpi = before
    figure.set_layout_engine(None)


def content_of(figure: Figure, ending: str = "png") -> bytes:
    """Return the content of a file of a figure, "png" or "svg"."""
    stream = BytesIO()
    with mpl.rc_context(STYLE):
        _settle(figure, DPI)
        figure.savefig(stream, format=ending, dpi=DPI, **_of_format(ending))
    return stream.getvalue()


def _of_format(ending: str) -> dict[str, Any]:
    # Dates would make two equal runs differ.
    return {"metadata": {"Date": None}} if ending == "svg" else {"pil_kwargs": {"compress_level": PNG_LEVEL}}


def _write(figure: Figure, file: Path, dpi: int, most: int | None = None) -> bool:
    """Write one file by a rename; a file above `most` bytes is not kept, nor is an older one of its name."""
    with replacing(file) as temporary:
        figure.savefig(temporary, dpi=dpi, **_of_format(file.suffix[1:]))
        small = most is None or temporary.stat().st_size <= most
    if not small:
        file.unlink()
    return small
