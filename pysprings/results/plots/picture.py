# SPDX-License-Identifier: MIT
"""What a picture declares, and what it may read."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

import xarray as xr
from matplotlib.figure import Figure

from pysprings.core.path_kinds import driven
from pysprings.results.analysis.parts import convergence_data, path_data, path_names, settings

Scope = Literal["run", "path", "state"]
# Part of the report that shows a picture; "" leaves it to the folder of figures
Part = Literal["", "springs", "capacity", "tilt", "comparison", "ground", "states", "numerics"]


@dataclass(frozen=True)
class View:
    """Data of a run for one picture.

    Attributes
    ----------
    result, springs
        Full model; spring set, None where too little converged.
    section
        Symmetry plane with the settings of the run as attrs; None where it was not kept.
    path
        Path of the picture with the settings of the run as attrs; empty for a picture of the whole run.
    predictions
        Answers of the macro-model along the path, by spring set.
    step
        Step of a picture of one state.
    """

    result: xr.DataTree
    springs: xr.DataTree | None = None
    section: xr.Dataset | None = None
    path: xr.Dataset = field(default_factory=xr.Dataset)
    predictions: Mapping[str, xr.Dataset] = field(default_factory=dict)
    step: int | None = None

    @property
    def is_vertical(self) -> bool:
        """Whether the path is a vertical one."""
        return driven(self.path.attrs) == "w"

    @cached_property
    def plane(self) -> xr.Dataset:
        """Symmetry plane of a result that has one; ValueError without."""
        if self.section is None:
            raise ValueError("the result holds no symmetry plane")
        return self.section

    @cached_property
    def reactions(self) -> xr.Dataset:
        """The path of the spring set, else that of the full model."""
        name = self.path.attrs["path"]
        if self.springs is not None and name in path_names(self.springs):
            return path_data(self.springs, name)
        return self.path

    @cached_property
    def convergence(self) -> xr.Dataset | None:
        """Newton record of the path; None where there is none or it is empty."""
        record = convergence_data(self.result, self.path.attrs["path"])
        return record if record is not None and record.sizes.get("iteration", 0) else None

    def with_settings(self, data: xr.Dataset) -> xr.Dataset:
        """Return data whose attrs also hold the settings of the springs."""
        attrs = settings(self.springs) if self.springs is not None else {}
        return data.assign_attrs({**attrs, **data.attrs})


def _always(_view: View) -> bool:
    return True


def _view(view: View) -> tuple[Any, ...]:
    return (view,)


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture of a run.

    Attributes
    ----------
    name
        Part of the file name: `NAME` for the whole run, `PATH_NAME` for a path, `PATH_NAME_STATE` for a state.
    caption
        Caption in the report.
    function
        Draws the picture of `data` and of options by keyword; returns a Figure.
    data
        View -> leading arguments of the function; the view itself by default.
    scope
        What one picture shows: the whole "run", a "path", or a "state" (last step, and u = 2.5 mm where reached).
    applies
        Whether a view holds the data that the picture needs.
    tall
        The picture needs the height of a printed page.
    section
        Part of the report that shows it: of a path the one that stands for all, of a state the last; by default its
        appendix of numerics.
    """

    name: str
    caption: str
    function: Callable[..., Figure]
    data: Callable[[View], tuple[Any, ...]] = _view
    scope: Scope = "path"
    applies: Callable[[View], bool] = _always
    tall: bool = False
    section: Part = "numerics"

    def draw(self, view: View, **options: Any) -> Figure:
        """Draw the picture of a view; options are keyword arguments of the function."""
        return self.function(*self.data(view), **options)
