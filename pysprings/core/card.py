# SPDX-License-Identifier: MIT
"""Compact HTML of an object for notebooks: a title, a few lines of text, and small drawings (light: plain SVG)."""

from collections.abc import Iterable, Mapping, Sequence
from html import escape

Point = tuple[float, float]

WIDTH, HEIGHT = 230, 150  # px of a drawing
_MARGIN = 26  # px
MOST_POINTS = 24  # of a curve
_TEXT = 'font-size="10" fill="currentColor" font-family="sans-serif"'


def card(title: str, lines: Mapping[str, str], drawings: Iterable[str] = ()) -> str:
    """Return HTML with a title, a row for each line that has a text, and drawings beside them; all text is escaped."""
    rows = "".join(
        f'<tr><th style="text-align:left;vertical-align:top">{escape(name)}</th>'
        f'<td style="text-align:left">{escape(text)}</td></tr>'
        for name, text in lines.items() if text
    )  # fmt: skip
    return (
        '<div style="display:flex;flex-wrap:wrap;gap:1em;align-items:flex-start">'
        f'<div style="max-width:44em"><b>{escape(title)}</b><table style="margin:0">{rows}</table></div>'
        f"{''.join(drawings)}</div>"
    )


def caisson_drawing(diameter: float, length: float, layers: Sequence[tuple[float, str]] = ()) -> str:
    """Return the caisson in its ground as SVG, to scale: layers are (depth of the top [m], name)."""
    deepest = 2.0 * length
    scale = min((HEIGHT - 2 * 12) / deepest, 0.5 * WIDTH / diameter)
    middle, top = 0.5 * WIDTH, 22.0
    left, right, tip = middle - 0.5 * scale * diameter, middle + 0.5 * scale * diameter, top + scale * length
    parts = [
        f'<rect x="0" y="{top}" width="{WIDTH}" height="{HEIGHT - top}" fill="currentColor" fill-opacity="0.08"/>',
        f'<path d="M{left:.1f} {tip:.1f}V{top}H{right:.1f}V{tip:.1f}" fill="none" stroke="currentColor" '
        'stroke-width="3"/>',
        f'<text x="{middle}" y="{top - 8}" text-anchor="middle" {_TEXT}>D {diameter:g} m</text>',
        f'<text x="{right + 5:.1f}" y="{tip:.1f}" {_TEXT}>L {length:g} m</text>',
    ]
    for depth, name in layers:
        if depth < 0.95 * deepest:
            y = top + scale * depth
            parts.append(f'<path d="M0 {y:.1f}H{WIDTH}" stroke="currentColor" stroke-opacity="0.5"/>')
            parts.append(f'<text x="3" y="{y + 11:.1f}" {_TEXT}>{escape(name[:18])}</text>')
    return _svg("caisson", parts)


def curves_drawing(curves: Sequence[Sequence[Point]], x: str, y: str) -> str:
    """Return curves, sequences of (x, y), as SVG in a frame that holds zero; the axes have their largest values."""
    points = [point for curve in curves for point in curve]
    if not points:
        return ""
    low_x, high_x = min(0.0, *(p[0] for p in points)), max(0.0, *(p[0] for p in points))
    low_y, high_y = min(0.0, *(p[1] for p in points)), max(0.0, *(p[1] for p in points))
    wide, high = (high_x - low_x) or 1.0, (high_y - low_y) or 1.0

    def place(point: Point) -> str:
        across = _MARGIN + (WIDTH - 2 * _MARGIN) * (point[0] - low_x) / wide
        up = HEIGHT - _MARGIN - (HEIGHT - 2 * _MARGIN) * (point[1] - low_y) / high
        return f"{across:.1f},{up:.1f}"

    lines = [
        f'<polyline points="{" ".join(place(p) for p in thinned(curve))}" fill="none" stroke="#0072B2"/>'
        for curve in curves
    ]
    axes = [
        f'<polyline points="{place(a)} {place(b)}" stroke="currentColor" stroke-opacity="0.5"/>'
        for a, b in (((low_x, 0.0), (high_x, 0.0)), ((0.0, low_y), (0.0, high_y)))
    ]
    words = [
        f'<text x="{WIDTH - 4}" y="{HEIGHT - 8}" text-anchor="end" {_TEXT}>{escape(x)} to {high_x:.3g}</text>',
        f'<text x="4" y="14" {_TEXT}>{escape(y)} to {high_y:.3g}</text>',
    ]
    return _svg(f"{y} over {x}", [*axes, *lines, *words])


def thinned(curve: Sequence[Point]) -> list[Point]:
    """Return at most `MOST_POINTS` points of a curve, the first and the last among them."""
    if len(curve) <= MOST_POINTS:
        return list(curve)
    return [curve[round(k * (len(curve) - 1) / (MOST_POINTS - 1))] for k in range(MOST_POINTS)]


def _svg(label: str, parts: Iterable[str]) -> str:
    return (
        f'<svg width="{WIDTH}" height="{HEIGHT}" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" '
        f'aria-label="{escape(label)}">{"".join(parts)}</svg>'
    )
