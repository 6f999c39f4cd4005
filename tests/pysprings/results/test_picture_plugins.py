# SPDX-License-Identifier: MIT
"""Pictures as plug-ins: some from outside the package, through a run, its folder and its report."""

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from pysprings.results import plots
from pysprings.results.folder import run_to_folder
from pysprings.results.layout import pictures_in
from pysprings.results.plots import PICTURES, Picture, View
from tests.support import tiny


def draw(view: View) -> Figure:
    """Draw H over u, and mark the step of the view."""
    figure = Figure(figsize=(2, 2))
    axes = figure.subplots()
    axes.plot(view.path["u"], view.path["H"])
    if view.step is not None:
        axes.plot(view.path["u"][view.step], view.path["H"][view.step], "o")
    return figure


def blank(_view: View) -> Figure:
    return Figure(figsize=(1, 1))


TOYS = (
    Picture("toy", "A toy of the path", draw),
    Picture("toy-state", "A toy of a state", draw, scope="state"),
    Picture("toy-run", "A toy of the run", blank, scope="run"),
    Picture("toy-water", "A toy of the water", blank, applies=lambda view: "pressure_min" in view.path),
)
STEMS = ["pull_toy", "pull_toy-state_last", "toy-run"]


@pytest.fixture
def toys() -> Iterator[None]:
    """The toys in the place of the pictures of the package, which take longer to draw."""
    ours = list(PICTURES)
    for picture in ours:
        PICTURES.remove(picture.name)
    for toy in TOYS:
        PICTURES.register(toy)
    yield
    for toy in TOYS:
        PICTURES.remove(toy.name)
    for picture in ours:
        PICTURES.register(picture)


def test_a_run_draws_lists_and_reports_them(toys: None, tmp_path: Path) -> None:
    folder = run_to_folder(tiny.scene(output={"figures": True}), tmp_path / "out")
    files = sorted(f"{stem}.png" for stem in STEMS)
    assert sorted(path.name for path in (folder / "figures").iterdir()) == files
    assert json.loads((folder / "run.json").read_text())["files"] == [f"figures/{name}" for name in files]
    assert sorted(path.name for path in pictures_in(folder)) == files
    page = (folder / "report.html").read_text()
    captions = (
        "A toy of the path, path pull",
        "A toy of a state, at the last converged step, path pull",
        "A toy of the run",
    )
    for caption in captions:
        assert f"<figcaption>{caption}</figcaption>" in page
    assert "A toy of the water" not in page


def test_names_in_reading_order(toys: None) -> None:
    result = tiny.result()
    names = [name for name, _ in plots.files.figures(result, None, {})]
    assert names == ["toy-run", "pull_toy", "pull_toy-state_last"]
