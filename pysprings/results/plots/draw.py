# SPDX-License-Identifier: MIT
"""Pictures of a run in reading order (`PICTURES`), and one of them by its name.

A new picture is one module in this folder and one entry here. Other packages call `PICTURES.register`.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import xarray as xr
from matplotlib.figure import Figure, SubFigure

from pysprings.core.errors import refused
from pysprings.core.registry import Registry
from pysprings.core.text import suggestion
from pysprings.macro.spring_sets import SPRING_SETS, with_stored
from pysprings.results.exporters.base import Source
from pysprings.results.parts import path_data, path_names, pick_step, section_data
from pysprings.results.plots import comparison, gap, ground, load, overview, profiles, rose, section
from pysprings.results.plots.picture import Picture, View
from pysprings.results.plots.style import drawn_on
from pysprings.springs.checks import extract_springs
from pysprings.springs.path import paths_of
from pysprings.springs.springs import Springs

PICTURES: Registry[Picture] = Registry(
    "picture",
    (
        ground.CAISSON, section.MESH, ground.PICTURE, overview.PICTURE, overview.TILT, overview.SECANT, load.PICTURE,
        comparison.PICTURE, comparison.LOOPS, profiles.PY, profiles.PICTURE, load.VERTICAL, rose.OUTSIDE, rose.INSIDE,
        gap.PICTURE, gap.OVALISATION, section.DISPLACEMENT, rose.PORE_PRESSURE, section.PRESSURE, load.NEWTON,
    ),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Predictions(Mapping[str, xr.Dataset]):
    """Answers of the springs along a path by spring set, computed at the first access."""

    tree: xr.DataTree
    path: str

    @cached_property
    def answers(self) -> Mapping[str, xr.Dataset]:
        springs = with_stored(extract_springs(self.tree)) if is_result(self.tree) else self.tree
        return Source(springs).predictions.get(self.path, {})

    def __getitem__(self, name: str) -> xr.Dataset:
        return self.answers[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.answers)

    def __len__(self) -> int:
        return len(self.answers)


def is_result(tree: xr.DataTree) -> bool:
    """Return whether a tree is the result of a full model, not a set of springs."""
    return any("H_outer" in path for path in paths_of(tree).values()) or "run_json" in tree.attrs


def draw(
    source: xr.DataTree | Springs, name: str, path: str | None = None, *, step: int | None = None,
    displacement: float | None = None, figure: Figure | SubFigure | None = None, **options: Any,
) -> Figure:  # fmt: skip
    """Draw a picture of a result or of springs; return its figure.

    Parameters
    ----------
    source
        Result (`run`, `open_result`) or springs (`extract_springs`, `open_springs`, `open_table`).
    name
        Picture: "py", "profiles", "tilt" ... (``PICTURES.names()``).
    path
        Load path, for a picture of one path; by default the first that has the data for the picture.
    step, displacement
        State, for a picture of one state: a step, or the lateral displacement u [m] that it is nearest to; by default
        the last converged step.
    figure
        Figure, or part of a figure (`Figure.subfigures`), that is emptied and drawn on; by default a new one.
    options
        Keyword arguments of the function that draws the picture.

    Raises
    ------
    UserInputError
        No such picture or path, or the source does not hold what the picture needs.
    """
    picture = PICTURES.find(name, "picture")
    if picture.scope == "run" and path is not None:
        raise refused("path", f"picture '{name}' shows all paths: leave path out")
    if picture.scope != "state" and (step is not None or displacement is not None):
        raise refused("step", f"picture '{name}' shows no single state: leave step and displacement out")
    view = _view(source.tree if isinstance(source, Springs) else source, picture, path, step, displacement)
    with drawn_on(figure):
        return picture.draw(view, **options)


def drawable(tree: xr.DataTree) -> list[str]:
    """Return the names of the pictures that a tree has the data for; predictions count as there, and are not made."""
    answers = dict.fromkeys(SPRING_SETS.names(), xr.Dataset())
    return [
        picture.name
        for picture in PICTURES
        if any(picture.applies(replace(view, predictions=answers)) for view in _views(tree, picture))
    ]


def _view(
    tree: xr.DataTree, picture: Picture, path: str | None, step: int | None, displacement: float | None
) -> View:  # fmt: skip
    """Return what a picture may read; of the first path for which it applies where none is named."""
    if path is not None and path not in path_names(tree):
        names = path_names(tree)
        raise refused("path", f"no path '{path}'{suggestion(path, names)}; there are: {', '.join(names) or 'none'}")
    for view in _views(tree, picture, path):
        if picture.applies(view):
            return view if picture.scope == "run" else replace(view, step=pick_step(view.path, step, displacement))
    where = f" of path '{path}'" if path else ""
    what = "result" if is_result(tree) else "springs"
    raise refused("picture", f"'{picture.name}' cannot be drawn{where}: the {what} does not hold its data")


def _views(tree: xr.DataTree, picture: Picture, path: str | None = None) -> Iterator[View]:
    """Yield the view of the whole, or of each path in turn: calibration paths before others."""
    view = View(tree, section=section_data(tree))
    if picture.scope == "run":
        yield view
        return
    names = [path] if path else sorted(path_names(tree), key=lambda name: name not in path_names(tree, "calibration"))
    for name in names:
        yield replace(view, path=path_data(tree, name), predictions=_Predictions(tree, name))
