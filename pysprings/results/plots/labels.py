# SPDX-License-Identifier: MIT
"""Names of curves written at their ends, where they cover neither a curve nor each other."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.text import Annotation

from pysprings.results.plots.style import INK, CompressedLayout

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D
    from numpy.typing import NDArray

LETTER, LINE = 0.62, 1.25  # width of a letter and height of a line, over the font size
# Where a label may sit: distances [pt] from the end of its curve to the middle of the near edge of the text.
REACHES = (9.0, 16.0, 26.0, 38.0)
DIRECTIONS = np.radians([0, 25, -25, 50, -50, 75, -75, 180, 155, -155, 130, -130, 100, -100])


@dataclass(frozen=True)
class Box:
    """A text's rectangle [pt]: centre, half width, half height."""

    x: float
    y: float
    half_width: float
    half_height: float

    def overlap(self, other: Box) -> bool:
        """Return whether two rectangles share a point."""
        apart_x = abs(self.x - other.x) - self.half_width - other.half_width
        apart_y = abs(self.y - other.y) - self.half_height - other.half_height
        return apart_x < 0 and apart_y < 0

    def holds(self, points: NDArray[np.float64]) -> int:
        """Count the points (n, 2) [pt] inside the rectangle."""
        inside = (np.abs(points[:, 0] - self.x) < self.half_width) & (np.abs(points[:, 1] - self.y) < self.half_height)
        return int(inside.sum())


def last_point(line: Line2D) -> tuple[float, float] | None:
    """Return the last point (data units) of a line that is a number, None when it has none."""
    x, y = np.asarray(line.get_xdata(), dtype=float), np.asarray(line.get_ydata(), dtype=float)
    good = np.flatnonzero(np.isfinite(x + y))
    return (float(x[good[-1]]), float(y[good[-1]])) if good.size else None


def label_beside(axes: Axes, lines: Iterable[Line2D], size: float = 9.0) -> None:
    """Write names of curves in a column right of the axes, at the heights of their ends, moved apart where needed.

    The text is each line's label. Call after the limits are set; the layout makes room for the column.
    """
    ends = [(line, end) for line in lines if (end := last_point(line)) is not None]
    right = axes.get_xlim()[1]
    heights = [point[1] for point in _points(axes, [(right, end[1]) for _, end in ends])]
    for (line, end), height, free in zip(ends, heights, spread(heights, size * LINE), strict=True):
        _write(
            axes,
            str(line.get_label()),
            (right, end[1]),
            (12.0, free - height),
            "left",
            line.get_color(),
            size,
        )


def label_ends(axes: Axes, labels: Sequence[tuple[Line2D, str]], size: float = 8.5) -> list[Box]:
    """Write a text near the end of each curve, where it covers the least of curves and other texts.

    Call after the limits are set. Returns the rectangles of the texts [pt].
    """
    chosen = [(line, text, end) for line, text in labels if (end := last_point(line)) is not None]
    ends = _points(axes, [end for _, _, end in chosen])
    curves = np.concatenate([_samples(axes, line) for line in axes.get_lines()] or [np.zeros((0, 2))])
    frame = axes.get_window_extent().transformed(_to_points(axes))
    placed: list[Box] = []
    for (line, text, end), point in zip(chosen, ends, strict=True):
        boxes = [_candidate(point, text, size, reach, angle) for reach in REACHES for angle in DIRECTIONS]
        costs = [
            box.holds(curves)
            + 50 * sum(box.overlap(other) for other in placed)
            + 50 * (not _inside(box, frame))
            + k / 20
            for k, box in enumerate(boxes)
        ]
        best = boxes[int(np.argmin(costs))]
        placed.append(best)
        _write(axes, text, end, (best.x - point[0], best.y - point[1]), "center", line.get_color(), size)
    return placed


def _candidate(point: Sequence[float], text: str, size: float, reach: float, angle: float) -> Box:
    half_width, half_height = LETTER * size * len(text) / 2, LINE * size / 2
    x = point[0] + (reach + half_width) * np.cos(angle)
    y = point[1] + (reach + half_height) * np.sin(angle)
    return Box(float(x), float(y), half_width, half_height)


def _inside(box: Box, frame: Any) -> bool:
    return (
        frame.x0 < box.x - box.half_width
        and box.x + box.half_width < frame.x1
        and frame.y0 < box.y - box.half_height
        and box.y + box.half_height < frame.y1
    )


def _page(axes: Axes) -> Figure:
    """Return the whole figure, also where the axes are in a part of one."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    return figure


def _to_points(axes: Axes) -> Any:
    from matplotlib.transforms import Affine2D

    figure = _page(axes)
    return Affine2D().scale(72 / figure.dpi)


def _points(axes: Axes, data: Sequence[tuple[float, float]]) -> NDArray[np.float64]:
    """Return places on the page [pt] of points in data units, with the layout settled."""
    figure = _page(axes)
    engine = figure.get_layout_engine()
    if engine is None or isinstance(engine, CompressedLayout):
        figure.draw_without_rendering()
    else:
        engine.execute(figure)  # what a drawing begins with
    if not len(data):
        return np.zeros((0, 2))
    return np.asarray(axes.transData.transform(data) * 72 / figure.dpi)


def _samples(axes: Axes, line: Line2D) -> NDArray[np.float64]:
    """Return points [pt], about one per 2 pt, along a line drawn in data units."""
    if line.get_transform() != axes.transData:
        return np.zeros((0, 2))
    path = np.column_stack([np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)])
    corners = axes.transData.transform(path[np.isfinite(path).all(axis=1)]) * 72 / _page(axes).dpi
    if len(corners) < 2:
        return np.asarray(corners).reshape(-1, 2)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
    at = np.arange(0.0, along[-1] + 2.0, 2.0)
    return np.column_stack([np.interp(at, along, corners[:, k]) for k in (0, 1)])


def _write(
    axes: Axes,
    text: str,
    at: tuple[float, float],
    offset: tuple[float, float],
    ha: str,
    colour: Any,
    size: float,
) -> Annotation:
    """Write a text at an offset [pt] from a point (data units), with a thin line to it."""
    written = axes.annotate(
        text,
        at,
        xytext=offset,
        textcoords="offset points",
        va="center",
        ha=ha,
        fontsize=size,
        color=INK,
        annotation_clip=False,
        gid="end label",
        arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.7, "shrinkA": 0, "shrinkB": 1},
    )
    written.set_bbox({"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.85})
    return written


def spread(heights: Sequence[float], gap: float) -> list[float]:
    """Return heights moved apart to at least `gap`, keeping their order and, cluster by cluster, their mean.

    >>> spread([0.0, 0.0, 10.0], 2.0)
    [-1.0, 1.0, 10.0]
    """
    order = np.argsort(np.asarray(heights, dtype=float), kind="stable")
    clusters: list[tuple[float, int]] = []  # mean height, number of labels
    for k in order:
        clusters.append((float(heights[k]), 1))
        while len(clusters) > 1 and _crowded(clusters[-2], clusters[-1], gap):
            (mean_b, n_b), (mean_a, n_a) = clusters.pop(), clusters.pop()
            clusters.append(((mean_a * n_a + mean_b * n_b) / (n_a + n_b), n_a + n_b))
    moved = [mean + gap * (i - (n - 1) / 2) for mean, n in clusters for i in range(n)]
    result = [0.0] * len(moved)
    for position, k in zip(moved, order, strict=True):
        result[int(k)] = position
    return result


def _crowded(below: tuple[float, int], above: tuple[float, int], gap: float) -> bool:
    return above[0] - gap * (above[1] - 1) / 2 - (below[0] + gap * (below[1] - 1) / 2) < gap
