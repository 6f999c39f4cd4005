# SPDX-License-Identifier: MIT
"""What a figure shows, in lines of text: panels, titles, axes, curves, marks, keys, colours. Nothing is rendered.

Numbers have four digits. Where labels end up after they have been moved apart depends on the fonts and is left out.
"""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import Collection, QuadMesh
from matplotlib.colors import Normalize, to_hex
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch, Patch
from matplotlib.spines import Spine
from matplotlib.text import Annotation, Text
from matplotlib.ticker import FixedLocator


def describe(figure: Figure) -> list[str]:
    """Return the lines of a figure: its size and title, then each panel in order."""
    width, height = figure.get_size_inches()
    engine = figure.get_layout_engine()
    compressed = bool(getattr(engine, "_compress", False))
    lines = [f"figure {number(width)} x {number(height)} in{' compressed' * compressed}: {figure.get_suptitle()!r}"]
    for legend in figure.legends:
        lines += indented(_legend(legend))
    lines += indented(_text(text) for text in figure.texts if text is not figure._suptitle)  # type: ignore[attr-defined]
    for axes in figure.axes:
        lines += indented(_bar(axes) if axes.get_subplotspec() is None else _panel(axes))
    return lines


def number(value: Any) -> str:
    """Return a number with four digits; rounding errors are zero."""
    value = float(value)
    return f"{0.0 if abs(value) < 1e-12 else value:.4g}"


def numbers(values: Iterable[Any]) -> str:
    return ", ".join(number(value) for value in values)


def indented(lines: Iterable[str]) -> Iterator[str]:
    return (f"  {line}" for line in lines)


def spread(values: Any) -> str:
    """Return the first, last, smallest, largest, mean of data; how many, how many of them are blank."""
    found = np.ma.filled(np.ma.asarray(values, dtype=float), np.nan).ravel()
    good = found[np.isfinite(found)]
    if not good.size:
        return f"{found.size} blank"
    blank = f", {found.size - good.size} blank" if good.size < found.size else ""
    ends = good[0], good[-1], good.min(), good.max(), good.mean()
    return f"{found.size}{blank}: {numbers(ends)}" if np.ptp(good) else f"{found.size}{blank}: {number(good[0])}"


def colour(value: Any) -> str:
    if value is None or (isinstance(value, str) and value == "none"):
        return "none"
    found = np.atleast_2d(np.asarray(value, dtype=float)) if not isinstance(value, str) else None
    if found is not None:
        return " ".join(dict.fromkeys(to_hex(row, keep_alpha=row[-1] < 1.0) for row in found[:8])) or "none"
    return to_hex(value)


def _bar(axes: Axes) -> Iterator[str]:
    """Yield the lines of a panel without a place of its own: a bar of colours."""
    yield f"bar {_axis('y', axes)}"
    for artist in axes.collections:
        if not isinstance(artist, QuadMesh) and len(artist.get_paths()):
            yield f"  {_collection(artist)}"


def _panel(axes: Axes) -> Iterator[str]:
    place = axes.get_subplotspec()
    assert place is not None
    titles = [axes.get_title(loc=where) for where in ("left", "center", "right")]
    sides = " ".join(name for name, spine in axes.spines.items() if spine.get_visible())
    yield f"panel {place.rowspan.start}, {place.colspan.start} {next(filter(None, titles), '')!r}"
    yield f"  {_axis('x', axes)}"
    yield f"  {_axis('y', axes)}"
    grid = any(line.get_visible() for line in axes.get_xgridlines())
    look = f"aspect {axes.get_aspect()}, grid {grid}, axes {axes.axison}, sides {sides or 'none'}"
    yield f"  {look}, ground {colour(axes.get_facecolor())}"
    for artist in axes.get_children():
        if isinstance(artist, Line2D):
            yield f"  {_line(artist)}"
        elif isinstance(artist, Text):
            if artist.get_text() and artist not in (axes.title, axes._left_title, axes._right_title):  # type: ignore[attr-defined]
                yield f"  {_text(artist)}"
        elif isinstance(artist, Legend):
            yield from indented(_legend(artist))
        elif isinstance(artist, Collection):
            yield f"  {_collection(artist)}"
        elif isinstance(artist, AxesImage):
            values = spread(artist.get_array())
            yield f"  image {numbers(artist.get_extent())}, {_shade(artist)}, values {values}{_rest(artist)}"
        elif isinstance(artist, Patch) and not isinstance(artist, Spine) and artist is not axes.patch:
            yield f"  {_patch(artist)}"


def _axis(name: str, axes: Axes) -> str:
    axis = axes.xaxis if name == "x" else axes.yaxis
    low, high = axes.get_xlim() if name == "x" else axes.get_ylim()
    line = f"{name}: {axis.get_label_text()!r} {axis.get_scale()} from {number(low)} to {number(high)}"
    if isinstance(axis.get_major_locator(), FixedLocator):
        line += f", ticks {numbers(axis.get_majorticklocs())}"
        labels = [text.get_text() for text in axis.get_ticklabels()]
        line += f" {labels}" if any(labels) else ""
    elif getattr(axis.get_major_locator(), "_integer", False):
        line += ", whole numbers"
    return line


def _line(line: Line2D) -> str:
    x, y = (spread(values) for values in line.get_data())
    look = f"{line.get_linestyle()} {number(line.get_linewidth())} {colour(line.get_color())}"
    if not _bare(line):
        inner = colour(line.get_markerfacecolor())
        face = "" if inner == colour(line.get_color()) else f" {inner}"
        edge = f" edge {number(line.get_markeredgewidth())}"
        look += f" marker {line.get_marker()} {number(line.get_markersize())}{face}{edge}"
        every = line.get_markevery()
        look += f" every {every}" if every is not None else ""
    label = "" if str(line.get_label()).startswith("_child") else f" {line.get_label()!r}"
    return f"line{label} {look} | x {x} | y {y}{_rest(line)}"


def _bare(line: Line2D) -> bool:
    return line.get_marker() in ("None", None, "")


def _text(text: Text) -> str:
    place = text.xy if isinstance(text, Annotation) else text.get_position()
    look = f"{text.get_ha()} {text.get_va()} {number(text.get_fontsize())} {colour(text.get_color())}"
    arrow = f" arrow {_patch(text.arrow_patch)}" if isinstance(text, Annotation) and text.arrow_patch else ""
    turned = f" turned {number(text.get_rotation())}" if text.get_rotation() else ""
    box = f" in {_patch(text.get_bbox_patch())}" if text.get_bbox_patch() else ""
    return f"text {text.get_text()!r} at {numbers(place)} {look}{turned}{arrow}{box}{_rest(text)}"


def _patch(patch: Patch) -> str:
    place = ""
    if not isinstance(patch, FancyArrowPatch | FancyBboxPatch):  # their places depend on the fonts
        place = f" {numbers(patch.get_path().transformed(patch.get_patch_transform()).get_extents().extents)}"
    face = colour(patch.get_facecolor()) if patch.get_fill() else "none"
    look = f"face {face} edge {colour(patch.get_edgecolor())} {patch.get_linestyle()} {number(patch.get_linewidth())}"
    hatch = f" hatch {patch.get_hatch()}" if patch.get_hatch() else ""
    return f"{type(patch).__name__}{place} {look}{hatch}{_rest(patch)}"


def _collection(each: Collection) -> str:
    paths = [path for path in each.get_paths() if path.vertices.size]
    corners = np.concatenate([path.vertices for path in paths]) if paths else np.empty((0, 2))
    offsets = np.ma.filled(np.ma.asarray(each.get_offsets(), dtype=float), np.nan)
    where = f"{len(paths)} paths x {spread(corners[:, 0])} | y {spread(corners[:, 1])}"
    if offsets.any():
        where += f" | at x {spread(offsets[:, 0])} | y {spread(offsets[:, 1])}"
    look = f"face {colour(each.get_facecolor())} edge {colour(each.get_edgecolor())}"
    values = f", {_shade(each)}, values {spread(each.get_array())}" if each.get_array() is not None else ""
    widths = numbers(sorted(set(np.atleast_1d(each.get_linewidth()).tolist())))
    label = "" if str(each.get_label()).startswith("_child") else f" {each.get_label()!r}"
    return f"{type(each).__name__}{label} {where} | {look} {widths}{values}{_rest(each)}"


def _shade(each: Any) -> str:
    norm: Normalize = each.norm
    return f"{each.get_cmap().name} {type(norm).__name__} {number(norm.vmin)} to {number(norm.vmax)}"


def _legend(legend: Legend) -> Iterator[str]:
    title = legend.get_title().get_text()
    yield f"legend loc {legend._loc_real} columns {legend._ncols} frame {legend.get_frame_on()} {title!r}".rstrip("' ")  # type: ignore[attr-defined]
    for handle, text in zip(legend.legend_handles, legend.get_texts(), strict=True):
        if isinstance(handle, Line2D):
            marker = "" if _bare(handle) else f" {handle.get_marker()} {number(handle.get_markersize())}"
            look = f"{handle.get_linestyle()} {number(handle.get_linewidth())} {colour(handle.get_color())}{marker}"
        elif isinstance(handle, Patch):
            hatch = f" hatch {handle.get_hatch()}" if handle.get_hatch() else ""
            look = f"face {colour(handle.get_facecolor())} edge {colour(handle.get_edgecolor())}{hatch}"
        else:
            look = type(handle).__name__
        yield f"  {text.get_text()!r} {look}"


def _rest(artist: Artist) -> str:
    """Return the order, name, clipping and transparency, where they are not the usual ones."""
    usual = {Line2D: 2, Text: 3, Patch: 1, Collection: 1, AxesImage: 0}
    order = next(value for kind, value in usual.items() if isinstance(artist, kind))
    parts = [f"order {number(artist.get_zorder())}"] if artist.get_zorder() != order else []
    parts += [f"name {artist.get_gid()}"] if artist.get_gid() else []
    parts += [f"alpha {number(np.max(artist.get_alpha()))}"] if artist.get_alpha() is not None else []
    parts += ["pixels"] if artist.get_rasterized() else []
    parts += ["hidden"] if not artist.get_visible() else []
    return "".join(f", {part}" for part in parts)
