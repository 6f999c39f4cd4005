# SPDX-License-Identifier: MIT
"""`explore`: its answers are those of the commands it shows; the page in a real browser, on a run and on an atlas."""

import base64
import io
import json
import re
import shlex
import shutil
import subprocess
import sys
import warnings
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from pysprings.cli.page import answers, figures
from pysprings.cli.page.answers import Answer, Asker
from pysprings.cli.page.sources import AtlasSource, RunSource, Source
from pysprings.core.errors import UserInputError
from pysprings.core.tables.load_cases import read_load_cases
from pysprings.full_model.run_record import RunRecord, Status
from pysprings.macro.batch import predict_batch
from pysprings.results.look import CASE_MARKS
from pysprings.results.plots import style
from pysprings.scene.load import parse_scene
from pysprings.springs.checks import open_springs, save_springs
from pysprings.studies.design import answer_cases
from tests.support import synthetic, tiny
from tests.support.commands import command, environment
from tests.support.rates import with_vertical

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
PATHS = (
    synthetic.Path("push", "translation", size=8e-3, steps=8),
    synthetic.Path("turn", "rotation", size=2e-3, steps=8),
)
CASES = "name, H [kN], arm [m], V [MN]\nstorm, 300, 8, 2\nice, 100, 2, 2\n"


@pytest.fixture(scope="module")
def run_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Springs of two paths, in a folder whose name a shell would take apart."""
    folder = tmp_path_factory.mktemp("a run")
    save_springs(synthetic.make_springs(PATHS), folder / "springs.nc")
    return folder


@pytest.fixture(scope="module")
def clay() -> AtlasSource:
    return AtlasSource.of("clay")


def start(source: Source, **changed: float | None) -> dict[str, float | None]:
    """Values of the inputs at the start, some of them changed."""
    values: dict[str, float | None] = {each.name: each.start for each in (*source.fields, *source.load_fields)}
    return values | changed


def predicted(values: dict[str, float | None], source: Source) -> tuple[int, Any, str]:
    """Exit code, last state and messages of the command that the page shows."""
    shown = shlex.split(answers.command_of(values, source))
    assert shown[0] == "pysprings"
    done = command(*shown[1:], "--json")
    return done.code, json.loads(done.out)["states"][-1] if done.out else None, done.err


def same_as_the_command(answer: Answer, values: dict[str, float | None], source: Source) -> None:
    """Compare an answer with that of its command."""
    code, state, _ = predicted(values, source)
    assert code == 0
    assert answer.way is not None
    last = answer.way.isel(step=-1)
    for name in ("u", "w", "rotation", "H", "M", "V", "utilisation"):
        assert float(last[name]) == pytest.approx(state[name], rel=1e-9, abs=1e-12), name


@pytest.mark.filterwarnings("ignore::pysprings.macro.predict.MacroWarning")
@pytest.mark.parametrize("loads", [{"H": 0.2, "arm": 8.0}, {"H": -0.1, "M": 0.3}, {"M": 0.4}, {"H": 0.1, "V": 2.2}])
def test_the_command_of_a_run_gives_the_same_answer(run_folder: Path, loads: dict[str, float]) -> None:
    source = RunSource.of(run_folder)
    values = start(source, **loads)
    same_as_the_command(Asker(source).answer(values), values, source)


@pytest.mark.parametrize(
    "typed, value", [("0,3", 0.3), (" 0.3 ", 0.3), (0.3, 0.3), ("", None), ("1.250,5", np.nan), ("inf", np.nan)]
)
def test_what_is_typed_is_a_number_or_refused(run_folder: Path, typed: object, value: float | None) -> None:
    pytest.importorskip("dash")
    from pysprings.cli.page.page import Page

    page = Page(RunSource.of(run_folder))
    values = page.values([typed, 8.0, None, None])
    assert values["H"] == pytest.approx(value, nan_ok=True)
    answer = page.asker.answer(values)
    assert (answer.way is None) == (value != 0.3)
    assert ("expected a quantity" in answer.refusal) == (value is not None and np.isnan(value))


@pytest.mark.filterwarnings("ignore::pysprings.macro.predict.MacroWarning")
@pytest.mark.parametrize("rate", [0.01, 0.1, 1.0])
def test_springs_of_several_rates_have_an_input_of_the_rate(tmp_path: Path, rate: float) -> None:
    """Without a rate they have no answer; at the start it is the slowest."""
    source = RunSource.of(save_springs(with_vertical(1e-5), tmp_path / "springs.nc"))
    assert [(each.name, each.start, each.ends) for each in source.fields] == [("rate", 0.01, (0.01, 1.0))]
    values = start(source, H=0.1, arm=2.0, rate=rate)
    same_as_the_command(Asker(source).answer(values), values, source)
    assert "--rate" in answers.command_of(values, source)
    blank = start(source, H=0.1, rate=None)
    assert "several rates" in (Asker(source).answer(blank).refusal or "")


def test_the_command_of_load_cases_has_the_rate_of_the_page(tmp_path: Path) -> None:
    pytest.importorskip("dash")
    from pysprings.cli.page.page import _table

    source, file = RunSource.of(save_springs(with_vertical(1e-5), tmp_path / "springs.nc")), tmp_path / "cases.csv"
    file.write_text(CASES, encoding="utf-8")
    values = start(source, H=0.1, rate=0.1)
    answer = Asker(source).answer(values, (file.name, f"data:,{base64.b64encode(CASES.encode()).decode()}"))
    *_, closing = _table(answer, source, values, str(file))
    shown = closing.children[-1].children
    done = command(*shlex.split(shown)[1:], "--json")
    assert done.code == 0, done.err
    assert isinstance(answer.cases, pd.DataFrame)
    there = [case["rotation_rad"] for case in json.loads(done.out)["cases"]]
    np.testing.assert_allclose(answer.cases["rotation_rad"], there, rtol=1e-9)


@pytest.mark.filterwarnings("ignore::pysprings.macro.predict.MacroWarning")
def test_the_command_of_an_atlas_gives_the_same_answer_as_inputs_change(clay: AtlasSource) -> None:
    asker = Asker(clay)
    for changed in ({}, {"D": 9.5}, {"D": 9.5, "su": 25.0, "alpha": 0.8}, {"V": 1.5}, {"gradient": 1.0, "arm": 30.0}):
        values = start(clay, H=0.3, **changed)
        answer = asker.answer(values)
        same_as_the_command(answer, values, clay)
        texts = [text for _, text in answers.remarks(answer)]
        assert any(text.startswith("standard deviation of the last state: u ") for text in texts)
        assert not any("made on mesh" in text for text in texts)  # its full models are extrapolated


@pytest.mark.parametrize(
    "changed", [{"H": 50.0}, {"H": None}, {"H": 0.3, "D": 20.0, "L": 4.0}, {"H": 0.3, "alpha": 2.0}, {"H": 1e9}]
)
def test_what_predict_refuses_is_refused_in_its_words(clay: AtlasSource, changed: dict[str, float | None]) -> None:
    values = start(clay, **changed)
    answer = Asker(clay).answer(values)
    code, _, message = predicted(values, clay)
    assert code in (2, 3)
    assert answer.way is None
    assert message.strip().endswith(answer.refusal)
    ((kind, said),) = answers.remarks(answer)
    assert kind == "refused"
    assert said.removeprefix("no answer: ") in message
    assert dict(answers.numbers(answer, clay, values))["u"] == "-"


def test_marks_are_texts(run_folder: Path) -> None:
    source = RunSource.of(run_folder)
    values = start(source, H=0.1, V=2.5)
    said = answers.remarks(Asker(source).answer(values))
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        _, _, messages = predicted(values, source)
    marks = [text for kind, text in said if kind == "mark"]
    assert "off_load" in marks[0]
    assert marks[1:] == messages.splitlines()
    assert len(marks) == 3


@pytest.mark.parametrize("name", ["sand", "clay"])
def test_inputs_of_the_ground_end_within_what_the_atlas_covers(name: str) -> None:
    source = AtlasSource.of(name)
    box = dict(zip(source.atlas.family.labels, source.atlas.box.T, strict=True))
    ends = {each.name: each.ends for each in source.fields if each.name in box}
    assert ends and all(box[own][0] <= low < high <= box[own][1] for own, (low, high) in ends.items())


def test_zero_is_a_value(clay: AtlasSource) -> None:
    values = start(clay, H=0.1, gradient=0.0)
    assert "--set 'gradient=\"0 kPa/m\"'" in answers.command_of(values, clay)
    same_as_the_command(Asker(clay).answer(values), values, clay)


def test_half_of_the_largest_load_is_half_of_what_is_known(clay: AtlasSource) -> None:
    asker = Asker(clay)
    answer = asker.answer(start(clay, H=asker.half_of_largest(start(clay))))
    assert answer.way is not None
    assert float(answer.way["utilisation"][-1]) == pytest.approx(0.5, abs=0.03)  # two figures


def test_load_cases_are_those_of_design(clay: AtlasSource, tmp_path: Path) -> None:
    values, file = start(clay, H=0.3, V=2.0), tmp_path / "cases.csv"
    file.write_text(CASES, encoding="utf-8")
    content = f"data:text/csv;base64,{base64.b64encode(file.read_bytes()).decode()}"
    found = Asker(clay).answer(values, ("cases.csv", content)).cases
    assert isinstance(found, pd.DataFrame)
    own = answer_cases(clay.springs(values), read_load_cases(file))
    assert found.drop(columns="remarks").equals(own.drop(columns="remarks"))
    wrong = Asker(clay).answer(values, ("cases.csv", "data:text/csv;base64," + base64.b64encode(b"name\nx\n").decode()))
    assert isinstance(wrong.cases, str)
    assert wrong.cases.startswith("fatal: user input: cases.csv:1: no column with a load")
    assert wrong.way is not None  # the load has its answer


def test_figures_have_the_numbers_of_the_answer(run_folder: Path) -> None:
    """States of the two paths, under their own loads: motion, p, m and t are those of the path, at its depths."""
    source = RunSource.of(run_folder)
    push = source.tree["paths/push"].to_dataset().isel(step=4)
    H, M = float(push["H"]), float(push["M"])
    answer = Asker(source).answer(start(source, H=1e-6 * H, M=1e-6 * M))
    drawn = {each["name"]: each for each in figures.load_over_motion(answer)["data"]}
    (place,) = zip(drawn["answer"]["x"], drawn["answer"]["y"], strict=True)
    assert place == pytest.approx((1e3 * float(push["u"]), 1e-6 * H))
    largest = float(answer.largest.H[0])  # type: ignore[union-attr]
    assert drawn["known"]["y"][-1] == pytest.approx(0.999e-6 * largest, rel=1e-6)
    assert answer.onward is not None
    np.testing.assert_allclose(answer.onward["M"][1:] / answer.onward["H"][1:], M / H, rtol=1e-9)
    turn = source.tree["paths/turn"].to_dataset().isel(step=4)
    answer = Asker(source).answer(start(source, H=1e-6 * float(turn["H"]), M=1e-6 * float(turn["M"])))
    by_depth = figures.by_depth(answer)["data"]
    assert [each["name"] for each in by_depth] == ["p [kN/m]", "m [kN m/m]", "t [kN/m]"]
    for each, values in zip(by_depth, (turn["p"], turn["m"].sum("side"), turn["t"].sum("side")), strict=True):
        np.testing.assert_allclose(each["y"], turn["depth"])
        np.testing.assert_allclose(each["x"], 1e-3 * values, rtol=1e-6, atol=1e-6)
    assert min(max(map(abs, each["x"])) for each in by_depth) > 0.0
    turned = figures.load_over_motion(Asker(source).answer(start(source, M=0.2)))["data"]
    assert (turned[-1]["name"], turned[-1]["y"]) == ("answer", pytest.approx([0.2]))


def test_the_band_is_that_of_95_percent_of_the_deviation(clay: AtlasSource) -> None:
    answer = Asker(clay).answer(start(clay, H=0.3))
    band = figures.load_over_motion(answer)["data"][0]
    assert answer.onward is not None and band["name"] == "band of 95 %"
    u, d = 1e3 * answer.onward["u"].values, 1.96e3 * answer.onward["u_deviation"].values
    known = np.isfinite(d)
    np.testing.assert_allclose(band["x"][: known.sum()], np.maximum(u - d, 0.0)[known], rtol=1e-3, atol=1e-9)
    np.testing.assert_allclose(band["x"][::-1][: known.sum()], (u + d)[known], rtol=1e-3)


def test_load_cases_of_another_vertical_load_are_grey(run_folder: Path) -> None:
    source, values = RunSource.of(run_folder), start(RunSource.of(run_folder), H=0.1)
    rows = b"name,H [kN],M [kN m],V [MN]\nhere,100,300,2\nlighter,50,-80,1\nhuge,9e5,1,2\n"
    answer = Asker(source).answer(values, ("cases.csv", f"data:,{base64.b64encode(rows).decode()}"))
    picture = figures.envelope(answer)
    drawn = {each["name"]: each for each in picture["data"]}
    for name, place, look in (("load", (0.1, 1.0), (style.VERMILLION, "circle")),
                              ("here", (0.1, 0.3), (CASE_MARKS["supported in part"][1], "square")),
                              ("lighter", (0.05, -0.08), (style.GREY, "square-open")),
                              ("huge", (900.0, 1e-3), (CASE_MARKS["no answer"][1], "square"))):  # fmt: skip
        assert (*drawn[name]["x"], *drawn[name]["y"]) == pytest.approx(place)
        assert (drawn[name]["marker"]["color"], drawn[name]["marker"]["symbol"]) == look
    ends = [each for each in picture["data"] if each["name"] in ("largest known load", "capacity", "end of the range")]
    H, M = (1e6 * np.concatenate([each[axis] for each in ends]) for axis in "xy")
    assert H.size == 2 * (2 * answers.DIRECTIONS + 1)  # each as a point of the line and as a dot
    np.testing.assert_allclose(predict_batch(source.tree, H=H, M=M)["utilisation"], 1.0, rtol=1e-6)
    assert "grey: cases of another V" in picture["layout"]["title"]["text"]
    low, high = picture["layout"]["xaxis"]["range"]
    assert low < -0.1 and high > 900.0


def test_the_largest_loads_have_the_vertical_load_that_they_are_at(run_folder: Path) -> None:
    """Those of springs at 2 MN stand for 2.1 MN, not for 3 MN; `predict` has the same words."""
    source = RunSource.of(run_folder)
    titles = []
    for V in (None, 2.1, 3.0):
        answer = Asker(source).answer(start(source, H=0.1, V=V))
        titles.append(figures.envelope(answer)["layout"]["title"]["text"])
        assert answer.way is not None
        assert titles[-1].partition("; ")[0].endswith(answer.way.attrs["capacity_from"].rpartition("; at ")[2]) == (
            V == 3.0
        )
    assert titles[0].startswith("Largest known loads at this V;") and titles[1] == titles[0]
    assert titles[2].startswith("Largest known loads at V = 2 MN of the springs, not at this V;")


def test_an_atlas_without_a_vertical_load_has_the_largest_loads_of_its_springs() -> None:
    """Solvers leave a newton or so of V = 0 on the paths of the atlas: of other loads, with other models behind it."""
    answer = Asker(source := AtlasSource.of("clay-gap")).answer(start(source, H=0.58, D=12.0, L=12.0))
    assert answer.way is not None and answer.way["V"][-1] == 0.0
    assert figures.envelope(answer)["layout"]["title"]["text"].startswith("Largest known loads at this V")


def test_commands_that_are_not_enough(run_folder: Path) -> None:
    assert "give the folder of a run" in command("explore").err
    assert command("explore", run_folder, "--atlas", "clay").code == 2
    pytest.importorskip("dash")
    done = command("explore", run_folder / "none")
    assert done.code == 2


def test_titles_are_texts_and_other_hosts_are_refused(run_folder: Path) -> None:
    pytest.importorskip("dash")
    from pysprings.cli.page.page import application

    source = replace(RunSource.of(run_folder), title="</title><script>alert(1)</script>")
    client = application(source).server.test_client()
    page = client.get("/").text
    assert "<script>alert" not in page
    assert "&lt;script&gt;alert" in page
    assert '<html lang="en">' in page
    assert client.get("/", headers={"Host": "elsewhere.example"}).status_code == 400  # a name that resolves to here


def test_load_cases_have_the_notes_of_design_and_a_run_that_did_not_end_is_named(
    run_folder: Path, tmp_path: Path
) -> None:
    pytest.importorskip("dash")
    from pysprings.cli.page.page import _table

    source = AtlasSource.of("sand")
    table = ("cases.csv", f"data:,{base64.b64encode(CASES.encode()).decode()}")
    values = start(source, H=0.1)
    shown = str(_table(Asker(source).answer(values, table), source, values, "cases.csv"))
    assert "note: springs of the atlas sand (88 full models)" in shown
    folder = Path(shutil.copytree(run_folder, tmp_path / "run"))
    assert "run" not in dict(RunSource.of(folder).facts({}))
    record = RunRecord(status=Status.PARTIAL, failures=["path 'push' stopped"])
    (folder / "run.json").write_text(json.dumps(record.as_dict()), encoding="utf-8")
    assert dict(RunSource.of(folder).facts({}))["run"] == "partial; path 'push' stopped"


def test_the_scene_of_the_download_names_no_table_of_load_cases(run_folder: Path, tmp_path: Path) -> None:
    pytest.importorskip("dash")
    from pysprings.cli.page.page import Page

    scene = tiny.scene(design={"cases": "not/here.csv"})
    source = replace(RunSource.of(run_folder), read=scene)
    saved = Page(source).saved(None, list(start(source, H=0.1).values()))
    with zipfile.ZipFile(io.BytesIO(base64.b64decode(saved["content"]))) as archive:
        text = archive.read("scene.toml").decode()
    assert parse_scene(text) == scene.replace(design={"cases": None})


def test_nothing_of_an_earlier_caisson_stays_beside_a_refused_one(clay: AtlasSource) -> None:
    pytest.importorskip("dash")
    from pysprings.cli.page.page import Page, _facts

    page = Page(clay)
    good, bad = start(clay, H=0.1), start(clay, H=0.1, D=-1.0)
    assert _facts(clay, good) is not None
    assert page.pictured(None, list(good.values())).startswith("data:image/png;base64,")
    assert _facts(clay, bad) is None
    assert page.pictured(None, list(bad.values())) is None


def test_an_error_of_the_program_leaves_no_earlier_answer(run_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = RunSource.of(run_folder)
    asker = Asker(source)
    assert asker.answer(start(source, H=0.1)).way is not None
    monkeypatch.setattr(answers, "way_to_load", lambda *_: 1 / 0)
    answer = asker.answer(start(source, H=0.2))
    assert answer.way is None
    assert "fatal: bug: ZeroDivisionError" in answer.refusal
    assert dict(answers.numbers(answer, source, start(source, H=0.2)))["u"] == "-"


def test_a_port_in_use_is_refused(run_folder: Path) -> None:
    from pysprings.cli.explore import bound

    with bound(0) as taken, pytest.raises(UserInputError, match="--port"):
        bound(taken.getsockname()[1])


def test_without_dash_its_package_is_named(run_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "dash", None)
    monkeypatch.delitem(sys.modules, "pysprings.cli.page.page", raising=False)
    done = command("explore", run_folder)
    assert (done.code, "this needs the package dash" in done.err) == (4, True)


# --- in a browser ---


@contextmanager
def served(*args: object) -> Iterator[str]:
    """The address of a page that a fresh process serves."""
    line = [sys.executable, "-m", "pysprings", "explore", *map(str, args), "--port", "0"]
    with subprocess.Popen(line, env=environment(), stdout=subprocess.PIPE, text=True) as server:
        try:
            assert server.stdout is not None
            yield server.stdout.readline().strip()
        finally:
            server.terminate()


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    pytest.importorskip("dash")
    api = pytest.importorskip("playwright.sync_api")
    if BROWSER is None:
        pytest.skip("no Chromium")
    with api.sync_playwright() as play:
        found = play.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])
        yield found
        found.close()


def opened(browser: Any, address: str) -> Any:
    """The page with its first answer."""
    asked: list[str] = []
    page = browser.new_page(viewport={"width": 1280, "height": 720})
    page.on("request", lambda request: asked.append(request.url))
    page.goto(address)
    page.wait_for_selector("#number-u")
    page.wait_for_selector("#load .main-svg")
    assert all(url.startswith((address, "data:", "blob:")) for url in asked)  # nothing from elsewhere
    return page


def after(page: Any, act: Any) -> None:
    """Wait until the answer to what is done is there."""
    before = page.inner_text("#command")
    act()
    page.wait_for_function("old => document.querySelector('#command').innerText != old", arg=before)


def shown_as_predicted(page: Any) -> dict[str, float]:
    """Compare the numbers of the page with the command that it shows; return the state of the command."""
    done = command(*shlex.split(page.inner_text("#command"))[1:], "--json")
    state: dict[str, float] = json.loads(done.out)["states"][-1]
    assert page.inner_text("#number-u") == f"{1e3 * state['u']:.5g} mm"
    assert page.inner_text("#number-tilt") == f"{style.DEG * state['rotation']:.5g} deg"
    assert page.inner_text("#number-utilisation") == f"{100.0 * state['utilisation']:.4g} %"
    return state


def complaints(page: Any) -> list[str]:
    """What axe-core finds: names, labels, contrast, landmarks."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright")
    found = axe.Axe().run(page).response["violations"]
    return [f"{each['id']}: {node['html'][:120]}" for each in found for node in each["nodes"]]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::pysprings.macro.predict.MacroWarning")
def test_a_run_in_a_browser(browser: Any, run_folder: Path, tmp_path: Path) -> None:
    with served(run_folder) as address:
        page = opened(browser, address)
        first = shown_as_predicted(page)
        assert complaints(page) == []
        page.focus("#H-slider")
        after(page, lambda: page.keyboard.press("ArrowRight"))  # a keyboard does
        assert shown_as_predicted(page)["H"] > first["H"]
        for _ in range(3):  # what was typed before the slider moved, again
            after(page, lambda: page.fill("#H-number", "0.2"))
            assert shown_as_predicted(page)["H"] == pytest.approx(2e5)
            page.focus("#H-slider")
            after(page, lambda: page.keyboard.press("Home"))
        after(page, lambda: page.keyboard.press("End"))
        assert 0.98 < shown_as_predicted(page)["utilisation"] < 1.0
        page.fill("#H-number", "900")
        page.wait_for_selector("#remarks .refused")
        assert "beyond the range" in page.inner_text("#remarks")
        assert page.inner_text("#number-u") == "-"
        assert complaints(page) == []
        assert page.evaluate("document.documentElement.scrollHeight") <= 720


def chosen_by_key(page: Any, button: str) -> Any:
    """Return the chooser of files that Enter opens on a button; an update of the page may take its focus before."""
    from playwright.sync_api import TimeoutError as Late

    for last in (False, False, True):
        try:
            with page.expect_file_chooser(timeout=10_000) as chosen:
                page.focus(button)
                page.keyboard.press("Enter")
            return chosen.value
        except Late:
            if last:
                raise
    raise AssertionError


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::pysprings.macro.predict.MacroWarning")
def test_an_atlas_in_a_browser(browser: Any, tmp_path: Path) -> None:
    with served("--atlas", "clay") as address:
        page = opened(browser, address)
        assert "springs of the atlas clay (96 full models)" in page.inner_text("#remarks")
        end = float(page.get_attribute("#H-slider", "max"))
        for name in ("D", "su"):
            page.focus(f"#{name}-slider")
            after(page, lambda: page.keyboard.press("ArrowRight"))
        page.wait_for_function(f"Number(document.querySelector('#H-slider').max) > {end}")  # a larger caisson
        assert re.search(r"--set 'su=\"[\d.]+ kPa\"'", page.inner_text("#command"))
        state = shown_as_predicted(page)
        cases = tmp_path / "cases.csv"
        cases.write_text(CASES, encoding="utf-8")
        chosen_by_key(page, "#choose").set_files(cases)
        page.wait_for_selector("#table td")
        assert "storm" in page.inner_text("#table")
        assert "2 cases" in page.inner_text("#table")
        assert complaints(page) == []
        with page.expect_download() as saved:
            page.click("#save")
        saved.value.save_as(tmp_path / "explored.zip")
    with zipfile.ZipFile(tmp_path / "explored.zip") as archive:
        archive.extractall(tmp_path)
        assert sorted(archive.namelist()) == ["command.txt", "scene.toml", "springs.nc"]
    args = shlex.split((tmp_path / "command.txt").read_text(encoding="utf-8"))
    load = args[args.index("--H") :]
    (again,) = json.loads(command("predict", tmp_path / "springs.nc", *load, "--json").out)["states"]
    assert again["u"] == pytest.approx(state["u"], rel=1e-9)
    (again,) = json.loads(
        command("predict", tmp_path / "scene.toml", "--atlas", "clay", *load, "--json").out
    )["states"]  # fmt: skip
    assert again["u"] == pytest.approx(state["u"], rel=1e-9)
    open_springs(tmp_path / "springs.nc")
