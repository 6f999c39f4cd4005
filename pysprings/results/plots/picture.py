# SPDX-License-Identifier: MIT
"""What a picture declares and may read, and quantities in the form that figures need."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from pysprings.core.arrays import Array, Integers
from pysprings.core.errors import refused
from pysprings.core.path_kinds import driven
from pysprings.results.parts import converged, convergence_data, path_data, path_names, settings
from pysprings.results.plots.style import KN, MM, MN, MRAD

Scope = Literal["run", "path", "state"]
# Part of the report that shows a picture; "" leaves it to the folder of figures
Part = Literal["", "first", "springs", "capacity", "tilt", "comparison", "ground", "states", "numerics"]


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
    section
        Part of the report that shows it: of a path the one that stands for all, of a state the last; by default its
        appendix of numerics.
    """

    name: str
    caption: str
    function: Callable[..., Figure]
    data: Callable[[View], tuple[Any, ...]] = lambda view: (view,)
    scope: Scope = "path"
    applies: Callable[[View], bool] = lambda _view: True
    section: Part = "numerics"

    def draw(self, view: View, **options: Any) -> Figure:
        """Draw the picture of a view; options are keyword arguments of the function."""
        return self.function(*self.data(view), **options)


def of_state(
    name: str, caption: str, function: Callable[..., Figure], needs: Sequence[str], section: Part = ""
) -> Picture:
    """Return a picture of one state of a path that holds the variables `needs`."""

    def applies(view: View) -> bool:
        return all(key in view.path for key in needs)

    return Picture(name, caption, function, lambda view: (view.path, view.step), "state", applies, section)


# Rings nearest to these parts of the skirt length: 0.25, 1.25, 2.25 and 3.25 m on the paper's 4 m skirt.
DEPTH_FRACTIONS = (1 / 16, 5 / 16, 9 / 16, 13 / 16)
SMALLEST = 1e-9  # mm, mrad: smaller motions are rounding
# degree of freedom that grows along a path -> factor and label of its axis
_AXES = {
    "u": (MM, "lateral displacement u of the lid centre [mm]"),
    "w": (MM, "vertical displacement w [mm], down +"),
    "rotation": (MRAD, "rotation of the caisson [mrad]"),
}


def pick_depths(path: xr.Dataset, depths: Iterable[float] | None = None) -> list[int]:
    """Choose rings: the nearest to the given depths [m], else to 1/16, 5/16, 9/16 and 13/16 of the skirt.

    Raises UserInputError for a depth that is not on the skirt.
    """
    length = skirt_length(path)
    targets = list(depths) if depths is not None else [f * length for f in DEPTH_FRACTIONS]
    if beyond := [f"{depth:g}" for depth in targets if not 0.0 <= depth <= length * (1.0 + 1e-9)]:
        raise refused("depths", f"{', '.join(beyond)} m is not on the skirt, 0 to {length:g} m")
    return sorted({_nearest(path, depth) for depth in targets})


def _nearest(path: xr.Dataset, depth: float) -> int:
    return int(np.argmin(np.abs(path["depth"].values - depth)))


def depth_words(path: xr.Dataset, depths: Iterable[float] | None) -> str:
    """Return where the rings lie that stand for the depths [m] that were asked for; empty where they are these."""
    drawn = [(depth, float(path["depth"][_nearest(path, depth)])) for depth in (() if depths is None else depths)]
    moved = [f"{at:.2f} m for {depth:g} m" for depth, at in drawn if abs(at - depth) >= 0.005]
    return f"nearest depths with results: {', '.join(moved)}" if moved else ""


def spread_depths(path: xr.Dataset, most: int) -> list[int]:
    """Choose at most `most` rings, evenly over the depth, first and last included."""
    n = path.sizes["depth"]
    return sorted({round(k) for k in np.linspace(0, n - 1, min(n, most))})


def skirt_length(path: xr.Dataset) -> float:
    """Return the skirt length [m]: from the attrs, else from the deepest ring."""
    return float(path.attrs.get("skirt_length_m", path["depth"].values.max()))


def step_text(path: xr.Dataset, step: int) -> str:
    """Describe the state of a step in words: lid displacement [mm] and rotation [mrad]."""
    u, rotation = float(path["u"][step]) * MM, float(path["rotation"][step]) * MRAD
    text = f"u = {_short(u)} mm, rotation = {_short(rotation)} mrad"
    if driven(path.attrs) == "w":
        text = f"w = {_short(float(path['w'][step]) * MM)} mm"
    text = text.replace("-", "\N{MINUS SIGN}")
    return text if converged(path)[step] else text + " (NOT CONVERGED)"


def heading(path: xr.Dataset, step: int) -> float:
    """Return where the front of a caisson is at a step: 1 at +x, -1 at -x where u (without u, its lean) is negative."""
    u, lean = float(path["u"][step]), float(path["rotation"][step]) * skirt_length(path)
    return -1.0 if (u if abs(u) > SMALLEST * abs(lean) else lean) < 0.0 else 1.0


def _short(value: float) -> str:
    """Return three digits of a motion [mm, mrad]; what is below a picometre is rounding."""
    return f"{0.0 if abs(value) < SMALLEST else value:.3g}"


def abscissa(path: xr.Dataset) -> tuple[Array, str]:
    """Return what the path drives, with its axis label: u [mm], or the rotation [mrad] on a pure rotation."""
    name = driven(path.attrs)
    factor, label = _AXES[name]
    return path[name].values * factor, label


def lateral_reaction(path: xr.Dataset) -> dict[str, Array]:
    """Return p [N/m] by side, ``{"net", "outside", "inside"}``, each of shape (depth, step).

    Components are summed: normal effective stress, shear, water.
    """
    by_side = path["p_component"].sum("component", skipna=False).transpose("side", "depth", "step")
    sides = {str(name): by_side.values[k] for k, name in enumerate(by_side["side"].values)}
    return {"net": by_side.sum("side", skipna=False).values, **sides}


def boundary_edges(section: xr.Dataset) -> Integers:
    """Return the edges that belong to a single cell of the section, shape (n_edge, 2), node numbers."""
    quads = section["section_quad"].transpose("section_cell", "corner").values.astype(int)
    edges = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    unique, count = np.unique(edges, axis=0, return_counts=True)
    return unique[(count == 1) & (unique[:, 0] != unique[:, 1])]


def caisson_size(section: xr.Dataset) -> tuple[float, float, float]:
    """Measure the caisson's hole in the section: inner radius, outer radius and skirt length [m].

    The skirt's walls are the vertical boundary edges that do not lie on the outer boundary of the soil. A
    section without a hole (steel meshed too) falls back on its attrs, and on NaN where they are silent.
    """
    x, depth = section["section_x"].values, section["section_depth"].values
    edges = boundary_edges(section)
    reach = np.abs(x).max()
    on_wall = np.isclose(x[edges[:, 0]], x[edges[:, 1]], atol=1e-6 * reach)
    on_wall &= np.abs(x[edges[:, 0]]) < reach * (1 - 1e-6)
    walls = edges[on_wall]
    if walls.size == 0:
        outer = float(section.attrs.get("outer_diameter_m", np.nan)) / 2
        thickness = float(section.attrs.get("skirt_thickness_m", np.nan))
        return outer - thickness, outer, float(section.attrs.get("skirt_length_m", np.nan))
    radii = np.abs(x[walls])
    return float(radii.min()), float(radii.max()), float(depth[walls].max())


def unit_text(values: Array) -> tuple[float, str]:
    """Choose (factor from N, kN or MN) for forces [N] of this size; moments take the same prefixes."""
    largest = float(np.nanmax(np.abs(values), initial=0.0))
    return (MN, "MN") if largest >= 1e6 else (KN, "kN")
