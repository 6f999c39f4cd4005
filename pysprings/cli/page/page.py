# SPDX-License-Identifier: MIT
"""The page: inputs at the left, the answer at the right; all controls are those of HTML, so that a keyboard does.

Dash (plotly) makes it: Panel would do the same with four times the weight, in elements that screen readers do not name.
"""

import io
import math
import threading
import zipfile
from contextlib import suppress
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from dash import Dash, Input, Output, State, ctx, dcc, html, no_update

from pysprings.cli.page import answers, figures
from pysprings.cli.page.sources import Field, H, RunSource, Source, Values, command_line
from pysprings.core.errors import PyspringsError
from pysprings.springs.checks import save_springs

MOST_BYTES = 5_000_000  # of an uploaded table
MOST_ROWS = 200  # of load cases that are shown
GRAPHS = {"load": figures.load_over_motion, "depth": figures.by_depth, "envelope": figures.envelope}
HTML = """<!DOCTYPE html>
<html lang="en"><head>{%metas%}<title>{%title%}</title>{%favicon%}{%css%}</head>
<body>{%app_entry%}<footer>{%config%}{%scripts%}{%renderer%}</footer></body></html>"""


def application(source: Source) -> Dash:
    """Return the page as an application."""
    app = Dash("pysprings", title=escape(f"pysprings: {source.title}"), update_title="", index_string=HTML,
               assets_folder=str(Path(__file__).parent / "assets"))  # fmt: skip
    app.server.config.update(TRUSTED_HOSTS=["127.0.0.1", "localhost"], MAX_CONTENT_LENGTH=4 * MOST_BYTES)
    app.layout = layout(source)
    page = Page(source)
    typed = [f"{each.name}-number" for each in page.fields]
    slid = [f"{each.name}-slider" for each in page.sliders]
    now = [State(name, "value") for name in typed]
    app.callback(
        output={
            "numbers": [Output(name, "value") for name in typed],
            "sliders": [Output(name, "value") for name in slid],
            "end": [Output("H-slider", "max"), Output("H-slider", "step")],
            "texts": [Output(name, "children") for name in ("numbers", "remarks", "facts", "command", "table")],
            "figures": [Output(name, "figure") for name in GRAPHS],
            "drawn": Output("drawn", "data"),
        },
        inputs={
            "typed": [Input(name, "value") for name in typed],
            "slid": [Input(name, "value") for name in slid],
            "table": [State("cases", "filename"), Input("cases", "contents")],
            "drawn": State("drawn", "data"),
        },
    )(page.answered)
    app.callback(Output("ground", "src"), inputs={"_drawn": Input("drawn", "data"), "typed": now})(page.pictured)
    app.callback(
        Output("saved", "data"), inputs={"_clicks": Input("save", "n_clicks"), "typed": now}, prevent_initial_call=True
    )(page.saved)
    threading.Thread(target=page.warm_up, daemon=True).start()  # while a browser is on its way
    return app


def layout(source: Source) -> Any:
    """Return the elements of the page."""
    graphs = [
        html.Div(html.Img(id="ground", alt="caisson and ground by depth"), className="graph"),
        *(dcc.Graph(id=name, config={"displayModeBar": False}, style={"height": "100%"}, className="graph")
          for name in GRAPHS),
    ]  # fmt: skip
    upload = dcc.Upload(html.Button("Load cases (CSV, xlsx)", id="choose"), id="cases", max_size=MOST_BYTES)
    aside = [
        html.H1(source.title), *map(_input, (*source.fields, *source.load_fields)), html.Div(id="facts"),
        html.Label([upload, html.Span("table of load cases", className="unseen")]),
        html.Button("Download scene, springs, command", id="save"), dcc.Download(id="saved"),
        html.P("The same answer in a terminal:"), html.Code(id="command"),
    ]  # fmt: skip
    main = [
        html.Output(id="numbers", className="numbers"), html.Div(id="remarks", tabIndex="0", role="status"),
        html.Div(graphs, className="graphs"), html.Div(id="table"), dcc.Store(id="drawn"),
    ]  # fmt: skip
    return html.Div([html.Aside(aside), html.Main(main)], className="page")


def _input(each: Field) -> Any:
    """Return an input: its name, a number, and a slider where it has ends."""
    unit = f" [{each.unit}]" if each.unit else ""
    number, slider = f"{each.name}-number", f"{each.name}-slider"
    parts = [
        html.Label(f"{each.name}{unit}", htmlFor=number, title=each.tip),
        # of type "number" it loses what is typed where that was typed before the slider moved
        dcc.Input(id=number, type="text", value=each.start),
    ]
    if each.ends is not None:
        low, high = each.ends
        value = low if each.start is None else each.start
        parts += [
            dcc.Input(id=slider, type="range", min=low, max=high, step=each.step, value=value, debounce=each.pause),
            html.Label(f"slider of {each.name}", htmlFor=slider, className="unseen"),
        ]
    return html.Div(parts, className="input")


class Page:
    """Answers to what is done on the page, one at a time: Matplotlib and NetCDF take no more."""

    def __init__(self, source: Source) -> None:
        self.source, self.asker, self.alone = source, answers.Asker(source), threading.Lock()
        self.fields = (*source.fields, *source.load_fields)
        self.sliders = [each for each in self.fields if each.ends is not None]

    def warm_up(self) -> None:
        """Load and compile what answers need."""
        with self.alone:
            self.asker.half_of_largest({each.name: each.start for each in self.fields})

    def values(self, typed: list[Any]) -> dict[str, float | None]:
        """Return the values of the inputs."""
        return {each.name: _number(value) for each, value in zip(self.fields, typed, strict=True)}

    def answered(self, typed: list[Any], slid: list[Any], table: list[Any], drawn: str | None) -> dict[str, Any]:
        """Return all that an answer shows; what is typed counts, but for the slider that has moved."""
        values, moved, source = self.values(typed), str(ctx.triggered_id or "").partition("-slider"), self.source
        by_slider = {each.name: value for each, value in zip(self.sliders, slid, strict=True)}
        name = moved[0] if moved[1] else ""
        if name:
            values[name] = _number(by_slider[name])
        with self.alone:
            first = ctx.triggered_id is None
            if first:
                values[H.name] = self.asker.half_of_largest(values)
            answer, key = self.asker.answer(values, tuple(table) if all(table) else None), str(source.key(values))
            return {
                "numbers": [values[each.name] if first or each.name == name else no_update for each in self.fields],
                "sliders": [no_update if each.name == name else values[each.name] or 0.0 for each in self.sliders],
                "end": [no_update] * 2 if key == drawn else _end(answer, values[H.name]),
                "texts": [
                    _numbers(answer, source, values),
                    [html.P(text, className=kind) for kind, text in answers.remarks(answer)],
                    no_update if key == drawn else _facts(source, values), answers.command_of(values, source),
                    _table(answer, source, values, table[0]),
                ],
                "figures": [draw(answer) for draw in GRAPHS.values()],
                "drawn": no_update if key == drawn else key,
            }  # fmt: skip

    def pictured(self, _drawn: Any, typed: list[Any]) -> Any:
        """Return the picture of caisson and ground; None for a scene that is refused."""
        with self.alone, suppress(PyspringsError):
            scene = self.source.scene(self.values(typed))
            return None if scene is None else figures.ground_picture(scene)
        return None

    def saved(self, _clicks: Any, typed: list[Any]) -> Any:
        """Return an archive of the scene, its springs, and the command of the answer; none where it is refused."""
        values, stream = self.values(typed), io.BytesIO()
        with self.alone, suppress(PyspringsError), TemporaryDirectory() as place:
            scene = self.source.scene(values)
            with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
                if scene is not None:
                    archive.writestr("scene.toml", scene.replace(design={"cases": None}).to_toml())
                springs = save_springs(self.source.springs(values), Path(place) / "springs.nc")
                archive.write(springs, springs.name)
                archive.writestr("command.txt", answers.command_of(values, self.source) + "\n")
            return dcc.send_bytes(stream.getvalue(), "explored.zip")  # type: ignore[attr-defined]
        return no_update


def _number(value: Any) -> float | None:
    """Return what an input holds, with a decimal point or comma; None where it is blank, NaN where it is no number."""
    if value is None or not str(value).strip():
        return None
    try:
        read = float(str(value).replace(",", "."))
    except ValueError:
        return math.nan
    return read if math.isfinite(read) else math.nan


def _end(answer: answers.Answer, force: float | None) -> list[Any]:
    """Return the end of the slider of H [MN], just below the largest known load, or H where that is more; its step."""
    known = 0.0 if answer.largest is None else 1e-6 * abs(float(answer.largest.H[0]))
    end = float(f"{0.99 * known if math.isfinite(known) else 0.0:.3g}") or 1.0  # rounded, within what is known
    end = max(end, force or 0.0)
    return [end, Field("H", "", "", None, (0.0, end)).step]


def _numbers(answer: answers.Answer, source: Source, values: Values) -> Any:
    return [
        html.Div([html.Span(name), html.Strong(text, id=f"number-{name.replace(' ', '-')}")])
        for name, text in answers.numbers(answer, source, values)
    ]


def _facts(source: Source, values: Values) -> Any:
    try:
        rows = source.facts(values)
    except PyspringsError:
        return None  # no earlier ones beside other inputs
    return html.Table(html.Tbody([html.Tr([html.Th(name, scope="row"), html.Td(text)]) for name, text in rows]))


def _table(answer: answers.Answer, source: Source, values: Values, name: str | None) -> Any:
    """Return the answers to load cases, as `design` prints them, with its command."""
    from pysprings.results.report import load_cases

    if answer.cases is None or isinstance(answer.cases, str):
        return answer.cases and html.P(answer.cases, className="refused")
    shown = load_cases.table_of(answer.cases.head(MOST_ROWS), brief=True)
    head = html.Thead(html.Tr([html.Th(each, scope="col") for each in shown.columns]))
    body = html.Tbody([html.Tr([html.Td(cell) for cell in row]) for row in shown.rows])
    more = f" (the first {MOST_ROWS} are shown)" if len(answer.cases) > MOST_ROWS else ""
    springs = source.options(values) if isinstance(source, RunSource) else ["springs.nc"]
    command = html.Code(command_line(["design", *springs, name or ""]))
    of_file = "" if isinstance(source, RunSource) else ", with springs.nc of the download"
    closing = html.P(f"{load_cases.closing(answer.cases)}{more}")
    notes = [html.P(f"note: {text}") for text in answer.cases.attrs["notes"]]
    return [closing, *notes, html.Table([head, body]), html.P(["The same in a terminal", of_file, ": ", command])]
