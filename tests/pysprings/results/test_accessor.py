# SPDX-License-Identifier: MIT
"""Trees in notebooks: compact HTML, pictures by name, on parts of figures."""

import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest
import xarray as xr
from matplotlib.figure import Figure

import pysprings
from pysprings import plots
from pysprings.core.errors import UserInputError
from pysprings.core.storage import write_tree
from pysprings.results.accessor import Accessor
from pysprings.results.layout import open_result
from pysprings.results.plots.draw import drawable
from tests.support import synthetic, tiny

PATHS = (synthetic.Path("pull", size=8e-3, steps=12), synthetic.Path("turn", "rotation", size=-2e-3, steps=6))
MOST_BYTES = 8_000


class Balance(HTMLParser):
    """Depth of open elements at the end, and the words of the page."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.words = ""
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_startendtag(self, tag: str, attrs: object) -> None:
        pass

    def handle_data(self, data: str) -> None:
        self.words += data + "\n"


@pytest.fixture(scope="module")
def springs() -> xr.DataTree:
    return synthetic.make_springs(PATHS)


@pytest.fixture(scope="module")
def result() -> xr.DataTree:
    return synthetic.make_result(PATHS)


def test_springs_are_a_few_kB_of_html_with_size_stiffness_paths_and_range(springs: xr.DataTree) -> None:
    assert isinstance(springs.pysprings, Accessor)
    html = springs.pysprings._repr_html_()
    page, u = Balance(html), springs["paths/pull"]["u"].max()
    assert page.open == []
    assert len(html) < MOST_BYTES < len(springs._repr_html_())
    assert html == pysprings.Springs.of(springs)._repr_html_()
    stiffness = 1e-6 * springs["stiffness_initial"].values[0, 0]
    for text in (f"K_H {stiffness:.4g} MN/m", f"u up to {1e3 * float(u):.3g} mm", "1 pull (calibration)"):
        assert text in page.words
    assert html.count("<polyline") == 2 + 1  # two axes, and the path that moves sideways
    assert html.count("<svg") == 2


def test_text_of_a_scene_is_escaped_and_its_layers_are_drawn() -> None:
    layers = [{"top": 0.0, "name": "<b>sand</b>"}, {"top": 2.0, "name": "dense", "friction_angle_final": 0.7}]
    html = tiny.sand(title="<script>", soil={"layers": layers})._repr_html_()
    page = Balance(html)
    assert page.open == []
    assert "<script>" in page.words and "<b>" not in html.replace("<b>&lt;script&gt;</b>", "")
    assert page.words.count("dense") == 2  # in a line, and in the drawing
    assert len(html) < MOST_BYTES


def test_a_picture_by_name_is_that_of_its_function(result: xr.DataTree) -> None:
    figure = result.pysprings.plot.py("pull", depths=[1.0])
    expected = plots.py_curves(plots.path_data(result, "pull"), depths=[1.0])
    drawn, wanted = ([line.get_xydata().tolist() for line in each.axes[0].lines] for each in (figure, expected))
    assert drawn == wanted and drawn
    assert figure._repr_png_().startswith(b"\x89PNG")


def test_pictures_share_a_figure(springs: xr.DataTree) -> None:
    whole = Figure(figsize=(12, 5), layout="constrained")
    left, right = whole.subfigures(1, 2)
    springs.pysprings.plot.overview(figure=left)
    springs.pysprings.plot.profiles("pull", figure=right, levels=[1.0])
    assert [len(part.axes) for part in (left, right)] == [2, 4]
    assert len(whole.axes) == 6
    assert type(plots.draw(springs, "tilt")) is not type(left)


def test_those_with_data_are_listed_and_all_of_them_are_drawn(result: xr.DataTree, springs: xr.DataTree) -> None:
    of_springs, of_result = drawable(springs), drawable(result)
    assert {"overview", "tilt", "secant_stiffness", "py", "profiles", "macro_against_full"} <= set(of_springs)
    assert {"mesh", "section", "gap", "stress_outside", "load_displacement"} <= set(of_result) - set(of_springs)
    assert dir(springs.pysprings.plot) == sorted(of_springs)


@pytest.mark.parametrize(
    ("name", "given", "words"),
    [
        ("pie", {}, "'pie' is not one of"),
        ("py", {"path": "push"}, "no path 'push'"),
        ("gap", {}, "does not hold its data"),
        ("tilt", {"path": "pull"}, "shows all paths"),
        ("py", {"path": "pull", "step": 3}, "no single state"),
    ],
)
def test_what_cannot_be_drawn_is_refused(springs: xr.DataTree, name: str, given: dict, words: str) -> None:
    with pytest.raises(UserInputError, match=words):
        plots.draw(springs, name, **given)


def test_a_name_of_no_picture_is_no_attribute(springs: xr.DataTree) -> None:
    assert not hasattr(springs.pysprings.plot, "pie")
    assert springs.pysprings.springs.length == springs.attrs["skirt_length_m"]


def test_a_result_opens_from_its_folder_and_springs_do_not(result: xr.DataTree, tmp_path: Path) -> None:
    tree = result.copy()
    tree.attrs["run_json"] = '{"status": "complete"}'
    write_tree(tree, tmp_path / "full_model.nc")
    assert open_result(tmp_path).attrs["title"] == result.attrs["title"]
    write_tree(synthetic.make_springs(PATHS), tmp_path / "springs.nc")
    with pytest.raises(UserInputError, match="no result of a full model"):
        open_result(tmp_path / "springs.nc")


def test_the_accessor_comes_with_the_first_name_and_import_stays_light() -> None:
    code = (
        "import sys, pysprings\nassert 'xarray' not in sys.modules\npysprings.open_springs\nimport xarray\n"
        "assert hasattr(xarray.DataTree, 'pysprings')\nassert 'matplotlib' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)
