# SPDX-License-Identifier: MIT
"""The examples of the gallery run, print no warning, and draw a picture."""

import runpy
from pathlib import Path

import matplotlib
import pytest
from matplotlib import pyplot
from matplotlib.figure import Figure

from tests.support.place import ROOT

EXAMPLES = sorted((ROOT / "examples").glob("plot_*.py"))


def test_there_are_at_least_ten_examples() -> None:
    assert len(EXAMPLES) >= 10


@pytest.mark.slow
@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_an_example_runs_and_draws(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    matplotlib.use("agg")
    figure = runpy.run_path(str(file))["figure"]
    assert isinstance(figure, Figure)
    assert any(axes.lines or axes.images or axes.collections or axes.patches for axes in figure.axes)
    pyplot.close("all")
