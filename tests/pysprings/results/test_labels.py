# SPDX-License-Identifier: MIT
"""Where the names of curves are written: by hand from the size of a letter, the distances and the directions."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Annotation

from pysprings.results.plots.labels import Box, label_beside, label_ends, last_point, spread

SIZE, TEXT = 8.5, "1.00 m"
HALF_WIDTH, HALF_HEIGHT = 0.62 * SIZE * len(TEXT) / 2, 1.25 * SIZE / 2  # a letter is 0.62 wide, a line 1.25 high
NEAR = 9.0  # points from the end of the curve to the text


@pytest.fixture
def axes() -> Axes:
    found = Figure(figsize=(8, 6)).subplots()
    found.set_xlim(0.0, 1.0)
    found.set_ylim(0.0, 1.0)
    return found


def line_to(axes: Axes, x: float, y: float) -> Line2D:
    (line,) = axes.plot([0.0, x], [y, y], color="red")
    return line


def centre(axes: Axes, x: float, y: float, degrees: float, reach: float = NEAR) -> tuple[float, float]:
    """Centre [pt] of the text of a curve that ends at (x, y), in a direction and at a distance."""
    at = axes.transData.transform((x, y)) * 72.0 / axes.figure.dpi
    angle = np.radians(degrees)
    return float(at[0] + (reach + HALF_WIDTH) * np.cos(angle)), float(at[1] + (reach + HALF_HEIGHT) * np.sin(angle))


def test_a_text_stands_right_of_its_curve_where_nothing_is(axes: Axes) -> None:
    line = line_to(axes, 0.5, 0.5)
    (box,) = label_ends(axes, [(line, TEXT)])
    assert (box.x, box.y) == pytest.approx(centre(axes, 0.5, 0.5, 0.0))
    assert (box.half_width, box.half_height) == pytest.approx((HALF_WIDTH, HALF_HEIGHT))
    (written,) = axes.texts
    assert isinstance(written, Annotation) and written.xy == (0.5, 0.5) and written.get_text() == TEXT
    assert written.xyann == pytest.approx((NEAR + HALF_WIDTH, 0.0), abs=1e-9)
    assert (written.get_ha(), written.get_va(), written.get_fontsize()) == ("center", "center", SIZE)


def test_texts_of_one_place_go_up_and_down_as_far_as_they_must(axes: Axes) -> None:
    """At 25 degrees two lines of text overlap still, at 50 they do not; then further ones, and further away."""
    lines = [line_to(axes, 0.5, 0.5) for _ in range(4)]
    boxes = label_ends(axes, [(line, TEXT) for line in lines])
    for box, degrees in zip(boxes[:3], (0.0, 50.0, -50.0), strict=True):
        assert (box.x, box.y) == pytest.approx(centre(axes, 0.5, 0.5, degrees))
    assert not any(boxes[3].overlap(other) for other in boxes[:3])
    assert (NEAR + HALF_HEIGHT) * np.sin(np.radians(25.0)) < 2.0 * HALF_HEIGHT


def test_a_text_stays_within_the_frame_and_off_the_curve(axes: Axes) -> None:
    """At the right edge: up and back, so that it covers no point of the curve."""
    (box,) = label_ends(axes, [(line_to(axes, 0.99, 0.5), TEXT)])
    assert (box.x, box.y) == pytest.approx(centre(axes, 0.99, 0.5, 155.0))
    (top,) = label_ends(axes, [(line_to(axes, 0.2, 0.999), TEXT)])
    assert top.y < centre(axes, 0.2, 0.999, 0.0)[1] - HALF_HEIGHT


def test_curves_without_a_number_have_no_name(axes: Axes) -> None:
    blank, short = (axes.plot([0.0, 0.3, 0.6], y)[0] for y in ([np.nan] * 3, [0.1, 0.2, np.nan]))
    assert last_point(blank) is None and last_point(short) == (0.3, 0.2)
    assert len(label_ends(axes, [(blank, "none"), (short, TEXT)])) == 1
    assert label_ends(axes, []) == []
    label_beside(axes, [blank])
    assert [text.get_text() for text in axes.texts] == [TEXT]


def test_names_beside_the_axes_stand_at_the_heights_of_their_ends(axes: Axes) -> None:
    """12 pt right of the axes; two of one height are a line of text apart, one above and one below."""
    for k, y in enumerate((0.2, 0.7, 0.7)):
        line_to(axes, 0.5, y).set_label(f"curve {k}")
    label_beside(axes, axes.get_lines(), size=9.0)
    assert [text.xy for text in axes.texts] == [(1.0, 0.2), (1.0, 0.7), (1.0, 0.7)]
    offsets = [text.xyann for text in axes.texts]
    np.testing.assert_allclose(offsets, [(12.0, 0.0), (12.0, -0.625 * 9.0), (12.0, 0.625 * 9.0)], atol=1e-9)
    assert {text.get_ha() for text in axes.texts} == {"left"} and axes.texts[1].get_text() == "curve 1"


def test_boxes_share_a_point_or_not() -> None:
    one = Box(0.0, 0.0, 2.0, 1.0)
    assert one.overlap(Box(3.9, 1.9, 2.0, 1.0)) and one.overlap(one)
    assert not one.overlap(Box(4.1, 0.0, 2.0, 1.0)) and not one.overlap(Box(0.0, -2.1, 2.0, 1.0))
    assert not one.overlap(Box(4.0, 0.0, 2.0, 1.0))
    points = np.array([[0.0, 0.0], [1.9, -0.9], [2.1, 0.0], [0.0, 1.1], [-1.0, 0.5]])
    assert one.holds(points) == 3


@pytest.mark.parametrize(
    ("heights", "expected"),
    [
        ([0.0, 1.0], [-0.5, 1.5]),
        ([1.0, 0.0, 3.0], [4.0 / 3.0, -2.0 / 3.0, 10.0 / 3.0]),  # 0 and 1 part; then 3 is too near: all keep their mean
        ([0.0, 2.0, 4.0], [0.0, 2.0, 4.0]),
        ([5.0, 5.0, 5.0], [3.0, 5.0, 7.0]),
        ([], []),
    ],
)
def test_heights_move_apart_about_their_mean(heights: list[float], expected: list[float]) -> None:
    found = spread(heights, 2.0)
    assert found == pytest.approx(expected)
