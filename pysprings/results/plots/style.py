# SPDX-License-Identifier: MIT
"""How every figure looks: palette, units for people, titles, marks of unconverged steps."""

import functools
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from io import BytesIO
from textwrap import fill
from typing import Any, ParamSpec, cast

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure, SubFigure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from numpy.typing import ArrayLike

from pysprings.core.arrays import Array, Marks
from pysprings.results.look import BLUE, GREEN, GREY, INK, KN, KPA, MM, MN, MRAD, ORANGE, PALE, PURPLE, SKY, VERMILLION

# the palette and units of pictures, for those that draw with this module
__all__ = [
    "BLUE", "GREEN", "GREY", "INK", "KN", "KPA", "MM", "MN", "MRAD", "ORANGE", "PALE", "PURPLE", "SKY", "VERMILLION",
]  # fmt: skip

NOTEBOOK_DPI = 80
DEG = 180 / np.pi

SURFACE_COLOURS = {"outer": BLUE, "inner": ORANGE, "lid": GREEN, "tip": PURPLE}
SIDE_COLOURS = {"outside": BLUE, "inside": ORANGE}
STEEL, SOIL = "#4a4a4a", "#f5efe1"

# One colour map has one meaning in all figures
DEPTH_COLOURS = "viridis_r"  # shallow to deep
LEVEL_COLOURS = "cividis_r"  # small to large loads
PATH_COLOURS = "turbo"  # load paths of a run
GAP_COLOURS = "YlOrRd"  # narrow to wide gaps
SIGNED_COLOURS = "RdBu_r"  # displacement and pressure, symmetric about zero
RADIUS_COLOURS = "copper_r"  # inner to outer stations of the tip; none is the white of the page

# Any: the type of rc parameters lists every key by name.
STYLE: Any = {
    "font.family": ["DejaVu Sans"],
    "font.size": 10.0,
    "axes.titlesize": 10.5,
    "axes.labelsize": 10.0,
    "legend.fontsize": 9.0,
    "xtick.labelsize": 9.0,
    "ytick.labelsize": 9.0,
    "figure.titlesize": 12.0,
    "axes.grid": True,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlelocation": "left",
    "lines.linewidth": 1.8,
    "text.usetex": False,
    "svg.hashsalt": "pysprings",
    "legend.frameon": False,
    "figure.facecolor": "white",
    "axes.formatter.useoffset": False,
    "axes.unicode_minus": True,
    "hatch.linewidth": 0.8,
}

Arguments = ParamSpec("Arguments")


def styled(draw: Callable[Arguments, Figure]) -> Callable[Arguments, Figure]:
    """Return a drawing function that uses the settings of this module, not those of the caller."""

    @functools.wraps(draw)
    def wrapper(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Figure:
        with mpl.rc_context(STYLE):
            return draw(*args, **kwargs)

    return wrapper


class CompressedLayout(ConstrainedLayoutEngine):
    """Layout of panels of equal aspect, which have their place only once they are drawn."""


_TARGET: ContextVar[Figure | SubFigure | None] = ContextVar("_TARGET", default=None)


@contextmanager
def drawn_on(target: Figure | SubFigure | None) -> Iterator[None]:
    """Draw the pictures of a block on a figure, or on a part of one (`Figure.subfigures`), in the place of new ones."""
    token = _TARGET.set(target)
    try:
        yield
    finally:
        _TARGET.reset(token)


class Drawing(Figure):
    """A figure that notebooks show without pyplot."""

    def _repr_png_(self) -> bytes:
        stream = BytesIO()
        with mpl.rc_context(STYLE):
            self.savefig(stream, format="png", dpi=NOTEBOOK_DPI)
        return stream.getvalue()


def new_figure(width: float, height: float, compressed: bool = False) -> Figure:
    """Return an empty figure of this size [inch], drawn by Agg, outside pyplot; the emptied target of `drawn_on`.

    `compressed` closes the empty room between panels of equal aspect.
    """
    target = _TARGET.get()
    if target is not None:
        target.clear()
        return cast(Figure, target)  # parts of figures have all methods that pictures use
    figure = Drawing(figsize=(width, height))
    FigureCanvasAgg(figure)
    layout = CompressedLayout if compressed else ConstrainedLayoutEngine
    figure.set_layout_engine(layout(w_pad=0.08, h_pad=0.08, compress=compressed))
    return figure


LETTERS = 10.5  # of a title that an inch holds
CAVITATES = "no capacity where water would cavitate, beyond"


def headline(attrs: Mapping[str, Any]) -> str:
    """Return what every title states: path, drainage, diameter D and skirt length L [m], an early stop."""
    parts = [f"path {plain(attrs['path'])}"] if attrs.get("path") else []
    parts += [plain(attrs["drainage"])] if attrs.get("drainage") else []
    if np.isfinite(attrs.get("outer_diameter_m", np.nan)):
        parts.append(f"D = {attrs['outer_diameter_m']:g} m, L = {attrs.get('skirt_length_m', np.nan):g} m")
    status = attrs.get("status", "complete")
    if status == "limit load":
        parts.append("to its limit load")
    elif status != "complete":
        parts.append(f"{plain(status)}: stopped before its end")
    if "cavitates" in attrs:
        parts.append(f"{CAVITATES} {attrs['cavitates']}")
    return "  |  ".join(parts)


def plain(text: object) -> str:
    """Return text from a scene so that matplotlib does not read it as a formula."""
    return str(text).replace("$", r"\$")


def set_title(figure: Figure, what: str, attrs: Mapping[str, Any], *more: str) -> None:
    """Write the figure's title: what it shows, then the settings of the run, then remarks; wide lines are wrapped."""
    most = int(LETTERS * figure.bbox.width / figure.dpi)
    figure.suptitle("\n".join(fill(line, most) for line in (what, headline(attrs), *more) if line))


def plot_path(axes: Axes, x: ArrayLike, y: ArrayLike, good: Marks, **line: Any) -> Array:
    """Draw a curve through its converged steps and a cross at each unconverged one; the line stops there.

    Returns the drawn ordinates of the line, NaN where unconverged.
    """
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    valid = np.where(good, y, np.nan)
    (drawn,) = axes.plot(x, valid, **line)
    bad = ~good & np.isfinite(x) & np.isfinite(y)
    if bad.any():
        axes.plot(
            x[bad],
            y[bad],
            linestyle="none",
            marker="x",
            markersize=8,
            markeredgewidth=1.8,
            color=drawn.get_color(),
            label="_unconverged",
            gid="unconverged",
            zorder=5,
        )
    return valid


def note_unconverged(axes: Axes, good: Marks) -> None:
    """Explain the crosses beside the curves, when there are any."""
    if not good.all():
        axes.plot([], [], linestyle="none", marker="x", markeredgewidth=1.8, color=INK, label="not converged")


def legend_beside(axes: Axes, size: float = 9.0, title: str = "") -> None:
    """Name the labelled curves of a panel right of it, in the order of the heights of their ends."""
    ends = {}
    for line in axes.get_lines():
        drawn = np.asarray(line.get_ydata(), dtype=float)
        good = drawn[np.isfinite(drawn)]
        if good.size and not str(line.get_label()).startswith("_"):
            ends[line] = float(good[-1])
    handles = sorted(ends, key=lambda line: -ends[line])
    axes.legend(handles=handles, loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=size, title=title or None)


def zero_lines(axes: Axes) -> None:
    """Draw the axes through zero that the view contains."""
    low, high = sorted(axes.get_ylim())
    if low < 0 < high:
        axes.axhline(0.0, color=GREY, linewidth=0.8, zorder=1)
    low, high = sorted(axes.get_xlim())
    if low < 0 < high:
        axes.axvline(0.0, color=GREY, linewidth=0.8, zorder=1)
