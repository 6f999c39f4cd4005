# SPDX-License-Identifier: MIT
"""The axes and signs of every file, as a drawing (SVG) for reports and the README.

``python -m pysprings.results.axes FILE.svg`` writes the drawing.
"""

import os
import sys
from pathlib import Path

_STYLE = """
  .t { font: 13px 'DejaVu Sans', Arial, sans-serif; fill: #1a1a1a; }
  .s { font: 12px 'DejaVu Sans', Arial, sans-serif; fill: #1a1a1a; }
  .b { font-weight: bold; }
  .i { font-style: italic; }
  .m { text-anchor: middle; }
  .e { text-anchor: end; }
  .axis { stroke: #1a1a1a; stroke-width: 1.8; fill: none; marker-end: url(#head); }
  .load { stroke: #D55E00; stroke-width: 2.6; fill: none; marker-end: url(#headload); }
  .soil { stroke: #0072B2; stroke-width: 1.6; fill: none; marker-end: url(#headsoil); }
  .dim { stroke: #7a7a7a; stroke-width: 1; fill: none; }
  .blue { fill: #0072B2; }
  .red { fill: #D55E00; }
"""

_HEADS = "".join(
    f'<marker id="{name}" viewBox="0 0 10 10" refX="8" refY="5" markerWidth="{size}" markerHeight="{size}" '
    f'orient="auto-start-reverse"><path d="M0 0 L10 5 L0 10 z" fill="{colour}"/></marker>'
    for name, size, colour in (("head", 6, "#1a1a1a"), ("headload", 5, "#D55E00"), ("headsoil", 6, "#0072B2"))
)

WIDTH, HEIGHT = 900, 520


def axes_svg() -> str:
    """Return the sketch of axes and signs as a self-contained SVG document."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" '
        f'height="{HEIGHT}" role="img" aria-label="Axes and signs of the caisson">'
        "<title>Axes and signs</title>"
        f"<style>{_STYLE}</style><defs>{_HEADS}</defs>"
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>'
        f"{_section()}{_plan()}{_rules()}</svg>\n"
    )


def write_axes_svg(file: str | os.PathLike[str]) -> Path:
    """Write the sketch to a file, whole or not at all, and return its path."""
    from pysprings.core.storage import write_text

    return write_text(axes_svg(), file)


def _text(x: float, y: float, text: str, style: str = "t") -> str:
    return f'<text class="{style}" x="{x}" y="{y}">{text}</text>'


def _line(x1: float, y1: float, x2: float, y2: float, style: str) -> str:
    return f'<line class="{style}" x1="{x1}" y1="{y1}" x2="{x2}" y2="{y2}"/>'


def _section() -> str:
    """Draw the caisson in the symmetry plane: mudline at y = 170, skirt 150 deep, axis at x = 270."""
    parts = [
        _text(30, 26, "Section in the symmetry plane, y away from you", "t b"),
        '<rect x="40" y="170" width="470" height="205" fill="#f5efe1"/>',
        _line(40, 170, 510, 170, "dim"),
        _text(506, 163, "mudline, z = 0", "s e"),
        '<path d="M150 150 H390 V320 H380 V170 H160 V320 H150 Z" fill="#4a4a4a"/>',
        _text(268, 300, "soil plug (inside)", "s m"),
        _text(452, 260, "outside", "s m"),
        _text(155, 336, "tip", "s m"),
        # displacement-conjugate axes at the lid centre
        '<circle cx="270" cy="170" r="4" fill="#1a1a1a"/>',
        _line(270, 170, 345, 170, "axis"),
        _line(270, 170, 270, 250, "axis"),
        _text(332, 190, "x, u", "t i"),
        _text(278, 247, "z, w, V", "t i"),
        '<circle cx="238" cy="196" r="7" fill="white" stroke="#1a1a1a" stroke-width="1.5"/>',
        '<path d="M233 191 L243 201 M243 191 L233 201" stroke="#1a1a1a" stroke-width="1.5"/>',
        _text(226, 200, "y", "t i e"),
        # load at height h
        _line(270, 150, 270, 72, "dim"),
        _line(270, 72, 345, 72, "load"),
        _text(352, 77, "H &gt; 0", "t b red"),
        '<path class="dim" d="M120 72 V170 M114 72 H126 M114 170 H126"/>',
        _line(126, 72, 270, 72, "dim"),
        _text(108, 126, "h", "t i e"),
        # rotation: right-hand about y, which points away = clockwise as seen here
        '<path class="axis" d="M222 128 A 52 52 0 0 1 318 128"/>',
        _text(335, 118, "rotation, M &gt; 0", "s"),
        _text(335, 134, "(it leans towards +x)", "s"),
        # reactions of the soil
        _line(470, 215, 396, 215, "soil"),
        _text(474, 211, "p(z)", "t i blue"),
        _line(398, 300, 398, 248, "soil"),
        _text(405, 292, "t(z), m(z)", "t i blue"),
        _line(236, 342, 166, 342, "soil"),
        _text(242, 346, "H_tip", "t i blue"),
        '<path class="dim" d="M64 170 V320 M58 170 H70 M58 320 H70"/>',
        _text(54, 250, "L", "t i e"),
    ]
    return "".join(parts)


def _plan() -> str:
    """Draw the plan, seen from above: centre at (700, 205), radius 95."""
    parts = [
        _text(560, 26, "Plan, seen from above", "t b"),
        '<path d="M605 205 A 95 95 0 0 1 795 205 Z" fill="#f5efe1"/>',
        '<circle cx="700" cy="205" r="95" fill="none" stroke="#4a4a4a" stroke-width="6"/>',
        _line(700, 205, 860, 205, "axis"),
        _line(700, 205, 700, 65, "axis"),
        _text(864, 210, "x", "t i"),
        _text(708, 72, "y", "t i"),
        _line(545, 205, 596, 205, "load"),
        _text(545, 195, "H", "t b red"),
        _text(808, 195, "front", "s"),
        _text(808, 228, "θ = 0", "s"),
        _text(590, 232, "back", "s e"),
        _text(590, 248, "θ = 180°", "s e"),
        _text(722, 84, "θ = 90°", "s"),
        '<path class="axis" d="M750 205 A 50 50 0 0 0 735.4 169.6"/>',
        _text(752, 180, "θ", "t i"),
        _line(700, 205, 758, 147, "dim"),
        _text(652, 170, "modelled", "s m"),
        _text(652, 185, "half", "s m"),
    ]
    return "".join(parts)


def _rules() -> str:
    """Write the rules that a drawing cannot show."""
    rows = [
        "u_x(z) = u &#8722; rotation·z = y(z) &#160;&#160;&#160; "
        "u_z(x) = w + rotation·x &#160;&#160;&#160; "
        "w, V positive down (heave is w &lt; 0) &#160;&#160;&#160; a load H at height h gives M = H·h",
        "Soil reactions (blue) are positive when they oppose a positive displacement: &#160; "
        "H = Σ p dz + H_tip + H_lid &#160;&#160;&#160; V = Σ t dz + V_tip + V_lid",
        "M = &#8722;(Σ p z dz + L·H_tip) + Σ m dz + M_tip + M_lid, about the lid centre at mudline",
        "Effective normal stress p'_N: compression positive. Gap ≥ 0. "
        "F_in, F_out: vertical force on the soil, down positive.",
        "Loads and reactions are those of the whole caisson. Units in data files: m, N, Pa, s, rad.",
    ]
    return "".join(_text(30, 412 + 22 * k, row, "s") for k, row in enumerate(rows))


if __name__ == "__main__":
    write_axes_svg(sys.argv[1] if len(sys.argv) > 1 else "docs/axes.svg")
