# SPDX-License-Identifier: MIT
"""Figures of the page in the colours of all pictures: load over motion, reactions by depth, H and M, the ground."""

from __future__ import annotations

from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np

from pysprings.cli.page.answers import Answer, load_of, profiles
from pysprings.core.words import RANGE_END
from pysprings.macro.fan_springs import BAND
from pysprings.results.plots.style import BLUE, GREEN, GREY, INK, KN, MM, MN, PURPLE, SKY, VERMILLION

if TYPE_CHECKING:
    import xarray as xr

    from pysprings.scene.model import Scene

Figure = dict[str, Any]
FONT = {"family": "DejaVu Sans, Verdana, sans-serif", "size": 11, "color": INK}
REACTIONS = {"p": ("p [kN/m]", BLUE), "m": ("m [kN m/m]", PURPLE), "t": ("t [kN/m]", GREEN)}
PICTURE = (6.4, 3.5)  # inch
DPI = 150


def figure(title: str, traces: list[Figure], **layout: Any) -> Figure:
    """Return a figure of plotly with the look of the page."""
    axes = {name: {"gridcolor": "#dddddd", "zerolinecolor": GREY, "automargin": True} | given
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


def load_over_motion(answer: Answer) -> Figure:
    """Draw H over u (M over the rotation without H) up to the largest known load, the answer and its band of 95 %."""
    force = answer.question is None or bool(answer.question.H) or not answer.question.M
    load, motion, scale = ("H", "u", MM) if force else ("M", "rotation", MM)
    heads = ("u [mm]", "H [MN]") if force else ("rotation [mrad]", "M [MN m]")
    traces = []
    for name, states, colour in (("to the largest known load", answer.onward, GREY), ("answer", answer.way, BLUE)):
        if states is None:
            continue
        x, y = scale * states[motion].values, MN * states[load].values
        if f"{motion}_deviation" in states and name != "answer":
            traces.append(_band(states, x, y, scale * states[f"{motion}_deviation"].values))
        traces.append(line(x, y, name, colour))
    if answer.way is not None:
        end = answer.way.isel(step=-1)
        at = scale * float(end[motion]), MN * float(end[load])
        traces.append(dots([at[0]], [at[1]], "answer", VERMILLION, "circle", ["answer"]))
    elif answer.question is not None and answer.onward is not None:
        asked = MN * load_of(answer.question)[0 if force else 1]
        x = scale * answer.onward[motion].values
        dashed = {"color": VERMILLION, "width": 2, "dash": "dash"}
        traces.append(line([0.0, x[-1]], [asked, asked], "no answer", VERMILLION, line=dashed, mode="lines+text",
                           text=["", "no answer"], textposition="bottom left"))  # fmt: skip
    band = ", band of 95 %" if any(each["name"] == "band of 95 %" for each in traces) else ""
    ends = [0.0, *(scale * float(each[motion][-1]) for each in (answer.way, answer.onward) if each is not None)]
    room = 0.08 * (max(ends) - min(ends)) or 1.0
    across = {"title": {"text": heads[0]}, "range": [min(ends) - room, max(ends) + room]}
    return figure(f"Load against motion{band}", traces, xaxis=across, yaxis={"title": {"text": heads[1]}})


def _band(states: xr.Dataset, x: Any, y: Any, deviation: Any) -> Figure:
    known = np.isfinite(deviation)
    x, width, load, sign = x[known], BAND * deviation[known], y[known], np.sign(x[-1])
    low, high = sign * np.maximum(sign * (x - width), 0.0), x + width * sign  # no motion against the load
    around = line(np.append(low, high[::-1]), np.append(load, load[::-1]), "band of 95 %", SKY, fill="toself")
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
        traces.append(line(KN * values, depth, words, colour, xaxis=own, mode="lines+markers", marker={"size": 5}))
        axes[f"xaxis{k + 1}" if k else "xaxis"] = {
            "title": {"text": words}, "domain": [k * width + 0.03 * bool(k), (k + 1) * width - 0.02], "nticks": 4,
            "tickangle": 0, "rangemode": "tozero",
        }  # fmt: skip
    return figure("Reactions by depth, of the answer" if found else "Reactions by depth: no answer", traces, **axes)


def envelope(answer: Answer) -> Figure:
    """Draw the largest known loads in the plane of H and M, the load and the load cases."""
    traces = []
    if answer.around is not None:
        H, M = (MN * np.concatenate([each, -each, each[:1]]) for each in (answer.around.H, answer.around.M))
        kinds = np.concatenate([answer.around.kind] * 2 + [answer.around.kind[:1]])
        traces.append(line(H, M, "largest known load", GREY))
        for ends, symbol, name in ((False, "circle", "capacity"), (True, "triangle-down-open", "end of the range")):
            at = (kinds == RANGE_END) == ends
            if at.any():
                traces.append(dots(H[at], M[at], name, GREEN, symbol, size=6))
    if answer.cases is not None:
        rows = answer.cases
        traces.append(dots(MN * rows["H_N"], MN * rows["M_Nm"], "load cases", INK, "square", list(rows["name"]), 6))
    if answer.question is not None:
        force, moment = load_of(answer.question)
        word = "load" if answer.way is not None else "load, no answer"
        symbol = "circle" if answer.way is not None else "x"
        traces.append(dots([MN * force], [MN * moment], "load", VERMILLION, symbol, [word]))
    ends = any(each["name"] == "end of the range" for each in traces)
    title = f"Largest known loads at this V{' (triangles: the springs end there)' if ends else ''}"
    return figure(title, traces, xaxis={"title": {"text": "H [MN]"}}, yaxis={"title": {"text": "M [MN m]"}})


def ground_picture(scene: Scene) -> str:
    """Return the picture of caisson and ground as a data URI of a PNG."""
    import xarray as xr
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure as Drawn

    from pysprings.results.plots.ground import ground_profile
    from pysprings.results.plots.picture import View
    from pysprings.results.plots.style import drawn_on
    from pysprings.results.report.page import picture_uri

    drawn = Drawn(figsize=PICTURE, layout="constrained")
    FigureCanvasAgg(drawn)
    with drawn_on(drawn):
        ground_profile(View(xr.DataTree(xr.Dataset(attrs={"scene_toml": scene.to_toml()}))))
    drawn.suptitle("")
    stream = BytesIO()
    drawn.savefig(stream, format="png", dpi=DPI)
    return picture_uri(stream.getvalue(), ".png")
