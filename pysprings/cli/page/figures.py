# SPDX-License-Identifier: MIT
"""Figures of the page in the colours of all pictures: load over motion, reactions by depth, H and M, the ground."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from pandas import DataFrame

from pysprings.cli.page.answers import Answer, load_of, profiles
from pysprings.core.loads import close_loads
from pysprings.core.words import RANGE_END
from pysprings.macro.capacity import NOT_AT_V
from pysprings.macro.fan_springs import BAND
from pysprings.results import look

if TYPE_CHECKING:
    from pysprings.scene.model import Scene

Figure = dict[str, Any]
FONT = {"family": "DejaVu Sans, Verdana, sans-serif", "size": 11, "color": look.INK}
REACTIONS = {"p": ("p [kN/m]", look.BLUE), "m": ("m [kN m/m]", look.PURPLE), "t": ("t [kN/m]", look.GREEN)}
MOST_NAMES = 12  # of loads that are written beside them
BESIDE = ("top right", "bottom right", "top left", "bottom left")
PICTURE = (6.4, 3.5)  # inch


def figure(title: str, traces: list[Figure], **layout: Any) -> Figure:
    """Return a figure of plotly with the look of the page."""
    axes = {name: {"gridcolor": "#dddddd", "zerolinecolor": look.GREY, "automargin": True} | given
            for name, given in layout.items() if name[1:5] == "axis"}  # fmt: skip
    rest = {name: given for name, given in layout.items() if name not in axes}
    return {
        "data": traces,
        "layout": {
            "title": {"text": title, "x": 0.01, "y": 0.98, "yanchor": "top", "font": {"size": 12}},
            "font": FONT, "margin": {"l": 48, "r": 10, "t": 24, "b": 34}, "paper_bgcolor": "white",
            "plot_bgcolor": "white", "showlegend": False, "hovermode": "closest", **axes, **rest,
        },
    }  # fmt: skip


def line(x: Any, y: Any, name: str, colour: str, **more: Any) -> Figure:
    """Return a curve."""
    return {"type": "scatter", "mode": "lines", "x": np.asarray(x).tolist(), "y": np.asarray(y).tolist(), "name": name,
            "line": {"color": colour, "width": 2}, **more}  # fmt: skip


def dots(x: Any, y: Any, name: str, colour: str, symbol: str, texts: list[str] | None = None, size: int = 9) -> Figure:
    """Return points, with texts beside them."""
    return line(x, y, name, colour, mode="markers+text" if texts else "markers", text=texts or "",
                textposition="top right", cliponaxis=False,
                marker={"symbol": symbol, "size": size, "color": colour, "line": {"width": 1.5}})  # fmt: skip


def room(values: Any, share: float = 0.08) -> list[float]:
    """Return an axis from 0 or the least to 0 or the largest of values, with room at its ends."""
    known = [0.0, *np.asarray(values)[np.isfinite(values)]]
    more = share * (max(known) - min(known)) or 1.0
    return [min(known) - more, max(known) + more]


def load_over_motion(answer: Answer) -> Figure:
    """Draw H over u (M over the rotation without H) up to the largest known load, the answer and its band of 95 %."""
    force = answer.question is None or bool(answer.question.H) or not answer.question.M
    load, motion = ("H", "u") if force else ("M", "rotation")
    heads = ("u [mm]", "H [MN]") if force else ("rotation [mrad]", "M [MN m]")
    drawn = [each for each in (answer.onward, answer.way) if each is not None]
    ways = [(look.MM * each[motion].values, look.MN * each[load].values) for each in drawn]
    traces, words = [line(*way, "known", look.GREY) for way in ways[:1]], ""
    if drawn and f"{motion}_deviation" in drawn[0]:
        words = ", band of 95 %"
        traces.insert(0, _band(*ways[0], look.MM * drawn[0][f"{motion}_deviation"].values))
    if answer.way is not None:
        x, y = ways[-1]
        traces += [line(x, y, "way", look.BLUE), dots(x[-1:], y[-1:], "answer", look.VERMILLION, "circle", ["answer"])]
    elif answer.question is not None:
        words += "; no answer to the load"
    across, along = (room(np.concatenate([[0.0], *(way[k] for way in ways)])) for k in (0, 1))
    axes = {"xaxis": {"title": {"text": heads[0]}, "range": across}}
    return figure(f"Load against motion{words}", traces, **axes, yaxis={"title": {"text": heads[1]}, "range": along})


def _band(x: Any, y: Any, deviation: Any) -> Figure:
    known = np.isfinite(deviation)
    x, width, load, sign = x[known], BAND * deviation[known], y[known], np.sign(x.sum())
    low, high = sign * np.maximum(sign * x - width, 0.0), x + sign * width  # no motion against the load
    around = line(np.append(low, high[::-1]), np.append(load, load[::-1]), "band of 95 %", look.SKY, fill="toself")
    return around | {"line": {"width": 0}, "opacity": 0.4, "hoverinfo": "skip"}


def by_depth(answer: Answer) -> Figure:
    """Draw p, m and t of the answer over depth."""
    found = profiles(answer)
    end = [] if answer.model is None else [answer.model.length, 0.0]
    axes: Figure = {"yaxis": {"title": {"text": "depth [m]"}, "range": end or None}}
    traces, width = [], 1.0 / max(len(found), 1)
    for k, (name, (depth, values)) in enumerate(found.items()):
        words, colour = REACTIONS[name]
        own = f"x{k + 1}" if k else "x"
        traces.append(line(look.KN * values, depth, words, colour, xaxis=own, mode="lines+markers", marker={"size": 5}))
        axes[f"xaxis{k + 1}" if k else "xaxis"] = {
            "title": {"text": words}, "domain": [k * width + 0.04 * bool(k), (k + 1) * width - 0.03], "nticks": 3,
            "tickangle": 0, "rangemode": "tozero",
        }  # fmt: skip
    return figure("Reactions by depth, of the answer" if found else "Reactions by depth: no answer", traces, **axes)


def envelope(answer: Answer) -> Figure:
    """Draw the largest known loads in the plane of H and M, the load and the load cases."""
    traces = []
    if answer.around is not None:
        H, M = (look.MN * np.concatenate([each, -each, each[:1]]) for each in (answer.around.H, answer.around.M))
        kinds = np.concatenate([answer.around.kind] * 2 + [answer.around.kind[:1]])
        traces.append(line(H, M, "largest known load", look.GREY))
        for ends, symbol, name in ((False, "circle", "capacity"), (True, "triangle-down-open", "end of the range")):
            at = (kinds == RANGE_END) == ends
            if at.any():
                traces.append(dots(H[at], M[at], name, look.GREEN, symbol, size=6))
    loads, others = [], False
    if answer.question is not None:
        loads = [("load", *load_of(answer.question), look.VERMILLION, "circle" if answer.way is not None else "x")]
    if answer.model is not None and answer.question is not None and isinstance(answer.cases, DataFrame):
        V = answer.model.rest_load if answer.question.V is None else answer.question.V
        near = close_loads(answer.cases["V_N"].fillna(V).to_numpy(float), V)
        others = not bool(near.all())
        for row, close in zip(answer.cases.to_dict("records"), near, strict=True):
            colour, symbol = (
                (look.CASE_MARKS.get(row["verdict"], look.OTHER_CASE)[1], "square")
                if close
                else (look.GREY, "square-open")
            )
            loads.append((row["name"], row["H_N"], row["M_Nm"], colour, symbol))
    for k, (name, force, moment, colour, symbol) in enumerate(loads):
        texts = [name] if len(loads) <= MOST_NAMES else None
        traces.append(dots([look.MN * force], [look.MN * moment], name, colour, symbol, texts, 6 if k else 9))
        traces[-1]["textposition"] = BESIDE[k % len(BESIDE)]
    across, along = (room([x for each in traces for x in each[axis]], 0.25) for axis in "xy")
    notes = ["triangles: the springs end there"] * any(each["name"] == "end of the range" for each in traces)
    notes += ["grey: cases of another V"] * others
    axes = {"xaxis": {"title": {"text": "H [MN]"}, "range": across}}
    known = answer.around is not None and bool(np.isfinite(answer.around.H).any())
    sources: Any = () if answer.around is None else answer.around.source
    where = next((text.rpartition("; at ")[2] for text in sources if text.endswith(NOT_AT_V)), "this V")
    title = "; ".join([f"{'Largest known loads' if known else 'No largest load is known'} at {where}", *notes])
    return figure(title, traces, **axes, yaxis={"title": {"text": "M [MN m]"}, "range": along})


def ground_picture(scene: Scene) -> str:
    """Return the picture of caisson and ground as a data URI of a PNG."""
    import xarray as xr

    from pysprings.results.plots.files import content_of
    from pysprings.results.plots.ground import ground_profile
    from pysprings.results.plots.picture import View
    from pysprings.results.report.page import picture_uri

    drawn = ground_profile(View(xr.DataTree(xr.Dataset(attrs={"scene_toml": scene.to_toml()}))))
    drawn.suptitle("")
    drawn.set_size_inches(*PICTURE)
    return picture_uri(content_of(drawn), ".png")
